/// Sources for patches: emitters are chosen by their unshadowed light at the patch, however many there are.
///
/// Elsewhere a tree chooses among many emitters (sources/light_tree.h), which is faster for each receiver but less
/// accurate: where all of a bulb of hundreds of triangles is visible, the choice alone causes noise. Patches trace many
/// shadow rays each, so weighing every emitter is worthwhile.
#ifndef RSV_BAKE_SOURCES_H
#define RSV_BAKE_SOURCES_H

#include "../receiver/next_event.h"
#include "../sources/local_lights.h"

#define RSV_BAKE_WEIGHED                                                                           \
    1024 ///< emitters that are weighed at most; where there are more, the tree chooses

/// All emitters that shadow rays are sent to, laid out for passes over them.
typedef struct rsv_bake_sources {
    rsv_context *context;
    const rsv_lights *lights;
    uint32_t count; ///< 0 = the tree chooses, or there are none
    /// [count] each: middle; front normal times area; radius around the middle; radiance; 1 = both sides emit
    float *x, *y, *z, *nx, *ny, *nz, *radius, *r, *g, *b, *both;
} rsv_bake_sources;

/// How near emitters look from a receiver, kept from one draw to the next: finding out takes longer than the draw.
typedef struct rsv_bake_view {
    uint32_t emitter; ///< RSV_NONE = none is kept here
    bool faces;       ///< whether it can be seen from there at all
    rsv_triangle_view triangle;
} rsv_bake_view;

#define RSV_BAKE_VIEWS 4 ///< a power of two

/// Their light at one receiver.
typedef struct rsv_bake_weights {
    rsv_local_lights local;             ///< suns and sky; where the tree chooses, all
    float emitters;                     ///< probability of choosing an emitter
    float sum;                          ///< of the luminance that emitters would give
    float weight[RSV_BAKE_WEIGHED];     ///< that of each emitter and of all before it
    rsv_rgb unshadowed;                 ///< irradiance of all weighed emitters
    rsv_bake_view view[RSV_BAKE_VIEWS]; ///< of emitter k at k modulo their number
} rsv_bake_weights;

rsv_status rsv_bake_sources_create(
    rsv_context *context, const rsv_lights *lights, rsv_bake_sources *sources);
void rsv_bake_sources_destroy(rsv_bake_sources *sources);

void rsv_bake_weigh(
    const rsv_bake_sources *sources, const rsv_receiver *receiver, rsv_bake_weights *weights);

/// As rsv_next_event_draw.
void rsv_bake_draw(const rsv_bake_sources *sources, rsv_bake_weights *weights,
    const rsv_receiver *receiver, const rsv_entrance *entrance, const float u[3],
    rsv_next_event *event);

#endif
