/// Pictures without noise, from two halves with guides.
#ifndef RSV_PICTURE_FILTER_H
#define RSV_PICTURE_FILTER_H

#include "picture_guides.h"

/// Filters two pictures with guides, of the same view, whose noise is independent or opposed (halves of one stratified
/// picture), each by the other.
/// @param filtered out: of one layer each
rsv_status rsv_picture_filter_halves(
    rsv_context *context, rsv_image *const half[2], rsv_image *filtered[2]);

/// Their mean, without negative light. @param filtered freed, or the result
rsv_image *rsv_picture_of_halves(rsv_image *filtered[2]);

/// Both. @param image out: of one layer
rsv_status rsv_picture_filter(rsv_context *context, rsv_image *const half[2], rsv_image **image);

#endif
