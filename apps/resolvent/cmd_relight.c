#include "command.h"
#include "crew.h"
#include "device.h"
#include "exposure.h"
#include "frame_path.h"
#include "light_script.h"
#include "object_picture.h"
#include "options.h"
#include "output_file.h"
#include "sequence.h"
#include "stats.h"
#include "subject.h"

#include "resolvent/frame.h"
#include "resolvent/lightmix.h"

#include <cJSON.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: resolvent relight OPERATOR -o OUT.{exr,png,hdr,safetensors} [options]\n"
    "\n"
    "Changes the lights and colours of a file from `resolvent solve` and solves again on the same\n"
    "operator, without tracing rays for it. Then renders a picture, or saves the result as an operator\n"
    "file.\n"
    "\n"
    "  -o FILE            the picture or operator file; repeat it for more\n"
    "  --light NAME=SCALE set a light to SCALE times its strength in the solved scene. NAME is a light\n"
    "                     listed by `resolvent info`, its node, an emissive material, or #K for light K\n"
    "                     (from 0); * matches any text. NAME=R,G,B: a factor for each channel;\n"
    "                     NAME=SCALE,R,G,B: both\n"
    "  --albedo MATERIAL=R,G,B  another base colour for a plain diffuse material\n"
    "  --move NAME=X,Y,Z  move a light by this offset in metres; emissive triangles move with it\n"
    "  --aim NAME=X,Y,Z   turn a spot light, luminaire or directional light to shine along X,Y,Z\n"
    "  --add NAME=X,Y,Z,I add a point light of I W/sr at X,Y,Z; --light NAME=1,R,G,B colours it\n"
    "  --env-intensity S  multiply the environment by S\n"
    "  --env-rotate DEG   rotate the environment to DEG degrees, counter-clockwise seen from above\n"
    "  --script FILE      render a sequence; -o day-%04d.png numbers the files. Each line of the script\n"
    "                     is a frame number and settings: light.NAME=SCALE (or R,G,B or SCALE,R,G,B)\n"
    "                     albedo.MATERIAL=R,G,B move.NAME=X,Y,Z aim.NAME=X,Y,Z place.object=X,Y,Z\n"
    "                     env-rotate=DEG env-intensity=S. Frames between two lines are interpolated. If\n"
    "                     only strengths and colours of lights change, the picture of each light is\n"
    "                     rendered once, and frames are sums of these\n"
    "  --frames A-B       render these frames of the animations of the glTF file that was solved; frame 0\n"
    "                     is at 0 s. -o walk-%04d.png numbers the files. The light follows what moves, from\n"
    "                     the changes above. Requires an OPERATOR solved without --time\n"
    "  --fps N            frames per second (default 24)\n" CLI_SHUTTER_HELP
    "  --clip NAME        the animation to play; all = all at once (default: the first)\n"
    "  --object FILE      with --mode operator: a rigid object that is lit and shown but not solved for; a\n"
    "                     script moves it, in metres from its position in its file (docs/view.md)\n"
    "  --mode MODE        final (default) or operator, as for `render`\n"
    "  --size WxH         pixels (default: 512 on the longer side, with the camera's aspect ratio)\n"
    "  --spp N            camera rays per pixel (default 9)\n"
    "  --camera NAME      a camera listed by `resolvent info OPERATOR` (default: the first)\n"
    "  --exposure STOPS   brighten .png by 2^STOPS (default: automatic for files, chosen for the light as\n"
    "                     solved and the same for all frames; 0 for built-in scenes)\n"
    "  --seed N           seed of the picture's random numbers (default 0)\n"
    "  --threads N        default: one per core; the result does not depend on it\n" CLI_DEVICE_HELP
    "  --stats FILE.json  what was done, time of each phase, norms and residuals (docs/stats.md)\n"
    "\n"
    "examples:\n"
    "  resolvent relight room.safetensors --light lamp=0.5,1,0.8,0.6 -o evening.png\n"
    "  resolvent relight room.safetensors --script day.txt -o day-%03d.png --size 320x180\n"
    "  resolvent relight walk.safetensors --light lamp=0.2 --frames 0-47 -o walk-%02d.png\n"
    "  resolvent relight room.safetensors --light sun=0 --albedo wall=0.2,0.3,0.8 -o night.safetensors\n";

