#include "command.h"
#include "crew.h"
#include "device.h"
#include "exposure.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "photometry.h"
#include "subject.h"
#include "view/view_editor.h"
#include "view/view_hud.h"
#include "view/view_player.h"
#include "view/view_script.h"
#include "view/view_show.h"
#include "view/view_window.h"

#include <cJSON.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "usage: resolvent view SCENE [options]\n"
    "\n"
    "Opens a window that shows SCENE (a file, a built-in scene, or a file from `resolvent solve`). Fly\n"
    "around, drag lights, change their strength and colour, and show single bounces of light. F1 in the\n"
    "window lists keys and mouse actions. A scene that is not solved yet appears at once as a sketch, and\n"
    "improves while it is solved in the background.\n"
    "\n"
    "  --size WxH         pixels of the window (default 960x540)\n"
    "  --camera NAME      the camera to start with\n"
    "  --object FILE      a rigid object that moves, with its shadow and reflections: drag its ring, or\n"
    "                     use `place` in a script (docs/view.md)\n"
    "  --exposure STOPS   brighten by 2^STOPS at the start (default: automatic for files, and printed; 0\n"
    "                     for built-in scenes)\n"
    "  --budget MS        milliseconds per frame for the light after a change: for its orders, and for\n"
    "                     following moving objects, those first that change the picture most; at least\n"
    "                     one goes on in each frame (default 8). Not with --record\n"
    "  --script FILE      commands for given frames: `FRAME COMMAND`, or `FIRST-LAST COMMAND`\n"
    "  --frames N         close after N frames\n"
    "  --stats FILE.json  when each quality was first shown, and frame times\n"
    "  --record DIR       write each frame to DIR/frame-0000.png, ... instead of opening a window; as\n"
    "                     many as --frames or the script says. Repeated runs give the same pictures,\n"
    "                     except for the times shown (`show hud` hides them)\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_MOMENT_HELP CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_SOLVE_HELP
    "  --threads N        default: one per core\n" CLI_DEVICE_HELP "\n"
    "script commands:\n"
    "  orbit YAW PITCH        rotate about the middle of the scene, degrees\n"
    "  look YAW PITCH         rotate the camera, degrees\n"
    "  fly RIGHT UP FORWARD   move the camera, metres\n"
    "  dolly FACTOR           multiply the distance by FACTOR\n"
    "  camera NAME            go to a camera of the scene\n"
    "  select ITEM            light.NAME, albedo.MATERIAL, environment or object; next, previous, none\n"
    "  intensity SCALE        set the selected light; `brighten STOPS` changes it\n"
    "  color R G B            set factors of a light, or a material's albedo; `tint R G B` adds to them\n"
    "  move X Y Z             move the selected light or object, metres from where it started; `nudge`\n"
    "                         adds to that\n"
    "  place X Y Z DEG        move the object, metres from its position in its file, and turn it about\n"
    "                         the vertical\n"
    "  add NAME X Y Z         add a point light, and select it\n"
    "  albedo MATERIAL R G B  set a base colour\n"
    "  env-rotate DEG         rotate the environment; `turn DEG` adds to that\n"
    "  object NAME            select an object of the scene for the following; none. `grasp X Y` selects\n"
    "                         the one seen there\n"
    "  shift X Y Z            move it, metres; `haul DX DY` moves it parallel to the picture\n"
    "  spin DEG               turn it about the vertical through its middle\n"
    "  resize FACTOR          scale it; it stays on the floor\n"
    "  hide                   hide it or show it again\n"
    "  duplicate              repeat it beside itself, and select the copy\n"
    "  delete                 delete it\n"
    "  paint R G B            base colour of its material; `surface ROUGHNESS METALNESS`\n"
    "  undo                   undo the last of these\n"
    "  save FILE.glb          save the edited scene\n"
    "  play                   play the animation of a glTF file, or pause it; `pause`\n"
    "  scrub S                go to S seconds of the animation; `step S` adds to that\n"
    "  speed X                play X times as fast\n"
    "  mode NAME              operator, final, occlusion, occlusion-screen, error, next\n"
    "  layer NAME             all, emission, direct, a number of bounces, next, previous\n"
    "  exposure STOPS         set the exposure; `expose STOPS` adds to it\n"
    "  tone NAME              clip, soft, next\n"
    "  show WHAT              switch on or off: hud, help, stereo, markers\n"
    "  separation METRES      distance between the eyes in stereo\n"
    "  pick X Y, drag DX DY, release   the mouse; the picture is 1 wide and 1 high\n"
    "  point X Y              read lux there from now on, as under the mouse; scripts print it\n"
    "  screenshot FILE        save the picture without panels: .png, .exr, .hdr\n"
    "  panorama FILE          save an equirectangular picture from the camera\n"
    "  reset                  undo everything\n"
    "  quit\n"
    "\n"
    "examples:\n"
    "  resolvent view cornell-spheres\n"
    "  resolvent view room.safetensors --size 1920x1080\n"
    "  printf '0 select light.light\\n0-59 orbit 2 0\\n30 intensity 2\\n' >tour.txt\n"
    "  resolvent view cornell-blocks --script tour.txt --record tour\n";

