// Scenes dropped on the page are solved there: on threads, on one thread, and not at all with a clear word.
// usage: test_solve.mjs WEB_FOLDER BUILT_PAGE SCENE.glb [FOLDER_FOR_SCREENSHOTS]
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { PageTest } from "./browser.mjs";

const [web, page_folder, scene, screenshots] = process.argv.slice(2);
const test = await PageTest.create(web, page_folder, 256);
const plain = { name: "plain.glb", mimeType: "model/gltf-binary", buffer: readFileSync(scene) };

const message = (page) => page.locator("#message").innerText();

/// Waits until a chosen file is solved or given up; what solveFile() returned.
function solved(page) {
    return page.evaluate(() => window.page.then((shown) => shown.solved));
}

/// Watches the page's frames: the longest gap between two, and the longest task, milliseconds.
function watchFrames(page) {
    return page.evaluate(() => {
        window.frames_seen = { frames: 0, gap: 0, task: 0 };
        let last = performance.now();
        const step = (now) => {
            window.frames_seen.frames++;
            window.frames_seen.gap = Math.max(window.frames_seen.gap, now - last);
            last = now;
            requestAnimationFrame(step);
        };
        requestAnimationFrame(step);
        new PerformanceObserver((list) => list.getEntries().forEach(({ duration }) => {
            window.frames_seen.task = Math.max(window.frames_seen.task, duration);
        })).observe({ type: "longtask" });
    });
}

async function solveAndCompare(threads) {
    const page = await test.open("");
    await watchFrames(page);
    await page.locator("#file").setInputFiles(plain);
    const result = await solved(page);
    if (!result) {
        test.check(false, `not solved: "${await message(page)}"`);
        return page;
    }
    const { frames, gap, task } = await page.evaluate(() => window.frames_seen);
    console.log(`${result.threads} threads: ${result.seconds.toFixed(2)} s, ${frames} frames, longest gap ${gap.toFixed(0)} ms, longest task ${task} ms`);
    test.check(result.threads === threads, `${result.threads} threads instead of ${threads}`);
    test.check(frames > 2, "the page stood still while it solved");
    await test.compare(page, "scene/box-operator.png");
    return page;
}

// on threads, in a page that is isolated
test.isolated = true;
let page = await test.open("");
const threads = await page.evaluate(() => Math.min(navigator.hardwareConcurrency, 8));
await page.close();
page = await solveAndCompare(threads);
if (screenshots) await test.photograph(page, join(screenshots, "web-solved.png"));
await test.checkBarriers(page);
test.check(await page.getByRole("link", { name: "lit scene" }).isVisible(), "the lit scene cannot be saved");
test.check(await page.locator("[data-light]").count() === 1, "the lit scene has no slider");
await page.evaluate(() => {
    const slider = document.querySelector("[data-light]");
    slider.value = 0;
    slider.dispatchEvent(new Event("input"));
});
const dark = await page.evaluate(() => window.page.then(({ basis }) => basis.irradiance.every((value) => value === 0)));
test.check(dark, "the only light is off, and it is not dark");

// dropped, and cancelled: the scene before stays
await page.evaluate(async (bytes) => {
    const data = new DataTransfer();
    data.items.add(new File([new Uint8Array(bytes)], "again.glb"));
    window.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}, [...plain.buffer]);
await page.getByRole("button", { name: "Cancel" }).click();
test.check(await solved(page) === null && /Cancelled/.test(await message(page)), `cancelled: "${await message(page)}"`);
test.check(await page.locator("#work").isHidden(), "cancelled, and the bar stays");

/// What the page says of a file.
async function says(buffer, words) {
    await page.locator("#file").setInputFiles({ ...plain, name: "bad.glb", buffer });
    const result = await solved(page);
    test.check(result === null && words.test(await message(page)), `bad file: "${await message(page)}"`);
}

await says(Buffer.from("no scene at all"), /^bad[.]glb: this is no binary glTF file/);
await says(plain.buffer.subarray(0, plain.buffer.length / 2), /^bad[.]glb: /);
await says(Buffer.alloc(0), /^bad[.]glb: this is no binary glTF file/);
await page.close();

// a browser without SIMD
page = await test.open("");
await page.route("**/solver_worker.js", async (route) => {
    const body = readFileSync(join(page_folder, "solver_worker.js"), "utf8");
    await route.fulfill({ contentType: "text/javascript", body: `WebAssembly.validate = () => false;${body}`,
        headers: { "cross-origin-embedder-policy": "require-corp" } });
});
await says(plain.buffer, /no WebAssembly SIMD/);
await page.close();

// one thread, where the page is not isolated
test.isolated = false;
page = await solveAndCompare(1);
await page.close();

// no solver beside the page: nothing is offered
page = await test.browser.newPage();
await page.route("**/solver_worker.js", (route) => route.fulfill({ status: 404 }));
await page.goto(test.address);
await page.evaluate(() => window.page.then(() => true));
test.check(await page.locator("#open").isHidden(), "solving is offered without a solver");

await test.close();
