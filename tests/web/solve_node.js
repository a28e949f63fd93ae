// The solver for web pages in Node: solve_node.js FOLDER_OF_THE_SOLVER SCENE.glb OUT [KEY=VALUE...]
// Writes OUT.glb and OUT.light.safetensors.
"use strict";
const { readFileSync, writeFileSync } = require("node:fs");
const { join, resolve } = require("node:path");

const [folder, scene, out, ...settings] = process.argv.slice(2);
const { work } = require(resolve(folder, "solver_worker.js"));
const bytes = readFileSync(scene);
const job = { glb: bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), threads: 2 };
for (const setting of settings) {
    const [key, value] = setting.split("=");
    job[key] = Number(value);
}
const start = performance.now();
const phases = [];
const source = async (kind) => {
    const script = resolve(folder, `solver_${kind}.js`);
    return { create: require(script), load: async (name) => readFileSync(join(folder, name)), script };
};
work(job, (message) => {
    const seconds = ((performance.now() - start) / 1000).toFixed(2);
    if (message.phase && message.phase !== phases.at(-1)) {
        phases.push(message.phase);
        if (job.verbose) console.log(`${seconds} s: ${message.phase}`);
    }
    if (message.note) console.log("note:", message.note);
    if (message.problem) {
        console.log("problem:", message.problem);
        process.exit(1);
    }
    if (!message.glb) return;
    writeFileSync(`${out}.glb`, new Uint8Array(message.glb));
    writeFileSync(`${out}.light.safetensors`, new Uint8Array(message.basis));
    const { user, system } = process.cpuUsage();
    console.log(`${message.threads} threads, ${seconds} s, ${((user + system) / 1e6).toFixed(2)} s of CPU time`);
    process.exit(0);
}, source);
