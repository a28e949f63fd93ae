// The page in headless Chromium: baked scenes look like our own pictures, follow their lights, and say what is wrong.
// usage: test_page.mjs WEB_FOLDER BUILT_PAGE [FOLDER_FOR_SCREENSHOTS]
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join, normalize, resolve } from "node:path";

const [web, page_folder, screenshots] = process.argv.slice(2);
const { chromium } = createRequire(resolve(web, "package.json"))("playwright-core");
const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm", ".png": "image/png" };
let failures = 0;

function check(condition, what) {
    if (!condition) console.log("FAILED:", what);
    failures += !condition;
}

const server = createServer(async (request, response) => {
    const path = normalize(new URL(request.url, "http://localhost").pathname).replace(/\/$/, "/index.html");
    try {
        let body = await readFile(join(page_folder, path.replace("/truncated/", "/scene/")));
        if (path.startsWith("/truncated/")) body = body.subarray(0, body.length / 2);
        response.setHeader("content-type", types[path.slice(path.lastIndexOf("."))] ?? "application/octet-stream");
        response.end(body);
    } catch {
        response.statusCode = 404;
        response.end();
    }
}).listen(0);
const address = `http://localhost:${server.address().port}/`;
const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

async function open(query, setup) {
    const page = await browser.newPage({ viewport: { width: 256, height: 256 } });
    if (setup) await page.addInitScript(setup);
    await page.goto(address + query);
    await page.evaluate(() => window.page.then(() => true));
    return page;
}

async function compare(page, picture) {
    const difference = await page.evaluate((url) => window.page.then((shown) => shown.compareWith(url)), picture);
    console.log(`${picture}: mean difference per channel`, difference.map((d) => `${(100 * d).toFixed(2)} %`).join(", "));
    check(difference.every((d) => d <= 0.02), `the page differs from ${picture}`);
}

/// The largest channel of what is shown.
function brightest(page) {
    return page.evaluate(() => {
        const shown = document.querySelector("canvas");
        const context = new OffscreenCanvas(shown.width, shown.height).getContext("2d");
        context.drawImage(shown, 0, 0);
        const { data } = context.getImageData(0, 0, shown.width, shown.height);
        return data.reduce((most, value, k) => k % 4 < 3 ? Math.max(most, value) : most, 0);
    });
}

async function slide(page, selector, value) {
    await page.evaluate(([selector, value]) => {
        const slider = document.querySelector(selector);
        slider.value = value;
        slider.dispatchEvent(new Event("input"));
    }, [selector, value]);
}

async function photograph(page, name) {
    if (!screenshots) return;
    await page.setViewportSize({ width: 720, height: 540 });
    await page.screenshot({ path: join(screenshots, name) });
    await page.setViewportSize({ width: 256, height: 256 });
}

const page = await open("");
await compare(page, "scene/box-operator.png");
await photograph(page, "web.png");
await slide(page, "[data-light]", 0);
const dark = await page.evaluate(() => window.page.then((shown) => shown.basis.irradiance.every((value) => value === 0)));
check(dark, "the only light is off, and it is not dark");

// last, as it takes the memory of the basis that is shown
const milliseconds = await page.evaluate(() => window.page.then(({ basis }) => {
    const [lights, receivers, passes] = [4, 100000, 50];
    const many = new basis.constructor(basis.runtime, ["a", "b", "c", "d"], [lights, receivers, 3],
        new Float32Array(lights * receivers * 3).fill(0.5));
    const scales = many.names.map((_, k) => [k, 1, 0.5]);
    const start = performance.now();
    for (let k = 0; k < passes; k++) many.relight(scales);
    return (performance.now() - start) / passes;
}));
console.log(`100,000 receivers, 4 lights: ${milliseconds.toFixed(3)} ms`);

const map = await open("?scene=scene/map");
await compare(map, "scene/box-operator.png");
await photograph(map, "web-map.png");
await slide(map, "[data-light]", 0);
check(await brightest(map) === 0, "the only light is off, and a lightmap still shines");

const hill = await open("?scene=scene/hill");
await slide(hill, "#turn", 90);
await compare(hill, "scene/hill-turned.png");
await photograph(hill, "web-sky.png");

/// What the page says of a scene that it cannot show, or not whole.
async function says(query, words) {
    const page = await open(`?scene=${query}`);
    const message = await page.locator("#message").innerText();
    check(words.test(message), `${query}: "${message}"`);
    return page;
}

await says("truncated/box", /cannot be shown/);
await says("truncated/map", /cannot be shown/);
await says("mixed/picture", /cannot be shown/);
await says("scene/nowhere", /missing/);
await says("scene/plain", /no baked light, neither in vertices nor in a lightmap/);
await says("mixed/hill", /were not baked together/);
// one light less in the header than in the data, and a basis that is cut off
const complaints = await page.evaluate(async () => {
    const { basis } = await window.page;
    const load = async (path) => new Uint8Array(await (await fetch(path)).arrayBuffer());
    const module = await load("resolvent_rt.wasm"), file = await load("scene/hill.light.safetensors");
    const header = file.subarray(8, 8 + Number(new DataView(file.buffer).getBigUint64(0, true)));
    header.set(new TextEncoder().encode(new TextDecoder().decode(header).replace('\\"sun\\",', "        ")));
    const fails = (bytes) => basis.constructor.create(module, bytes.buffer).then(() => "none", (error) => error.message);
    return [await fails(file), await fails(file.slice(0, 5000)), await fails(new Uint8Array(4))];
});
check(/names \d+ lights and holds \d+/.test(complaints[0]), `a light too few: "${complaints[0]}"`);
check(complaints.slice(1).every((message) => /cut off/.test(message)), `a basis cut off: "${complaints}"`);
const flat = await open("", () => { HTMLCanvasElement.prototype.getContext = () => null; });
check(await flat.locator("#still").isVisible(), "no WebGL, and no still picture");

await browser.close();
server.close();
if (!failures) console.log("all passed");
process.exit(failures ? 1 : 0);
