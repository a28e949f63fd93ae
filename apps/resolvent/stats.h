/// The JSON file of --stats: what was done, how long it took, how accurate it is.
#ifndef CLI_STATS_H
#define CLI_STATS_H

#include "session.h"

#include "resolvent/certify.h"
#include "resolvent/plan.h"

struct cJSON;

/// Figures of a run. Those that it does not have (there is no operator in mode reference) are NAN or 0, and
/// appear as null.
typedef struct cli_stats {
    const char *command, *scene, *mode;
    rsv_quality quality;
    uint32_t width, height, samples; ///< 0 = not a picture
    uint32_t threads, seed;
    const rsv_solve_report *report;     ///< NULL = nothing was solved
    const rsv_certificate *certificate; ///< NULL = nothing was solved, or a plan has estimates of its own
    const rsv_goal_certificate *goal;   ///< NULL = there was none
    const rsv_error_split *split;       ///< NULL = there was none
    bool is_planned;                    ///< by `plan`, not by a quality
    rsv_picture_plan plan;
    uint32_t order_count;
    double standard_error; ///< of the picture's mean, relative; NAN = unknown
    double time_solve;     ///< seconds; 0 = take it from the report
    double time_render;
    const float *exposure; ///< stops of .png; NULL = there is none
    /// More members of the file, which take them over; NULL = none.
    struct cJSON *more;
} cli_stats;

/// Names of the qualities, in the order of rsv_quality; NULL-terminated.
extern const char *const cli_quality_names[];

/// Computes the short certificate of a solution, if `path` is not NULL.
rsv_status cli_certify_briefly(
    const char *path, const rsv_light *solution, uint32_t seed, rsv_certificate *certificate);

/// Prints errors on standard error.
bool cli_write_stats(const char *path, const cli_session *session, const cli_stats *stats);

#endif
