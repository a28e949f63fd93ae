#include "lit_gather.h"

#include "rough_branch.h"

/// A chain on its way.
typedef struct traveller {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    bool shot;
    rsv_random *random;
    rsv_chain chain;
    rsv_rough_departure departure; ///< how it left the surface before
    rsv_rgb found;
} traveller;

static void add(traveller *t, rsv_rgb radiance) { t->found = rgb_add(t->found, radiance); }

static bool counts(const traveller *t)
{
    uint32_t emitter = t->lights->triangle_emitter[t->chain.triangle];
    if (emitter == RSV_NONE) return false;
    const rsv_emitter_group *group = &t->lights->group[t->lights->emitter[emitter].group];
    return !group->muted && (group->gathered || t->chain.events > 0);
}

static void add_emission(traveller *t, const rsv_bsdf *bsdf)
{
    const rsv_chain *chain = &t->chain;
    if (!bsdf->emissive || (chain->back && !bsdf->double_sided) || !counts(t)) return;
    float weight = rsv_rough_emission_weight(t->scene, t->lights, chain, &t->departure);
    rsv_rgb emission = rgb_scale(bsdf->emission, weight * bsdf->opacity);
    add(t, rgb_mul(rsv_chain_throughput(t->scene, chain, &chain->medium), emission));
}

static void add_sky(traveller *t)
{
    rsv_rgb sky = rsv_rough_sky(t->lights, t->chain.direction, &t->departure);
    add(t, rgb_mul(rsv_chain_throughput(t->scene, &t->chain, &t->chain.medium), sky));
}

/// Aims at sources. @param chance of coming to aim at them from here
static void add_aimed(traveller *t, const rsv_rough_surface *surface, float chance)
{
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(t->random);
    add(t, rgb_scale(rsv_rough_light(surface, t->lights, t->shot, u), 1 / chance));
}

/// Draws what happens at the surface, and aims at sources where that is not the diffuse lobe.
static rsv_bsdf_event draw(traveller *t, const rsv_rough_surface *s)
{
    float opacity = s->bsdf->opacity;
    t->departure = (rsv_rough_departure){ .shot = t->shot };
    if (opacity < 1 && rsv_random_float(t->random) >= opacity)
        return rsv_event(RSV_LOBE_TRANSMIT, t->chain.direction, rgb_gray(1));
    float u_lobe = rsv_random_float(t->random), u1 = rsv_random_float(t->random);
    rsv_bsdf_event event = rsv_bsdf_draw_event(
        s->bsdf, s->wo, s->normal, s->front, u_lobe, u1, rsv_random_float(t->random));
    if (event.lobe == RSV_LOBE_DIFFUSE || !s->bsdf->rough) return event;
    float specular = rsv_bsdf_specular_chance(s->bsdf, s->wo, s->normal, s->front);
    if (specular * opacity > 0) add_aimed(t, s, specular * opacity);
    if (event.lobe != RSV_LOBE_NONE && event.pdf_solid_angle > 0) {
        t->departure = rsv_rough_depart(s, event.direction, 0);
        t->departure.shot = t->shot;
    }
    return event;
}

/// Moves on by an event. @return false if the chain ends, as `end` then says
static bool move_on(traveller *t, const rsv_bsdf_event *event, rsv_chain_end *end)
{
    bool transmit = event->lobe == RSV_LOBE_TRANSMIT;
    *end = RSV_CHAIN_ABSORBED;
    if (event->lobe == RSV_LOBE_NONE || t->chain.events >= RSV_CHAIN_MAX_EVENTS) return false;
    if (event->lobe == RSV_LOBE_DIFFUSE) {
        t->chain.weight = rgb_mul(t->chain.weight, event->weight);
        if (rsv_chain_survives(&t->chain.weight, t->random)) *end = RSV_CHAIN_DIFFUSE;
        return false;
    }
    rsv_chain_move move =
        rsv_chain_step(t->scene, &t->chain, transmit, event->direction, event->weight);
    if (move == RSV_CHAIN_MOVED) return rsv_chain_survives(&t->chain.weight, t->random);
    if (move == RSV_CHAIN_LEFT_SCENE) {
        add_sky(t);
        *end = RSV_CHAIN_ESCAPED;
    }
    return false;
}

rsv_gather rsv_gather_lit(const rsv_transport_scene *scene, const rsv_lights *lights, bool shot,
    rsv_chain chain, rsv_random *random)
{
    traveller t = { scene, lights, shot, random, chain, { .shot = shot }, rgb_gray(0) };
    rsv_gather gather = { .end = RSV_CHAIN_ABSORBED };
    rsv_bsdf_event event;
    do {
        rsv_rough_surface surface;
        rsv_rough_meet(scene, &t.chain, &surface);
        add_emission(&t, surface.bsdf);
        event = draw(&t, &surface);
    } while (move_on(&t, &event, &gather.end));
    gather.chain = t.chain;
    gather.chain.weight = rsv_chain_throughput(scene, &t.chain, &t.chain.medium);
    gather.emission = t.found;
    return gather;
}
