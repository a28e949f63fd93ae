/// @file image.h
/// Pictures: linear RGB radiance with named layers, read, written, compared.
#ifndef RESOLVENT_IMAGE_H
#define RESOLVENT_IMAGE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Layer 0 is the picture itself ("" by name); further layers are e.g. "emission", "direct",
/// "bounce1". All have the same size. Row 0 is the top.
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
/// @param name at most 63 bytes and unlike the other layers' names; copied
RSV_API rsv_status rsv_image_set_layer_name(rsv_image *image, uint32_t layer, const char *name);
/// Index of the layer called `name`; UINT32_MAX if there is none.
RSV_API uint32_t rsv_image_find_layer(const rsv_image *image, const char *name);

/// Reads .exr (all RGB layers), .hdr, .png, .jpg, .webp, .tga, .bmp and .gif; 8-bit formats are decoded from sRGB to
/// linear.
RSV_API rsv_status rsv_image_read(rsv_context *context, const char *path, rsv_image **image);

/// The same of a picture in memory. @param name for messages, and to tell by its extension what the bytes leave open
RSV_API rsv_status rsv_image_read_memory(
    rsv_context *context, const char *name, const void *bytes, size_t count, rsv_image **image);

/// Writes by extension: .exr (32-bit float, all layers), .hdr and .png (layer 0). PNG holds
/// sRGB(radiance * 2^exposure), clipped. The file appears complete or not at all.
RSV_API rsv_status rsv_image_write(const rsv_image *image, const char *path, float exposure);

/// Stops for rsv_image_write by which layer 0 is shown well, in steps of 0.05: 0 where the geometric mean of the luminance of
/// what is not black lies between 0.13 and 0.36, else what brings it to the nearer of the two, within -64 .. 64. 0 for a black
/// picture. What is more than 8 stops below the brightest 5 % counts as no darker than that.
RSV_API float rsv_image_exposure(const rsv_image *image);

/// RSV_OK if `path` has a supported extension and its folder can be written; to be asked before long
/// work.
RSV_API rsv_status rsv_image_check_output(const char *path);

/// How picture b differs from reference a; all over the three channels together.
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

/// What two pictures of one truth, each with noise of its own, say of a third.
typedef struct rsv_image_judgement {
    /// Mean of (b - a0) (b - a1) / (m^2 + 0.01 mean(a)^2), where m is the mean of both a over 5 x 5 pixels: noise that
    /// does not correlate cancels, so this is how far b is from the truth, and can come out below 0.
    double relative_mse;
    double relative_mse_error; ///< its standard error, pixels taken for independent
    double reference_mse;      ///< relative MSE of the mean of the two themselves
} rsv_image_judgement;

/// Judges the picture b by two independent references of the same size, such as path-traced ones with different seeds.
/// Unlike the noise of a single reference, that of two does not count as an error of b.
RSV_API rsv_status rsv_image_judge(const rsv_image *const a[2], const uint32_t layer_a[2],
    const rsv_image *b, uint32_t layer_b, rsv_image_judgement *judgement);

#ifdef __cplusplus
}
#endif

#endif
