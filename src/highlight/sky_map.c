#include "sky_map.h"

#include "../core/core.h"
#include "../core/octahedral.h"
#include "lobe_polygon.h"

#include <string.h>

#define LEAST_SIDE 4
#define MOST_SIDE 2048

// ---- making -------------------------------------------------------------------------------------

typedef struct splat {
    rsv_rgb *texel;
    float *weight; ///< solid angle
    uint32_t side;
} splat;

static void add_patch(void *user, rsv_vec3 direction, double solid_angle, rsv_rgb radiance)
{
    splat *s = user;
    uint32_t bin = rsv_octahedral_bin(direction, s->side);
    s->texel[bin] = rgb_mad(s->texel[bin], (float)solid_angle, radiance);
}

static void add_weight(void *user, rsv_vec3 direction, double solid_angle, rsv_rgb radiance)
{
    splat *s = user;
    (void)radiance;
    s->weight[rsv_octahedral_bin(direction, s->side)] += (float)solid_angle;
}

static rsv_rgb sky_at(const rsv_sky *const *sky, int count, rsv_vec3 direction)
{
    rsv_rgb sum = rgb_gray(0);
    for (int k = 0; k < count; k++)
        sum = rgb_add(sum, rsv_sky_radiance(sky[k], direction));
    return sum;
}

/// Texels that no patch fell into take what is in their middle.
static void finish_finest(splat *s, const rsv_sky *const *sky, int count)
{
    for (uint32_t i = 0; i < s->side * s->side; i++) {
        if (s->weight[i] > 0) {
            s->texel[i] = rgb_scale(s->texel[i], 1 / s->weight[i]);
            continue;
        }
        float x = ((float)(i % s->side) + 0.5f) / (float)s->side;
        float y = ((float)(i / s->side) + 0.5f) / (float)s->side;
        s->texel[i] = sky_at(sky, count, rsv_octahedral_to_direction(x, y));
        s->weight[i] = 1e-9f;
    }
}

/// Four texels to one, by their solid angles.
static void halve(const rsv_rgb *fine, float *weight, uint32_t side, rsv_rgb *coarse)
{
    uint32_t half = side / 2;
    for (uint32_t j = 0; j < half; j++) {
        for (uint32_t i = 0; i < half; i++) {
            rsv_rgb sum = rgb_gray(0);
            float total = 0;
            for (uint32_t k = 0; k < 4; k++) {
                size_t from = (size_t)(2 * j + k / 2) * side + 2 * i + k % 2;
                sum = rgb_mad(sum, weight[from], fine[from]);
                total += weight[from];
            }
            coarse[j * half + i] = rgb_scale(sum, 1 / total);
            weight[(size_t)j * half + i] = total; // texels ahead of those still to be read
        }
    }
}

static uint32_t power_of_two(uint32_t side)
{
    uint32_t power = LEAST_SIDE;
    while (2 * power <= side && power < MOST_SIDE)
        power *= 2;
    return power;
}

static void lay_out(rsv_sky_map *map, size_t *count)
{
    *count = 0;
    for (uint32_t side = map->side; side >= LEAST_SIDE && map->levels < RSV_SKY_LEVELS; side /= 2) {
        map->first[map->levels++] = *count;
        *count += (size_t)side * side;
    }
}

rsv_status rsv_sky_map_create(
    const rsv_lights *lights, rsv_highlight_part part, uint32_t side, rsv_sky_map *map)
{
    const rsv_environment_light *e = lights->environment;
    const rsv_sky *sky[2];
    int skies = 0;
    size_t count;
    *map = (rsv_sky_map){ .side = power_of_two(side) };
    if (e && (part & RSV_HIGHLIGHT_SAMPLED) && e->sampled.pixel) sky[skies++] = &e->sampled;
    if (e && (part & RSV_HIGHLIGHT_GATHERED) && e->gathered.pixel) sky[skies++] = &e->gathered;
    if (skies == 0) return RSV_OK;
    lay_out(map, &count);
    rsv_context *context = lights->context;
    map->texel = rsv_alloc(context, count, sizeof *map->texel);
    splat s = { map->texel, rsv_alloc(context, (size_t)map->side * map->side, sizeof(float)),
        map->side };
    if (map->texel && s.weight) {
        rsv_sky_visit(sky[0], add_weight, &s);
        for (int k = 0; k < skies; k++)
            rsv_sky_visit(sky[k], add_patch, &s);
        finish_finest(&s, sky, skies);
        for (uint32_t l = 1; l < map->levels; l++)
            halve(map->texel + map->first[l - 1], s.weight, map->side >> (l - 1),
                map->texel + map->first[l]);
    }
    bool failed = !map->texel || !s.weight;
    rsv_free(context, s.weight);
    return failed ? RSV_ERROR_MEMORY : RSV_OK;
}

// ---- looking up -----------------------------------------------------------------------------------

