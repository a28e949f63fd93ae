#include "camera_chain.h"

#define FAINT 0.01f ///< branches below this weight play roulette
#define MAX_EVENTS 64
#define STACK 64

static rsv_rgb emission_towards(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, &storage);
    bool shows = (bsdf->emissive || bsdf->unlit) && (!chain->back || bsdf->double_sided);
    return shows ? rgb_mul(chain->weight, rgb_scale(bsdf->emission, bsdf->opacity)) : rgb_gray(0);
}

/// Moves one branch on; false if it ended, in the sky with the radiance from there.
static bool leave(const rsv_transport_scene *scene, const rsv_sky *sky, rsv_chain *chain,
    bool transmit, rsv_vec3 direction, rsv_rgb weight, rsv_rgb *radiance)
{
    rsv_chain_move move = rsv_chain_step(scene, chain, transmit, direction, weight);
    if (move == RSV_CHAIN_LEFT_SCENE) {
        rsv_rgb beyond = rsv_sky_radiance(sky, chain->direction);
        *radiance = rgb_add(*radiance, rgb_mul(chain->weight, beyond));
    }
    return move == RSV_CHAIN_MOVED;
}

/// One branch of a smooth surface.
static bool follow(const rsv_transport_scene *scene, const rsv_sky *sky, rsv_chain *chain,
    bool transmit, const rsv_bsdf_branches *branches, rsv_random *random, rsv_rgb *radiance)
{
    rsv_rgb weight = transmit ? branches->transmit : branches->reflect;
    float carried = rgb_max(rgb_mul(chain->weight, weight));
    if (carried <= 0 || chain->events >= MAX_EVENTS) return false;
    if (carried < FAINT) {
        if (rsv_random_float(random) * FAINT >= carried) return false;
        weight = rgb_scale(weight, FAINT / carried);
    }
    rsv_vec3 direction = transmit ? branches->transmit_direction : branches->reflect_direction;
    return leave(scene, sky, chain, transmit, direction, weight, radiance);
}

/// One of the directions that a rough surface scatters from; false if it has none.
static bool follow_rough(const rsv_transport_scene *scene, const rsv_sky *sky, rsv_chain *chain,
    rsv_random *random, rsv_rgb *radiance)
{
    rsv_bsdf_event event = rsv_chain_draw_event(scene, chain, random);
    bool specular = event.lobe == RSV_LOBE_REFLECT || event.lobe == RSV_LOBE_TRANSMIT;
    if (!specular || event.pdf_solid_angle == 0 || chain->events >= MAX_EVENTS) return false;
    bool transmit = event.lobe == RSV_LOBE_TRANSMIT;
    return leave(scene, sky, chain, transmit, event.direction, event.weight, radiance);
}

rsv_rgb rsv_camera_chain(const rsv_transport_scene *scene, const rsv_sky *sky, rsv_chain chain,
    uint32_t seed, rsv_diffuse_end end, void *user)
{
    rsv_chain stack[STACK];
    int depth = 0;
    rsv_rgb radiance = rgb_gray(0);
    rsv_random random = rsv_random_from(seed, chain.triangle, 0x17c3u);
    stack[depth++] = chain;
    while (depth > 0) {
        chain = stack[--depth];
        radiance = rgb_add(radiance, emission_towards(scene, &chain));
        rsv_bsdf_branches branches = rsv_chain_branches(scene, &chain);
        if (!rgb_is_black(branches.diffuse))
            end(user, &chain, rgb_mul(chain.weight, branches.diffuse));
        for (int transmit = 0; transmit < 2; transmit++) {
            rsv_chain next = chain;
            if (depth < STACK && follow(scene, sky, &next, transmit, &branches, &random, &radiance))
                stack[depth++] = next;
        }
        if (branches.rough && depth < STACK && follow_rough(scene, sky, &chain, &random, &radiance))
            stack[depth++] = chain;
    }
    return radiance;
}
