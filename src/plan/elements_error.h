/// How much of a picture's error is due to elements, and pixels that gather light to avoid it.
///
/// Some pixels are rendered again with gather rays, with the same random numbers otherwise. Where they differ from those
/// whose light was looked up, apart from noise, elements err.
#ifndef RSV_ELEMENTS_ERROR_H
#define RSV_ELEMENTS_ERROR_H

#include "planner.h"

/// Estimates the error of elements after the first two passes, more accurately if that does not decide whether they are
/// good enough (except in filtered pictures), and what gathering would bring.
rsv_status rsv_judge_elements(rsv_planner *planner);

/// Relative MSE by elements: as was found, as far as that is certain, otherwise as is usual. Where some pixels gather,
/// all others were looked at.
double rsv_known_elements_error(const rsv_planner *planner);

/// The same, or more if they err by more than chance.
double rsv_likely_elements_error(const rsv_planner *planner);

/// Whether elements err too much for the target.
bool rsv_elements_limit(const rsv_planner *planner);

/// Relative MSE that is left for the noise of samples by an error due to elements: a given one, and the known one.
double rsv_noise_beside(const rsv_planner *planner, double elements);
double rsv_noise_allowed(const rsv_planner *planner);

/// Gathers at some pixels, where that is all that is needed. The picture begins again.
rsv_status rsv_gather_where_needed(rsv_planner *planner);

#endif
