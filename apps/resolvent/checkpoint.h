/// The options --checkpoint and --resume of commands that solve for long.
#ifndef CLI_CHECKPOINT_H
#define CLI_CHECKPOINT_H

#include "options.h"
#include "session.h"

#include <limits.h>

typedef struct cli_checkpoint {
    const char *folder; ///< NULL = none
    bool resume;        ///< an earlier run must have begun
    char
        rows[PATH_MAX]; ///< FOLDER/VERSION-FINGERPRINT: of one scene and one version of the program
    char earlier[PATH_MAX]; ///< the latest of another scene there; "" = none
} cli_checkpoint;

// clang-format off
#define CLI_CHECKPOINT_OPTIONS(checkpoint)                                                         \
    { .name = "--checkpoint", .kind = CLI_TEXT, .value = &(checkpoint)->folder },                  \
    { .name = "--resume", .kind = CLI_FLAG, .value = &(checkpoint)->resume,                        \
      .goes_with = "--checkpoint" }
// clang-format on

#define CLI_CHECKPOINT_HELP                                                                        \
    "  --checkpoint DIR   save rows of the operator in DIR as they are traced. After an interruption, the\n"\
    "                     same command continues from there and ends with the same bytes. After an edit\n"\
    "                     of the scene, only what it may have changed is computed again. You may delete\n"\
    "                     DIR at any time\n"                                                       \
    "  --resume           fail unless DIR holds rows of this scene\n"

/// Makes the folder for a scene's rows, and has the solve use it. Does nothing if no folder was given.
/// @return false, after an error message, on failure
bool cli_checkpoint_prepare(
    cli_session *session, cli_checkpoint *checkpoint, const rsv_scene *scene, rsv_solve_desc *desc);

/// To be called once a solution is done: keeps the rows of its scene and of the previous one, and removes those of
/// other finished solutions.
void cli_checkpoint_prune(const cli_checkpoint *checkpoint);

#endif
