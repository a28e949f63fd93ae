/// What surfaces of a baked scene show. Exposure is a uniform that all share.
import * as THREE from "three";

/// How much of what is behind glass a pane takes away, at least.
const GLASS = 0.08;

function emissionOf({ emissive, emissiveIntensity }) {
    return emissive ? emissive.clone().multiplyScalar(emissiveIntensity) : new THREE.Color(0);
}

/// Its colour, and where it covers what is behind.
function coverOf(material) {
    return { color: material.color, vertexColors: material.vertexColors, map: material.map ?? null, alphaTest: material.alphaTest,
        transparent: material.transparent, opacity: material.opacity };
}

/// What reflects diffusely: base colour times light, and what it emits.
function litMaterial(material, light) {
    const shown = new THREE.MeshBasicMaterial(coverOf(material));
    light.apply(shown, material);
    return shown;
}

/// What does not reflect diffusely: lamps, and metal and glass, which mirror the surroundings.
function darkMaterial(material) {
    if (!material.isMeshStandardMaterial) return new THREE.MeshBasicMaterial(coverOf(material));
    if (material.transmission > 0)
        return new THREE.MeshStandardMaterial({ color: 0, roughness: material.roughness, transparent: true,
            opacity: Math.max(GLASS, 1 - Math.max(...material.color.toArray())), depthWrite: false });
    return new THREE.MeshStandardMaterial({ ...coverOf(material),
        metalness: material.metalness, metalnessMap: material.metalnessMap,
        roughness: material.roughness, roughnessMap: material.roughnessMap });
}

/// @param light where the mesh has its light; null = it has none
export function shownMaterial(material, light, exposure) {
    const shown = light ? litMaterial(material, light) : darkMaterial(material);
    const emission = emissionOf(material);
    Object.assign(shown, { name: material.name, side: material.side, toneMapped: false });
    shown.userData = { emission };
    // emission is added to what light does: one line in a shader that three.js makes
    shown.onBeforeCompile = (shader) => {
        light?.adapt(shader);
        Object.assign(shader.uniforms, { emission: { value: emission }, exposure });
        shader.fragmentShader = "uniform vec3 emission; uniform float exposure;\n" + shader.fragmentShader.replace(
            "#include <opaque_fragment>",
            "outgoingLight = exposure * (outgoingLight + emission);\n#include <opaque_fragment>");
    };
    return shown;
}
