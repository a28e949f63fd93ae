/// Baked scenes for three.js, relit when their lights change.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MapLight, VertexLight } from "./light.js";
import { shownMaterial } from "./materials.js";
import { loadModule } from "./module.js";
import { LightBasis } from "./runtime.js";

async function fetchBytes(url) {
    const response = await fetch(url).catch(() => null);
    if (!response?.ok) throw new Error(`${url} is missing`);
    return response.arrayBuffer();
}

/// A file of `resolvent bake --to vertex|lightmap --basis`.
export class RelightableScene {
    /// @param url of the .glb @param basisUrl default: beside it, as `bake` names it
    static async load(url, basisUrl = url.replace(/\.glb$/, ".light.safetensors")) {
        const [file, basis, module] = await Promise.all([fetchBytes(url), fetchBytes(basisUrl), loadModule()]);
        return RelightableScene.parse(file, basis, module);
    }

    /// The same of bytes.
    static async parse(file, basisFile, module) {
        const gltf = await new GLTFLoader().parseAsync(file, "");
        const scale = gltf.asset.extras?.resolvent?.light_scale;
        const light = scale ? new VertexLight(scale) : await MapLight.find(gltf);
        if (!light) throw new Error("the file holds no baked light, neither in vertices nor in a lightmap");
        const basis = await LightBasis.create(module ?? await loadModule(), basisFile);
        return new RelightableScene(gltf, light, basis);
    }

    #light;
    #basis;
    #scales;
    #lamps = [];
    #degrees;
    #changed = true;

    constructor(gltf, light, basis) {
        this.root = gltf.scene;
        this.animations = gltf.animations;
        this.camera = gltf.cameras[0] ?? null;
        /// Multiplies what is shown, before tone mapping.
        this.exposure = { value: 1 };
        this.#light = light;
        this.#basis = basis;
        this.#scales = basis.names.map(() => [1, 1, 1]);
        this.#degrees = basis.rotation;
        const punctual = [];
        this.root.traverse((node) => node.isLight && punctual.push(node));
        punctual.forEach((node) => node.removeFromParent()); // their light is baked
        this.root.traverse((node) => node.isMesh && this.#adopt(node));
        if (light.count !== basis.receiverCount)
            throw new Error(`the light basis has ${basis.receiverCount} receivers, the scene ${light.count} ${light.kind}: they were not baked together`);
        this.root.updateMatrixWorld(true);
    }

    #adopt(mesh) {
        const lit = this.#light.adopt(mesh);
        const shown = shownMaterial(mesh.material, lit ? this.#light : null, this.exposure);
        shown.toneMapped = true;
        mesh.material = shown;
        const { emission } = shown.userData;
        if (emission.r + emission.g + emission.b > 0)
            this.#lamps.push({ name: shown.name, emission, baked: emission.clone() });
    }

    #index(name) {
        const index = this.#basis.names.indexOf(name);
        if (index < 0) throw new Error(`there is no light '${name}'; there are ${this.#basis.names.join(", ")}`);
        return index;
    }

    /// Names of the lights.
    get lights() {
        return [...this.#basis.names];
    }

    /// Milliseconds that relighting took last.
    get milliseconds() {
        return this.#basis.milliseconds;
    }

    /// @param strength relative to the bake, 0 = off @param color as of THREE.Color, or white
    setLight(name, strength, color = 0xffffff) {
        if (!(strength >= 0 && strength < Infinity)) throw new RangeError(`light '${name}': its strength is ${strength}`);
        const { r, g, b } = new THREE.Color(color);
        this.#scales[this.#index(name)] = [strength * r, strength * g, strength * b];
        this.#changed = true;
    }

    /// Turns the surroundings, if they were baked with --env-turns.
    turnSky(degrees) {
        this.#degrees = degrees;
        this.#changed = true;
    }

    /// Relights if something has changed. @return whether it had
    update() {
        if (!this.#changed) return false;
        this.#changed = false;
        this.#light.show(this.#basis.relight(this.#scales, this.#degrees));
        for (const lamp of this.#lamps) {
            const index = this.#basis.names.indexOf(lamp.name);
            if (index >= 0) lamp.emission.copy(lamp.baked).multiply(new THREE.Color(...this.#scales[index]));
        }
        return true;
    }

    /// Frees what the graphics card holds.
    dispose() {
        this.root.traverse((node) => {
            if (!node.isMesh) return;
            node.geometry.dispose();
            node.material.dispose();
        });
        this.#light.texture?.dispose();
    }
}
