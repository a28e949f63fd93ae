#include "command.h"
#include "crew.h"
#include "device.h"
#include "error_target.h"
#include "exposure.h"
#include "frame_path.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "photometry.h"
#include "sequence.h"
#include "stats.h"
#include "subject.h"

#include "resolvent/frame.h"
#include "resolvent/plan.h"
#include "resolvent/update.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: resolvent render SCENE -o OUT.{exr,png,hdr} [options]\n"
    "\n"
    "Solves the light of SCENE and renders a picture. SCENE is a file, a built-in scene, or a file from\n"
    "`resolvent solve`, which is not solved again. .exr and .hdr hold linear radiance; .png is sRGB. By\n"
    "default, the number of elements, rays and samples is chosen for a relative error of 7 %.\n"
    "\n"
    "  -o FILE            the picture; repeat it for more formats\n"
    "  --size WxH         pixels (default: 512 on the longer side, with the camera's aspect ratio)\n"
    "  --mode MODE        final      direct light per pixel, all other light from the solution (default)\n"
    "                     operator   all light from the solution: the real-time path\n"
    "                     reference  unbiased path tracer; slow, to check the others\n"
    "                     occlusion  baseline: ray-traced ambient occlusion times albedo\n"
    "                     occlusion-screen  the same from the depth buffer, as in games\n"
    "  --occlusion-distance M  modes occlusion: surfaces farther than M metres do not occlude\n"
    "  --spp N            camera rays per pixel (default: planned, or by quality 4, 9, 16; reference 64)\n"
    "  --noise P%         final, operator: up to 64 times as many rays where a pixel's noise exceeds P;\n"
    "                     0 = the same number everywhere (default: 0; for final without --spp, by\n"
    "                     quality 0, 20 %, 10 %)\n" CLI_MESH_HELP CLI_READING_HELP CLI_MOMENT_HELP
        CLI_SEQUENCE_HELP CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_FOG_HEIGHT_HELP CLI_SOLVE_HELP
    "  --camera NAME      a camera listed by `resolvent info SCENE` (default: the first)\n"
    "  --fstop N          depth of field: the aperture's diameter is the focal length / N, for film\n"
    "                     24 mm high (default: everything is sharp)\n"
    "  --focus M          distance in focus, metres (default: that of the middle of the picture)\n"
    "  --shift-x X        shift the film to the right, in picture widths (default 0)\n"
    "  --shift-y Y        shift it upwards, in picture heights (default 0)\n"
    "  --projection P     perspective (default: that of the camera); equirectangular: all around;\n"
    "                     fisheye: the half space ahead, in a circle\n"
    "  --goal             refine the surfaces that this camera sees, directly or through reflected light\n"
    "  --gather N         final: N gather rays per camera ray instead of a lookup (default 0)\n"
    "  --denoise          final: remove noise with a filter that keeps edges and textures but may blur\n"
    "                     faint detail. Default for .png alone, with --quality draft or without options\n"
    "                     for quality\n"
    "  --no-denoise       keep the noise\n"
    "  --gloss KIND       operator: reflections in rough surfaces by paths (default; unbiased), or reused\n"
    "                     among neighbours, as in `view` (fast, slightly biased)\n"
    "  --layers           .exr: one more layer for each order of light: emission, direct, bounce1, ...\n"
    "  --photometric      .exr, .hdr: multiply by 683 lm/W, so that luminance is in cd/m2\n" CLI_EXPOSURE_HELP
    "  --error P%         final: plan the picture for this relative RMS error of pixels, 0.5 % to 100 %\n"
    "                     (default 7 %), and print the plan. With --quality: refine the solution until\n"
    "                     the estimated relative error of its irradiance (with --goal: of the picture's\n"
    "                     mean) is below P percent with 95 % confidence, or a limit is reached\n"
    "  --max-time S       final: the best picture within S seconds, including loading; with --error, stop\n"
    "                     at that error\n"
    "  --threads N        default: one per core; the picture does not depend on it\n" CLI_DEVICE_HELP
    "  --stats FILE.json  what was done, time of each phase, norms and residuals (docs/stats.md)\n"
    "  --certificate      add a short certificate of the solution to --stats (docs/certificate.md); in a\n"
    "                     furnished room, it can take longer than the picture\n"
    "\n"
    "examples:\n"
    "  resolvent render cornell-spheres -o spheres.png\n"
    "  resolvent render room.glb -o room.exr -o room.png --size 1280x720 --quality high\n"
    "  resolvent render model.glb -o model.png --env sky --max-time 10\n"
    "  resolvent render room.glb -o room.exr --error 3%\n"
    "  resolvent render room.glb -o room.exr --quality draft --error 2% --max-time 600\n"
    "  resolvent render walk.glb -o walk-%03d.png --frames 0-47 --fps 24 --mode operator\n"
    "  resolvent render room.glb -o orders.exr --mode operator --layers\n"
    "  resolvent render room.glb -o judge.exr --mode reference --spp 1024 --stats judge.json\n";

