/// What a command works on: a scene, or an operator file with the scene in it.
#ifndef CLI_SUBJECT_H
#define CLI_SUBJECT_H

#include "error_target.h"
#include "session.h"

#include "resolvent/opfile.h"

typedef struct cli_subject {
    rsv_scene *scene;
    rsv_solution *solution; ///< NULL = not solved yet
} cli_subject;

/// Opens an operator file, or as cli_open_scene does. Prints what went wrong; false then.
/// @param environment as in cli_open_scene; operator files have theirs
bool cli_open_subject(cli_session *session, const char *name, const cli_environment *environment,
    cli_subject *subject);

/// What --max-elements and --max-memory allow; 0 = anything.
typedef struct cli_budget {
    uint32_t elements;
    size_t bytes;
} cli_budget;

// clang-format off
/// The options that fill a cli_budget, for a command's table.
#define CLI_BUDGET_OPTIONS(budget)                                                                 \
    { .name = "--max-elements", .kind = CLI_COUNT, .value = &(budget)->elements, .min = 1,         \
      .max = UINT32_MAX },                                                                         \
    { .name = "--max-memory", .kind = CLI_BYTES, .value = &(budget)->bytes }
// clang-format on

/// Their lines in a command's help.
#define CLI_BUDGET_HELP                                                                            \
    "  --max-elements N   rows of the operator at most: a coarser solution where N are too few\n"  \
    "  --max-memory SIZE  memory of the program at most, such as 2GiB; likewise\n"

/// What --quality, --solver, --seed and the budgets make of a solution's description.
rsv_solve_desc cli_describe_solve(int quality, int solver, uint32_t seed, const cli_budget *budget);

/// Solves the subject unless it is solved already; warns then of options that do nothing.
/// @param target NULL = none @param certificate of the solution, where there is a target
rsv_status cli_solve_subject(cli_session *session, const rsv_solve_desc *desc,
    const cli_error_target *target, cli_subject *subject, rsv_certificate *certificate);

void cli_close_subject(cli_subject *subject);

/// Pixels of a picture where none are asked for: 512 on the longer side, in the camera's aspect.
cli_size cli_default_size(const rsv_camera *camera);

#endif
