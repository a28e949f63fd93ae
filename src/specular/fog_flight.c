#include "fog_flight.h"

#include "../media/phase.h"
#include "../sources/air_light.h"
#include "specular_path.h"

/// Light of sources that the uneven part of the phase function turns into the path.
static rsv_rgb turned_light(const rsv_transport_scene *scene, const rsv_specular_path *path,
    rsv_vec3 place, rsv_random *random)
{
    const rsv_fog *fog = scene->view->fog;
    const rsv_air_setting setting = { scene->fog_lights, scene->tracer, fog };
    const rsv_air_receiver receiver = {
        .point = place, .forward = path->direction, .uneven = true
    };
    uint64_t rays = 0;
    float u[5];
    for (int k = 0; k < 5; k++)
        u[k] = rsv_random_float(random);
    if (!scene->fog_lights) return rgb_gray(0);
    rsv_rgb light = rsv_air_light(&setting, &receiver, u, &rays);
    return rgb_scale(rgb_mul(path->weight, light), 1 / (4 * RSV_PI));
}

rsv_vec3 rsv_fog_draw_turn(float g, rsv_vec3 forward, rsv_random *random)
{
    // directions that belong to the isotropic part are drawn again
    double even = rsv_phase_even_share(g) / (4 * M_PI);
    for (;;) {
        float u1 = rsv_random_float(random), u2 = rsv_random_float(random);
        rsv_vec3 direction = rsv_phase_sample(g, forward, u1, u2);
        double density = (double)rsv_phase(g, v3_dot(forward, direction));
        if ((double)rsv_random_float(random) * density >= even) return direction;
    }
}

/// Adds the light that a gather path finds where fog turns it.
static void gather_turned(const rsv_transport_scene *scene, rsv_specular_path *path, rsv_vec3 place,
    rsv_random *random, rsv_fog_crossing *crossing)
{
    crossing->emission = rgb_add(crossing->emission, turned_light(scene, path, place, random));
    path->turns = 0; // light straight from sources has been gathered
}

/// Turns the path at a place. False if it ends there.
static bool turn(const rsv_transport_scene *scene, rsv_specular_path *path, rsv_vec3 place,
    rsv_random *random, rsv_fog_crossing *crossing)
{
    const rsv_fog *fog = scene->view->fog;
    crossing->emission = rgb_add(crossing->emission, rgb_mul(path->weight, rsv_fog_glow(fog)));
    path->weight = rgb_mul(path->weight, fog->albedo);
    if (rgb_is_black(path->weight)) return false;
    if (!crossing->witness) gather_turned(scene, path, place, random, crossing);
    if (!rsv_specular_survives(&path->weight, random)) return false;
    path->direction = rsv_fog_draw_turn(fog->anisotropy, path->direction, random);
    path->events++;
    path->rays++;
    return rsv_specular_goes_on(path, random);
}

rsv_specular_path rsv_specular_in_air(
    const rsv_transport_scene *scene, const rsv_medium *medium, rsv_vec3 direction)
{
    rsv_specular_path path = { .direction = direction,
        .weight = rgb_gray(1),
        .triangle = RSV_NONE,
        .spread = RSV_GATHER_SPREAD };
    if (medium) path.medium = *medium;
    path.start_ior = rsv_medium_ior(&path.medium, scene->bsdf);
    return path;
}

/// A segment of a path through fog.
typedef struct segment {
    rsv_ray ray;
    rsv_hit hit; ///< end of the segment; triangle RSV_NONE = none
    bool turned; ///< it leaves a place in the fog, and the path is not at its end yet
} segment;

/// The segment that leaves a place where the path was turned.
static segment send(const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_vec3 place)
{
    segment s = { .ray = { place, path->direction, INFINITY }, .turned = true };
    if (rsv_ray_meets(scene->tracer, &s.ray, &s.hit))
        s.ray.t_max = s.hit.t;
    else
        s.hit.triangle = RSV_NONE;
    return s;
}

/// Ends a segment that fog let pass.
static rsv_fog_fate arrive(
    const rsv_transport_scene *scene, rsv_specular_path *path, const segment *s)
{
    if (s->hit.triangle == RSV_NONE) return RSV_FOG_ESCAPES;
    if (s->turned)
        rsv_specular_end_segment(
            scene, path, &s->hit, rsv_meets_back(scene, s->hit.triangle, path->direction));
    path->length = 0;
    return RSV_FOG_MEETS;
}

static bool scatters_evenly(const rsv_fog *fog, rsv_random *random)
{
    return fog->anisotropy == 0 ||
           (double)rsv_random_float(random) < rsv_phase_even_share(fog->anisotropy);
}

/// Follows a path until fog no longer turns it.
static rsv_fog_fate follow(const rsv_transport_scene *scene, rsv_specular_path *path, segment s,
    rsv_random *random, rsv_fog_crossing *crossing)
{
    const rsv_fog *fog = scene->view->fog;
    for (;;) {
        if (crossing->witness)
            crossing->witness->cross(crossing->witness->user, &s.ray, path->weight);
        float u_channel = rsv_random_float(random), u = rsv_random_float(random);
        rsv_fog_flight flight = rsv_fog_fly(fog, &s.ray, path->weight, u_channel, u);
        path->weight = rgb_mul(path->weight, flight.weight);
        if (!flight.lands) return arrive(scene, path, &s);
        crossing->place = flight.place;
        if (scatters_evenly(fog, random)) return RSV_FOG_LANDS;
        if (!turn(scene, path, flight.place, random, crossing)) return RSV_FOG_ABSORBS;
        s = send(scene, path, flight.place);
    }
}

rsv_fog_fate rsv_specular_cross_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    bool leaves, rsv_random *random, rsv_fog_crossing *crossing)
{
    if (!scene->view->fog || path->medium.depth || !(leaves || path->length > 0))
        return leaves ? RSV_FOG_ESCAPES : RSV_FOG_MEETS;
    const segment s = { .ray = rsv_specular_segment(scene, path, leaves),
        .hit = { leaves ? RSV_NONE : path->triangle, path->length, path->u, path->v } };
    return follow(scene, path, s, random, crossing);
}

rsv_fog_fate rsv_specular_cross_beyond(const rsv_transport_scene *scene, rsv_specular_path *path,
    const rsv_ray *ray, rsv_random *random, rsv_fog_crossing *crossing)
{
    const segment s = { .ray = { ray->origin, ray->direction, INFINITY },
        .hit = { .triangle = RSV_NONE } };
    if (!scene->view->fog || path->medium.depth) return RSV_FOG_ESCAPES;
    return follow(scene, path, s, random, crossing);
}

rsv_fog_fate rsv_specular_meet_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    rsv_vec3 place, rsv_random *random, rsv_fog_crossing *crossing)
{
    crossing->place = place;
    if (scatters_evenly(scene->view->fog, random)) return RSV_FOG_LANDS;
    if (!turn(scene, path, place, random, crossing)) return RSV_FOG_ABSORBS;
    return follow(scene, path, send(scene, path, place), random, crossing);
}