static const char *const mode_names[] = { [RSV_RENDER_OPERATOR] = "operator",
    [RSV_RENDER_FINAL] = "final",
    [RSV_RENDER_REFERENCE] = "reference",
    [RSV_RENDER_OCCLUSION] = "occlusion",
    [RSV_RENDER_OCCLUSION_SCREEN] = "occlusion-screen",
    NULL };

static const char *const projection_names[] = { [RSV_PROJECTION_CAMERA] = "perspective",
    [RSV_PROJECTION_EQUIRECTANGULAR] = "equirectangular",
    [RSV_PROJECTION_FISHEYE] = "fisheye",
    NULL };

static const char *const gloss_names[] = {
    [RSV_GLOSS_PATHS] = "paths", [RSV_GLOSS_REUSED] = "reused", NULL
};

typedef struct settings {
    const char *scene, *camera, *stats, *mesh;
    cli_environment environment;
    cli_moment moment;
    cli_sequence sequence;
    cli_reading reading;
    cli_error_target target;
    cli_solve_choice solve;
    cli_list outputs;
    cli_size size;
    int mode, device, gloss;
    uint32_t samples; ///< 0 = by mode and quality
    uint32_t threads, gather_rays;
    float exposure, occlusion_distance;
    float fstop, focus; ///< fstop 0 = a pinhole; focus 0 = what is at the centre of the picture
    float shift[2];     ///< of the film, in widths and heights
    int projection;
    float noise; ///< below 0 = by mode and quality
    bool layers, goal, photometric, certificate, denoise, no_denoise;
    bool planned; ///< elements, rays and samples are chosen by error or time
} settings;

/// Whether no option says how to make the picture, so that a plan decides.
static bool is_planned(const settings *s)
{
    return s->mode == RSV_RENDER_FINAL && s->solve.quality < 0 && !s->samples && s->noise < 0 &&
           !s->gather_rays && !s->goal;
}

/// Whether the picture is to be looked at, and no option asks for exact values: it is filtered then.
static bool is_first_look(const settings *s)
{
    for (size_t k = 0; k < s->outputs.count; k++)
        if (!cli_ends_in(s->outputs.item[k], ".png")) return false;
    bool by_default = s->planned && s->target.share == 0 && s->target.max_seconds == 0;
    bool is_draft = s->solve.quality == RSV_QUALITY_DRAFT && !s->samples && s->noise < 0 &&
                    !s->gather_rays && s->target.share == 0;
    return s->mode == RSV_RENDER_FINAL && (by_default || is_draft) && !s->no_denoise &&
           !s->layers && !s->sequence.frames;
}

/// Refuses options that exclude each other.
static bool check_sequence(settings *s, int *exit_status)
{
    bool at_time = isfinite(s->moment.time), in_sequence = s->sequence.frames != NULL;
    *exit_status = CLI_BAD_USAGE;
    if (s->moment.clip && !at_time && !in_sequence)
        cli_usage_error("render", "--clip requires --time or --frames");
    else if (at_time && in_sequence)
        cli_usage_error("render", "--time and --frames exclude each other; leave out one");
    else if (in_sequence && (s->target.share > 0 || s->target.max_seconds > 0))
        cli_usage_error("render",
            "--error and --max-time are not supported with --frames; choose --quality and "
            "--spp instead");
    else
        return !in_sequence || cli_read_sequence("render", &s->sequence);
    return false;
}

static bool check_units(const settings *s, int *exit_status)
{
    bool light = s->mode != RSV_RENDER_OCCLUSION && s->mode != RSV_RENDER_OCCLUSION_SCREEN;
    bool linear = false;
    for (size_t k = 0; k < s->outputs.count; k++)
        linear = linear || !cli_ends_in(s->outputs.item[k], ".png");
    if (!s->photometric || (light && linear)) return true;
    *exit_status =
        cli_usage_error("render", light ? "--photometric requires .exr or .hdr: .png cannot hold "
                                          "cd/m2"
                                        : "--photometric is not supported by the occlusion modes, "
                                          "which compute no light");
    return false;
}

