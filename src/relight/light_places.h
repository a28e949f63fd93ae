/// Lights that are moved in their scene: punctual ones by their position, lamps by the triangles of their material.
#ifndef RSV_LIGHT_PLACES_H
#define RSV_LIGHT_PLACES_H

#include "../sources/light_subset.h"

/// Where one source began.
typedef struct rsv_light_place {
    rsv_vec3 centre;          ///< of a lamp, the mean of its vertices
    rsv_vec3 direction, side; ///< of a punctual light
    uint32_t *vertex;         ///< [vertex_count] of a lamp
    rsv_vec3 *home;           ///< [vertex_count] their positions
    size_t vertex_count;
} rsv_light_place;

/// Where a punctual light stands.
void rsv_light_place_note(const rsv_punctual_light *light, rsv_light_place *place);

/// @param place [count] zeros at first; free it with rsv_light_places_free, even after an error
rsv_status rsv_light_places_find(
    const rsv_scene *scene, const rsv_source *source, size_t count, rsv_light_place *place);
void rsv_light_places_free(rsv_context *context, rsv_light_place *place, size_t count);

/// Puts a source where it began, and then `offset` from there.
/// @param aim direction of a light, unit; 0 = the one that it began with
void rsv_light_place_move(rsv_scene *scene, const rsv_source *source, const rsv_light_place *place,
    rsv_vec3 offset, rsv_vec3 aim);

#endif
