#include "picture_filter.h"

#include "../core/core.h"
#include "../denoise/denoise.h"

rsv_status rsv_picture_filter(rsv_context *context, rsv_image *const half[2], rsv_image **image)
{
    rsv_denoise_half halves[2];
    uint32_t width = rsv_image_width(half[0]), height = rsv_image_height(half[0]);
    for (int k = 0; k < 2; k++)
        halves[k] = (rsv_denoise_half){ rsv_image_const_pixels(half[k], 0),
            rsv_guide_of(half[k], RSV_GUIDE_DIFFUSE), rsv_guide_of(half[k], RSV_GUIDE_ALBEDO),
            rsv_guide_of(half[k], RSV_GUIDE_NORMAL), rsv_guide_of(half[k], RSV_GUIDE_PLACE) };
    rsv_status status = rsv_image_create(context, width, height, 1, image);
    if (status != RSV_OK) return status;
    status = rsv_denoise(context, width, height, halves, rsv_image_pixels(*image, 0));
    if (status == RSV_OK) return status;
    rsv_image_destroy(*image);
    *image = NULL;
    return status;
}
