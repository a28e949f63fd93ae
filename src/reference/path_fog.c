#include "../media/phase.h"
#include "../sources/local_lights.h"
#include "../sources/punctual_light.h"
#include "path_sources.h"
#include "path_volume.h"

/// Weight of a sample drawn with density `own`, which two other techniques draw with `a` and `b`.
static float power_heuristic(double own, double a, double b)
{
    double p = a / own, q = b / own;
    return (float)(1 / (1 + p * p + q * q));
}

rsv_rgb rsv_path_fog_transmittance(
    rsv_light_path *path, rsv_vec3 point, rsv_vec3 direction, float distance)
{
    const rsv_fog *fog = path->tracer->fog;
    const rsv_ray ray = { point, direction, distance };
    if (!fog) return rgb_gray(1);
    if (fog->volume) return rsv_path_volume_transmittance(fog, &path->numbers.random, &ray);
    return rsv_fog_transmittance(fog, rsv_fog_run_of(fog, point, direction, distance).column);
}

static float sum_of(rsv_rgb c) { return c.r + c.g + c.b; }

/// a_c sigma_c exp(-sigma_c column)
static rsv_rgb scattered_share(const rsv_fog *fog, double column)
{
    return rgb_mul(rgb_mul(fog->albedo, fog->extinction), rsv_fog_transmittance(fog, column));
}

/// Density per metre of being scattered at s.
static double scatter_pdf(const rsv_fog *fog, const rsv_fog_vertex *v, double s)
{
    rsv_rgb share = rgb_mul(v->share, scattered_share(fog, rsv_fog_column(&v->run, s)));
    return rsv_fog_density(&v->run, s) * (double)sum_of(share);
}

static void set_place(rsv_fog_vertex *v, double s)
{
    v->distance = s;
    v->point = v3_mad(v->origin, (float)s, v->forward);
}

// ---- sources ------------------------------------------------------------------------------------

/// A place on a source, and how light gets from there to where it is scattered.
typedef struct arrival {
    rsv_light_sample
        sample; ///< of an emitter or the sky: `radiance` and density are those per solid angle
    const rsv_punctual_light *punctual; ///< NULL = that; else `radiance` is an irradiance
} arrival;

/// Adds light of a source scattered at the vertex: `weight` over all densities but that of the direction.
static void add_scattered(rsv_light_path *path, const rsv_fog_vertex *v, rsv_rgb throughput,
    const arrival *from, double weight)
{
    const rsv_path_tracer *tracer = path->tracer;
    const rsv_light_sample *sample = &from->sample;
    rsv_rgb seen = rgb_gray(1);
    if (!(weight > 0)) return;
    rsv_ray ray = rsv_shadow_ray(tracer->lights, sample, v->point, v->point);
    if (from->punctual) ray = rsv_ray_to(v->point, sample->direction, sample->distance);
    if (from->punctual)
        seen = rsv_straight_transmittance(tracer, ray, true);
    else if (rsv_tracer_occluded(tracer->tracer, &ray))
        seen = tracer->blended ? rsv_straight_transmittance(tracer, ray, false) : rgb_gray(0);
    if (rgb_is_black(seen)) return;
    float phase = rsv_phase(tracer->fog->anisotropy, v3_dot(v->forward, sample->direction));
    rsv_rgb arriving = rgb_mul(rgb_scale(sample->radiance, (float)(weight * (double)phase)), seen);
    arriving = rgb_mul(arriving,
        rsv_path_fog_transmittance(path, v->point, sample->direction, sample->distance));
    rsv_path_add_light(path, path->diffuse_events + 1, throughput, arriving);
}

/// Sets the light from a punctual light that arrives at the vertex. False if there is none.
static bool set_punctual(
    const rsv_path_tracer *tracer, rsv_vec3 place, const rsv_fog_vertex *v, arrival *from)
{
    rsv_punctual_sample found;
    if (!rsv_punctual_arriving(tracer->lights->scene, from->punctual, place, v->point, &found))
        return false;
    from->sample = (rsv_light_sample){ .direction = found.direction,
        .distance = found.distance,
        .radiance = found.irradiance,
        .emitter = RSV_NONE };
    return true;
}

