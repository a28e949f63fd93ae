/// What keys do: each stands for a command.
#ifndef CLI_VIEW_KEYS_H
#define CLI_VIEW_KEYS_H

#include <stddef.h>

typedef struct cli_view_key {
    const char *key;     ///< as SDL names it; "Shift+" before it where that is to be held
    const char *command; ///< NULL = not of the keyboard: for the help alone
    const char *help;    ///< NULL = goes without saying
} cli_view_key;

extern const cli_view_key cli_view_keys[];
extern const size_t cli_view_key_count;

#endif
