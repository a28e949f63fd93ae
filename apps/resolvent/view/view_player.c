#include "view_player.h"

#include "../subject.h"

#include "resolvent/edit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// Frames at the same moment after which the light is finished.
#define FRAMES_TO_SETTLE 4

static bool fail(cli_view_state *state, char *problem, const char *text)
{
    snprintf(problem, CLI_VIEW_TEXT_LENGTH, "%.250s", text);
    state->plays = false;
    return false;
}

bool cli_view_is_playable(const char *path)
{
    const char *end = strrchr(path, '.');
    return end && (strcmp(end, ".gltf") == 0 || strcmp(end, ".glb") == 0);
}

/// Seconds that the animation lasts.
static double length_of(const cli_view_player *p)
{
    double end = 0;
    size_t count = rsv_animation_clip_count(p->animation);
    for (uint32_t k = 0; k < count; k++)
        if (p->clip == RSV_NONE || p->clip == k)
            end = fmax(end, rsv_animation_clip(p->animation, k)->end);
    return end;
}

/// Opens the scene's file, or the one in its operator file. @return false after an error
static bool open_file(const cli_view_player *p, const rsv_scene *scene)
{
    rsv_animation **animation = &p->session->animation;
    const rsv_load_desc load = cli_describe_load(p->session);
    if (cli_view_is_playable(p->path))
        return rsv_animation_open(p->session->context, p->path, &load, animation) == RSV_OK;
    return !rsv_scene_has_document(scene) ||
           rsv_animation_open_document(scene, animation) == RSV_OK;
}

/// Opens the animation when it is first needed.
static bool open_animation(
    cli_view_player *p, const cli_view_show *show, cli_view_state *state, char *problem)
{
    const rsv_scene *scene = rsv_light_scene(show->lit.light);
    const char *name = p->clip_name;
    if (p->animation) return true;
    if (!p->session->animation && !open_file(p, scene))
        return fail(state, problem, rsv_last_error());
    if (!p->session->animation)
        return fail(state, problem, "only glTF files are played; convert it to .glb");
    p->animation = p->session->animation;
    p->clip = name ? rsv_animation_find_clip(p->animation, name) : 0;
    bool all = name && strcmp(name, "all") == 0;
    if (rsv_animation_clip_count(p->animation) > 0 && (p->clip != RSV_NONE || all)) {
        state->length = length_of(p);
        return true;
    }
    p->animation = NULL;
    return fail(state, problem, "the file holds no such animation");
}

/// Where the animation is in this frame: it begins again after its end.
static void advance(cli_view_player *p, cli_view_state *state)
{
    double now = cli_seconds(), passed = p->step > 0 ? p->step : now - p->clock;
    bool began = state->plays && p->clock == 0;
    p->clock = state->plays ? now : 0;
    if (!state->plays || began) return;
    state->time += passed * (double)state->speed;
    if (state->length > 0) state->time -= state->length * floor(state->time / state->length);
}

/// On the way to the wanted version, as far as the budget goes. @param version out: the same, if it goes that far
static rsv_status choose_version(
    cli_view_player *p, const cli_view_state *state, rsv_scene *wanted, rsv_scene **version)
{
    *version = wanted;
    if (!p->scene) return RSV_OK; // the first step computes everything
    if (!cli_turns_take(
            &p->turns, rsv_scene_get_view(p->scene), rsv_scene_get_view(wanted), &state->camera))
        return RSV_ERROR_MEMORY;
    if (!p->turns.waiting) return RSV_OK;
    return rsv_scene_mix(p->scene, wanted, p->turns.moved, version);
}

static void take_version(cli_view_player *p, rsv_scene *version, rsv_scene *wanted)
{
    rsv_scene_destroy(p->scene);
    rsv_scene_destroy(p->wanted);
    p->scene = version;
    p->wanted = version == wanted ? NULL : wanted;
}

static bool follow(cli_view_player *p, cli_view_show *show, cli_view_state *state, char *problem)
{
    rsv_scene *wanted = NULL, *version = NULL;
    double time = state->time, start = cli_seconds();
    bool first = !p->scene;
    rsv_status status = rsv_animation_scene(p->animation, p->clip, time, &wanted);
    if (status == RSV_OK) status = choose_version(p, state, wanted, &version);
    if (status == RSV_OK) status = cli_show_follow(show, state, version);
    if (status != RSV_OK) {
        if (version != wanted) rsv_scene_destroy(version);
        rsv_scene_destroy(wanted);
        return fail(state, problem, rsv_last_error());
    }
    take_version(p, version, wanted);
    if (!first) cli_turns_note(&p->turns, 1e3 * (cli_seconds() - start));
    p->followed = time;
    p->quiet_frames = 0;
    p->settled = false;
    return true;
}

/// Finishes the light of a moment that stays.
static bool settle(cli_view_player *p, cli_view_show *show, cli_view_state *state, char *problem)
{
    if (!p->scene || p->settled || ++p->quiet_frames < FRAMES_TO_SETTLE) return true;
    p->settled = true;
    return cli_show_follow(show, state, p->scene) == RSV_OK ||
           fail(state, problem, rsv_last_error());
}

bool cli_view_play(
    cli_view_player *p, cli_view_show *show, cli_view_state *state, double *lag_ms, char *problem)
{
    double start = cli_seconds();
    *lag_ms = 0;
    if (!state->plays && !state->sought && !p->scene) return true;
    if (!cli_show_is_complete(show)) return true; // not before the best light is there
    if (!open_animation(p, show, state, problem)) return false;
    advance(p, state);
    bool moves =
        state->sought || p->wanted || (state->plays && (!p->scene || state->time != p->followed));
    state->sought = false;
    bool good = moves ? follow(p, show, state, problem) : settle(p, show, state, problem);
    if (moves) *lag_ms = fmax(1e3 * (cli_seconds() - start), cli_turns_lag(&p->turns));
    return good;
}

void cli_view_player_end(cli_view_player *p)
{
    take_version(p, NULL, NULL);
    cli_turns_end(&p->turns);
}