/// Density of the third technique over that of the path's own distance: per solid angle at the vertex, or for a
/// punctual light without unit.
static double segment_pdf(
    const rsv_fog_lights *lights, const rsv_fog_vertex *v, uint32_t entry, rsv_vec3 place)
{
    if (v->by_collision) return 0;
    rsv_equiangular e = rsv_equiangular_of(v->origin, v->forward, place, v->run.begin, v->run.end);
    double pdf = (double)lights->probability[entry] * rsv_equiangular_pdf(&e, v->distance);
    if (entry < lights->emitters) {
        const rsv_emitter *emitter = &lights->lights->emitter[lights->lights->sampled[entry]];
        rsv_vec3 way = v3_sub(place, v->point);
        double square = (double)v3_dot(way, way);
        double cos = fabs((double)v3_dot(emitter->normal, way)) / sqrt(square);
        pdf *= square / fmax((double)emitter->area * cos, 1e-300);
    }
    return pdf / v->pdf;
}

/// The second technique for lights with a place.
static void gather_placed(
    rsv_light_path *path, const rsv_fog_vertex *v, float u_select, float u1, float u2)
{
    const rsv_fog_lights *lights = &path->tracer->fog_lights;
    float probability = 0;
    uint32_t entry = rsv_fog_choice_draw(&v->choice, u_select, &probability);
    if (entry == RSV_NONE) return;
    arrival from = { .punctual = rsv_fog_light_punctual(lights, entry) };
    rsv_light_sample *sample = &from.sample;
    double weight;
    if (from.punctual) {
        rsv_vec3 place = rsv_punctual_place(from.punctual, (const float[3]){ u1, u2, u_select });
        if (!set_punctual(path->tracer, place, v, &from)) return;
        weight = power_heuristic((double)probability, segment_pdf(lights, v, entry, place), 0) /
                 (double)probability;
    } else {
        if (!rsv_fog_sample_emitter(&v->choice, entry, u1, u2, sample)) return;
        rsv_vec3 place = v3_mad(v->point, sample->distance, sample->direction);
        double own = (double)probability * (double)sample->pdf_solid_angle;
        float phase =
            rsv_phase(path->tracer->fog->anisotropy, v3_dot(v->forward, sample->direction));
        weight = power_heuristic(own, (double)phase, segment_pdf(lights, v, entry, place)) / own;
    }
    add_scattered(path, v, path->throughput, &from, weight);
}

/// Lights without a place: nothing but the path's own place can find them.
static void gather_distant(rsv_light_path *path, const rsv_fog_vertex *v, float u1, float u2)
{
    const rsv_lights *lights = path->tracer->lights;
    for (size_t k = 0; k < lights->distant_count; k++) {
        arrival from = { .punctual = &lights->scene->light[lights->punctual[k]] };
        if (set_punctual(path->tracer, from.punctual->position, v, &from))
            add_scattered(path, v, path->throughput, &from, 1);
    }
    const rsv_environment_light *sky = lights->environment;
    if (!sky || !(sky->sampler.flux > 0)) return;
    arrival from = { .sample = { .distance = INFINITY, .emitter = RSV_NONE } };
    double own = (double)rsv_sky_sample(&sky->sampler, u1, u2, &from.sample.direction);
    if (!(own > 0)) return;
    from.sample.radiance = rsv_sky_radiance(&sky->whole, from.sample.direction);
    float phase =
        rsv_phase(path->tracer->fog->anisotropy, v3_dot(v->forward, from.sample.direction));
    add_scattered(path, v, path->throughput, &from, power_heuristic(own, (double)phase, 0) / own);
}

// ---- the third technique ------------------------------------------------------------------------

/// A place on the light, as it is drawn for a whole segment. @param sample place on an emitter
/// @param u3 of a light that has a depth
static rsv_vec3 draw_place(
    const rsv_fog_lights *l, uint32_t entry, float u1, float u2, float u3, rsv_light_sample *sample)
{
    const rsv_punctual_light *punctual = rsv_fog_light_punctual(l, entry);
    sample->emitter = RSV_NONE;
    if (punctual) return rsv_punctual_place(punctual, (const float[3]){ u1, u2, u3 });
    sample->emitter = l->lights->sampled[entry];
    const rsv_emitter *emitter = &l->lights->emitter[sample->emitter];
    rsv_square_to_triangle(u1, u2, &sample->u, &sample->v);
    return v3_barycentric(
        emitter->corner[0], emitter->corner[1], emitter->corner[2], sample->u, sample->v);
}

