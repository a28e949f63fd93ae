#include "path_sources.h"

#include "../sources/punctual_light.h"

/// Weight of a sample drawn with density `own` that another technique draws with density `other`.
static float power_heuristic(float own, float other)
{
    float ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

static void add_throughput(
    rsv_light_path *path, uint32_t diffuse_events, rsv_rgb throughput, rsv_rgb radiance)
{
    rsv_rgb *order = path->light->order;
    order += diffuse_events < RSV_PATH_ORDERS ? diffuse_events : RSV_PATH_ORDERS - 1;
    *order = rgb_add(*order, rgb_mul(throughput, radiance));
}

static void add_light(rsv_light_path *path, uint32_t diffuse_events, rsv_rgb radiance)
{
    add_throughput(path, diffuse_events, path->throughput, radiance);
}

/// Radiance at the path's start per radiance of a source in `medium`, at that distance from the path's end, without the
/// throughput.
static rsv_rgb from_source(const rsv_light_path *path, const rsv_medium *medium, float distance)
{
    const rsv_bsdf *bsdf = path->tracer->bsdf;
    float ratio = path->start_ior / rsv_medium_ior(medium, bsdf);
    return rgb_scale(rsv_medium_transmittance(medium, bsdf, distance), ratio * ratio);
}

/// The same of a source seen from `point` along `direction`.
static rsv_rgb from_source_at(rsv_light_path *path, const rsv_medium *medium, rsv_vec3 point,
    rsv_vec3 direction, float distance)
{
    rsv_rgb arriving = from_source(path, medium, distance);
    if (!path->tracer->fog || medium->depth) return arriving;
    return rgb_mul(arriving, rsv_path_fog_transmittance(path, point, direction, distance));
}

void rsv_path_add_light(
    rsv_light_path *path, uint32_t diffuse_events, rsv_rgb throughput, rsv_rgb radiance)
{
    rsv_rgb arriving = rgb_mul(from_source(path, &path->medium, 0), radiance);
    add_throughput(path, diffuse_events, throughput, arriving);
}

rsv_medium rsv_path_medium_beside(const rsv_light_path *path, const rsv_path_surface *s, bool below)
{
    rsv_medium medium = path->medium;
    if (below && s->bsdf->solid) rsv_medium_cross(&medium, s->material, !s->front);
    return medium;
}

/// Whether it still runs as the camera's ray did.
static bool is_sight(const rsv_light_path *path)
{
    rsv_vec3 a = path->ray.direction, b = path->sight;
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

void rsv_path_add_emission(rsv_light_path *path, const rsv_path_surface *s, float distance)
{
    const rsv_lights *lights = path->tracer->lights;
    if (s->bsdf->unlit && path->diffuse_events == 0 && (s->front || s->bsdf->double_sided))
        add_light(path, 0,
            rgb_scale(
                rgb_mul(from_source(path, &path->medium, 0), s->bsdf->emission), s->bsdf->opacity));
    uint32_t index = rsv_emitter_at(lights, s->triangle, s->u, s->v);
    if (index == RSV_NONE) return;
    const rsv_emitter *emitter = &lights->emitter[index];
    if (!s->front && !emitter->double_sided) return;

    float weight = 1;
    if (path->vertex.is_last)
        weight = rsv_fog_emission_weight(path, index, s->point);
    else if (path->pdf_solid_angle > 0 && !lights->group[emitter->group].gathered) {
        float pdf_light = rsv_local_lights_pdf(
            &path->local[path->below], index, path->ray.direction, path->passed + distance);
        weight = power_heuristic(path->pdf_solid_angle, pdf_light);
    }
    if (is_sight(path)) weight *= path->tracer->scene->material[s->material].camera_emission;
    rsv_rgb arriving = rgb_mul(from_source(path, &path->medium, 0), s->bsdf->emission);
    add_light(path, path->diffuse_events, rgb_scale(arriving, weight * s->bsdf->opacity));
}

void rsv_path_add_environment(rsv_light_path *path)
{
    const rsv_environment_light *environment = path->tracer->lights->environment;
    if (!environment) return;
    rsv_vec3 direction = v3_normalize(path->ray.direction);
    rsv_rgb radiance = rsv_sky_radiance(&environment->whole, direction);
    float weight = 1;
    if (path->vertex.is_last)
        weight = rsv_fog_sky_weight(path, direction);
    else if (path->pdf_solid_angle > 0)
        weight = power_heuristic(
            path->pdf_solid_angle, rsv_local_lights_sky_pdf(&path->local[path->below], direction));
    rsv_rgb arriving = rgb_mul(from_source(path, &path->medium, 0), radiance);
    add_light(path, path->diffuse_events, rgb_scale(arriving, weight));
}

/// Part of a sample's light that arrives past the coverage of surfaces. Paths that hit the source find the light that
/// sheets transmit.
static rsv_rgb seen_of_light(const rsv_path_tracer *tracer, const rsv_path_surface *s,
    const rsv_light_sample *sample, bool below)
{
    rsv_ray ray = rsv_shadow_ray(
        tracer->lights, sample, s->point, rsv_path_surface_departure(s, below, sample->direction));
    if (!rsv_tracer_occluded(tracer->tracer, &ray)) return rgb_gray(1);
    return tracer->blended ? rsv_straight_transmittance(tracer, ray, false) : rgb_gray(0);
}

/// Adds light that arrives at the surface and scatters: diffusely, which makes it one order more, or in
/// a rough lobe.
static void add_scattered(rsv_light_path *path, rsv_rgb arriving, rsv_rgb diffuse, rsv_rgb rough)
{
    add_light(path, path->diffuse_events + 1, rgb_mul(diffuse, arriving));
    if (!rgb_is_black(rough)) add_light(path, path->diffuse_events, rgb_mul(rough, arriving));
}

static void add_emitter_sample(
    rsv_light_path *path, const rsv_path_surface *s, bool below, float u_select, float u1, float u2)
{
    rsv_light_sample sample;
    if (!rsv_local_lights_sample(&path->local[below], u_select, u1, u2, &sample)) return;
    rsv_bsdf_value diffuse = rsv_path_surface_respond(s, sample.direction, RSV_LOBES_DIFFUSE);
    rsv_bsdf_value rough = rsv_path_surface_respond(s, sample.direction, RSV_LOBES_ROUGH);
    float pdf_bsdf = diffuse.pdf_solid_angle + rough.pdf_solid_angle;
    if (pdf_bsdf == 0) return;
    rsv_rgb seen = seen_of_light(path->tracer, s, &sample, below);
    if (rgb_is_black(seen)) return;
    float weight = power_heuristic(sample.pdf_solid_angle, pdf_bsdf) / sample.pdf_solid_angle;
    rsv_medium medium = rsv_path_medium_beside(path, s, below);
    rsv_rgb arriving =
        rgb_mul(from_source_at(path, &medium, s->point, sample.direction, sample.distance),
            sample.radiance);
    arriving = rgb_mul(arriving, seen);
    add_scattered(path, rgb_scale(arriving, weight), diffuse.response, rough.response);
}

static void add_punctual_light(
    rsv_light_path *path, const rsv_path_surface *s, const rsv_punctual_sample *light)
{
    rsv_bsdf_value diffuse = rsv_path_surface_respond(s, light->direction, RSV_LOBES_DIFFUSE);
    rsv_bsdf_value rough = rsv_path_surface_respond(s, light->direction, RSV_LOBES_ROUGH);
    if (diffuse.pdf_solid_angle + rough.pdf_solid_angle == 0) return;
    bool below = rsv_path_surface_is_below(s, light->direction);
    rsv_ray ray = { rsv_path_surface_departure(s, below, light->direction), light->direction,
        RSV_PUNCTUAL_WAY * light->distance };
    rsv_medium medium = rsv_path_medium_beside(path, s, below);
    rsv_rgb arriving =
        rgb_mul(light->irradiance, rsv_straight_transmittance(path->tracer, ray, true));
    arriving = rgb_mul(
        arriving, from_source_at(path, &medium, s->point, light->direction, light->distance));
    add_scattered(path, arriving, diffuse.response, rough.response);
}

/// @param both_sides light from below counts, too
static void add_punctual_lights(rsv_light_path *path, const rsv_path_surface *s, bool both_sides)
{
    const rsv_lights *lights = path->tracer->lights;
    rsv_vec3 normal = both_sides || rsv_path_surface_turned(s) ? v3(0, 0, 0) : s->normal;
    float u =
        lights->punctual_tree || lights->extended ? rsv_random_float(&path->numbers.random) : 0;
    for (uint32_t k = 0; k < rsv_punctual_count(lights); k++) {
        rsv_punctual_sample light;
        if (rsv_punctual_at(lights, s->point, normal, k, u, &light))
            add_punctual_light(path, s, &light);
    }
}

/// Chains of mirrors and glass that every surface of a path may try.
#define TRIED_CHAINS 256

/// Adds light of punctual lights through mirrors and glass. If there are many, a few surfaces are connected on behalf
/// of all.
static void add_connected_lights(rsv_light_path *path, const rsv_path_surface *s)
{
    const rsv_connections *connections = path->tracer->connections;
    rsv_connection found[RSV_MOST_CONNECTIONS];
    float chance = TRIED_CHAINS / (float)rsv_connections_chain_count(connections);
    if (chance < 1 && rsv_random_float(&path->numbers.random) >= chance) return;
    size_t count = rsv_connect(connections, s->point, found);
    for (size_t k = 0; k < count; k++) {
        if (found[k].straight) continue; // shadow rays pass thin sheets (add_punctual_light)
        rsv_vec3 towards = found[k].towards;
        rsv_bsdf_value diffuse = rsv_path_surface_respond(s, towards, RSV_LOBES_DIFFUSE);
        rsv_bsdf_value rough = rsv_path_surface_respond(s, towards, RSV_LOBES_ROUGH);
        if (diffuse.pdf_solid_angle + rough.pdf_solid_angle == 0) continue;
        bool below = rsv_path_surface_is_below(s, towards);
        rsv_medium medium = rsv_path_medium_beside(path, s, below);
        rsv_rgb arriving = rgb_scale(found[k].irradiance, 1 / f_min(chance, 1));
        arriving = rgb_mul(arriving, from_source(path, &medium, 0));
        add_scattered(path, arriving, diffuse.response, rough.response);
    }
}

/// Whether lights are found by aiming at them, above the surface and below.
static void choose_sides(const rsv_path_surface *s, bool aim[2])
{
    aim[0] = s->entry, aim[1] = false;
    if (s->entry) return;
    rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(s->bsdf, s->wo, s->normal, s->front);
    rsv_rgb diffuse = rgb_mul(branches.diffuse, s->bsdf->base_color);
    aim[0] = branches.rough || (!s->translucent && !rgb_is_black(diffuse));
    aim[1] = branches.rough && (s->bsdf->transmission > 0 || s->bsdf->passed > 0);
}

void rsv_path_gather_sources(
    rsv_light_path *path, const rsv_path_surface *s, float u_select, float u1, float u2)
{
    choose_sides(s, path->aimed);
    for (int below = 0; below < 2; below++) {
        if (!path->aimed[below]) continue;
        rsv_vec3 normal = below ? v3_neg(s->normal) : s->normal;
        rsv_lights_about(path->tracer->lights, s->point, normal, &path->local[below]);
        add_emitter_sample(path, s, below, u_select, u1, u2);
    }
    if (!path->aimed[0] && !path->aimed[1]) return;
    add_punctual_lights(path, s, path->aimed[1]);
    // a virtual receiver is connected once for all paths (probe.c)
    if (path->tracer->connections && s->triangle != RSV_NONE) add_connected_lights(path, s);
}
