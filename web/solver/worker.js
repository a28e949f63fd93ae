/// The solver in a worker of its own, so that the page stays free; it is cancelled by ending the worker.
///
/// In: { glb: ArrayBuffer, threads, and what solve() takes }. Out, any number of { phase, fraction } and
/// { note }, then { glb, basis } (the file with a lightmap, and its light basis) or { problem }.
"use strict";

/// Bytes of an empty module with one v128 instruction: refused by browsers without SIMD.
const simd = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11]);

const inNode = typeof process === "object";

/// Says what the browser lacks, or nothing.
function findMissing() {
    if (typeof WebAssembly !== "object") return "this browser has no WebAssembly";
    if (!WebAssembly.validate(simd)) return "this browser has no WebAssembly SIMD; use a newer one";
    return null;
}

/// Whether a file begins as binary glTF does.
function isBinaryGltf(bytes) {
    return bytes.byteLength >= 4 && new DataView(bytes).getUint32(0, true) === 0x46546c67;
}

/// Threads need memory that workers share, which browsers give to isolated pages alone.
function canShare() {
    return typeof SharedArrayBuffer === "function" && (inNode || self.crossOriginIsolated === true);
}

function describe(error) {
    const text = String(error?.message ?? error);
    return /memory|OOM/i.test(text) ? "the browser gives it too little memory; try a smaller scene" : text;
}

/// @param load (name): promises the bytes of a file of the solver @param create the loaded script's createSolver
async function openSolver(kind, threads, tell, { create, load, script }) {
    const module = await create({
        wasmBinary: await load(`solver_${kind}.wasm`),
        threads: threads - 1, // beside this one
        mainScriptUrlOrBlob: script,
        print: () => {},
        printErr: () => {},
    });
    module.onSolverProgress = (phase, fraction) => tell({ phase, fraction });
    module.onSolverNote = (note) => tell({ note });
    return module;
}

/// Solves one scene; the rest is as page_task of solver.c has it.
function solve(module, { glb, threads, triangles = 100000, elements = 0, mapSize = 512, error = 0.05, levels = -1, samples = 0 }) {
    module.FS.writeFile("/scene.glb", new Uint8Array(glb));
    const [input, output, task] = [module._malloc(32), module._malloc(32), module._malloc(28)];
    module.stringToUTF8("/scene.glb", input, 32);
    module.stringToUTF8("/lit.glb", output, 32);
    const view = new DataView(module.HEAPU8.buffer, task, 28);
    [threads, triangles, elements, mapSize].forEach((value, k) => view.setInt32(4 * k, value, true));
    view.setFloat32(16, error, true);
    view.setInt32(20, levels, true);
    view.setInt32(24, samples, true);
    if (!module._rsv_page_solve(input, output, task))
        return { problem: module.UTF8ToString(module._rsv_page_problem()).replace("/scene.glb: ", "") };
    const read = (name) => module.FS.readFile(name).buffer;
    return { glb: read("/lit.glb"), basis: read("/lit.light.safetensors") };
}

/// @param tell takes messages to the page, with a list of what moves there
async function work(job, tell, source) {
    const missing = findMissing();
    if (missing) return tell({ problem: missing });
    if (!isBinaryGltf(job.glb)) return tell({ problem: "this is no binary glTF file; export the scene as .glb" });
    const kind = canShare() && job.threads > 1 ? "threads" : "alone";
    const threads = kind === "threads" ? job.threads : 1;
    try {
        const module = await openSolver(kind, threads, tell, await source(kind));
        const result = solve(module, { ...job, threads });
        tell({ ...result, threads }, [result.glb, result.basis].filter(Boolean));
    } catch (error) {
        tell({ problem: describe(error) });
    }
}

if (inNode) {
    module.exports = { work };
} else {
    const load = async (name) => {
        const response = await fetch(name);
        if (!response.ok) throw new Error(`${name} is missing`);
        return response.arrayBuffer();
    };
    self.onmessage = ({ data }) => work(data, (message, moved = []) => self.postMessage(message, moved), async (kind) => {
        const script = new URL(`solver_${kind}.js`, self.location.href).href;
        importScripts(script);
        return { create: self.createSolver, load, script };
    });
}
