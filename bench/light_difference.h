/// By how much two solutions of one scene differ.
#ifndef CLI_LIGHT_DIFFERENCE_H
#define CLI_LIGHT_DIFFERENCE_H

#include "resolvent/solve.h"

/// RMS difference of the irradiance (luminance) over the surfaces of the scene, over the RMS of `a`.
double cli_light_difference(const rsv_light *a, const rsv_light *b);

#endif
