#include "path_volume.h"

#include "path_sources.h"

/// A ray through the blocks of a volume, each with its majorant.
typedef struct tracking {
    const rsv_fog *fog;
    const rsv_volume *volume;
    rsv_grid_line line;   ///< in cells
    rsv_grid_walk blocks; ///< in blocks
    double most;          ///< of the extinctions of channels per density
    double majorant;      ///< in the walk's block, 1/m
    double exit;          ///< of that, metres
    int axis;
} tracking;

static void look_up_block(tracking *t)
{
    const rsv_volume *v = t->volume;
    const int32_t *block = t->blocks.cell;
    size_t line = v->block_side[0], plane = line * v->block_side[1];
    t->exit = rsv_grid_exit(&t->blocks, &t->axis);
    t->majorant =
        t->most *
        (double)
            v->block_densest[(size_t)block[2] * plane + (size_t)block[1] * line + (size_t)block[0]];
}

static tracking track(const rsv_fog *fog, const rsv_ray *ray)
{
    tracking t = { .fog = fog, .volume = fog->volume, .most = (double)rgb_max(fog->extinction) };
    double begin = 0, end = (double)ray->t_max;
    int32_t last[3];
    rsv_grid_line line;
    rsv_fog_clip_to_box(fog, ray->origin, ray->direction, &begin, &end);
    t.line = rsv_volume_line(t.volume, ray->origin, ray->direction);
    for (int k = 0; k < 3; k++) {
        line.origin[k] = t.line.origin[k] / RSV_VOLUME_BLOCK;
        line.slope[k] = t.line.slope[k] / RSV_VOLUME_BLOCK;
        last[k] = (int32_t)t.volume->block_side[k] - 1;
    }
    t.blocks = rsv_grid_begin(&line, last, begin, fmax(begin, end));
    look_up_block(&t);
    return t;
}

/// Goes on to the next tentative collision. False if there is none. @param s out: metres along the ray
static bool collide(tracking *t, rsv_random *random, double *s)
{
    while (t->blocks.at < t->blocks.end) {
        double step = -log1p(-(double)rsv_random_float(random)) / t->majorant;
        if (t->majorant > 0 && t->blocks.at + step < t->exit) {
            *s = t->blocks.at += step;
            return true;
        }
        rsv_grid_advance(&t->blocks, t->axis, t->exit);
        look_up_block(t);
    }
    return false;
}

/// Extinction per majorant.
static rsv_rgb local_share(const tracking *t, double s)
{
    double density = rsv_volume_density(t->volume, &t->line, s);
    return rgb_scale(t->fog->extinction, (float)(density / t->majorant));
}

rsv_rgb rsv_path_volume_transmittance(const rsv_fog *fog, rsv_random *random, const rsv_ray *ray)
{
    tracking t = track(fog, ray);
    rsv_rgb passed = rgb_gray(1);
    double s;
    while (collide(&t, random, &s)) {
        passed = rgb_mul(passed, rgb_sub(rgb_gray(1), local_share(&t, s)));
        if (rgb_is_black(passed)) break;
    }
    return passed;
}

static float sum_of(rsv_rgb c) { return c.r + c.g + c.b; }

/// What the fog emits per majorant, where it collides.
static void add_emission(rsv_light_path *path, const tracking *t, double s)
{
    double density = rsv_volume_density(t->volume, &t->line, s);
    if (rgb_is_black(t->fog->emission)) return;
    rsv_path_add_light(path, path->diffuse_events, path->throughput,
        rgb_scale(t->fog->emission, (float)(density / t->majorant)));
}

/// Whether the path is scattered at a tentative collision; weighs it either way.
static bool is_scattered(rsv_light_path *path, const tracking *t, double s, rsv_random *random)
{
    rsv_rgb share = local_share(t, s);
    rsv_rgb scattered = rgb_mul(path->throughput, rgb_mul(share, t->fog->albedo));
    rsv_rgb passed = rgb_mul(path->throughput, rgb_sub(rgb_gray(1), share));
    float sum = sum_of(scattered) + sum_of(passed);
    path->throughput = rgb_gray(0);
    if (!(sum > 0)) return false;
    float probability = sum_of(scattered) / sum;
    bool is = rsv_random_float(random) < probability;
    path->throughput =
        is ? rgb_scale(scattered, 1 / probability) : rgb_scale(passed, 1 / (1 - probability));
    return is;
}

rsv_fog_outcome rsv_path_cross_volume(rsv_light_path *path, float length)
{
    const rsv_fog *fog = path->tracer->fog;
    const rsv_ray ray = { path->ray.origin, v3_normalize(path->ray.direction), length };
    tracking t = track(fog, &ray);
    rsv_random *random = &path->numbers.random;
    double s;
    while (collide(&t, random, &s)) {
        add_emission(path, &t, s);
        bool scattered = is_scattered(path, &t, s, random);
        if (rgb_is_black(path->throughput)) return RSV_FOG_ABSORBED;
        if (!scattered) continue;
        path->vertex = (rsv_fog_vertex){ .origin = ray.origin,
            .forward = ray.direction,
            .by_collision = true,
            .distance = s,
            .point = v3_mad(ray.origin, (float)s, ray.direction) };
        return rsv_path_turn_in_fog(path);
    }
    return RSV_FOG_PASSED;
}
