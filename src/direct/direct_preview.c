#include "direct_preview.h"

#include "../core/parallel.h"
#include "../receiver/next_event.h"
#include "../sources/light_pattern.h"
#include "../trace/packet.h"
#include "../trace/passage.h"
#include "preview_kernels.h"
#include "preview_sharing.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH
#define NODES RSV_BLOCK_NODES
#define POINTS RSV_BLOCK_POINTS
#define TURNS (RSV_PATTERN_PLACES / POINTS)
/// Blocks that are looked at together: a lane for each of their nodes.
#define GROUP (LANES / NODES)

typedef struct preview_job {
    const rsv_receiver_blocks *blocks;
    const rsv_lights *lights;
    const rsv_preview_kernels *kernels;
    rsv_light_pattern pattern;
    rsv_preview_polygon polygon[RSV_PATTERN_POLYGONS];
    rsv_rgb radiance[RSV_PATTERN_POLYGONS];
    rsv_preview_places
        turn[TURNS];     ///< in TURNS packets every point has seen as many places, every node all
    rsv_rgb *irradiance; ///< [node_count] out
    atomic_uint_least64_t rays;
} preview_job;

bool rsv_can_preview(const rsv_lights *lights)
{
    for (size_t i = 0; i < lights->emitter_count; i++)
        if (rsv_emitter_sides_differ(lights->scene, &lights->emitter[i])) return false;
    return !rsv_environment_light_is_sampled(lights->environment);
}

// ---- the source -------------------------------------------------------------------------------------

static rsv_preview_polygon polygon_of(const rsv_emitter *e)
{
    rsv_preview_polygon p = { .normal_x = e->normal.x,
        .normal_y = e->normal.y,
        .normal_z = e->normal.z,
        .double_sided = e->double_sided };
    for (int i = 0; i < 3; i++) {
        p.x[i] = e->corner[i].x, p.y[i] = e->corner[i].y, p.z[i] = e->corner[i].z;
        p.height = f_max(p.height, 0x1p-20f * v3_max_abs(e->corner[i]));
    }
    return p;
}

static void set_place(rsv_preview_places *turn, uint32_t lane, const rsv_pattern_place *place)
{
    turn->x[lane] = place->point.x, turn->y[lane] = place->point.y, turn->z[lane] = place->point.z;
    turn->normal_x[lane] = place->normal.x;
    turn->normal_y[lane] = place->normal.y;
    turn->normal_z[lane] = place->normal.z;
    turn->extent[lane] = place->extent;
    turn->spread[lane] = place->area / RSV_PI;
    turn->double_sided[lane] = place->double_sided;
    turn->strength[lane] = place->strength;
}

/// In four turns each node sees sixteen places, which are spread over the source: point k sees four in a row of them,
/// from the 4 k-th on. In each single turn the points of four nodes between them see all sixteen.
static void lay_out_places(preview_job *job)
{
    for (uint32_t t = 0; t < TURNS; t++)
        for (uint32_t lane = 0; lane < LANES; lane++) {
            uint32_t node = lane / POINTS, point = lane % POINTS;
            uint32_t place = t / POINTS * LANES + POINTS * point + (node + point + t) % POINTS;
            set_place(&job->turn[t], lane, &job->pattern.place[place]);
        }
}

static void set_up(preview_job *job)
{
    job->kernels = rsv_preview_kernels_best();
    job->pattern = rsv_light_pattern_of(job->lights);
    for (uint32_t k = 0; k < job->pattern.polygons; k++) {
        job->polygon[k] = polygon_of(job->pattern.polygon[k]);
        job->radiance[k] = job->pattern.polygon[k]->radiance;
    }
    if (job->pattern.any) lay_out_places(job);
}

// ---- emitters ---------------------------------------------------------------------------------------

static void clear_packet(rsv_ray_packet *packet)
{
    memset(packet, 0, sizeof *packet);
    memset(packet->mask, 0xff, sizeof packet->mask);
}

static uint32_t valid_points(const rsv_receiver_block *block, uint32_t n)
{
    return block->valid >> n * POINTS & ((1u << POINTS) - 1);
}

/// Mean over the points of a node.
static float mean_of(const rsv_receiver_block *block, uint32_t n, const float *value)
{
    uint32_t valid = valid_points(block, n);
    float sum = 0;
    for (uint32_t k = 0; k < POINTS; k++)
        sum += valid >> k & 1 ? value[n * POINTS + k] : 0;
    return valid ? sum / (float)__builtin_popcount(valid) : 0;
}

