/// Converts glTF materials to the library's. docs/gltf.md says how each extension is treated.
#include "../scene/material_fields.h"
#include "gltf_json.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace rsv_gltf
{

namespace
{

/// Where a texture is used.
struct texture_use {
    int texture, uv_set;
    const json &transform; ///< KHR_texture_transform; may be null
};

texture_use use_of(const json &object, const char *key)
{
    const json &info = member(object, key);
    return { reference(info, "index"), reference(info, "texCoord", 0),
        extension(info, "KHR_texture_transform") };
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
    if (use.transform.is_object()) {
        set_transform(use.transform, ref.ref);
        uv_set = reference(use.transform, "texCoord", uv_set);
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
void convert_base_color(
    const json &source, const double factor[4], const texture_use &use, owned_material &to)
{
    rsv_material &m = to.material.value;
    const std::string mode = text(source, "alphaMode");
    const double cutoff = mode == "MASK" ? number(source, "alphaCutoff", 0.5) : 0;
    if (!mode.empty() && mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
        add_note(to, "its alphaMode '" + shown(mode) + "' is not in the format; OPAQUE is used");
    m.base_color = to_rgb(factor);
    add_texture(to, RSV_TEXTURE_BASE_COLOR, true, use);
    to.material.opaque = mode != "BLEND" && !(cutoff > 0);
    if (to.material.opaque) return;
    m.opacity = static_cast<float>(factor[3]);
    m.alpha_cutoff = static_cast<float>(cutoff);
    add_texture(to, RSV_TEXTURE_OPACITY, true, use);
}

void convert_metallic_roughness(const json &source, owned_material &to)
{
    const json &pbr = member(source, "pbrMetallicRoughness");
    double base_color[4] = { 1, 1, 1, 1 };
    exact_numbers(pbr, "baseColorFactor", 4, base_color, "material '" + to.name + "'");
    convert_base_color(source, base_color, use_of(pbr, "baseColorTexture"), to);
    to.material.value.metallic = static_cast<float>(number(pbr, "metallicFactor", 1));
    to.material.value.roughness = static_cast<float>(number(pbr, "roughnessFactor", 1));
    add_texture(to, RSV_TEXTURE_METALLIC_ROUGHNESS, false, use_of(pbr, "metallicRoughnessTexture"));
}

/// A dielectric whose Fresnel reflectance at normal incidence is the given specular colour; bright ones over a
/// dark base are metals.
void convert_specular_glossiness(const json &source, const json &from, owned_material &to)
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
    if (from.contains("specularGlossinessTexture"))
        add_note(to, "its specularGlossinessTexture is left out");
}

void convert_emission(const json &source, owned_material &to)
{
    double emission[3] = { 0, 0, 0 };
    exact_numbers(source, "emissiveFactor", 3, emission, "material '" + to.name + "'");
    const json &strength = extension(source, "KHR_materials_emissive_strength");
    double scale = number(strength, "emissiveStrength", 1);
    for (double &channel : emission)
        channel *= scale;
    to.material.value.emission = to_rgb(emission);
    add_texture(to, RSV_TEXTURE_EMISSION, true, use_of(source, "emissiveTexture"));
}

void take(const json &from, const rsv_material_field &f, rsv_material &m)
{
    float *value = reinterpret_cast<float *>(reinterpret_cast<char *>(&m) + f.offset);
    if (f.channels == 1) {
        *value = static_cast<float>(number(from, f.key, f.usual));
        return;
    }
    const rsv_rgb c = color(from, f.key, { f.usual, f.usual, f.usual });
    std::memcpy(value, &c, sizeof c);
}

bool is_in_extras(const rsv_material_field &f)
{
    return f.extension && std::strcmp(f.extension, RSV_IN_EXTRAS) == 0;
}

/// A texture that multiplies a field.
struct factor {
    rsv_texture_role role;
    bool srgb;
    const char *extension, *key;
};

constexpr factor factors[] = {
#define TEXTURE(role, name, channel, srgb, extension, key)                                         \
    { RSV_TEXTURE_##role, srgb, extension, key },
    RSV_MATERIAL_TEXTURES(TEXTURE)
#undef TEXTURE
};

/// Numbers, colours and textures of extensions.
void convert_extensions(const json &source, owned_material &to)
{
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++) {
        if (!f->extension || is_in_extras(*f)) continue;
        const json &from = extension(source, f->extension);
        if (from.is_object()) take(from, *f, to.material.value);
    }
    for (const factor &f : factors)
        add_texture(to, f.role, f.srgb, use_of(extension(source, f.extension), f.key));
    add_texture(to, RSV_TEXTURE_IRIDESCENCE_THICKNESS, false,
        use_of(extension(source, "KHR_materials_iridescence"), "iridescenceThicknessTexture"));
    add_texture(to, RSV_TEXTURE_ANISOTROPY, false,
        use_of(extension(source, "KHR_materials_anisotropy"), "anisotropyTexture"));
    float &ior = to.material.value.ior;
    if (ior == 0) ior = 1e3f; // stands for total reflection
    const json &coat = extension(source, "KHR_materials_clearcoat");
    if (to.material.value.clearcoat > 0)
        add_texture(to, RSV_TEXTURE_CLEARCOAT_NORMAL, false, use_of(coat, "clearcoatNormalTexture"),
            number(member(coat, "clearcoatNormalTexture"), "scale", 1));
}

/// Properties of the library's own that no extension has; they override extensions.
void convert_extras(const json &source, owned_material &to)
{
    const json &own = member(member(source, "extras"), "resolvent");
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++)
        if (is_in_extras(*f) && !member(own, f->key).is_null()) take(own, *f, to.material.value);
}

float mean_free_path(float color, float distance)
{
    if (!(distance < INFINITY) || !(color > 0) || color >= 1)
        return distance < INFINITY ? 0 : distance;
    return -distance / std::log(color);
}

/// A scattering medium: light that enters leaves near by. The multiple-scattering colour becomes its reflectance; the
/// mean free path comes from the attenuation of KHR_materials_volume.
void convert_scatter(const json &source, owned_material &to)
{
    rsv_material &m = to.material.value;
    const json &current = extension(source, "KHR_materials_scatter");
    const json &former = extension(source, "KHR_materials_volume_scatter");
    bool any = current.is_object() || former.is_object();
    if (any && m.thickness > 0 && m.attenuation_distance < INFINITY) {
        m.base_color = current.is_object() ? color(current, "multiscatterColorFactor", { 1, 1, 1 })
                                           : color(former, "multiscatterColor", { 0, 0, 0 });
        m.scatter_distance = { mean_free_path(m.attenuation_color.r, m.attenuation_distance),
            mean_free_path(m.attenuation_color.g, m.attenuation_distance),
            mean_free_path(m.attenuation_color.b, m.attenuation_distance) };
        m.transmission = m.diffuse_transmission = 0;
        add_note(to, "its scattering medium is shown as diffusion below the surface");
    } else if (any) {
        add_note(to, "scattering is ignored: it needs a thickness and an attenuationDistance");
    }
}

void note_left_out(const json &source, owned_material &to)
{
    if (reference(member(source, "occlusionTexture"), "index") >= 0)
        to.remark += "; its occlusion texture is left out: occlusion is computed";
    if (!member(extension(source, "KHR_materials_volume"), "thicknessTexture").is_null())
        to.remark += "; its thickness texture is left out: the mesh gives the thickness";
}

} // namespace

void convert_material(const json &source, owned_material &to)
{
    rsv_material &m = to.material.value;
    m = rsv_default_material();
    m.double_sided = flag(source, "doubleSided");
    m.unlit = extension(source, "KHR_materials_unlit").is_object();
    const json &glossiness = extension(source, "KHR_materials_pbrSpecularGlossiness");
    if (glossiness.is_object())
        convert_specular_glossiness(source, glossiness, to);
    else
        convert_metallic_roughness(source, to);
    convert_emission(source, to);
    convert_extensions(source, to);
    convert_scatter(source, to);
    convert_extras(source, to);
    add_texture(to, RSV_TEXTURE_NORMAL, false, use_of(source, "normalTexture"),
        number(member(source, "normalTexture"), "scale", 1));
    note_left_out(source, to);
    to.note.erase(0, 2); // the first separator
    to.remark.erase(0, 2);
}

} // namespace rsv_gltf