static bool check_denoise(const settings *s, int *exit_status)
{
    const char *wrong = s->no_denoise                 ? "--no-denoise"
                        : s->mode != RSV_RENDER_FINAL ? "modes other than final"
                        : s->layers                   ? "--layers"
                                                      : NULL;
    if (!s->denoise || !wrong) return true;
    *exit_status = cli_usage_error("render", "--denoise and %s exclude each other", wrong);
    return false;
}

/// Whether the picture is planned, and the quality if it is not.
static bool settle_plan(settings *s, int *exit_status)
{
    s->planned = is_planned(s) && !s->sequence.frames;
    if (s->solve.quality < 0) s->solve.quality = RSV_QUALITY_MEDIUM;
    if (s->planned || s->target.max_seconds == 0 || s->target.share > 0) return true;
    *exit_status = cli_usage_error("render", "--max-time requires --error, except for planned "
                                             "pictures: leave out --mode, "
                                             "--quality, --spp, --noise, --gather and --goal");
    return false;
}

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_LIST, .value = &s->outputs },
        { .name = "--size", .kind = CLI_SIZE, .value = &s->size, .min = 1, .max = 32768 },
        { .name = "--mode", .kind = CLI_CHOICE, .value = &s->mode, .choices = mode_names },
        { .name = "--spp", .kind = CLI_COUNT, .value = &s->samples, .min = 1, .max = 1 << 24 },
        { .name = "--noise", .kind = CLI_SHARE, .value = &s->noise, .min = 0, .max = 1 },
        { .name = "--camera", .kind = CLI_TEXT, .value = &s->camera },
        { .name = "--fstop", .kind = CLI_REAL, .value = &s->fstop, .min = 0.01, .max = 1e6 },
        { .name = "--focus",
            .kind = CLI_REAL,
            .value = &s->focus,
            .min = 1e-6,
            .max = 1e9,
            .goes_with = "--fstop" },
        { .name = "--shift-x", .kind = CLI_REAL, .value = &s->shift[0], .min = -100, .max = 100 },
        { .name = "--shift-y", .kind = CLI_REAL, .value = &s->shift[1], .min = -100, .max = 100 },
        { .name = "--projection",
            .kind = CLI_CHOICE,
            .value = &s->projection,
            .choices = projection_names },
        { .name = "--goal", .kind = CLI_FLAG, .value = &s->goal },
        { .name = "--gather", .kind = CLI_COUNT, .value = &s->gather_rays, .max = 1 << 16 },
        { .name = "--occlusion-distance",
            .kind = CLI_REAL,
            .value = &s->occlusion_distance,
            .max = 1e9 },
        { .name = "--gloss", .kind = CLI_CHOICE, .value = &s->gloss, .choices = gloss_names },
        { .name = "--layers", .kind = CLI_FLAG, .value = &s->layers },
        { .name = "--denoise", .kind = CLI_FLAG, .value = &s->denoise },
        { .name = "--no-denoise", .kind = CLI_FLAG, .value = &s->no_denoise },
        CLI_EXPOSURE_OPTION(&s->exposure),
        { .name = "--photometric", .kind = CLI_FLAG, .value = &s->photometric },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_DEVICE_OPTION(&s->device),
        CLI_MESH_OPTION(&s->mesh),
        { .name = "--time", .kind = CLI_REAL, .value = &s->moment.time, .min = -1e6, .max = 1e6 },
        { .name = "--clip", .kind = CLI_TEXT, .value = &s->moment.clip },
        CLI_SEQUENCE_OPTIONS(&s->sequence),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        CLI_FOG_OPTIONS(&s->environment),
        CLI_FOG_HEIGHT_OPTION(&s->environment),
        CLI_ERROR_TARGET_ALONE(&s->target),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = "--certificate",
            .kind = CLI_FLAG,
            .value = &s->certificate,
            .goes_with = "--stats" },
        { .name = NULL },
    };
    const cli_usage usage = { "render", help, options, "SCENE", 1, 1,
        "-o --size --quality --error --max-time --mode --env --camera --exposure --frames" };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (s->outputs.count == 0) {
        *exit_status = cli_usage_error("render", "-o OUT.{exr,png,hdr} is missing");
        return false;
    }
    return check_sequence(s, exit_status) && check_units(s, exit_status) &&
           check_denoise(s, exit_status) && settle_plan(s, exit_status);
}

