/// Chooses an exposure as `resolvent render` and `view` do for files (src/io/image_exposure.c): none if the picture's
/// log-average luminance lies in a well-lit range, else just enough to reach the nearer end of that range.
import { FloatType, WebGLRenderTarget } from "three";
import { fitView } from "./camera.js";

/// As in image_exposure.c, which says what they are.
const [DARKEST, BRIGHTEST, DEPTH, BRIGHT_SHARE, LEAST_LIT, MOST] = [0.13, 0.36, 8, 0.05, 0.0005, 64];

/// Of the slider, and so of the result.
export const STEP = 0.05;

/// Pixels along the shorter side of the picture that is looked at.
const SIDE = 128;

/// @param pixels of a picture, linear, four numbers each @return stops
export function chooseExposure(pixels) {
    const stops = [];
    for (let k = 0; k < pixels.length; k += 4) {
        const luminance = 0.2126 * pixels[k] + 0.7152 * pixels[k + 1] + 0.0722 * pixels[k + 2];
        if (luminance > 0 && luminance < Infinity) stops.push(Math.log2(luminance));
    }
    if (stops.length <= LEAST_LIT * pixels.length / 4) return 0;
    stops.sort((a, b) => b - a);
    const floor = stops[Math.floor(BRIGHT_SHARE * stops.length)] - DEPTH;
    const mean = stops.reduce((sum, value) => sum + Math.max(value, floor), 0) / stops.length;
    const change = Math.max(Math.log2(DARKEST) - mean, 0) + Math.min(Math.log2(BRIGHTEST) - mean, 0);
    return Math.round(Math.min(Math.max(change, -MOST), MOST) / STEP) * STEP;
}

/// The exposure of a scene as its own camera sees it, whatever the shape of the window. It is shown without exposure
/// now. @return stops; 0 where the graphics card does not draw floats
export function findExposure(renderer, world, { fov, aspect }, camera) {
    if (!renderer.extensions.has("EXT_color_buffer_float")) return 0;
    const scale = SIDE / Math.min(aspect, 1);
    const [width, height] = [Math.max(1, Math.round(scale * aspect)), Math.round(scale)];
    const target = new WebGLRenderTarget(width, height, { type: FloatType }), lens = camera.clone();
    const pixels = new Float32Array(4 * width * height);
    fitView(lens, fov, aspect, width, height);
    renderer.setRenderTarget(target);
    renderer.render(world, lens);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    renderer.setRenderTarget(null);
    target.dispose();
    return chooseExposure(pixels);
}