/// Sets the light from a light's sample that arrives at the vertex. False if there is none.
static bool set_arrival(
    const rsv_path_tracer *tracer, rsv_vec3 place, const rsv_fog_vertex *v, arrival *from)
{
    const rsv_fog_lights *l = &tracer->fog_lights;
    rsv_light_sample *sample = &from->sample;
    if (from->punctual) return set_punctual(tracer, place, v, from);
    rsv_vec3 way = v3_sub(place, v->point);
    sample->distance = v3_length(way);
    if (!(sample->distance > 0)) return false;
    sample->direction = v3_scale(way, 1 / sample->distance);
    const rsv_emitter *emitter = &l->lights->emitter[sample->emitter];
    bool back = v3_dot(emitter->normal, way) > 0;
    sample->radiance = rsv_emitter_radiance(l->lights, sample->emitter, back, sample->u, sample->v);
    return rsv_emitter_faces(emitter, v->point);
}

/// Weight of the third technique / its density, without that of the vertex's distance.
static double segment_weight(const rsv_path_tracer *tracer, rsv_fog_vertex *v, uint32_t entry,
    rsv_vec3 place, const arrival *from)
{
    const rsv_fog_lights *l = &tracer->fog_lights;
    const rsv_light_sample *sample = &from->sample;
    double own = segment_pdf(l, v, entry, place), drawn, turned = 0;
    if (!(own > 0)) return 0;
    rsv_fog_lights_at(l, v->point, &v->choice);
    if (from->punctual) {
        drawn = (double)rsv_fog_choice_probability(&v->choice, entry);
    } else {
        drawn = (double)rsv_fog_emitter_pdf(
            &v->choice, sample->emitter, sample->direction, sample->distance);
        turned = (double)rsv_phase(tracer->fog->anisotropy, v3_dot(v->forward, sample->direction));
    }
    return (double)power_heuristic(own, drawn, turned) / own;
}

/// Light of one source that is scattered anywhere on the segment.
static void gather_along(rsv_light_path *path, rsv_fog_vertex *v)
{
    const rsv_path_tracer *tracer = path->tracer;
    const rsv_fog_lights *l = &tracer->fog_lights;
    float u_select, u_distance, u1, u2;
    if (!l->count) return;
    rsv_path_next_pair(&path->numbers, &u_select, &u_distance);
    rsv_path_next_pair(&path->numbers, &u1, &u2);
    uint32_t entry = rsv_alias_table_draw(l->table, l->count, (double)u_select);
    arrival from = { .punctual = rsv_fog_light_punctual(l, entry) };
    rsv_vec3 place = draw_place(l, entry, u1, u2, u_select, &from.sample);
    rsv_equiangular e = rsv_equiangular_of(v->origin, v->forward, place, v->run.begin, v->run.end);
    if (!(e.angle > 0)) return;
    double s = fmin(fmax(rsv_equiangular_sample(&e, u_distance), v->run.begin), v->run.end);
    set_place(v, s);
    v->pdf = scatter_pdf(tracer->fog, v, s);
    if (!(v->pdf > 0) || !(s < INFINITY) || !set_arrival(tracer, place, v, &from)) return;
    // the density of a place that paths hardly reach may be too small to divide by in float
    double weight =
        segment_weight(tracer, v, entry, place, &from) * (rsv_fog_density(&v->run, s) / v->pdf);
    rsv_rgb share = scattered_share(tracer->fog, rsv_fog_column(&v->run, s));
    add_scattered(path, v, rgb_mul(path->throughput, share), &from, weight);
}

// ---- emission that a path comes to ----------------------------------------------------------------

float rsv_fog_emission_weight(const rsv_light_path *path, uint32_t emitter, rsv_vec3 place)
{
    const rsv_fog_lights *l = &path->tracer->fog_lights;
    const rsv_fog_vertex *v = &path->vertex;
    uint32_t entry = l->entry[emitter];
    if (entry == RSV_NONE) return 1;
    float distance = v3_length(v3_sub(place, v->point));
    double drawn = (double)rsv_fog_emitter_pdf(&v->choice, emitter, path->ray.direction, distance);
    return power_heuristic((double)path->pdf_solid_angle, drawn, segment_pdf(l, v, entry, place));
}

float rsv_fog_sky_weight(const rsv_light_path *path, rsv_vec3 direction)
{
    double drawn = (double)rsv_sky_pdf(&path->tracer->lights->environment->sampler, direction);
    return power_heuristic((double)path->pdf_solid_angle, drawn, 0);
}

// ---- flights ------------------------------------------------------------------------------------

