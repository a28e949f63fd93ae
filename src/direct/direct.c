#include "direct.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "direct_device.h"
#include "near_punctual.h"

#define LANES RSV_DIRECT_LANES

/// Up to sixteen shadow rays.
static void sample_emitters(const rsv_direct_job *job, const rsv_node_receivers *receivers,
    const rsv_local_lights *local, uint32_t first, uint32_t lanes, rsv_event_sums *sums)
{
    const rsv_direct_setting *s = &job->setting;
    const rsv_entrance entrance = rsv_direct_entrance(s, receivers);
    rsv_next_event event[LANES];
    if (lanes == 0) return; // as gcc would fear
    for (uint32_t k = 0; k < lanes; k++) {
        uint32_t at = rsv_direct_turn(s, receivers->valid, first + k);
        float u[3];
        rsv_next_event_clear(&event[k]);
        if (!(receivers->valid >> at & 1)) continue;
        rsv_direct_numbers(s, receivers->node, first + k, u);
        rsv_next_event_draw(&receivers->at[at], &entrance, &local[at], u, &event[k]);
    }
    float passed[LANES];
    rsv_next_events_passed(job->scene->tracer, event, lanes, passed);
    for (uint32_t k = 0; k < lanes; k++)
        rsv_event_sums_add(sums, &event[k], passed[k]);
}

static rsv_direct_estimate from_emitters(const rsv_direct_job *job, uint32_t node,
    const rsv_node_receivers *receivers, rsv_direct_rays rays)
{
    const rsv_direct_setting *s = &job->setting;
    rsv_local_lights local[LANES];
    rsv_rgb unshadowed;
    float valid = (float)__builtin_popcount(receivers->valid);
    if (!receivers->valid || !rsv_lights_any_sampled(s->lights)) return rsv_direct_no_estimate();
    for (uint32_t k = 0; k < s->points; k++)
        if (receivers->valid >> k & 1) rsv_receiver_weigh(&receivers->at[k], s->lights, &local[k]);
    bool by_tree = rsv_direct_unshadowed(s, receivers, local, valid, &unshadowed);
    if (!by_tree && rgb_is_black(unshadowed)) return rsv_direct_no_estimate();
    if (job->whole && !by_tree)
        rays.samples = rsv_direct_samples_by_share(job, node, unshadowed, rays.samples);
    rsv_event_sums sums = rsv_event_sums_zero();
    for (uint32_t first = 0; first < rays.samples; first += rays.lanes)
        sample_emitters(job, receivers, local, first, rays.lanes, &sums);
    rsv_direct_estimate e = rsv_direct_from_sums(
        &sums, unshadowed, by_tree, rsv_direct_drawn(s, receivers->valid, rays.samples));
    e.rays = rays.samples;
    return e;
}

/// Adds the light of punctual lights. @param near_lights those to omit
static void add_punctual(const rsv_direct_job *job, const rsv_node_receivers *receivers,
    uint32_t near_lights, rsv_direct_estimate *e)
{
    const rsv_direct_setting *s = &job->setting;
    rsv_direct_punctual p = { 0 };
    for (uint32_t l = 0; l < rsv_punctual_count(s->lights); l++) {
        rsv_next_event event[LANES];
        if (near_lights && (near_lights >> l & 1)) continue;
        for (uint32_t k = 0; k < s->points; k++) {
            if (receivers->valid >> k & 1)
                rsv_direct_to_punctual(s, receivers, k, l, &event[k]);
            else
                rsv_next_event_clear(&event[k]);
        }
        float passed[LANES];
        rsv_next_events_passed(job->scene->tracer, event, s->points, passed);
        p.seen = p.hidden = 0;
        for (uint32_t k = 0; k < s->points; k++)
            rsv_direct_count_punctual(&p, &event[k], passed[k]);
        e->partial = e->partial || (p.seen > 0 && p.hidden > 0);
        e->rays += s->points;
    }
    float valid = (float)__builtin_popcount(receivers->valid);
    e->irradiance = rgb_add(e->irradiance, rgb_scale(p.sum, 1 / valid));
}

static rsv_direct_estimate estimate_from(
    const rsv_direct_job *job, uint32_t node, uint32_t valid, rsv_direct_rays rays)
{
    rsv_node_receivers receivers;
    rsv_direct_receive(job, node, valid, &receivers);
    rsv_direct_estimate e = from_emitters(job, node, &receivers, rays);
    uint32_t near_lights = rsv_near_punctual(job, node);
    add_punctual(job, &receivers, near_lights, &e);
    if (near_lights) rsv_near_punctual_add(job, &receivers, node, near_lights, &e);
    return e;
}

