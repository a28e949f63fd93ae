/// Progress of a command on standard error: one bar with the time left on a terminal, plain lines elsewhere. The
/// library reports phases, each from 0 to 1, but not how many will come. Each phase gets a share of the rest of the bar
/// that depends on its kind, so the bar only moves forward.
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include <stdbool.h>

typedef struct cli_progress {
    bool terminal;
    bool bar_shown;
    bool muted; ///< shows nothing
    char phase[32];
    char part[32];       ///< "frame 3 of 12: ", or nothing
    double part_begin;   ///< share of all the work that was done when the part began
    double part_share;   ///< of all the work
    double phase_begin;  ///< of the part's, when the phase began
    double phase_share;  ///< of the part's
    double reached;      ///< of the phase
    double done;         ///< share of all the work
    double total;        ///< seconds that the work will have taken, as guessed so far; 0 = no guess
    double work_started; ///< seconds, cli_seconds()
    double first_started; ///< seconds, of the first phase; 0 = none has begun
    double phase_started; ///< seconds, of the phase
    double last_shown;
    int printed_percent; ///< of the last plain line; -1 = there is none
} cli_progress;

void cli_progress_begin(cli_progress *progress);

/// Begins one of `count` equal parts of the command. @param name such as "frame" @param number counts from 1; 0 = the
/// work before the first part, which counts as a part too
void cli_progress_part(cli_progress *progress, const char *name, unsigned number, unsigned count);

/// Notes that `fraction` of `phase` is done, and updates the bar. Cheap enough to be called often.
void cli_progress_update(cli_progress *progress, const char *phase, double fraction);

/// The same at a given time. @param now seconds of the clock of cli_seconds()
void cli_progress_update_at(cli_progress *progress, const char *phase, double fraction, double now);

/// Takes the bar off the terminal, so that another line can be printed.
void cli_progress_clear(cli_progress *progress);

/// Seconds on a monotonic clock.
double cli_seconds(void);

#endif
