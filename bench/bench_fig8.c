/// Figure 8 of the paper: frames per second over the size of a mesh, with the solved light and with ambient occlusion.
#include "bars.h"
#include "bench_gpu.h"
#include "device.h"

#include "resolvent/frame.h"
#include "resolvent/measure.h"
#include "resolvent/render.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { mesh_count = 4, few = 3 };

static const unsigned mesh_kilobytes[mesh_count] = { 128, 512, 1024, 3096 };

/// Of a closed mesh: three indices, and half a vertex with its normal, at four bytes a number.
static const double bytes_per_triangle = 3 * 4 + 0.5 * 6 * 4;

/// The competitors on one mesh.
typedef struct contest {
    uint32_t width, height; ///< pixels
    rsv_scene *scene;
    rsv_light *solution;
    rsv_frame_renderer *frames;
    rsv_occlusion *by_rays, *on_screen;
    rsv_occlusion *faster; ///< of the two
    double by_rays_s, on_screen_s;
    rsv_image *picture;
    double *frame_s, *occlusion_s, *speed_up; ///< [repetitions]
} contest;

/// The camera moves a little from frame to frame.
static rsv_camera camera_at(const rsv_scene *scene, uint32_t index)
{
    rsv_camera camera = rsv_scene_get_view(scene)->camera[0];
    camera.position.x += 0.02f * sinf(0.1f * (float)(index + 1));
    return camera;
}

static double time_frame(const contest *c, uint32_t index)
{
    rsv_frame_view view = { .camera = { camera_at(c->scene, index) } };
    rsv_frame_stats stats;
    return rsv_frame_render(c->frames, &view, &stats) == RSV_OK ? 1e-3 * stats.total_ms : NAN;
}

/// With the scene in the caches.
static double time_warm_frame(const contest *c, uint32_t index)
{
    time_frame(c, index);
    return time_frame(c, index);
}

/// As for frames, until the picture lies where it was made.
static double time_occlusion(const contest *c, rsv_occlusion *occlusion, uint32_t index)
{
    rsv_camera camera = camera_at(c->scene, index);
    rsv_status status = rsv_occlusion_render(occlusion, &camera, c->picture);
    return status == RSV_OK ? rsv_occlusion_seconds(occlusion) : NAN;
}

static double median_occlusion(const contest *c, rsv_occlusion *occlusion)
{
    double seconds[few];
    for (uint32_t k = 0; k < few; k++)
        seconds[k] = time_occlusion(c, occlusion, k);
    return cli_median(seconds, few);
}

static void find_faster(contest *c)
{
    c->by_rays_s = median_occlusion(c, c->by_rays);
    c->on_screen_s = median_occlusion(c, c->on_screen);
    c->faster = c->on_screen_s < c->by_rays_s ? c->on_screen : c->by_rays;
}

/// Runs all contestants in alternation, so that other load on the machine affects all alike.
/// @param first_to_last [repetitions] frames per second of the last mesh : of the first
static void hold(contest *contests, uint32_t repetitions, double *first_to_last)
{
    for (uint32_t k = 0; k < repetitions && !cli_interrupted(); k++) {
        for (int mesh = 0; mesh < mesh_count; mesh++) {
            contest *c = &contests[mesh];
            c->frame_s[k] = time_frame(c, k);
            c->occlusion_s[k] = time_occlusion(c, c->faster, k);
            c->speed_up[k] = c->occlusion_s[k] / c->frame_s[k];
        }
        double last = time_warm_frame(&contests[mesh_count - 1], k);
        first_to_last[k] = time_warm_frame(&contests[0], k) / last;
    }
}

static void add_row(const contest *c, unsigned kilobytes, uint32_t repetitions, cJSON *row)
{
    char name[16];
    snprintf(name, sizeof name, "%u KB", kilobytes);
    cJSON_AddStringToObject(row, "scene", name);
    cJSON_AddNumberToObject(row, "triangles", (double)rsv_scene_get_view(c->scene)->triangle_count);
    cJSON_AddStringToObject(
        row, "occlusion", c->faster == c->on_screen ? "from the depth buffer" : "by rays");
    cJSON_AddNumberToObject(row, "fps_occlusion_rays", 1 / c->by_rays_s);
    cJSON_AddNumberToObject(row, "fps_occlusion_screen", 1 / c->on_screen_s);
    cJSON_AddNumberToObject(row, "fps", 1 / cli_median(c->frame_s, repetitions));
    cJSON_AddNumberToObject(row, "fps_occlusion", 1 / cli_median(c->occlusion_s, repetitions));
    cJSON_AddNumberToObject(row, "speed_up", cli_median(c->speed_up, repetitions));
}

static rsv_status create_occlusion(
    const contest *c, rsv_render_mode mode, rsv_occlusion **occlusion)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.width = c->width;
    desc.height = c->height;
    desc.samples = 1;
    return rsv_occlusion_create(c->scene, &desc, occlusion);
}

/// A twentieth of that a side on the emulated device.
static void choose_size(contest *c, uint32_t rows)
{
    c->height = cli_device_is_emulated() ? (rows + 19) / 20 : rows;
    c->width = (16 * c->height + 8) / 9;
}

