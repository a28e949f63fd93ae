#include "camera_chain.h"

#include "rough_aim.h"

#define STACK 64

/// A chain at a surface, and how it left the one before.
typedef struct link {
    rsv_chain chain;
    rsv_rough_departure departure;
    uint32_t path; ///< names the branches that led here; seeds what is drawn here
    bool shot;     ///< photons bring what sources send here
} link;

/// The links still to be followed, and what the others found.
typedef struct tree {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_camera_setting *setting;
    const rsv_pixel_sample *sample;
    link stack[STACK];
    int depth;
    rsv_rgb radiance;
} tree;

static void add_emission(tree *t, const link *at)
{
    rsv_bsdf storage;
    const rsv_chain *chain = &at->chain;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(t->scene, chain, &storage);
    if (!rsv_side_shows_emission(bsdf, chain->back)) return;
    float weight = rsv_rough_emission_weight(t->scene, t->lights, chain, &at->departure);
    rsv_rgb emission = rgb_scale(bsdf->emission, weight * bsdf->opacity);
    rsv_rgb throughput = rsv_chain_throughput(t->scene, chain, &chain->medium);
    t->radiance = rgb_add(t->radiance, rgb_mul(throughput, emission));
}

/// Moves one branch on: to the next link or to the sky.
static void leave(tree *t, link next, const rsv_camera_branch *b)
{
    if (t->depth == STACK) return;
    next.path = b->path;
    rsv_chain_move move =
        rsv_chain_step(t->scene, &next.chain, b->transmit, b->direction, b->weight);
    if (move == RSV_CHAIN_MOVED) t->stack[t->depth++] = next;
    if (move != RSV_CHAIN_LEFT_SCENE) return;
    rsv_rgb beyond = rsv_rough_sky(t->lights, b->direction, &next.departure);
    rsv_rgb throughput = rsv_chain_throughput(t->scene, &next.chain, &next.chain.medium);
    t->radiance = rgb_add(t->radiance, rgb_mul(throughput, beyond));
}

/// One branch of a smooth surface.
static void follow(tree *t, const link *at, bool transmit, const rsv_bsdf_branches *branches)
{
    rsv_camera_branch branch;
    uint32_t most = t->setting->max_events;
    if (!rsv_ideal_branch(&at->chain, at->path, most, transmit, branches, &branch)) return;
    leave(t, (link){ at->chain, { .shot = at->shot }, at->path, at->shot }, &branch);
}

/// Goes straight on where the surface does not cover. What a rough surface aims at is aimed at through it, too, so that the
/// departure stays what it was; without one, that is done along with what is transmitted.
static void pass(tree *t, const link *at, rsv_bsdf_branches *branches)
{
    rsv_bsdf storage;
    if (!(at->departure.pdf_solid_angle > 0)) return;
    float uncovered = 1 - rsv_chain_bsdf(t->scene, &at->chain, &storage)->opacity;
    if (!(uncovered > 0)) return;
    rsv_bsdf_branches past = { .transmit = rgb_gray(uncovered),
        .transmit_direction = at->chain.direction };
    branches->transmit = rgb_positive(rgb_sub(branches->transmit, past.transmit));
    rsv_camera_branch branch;
    if (rsv_ideal_branch(&at->chain, at->path, t->setting->max_events, true, &past, &branch))
        leave(t, *at, &branch);
}

static rsv_rough_numbers draw_numbers(const tree *t, const link *at)
{
    rsv_rough_numbers n;
    if (!t->sample || at->chain.events > 0)
        return rsv_rough_numbers_of(at->path, at->chain.triangle);
    n.kept = rsv_pixel_sample_1d(*t->sample, 20);
    n.light[0] = rsv_pixel_sample_1d(*t->sample, 21);
    rsv_pixel_sample_2d(*t->sample, 22, &n.light[1], &n.light[2]);
    n.direction[0] = rsv_pixel_sample_1d(*t->sample, 23);
    rsv_pixel_sample_2d(*t->sample, 24, &n.direction[1], &n.direction[2]);
    n.sky[0] = rsv_pixel_sample_1d(*t->sample, 25);
    rsv_pixel_sample_2d(*t->sample, 26, &n.sky[1], &n.sky[2]);
    return n;
}

/// One of the directions that a rough surface scatters from, if it draws one, and the sources aimed at.
static void follow_rough(tree *t, link at, const rsv_bsdf_branches *branches)
{
    rsv_rough_surface surface;
    rsv_rough_numbers numbers = draw_numbers(t, &at);
    if (!rsv_rough_arrive(t->scene, &at.chain, &numbers, branches, &surface)) return;
    t->radiance =
        rgb_add(t->radiance, rsv_rough_light(&surface, t->lights, at.shot, numbers.light));
    rsv_sky_aim aim;
    rsv_rough_aim(&surface, t->setting->visibility, &aim);
    t->radiance =
        rgb_add(t->radiance, rsv_rough_aimed_light(&surface, t->lights, &aim, numbers.sky));
    rsv_camera_branch branch;
    if (!rsv_rough_branch(&surface, &numbers, at.path, t->setting->max_events, &branch)) return;
    float sky_pdf = rsv_sky_aim_pdf(&aim, branch.direction);
    link next = { at.chain, rsv_rough_depart(&surface, branch.direction, sky_pdf), at.path,
        at.shot };
    next.departure.shot = at.shot;
    if (t->setting->shot && at.chain.events == 0) next.shot = rsv_rough_is_wide(surface.bsdf);
    leave(t, next, &branch);
}

rsv_rgb rsv_camera_chain(const rsv_camera_setting *setting, rsv_chain chain, uint32_t path,
    const rsv_pixel_sample *sample, rsv_diffuse_end end, void *user)
{
    const rsv_transport_scene *scene = setting->scene;
    tree t; // its stack need not be cleared
    t.scene = scene;
    t.lights = setting->lights;
    t.setting = setting;
    t.sample = sample;
    t.radiance = rgb_gray(0);
    t.depth = 1;
    t.stack[0] = (link){ .chain = chain, .path = path };
    while (t.depth > 0) {
        link at = t.stack[--t.depth];
        add_emission(&t, &at);
        rsv_bsdf_branches branches = rsv_chain_branches(scene, &at.chain);
        if (!rgb_is_black(branches.diffuse))
            end(user, &at.chain,
                rgb_mul(
                    rsv_chain_throughput(scene, &at.chain, &at.chain.medium), branches.diffuse));
        pass(&t, &at, &branches);
        follow(&t, &at, false, &branches);
        follow(&t, &at, true, &branches);
        if (branches.rough) follow_rough(&t, at, &branches);
    }
    return t.radiance;
}
