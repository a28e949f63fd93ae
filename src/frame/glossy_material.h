/// Opaque materials with rough lobes above or instead of a diffuse one, prepared for shading sixteen pixels at a time.
///
/// Such a surface sends B T(cos) / pi from its base and A(cos) L from its lobes to the eye. T is rsv_bsdf_exit with the
/// diffuse fraction, A the lobes' directional albedo, and L the mean radiance that arrives over the lobes, weighted by
/// it. Both are tabulated by cosine, as finely as the engine's own tables, so that T agrees with the BSDF.
///
/// Where a texture changes the roughness, there is such a table for each of RSV_GLOSSY_LEVELS roughnesses. Where one
/// changes how metallic the surface is, or what colour metal has, the tables are those of the dielectric, and further
/// ones those of metal, as a polynomial in its reflectance at normal incidence.
#ifndef RSV_GLOSSY_MATERIAL_H
#define RSV_GLOSSY_MATERIAL_H

#include "../specular/specular_walk.h"

/// Lobes at least this rough are shown by the irradiance at their surface: their mean radiance hardly differs from it.
#define RSV_GLOSSY_EVEN_ROUGHNESS 0.8f

/// Roughnesses from 0 to 1 that varying materials are tabulated at.
#define RSV_GLOSSY_LEVELS 20

/// By the square root of the cosine, in floats: T red, green, blue, 0, A red, green, blue, 0.
typedef float rsv_glossy_row[8];

/// The same, of metal with reflectance F0 at normal incidence: A is the sum of [k] F0^k; red, green, blue, 0.
typedef float rsv_glossy_metal_row[3][4];

/// Textures that are looked up sixteen pixels at a time.
typedef enum rsv_glossy_map {
    RSV_GLOSSY_COLOR,
    RSV_GLOSSY_METALLIC_ROUGHNESS,
    RSV_GLOSSY_NORMAL,
    RSV_GLOSSY_EMISSION,
    RSV_GLOSSY_MAPS
} rsv_glossy_map;

typedef struct rsv_glossy_material {
    const rsv_glossy_row *row;         ///< [level_count][RSV_TABLE_COS]
    const rsv_glossy_metal_row *metal; ///< [level_count][RSV_TABLE_COS]; NULL: the rows include it
    int32_t level_count;               ///< 1: of the material's own roughness
    float base_color[3], emission[3];  ///< times textures; emission is 0 where it is not shown
    float metallic, roughness;         ///< times textures
    float coat_alpha;                  ///< width of the clear coat's lobe; INFINITY = there is none
    int32_t plain;                     ///< 1: described by this table and the maps
    int32_t even;      ///< 1: lobes at least RSV_GLOSSY_EVEN_ROUGHNESS rough reflect the irradiance
    int32_t bare;      ///< 1: there is no diffuse lobe
    int32_t odd_color; ///< 1: textures of the base colour that rsv_base_color_at has to look up
    uint32_t maps;     ///< a bit for each rsv_glossy_map that there is
    uint32_t alike;    ///< of these, those whose texels lie where those of the first one do
    rsv_texture_ref map[RSV_GLOSSY_MAPS];
} rsv_glossy_material;

RSV_INLINE bool rsv_glossy_has(const rsv_glossy_material *m, rsv_glossy_map map)
{
    return m->maps >> map & 1;
}

/// Whether the tables depend neither on the base colour nor on how metallic the surface is.
RSV_INLINE bool rsv_glossy_is_general(const rsv_glossy_material *m)
{
    return m->level_count > 1 || m->metal;
}

/// Whether textures change more than the base colour of the diffuse lobe.
RSV_INLINE bool rsv_glossy_varies(const rsv_glossy_material *m)
{
    return rsv_glossy_is_general(m) || rsv_glossy_has(m, RSV_GLOSSY_EMISSION);
}

typedef struct rsv_glossy_materials {
    rsv_context *context;
    const rsv_transport_scene *scene;
    rsv_glossy_material *material; ///< [material_count]
    rsv_glossy_row *row;           ///< of all materials
    rsv_glossy_metal_row *metal;   ///< of those that have any
} rsv_glossy_materials;

/// Whether any surface may have a rough lobe besides the diffuse one.
bool rsv_any_glossy(const rsv_transport_scene *scene);

/// @param translucent [material_count] which have a diffusion profile; NULL = none has
rsv_status rsv_glossy_materials_create(rsv_context *context, const rsv_transport_scene *scene,
    const uint8_t *translucent, rsv_glossy_materials *materials);
void rsv_glossy_materials_destroy(rsv_glossy_materials *materials);

/// Updates the materials; plain ones stay plain.
void rsv_glossy_materials_refresh(rsv_glossy_materials *materials);

/// Approximate directional albedo of all lobes except the diffuse one, by which their light is divided for averaging.
/// Never 0.
rsv_rgb rsv_glossy_albedo(const rsv_bsdf *bsdf, float cos);

/// Width of the narrowest rough lobe.
float rsv_glossy_width(const rsv_bsdf *bsdf);

#endif
