// Runs a project in Godot 4 in headless Chromium: run.mjs WEB FOLDER, where FOLDER has Godot's index.js and index.wasm,
// page.html and project.pck. Pictures that the project prints land in FOLDER/NAME.png; its other words are printed.
import { writeFile, readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const [web, folder] = process.argv.slice(2);
const { chromium } = createRequire(resolve(web, "package.json"))("playwright-core");
const types = { html: "text/html", js: "text/javascript", wasm: "application/wasm" };
const server = createServer(async (request, response) => {
    const path = new URL(request.url, "http://localhost").pathname;
    response.setHeader("Cross-Origin-Opener-Policy", "same-origin");
    response.setHeader("Cross-Origin-Embedder-Policy", "require-corp");
    try {
        const body = await readFile(join(folder, path));
        response.setHeader("content-type", types[path.slice(path.lastIndexOf(".") + 1)] ?? "application/octet-stream");
        response.end(body);
    } catch {
        response.statusCode = 404;
        response.end();
    }
}).listen(0);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
const page = await browser.newPage({ viewport: { width: 300, height: 300 } });
const saved = [];
const done = new Promise((resolve, reject) => {
    page.on("pageerror", (error) => reject(error));
    page.on("console", (message) => {
        const [word, name, data] = message.text().split(" ");
        if (word === "PICTURE") saved.push(writeFile(join(folder, `${name}.png`), Buffer.from(data, "base64")));
        else console.log(message.text());
        if (message.text() === "STEPS DONE") resolve();
    });
    setTimeout(() => reject(new Error("Godot did not finish within 120 s")), 120000);
});
let failed = 0;
try {
    await page.goto(`http://localhost:${server.address().port}/page.html`);
    await done;
    await Promise.all(saved);
} catch (error) {
    console.log("FAILED:", error.message);
    failed = 1;
}
await browser.close();
server.close();
process.exit(failed);
