/// All sources of a scene.
#include "lamps.h"

#include "../core/core.h"
#include "../sources/punctual_light.h"

rsv_highlights_desc rsv_default_highlights_desc(void)
{
    return (rsv_highlights_desc){ .part = RSV_HIGHLIGHT_ALL, .polygons = 24, .sky_side = 512 };
}

rsv_status rsv_highlights_create(
    const rsv_lights *lights, const rsv_highlights_desc *desc, rsv_highlights **result)
{
    rsv_status status = RSV_OK;
    rsv_highlights *h = rsv_alloc(lights->context, 1, sizeof *h);
    *result = NULL;
    if (!h) return RSV_ERROR_MEMORY;
    h->context = lights->context;
    h->lights = lights;
    h->desc = *desc;
    h->desc.polygons = desc->polygons < 1                   ? 1
                       : desc->polygons < RSV_MOST_POLYGONS ? desc->polygons
                                                            : RSV_MOST_POLYGONS;
    bool sampled = desc->part & RSV_HIGHLIGHT_SAMPLED;
    h->group_count = (uint32_t)lights->group_count;
    h->sun_count = sampled && lights->environment ? lights->environment->sun_count : 0;
    h->punctual_count = sampled ? (uint32_t)lights->punctual_count : 0;
    RSV_TRY(rsv_lamp_tree_create(lights, desc->part, &h->lamps));
    RSV_TRY(rsv_sky_map_create(lights, desc->part, desc->sky_side, &h->sky));
    *result = h;
    h = NULL;
cleanup:
    rsv_highlights_destroy(h);
    return status;
}

void rsv_highlights_destroy(rsv_highlights *h)
{
    if (!h) return;
    rsv_lamp_tree_destroy(h->context, &h->lamps);
    rsv_free(h->context, h->sky.texel);
    rsv_free(h->context, h);
}

uint32_t rsv_highlights_source_count(const rsv_highlights *h)
{
    return rsv_highlights_sky(h) + (h->sky.texel != NULL);
}

rsv_highlight_source rsv_highlights_source(const rsv_highlights *h, uint32_t source)
{
    if (source < h->group_count) return (rsv_highlight_source){ RSV_HIGHLIGHT_GROUP, source };
    source -= h->group_count;
    if (source < h->sun_count) return (rsv_highlight_source){ RSV_HIGHLIGHT_SUN, source };
    source -= h->sun_count;
    if (source < h->punctual_count)
        return (rsv_highlight_source){ RSV_HIGHLIGHT_PUNCTUAL, h->lights->punctual[source] };
    return (rsv_highlight_source){ RSV_HIGHLIGHT_SKY, 0 };
}

// ---- one by one -----------------------------------------------------------------------------------

static void take_suns(
    const rsv_highlights *h, const rsv_highlight_lobes *l, rsv_light_taker take, void *user)
{
    for (uint32_t k = 0; k < h->sun_count; k++) {
        const rsv_sun *sun = &h->lights->environment->sun[k];
        rsv_rgb disc = rsv_highlight_disc(l, sun->direction, sun->cos_radius);
        if (!rgb_is_black(disc)) take(user, h->group_count + k, rgb_mul(disc, sun->radiance));
    }
}

static void take_punctual(
    const rsv_highlights *h, const rsv_highlight_lobes *l, rsv_light_taker take, void *user)
{
    uint32_t first = h->group_count + h->sun_count;
    for (uint32_t k = 0; k < h->punctual_count; k++) {
        const rsv_punctual_light *light = &h->lights->scene->light[h->lights->punctual[k]];
        rsv_vec3 direction;
        rsv_rgb irradiance;
        float distance;
        if (!rsv_punctual_irradiance(light, l->point.position, &direction, &distance, &irradiance))
            continue;
        rsv_rgb response = rsv_highlight_direction(l, direction);
        if (!rgb_is_black(response)) take(user, first + k, rgb_mul(response, irradiance));
    }
}

static void take_all(
    const rsv_highlights *h, const rsv_highlight_lobes *l, rsv_light_taker take, void *user)
{
    rsv_lamps_light(h, l, take, user);
    take_suns(h, l, take, user);
    take_punctual(h, l, take, user);
    rsv_rgb sky = rsv_sky_map_light(&h->sky, l);
    if (!rgb_is_black(sky)) take(user, rsv_highlights_sky(h), sky);
}

/// The brightest so far, and the sum of the others.
typedef struct brightest {
    rsv_highlight_light *light; ///< [RSV_HIGHLIGHT_LIGHTS], the last kept free for the others
    uint32_t count;
    rsv_rgb others;
} brightest;

static void keep(void *user, uint32_t source, rsv_rgb radiance)
{
    brightest *b = user;
    uint32_t dimmest = 0;
    if (source == RSV_NONE) {
        b->others = rgb_add(b->others, radiance);
        return;
    }
    for (uint32_t i = 0; i < b->count; i++) {
        if (b->light[i].source == source) {
            b->light[i].radiance = rgb_add(b->light[i].radiance, radiance);
            return;
        }
        if (rgb_luminance(b->light[i].radiance) < rgb_luminance(b->light[dimmest].radiance))
            dimmest = i;
    }
    if (b->count < RSV_HIGHLIGHT_LIGHTS - 1) {
        b->light[b->count++] = (rsv_highlight_light){ source, radiance };
    } else if (rgb_luminance(radiance) > rgb_luminance(b->light[dimmest].radiance)) {
        b->others = rgb_add(b->others, b->light[dimmest].radiance);
        b->light[dimmest] = (rsv_highlight_light){ source, radiance };
    } else {
        b->others = rgb_add(b->others, radiance);
    }
}

static void sort_by_source(rsv_highlight_light *light, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        rsv_highlight_light moved = light[i];
        uint32_t at = i;
        for (; at > 0 && light[at - 1].source > moved.source; at--)
            light[at] = light[at - 1];
        light[at] = moved;
    }
}

uint32_t rsv_highlights_at(
    const rsv_highlights *h, const rsv_highlight_lobes *l, rsv_highlight_light *light)
{
    brightest b = { light, 0, rgb_gray(0) };
    take_all(h, l, keep, &b);
    sort_by_source(light, b.count);
    if (!rgb_is_black(b.others)) light[b.count++] = (rsv_highlight_light){ RSV_NONE, b.others };
    return b.count;
}

static void add(void *user, uint32_t source, rsv_rgb radiance)
{
    rsv_rgb *sum = user;
    (void)source;
    *sum = rgb_add(*sum, radiance);
}

rsv_rgb rsv_highlights_sum(const rsv_highlights *h, const rsv_highlight_lobes *l)
{
    rsv_rgb sum = rgb_gray(0);
    take_all(h, l, add, &sum);
    return sum;
}

void rsv_highlights_sum_many(
    const rsv_highlights *h, const rsv_highlight_point *point, size_t count, rsv_rgb *radiance)
{
    for (size_t i = 0; i < count; i++) {
        rsv_highlight_lobes lobes;
        bool rough = rsv_highlight_prepare(&point[i], &lobes);
        radiance[i] = rough ? rsv_highlights_sum(h, &lobes) : rgb_gray(0);
    }
}
