/// Scenes of benchmarks that are third-party files: their places and surroundings.
#ifndef CLI_ROOM_FILES_H
#define CLI_ROOM_FILES_H

#include "benchmarks.h"

#include <limits.h>

typedef struct cli_room_files {
    char name[64]; ///< for files about it
    char scene[PATH_MAX], environment[PATH_MAX];
    bool is_asset; ///< one that may be missing
} cli_room_files;

/// Finds the scene of a task, one of the known names or a scene of the user's own. False after a message.
/// @param benchmark whose message that is
bool cli_find_room(const cli_bench_task *bench, const char *benchmark, cli_room_files *room);

/// Whether the file of a known name is not there; says so in the result.
bool cli_room_is_missing(const cli_room_files *room, struct cJSON *result);

#endif
