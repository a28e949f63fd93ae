#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { bar_width = 32 };

/// Redrawing faster than the eye reads costs time in the terminal.
static const double redraw_interval = 0.1;
/// Without a terminal: work shorter than this stays silent, longer work adds a line this often, and for each new phase
/// that comes no sooner than this after the last line.
static const double quiet_period = 2.0, line_interval = 10.0, phase_interval = 1.0;

double cli_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void cli_progress_begin(cli_progress *progress)
{
    *progress = (cli_progress){ .terminal = isatty(STDERR_FILENO) };
    progress->work_started = cli_seconds();
}

/// "12 s", "3 min 20 s", "2 h 5 min"
static void format_duration(double seconds, char *text, size_t size)
{
    long whole = lround(fmin(seconds, 1e8));
    if (whole < 60)
        snprintf(text, size, "%ld s", whole);
    else if (whole < 3600)
        snprintf(text, size, "%ld min %ld s", whole / 60, whole % 60);
    else
        snprintf(text, size, "%ld h %ld min", whole / 3600, whole / 60 % 60);
}

/// ", 12 s left", or nothing while too little is known.
static void format_eta(
    const cli_progress *progress, double now, double fraction, char *text, size_t size)
{
    double elapsed = now - progress->phase_started;
    text[0] = '\0';
    if (fraction <= 0.01 || elapsed < 0.3) return;
    char duration[32];
    format_duration(elapsed * (1 - fraction) / fraction, duration, sizeof duration);
    snprintf(text, size, ", %s left", duration);
}

static void draw_bar(const cli_progress *progress, double fraction, const char *eta)
{
    static const char full[] = "################################",
                      empty[] = "................................";
    int filled = (int)(fraction * bar_width);
    fprintf(stderr, "\r%-17s [%.*s%.*s] %3.0f %%%s\033[K", progress->phase, filled, full,
        bar_width - filled, empty, 100 * fraction, eta);
    fflush(stderr);
}

void cli_progress_update(cli_progress *progress, const char *phase, double fraction)
{
    if (progress->muted) return;
    double now = cli_seconds();
    bool new_phase = strncmp(progress->phase, phase, sizeof progress->phase - 1) != 0;
    if (new_phase) {
        snprintf(progress->phase, sizeof progress->phase, "%s", phase);
        progress->phase_started = now;
    }
    double interval = new_phase ? 0 : redraw_interval;
    if (!progress->terminal) interval = new_phase ? phase_interval : line_interval;
    if (!progress->terminal && now - progress->work_started < quiet_period) return;
    if (now - progress->last_shown < interval) return;
    progress->last_shown = now;
    char eta[64];
    fraction = fmin(fmax(fraction, 0), 1);
    format_eta(progress, now, fraction, eta, sizeof eta);
    if (progress->terminal) {
        draw_bar(progress, fraction, eta);
        progress->bar_shown = true;
    } else {
        fprintf(stderr, "%s: %.0f %%%s\n", progress->phase, 100 * fraction, eta);
    }
}

void cli_progress_clear(cli_progress *progress)
{
    if (!progress->bar_shown) return;
    fputs("\r\033[K", stderr);
    fflush(stderr);
    progress->bar_shown = false;
}
