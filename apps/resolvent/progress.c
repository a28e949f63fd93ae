#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { bar_width = 32 };

/// Redrawing faster than the eye reads costs time in the terminal.
static const double redraw_interval = 0.1;
/// Without a terminal: work shorter than this stays silent, longer work adds a line this often.
static const double quiet_period = 2.0, line_interval = 10.0;
/// The time left is worth saying once so much is done, and so long it took.
static const double least_done = 0.08, least_seconds = 1.0;

double cli_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void cli_progress_begin(cli_progress *progress)
{
    *progress = (cli_progress){ .terminal = isatty(STDERR_FILENO), .printed_percent = -1 };
    progress->work_started = cli_seconds();
    progress->part_share = 1;
}

void cli_progress_part(cli_progress *progress, const char *name, unsigned number, unsigned count)
{
    if (number > 0)
        snprintf(progress->part, sizeof progress->part, "%s %u of %u: ", name, number, count);
    progress->part_begin = (double)number / (count + 1);
    progress->part_share = 1.0 / (count + 1);
    progress->phase_begin = progress->phase_share = 0;
    progress->phase[0] = '\0';
}

static bool begins_with(const char *phase, const char *word)
{
    return strncmp(phase, word, strlen(word)) == 0;
}

/// Typical share of the remaining work that a phase takes, measured over solves and renders.
static double share_of_rest(const char *phase)
{
    static const struct {
        const char *begin;
        double share;
    } known[] = { { "pilot", 0.05 }, { "goal", 0.05 }, { "assemble", 0.35 }, { "direct", 0.2 },
        { "level", 0.08 }, { "caustics", 0.2 }, { "divide", 0.1 }, { "weights", 0.1 },
        { "subsurface", 0.2 }, { "spectrum", 0.3 }, { "solve", 0.3 }, { "trial", 0.15 },
        { "pass", 0.8 } };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (begins_with(phase, known[k].begin)) return known[k].share;
    return 0.95; // pictures, readings and bakes come last
}

/// Counts everything before a new phase as done, except phases that were only announced.
static void begin_phase(cli_progress *progress, const char *phase, double now)
{
    size_t length = strlen(progress->phase), tail = strlen("assemble");
    bool announced = length >= tail && progress->reached < 0.02 &&
                     strcmp(progress->phase + length - tail, "assemble") == 0;
    if (!announced) progress->phase_begin += progress->phase_share;
    progress->reached = 0;
    progress->phase_share = (1 - progress->phase_begin) * share_of_rest(phase);
    progress->phase_started = now;
    snprintf(progress->phase, sizeof progress->phase, "%s", phase);
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

/// Share of all the work that was done, or will be, when the phase has reached `fraction`.
static double share_at(const cli_progress *progress, double fraction)
{
    double of_part = fmin(progress->phase_begin + progress->phase_share * fraction, 1);
    return progress->part_begin + progress->part_share * of_part;
}

/// Seconds that all the work will have taken: guesses differ, the more the earlier, and are averaged over a second. The
/// phase goes on at its own speed, not at that of earlier ones, which may have taken far more or less than their share.
static void guess_total(cli_progress *progress, double now, double elapsed)
{
    if (progress->done < least_done || elapsed < least_seconds || progress->reached <= 0) return;
    double in_phase = now - progress->phase_started,
           to_come = in_phase / progress->reached - in_phase;
    double guess = (elapsed + to_come) / share_at(progress, 1),
           weight = exp(progress->last_shown - now);
    progress->total = progress->total > 0 ? weight * progress->total + (1 - weight) * guess : guess;
}

/// ", 12 s left", or nothing while too little is known.
static void format_eta(const cli_progress *progress, double elapsed, char *text, size_t size)
{
    char duration[32];
    text[0] = '\0';
    if (progress->total <= 0 || progress->done >= 1) return;
    format_duration(fmax(progress->total - elapsed, 0), duration, sizeof duration);
    snprintf(text, size, ", %s left", duration);
}

static void draw_bar(const cli_progress *progress, const char *eta)
{
    static const char full[] = "################################",
                      empty[] = "................................";
    int filled = (int)(progress->done * bar_width);
    fprintf(stderr, "\r[%.*s%.*s] %3.0f %%%s  %s%s\033[K", filled, full, bar_width - filled, empty,
        floor(100 * progress->done), eta, progress->part, progress->phase);
    fflush(stderr);
}

static void show(cli_progress *progress, double now)
{
    char eta[64];
    double elapsed = now - progress->first_started;
    guess_total(progress, now, elapsed);
    format_eta(progress, elapsed, eta, sizeof eta);
    progress->last_shown = now;
    if (progress->terminal) {
        draw_bar(progress, eta);
        progress->bar_shown = true;
        return;
    }
    int percent = (int)floor(100 * progress->done);
    if (percent == progress->printed_percent) return; // a log needs no line twice
    fprintf(stderr, "%s%s: %d %%%s\n", progress->part, progress->phase, percent, eta);
    progress->printed_percent = percent;
}

void cli_progress_update(cli_progress *progress, const char *phase, double fraction)
{
    cli_progress_update_at(progress, phase, fraction, cli_seconds());
}

void cli_progress_update_at(cli_progress *progress, const char *phase, double fraction, double now)
{
    if (progress->muted) return;
    if (progress->first_started == 0) progress->first_started = now;
    if (strncmp(progress->phase, phase, sizeof progress->phase - 1) != 0)
        begin_phase(progress, phase, now);
    fraction = fmin(fmax(fraction, 0), 1);
    progress->reached = fmax(progress->reached, fraction);
    progress->done = fmax(progress->done, share_at(progress, fraction));
    if (!progress->terminal && now - progress->work_started < quiet_period) return;
    if (now - progress->last_shown < (progress->terminal ? redraw_interval : line_interval)) return;
    show(progress, now);
}

void cli_progress_clear(cli_progress *progress)
{
    if (!progress->bar_shown) return;
    fputs("\r\033[K", stderr);
    fflush(stderr);
    progress->bar_shown = false;
}
