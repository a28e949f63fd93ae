/// The options --error and --max-time of commands that solve.
#ifndef CLI_ERROR_TARGET_H
#define CLI_ERROR_TARGET_H

#include "options.h"

#include "resolvent/certify.h"

typedef struct cli_error_target {
    float share;       ///< of the irradiance; 0 = solve once
    float max_seconds; ///< 0 = the library's
} cli_error_target;

// clang-format off
#define CLI_ERROR_TARGET_OPTIONS(target)                                                           \
    { .name = "--error", .kind = CLI_SHARE, .value = &(target)->share, .min = 1e-4, .max = 1 },    \
    { .name = "--max-time", .kind = CLI_REAL, .value = &(target)->max_seconds, .min = 1e-3,        \
      .max = 1e9, .goes_with = "--error" }
/// Where --max-time may stand alone.
#define CLI_ERROR_TARGET_ALONE(target)                                                             \
    { .name = "--error", .kind = CLI_SHARE, .value = &(target)->share, .min = 1e-4, .max = 1 },    \
    { .name = "--max-time", .kind = CLI_REAL, .value = &(target)->max_seconds, .min = 1e-3,        \
      .max = 1e9 }
// clang-format on

#define CLI_ERROR_TARGET_HELP                                                                      \
    "  --error P%         refine, from --quality on, until the certificate's estimate of the\n"    \
    "                     irradiance's relative error is below P percent (upper end of its 95 %\n" \
    "                     interval; with a goal: of what that reads), or until a budget ends\n"    \
    "  --max-time S       --error: seconds (default: as long as it takes)\n"

/// Solves once within the budget of `desc`, or until the target is reached.
/// @param certificate of the solution, where there is a target
rsv_status cli_solve_to_target(const rsv_scene *scene, const rsv_solve_desc *desc,
    const cli_error_target *target, rsv_light **solution, rsv_certificate *certificate);

#endif
