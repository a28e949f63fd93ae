#include "fog_light.h"

#include "../direct/voxel_direct.h"
#include "../media/phase.h"
#include "../sources/air_light.h"
#include "../specular/fog_flight.h"
#include "lit_gather.h"
#include "pixel_direct.h"

static rsv_air_setting setting_of(const rsv_light_view *s)
{
    return (rsv_air_setting){ s->fog_lights, s->tracer, s->scene.view->fog };
}

/// Of fluence: radiance that is scattered to all sides.
static rsv_rgb scatter(const rsv_light_view *s, rsv_rgb fluence)
{
    return rgb_scale(rgb_mul(fluence, s->scene.view->fog->albedo), 1 / (4 * RSV_PI));
}

// ---- at a place -----------------------------------------------------------------------------------

/// Fluence of sampled sources, weighed by the phase function as the receiver says.
static rsv_rgb sample_fluence(
    const rsv_light_view *s, const rsv_air_receiver *receiver, rsv_random *random)
{
    const rsv_air_setting setting = setting_of(s);
    uint64_t rays = 0;
    float u[5];
    for (int k = 0; k < 5; k++)
        u[k] = rsv_random_float(random);
    return rsv_air_light(&setting, receiver, u, &rays);
}

rsv_rgb rsv_fog_fluence_sample(const rsv_light_view *s, rsv_vec3 place, rsv_random *random)
{
    const rsv_voxel_air air = { s->elements->voxels, setting_of(s) };
    float u[4];
    uint64_t rays = 0;
    if (!air.voxels) return rgb_gray(0);
    uint32_t voxel = rsv_voxels_find(air.voxels, s->tracer, place);
    const rsv_air_receiver receiver = rsv_voxel_receiver(air.voxels, voxel, place);
    for (int k = 0; k < 4; k++)
        u[k] = rsv_random_float(random);
    rsv_rgb near = rsv_voxel_near_light(&air, voxel, &receiver, u, &rays);
    return rgb_add(near, sample_fluence(s, &receiver, random));
}

rsv_rgb rsv_fog_scattered_sample(const rsv_light_view *s, rsv_vec3 place, rsv_random *random)
{
    return scatter(s, rsv_fog_fluence_sample(s, place, random));
}

rsv_rgb rsv_fog_stored_radiance(const rsv_light_view *s, rsv_vec3 place, bool skip_sampled)
{
    rsv_rgb glow = rsv_fog_glow(s->scene.view->fog);
    uint32_t node = rsv_elements_find_voxel(s->elements, s->tracer, place);
    if (node == RSV_NONE) return glow;
    return rgb_add(glow, rgb_add(rsv_light_view_scattered(s, node, 0, skip_sampled),
                             rsv_light_view_scattered(s, node, RSV_NONE, false)));
}

rsv_rgb rsv_fog_radiance_at(const rsv_light_view *s, rsv_vec3 place, rsv_random *random)
{
    return rgb_add(
        rsv_fog_stored_radiance(s, place, true), rsv_fog_scattered_sample(s, place, random));
}

// ---- along a segment, as stored -------------------------------------------------------------------

typedef struct march {
    const rsv_light_view *light;
    const rsv_fog *fog;
    const rsv_fog_segment *segment;
    rsv_fog_run run;
    rsv_rgb share; ///< of channels in the throughput
    float even;    ///< fraction of the phase function that is isotropic, which voxels scatter
    rsv_fog_sink sink;
    void *user;
} march;

static void add(const march *m, uint32_t order, rsv_rgb weight, rsv_rgb radiance)
{
    m->sink(m->user, order, rgb_mul(m->segment->throughput, rgb_mul(weight, radiance)));
}

/// A voxel has uniform radiance: it scatters this times the light that the piece removes.
static void visit_voxel(void *user, uint32_t voxel, double begin, double end)
{
    const march *m = user;
    const rsv_light_view *s = m->light;
    rsv_rgb near = rsv_fog_transmittance(m->fog, rsv_fog_column(&m->run, begin));
    rsv_rgb far = rsv_fog_transmittance(m->fog, rsv_fog_column(&m->run, end));
    rsv_rgb taken = rgb_scale(rgb_sub(near, far), m->even);
    uint32_t node = (uint32_t)rsv_elements_surface_nodes(s->elements) + voxel;
    add(m, 1, taken, rsv_light_view_scattered(s, node, 0, m->segment->final));
    if (m->segment->gather) return;
    if (!m->segment->by_order) {
        add(m, 2, taken, rsv_light_view_scattered(s, node, RSV_NONE, false));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++)
        add(m, order + 1, taken, rsv_light_view_scattered(s, node, order, false));
}

// ---- along a segment, sampled ---------------------------------------------------------------------

/// Per metre, of a distance drawn as light is taken along the segment, in the mixture over channels.
static double distance_pdf(const march *m, double s)
{
    double column = rsv_fog_column(&m->run, s), sum = 0;
    for (int c = 0; c < 3; c++) {
        double sigma = (double)(&m->fog->extinction.r)[c];
        if (sigma > 0)
            sum += (double)(&m->share.r)[c] * sigma * exp(-sigma * column) /
                   -expm1(-sigma * m->run.column);
    }
    return sum * rsv_fog_density(&m->run, s);
}