static const char *const mode_names[] = {
    [RSV_RENDER_OPERATOR] = "operator", [RSV_RENDER_FINAL] = "final", NULL
};

typedef struct settings {
    const char *scene, *camera, *stats, *script, *object;
    cli_list outputs, lights, albedos, moves, aims, added;
    cli_size size;
    int mode, device;
    uint32_t samples, threads, seed;
    float exposure, env_intensity, env_rotate;
    cli_light_script animation;
    cli_sequence
        sequence; ///< of the animations of the file; its frames are those of `animation`, too
    const char *clip;
    rsv_scene *body; ///< the object; NULL = none
    rsv_vec3 place;  ///< in the frame in hand
    rsv_light_scale light[CLI_LIST_CAPACITY + 1 + CLI_MAX_TRACKS];
    rsv_albedo_change albedo[CLI_LIST_CAPACITY + CLI_MAX_TRACKS];
    rsv_light_move move[CLI_LIST_CAPACITY + CLI_MAX_TRACKS];
    rsv_light_aim aim[CLI_LIST_CAPACITY + CLI_MAX_TRACKS];
    rsv_punctual_light add[CLI_LIST_CAPACITY];
    char *name[5 * CLI_LIST_CAPACITY]; ///< owned copies for the five above
    rsv_relight_desc still;            ///< changes by options
    rsv_relight_desc relight;          ///< changes by options and script at the current frame
} settings;

/// State shared by all frames: the file is read once.
typedef struct stage {
    cli_subject subject;
    rsv_relighter *relighter;
    uint32_t camera, frame_count;
    rsv_light_mix *mix; ///< frames are sums of one picture per source; NULL = each is rendered
    bool prepared;      ///< only strengths change, and the light of each source alone is known
    rsv_update_report updates;   ///< of all frames that follow an animation
    const rsv_camera *viewpoint; ///< in the frame in hand; NULL = the camera as solved
    uint32_t moment;             ///< of the frame in hand
    rsv_image *exposed;          ///< that frame's picture, if it is there already; NULL = it is not
    double relight_rays;
    double time_relight, time_render;
    float exposure; ///< of .png: one for all frames
    char scene_name[256];
} stage;

// ---- options --------------------------------------------------------------------------------------

/// Position of an added light, in the file's coordinates: in double, as the scene may lie far from its origin.
static rsv_vec3 place_of_added(const char *item, const rsv_scene *scene)
{
    const double *origin = rsv_scene_get_view(scene)->origin;
    const char *next = strrchr(item, '=');
    double at[3] = { 0 };
    for (int axis = 0; axis < 3 && next; axis++) {
        char *end;
        at[axis] = strtod(next + 1, &end) - origin[axis];
        next = end;
    }
    return (rsv_vec3){ (float)at[0], (float)at[1], (float)at[2] };
}

/// Moves and directions. @param names how many of s->name are taken
static bool read_places(settings *s, size_t *names)
{
    float v[4];
    for (size_t k = 0; k < s->moves.count; k++) {
        char *name = s->name[(*names)++] = strdup(s->moves.item[k]);
        if (!name || cli_cut_change(name, v) != 3) {
            cli_usage_error("relight", "--move: '%s' is not NAME=X,Y,Z", s->moves.item[k]);
            return false;
        }
        s->move[k] = (rsv_light_move){ name, { v[0], v[1], v[2] } };
    }
    for (size_t k = 0; k < s->aims.count; k++) {
        char *name = s->name[(*names)++] = strdup(s->aims.item[k]);
        if (!name || cli_cut_change(name, v) != 3) {
            cli_usage_error("relight", "--aim: '%s' is not NAME=X,Y,Z", s->aims.item[k]);
            return false;
        }
        s->aim[k] = (rsv_light_aim){ name, { v[0], v[1], v[2] } };
    }
    return true;
}

