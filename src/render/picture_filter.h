/// Pictures without noise, from two halves with guides.
#ifndef RSV_PICTURE_FILTER_H
#define RSV_PICTURE_FILTER_H

#include "picture_guides.h"

/// Filters two pictures with guides, of the same view and with independent noise, each by the other.
/// @param filtered out: of one layer each
rsv_status rsv_picture_filter_halves(
    rsv_context *context, rsv_image *const half[2], rsv_image *filtered[2]);

/// The mean of the filtered pictures.
/// @param image out: of one layer
rsv_status rsv_picture_filter(rsv_context *context, rsv_image *const half[2], rsv_image **image);

#endif
