#include "../render/camera_step.h"
#include "specular_queue.h"

#include <string.h>

typedef rsv_specular_queue queue;

static uint32_t first_of(uint32_t lanes) { return (uint32_t)__builtin_ctz(lanes); }

/// Has the light of a lane added to its pixel.
static void turn_to(queue *q, const rsv_specular_lanes *c, uint32_t lane)
{
    q->light.pixel = c->pixel[lane];
    q->light.trail = c->trail[lane];
}

rsv_specular_path rsv_specular_of_lane(
    const rsv_specular_queue *q, const rsv_ray_packet *p, const rsv_specular_lanes *c, uint32_t k)
{
    rsv_specular_path path = { .direction =
                                   v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]),
        .weight = rsv_lane_color(c->weight, k),
        .medium = q->media->medium[c->medium[k]],
        .channel = RSV_CHANNEL_ALL, // a frame has too few samples to separate colours
        .start_ior = c->start_ior[k],
        .settled = c->settled[k],
        .events = c->events[k],
        .spread = q->spread,
        .width = c->width[k] };
    return path;
}

static rsv_specular_path path_arrived(const queue *q, const rsv_arrival *a, uint32_t k)
{
    rsv_specular_path path = rsv_specular_of_lane(q, a->rays, a->paths, k);
    path.triangle = a->rays->triangle[k];
    path.u = a->rays->u[k];
    path.v = a->rays->v[k];
    path.back = a->paths->back[k];
    return path;
}

/// Records the distance of the pixel's surface, if this is most of its light: the image in a mirror, an object behind a
/// pane.
/// @param distance from the last surface, which the path's width includes
static void note_depth(queue *q, const rsv_arrival *a, uint32_t lane, float distance)
{
    rsv_specular_light *light = &q->light;
    float share = rgb_max(rsv_lane_color(a->paths->throughput, lane));
    bool counts =
        q->spread > 0 && a->paths->events[lane] > 0; // widths give distances, if rays spread
    if (!light->depth || !counts || !(share > light->carried[light->pixel])) return;
    light->carried[light->pixel] = share;
    light->depth[light->pixel] = distance + a->paths->width[lane] / q->spread;
}

// ---- branches -----------------------------------------------------------------------------------

/// Queues a branch that leaves the surface of a lane.
static inline void set_out(queue *q, const rsv_specular_lanes *c, uint32_t lane, bool transmit)
{
    const rsv_branch_lanes *b = &q->branch[transmit];
    q->kind[q->waiting_count] = (uint8_t)b->kind[lane];
    rsv_specular_traveller *t = &q->waiting[q->waiting_count++];
    t->origin = rsv_lane_vector(b->origin, lane);
    t->direction = rsv_lane_vector(b->direction, lane);
    t->weight = rsv_lane_color(b->weight, lane);
    t->t_min = b->t_min[lane];
    t->start_ior = c->start_ior[lane];
    t->width = c->width[lane];
    t->trail = b->trail[lane];
    t->pixel = c->pixel[lane];
    t->events = c->events[lane] + 1;
    t->medium = transmit ? rsv_specular_media_beyond(q->media, c, lane) : (uint8_t)c->medium[lane];
    t->settled = c->settled[lane];
}

/// Room for two branches of each lane.
static bool has_room(const queue *q, uint32_t lanes)
{
    return q->waiting_count + 2 * (uint32_t)__builtin_popcount(lanes) <= RSV_QUEUE_CAPACITY;
}

/// Lanes of smooth surfaces of one material.
static void leave_smooth(queue *q, const rsv_arrival *a, uint32_t lanes)
{
    const rsv_transport_scene *scene = q->light.scene;
    const rsv_specular_lanes *c = a->paths;
    const rsv_bsdf *bsdf = &scene->bsdf[c->material[first_of(lanes)]];
    q->kernels->leave_smooth(scene->view, bsdf, q->clearances, a->rays, c, q->branch);
    for (int transmit = 0; transmit < 2; transmit++)
        for (uint32_t left = lanes; left; left &= left - 1) {
            uint32_t k = first_of(left);
            if (q->branch[transmit].alive[k] && c->events[k] < q->light.max_events)
                set_out(q, c, k, transmit);
        }
}