/// Reads the changes that options make; prints an error and returns false if one is invalid.
static bool read_changes(settings *s)
{
    float v[4];
    size_t names = 0;
    for (size_t k = 0; k < s->lights.count; k++) {
        char *name = s->name[names++] = strdup(s->lights.item[k]);
        size_t count = name ? cli_cut_change(name, v) : 0;
        rsv_rgb scale;
        if (!cli_light_scale(v, count, &scale)) {
            cli_usage_error("relight",
                "--light: '%s' is not NAME=SCALE, NAME=R,G,B or NAME=SCALE,R,G,B",
                s->lights.item[k]);
            return false;
        }
        s->light[k] = (rsv_light_scale){ name, scale };
    }
    for (size_t k = 0; k < s->albedos.count; k++) {
        char *name = s->name[names++] = strdup(s->albedos.item[k]);
        if (!name || cli_cut_change(name, v) != 3) {
            cli_usage_error("relight", "--albedo: '%s' is not MATERIAL=R,G,B", s->albedos.item[k]);
            return false;
        }
        s->albedo[k] = (rsv_albedo_change){ name, { v[0], v[1], v[2] } };
    }
    if (!read_places(s, &names)) return false;
    for (size_t k = 0; k < s->added.count; k++) {
        char *name = s->name[names++] = strdup(s->added.item[k]);
        if (!name || cli_cut_change(name, v) != 4 || v[3] < 0) {
            cli_usage_error(
                "relight", "--add: '%s' is not NAME=X,Y,Z,I with I from 0 on", s->added.item[k]);
            return false;
        }
        s->add[k] = (rsv_punctual_light){ .name = name,
            .kind = RSV_PUNCTUAL_POINT,
            .position = { v[0], v[1], v[2] },
            .intensity = { v[3], v[3], v[3] } };
    }
    size_t lights = s->lights.count;
    if (s->env_intensity != 1)
        s->light[lights++] = (rsv_light_scale){ "environment",
            { s->env_intensity, s->env_intensity, s->env_intensity } };
    bool turn = isfinite(s->env_rotate);
    s->still = (rsv_relight_desc){ .size = sizeof(rsv_relight_desc),
        .light = s->light,
        .light_count = lights,
        .albedo = s->albedo,
        .albedo_count = s->albedos.count,
        .move = s->move,
        .move_count = s->moves.count,
        .aim = s->aim,
        .aim_count = s->aims.count,
        .turn = turn,
        .rotation = turn ? s->env_rotate : 0 };
    return true;
}

/// A script that places an object needs one.
static bool check_places(const settings *s)
{
    for (size_t k = 0; k < s->animation.track_count && !s->object; k++)
        if (s->animation.track[k].kind == CLI_TRACK_PLACE) {
            cli_error("%s: there is no object to place; add one with --object FILE", s->script);
            return false;
        }
    return true;
}

