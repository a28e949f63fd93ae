#include "bake_direct.h"

#include "../core/sampling.h"
#include "../core/stratified.h"
#include "bake_constants.h"
#include "bake_receiver.h"

/// A patch for light from sources. Must not be copied.
typedef struct lit_patch {
    const rsv_light_view *s;
    const rsv_bake_sources *sources;
    rsv_receiver at[RSV_BAKE_PLACES];
    rsv_bake_weights weights[WEIGHED_PLACES];
    uint32_t count;
    rsv_medium medium;
    rsv_surface_entry entry;
    rsv_entrance entrance;
    rsv_rgb unshadowed; ///< mean over the places
    bool by_tree;       ///< some emitters are chosen by a tree
} lit_patch;

bool rsv_bake_is_sampled(const rsv_light_view *s, const rsv_surface_place *place)
{
    uint32_t face = s->elements->face_of[place->back][place->triangle];
    return face != RSV_NONE && !rsv_is_translucent(s, face);
}

rsv_rgb rsv_bake_stored(const rsv_light_view *s, const rsv_surface_place *place)
{
    uint32_t face = s->elements->face_of[place->back][place->triangle];
    if (!rsv_bake_is_sampled(s, place))
        return rsv_bake_shown(s, place->triangle, place->back, place->u, place->v);
    return rgb_add(rsv_light_view_direct(s, face, place->u, place->v, true),
        rsv_elements_interpolate(s->elements, s->indirect, face, place->u, place->v));
}

rsv_rgb rsv_bake_stored_mean(const rsv_light_view *s, const rsv_bake_patch *patch)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < patch->count; k++)
        sum = rgb_mad(sum, 1 / (float)patch->count, rsv_bake_stored(s, &patch->place[k]));
    return sum;
}

static void set_up(lit_patch *lit, const rsv_light_view *s, const rsv_bake_patch *patch)
{
    const rsv_scene_view *view = s->scene.view;
    uint32_t material = view->triangle_material[patch->place[0].triangle];
    bool varies = rsv_coat_varies(view, material);
    lit->s = s;
    lit->count = patch->count;
    lit->entry = rsv_surface_entry_of(material);
    for (uint32_t k = 0; k < patch->count; k++) {
        const rsv_surface_place *p = &patch->place[k];
        rsv_surface_point point =
            rsv_surface_point_seen(view, p->triangle, p->u, p->v, p->back, p->width);
        lit->at[k] = rsv_receiver_at(view, s->tracer, p->triangle, p->u, p->v, point);
        if (varies) rsv_surface_entry_add(&lit->entry, view, s->bsdf, p->triangle, p->u, p->v);
    }
    if (varies) rsv_surface_entry_finish(&lit->entry);
    lit->medium = rsv_medium_above(&s->scene.media, lit->at[0].origin, lit->at[0].point.geometric);
    lit->entrance = rsv_entrance_through(&lit->medium, s->bsdf, RSV_COVER_PATCH);
    lit->entrance.patch = &lit->entry;
}

// ---- emitters, suns and the sky -------------------------------------------------------------------

/// @param count places that shadow rays start from
static void weigh_sources(lit_patch *lit, uint32_t count)
{
    lit->unshadowed = rgb_gray(0);
    lit->by_tree = false;
    for (uint32_t k = 0; k < count; k++) {
        rsv_bake_weigh(lit->sources, &lit->at[k], &lit->weights[k]);
        lit->unshadowed = rgb_mad(lit->unshadowed, 1 / (float)count, lit->weights[k].unshadowed);
        lit->by_tree = lit->by_tree || lit->weights[k].local.tree_share > 0;
    }
}

/// Shadow rays of both halves from the first places, by turns, in packets that the halves share.
static void sample_sources(
    lit_patch *lit, uint32_t places, uint32_t samples, uint32_t seed, rsv_event_sums half[2])
{
    half[0] = half[1] = rsv_event_sums_zero();
    for (uint32_t first = 0; first < 2 * samples; first += RSV_PACKET_WIDTH) {
        rsv_next_event event[RSV_PACKET_WIDTH];
        float passed[RSV_PACKET_WIDTH];
        uint32_t left = 2 * samples - first;
        uint32_t lanes = left < RSV_PACKET_WIDTH ? left : RSV_PACKET_WIDTH;
        for (uint32_t k = 0; k < lanes; k++) {
            uint32_t index = (first + k) / 2, stream = rsv_hash2(seed, k % 2);
            uint32_t at = (index + (k % 2) * (places / 2)) % places;
            float u[3] = { rsv_sobol_1d(index, rsv_hash2(stream, 1)), 0, 0 };
            rsv_sobol_2d(index, rsv_hash2(stream, 2), &u[1], &u[2]);
            rsv_bake_draw(
                lit->sources, &lit->weights[at], &lit->at[at], &lit->entrance, u, &event[k]);
        }
        rsv_next_events_passed(lit->s->tracer, event, lanes, passed);
        for (uint32_t k = 0; k < lanes; k++)
            rsv_event_sums_add(&half[k % 2], &event[k], passed[k]);
    }
}