/// Whether the picture is one of a solution.
static bool is_solved(const settings *s)
{
    return s->mode == RSV_RENDER_OPERATOR || s->mode == RSV_RENDER_FINAL;
}

/// The name of a picture; of a sequence's, one with a number. @return false after saying why it has none
static bool picture_path(
    const settings *s, const char *pattern, uint32_t frame, char path[PATH_MAX])
{
    if (!s->sequence.frames) return snprintf(path, PATH_MAX, "%s", pattern) < PATH_MAX;
    if (cli_frame_path(pattern, frame, path)) return true;
    cli_error("-o %s: with --frames, the name must contain a frame number, as in "
              "frame-%%04d.png",
        pattern);
    return false;
}

static bool check_picture(const settings *s, const char *pattern)
{
    char path[PATH_MAX];
    if (!picture_path(s, pattern, s->sequence.last, path)) return false;
    if (rsv_image_check_output(path) == RSV_OK) return cli_check_apart(s->stats, path);
    cli_error("%s", rsv_last_error());
    return false;
}

static bool takes_the_film(const settings *s)
{
    bool shifted = s->shift[0] != 0 || s->shift[1] != 0;
    bool is_occlusion = s->mode == RSV_RENDER_OCCLUSION || s->mode == RSV_RENDER_OCCLUSION_SCREEN;
    if (is_occlusion && (s->fstop > 0 || shifted || s->projection != RSV_PROJECTION_CAMERA))
        cli_error(
            "--mode %s supports a pinhole camera only: leave out --fstop, --shift-x, --shift-y and "
            "--projection",
            mode_names[s->mode]);
    else if (s->fstop > 0 && s->projection != RSV_PROJECTION_CAMERA)
        cli_error("--fstop is not supported with --projection %s; leave it out",
            projection_names[s->projection]);
    else
        return true;
    return false;
}

/// Refuses, before the long work, what this build cannot do and outputs that cannot be written.
static bool check_request(const settings *s)
{
    if (!is_solved(s) && (s->solve.solver != RSV_SOLVER_AUTO || s->target.share > 0 || s->goal ||
                             s->noise >= 0 || s->certificate)) {
        cli_error("--mode %s solves nothing: leave out --solver, --error, --goal, --noise and "
                  "--certificate",
            mode_names[s->mode]);
        return false;
    }
    if (s->planned && s->target.share > 0 && s->target.share < 0.005f) {
        cli_error(
            "--error %g %%: planned pictures support errors of 0.5 %% and more; for less, choose "
            "--quality and --spp",
            100 * (double)s->target.share);
        return false;
    }
    if (s->sequence.frames && rsv_is_operator_file(s->scene)) {
        cli_error("--frames: '%s' is already solved; use `resolvent relight %s --frames %s`",
            s->scene, s->scene, s->sequence.frames);
        return false;
    }
    if (!takes_the_film(s)) return false;
    bool shifted = s->shift[0] != 0 || s->shift[1] != 0;
    bool is_more = s->layers || s->noise > 0 || s->fstop > 0 || s->projection || shifted;
    if (s->gloss == RSV_GLOSS_REUSED && (s->mode != RSV_RENDER_OPERATOR || is_more)) {
        cli_error("--gloss reused requires --mode operator, without --layers, --noise, --fstop, "
                  "--shift-x, --shift-y and --projection");
        return false;
    }
    if (s->mode == RSV_RENDER_REFERENCE && s->device != CLI_DEVICE_CPU) {
        cli_error("--mode reference runs on the CPU only: leave out --device");
        return false;
    }
    for (size_t i = 0; i < s->outputs.count; i++)
        if (!check_picture(s, s->outputs.item[i])) return false;
    return !s->stats || cli_check_output(s->stats);
}

static bool writes_exr(const settings *s)
{
    for (size_t i = 0; i < s->outputs.count; i++)
        if (cli_ends_in(s->outputs.item[i], ".exr")) return true;
    return false;
}

static uint32_t default_samples(const settings *s)
{
    static const uint32_t by_quality[] = { 4, 9, 16 };
    return s->mode == RSV_RENDER_REFERENCE ? 64 : by_quality[s->solve.quality];
}

