#include "fog_flight.h"
#include "specular_path_body.h"

/// Radiance emitted along the specular path by its surface, as far as that covers.
static rsv_rgb emission_towards(const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(scene, path, &storage);
    bool shows = bsdf->emissive && (!path->back || bsdf->double_sided);
    return shows ? rgb_scale(bsdf->emission, bsdf->opacity) : rgb_gray(0);
}

bool rsv_specular_survives(rsv_rgb *weight, rsv_random *random)
{
    float largest = rgb_max(*weight);
    if (largest >= 1 || largest <= 0) return largest > 0;
    if (rsv_random_float(random) >= largest) return false;
    *weight = rgb_scale(*weight, 1 / largest);
    return true;
}

/// Where no surface ends it.
static rsv_gather end_in_air(const rsv_transport_scene *scene, rsv_gather *gather,
    const rsv_specular_path *path, rsv_fog_fate fate)
{
    gather->path = *path;
    gather->path.weight = rsv_specular_throughput(scene, path, &path->medium);
    gather->end = fate == RSV_FOG_LANDS     ? RSV_SPECULAR_SCATTERED
                  : fate == RSV_FOG_ESCAPES ? RSV_SPECULAR_ESCAPED
                                            : RSV_SPECULAR_ABSORBED;
    return *gather;
}

/// Follows the path through fog, and adds the light it finds there.
static rsv_fog_fate cross_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    bool leaves, rsv_random *random, rsv_gather *gather)
{
    rsv_fog_crossing crossing = { .emission = gather->emission };
    rsv_fog_fate fate = rsv_specular_cross_fog(scene, path, leaves, random, &crossing);
    gather->emission = crossing.emission;
    gather->place = crossing.place;
    return fate;
}

static rsv_vec3 place_of(const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    const uint32_t *corner = scene->view->triangle[path->triangle];
    const rsv_vec3 *p = scene->view->position;
    return v3_barycentric(p[corner[0]], p[corner[1]], p[corner[2]], path->u, path->v);
}

/// @param witness NULL = none @param gather light found so far
static rsv_gather follow(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, const rsv_emission_wanted *wanted, const rsv_specular_witness *witness,
    rsv_gather gather)
{
    for (;;) {
        rsv_fog_fate fate = cross_fog(scene, &path, false, random, &gather);
        if (fate != RSV_FOG_MEETS) return end_in_air(scene, &gather, &path, fate);
        if (wanted->filter(wanted->user, path.triangle, path.turns))
            gather.emission = rgb_add(
                gather.emission, rgb_mul(rsv_specular_throughput(scene, &path, &path.medium),
                                     emission_towards(scene, &path)));
        gather.path = path;
        rsv_bsdf_event event = rsv_specular_draw_event(scene, &path, random);
        if (event.lobe == RSV_LOBE_NONE || !rsv_specular_goes_on(&path, random)) return gather;
        if (event.lobe == RSV_LOBE_DIFFUSE) {
            gather.path.weight = rgb_mul(path.weight, event.weight);
            gather.end = rsv_specular_survives(&gather.path.weight, random) ? RSV_SPECULAR_DIFFUSE
                                                                            : RSV_SPECULAR_ABSORBED;
            gather.path.weight = rsv_specular_throughput(scene, &gather.path, &gather.path.medium);
            return gather;
        }
        rsv_specular_move move = rsv_specular_follow(scene, &path, &event, event.weight);
        if (move == RSV_SPECULAR_LOST) return gather;
        if (witness && witness->visit)
            witness->visit(witness->user, &path, move == RSV_SPECULAR_LEFT_SCENE,
                place_of(scene, &gather.path));
        gather.path = path;
        if (move == RSV_SPECULAR_LEFT_SCENE) {
            fate = cross_fog(scene, &path, true, random, &gather);
            if (fate != RSV_FOG_MEETS) return end_in_air(scene, &gather, &path, fate);
        }
        if (!rsv_specular_survives(&path.weight, random)) return gather;
    }
}

rsv_gather rsv_specular_gather(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, rsv_emission_filter filter, const void *user)
{
    const rsv_emission_wanted wanted = { filter, user };
    return rsv_specular_gather_seen(scene, path, random, &wanted, NULL);
}

rsv_gather rsv_specular_gather_seen(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, const rsv_emission_wanted *wanted, const rsv_specular_witness *witness)
{
    const rsv_gather nothing = { .end = RSV_SPECULAR_ABSORBED };
    return follow(scene, path, random, wanted, witness, nothing);
}

/// After the fog on the first segment. @return false if that ends the path
static bool goes_on(const rsv_transport_scene *scene, const rsv_specular_path *path,
    const rsv_fog_crossing *crossing, rsv_fog_fate fate, rsv_gather *gather)
{
    gather->emission = crossing->emission;
    gather->place = crossing->place;
    if (fate != RSV_FOG_MEETS) end_in_air(scene, gather, path, fate);
    return fate == RSV_FOG_MEETS;
}

rsv_gather rsv_specular_gather_from_fog(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_vec3 place, rsv_random *random, const rsv_emission_wanted *wanted)
{
    rsv_gather gather = { .end = RSV_SPECULAR_ABSORBED };
    rsv_fog_crossing crossing = { .emission = rgb_gray(0) };
    rsv_fog_fate fate = rsv_specular_meet_fog(scene, &path, place, random, &crossing);
    if (!goes_on(scene, &path, &crossing, fate, &gather)) return gather;
    return follow(scene, path, random, wanted, NULL, gather);
}

rsv_gather rsv_specular_gather_beyond(const rsv_transport_scene *scene, const rsv_medium *medium,
    const rsv_ray *ray, rsv_random *random, const rsv_emission_wanted *wanted)
{
    rsv_gather gather = { .end = RSV_SPECULAR_ABSORBED };
    rsv_fog_crossing crossing = { .emission = rgb_gray(0) };
    rsv_specular_path path = rsv_specular_in_air(scene, medium, ray->direction);
    rsv_fog_fate fate = rsv_specular_cross_beyond(scene, &path, ray, random, &crossing);
    if (!goes_on(scene, &path, &crossing, fate, &gather)) return gather;
    return follow(scene, path, random, wanted, NULL, gather);
}
