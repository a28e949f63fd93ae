/// Wavefronts of mirror and glass paths: branches of many pixels wait until all of them take their next step, with
/// similar ones together in packets.
///
/// They give the results of rsv_camera_path, in another order. Rough surfaces, which draw one random direction and
/// sample lights, are left to that function.
#ifndef RSV_SPECULAR_QUEUE_H
#define RSV_SPECULAR_QUEUE_H

#include "packet_kernels.h"
#include "specular_light.h"
#include "specular_media.h"

/// Waiting branches at most; specular paths that would send out further ones are followed at once.
#define RSV_QUEUE_CAPACITY 4096

/// A branch on its way: the specular path has set out along its direction. Fills a line of the cache.
typedef struct rsv_specular_traveller {
    rsv_vec3 origin, direction;
    rsv_rgb weight;
    float t_min; ///< nearer, its ray meets nothing
    float start_ior, width;
    uint32_t trail; ///< as in camera_path.h
    uint32_t pixel;
    uint32_t events; ///< on arrival
    uint8_t medium;  ///< of rsv_specular_media
    bool settled;
} __attribute__((aligned(64))) rsv_specular_traveller;

/// Some of those moving, side by side.
typedef struct rsv_specular_packet {
    rsv_ray_packet rays;
    rsv_specular_lanes paths;
    rsv_packet_places places;
    uint32_t left; ///< lanes whose ends are not in the table, a bit each
    uint32_t count;
    const uint32_t *member; ///< [count]
} rsv_specular_packet;

typedef struct rsv_specular_queue {
    const rsv_packet_kernels *kernels;
    const rsv_specular_media *media;
    const rsv_clearances *clearances;
    rsv_specular_light light;
    float spread;                      ///< of all specular paths
    const rsv_glossy_shading *shading; ///< of the frame
    rsv_glossy_tile *lobes;            ///< of a packet at glossy surfaces; NULL = there are none
    float (*irradiance)[4];            ///< [RSV_BLOCK][RSV_TILE] of one
    rsv_specular_traveller *waiting;   ///< [RSV_QUEUE_CAPACITY] for their next step
    uint8_t *kind; ///< [RSV_QUEUE_CAPACITY] theirs: those of one are traced together
    uint32_t waiting_count;
    rsv_specular_traveller *moving; ///< [RSV_QUEUE_CAPACITY] taking a step
    uint32_t moving_count;
    uint32_t *order; ///< [RSV_QUEUE_CAPACITY] of those moving, one kind after the other
    rsv_specular_packet packet[RSV_STAGES];
    rsv_branch_lanes branch[2]; ///< reflected and transmitted, of the packet in hand
    rsv_ray_packet body;        ///< a packet's rays as the mover meets them
    uint64_t rays;
} rsv_specular_queue;

rsv_status rsv_specular_queue_create(const rsv_light_table *table,
    const rsv_packet_kernels *kernels, const rsv_specular_media *media,
    const rsv_clearances *clearances, rsv_specular_queue *queue);
void rsv_specular_queue_destroy(rsv_specular_queue *queue);

/// Specular paths arrive at surfaces: adds their light and queues their branches. @param lanes that do, one bit each
void rsv_specular_queue_arrive(
    rsv_specular_queue *queue, const rsv_arrival *arrival, uint32_t lanes);

/// The specular path of a lane on its way.
rsv_specular_path rsv_specular_of_lane(const rsv_specular_queue *queue, const rsv_ray_packet *rays,
    const rsv_specular_lanes *paths, uint32_t lane);

/// Follows all queued paths to their ends.
void rsv_specular_queue_run(rsv_specular_queue *queue);

#endif
