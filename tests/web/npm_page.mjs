// The installed package in a plain page without a bundler, under a strict content security policy.
// usage: npm_page.mjs WEB_FOLDER PAGE_FOLDER [FOLDER_FOR_SCREENSHOTS]
import { join } from "node:path";
import { PageTest } from "./browser.mjs";

const [web, folder, screenshots] = process.argv.slice(2);
const test = await PageTest.create(web, folder, 256);
const page = await test.open("npm_page.html");
for (const name of ["box", "map"]) {
    const shown = await page.evaluate(async (name) => {
        const { show, mean } = await window.page;
        const view = await show(`${name}.glb`);
        const lamp = view.room.lights[0];
        const result = { lights: view.room.lights, baked: mean(view) };
        view.room.setLight(lamp, 1, 0xff8000);
        view.draw();
        result.orange = mean(view);
        view.room.setLight(lamp, 0);
        view.draw();
        result.dark = mean(view);
        view.room.setLight(lamp, 1);
        view.draw();
        result.again = mean(view);
        result.milliseconds = view.room.milliseconds;
        try {
            view.room.setLight("no such lamp", 1);
        } catch (error) {
            result.error = error.message;
        }
        return result;
    }, name);
    console.log(name, JSON.stringify(shown));
    test.check(shown.baked[0] > 0.1, `${name}: something is shown`);
    test.check(shown.dark.every((value) => value === 0), `${name}: dark without its only lamp`);
    test.check(shown.again.every((value, k) => Math.abs(value - shown.baked[k]) < 0.01), `${name}: as baked again`);
    test.check(shown.orange[2] < 0.02 && Math.abs(shown.orange[0] - shown.baked[0]) < 0.01, `${name}: orange`);
    test.check(shown.error?.includes("there is no light 'no such lamp'"), `${name}: ${shown.error}`);
    if (screenshots) await page.screenshot({ path: join(screenshots, `npm-${name}.png`) });
}
const worker = await page.evaluate(async () => (await window.page).inWorker("box.light.safetensors"));
console.log("worker", JSON.stringify(worker));
test.check(worker.halved && worker.error.includes("do not fit"), "the worker relights, and says what is wrong");
const missing = await page.evaluate(async () => (await window.page).show("nowhere.glb").then(() => "nothing", (e) => e.message));
test.check(missing.includes("is missing"), `a missing file: ${missing}`);
const mixed = await page.evaluate(async () => {
    const { RelightableScene } = await import("resolvent-rt/three");
    return RelightableScene.load("box.glb", "map.light.safetensors").then(() => "nothing", (e) => e.message);
});
test.check(mixed.includes("not baked together"), `a basis of another file: ${mixed}`);
// the sample page, with the box as its room
const sample = await test.browser.newPage();
sample.on("pageerror", (error) => test.check(false, `samples/page: ${error.message}`));
await sample.goto(`${test.address}index.html`);
await sample.waitForSelector("input[type=range]", { timeout: 10000 }).catch(() => null);
test.check((await sample.$$("input[type=range]")).length === 2, "samples/page: a slider for the only light, one for exposure");
await test.close();