/// Frames of an animation, which take the place of a script's.
static bool read_frames(settings *s)
{
    if (!s->sequence.frames) return true;
    if (s->script) {
        cli_usage_error("relight", "--frames and --script exclude each other; leave out one");
        return false;
    }
    if (!cli_read_sequence("relight", &s->sequence)) return false;
    s->animation.first = s->sequence.first;
    s->animation.last = s->sequence.last;
    return true;
}

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_LIST, .value = &s->outputs },
        { .name = "--light", .kind = CLI_LIST, .value = &s->lights },
        { .name = "--albedo", .kind = CLI_LIST, .value = &s->albedos },
        { .name = "--move", .kind = CLI_LIST, .value = &s->moves },
        { .name = "--aim", .kind = CLI_LIST, .value = &s->aims },
        { .name = "--add", .kind = CLI_LIST, .value = &s->added },
        { .name = "--env-intensity", .kind = CLI_REAL, .value = &s->env_intensity, .max = 1e6 },
        { .name = "--env-rotate",
            .kind = CLI_REAL,
            .value = &s->env_rotate,
            .min = -36000,
            .max = 36000 },
        { .name = "--mode", .kind = CLI_CHOICE, .value = &s->mode, .choices = mode_names },
        { .name = "--size", .kind = CLI_SIZE, .value = &s->size, .min = 1, .max = 32768 },
        { .name = "--spp", .kind = CLI_COUNT, .value = &s->samples, .min = 1, .max = 1 << 24 },
        { .name = "--camera", .kind = CLI_TEXT, .value = &s->camera },
        CLI_EXPOSURE_OPTION(&s->exposure),
        { .name = "--seed", .kind = CLI_COUNT, .value = &s->seed, .max = UINT32_MAX },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_DEVICE_OPTION(&s->device),
        { .name = "--object", .kind = CLI_TEXT, .value = &s->object },
        { .name = "--script", .kind = CLI_TEXT, .value = &s->script },
        CLI_SEQUENCE_OPTIONS(&s->sequence),
        { .name = "--clip", .kind = CLI_TEXT, .value = &s->clip, .goes_with = "--frames" },
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = NULL },
    };
    const cli_usage usage = { "relight", help, options, "OPERATOR", 1, 1,
        "-o --light --albedo --move --add --env-rotate --script --size --camera --exposure" };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    *exit_status = CLI_BAD_USAGE;
    if (s->outputs.count == 0) {
        cli_usage_error("relight", "-o OUT.{exr,png,hdr,safetensors} is missing");
        return false;
    }
    if (s->object && s->mode != RSV_RENDER_OPERATOR) {
        cli_usage_error("relight", "--object: moving objects require --mode operator");
        return false;
    }
    if (!read_changes(s) || !read_frames(s)) return false;
    *exit_status = CLI_FAILURE;
    return !s->script || (cli_read_light_script(s->script, &s->animation) && check_places(s));
}

static bool is_operator_name(const char *path)
{
    const char *extension = strrchr(path, '.');
    return extension && strcmp(extension, ".safetensors") == 0;
}

// ---- frames ---------------------------------------------------------------------------------------

/// Sets the changes for a frame: those of options first; a script's for the same property overrule them.
static void enter_frame(settings *s, uint32_t frame)
{
    s->relight = s->still;
    for (size_t k = 0; k < s->animation.track_count; k++) {
        const cli_track *track = &s->animation.track[k];
        float v[3];
        cli_track_at(track, frame, v);
        rsv_rgb value = { v[0], v[1], v[2] };
        if (track->kind == CLI_TRACK_LIGHT)
            s->light[s->relight.light_count++] = (rsv_light_scale){ track->name, value };
        else if (track->kind == CLI_TRACK_ALBEDO)
            s->albedo[s->relight.albedo_count++] = (rsv_albedo_change){ track->name, value };
        else if (track->kind == CLI_TRACK_MOVE)
            s->move[s->relight.move_count++] =
                (rsv_light_move){ track->name, { v[0], v[1], v[2] } };
        else if (track->kind == CLI_TRACK_AIM)
            s->aim[s->relight.aim_count++] = (rsv_light_aim){ track->name, { v[0], v[1], v[2] } };
        else if (track->kind == CLI_TRACK_PLACE)
            s->place = (rsv_vec3){ v[0], v[1], v[2] };
        else if (track->kind == CLI_TRACK_INTENSITY)
            s->light[s->relight.light_count++] =
                (rsv_light_scale){ "environment", { v[0], v[0], v[0] } };
        else
            s->relight.turn = true, s->relight.rotation = v[0];
    }
}

/// @return false if the name is too long, or has no place for a number and needs one
static bool output_path(const settings *s, size_t output, uint32_t frame, char path[PATH_MAX])
{
    if (s->script || s->sequence.frames)
        return cli_frame_path(s->outputs.item[output], frame, path);
    return snprintf(path, PATH_MAX, "%s", s->outputs.item[output]) < PATH_MAX;
}

