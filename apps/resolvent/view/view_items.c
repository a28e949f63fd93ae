#include "view_items.h"

#include "view_camera.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LARGEST_SCALE 1e6f
/// Lights stay within this many times the scene's size from its middle.
#define FARTHEST 10.0f

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

static void list_object(cli_view_state *s, const rsv_scene_view *body)
{
    const rsv_vec3 *low = &body->bounds_min, *high = &body->bounds_max;
    const double *own = body->origin, *room = s->scene->origin;
    s->object = s->item_count++;
    s->home[s->object] = (cli_view_item){ .kind = CLI_VIEW_OBJECT,
        .name = "object",
        .color = { 1, 1, 1 },
        .scale = 1,
        .home = { 0.5f * (low->x + high->x) + (float)(own[0] - room[0]),
            0.5f * (low->y + high->y) + (float)(own[1] - room[1]),
            0.5f * (low->z + high->z) + (float)(own[2] - room[2]) },
        .glow = { 1, 1, 1 },
        .movable = true };
}

/// Whether more than one source has this name.
static bool is_shared(const rsv_relighter *relighter, const char *name)
{
    size_t count = 0;
    for (size_t k = 0; k < rsv_relighter_source_count(relighter); k++)
        count += strcmp(rsv_relighter_source(relighter, k).name, name) == 0;
    return count > 1;
}

void cli_view_list_items(cli_view_state *s, const rsv_relighter *relighter, const rsv_scene *body)
{
    size_t sources = relighter ? rsv_relighter_source_count(relighter) : 0;
    for (size_t k = 0; k < sources; k++) {
        rsv_relight_source source = rsv_relighter_source(relighter, k);
        bool by_node = source.node && is_shared(relighter, source.name);
        s->home[s->item_count++] = (cli_view_item){
            .kind = is_surroundings(s, k, sources) ? CLI_VIEW_ENVIRONMENT : CLI_VIEW_LIGHT,
            .name = by_node ? source.node : source.name,
            .alias = by_node ? source.name : source.node,
            .color = { 1, 1, 1 },
            .scale = 1,
            .home = source.position,
            .glow = hue(source.strength),
            .movable = source.movable,
        };
    }
    for (size_t m = 0; relighter && m < s->scene->material_count; m++)
        if (is_plain(s->scene, m))
            s->home[s->item_count++] = (cli_view_item){ .kind = CLI_VIEW_MATERIAL,
                .name = s->scene->material[m].name,
                .color = s->scene->material[m].base_color,
                .scale = 1 };
    s->object = SIZE_MAX;
    if (body) list_object(s, rsv_scene_get_view(body));
}

static const char *prefix_of(cli_view_kind kind)
{
    static const char *const prefixes[] = { "light.", "", "albedo.", "" };
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
        if (strcmp(own, name) == 0) return k;
    }
    for (k = 0; k < s->item_count; k++) {
        const cli_view_item *item = &s->item[k];
        size_t prefix = strlen(prefix_of(item->kind));
        if (item->alias && strncmp(name, prefix_of(item->kind), prefix) == 0 &&
            strcmp(name + prefix, item->alias) == 0)
            break;
    }
    return k;
}

float cli_view_place(const cli_view_state *s, const cli_view_item *item, float place[2])
{
    rsv_vec3 at = { item->home.x + item->offset.x, item->home.y + item->offset.y,
        item->home.z + item->offset.z };
    return item->movable ? cli_camera_project(&s->camera, s->aspect, at, place) : 0;
}

// ---- commands for the selection ----------------------------------------------------------------------

bool cli_view_fail(char *problem, const char *format, const char *detail)
{
    snprintf(problem, CLI_VIEW_TEXT_LENGTH, format, detail);
    return false;
}

bool cli_view_select(cli_view_state *s, const char *name, char *problem)
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
        return cli_view_fail(problem,
            "there is no '%.100s' to select; Tab goes through light.NAME, environment, "
            "albedo.MATERIAL and object",
            name);
    return true;
}

