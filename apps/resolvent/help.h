/// Prints the texts of `--help` and `--help all`.
#ifndef CLI_HELP_H
#define CLI_HELP_H

#include "options.h"

/// Prints the help of a command. In its text, {--name} is replaced by the choices of that option.
/// @param all false = only what the command does, three examples and the common options
void cli_print_help(const cli_usage *usage, bool all);

#endif
