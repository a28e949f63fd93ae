/// A baked glTF scene: diffuse surfaces show base colour times light, lamps what they emit.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/// What a surface shows: radiance = base colour * irradiance / pi, or what it emits.
function shownMaterial(material, lit) {
    const emits = material.emissive && material.emissive.getHex() !== 0;
    const shown = new THREE.MeshBasicMaterial({
        name: material.name,
        color: emits && !lit ? new THREE.Color(0) : material.color,
        map: material.map ?? null,
        side: material.side,
        alphaTest: material.alphaTest,
        transparent: material.transparent,
        opacity: material.opacity,
        vertexColors: lit,
        toneMapped: false,
    });
    shown.userData.emission = emits
        ? material.emissive.clone().multiplyScalar(material.emissiveIntensity)
        : new THREE.Color(0);
    // emission is added to what light does: one line in a shader that three.js makes
    shown.onBeforeCompile = (shader) => {
        shader.uniforms.emission = { value: shown.userData.emission };
        shader.uniforms.exposure = shown.userData.exposure;
        shader.fragmentShader = "uniform vec3 emission; uniform float exposure;\n" + shader.fragmentShader.replace(
            "#include <opaque_fragment>",
            "outgoingLight = exposure * (outgoingLight + emission);\n#include <opaque_fragment>");
    };
    return shown;
}

export class BakedScene {
    static async load(bytes) {
        const gltf = await new GLTFLoader().parseAsync(bytes, "");
        return new BakedScene(gltf);
    }

    constructor(gltf) {
        this.root = gltf.scene;
        this.camera = gltf.cameras[0] ?? new THREE.PerspectiveCamera(45, 1, 0.01, 100);
        this.lightScale = gltf.asset.extras?.resolvent?.light_scale;
        this.exposure = { value: 1 };
        this.surfaces = [];
        this.lamps = [];
        if (!this.lightScale) throw new Error("the scene holds no baked light");
        const lights = [];
        this.root.traverse((node) => node.isLight && lights.push(node));
        lights.forEach((light) => light.removeFromParent()); // their light is in the vertices
        this.root.traverse((node) => node.isMesh && this.#adopt(node));
        this.root.updateMatrixWorld(true);
    }

    #adopt(mesh) {
        const color = mesh.geometry.getAttribute("color");
        mesh.material = shownMaterial(mesh.material, color !== undefined);
        mesh.material.userData.exposure = this.exposure;
        if (color !== undefined) {
            // radiance of a white surface, as baked
            const light = new Float32Array(3 * color.count);
            for (let k = 0; k < color.count; k++)
                light.set([color.getX(k), color.getY(k), color.getZ(k)].map((c) => c * this.lightScale), 3 * k);
            mesh.geometry.setAttribute("color", new THREE.BufferAttribute(light, 3));
            this.surfaces.push({ light: mesh.geometry.getAttribute("color"), first: mesh.geometry.userData.resolvent_first_receiver });
        }
        const emission = mesh.material.userData.emission;
        if (emission.r + emission.g + emission.b > 0) this.lamps.push({ name: mesh.material.name, emission, baked: emission.clone() });
    }

    /// Whether a basis was baked with this scene; throws if it was not.
    checkBasis(basis) {
        const vertices = this.surfaces.reduce((sum, surface) => sum + surface.light.count, 0);
        if (vertices !== basis.receiverCount || this.surfaces.some((surface) => surface.first === undefined))
            throw new Error(`the light basis has ${basis.receiverCount} receivers, the scene ${vertices} vertices: they were not baked together`);
    }

    /// Puts irradiance into the vertices.
    show(irradiance) {
        for (const { light, first } of this.surfaces) {
            for (let k = 0; k < light.array.length; k++)
                light.array[k] = irradiance[3 * first + k] / Math.PI;
            light.needsUpdate = true;
        }
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