typedef struct settings {
    const char *scene, *camera, *script, *record, *mesh, *object, *stats;
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_solve_choice solve;
    cli_size size;
    uint32_t frames, threads; ///< 0 = as long as it takes; one per processor
    int device;
    float budget_ms, exposure;
} settings;

/// Everything that is open.
typedef struct viewer {
    const settings *settings;
    cli_session *session;
    cli_subject subject;
    rsv_scene *body; ///< that moves; NULL = none
    cli_view_show show;
    cli_view_state state;
    cli_view_script script;
    cli_view_hud hud;
    cli_view_player player;
    cli_view_editor editor;
    cli_canvas canvas;
    bool made_folder;            ///< for the frames, which was not there before
    bool exposes;                ///< the first light is still to say how bright it is shown
    cli_window *window;          ///< NULL = recording
    uint32_t frame, frame_count; ///< so far; at most
    double *time_ms;             ///< [time_count] of frames, for the statistics
    size_t time_count;
    float told[2]; ///< where lux were said last
} viewer;

enum { CLI_VIEW_MOST_TIMES = 100000 };

/// Seconds of an animation from one recorded frame to the next.
#define RECORDED_STEP (1.0 / 24)

// ---- options ----------------------------------------------------------------------------------------

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "--size", .kind = CLI_SIZE, .value = &s->size, .min = 1, .max = 16384 },
        { .name = "--camera", .kind = CLI_TEXT, .value = &s->camera },
        { .name = "--object", .kind = CLI_TEXT, .value = &s->object },
        { .name = "--budget", .kind = CLI_REAL, .value = &s->budget_ms, .min = 0.01, .max = 1e6 },
        CLI_EXPOSURE_OPTION(&s->exposure),
        { .name = "--script", .kind = CLI_TEXT, .value = &s->script },
        { .name = "--frames",
            .kind = CLI_COUNT,
            .value = &s->frames,
            .min = 1,
            .max = CLI_VIEW_MOST_FRAMES },
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = "--record", .kind = CLI_TEXT, .value = &s->record },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_DEVICE_OPTION(&s->device),
        CLI_MESH_OPTION(&s->mesh),
        CLI_MOMENT_OPTIONS(&s->moment),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        CLI_FOG_OPTIONS(&s->environment),
        { .name = NULL },
    };
    const cli_usage usage = { "view", help, options, "SCENE", 1, 1,
        "--size --camera --exposure --object --script --record --env --quality" };
    return cli_parse(&usage, argc, argv, &s->scene, exit_status);
}

// ---- opening ------------------------------------------------------------------------------------------

static bool report(viewer *v, rsv_status status)
{
    if (status != RSV_OK) cli_report_failure(v->session, status);
    return status == RSV_OK;
}

/// @param light NULL = none yet
static bool begin_state(viewer *v, const rsv_light *light)
{
    const float time = v->settings->moment.time;
    uint32_t layers = light ? 1 + rsv_light_order_count(light) : 1;
    const rsv_scene *scene = light ? rsv_light_scene(light) : v->subject.scene;
    uint32_t camera = rsv_scene_find_camera(v->subject.scene, v->settings->camera);
    if (camera == RSV_NONE) {
        cli_error("--camera: %s has no camera '%s'; `resolvent info %s` lists them",
            v->settings->scene, v->settings->camera, v->settings->scene);
        return false;
    }
    if (!cli_view_state_begin(v->show.lit.relighter, scene, layers, v->body, &v->state)) {
        cli_error("out of memory");
        return false;
    }
    v->state.camera = v->state.scene->camera[camera];
    v->exposes = cli_exposes(v->session, v->settings->scene, v->settings->exposure);
    if (!isnan(v->settings->exposure)) cli_view_expose(&v->state, v->settings->exposure);
    v->state.time = isfinite(time) ? (double)time : 0;
    v->player = (cli_view_player){ .session = v->session,
        .path = v->settings->scene,
        .clip_name = v->settings->moment.clip,
        .turns = { .budget_ms = v->settings->record ? 0 : (double)v->settings->budget_ms },
        .step = v->settings->record ? RECORDED_STEP : 0 };
    return true;
}

