/// Phong's exponent as a roughness.
#ifndef RSV_PHONG_H
#define RSV_PHONG_H

#include <math.h>

#define RSV_SHARPEST_SHININESS 1000 ///< end of the scale in .mtl files: an ideal mirror

/// alpha^2 = 2 / (n + 2) matches the width of Blinn's lobe (Walter et al. 2007); alpha = roughness^2.
static inline float rsv_roughness_of_shininess(float shininess)
{
    return shininess >= RSV_SHARPEST_SHININESS ? 0 : powf(2 / (shininess + 2), 0.25f);
}

#endif
