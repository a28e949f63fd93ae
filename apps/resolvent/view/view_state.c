#include "view_state.h"

#include "view_camera.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// A light is picked from within this part of the picture's height.
#define PICK_RADIUS 0.03f
#define LARGEST_SCALE 1e6f
#define MOST_STOPS 64.0f
/// Lights stay within this many times the scene's size from its middle.
#define FARTHEST 10.0f
/// And cameras within this many.
#define FARTHEST_CAMERA 1e4f

const char *const cli_view_mode_names[] = { "operator", "final", "occlusion", "occlusion-screen",
    "error", NULL };

// ---- items ----------------------------------------------------------------------------------------

/// Materials whose colour is no part of the operator.
static bool is_plain(const rsv_scene_view *scene, size_t material)
{
    const rsv_material *m = &scene->material[material];
    rsv_rgb s = m->scatter_distance;
    return m->metallic == 0 && m->transmission == 0 && m->opacity == 1 &&
           m->diffuse_transmission == 0 && !scene->material_varies[material] &&
           s.r + s.g + s.b == 0;
}

static rsv_rgb hue(rsv_rgb color)
{
    float most = fmaxf(color.r, fmaxf(color.g, color.b));
    return most > 0 ? (rsv_rgb){ color.r / most, color.g / most, color.b / most }
                    : (rsv_rgb){ 1, 1, 1 };
}

static bool is_surroundings(const cli_view_state *s, size_t source, size_t count)
{
    return s->scene->environment && source + 1 == count; // they come last
}

static void list_items(cli_view_state *s, const rsv_relighter *relighter)
{
    size_t sources = rsv_relighter_source_count(relighter);
    for (size_t k = 0; k < sources; k++) {
        rsv_relight_source source = rsv_relighter_source(relighter, k);
        s->home[s->item_count++] = (cli_view_item){
            .kind = is_surroundings(s, k, sources) ? CLI_VIEW_ENVIRONMENT : CLI_VIEW_LIGHT,
            .name = source.name,
            .color = { 1, 1, 1 },
            .scale = 1,
            .home = source.position,
            .glow = hue(source.strength),
            .movable = source.movable,
        };
    }
    for (size_t m = 0; m < s->scene->material_count; m++)
        if (is_plain(s->scene, m))
            s->home[s->item_count++] = (cli_view_item){ .kind = CLI_VIEW_MATERIAL,
                .name = s->scene->material[m].name,
                .color = s->scene->material[m].base_color,
                .scale = 1 };
}

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
    s->exposure = 0;
    s->soft = false;
    s->light_changes++;
}

bool cli_view_state_begin(
    const rsv_relighter *relighter, const rsv_scene *scene, uint32_t layer_count, cli_view_state *s)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    size_t most =
        rsv_relighter_source_count(relighter) + view->material_count + CLI_VIEW_MOST_ADDED;
    *s = (cli_view_state){ .scene = view,
        .aspect = 1,
        .layer_count = layer_count,
        .hud = true,
        .markers = true,
        .separation = 0.064f,
        .home_rotation = view->environment ? view->environment->rotation : 0 };
    s->item = calloc(most + 1, sizeof *s->item);
    s->home = calloc(most + 1, sizeof *s->home);
    if (!s->item || !s->home) return false;
    list_items(s, relighter);
    reset(s);
    s->light_changes = 0;
    return true;
}

void cli_view_state_free(cli_view_state *s)
{
    free(s->item);
    free(s->home);
    *s = (cli_view_state){ 0 };
}

static const char *prefix_of(cli_view_kind kind)
{
    static const char *const prefixes[] = { "light.", "", "albedo." };
    return prefixes[kind];
}

void cli_view_item_name(const cli_view_item *item, char *text)
{
    snprintf(text, CLI_VIEW_TEXT_LENGTH, "%s%s", prefix_of(item->kind), item->name);
}

size_t cli_view_find_item(const cli_view_state *s, const char *name)
{
    size_t k = 0;
    char own[CLI_VIEW_TEXT_LENGTH];
    for (; k < s->item_count; k++) {
        cli_view_item_name(&s->item[k], own);
        if (strcmp(own, name) == 0) break;
    }
    return k;
}

