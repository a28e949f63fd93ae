// What tests of the page share: a server, headless Chromium, and a count of what failed.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join, normalize, resolve } from "node:path";

const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm", ".png": "image/png" };

/// What isolates a page, so that it may share memory among threads.
const isolation = { "cross-origin-opener-policy": "same-origin", "cross-origin-embedder-policy": "require-corp" };

/// Serves a folder; what is under /truncated/ is cut in half. @param isIsolated says whether pages are, at each request
function serve(folder, isIsolated) {
    return createServer(async (request, response) => {
        const path = normalize(new URL(request.url, "http://localhost").pathname).replace(/\/$/, "/index.html");
        try {
            let body = await readFile(join(folder, path.replace("/truncated/", "/scene/")));
            if (path.startsWith("/truncated/")) body = body.subarray(0, body.length / 2);
            for (const [header, value] of Object.entries(isIsolated() ? isolation : {})) response.setHeader(header, value);
            response.setHeader("content-type", types[path.slice(path.lastIndexOf("."))] ?? "application/octet-stream");
            response.end(body);
        } catch {
            response.statusCode = 404;
            response.end();
        }
    }).listen(0);
}

/// What axe-core finds serious in a page, one line each. @param load `require` of the folder that has it
export async function findBarriers(page, load) {
    await page.addScriptTag({ path: load.resolve("axe-core") });
    const { violations } = await page.evaluate(() => window.axe.run({ resultTypes: ["violations"] }));
    return violations.filter(({ impact }) => impact === "serious" || impact === "critical")
        .map(({ id, help, nodes }) => `${id}, ${help}: ${nodes.length} times, first ${nodes[0].html.slice(0, 120)}`);
}

export class PageTest {
    failures = 0;

    /// @param web folder of the page's sources @param folder the built page @param side of the view, pixels
    static async create(web, folder, side) {
        const test = new PageTest();
        test.load = createRequire(resolve(web, "package.json"));
        const { chromium } = test.load("playwright-core");
        test.side = side;
        test.isolated = false;
        test.server = serve(folder, () => test.isolated);
        test.address = `http://localhost:${test.server.address().port}/`;
        test.browser = await chromium.launch({
            executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
            args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        });
        return test;
    }

    check(condition, what) {
        if (!condition) console.log("FAILED:", what);
        this.failures += !condition;
    }

    /// @param setup runs in the page before its own code
    async open(query, setup) {
        const page = await this.browser.newPage({ viewport: { width: this.side, height: this.side } });
        page.on("pageerror", (error) => this.check(false, `${query}: ${error.message}`));
        if (setup) await page.addInitScript(setup);
        await page.goto(this.address + query);
        await page.evaluate(() => window.page.then(() => true));
        return page;
    }

    async checkBarriers(page) {
        for (const barrier of await findBarriers(page, this.load)) this.check(false, barrier);
    }

    /// Mean difference per channel from one of our own pictures. @param exposure of that picture, stops
    async compare(page, picture, most = 0.02, exposure = 0) {
        await page.evaluate((stops) => {
            const slider = document.querySelector("#exposure");
            Object.assign(slider, { min: -64, max: 64, value: stops });
            slider.dispatchEvent(new Event("input"));
        }, exposure);
        const difference = await page.evaluate((url) => window.page.then((shown) => shown.compareWith(url)), picture);
        console.log(`${picture}: mean difference per channel`, difference.map((d) => `${(100 * d).toFixed(2)} %`).join(", "));
        this.check(difference.every((d) => d <= most), `the page differs from ${picture}`);
    }

    async photograph(page, path, width = 720, height = 540) {
        await page.setViewportSize({ width, height });
        await page.screenshot({ path });
        await page.setViewportSize({ width: this.side, height: this.side });
    }

    async close() {
        await this.browser.close();
        this.server.close();
        if (!this.failures) console.log("all passed");
        process.exit(this.failures ? 1 : 0);
    }
}
