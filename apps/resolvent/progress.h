/// Progress of long work on standard error: a bar with an ETA on a terminal, plain lines elsewhere.
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include <stdbool.h>

typedef struct cli_progress {
    bool terminal;
    bool bar_shown;
    bool muted; ///< shows nothing
    char phase[32];
    double work_started; ///< seconds, cli_seconds()
    double phase_started;
    double last_shown;
} cli_progress;

void cli_progress_begin(cli_progress *progress);

/// Shows that `fraction` of `phase` is done; cheap enough to be called often.
void cli_progress_update(cli_progress *progress, const char *phase, double fraction);

/// Takes the bar off the terminal, so that another line can be printed.
void cli_progress_clear(cli_progress *progress);

/// Seconds on a monotonic clock.
double cli_seconds(void);

#endif