float cli_view_place(const cli_view_state *s, const cli_view_item *item, float place[2])
{
    rsv_vec3 at = { item->home.x + item->offset.x, item->home.y + item->offset.y,
        item->home.z + item->offset.z };
    return item->kind == CLI_VIEW_LIGHT && item->movable
               ? cli_camera_project(&s->camera, s->aspect, at, place)
               : 0;
}

// ---- commands that concern what is selected ----------------------------------------------------------

static bool fail(char *problem, const char *format, const char *detail)
{
    snprintf(problem, CLI_VIEW_TEXT_LENGTH, format, detail);
    return false;
}

static bool select_item(cli_view_state *s, const char *name, char *problem)
{
    size_t count = s->item_count;
    s->grabbed = false;
    if (strcmp(name, "none") == 0)
        s->selected = count;
    else if (strcmp(name, "next") == 0)
        s->selected = s->selected >= count ? 0 : s->selected + 1;
    else if (strcmp(name, "previous") == 0)
        s->selected = s->selected == 0 ? count : s->selected - 1;
    else if (cli_view_find_item(s, name) < count)
        s->selected = cli_view_find_item(s, name);
    else
        return fail(problem,
            "there is no '%.100s' to select; Tab goes through light.NAME, environment and "
            "albedo.MATERIAL",
            name);
    return true;
}

/// The item selected, if it is of the right kind.
static cli_view_item *selected_light(cli_view_state *s, char *problem)
{
    if (s->selected < s->item_count && s->item[s->selected].kind != CLI_VIEW_MATERIAL)
        return &s->item[s->selected];
    fail(problem, "no light is selected%s", "");
    return NULL;
}

static bool set_scale(cli_view_state *s, float scale, char *problem)
{
    cli_view_item *light = selected_light(s, problem);
    if (!light) return false;
    if (!(scale >= 0 && scale <= LARGEST_SCALE))
        return fail(problem, "an intensity must be from 0 to 1e6%s", "");
    light->scale = scale;
    s->light_changes++;
    return true;
}

/// A light that was switched off comes back faintly.
static bool brighten(cli_view_state *s, float stops, char *problem)
{
    cli_view_item *light = selected_light(s, problem);
    if (!light) return false;
    float scale = (light->scale > 0 ? light->scale : 0.125f) * exp2f(stops);
    return set_scale(s, fminf(scale, LARGEST_SCALE), problem);
}

static bool set_color(cli_view_state *s, size_t index, rsv_rgb color, char *problem)
{
    if (index >= s->item_count) return fail(problem, "nothing is selected%s", "");
    cli_view_item *item = &s->item[index];
    float most = item->kind == CLI_VIEW_MATERIAL ? 1 : 1000;
    bool good = color.r >= 0 && color.g >= 0 && color.b >= 0 && color.r <= most &&
                color.g <= most && color.b <= most;
    if (!good) return fail(problem, "a color must be from 0 to %s", most > 1 ? "1000" : "1");
    if (item->kind == CLI_VIEW_ENVIRONMENT && (color.r != color.g || color.g != color.b))
        return fail(problem, "the environment takes one factor for all colors%s", "");
    item->color = color;
    s->light_changes++;
    return true;
}

static float clamped(float value, float most) { return fminf(fmaxf(value, 0), most); }

static bool tint(cli_view_state *s, const float by[3], char *problem)
{
    if (s->selected >= s->item_count) return fail(problem, "nothing is selected%s", "");
    const cli_view_item *item = &s->item[s->selected];
    float most = item->kind == CLI_VIEW_MATERIAL ? 1 : 1000;
    rsv_rgb color = { clamped(item->color.r + by[0], most), clamped(item->color.g + by[1], most),
        clamped(item->color.b + by[2], most) };
    return set_color(s, s->selected, color, problem);
}

static float within(float value, float most) { return fminf(fmaxf(value, -most), most); }

