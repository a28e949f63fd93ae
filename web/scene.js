/// A baked glTF scene: diffuse surfaces show base colour times light, lamps what they emit.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { findCamera } from "./camera.js";
import { MapLight, VertexLight } from "./rt/light.js";
import { shownMaterial } from "./rt/materials.js";

export class BakedScene {
    static async load(bytes) {
        const gltf = await new GLTFLoader().parseAsync(bytes, "");
        const scale = gltf.asset.extras?.resolvent?.light_scale;
        const light = scale ? new VertexLight(scale) : await MapLight.find(gltf);
        const scene = light && new BakedScene(gltf, light);
        if (!light?.count) throw new Error("the file holds no baked light, neither in vertices nor in a lightmap");
        return scene;
    }

    constructor(gltf, light) {
        this.root = gltf.scene;
        this.light = light;
        this.exposure = { value: 1 };
        this.lamps = [];
        this.mirrors = [];
        const lights = [];
        this.root.traverse((node) => node.isLight && lights.push(node));
        lights.forEach((node) => node.removeFromParent()); // their light is baked
        this.root.traverse((node) => node.isMesh && this.#adopt(node));
        this.root.updateMatrixWorld(true);
        this.camera = findCamera(this.root);
    }

    #adopt(mesh) {
        const lit = this.light.adopt(mesh);
        const shown = shownMaterial(mesh.material, lit ? this.light : null, this.exposure);
        const { emission } = shown.userData;
        mesh.material = shown;
        if (shown.isMeshStandardMaterial) this.mirrors.push(mesh);
        if (emission.r + emission.g + emission.b > 0)
            this.lamps.push({ name: shown.name, emission, baked: emission.clone() });
    }

    /// Whether a basis was baked with this scene; throws if it was not.
    checkBasis({ receiverCount }) {
        const { count, kind } = this.light;
        if (count !== receiverCount)
            throw new Error(`the light basis has ${receiverCount} receivers, the scene ${count} ${kind}: they were not baked together`);
    }

    /// Lamps shine as their light does.
    scaleLamps(name, scale) {
        for (const lamp of this.lamps)
            if (lamp.name === name) lamp.emission.copy(lamp.baked).multiply(new THREE.Color(...scale));
    }

    setWireframe(on) {
        this.root.traverse((node) => { if (node.isMesh) node.material.wireframe = on; });
    }
}
