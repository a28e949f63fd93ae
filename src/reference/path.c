/// One path of the reference: how it turns, and where it ends.
#include "path_sources.h"

/// Pairs of numbers from the quasi-random sequence: three for each of the first four surfaces.
#define QUASI_RANDOM_PAIRS 12
#define FIRST_ROULETTE_BOUNCE 5
/// Ends even lossless paths. Above albedo^2 of anything that occurs, or the variance were infinite.
#define LARGEST_SURVIVAL 0.999f
/// In fog, paths of many thousand events bring light: a lossless slab of optical thickness t wants more than 1 - 3 /
/// t^2.
#define LARGEST_SURVIVAL_IN_FOG 0.9999f

void rsv_path_next_pair(rsv_path_numbers *numbers, float *x, float *y)
{
    if (numbers->pairs_taken < QUASI_RANDOM_PAIRS) {
        uint32_t seed = rsv_hash2(numbers->id.stream, ++numbers->pairs_taken);
        rsv_sobol_2d(numbers->id.sample, seed, x, y);
    } else {
        *x = rsv_random_float(&numbers->random);
        *y = rsv_random_float(&numbers->random);
    }
}

static void start_path(rsv_light_path *path, const rsv_path_tracer *tracer,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light)
{
    *light = (rsv_path_light){ 0 };
    path->tracer = tracer;
    path->numbers = (rsv_path_numbers){ id, 0, rsv_random_from(id.sample, id.stream, 0) };
    path->throughput = rgb_gray(1);
    path->medium = *medium;
    path->start_ior = rsv_medium_ior(medium, tracer->bsdf);
    path->settled = false;
    path->channel = RSV_CHANNEL_OPEN;
    path->bounces = path->diffuse_events = 0;
    path->pdf_solid_angle = path->passed = 0;
    path->light = light;
    path->sight = (rsv_vec3){ 0, 0, 0 };
    path->vertex.is_last = false;
}

/// Infers the medium of the ray from the surface of a body, and applies its absorption.
static void cross_medium(rsv_light_path *path, const rsv_path_surface *s)
{
    float distance = v3_length(v3_sub(s->point, path->departure));
    const rsv_bsdf *bsdf = path->tracer->bsdf;
    if (s->bsdf->solid) {
        if (!s->front) rsv_medium_arrive_inside(&path->medium, s->material);
        if (!path->settled) path->start_ior = rsv_medium_ior(&path->medium, bsdf);
        path->settled = true;
    }
    path->throughput =
        rgb_mul(path->throughput, rsv_medium_transmittance(&path->medium, bsdf, distance));
}

/// The surface where light entered that leaves at `exit`, seen as from straight above.
static void enter_surface(const rsv_path_tracer *tracer, const rsv_path_surface *exit,
    const rsv_body_point *entry, rsv_path_surface *result)
{
    rsv_vec3 above = exit->front ? entry->geometric : v3_neg(entry->geometric);
    rsv_ray down = { v3_add(entry->point, above), v3_neg(above), 1 };
    rsv_hit hit = { entry->triangle, 1, entry->u, entry->v };
    rsv_path_surface_meet(tracer, &down, &hit, result);
    result->entry = true;
}

/// Gathers the sources where light entered and turns into a direction in which it did.
static bool go_where_light_entered(rsv_light_path *path, const rsv_path_surface *entry)
{
    float u_select, u_unused, light_u1, light_u2, u1, u2;
    rsv_path_next_pair(&path->numbers, &u_select, &u_unused);
    rsv_path_next_pair(&path->numbers, &light_u1, &light_u2);
    rsv_path_next_pair(&path->numbers, &u1, &u2);
    rsv_path_gather_sources(path, entry, u_select, light_u1, light_u2);

    rsv_vec3 local = rsv_square_to_cosine_hemisphere(u1, u2), t, b;
    v3_frame(entry->normal, &t, &b);
    rsv_vec3 wi =
        v3_normalize(v3_mad(v3_mad(v3_scale(entry->normal, local.z), local.x, t), local.y, b));
    if (!rsv_path_surface_leads(entry, false, wi)) return false;
    path->throughput = rgb_mul(path->throughput, rsv_bsdf_entry(entry->bsdf, local.z));
    path->pdf_solid_angle = local.z / RSV_PI;
    path->passed = 0;
    path->below = path->vertex.is_last = false;
    path->diffuse_events++;
    path->departure = entry->point;
    path->ray = (rsv_ray){ rsv_path_surface_departure(entry, false, wi), wi, INFINITY };
    return true;
}

