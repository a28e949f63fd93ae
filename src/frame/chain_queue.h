/// Wavefronts of mirror and glass chains: branches of many pixels wait until sixteen alike can be traced side by side.
///
/// They give what rsv_camera_chain gives, in another order. Rough surfaces, which draw one direction at random and aim at
/// lights, are left to it.
#ifndef RSV_CHAIN_QUEUE_H
#define RSV_CHAIN_QUEUE_H

#include "../operator/chain.h"
#include "light_table.h"
#include "mover_internal.h"

/// Waiting branches of one kind at most; further ones are followed at once.
#define RSV_QUEUE_CAPACITY 1280

/// A branch on its way: the chain has set out along its direction.
typedef struct rsv_chain_traveller {
    rsv_chain chain;
    rsv_vec3 origin;
    uint32_t path; ///< as in camera_chain.h
    uint32_t pixel;
} rsv_chain_traveller;

typedef struct rsv_chain_queue {
    const rsv_light_table *table;
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    rsv_sky sky;
    uint32_t max_events;
    float (*radiance)[4];              ///< of pixels; what chains find is added
    uint32_t waiting[2];               ///< reflected, transmitted
    rsv_chain_traveller *traveller[2]; ///< [RSV_QUEUE_CAPACITY]
    const rsv_mover *mover;            ///< NULL = none
    uint64_t rays;
    rsv_ray_packet packet;
    rsv_ray_packet body;  ///< its rays as the mover meets them
    uint32_t pixel, path; ///< of the chain in hand
} rsv_chain_queue;

rsv_status rsv_chain_queue_create(const rsv_light_table *table, rsv_chain_queue *queue);
/// Takes the solution's lights over again.
void rsv_chain_queue_refresh(rsv_chain_queue *queue);
void rsv_chain_queue_destroy(rsv_chain_queue *queue);

/// A chain that has arrived at a surface: adds what that shows and queues its branches.
void rsv_chain_queue_add(
    rsv_chain_queue *queue, const rsv_chain *chain, uint32_t path, uint32_t pixel);

/// What lies beyond the scene.
void rsv_chain_queue_add_sky(
    rsv_chain_queue *queue, rsv_vec3 direction, rsv_rgb weight, uint32_t pixel);

/// What a surface in the table shows with the mover's shadow on it. @param shown without
rsv_rgb rsv_shade_stored(const rsv_light_table *table, const rsv_mover *mover, uint32_t triangle,
    float u, float v, bool back, uint32_t stream, rsv_rgb shown);

/// Follows all that wait to their ends.
void rsv_chain_queue_run(rsv_chain_queue *queue);

#endif
