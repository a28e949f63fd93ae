/// The runtime as a WebAssembly module: a light basis in its memory, relit there.

/// Arrays of a file in the safetensors layout. Throws an error that says what is wrong.
export function readTensors(buffer) {
    if (buffer.byteLength < 8) throw new Error("the light basis is cut off");
    const length = Number(new DataView(buffer).getBigUint64(0, true));
    if (!(length <= buffer.byteLength - 8)) throw new Error("the light basis is cut off, or no safetensors file");
    let header;
    try {
        header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
    } catch {
        throw new Error("the header of the light basis is damaged");
    }
    return {
        notes: header.__metadata__ ?? {},
        floats(name) {
            const entry = header[name];
            if (entry?.dtype !== "F32") throw new Error(`the light basis lacks '${name}'`);
            const [begin, end] = entry.data_offsets;
            const count = entry.shape.reduce((a, b) => a * b, 1);
            if (end - begin !== 4 * count || 8 + length + end > buffer.byteLength)
                throw new Error("the light basis is cut off");
            return { shape: entry.shape, values: new Float32Array(buffer.slice(8 + length + begin, 8 + length + end)) };
        },
    };
}

/// Light that follows its lights: `relight(scales)` gives irradiance of all receivers, W/m2.
export class LightBasis {
    /// @param module bytes of resolvent_rt.wasm @param file bytes of a light basis
    static async create(module, file) {
        const tensors = readTensors(file);
        if (tensors.notes.format !== "resolvent-light-basis") throw new Error("the file holds no light basis");
        if (!["1", "2"].includes(tensors.notes.format_version))
            throw new Error("the light basis is of a version that is not known here");
        const names = JSON.parse(tensors.notes["light.name"] ?? "[]");
        const { shape, values } = tensors.floats("basis.value");
        if (names.length !== shape[0])
            throw new Error(`the light basis names ${names.length} lights and holds ${shape[0]}`);
        const turns = Number(tensors.notes["surroundings.turns"] ?? 1);
        if (!(turns >= 1 && turns <= shape[0])) throw new Error("the light basis has no such turns of the sky");
        const { instance } = await WebAssembly.instantiate(module);
        const basis = new LightBasis(instance.exports, names, shape, values, turns);
        basis.rotation = Number(tensors.notes["surroundings.rotation"] ?? 0);
        return basis;
    }

    /// @param turns how many of the last lights are one sky at evenly spread angles, the first at `rotation` degrees
    constructor(runtime, names, [lights, receivers, width], values, turns = 1) {
        this.runtime = runtime;
        this.names = names.slice(0, lights - turns + 1);
        this.turns = turns;
        this.rotation = 0;
        this.receiverCount = receivers;
        this.milliseconds = 0;
        this.basis = (runtime.__heap_base.value + 15) & ~15;
        this.sky = this.basis + 16;
        this.value = this.sky + 16;
        this.scale = this.value + 4 * values.length;
        this.out = this.scale + 12 * lights;
        const needed = this.out + 4 * receivers * width - runtime.memory.buffer.byteLength;
        if (needed > 0) runtime.memory.grow(Math.ceil(needed / 65536));
        const memory = runtime.memory.buffer;
        new Uint32Array(memory, this.basis, 4).set([lights, receivers, width / 3, this.value]);
        new Float32Array(memory, this.value, values.length).set(values);
        this.scales = new Float32Array(memory, this.scale, 3 * lights).fill(1);
        this.skyScale = new Float32Array(memory, this.sky, 3);
        this.irradiance = new Float32Array(memory, this.out, receivers * width);
    }

    /// @param scales one [r, g, b] for each of `names`, 1 = as baked @param degrees of the sky, where it can be turned
    relight(scales, degrees = this.rotation) {
        const last = scales.length - 1;
        this.scales.set(scales.flat());
        const start = performance.now();
        if (this.turns > 1) {
            this.skyScale.set(scales[last]);
            this.runtime.rsv_rt_turn((degrees - this.rotation) / 360, this.sky, this.turns, this.scale + 12 * last);
        }
        const status = this.runtime.rsv_rt_relight(this.basis, this.scale, last + this.turns, 0, this.receiverCount, this.out);
        this.milliseconds = performance.now() - start;
        if (status !== 0) throw new Error(`${scales.length} light scales do not fit ${this.names.length} lights`);
        return this.irradiance;
    }
}