/// Transmittance of a node's coat.
static rsv_rgb entering(
    const preview_job *job, const rsv_receiver_block *block, uint32_t n, float cos, rsv_rgb light)
{
    if (!block->coated) return light;
    const rsv_surface_entry *entry = rsv_receiver_entry(job->blocks, block, n);
    return rgb_mul(light, rsv_surface_entry_at(entry, job->blocks->scene->bsdf, cos));
}

/// Irradiance of the nodes without occlusion. @return whether there is any
static bool sum_polygons(
    const preview_job *job, const rsv_receiver_block *block, rsv_rgb unshadowed[NODES])
{
    _Alignas(64) float value[LANES];
    bool any = false;
    for (uint32_t i = 0; i < job->pattern.polygons; i++) {
        job->kernels->irradiance(block, &job->polygon[i], value);
        for (uint32_t n = 0; n < NODES; n++) {
            float mean = mean_of(block, n, value);
            unshadowed[n] = rgb_mad(unshadowed[n], mean, job->radiance[i]);
            any = any || mean > 0;
        }
    }
    return any;
}

/// Light that is on its way to the nodes from the places of one turn.
static void add_open(const rsv_preview_places *places, const float *share, rsv_rgb open[NODES])
{
    for (uint32_t k = 0; k < LANES; k++)
        open[k / POINTS] = rgb_mad(open[k / POINTS], share[k], places->strength[k]);
}

/// The same from many emitters, whose formulas would be too many: all places of all turns.
static bool sum_places(const preview_job *job, const rsv_receiver_block *block,
    rsv_ray_packet *packet, rsv_rgb unshadowed[NODES])
{
    _Alignas(64) float share[LANES], cosine[LANES];
    bool any = false;
    for (uint32_t t = 0; t < TURNS; t++) {
        job->kernels->aim(block, &job->turn[t], packet, share, cosine);
        add_open(&job->turn[t], share, unshadowed);
    }
    for (uint32_t n = 0; n < NODES; n++) {
        float points = (float)__builtin_popcount(valid_points(block, n));
        unshadowed[n] = rgb_scale(unshadowed[n], points > 0 ? POINTS / points : 0);
        any = any || !rgb_is_black(unshadowed[n]);
    }
    return any;
}

static uint32_t lanes_in_use(const rsv_ray_packet *packet)
{
    uint32_t lanes = 0;
    for (uint32_t k = 0; k < LANES; k++)
        lanes |= (uint32_t)(packet->t_max[k] > 0) << k;
    return lanes;
}

/// A block in progress: its rays towards the points of the first turn, and their results.
typedef struct block_look {
    rsv_ray_packet packet;
    float share[LANES], cosine[LANES];
    float passed[LANES]; ///< transmittance of each ray
    rsv_rgb unshadowed[NODES];
    uint32_t sent, known; ///< lanes: with a ray, traced
} __attribute__((aligned(64))) block_look;

/// Starts with the unoccluded light.
static void aim_block(const preview_job *job, const rsv_receiver_block *block, block_look *look)
{
    look->sent = look->known = 0;
    memset(look->passed, 0, sizeof look->passed);
    memset(look->unshadowed, 0, sizeof look->unshadowed);
    bool any = job->pattern.polygons ? sum_polygons(job, block, look->unshadowed)
                                     : sum_places(job, block, &look->packet, look->unshadowed);
    if (!any) return;
    job->kernels->aim(block, &job->turn[0], &look->packet, look->share, look->cosine);
    rsv_receiver_block_lift(block, &look->packet);
    look->sent = lanes_in_use(&look->packet);
}

static void copy_lane(const rsv_ray_packet *from, uint32_t a, rsv_ray_packet *to, uint32_t b)
{
    to->origin_x[b] = from->origin_x[a];
    to->origin_y[b] = from->origin_y[a];
    to->origin_z[b] = from->origin_z[a];
    to->direction_x[b] = from->direction_x[a];
    to->direction_y[b] = from->direction_y[a];
    to->direction_z[b] = from->direction_z[a];
    to->t_max[b] = from->t_max[a];
}

/// Whether all of some rays are free, or none.
static bool see_alike(const float *passed, uint32_t lanes)
{
    bool all = true, none = true;
    for (; lanes; lanes &= lanes - 1) {
        float share = passed[__builtin_ctz(lanes)];
        all = all && share == 1;
        none = none && share == 0;
    }
    return all || none;
}

/// The rays of a block as if all had been traced and brought the same.
static void take_as_seen(block_look *look, float passed)
{
    look->known = look->sent;
    for (uint32_t k = 0; k < LANES; k++)
        look->passed[k] = look->sent >> k & 1 ? passed : 0;
}

