/// Steps of building a level, for building it from scratch (source_level.c) and for following a motion
/// (source_follow.c).
#ifndef RSV_SOURCE_LEVEL_INTERNAL_H
#define RSV_SOURCE_LEVEL_INTERNAL_H

#include "../update/kept_light.h"
#include "source_level.h"

typedef struct rsv_level_builder {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_elements *coarse;
    const rsv_source_level_desc *desc;
    rsv_elements *elements;
    rsv_rgb *direct;
    float *deviation; ///< of direct
    uint16_t *valid_points;
    rsv_rgb *first_look;         ///< as in rsv_source_level
    uint8_t *known;              ///< [node_count] 1 where valid_points are known already
    uint8_t *lit;                ///< [node_count] 1 where direct and deviation are
    rsv_photon_shooter *shooter; ///< of photons; NULL = none
    rsv_photon_log *log;         ///< of kept photons, instead; NULL = none are
    const rsv_scene_change *met; ///< boxes: which of them are shot again
    rsv_photon_map map[2];       ///< on `elements` and on `coarse`
    rsv_rgb *caustic;
    uint8_t *split;       ///< [cell_count]
    const uint8_t *asked; ///< [cell_count] 1 = the cell or a neighbour may be split; NULL = all may
    rsv_kept_light *kept; ///< NULL = nothing is known from before the scene was edited
    bool complete;        ///< there will be no more splits
    size_t kept_count;    ///< nodes in the end of which it is
    uint64_t *rays;
} rsv_level_builder;

/// Known values on the elements before a split.

typedef struct rsv_earlier_level {
    rsv_elements *elements;
    rsv_rgb *direct;
    float *deviation;
    uint16_t *valid_points;
    rsv_rgb *first_look;
} rsv_earlier_level;

/// Nothing was looked at yet: no light is that dark. NULL = no memory
rsv_rgb *rsv_level_create_first_look(const rsv_elements *elements);

/// Elements ready to receive: walls kept apart, buried corners bridged.
/// @param earlier NULL = nothing is known yet
rsv_status rsv_level_prepare(rsv_level_builder *b, const rsv_earlier_level *earlier);

/// Estimates direct light at the nodes that `known` does not cover. @param known [node_count]
rsv_status rsv_level_estimate(rsv_level_builder *b, uint32_t samples, const uint8_t *known);
/// At nodes that are not lit yet, with more samples where shadows may end.
rsv_status rsv_level_estimate_fresh(rsv_level_builder *b, const rsv_earlier_level *earlier);

/// Shoots photons onto the elements of the level and the coarse ones.
rsv_status rsv_level_shoot(rsv_level_builder *b, uint32_t count);
void rsv_level_free_photons(rsv_level_builder *b);

/// Marks the cells on both sides of every edge across which light bends, that may be split in a round; counts them.
rsv_status rsv_level_mark_cells(rsv_level_builder *b, uint32_t round, size_t *marked);

/// Whether a cell is not as small as cells get.
bool rsv_level_may_split(const rsv_level_builder *b, uint32_t cell);

/// Takes the fields away from the builder, which starts anew.
rsv_earlier_level rsv_level_set_aside(rsv_level_builder *b);
void rsv_level_free_earlier(rsv_level_builder *b, rsv_earlier_level *earlier);

/// Gives what was built to a level.
rsv_status rsv_level_hand_over(rsv_level_builder *b, rsv_source_level *level);
/// Frees what is left.
void rsv_level_end(rsv_level_builder *b);

#endif
