/// Direct light per pixel by next-event estimation, with closed forms as control variate.
///
/// Sample i of a pixel finds the unshadowed contribution S_i and its visibility V_i, and knows the exact mean A_i
/// (Lambert's formula). The samples are divided into two halves, whose shadow rays are stratified within each half and
/// independent between them. With a_i the mean visibility of the *other* half and, with less weight, of the
/// neighbouring pixels in the row,
///
///     sum_i  S_i V_i + a_i (A_i - C_i)
///
/// (C_i = S_i with the mean radiance of a textured emitter, whatever the coat transmits) has no noise where all samples
/// see the light, and is unbiased: A_i - C_i is 0 on average, independently of the others. (Samples stratified against
/// sample i know where it is not, which is a bias of order 1 / samples.)
///
/// Where sources are partly visible, samples trace more shadow rays: the number that balances their cost against that
/// of camera rays, sqrt(variance of visibility / variance of all else * cost of a camera ray / of a shadow ray) (Bolin
/// and Meyer 1997). The variances are those of the pixel's neighbours: a pixel that used its own samples would stop
/// where they happen to agree, and be biased.
#ifndef RSV_PIXEL_DIRECT_H
#define RSV_PIXEL_DIRECT_H

#include "../receiver/next_event.h"
#include "../solve/light.h"
#include "pixel_noise.h"
#include "pixel_sample.h"

/// Result of one sample's shadow rays to one source or, chosen among them, to all emitters.
typedef struct rsv_direct_term {
    uint32_t column, sample;
    bool of_first;        ///< at the first surface that the camera ray has come to
    uint32_t rays, asked; ///< drawn; of these, to sources in A that are above the horizon
    float seen,
        veiled;      ///< of those: sum of transmittances, and of transmittance times its complement
    float expected;  ///< luminance without occlusion, emitters in a tree by a rough estimate
    rsv_rgb exact;   ///< A times the weight of the camera path, like the following
    rsv_rgb arrived; ///< sum of S V over the rays
    rsv_rgb control; ///< sum of C over the rays
} rsv_direct_term;

/// A surface that may want further shadow rays.
typedef struct rsv_direct_spot {
    rsv_specular_path path;
    rsv_rgb weight;
    rsv_pixel_sample sample;
    size_t term;
} rsv_direct_spot;

/// Results of the first shadow rays, for the terms of a pixel that may need more.
typedef struct rsv_shadow_tally {
    uint32_t terms, asked;
    float seen, veiled;
    float brightest;                ///< the luminance that each could bring: the greatest
    float squares;                  ///< sum of the squares of their A
    float further, further_squares; ///< found of emitters in a tree: sum, and sum of squares
} rsv_shadow_tally;

/// The direct light of one row of pixels. Terms of a pixel must be added one after the other.
typedef struct rsv_pixel_direct {
    const rsv_light_view *solution;
    uint32_t width;
    rsv_shadow_tally *tally; ///< [width]
    rsv_direct_term *term;
    rsv_direct_spot *spot;
    size_t term_count, term_capacity, spot_count, spot_capacity;
    rsv_next_event event[RSV_PACKET_WIDTH]; ///< whose shadow rays are not traced yet
    size_t owner[RSV_PACKET_WIDTH];         ///< their terms
    uint32_t pending;
    rsv_status status;
} rsv_pixel_direct;

/// @param width of the picture
rsv_status rsv_pixel_direct_begin(
    rsv_pixel_direct *direct, const rsv_light_view *solution, uint32_t width);
void rsv_pixel_direct_end(rsv_pixel_direct *direct);

/// Adds the sampled light of all sources at the specular path's surface.
/// @param weight radiance at the camera per irradiance
void rsv_pixel_direct_add(rsv_pixel_direct *direct, const rsv_specular_path *path, rsv_rgb weight,
    uint32_t column, rsv_pixel_sample sample);

/// Direct light of a pixel.
typedef struct rsv_pixel_light {
    rsv_rgb of_first,
        of_others; ///< sums over samples, by the first surface and by those behind mirrors and glass
    float squares; ///< sum of the squares of the luminance of both
} rsv_pixel_light;

typedef void (*rsv_pixel_direct_sink)(void *user, uint32_t column, const rsv_pixel_light *light);

/// Sends further shadow rays, hands each pixel's light to `add` and starts over.
/// @param noise [width] of all light but the direct
rsv_status rsv_pixel_direct_resolve(
    rsv_pixel_direct *direct, const rsv_pixel_noise *noise, rsv_pixel_direct_sink add, void *user);

/// The same as one sample that is unbiased by itself, for a surface that a camera sees. @param stored the solution's
/// value: where it is right and no shadow is near, there is no noise
rsv_rgb rsv_seen_irradiance(
    const rsv_light_view *solution, const rsv_specular_path *path, rsv_rgb stored, uint32_t seed);

/// One-sample estimate of the irradiance that next-event estimation finds at the specular path's surface.
rsv_rgb rsv_sampled_irradiance(
    const rsv_light_view *solution, const rsv_specular_path *path, rsv_random *random);

#endif
