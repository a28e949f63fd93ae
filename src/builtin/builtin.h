/// The built-in scenes' generators: each fills an empty scene.
#ifndef RSV_BUILTIN_H
#define RSV_BUILTIN_H

#include "shapes.h"

/// A Lambert surface that reflects `albedo` and emits `radiance`.
rsv_status rsv_add_lambert(
    rsv_scene *scene, const char *name, rsv_rgb albedo, rsv_rgb radiance, uint32_t *material_id);

rsv_status rsv_build_cornell_blocks(rsv_scene *scene);
rsv_status rsv_build_cornell_spheres(rsv_scene *scene);
rsv_status rsv_build_furnace(rsv_scene *scene);
rsv_status rsv_build_two_rooms(rsv_scene *scene);
rsv_status rsv_build_fog_rooms(rsv_scene *scene);
rsv_status rsv_build_milk(rsv_scene *scene);
rsv_status rsv_build_smoke(rsv_scene *scene);

/// Fog in the committed scenes fog-rooms and smoke.
rsv_status rsv_fill_fog_rooms(rsv_scene *scene);
rsv_status rsv_fill_smoke(rsv_scene *scene);

/// @param rooms a whole number of them
rsv_status rsv_build_gallery(rsv_scene *scene, double rooms);
/// @param triangles about as many
rsv_status rsv_build_terraces(rsv_scene *scene, double triangles);

/// The Cornell box without the blocks: walls, light and camera.
rsv_status rsv_build_cornell_box(rsv_scene *scene);

rsv_status rsv_build_cornell_glass(rsv_scene *scene, const rsv_builtin_desc *desc);
rsv_status rsv_build_cornell_marble(rsv_scene *scene, const rsv_builtin_desc *desc);
rsv_status rsv_build_cornell_plaster(rsv_scene *scene, const rsv_builtin_desc *desc);
rsv_status rsv_build_cornell_showcase(rsv_scene *scene, const rsv_builtin_desc *desc);
rsv_status rsv_build_character(rsv_scene *scene, const rsv_builtin_desc *desc);

#endif
