#include "pixel_direct.h"

#include "../core/stratified.h"

#include <string.h>

void rsv_pixel_direct_begin(rsv_pixel_direct *d, const rsv_solution *solution)
{
    memset(d, 0, sizeof *d);
    memset(d->packet.mask, 0xff, sizeof d->packet.mask);
    d->context = solution->context;
    d->tracer = solution->tracer;
}

void rsv_pixel_direct_end(rsv_pixel_direct *d) { rsv_free(d->context, d->term); }

static void trace_pending(rsv_pixel_direct *d)
{
    for (uint32_t k = d->pending; k < RSV_PACKET_WIDTH; k++)
        d->packet.t_max[k] = -1;
    if (d->pending) rsv_tracer_occluded_packet(d->tracer, &d->packet, true);
    for (uint32_t k = 0; k < d->pending; k++)
        d->term[d->owner[k]].visible = d->packet.t_max[k] > 0;
    d->pending = 0;
}

static rsv_direct_term *push_term(rsv_pixel_direct *d, rsv_direct_term term)
{
    if (d->status == RSV_OK)
        d->status = rsv_grow(
            d->context, (void **)&d->term, &d->term_capacity, d->term_count + 1, sizeof *d->term);
    if (d->status != RSV_OK) return NULL;
    d->term[d->term_count] = term;
    return &d->term[d->term_count++];
}

static void push_shadow_ray(rsv_pixel_direct *d, rsv_ray ray)
{
    uint32_t k = d->pending++;
    d->packet.origin_x[k] = ray.origin.x;
    d->packet.origin_y[k] = ray.origin.y;
    d->packet.origin_z[k] = ray.origin.z;
    d->packet.direction_x[k] = ray.direction.x;
    d->packet.direction_y[k] = ray.direction.y;
    d->packet.direction_z[k] = ray.direction.z;
    d->packet.t_max[k] = ray.t_max;
    d->owner[k] = d->term_count - 1;
    if (d->pending == RSV_PACKET_WIDTH) trace_pending(d);
}

/// A diffuse surface as sources light it.
typedef struct lit_point {
    const rsv_bsdf *bsdf;
    rsv_bsdf storage;
    rsv_surface_point point;
    rsv_vec3 origin;          ///< of shadow rays
    const rsv_medium *medium; ///< above it
    const rsv_bsdf *media;    ///< [material_count]
} lit_point;

static void set_up_point(
    const rsv_solution *s, const rsv_chain *chain, rsv_surface_point point, lit_point *lit)
{
    lit->bsdf = rsv_chain_bsdf(&s->scene, chain, &lit->storage);
    lit->point = point;
    lit->origin = rsv_offset_origin(point.position, point.geometric, point.extent);
    lit->medium = &chain->medium;
    lit->media = s->bsdf;
}

/// Share of light from a source at that distance that enters the surface.
static rsv_rgb entry(const lit_point *lit, float distance, float cos)
{
    return rgb_mul(rsv_bsdf_entry(lit->bsdf, cos),
        rsv_medium_transmittance(lit->medium, lit->media, distance));
}

/// Which of a pixel's camera rays the light is for.
typedef struct pixel_sample {
    uint32_t column, index, count, seed;
} pixel_sample;

static void add_emitters(rsv_pixel_direct *d, const rsv_solution *s, const lit_point *lit,
    rsv_rgb weight, pixel_sample sample)
{
    const rsv_surface_point *point = &lit->point;
    rsv_local_lights local;
    rsv_lights_at(s->lights, point->position, point->normal, &local);
    if (!local.by_tree && rgb_is_black(local.unshadowed)) return;
    rsv_direct_term term = { .column = sample.column,
        .sample = sample.index,
        .controlled = !local.by_tree && !lit->bsdf->coated };
    if (term.controlled) term.exact = rgb_mul(weight, local.unshadowed);
    float x, y, select = rsv_stratified_1d(sample.index, sample.count, rsv_hash2(sample.seed, 3));
    rsv_stratified_2d(sample.index, sample.count, rsv_hash2(sample.seed, 4), &x, &y);
    rsv_light_sample light;
    bool useful = rsv_local_lights_sample(&local, select, x, y, &light);
    if (useful) {
        float cos = v3_dot(point->normal, light.direction);
        rsv_rgb entered = rgb_mul(weight, entry(lit, light.distance, cos));
        float scale = cos / light.pdf_solid_angle;
        term.sampled = rgb_scale(rgb_mul(entered, light.radiance), scale);
        term.control = rgb_scale(rgb_mul(weight, light.mean_radiance), scale);
        // what the geometry hides from the shading normal is blocked like anything else
        useful = rsv_surface_faces(point, light.direction);
    }
    if (push_term(d, term) && useful)
        push_shadow_ray(d, rsv_shadow_ray(s->lights, &light, point->position, lit->origin));
}

