// Khronos' validator on baked files: no errors, no warnings.
// usage: validate.mjs WEB_FOLDER FILE...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const [web, ...files] = process.argv.slice(2);
const validator = createRequire(resolve(web, "package.json"))("gltf-validator");
let failures = 0;
for (const file of files) {
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 100 });
    for (const issue of issues.messages.filter((message) => message.severity < 2))
        console.log(`FAILED: ${file}: ${issue.code} at ${issue.pointer}: ${issue.message}`);
    failures += issues.numErrors + issues.numWarnings;
}
process.exit(failures ? 1 : 0);
