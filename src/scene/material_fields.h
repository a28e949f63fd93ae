/// Lists of the fields of rsv_material, from which the rest of the code is generated: defaults and ranges, operator
/// files, reading and writing glTF, and textures at points. Also for device code.
#ifndef RSV_MATERIAL_FIELDS_H
#define RSV_MATERIAL_FIELDS_H

#include "resolvent/scene.h"

/// NUMBER(field, channels, usual, low, high, extension, key): values between `low` and `high`, `usual` where nothing is
/// said; in glTF the number or colour `key` of `extension`. RSV_IN_EXTRAS: of "extras": { "resolvent": ... }; NULL:
/// code of its own. FLAG(field). In the order of operator files.
#define RSV_MATERIAL_FIELDS(NUMBER, FLAG)                                                          \
    NUMBER(base_color, 3, 1, 0, 1, NULL, NULL)                                                     \
    NUMBER(metallic, 1, 0, 0, 1, NULL, NULL)                                                       \
    NUMBER(roughness, 1, 1, 0, 1, NULL, NULL)                                                      \
    NUMBER(ior, 1, 1.5f, 1, RSV_MOST_OF_MATERIAL, "KHR_materials_ior", "ior")                      \
    NUMBER(specular, 1, 1, 0, 1, "KHR_materials_specular", "specularFactor")                       \
    NUMBER(specular_color, 3, 1, 0, 1, "KHR_materials_specular", "specularColorFactor")            \
    NUMBER(transmission, 1, 0, 0, 1, "KHR_materials_transmission", "transmissionFactor")           \
    NUMBER(thickness, 1, 0, 0, RSV_MOST_OF_MATERIAL, "KHR_materials_volume", "thicknessFactor")    \
    NUMBER(attenuation_color, 3, 1, 0, 1, "KHR_materials_volume", "attenuationColor")              \
    NUMBER(attenuation_distance, 1, INFINITY, 1e-30f, INFINITY, "KHR_materials_volume",            \
        "attenuationDistance")                                                                     \
    NUMBER(emission, 3, 0, 0, RSV_MOST_OF_MATERIAL, NULL, NULL)                                    \
    FLAG(double_sided)                                                                             \
    FLAG(unlit)                                                                                    \
    NUMBER(clearcoat, 1, 0, 0, 1, "KHR_materials_clearcoat", "clearcoatFactor")                    \
    NUMBER(clearcoat_roughness, 1, 0, 0, 1, "KHR_materials_clearcoat", "clearcoatRoughnessFactor") \
    NUMBER(sheen_color, 3, 0, 0, 1, "KHR_materials_sheen", "sheenColorFactor")                     \
    NUMBER(sheen_roughness, 1, 0, 0, 1, "KHR_materials_sheen", "sheenRoughnessFactor")             \
    NUMBER(diffuse_transmission, 1, 0, 0, 1, "KHR_materials_diffuse_transmission",                 \
        "diffuseTransmissionFactor")                                                               \
    NUMBER(diffuse_transmission_color, 3, 1, 0, 1, "KHR_materials_diffuse_transmission",           \
        "diffuseTransmissionColorFactor")                                                          \
    NUMBER(scatter_distance, 3, 0, 0, RSV_MOST_OF_MATERIAL, RSV_IN_EXTRAS, "scatter_distance")     \
    NUMBER(iridescence, 1, 0, 0, 1, "KHR_materials_iridescence", "iridescenceFactor")              \
    NUMBER(iridescence_ior, 1, 1.3f, 1, RSV_MOST_OF_MATERIAL, "KHR_materials_iridescence",         \
        "iridescenceIor")                                                                          \
    NUMBER(iridescence_thickness_min, 1, 100, 0, RSV_MOST_OF_MATERIAL,                             \
        "KHR_materials_iridescence", "iridescenceThicknessMinimum")                                \
    NUMBER(iridescence_thickness_max, 1, 400, 0, RSV_MOST_OF_MATERIAL,                             \
        "KHR_materials_iridescence", "iridescenceThicknessMaximum")                                \
    NUMBER(anisotropy, 1, 0, 0, 1, "KHR_materials_anisotropy", "anisotropyStrength")               \
    NUMBER(anisotropy_rotation, 1, 0, -RSV_MOST_OF_MATERIAL, RSV_MOST_OF_MATERIAL,                 \
        "KHR_materials_anisotropy", "anisotropyRotation")                                          \
    NUMBER(dispersion, 1, 0, 0, RSV_MOST_OF_MATERIAL, "KHR_materials_dispersion", "dispersion")    \
    NUMBER(opacity, 1, 1, 0, 1, NULL, NULL)                                                        \
    NUMBER(alpha_cutoff, 1, 0, 0, RSV_MOST_OF_MATERIAL, NULL, NULL)                                \
    NUMBER(camera_emission, 1, 1, 0, 1, RSV_IN_EXTRAS, "camera_emission")

/// TEXTURE(role, field, channel, srgb, extension, key): the field is multiplied by `channel` (r, g, a or rgb) of a
/// texture with RSV_TEXTURE_##role, in glTF `key` of `extension`. Textures that do more have code of their own (base
/// colour, normals, ...).
#define RSV_MATERIAL_TEXTURES(TEXTURE)                                                             \
    TEXTURE(SPECULAR, specular, a, false, "KHR_materials_specular", "specularTexture")             \
    TEXTURE(SPECULAR_COLOR, specular_color, rgb, true, "KHR_materials_specular",                   \
        "specularColorTexture")                                                                    \
    TEXTURE(CLEARCOAT, clearcoat, r, false, "KHR_materials_clearcoat", "clearcoatTexture")         \
    TEXTURE(CLEARCOAT_ROUGHNESS, clearcoat_roughness, g, false, "KHR_materials_clearcoat",         \
        "clearcoatRoughnessTexture")                                                               \
    TEXTURE(SHEEN_COLOR, sheen_color, rgb, true, "KHR_materials_sheen", "sheenColorTexture")       \
    TEXTURE(SHEEN_ROUGHNESS, sheen_roughness, a, false, "KHR_materials_sheen",                     \
        "sheenRoughnessTexture")                                                                   \
    TEXTURE(                                                                                       \
        TRANSMISSION, transmission, r, false, "KHR_materials_transmission", "transmissionTexture") \
    TEXTURE(DIFFUSE_TRANSMISSION, diffuse_transmission, a, false,                                  \
        "KHR_materials_diffuse_transmission", "diffuseTransmissionTexture")                        \
    TEXTURE(DIFFUSE_TRANSMISSION_COLOR, diffuse_transmission_color, rgb, true,                     \
        "KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture")                   \
    TEXTURE(IRIDESCENCE, iridescence, r, false, "KHR_materials_iridescence", "iridescenceTexture")

/// Products of a few such values stay finite in double.
#define RSV_MOST_OF_MATERIAL 1e30f

/// In place of an extension.
#define RSV_IN_EXTRAS "extras"

/// A NUMBER.
typedef struct rsv_material_field {
    const char *name;
    size_t offset; ///< in rsv_material
    int channels;
    float usual, low, high;
    const char *extension, *key;
} rsv_material_field;

#ifdef __cplusplus
extern "C" {
#endif

/// All of them; the last has no name.
const rsv_material_field *rsv_material_fields(void);

#ifdef __cplusplus
}
#endif

#endif