/// The surface that a specular path has arrived at.
typedef struct surface {
    rsv_specular_path path;
    rsv_surface_point point;
    const rsv_bsdf *bsdf;
    rsv_bsdf_branches branches;
} surface;

/// One branch of any smooth surface.
static void leave(queue *q, const rsv_arrival *a, uint32_t lane, const surface *s, bool transmit)
{
    const rsv_specular_path *path = &s->path;
    rsv_camera_branch branch;
    rsv_ray ray;
    if (!rsv_ideal_branch(
            path, q->light.trail, q->light.max_events, transmit, &s->branches, &branch) ||
        !rsv_specular_depart(&s->point, transmit, branch.direction, &ray))
        return;
    rsv_branch_lanes *b = &q->branch[transmit];
    rsv_set_lane_vector(b->origin, lane, ray.origin);
    rsv_set_lane_vector(b->direction, lane, branch.direction);
    rsv_set_lane_color(b->weight, lane, rgb_mul(path->weight, branch.weight));
    b->t_min[lane] = 0;
    b->trail[lane] = branch.trail;
    b->kind[lane] = rsv_branch_kind(path->back, transmit, branch.direction);
    set_out(q, a->paths, lane, transmit);
}

// ---- surfaces -----------------------------------------------------------------------------------

/// Passes rays on at metal and glass as if they were smooth: for their light behind mirrors and glass.
static void smooth_out(surface *s)
{
    rsv_bsdf smooth = *s->bsdf;
    smooth.alpha = 0;
    s->branches = rsv_specular_branches_of(&smooth, &s->path, &s->point);
}

/// A rough surface: its lobes join those of the tile, or use the irradiance behind mirrors and glass.
static void end_rough(queue *q, const rsv_arrival *a, uint32_t lane, surface *s)
{
    const rsv_specular_path *path = &s->path;
    const rsv_surface_point *point = &s->point;
    const rsv_bsdf *bsdf = s->bsdf;
    rsv_rgb throughput = rsv_lane_color(a->paths->throughput, lane);
    note_depth(q, a, lane, 0);
    bool first = path->events == 0 && path->medium.depth == 0;
    bool diffuses = !rgb_is_black(s->branches.diffuse);
    rsv_add_emission(&q->light, path, bsdf, throughput);
    if (diffuses)
        rsv_add_diffuse_light(
            &q->light, path, bsdf->base_color, rgb_mul(throughput, s->branches.diffuse));
    bool through = !first && path->medium.depth == 0 &&
                   rsv_sees_through_panes(&q->light, path->direction, point->position, throughput);
    if (first || through) {
        float distance =
            first ? a->rays->t_max[lane] : v3_length(v3_sub(point->position, q->light.eye));
        rsv_note_gloss(&q->light, path, point, bsdf, distance, throughput);
        if (bsdf->transmission > 0 || bsdf->passed > 0) return; // rays take all branches
    } else if (diffuses) {
        rsv_add_even_gloss(&q->light, path, point, bsdf, throughput);
    } else {
        smooth_out(s);
    }
    if (!has_room(q, 1u << lane) ||
        rsv_specular_media_beyond(q->media, a->paths, lane) == RSV_MEDIUM_UNLISTED)
        return;
    leave(q, a, lane, s, false);
    leave(q, a, lane, s, true);
}

