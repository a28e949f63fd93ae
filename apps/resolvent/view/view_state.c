#include "view_state.h"

#include "view_camera.h"
#include "view_items.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// A light is picked from within this part of the picture's height.
#define PICK_RADIUS 0.03f
#define MOST_STOPS 64.0f
/// Cameras stay within this many times the scene's size from its middle.
#define FARTHEST_CAMERA 1e4f

const char *const cli_view_mode_names[] = { "operator", "final", "occlusion", "occlusion-screen",
    "error", NULL };

static void begin_pose(cli_view_state *s)
{
    const rsv_vec3 *low = &s->scene->bounds_min, *high = &s->scene->bounds_max;
    s->camera = s->scene->camera[0];
    s->pivot = (rsv_vec3){ 0.5f * (low->x + high->x), 0.5f * (low->y + high->y),
        0.5f * (low->z + high->z) };
    float x = high->x - s->pivot.x, y = high->y - s->pivot.y, z = high->z - s->pivot.z;
    s->reach = sqrtf(x * x + y * y + z * z);
}

/// Everything but the window's own choices.
static void reset(cli_view_state *s)
{
    begin_pose(s);
    memcpy(s->item, s->home, s->item_count * sizeof *s->item);
    s->env_rotation = s->home_rotation;
    s->selected = s->item_count;
    s->grabbed = false;
    s->mode = CLI_VIEW_OPERATOR;
    s->layer = RSV_NONE;
    s->exposure = s->own_exposure;
    s->soft = false;
    s->object_turn = 0;
    s->light_changes++;
    s->object_changes++;
}

bool cli_view_state_begin(const rsv_relighter *relighter, const rsv_scene *scene,
    uint32_t layer_count, const rsv_scene *body, cli_view_state *s)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    size_t most = (relighter ? rsv_relighter_source_count(relighter) : 0) + view->material_count +
                  1 + CLI_VIEW_MOST_ADDED;
    *s = (cli_view_state){ .scene = view,
        .aspect = 1,
        .layer_count = layer_count,
        .hud = true,
        .markers = true,
        .separation = 0.064f,
        .speed = 1,
        .home_rotation = view->environment ? view->environment->rotation : 0 };
    s->item = calloc(most + 1, sizeof *s->item);
    s->home = calloc(most + 1, sizeof *s->home);
    s->taken = calloc(most + 1, sizeof *s->taken);
    if (!s->item || !s->home || !s->taken) return false;
    cli_view_list_items(s, relighter, body);
    reset(s);
    cli_view_note_taken(s);
    s->light_changes = s->object_changes = 0;
    return true;
}

void cli_view_state_continue(cli_view_state *s, const cli_view_state *earlier)
{
    s->camera = earlier->camera;
    s->aspect = earlier->aspect;
    s->exposure = earlier->exposure;
    s->own_exposure = earlier->own_exposure;
    s->soft = earlier->soft;
    s->stereo = earlier->stereo;
    s->hud = earlier->hud;
    s->help = earlier->help;
    s->markers = earlier->markers;
    s->separation = earlier->separation;
    s->quit = earlier->quit;
    s->plays = earlier->plays;
    s->sought = earlier->sought;
    s->time = earlier->time;
    s->length = earlier->length;
    s->speed = earlier->speed;
    s->points = earlier->points;
    memcpy(s->pointer, earlier->pointer, sizeof s->pointer);
    if (s->object >= s->item_count || earlier->object >= earlier->item_count) return;
    s->item[s->object].offset = earlier->item[earlier->object].offset;
    s->object_turn = earlier->object_turn;
    s->object_changes = earlier->object_changes;
    if (earlier->selected == earlier->object) s->selected = s->object;
}

void cli_view_expose(cli_view_state *s, float stops)
{
    s->exposure += stops - s->own_exposure;
    s->own_exposure = stops;
}

void cli_view_state_free(cli_view_state *s)
{
    free(s->item);
    free(s->home);
    free(s->taken);
    *s = (cli_view_state){ 0 };
}

// ---- mouse ------------------------------------------------------------------------------------------

/// The light or object whose marker is nearest to a place in the picture.
static void pick(cli_view_state *s, float x, float y)
{
    float nearest = PICK_RADIUS;
    s->grabbed = false;
    if (s->stereo) return; // no markers to aim at
    for (size_t k = 0; k < s->item_count; k++) {
        float place[2];
        if (!(cli_view_place(s, &s->item[k], place) > 0)) continue;
        float distance = hypotf((place[0] - x) * s->aspect, place[1] - y);
        if (distance >= nearest) continue;
        nearest = distance;
        s->selected = k;
        s->grabbed = true;
    }
}

