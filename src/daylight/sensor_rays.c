#include "sensor_rays.h"

#include "../core/sampling.h"
#include "../solve/goal.h"

#define MOST_PANES 64 ///< surfaces that the sun's light passes on its way to a sensor, at most

/// A sensor at work.
typedef struct sensor {
    const rsv_daylight *daylight;
    const rsv_operator_view *op;
    const rsv_stored_noise *noise;
    rsv_sensor_place place;
    rsv_sensor_rays *found;
    rsv_shared_noise shared;
    double light[RSV_DAYLIGHT_GROUPS]; ///< that surfaces send, luminance
    uint32_t group, per_group, backs;
} sensor;

static bool counts_nothing(const void *user, uint32_t triangle, uint32_t turns)
{
    (void)user, (void)triangle, (void)turns;
    return false;
}

rsv_sensor_place rsv_sensor_place_of(const rsv_daylight *d, size_t index)
{
    const rsv_transport_scene *scene = &rsv_operator_get_view(d->light->op)->world->scene;
    rsv_sensor_place place = { .normal = v3_normalize(d->sensor[index].normal) };
    place.origin =
        rsv_tracer_receiver_origin(scene->tracer, d->sensor[index].position, place.normal);
    place.medium = rsv_medium_above(&scene->media, place.origin, place.normal);
    return place;
}

static void see_sky(sensor *s, rsv_vec3 start, rsv_vec3 end, double share)
{
    const rsv_daylight *d = s->daylight;
    uint32_t patch = rsv_sky_patch_at(&d->patches, rsv_daylight_to_sky(d, end));
    rsv_patch_share *to =
        rsv_daylight_is_straight(start, end) ? s->found->straight : s->found->bent;
    to[patch].column[s->group] += (float)(share * RSV_PI / s->per_group);
}

/// A surface whose back is hit where it has none to show.
static bool is_back_of_wall(const sensor *s, const rsv_specular_path *path)
{
    const rsv_bsdf *bsdf =
        &s->op->world->scene.bsdf[rsv_specular_material(&s->op->world->scene, path)];
    return path->back && !bsdf->double_sided && bsdf->transmission == 0 && bsdf->opacity == 1;
}

static void see_surface(sensor *s, const rsv_specular_path *end)
{
    const rsv_elements *e = s->op->elements;
    uint32_t face = e->face_of[end->back][end->triangle];
    if (face == RSV_NONE) return;
    float share = RSV_PI / (float)(s->per_group * RSV_DAYLIGHT_GROUPS);
    rsv_goal_weigh_end(s->op, end, share, s->found->weight);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->op->world->scene, end, &storage);
    rsv_rgb stored =
        rsv_elements_interpolate(e, s->daylight->light->irradiance, face, end->u, end->v);
    rsv_rgb seen = rgb_mul(end->weight, bsdf->base_color);
    s->light[s->group] += (double)rgb_luminance(rgb_mul(seen, stored));
    if (!s->noise) return;
    const rsv_stored_lookup found = { face, end->u, end->v, rgb_luminance(seen) * share / RSV_PI,
        rgb_luminance(stored) };
    rsv_shared_noise_add(&s->shared, s->noise, &found);
}

static void trace(sensor *s, rsv_vec3 direction, rsv_random *random)
{
    const rsv_transport_scene *scene = &s->op->world->scene;
    rsv_ray ray = { s->place.origin, direction, INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, &ray, &hit)) {
        see_sky(s, direction, direction, 1);
        return;
    }
    rsv_specular_path path = rsv_specular_begin(scene, &s->place.medium, direction, hit);
    s->backs += is_back_of_wall(s, &path);
    rsv_gather gather = rsv_specular_gather(scene, path, random, counts_nothing, NULL);
    if (gather.end == RSV_SPECULAR_ESCAPED)
        see_sky(s, direction, gather.path.direction, (double)rgb_luminance(gather.path.weight));
    else if (gather.end == RSV_SPECULAR_DIFFUSE)
        see_surface(s, &gather.path);
}

static void summarise(sensor *s)
{
    double sum = 0, variance = s->noise ? rsv_shared_noise_variance(&s->shared, s->noise) : 0;
    for (int g = 0; g < RSV_DAYLIGHT_GROUPS; g++)
        sum += s->light[g];
    for (int g = 0; g < RSV_DAYLIGHT_GROUPS; g++)
        s->found->reflected[g] = sum > 0 ? s->light[g] * RSV_DAYLIGHT_GROUPS / sum : 1;
    s->found->stored_error = s->shared.light > 0 ? sqrt(variance) / s->shared.light : 0;
    s->found->buried = 2 * (uint64_t)s->backs > (uint64_t)s->per_group * RSV_DAYLIGHT_GROUPS;
}

void rsv_sensor_rays_trace(
    const rsv_daylight *d, const rsv_stored_noise *noise, size_t index, rsv_sensor_rays *found)
{
    sensor s = { .daylight = d,
        .op = rsv_operator_get_view(d->light->op),
        .noise = noise,
        .place = rsv_sensor_place_of(d, index),
        .found = found };
    s.per_group = (d->desc.sensor_rays + RSV_DAYLIGHT_GROUPS - 1) / RSV_DAYLIGHT_GROUPS;
    for (s.group = 0; s.group < RSV_DAYLIGHT_GROUPS; s.group++) {
        uint32_t stream = rsv_hash3(d->desc.seed ^ 0x1d2fu, (uint32_t)index, s.group);
        for (uint32_t k = 0; k < s.per_group; k++) {
            float x, y;
            rsv_sobol_2d(k, stream, &x, &y);
            rsv_vec3 h = rsv_square_to_cosine_hemisphere(x, y);
            rsv_random random = rsv_random_from(stream, k, 0x2f6u);
            trace(&s, v3_turned_to(s.place.normal, h), &random);
        }
    }
    summarise(&s);
}

double rsv_sun_passed(const rsv_daylight *d, const rsv_sensor_place *place, rsv_vec3 direction)
{
    const rsv_transport_scene *scene = &rsv_operator_get_view(d->light->op)->world->scene;
    rsv_ray ray = { place->origin, direction, INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, &ray, &hit)) return 1;
    rsv_specular_path path = rsv_specular_begin(scene, &place->medium, direction, hit);
    for (int panes = 0; panes < MOST_PANES; panes++) {
        rsv_bsdf_branches branches = rsv_specular_branches(scene, &path);
        if (rgb_is_black(branches.transmit)) return 0;
        rsv_specular_move move =
            rsv_specular_step(scene, &path, true, branches.transmit_direction, branches.transmit);
        if (move == RSV_SPECULAR_LOST) return 0;
        if (move == RSV_SPECULAR_LEFT_SCENE)
            return rsv_daylight_is_straight(direction, path.direction)
                       ? (double)rgb_luminance(path.weight)
                       : 0;
    }
    return 0;
}
