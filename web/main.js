/// The page: a baked scene under lights that can be dimmed and coloured. ?scene=FOLDER/NAME chooses another one.
import * as THREE from "three";
import { VRButton } from "three/addons/webxr/VRButton.js";
import { createCamera, fitView } from "./camera.js";
import { addControls } from "./controls.js";
import { findExposure } from "./exposure.js";
import { Reflections } from "./reflections.js";
import { LightBasis } from "./rt/runtime.js";
import { BakedScene } from "./scene.js";
import { Sky } from "./sky.js";
import { Solving, hasSolver, nameStep } from "./solve.js";

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

/// A scene that lies beside the page, and what belongs to it.
const served = {
    name,
    glb: () => fetchBytes(`${name}.glb`),
    basis: () => fetchBytes(`${name}.light.safetensors`),
    sky: `${name}.hdr`,
};

async function loadBasis(source) {
    const [module, file] = await Promise.all([fetchBytes("resolvent_rt.wasm"), source.basis()]);
    return LightBasis.create(module, file);
}

/// Lets the visitor change the lights of a basis.
function letLightsChange(basis, scene, sky, reflections, redraw) {
    scene.checkBasis(basis);
    element("lights").replaceChildren();
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

/// Frees what a scene that is no longer shown has on the graphics card.
function release({ world, controls, reflections }) {
    controls.dispose();
    reflections.dispose();
    world.traverse(({ geometry, material }) => {
        geometry?.dispose();
        material?.map?.dispose();
        material?.lightMap?.dispose();
        material?.dispose();
    });
    world.background?.dispose?.();
}

/// Builds what is drawn of a scene. @param say takes what is wrong with its lights
async function openScene(renderer, source) {
    const scene = await BakedScene.load(await source.glb());
    const world = new THREE.Scene();
    world.add(scene.root);
    const basis = await loadBasis(source).catch((error) => { say(`The lights cannot be changed: ${error.message}.`); return null; });
    const sky = source.sky && basis?.names.includes("environment") ? await Sky.load(source.sky, world) : null;
    const { camera, controls } = createCamera(scene, renderer);
    const reflections = new Reflections(renderer, world, scene, camera.position.clone());
    return { scene, world, basis, sky, camera, controls, reflections };
}

/// Shows a scene, and lets the visitor change it, in place of what was shown.
function showScene(renderer, shown, view) {
    const { scene, world, basis, sky, camera, controls, reflections } = view;
    const draw = () => renderer.render(world, camera);
    if (shown.view) release(shown.view);
    Object.assign(shown, { view, draw, basis });
    shown.resize = () => {
        const { naturalWidth, naturalHeight } = element("still");
        const aspect = naturalWidth ? naturalWidth / naturalHeight : scene.camera.aspect;
        fitView(camera, scene.camera.fov, aspect, innerWidth, innerHeight);
        renderer.setSize(innerWidth, innerHeight);
        draw();
    };
    const expose = (stops) => {
        scene.exposure.value = 2 ** stops;
        sky?.expose(scene.exposure.value);
    };
    element("exposure").oninput = () => { expose(Number(element("exposure").value)); draw(); };
    element("wireframe").onchange = () => { scene.setWireframe(element("wireframe").checked); draw(); };
    controls.addEventListener("change", draw);
    shown.resize();
    try {
        if (basis) letLightsChange(basis, scene, sky, reflections, draw);
    } catch (error) {
        say(`The lights cannot be changed: ${error.message}.`);
    }
    reflections.update();
    expose(0);
    offerExposure(findExposure(renderer, world, scene.camera, camera));
    element("exposure").oninput();
    element("wireframe").onchange();
}

/// The slider begins with the exposure that was chosen, and reaches as far from there to either side.
function offerExposure(stops) {
    Object.assign(element("exposure"), { min: stops - 4, max: stops + 4, value: stops });
}

/// The path-traced picture of the scene that lies beside the page.
function letCompare(shown) {
    element("compare").oninput = async () => {
        shown.view.controls.reset(); // the picture was taken from there
        if (await showStill(Number(element("compare").value))) return;
        element("compare").disabled = true;
        say(`${name}.png is missing.`);
    };
    element("still").onload = () => shown.resize();
}

/// A scene of the visitor's has no such picture.
function endCompare() {
    element("compare").parentElement.hidden = element("still").hidden = true;
    element("still").removeAttribute("src");
}

// ---- scenes of the visitor --------------------------------------------------------------------------

function offerFile(link, bytes, name) {
    URL.revokeObjectURL(link.href);
    link.href = URL.createObjectURL(new Blob([bytes]));
    link.download = name;
}

function listNotes(notes) {
    element("notes").hidden = notes.length === 0;
    element("notes").querySelector("ul").replaceChildren(...notes.map((note) =>
        Object.assign(document.createElement("li"), { textContent: note })));
}

/// Solves a file and shows it. @return (promised) seconds that it took, and on how many threads
async function solveFile(file, renderer, shown) {
    const start = performance.now();
    const seconds = () => (performance.now() - start) / 1000;
    element("message").hidden = element("saved").hidden = true;
    element("work").hidden = false;
    element("file").disabled = true;
    const solving = new Solving(await file.arrayBuffer(), (phase, fraction) => {
        element("progress").value = fraction;
        element("step").textContent = `${nameStep(phase)}, ${seconds().toFixed(0)} s`;
    });
    element("step").textContent = "reading the scene";
    element("cancel").onclick = () => solving.cancel();
    try {
        const { glb, basis, threads } = await solving.result;
        const solved = seconds();
        showScene(renderer, shown, await openScene(renderer, { glb: () => glb, basis: () => basis }));
        endCompare();
        const base = file.name.replace(/[.]glb$/i, "");
        offerFile(element("save-scene"), glb, `${base}-lit.glb`);
        offerFile(element("save-basis"), basis, `${base}-lit.light.safetensors`);
        element("saved").hidden = false;
        return { seconds: solved, threads };
    } catch (error) {
        say(error.message === "cancelled" ? "Cancelled: the scene before is still shown." : `${file.name}: ${error.message}.`);
        return null;
    } finally {
        listNotes(solving.notes);
        element("work").hidden = true;
        element("file").disabled = false;
        element("file").value = "";
    }
}

/// Takes files that are chosen or dropped anywhere on the page, one at a time.
async function letSolve(renderer, shown) {
    if (!await hasSolver()) return;
    element("open").hidden = false;
    const take = (file) => {
        if (!file || element("file").disabled) return;
        shown.solved = solveFile(file, renderer, shown);
    };
    element("file").onchange = () => take(element("file").files[0]);
    addEventListener("dragover", (event) => { event.preventDefault(); element("open").classList.add("over"); });
    addEventListener("dragleave", () => element("open").classList.remove("over"));
    addEventListener("drop", (event) => {
        event.preventDefault();
        element("open").classList.remove("over");
        take(event.dataTransfer.files[0]);
    });
}

async function main() {
    const renderer = createRenderer();
    if (!renderer) {
        element("panel").hidden = true;
        const instead = await showStill(1) ? ": here is a still picture instead" : `, and ${name}.png is missing`;
        say(`This browser shows no WebGL${instead}.`);
        return {};
    }
    const shown = {};
    addEventListener("resize", () => shown.resize?.());
    await letSolve(renderer, shown); // first: it works where the scene beside the page does not
    showScene(renderer, shown, await openScene(renderer, served));
    letCompare(shown);
    await offerHeadset(renderer, () => shown.draw());
    return Object.assign(shown, { compareWith: (url) => compareWith(renderer, shown.draw, url) });
}

// what tests wait for
window.page = main().catch((error) => {
    say(`The scene cannot be shown: ${error.message}.`);
    return {};
});