static bool check_output(const char *path)
{
    if (is_operator_name(path)) return cli_check_output(path);
    if (rsv_image_check_output(path) == RSV_OK) return true;
    cli_error("%s", rsv_last_error());
    return false;
}

static bool check_outputs(const settings *s)
{
    char path[PATH_MAX];
    for (size_t k = 0; k < s->outputs.count; k++) {
        if (!output_path(s, k, s->animation.last, path)) {
            cli_error("-o %s: with %s, the name must contain a frame number, as in "
                      "frame-%%04d.png",
                s->outputs.item[k], s->script ? "--script" : "--frames");
            return false;
        }
        if (s->sequence.frames && is_operator_name(path)) {
            cli_error("-o %s: --frames writes pictures only, because operator files contain "
                      "light at rest",
                s->outputs.item[k]);
            return false;
        }
        if (!check_output(path) || !cli_check_apart(s->stats, path)) return false;
    }
    return !s->stats || cli_check_output(s->stats);
}

// ---- work -----------------------------------------------------------------------------------------

static rsv_render_desc describe_picture(const settings *s, const stage *on)
{
    const rsv_scene_view *view = rsv_scene_get_view(on->subject.scene);
    rsv_render_desc desc = rsv_default_render_desc();
    cli_size size = s->size.width ? s->size : cli_default_size(&view->camera[on->camera]);
    desc.mode = (rsv_render_mode)s->mode;
    desc.camera = on->camera;
    desc.viewpoint = on->viewpoint;
    desc.width = size.width;
    desc.height = size.height;
    desc.samples = s->samples;
    desc.seed = s->seed + on->moment;
    return desc;
}

static rsv_status render(const settings *s, const stage *on, rsv_image **image)
{
    const rsv_light *solution = on->subject.solution;
    rsv_render_desc desc = describe_picture(s, on);
    if (s->body) return cli_render_object(solution, s->body, s->place, &desc, image);
    if (on->mix) return rsv_light_mix_take(on->mix, image);
    return s->mode == RSV_RENDER_OPERATOR
               ? rsv_render_operator(solution, &desc, RSV_GLOSS_PATHS, image)
               : rsv_render(solution, &desc, image);
}

/// Writes all outputs after the solve; the picture is rendered once for all files.
static rsv_status write_outputs(const settings *s, stage *on, uint32_t frame)
{
    char path[PATH_MAX];
    rsv_status status = RSV_OK;
    rsv_image *image = NULL;
    const rsv_light *solution = on->subject.solution;
    double started = cli_seconds();
    for (size_t k = 0; k < s->outputs.count && status == RSV_OK; k++) {
        if (!output_path(s, k, frame, path)) continue; // check_outputs saw to it
        if (is_operator_name(path)) {
            status = rsv_light_save(solution, on->scene_name, path);
            continue;
        }
        if (!image && on->exposed) {
            image = on->exposed;
            on->exposed = NULL;
        } else if (!image) {
            status = render(s, on, &image);
        }
        if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
        if (status == RSV_OK) status = rsv_image_write(image, path, on->exposure);
    }
    rsv_image_destroy(image);
    on->time_render += cli_seconds() - started;
    return status;
}

static bool write_stats(const cli_session *session, const settings *s, const stage *on)
{
    const rsv_light *solution = on->subject.solution;
    const rsv_scene_view *view = rsv_scene_get_view(on->subject.scene);
    cli_size size = s->size.width ? s->size : cli_default_size(&view->camera[on->camera]);
    cJSON *more = cJSON_CreateObject();
    cJSON_AddNumberToObject(more, "frames", on->frame_count);
    if (on->mix) cJSON_AddNumberToObject(more, "pictures", (double)rsv_light_mix_rendered(on->mix));
    cJSON_AddNumberToObject(more, "relight_rays", on->relight_rays);
    if (s->sequence.frames) cli_write_updates(more, &on->updates);
    cli_stats stats = { .command = "relight",
        .scene = s->scene,
        .mode = mode_names[s->mode],
        .quality = RSV_QUALITY_MEDIUM,
        .width = size.width,
        .height = size.height,
        .samples = s->samples,
        .threads = cli_thread_count(s->threads),
        .seed = s->seed,
        .report = rsv_light_report(solution),
        .order_count = rsv_light_order_count(solution),
        .standard_error = NAN,
        .exposure = cli_writes_png(&s->outputs) ? &on->exposure : NULL,
        .time_solve = on->time_relight,
        .time_render = on->time_render,
        .more = more };
    return cli_write_stats(s->stats, session, &stats);
}

