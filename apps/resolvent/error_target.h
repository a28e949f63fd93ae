/// The options --error, --max-elements and --max-time of commands that solve.
#ifndef CLI_ERROR_TARGET_H
#define CLI_ERROR_TARGET_H

#include "options.h"

#include "resolvent/certify.h"

typedef struct cli_error_target {
    float share;           ///< of the irradiance; 0 = solve once
    uint32_t max_elements; ///< 0 = the library's
    float max_seconds;     ///< likewise
} cli_error_target;

// clang-format off
#define CLI_ERROR_TARGET_OPTIONS(target)                                                           \
    { .name = "--error", .kind = CLI_SHARE, .value = &(target)->share, .min = 1e-4, .max = 1 },    \
    { .name = "--max-elements", .kind = CLI_COUNT, .value = &(target)->max_elements, .min = 1,     \
      .max = UINT32_MAX },                                                                         \
    { .name = "--max-time", .kind = CLI_REAL, .value = &(target)->max_seconds, .min = 1e-3,        \
      .max = 1e9 }
// clang-format on

#define CLI_ERROR_TARGET_HELP                                                                      \
    "  --error P%         refine, from --quality on, until the certificate's estimate of the\n"    \
    "                     irradiance's relative error is below P percent (upper end of its 95 %\n" \
    "                     interval), or until a budget ends\n"                                     \
    "  --max-elements N   --error: no more than that (default 5000000)\n"                          \
    "  --max-time S       --error: seconds (default: as long as it takes)\n"

/// Solves once, or until the target is reached.
/// @param certificate of the solution, where there is a target
rsv_status cli_solve_to_target(const rsv_scene *scene, const rsv_solve_desc *desc,
    const cli_error_target *target, rsv_solution **solution, rsv_certificate *certificate);

#endif
