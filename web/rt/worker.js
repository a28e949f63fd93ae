/// A light basis in a worker: the page stays free while large scenes are relit.
import { loadModule } from "./module.js";
import { LightBasis } from "./runtime.js";

/// Use as LightBasis, but relight() returns a promise.
export class WorkerBasis {
    /// @param file bytes of a light basis; they move to the worker
    static async create(file) {
        const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
        const basis = new WorkerBasis(worker);
        Object.assign(basis, await basis.#ask({ file }, [file]));
        return basis;
    }

    #worker;
    #waiting = [];

    constructor(worker) {
        this.#worker = worker;
        worker.onmessage = ({ data }) => {
            const { resolve, reject } = this.#waiting.shift();
            if (data.error) reject(new Error(data.error));
            else resolve(data.result);
        };
        worker.onerror = (event) => {
            this.#waiting.splice(0).forEach(({ reject }) => reject(new Error(event.message ?? "the worker cannot be started")));
        };
    }

    #ask(message, transfer) {
        return new Promise((resolve, reject) => {
            this.#waiting.push({ resolve, reject });
            this.#worker.postMessage(message, transfer ?? []);
        });
    }

    /// @param scales, degrees as of LightBasis @return (promised) irradiance, a copy
    relight(scales, degrees = this.rotation) {
        return this.#ask({ scales, degrees });
    }

    terminate() {
        this.#worker.terminate();
        this.#waiting.splice(0).forEach(({ reject }) => reject(new Error("the worker was ended")));
    }
}

let basis = null;

async function answer({ file, scales, degrees }) {
    if (!file) {
        const irradiance = basis.relight(scales, degrees).slice();
        return { result: irradiance, transfer: [irradiance.buffer] };
    }
    basis = await LightBasis.create(await loadModule(), file);
    const { names, receiverCount, rotation, turns } = basis;
    return { result: { names, receiverCount, rotation, turns }, transfer: [] };
}

if (typeof WorkerGlobalScope !== "undefined" && self instanceof WorkerGlobalScope)
    self.onmessage = async ({ data }) => {
        try {
            const { result, transfer } = await answer(data);
            self.postMessage({ result }, transfer);
        } catch (error) {
            self.postMessage({ error: error.message });
        }
    };
