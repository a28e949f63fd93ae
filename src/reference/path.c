/// One path of the reference: next-event estimation and BSDF sampling, combined by the power
/// heuristic with exponent 2 (Veach and Guibas 1995).
#include "reference_internal.h"

/// Pairs of numbers from the quasi-random sequence: three for each of the first four surfaces.
#define QUASI_RANDOM_PAIRS 12
#define FIRST_ROULETTE_BOUNCE 5
/// Ends even lossless paths. Above albedo^2 of anything that occurs, or the variance were infinite.
#define LARGEST_SURVIVAL 0.999f

typedef struct number_source {
    rsv_path_id id;
    uint32_t pairs_taken;
    rsv_random random;
} number_source;

typedef struct light_path {
    const rsv_path_tracer *tracer;
    number_source numbers;
    rsv_ray ray;
    rsv_vec3 departure; ///< point of the surface that the ray left
    rsv_rgb throughput; ///< of basic radiance (surface/medium.h)
    rsv_medium medium;  ///< that the ray runs through
    float start_ior;    ///< of the medium that the path started in
    bool settled;       ///< has met the surface of a body, and so knows where it started
    uint32_t bounces, diffuse_events;
    /// With which the last surface chose the ray; 0 = next-event estimation could not have found
    /// what the ray finds.
    float pdf_solid_angle;
    /// The lights as the last surface sees them that next-event estimation knows of: above it and
    /// below, and on which of these sides the ray left.
    rsv_local_lights local[2];
    bool aimed[2]; ///< whether they are set
    bool below;
    rsv_path_light *light;
} light_path;

/// Where a ray arrived. Normals are unit and on the side the ray came from.
typedef struct surface {
    const rsv_bsdf *bsdf;
    rsv_bsdf own; ///< what `bsdf` points to where the material varies
    rsv_vec3 point, wo;
    rsv_vec3 geometric_normal;
    rsv_vec3 normal; ///< for scattering
    float extent;    ///< for rsv_offset_origin
    uint32_t triangle;
    float u, v;
    bool front;
    /// Of a translucent body: light that leaves here diffusely entered elsewhere, or has just been followed to
    /// where it entered, and its direction is all that is left to choose.
    bool translucent, entry;
} surface;

static void next_pair(number_source *numbers, float *x, float *y)
{
    if (numbers->pairs_taken < QUASI_RANDOM_PAIRS) {
        uint32_t seed = rsv_hash2(numbers->id.stream, ++numbers->pairs_taken);
        rsv_sobol_2d(numbers->id.sample, seed, x, y);
    } else {
        *x = rsv_random_float(&numbers->random);
        *y = rsv_random_float(&numbers->random);
    }
}

static void start_path(light_path *path, const rsv_path_tracer *tracer, const rsv_medium *medium,
    rsv_path_id id, rsv_path_light *light)
{
    *light = (rsv_path_light){ 0 };
    path->tracer = tracer;
    path->numbers = (number_source){ id, 0, rsv_random_from(id.sample, id.stream, 0) };
    path->throughput = rgb_gray(1);
    path->medium = *medium;
    path->start_ior = rsv_medium_ior(medium, tracer->bsdf);
    path->settled = false;
    path->bounces = path->diffuse_events = 0;
    path->pdf_solid_angle = 0;
    path->light = light;
}

static void add_light(light_path *path, uint32_t diffuse_events, rsv_rgb radiance)
{
    rsv_rgb *order = path->light->order;
    order += diffuse_events < RSV_PATH_ORDERS ? diffuse_events : RSV_PATH_ORDERS - 1;
    *order = rgb_add(*order, rgb_mul(path->throughput, radiance));
}

/// Textures are looked up as they are: what a pixel averages is the business of its samples.
static void meet_surface(
    const rsv_path_tracer *tracer, const rsv_ray *ray, const rsv_hit *hit, surface *s)
{
    const rsv_scene_view *scene = tracer->scene;
    rsv_surface_point point =
        rsv_surface_point_seen(scene, hit->triangle, hit->u, hit->v, false, 0);
    s->bsdf = rsv_surface_bsdf(scene, tracer->bsdf, hit->triangle, hit->u, hit->v, 0, &s->own);
    s->point = point.position;
    s->wo = v3_neg(v3_normalize(ray->direction));
    s->extent = point.extent;
    s->triangle = hit->triangle;
    s->u = hit->u;
    s->v = hit->v;
    s->translucent = tracer->bodies->triangle_body[hit->triangle] != RSV_NONE;
    s->entry = false;
    s->front = v3_dot(point.geometric, s->wo) > 0;
    s->geometric_normal = s->front ? point.geometric : v3_neg(point.geometric);
    s->normal = s->front ? point.normal : v3_neg(point.normal);
    if (!s->bsdf->lambert)
        s->normal = rsv_bsdf_specular_normal(s->normal, s->geometric_normal, s->wo);
}