/// One channel of a half's estimate. The share that is seen is that of both halves, linearised for each: a ratio of few
/// samples would be biased.
static float ratio(float unshadowed, float visible, float open, float all_visible, float all_open)
{
    if (!(all_open > 0)) return 0;
    float share = all_visible / all_open;
    return unshadowed * (share + 2 * (visible - share * open) / all_open);
}

static rsv_rgb half_of(
    const lit_patch *lit, const rsv_event_sums *own, const rsv_event_sums *all, uint32_t samples)
{
    const rsv_rgb u = lit->unshadowed, v = own->visible, o = own->open;
    rsv_rgb known = rgb(ratio(u.r, v.r, o.r, all->visible.r, all->open.r),
        ratio(u.g, v.g, o.g, all->visible.g, all->open.g),
        ratio(u.b, v.b, o.b, all->visible.b, all->open.b));
    return rgb_mad(known, 1 / (float)samples, own->further);
}

static void estimate_sources(lit_patch *lit, uint32_t samples, uint32_t seed, rsv_bake_estimate *e)
{
    uint32_t places = lit->count < samples ? lit->count : samples;
    if (places > 2 && 4 * places > samples) places = samples > 8 ? samples / 4 : 2;
    if (places > WEIGHED_PLACES) places = WEIGHED_PLACES;
    weigh_sources(lit, places);
    if (!lit->by_tree && rgb_is_black(lit->unshadowed)) return;
    rsv_event_sums half[2];
    sample_sources(lit, places, samples, seed, half);
    rsv_event_sums all = rsv_event_sums_merge(half[0], half[1]);
    for (uint32_t h = 0; h < 2; h++)
        e->half[h] = half_of(lit, &half[h], &all, samples);
    float open = rgb_luminance(all.open), count = 2 * (float)samples;
    e->open = rgb_luminance(lit->unshadowed);
    e->seen = open > 0 ? rgb_luminance(all.visible) / open : 0;
    float mean = rgb_luminance(all.further) / count;
    e->choice = f_max(all.further_squared / count - mean * mean, 0);
}

// ---- punctual lights ------------------------------------------------------------------------------

/// From all places of the patch: their shadows are sharp.
static rsv_rgb punctual_light(const lit_patch *lit, uint32_t seed)
{
    rsv_rgb sum = rgb_gray(0);
    const rsv_lights *lights = lit->s->lights;
    for (uint32_t l = 0; l < rsv_punctual_count(lights); l++) {
        rsv_next_event event[RSV_BAKE_PLACES];
        float passed[RSV_BAKE_PLACES];
        for (uint32_t k = 0; k < lit->count; k++)
            rsv_next_event_punctual(&lit->at[k], &lit->entrance, lights, l,
                rsv_stratified_1d(k, lit->count, seed), &event[k]);
        rsv_next_events_passed(lit->s->tracer, event, lit->count, passed);
        for (uint32_t k = 0; k < lit->count; k++)
            if (passed[k] > 0) sum = rgb_mad(sum, passed[k], event[k].light);
    }
    return rgb_scale(sum, 1 / (float)lit->count);
}

rsv_bake_estimate rsv_bake_estimate_patch(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, uint32_t samples, uint32_t seed)
{
    const rsv_light_view *s = lamps->light;
    rsv_bake_estimate e = { .stored = rsv_bake_stored_mean(s, patch) };
    if (patch->count == 0 || !rsv_bake_is_sampled(s, &patch->place[0])) return e;
    bool draws = rsv_lights_any_sampled(s->lights);
    if (!draws && rsv_punctual_count(s->lights) == 0) return e;
    lit_patch lit;
    lit.sources = &lamps->sources;
    set_up(&lit, s, patch);
    if (draws) estimate_sources(&lit, samples, seed, &e);
    e.punctual = punctual_light(&lit, rsv_hash2(seed, 3));
    return e;
}

float rsv_bake_estimate_error(const rsv_bake_estimate *e, uint32_t samples)
{
    float by_shadow = e->open * e->open * f_max(e->seen * (1 - e->seen), 0);
    return sqrtf(STRATIFIED * (by_shadow + e->choice) / (2 * (float)samples));
}

rsv_rgb rsv_bake_light_patch(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, float error, uint32_t seed)
{
    uint32_t samples = LEAST_SAMPLES;
    rsv_bake_estimate e = rsv_bake_estimate_patch(lamps, patch, samples, rsv_hash2(seed, 0));
    for (uint32_t round = 1; samples < MOST_LIGHT_SAMPLES; round++) {
        float off = rsv_bake_estimate_error(&e, samples) / error;
        if (off <= 1) break;
        float wanted = f_min((float)samples * off * off, MOST_LIGHT_SAMPLES);
        samples = (uint32_t)f_max(wanted, 2 * (float)samples);
        e = rsv_bake_estimate_patch(lamps, patch, samples, rsv_hash2(seed, round));
    }
    return rgb_positive(rsv_bake_estimate_total(&e));
}
