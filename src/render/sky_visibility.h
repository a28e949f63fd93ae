/// Visibility of the sky from surfaces, as found by the rows of G: for rough lobes, which would hit a window only by
/// chance.
///
/// Nodes in one cube of a grid that face about the same way share their visibility, so that there are few gaps where
/// one row has few rays, along its surface. The sky is divided into squares of the octahedral map: the bins of
/// escapes.h or, if more of them are visible than are stored, squares of two or four bins a side.
#ifndef RSV_SKY_VISIBILITY_H
#define RSV_SKY_VISIBILITY_H

#include "../core/index_map.h"
#include "../solve/light.h"

/// Squares that are kept: half the sphere in those of four bins a side, and those on the horizon.
#define RSV_MOST_VISIBLE_SQUARES 160
#define RSV_SKY_SQUARE_LEVELS 3

/// A square for sampling. Those of the two finer levels are enlarged, so that directions between two rays are sampled
/// too.
typedef struct rsv_sky_square {
    rsv_vec3 direction; ///< unit, of its middle
    float x, y;         ///< its middle in the octahedral map, away from the map's border
    float half;         ///< half the side that is drawn from
    float luminance;    ///< mean of the gathered sky
} rsv_sky_square;

/// The sky visible from one place.
typedef struct rsv_visible_sky {
    uint32_t count;
    uint16_t square[RSV_MOST_VISIBLE_SQUARES];
} rsv_visible_sky;

typedef struct rsv_sky_visibility {
    rsv_context *context;
    const rsv_elements *elements;
    uint32_t *place_of;       ///< [node_count] RSV_NONE = the node is not rough or has no row
    float cube;               ///< side of the grid's cubes, metres
    rsv_index_map places;     ///< cube and side that is faced -> index of the place
    rsv_visible_sky *visible; ///< [places.count]
    rsv_sky_square *square;   ///< of all levels, the finest first
} rsv_sky_visibility;

/// @param visibility NULL where no rough surface has rows, or no sky is gathered
rsv_status rsv_sky_visibility_create(
    const rsv_light_view *solution, rsv_sky_visibility **visibility);
void rsv_sky_visibility_destroy(rsv_sky_visibility *visibility);

/// The sky visible from the surface of a specular path: that of its nearest node or, without elements, of those around
/// that face the same way. NULL = unknown.
/// @param point of the specular path
const rsv_visible_sky *rsv_sky_visibility_at(const rsv_sky_visibility *visibility,
    const rsv_specular_path *path, const rsv_surface_point *point);

#endif
