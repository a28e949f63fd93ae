/// What rows blur, made sharp again.
#ifndef RSV_SHARPEN_H
#define RSV_SHARPEN_H

#include "../elements/elements.h"

/// Rows average over their node's hat function, so what was solved is M E rather than E, with M =
/// rsv_elements_average. 3 M - 2 M^2 times it is E again to second order (M (3 M - 2 M^2) = I +
/// O((I - M)^2)), most visibly at the borders of surfaces, and unlike 2 I - M it does not amplify noise.
/// Next to a jump it would overshoot: nodes there keep what was solved.
/// @param value [node_count], in and out @param once, twice scratch [node_count]
void rsv_sharpen(const rsv_elements *elements, rsv_rgb *value, rsv_rgb *once, rsv_rgb *twice);

#endif