/// Chooses the exposure once, for the first solved light.
static rsv_status expose(viewer *v)
{
    float stops = 0;
    if (!v->exposes || !cli_show_is_lit(&v->show)) return RSV_OK;
    v->exposes = false;
    uint32_t camera = rsv_scene_find_camera(v->subject.scene, v->settings->camera);
    rsv_status status = cli_expose_light(v->session, true, v->show.lit.light, camera, &stops);
    if (status == RSV_OK) cli_view_expose(&v->state, stops);
    return status;
}

static bool set_canvas(cli_canvas *canvas, uint32_t width, uint32_t height)
{
    if (canvas->pixel && canvas->width == width && canvas->height == height) return true;
    free(canvas->pixel);
    *canvas = (cli_canvas){ width, height, calloc((size_t)width * height, 4) };
    if (!canvas->pixel) cli_error("out of memory");
    return canvas->pixel != NULL;
}

/// Makes the light before anything is shown: frames are the same every time.
static bool await_light(viewer *v)
{
    const settings *s = v->settings;
    cli_lit *lit = &v->show.lit;
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    bool is_file = v->subject.solution != NULL;
    if (!report(v, cli_solve_subject(v->session, &desc, NULL, &v->subject, NULL))) return false;
    lit->name = is_file ? "solved" : cli_quality_names[s->solve.quality];
    lit->light = v->subject.solution;
    v->subject.solution = NULL;
    if (!report(v, rsv_relighter_create(lit->light, &lit->relighter)) ||
        !report(v, rsv_relighter_prepare(lit->relighter)))
        return false;
    double budget = s->record ? 0 : (double)s->budget_ms;
    return report(v, cli_view_frames_create(lit->light, v->body, budget, &lit->frames)) &&
           report(v, cli_view_frames_attach(lit->frames, lit->relighter));
}

/// Shows the scene at once, and makes its light meanwhile.
static bool begin_show(viewer *v)
{
    const settings *s = v->settings;
    cli_refiner_desc desc = { .session = v->session,
        .scene = v->subject.scene,
        .light = v->subject.solution,
        .solve = cli_describe_solve(&s->solve),
        .quality = (rsv_quality)s->solve.quality,
        .body = v->body,
        .budget_ms = (double)s->budget_ms,
        .width = s->size.width,
        .height = s->size.height,
        .keeps_pace = !s->script };
    v->subject.solution = NULL;
    return cli_show_begin(&v->show, &desc, cli_thread_count(s->threads));
}

/// Devices and teams of processes belong to one thread; scripts of solved scenes give the same frames every time.
static bool must_await(const viewer *v)
{
    const settings *s = v->settings;
    return s->record || cli_device() || cli_crew() || (s->script && v->subject.solution);
}

/// A file that can be played is shown at the start of its animation: its scenes have the same surfaces at all times.
static void open_animation(viewer *v)
{
    cli_session *session = v->session;
    const rsv_load_desc load = cli_describe_load(session);
    rsv_animation *animation = NULL;
    if (isfinite(session->moment.time) || !cli_view_is_playable(v->settings->scene)) return;
    if (rsv_animation_open(session->context, v->settings->scene, &load, &animation) != RSV_OK ||
        rsv_animation_clip_count(animation) == 0) {
        rsv_animation_destroy(animation); // errors are shown when it is to be played
        return;
    }
    session->animation = animation;
    session->moment.time = 0;
}

static bool open_light(viewer *v)
{
    const settings *s = v->settings;
    open_animation(v);
    v->session->keep_document = rsv_is_operator_file(s->scene); // it may hold an animation
    if (!cli_open_subject(v->session, s->scene, &s->environment, &v->subject)) return false;
    v->session->moment = CLI_AT_REST; // the moment is the scene's only
    if (s->object && !(v->body = cli_open_scene(v->session, s->object, NULL))) return false;
    const rsv_solve_desc solve = cli_describe_solve(&s->solve);
    cli_view_editor_begin(&v->editor, v->subject.scene, &solve);
    cli_progress_clear(&v->session->progress);
    return must_await(v) ? await_light(v) : begin_show(v);
}