/// Light of a surface of any kind that is not in the table, and its branches.
static void scatter_one(queue *q, const rsv_arrival *a, uint32_t lane)
{
    rsv_bsdf storage;
    surface s = { .path = path_arrived(q, a, lane) };
    const rsv_specular_path *path = &s.path;
    const rsv_transport_scene *scene = q->light.scene;
    const rsv_bsdf *bsdf = s.bsdf = rsv_specular_bsdf(scene, path, &storage);
    s.point = rsv_surface_point_seen(
        scene->view, path->triangle, path->u, path->v, path->back, path->width);
    s.branches = rsv_specular_branches_of(bsdf, path, &s.point);
    turn_to(q, a->paths, lane);
    if (s.branches.rough && q->light.gloss) {
        end_rough(q, a, lane, &s);
        return;
    }
    if (s.branches.rough || !has_room(q, 1u << lane) ||
        rsv_specular_media_beyond(q->media, a->paths, lane) == RSV_MEDIUM_UNLISTED) {
        rsv_add_whole_path(&q->light, path);
        return;
    }
    rsv_rgb throughput = rsv_lane_color(a->paths->throughput, lane);
    rsv_add_emission(&q->light, path, bsdf, throughput);
    if (!rgb_is_black(s.branches.diffuse))
        rsv_add_diffuse_light(
            &q->light, path, bsdf->base_color, rgb_mul(throughput, s.branches.diffuse));
    leave(q, a, lane, &s, false);
    leave(q, a, lane, &s, true);
}

/// Lanes at surfaces of this material, and whether each of them knows the medium beyond.
static uint32_t lanes_alike(
    const queue *q, const rsv_specular_lanes *c, uint32_t material, uint32_t lanes, bool *listed)
{
    uint32_t alike = 0;
    *listed = true;
    for (uint32_t left = lanes; left; left &= left - 1) {
        uint32_t k = first_of(left);
        if (c->material[k] != material) continue;
        alike |= 1u << k;
        *listed &= rsv_specular_media_beyond(q->media, c, k) != RSV_MEDIUM_UNLISTED;
    }
    return alike;
}

static void scatter(queue *q, const rsv_arrival *a, uint32_t lanes)
{
    while (lanes) {
        bool listed;
        uint32_t material = a->paths->material[first_of(lanes)];
        uint32_t alike = lanes_alike(q, a->paths, material, lanes, &listed);
        lanes &= ~alike;
        if (q->media->material[material].smooth && listed && has_room(q, alike))
            leave_smooth(q, a, alike);
        else
            for (; alike; alike &= alike - 1)
                scatter_one(q, a, first_of(alike));
    }
}

// ---- all kinds of hits ---------------------------------------------------------------------------

static void see_sky(queue *q, const rsv_arrival *a, uint32_t lanes)
{
    for (; lanes && q->light.sky.pixel; lanes &= lanes - 1) {
        uint32_t k = first_of(lanes);
        const rsv_ray_packet *p = a->rays;
        turn_to(q, a->paths, k);
        note_depth(q, a, k, RSV_HISTORY_FAR);
        rsv_add_sky(&q->light, v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]),
            rsv_lane_color(a->paths->throughput, k));
    }
}

static void see_stored(queue *q, const rsv_arrival *a, uint32_t lanes)
{
    for (; lanes; lanes &= lanes - 1) {
        uint32_t k = first_of(lanes);
        turn_to(q, a->paths, k);
        note_depth(q, a, k, a->rays->t_max[k]);
        rsv_add_stored(&q->light, rsv_lane_color(a->paths->throughput, k), a->rays, a->places, k);
    }
}

/// Leaves the lobe of a lane to be lit like those at camera rays' hits, if only panes are in front of it.
static bool leave_lobe(
    queue *q, const rsv_arrival *a, uint32_t k, uint32_t place, rsv_rgb throughput)
{
    const rsv_ray_packet *p = a->rays;
    const rsv_glossy_tile *from = q->lobes;
    rsv_glossy_tile *to = q->light.gloss;
    rsv_vec3 direction = v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]);
    rsv_vec3 point = rsv_packet_point(p, k);
    uint32_t pixel = q->light.pixel;
    bool outside = q->media->medium[a->paths->medium[k]].depth == 0;
    if (!to || !outside || !rsv_sees_through_panes(&q->light, direction, point, throughput))
        return false;
    const float passed[3] = { throughput.r, throughput.g, throughput.b };
    for (int c = 0; c < 3; c++) {
        to->normal[c][pixel] = from->normal[c][place];
        to->albedo[c][pixel] = from->albedo[c][place] * passed[c];
        to->passed[c][pixel] = passed[c];
        to->even[c][pixel] = from->even[c][place];
    }
    to->alpha[pixel] = from->alpha[place];
    to->u[pixel] = p->u[k], to->v[pixel] = p->v[k];
    to->triangle[pixel] = p->triangle[k];
    to->depth[pixel] = v3_length(v3_sub(point, q->light.eye));
    to->count++;
    return true;
}

