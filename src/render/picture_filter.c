#include "picture_filter.h"

#include "../core/core.h"
#include "../core/vec.h"
#include "../denoise/denoise.h"

rsv_status rsv_picture_filter_halves(
    rsv_context *context, rsv_image *const half[2], rsv_image *filtered[2])
{
    rsv_denoise_half halves[2];
    uint32_t width = rsv_image_width(half[0]), height = rsv_image_height(half[0]);
    rsv_status status = RSV_OK;
    filtered[0] = filtered[1] = NULL;
    for (int k = 0; k < 2; k++)
        halves[k] = (rsv_denoise_half){ rsv_image_const_pixels(half[k], 0),
            rsv_guide_of(half[k], RSV_GUIDE_DIFFUSE), rsv_guide_of(half[k], RSV_GUIDE_ALBEDO),
            rsv_guide_of(half[k], RSV_GUIDE_NORMAL), rsv_guide_of(half[k], RSV_GUIDE_PLACE) };
    for (int k = 0; k < 2; k++)
        RSV_TRY(rsv_image_create(context, width, height, 1, &filtered[k]));
    rsv_rgb *const pixels[2] = { rsv_image_pixels(filtered[0], 0),
        rsv_image_pixels(filtered[1], 0) };
    RSV_TRY(rsv_denoise(context, width, height, halves, pixels));
    return RSV_OK;
cleanup:
    rsv_image_destroy(filtered[0]);
    rsv_image_destroy(filtered[1]);
    filtered[0] = filtered[1] = NULL;
    return status;
}

rsv_image *rsv_picture_of_halves(rsv_image *filtered[2])
{
    size_t pixels = (size_t)rsv_image_width(filtered[0]) * rsv_image_height(filtered[0]);
    rsv_rgb *a = rsv_image_pixels(filtered[0], 0), *b = rsv_image_pixels(filtered[1], 0);
    for (size_t k = 0; k < pixels; k++)
        a[k] = rgb_positive(rgb_scale(rgb_add(a[k], b[k]), 0.5f));
    rsv_image_destroy(filtered[1]);
    return filtered[0];
}

rsv_status rsv_picture_filter(rsv_context *context, rsv_image *const half[2], rsv_image **image)
{
    rsv_image *filtered[2];
    rsv_status status = rsv_picture_filter_halves(context, half, filtered);
    if (status == RSV_OK) *image = rsv_picture_of_halves(filtered);
    return status;
}
