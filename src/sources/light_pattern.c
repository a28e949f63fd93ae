#include "light_pattern.h"

#include "../core/sampling.h"
#include "lights_internal.h"

static const rsv_emitter *sampled(const rsv_lights *lights, size_t k)
{
    return &lights->emitter[lights->sampled[k]];
}

static double total_power(const rsv_lights *lights)
{
    double total = 0;
    for (size_t k = 0; k < lights->sampled_count; k++)
        total += rsv_emitter_power(sampled(lights, k));
    return total;
}

/// The emitter in which a share of all power is reached, and how far into its own. @param share in, out: 0..1
static const rsv_emitter *emitter_at(const rsv_lights *lights, double total, double *share)
{
    size_t k = 0;
    double left = *share * total, power = rsv_emitter_power(sampled(lights, 0));
    while (left >= power && k + 1 < lights->sampled_count) {
        left -= power;
        power = rsv_emitter_power(sampled(lights, ++k));
    }
    *share = power > 0 ? fmin(left / power, 0x1.fffffep-1) : 0;
    return sampled(lights, k);
}

static rsv_pattern_place place_of(const rsv_lights *lights, double total, uint32_t index)
{
    const float middle = 0.5f / RSV_PATTERN_PLACES; // of the strata that Sobol's points begin at
    float x = rsv_unit_float(rsv_reverse_bits(index)) + middle, u, v;
    float y = rsv_unit_float(rsv_sobol_second(index)) + middle;
    double share = x;
    const rsv_emitter *e = emitter_at(lights, total, &share);
    rsv_square_to_triangle((float)share, y, &u, &v);
    double area = total * e->area / (rsv_emitter_power(e) * RSV_PATTERN_PLACES);
    return (
        rsv_pattern_place){ .point = v3_barycentric(e->corner[0], e->corner[1], e->corner[2], u, v),
        .normal = e->normal,
        .area = (float)area,
        .strength = rgb_scale(e->radiance, (float)area),
        .extent = rsv_triangle_extent(lights->scene, e->triangle),
        .double_sided = e->double_sided };
}

rsv_light_pattern rsv_light_pattern_of(const rsv_lights *lights)
{
    double total = total_power(lights);
    rsv_light_pattern pattern = { .any = total > 0 };
    for (uint32_t k = 0; k < RSV_PATTERN_PLACES && pattern.any; k++)
        pattern.place[k] = place_of(lights, total, k);
    if (lights->sampled_count > RSV_PATTERN_POLYGONS) return pattern;
    for (size_t k = 0; k < lights->sampled_count && pattern.any; k++)
        pattern.polygon[pattern.polygons++] = sampled(lights, k);
    return pattern;
}
