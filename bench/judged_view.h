/// Pictures of a view, judged by two of mode `reference`, whose error over time they are compared with.
#ifndef CLI_JUDGED_VIEW_H
#define CLI_JUDGED_VIEW_H

#include "benchmarks.h"

#include "resolvent/render.h"

/// Time that something took.
typedef struct cli_cost {
    double seconds;     ///< by the clock
    double cpu_seconds; ///< of all processors, which others on the machine hardly lengthen
} cli_cost;

cli_cost cli_cost_now(void);
cli_cost cli_cost_since(cli_cost then);

typedef struct cli_judged_view {
    rsv_camera camera;
    cli_size size;
    rsv_image *half[2];  ///< independent pictures of mode reference
    uint32_t samples;    ///< per pixel of each
    uint32_t seed;       ///< of the references, in addition to what all views share
    double variance;     ///< relative MSE of one sample per pixel in that mode
    double pass_seconds; ///< of all processors, for one sample per pixel
    double pass_clock;   ///< likewise, by the clock
} cli_judged_view;

/// The scene's first camera, and another view: its second camera or a place of the benchmarks' flight.
/// @param name of the scene, for files in the task's cache of references
/// @param seconds of wall-clock time that references may take; if that is too short, they have fewer samples than asked
/// for
/// @param view out, [2]; to be destroyed even after an error
rsv_status cli_judged_views_create(const cli_bench_task *bench, const rsv_scene *scene,
    const char *name, double seconds, cli_judged_view *view);
void cli_judged_views_destroy(cli_judged_view *view);

/// A picture of mode final.
rsv_render_desc cli_describe_view(const cli_judged_view *view, uint32_t samples);
/// Takes it.
rsv_status cli_take_view(
    const cli_judged_view *view, const rsv_light *light, uint32_t samples, rsv_image **image);

/// @param error out: relative MSE, no less than its standard error
rsv_status cli_judge_view(const cli_judged_view *view, const rsv_image *image, double *error);

/// Seconds of all processors that mode reference takes to a relative MSE, which falls with one over the samples.
double cli_reference_seconds(const cli_judged_view *view, double error);

#endif