/// Default noise target. If rays per pixel were given, they are used as they are.
static float default_noise(const settings *s)
{
    static const float by_quality[] = { 0, 0.2f, 0.1f };
    return s->mode == RSV_RENDER_FINAL && !s->samples ? by_quality[s->solve.quality] : 0;
}

static cli_size default_size(const settings *s, const rsv_camera *camera)
{
    if (s->projection == RSV_PROJECTION_EQUIRECTANGULAR) return (cli_size){ 512, 256 };
    if (s->projection == RSV_PROJECTION_FISHEYE) return (cli_size){ 512, 512 };
    return cli_default_size(camera);
}

static bool describe_picture(const settings *s, const rsv_scene *scene, rsv_render_desc *desc)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    *desc = rsv_default_render_desc();
    desc->camera = rsv_scene_find_camera(scene, s->camera);
    if (desc->camera == RSV_NONE) {
        cli_error("--camera: %s has no camera '%s'; `resolvent info %s` lists them", s->scene,
            s->camera ? s->camera : "", s->scene);
        return false;
    }
    cli_size size = s->size.width ? s->size : default_size(s, &view->camera[desc->camera]);
    desc->mode = (rsv_render_mode)s->mode;
    desc->width = size.width;
    desc->height = size.height;
    desc->samples = s->samples ? s->samples : default_samples(s);
    desc->noise = s->noise >= 0 ? s->noise : default_noise(s);
    desc->gather_rays = s->gather_rays;
    desc->occlusion_distance = s->occlusion_distance;
    desc->layers = s->layers;
    desc->denoise = s->denoise || is_first_look(s);
    desc->film = (rsv_film_desc){ .projection = (rsv_projection)s->projection,
        .f_number = s->fstop,
        .focus_distance = s->focus,
        .shift = { s->shift[0], s->shift[1] } };
    desc->seed = s->solve.seed;
    return true;
}

/// Bytes that a picture takes in the making: measured were 23 per pixel, 43 where samples follow the noise or frames
/// add up, and 12 for each layer.
static size_t picture_bytes(const settings *s, const rsv_render_desc *picture)
{
    bool sums = picture->mode == RSV_RENDER_OPERATOR && !picture->layers;
    size_t bytes = s->planned || picture->noise > 0 || sums ? 46 : 25;
    if (picture->layers) bytes += 120;
    if (picture->denoise) bytes += s->planned ? 470 : 320;
    return picture->width * (size_t)picture->height * bytes;
}

static rsv_solve_desc describe_solve(
    const settings *s, const rsv_scene *scene, const rsv_render_desc *picture)
{
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    desc.reserved_bytes = picture_bytes(s, picture);
    desc.direct_level = s->mode != RSV_RENDER_FINAL;
    if (s->goal) desc.goal_camera = rsv_scene_find_camera(scene, s->camera);
    return desc;
}

/// @param certificate filled where the error is a target
static rsv_status solve(cli_session *session, const settings *s, const rsv_render_desc *picture,
    cli_subject *subject, rsv_certificate *certificate)
{
    rsv_solve_desc desc = describe_solve(s, subject->scene, picture);
    return cli_solve_subject(session, &desc, &s->target, subject, certificate);
}

/// The certificate that the statistics want, unless there is one.
static rsv_status certify(
    const settings *s, const cli_subject *subject, rsv_certificate *certificate)
{
    if (!s->certificate || !subject->solution || certificate->samples) return RSV_OK;
    return cli_certify_briefly(s->stats, subject->solution, s->solve.seed, certificate);
}

/// Of .png.
static float choose_exposure(cli_session *session, const settings *s, const rsv_image *image)
{
    bool wanted = cli_writes_png(&s->outputs) && cli_exposes(session, s->scene, s->exposure);
    return cli_expose(session, wanted, s->exposure, image);
}

/// @param photometric in place of the image where values are kept; NULL = none
static rsv_status write_picture(
    const char *path, const rsv_image *image, const rsv_image *photometric, float exposure)
{
    bool shown = !photometric || cli_ends_in(path, ".png");
    return rsv_image_write(shown ? image : photometric, path, exposure);
}

static rsv_status write_pictures(const cli_session *session, const settings *s, uint32_t frame,
    const rsv_image *image, float exposure)
{
    char path[PATH_MAX];
    rsv_status status = RSV_OK;
    rsv_image *photometric = NULL;
    if (!cli_crew_speaks()) return RSV_OK;
    if (s->photometric) status = cli_photometric_picture(session->context, image, &photometric);
    for (size_t i = 0; i < s->outputs.count && status == RSV_OK; i++)
        if (picture_path(s, s->outputs.item[i], frame, path)) // check_picture saw to it
            status = write_picture(path, image, photometric, exposure);
    rsv_image_destroy(photometric);
    return status;
}