/// Whether frames differ only in strengths and only pictures are written: then each is a sum of known pictures.
static bool is_a_sum(const settings *s)
{
    if (s->animation.first == s->animation.last || s->sequence.frames) return false;
    for (size_t k = 0; k < s->animation.track_count; k++) {
        cli_track_kind kind = s->animation.track[k].kind;
        if (kind != CLI_TRACK_LIGHT && kind != CLI_TRACK_INTENSITY && kind != CLI_TRACK_PLACE)
            return false;
    }
    for (size_t k = 0; k < s->outputs.count; k++)
        if (is_operator_name(s->outputs.item[k])) return false;
    return true;
}

static bool is_translucent(const rsv_scene_view *view)
{
    bool any = false;
    for (size_t m = 0; m < view->material_count; m++) {
        rsv_rgb scatter = view->material[m].scatter_distance;
        any = any || scatter.r + scatter.g + scatter.b > 0;
    }
    return any;
}

/// Frames of this process that repay a picture for each source that changes and two for the rest.
static bool is_worth_a_mix(const settings *s)
{
    size_t frames = (s->animation.last - s->animation.first + 1) / cli_crew_size();
    return !s->body && frames > 2 * s->animation.track_count + 2;
}

/// Renders each source alone, if every frame is a sum of those pictures.
static rsv_status prepare_sums(const settings *s, stage *on)
{
    rsv_status status = RSV_OK;
    rsv_render_desc desc = describe_picture(s, on);
    if (!is_a_sum(s)) return RSV_OK;
    on->prepared = !is_translucent(rsv_scene_get_view(on->subject.scene));
    if (on->prepared) status = rsv_relighter_prepare(on->relighter);
    if (status == RSV_OK && is_worth_a_mix(s))
        status = rsv_light_mix_create(on->relighter, &desc, &on->mix);
    return status;
}

/// Statistics describe the last frame exactly: sums of pictures have left the report of the solve unchanged.
static bool finish_stats(cli_session *session, const settings *s, stage *on)
{
    double started = cli_seconds();
    rsv_status status = on->relighter ? rsv_relighter_settle(on->relighter) : RSV_OK;
    on->time_relight += cli_seconds() - started;
    if (on->relighter) on->relight_rays = (double)rsv_relighter_rays(on->relighter);
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK && write_stats(session, s, on);
}

/// Exposes for the light as it was solved, so that changes are visible.
static rsv_status set_exposure(cli_session *session, const settings *s, stage *on)
{
    bool wanted = cli_writes_png(&s->outputs) && cli_exposes(session, s->scene, s->exposure);
    on->exposure = isnan(s->exposure) ? 0 : s->exposure;
    if (!wanted) return RSV_OK;
    return cli_expose_light(session, true, on->subject.solution, on->camera, &on->exposure);
}

/// Opens the file and sets up the state shared by frames.
static bool set_stage(cli_session *session, const settings *s, stage *on)
{
    if (!cli_open_subject(session, s->scene, NULL, &on->subject)) return false;
    on->camera = rsv_scene_find_camera(on->subject.scene, s->camera);
    if (on->camera == RSV_NONE) {
        cli_error("--camera: %s has no camera '%s'; `resolvent info %s` lists them", s->scene,
            s->camera ? s->camera : "", s->scene);
        return false;
    }
    double started = cli_seconds();
    rsv_status status =
        rsv_operator_scene_name(session->context, s->scene, on->scene_name, sizeof on->scene_name);
    if (status == RSV_OK) status = set_exposure(session, s, on);
    if (status == RSV_OK) status = rsv_relighter_create(on->subject.solution, &on->relighter);
    for (size_t k = 0; k < s->added.count && status == RSV_OK; k++) {
        rsv_punctual_light light = s->add[k];
        light.position = place_of_added(s->added.item[k], on->subject.scene);
        status = rsv_relighter_add_light(on->relighter, &light);
    }
    if (status == RSV_OK) status = prepare_sums(s, on);
    on->time_relight += cli_seconds() - started;
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}

