/// Where a baked scene keeps its light: in its vertices, or in the texels of a lightmap.
import * as THREE from "three";

/// COLOR_0 of the vertices: irradiance / (pi light_scale), times the colour that they had before. That is kept in _COLOR.
export class VertexLight {
    kind = "vertices";
    #surfaces = [];

    /// @param scale `asset.extras.resolvent.light_scale`
    constructor(scale) {
        this.scale = scale;
    }

    /// How many values of light there are.
    get count() {
        return this.#surfaces.reduce((sum, { light }) => sum + light.count, 0);
    }

    /// Whether light is in this mesh; it becomes radiance of a white surface then, as baked. Other meshes keep their colours.
    adopt({ geometry }) {
        const { color: baked, _color: own } = geometry.attributes;
        const first = geometry.userData.resolvent_first_receiver;
        if (!baked || first === undefined) return false;
        const light = new THREE.BufferAttribute(new Float32Array(baked.itemSize * baked.count), baked.itemSize);
        for (let k = 0; k < light.count; k++)
            for (let c = 0; c < light.itemSize; c++)
                light.setComponent(k, c, baked.getComponent(k, c) * (c < 3 ? this.scale : 1));
        geometry.setAttribute("color", light);
        geometry.deleteAttribute("_color"); // the card needs none
        this.#surfaces.push({ light, own, first });
        return true;
    }

    adapt() {}

    apply() {}

    show(irradiance) {
        for (const { light, own, first } of this.#surfaces) {
            for (let k = 0; k < light.count; k++)
                for (let c = 0; c < 3; c++)
                    light.setComponent(k, c, irradiance[3 * (first + k) + c] / Math.PI * (own?.getComponent(k, c) ?? 1));
            light.needsUpdate = true;
        }
    }
}

/// MOZ_lightmap: irradiance in one texture, as 8-bit codes until a basis brings it in full.
export class MapLight {
    kind = "texels";
    #materials = [];

    /// The map that the materials of a file name; null if none does, an error if they name several.
    static async find({ parser }) {
        const named = (parser.json.materials ?? []).map(({ extensions }) => extensions?.MOZ_lightmap).filter(Boolean);
        if (!named.length) return null;
        if (named.some(({ index }) => index !== named[0].index)) throw new Error("the scene has several lightmaps");
        return new MapLight(await parser.getDependency("texture", named[0].index));
    }

    constructor(texture) {
        texture.colorSpace = THREE.SRGBColorSpace;
        this.texture = texture;
    }

    get count() {
        return this.texture.image.width * this.texture.image.height;
    }

    adopt({ material }) {
        return material.userData.gltfExtensions?.MOZ_lightmap !== undefined;
    }

    /// Within its triangle, even where a pixel's middle lies beyond an edge: light of other surfaces is next to it in the map.
    adapt(shader) {
        for (const [stage, chunk] of [["vertexShader", "uv_pars_vertex"], ["fragmentShader", "uv_pars_fragment"]])
            shader[stage] = shader[stage].replace(`#include <${chunk}>`,
                THREE.ShaderChunk[chunk].replace("varying vec2 vLightMapUv", "centroid varying vec2 vLightMapUv"));
    }

    apply(shown, { userData }) {
        const { texCoord = 1, intensity = 1 } = userData.gltfExtensions.MOZ_lightmap;
        this.texture.channel = texCoord;
        shown.lightMap = this.texture;
        shown.lightMapIntensity = intensity;
        this.#materials.push(shown);
    }

    show(irradiance) {
        if (!this.texture.isDataTexture) this.#takeFloats(irradiance);
        this.texture.needsUpdate = true;
    }

    /// The texture becomes one of halves, which every browser can filter, over the memory that light is put into.
    #takeFloats(irradiance) {
        const { channel, image } = this.texture;
        this.texture.dispose();
        this.texture = new THREE.DataTexture(irradiance, image.width, image.height, THREE.RGBFormat, THREE.FloatType);
        Object.assign(this.texture, { internalFormat: "RGB16F", channel,
            minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter });
        for (const material of this.#materials)
            Object.assign(material, { lightMap: this.texture, lightMapIntensity: 1 });
    }
}