static bool write_stats(const cli_session *session, const settings *s, const rsv_render_desc *desc,
    const rsv_light *solution, const rsv_certificate *certificate, cli_stats *stats)
{
    stats->command = "render";
    stats->scene = s->scene;
    stats->mode = mode_names[s->mode];
    stats->quality = (rsv_quality)s->solve.quality;
    stats->width = desc->width;
    stats->height = desc->height;
    stats->samples = stats->is_planned ? stats->plan.samples : desc->samples;
    stats->threads = cli_thread_count(s->threads);
    stats->seed = s->solve.seed;
    if (solution) stats->report = rsv_light_report(solution);
    stats->certificate = certificate && certificate->samples ? certificate : NULL;
    if (solution) stats->order_count = rsv_light_order_count(solution);
    return cli_write_stats(s->stats, session, stats);
}

/// @param solve borrowed
static rsv_plan_desc describe_plan(
    cli_session *session, const settings *s, const rsv_solve_desc *solve)
{
    rsv_plan_desc plan = rsv_default_plan_desc();
    double left = (double)s->target.max_seconds - (cli_seconds() - session->started);
    plan.solve = solve;
    if (s->target.share > 0) plan.relative_error = (double)s->target.share;
    if (s->target.max_seconds == 0) return plan;
    if (s->target.share == 0) plan.relative_error = 0;
    if (left <= 0)
        cli_warn(session, "--max-time: loading the scene alone took that long; allow more time");
    plan.max_seconds = fmax(left, 1e-3);
    return plan;
}

/// A picture by error or time.
static rsv_status render_planned(cli_session *session, const settings *s,
    const rsv_render_desc *desc, cli_subject *subject, rsv_image **image, cli_stats *stats)
{
    static const rsv_solve_report nothing = { 0 };
    rsv_solve_desc solve = cli_describe_solve(&s->solve);
    solve.reserved_bytes = picture_bytes(s, desc);
    rsv_plan_desc plan = describe_plan(session, s, &solve);
    double started = cli_seconds();
    bool was_solved = subject->solution != NULL;
    rsv_status status =
        rsv_render_planned(subject->scene, &plan, desc, &subject->solution, image, &stats->plan);
    stats->is_planned = true;
    if (status != RSV_OK) return status;
    const rsv_solve_report *r =
        was_solved || !subject->solution ? &nothing : rsv_light_report(subject->solution);
    stats->time_render = cli_seconds() - started - r->time_bvh - r->time_assemble - r->time_solve;
    return status;
}

/// The picture of a scene that is solved where the mode wants it.
static rsv_status render(const settings *s, const rsv_render_desc *desc, const cli_subject *subject,
    rsv_image **image, cli_stats *stats)
{
    rsv_status status;
    double started = cli_seconds();
    if (desc->mode == RSV_RENDER_OPERATOR)
        status = rsv_render_operator(subject->solution, desc, (rsv_frame_gloss)s->gloss, image);
    else if (is_solved(s))
        status = rsv_render(subject->solution, desc, image);
    else if (desc->mode == RSV_RENDER_REFERENCE)
        status = rsv_render_reference(subject->scene, desc, image, &stats->standard_error);
    else
        status = rsv_render_occlusion(subject->scene, desc, image);
    stats->time_render = cli_seconds() - started;
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    return status;
}

// ---- sequences ------------------------------------------------------------------------------------

/// State shared by the frames of a sequence.
typedef struct reel {
    cli_session *session;
    const settings *s;
    rsv_light *light;        ///< follows from frame to frame; NULL = none does
    rsv_scene *base;         ///< the scene that the light was first solved for
    bool cannot_follow;      ///< frames move surfaces, or need what a followed light lacks
    rsv_update_store *store; ///< data of the last frame's solution, if lights do not follow
    rsv_solve_report sum;    ///< the last one's, with times and rays of all
    rsv_update_report kept;  ///< of all
    cli_stats stats;
    float exposure; ///< of all frames: chosen for the first one
} reel;