/// Lanes at glossy surfaces with a diffuse lobe: their rough one shows the irradiance. @return the others
static uint32_t see_glossy(queue *q, const rsv_arrival *a, uint32_t lanes)
{
    const rsv_light_table *table = q->light.table;
    uint32_t glossy = rsv_glossy_lanes(table, a->rays, lanes);
    for (uint32_t left = glossy; left; left &= left - 1)
        if (table->glossy->material[a->paths->material[first_of(left)]].bare)
            glossy &= ~(1u << first_of(left));
    if (!glossy) return lanes;
    memset(q->lobes->depth, 0, RSV_BLOCK * RSV_TILE * sizeof(float));
    q->kernels->look_up(table, a->places, q->irradiance);
    glossy &= ~q->kernels->shade_glossy(q->shading, a->rays, a->paths->width, glossy, q->irradiance,
        (rsv_glossy_block){ q->lobes, 0, NULL });
    for (uint32_t left = glossy; left; left &= left - 1) {
        uint32_t k = first_of(left), place = k / RSV_BLOCK * RSV_TILE + k % RSV_BLOCK;
        const float *base = q->irradiance[place];
        const rsv_glossy_tile *g = q->lobes;
        rsv_rgb throughput = rsv_lane_color(a->paths->throughput, k);
        turn_to(q, a->paths, k);
        note_depth(q, a, k, 0);
        bool lit = g->depth[place] > 0; // or else the lobe is in it already
        if (lit && leave_lobe(q, a, k, place, throughput)) lit = false;
        float share = lit ? 1.0f : 0.0f;
        rsv_rgb shown = rgb(base[0] + share * g->albedo[0][place] * g->even[0][place],
            base[1] + share * g->albedo[1][place] * g->even[1][place],
            base[2] + share * g->albedo[2][place] * g->even[2][place]);
        rsv_add_light(&q->light, rgb_mul(throughput, shown));
    }
    return lanes & ~glossy;
}

/// Follows specular paths one by one that come into a medium which is not listed.
static void follow(queue *q, const rsv_arrival *a, uint32_t lanes)
{
    for (; lanes; lanes &= lanes - 1) {
        uint32_t k = first_of(lanes);
        const rsv_ray_packet *p = a->rays;
        rsv_hit hit = rsv_packet_hit(p, k);
        rsv_specular_path path = rsv_specular_of_lane(q, p, a->paths, k);
        rsv_specular_end_segment(q->light.scene, &path, &hit, rsv_packet_meets_back(p, k));
        turn_to(q, a->paths, k);
        rsv_add_whole_path(&q->light, &path);
    }
}

void rsv_specular_queue_arrive(rsv_specular_queue *q, const rsv_arrival *a, uint32_t lanes)
{
    uint32_t missed = 0;
    for (uint32_t k = 0; k < RSV_LANES; k++)
        missed |= (uint32_t)(a->rays->triangle[k] == RSV_NONE) << k;
    uint32_t met = lanes & ~missed;
    uint32_t unlisted = rsv_specular_media_arrive(q->media, a, met, q->spread);
    see_sky(q, a, lanes & missed);
    follow(q, a, unlisted);
    see_stored(q, a, met & ~unlisted & ~a->left);
    scatter(q, a, see_glossy(q, a, met & ~unlisted & a->left));
}
