// The module relights: two lights, three receivers.
import { readFileSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]));
const { memory, rsv_rt_relight, __heap_base } = instance.exports;
const base = (__heap_base.value + 15) & ~15;
const value = base + 64, scale = value + 4 * 18, out = scale + 4 * 6;
memory.grow(1);
new Uint32Array(memory.buffer, base, 4).set([2, 3, 1, value]);
new Float32Array(memory.buffer, value, 18).set(Array.from({ length: 18 }, (_, k) => k));
new Float32Array(memory.buffer, scale, 6).set([1, 2, 3, 0.5, 0.25, 2]);
const status = rsv_rt_relight(base, scale, 2, 0, 3, out);
const got = Array.from(new Float32Array(memory.buffer, out, 9));
const expected = Array.from({ length: 9 }, (_, k) => k * [1, 2, 3][k % 3] + (k + 9) * [0.5, 0.25, 2][k % 3]);
if (status !== 0 || got.some((x, k) => x !== expected[k])) {
    console.log("FAILED:", status, got, expected);
    process.exit(1);
}
if (rsv_rt_relight(base, scale, 3, 0, 3, out) === 0) process.exit(1);
console.log("all passed");
