/// Which solver costs least.
#ifndef RSV_CHOOSE_SOLVER_H
#define RSV_CHOOSE_SOLVER_H

#include "linear_map.h"
#include "resolvent/solve.h"

/// What is known when the choice is made.
typedef struct rsv_solver_question {
    rsv_solver wanted;
    double norm_inf, spectral_radius;
    uint32_t terms; ///< that the Neumann series would still take
    const rsv_linear_map *map;
} rsv_solver_question;

/// @param reason a sentence, [reason_bytes]
rsv_solver rsv_choose_solver(
    const rsv_solver_question *question, char *reason, size_t reason_bytes);

#endif