static void add_reports(reel *r, const rsv_solve_report *report, const rsv_update_report *kept)
{
    rsv_solve_report before = r->sum;
    r->sum = *report;
    r->sum.rays += before.rays;
    r->sum.row_rays += before.row_rays;
    r->sum.kept_row_rays += before.kept_row_rays;
    r->sum.spared_seconds += before.spared_seconds;
    r->sum.time_bvh += before.time_bvh;
    r->sum.time_assemble += before.time_assemble;
    r->sum.time_solve += before.time_solve;
    cli_add_update(&r->kept, kept);
}

/// Solves the light of a frame, reusing what is still valid of the previous one.
static rsv_status update(reel *r, cli_subject *subject, const rsv_render_desc *picture)
{
    rsv_update_report kept;
    rsv_solve_desc desc = describe_solve(r->s, subject->scene, picture);
    rsv_status status =
        rsv_operator_update(subject->scene, &desc, r->store, &subject->solution, &kept);
    if (status == RSV_OK) add_reports(r, rsv_light_report(subject->solution), &kept);
    return status;
}

/// The light that goes on from frame to frame.
static rsv_status follow(reel *r, cli_subject *subject, const rsv_render_desc *picture)
{
    rsv_solve_desc desc = describe_solve(r->s, subject->scene, picture);
    rsv_status status;
    if (!r->light) {
        status = rsv_light_create(subject->scene, &desc, &r->light);
        if (status == RSV_OK) r->base = subject->scene;
    } else {
        bool finished = r->s->mode == RSV_RENDER_OPERATOR;
        status = cli_follow_frame(r->light, subject->scene, finished, &r->kept);
    }
    if (status != RSV_OK) return status;
    r->sum = *rsv_light_report(r->light);
    r->sum.time_assemble += r->kept.seconds;
    subject->solution = r->light;
    return RSV_OK;
}

static void stop_following(reel *r)
{
    rsv_light_destroy(r->light);
    rsv_scene_destroy(r->base);
    r->light = NULL;
    r->base = NULL;
}

/// The light of a frame.
static rsv_status find_light(reel *r, cli_subject *subject, const rsv_render_desc *picture)
{
    if (!r->cannot_follow) {
        rsv_status status = follow(r, subject, picture);
        if (status != RSV_ERROR_UNSUPPORTED || !r->light) return status;
        stop_following(r);
        r->cannot_follow = true;
    }
    return update(r, subject, picture);
}

/// Frees what belongs to this frame only.
static void close_frame(const reel *r, cli_subject *subject)
{
    if (subject->solution == r->light) subject->solution = NULL;
    if (subject->scene == r->base) subject->scene = NULL;
    cli_close_subject(subject);
}

/// The figures of a frame: the last moment's, and the time of all.
static void note_picture(
    reel *r, const cli_subject *subject, const rsv_render_desc *desc, const cli_stats *stats)
{
    r->stats.time_render += stats->time_render;
    r->stats.standard_error = stats->standard_error;
    r->stats.width = desc->width;
    r->stats.height = desc->height;
    r->stats.samples = desc->samples * cli_moments_of_frame(&r->s->sequence);
    r->stats.order_count = subject->solution ? rsv_light_order_count(subject->solution) : 0;
}

/// Solves and renders one moment. @param image out; to be destroyed
static bool run_moment(reel *r, uint32_t frame, uint32_t moment, rsv_image **image)
{
    const settings *s = r->s;
    cli_subject subject = { 0 };
    rsv_render_desc desc;
    cli_stats stats = { .standard_error = NAN };
    r->session->moment.time = cli_frame_time(&s->sequence, frame, moment);
    subject.scene = cli_open_scene(r->session, s->scene, &s->environment);
    bool good = subject.scene && describe_picture(s, subject.scene, &desc);
    rsv_status status = good && is_solved(s) ? find_light(r, &subject, &desc) : RSV_OK;
    if (good && r->light) // its cameras are those of the first frame
        desc.viewpoint = &rsv_scene_get_view(subject.scene)->camera[desc.camera];
    if (good) desc.seed += moment;
    if (good && status == RSV_OK) status = render(s, &desc, &subject, image, &stats);
    if (status != RSV_OK) cli_report_failure(r->session, status);
    if (good) note_picture(r, &subject, &desc, &stats);
    close_frame(r, &subject);
    return good && status == RSV_OK;
}