/// Emission per extinction, times 1 - transmittance: the emission of the whole segment.
static void add_fog_emission(rsv_light_path *path, const rsv_fog_run *run)
{
    const rsv_fog *fog = path->tracer->fog;
    if (rgb_is_black(fog->emission)) return;
    rsv_rgb passed = rsv_fog_transmittance(fog, run->column), sigma = fog->extinction;
    rsv_rgb emitted = rgb(sigma.r > 0 ? fog->emission.r * (1 - passed.r) / sigma.r : 0,
        sigma.g > 0 ? fog->emission.g * (1 - passed.g) / sigma.g : 0,
        sigma.b > 0 ? fog->emission.b * (1 - passed.b) / sigma.b : 0);
    rsv_path_add_light(path, path->diffuse_events, path->throughput, emitted);
}

/// Column at which the path is scattered; INFINITY if it goes on.
static double draw_flight(const rsv_fog *fog, rsv_rgb share, float u_channel, float u)
{
    int c = u_channel < share.r ? 0 : u_channel < share.r + share.g ? 1 : 2;
    float albedo = (&fog->albedo.r)[c], extinction = (&fog->extinction.r)[c];
    return u < albedo ? rsv_fog_free_column(extinction, u / albedo) : INFINITY;
}

/// Weights a path that passed the fog by the probabilities of the other outcomes.
static rsv_fog_outcome pass(rsv_light_path *path, const rsv_fog_vertex *v)
{
    rsv_rgb passed = rsv_fog_transmittance(path->tracer->fog, v->run.column);
    rsv_rgb taken = rgb_mul(path->tracer->fog->albedo, rgb_sub(rgb_gray(1), passed));
    float probability = 1 - sum_of(rgb_mul(v->share, taken));
    if (!(probability > 0)) return RSV_FOG_ABSORBED;
    path->throughput = rgb_scale(rgb_mul(path->throughput, passed), 1 / probability);
    return rgb_is_black(path->throughput) ? RSV_FOG_ABSORBED : RSV_FOG_PASSED;
}

rsv_fog_outcome rsv_path_turn_in_fog(rsv_light_path *path)
{
    rsv_fog_vertex *v = &path->vertex;
    const rsv_path_tracer *tracer = path->tracer;
    float u_select, u_unused, light1, light2, sky1, sky2, u1, u2;
    rsv_path_next_pair(&path->numbers, &u_select, &u_unused);
    rsv_path_next_pair(&path->numbers, &light1, &light2);
    rsv_path_next_pair(&path->numbers, &sky1, &sky2);
    rsv_path_next_pair(&path->numbers, &u1, &u2);
    rsv_fog_lights_at(&tracer->fog_lights, v->point, &v->choice);
    gather_placed(path, v, u_select, light1, light2);
    gather_distant(path, v, sky1, sky2);
    rsv_vec3 direction = rsv_phase_sample(tracer->fog->anisotropy, v->forward, u1, u2);
    path->pdf_solid_angle = rsv_phase(tracer->fog->anisotropy, v3_dot(v->forward, direction));
    path->passed = 0;
    path->diffuse_events++;
    path->departure = v->point;
    path->ray = (rsv_ray){ v->point, direction, INFINITY };
    v->is_last = true;
    return RSV_FOG_SCATTERED;
}

rsv_fog_outcome rsv_path_cross_fog(rsv_light_path *path, float length)
{
    const rsv_fog *fog = path->tracer->fog;
    if (fog->volume) return rsv_path_cross_volume(path, length);
    rsv_fog_vertex along = { .origin = path->ray.origin,
        .forward = v3_normalize(path->ray.direction) };
    along.run = rsv_fog_run_of(fog, along.origin, along.forward, length);
    if (!(along.run.column > 0)) return RSV_FOG_PASSED;
    along.share = rgb_scale(path->throughput, 1 / sum_of(path->throughput));
    add_fog_emission(path, &along.run);
    if (rgb_is_black(fog->albedo)) return pass(path, &along);
    gather_along(path, &along);
    float u_channel, u;
    rsv_path_next_pair(&path->numbers, &u_channel, &u);
    double column = draw_flight(fog, along.share, u_channel, u);
    if (!(column < along.run.column)) return pass(path, &along);
    set_place(&along, rsv_fog_find(&along.run, column));
    along.pdf = scatter_pdf(fog, &along, along.distance);
    if (!(along.pdf > 0)) return RSV_FOG_ABSORBED; // rounding
    float density = (float)(rsv_fog_density(&along.run, along.distance) / along.pdf);
    path->throughput = rgb_mul(path->throughput, rgb_scale(scattered_share(fog, column), density));
    path->vertex = along;
    return rsv_path_turn_in_fog(path);
}
