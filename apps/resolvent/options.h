/// Command-line options: a table per command, long names, `--name value` and `--name=value`.
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include "resolvent/core.h"

#define CLI_LIST_CAPACITY 256

/// Values of an option that may be given more than once.
typedef struct cli_list {
    const char *item[CLI_LIST_CAPACITY];
    size_t count;
} cli_list;

typedef struct cli_size {
    uint32_t width, height; ///< 0 x 0 = not given
} cli_size;

typedef enum cli_option_kind {
    CLI_FLAG,   ///< bool *; takes no value
    CLI_TEXT,   ///< const char **
    CLI_LIST,   ///< cli_list *
    CLI_COUNT,  ///< uint32_t *, in [min, max]
    CLI_REAL,   ///< float *, in [min, max]
    CLI_SHARE,  ///< float *, in [min, max]: 0.01 or 1%
    CLI_CHOICE, ///< int *: index of the value among `choices`
    CLI_BYTES,  ///< size_t *: 300MiB, 2GiB, 1.5GB, ...
    CLI_SIZE,   ///< cli_size *: WIDTHxHEIGHT, each in [min, max]
    CLI_SIDES   ///< the same, or one number for both
} cli_option_kind;

typedef struct cli_option {
    const char *name; ///< with its dashes
    cli_option_kind kind;
    void *value; ///< variable that the option sets; holds the default before
    double min, max;
    const char *const *choices; ///< NULL-terminated
    /// An option without which this one does nothing, or one of its choices: "--goal", "--to=vertex"; NULL = none
    const char *goes_with;
} cli_option;

typedef struct cli_usage {
    const char *command;       ///< "render", as in `resolvent render --help`
    const char *help;          ///< of --help all; {--name} becomes the choices of that option
    const cli_option *options; ///< ends with a NULL name; 64 at most
    const char *operands;      ///< names of the positional arguments, for messages: "SCENE"
    size_t operand_min, operand_max;
    const char *common; ///< options that --help explains, separated by spaces; NULL = all
} cli_usage;

/// Parses options and operands.
/// @param operands [usage->operand_max]; operands not given become NULL
/// @param exit_status if the result is false, the status to exit with: 0 after --help, 2 after a mistake
/// @return whether to go on
bool cli_parse(
    const cli_usage *usage, int argc, char **argv, const char **operands, int *exit_status);

/// Prints one line with a hint at --help; returns the exit status for bad usage.
/// @param command NULL = the program itself
int cli_usage_error(const char *command, const char *format, ...) RSV_PRINTF(2, 3);

/// Says that `name` is not, say, "an option", and which of the candidates it resembles.
int cli_unknown_name(const char *command, const char *name, const char *kind,
    const char *const *candidates, size_t count);

#endif
