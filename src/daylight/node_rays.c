#include "node_rays.h"

#include "../core/sampling.h"
#include "../operator/receiver_points.h"
#include "../trace/packet.h"

#include <string.h>

#define LANES RSV_SUPPORT_POINTS

/// A node whose rays leave.
typedef struct node_receiver {
    rsv_receiver_points points;
    rsv_surface_entry entry;
    rsv_medium medium;
    uint32_t node, group, packet;
} node_receiver;

static bool counts_nothing(const void *user, uint32_t triangle, uint32_t turns)
{
    (void)user, (void)triangle, (void)turns;
    return false;
}

static void receive(const rsv_node_job *job, uint32_t node, node_receiver *r)
{
    const rsv_transport_scene *scene = &job->op->world->scene;
    const rsv_elements *e = job->op->elements;
    rsv_support_point sample[LANES];
    rsv_receiver_draw draw = { node, rsv_elements_draw_of(e, node), job->daylight->light->desc.seed,
        job->op->valid_points[node] };
    rsv_receiver_points_choose(e, draw, sample);
    rsv_receiver_points_set_up(e, scene->tracer, draw, sample, &r->points);
    r->entry = rsv_elements_entry(e, node, sample, LANES, UINT32_MAX);
    const rsv_receiver_points *p = &r->points;
    r->medium = rsv_medium_above(&scene->media, v3(p->origin_x[0], p->origin_y[0], p->origin_z[0]),
        v3(p->geometric_x[0], p->geometric_y[0], p->geometric_z[0]));
    r->node = node;
}

static void aim(
    const rsv_node_job *job, const node_receiver *r, float z[LANES], rsv_ray_packet *packet)
{
    float x[LANES], y[LANES];
    uint32_t stream = rsv_hash3(job->daylight->desc.seed ^ 0x7c15u, r->node, r->group);
    for (uint32_t k = 0; k < LANES; k++) {
        float u1, u2;
        rsv_sobol_2d(r->packet * LANES + k, stream, &u1, &u2);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(u1, u2);
        x[k] = d.x, y[k] = d.y, z[k] = d.z;
    }
    rsv_receiver_points_aim(&r->points, x, y, z, packet);
}

static void add(const rsv_node_job *job, const node_receiver *r, rsv_vec3 direction, rsv_rgb weight,
    rsv_block_escapes *found)
{
    const rsv_daylight *d = job->daylight;
    uint32_t patch = rsv_sky_patch_at(&d->patches, rsv_daylight_to_sky(d, direction));
    const rsv_node_escape escape = { r->node, patch, r->group,
        rgb_scale(weight, RSV_PI / (float)(LANES * job->packets)) };
    rsv_block_escapes_add(d->context, found, &escape);
}

/// Follows a ray after a hit, through mirrors and panes.
static void follow(const rsv_node_job *job, const node_receiver *r, const rsv_ray_packet *p, int k,
    rsv_rgb entered, rsv_block_escapes *found)
{
    const rsv_transport_scene *scene = &job->op->world->scene;
    uint32_t triangle = p->triangle[k];
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[triangle]];
    if (bsdf->lambert && bsdf->opacity == 1) return;
    rsv_vec3 direction = v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]);
    rsv_random random = rsv_random_from(job->daylight->desc.seed ^ 0x3ac5u, r->node,
        (r->group * job->packets + r->packet) * LANES + (uint32_t)k);
    rsv_specular_path path = rsv_specular_begin(scene, &r->medium, direction, rsv_packet_hit(p, k));
    rsv_gather gather = rsv_specular_gather(scene, path, &random, counts_nothing, NULL);
    if (gather.end == RSV_SPECULAR_ESCAPED)
        add(job, r, gather.path.direction, rgb_mul(gather.path.weight, entered), found);
}

static void trace_packet(const rsv_node_job *job, const node_receiver *r, rsv_block_escapes *found)
{
    const rsv_transport_scene *scene = &job->op->world->scene;
    rsv_ray_packet packet = { 0 };
    float z[LANES];
    memset(packet.mask, 0xff, sizeof packet.mask);
    aim(job, r, z, &packet);
    rsv_tracer_closest_packet(scene->tracer, &packet, false);
    for (int k = 0; k < LANES; k++) {
        bool met = packet.triangle[k] != RSV_NONE;
        if (!met && !(packet.t_max[k] > 0)) continue; // started below the surface
        rsv_rgb entered = rsv_surface_entry_at(&r->entry, scene->bsdf, z[k]);
        if (met)
            follow(job, r, &packet, k, entered, found);
        else
            add(job, r, v3(packet.direction_x[k], packet.direction_y[k], packet.direction_z[k]),
                entered, found);
    }
}

void rsv_node_rays_trace(
    const rsv_node_job *job, size_t begin, size_t end, rsv_block_escapes *found)
{
    const rsv_elements *e = job->op->elements;
    for (size_t n = begin; n < end; n++) {
        node_receiver r;
        if (e->node_hanging[n] != RSV_NONE || !job->op->valid_points[n]) continue;
        receive(job, (uint32_t)n, &r);
        for (r.group = 0; r.group < RSV_DAYLIGHT_GROUPS; r.group++)
            for (r.packet = 0; r.packet < job->packets; r.packet++)
                trace_packet(job, &r, found);
    }
}
