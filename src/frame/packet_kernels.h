/// The loops over all pixels, compiled for several instruction sets from one source (packet_kernels_body.h). They use
/// no operation whose rounding could differ between those.
#ifndef RSV_PACKET_KERNELS_H
#define RSV_PACKET_KERNELS_H

#include "../trace/camera_ray.h"
#include "light_table.h"
#include "resolvent/trace.h"

/// Pixels of a packet lie in a block of this side; its first eight lanes are the upper half.
#define RSV_BLOCK 4
/// Blocks share a tile of this side, the unit of work of a thread.
#define RSV_TILE 32

/// How a frame's camera rays run.
typedef struct rsv_frame_aim {
    rsv_lens lens;
    uint32_t width, height;
    float place_x, place_y; ///< of the sample within each pixel
} rsv_frame_aim;

/// From radiance to codes.
typedef struct rsv_frame_tone {
    float scale; ///< 2^exposure / samples
    bool soft;
    bool first; ///< sample of its pixel: sums start over
} rsv_frame_tone;

typedef struct rsv_packet_kernels {
    /// Camera rays of the block whose upper left pixel is (column, row); lanes outside the picture are switched off.
    void (*aim)(const rsv_frame_aim *aim, uint32_t column, uint32_t row, rsv_ray_packet *packet);
    /// Radiance of what the packet's rays met, a block of a tile's pixels.
    /// @param radiance [RSV_BLOCK][RSV_TILE] @return lanes whose side is not RSV_SHOWN_STORED, a bit each
    uint32_t (*look_up)(
        const rsv_light_table *table, const rsv_ray_packet *packet, float (*radiance)[4]);
    /// Adds a row of samples to its sums, and shows them.
    /// @param sum, radiance [count] @param pixel [count]
    void (*display)(const rsv_frame_tone *tone, uint32_t count, const float (*radiance)[4],
        float (*sum)[4], uint8_t (*pixel)[4]);
} rsv_packet_kernels;

/// @param instructions BEST, or what the processor is known to have; set to what is in use
const rsv_packet_kernels *rsv_packet_kernels_for(rsv_instructions *instructions);

/// Whether the processor, and this build, have them.
bool rsv_has_instructions(rsv_instructions instructions);

extern const rsv_packet_kernels rsv_packet_kernels_portable, rsv_packet_kernels_avx2,
    rsv_packet_kernels_avx512;

#endif
