/// Bounds of coordinates in double precision, and the origin to subtract if they are far from 0.
#ifndef RSV_FAR_BOX_H
#define RSV_FAR_BOX_H

#include <stdbool.h>

typedef struct rsv_far_box {
    double low[3], high[3];
} rsv_far_box;

rsv_far_box rsv_far_nothing(void);
void rsv_far_enclose(rsv_far_box *box, const double point[3]);

/// Whether the box is so far from the origin, relative to its size, that single precision would lose digits.
bool rsv_is_far(const rsv_far_box *box);

/// A round origin near the centre of the box, in whole tens or hundreds of metres, so that similar files get the same
/// one. All 0 if the box is not far from 0.
void rsv_far_origin(const rsv_far_box *box, double origin[3]);

#endif
