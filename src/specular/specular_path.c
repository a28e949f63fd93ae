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
static rsv_gather end_gather(const rsv_transport_scene *scene, rsv_gather *gather,
    const rsv_specular_path *path, rsv_specular_end end)
{
    gather->path = *path;
    gather->path.weight = rsv_specular_throughput(scene, path, &path->medium);
    gather->end = end;
    return *gather;
}

rsv_gather rsv_specular_gather(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, rsv_emission_filter filter, const void *user)
{
    rsv_gather gather = { .end = RSV_SPECULAR_ABSORBED };
    for (;;) {
        if (rsv_specular_lands(scene, &path, false, random, &gather.place))
            return end_gather(scene, &gather, &path, RSV_SPECULAR_SCATTERED);
        if (filter(user, path.triangle, path.turns))
            gather.emission = rgb_add(
                gather.emission, rgb_mul(rsv_specular_throughput(scene, &path, &path.medium),
                                     emission_towards(scene, &path)));
        gather.path = path;
        rsv_bsdf_event event = rsv_specular_draw_event(scene, &path, random);
        if (event.lobe == RSV_LOBE_NONE || path.events >= RSV_SPECULAR_MAX_EVENTS) return gather;
        if (event.lobe == RSV_LOBE_DIFFUSE) {
            gather.path.weight = rgb_mul(path.weight, event.weight);
            gather.end = rsv_specular_survives(&gather.path.weight, random) ? RSV_SPECULAR_DIFFUSE
                                                                            : RSV_SPECULAR_ABSORBED;
            gather.path.weight = rsv_specular_throughput(scene, &gather.path, &gather.path.medium);
            return gather;
        }
        rsv_specular_move move = rsv_specular_follow(scene, &path, &event, event.weight);
        if (move == RSV_SPECULAR_LOST) return gather;
        gather.path = path;
        if (move == RSV_SPECULAR_LEFT_SCENE) {
            bool lands = rsv_specular_lands(scene, &path, true, random, &gather.place);
            return end_gather(
                scene, &gather, &path, lands ? RSV_SPECULAR_SCATTERED : RSV_SPECULAR_ESCAPED);
        }
        if (!rsv_specular_survives(&path.weight, random)) return gather;
    }
}