static bool move_to(cli_view_state *s, rsv_vec3 offset, char *problem)
{
    cli_view_item *light = selected_light(s, problem);
    if (!light) return false;
    if (!light->movable) return fail(problem, "'%.100s' cannot be moved", light->name);
    float most = FARTHEST * s->reach;
    light->offset =
        (rsv_vec3){ within(offset.x, most), within(offset.y, most), within(offset.z, most) };
    s->light_changes++;
    return true;
}

static bool nudge(cli_view_state *s, rsv_vec3 by, char *problem)
{
    cli_view_item *light = selected_light(s, problem);
    rsv_vec3 o = light ? light->offset : (rsv_vec3){ 0 };
    return light && move_to(s, (rsv_vec3){ o.x + by.x, o.y + by.y, o.z + by.z }, problem);
}

static bool set_albedo(cli_view_state *s, const cli_view_command *c, char *problem)
{
    char name[CLI_VIEW_TEXT_LENGTH];
    snprintf(name, sizeof name, "albedo.%.240s", c->text);
    size_t index = cli_view_find_item(s, name);
    if (index == s->item_count)
        return fail(problem, "there is no plain diffuse material '%.100s'", c->text);
    return set_color(s, index, (rsv_rgb){ c->number[0], c->number[1], c->number[2] }, problem);
}

// ---- lights that are added ------------------------------------------------------------------------------

/// Of their intensity over the square of the scene's size: about what lights a room well.
#define ADDED_INTENSITY 0.25f

static bool add_light(cli_view_state *s, const cli_view_command *c, char *problem)
{
    char name[CLI_VIEW_TEXT_LENGTH];
    snprintf(name, sizeof name, "light.%.240s", c->text);
    if (s->added_count == CLI_VIEW_MOST_ADDED || strlen(c->text) >= CLI_VIEW_NAME_LENGTH)
        return fail(problem, "there is no room for one more light '%.60s'", c->text);
    if (cli_view_find_item(s, name) < s->item_count)
        return fail(problem, "there is a '%.100s' already", name);
    char *own = s->added_name[s->added_count++];
    memcpy(own, c->text, strlen(c->text) + 1);
    s->selected = s->item_count++;
    s->item[s->selected] = s->home[s->selected] = (cli_view_item){ .kind = CLI_VIEW_LIGHT,
        .name = own,
        .color = { 1, 1, 1 },
        .scale = 1,
        .home = { c->number[0], c->number[1], c->number[2] },
        .glow = { 1, 1, 1 },
        .movable = true };
    s->home[s->selected].scale = 0; // `reset` switches it off
    s->light_changes++;
    return true;
}

rsv_light cli_view_added_light(const cli_view_state *s, size_t index)
{
    const cli_view_item *item = &s->item[s->item_count - s->added_count + index];
    float intensity = ADDED_INTENSITY * s->reach * s->reach;
    return (rsv_light){ .name = item->name,
        .kind = RSV_LIGHT_POINT,
        .position = item->home,
        .intensity = { intensity, intensity, intensity } };
}

// ---- mouse ------------------------------------------------------------------------------------------

/// The light whose marker is nearest to a place in the picture.
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
    return depth <= 0 || nudge(s, cli_camera_drag(&s->camera, s->aspect, depth, dx, dy), problem);
}

// ---- what is shown ----------------------------------------------------------------------------------

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
    return fail(problem, "'%.60s' is no mode", name);
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
        return fail(problem, "there is no layer '%.60s'", name);
    s->layer = at == 0 ? RSV_NONE : at - 1;
    return true;
}

static bool set_tone(cli_view_state *s, const char *name, char *problem)
{
    bool next = strcmp(name, "next") == 0, soft = strcmp(name, "soft") == 0;
    if (!next && !soft && strcmp(name, "clip") != 0)
        return fail(problem, "'%.60s' is no tone curve", name);
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
    if (!flag) return fail(problem, "'%.60s' is nothing to show", name);
    *flag = !*flag;
    return true;
}

