#include "camera_path.h"

#include "../specular/fog_flight.h"
#include "rough_aim.h"

#define STACK 64

/// A specular path at a surface, and how it left the one before.
typedef struct link {
    rsv_specular_path path;
    rsv_rough_departure departure;
    uint32_t trail; ///< identifies the branches up to here; seeds the random numbers here
    bool shot;      ///< photons bring the light of sources here
} link;

/// The links that remain to be followed, and the light found by the others.
typedef struct tree {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_camera_setting *setting;
    const rsv_pixel_sample *sample;
    rsv_vec3 start; ///< direction that the camera's ray had; zero for the rest of a path
    void *user;     ///< of the setting's and the caller's functions
    link stack[STACK];
    int depth;
    uint32_t most; ///< events after which the link in hand goes no further
    rsv_rgb radiance;
} tree;

/// Share of the emission that is seen there.
static float emission_seen(const tree *t, const rsv_specular_path *path)
{
    if (!rsv_runs_straight(t->start, path->direction)) return 1;
    const rsv_scene_view *scene = t->lights->scene;
    return scene->material[scene->triangle_material[path->triangle]].camera_emission;
}

static void add_emission(tree *t, const link *at, const rsv_bsdf *bsdf)
{
    const rsv_specular_path *path = &at->path;
    if (!rsv_side_shows_emission(bsdf, path->back)) return;
    float weight = rsv_rough_emission_weight(t->scene, t->lights, path, &at->departure);
    weight *= emission_seen(t, path);
    rsv_rgb emission = rgb_scale(bsdf->emission, weight * bsdf->opacity);
    rsv_rgb throughput = rsv_specular_throughput(t->scene, path, &path->medium);
    t->radiance = rgb_add(t->radiance, rgb_mul(throughput, emission));
}

/// Applies the fog on a path's last segment. There is no fog in solid bodies.
static void cross_fog(tree *t, rsv_specular_path *path, bool leaves, uint32_t trail)
{
    if (!t->setting->cross_fog || path->medium.depth || !(leaves || path->length > 0)) return;
    rsv_ray segment = rsv_specular_segment(t->scene, path, leaves);
    rsv_rgb throughput = rsv_specular_throughput(t->scene, path, &path->medium);
    rsv_rgb passed = t->setting->cross_fog(t->user, &segment, throughput, trail);
    path->weight = rgb_mul(path->weight, passed);
    path->length = 0;
}

/// Moves one branch on: to the next link or to the sky.
static void leave(tree *t, link next, const rsv_camera_branch *b)
{
    if (t->depth == STACK) return;
    next.trail = b->trail;
    rsv_specular_move move =
        rsv_specular_step(t->scene, &next.path, b->transmit, b->direction, b->weight);
    if (move == RSV_SPECULAR_LOST) return;
    cross_fog(t, &next.path, move == RSV_SPECULAR_LEFT_SCENE, next.trail);
    if (move == RSV_SPECULAR_MOVED) t->stack[t->depth++] = next;
    if (move != RSV_SPECULAR_LEFT_SCENE) return;
    rsv_rgb beyond = rsv_rough_sky(t->lights, b->direction, &next.departure);
    rsv_rgb throughput = rsv_specular_throughput(t->scene, &next.path, &next.path.medium);
    t->radiance = rgb_add(t->radiance, rgb_mul(throughput, beyond));
}

/// One branch of a smooth surface.
static void follow(tree *t, const link *at, bool transmit, const rsv_bsdf_branches *branches)
{
    rsv_camera_branch branch;
    if (!rsv_ideal_branch(&at->path, at->trail, t->most, transmit, branches, &branch)) return;
    leave(t, (link){ at->path, { .shot = at->shot }, at->trail, at->shot }, &branch);
}

/// Continues straight past the surface's coverage. Sources sampled at a rough surface are sampled through it too, so
/// the departure stays the same; without one, this is done together with transmission.
/// @param opacity of the surface
static void pass(tree *t, const link *at, float opacity, rsv_bsdf_branches *branches)
{
    float uncovered = 1 - opacity;
    if (!(at->departure.pdf_solid_angle > 0)) return;
    if (!(uncovered > 0)) return;
    rsv_bsdf_branches past = { .transmit = rgb_gray(uncovered),
        .transmit_direction = at->path.direction };
    branches->transmit = rgb_positive(rgb_sub(branches->transmit, past.transmit));
    rsv_camera_branch branch;
    if (rsv_ideal_branch(&at->path, at->trail, t->most, true, &past, &branch))
        leave(t, *at, &branch);
}