static double draw_distance(const march *m, float u_channel, float u)
{
    int c = u_channel < m->share.r ? 0 : u_channel < m->share.r + m->share.g ? 1 : 2;
    double sigma = (double)(&m->fog->extinction.r)[c];
    double column = -log1p((double)u * expm1(-sigma * m->run.column)) / sigma;
    return rsv_fog_find(&m->run, fmin(column, m->run.column));
}

/// Shares of channels that the fog takes light from.
static bool set_share(march *m)
{
    const rsv_fog *fog = m->fog;
    rsv_rgb w = m->segment->throughput;
    w = rgb(fog->extinction.r > 0 ? w.r : 0, fog->extinction.g > 0 ? w.g : 0,
        fog->extinction.b > 0 ? w.b : 0);
    float sum = w.r + w.g + w.b;
    m->share = rgb_scale(w, sum > 0 ? 1 / sum : 0);
    return sum > 0;
}

static rsv_vec3 middle_of(const rsv_fog_lights *l, uint32_t entry)
{
    const rsv_punctual_light *light = rsv_fog_light_punctual(l, entry);
    if (light) return light->position;
    const rsv_emitter *emitter = &l->lights->emitter[l->lights->sampled[entry]];
    return v3_scale(
        v3_add(v3_add(emitter->corner[0], emitter->corner[1]), emitter->corner[2]), 1.0f / 3);
}

static rsv_equiangular angle_at(const march *m, uint32_t entry)
{
    const rsv_ray *ray = &m->segment->ray;
    return rsv_equiangular_of(ray->origin, ray->direction, middle_of(m->light->fog_lights, entry),
        m->run.begin, m->run.end);
}

/// A light with a place, and a distance at which it is scattered. Both are drawn in two ways: the distance as the fog
/// takes light, and the light as it is seen from there; or the light by its power, and the distance by the angle at it.
typedef struct scattering {
    uint32_t entry;
    double distance;
    rsv_fog_choice choice; ///< at the distance
} scattering;

static rsv_vec3 place_at(const march *m, double distance)
{
    return v3_mad(m->segment->ray.origin, (float)distance, m->segment->ray.direction);
}

/// Radiance that is scattered at a distance, per mean radiance around that point. @param density per metre of the
/// distance
static rsv_rgb scattered_at(const march *m, double distance, double density)
{
    rsv_rgb passed = rsv_fog_transmittance(m->fog, rsv_fog_column(&m->run, distance));
    double scale = rsv_fog_density(&m->run, distance) / density;
    if (!(scale < INFINITY)) return rgb_gray(0);
    rsv_rgb taken = rgb_scale(rgb_mul(passed, m->fog->extinction), (float)scale);
    return rgb_mul(taken, m->fog->albedo);
}

/// Adds light of one source that is scattered at a point. @param density per metre, and of everything else that was
/// drawn
static void add_scattered(const march *m, double distance, rsv_rgb fluence, double density)
{
    if (rgb_is_black(fluence)) return;
    rsv_rgb weight = scattered_at(m, distance, density);
    add(m, 1, weight, rgb_scale(fluence, 1 / (4 * RSV_PI)));
}

/// Adds a sample, weighed by the balance heuristic.
static void add_light(const march *m, const scattering *s, const float u[2])
{
    const rsv_air_setting setting = setting_of(m->light);
    const rsv_air_receiver receiver = { .point = place_at(m, s->distance),
        .forward = m->segment->ray.direction };
    uint64_t rays = 0;
    rsv_equiangular e = angle_at(m, s->entry);
    double by_angle = e.angle > 0 ? (double)setting.lights->probability[s->entry] *
                                        rsv_equiangular_pdf(&e, s->distance)
                                  : 0;
    double density = by_angle + distance_pdf(m, s->distance) *
                                    (double)rsv_fog_choice_probability(&s->choice, s->entry);
    if (!(density > 0)) return;
    add_scattered(
        m, s->distance, rsv_air_light_of_entry(&setting, &receiver, s->entry, u, &rays), density);
}

static void add_placed_lights(const march *m, double distance)
{
    const rsv_fog_lights *l = m->light->fog_lights;
    const float *u = m->segment->u;
    float probability;
    scattering s = { .distance = distance };
    if (!l->count) return;
    rsv_fog_lights_at(l, place_at(m, s.distance), &s.choice);
    s.entry = rsv_fog_choice_draw(&s.choice, u[2], &probability);
    if (s.entry != RSV_NONE) add_light(m, &s, u + 4);
    s.entry = rsv_alias_table_draw(l->table, l->count, (double)u[2]);
    rsv_equiangular e = angle_at(m, s.entry);
    if (!(e.angle > 0)) return;
    s.distance = fmin(fmax(rsv_equiangular_sample(&e, u[3]), m->run.begin), m->run.end);
    rsv_fog_lights_at(l, place_at(m, s.distance), &s.choice);
    add_light(m, &s, u + 4);
}

// ---- along a segment, turned ------------------------------------------------------------------------

