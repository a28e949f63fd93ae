// The installed package in Node: both modules, worth of a sum in double precision, errors, speed.
// usage: npm_node.mjs BASIS THE_SAME_PACKED
import { readFile } from "node:fs/promises";
import { LightBasis, hasSimd, loadModule, readTensors } from "resolvent-rt";

let failures = 0;
function check(condition, what) {
    if (!condition) console.log("FAILED:", what);
    failures += !condition;
}

async function refuses(file, words) {
    const message = await LightBasis.create(await loadModule(), file).then(() => "nothing", (error) => error.message);
    check(message.includes(words), `'${message}' does not say '${words}'`);
}

/// A safetensors file of a basis.
function basisFile(lights, receivers, make, names = Array.from({ length: lights }, (_, k) => `light ${k}`)) {
    const values = Float32Array.from({ length: lights * receivers * 3 }, (_, k) => make(k));
    const header = new TextEncoder().encode(JSON.stringify({
        __metadata__: { format: "resolvent-light-basis", format_version: "1", "light.name": JSON.stringify(names) },
        "basis.value": { dtype: "F32", shape: [lights, receivers, 3], data_offsets: [0, values.byteLength] } }));
    const file = new Uint8Array(8 + header.length + values.byteLength);
    new DataView(file.buffer).setBigUint64(0, BigInt(header.length), true);
    file.set(header, 8);
    file.set(new Uint8Array(values.buffer), 8 + header.length);
    return { file: file.buffer, values };
}

check(hasSimd(), "Node has SIMD");
const real = (await readFile(process.argv[2])).buffer;
const box = await LightBasis.create(await loadModule(), real);
check(box.names.length === 1 && box.receiverCount > 100, "a file of the program");
const baked = readTensors(real).floats("basis.value").values;
check(box.relight([[1, 1, 1]]).every((value, k) => value === baked[k]), "as baked at strength 1");

const { file, values } = basisFile(4, 100000, (k) => Math.sin(k) ** 2);
const scales = [[1, 0.5, 0], [0, 2, 3], [0.1, 0.2, 0.3], [7, 0, 1]];
const results = [];
for (const simd of [true, false]) {
    const basis = await LightBasis.create(await loadModule(simd), file);
    const first = performance.now();
    results.push(basis.relight(scales).slice());
    const milliseconds = performance.now() - first;
    console.log(`${simd ? "SIMD" : "scalar"}: 100,000 receivers, 4 lights: first ${milliseconds.toFixed(2)} ms`);
    check(milliseconds < 160, "the first relight is slow beyond any noise of the machine");
}
check(results[0].every((value, k) => value === results[1][k]), "SIMD and scalar give the same bits");
for (let k = 0; k < 3000; k++) {
    const exact = scales.reduce((sum, scale, light) => sum + scale[k % 3] * values[light * 300000 + k], 0);
    if (Math.abs(results[0][k] - exact) > 1e-5 * (1 + exact)) { check(false, `receiver value ${k}`); break; }
}

// packed, it is the same but for the rounding of halves
const small = (await readFile(process.argv[3])).buffer;
const packed = (await LightBasis.create(await loadModule(), small)).relight([[1, 1, 1]]);
check(packed.every((value, k) => Math.abs(value - baked[k]) <= 2 ** -11 * Math.abs(baked[k]) + 1e-9), "a packed basis");
check(3 * small.byteLength < real.byteLength, `packed ${small.byteLength} bytes, plain ${real.byteLength}`);
const damaged = small.slice();
new Uint8Array(damaged)[damaged.byteLength - 40] ^= 0x55;
await refuses(damaged, "damaged");

await refuses(new ArrayBuffer(4), "cut off");
await refuses(real.slice(0, real.byteLength / 2), "cut off");
await refuses(new TextEncoder().encode("no such file at all").buffer, "cut off");
await refuses(basisFile(2, 3, () => 0, ["one"]).file, "names 1 lights and holds 2");
let message = "nothing";
try { box.relight([]); } catch (error) { message = error.message; }
check(message.includes("do not fit"), `too few scales: '${message}'`);
console.log(failures ? "failed" : "Node: all passed");
process.exit(failures ? 1 : 0);
