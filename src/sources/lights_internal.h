/// Shared by the files that set up the sources of a scene.
#ifndef RSV_LIGHTS_INTERNAL_H
#define RSV_LIGHTS_INTERNAL_H

#include "lights.h"
#include "local_lights.h"

/// Whether a surface of this material is brighter here than there.
bool rsv_emission_varies(const rsv_material *material);

/// How unevenly a cell shines, as patches of an eighth of its size see it.
typedef struct rsv_emission_spread {
    float variance; ///< of the luminance, over its squared mean
    float u, v;     ///< the brightest patch, on the triangle
} rsv_emission_spread;

/// One of the 4^level cells of a triangle, with its mean radiance. The caller sets its group and the number of cells.
/// @param spread out
rsv_emitter rsv_emitter_create(const rsv_scene_view *scene, const rsv_bsdf *bsdf, uint32_t triangle,
    int level, uint32_t place, rsv_emission_spread *spread);

/// Puts it where its triangle is now.
void rsv_emitter_follow(const rsv_scene_view *scene, rsv_emitter *emitter);

/// Gives it the radiance that its material has now.
void rsv_emitter_set_strength(
    const rsv_scene_view *scene, const rsv_bsdf *material, rsv_emitter *emitter);

/// Chooses the emitters that are weighed and builds trees of all others, and of punctual lights where there are enough;
/// earlier ones are felled.
rsv_status rsv_lights_plant_trees(rsv_lights *lights);

/// Sets `share` and `gathered` of every group.
void rsv_lights_choose_gathered(rsv_lights *lights);

#endif
