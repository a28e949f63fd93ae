/// The input of a command: a scene, or an operator file with the scene in it.
#ifndef CLI_SUBJECT_H
#define CLI_SUBJECT_H

#include "error_target.h"
#include "session.h"
#include "stats.h"

#include "resolvent/opfile.h"

typedef struct cli_subject {
    rsv_scene *scene;
    rsv_light *solution; ///< NULL = not solved yet
} cli_subject;

/// Opens an operator file, or a scene as cli_open_scene does. Prints an error and returns false on failure.
/// @param environment as in cli_open_scene; not for operator files, which contain theirs
bool cli_open_subject(cli_session *session, const char *name, const cli_environment *environment,
    cli_subject *subject);

/// For commands that accept only operator files: whether `name` is one. Prints an error if not.
bool cli_is_operator(const char *name);

/// How a scene is solved: --quality, --solver, --seed, --max-elements and --max-memory.
typedef struct cli_solve_choice {
    int quality, solver; ///< rsv_quality, rsv_solver
    uint32_t seed;
    uint32_t max_elements; ///< 0 = any number, as max_bytes
    size_t max_bytes;
    const char *petsc; ///< options of PETSc, which is to solve; NULL = none were given
} cli_solve_choice;

#define CLI_DEFAULT_SOLVE ((cli_solve_choice){ .quality = RSV_QUALITY_MEDIUM })

// clang-format off
/// The options that fill a cli_solve_choice, for a command's table.
#define CLI_SOLVE_OPTIONS(choice)                                                                  \
    { .name = "--quality", .kind = CLI_CHOICE, .value = &(choice)->quality,                        \
      .choices = cli_quality_names },                                                              \
    { .name = "--solver", .kind = CLI_CHOICE, .value = &(choice)->solver,                          \
      .choices = rsv_solver_names() },                                                               \
    { .name = "--seed", .kind = CLI_COUNT, .value = &(choice)->seed, .max = UINT32_MAX },          \
    { .name = "--max-elements", .kind = CLI_COUNT, .value = &(choice)->max_elements, .min = 1,     \
      .max = UINT32_MAX },                                                                         \
    { .name = "--max-memory", .kind = CLI_BYTES, .value = &(choice)->max_bytes },                  \
    { .name = "--petsc", .kind = CLI_TEXT, .value = &(choice)->petsc }
// clang-format on

/// Their lines in a command's help.
#define CLI_SOLVE_HELP                                                                             \
    "  --quality Q        draft, medium (default) or high: number of elements and rays\n"          \
    "  --solver NAME      solver of the linear system (default auto):\n"                           \
    "                     {--solver}\n"                                                            \
    "  --petsc OPTIONS    solve with PETSc and these options, such as \"-ksp_type bcgs -ksp_monitor\"\n"\
    "  --seed N           seed of the random numbers (default 0)\n"                                \
    "  --max-elements N   at most N elements; the solution becomes coarser if it would need more\n"\
    "  --max-memory SIZE  at most this much memory, such as 2GiB; may make the solution coarser\n"

/// Loads the plug-in for PETSc if it is the solver. Call it before the session begins. Prints errors.
bool cli_prepare_solve(const cli_solve_choice *choice);

rsv_solve_desc cli_describe_solve(const cli_solve_choice *choice);

/// Solves the subject unless it is solved already; warns then of options that do nothing.
/// @param target NULL = none @param certificate of the solution, where there is a target
rsv_status cli_solve_subject(cli_session *session, const rsv_solve_desc *desc,
    const cli_error_target *target, cli_subject *subject, rsv_certificate *certificate);

void cli_close_subject(cli_subject *subject);

/// Default size of a picture: 512 pixels on the longer side, in the camera's aspect.
cli_size cli_default_size(const rsv_camera *camera);

#endif
