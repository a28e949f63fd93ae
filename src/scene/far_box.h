/// Bounds of coordinates in double, and what is to be taken out of them where they lie far from the origin.
#ifndef RSV_FAR_BOX_H
#define RSV_FAR_BOX_H

#include <stdbool.h>

typedef struct rsv_far_box {
    double low[3], high[3];
} rsv_far_box;

rsv_far_box rsv_far_nothing(void);
void rsv_far_enclose(rsv_far_box *box, const double point[3]);

/// Whether all that the box holds lies so far from the origin, for its size, that single precision would lose digits of it.
bool rsv_is_far(const rsv_far_box *box);

/// A round place near the centre of what lies far away: whole tens or hundreds of metres say the same to everybody. All 0 if
/// it does not.
void rsv_far_origin(const rsv_far_box *box, double origin[3]);

#endif
