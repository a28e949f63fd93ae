/// What to do about elements that err too much, by cost.
#ifndef RSV_REMEDIES_H
#define RSV_REMEDIES_H

#include "planner.h"

/// What can be done about elements that err much, at more pixels than can be gathered apart.
typedef enum rsv_remedy {
    RSV_ACCEPT, ///< leave less of the error to noise
    RSV_GATHER,
    RSV_REFINE
} rsv_remedy;

/// Factors of the next solution.
typedef struct rsv_refinement {
    double elements;
    uint32_t rays; ///< of each row
} rsv_refinement;

rsv_refinement rsv_next_refinement(const rsv_planner *planner);

/// The remedy that costs least. @param is_last whether no finer solution may follow
rsv_remedy rsv_choose_remedy(const rsv_planner *planner, bool is_last);

#endif