static rsv_vec3 leaving_point(const surface *s, bool transmitted)
{
    rsv_vec3 side = transmitted ? v3_neg(s->geometric_normal) : s->geometric_normal;
    return rsv_offset_origin(s->point, side, s->extent);
}

static uint32_t material_of(const light_path *path, const surface *s)
{
    return path->tracer->scene->triangle_material[s->triangle];
}

/// Learns from the surface of a body what the ray has run through, and lets that absorb.
static void cross_medium(light_path *path, const surface *s)
{
    float distance = v3_length(v3_sub(s->point, path->departure));
    const rsv_bsdf *bsdf = path->tracer->bsdf;
    if (s->bsdf->solid) {
        if (!s->front) rsv_medium_arrive_inside(&path->medium, material_of(path, s));
        if (!path->settled) path->start_ior = rsv_medium_ior(&path->medium, bsdf);
        path->settled = true;
    }
    path->throughput =
        rgb_mul(path->throughput, rsv_medium_transmittance(&path->medium, bsdf, distance));
}

/// The medium on either side of a surface that the path has come to.
static rsv_medium medium_beside(const light_path *path, const surface *s, bool below)
{
    rsv_medium medium = path->medium;
    if (below && s->bsdf->solid) rsv_medium_cross(&medium, material_of(path, s), !s->front);
    return medium;
}

/// Radiance at the path's start per radiance of a source in `medium`, at that distance from the path's
/// end, but for the throughput.
static rsv_rgb from_source(const light_path *path, const rsv_medium *medium, float distance)
{
    const rsv_bsdf *bsdf = path->tracer->bsdf;
    float ratio = path->start_ior / rsv_medium_ior(medium, bsdf);
    return rgb_scale(rsv_medium_transmittance(medium, bsdf, distance), ratio * ratio);
}