/// Radiance along a ray that fog has turned, order by order as it counts there, straight from sampled sources left out.
static void add_turned(const march *m, rsv_rgb weight, const rsv_ray *ray, rsv_random *random)
{
    const rsv_light_view *s = m->light;
    const rsv_lit_setting setting = { &s->scene, s->lights, false };
    rsv_gather gather = rsv_gather_lit_ray(&setting, NULL, ray, random);
    const rsv_specular_path *end = &gather.path;
    add(m, 2, weight, gather.emission);
    weight = rgb_mul(weight, end->weight);
    if (gather.end == RSV_SPECULAR_SCATTERED) {
        uint32_t node = rsv_elements_find_voxel(s->elements, s->tracer, gather.place);
        add(m, 1, weight, rsv_fog_glow(m->fog));
        add(m, 2, weight, rsv_fog_scattered_sample(s, gather.place, random));
        if (node == RSV_NONE) return;
        add(m, 2, weight, rsv_light_view_scattered(s, node, 0, true));
        add(m, 3, weight, rsv_light_view_scattered(s, node, RSV_NONE, true));
    }
    uint32_t face = gather.end == RSV_SPECULAR_DIFFUSE
                        ? s->elements->face_of[end->back][end->triangle]
                        : RSV_NONE;
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    rsv_rgb albedo = rsv_specular_bsdf(&s->scene, end, &storage)->base_color;
    weight = rgb_scale(rgb_mul(weight, albedo), 1 / RSV_PI);
    add(m, 2, weight,
        rgb_add(rsv_light_view_direct(s, face, end->u, end->v, true),
            rsv_sampled_irradiance(s, end, random)));
    add(m, 3, weight, rsv_elements_interpolate(s->elements, s->indirect, face, end->u, end->v));
}

/// Light that the directional part of the phase function turns into the path at a distance. In mode operator, it
/// includes light straight from sources, which mode final already has. @param density per metre of the distance
static void add_uneven(const march *m, double distance, double density, rsv_random *random)
{
    rsv_rgb weight = rgb_scale(scattered_at(m, distance, density), 1 - m->even);
    rsv_vec3 place = place_at(m, distance), forward = m->segment->ray.direction;
    const rsv_air_receiver receiver = { .point = place, .forward = forward, .uneven = true };
    if (!m->segment->final)
        add(m, 1, rgb_scale(weight, 1 / (4 * RSV_PI)), sample_fluence(m->light, &receiver, random));
    rsv_ray ray = { place, rsv_fog_draw_turn(m->fog->anisotropy, forward, random), INFINITY };
    add_turned(m, weight, &ray, random);
}

/// Indirect light that the isotropic part of the phase function turns into the path at a distance.
/// @param density per metre of the distance
static void gather_even(const march *m, double distance, double density)
{
    rsv_random random = rsv_random_from(m->segment->seed, 2, 0xf09u);
    rsv_rgb weight = rgb_scale(scattered_at(m, distance, density), m->even);
    m->segment->gather(
        m->user, place_at(m, distance), rgb_mul(m->segment->throughput, weight), &random);
}

static void add_sampled(march *m)
{
    const rsv_air_setting setting = setting_of(m->light);
    const float *u = m->segment->u;
    uint64_t rays = 0;
    if (!set_share(m) || rgb_is_black(m->fog->albedo)) return;
    double distance = draw_distance(m, u[0], u[1]), density = distance_pdf(m, distance);
    if (!(density > 0)) return;
    if (m->fog->anisotropy != 0) {
        rsv_random random = rsv_random_from(m->segment->seed, 1, 0xf09u);
        add_uneven(m, distance, density, &random);
    }
    if (m->segment->gather) gather_even(m, distance, density);
    if (!m->segment->final) return;
    const rsv_air_receiver receiver = { .point = place_at(m, distance),
        .forward = m->segment->ray.direction };
    add_placed_lights(m, distance);
    add_scattered(m, distance, rsv_air_light_from_afar(&setting, &receiver, u + 6, &rays), density);
}

rsv_rgb rsv_fog_march(
    const rsv_light_view *s, const rsv_fog_segment *segment, rsv_fog_sink sink, void *user)
{
    const rsv_ray *ray = &segment->ray;
    march m = {
        .light = s, .fog = s->scene.view->fog, .segment = segment, .sink = sink, .user = user
    };
    m.even = (float)rsv_phase_even_share(m.fog->anisotropy);
    m.run = rsv_fog_run_of(m.fog, ray->origin, ray->direction, ray->t_max);
    if (!(m.run.column > 0)) return rgb_gray(1);
    rsv_rgb passed = rsv_fog_transmittance(m.fog, m.run.column);
    add(&m, 0, rgb_sub(rgb_gray(1), passed), rsv_fog_glow(m.fog));
    const double range[2] = { m.run.begin, m.run.end };
    if (s->elements->voxels)
        rsv_voxels_walk(s->elements->voxels, s->tracer, ray, range, visit_voxel, &m);
    if (segment->final || segment->gather || m.fog->anisotropy != 0) add_sampled(&m);
    return passed;
}
