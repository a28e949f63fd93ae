/// @file image.h
/// Pictures: linear RGB radiance in named layers. Reading, writing, comparing.
#ifndef RESOLVENT_IMAGE_H
#define RESOLVENT_IMAGE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A picture. Layer 0, named "", is the picture itself; others are, for example, "emission", "direct" and "bounce1".
/// All have the same size. Row 0 is the top.
typedef struct rsv_image rsv_image;

RSV_API rsv_status rsv_image_create(
    rsv_context *context, uint32_t width, uint32_t height, uint32_t layer_count, rsv_image **image);
RSV_API void rsv_image_destroy(rsv_image *image);

RSV_API uint32_t rsv_image_width(const rsv_image *image);
RSV_API uint32_t rsv_image_height(const rsv_image *image);
RSV_API uint32_t rsv_image_layer_count(const rsv_image *image);
/// [height * width] pixels, row-major; borrowed.
RSV_API rsv_rgb *rsv_image_pixels(rsv_image *image, uint32_t layer);
RSV_API const rsv_rgb *rsv_image_const_pixels(const rsv_image *image, uint32_t layer);
RSV_API const char *rsv_image_layer_name(const rsv_image *image, uint32_t layer);
/// @param name at most 63 bytes, different from the other layers' names; copied
RSV_API rsv_status rsv_image_set_layer_name(rsv_image *image, uint32_t layer, const char *name);
/// Index of the layer called `name`; UINT32_MAX if there is none.
RSV_API uint32_t rsv_image_find_layer(const rsv_image *image, const char *name);

/// Reads .exr (all RGB layers), .hdr, .png, .jpg, .webp, .tga, .bmp and .gif. Formats with 8 bits are converted from
/// sRGB to linear.
RSV_API rsv_status rsv_image_read(rsv_context *context, const char *path, rsv_image **image);

/// Reads a picture in memory.
/// @param name for messages; its extension gives the format if the bytes do not
RSV_API rsv_status rsv_image_read_memory(
    rsv_context *context, const char *name, const void *bytes, size_t count, rsv_image **image);

/// Writes a picture. The extension selects the format: .exr (32-bit float, all layers), .hdr or .png (layer 0). PNG
/// holds sRGB(radiance * 2^exposure), clipped. The file appears complete or not at all.
RSV_API rsv_status rsv_image_write(const rsv_image *image, const char *path, float exposure);

/// A good exposure of layer 0 for rsv_image_write, in stops, in steps of 0.05. It is 0 if the geometric mean of the
/// luminance of pixels that are not black is between 0.13 and 0.36. Otherwise it moves this mean to the nearer of these
/// limits, within -64..64. Pixels more than 8 stops below the brightest 5 % count as 8 stops below. 0 for a black
/// picture.
RSV_API float rsv_image_exposure(const rsv_image *image);

/// RSV_OK if `path` has a supported extension and its folder is writable. Call it before long work.
RSV_API rsv_status rsv_image_check_output(const char *path);

/// Differences of picture b from reference a, over all three channels together.
typedef struct rsv_image_difference {
    double rmse;                  ///< root mean square of b - a
    double relative_mse;          ///< mean of (b - a)^2 / (a^2 + 0.01 mean(a)^2)
    double psnr;                  ///< dB, peak = largest value of a
    double mean_ratio;            ///< mean(b) / mean(a)
    double channel_mean_ratio[3]; ///< the same per channel
    /// median over pixels of |lum(b) - lum(a)| / max(lum(a), 1e-3 mean of lum(a))
    double median_relative_error;
} rsv_image_difference;

/// Compares layer `layer_b` of b against layer `layer_a` of a (the reference).
RSV_API rsv_status rsv_image_compare(const rsv_image *a, uint32_t layer_a, const rsv_image *b,
    uint32_t layer_b, rsv_image_difference *difference);

/// The error of a picture, from two independent references.
typedef struct rsv_image_judgement {
    /// Mean of (b - a0) (b - a1) / (m^2 + 0.01 mean(a)^2), where m is the mean of both references over 5 x 5 pixels.
    /// The noise of the references is uncorrelated and cancels, so this is the relative MSE of b alone. It can be
    /// slightly negative.
    double relative_mse;
    double relative_mse_error; ///< its standard error, assuming independent pixels
    double reference_mse;      ///< relative MSE of the mean of the two references
} rsv_image_judgement;

/// Compares picture b with two independent references of the same size, such as path-traced ones with different seeds.
/// Unlike the noise of a single reference, theirs does not count as an error of b.

RSV_API rsv_status rsv_image_judge(const rsv_image *const a[2], const uint32_t layer_a[2],
    const rsv_image *b, uint32_t layer_b, rsv_image_judgement *judgement);

#ifdef __cplusplus
}
#endif

#endif
