#include "sheet.h"

enum { gap = 4 }; ///< pixels between the pictures

rsv_status cli_sheet_create(rsv_context *context, const rsv_image *first, uint32_t count,
    uint32_t columns, rsv_image **sheet)
{
    if (columns > count) columns = count;
    uint32_t rows = (count + columns - 1) / columns;
    uint32_t across = rsv_image_width(first) + gap, down = rsv_image_height(first) + gap;
    rsv_status status =
        rsv_image_create(context, columns * across - gap, rows * down - gap, 1, sheet);
    if (status != RSV_OK) return status;
    rsv_rgb *pixel = rsv_image_pixels(*sheet, 0);
    size_t pixel_count = (size_t)rsv_image_width(*sheet) * rsv_image_height(*sheet);
    for (size_t i = 0; i < pixel_count; i++)
        pixel[i] = (rsv_rgb){ 1, 1, 1 };
    return RSV_OK;
}

void cli_sheet_paste(rsv_image *sheet, const rsv_image *image, uint32_t layer, float scale,
    uint32_t place, uint32_t columns)
{
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    uint32_t left = place % columns * (width + gap), top = place / columns * (height + gap);
    const rsv_rgb *from = rsv_image_const_pixels(image, layer);
    for (uint32_t y = 0; y < height; y++) {
        rsv_rgb *to =
            rsv_image_pixels(sheet, 0) + (size_t)(top + y) * rsv_image_width(sheet) + left;
        for (uint32_t x = 0; x < width; x++, from++)
            to[x] = (rsv_rgb){ scale * from->r, scale * from->g, scale * from->b };
    }
}
