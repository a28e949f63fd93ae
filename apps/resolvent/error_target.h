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
/// For commands where --max-time does not need --error.
#define CLI_ERROR_TARGET_ALONE(target)                                                             \
    { .name = "--error", .kind = CLI_SHARE, .value = &(target)->share, .min = 1e-4, .max = 1 },    \
    { .name = "--max-time", .kind = CLI_REAL, .value = &(target)->max_seconds, .min = 1e-3,        \
      .max = 1e9 }
// clang-format on

#define CLI_ERROR_TARGET_HELP                                                                      \
    "  --error P%         refine, starting from --quality, until the estimated relative error of the\n"\
    "                     irradiance (with --goal: of the goal's reading) is below P percent with 95 %\n"\
    "                     confidence, or a limit is reached\n"                                     \
    "  --max-time S       with --error: stop after S seconds (default: no limit)\n"

/// Solves once within the budget of `desc`, or until the target is reached.
/// @param certificate of the solution, where there is a target
rsv_status cli_solve_to_target(const rsv_scene *scene, const rsv_solve_desc *desc,
    const cli_error_target *target, rsv_light **solution, rsv_certificate *certificate);

#endif
