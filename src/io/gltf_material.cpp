/// glTF materials in the library's terms. docs/gltf.md says what becomes of each extension.
#include "gltf_json.hpp"

#include <algorithm>
#include <cmath>

namespace rsv_gltf
{

namespace
{

typedef tinygltf::Value json;

/// Where a texture is used, in either of tinygltf's forms.
struct texture_use {
    int texture, uv_set;
    const json *transform; ///< KHR_texture_transform; may be NULL
};

texture_use use_of(int index, int uv_set, const tinygltf::ExtensionMap &extensions)
{
    const json &transform = extension(extensions, "KHR_texture_transform");
    return { index, uv_set, transform.IsObject() ? &transform : nullptr };
}

texture_use use_of(const json &object, const char *key)
{
    const json *info = find(object, key);
    if (!info) return { -1, 0, nullptr };
    const json *extensions = find(*info, "extensions");
    return { static_cast<int>(number(*info, "index", -1)),
        static_cast<int>(number(*info, "texCoord", 0)),
        extensions ? find(*extensions, "KHR_texture_transform") : nullptr };
}

/// Offset after rotation (counter-clockwise, as seen with v running down) after scale.
void set_transform(const json &transform, rsv_texture_ref &ref)
{
    double offset[2] = { 0, 0 }, scale[2] = { 1, 1 };
    double angle = number(transform, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
    numbers(transform, "offset", 2, offset);
    numbers(transform, "scale", 2, scale);
    const double m[2][3] = { { c * scale[0], s * scale[1], offset[0] },
        { -s * scale[0], c * scale[1], offset[1] } };
    for (int i = 0; i < 6; i++)
        ref.transform[i / 3][i % 3] = static_cast<float>(m[i / 3][i % 3]);
}

void add_texture(
    owned_material &to, rsv_texture_role role, bool srgb, const texture_use &use, double scale = 1)
{
    if (use.texture < 0) return;
    rsv_gltf_texture_ref ref{ use.texture, srgb, rsv_default_texture_ref(role, 0) };
    int uv_set = use.uv_set;
    if (use.transform) {
        set_transform(*use.transform, ref.ref);
        uv_set = static_cast<int>(number(*use.transform, "texCoord", uv_set));
    }
    if (uv_set < 0 || uv_set > 1) {
        to.note += "; a texture by texture coordinates " + std::to_string(uv_set) +
                   " (only 0 and 1 are read) is left out";
        return;
    }
    ref.ref.uv_set = static_cast<uint32_t>(uv_set);
    ref.ref.scale = static_cast<float>(scale);
    to.textures.push_back(ref);
}

/// Adds to the one line that will be shown.
void add_note(owned_material &to, const std::string &text) { to.note += "; " + text; }

/// Base colour, its texture and alpha.
void convert_base_color(const tinygltf::Material &source, const double factor[4],
    const texture_use &use, owned_material &to)
{
    rsv_material &m = to.material.value;
    double cutoff = source.alphaMode == "MASK" ? source.alphaCutoff : 0;
    m.base_color = to_rgb(factor);
    add_texture(to, RSV_TEXTURE_BASE_COLOR, true, use);
    to.material.opaque = source.alphaMode != "BLEND" && !(cutoff > 0);
    if (to.material.opaque) return;
    m.opacity = static_cast<float>(factor[3]);
    m.alpha_cutoff = static_cast<float>(cutoff);
    add_texture(to, RSV_TEXTURE_OPACITY, true, use);
}

void convert_metallic_roughness(const tinygltf::Material &source, owned_material &to)
{
    const tinygltf::PbrMetallicRoughness &pbr = source.pbrMetallicRoughness;
    double base_color[4] = { 1, 1, 1, 1 };
    copy_numbers(
        pbr.baseColorFactor, base_color, 4, "baseColorFactor of material '" + to.name + "'");
    convert_base_color(source, base_color,
        use_of(pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord,
            pbr.baseColorTexture.extensions),
        to);
    to.material.value.metallic = static_cast<float>(pbr.metallicFactor);
    to.material.value.roughness = static_cast<float>(pbr.roughnessFactor);
    add_texture(to, RSV_TEXTURE_METALLIC_ROUGHNESS, false,
        use_of(pbr.metallicRoughnessTexture.index, pbr.metallicRoughnessTexture.texCoord,
            pbr.metallicRoughnessTexture.extensions));
}

/// A dielectric whose Fresnel reflectance at normal incidence is the given specular colour; bright ones over a
/// dark base are metals.
void convert_specular_glossiness(
    const tinygltf::Material &source, const json &from, owned_material &to)
{
    rsv_material &m = to.material.value;
    double diffuse[4] = { 1, 1, 1, 1 }, specular[3] = { 1, 1, 1 };
    numbers(from, "diffuseFactor", 4, diffuse);
    numbers(from, "specularFactor", 3, specular);
    double f0 = std::max(specular[0], std::max(specular[1], specular[2]));
    bool metal = f0 > 0.25 && f0 > std::max(diffuse[0], std::max(diffuse[1], diffuse[2]));
    convert_base_color(source, diffuse, use_of(from, "diffuseTexture"), to);
    m.roughness = static_cast<float>(1 - number(from, "glossinessFactor", 1));
    m.metallic = metal ? 1 : 0;
    if (metal) {
        m.base_color = to_rgb(specular);
    } else if (f0 > 0) {
        double root = std::sqrt(std::min(f0, 0.9));
        const double tint[3] = { specular[0] / f0, specular[1] / f0, specular[2] / f0 };
        m.ior = static_cast<float>((1 + root) / (1 - root));
        m.specular_color = to_rgb(tint);
    } else {
        m.specular = 0;
    }
    add_note(to, "KHR_materials_pbrSpecularGlossiness is converted to metal and roughness");
    if (find(from, "specularGlossinessTexture"))
        add_note(to, "its specularGlossinessTexture is left out");
}

void convert_emission(const tinygltf::Material &source, owned_material &to)
{
    double emission[3] = { 0, 0, 0 };
    copy_numbers(
        source.emissiveFactor, emission, 3, "emissiveFactor of material '" + to.name + "'");
    const json &strength = extension(source.extensions, "KHR_materials_emissive_strength");
    double scale = number(strength, "emissiveStrength", 1);
    for (double &channel : emission)
        channel *= scale;
    to.material.value.emission = to_rgb(emission);
    add_texture(to, RSV_TEXTURE_EMISSION, true,
        use_of(source.emissiveTexture.index, source.emissiveTexture.texCoord,
            source.emissiveTexture.extensions));
}

void convert_interface(const tinygltf::ExtensionMap &extensions, owned_material &to)
{
    rsv_material &m = to.material.value;
    const json &ior = extension(extensions, "KHR_materials_ior");
    const json &specular = extension(extensions, "KHR_materials_specular");
    double index = number(ior, "ior", m.ior);
    m.ior = static_cast<float>(index == 0 ? 1e3 : index); // 0 stands for total reflection
    if (!specular.IsObject()) return;
    m.specular = static_cast<float>(number(specular, "specularFactor", 1));
    m.specular_color = color(specular, "specularColorFactor", { 1, 1, 1 });
    add_texture(to, RSV_TEXTURE_SPECULAR, false, use_of(specular, "specularTexture"));
    add_texture(to, RSV_TEXTURE_SPECULAR_COLOR, true, use_of(specular, "specularColorTexture"));
}

void convert_layers(const tinygltf::ExtensionMap &extensions, owned_material &to)
{
    rsv_material &m = to.material.value;
    const json &coat = extension(extensions, "KHR_materials_clearcoat");
    m.clearcoat = static_cast<float>(number(coat, "clearcoatFactor", 0));
    m.clearcoat_roughness = static_cast<float>(number(coat, "clearcoatRoughnessFactor", 0));
    add_texture(to, RSV_TEXTURE_CLEARCOAT, false, use_of(coat, "clearcoatTexture"));
    add_texture(
        to, RSV_TEXTURE_CLEARCOAT_ROUGHNESS, false, use_of(coat, "clearcoatRoughnessTexture"));
    if (find(coat, "clearcoatNormalTexture")) add_note(to, "clearcoatNormalTexture is ignored");
    const json &sheen = extension(extensions, "KHR_materials_sheen");
    m.sheen_color = color(sheen, "sheenColorFactor", { 0, 0, 0 });
    m.sheen_roughness = static_cast<float>(number(sheen, "sheenRoughnessFactor", 0));
    add_texture(to, RSV_TEXTURE_SHEEN_COLOR, true, use_of(sheen, "sheenColorTexture"));
    add_texture(to, RSV_TEXTURE_SHEEN_ROUGHNESS, false, use_of(sheen, "sheenRoughnessTexture"));
}

void convert_transmission(const tinygltf::ExtensionMap &extensions, owned_material &to)
{
    rsv_material &m = to.material.value;
    const json &transmission = extension(extensions, "KHR_materials_transmission");
    const json &diffuse = extension(extensions, "KHR_materials_diffuse_transmission");
    const json &volume = extension(extensions, "KHR_materials_volume");
    m.transmission = static_cast<float>(number(transmission, "transmissionFactor", 0));
    add_texture(to, RSV_TEXTURE_TRANSMISSION, false, use_of(transmission, "transmissionTexture"));
    m.diffuse_transmission = static_cast<float>(number(diffuse, "diffuseTransmissionFactor", 0));
    m.diffuse_transmission_color = color(diffuse, "diffuseTransmissionColorFactor", { 1, 1, 1 });
    add_texture(
        to, RSV_TEXTURE_DIFFUSE_TRANSMISSION, false, use_of(diffuse, "diffuseTransmissionTexture"));
    add_texture(to, RSV_TEXTURE_DIFFUSE_TRANSMISSION_COLOR, true,
        use_of(diffuse, "diffuseTransmissionColorTexture"));
    m.thickness = static_cast<float>(number(volume, "thicknessFactor", 0));
    m.attenuation_color = color(volume, "attenuationColor", { 1, 1, 1 });
    m.attenuation_distance = static_cast<float>(number(volume, "attenuationDistance", INFINITY));
}

float mean_free_path(float color, float distance)
{
    if (!(distance < INFINITY) || !(color > 0) || color >= 1)
        return distance < INFINITY ? 0 : distance;
    return -distance / std::log(color);
}

/// A medium that scatters: what enters leaves near by, with the multiple-scattering colour as reflectance, after
/// a mean free path that the attenuation of KHR_materials_volume tells.
void convert_scatter(const tinygltf::Material &source, owned_material &to)
{
    rsv_material &m = to.material.value;
    const json &current = extension(source.extensions, "KHR_materials_scatter");
    const json &former = extension(source.extensions, "KHR_materials_volume_scatter");
    bool any = current.IsObject() || former.IsObject();
    if (any && m.thickness > 0 && m.attenuation_distance < INFINITY) {
        m.base_color = current.IsObject() ? color(current, "multiscatterColorFactor", { 1, 1, 1 })
                                          : color(former, "multiscatterColor", { 0, 0, 0 });
        m.scatter_distance = { mean_free_path(m.attenuation_color.r, m.attenuation_distance),
            mean_free_path(m.attenuation_color.g, m.attenuation_distance),
            mean_free_path(m.attenuation_color.b, m.attenuation_distance) };
        m.transmission = m.diffuse_transmission = 0;
        add_note(to, "its scattering medium is shown as diffusion below the surface");
    } else if (any) {
        add_note(to, "scattering is ignored: it needs a thickness and an attenuationDistance");
    }
    const json *own = find(source.extras, "resolvent");
    if (own) m.scatter_distance = color(*own, "scatter_distance", m.scatter_distance);
}

void note_ignored(const tinygltf::Material &source, owned_material &to)
{
    static const char *const ignored[] = { "KHR_materials_anisotropy", "KHR_materials_iridescence",
        "KHR_materials_dispersion" };
    for (const char *name : ignored)
        if (source.extensions.count(name)) add_note(to, std::string(name) + " is ignored");
    if (source.occlusionTexture.index >= 0)
        to.remark += "; its occlusion texture is left out: light is computed instead";
    if (find(extension(source.extensions, "KHR_materials_volume"), "thicknessTexture"))
        to.remark +=
            "; its thickness texture is left out: bodies are as thick as they are modelled";
}

} // namespace

void convert_material(const tinygltf::Material &source, owned_material &to)
{
    rsv_material &m = to.material.value;
    m = rsv_default_material();
    m.double_sided = source.doubleSided;
    m.unlit = source.extensions.count("KHR_materials_unlit") != 0;
    const json &glossiness = extension(source.extensions, "KHR_materials_pbrSpecularGlossiness");
    if (glossiness.IsObject())
        convert_specular_glossiness(source, glossiness, to);
    else
        convert_metallic_roughness(source, to);
    convert_emission(source, to);
    convert_interface(source.extensions, to);
    convert_layers(source.extensions, to);
    convert_transmission(source.extensions, to);
    convert_scatter(source, to);
    add_texture(to, RSV_TEXTURE_NORMAL, false,
        use_of(source.normalTexture.index, source.normalTexture.texCoord,
            source.normalTexture.extensions),
        source.normalTexture.scale);
    note_ignored(source, to);
    to.note.erase(0, 2); // the first separator
    to.remark.erase(0, 2);
}

} // namespace rsv_gltf