static uint32_t count_frames(const viewer *v)
{
    uint32_t scripted = cli_view_script_length(&v->script);
    if (v->settings->frames) return v->settings->frames;
    if (!v->settings->record) return UINT32_MAX;
    return scripted ? scripted : 1;
}

/// Checks everything that can be checked before the long work.
static bool open_viewer(viewer *v)
{
    const settings *s = v->settings;
    char title[CLI_VIEW_TEXT_LENGTH];
    if (s->script && !cli_read_view_script(s->script, &v->script)) return false;
    v->frame_count = count_frames(v);
    snprintf(title, sizeof title, "%.200s - resolvent", s->scene);
    if (s->record && !cli_make_folder("--record", s->record, &v->made_folder)) return false;
    if (!s->record) v->window = cli_window_open(title, s->size.width, s->size.height);
    if (!s->record && !v->window) return false;
    const char *slash = strrchr(s->scene, '/');
    v->hud.scene = slash ? slash + 1 : s->scene;
    return open_light(v) && begin_state(v, v->show.lit.light) && report(v, expose(v)) &&
           set_canvas(&v->canvas, s->size.width, s->size.height);
}

static void close_viewer(viewer *v)
{
    cli_window_close(v->window);
    cli_free_view_script(&v->script);
    cli_view_state_free(&v->state);
    cli_show_end(&v->show);
    cli_view_player_end(&v->player);
    cli_view_editor_end(&v->editor);
    rsv_scene_destroy(v->body);
    cli_close_subject(&v->subject);
    free(v->canvas.pixel);
    free(v->time_ms);
    if (v->made_folder) rmdir(v->settings->record); // only succeeds if no frame was written
}

// ---- frames ---------------------------------------------------------------------------------------------

static bool apply(viewer *v, const cli_view_command *command, char *problem)
{
    return cli_view_edits(command->verb)
               ? cli_view_editor_apply(&v->editor, &v->state, command, problem)
               : cli_view_apply(&v->state, command, problem);
}

/// Carries out a command of the window; errors appear in the window.
static void obey(void *user, const char *text)
{
    viewer *v = user;
    cli_view_command command;
    v->hud.message[0] = '\0';
    if (!cli_read_view_command(text, &command, v->hud.message)) return;
    if (cli_view_needs_light(command.verb) && !cli_show_is_complete(&v->show))
        snprintf(
            v->hud.message, sizeof v->hud.message, "%s: available once all light is solved", text);
    else
        apply(v, &command, v->hud.message);
}

static bool run_script(viewer *v)
{
    char problem[CLI_VIEW_TEXT_LENGTH];
    for (size_t k = 0; k < v->script.line_count; k++) {
        const cli_view_script_line *line = &v->script.line[k];
        if (v->frame < line->first || v->frame > line->last) continue;
        if (apply(v, &line->command, problem)) continue;
        cli_error("%s:%zu: %s", v->script.path, line->number, problem);
        return false;
    }
    return true;
}

/// Shows whether a file was written. A failure ends the program only in scripts.
static bool note_saved(viewer *v, rsv_status status, const char *path)
{
    snprintf(v->hud.message, sizeof v->hud.message, "%s%.200s",
        status == RSV_OK ? "" : "not written: ", status == RSV_OK ? path : rsv_last_error());
    return status == RSV_OK || (v->window && !v->script.path) || report(v, status);
}

static bool save_wanted(viewer *v)
{
    cli_view_state *s = &v->state;
    bool good = true;
    if (s->screenshot[0])
        good = note_saved(
            v, cli_view_save_picture(v->show.lit.frames, &v->canvas, s->screenshot), s->screenshot);
    if (s->panorama[0] && good)
        good =
            note_saved(v, cli_view_save_panorama(v->show.lit.light, s, s->panorama), s->panorama);
    s->screenshot[0] = s->panorama[0] = '\0';
    return good;
}

static bool record(viewer *v)
{
    char path[PATH_MAX];
    int length = snprintf(path, sizeof path, "%s/frame-%04u.png", v->settings->record, v->frame);
    if (length < 0 || length >= PATH_MAX) {
        cli_error("--record %s: the name is too long", v->settings->record);
        return false;
    }
    return report(v, cli_view_save_picture(v->show.lit.frames, &v->canvas, path));
}