/// One ray from each node of the group; together they test all points. If they agree, the other rays are skipped.
/// @param first [GROUP] @return number of rays
static uint64_t look_first(const preview_job *job, block_look *first, rsv_ray_packet *packet)
{
    for (uint32_t k = 0; k < LANES; k++) {
        block_look *look = &first[k / NODES];
        uint32_t lane = k % NODES * POINTS + k / NODES;
        packet->t_max[k] = -1;
        if (look->sent >> lane & 1) copy_lane(&look->packet, lane, packet, k);
    }
    uint32_t sent = lanes_in_use(packet);
    if (!sent) return 0;
    float passed[LANES];
    rsv_tracer_passed_packet(job->blocks->scene->tracer, packet, false, passed);
    for (uint32_t k = 0; k < LANES; k++) {
        block_look *look = &first[k / NODES];
        uint32_t lane = k % NODES * POINTS + k / NODES;
        look->known |= (sent >> k & 1) << lane;
        look->passed[lane] = passed[k];
    }
    for (uint32_t g = 0; g < GROUP && see_alike(passed, sent); g++)
        take_as_seen(&first[g], passed[__builtin_ctz(sent)]);
    return (uint64_t)__builtin_popcount(sent);
}

/// The other rays of a block. @return how many
static uint64_t look_on(const preview_job *job, block_look *look)
{
    uint32_t left = look->sent & ~look->known;
    if (!left) return 0;
    for (uint32_t k = 0; k < LANES; k++)
        if (!(left >> k & 1)) look->packet.t_max[k] = -1;
    float passed[LANES];
    rsv_tracer_passed_packet(job->blocks->scene->tracer, &look->packet, false, passed);
    for (uint32_t k = 0; k < LANES; k++)
        if (left >> k & 1) look->passed[k] = passed[k];
    return (uint64_t)__builtin_popcount(left);
}

/// Stores the results of a block's nodes. At first, irradiance is unoccluded.
static void note_block(const preview_job *job, size_t index, const block_look *look)
{
    const rsv_receiver_block *block = &job->blocks->block[index];
    bool partial = !see_alike(look->passed, look->sent);
    rsv_preview_sums sums[NODES] = { 0 }, all = { { 0, 0, 0 }, { 0, 0, 0 } };
    for (uint32_t k = 0; k < LANES && look->sent; k++) {
        rsv_preview_sums *s = &sums[k / POINTS];
        rsv_rgb light = rgb_scale(job->turn[0].strength[k], look->share[k]);
        s->open = rgb_add(s->open, light);
        if (look->passed[k] > 0)
            s->visible = rgb_mad(s->visible, look->passed[k],
                entering(job, block, k / POINTS, look->cosine[k], light));
    }
    for (uint32_t n = 0; n < NODES; n++) {
        all.open = rgb_mad(all.open, 1.0f / NODES, sums[n].open);
        all.visible = rgb_mad(all.visible, 1.0f / NODES, sums[n].visible);
    }
    for (uint32_t n = 0; n < NODES && block->node[n] != RSV_NONE; n++) {
        job->irradiance[block->node[n]] = look->unshadowed[n];
        // a node whose places all look away goes by its neighbours
        job->blocks->sums[block->node[n]] = rgb_is_black(sums[n].open) ? all : sums[n];
        if (partial) rsv_preview_mark_edge(job->blocks, block->node[n]);
    }
}

/// Data of a worker.
typedef struct group_look {
    block_look block[GROUP];
    rsv_ray_packet first; ///< one ray of each node
} group_look;

static void clear_group(group_look *group)
{
    clear_packet(&group->first);
    for (uint32_t g = 0; g < GROUP; g++)
        clear_packet(&group->block[g].packet);
}

/// @return how many rays
static uint64_t light_group(const preview_job *job, size_t first, group_look *group)
{
    size_t left = job->blocks->block_count - first, count = left < GROUP ? left : GROUP;
    for (size_t g = 0; g < GROUP; g++) {
        group->block[g].sent = group->block[g].known = 0;
        if (g < count) aim_block(job, &job->blocks->block[first + g], &group->block[g]);
    }
    uint64_t rays = look_first(job, group->block, &group->first);
    for (size_t g = 0; g < count; g++) {
        rays += look_on(job, &group->block[g]);
        note_block(job, first + g, &group->block[g]);
    }
    return rays;
}

static void light_groups(void *data, rsv_span span)
{
    preview_job *job = data;
    group_look group;
    uint64_t traced = 0;
    clear_group(&group);
    for (size_t g = span.begin; g < span.end; g++)
        traced += light_group(job, g * GROUP, &group);
    atomic_fetch_add(&job->rays, traced);
}

