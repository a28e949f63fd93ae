#include "pixel_direct.h"

#include "../sources/punctual_light.h"
#include "../surface/lift.h"
#include "../trace/packet.h"
#include "../trace/passage.h"

#include <string.h>

/// Shadow rays of a sample at most, the first included.
#define MOST_RAYS 8
/// What a camera ray costs, in shadow rays.
#define CAMERA_RAY_COST 5
/// Samples whose light is this share of the brightest of their pixel, or less, are content with one.
#define FAINT_SHARE 0.2f
/// Pixels to either side that a pixel asks how noisy it is.
#define NEIGHBOURS 2

rsv_status rsv_pixel_direct_begin(
    rsv_pixel_direct *d, const rsv_light_view *solution, uint32_t width)
{
    memset(d, 0, sizeof *d);
    memset(d->packet.mask, 0xff, sizeof d->packet.mask);
    d->solution = solution;
    d->width = width;
    d->tally = rsv_alloc(solution->context, width, sizeof *d->tally);
    return d->tally ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_pixel_direct_end(rsv_pixel_direct *d)
{
    rsv_context *context = d->solution->context;
    rsv_free(context, d->tally);
    rsv_free(context, d->term);
    rsv_free(context, d->spot);
}

static void trace_pending(rsv_pixel_direct *d)
{
    for (uint32_t k = d->pending; k < RSV_PACKET_WIDTH; k++)
        d->packet.t_max[k] = -1;
    float passed[RSV_PACKET_WIDTH];
    if (d->pending) rsv_tracer_passed_packet(d->solution->tracer, &d->packet, true, passed);
    for (uint32_t k = 0; k < d->pending; k++) {
        if (!(passed[k] > 0)) continue;
        rsv_direct_term *term = &d->term[d->owner[k]];
        term->arrived = rgb_mad(term->arrived, passed[k], d->carried[k]);
        if (!d->known[k]) continue;
        term->seen += passed[k];
        term->veiled += passed[k] * (1 - passed[k]);
    }
    d->pending = 0;
}

static bool push_term(rsv_pixel_direct *d, rsv_direct_term term)
{
    if (d->status == RSV_OK)
        d->status = rsv_grow(d->solution->context, (void **)&d->term, &d->term_capacity,
            d->term_count + 1, sizeof *d->term);
    if (d->status == RSV_OK) d->term[d->term_count++] = term;
    return d->status == RSV_OK;
}

/// Of the last term.
static void push_spot(
    rsv_pixel_direct *d, const rsv_specular_path *path, rsv_rgb weight, rsv_pixel_sample sample)
{
    if (d->status == RSV_OK)
        d->status = rsv_grow(d->solution->context, (void **)&d->spot, &d->spot_capacity,
            d->spot_count + 1, sizeof *d->spot);
    if (d->status == RSV_OK)
        d->spot[d->spot_count++] = (rsv_direct_spot){ *path, weight, sample, d->term_count - 1 };
}

/// @param carried what the ray brings to its term if it is free
/// @param known   closed forms know its source
static void push_shadow_ray(
    rsv_pixel_direct *d, size_t term, rsv_ray ray, rsv_rgb carried, bool known)
{
    uint32_t k = d->pending++;
    rsv_packet_set_ray(&d->packet, k, ray);
    d->owner[k] = term;
    d->carried[k] = carried;
    d->known[k] = known;
    if (d->pending == RSV_PACKET_WIDTH) trace_pending(d);
}

/// The half of a pixel's samples that one belongs to.
static uint32_t half_of(uint32_t sample) { return sample & 1; }

/// The sample as one of its half alone, which is drawn for without regard to the other.
static rsv_pixel_sample within_half(rsv_pixel_sample sample)
{
    uint32_t half = half_of(sample.index);
    return (rsv_pixel_sample){ sample.index / 2, (sample.count + 1 - half) / 2,
        rsv_hash2(sample.seed, 7 + half) };
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
    const rsv_light_view *s, const rsv_specular_path *path, rsv_surface_point point, lit_point *lit)
{
    lit->bsdf = rsv_specular_bsdf(&s->scene, path, &lit->storage);
    lit->point = point;
    rsv_surface_lift(s->scene.view, s->tracer, path->triangle, path->u, path->v, &lit->point);
    lit->origin = rsv_offset_origin(point.position, point.geometric, point.extent);
    lit->medium = &path->medium;
    lit->media = s->bsdf;
}

/// Share of light from a source at that distance that enters the surface.
static rsv_rgb entry(const lit_point *lit, float distance, float cos)
{
    return rgb_mul(rsv_bsdf_entry(lit->bsdf, cos),
        rsv_medium_transmittance(lit->medium, lit->media, distance));
}

/// Sends a shadow ray of a term to one of the emitters.
static void aim(rsv_pixel_direct *d, size_t term, const rsv_local_lights *local,
    const lit_point *lit, rsv_rgb weight, rsv_pixel_sample sample)
{
    const rsv_surface_point *point = &lit->point;
    float x, y, select = rsv_pixel_sample_1d(sample, 3);
    rsv_pixel_sample_2d(sample, 4, &x, &y);
    d->term[term].rays++;
    rsv_light_sample light;
    if (!rsv_local_lights_sample(local, select, x, y, &light)) return;
    float cos = v3_dot(point->normal, light.direction), scale = cos / light.pdf_solid_angle;
    bool known = rsv_light_sample_is_weighed(&light);
    d->term[term].asked += known;
    rsv_rgb control = rgb_mul(weight, light.mean_radiance);
    d->term[term].control = rgb_mad(d->term[term].control, scale, control);
    // what the geometry hides from the shading normal is blocked like anything else
    if (!rsv_surface_faces(point, light.direction)) return;
    rsv_rgb entered = rgb_mul(weight, entry(lit, light.distance, cos));
    push_shadow_ray(d, term,
        rsv_shadow_ray(d->solution->lights, &light, point->position,
            rsv_lifted_origin(point, lit->origin, light.direction)),
        rgb_scale(rgb_mul(entered, light.radiance), scale), known);
}

static void add_emitters(rsv_pixel_direct *d, const rsv_specular_path *path, const lit_point *lit,
    rsv_rgb weight, uint32_t column, rsv_pixel_sample sample)
{
    rsv_local_lights local;
    rsv_lights_at(d->solution->lights, lit->point.position, lit->point.normal, &local);
    if (rsv_local_lights_are_dark(&local)) return;
    rsv_direct_term term = {
        .column = column, .sample = sample.index, .exact = rgb_mul(weight, local.unshadowed)
    };
    term.expected = rgb_luminance(term.exact) + rgb_luminance(weight) * local.tree_estimate;
    if (!push_term(d, term)) return;
    push_spot(d, path, weight, sample);
    aim(d, d->term_count - 1, &local, lit, weight, within_half(sample));
}

static void add_punctual(rsv_pixel_direct *d, const lit_point *lit, rsv_rgb weight, uint32_t column,
    rsv_pixel_sample sample)
{
    const rsv_surface_point *point = &lit->point;
    const rsv_lights *lights = d->solution->lights;
    float u = rsv_pixel_sample_1d(sample, 5);
    for (uint32_t k = 0; k < rsv_punctual_count(lights); k++) {
        rsv_punctual_sample light;
        if (!rsv_punctual_at(lights, point->position, point->normal, k, u, &light) ||
            !rsv_surface_faces(point, light.direction))
            continue;
        float cos = v3_dot(point->normal, light.direction);
        rsv_rgb entered = rgb_mul(weight, entry(lit, light.distance, cos));
        rsv_direct_term term = { .column = column, .sample = sample.index, .rays = 1 };
        if (push_term(d, term))
            push_shadow_ray(d, d->term_count - 1,
                rsv_punctual_ray(&light, rsv_lifted_origin(point, lit->origin, light.direction)),
                rgb_scale(rgb_mul(entered, light.irradiance), cos), false);
    }
}

static void set_up_seen(
    const rsv_light_view *s, const rsv_specular_path *path, rsv_pixel_sample sample, lit_point *lit)
{
    float width = rsv_width_of_sample(path->width, sample);
    set_up_point(s, path,
        rsv_surface_point_seen(s->scene.view, path->triangle, path->u, path->v, path->back, width),
        lit);
}

void rsv_pixel_direct_add(rsv_pixel_direct *d, const rsv_specular_path *path, rsv_rgb weight,
    uint32_t column, rsv_pixel_sample sample)
{
    lit_point lit;
    set_up_seen(d->solution, path, sample, &lit);
    if (rsv_lights_any_sampled(d->solution->lights))
        add_emitters(d, path, &lit, weight, column, sample);
    add_punctual(d, &lit, weight, column, sample);
}

// ---- penumbrae ----------------------------------------------------------------------------------

static void tally_rays(rsv_pixel_direct *d)
{
    memset(d->tally, 0, d->width * sizeof *d->tally);
    for (size_t k = 0; k < d->spot_count; k++) {
        const rsv_direct_term *term = &d->term[d->spot[k].term];
        rsv_shadow_tally *tally = &d->tally[term->column];
        float exact = rgb_luminance(term->exact);
        tally->asked += term->asked;
        tally->seen += term->seen;
        tally->veiled += term->veiled;
        tally->brightest = f_max(tally->brightest, term->expected);
        tally->squares += exact * exact;
        float further = term->asked ? 0 : rgb_luminance(term->arrived);
        tally->terms++;
        tally->further += further;
        tally->further_squares += further * further;
    }
}

/// Sum of the squared deviations of what the first shadow rays found: by visibility, as all else is known, and by which
/// emitters the tree chose.
static float light_spread(const rsv_shadow_tally *t)
{
    float share = t->asked ? t->seen / (float)t->asked : 0;
    float veiled = t->asked ? t->veiled / (float)t->asked : 0;
    float by_choice = t->terms ? t->further_squares - t->further * t->further / (float)t->terms : 0;
    return t->squares * f_max(share * (1 - share) - veiled, 0) + f_max(by_choice, 0);
}

/// Further shadow rays of each sample of a pixel, by its neighbours.
static uint32_t further_rays(
    const rsv_pixel_direct *d, const rsv_pixel_noise *noise, uint32_t column)
{
    rsv_shadow_tally around = { 0 };
    uint32_t first = column > NEIGHBOURS ? column - NEIGHBOURS : 0;
    float spread = 0;
    for (uint32_t k = first; k <= column + NEIGHBOURS && k < d->width; k++) {
        if (k == column) continue;
        around.asked += d->tally[k].asked;
        around.seen += d->tally[k].seen;
        around.veiled += d->tally[k].veiled;
        around.squares += d->tally[k].squares;
        around.terms += d->tally[k].terms;
        around.further += d->tally[k].further;
        around.further_squares += d->tally[k].further_squares;
        spread += rsv_pixel_noise_spread(&noise[k]);
    }
    float light = light_spread(&around);
    if (!(light > 0)) return 0;
    // nothing else is uncertain
    if (spread * (MOST_RAYS * MOST_RAYS) <= CAMERA_RAY_COST * light) return MOST_RAYS - 1;
    float rays = sqrtf(CAMERA_RAY_COST * light / spread);
    return rays > 1 ? (uint32_t)(rays - 0.5f) : 0;
}

static void send_further_rays(rsv_pixel_direct *d, const rsv_direct_spot *spot, uint32_t further)
{
    const rsv_light_view *s = d->solution;
    lit_point lit;
    rsv_local_lights local;
    set_up_seen(s, &spot->path, spot->sample, &lit);
    rsv_lights_at(s->lights, lit.point.position, lit.point.normal, &local);
    rsv_pixel_sample own = within_half(spot->sample);
    rsv_pixel_sample sample = { own.index * further, own.count * further, rsv_hash2(own.seed, 6) };
    for (uint32_t ray = 0; ray < further; ray++, sample.index++)
        aim(d, spot->term, &local, &lit, spot->weight, sample);
}

static void look_into_penumbrae(rsv_pixel_direct *d, const rsv_pixel_noise *noise)
{
    tally_rays(d);
    for (size_t k = 0; k < d->spot_count; k++) {
        const rsv_direct_term *term = &d->term[d->spot[k].term];
        if (term->expected <= FAINT_SHARE * d->tally[term->column].brightest) continue;
        uint32_t further = further_rays(d, noise, term->column);
        if (further) send_further_rays(d, &d->spot[k], further);
    }
    trace_pending(d);
}

static rsv_rgb resolve_pixel(const rsv_direct_term *term, size_t count, float *squares)
{
    rsv_rgb sum = rgb_gray(0);
    uint32_t asked[2] = { 0, 0 };
    float of_sample = 0, seen[2] = { 0, 0 };
    for (size_t i = 0; i < count; i++) {
        seen[half_of(term[i].sample)] += term[i].seen;
        asked[half_of(term[i].sample)] += term[i].asked;
    }
    *squares = 0;
    for (size_t i = 0; i < count; i++) {
        float share = 1 / (float)term[i].rays;
        rsv_rgb light = rgb_scale(term[i].arrived, share);
        uint32_t other = 1 - half_of(term[i].sample);
        if (asked[other] > 0) {
            float others = seen[other] / (float)asked[other];
            light =
                rgb_mad(light, others, rgb_sub(term[i].exact, rgb_scale(term[i].control, share)));
        }
        sum = rgb_add(sum, light);
        of_sample += rgb_luminance(light);
        if (i + 1 < count && term[i + 1].sample == term[i].sample) continue;
        *squares += of_sample * of_sample;
        of_sample = 0;
    }
    return sum;
}

rsv_status rsv_pixel_direct_resolve(
    rsv_pixel_direct *d, const rsv_pixel_noise *noise, rsv_pixel_direct_sink add, void *user)
{
    trace_pending(d);
    look_into_penumbrae(d, noise);
    for (size_t begin = 0, end; begin < d->term_count; begin = end) {
        uint32_t column = d->term[begin].column;
        for (end = begin; end < d->term_count && d->term[end].column == column; end++)
            ;
        float squares;
        rsv_rgb light = resolve_pixel(d->term + begin, end - begin, &squares);
        add(user, column, light, squares);
    }
    d->term_count = d->spot_count = 0;
    return d->status;
}

static rsv_rgb sampled_emitter(const rsv_light_view *s, const lit_point *lit, rsv_random *random)
{
    rsv_local_lights local;
    rsv_light_sample light;
    const rsv_surface_point *point = &lit->point;
    rsv_lights_at(s->lights, point->position, point->normal, &local);
    float select = rsv_random_float(random), x = rsv_random_float(random);
    if (!rsv_local_lights_sample(&local, select, x, rsv_random_float(random), &light) ||
        !rsv_surface_faces(point, light.direction))
        return rgb_gray(0);
    rsv_ray ray = rsv_shadow_ray(
        s->lights, &light, point->position, rsv_lifted_origin(point, lit->origin, light.direction));
    float cos = v3_dot(point->normal, light.direction), passed = rsv_tracer_passed(s->tracer, &ray);
    rsv_rgb entered = rgb_mul(light.radiance, entry(lit, light.distance, cos));
    return rgb_scale(entered, passed * cos / light.pdf_solid_angle);
}

rsv_rgb rsv_sampled_irradiance(
    const rsv_light_view *s, const rsv_specular_path *path, rsv_random *random)
{
    lit_point lit;
    set_up_point(s, path,
        rsv_surface_point_at(s->scene.view, path->triangle, path->u, path->v, path->back), &lit);
    rsv_rgb sum = rgb_gray(0);
    if (rsv_lights_any_sampled(s->lights)) sum = sampled_emitter(s, &lit, random);
    float u = rsv_random_float(random);
    for (uint32_t k = 0; k < rsv_punctual_count(s->lights); k++) {
        rsv_punctual_sample light;
        if (!rsv_punctual_at(s->lights, lit.point.position, lit.point.normal, k, u, &light) ||
            !rsv_surface_faces(&lit.point, light.direction))
            continue;
        rsv_ray ray =
            rsv_punctual_ray(&light, rsv_lifted_origin(&lit.point, lit.origin, light.direction));
        float cos = v3_dot(lit.point.normal, light.direction);
        rsv_rgb entered = rgb_mul(light.irradiance, entry(&lit, light.distance, cos));
        sum = rgb_mad(sum, cos * rsv_tracer_passed(s->tracer, &ray), entered);
    }
    return sum;
}
