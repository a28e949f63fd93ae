/// The keys: each stands for a command.
#ifndef CLI_VIEW_KEYS_H
#define CLI_VIEW_KEYS_H

#include <stddef.h>

typedef struct cli_view_key {
    const char *key;     ///< SDL's name, after "Shift+" if that has to be held
    const char *command; ///< NULL = no key: listed in the help only
    const char *help;    ///< NULL = not listed in the help
} cli_view_key;

extern const cli_view_key cli_view_keys[];
extern const size_t cli_view_key_count;

#endif
