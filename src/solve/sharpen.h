/// Sharpens the solution, because rows blur it.
#ifndef RSV_SHARPEN_H
#define RSV_SHARPEN_H

#include "../elements/elements.h"

/// Rows average over their node's hat function, so the solution is M E instead of E, with M = rsv_elements_average.
/// Multiplied by 3 M - 2 M^2, it is E again to second order (M (3 M - 2 M^2) = I + O((I - M)^2)), most visibly at the
/// borders of surfaces. Unlike 2 I - M, this does not amplify noise. Next to a jump it would overshoot, so nodes there
/// keep their value.
/// @param value [node_count], in and out @param once, twice scratch [node_count]
void rsv_sharpen(const rsv_elements *elements, rsv_rgb *value, rsv_rgb *once, rsv_rgb *twice);

#endif
