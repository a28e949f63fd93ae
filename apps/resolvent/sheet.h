/// Pictures of one size side by side.
#ifndef CLI_SHEET_H
#define CLI_SHEET_H

#include "resolvent/image.h"

/// A white sheet with room for `count` pictures like `first`, in reading order.
rsv_status cli_sheet_create(rsv_context *context, const rsv_image *first, uint32_t count,
    uint32_t columns, rsv_image **sheet);

/// Puts a layer of a picture, times `scale`, in its place.
void cli_sheet_paste(rsv_image *sheet, const rsv_image *image, uint32_t layer, float scale,
    uint32_t place, uint32_t columns);

#endif