/// Leaves diffusely from below a translucent surface: from where light entered, gathers the sources there and
/// turns into a direction in which light entered.
static bool scatter_below(rsv_light_path *path, const rsv_path_surface *exit, rsv_rgb leaving)
{
    rsv_body_point out = { exit->point, exit->geometric_normal, exit->triangle, exit->u, exit->v };
    rsv_body_point in;
    rsv_rgb share;
    if (!rsv_bodies_sample_entry(path->tracer->bodies, &out, &path->numbers.random, &in, &share))
        return false;
    path->throughput = rgb_mul(path->throughput, rgb_mul(leaving, share));
    path->throughput = rgb_mul(path->throughput, exit->bsdf->base_color);
    if (rgb_is_black(path->throughput)) return false;
    rsv_path_surface entry;
    enter_surface(path->tracer, exit, &in, &entry);
    return go_where_light_entered(path, &entry);
}

/// An event at a surface whose diffuse lobe has a normal of its own.
static rsv_bsdf_sample sample_turned(const rsv_path_surface *s, const float u[3])
{
    rsv_bsdf_event event = rsv_bsdf_draw_event(s->bsdf, s->wo, s->normal, s->front, u);
    rsv_bsdf_sample sample = { event.lobe, event.direction, event.weight, event.pdf_solid_angle };
    if (event.lobe == RSV_LOBE_DIFFUSE) {
        rsv_vec3 local = rsv_square_to_cosine_hemisphere(u[1], u[2]);
        rsv_rgb entered = rgb_mul(s->bsdf->base_color, rsv_bsdf_entry(s->bsdf, local.z));
        sample.direction = rsv_from_frame(local, s->receiving);
        sample.weight = rgb_mul(sample.weight, entered);
        sample.pdf_solid_angle = local.z;
    }
    if (sample.pdf_solid_angle > 0)
        sample.pdf_solid_angle =
            rsv_path_surface_respond(s, sample.direction, RSV_LOBES_ALL).pdf_solid_angle;
    return sample;
}

/// An event; the diffuse lobe of a translucent surface has no direction of its own.
static rsv_bsdf_sample sample_direction(const rsv_path_surface *s, const float u[3])
{
    if (!s->translucent && rsv_path_surface_turned(s)) return sample_turned(s, u);
    if (!s->translucent) return rsv_bsdf_sample_direction(s->bsdf, s->wo, s->normal, s->front, u);
    rsv_bsdf_event event = rsv_bsdf_draw_event(s->bsdf, s->wo, s->normal, s->front, u);
    rsv_bsdf_sample sample = { event.lobe, event.direction, event.weight, event.pdf_solid_angle };
    // sampling for the rough lobes only: weighted by the same density, the two add up to one
    if (sample.pdf_solid_angle > 0)
        sample.pdf_solid_angle =
            rsv_path_surface_respond(s, event.direction, RSV_LOBES_ROUGH).pdf_solid_angle;
    return sample;
}

/// Has the surface of a body that disperses light scatter one channel: the path's, or any.
static void disperse(rsv_light_path *path, rsv_path_surface *s)
{
    s->channel = path->channel;
    if (!rsv_bsdf_disperses(s->bsdf)) return;
    if (s->channel == RSV_CHANNEL_OPEN)
        s->channel = (rsv_channel)(RSV_CHANNEL_RED +
                                   (int)f_min(3 * rsv_random_float(&path->numbers.random), 2));
    s->own = rsv_bsdf_in_channel(s->bsdf, s->channel);
    s->bsdf = &s->own;
}

/// Light that has gone through such a surface is of its channel.
static void take_channel(rsv_light_path *path, const rsv_path_surface *s)
{
    if (path->channel != RSV_CHANNEL_OPEN || !rsv_bsdf_disperses(s->bsdf)) return;
    path->channel = s->channel;
    path->throughput = rgb_mul(path->throughput, rsv_channel_weight(s->channel));
}

/// Gathers the sources and turns the path into a new direction; false where it ends.
static bool scatter(rsv_light_path *path, const rsv_path_surface *s)
{
    float u_select, light_u1, light_u2, u[3];
    rsv_path_next_pair(&path->numbers, &u_select, &u[0]);
    rsv_path_next_pair(&path->numbers, &light_u1, &light_u2);
    rsv_path_next_pair(&path->numbers, &u[1], &u[2]);
    rsv_path_gather_sources(path, s, u_select, light_u1, light_u2);
    rsv_bsdf_sample sample = sample_direction(s, u);
    if (sample.lobe == RSV_LOBE_NONE) return false;
    if (s->translucent && sample.lobe == RSV_LOBE_DIFFUSE)
        return scatter_below(path, s, sample.weight);
    bool transmitted = sample.lobe == RSV_LOBE_TRANSMIT;
    if (transmitted) take_channel(path, s);
    if (!rsv_path_surface_leads(s, transmitted, sample.direction)) return false;
    path->throughput = rgb_mul(path->throughput, sample.weight);
    if (rgb_is_black(path->throughput)) return false;
    path->pdf_solid_angle = path->aimed[transmitted] ? sample.pdf_solid_angle : 0;
    path->passed = 0;
    path->below = transmitted;
    path->vertex.is_last = false;
    path->medium = rsv_path_medium_beside(path, s, transmitted);
    path->diffuse_events += sample.lobe == RSV_LOBE_DIFFUSE;
    path->departure = s->point;
    path->ray = (rsv_ray){ rsv_path_surface_departure(s, transmitted, sample.direction),
        sample.direction, INFINITY };
    return true;
}

