#include "chain_body.h"

/// Radiance emitted along the chain by its surface, as far as that covers.
static rsv_rgb emission_towards(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, &storage);
    bool shows = bsdf->emissive && (!chain->back || bsdf->double_sided);
    return shows ? rgb_scale(bsdf->emission, bsdf->opacity) : rgb_gray(0);
}

bool rsv_chain_survives(rsv_rgb *weight, rsv_random *random)
{
    float largest = rgb_max(*weight);
    if (largest >= 1 || largest <= 0) return largest > 0;
    if (rsv_random_float(random) >= largest) return false;
    *weight = rgb_scale(*weight, 1 / largest);
    return true;
}

rsv_gather rsv_chain_gather(const rsv_transport_scene *scene, rsv_chain chain, rsv_random *random,
    rsv_emission_filter filter, const void *user)
{
    rsv_gather gather = { .end = RSV_CHAIN_ABSORBED };
    for (;;) {
        if (filter(user, chain.triangle, chain.turns))
            gather.emission =
                rgb_add(gather.emission, rgb_mul(rsv_chain_throughput(scene, &chain, &chain.medium),
                                             emission_towards(scene, &chain)));
        gather.chain = chain;
        rsv_bsdf_event event = rsv_chain_draw_event(scene, &chain, random);
        if (event.lobe == RSV_LOBE_NONE || chain.events >= RSV_CHAIN_MAX_EVENTS) return gather;
        if (event.lobe == RSV_LOBE_DIFFUSE) {
            gather.chain.weight = rgb_mul(chain.weight, event.weight);
            gather.end = rsv_chain_survives(&gather.chain.weight, random) ? RSV_CHAIN_DIFFUSE
                                                                          : RSV_CHAIN_ABSORBED;
            gather.chain.weight = rsv_chain_throughput(scene, &gather.chain, &gather.chain.medium);
            return gather;
        }
        rsv_chain_move move = rsv_chain_follow(scene, &chain, &event, event.weight);
        if (move == RSV_CHAIN_LOST) return gather;
        gather.chain = chain;
        if (move == RSV_CHAIN_LEFT_SCENE) {
            gather.chain.weight = rsv_chain_throughput(scene, &chain, &chain.medium);
            gather.end = RSV_CHAIN_ESCAPED;
            return gather;
        }
        if (!rsv_chain_survives(&chain.weight, random)) return gather;
    }
}
