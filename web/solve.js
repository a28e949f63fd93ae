/// Scenes that the visitor drops on the page are solved in a worker; nothing leaves the machine.

/// What the steps of the library are called on the page.
const steps = [[/caustics/, "light through glass and off mirrors"], [/assemble/, "light between surfaces"], [/direct/, "direct light"],
    [/solve|spectrum/, "bounces"], [/bake/, "lightmap"]];

const mostThreads = 8;

/// In words: "direct light".
export function nameStep(phase) {
    return steps.find(([pattern]) => pattern.test(phase))?.[1] ?? "reading the scene";
}

/// Whether the page was built with the solver.
export async function hasSolver() {
    const response = await fetch("solver_worker.js", { method: "HEAD" }).catch(() => null);
    return Boolean(response?.ok && !response.headers.get("content-type")?.startsWith("text/html"));
}

export class Solving {
    #worker;
    #reject;

    /// @param glb bytes of a file, which move to the worker @param show (phase, fraction): called as work goes on
    constructor(glb, show) {
        const threads = Math.min(navigator.hardwareConcurrency ?? 1, mostThreads);
        /// The warnings of the library, one line each.
        this.notes = [];
        /// { glb, basis, threads }: the lit file, its light basis, and how many threads there were; or an error.
        this.result = new Promise((resolve, reject) => {
            this.#reject = reject;
            this.#worker = new Worker("solver_worker.js");
            this.#worker.onerror = ({ message }) => this.#end(() => reject(new Error(message ?? "the solver cannot be loaded")));
            this.#worker.onmessage = ({ data }) => {
                if (data.phase) show(data.phase, data.fraction);
                else if (data.note) this.notes.push(data.note);
                else if (data.problem) this.#end(() => reject(new Error(data.problem)));
                else if (data.glb) this.#end(() => resolve(data));
            };
        });
        this.#worker.postMessage({ glb, threads }, [glb]);
    }

    #end(tell) {
        this.#worker.terminate();
        tell();
    }

    cancel() {
        this.#end(() => this.#reject(new Error("cancelled")));
    }
}
