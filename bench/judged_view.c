#include "judged_view.h"

#include "camera_flight.h"
#include "flown_frames.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>

/// Seeds of references, unlike those of the pictures that they judge.
enum { judge_seed = 1000, second_view_frame = 24, timed_samples = 4 };

cli_cost cli_cost_now(void) { return (cli_cost){ cli_seconds(), cli_processor_seconds() }; }

cli_cost cli_cost_since(cli_cost then)
{
    cli_cost now = cli_cost_now();
    return (cli_cost){ now.seconds - then.seconds, now.cpu_seconds - then.cpu_seconds };
}

rsv_render_desc cli_describe_view(const cli_judged_view *view, uint32_t samples)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = view->size.width;
    desc.height = view->size.height;
    desc.samples = samples;
    desc.viewpoint = &view->camera;
    desc.mode = RSV_RENDER_FINAL;
    return desc;
}

/// A picture of mode reference, and how long a sample of each pixel takes.
static rsv_status render_reference(const rsv_scene *scene, cli_judged_view *view, uint32_t seed,
    uint32_t samples, rsv_image **image)
{
    rsv_render_desc desc = cli_describe_view(view, samples);
    desc.mode = RSV_RENDER_REFERENCE;
    desc.seed = seed;
    cli_cost started = cli_cost_now();
    rsv_status status = rsv_render_reference(scene, &desc, image, NULL);
    cli_cost cost = cli_cost_since(started);
    view->pass_seconds = cost.cpu_seconds / samples;
    view->pass_clock = cost.seconds / samples;
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    return status;
}

/// Where a reference is kept. @return false = nowhere
static bool path_of_half(const cli_bench_task *bench, const char *name, const cli_judged_view *view,
    uint32_t seed, char path[PATH_MAX])
{
    return bench->cache &&
           snprintf(path, PATH_MAX, "%s/%s-reference-%ux%u-%uspp-%u.exr", bench->cache, name,
               view->size.width, view->size.height, view->samples, seed) < PATH_MAX;
}

/// From the folder of references, where it is there; into it, if not.
static rsv_status get_half(const cli_bench_task *bench, const rsv_scene *scene, const char *name,
    cli_judged_view *view, int half)
{
    char path[PATH_MAX];
    uint32_t seed = judge_seed + view->seed + (uint32_t)half;
    bool is_kept = path_of_half(bench, name, view, seed, path);
    if (is_kept && access(path, R_OK) == 0)
        return rsv_image_read(rsv_scene_get_context(scene), path, &view->half[half]);
    rsv_status status = render_reference(scene, view, seed, view->samples, &view->half[half]);
    if (status == RSV_OK && is_kept) status = rsv_image_write(view->half[half], path, 0);
    return status;
}

/// As many samples as are asked for, or as there is time for. References that exist already take no time.
static void choose_samples(
    const cli_bench_task *bench, const char *name, double seconds, cli_judged_view *view)
{
    char path[PATH_MAX];
    view->samples = bench->reference_samples;
    bool is_kept = path_of_half(bench, name, view, judge_seed + view->seed, path);
    if (is_kept && access(path, R_OK) == 0) return;
    double most = seconds / (2 * view->pass_clock);
    if (most < view->samples) view->samples = (uint32_t)fmax(most, timed_samples);
}

/// Mode reference takes its time in this run, whether its pictures are known or not.
static rsv_status time_reference(const rsv_scene *scene, cli_judged_view *view)
{
    rsv_image *image = NULL;
    rsv_status status = render_reference(scene, view, judge_seed, timed_samples, &image);
    rsv_image_destroy(image);
    return status;
}

/// Variance from the difference of the two references.
static rsv_status find_variance(cli_judged_view *view)
{
    static const uint32_t layers[2] = { 0 };
    const rsv_image *const half[2] = { view->half[0], view->half[1] };
    rsv_image_judgement own;
    rsv_status status = rsv_image_judge(half, layers, half[0], 0, &own);
    if (status == RSV_OK) view->variance = own.reference_mse * 2 * view->samples;
    return status;
}

/// @param seconds that its references may take
static rsv_status fill_view(const cli_bench_task *bench, const rsv_scene *scene, const char *name,
    double seconds, cli_judged_view *view)
{
    rsv_status status = time_reference(scene, view);
    if (status == RSV_OK) choose_samples(bench, name, seconds, view);
    for (int half = 0; half < 2 && status == RSV_OK; half++)
        status = get_half(bench, scene, name, view, half);
    return status == RSV_OK ? find_variance(view) : status;
}

rsv_status cli_judged_views_create(const cli_bench_task *bench, const rsv_scene *scene,
    const char *name, double seconds, cli_judged_view *view)
{
    cli_flight flight;
    rsv_status status = cli_flight_plan(scene, &flight);
    for (uint32_t v = 0; v < 2; v++)
        view[v] = (cli_judged_view){ .size = bench->frame_size, .seed = 2 * v };
    if (status != RSV_OK) return status;
    view[0].camera = cli_flight_camera(&flight, 0);
    view[1].camera = flight.station_count > 1 ? flight.station[1].camera
                                              : cli_flight_camera(&flight, second_view_frame);
    for (uint32_t v = 0; v < 2 && status == RSV_OK; v++)
        status = fill_view(bench, scene, name, seconds / 2, &view[v]);
    return status;
}

void cli_judged_views_destroy(cli_judged_view *view)
{
    for (uint32_t v = 0; v < 2; v++)
        for (uint32_t k = 0; k < 2; k++)
            rsv_image_destroy(view[v].half[k]);
}

rsv_status cli_take_view(
    const cli_judged_view *view, const rsv_light *light, uint32_t samples, rsv_image **image)
{
    rsv_render_desc desc = cli_describe_view(view, samples);
    return rsv_render(light, &desc, image);
}

rsv_status cli_judge_view(const cli_judged_view *view, const rsv_image *image, double *error)
{
    static const uint32_t layers[2] = { 0 };
    const rsv_image *const half[2] = { view->half[0], view->half[1] };
    rsv_image_judgement judgement;
    rsv_status status = rsv_image_judge(half, layers, image, 0, &judgement);
    if (status == RSV_OK) *error = fmax(judgement.relative_mse, judgement.relative_mse_error);
    return status;
}

double cli_reference_seconds(const cli_judged_view *view, double error)
{
    return view->pass_seconds * fmax(view->variance / error, 1);
}
