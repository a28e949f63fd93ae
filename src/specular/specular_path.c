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

rsv_gather rsv_specular_gather(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, rsv_emission_filter filter, const void *user)
{
    const rsv_specular_witness nobody = { NULL, NULL };
    return rsv_specular_gather_seen(scene, path, random, filter, user, nobody);
}

static rsv_vec3 place_of(const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    const uint32_t *corner = scene->view->triangle[path->triangle];
    const rsv_vec3 *p = scene->view->position;
    return v3_barycentric(p[corner[0]], p[corner[1]], p[corner[2]], path->u, path->v);
}

rsv_gather rsv_specular_gather_seen(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, rsv_emission_filter filter, const void *user, rsv_specular_witness witness)
{
    rsv_gather gather = { .end = RSV_SPECULAR_ABSORBED };
    for (;;) {
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
        if (witness.visit)
            witness.visit(witness.user, &path, move == RSV_SPECULAR_LEFT_SCENE,
                place_of(scene, &gather.path));
        gather.path = path;
        if (move == RSV_SPECULAR_LEFT_SCENE) {
            gather.path.weight = rsv_specular_throughput(scene, &path, &path.medium);
            gather.end = RSV_SPECULAR_ESCAPED;
            return gather;
        }
        if (!rsv_specular_survives(&path.weight, random)) return gather;
    }
}
