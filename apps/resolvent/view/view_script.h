/// Commands by frame: the file format of `resolvent view --script`.
///
///     # frame  command                       or first-last: in every one of these frames
///     0        select light.lamp
///     0-59     orbit 2 0
///     30       intensity 2
#ifndef CLI_VIEW_SCRIPT_H
#define CLI_VIEW_SCRIPT_H

#include "view_command.h"

#include <stdint.h>

enum { CLI_VIEW_MOST_FRAMES = 1000000 };

typedef struct cli_view_script_line {
    uint32_t first, last; ///< frames
    size_t number;        ///< of the line, from 1
    cli_view_command command;
} cli_view_script_line;

typedef struct cli_view_script {
    const char *path; ///< borrowed
    cli_view_script_line *line;
    size_t line_count;
} cli_view_script;

/// Prints on standard error which line is wrong, and why. @param script to be freed even after an error
bool cli_read_view_script(const char *path, cli_view_script *script);
void cli_free_view_script(cli_view_script *script);

/// Whether the script does more than to move the camera or an object.
bool cli_view_script_needs_light(const cli_view_script *script);

/// Frames until the last command has been carried out.
uint32_t cli_view_script_length(const cli_view_script *script);

#endif
