/// What `--help` and `--help all` print.
#ifndef CLI_HELP_H
#define CLI_HELP_H

#include "options.h"

/// Prints the help of a command. In it, {--name} becomes the choices of that option.
/// @param all false = what the command does, three examples and the common options alone
void cli_print_help(const cli_usage *usage, bool all);

#endif