/// The item selected, if it is of the right kind.
static cli_view_item *selected_light(cli_view_state *s, char *problem)
{
    cli_view_item *item = s->selected < s->item_count ? &s->item[s->selected] : NULL;
    if (item && item->kind != CLI_VIEW_MATERIAL && item->kind != CLI_VIEW_OBJECT) return item;
    cli_view_fail(problem, "no light is selected%s", "");
    return NULL;
}

bool cli_view_set_scale(cli_view_state *s, float scale, char *problem)
{
    cli_view_item *light = selected_light(s, problem);
    if (!light) return false;
    if (!(scale >= 0 && scale <= LARGEST_SCALE))
        return cli_view_fail(problem, "an intensity must be from 0 to 1e6%s", "");
    light->scale = scale;
    s->light_changes++;
    return true;
}

/// A light that was switched off comes back faintly.
bool cli_view_brighten(cli_view_state *s, float stops, char *problem)
{
    cli_view_item *light = selected_light(s, problem);
    if (!light) return false;
    float scale = (light->scale > 0 ? light->scale : 0.125f) * exp2f(stops);
    return cli_view_set_scale(s, fminf(scale, LARGEST_SCALE), problem);
}

bool cli_view_set_color(cli_view_state *s, size_t index, rsv_rgb color, char *problem)
{
    if (index >= s->item_count) return cli_view_fail(problem, "nothing is selected%s", "");
    cli_view_item *item = &s->item[index];
    if (item->kind == CLI_VIEW_OBJECT)
        return cli_view_fail(problem, "the object keeps its colors%s", "");
    float most = item->kind == CLI_VIEW_MATERIAL ? 1 : 1000;
    bool good = color.r >= 0 && color.g >= 0 && color.b >= 0 && color.r <= most &&
                color.g <= most && color.b <= most;
    if (!good)
        return cli_view_fail(problem, "a color must be from 0 to %s", most > 1 ? "1000" : "1");
    if (item->kind == CLI_VIEW_ENVIRONMENT && (color.r != color.g || color.g != color.b))
        return cli_view_fail(problem, "the environment takes one factor for all colors%s", "");
    item->color = color;
    s->light_changes++;
    return true;
}

static float clamped(float value, float most) { return fminf(fmaxf(value, 0), most); }

bool cli_view_tint(cli_view_state *s, const float by[3], char *problem)
{
    if (s->selected >= s->item_count) return cli_view_fail(problem, "nothing is selected%s", "");
    const cli_view_item *item = &s->item[s->selected];
    float most = item->kind == CLI_VIEW_MATERIAL ? 1 : 1000;
    rsv_rgb color = { clamped(item->color.r + by[0], most), clamped(item->color.g + by[1], most),
        clamped(item->color.b + by[2], most) };
    return cli_view_set_color(s, s->selected, color, problem);
}

float cli_view_within(float value, float most) { return fminf(fmaxf(value, -most), most); }

/// The item selected, if it has a place.
static cli_view_item *selected_thing(cli_view_state *s, char *problem)
{
    cli_view_item *item = s->selected < s->item_count ? &s->item[s->selected] : NULL;
    if (item && item->movable) return item;
    if (item && item->kind != CLI_VIEW_MATERIAL)
        cli_view_fail(problem, "'%.100s' cannot be moved", item->name);
    else
        cli_view_fail(problem, "no light is selected%s", "");
    return NULL;
}

static void move_item(cli_view_state *s, cli_view_item *item, rsv_vec3 offset)
{
    float most = FARTHEST * s->reach;
    item->offset = (rsv_vec3){ cli_view_within(offset.x, most), cli_view_within(offset.y, most),
        cli_view_within(offset.z, most) };
    if (item->kind == CLI_VIEW_OBJECT)
        s->object_changes++;
    else
        s->light_changes++;
}

bool cli_view_move_to(cli_view_state *s, rsv_vec3 offset, char *problem)
{
    cli_view_item *item = selected_thing(s, problem);
    if (item) move_item(s, item, offset);
    return item != NULL;
}

bool cli_view_nudge(cli_view_state *s, rsv_vec3 by, char *problem)
{
    cli_view_item *item = selected_thing(s, problem);
    rsv_vec3 o = item ? item->offset : (rsv_vec3){ 0 };
    if (item) move_item(s, item, (rsv_vec3){ o.x + by.x, o.y + by.y, o.z + by.z });
    return item != NULL;
}