/// Iterates until the light has converged, unless it has already.
static rsv_status settle(const stage *on)
{
    rsv_relight_progress progress = { 0 };
    rsv_status status = RSV_OK;
    if (on->prepared) status = rsv_relighter_step(on->relighter, 0, &progress);
    bool is_there = progress.converged && progress.orders == 0;
    return status == RSV_OK && !is_there ? rsv_relighter_refine(on->relighter) : status;
}

/// Changes the light to that of the frame.
static rsv_status relight(const settings *s, stage *on)
{
    double started = cli_seconds();
    rsv_status status = rsv_relighter_change(on->relighter, &s->relight);
    if (status == RSV_OK && !on->mix) status = settle(on);
    on->time_relight += cli_seconds() - started;
    return status;
}

static bool keeps_operators(const settings *s)
{
    bool any = false;
    for (size_t k = 0; k < s->outputs.count; k++)
        any = any || is_operator_name(s->outputs.item[k]);
    return any;
}

static bool run_frame(cli_session *session, settings *s, stage *on, uint32_t frame)
{
    enter_frame(s, frame);
    rsv_status status = relight(s, on);
    if (status == RSV_OK) status = write_outputs(s, on, frame);
    if (status != RSV_OK) cli_report_failure(session, status);
    on->frame_count++;
    return status == RSV_OK;
}

/// Relights the light as it is at rest, for all frames to follow from.
static bool begin_sequence(cli_session *session, settings *s, stage *on)
{
    enter_frame(s, s->sequence.first);
    rsv_status status = relight(s, on);
    on->relight_rays = (double)rsv_relighter_rays(on->relighter);
    rsv_relighter_destroy(on->relighter);
    on->relighter = NULL;
    if (status == RSV_OK)
        status =
            rsv_animation_open_document(rsv_light_scene(on->subject.solution), &session->animation);
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}

typedef struct sequence_run {
    cli_session *session;
    settings *s;
    stage *on;
} sequence_run;

/// Renders the moment in hand, and adds it to its frame.
static rsv_status expose(const settings *s, stage *on)
{
    double started = cli_seconds();
    rsv_image *image = NULL;
    rsv_status status = render(s, on, &image);
    if (status == RSV_OK) cli_add_moment(&s->sequence, image, &on->exposed);
    on->time_render += cli_seconds() - started;
    return status;
}

/// Takes the light to a moment of a frame. @param own whether this process renders the frame
static bool run_moment(const sequence_run *run, uint32_t frame, uint32_t moment, bool own)
{
    settings *s = run->s;
    stage *on = run->on;
    rsv_scene *scene = NULL;
    run->session->moment = (cli_moment){ cli_frame_time(&s->sequence, frame, moment), s->clip };
    if (!cli_load_moment(run->session, s->scene, &scene)) return false;
    double started = cli_seconds();
    bool finished = s->mode == RSV_RENDER_OPERATOR;
    rsv_status status = cli_follow_frame(on->subject.solution, scene, finished, &on->updates);
    on->time_relight += cli_seconds() - started;
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    if (on->camera < view->camera_count) on->viewpoint = &view->camera[on->camera];
    on->moment = moment;
    if (status == RSV_OK && own) status = expose(s, on);
    if (status != RSV_OK) cli_report_failure(run->session, status);
    on->viewpoint = NULL;
    rsv_scene_destroy(scene);
    return status == RSV_OK;
}