static bool survives_roulette(rsv_light_path *path)
{
    if (++path->bounces < FIRST_ROULETTE_BOUNCE) return true;
    float largest = path->vertex.is_last ? LARGEST_SURVIVAL_IN_FOG : LARGEST_SURVIVAL;
    float survival = f_min(rgb_max(path->throughput), largest);
    if (rsv_random_float(&path->numbers.random) >= survival) return false;
    path->throughput = rgb_scale(path->throughput, 1 / survival);
    return true;
}

/// Goes straight on where the surface does not cover. Next-event estimation sees lamps past it, too.
static bool passes(rsv_light_path *path, const rsv_path_surface *s, float distance)
{
    if (s->bsdf->opacity >= 1 || rsv_random_float(&path->numbers.random) < s->bsdf->opacity)
        return false;
    path->passed += distance;
    path->departure = s->point;
    path->ray.origin = rsv_path_surface_departure(s, true, path->ray.direction);
    return true;
}

/// Whether the ray is in air up to its hit, if it has one.
static bool is_in_air(const rsv_light_path *path, const rsv_path_surface *met)
{
    bool inside = met && met->bsdf->solid && !met->front;
    return path->medium.depth == 0 && !inside;
}

static void follow(rsv_light_path *path)
{
    rsv_hit hit = { .t = INFINITY };
    for (;;) {
        rsv_path_surface s;
        bool met = rsv_tracer_closest(path->tracer->tracer, &path->ray, &hit);
        if (met) rsv_path_surface_meet(path->tracer, &path->ray, &hit, &s);
        if (path->tracer->fog && is_in_air(path, met ? &s : NULL)) {
            rsv_fog_outcome outcome = rsv_path_cross_fog(path, met ? hit.t : INFINITY);
            if (outcome == RSV_FOG_SCATTERED && survives_roulette(path)) continue;
            if (outcome != RSV_FOG_PASSED) return;
        }
        if (!met) {
            rsv_path_add_environment(path);
            return;
        }
        cross_medium(path, &s);
        rsv_path_add_emission(path, &s, hit.t);
        if (passes(path, &s, hit.t)) {
            if (!survives_roulette(path)) return;
            continue;
        }
        disperse(path, &s);
        if (!scatter(path, &s) || !survives_roulette(path)) return;
    }
}

void rsv_trace_camera_path(const rsv_path_tracer *tracer, const rsv_ray *ray,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light)
{
    rsv_light_path path;
    start_path(&path, tracer, medium, id, light);
    path.ray = *ray;
    path.departure = ray->origin;
    path.sight = ray->direction;
    follow(&path);
}

void rsv_trace_receiver_path(const rsv_path_tracer *tracer, rsv_vec3 point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light)
{
    static const rsv_bsdf white = {
        .base_color = { 1, 1, 1 }, .ior = 1, .diffuse = 1, .opacity = 1, .lambert = true
    };
    rsv_vec3 origin = rsv_tracer_receiver_origin(tracer->tracer, point, normal);
    float lift = v3_length(v3_sub(origin, point));
    rsv_path_surface receiver = { .bsdf = &white,
        .point = point,
        .wo = normal,
        .geometric_normal = normal,
        .normal = normal,
        .receiving = normal,
        .horizon = normal,
        .extent = 0x1p20f * lift, // from which rsv_offset_origin computes the lift
        .triangle = RSV_NONE,
        .front = true };
    rsv_light_path path;
    start_path(&path, tracer, medium, id, light);
    if (scatter(&path, &receiver)) follow(&path);
}

void rsv_trace_entering_path(const rsv_path_tracer *tracer, rsv_body_point point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light)
{
    rsv_ray down = { v3_add(point.point, point.geometric), v3_neg(point.geometric), 1 };
    rsv_hit hit = { point.triangle, 1, point.u, point.v };
    rsv_path_surface entry;
    rsv_light_path path;
    rsv_path_surface_meet(tracer, &down, &hit, &entry);
    entry.entry = true;
    entry.normal = entry.receiving = normal;
    start_path(&path, tracer, medium, id, light);
    if (go_where_light_entered(&path, &entry)) follow(&path);
}

rsv_rgb rsv_path_light_total(const rsv_path_light *light)
{
    rsv_rgb total = light->order[0];
    for (int i = 1; i < RSV_PATH_ORDERS; i++)
        total = rgb_add(total, light->order[i]);
    return total;
}