static bool set_camera(cli_view_state *s, const char *name, char *problem)
{
    for (size_t k = 0; k < s->scene->camera_count; k++)
        if (strcmp(s->scene->camera[k].name, name) == 0) {
            s->camera = s->scene->camera[k];
            return true;
        }
    return fail(problem, "the scene has no camera '%.100s'", name);
}

static bool turn_to(cli_view_state *s, float degrees, char *problem)
{
    if (!s->scene->environment) return fail(problem, "there are no surroundings to turn%s", "");
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

/// Commands that cannot fail.
static void apply_plain(cli_view_state *s, const cli_view_command *c)
{
    const float *n = c->number;
    if (c->verb == CLI_VIEW_EXPOSURE) s->exposure = within(n[0], MOST_STOPS);
    if (c->verb == CLI_VIEW_EXPOSE) s->exposure = within(s->exposure + n[0], MOST_STOPS);
    if (c->verb == CLI_VIEW_SEPARATION) s->separation = n[0];
    if (c->verb == CLI_VIEW_PICK) pick(s, n[0], n[1]);
    if (c->verb == CLI_VIEW_RELEASE) s->grabbed = false;
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
        return add_light(s, c, problem);
    case CLI_VIEW_ALBEDO:
        return set_albedo(s, c, problem);
    case CLI_VIEW_BRIGHTEN:
        return brighten(s, n[0], problem);
    case CLI_VIEW_CAMERA:
        return set_camera(s, c->text, problem);
    case CLI_VIEW_COLOR:
        return set_color(s, s->selected, (rsv_rgb){ n[0], n[1], n[2] }, problem);
    case CLI_VIEW_DRAG:
        return drag(s, n[0], n[1], problem);
    case CLI_VIEW_ENV_ROTATE:
        return turn_to(s, n[0], problem);
    case CLI_VIEW_INTENSITY:
        return set_scale(s, n[0], problem);
    case CLI_VIEW_LAYER:
        return set_layer(s, c->text, problem);
    case CLI_VIEW_MODE:
        return set_mode(s, c->text, problem);
    case CLI_VIEW_MOVE:
        return move_to(s, (rsv_vec3){ n[0], n[1], n[2] }, problem);
    case CLI_VIEW_NUDGE:
        return nudge(s, (rsv_vec3){ n[0], n[1], n[2] }, problem);
    case CLI_VIEW_SELECT:
        return select_item(s, c->text, problem);
    case CLI_VIEW_SHOW:
        return toggle(s, c->text, problem);
    case CLI_VIEW_TINT:
        return tint(s, n, problem);
    case CLI_VIEW_TONE:
        return set_tone(s, c->text, problem);
    case CLI_VIEW_TURN:
        return turn_to(s, s->env_rotation + n[0], problem);
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

static bool same(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

rsv_relight_desc cli_view_relighting(const cli_view_state *s, const cli_view_changes *room)
{
    rsv_relight_desc desc = { .light = room->light, .albedo = room->albedo, .move = room->move };
    for (size_t k = 0; k < s->item_count; k++) {
        const cli_view_item *item = &s->item[k], *home = &s->home[k];
        rsv_rgb c = item->color;
        rsv_vec3 o = item->offset;
        if (item->kind == CLI_VIEW_MATERIAL) {
            if (!same(c, home->color))
                room->albedo[desc.albedo_count++] = (rsv_albedo_change){ item->name, c };
            continue;
        }
        rsv_rgb scale = { clamped(item->scale * c.r, LARGEST_SCALE),
            clamped(item->scale * c.g, LARGEST_SCALE), clamped(item->scale * c.b, LARGEST_SCALE) };
        if (!same(scale, (rsv_rgb){ 1, 1, 1 }))
            room->light[desc.light_count++] = (rsv_light_scale){ item->name, scale };
        if (o.x != 0 || o.y != 0 || o.z != 0)
            room->move[desc.move_count++] = (rsv_light_move){ item->name, o };
    }
    desc.turn = s->env_rotation != s->home_rotation;
    desc.rotation = s->env_rotation;
    return desc;
}