/// Half a turn across the picture, where no light is held.
static bool drag(cli_view_state *s, float dx, float dy, char *problem)
{
    float place[2];
    if (!s->grabbed) {
        cli_camera_orbit(&s->camera, s->pivot, -180 * dx, -90 * dy);
        return true;
    }
    float depth = cli_view_place(s, &s->item[s->selected], place);
    return depth <= 0 ||
           cli_view_nudge(s, cli_camera_drag(&s->camera, s->aspect, depth, dx, dy), problem);
}

// ---- the picture ------------------------------------------------------------------------------------

static bool set_mode(cli_view_state *s, const char *name, char *problem)
{
    if (strcmp(name, "next") == 0) {
        s->mode = (s->mode + 1) % CLI_VIEW_MODE_COUNT;
        return true;
    }
    for (int k = 0; cli_view_mode_names[k]; k++)
        if (strcmp(name, cli_view_mode_names[k]) == 0) {
            s->mode = (cli_view_mode)k;
            return true;
        }
    return cli_view_fail(problem, "'%.60s' is not a mode", name);
}

/// All, emission, direct, 1, 2, ... as one ring.
static bool set_layer(cli_view_state *s, const char *name, char *problem)
{
    uint32_t ring = s->layer_count + 1, at = s->layer == RSV_NONE ? 0 : s->layer + 1;
    char *end;
    long bounces = strtol(name, &end, 10);
    if (strcmp(name, "next") == 0)
        at = (at + 1) % ring;
    else if (strcmp(name, "previous") == 0)
        at = (at + ring - 1) % ring;
    else if (strcmp(name, "all") == 0)
        at = 0;
    else if (strcmp(name, "emission") == 0)
        at = 1;
    else if (strcmp(name, "direct") == 0)
        at = 2;
    else if (end != name && !*end && bounces > 0 && bounces + 2 < (long)ring)
        at = (uint32_t)bounces + 2;
    else
        return cli_view_fail(problem, "there is no layer '%.60s'", name);
    s->layer = at == 0 ? RSV_NONE : at - 1;
    return true;
}

static bool set_tone(cli_view_state *s, const char *name, char *problem)
{
    bool next = strcmp(name, "next") == 0, soft = strcmp(name, "soft") == 0;
    if (!next && !soft && strcmp(name, "clip") != 0)
        return cli_view_fail(problem, "'%.60s' is not a tone curve", name);
    s->soft = next ? !s->soft : soft;
    return true;
}

static bool toggle(cli_view_state *s, const char *name, char *problem)
{
    bool *flag = strcmp(name, "hud") == 0       ? &s->hud
                 : strcmp(name, "help") == 0    ? &s->help
                 : strcmp(name, "stereo") == 0  ? &s->stereo
                 : strcmp(name, "markers") == 0 ? &s->markers
                                                : NULL;
    if (!flag)
        return cli_view_fail(problem,
            "'%.60s' cannot be shown; use hud, help, stereo or "
            "markers",
            name);
    *flag = !*flag;
    return true;
}

static bool set_camera(cli_view_state *s, const char *name, char *problem)
{
    size_t count = s->scene->camera_count, k = 0;
    while (k < count && strcmp(s->scene->camera[k].name, name) != 0)
        k++;
    for (size_t n = 0; k == count && n < count; n++) {
        const char *node = s->scene->camera_node[n];
        if (node && strcmp(node, name) == 0) k = n;
    }
    if (k < count) {
        s->camera = s->scene->camera[k];
        return true;
    }
    return cli_view_fail(problem, "the scene has no camera '%.100s'", name);
}

static bool turn_to(cli_view_state *s, float degrees, char *problem)
{
    if (!s->scene->environment)
        return cli_view_fail(problem, "there is no environment to rotate%s", "");
    s->env_rotation = fmodf(degrees, 360);
    s->light_changes++;
    return true;
}

static void set_text(char *to, const char *from) { memcpy(to, from, CLI_VIEW_TEXT_LENGTH); }

// ---- all of them --------------------------------------------------------------------------------------

/// Leads the camera, but not to where nothing is left of the scene.
static void lead_camera(cli_view_state *s, const cli_view_command *c)
{
    const float *n = c->number;
    rsv_camera before = s->camera;
    if (c->verb == CLI_VIEW_LOOK) cli_camera_look(&s->camera, n[0], n[1]);
    if (c->verb == CLI_VIEW_ORBIT) cli_camera_orbit(&s->camera, s->pivot, n[0], n[1]);
    if (c->verb == CLI_VIEW_FLY) cli_camera_fly(&s->camera, n[0], n[1], n[2]);
    if (c->verb == CLI_VIEW_DOLLY && n[0] > 0) cli_camera_dolly(&s->camera, s->pivot, n[0]);
    const rsv_vec3 *p = &s->camera.position, *q = &s->pivot;
    float distance = fmaxf(fabsf(p->x - q->x), fmaxf(fabsf(p->y - q->y), fabsf(p->z - q->z)));
    bool orthographic = s->camera.vertical_fov == 0;
    float size = orthographic ? s->camera.vertical_extent : s->reach;
    if (!(distance <= FARTHEST_CAMERA * s->reach && size > s->reach / FARTHEST_CAMERA &&
            size < FARTHEST_CAMERA * s->reach))
        s->camera = before;
}

