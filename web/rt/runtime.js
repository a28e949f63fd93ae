/// The runtime as a WebAssembly module: a light basis in its memory, relit there.

/// The bytes of a zlib stream. @param count how many they must be
async function inflate(bytes, count) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const plain = await new Response(stream).arrayBuffer().catch(() => null);
    if (plain?.byteLength !== count) throw new Error("the light basis is damaged");
    return new Uint8Array(plain);
}

let halves = null;

/// Numbers of all halves by their bits.
function tableOfHalves() {
    halves ??= Float32Array.from({ length: 65536 }, (_, bits) => {
        const exponent = bits >> 10 & 31, mantissa = bits & 1023;
        const size = exponent ? (1024 + mantissa) * 2 ** (exponent - 25) : mantissa * 2 ** -24;
        return bits & 0x8000 ? -size : size;
    });
    return halves;
}

/// Undoes what `bake --packed` does to a light: of each channel the low bytes of all receivers' differences, then the high ones;
/// green and blue by how far they are from the channel before.
function unpackLight(planes, receivers, width, scale, out) {
    const table = tableOfHalves();
    const before = new Uint16Array(receivers); // halves of the last channel
    for (let c = 0; c < width; c++) {
        const low = 2 * c * receivers, high = low + receivers;
        if (c % 3 === 0) before.fill(0);
        for (let n = 0, code = 0; n < receivers; n++) {
            const difference = planes[low + n] | planes[high + n] << 8;
            code += difference >> 1 ^ -(difference & 1);
            before[n] += code;
            out[n * width + c] = scale * table[before[n]];
        }
    }
}

/// The values of a basis, as they are or packed.
async function readValues(tensors) {
    if (tensors.notes.format_version !== "3") return tensors.floats("basis.value");
    const shape = JSON.parse(tensors.notes["basis.shape"] ?? "[]"), [lights, receivers, width] = shape;
    const { values: scale } = tensors.floats("basis.scale");
    if (!(lights === scale.length && receivers >= 0 && width >= 0)) throw new Error("the light basis is damaged");
    const packed = Array.from(scale, (_, k) => tensors.bytes(`basis.packed.${k}`));
    const one = receivers * width, values = new Float32Array(lights * one);
    for (let k = 0; k < lights; k++)
        unpackLight(await inflate(packed[k], 2 * one), receivers, width, scale[k], values.subarray(k * one, (k + 1) * one));
    return { shape, values };
}

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
    /// Where an array is in the file.
    const find = (name, type, bytes) => {
        const entry = header[name];
        if (entry?.dtype !== type) throw new Error(`the light basis lacks '${name}'`);
        const [begin, end] = entry.data_offsets;
        const count = entry.shape.reduce((a, b) => a * b, 1);
        if (end - begin !== bytes * count || 8 + length + end > buffer.byteLength)
            throw new Error("the light basis is cut off");
        return { shape: entry.shape, begin: 8 + length + begin, end: 8 + length + end };
    };
    return {
        notes: header.__metadata__ ?? {},
        floats(name) {
            const { shape, begin, end } = find(name, "F32", 4);
            return { shape, values: new Float32Array(buffer.slice(begin, end)) };
        },
        bytes(name) {
            const { begin, end } = find(name, "U8", 1);
            return new Uint8Array(buffer, begin, end - begin);
        },
    };
}

/// Light that follows its lights: `relight(scales)` gives irradiance of all receivers, W/m2.
export class LightBasis {
    /// @param module bytes of resolvent_rt.wasm @param file bytes of a light basis
    static async create(module, file) {
        const tensors = readTensors(file);
        if (tensors.notes.format !== "resolvent-light-basis") throw new Error("the file holds no light basis");
        if (!["1", "2", "3"].includes(tensors.notes.format_version))
            throw new Error("the light basis is of a version that is not known here");
        const names = JSON.parse(tensors.notes["light.name"] ?? "[]");
        const { shape, values } = await readValues(tensors);
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
        /// What each light does: [lights][receivers][width].
        this.values = new Float32Array(memory, this.value, values.length);
    }

    /// What each light counts for, every angle of the sky by itself: [r, g, b] one after the other.
    /// @param scales one [r, g, b] for each of `names`, 1 = as baked @param degrees of the sky, where it can be turned
    weights(scales, degrees = this.rotation) {
        const last = this.names.length - 1;
        if (scales.length !== this.names.length)
            throw new Error(`${scales.length} light scales do not fit ${this.names.length} lights`);
        this.scales.set(scales.flat());
        if (this.turns > 1) {
            this.skyScale.set(scales[last]);
            this.runtime.rsv_rt_turn((degrees - this.rotation) / 360, this.sky, this.turns, this.scale + 12 * last);
        }
        return this.scales;
    }

    /// Irradiance of all receivers, W/m2. Parameters as of `weights`.
    relight(scales, degrees = this.rotation) {
        const start = performance.now(), lights = this.weights(scales, degrees).length / 3;
        this.runtime.rsv_rt_relight(this.basis, this.scale, lights, 0, this.receiverCount, this.out);
        this.milliseconds = performance.now() - start;
        return this.irradiance;
    }
}
