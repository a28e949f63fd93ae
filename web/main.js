/// The page: a baked scene under lights that can be dimmed and coloured. ?scene=FOLDER/NAME chooses another one.
import * as THREE from "three";
import { VRButton } from "three/addons/webxr/VRButton.js";
import { createCamera, fitView } from "./camera.js";
import { addControls } from "./controls.js";
import { Reflections } from "./reflections.js";
import { LightBasis } from "./rt/runtime.js";
import { BakedScene } from "./scene.js";
import { Sky } from "./sky.js";

const element = (id) => document.getElementById(id);
const name = new URLSearchParams(location.search).get("scene") ?? "scene/box";

function say(message) {
    element("message").textContent = message;
    element("message").hidden = false;
}

async function fetchBytes(path) {
    const response = await fetch(path).catch(() => null);
    const type = response?.headers.get("content-type") ?? "";
    if (!response?.ok || type.startsWith("text/html")) throw new Error(`${path} is missing`);
    return response.arrayBuffer();
}

/// The path-traced picture over that share of the view, from the left.
/// @return (promised) whether there is one
async function showStill(share) {
    const still = element("still");
    if (share > 0 && !still.src) still.src = `${name}.png`;
    still.hidden = share === 0;
    still.style.clipPath = `inset(0 ${100 * (1 - share)}% 0 0)`;
    if (share === 0 || await still.decode().then(() => true, () => false)) return true;
    still.hidden = true;
    return false;
}

/// The renderer; null where the browser has no WebGL.
function createRenderer() {
    try {
        const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
        renderer.setPixelRatio(devicePixelRatio);
        element("view").append(renderer.domElement);
        return renderer;
    } catch {
        return null;
    }
}

async function loadBasis() {
    const [module, file] = await Promise.all([fetchBytes("resolvent_rt.wasm"), fetchBytes(`${name}.light.safetensors`)]);
    return LightBasis.create(module, file);
}

/// Lets the visitor change the lights of a basis.
function letLightsChange(basis, scene, sky, reflections, redraw) {
    scene.checkBasis(basis);
    addControls(element("lights"), basis, (scales, degrees) => {
        scene.light.show(basis.relight(scales, degrees));
        basis.names.forEach((light, k) => scene.scaleLamps(light, scales[k]));
        sky?.turn(degrees, Math.max(...(scales[basis.names.indexOf("environment")] ?? [0])));
        element("timing").textContent = `relit in ${basis.milliseconds.toFixed(2)} ms, ${basis.receiverCount} ${scene.light.kind}`;
        reflections.follow(redraw);
        redraw();
    });
}

/// Mean difference per channel, 0..1, between what is shown and a picture that is fitted into the view as the still is.
async function compareWith(renderer, draw, url) {
    const picture = new Image();
    picture.src = url;
    await picture.decode();
    draw();
    const pixels = [renderer.domElement, picture].map((source) => {
        const canvas = new OffscreenCanvas(picture.naturalWidth, picture.naturalHeight);
        const context = canvas.getContext("2d");
        const scale = Math.min(source.width / canvas.width, source.height / canvas.height);
        const [width, height] = [scale * canvas.width, scale * canvas.height];
        context.drawImage(source, (source.width - width) / 2, (source.height - height) / 2, width, height, 0, 0, canvas.width, canvas.height);
        return context.getImageData(0, 0, canvas.width, canvas.height).data;
    });
    const sums = [0, 0, 0];
    for (let k = 0; k < pixels[0].length; k++)
        if (k % 4 < 3) sums[k % 4] += Math.abs(pixels[0][k] - pixels[1][k]);
    return sums.map((sum) => sum / 255 / (pixels[0].length / 4));
}

async function offerHeadset(renderer, draw) {
    if (!await navigator.xr?.isSessionSupported("immersive-vr").catch(() => false)) return;
    renderer.xr.enabled = true;
    renderer.setAnimationLoop(draw);
    document.body.append(VRButton.createButton(renderer));
}

async function main() {
    const renderer = createRenderer();
    if (!renderer) {
        element("panel").hidden = true;
        const instead = await showStill(1) ? ": here is a still picture instead" : `, and ${name}.png is missing`;
        say(`This browser shows no WebGL${instead}.`);
        return {};
    }
    const scene = await BakedScene.load(await fetchBytes(`${name}.glb`));
    const world = new THREE.Scene();
    world.add(scene.root);
    const basis = await loadBasis().catch((error) => { say(`The lights cannot be changed: ${error.message}.`); return null; });
    const sky = basis?.names.includes("environment") ? await Sky.load(`${name}.hdr`, world) : null;
    const { camera, controls } = createCamera(scene, renderer);
    const reflections = new Reflections(renderer, world, scene, camera.position.clone());
    const draw = () => renderer.render(world, camera);
    const resize = () => {
        const { naturalWidth, naturalHeight } = element("still");
        const aspect = naturalWidth ? naturalWidth / naturalHeight : scene.camera.aspect;
        fitView(camera, scene.camera.fov, aspect, innerWidth, innerHeight);
        renderer.setSize(innerWidth, innerHeight);
        draw();
    };
    element("exposure").oninput = () => {
        scene.exposure.value = 2 ** element("exposure").value;
        sky?.expose(scene.exposure.value);
        draw();
    };
    element("wireframe").onchange = () => { scene.setWireframe(element("wireframe").checked); draw(); };
    element("compare").oninput = async () => {
        controls.reset(); // the picture was taken from there
        if (await showStill(Number(element("compare").value))) return;
        element("compare").disabled = true;
        say(`${name}.png is missing.`);
    };
    element("still").onload = resize;
    controls.addEventListener("change", draw);
    addEventListener("resize", resize);
    resize();
    await offerHeadset(renderer, draw);
    try {
        if (basis) letLightsChange(basis, scene, sky, reflections, draw);
    } catch (error) {
        say(`The lights cannot be changed: ${error.message}.`);
    }
    reflections.update();
    draw();
    return { basis, compareWith: (url) => compareWith(renderer, draw, url) };
}

// what tests wait for
window.page = main().catch((error) => {
    say(`The scene cannot be shown: ${error.message}.`);
    return {};
});