static rsv_rough_numbers draw_numbers(const tree *t, const link *at)
{
    rsv_rough_numbers n;
    if (!t->sample || at->path.events > 0)
        return rsv_rough_numbers_of(at->trail, at->path.triangle);
    n.kept = rsv_pixel_sample_1d(*t->sample, 20);
    n.light[0] = rsv_pixel_sample_1d(*t->sample, 21);
    rsv_pixel_sample_2d(*t->sample, 22, &n.light[1], &n.light[2]);
    n.direction[0] = rsv_pixel_sample_1d(*t->sample, 23);
    rsv_pixel_sample_2d(*t->sample, 24, &n.direction[1], &n.direction[2]);
    n.sky[0] = rsv_pixel_sample_1d(*t->sample, 25);
    rsv_pixel_sample_2d(*t->sample, 26, &n.sky[1], &n.sky[2]);
    return n;
}

/// Light of sampled sources at a rough surface.
static rsv_rgb light_aimed(
    const tree *t, const link *at, rsv_rough_surface *surface, const rsv_rough_numbers *numbers)
{
    rsv_rough_surface wide;
    if (t->setting->no_highlights && at->path.events == 0)
        return rsv_rough_light_by(surface, NULL, t->lights, at->shot, numbers->light);
    if (t->setting->averages) rsv_rough_find_turns(surface);
    if (!(t->setting->widening > 0) || rsv_punctual_count(t->lights) == 0)
        return rsv_rough_light(surface, t->lights, at->shot, numbers->light);
    rsv_rough_meet(t->scene, surface->path, &wide);
    rsv_rough_widen(&wide, t->setting->widening);
    return rsv_rough_light_by(surface, &wide, t->lights, at->shot, numbers->light);
}

/// One of the directions that a rough surface scatters from, if it draws one, and the sources aimed at.
/// @param at its weight is made up for surfaces whose lobes are not looked at
static void follow_rough(
    tree *t, link *at, const rsv_bsdf_branches *branches, rsv_rough_surface *surface)
{
    rsv_rough_numbers numbers = draw_numbers(t, at);
    if (!rsv_rough_arrive(&at->path, &numbers, branches, surface)) return;
    t->radiance = rgb_add(t->radiance, light_aimed(t, at, surface, &numbers));
    rsv_sky_aim aim;
    rsv_rough_aim(surface, t->setting->visibility, &aim);
    t->radiance =
        rgb_add(t->radiance, rsv_rough_aimed_light(surface, t->lights, &aim, numbers.sky));
    rsv_camera_branch branch;
    if (!rsv_rough_branch(surface, &numbers, at->trail, t->most, &branch)) return;
    float sky_pdf = rsv_sky_aim_pdf(&aim, branch.direction);
    link next = { at->path, rsv_rough_depart(surface, branch.direction, sky_pdf), at->trail,
        at->shot };
    next.departure.shot = at->shot;
    if (t->setting->shot && at->path.events == 0) next.shot = rsv_rough_is_wide(surface->bsdf);
    leave(t, next, &branch);
}

/// Pictures cut no path off: those that are long enough for any other scene play roulette.
static void limit_events(tree *t, link *at)
{
    t->most = t->setting->max_events;
    if (t->most < RSV_CAMERA_PATH_DEPTH || at->path.events < t->most) return;
    if (rsv_unit_float(rsv_hash2(at->trail, 0x10e6u)) >= RSV_SPECULAR_LONG_SURVIVAL) return;
    at->path.weight = rgb_scale(at->path.weight, 1 / RSV_SPECULAR_LONG_SURVIVAL);
    t->most = UINT32_MAX;
}

/// The light at a link's surface, and the branches that leave there.
static void visit(tree *t, link *at, rsv_diffuse_end end, void *user)
{
    rsv_rough_surface surface;
    rsv_rough_see(t->scene, &at->path, &surface);
    add_emission(t, at, surface.bsdf);
    rsv_bsdf_branches branches = rsv_specular_branches_of(surface.bsdf, &at->path, &surface.point);
    if (!rgb_is_black(branches.diffuse))
        end(user, &at->path,
            rgb_mul(
                rsv_specular_throughput(t->scene, &at->path, &at->path.medium), branches.diffuse));
    limit_events(t, at);
    pass(t, at, surface.bsdf->opacity, &branches);
    follow(t, at, false, &branches);
    follow(t, at, true, &branches);
    if (branches.rough) follow_rough(t, at, &branches, &surface);
}

rsv_rgb rsv_camera_path(const rsv_camera_setting *setting, rsv_specular_path path, uint32_t trail,
    const rsv_pixel_sample *sample, rsv_diffuse_end end, void *user)
{
    tree t; // its stack need not be cleared
    t.scene = setting->scene;
    t.lights = setting->lights;
    t.setting = setting;
    t.sample = sample;
    t.start = path.events == 0 ? path.direction : v3(0, 0, 0);
    t.user = user;
    t.radiance = rgb_gray(0);
    t.depth = 1;
    t.stack[0] = (link){ .path = path, .trail = trail };
    while (t.depth > 0) {
        link at = t.stack[--t.depth];
        visit(&t, &at, end, user);
    }
    return t.radiance;
}
