/// The bytes of the runtime as WebAssembly, with SIMD where the browser has it.

/// A module whose one function makes a vector: (func (result v128) i32.const 0 i8x16.splat)
const PROBE = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 8, 1, 6, 0, 65, 0, 253, 15, 11]);

/// Whether WebAssembly here has 128-bit SIMD.
export function hasSimd() {
    return typeof WebAssembly === "object" && WebAssembly.validate(PROBE);
}

async function read(url) {
    if (url.protocol === "file:" && typeof process === "object") {
        const { readFile } = await import("node:fs/promises");
        return readFile(url);
    }
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url} is missing`);
    return response.arrayBuffer();
}

/// @param simd false = the module without SIMD; both give the same bits
export async function loadModule(simd = hasSimd()) {
    if (typeof WebAssembly !== "object") throw new Error("this browser has no WebAssembly");
    return read(simd ? new URL("./resolvent_rt.wasm", import.meta.url) : new URL("./resolvent_rt_scalar.wasm", import.meta.url));
}
