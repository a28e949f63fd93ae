/// The fine level: direct and caustic irradiance on elements that are split where it changes quickly.
///
/// Indirect light is smooth and lives on the coarse elements; shadows and caustics are not.
#ifndef RSV_SOURCE_LEVEL_H
#define RSV_SOURCE_LEVEL_H

#include "direct.h"
#include "photon_log.h"

#include "../update/light_shafts.h"

#define RSV_LEVEL_POINTS 4 ///< receiver points over the support of a node
/// Factor of shadow rays for nodes of split cells with the edge of a shadow.
#define RSV_PENUMBRA_FACTOR 4

typedef struct rsv_source_level_desc {
    bool direct;            ///< next-event estimates are needed
    uint32_t photon_count;  ///< 0 = no caustics
    uint32_t levels;        ///< splits below the coarse elements at most
    size_t max_cells;       ///< no more splits that lead beyond
    uint32_t light_samples; ///< shadow rays per node
    const uint8_t *hidden;  ///< [cell_count of the coarse elements] non-zero = not worth splitting;
                            ///< NULL = all are
    uint32_t seed;
    /// Elements to start from: the coarse ones with splits. Light on them is then computed only for splitting, and
    /// coarsely. NULL = the coarse ones.
    const rsv_elements *start;
} rsv_source_level_desc;

typedef struct rsv_source_level {
    rsv_elements *elements;
    rsv_rgb *direct;         ///< [node_count] irradiance, or NULL
    rsv_rgb *caustic;        ///< [node_count] irradiance, or NULL
    rsv_rgb *coarse_caustic; ///< [node_count of the coarse elements], or NULL
    float *deviation;        ///< [node_count] of `direct`, or NULL
    uint16_t *valid_points;  ///< [node_count]
    rsv_rgb *
        first_look; ///< [node_count] what the first rays found (rsv_level_motion); NULL = not known
    size_t built_cells; ///< cells when it was built as a whole
    size_t kept;        ///< nodes whose direct light is from before an edit
} rsv_source_level;

/// @param coarse elements to start from
rsv_status rsv_source_level_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *coarse, const rsv_source_level_desc *desc, rsv_source_level *level,
    uint64_t *rays);
/// Motion on and around a level.
typedef struct rsv_level_motion {
    const uint8_t *moved;           ///< [triangle_count] RSV_MOVE_... (moved_elements.h)
    const rsv_light_shafts *shafts; ///< from sources through boxes around moved objects
    const rsv_lights *lights;       ///< as they are now
    bool whole; ///< cells are not split where new shadows end: that is left to a later call
    /// At places that stay, the rays that penumbrae get beyond the first ones are traced again only if the first ones
    /// find something else than in the previous call.
    bool hasty;
    /// Only places whose draw number leaves the remainder `turn` when divided by `turns`, and what has moved; 0 = all.
    uint32_t turns, turn;
    rsv_photon_log **photons; ///< kept from one motion to the next; NULL = they are not
} rsv_level_motion;

/// Takes a level to where its surfaces are now: in place, and with splits where new shadows end, none being undone.
/// @param desc, coarse as it was created with, surfaces elsewhere @param level with deviation and valid points
rsv_status rsv_source_level_follow(const rsv_transport_scene *scene, const rsv_elements *coarse,
    const rsv_source_level_desc *desc, const rsv_level_motion *motion, rsv_source_level *level,
    uint64_t *rays);

void rsv_source_level_destroy(rsv_context *context, rsv_source_level *level);

#endif