/// A change of the light that cannot be made, such as an albedo of 1 all around.
static bool is_refusal(rsv_status status)
{
    return status == RSV_ERROR_ARGUMENT || status == RSV_ERROR_UNSUPPORTED ||
           status == RSV_ERROR_SCENE;
}

/// Makes a frame. In a window, changes that are refused show a message, and the frame keeps the previous light.
static bool make_frame(viewer *v, cli_view_timing *timing)
{
    rsv_status status = cli_show_update(&v->show, &v->state);
    if (status == RSV_OK) status = expose(v);
    if (status == RSV_OK) status = cli_show_frame(&v->show, &v->state, &v->canvas, timing);
    if (!v->window || !is_refusal(status)) return report(v, status);
    snprintf(v->hud.message, sizeof v->hud.message, "%.250s", rsv_last_error());
    status = cli_show_frame(&v->show, &v->state, &v->canvas, timing);
    return is_refusal(status) || report(v, status);
}

static void note_time(viewer *v, const cli_view_timing *timing)
{
    if (!v->settings->stats || v->time_count == CLI_VIEW_MOST_TIMES) return;
    if (!v->time_ms) v->time_ms = calloc(CLI_VIEW_MOST_TIMES, sizeof *v->time_ms);
    if (v->time_ms) v->time_ms[v->time_count++] = timing->total_ms;
}

/// Shows which light is displayed, which one is being computed, or why no better one will come.
static void note_quality(viewer *v)
{
    v->hud.quality = cli_show_is_lit(&v->show) ? v->show.lit.name : "sketch";
    v->hud.making[0] = '\0';
    if (v->show.refiner) cli_refiner_say(v->show.refiner, v->hud.making);
    if (!v->show.message[0]) return;
    cli_error("%s", v->show.message);
    snprintf(v->hud.message, sizeof v->hud.message, "%s", v->show.message);
    v->show.message[0] = '\0';
}

/// Lux at the place that was pointed at; a script says it once for each new place.
static void read_pointer(viewer *v)
{
    rsv_rgb irradiance;
    const float *place = v->state.pointer;
    v->hud.reading[0] = '\0';
    if (!v->state.points || v->state.stereo || !cli_show_is_lit(&v->show)) return;
    if (rsv_read_picture_point(v->show.lit.light, &v->state.camera, v->canvas.width,
            v->canvas.height, place, &irradiance))
        snprintf(v->hud.reading, sizeof v->hud.reading, "%.4g lux", cli_luminous(irradiance));
    bool told = v->told[0] == place[0] && v->told[1] == place[1];
    if (!v->script.path || told) return;
    printf("frame %u: %g %g: %s\n", v->frame, (double)place[0], (double)place[1],
        v->hud.reading[0] ? v->hud.reading : "no surface that stores light");
    v->told[0] = place[0], v->told[1] = place[1];
}

/// Scripts begin with the first light, or, where they do more than to move about, with the best one.
static bool can_run_script(const viewer *v)
{
    return cli_view_script_needs_light(&v->script) ? cli_show_is_complete(&v->show)
                                                   : cli_show_is_lit(&v->show);
}

/// Plays or edits: an edited scene is no longer that of the file.
static bool move_objects(viewer *v, char *problem)
{
    bool played = v->player.scene != NULL, wanted = v->state.plays || v->state.sought;
    v->editor.played = played;
    cli_view_editor_say(&v->editor, v->hud.object);
    if (!played && wanted && v->editor.past_count > 0) {
        v->state.plays = v->state.sought = false;
        snprintf(problem, CLI_VIEW_TEXT_LENGTH, "an edited scene cannot be played");
        return false;
    }
    return cli_view_play(&v->player, &v->show, &v->state, &v->hud.lag_ms, problem) &&
           cli_view_edit(&v->editor, &v->show, &v->state, &v->hud.lag_ms, problem);
}

/// What cannot be played or edited is said in the window, where one can go on.
static bool play(viewer *v)
{
    char problem[CLI_VIEW_TEXT_LENGTH];
    if (move_objects(v, problem)) return true;
    snprintf(v->hud.message, sizeof v->hud.message, "%s", problem);
    if (v->window && !v->script.path) return true;
    cli_error("%s: %s", v->settings->scene, problem);
    return false;
}

