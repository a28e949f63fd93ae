/// A relighter: its data, and E0 of the sources in their present state.
#ifndef RSV_RELIGHTER_H
#define RSV_RELIGHTER_H

#include "../scene/scene.h"
#include "../solve/light_change.h"
#include "../solve/transport_map.h"
#include "light_places.h"
#include "light_settings.h"
#include "resolvent/relight.h"

struct rsv_relighter {
    rsv_context *context;
    rsv_light *light;
    const rsv_light_view *s; ///< of that
    rsv_light_fields *field; ///< of that
    rsv_scene *scene;        ///< of that: its own
    rsv_light *began;        ///< a copy of the light as it was; NULL once a source was added
    rsv_light_basis
        *basis; ///< the light's parts of E0, at the strengths that sources have by themselves
    rsv_light_part *home_part;  ///< [capacity] of sources that are away from where they began
    bool *away;                 ///< [capacity] those sources
    rsv_light_part *began_part; ///< [capacity] levels of parts at home before a refinement
    rsv_light_sources *sources; ///< at those strengths, where they stand now
    uint16_t *valid;            ///< receiver points of the direct level
    rsv_rgb environment_scale;  ///< that the scene's pixels have now
    size_t capacity;            ///< sources that there is room for
    const rsv_rgb **summed;     ///< [capacity] scratch
    rsv_rgb *factor;            ///< [capacity]
    rsv_light_part **listed;    ///< [2 capacity]
    rsv_light_place *place;     ///< [source_count]
    rsv_light_settings home, now, wanted;
    bool *stale; ///< [source_count] must be sampled in full before the light has settled
    bool *moved; ///< [source_count] must be sampled now
    bool *moves; ///< [material_count] whose triangles can be moved
    rsv_receiver_blocks *coarse, *fine; ///< of either level; NULL until something moves
    rsv_transport_map *map;
    rsv_rgb *next, *scratch; ///< [node_count]
    uint64_t rays;           ///< traced so far
    double residual;
    struct rsv_relight_responses *responses; ///< NULL = not known, for the sources as they stand
    bool prepared;                           ///< responses are requested, and possible
    bool settled;
    bool once;             ///< there will be one change, and no way back
    bool grown;            ///< a source was added
    bool refined;          ///< levels have other elements than in the beginning
    uint32_t replacements; ///< of levels
    bool behind;           ///< a change was interrupted: the next one applies everything again
};

static inline size_t rsv_relighter_nodes(const rsv_relighter *r)
{
    return r->s->elements->node_count;
}

/// Whether a source is known by few rays only.
static inline bool rsv_relighter_any_stale(const rsv_relighter *r)
{
    bool any = false;
    for (size_t k = 0; k < r->basis->source_count; k++)
        any = any || r->stale[k];
    return any;
}

/// Allocates memory for more sources in all arrays of sources.
rsv_status rsv_relighter_make_room(rsv_relighter *relighter, size_t sources);

/// Pixels of the surroundings.
size_t rsv_surroundings_length(const rsv_scene *scene);

/// Gives sources of the scene their strengths. @param scale [source_count] NULL = those that they have by themselves
rsv_status rsv_relighter_set_strengths(rsv_relighter *relighter, const rsv_rgb *scale);

/// The lights of the present scene, divided into gathered and sampled ones as in the operator.
rsv_status rsv_relighter_find_lights(rsv_relighter *relighter);

/// Changes since E0 was last updated.
typedef enum rsv_relighter_change_kind {
    RSV_RELIGHTER_ANYTHING,
    RSV_RELIGHTER_STRENGTHS, ///< of sources, no more
    RSV_RELIGHTER_PLACES     ///< of lights, no more: nothing else need be looked at
} rsv_relighter_change_kind;

/// Samples sources, at the strengths that they have by themselves. @param which [source_count]
rsv_status rsv_relighter_sample(rsv_relighter *relighter, const bool *which,
    rsv_relighter_change_kind kind, const rsv_light_effort *effort);

/// Light of the present environment that rows gather, at its unscaled strength; 0 without an environment.
/// @param sky [node_count] out
void rsv_relighter_see_sky(const rsv_relighter *relighter, rsv_rgb *sky);

/// Stores the contributions on the original levels, before these are refined.
rsv_status rsv_relighter_keep_levels(rsv_relighter *relighter);
/// Frees data of levels that no longer exist.
void rsv_relighter_forget_levels(rsv_relighter *relighter);
/// After the light has the levels of the beginning again: gives them back to parts at home. Others have nothing there
/// then, and their sources are stale.
void rsv_relighter_return_levels(rsv_relighter *relighter);

/// rsv_relighter_change for factors only. @param scale [source_count]
rsv_status rsv_relighter_scale(rsv_relighter *relighter, const rsv_rgb *scale);

/// Creates the linear map of the light's operator again.
rsv_status rsv_relighter_map(rsv_relighter *relighter);

/// Brings scene, lights and E0 to the present settings, after parts have changed.
rsv_status rsv_relighter_update_sources(rsv_relighter *relighter, rsv_relighter_change_kind kind);

#endif
