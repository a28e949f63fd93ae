/// Direct light per pixel by next-event estimation, with what is known in closed form as control variate.
///
/// Sample i of a pixel finds the unshadowed contribution S_i, visible or not (V_i), and knows its exact
/// mean A_i (Lambert's formula). With a_i the mean visibility of the pixel's *other* samples,
///
///     sum_i  S_i V_i + a_i (A_i - C_i)
///
/// (C_i = S_i with the mean radiance of a textured emitter) is free of noise where all samples see the light, and unbiased as far as the others tell nothing of sample i.
/// Samples of a pixel are stratified against each other, so a bias of order 1 / samples remains in penumbrae.
#ifndef RSV_PIXEL_DIRECT_H
#define RSV_PIXEL_DIRECT_H

#include "../solve/solution.h"

typedef struct rsv_direct_term {
    uint32_t column, sample;
    bool controlled; ///< A is known
    float visible;
    rsv_rgb exact, sampled; ///< A, S times the weight of the camera chain
    rsv_rgb control;        ///< S with the emitter's mean radiance, which is what A knows
} rsv_direct_term;

/// The direct light of one row of pixels. Terms of a pixel must be added one after the other.
typedef struct rsv_pixel_direct {
    rsv_context *context;
    const rsv_tracer *tracer;
    rsv_direct_term *term;
    size_t term_count, term_capacity;
    rsv_ray_packet packet; ///< shadow rays not traced yet
    uint32_t pending;
    size_t owner[RSV_PACKET_WIDTH]; ///< their terms
    rsv_status status;
} rsv_pixel_direct;

void rsv_pixel_direct_begin(rsv_pixel_direct *direct, const rsv_solution *solution);
void rsv_pixel_direct_end(rsv_pixel_direct *direct);

/// Adds the sampled light of all sources at the chain's surface.
/// @param weight radiance at the camera per irradiance
/// @param sample of `samples` in the pixel
void rsv_pixel_direct_add(rsv_pixel_direct *direct, const rsv_solution *solution,
    const rsv_chain *chain, rsv_rgb weight, uint32_t column, uint32_t sample, uint32_t samples,
    uint32_t seed);

/// Called for each pixel with the sum over its samples, and the sum of the squares of their luminance.
typedef void (*rsv_pixel_direct_sink)(void *user, uint32_t column, rsv_rgb radiance, float squares);

/// Traces what is pending, hands each pixel's light to `add` and starts over.
rsv_status rsv_pixel_direct_resolve(
    rsv_pixel_direct *direct, rsv_pixel_direct_sink add, void *user);

/// One-sample estimate of the irradiance that next-event estimation finds at the chain's surface.
rsv_rgb rsv_sampled_irradiance(
    const rsv_solution *solution, const rsv_chain *chain, rsv_random *random);

#endif
