// Pages as files, without a server, at the width of a phone and of a desk: axe-core finds nothing serious, no page is wider than the
// window, and no script fails.
// usage: test_axe.mjs WEB_FOLDER SITE_FOLDER PAGE...
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { findBarriers } from "./browser.mjs";

const [web, site, ...names] = process.argv.slice(2);
const load = createRequire(resolve(web, "package.json"));
const { chromium } = load("playwright-core");
const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"],
});
let failures = 0;

function fail(what) {
    console.log("FAILED:", what);
    failures++;
}

for (const width of [390, 1280]) {
    const page = await browser.newPage({ viewport: { width, height: 900 } });
    page.on("pageerror", (error) => fail(`${page.url()}: ${error.message}`));
    for (const name of names) {
        await page.goto(pathToFileURL(resolve(join(site, name))).href);
        for (const barrier of await findBarriers(page, load)) fail(`${name} at ${width}: ${barrier}`);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
        if (wide > 0) fail(`${name} at ${width}: ${wide} pixels too wide`);
    }
    await page.close();
}
await browser.close();
console.log(failures ? "failed" : `axe-core: ${names.length} pages, nothing serious`);
process.exit(failures ? 1 : 0);
