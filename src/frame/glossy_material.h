/// Opaque materials with one rough lobe above or instead of a diffuse one, prepared for shading sixteen pixels at a
/// time.
///
/// Such a surface sends B T(cos) / pi from its base and A(cos) L from its lobe to the eye. T is rsv_bsdf_exit with the
/// diffuse fraction, A the lobe's directional albedo, and L the mean radiance that arrives over the lobe, weighted by
/// it. Both are tabulated by cosine, as finely as the engine's own tables, so that T agrees with the BSDF.
#ifndef RSV_GLOSSY_MATERIAL_H
#define RSV_GLOSSY_MATERIAL_H

#include "../specular/specular_walk.h"

/// Lobes at least this rough are shown by the irradiance at their surface: their mean radiance hardly differs from it.
#define RSV_GLOSSY_EVEN_ROUGHNESS 0.8f

/// By the square root of the cosine, in floats: T red, green, blue, 0, A red, green, blue, 0.
typedef float rsv_glossy_row[8];

typedef struct rsv_glossy_material {
    rsv_glossy_row row[RSV_TABLE_COS];
    float base_color[3], emission[3]; ///< emission is 0 where it is not shown
    float alpha;                      ///< width of the lobe
    int32_t plain; ///< 1: described by this table, with base_color times the textures below
    int32_t even;  ///< 1: the lobe reflects the irradiance, and takes no rays
    int32_t bare;  ///< 1: there is no diffuse lobe
    int32_t texture_count;
} rsv_glossy_material;

typedef struct rsv_glossy_materials {
    rsv_context *context;
    const rsv_transport_scene *scene;
    rsv_glossy_material *material; ///< [material_count]
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