/// The animation: plays on, rests, goes to a moment, or runs faster.
static void lead_animation(cli_view_state *s, const cli_view_command *c)
{
    if (c->verb == CLI_VIEW_PLAY) s->plays = !s->plays;
    if (c->verb == CLI_VIEW_PAUSE) s->plays = false;
    if (c->verb == CLI_VIEW_SPEED) s->speed = c->number[0];
    if (c->verb == CLI_VIEW_SCRUB) s->time = c->exact[0];
    if (c->verb == CLI_VIEW_STEP) s->time = fmax(s->time + c->exact[0], 0);
    s->sought = s->sought || c->verb == CLI_VIEW_SCRUB || c->verb == CLI_VIEW_STEP;
}

/// Commands that cannot fail.
static void apply_plain(cli_view_state *s, const cli_view_command *c)
{
    const float *n = c->number;
    if (c->verb == CLI_VIEW_EXPOSURE) s->exposure = cli_view_within(n[0], MOST_STOPS);
    if (c->verb == CLI_VIEW_EXPOSE) s->exposure = cli_view_within(s->exposure + n[0], MOST_STOPS);
    if (c->verb == CLI_VIEW_SEPARATION) s->separation = n[0];
    if (c->verb == CLI_VIEW_PICK) pick(s, n[0], n[1]);
    if (c->verb == CLI_VIEW_RELEASE) s->grabbed = false;
    for (int k = 0; c->verb == CLI_VIEW_POINT && k < 2; k++) {
        s->points = true;
        s->pointer[k] = fminf(fmaxf(n[k], 0), 1);
    }
    if (c->verb == CLI_VIEW_SCREENSHOT) set_text(s->screenshot, c->text);
    if (c->verb == CLI_VIEW_PANORAMA) set_text(s->panorama, c->text);
    if (c->verb == CLI_VIEW_RESET) reset(s);
    if (c->verb == CLI_VIEW_QUIT) s->quit = true;
}

bool cli_view_apply(cli_view_state *s, const cli_view_command *c, char *problem)
{
    const float *n = c->number;
    switch (c->verb) {
    case CLI_VIEW_ADD:
        return cli_view_add_light(s, c, problem);
    case CLI_VIEW_ALBEDO:
        return cli_view_set_albedo(s, c, problem);
    case CLI_VIEW_BRIGHTEN:
        return cli_view_brighten(s, n[0], problem);
    case CLI_VIEW_CAMERA:
        return set_camera(s, c->text, problem);
    case CLI_VIEW_COLOR:
        return cli_view_set_color(s, s->selected, (rsv_rgb){ n[0], n[1], n[2] }, problem);
    case CLI_VIEW_DRAG:
        return drag(s, n[0], n[1], problem);
    case CLI_VIEW_ENV_ROTATE:
        return turn_to(s, n[0], problem);
    case CLI_VIEW_INTENSITY:
        return cli_view_set_scale(s, n[0], problem);
    case CLI_VIEW_LAYER:
        return set_layer(s, c->text, problem);
    case CLI_VIEW_MODE:
        return set_mode(s, c->text, problem);
    case CLI_VIEW_MOVE:
        return cli_view_move_to(s, (rsv_vec3){ n[0], n[1], n[2] }, problem);
    case CLI_VIEW_NUDGE:
        return cli_view_nudge(s, (rsv_vec3){ n[0], n[1], n[2] }, problem);
    case CLI_VIEW_PLACE:
        return cli_view_place_object(s, n, problem);
    case CLI_VIEW_SELECT:
        return cli_view_select(s, c->text, problem);
    case CLI_VIEW_SHOW:
        return toggle(s, c->text, problem);
    case CLI_VIEW_TINT:
        return cli_view_tint(s, n, problem);
    case CLI_VIEW_TONE:
        return set_tone(s, c->text, problem);
    case CLI_VIEW_TURN:
        return turn_to(s, s->env_rotation + n[0], problem);
    case CLI_VIEW_PAUSE:
    case CLI_VIEW_PLAY:
    case CLI_VIEW_SCRUB:
    case CLI_VIEW_SPEED:
    case CLI_VIEW_STEP:
        lead_animation(s, c);
        return true;
    case CLI_VIEW_DOLLY:
    case CLI_VIEW_FLY:
    case CLI_VIEW_LOOK:
    case CLI_VIEW_ORBIT:
        lead_camera(s, c);
        return true;
    default:
        apply_plain(s, c);
        return true;
    }
}
