// The page in headless Chromium: baked scenes look like our own pictures, follow their lights, and say what is wrong.
// usage: test_page.mjs WEB_FOLDER BUILT_PAGE EXPOSURE_OF_FRAMED [FOLDER_FOR_SCREENSHOTS]
import { join } from "node:path";
import { PageTest } from "./browser.mjs";

const [web, page_folder, own_stops, screenshots] = process.argv.slice(2);
const test = await PageTest.create(web, page_folder, 256);

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
    if (screenshots) await test.photograph(page, join(screenshots, name));
}

const page = await test.open("");
await test.compare(page, "scene/box-operator.png");
await photograph(page, "web.png");
await test.checkBarriers(page);
await slide(page, "[data-light]", 0);
const dark = await page.evaluate(() => window.page.then((shown) => shown.basis.irradiance.every((value) => value === 0)));
test.check(dark, "the only light is off, and it is not dark");

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

const map = await test.open("?scene=scene/map");
await test.compare(map, "scene/box-operator.png");
await photograph(map, "web-map.png");
await slide(map, "[data-light]", 0);
test.check(await brightest(map) === 0, "the only light is off, and a lightmap still shines");

const hill = await test.open("?scene=scene/hill");
await slide(hill, "#turn", 90);
await test.compare(hill, "scene/hill-turned.png");
await photograph(hill, "web-sky.png");

// colours of vertices stay when light changes, and cut-outs by their alpha; a metal with colours of its own is in nobody's way
const colored = await test.open("?scene=scene/colored");
test.check(await colored.locator("#message").isHidden(), `colours: "${await colored.locator("#message").innerText()}"`);
await test.compare(colored, "scene/colored.png");
await photograph(colored, "web-colored.png");

// without a camera all is seen, as in our own picture, whose exposure was chosen as the page chooses its own
const framed = await test.open("?scene=scene/framed");
const stops = Number(await framed.locator("#exposure").inputValue());
console.log(`exposure ${stops.toFixed(2)} stops, of our own picture ${own_stops}`);
test.check(Math.abs(stops - own_stops) <= 0.1, "the page chooses another exposure than our own picture has");
await test.compare(framed, "scene/framed.png");

// and so it is in a view of any shape: a narrow one shows as much from side to side, a wide one from top to bottom
for (const [width, height] of [[192, 300], [400, 256]]) {
    await framed.setViewportSize({ width, height });
    await framed.waitForFunction((width) => document.querySelector("canvas").width === width, width);
    await test.compare(framed, "scene/framed.png");
}

// what is to be set has names for those who hear the page
test.check(await colored.getByRole("slider", { name: "light" }).count() === 1, "a slider has no name");
test.check(await colored.getByLabel("Colour of light").count() === 1, "a colour has no name");

// day and night: the sky turns by itself while the box is ticked, and the light with it
const day = hill.getByRole("checkbox", { name: "Day and night" });
const sky = () => hill.evaluate(() => window.page.then(({ basis }) => ({ degrees: Number(document.querySelector("#turn").value),
    light: basis.irradiance.reduce((sum, value) => sum + value, 0) })));
await slide(hill, "#turn", 0);
const noon = await sky();
await day.check();
await hill.waitForFunction(() => document.querySelector("#turn").value > 20);
await day.uncheck();
const later = await sky();
test.check(Math.abs(later.light - noon.light) > 0.01 * noon.light, `the sky turned by ${later.degrees} degrees, and light is the same`);
await hill.waitForTimeout(100);
test.check((await sky()).degrees === later.degrees, "the sky goes on after the box was cleared");

// a headset: offered where there is one, and asked for a session by the button
const headset = await test.open("", () => {
    const xr = Object.assign(new EventTarget(), {
        isSessionSupported: async (mode) => mode === "immersive-vr",
        requestSession: (mode) => { window.asked = mode; return new Promise(() => {}); },
    });
    Object.defineProperty(navigator, "xr", { value: xr });
});
const button = headset.locator("#VRButton");
await headset.waitForFunction(() => document.querySelector("#VRButton")?.textContent === "ENTER VR");
await button.click();
test.check(await headset.evaluate(() => window.asked) === "immersive-vr", "the button asks for no session");
await test.compare(headset, "scene/box-operator.png");
await headset.close(); // it draws all the time
test.check(await page.locator("#VRButton").count() === 0, "a headset is offered where there is none");

/// What the page says of a scene that it cannot show, or not whole.
async function says(query, words) {
    const page = await test.open(`?scene=${query}`);
    const message = await page.locator("#message").innerText();
    test.check(words.test(message), `${query}: "${message}"`);
    await page.close();
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
test.check(/names \d+ lights and holds \d+/.test(complaints[0]), `a light too few: "${complaints[0]}"`);
test.check(complaints.slice(1).every((message) => /cut off/.test(message)), `a basis cut off: "${complaints}"`);
// no WebGL: a still picture, where there is one
for (const [query, words, still] of [["", /here is a still picture/, true], ["?scene=scene/hill", /hill.png is missing/, false]]) {
    const flat = await test.open(query, () => { HTMLCanvasElement.prototype.getContext = () => null; });
    const message = await flat.locator("#message").innerText();
    test.check(await flat.locator("#still").isVisible() === still, `no WebGL, and the still picture is ${still ? "not there" : "broken"}`);
    test.check(words.test(message), `no WebGL: "${message}"`);
    await flat.close();
}
await slide(hill, "#compare", 0.5);
await hill.waitForFunction(() => document.querySelector("#message").innerText.includes("hill.png is missing"));
test.check(await hill.locator("#still").isHidden(), "a still picture that is missing lies over the view");

await test.close();