static bool run_frame(void *user, uint32_t frame)
{
    reel *r = user;
    const settings *s = r->s;
    rsv_image *mean = NULL;
    bool good = true;
    for (uint32_t k = 0; k < cli_moments_of_frame(&s->sequence) && good; k++) {
        rsv_image *image = NULL;
        good = run_moment(r, frame, k, &image);
        if (good) cli_add_moment(&s->sequence, image, &mean);
    }
    if (good && frame == s->sequence.first) r->exposure = choose_exposure(r->session, s, mean);
    rsv_status status = good ? write_pictures(r->session, s, frame, mean, r->exposure) : RSV_OK;
    if (status != RSV_OK) cli_report_failure(r->session, status);
    rsv_image_destroy(mean);
    return good && status == RSV_OK;
}

static bool write_reel_stats(reel *r)
{
    const settings *s = r->s;
    const rsv_render_desc desc = { .size = sizeof desc,
        .width = r->stats.width,
        .height = r->stats.height,
        .samples = r->stats.samples };
    if (!s->stats) return true;
    r->stats.more = cJSON_CreateObject();
    cJSON_AddNumberToObject(r->stats.more, "frames", s->sequence.last - s->sequence.first + 1);
    cli_write_updates(r->stats.more, &r->kept);
    r->stats.report = is_solved(s) ? &r->sum : NULL;
    if (cli_writes_png(&s->outputs)) r->stats.exposure = &r->exposure;
    return write_stats(r->session, s, &desc, NULL, NULL, &r->stats);
}

static int run_sequence(cli_session *session, const settings *s)
{
    reel r = { .session = session, .s = s, .cannot_follow = s->goal || s->layers };
    rsv_status status = rsv_update_store_create(session->context, &r.store);
    bool good = status == RSV_OK;
    if (!good) cli_report_failure(session, status);
    if (good && s->layers && !writes_exr(s))
        cli_warn(session, "--layers: only .exr files hold layers");
    good = good && cli_run_frames(session, &s->sequence, run_frame, &r);
    rsv_update_store_destroy(r.store);
    stop_following(&r);
    return good && write_reel_stats(&r) ? CLI_SUCCESS : CLI_FAILURE;
}

static int run(cli_session *session, settings *s)
{
    int exit_status = CLI_FAILURE;
    cli_stats stats = { .standard_error = NAN };
    rsv_render_desc desc;
    rsv_certificate certificate = { 0 };
    rsv_image *image = NULL;
    float exposure = 0;
    cli_subject subject;
    if (!cli_open_subject(session, s->scene, &s->environment, &subject)) return exit_status;
    if (!describe_picture(s, subject.scene, &desc)) goto cleanup;
    if (s->layers && !writes_exr(s)) cli_warn(session, "--layers: only .exr files hold layers");
    if (desc.denoise && !s->denoise)
        cli_note(session, "noise will be filtered out of the picture; --no-denoise keeps it");

    rsv_status status = RSV_OK;
    if (s->planned)
        status = render_planned(session, s, &desc, &subject, &image, &stats);
    else if (is_solved(s))
        status = solve(session, s, &desc, &subject, &certificate);
    if (status == RSV_OK && !s->planned) status = render(s, &desc, &subject, &image, &stats);
    if (status == RSV_OK) status = certify(s, &subject, &certificate);
    if (status == RSV_OK) {
        exposure = choose_exposure(session, s, image);
        status = write_pictures(session, s, 0, image, exposure);
    }
    if (cli_writes_png(&s->outputs)) stats.exposure = &exposure;
    if (status != RSV_OK)
        cli_report_failure(session, status);
    else if (!s->stats || write_stats(session, s, &desc, is_solved(s) ? subject.solution : NULL,
                              &certificate, &stats))
        exit_status = CLI_SUCCESS;

cleanup:
    rsv_image_destroy(image);
    cli_close_subject(&subject);
    return exit_status;
}

int cli_render(int argc, char **argv)
{
    settings s = { .mode = RSV_RENDER_FINAL,
        .solve = { .quality = -1 },
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST,
        .sequence = CLI_DEFAULT_SEQUENCE,
        .exposure = CLI_AUTO_EXPOSURE,
        .noise = -1 };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    if (!check_request(&s)) return CLI_FAILURE;
    cli_session session;
    if (!cli_prepare_solve(&s.solve) || !cli_device_open(s.device) ||
        !cli_session_begin(&session, s.threads))
        return CLI_FAILURE;
    session.mesh = s.mesh;
    session.moment = s.moment;
    session.reading = s.reading;
    session.max_bytes = s.solve.max_bytes;
    exit_status = s.sequence.frames ? run_sequence(&session, &s) : run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