static bool run_frame(viewer *v)
{
    cli_view_timing timing;
    bool waits = v->script.path && !can_run_script(v);
    if ((!waits && !run_script(v)) || !play(v) || !make_frame(v, &timing) || !save_wanted(v))
        return false;
    note_quality(v);
    read_pointer(v);
    note_time(v, &timing);
    cli_view_hud_note(&v->hud, &timing);
    cli_view_hud_draw(&v->hud, &v->state, &v->canvas);
    bool good = v->window ? cli_window_show(v->window, &v->canvas) : record(v);
    if (waits && v->show.failed) return false; // the light will not come
    v->frame += !waits;
    if (v->window) cli_show_yield(&v->show, timing.total_ms);
    return good;
}

static int compare_times(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/// How long the light took from frame to frame of an animation.
static void add_steps(cJSON *root, const cli_turns *turns)
{
    if (!turns->steps) return;
    cJSON_AddNumberToObject(root, "steps", turns->steps);
    cJSON_AddNumberToObject(root, "mean_step_ms", turns->sum_ms / turns->steps);
    cJSON_AddNumberToObject(root, "longest_step_ms", turns->longest_ms);
    cJSON_AddNumberToObject(root, "late_steps", turns->late_frames);
}

/// Writes when each light appeared, in seconds since the start, and how long frames took.
static bool write_stats(viewer *v)
{
    if (!v->settings->stats) return true;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "command", "view");
    cJSON_AddStringToObject(root, "scene", v->settings->scene);
    cJSON *shown = cJSON_AddObjectToObject(root, "shown_s");
    for (uint32_t k = 0; k < v->show.event_count; k++)
        cJSON_AddNumberToObject(
            shown, v->show.event[k].name, v->show.event[k].when - v->session->started);
    cJSON *processor = cJSON_AddObjectToObject(root, "shown_processor_s");
    for (uint32_t k = 0; k < v->show.event_count; k++)
        cJSON_AddNumberToObject(processor, v->show.event[k].name, v->show.event[k].processor);
    cJSON_AddNumberToObject(root, "frames", (double)v->time_count);
    add_steps(root, &v->player.turns);
    if (v->time_count > 0) {
        qsort(v->time_ms, v->time_count, sizeof *v->time_ms, compare_times);
        cJSON_AddNumberToObject(root, "median_ms", v->time_ms[v->time_count / 2]);
        cJSON_AddNumberToObject(root, "worst_ms", v->time_ms[v->time_count - 1]);
    }
    bool written = cli_write_json(v->settings->stats, root);
    cJSON_Delete(root);
    return written;
}

/// @return whether there is anything to draw on
static bool listen(viewer *v)
{
    uint32_t width, height;
    bool rests = v->frame > 0 && !v->script.path && !v->state.plays && cli_show_at_rest(&v->show);
    cli_window_size(v->window, &width, &height);
    int wait_ms = !rests && width ? 0 : v->show.refiner ? 20 : 100;
    cli_window_listen(v->window, 0.4f * v->state.reach, wait_ms, obey, v);
    cli_window_size(v->window, &width, &height);
    return width > 0 && set_canvas(&v->canvas, width, height);
}

static bool run(viewer *v)
{
    while (v->frame < v->frame_count && !v->state.quit) {
        if (cli_interrupted()) return report(v, RSV_ERROR_CANCELLED);
        if (v->window && !listen(v)) continue;
        if (!run_frame(v)) return false;
    }
    return true;
}

int cli_view(int argc, char **argv)
{
    settings s = { .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST,
        .solve = CLI_DEFAULT_SOLVE,
        .size = { 960, 540 },
        .budget_ms = 8,
        .exposure = CLI_AUTO_EXPOSURE };
    cli_session session;
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    if (!cli_prepare_solve(&s.solve) || !cli_device_open(s.device) ||
        !cli_session_begin(&session, s.threads))
        return CLI_FAILURE;
    session.mesh = s.mesh;
    session.moment = s.moment;
    session.reading = s.reading;
    session.max_bytes = s.solve.max_bytes;
    viewer v = { .settings = &s, .session = &session, .told = { -1, -1 } };
    bool good = open_viewer(&v);
    cli_progress_clear(&session.progress);
    session.progress.muted = true; // from here on frames show how far things are
    good = good && run(&v) && !v.show.failed && write_stats(&v);
    close_viewer(&v);
    cli_session_end(&session);
    return good ? CLI_SUCCESS : CLI_FAILURE;
}