bool cli_view_place_object(cli_view_state *s, const float place[4], char *problem)
{
    if (s->object >= s->item_count)
        return cli_view_fail(
            problem, "there is no object to place; add one with --object FILE%s", "");
    s->object_turn = place[3];
    move_item(s, &s->item[s->object], (rsv_vec3){ place[0], place[1], place[2] });
    return true;
}

bool cli_view_set_albedo(cli_view_state *s, const cli_view_command *c, char *problem)
{
    char name[CLI_VIEW_TEXT_LENGTH];
    snprintf(name, sizeof name, "albedo.%.240s", c->text);
    size_t index = cli_view_find_item(s, name);
    if (index == s->item_count)
        return cli_view_fail(problem, "there is no plain diffuse material '%.100s'", c->text);
    return cli_view_set_color(
        s, index, (rsv_rgb){ c->number[0], c->number[1], c->number[2] }, problem);
}

// ---- lights that are added ------------------------------------------------------------------------------

/// Intensity of an added light over the square of the scene's size: about enough to light a room well.
#define ADDED_INTENSITY 0.25f

bool cli_view_add_light(cli_view_state *s, const cli_view_command *c, char *problem)
{
    char name[CLI_VIEW_TEXT_LENGTH];
    snprintf(name, sizeof name, "light.%.240s", c->text);
    if (s->added_count == CLI_VIEW_MOST_ADDED || strlen(c->text) >= CLI_VIEW_NAME_LENGTH)
        return cli_view_fail(problem, "there is no room for one more light '%.60s'", c->text);
    if (cli_view_find_item(s, name) < s->item_count)
        return cli_view_fail(problem, "'%.100s' already exists", name);
    const double *from = s->scene->origin; // numbers are those of the scene's file
    char *own = s->added_name[s->added_count++];
    memcpy(own, c->text, strlen(c->text) + 1);
    s->selected = s->item_count++;
    s->item[s->selected] = s->home[s->selected] = (cli_view_item){ .kind = CLI_VIEW_LIGHT,
        .name = own,
        .color = { 1, 1, 1 },
        .scale = 1,
        .home = { (float)(c->exact[0] - from[0]), (float)(c->exact[1] - from[1]),
            (float)(c->exact[2] - from[2]) },
        .glow = { 1, 1, 1 },
        .movable = true };
    s->taken[s->selected] = s->item[s->selected];
    s->home[s->selected].scale = 0; // `reset` switches it off
    s->light_changes++;
    return true;
}

rsv_punctual_light cli_view_added_light(const cli_view_state *s, size_t index)
{
    const cli_view_item *item = &s->item[s->item_count - s->added_count + index];
    float intensity = ADDED_INTENSITY * s->reach * s->reach;
    return (rsv_punctual_light){ .name = item->name,
        .kind = RSV_PUNCTUAL_POINT,
        .position = item->home,
        .intensity = { intensity, intensity, intensity } };
}

static bool same(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

rsv_relight_desc cli_view_relighting(const cli_view_state *s, const cli_view_changes *room)
{
    rsv_relight_desc desc = {
        .size = sizeof desc, .light = room->light, .albedo = room->albedo, .move = room->move
    };
    for (size_t k = 0; k < s->item_count; k++) {
        const cli_view_item *item = &s->item[k], *home = &s->home[k];
        rsv_rgb c = item->color;
        rsv_vec3 o = item->offset;
        if (item->kind == CLI_VIEW_MATERIAL) {
            if (!same(c, home->color))
                room->albedo[desc.albedo_count++] = (rsv_albedo_change){ item->name, c };
            continue;
        }
        if (item->kind == CLI_VIEW_OBJECT) continue;
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

void cli_view_note_taken(cli_view_state *s)
{
    memcpy(s->taken, s->item, s->item_count * sizeof *s->item);
    s->taken_rotation = s->env_rotation;
}

void cli_view_take_back(cli_view_state *s)
{
    for (size_t k = 0; k < s->item_count; k++)
        if (s->item[k].kind != CLI_VIEW_OBJECT) s->item[k] = s->taken[k];
    s->env_rotation = s->taken_rotation;
}
