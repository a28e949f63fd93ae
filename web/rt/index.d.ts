/** Strength of a light per channel, relative to the bake: [red, green, blue]. */
export type Scale = readonly [number, number, number];

/** What each light does by itself, from `resolvent bake --basis`. */
export class LightBasis {
    /**
     * @param module bytes of resolvent_rt.wasm, from `loadModule()`
     * @param file bytes of NAME.light.safetensors
     * @throws Error that says what is wrong with the file
     */
    static create(module: BufferSource, file: ArrayBuffer): Promise<LightBasis>;
    /** Names of the lights, in the order of `scales`. */
    readonly names: string[];
    readonly receiverCount: number;
    /** Angles at which the surroundings were baked; 1 = they cannot be turned. */
    readonly turns: number;
    /** Degrees of the first of these angles. */
    readonly rotation: number;
    /** How long the last relight took. */
    readonly milliseconds: number;
    /**
     * Irradiance of all receivers, W/m2: [receiverCount * 3]. The array is the runtime's own, and changes with the next call.
     * @param scales one for each of `names`
     * @param degrees of the surroundings, if they can be turned
     */
    relight(scales: readonly Scale[], degrees?: number): Float32Array;
    /** What each light counts for, every angle of the surroundings by itself: [lights * 3]. Parameters as of `relight`. */
    weights(scales: readonly Scale[], degrees?: number): Float32Array;
    /** What each light does, for shaders that add them up: [lights * receiverCount * 3]. */
    readonly values: Float32Array;
}

/** Arrays of a safetensors file. */
export function readTensors(buffer: ArrayBuffer): {
    notes: Record<string, string>;
    floats(name: string): { shape: number[]; values: Float32Array };
    bytes(name: string): Uint8Array;
};

/** Bytes of the runtime, with SIMD where there is any, or as asked. */
export function loadModule(simd?: boolean): Promise<BufferSource>;

/** Whether WebAssembly here has 128-bit SIMD. */
export function hasSimd(): boolean;