/// Weight of a sample drawn with density `own` that another technique draws with density `other`.
static float power_heuristic(float own, float other)
{
    float ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

static void add_emission(light_path *path, const surface *s, float distance)
{
    const rsv_lights *lights = path->tracer->lights;
    if (s->bsdf->unlit && path->diffuse_events == 0 && (s->front || s->bsdf->double_sided))
        add_light(path, 0, rgb_mul(from_source(path, &path->medium, 0), s->bsdf->emission));
    uint32_t index = rsv_emitter_at(lights, s->triangle, s->u, s->v);
    if (index == RSV_NONE) return;
    const rsv_emitter *emitter = &lights->emitter[index];
    if (!s->front && !emitter->double_sided) return;

    float weight = 1;
    if (path->pdf_solid_angle > 0 && !lights->group[emitter->group].gathered) {
        float pdf_light =
            rsv_local_lights_pdf(&path->local[path->below], index, path->ray.direction, distance);
        weight = power_heuristic(path->pdf_solid_angle, pdf_light);
    }
    rsv_rgb arriving = rgb_mul(from_source(path, &path->medium, 0), s->bsdf->emission);
    add_light(path, path->diffuse_events, rgb_scale(arriving, weight));
}

/// The surroundings, seen by a ray that left the scene.
static void add_environment(light_path *path)
{
    const rsv_environment_light *environment = path->tracer->lights->environment;
    if (!environment) return;
    rsv_vec3 direction = v3_normalize(path->ray.direction);
    rsv_rgb radiance = rsv_sky_radiance(&environment->whole, direction);
    float weight = 1;
    if (path->pdf_solid_angle > 0)
        weight = power_heuristic(
            path->pdf_solid_angle, rsv_local_lights_sky_pdf(&path->local[path->below], direction));
    rsv_rgb arriving = rgb_mul(from_source(path, &path->medium, 0), radiance);
    add_light(path, path->diffuse_events, rgb_scale(arriving, weight));
}

/// What of the light from wi enters a translucent body, over pi: as if it left a white one right here.
static rsv_bsdf_value respond_to_entering(const surface *s, rsv_vec3 wi)
{
    float cos = f_max(v3_dot(s->normal, wi), 0);
    return (rsv_bsdf_value){ rgb_scale(rsv_bsdf_entry(s->bsdf, cos), cos / RSV_PI), cos / RSV_PI };
}

/// Response of the lobes in `lobes`; nothing where the normals disagree on wi's side.
static rsv_bsdf_value respond(const surface *s, rsv_vec3 wi, rsv_lobe_set lobes)
{
    rsv_bsdf_value nothing = { rgb_gray(0), 0 };
    if (v3_dot(s->geometric_normal, wi) * v3_dot(s->normal, wi) <= 0) return nothing;
    if (s->entry) return lobes == RSV_LOBES_DIFFUSE ? respond_to_entering(s, wi) : nothing;
    if (s->translucent && lobes == RSV_LOBES_DIFFUSE) return nothing;
    return rsv_bsdf_evaluate(s->bsdf, wi, s->wo, s->normal, s->front, lobes);
}

static bool sees_light(
    const rsv_path_tracer *tracer, const surface *s, const rsv_light_sample *sample, bool below)
{
    rsv_ray ray = rsv_shadow_ray(tracer->lights, sample, s->point, leaving_point(s, below));
    return !rsv_tracer_occluded(tracer->tracer, &ray);
}

/// Adds light that arrives at the surface and scatters: diffusely, which makes it one order more, or in
/// a rough lobe.
static void add_scattered(light_path *path, rsv_rgb arriving, rsv_rgb diffuse, rsv_rgb rough)
{
    add_light(path, path->diffuse_events + 1, rgb_mul(diffuse, arriving));
    if (!rgb_is_black(rough)) add_light(path, path->diffuse_events, rgb_mul(rough, arriving));
}

static void add_emitter_sample(
    light_path *path, const surface *s, bool below, float u_select, float u1, float u2)
{
    rsv_light_sample sample;
    if (!rsv_local_lights_sample(&path->local[below], u_select, u1, u2, &sample)) return;
    rsv_bsdf_value diffuse = respond(s, sample.direction, RSV_LOBES_DIFFUSE);
    rsv_bsdf_value rough = respond(s, sample.direction, RSV_LOBES_ROUGH);
    float pdf_bsdf = diffuse.pdf_solid_angle + rough.pdf_solid_angle;
    if (pdf_bsdf == 0 || !sees_light(path->tracer, s, &sample, below)) return;
    float weight = power_heuristic(sample.pdf_solid_angle, pdf_bsdf) / sample.pdf_solid_angle;
    rsv_medium medium = medium_beside(path, s, below);
    rsv_rgb arriving = rgb_mul(from_source(path, &medium, sample.distance), sample.radiance);
    add_scattered(path, rgb_scale(arriving, weight), diffuse.response, rough.response);
}

/// Share of light that passes a surface without turning: past what it does not cover, and through thin sheets.
static rsv_rgb straight_through(const surface *s)
{
    rsv_rgb uncovered = rgb_gray(1 - s->bsdf->opacity);
    if (s->bsdf->transmission == 0 || s->bsdf->solid) return uncovered;
    rsv_rgb sheet = rsv_bsdf_evaluate_branches(s->bsdf, s->wo, s->normal, s->front).transmit;
    return rgb_mad(uncovered, s->bsdf->opacity, sheet);
}

/// Share of light that reaches the ray's origin from its end without turning.
static rsv_rgb straight_transmittance(const rsv_path_tracer *tracer, rsv_ray ray)
{
    rsv_rgb passed = rgb_gray(1);
    rsv_hit hit;
    while (!rgb_is_black(passed) && rsv_tracer_closest(tracer->tracer, &ray, &hit)) {
        surface s;
        meet_surface(tracer, &ray, &hit, &s);
        passed = rgb_mul(passed, straight_through(&s));
        ray.origin = leaving_point(&s, true);
        ray.t_max -= hit.t;
    }
    return passed;
}

static void add_punctual_light(light_path *path, const surface *s, const rsv_punctual_sample *light)
{
    rsv_bsdf_value diffuse = respond(s, light->direction, RSV_LOBES_DIFFUSE);
    rsv_bsdf_value rough = respond(s, light->direction, RSV_LOBES_ROUGH);
    if (diffuse.pdf_solid_angle + rough.pdf_solid_angle == 0) return;
    bool below = v3_dot(s->geometric_normal, light->direction) < 0;
    rsv_ray ray = { leaving_point(s, below), light->direction, light->distance };
    rsv_medium medium = medium_beside(path, s, below);
    rsv_rgb arriving = rgb_mul(light->irradiance, straight_transmittance(path->tracer, ray));
    arriving = rgb_mul(arriving, from_source(path, &medium, light->distance));
    add_scattered(path, arriving, diffuse.response, rough.response);
}

/// @param both_sides light from below counts, too
static void add_punctual_lights(light_path *path, const surface *s, bool both_sides)
{
    const rsv_lights *lights = path->tracer->lights;
    rsv_vec3 normal = both_sides ? v3(0, 0, 0) : s->normal;
    float u = lights->punctual_tree ? rsv_random_float(&path->numbers.random) : 0;
    for (uint32_t k = 0; k < rsv_punctual_count(lights); k++) {
        rsv_punctual_sample light;
        if (rsv_punctual_at(lights, s->point, normal, k, u, &light))
            add_punctual_light(path, s, &light);
    }
}

/// Whether lights are found by aiming at them, above the surface and below.
static void choose_sides(const surface *s, bool aim[2])
{
    aim[0] = s->entry, aim[1] = false;
    if (s->entry) return;
    rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(s->bsdf, s->wo, s->normal, s->front);
    rsv_rgb diffuse = rgb_mul(branches.diffuse, s->bsdf->exitance_albedo);
    aim[0] = branches.rough || (!s->translucent && !rgb_is_black(diffuse));
    aim[1] = branches.rough && (s->bsdf->transmission > 0 || s->bsdf->passed > 0);
}

static void gather_sources(light_path *path, const surface *s, float u_select, float u1, float u2)
{
    choose_sides(s, path->aimed);
    for (int below = 0; below < 2; below++) {
        if (!path->aimed[below]) continue;
        rsv_vec3 normal = below ? v3_neg(s->normal) : s->normal;
        rsv_lights_at(path->tracer->lights, s->point, normal, &path->local[below]);
        add_emitter_sample(path, s, below, u_select, u1, u2);
    }
    if (path->aimed[0] || path->aimed[1]) add_punctual_lights(path, s, path->aimed[1]);
}

/// The surface where light entered that leaves at `exit`, seen as from straight above.
static void enter_surface(const rsv_path_tracer *tracer, const surface *exit,
    const rsv_body_point *entry, surface *result)
{
    rsv_vec3 above = exit->front ? entry->geometric : v3_neg(entry->geometric);
    rsv_ray down = { v3_add(entry->point, above), v3_neg(above), 1 };
    rsv_hit hit = { entry->triangle, 1, entry->u, entry->v };
    meet_surface(tracer, &down, &hit, result);
    result->entry = true;
}

/// Leaves diffusely from below a translucent surface: from where light entered, gathers the sources there and
/// turns into a direction in which light entered.
static bool scatter_below(light_path *path, const surface *exit, rsv_rgb leaving)
{
    float u_select, u_unused, light_u1, light_u2, u1, u2;
    rsv_body_point out = { exit->point, exit->geometric_normal, exit->triangle, exit->u, exit->v };
    rsv_body_point in;
    rsv_rgb share;
    if (!rsv_bodies_sample_entry(path->tracer->bodies, &out, &path->numbers.random, &in, &share))
        return false;
    path->throughput = rgb_mul(path->throughput, rgb_mul(leaving, share));
    path->throughput = rgb_mul(path->throughput, exit->bsdf->exitance_albedo);
    if (rgb_is_black(path->throughput)) return false;
    surface entry;
    enter_surface(path->tracer, exit, &in, &entry);
    next_pair(&path->numbers, &u_select, &u_unused);
    next_pair(&path->numbers, &light_u1, &light_u2);
    next_pair(&path->numbers, &u1, &u2);
    gather_sources(path, &entry, u_select, light_u1, light_u2);

    rsv_vec3 local = rsv_square_to_cosine_hemisphere(u1, u2), t, b;
    v3_frame(entry.normal, &t, &b);
    rsv_vec3 wi =
        v3_normalize(v3_mad(v3_mad(v3_scale(entry.normal, local.z), local.x, t), local.y, b));
    if (v3_dot(entry.geometric_normal, wi) <= 0) return false;
    path->throughput = rgb_mul(path->throughput, rsv_bsdf_entry(entry.bsdf, local.z));
    path->pdf_solid_angle = local.z / RSV_PI;
    path->below = false;
    path->diffuse_events++;
    path->departure = entry.point;
    path->ray = (rsv_ray){ leaving_point(&entry, false), wi, INFINITY };
    return true;
}

/// An event at a translucent surface; its diffuse lobe has no direction of its own.
static rsv_bsdf_sample sample_direction(const surface *s, float u_lobe, float u1, float u2)
{
    if (!s->translucent)
        return rsv_bsdf_sample_direction(s->bsdf, s->wo, s->normal, s->front, u_lobe, u1, u2);
    rsv_bsdf_event event = rsv_bsdf_draw_event(s->bsdf, s->wo, s->normal, s->front, u_lobe, u1, u2);
    rsv_bsdf_sample sample = { event.lobe, event.direction, event.weight, event.pdf_solid_angle };
    // lights are aimed at for the rough lobes alone: weighed by the same density, the two add up to one
    if (sample.pdf_solid_angle > 0)
        sample.pdf_solid_angle = respond(s, event.direction, RSV_LOBES_ROUGH).pdf_solid_angle;
    return sample;
}

/// Gathers the sources and turns the path into a new direction; false where it ends.
static bool scatter(light_path *path, const surface *s)
{
    float u_select, u_lobe, light_u1, light_u2, u1, u2;
    next_pair(&path->numbers, &u_select, &u_lobe);
    next_pair(&path->numbers, &light_u1, &light_u2);
    next_pair(&path->numbers, &u1, &u2);
    gather_sources(path, s, u_select, light_u1, light_u2);
    rsv_bsdf_sample sample = sample_direction(s, u_lobe, u1, u2);
    if (sample.lobe == RSV_LOBE_NONE) return false;
    if (s->translucent && sample.lobe == RSV_LOBE_DIFFUSE)
        return scatter_below(path, s, sample.weight);
    bool transmitted = sample.lobe == RSV_LOBE_TRANSMIT;
    float rise = v3_dot(s->geometric_normal, sample.direction);
    if (transmitted ? rise >= 0 : rise <= 0) return false;
    path->throughput = rgb_mul(path->throughput, sample.weight);
    if (rgb_is_black(path->throughput)) return false;
    path->pdf_solid_angle = path->aimed[transmitted] ? sample.pdf_solid_angle : 0;
    path->below = transmitted;
    path->medium = medium_beside(path, s, transmitted);
    path->diffuse_events += sample.lobe == RSV_LOBE_DIFFUSE;
    path->departure = s->point;
    path->ray = (rsv_ray){ leaving_point(s, transmitted), sample.direction, INFINITY };
    return true;
}

static bool survives_roulette(light_path *path)
{
    if (++path->bounces < FIRST_ROULETTE_BOUNCE) return true;
    float survival = f_min(rgb_max(path->throughput), LARGEST_SURVIVAL);
    if (rsv_random_float(&path->numbers.random) >= survival) return false;
    path->throughput = rgb_scale(path->throughput, 1 / survival);
    return true;
}

/// Goes straight on where the surface does not cover. Next-event estimation sees no lamp through it.
static bool passes(light_path *path, const surface *s)
{
    if (s->bsdf->opacity >= 1 || rsv_random_float(&path->numbers.random) < s->bsdf->opacity)
        return false;
    path->pdf_solid_angle = 0;
    path->departure = s->point;
    path->ray.origin = leaving_point(s, true);
    return true;
}

static void follow(light_path *path)
{
    rsv_hit hit;
    for (;;) {
        if (!rsv_tracer_closest(path->tracer->tracer, &path->ray, &hit)) {
            add_environment(path);
            return;
        }
        surface s;
        meet_surface(path->tracer, &path->ray, &hit, &s);
        cross_medium(path, &s);
        if (passes(path, &s)) {
            if (!survives_roulette(path)) return;
            continue;
        }
        add_emission(path, &s, hit.t);
        if (!scatter(path, &s) || !survives_roulette(path)) return;
    }
}

void rsv_trace_camera_path(const rsv_path_tracer *tracer, const rsv_ray *ray,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light)
{
    light_path path;
    start_path(&path, tracer, medium, id, light);
    path.ray = *ray;
    path.departure = ray->origin;
    follow(&path);
}

void rsv_trace_receiver_path(const rsv_path_tracer *tracer, rsv_vec3 point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light)
{
    static const rsv_bsdf white = { .base_color = { 1, 1, 1 },
        .exitance_albedo = { 1, 1, 1 },
        .ior = 1,
        .diffuse = 1,
        .opacity = 1,
        .lambert = true };
    rsv_vec3 origin = rsv_tracer_receiver_origin(tracer->tracer, point, normal);
    float lift = v3_length(v3_sub(origin, point));
    surface receiver = { .bsdf = &white,
        .point = point,
        .wo = normal,
        .geometric_normal = normal,
        .normal = normal,
        .extent = 0x1p20f * lift, // what rsv_offset_origin makes the lift of
        .triangle = RSV_NONE,
        .front = true };
    light_path path;
    start_path(&path, tracer, medium, id, light);
    if (scatter(&path, &receiver)) follow(&path);
}

rsv_rgb rsv_path_light_total(const rsv_path_light *light)
{
    rsv_rgb total = light->order[0];
    for (int i = 1; i < RSV_PATH_ORDERS; i++)
        total = rgb_add(total, light->order[i]);
    return total;
}