/// Where the square ends, the sphere goes on at its edge mirrored about the middle of that.
static rsv_rgb texel_at(const rsv_rgb *texel, int side, int i, int j)
{
    if (i < 0 || i >= side) {
        i = i < 0 ? -1 - i : 2 * side - 1 - i;
        j = side - 1 - j;
    }
    if (j < 0 || j >= side) {
        j = j < 0 ? -1 - j : 2 * side - 1 - j;
        i = side - 1 - i;
    }
    return texel[(size_t)j * (size_t)side + (size_t)i];
}

static rsv_rgb level_at(const rsv_sky_map *map, uint32_t level, float x, float y)
{
    const rsv_rgb *texel = map->texel + map->first[level];
    int side = (int)(map->side >> level);
    float u = x * (float)side - 0.5f, v = y * (float)side - 0.5f;
    int i = (int)floorf(u), j = (int)floorf(v);
    float fu = u - (float)i, fv = v - (float)j;
    rsv_rgb above = rgb_mad(
        rgb_scale(texel_at(texel, side, i, j), 1 - fu), fu, texel_at(texel, side, i + 1, j));
    rsv_rgb below = rgb_mad(rgb_scale(texel_at(texel, side, i, j + 1), 1 - fu), fu,
        texel_at(texel, side, i + 1, j + 1));
    return rgb_mad(rgb_scale(above, 1 - fv), fv, below);
}

rsv_rgb rsv_sky_map_mean(const rsv_sky_map *map, rsv_vec3 direction, float solid_angle)
{
    if (!map->texel) return rgb_gray(0);
    float x, y, side = (float)map->side;
    rsv_octahedral_from_direction(direction, &x, &y);
    // a texel of the finest level has 4 pi / side^2 in the mean
    float level = 0.5f * log2f(f_max(solid_angle * side * side / (4 * RSV_PI), 1));
    level = f_min(level, (float)(map->levels - 1));
    uint32_t fine = (uint32_t)level;
    float weight = level - (float)fine;
    rsv_rgb mean = level_at(map, fine, x, y);
    if (!(weight > 0)) return mean;
    return rgb_mad(rgb_scale(mean, 1 - weight), weight, level_at(map, fine + 1, x, y));
}

// ---- lobes ----------------------------------------------------------------------------------------

/// Directions of equal share under the plain cosine: three around the middle and five about them, at the
/// middles of their shares of the disk.
rsv_vec3 rsv_lobe_tap(const rsv_highlight_lobe *lobe, uint32_t k, float *density)
{
    const float tap[RSV_LOBE_TAPS][2] = { { 0.4330127f, 0.0000000f }, { -0.2165064f, 0.3750000f },
        { -0.2165064f, -0.3750000f }, { 0.6708015f, 0.4873658f }, { -0.2562234f, 0.7885744f },
        { -0.8291562f, 0.0000000f }, { -0.2562234f, -0.7885744f }, { 0.6708015f, -0.4873658f } };
    float x = tap[k][0], y = tap[k][1];
    rsv_vec3 v = v3(x, y, sqrtf(f_max(1 - x * x - y * y, 0)));
    rsv_vec3 wi = rsv_lobe_direction(&lobe->shape, v);
    *density = rsv_lobe_density(&lobe->shape, wi);
    return wi;
}

static rsv_rgb divided(rsv_rgb a, rsv_rgb b)
{
    return rgb(b.r > 0 ? a.r / b.r : 0, b.g > 0 ? a.g / b.g : 0, b.b > 0 ? a.b / b.b : 0);
}

/// Directions weighed by how much more of their light the BSDF reflects than the transformed cosine, all together the albedo.
static rsv_rgb lobe_light(
    const rsv_sky_map *map, const rsv_highlight_lobes *l, const rsv_highlight_lobe *lobe)
{
    rsv_rgb sum = rgb_gray(0), total = rgb_gray(0);
    bool below = rsv_lobe_is_below(lobe->kind);
    for (uint32_t k = 0; k < RSV_LOBE_TAPS; k++) {
        float density;
        rsv_vec3 local = rsv_lobe_tap(lobe, k, &density);
        if (below) local.z = -local.z;
        rsv_vec3 wi = rsv_from_lobe_frame(l, local);
        if (!(density > 1e-20f)) continue;
        rsv_rgb weight = rgb_scale(rsv_lobe_response(l, lobe->kind, wi), 1 / density);
        total = rgb_add(total, weight);
        if (v3_dot(l->point.horizon, wi) * local.z <= 0) continue;
        float solid_angle = 1 / (RSV_LOBE_TAPS * density);
        sum = rgb_add(sum, rgb_mul(weight, rsv_sky_map_mean(map, wi, solid_angle)));
    }
    return rgb_mul(divided(sum, total), lobe->albedo);
}

rsv_rgb rsv_sky_map_light(const rsv_sky_map *map, const rsv_highlight_lobes *l)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; map->texel && k < l->count; k++)
        sum = rgb_add(sum, lobe_light(map, l, &l->lobe[k]));
    return sum;
}
