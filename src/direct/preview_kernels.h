/// The arithmetic of sixteen receiver points at a time, compiled for several instruction sets from one source
/// (preview_kernels_body.h). It uses no operation whose rounding could differ between those.
#ifndef RSV_PREVIEW_KERNELS_H
#define RSV_PREVIEW_KERNELS_H

#include "receiver_blocks.h"

/// An emitter, one of its corners after the other.
typedef struct rsv_preview_polygon {
    float x[3], y[3], z[3];
    float normal_x, normal_y, normal_z; ///< unit, of the front
    float height;                       ///< least one above its plane that is not rounding
    int double_sided;
} rsv_preview_polygon;

/// Places of a source, one for each lane.
typedef struct rsv_preview_places {
    float x[RSV_PACKET_WIDTH], y[RSV_PACKET_WIDTH], z[RSV_PACKET_WIDTH];
    float normal_x[RSV_PACKET_WIDTH], normal_y[RSV_PACKET_WIDTH], normal_z[RSV_PACKET_WIDTH];
    float extent[RSV_PACKET_WIDTH];
    float spread[RSV_PACKET_WIDTH]; ///< area that each stands for over pi, m2
    int double_sided[RSV_PACKET_WIDTH];
    rsv_rgb strength[RSV_PACKET_WIDTH];
} __attribute__((aligned(64))) rsv_preview_places;

typedef struct rsv_preview_kernels {
    /// Irradiance of each lane from a triangle of radiance 1 without occlusion (rsv_polygon_irradiance in single
    /// precision), 0 for lanes that it does not face.
    void (*irradiance)(
        const rsv_receiver_block *block, const rsv_preview_polygon *polygon, float *irradiance);
    /// Shadow rays from each lane to its place; lanes are switched off that get no light from there.
    /// @param share cosines over the squared distance, per lane, as from a disk of the place's area @param cosine at
    /// the
    ///              receiver
    void (*aim)(const rsv_receiver_block *block, const rsv_preview_places *places,
        rsv_ray_packet *packet, float *share, float *cosine);
} rsv_preview_kernels;

/// The fastest kernels for this CPU.
const rsv_preview_kernels *rsv_preview_kernels_best(void);

extern const rsv_preview_kernels rsv_preview_kernels_portable, rsv_preview_kernels_avx2,
    rsv_preview_kernels_avx512;

#endif
