/// Outlines: pixels between surfaces that differ visibly.
///
/// A pixel that covers two surfaces shows a mix of both. With few camera rays, its neighbours along the outline get
/// different mixes, and the line looks ragged. A relative error hardly shows this: beside a lamp, everything is small.
#ifndef RSV_OUTLINES_H
#define RSV_OUTLINES_H

#include "picture_row.h"

/// Marks pixels that outlines cross. The first surface that each camera ray meets counts; what is seen in
/// mirrors or through glass does not.
/// @param job film and solution @param picture that shows how much both sides differ; it may be noisy
/// @param is_outline [height * width] out
rsv_status rsv_find_outlines(
    const rsv_picture_job *job, const rsv_image *picture, uint8_t *is_outline);

#endif
