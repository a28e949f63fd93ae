// A sky for the example: day at one side of the world and night at the other, as a latitude-longitude picture.
// usage: node make_sky.mjs OUT.hdr
import { writeFileSync } from "node:fs";

const width = 256, height = 128;
const sun = normalize([1, 0.35, 0.3]);

function normalize(v) {
    const length = Math.hypot(...v);
    return v.map((x) => x / length);
}

/// Radiance towards a unit direction: blue by day, red near the low sun, dim and bluish by night; the ground is dark.
function radiance([x, y, z]) {
    const near = x * sun[0] + y * sun[1] + z * sun[2];
    const day = (0.5 + 0.5 * near) ** 2, rise = Math.max(y, 0);
    const glow = Math.max(near, 0) ** 24, dusk = day * Math.exp(-6 * rise);
    const sky = [0.25, 0.45, 1].map((blue, c) => 0.015 * [0.5, 0.7, 1][c] + day * blue
        + dusk * [1.1, 0.45, 0.05][c] + glow * [14, 10, 6][c]);
    return y > 0 ? sky : sky.map((value) => 0.15 * Math.min(value, 1));
}

/// Shared exponent: three mantissas and a power of two.
function rgbe(color) {
    const exponent = Math.ceil(Math.log2(Math.max(...color) * 1.0001));
    return [...color.map((value) => Math.floor(value * 2 ** (8 - exponent))), exponent + 128];
}

const pixels = new Uint8Array(4 * width * height);
for (let row = 0; row < height; row++)
    for (let column = 0; column < width; column++) {
        const theta = Math.PI * (row + 0.5) / height, phi = 2 * Math.PI * ((column + 0.5) / width - 0.5);
        const direction = [Math.sin(theta) * Math.cos(phi), Math.cos(theta), Math.sin(theta) * Math.sin(phi)];
        pixels.set(rgbe(radiance(direction)), 4 * (row * width + column));
    }
writeFileSync(process.argv[2], Buffer.concat([
    Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), pixels]));