static void add_punctual(rsv_pixel_direct *d, const rsv_solution *s, const lit_point *lit,
    rsv_rgb weight, pixel_sample sample)
{
    const rsv_surface_point *point = &lit->point;
    float u = rsv_stratified_1d(sample.index, sample.count, rsv_hash2(sample.seed, 5));
    for (uint32_t k = 0; k < rsv_punctual_count(s->lights); k++) {
        rsv_punctual_sample light;
        if (!rsv_punctual_at(s->lights, point->position, point->normal, k, u, &light) ||
            !rsv_surface_faces(point, light.direction))
            continue;
        float cos = v3_dot(point->normal, light.direction);
        rsv_rgb entered = rgb_mul(weight, entry(lit, light.distance, cos));
        rsv_direct_term term = { .column = sample.column,
            .sample = sample.index,
            .sampled = rgb_scale(rgb_mul(entered, light.irradiance), cos) };
        if (push_term(d, term)) push_shadow_ray(d, rsv_punctual_ray(&light, lit->origin));
    }
}

void rsv_pixel_direct_add(rsv_pixel_direct *d, const rsv_solution *s, const rsv_chain *chain,
    rsv_rgb weight, uint32_t column, uint32_t sample, uint32_t samples, uint32_t seed)
{
    pixel_sample of = { column, sample, samples, seed };
    lit_point lit;
    set_up_point(s, chain,
        rsv_surface_point_seen(
            s->scene.view, chain->triangle, chain->u, chain->v, chain->back, chain->width),
        &lit);
    if (rsv_lights_any_sampled(s->lights)) add_emitters(d, s, &lit, weight, of);
    add_punctual(d, s, &lit, weight, of);
}

static rsv_rgb resolve_pixel(const rsv_direct_term *term, size_t count, float *squares)
{
    rsv_rgb sum = rgb_gray(0);
    float visible = 0, controlled = 0, of_sample = 0;
    for (size_t i = 0; i < count; i++) {
        if (!term[i].controlled) continue;
        visible += term[i].visible;
        controlled += 1;
    }
    *squares = 0;
    for (size_t i = 0; i < count; i++) {
        rsv_rgb light = rgb_scale(term[i].sampled, term[i].visible);
        if (term[i].controlled && controlled > 1) {
            float others = (visible - term[i].visible) / (controlled - 1);
            light = rgb_mad(light, others, rgb_sub(term[i].exact, term[i].control));
        }
        sum = rgb_add(sum, light);
        of_sample += rgb_luminance(light);
        if (i + 1 < count && term[i + 1].sample == term[i].sample) continue;
        *squares += of_sample * of_sample;
        of_sample = 0;
    }
    return sum;
}

rsv_status rsv_pixel_direct_resolve(rsv_pixel_direct *d, rsv_pixel_direct_sink add, void *user)
{
    trace_pending(d);
    for (size_t begin = 0, end; begin < d->term_count; begin = end) {
        uint32_t column = d->term[begin].column;
        for (end = begin; end < d->term_count && d->term[end].column == column; end++)
            ;
        float squares;
        rsv_rgb light = resolve_pixel(d->term + begin, end - begin, &squares);
        add(user, column, light, squares);
    }
    d->term_count = 0;
    return d->status;
}

static bool is_open(const rsv_solution *s, rsv_ray ray)
{
    return !rsv_tracer_occluded(s->tracer, &ray);
}

static rsv_rgb sampled_emitter(const rsv_solution *s, const lit_point *lit, rsv_random *random)
{
    rsv_local_lights local;
    rsv_light_sample light;
    const rsv_surface_point *point = &lit->point;
    rsv_lights_at(s->lights, point->position, point->normal, &local);
    float select = rsv_random_float(random), x = rsv_random_float(random);
    if (!rsv_local_lights_sample(&local, select, x, rsv_random_float(random), &light) ||
        !rsv_surface_faces(point, light.direction) ||
        !is_open(s, rsv_shadow_ray(s->lights, &light, point->position, lit->origin)))
        return rgb_gray(0);
    float cos = v3_dot(point->normal, light.direction);
    rsv_rgb entered = rgb_mul(light.radiance, entry(lit, light.distance, cos));
    return rgb_scale(entered, cos / light.pdf_solid_angle);
}

rsv_rgb rsv_sampled_irradiance(const rsv_solution *s, const rsv_chain *chain, rsv_random *random)
{
    lit_point lit;
    set_up_point(s, chain,
        rsv_surface_point_at(s->scene.view, chain->triangle, chain->u, chain->v, chain->back),
        &lit);
    rsv_rgb sum = rgb_gray(0);
    if (rsv_lights_any_sampled(s->lights)) sum = sampled_emitter(s, &lit, random);
    float u = rsv_random_float(random);
    for (uint32_t k = 0; k < rsv_punctual_count(s->lights); k++) {
        rsv_punctual_sample light;
        if (!rsv_punctual_at(s->lights, lit.point.position, lit.point.normal, k, u, &light) ||
            !rsv_surface_faces(&lit.point, light.direction) ||
            !is_open(s, rsv_punctual_ray(&light, lit.origin)))
            continue;
        float cos = v3_dot(lit.point.normal, light.direction);
        rsv_rgb entered = rgb_mul(light.irradiance, entry(&lit, light.distance, cos));
        sum = rgb_mad(sum, cos, entered);
    }
    return sum;
}
