/// Light bases for any engine. Nothing here needs a page: it works in Node and in workers, too.
export { LightBasis, readTensors } from "./runtime.js";
export { loadModule, hasSimd } from "./module.js";
