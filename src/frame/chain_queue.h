/// Wavefronts of mirror and glass chains: branches of many pixels wait until all of them take their next step, those
/// that are alike side by side in packets.
///
/// They give what rsv_camera_chain gives, in another order. Rough surfaces, which draw one direction at random and aim at
/// lights, are left to it.
#ifndef RSV_CHAIN_QUEUE_H
#define RSV_CHAIN_QUEUE_H

#include "chain_light.h"
#include "chain_media.h"
#include "packet_kernels.h"

/// Waiting branches at most; chains that would send out further ones are followed at once.
#define RSV_QUEUE_CAPACITY 4096

/// A branch on its way: the chain has set out along its direction. Fills a line of the cache.
typedef struct rsv_chain_traveller {
    rsv_vec3 origin, direction;
    rsv_rgb weight;
    float t_min; ///< nearer, its ray meets nothing
    float start_ior, width;
    uint32_t path; ///< as in camera_chain.h
    uint32_t pixel;
    uint32_t events; ///< on arrival
    uint8_t medium;  ///< of rsv_chain_media
    bool settled;
} __attribute__((aligned(64))) rsv_chain_traveller;

/// Some of those moving, side by side.
typedef struct rsv_chain_packet {
    rsv_ray_packet rays;
    rsv_chain_lanes chains;
    rsv_packet_places places;
    uint32_t left; ///< lanes whose ends are not in the table, a bit each
    uint32_t count;
    const uint32_t *member; ///< [count]
} rsv_chain_packet;

typedef struct rsv_chain_queue {
    const rsv_packet_kernels *kernels;
    const rsv_chain_media *media;
    const rsv_clearances *clearances;
    rsv_chain_light light;
    float spread;                 ///< of all chains
    rsv_chain_traveller *waiting; ///< [RSV_QUEUE_CAPACITY] for their next step
    uint8_t *kind;                ///< [RSV_QUEUE_CAPACITY] theirs: those of one are traced together
    uint32_t waiting_count;
    rsv_chain_traveller *moving; ///< [RSV_QUEUE_CAPACITY] taking a step
    uint32_t moving_count;
    uint32_t *order; ///< [RSV_QUEUE_CAPACITY] of those moving, one kind after the other
    rsv_chain_packet packet[RSV_STAGES];
    rsv_branch_lanes branch[2]; ///< reflected and transmitted, of the packet in hand
    rsv_ray_packet body;        ///< a packet's rays as the mover meets them
    uint64_t rays;
} rsv_chain_queue;

rsv_status rsv_chain_queue_create(const rsv_light_table *table, const rsv_packet_kernels *kernels,
    const rsv_chain_media *media, const rsv_clearances *clearances, rsv_chain_queue *queue);
void rsv_chain_queue_destroy(rsv_chain_queue *queue);

/// What the rays of a packet met, and the chains that they belong to.
typedef struct rsv_arrival {
    const rsv_ray_packet *rays;
    const rsv_packet_places *places;
    uint32_t left; ///< lanes whose ends are not in the table
    rsv_chain_lanes *chains;
} rsv_arrival;

/// Chains on their way arrive: adds what they see and queues their branches. @param lanes that do, a bit each
void rsv_chain_queue_arrive(rsv_chain_queue *queue, const rsv_arrival *arrival, uint32_t lanes);

/// The chain of a lane on its way.
rsv_chain rsv_chain_of_lane(const rsv_chain_queue *queue, const rsv_ray_packet *rays,
    const rsv_chain_lanes *chains, uint32_t lane);

/// Follows all that wait to their ends.
void rsv_chain_queue_run(rsv_chain_queue *queue);

#endif
