#include "lit_gather.h"

#include "../sources/partition.h"
#include "../specular/fog_flight.h"
#include "camera_step.h"

/// A specular path on its way.
typedef struct traveller {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    bool shot;
    rsv_random *random;
    rsv_specular_path path;
    rsv_rough_departure departure; ///< how it left the surface before
    rsv_rgb found;
    rsv_vec3 place; ///< in the fog, where that ends it
} traveller;

static void add(traveller *t, rsv_rgb radiance) { t->found = rgb_add(t->found, radiance); }

static bool counts(const traveller *t)
{
    return rsv_gathering_counts(t->lights, t->path.triangle, t->path.turns, t->shot);
}

static void add_emission(traveller *t, const rsv_bsdf *bsdf)
{
    const rsv_specular_path *path = &t->path;
    if (!bsdf->emissive || (path->back && !bsdf->double_sided) || !counts(t)) return;
    float weight = rsv_rough_emission_weight(t->scene, t->lights, path, &t->departure);
    rsv_rgb emission = rgb_scale(bsdf->emission, weight * bsdf->opacity);
    add(t, rgb_mul(rsv_specular_throughput(t->scene, path, &path->medium), emission));
}

static void add_sky(traveller *t)
{
    rsv_vec3 direction = t->path.direction;
    rsv_rgb sky = t->path.turns ? rsv_rough_sky(t->lights, direction, &t->departure)
                                : rsv_gathering_sky(t->lights, direction, 0, t->shot);
    add(t, rgb_mul(rsv_specular_throughput(t->scene, &t->path, &t->path.medium), sky));
}

/// Aims at sources. @param chance of coming to aim at them from here
static void add_aimed(traveller *t, const rsv_rough_surface *surface, float chance)
{
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(t->random);
    add(t, rgb_scale(rsv_rough_light(surface, t->lights, t->shot, u), 1 / chance));
}

/// Draws the event at the surface, and samples sources for all but the diffuse lobe.
static rsv_bsdf_event draw(traveller *t, const rsv_rough_surface *s)
{
    float opacity = s->bsdf->opacity;
    // sources were sampled past blended surfaces too
    if (opacity < 1 && rsv_random_float(t->random) >= opacity)
        return rsv_event(RSV_LOBE_PASS, t->path.direction, rgb_gray(1));
    t->departure = (rsv_rough_departure){ .shot = t->shot };
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(t->random);
    rsv_bsdf_event event = rsv_bsdf_draw_event(s->bsdf, s->wo, s->normal, s->front, u);
    if (event.lobe == RSV_LOBE_DIFFUSE || !s->bsdf->rough) return event;
    float specular = rsv_bsdf_specular_chance(s->bsdf, s->wo, s->normal, s->front);
    if (specular * opacity > 0) add_aimed(t, s, specular * opacity);
    if (event.lobe != RSV_LOBE_NONE && event.pdf_solid_angle > 0) {
        t->departure = rsv_rough_depart(s, event.direction, 0);
        t->departure.shot = t->shot;
    }
    return event;
}

/// After fog. @param turned it has turned the path, and has aimed at sources from there
/// @return false if the path ends, or leaves the scene, as `end` then says
static bool leave_fog(traveller *t, const rsv_fog_crossing *crossing, rsv_fog_fate fate,
    bool turned, rsv_specular_end *end)
{
    add(t, crossing->emission);
    t->place = crossing->place;
    if (turned) t->departure = (rsv_rough_departure){ .shot = t->shot };
    if (fate == RSV_FOG_ESCAPES) add_sky(t);
    *end = fate == RSV_FOG_LANDS     ? RSV_SPECULAR_SCATTERED
           : fate == RSV_FOG_ESCAPES ? RSV_SPECULAR_ESCAPED
                                     : RSV_SPECULAR_ABSORBED;
    return fate == RSV_FOG_MEETS;
}

static bool cross_fog(traveller *t, bool leaves, rsv_specular_end *end)
{
    rsv_fog_crossing crossing = { .emission = rgb_gray(0) };
    uint32_t rays = t->path.rays;
    rsv_fog_fate fate = rsv_specular_cross_fog(t->scene, &t->path, leaves, t->random, &crossing);
    return leave_fog(t, &crossing, fate, t->path.rays != rays, end);
}

/// Moves on by an event. @return false if the specular path ends, as `end` then says
static bool move_on(traveller *t, const rsv_bsdf_event *event, rsv_specular_end *end)
{
    *end = RSV_SPECULAR_ABSORBED;
    if (event->lobe == RSV_LOBE_NONE || !rsv_specular_goes_on(&t->path, t->random)) return false;
    if (event->lobe == RSV_LOBE_DIFFUSE) {
        t->path.weight = rgb_mul(t->path.weight, event->weight);
        if (rsv_specular_survives(&t->path.weight, t->random)) *end = RSV_SPECULAR_DIFFUSE;
        return false;
    }
    rsv_specular_move move = rsv_specular_follow(t->scene, &t->path, event, event->weight);
    if (move == RSV_SPECULAR_MOVED) return rsv_specular_survives(&t->path.weight, t->random);
    if (move == RSV_SPECULAR_LEFT_SCENE) return cross_fog(t, true, end);
    return false;
}

/// From surface to surface.
static rsv_specular_end travel(traveller *t)
{
    rsv_specular_end end = RSV_SPECULAR_ABSORBED;
    rsv_bsdf_event event;
    do {
        rsv_rough_surface surface;
        if (!cross_fog(t, false, &end)) break;
        rsv_rough_meet(t->scene, &t->path, &surface);
        add_emission(t, surface.bsdf);
        event = draw(t, &surface);
    } while (move_on(t, &event, &end));
    return end;
}

static rsv_gather result_of(const traveller *t, rsv_specular_end end)
{
    rsv_gather gather = { .end = end, .path = t->path, .place = t->place, .emission = t->found };
    gather.path.weight = rsv_specular_throughput(t->scene, &t->path, &t->path.medium);
    return gather;
}

static traveller begin(const rsv_lit_setting *s, rsv_specular_path path, rsv_random *random)
{
    return (traveller){ .scene = s->scene,
        .lights = s->lights,
        .shot = s->shot,
        .random = random,
        .path = path,
        .departure = { .shot = s->shot } };
}

rsv_gather rsv_gather_lit(
    const rsv_lit_setting *setting, rsv_specular_path path, rsv_random *random)
{
    traveller t = begin(setting, path, random);
    rsv_specular_end end = travel(&t);
    return result_of(&t, end);
}

rsv_gather rsv_gather_lit_ray(const rsv_lit_setting *setting, const rsv_medium *medium,
    const rsv_ray *ray, rsv_random *random)
{
    const rsv_transport_scene *scene = setting->scene;
    rsv_hit hit;
    if (rsv_tracer_closest(scene->tracer, ray, &hit))
        return rsv_gather_lit(
            setting, rsv_specular_begin(scene, medium, ray->direction, hit), random);
    traveller t = begin(setting, rsv_specular_in_air(scene, medium, ray->direction), random);
    rsv_fog_crossing crossing = { .emission = rgb_gray(0) };
    rsv_specular_end end;
    rsv_fog_fate fate = rsv_specular_cross_beyond(scene, &t.path, ray, random, &crossing);
    if (leave_fog(&t, &crossing, fate, t.path.rays > 0, &end)) end = travel(&t);
    return result_of(&t, end);
}
