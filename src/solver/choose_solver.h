/// Which solver costs least.
#ifndef RSV_CHOOSE_SOLVER_H
#define RSV_CHOOSE_SOLVER_H

#include "resolvent/solve.h"

/// Input of the choice.
typedef struct rsv_solver_question {
    rsv_solver wanted;
    double norm_inf, spectral_radius;
    uint32_t terms; ///< that the Neumann series would still take
    size_t node_count;
    bool on_device; ///< whether BiCGStab would run on a device
} rsv_solver_question;

/// @param reason a sentence, [reason_bytes]
rsv_solver rsv_choose_solver(
    const rsv_solver_question *question, char *reason, size_t reason_bytes);

#endif