static void share_blocks(void *data, rsv_span span)
{
    const rsv_receiver_blocks *b = ((const preview_job *)data)->blocks;
    for (size_t k = span.begin; k < span.end; k++)
        rsv_preview_share(b, &b->block[k]);
}

// ---- punctual lights --------------------------------------------------------------------------------

/// Sets a lane's ray to a light; the packet lifts the receiver off its triangle. @return the unoccluded light
static rsv_rgb aim_at_light(const preview_job *job, const rsv_receiver_block *block, uint32_t lane,
    uint32_t light, rsv_ray_packet *packet)
{
    const rsv_medium outside = { .depth = 0 }; // nodes inside absorbing bodies are not in blocks
    rsv_entrance entrance = rsv_entrance_through(
        &outside, job->blocks->scene->bsdf, block->coated ? RSV_COVER_PATCH : RSV_COVER_NONE);
    rsv_vec3 point = v3(block->x[lane], block->y[lane], block->z[lane]);
    rsv_receiver receiver = rsv_receiver_in_space(
        point, v3(block->normal_x[lane], block->normal_y[lane], block->normal_z[lane]), point);
    rsv_next_event event;
    packet->t_max[lane] = -1;
    if (!(block->valid >> lane & 1)) return rgb_gray(0);
    if (block->coated) entrance.patch = rsv_receiver_entry(job->blocks, block, lane / POINTS);
    // places of a light that has a size are shared among the points of a node
    float u = job->lights->extended ? ((float)(lane % POINTS) + 0.5f) / POINTS : 0.5f;
    rsv_next_event_punctual(&receiver, &entrance, job->lights, light, u, &event);
    if (rsv_next_event_asks(&event)) rsv_packet_set_ray(packet, lane, event.ray);
    return event.light;
}

static uint64_t light_by_light(
    const preview_job *job, const rsv_receiver_block *block, uint32_t light)
{
    rsv_ray_packet packet;
    rsv_rgb arriving[LANES];
    clear_packet(&packet);
    for (uint32_t k = 0; k < LANES; k++)
        arriving[k] = aim_at_light(job, block, k, light, &packet);
    rsv_receiver_block_lift(block, &packet);
    uint32_t sent = lanes_in_use(&packet);
    if (!sent) return 0;
    float passed[LANES];
    rsv_tracer_passed_packet(job->blocks->scene->tracer, &packet, false, passed);
    for (uint32_t n = 0; n < NODES && block->node[n] != RSV_NONE; n++) {
        float value[3][LANES];
        for (uint32_t k = n * POINTS; k < (n + 1) * POINTS; k++) {
            rsv_rgb light_in = passed[k] > 0 ? rgb_scale(arriving[k], passed[k]) : rgb_gray(0);
            value[0][k] = light_in.r, value[1][k] = light_in.g, value[2][k] = light_in.b;
        }
        rsv_rgb *e = &job->irradiance[block->node[n]];
        *e = rgb_add(*e, rgb(mean_of(block, n, value[0]), mean_of(block, n, value[1]),
                             mean_of(block, n, value[2])));
    }
    return (uint64_t)__builtin_popcount(sent);
}

/// Shadows of the pattern's source, and the punctual lights.
static void finish_blocks(void *data, rsv_span span)
{
    preview_job *job = data;
    const rsv_receiver_blocks *b = job->blocks;
    uint64_t traced = 0;
    for (size_t k = span.begin; k < span.end; k++) {
        if (job->pattern.any) rsv_preview_shadow(b, &b->block[k], job->irradiance);
        for (uint32_t l = 0; l < rsv_punctual_count(job->lights); l++)
            traced += light_by_light(job, &b->block[k], l);
    }
    atomic_fetch_add(&job->rays, traced);
}

// ---- the whole --------------------------------------------------------------------------------------

rsv_status rsv_direct_preview(const rsv_receiver_blocks *blocks, const rsv_lights *lights,
    rsv_rgb *irradiance, uint64_t *rays)
{
    rsv_context *context = blocks->context;
    preview_job job = { .blocks = blocks, .lights = lights, .irradiance = irradiance };
    size_t count = blocks->block_count, groups = (count + GROUP - 1) / GROUP;
    set_up(&job);
    memset(blocks->edge, 0, blocks->elements->node_count);
    for (size_t n = 0; n < blocks->elements->node_count; n++)
        if (blocks->held[n]) irradiance[n] = rgb_gray(0);
    if (job.pattern.any) {
        rsv_parallel_for(context, groups, 16, light_groups, &job);
        rsv_parallel_for(context, count, 256, share_blocks, &job);
    }
    rsv_parallel_for(context, count, 256, finish_blocks, &job);
    *rays += job.rays;
    return rsv_progress(context, "direct", 1);
}
