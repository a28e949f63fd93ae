import type { Scale } from "./index.js";

/** A light basis in a worker. */
export class WorkerBasis {
    /** @param file bytes of NAME.light.safetensors; they move to the worker */
    static create(file: ArrayBuffer): Promise<WorkerBasis>;
    readonly names: string[];
    readonly receiverCount: number;
    readonly turns: number;
    readonly rotation: number;
    /** Irradiance of all receivers, W/m2: a copy. */
    relight(scales: readonly Scale[], degrees?: number): Promise<Float32Array>;
    terminate(): void;
}