/// Each process follows all frames, so that they are the same for any number, and renders those that are its own.
static bool run_sequence_frame(void *user, uint32_t frame)
{
    const sequence_run *run = user;
    settings *s = run->s;
    stage *on = run->on;
    if (cli_crew_alarmed()) return true;
    bool own = (s->sequence.last - frame) % cli_crew_size() == cli_crew_rank(), good = true;
    for (uint32_t k = 0; k < cli_moments_of_frame(&s->sequence) && good; k++)
        good = run_moment(run, frame, k, own);
    rsv_status status = good && own ? write_outputs(s, on, frame) : RSV_OK;
    if (status != RSV_OK) cli_report_failure(run->session, status);
    rsv_image_destroy(on->exposed);
    on->exposed = NULL;
    on->frame_count += own;
    return good && status == RSV_OK;
}

static bool run_sequence(cli_session *session, settings *s, stage *on)
{
    sequence_run run = { session, s, on };
    bool good = begin_sequence(session, s, on) &&
                cli_run_frames(session, &s->sequence, run_sequence_frame, &run);
    cli_close_animation(session);
    return good;
}

/// Those frames that are this process's: several take turns, the first of them with the last, whose statistics count.
static bool run_frames(cli_session *session, settings *s, stage *on)
{
    uint32_t first = s->animation.first, last = s->animation.last, count = last - first + 1;
    for (uint32_t frame = first; frame <= last && !cli_crew_alarmed(); frame++) {
        if ((last - frame) % cli_crew_size() != cli_crew_rank()) continue;
        if (count > 1) cli_progress_part(&session->progress, "frame", frame - first + 1, count);
        if (!run_frame(session, s, on, frame)) return false;
    }
    return true;
}

static int run(cli_session *session, settings *s)
{
    stage on = { .frame_count = 0 };
    uint32_t frames = s->animation.last - s->animation.first + 1;
    if (!cli_is_operator(s->scene)) return CLI_FAILURE;
    session->keep_document = keeps_operators(s) || s->sequence.frames;
    if (s->object && !(s->body = cli_open_scene(session, s->object, NULL))) return CLI_FAILURE;
    if (frames > 1) cli_progress_part(&session->progress, "frame", 0, frames);
    bool good = set_stage(session, s, &on) &&
                (s->sequence.frames ? run_sequence : run_frames)(session, s, &on);
    if (good && s->stats) good = finish_stats(session, s, &on);
    rsv_light_mix_destroy(on.mix);
    rsv_relighter_destroy(on.relighter);
    cli_close_subject(&on.subject);
    return good ? CLI_SUCCESS : CLI_FAILURE;
}

/// Before several processes read the file each for itself.
static bool is_same_everywhere(const settings *s)
{
    cli_session session;
    if (cli_crew_size() == 1) return true;
    if (!cli_session_begin(&session, s->threads)) return false;
    rsv_status status = rsv_operator_compare(session.context, s->scene);
    if (status != RSV_OK) cli_report_failure(&session, status);
    cli_session_end(&session);
    return status == RSV_OK;
}

int cli_relight(int argc, char **argv)
{
    settings s = { .mode = RSV_RENDER_FINAL,
        .sequence = CLI_DEFAULT_SEQUENCE,
        .samples = 9,
        .exposure = CLI_AUTO_EXPOSURE,
        .env_intensity = 1,
        .env_rotate = NAN };
    int exit_status;
    cli_session session;
    if (parse_settings(&s, argc, argv, &exit_status)) {
        exit_status = CLI_FAILURE;
        bool same = is_same_everywhere(&s);
        cli_crew_disperse();
        if (same && check_outputs(&s) && cli_device_open(s.device) &&
            cli_session_begin(&session, s.threads)) {
            exit_status = run(&session, &s);
            rsv_scene_destroy(s.body);
            cli_session_end(&session);
        }
    }
    cli_free_light_script(&s.animation);
    for (size_t k = 0; k < sizeof s.name / sizeof *s.name; k++)
        free(s.name[k]);
    return exit_status;
}