static rsv_status open_contest(const cli_bench_task *bench, unsigned kilobytes, contest *c)
{
    rsv_context *context = bench->session->context;
    rsv_builtin_desc body = rsv_default_builtin_desc();
    rsv_solve_desc desc = cli_bench_solve_desc(bench, RSV_QUALITY_DRAFT);
    rsv_frame_desc frame = rsv_default_frame_desc();
    choose_size(c, bench->size);
    frame.width = c->width;
    frame.height = c->height;
    body.body_triangles = (size_t)(1024 * kilobytes / bytes_per_triangle);
    c->frame_s = calloc(3 * bench->repetitions, sizeof(double));
    if (!c->frame_s) return RSV_ERROR_MEMORY;
    c->occlusion_s = c->frame_s + bench->repetitions;
    c->speed_up = c->occlusion_s + bench->repetitions;
    rsv_status status = rsv_scene_builtin_with(context, bench->scene, &body, &c->scene);
    if (!status) status = rsv_light_create(c->scene, &desc, &c->solution);
    if (!status) status = rsv_frame_renderer_create(c->solution, &frame, &c->frames);
    if (!status) status = create_occlusion(c, RSV_RENDER_OCCLUSION, &c->by_rays);
    if (!status) status = create_occlusion(c, RSV_RENDER_OCCLUSION_SCREEN, &c->on_screen);
    if (!status) status = rsv_image_create(context, c->width, c->height, 1, &c->picture);
    if (!status) find_faster(c);
    if (!status) time_frame(c, 0); // the first one brings the light
    return status;
}

static void close_contest(contest *c)
{
    rsv_frame_renderer_destroy(c->frames);
    rsv_occlusion_destroy(c->by_rays);
    rsv_occlusion_destroy(c->on_screen);
    rsv_image_destroy(c->picture);
    rsv_light_destroy(c->solution);
    rsv_scene_destroy(c->scene);
    free(c->frame_s);
}

static rsv_status measure(const cli_bench_task *bench, contest *contests, cJSON *result)
{
    double *first_to_last = calloc(bench->repetitions, sizeof *first_to_last);
    if (cli_device()) cli_describe_device(result);
    rsv_status status = first_to_last ? RSV_OK : RSV_ERROR_MEMORY;
    for (int k = 0; k < mesh_count && !status; k++)
        status = open_contest(bench, mesh_kilobytes[k], &contests[k]);
    if (!status) hold(contests, bench->repetitions, first_to_last);
    if (!status && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    cJSON *meshes = cJSON_AddArrayToObject(result, "meshes");
    for (int k = 0; k < mesh_count && !status; k++) {
        cJSON *row = cJSON_CreateObject();
        cJSON_AddItemToArray(meshes, row);
        add_row(&contests[k], mesh_kilobytes[k], bench->repetitions, row);
    }
    if (!status) {
        cJSON_AddNumberToObject(result, "width", contests[0].width);
        cJSON_AddNumberToObject(result, "height", contests[0].height);
        cJSON_AddNumberToObject(
            result, "fps_largest_to_smallest", cli_median(first_to_last, bench->repetitions));
    }
    free(first_to_last);
    return status;
}

bool cli_bench_fig8(const cli_bench_task *bench, cJSON *result)
{
    contest contests[mesh_count] = { 0 };
    rsv_status status = measure(bench, contests, result);
    for (int k = 0; k < mesh_count; k++)
        close_contest(&contests[k]);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_fig8(const cJSON *result)
{
    const cJSON *row, *device = cJSON_GetObjectItem(result, "device");
    if (device)
        printf(
            "\nFrames per second on %s", cJSON_GetStringValue(cJSON_GetObjectItem(device, "name")));
    else
        printf("\nFrames per second");
    printf(
        " at %.0fx%.0f\n\n", cli_json_number(result, "width"), cli_json_number(result, "height"));
    printf("| mesh | triangles | solved light | ambient occlusion | speed-up | by rays "
           "| from the depth buffer |\n|---|---|---|---|---|---|---|\n");
    cJSON_ArrayForEach(row, cJSON_GetObjectItem(result, "meshes"))
    {
        printf("| %s | %.0f | %.1f | %.1f | %.2f | %.1f | %.1f |\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(row, "scene")),
            cli_json_number(row, "triangles"), cli_json_number(row, "fps"),
            cli_json_number(row, "fps_occlusion"), cli_json_number(row, "speed_up"),
            cli_json_number(row, "fps_occlusion_rays"),
            cli_json_number(row, "fps_occlusion_screen"));
    }
    printf("\nFrames per second of the largest mesh : of the smallest: %.2f\n\n",
        cli_json_number(result, "fps_largest_to_smallest"));
}

static const cJSON *meshes_of(const cJSON *scenes)
{
    return cJSON_GetObjectItem(cJSON_GetArrayItem(scenes, 0), "meshes");
}

bool cli_write_fig8_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "triangles", "fps", "fps_occlusion", "speed_up",
        "fps_occlusion_rays", "fps_occlusion_screen" };
    return cli_write_columns(path, meshes_of(scenes), columns, sizeof columns / sizeof columns[0]);
}

bool cli_write_fig8_plot(const char *path, const cJSON *scenes)
{
    const cJSON *result = cJSON_GetArrayItem(scenes, 0);
    char title[64];
    snprintf(title, sizeof title, "frames per second at %.0fx%.0f, by size of the mesh",
        cli_json_number(result, "width"), cli_json_number(result, "height"));
    cli_bars bars = {
        .title = title, .series = { "solved light", "ambient occlusion" }, .scale = 1
    };
    char note[mesh_count][32];
    const cJSON *row;
    cJSON_ArrayForEach(row, meshes_of(scenes))
    {
        char *text = note[bars.group_count];
        cli_bar_group *group = &bars.group[bars.group_count++];
        snprintf(text, sizeof note[0], "%.2f times as fast", cli_json_number(row, "speed_up"));
        group->name = cJSON_GetStringValue(cJSON_GetObjectItem(row, "scene"));
        group->note = text;
        group->value[0] = cli_json_number(row, "fps");
        group->value[1] = cli_json_number(row, "fps_occlusion");
    }
    return cli_write_bars(path, &bars);
}