/// A preview, and a look where that sees sources in part.
static rsv_direct_estimate estimate(const rsv_direct_job *job, uint32_t node)
{
    uint32_t previewed = 0;
    if (rsv_direct_previews(job)) {
        rsv_direct_estimate e = estimate_from(
            job, node, rsv_direct_preview_points(job, node), rsv_direct_preview_rays(job));
        if (!e.partial) return e;
        previewed = e.rays;
    }
    rsv_direct_estimate e =
        estimate_from(job, node, job->valid_points[node], rsv_direct_look_rays(job));
    e.rays += previewed;
    return e;
}

/// Moves nodes with nearby lights, which devices do not support, behind the others.
/// @return number of the others
static size_t put_near_last(const rsv_direct_job *job, uint32_t *list, size_t count)
{
    size_t others = 0;
    for (size_t k = 0; k < count; k++) {
        if (rsv_near_punctual(job, list[k])) continue;
        uint32_t node = list[k];
        list[k] = list[others];
        list[others++] = node;
    }
    return others;
}

/// Lists this process's nodes that receive light and are not known; the others of its own get none.
/// @param list [node_count] @return how many
static size_t list_nodes(
    const rsv_direct_job *job, const uint8_t *known, uint32_t *list, rsv_direct_light *light)
{
    rsv_team_place place = rsv_team_place_of(job->elements->context);
    size_t count = 0;
    for (size_t node = 0; node < rsv_elements_surface_nodes(job->elements); node++) {
        if (!rsv_team_owns(place, node, RSV_TEAM_BLOCK) || (known && known[node])) continue;
        light->irradiance[node] = rgb_gray(0);
        if (light->deviation) light->deviation[node] = 0;
        bool dark = job->whole && rgb_is_black(job->whole[node]);
        if (job->valid_points[node] && !dark) list[count++] = (uint32_t)node;
    }
    return count;
}

/// Nodes that receive direct light.
typedef struct node_job {
    const rsv_direct_job *job;
    const uint32_t *node; ///< [count]
    size_t count;
    rsv_direct_light *light;
    atomic_uint_least64_t rays;
    size_t done; ///< by worker 0
} node_job;

static void report_nodes(node_job *nodes)
{
    rsv_context *context = nodes->job->elements->context;
    if ((++nodes->done & 1023) != 0) return;
    size_t done = nodes->done * (size_t)rsv_threads(context);
    rsv_progress(context, "direct", fmin((double)done / (double)nodes->count, 1));
}

static void light_nodes(void *data, rsv_span span)
{
    node_job *nodes = data;
    const rsv_direct_light *light = nodes->light;
    uint64_t traced = 0;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t node = nodes->node[k];
        if (rsv_cancelled(nodes->job->elements->context)) break;
        rsv_direct_estimate e = estimate(nodes->job, node);
        traced += e.rays;
        light->irradiance[node] = e.irradiance;
        if (light->deviation) light->deviation[node] = e.deviation;
        if (span.worker == 0) report_nodes(nodes);
    }
    atomic_fetch_add(&nodes->rays, traced);
}

static void estimate_nodes(
    const rsv_direct_job *job, const uint32_t *node, size_t count, rsv_direct_light *light)
{
    node_job nodes = { .job = job, .node = node, .count = count, .light = light };
    rsv_parallel_for(job->elements->context, count, 64, light_nodes, &nodes);
    light->rays += nodes.rays;
}

rsv_status rsv_direct_irradiance(
    const rsv_direct_job *job, const uint8_t *known, rsv_direct_light *light)
{
    rsv_status status = RSV_OK;
    rsv_context *context = job->elements->context;
    size_t nodes = job->elements->node_count, done;
    rsv_direct_light own = { light->irradiance, light->deviation, 0 };
    uint32_t *list = rsv_alloc(context, nodes, sizeof *list);
    if (!list) return RSV_ERROR_MEMORY;
    size_t count = list_nodes(job, known, list, &own);
    RSV_TRY(rsv_direct_by_device(job, list, put_near_last(job, list, count), &own, &done));
    estimate_nodes(job, list + done, count - done, &own);
    light->rays += rsv_team_total(context, own.rays);
    rsv_team_merge(context, own.irradiance, sizeof *own.irradiance, nodes, RSV_TEAM_BLOCK);
    if (own.deviation)
        rsv_team_merge(context, own.deviation, sizeof *own.deviation, nodes, RSV_TEAM_BLOCK);
    rsv_elements_constrain(job->elements, own.irradiance);
    status = rsv_progress(context, "direct", 1);
cleanup:
    rsv_free(context, list);
    return status;
}
