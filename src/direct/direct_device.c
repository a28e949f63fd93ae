#include "direct_device.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "../trace/hierarchy.h"
#include "direct_constants.h"

typedef struct direct_device {
    rsv_context *context;
    const rsv_direct_job *job;
    const rsv_device_direct_table *table;
    rsv_device_direct *direct; ///< NULL = there is none, or it has failed
    size_t most;
    rsv_node_receivers *receivers; ///< [most]
    rsv_direct_estimate *estimate; ///< [most] in the order of the receivers
    uint32_t *again;               ///< [most] nodes that need more samples
} direct_device;

// ---- support by devices --------------------------------------------------------------------------

/// Whether the device is worth its hierarchy, which takes the processor about as long as a ray per triangle.
static bool is_worthwhile(const rsv_direct_job *job, size_t count)
{
    size_t rays = rsv_direct_look_rays(job).samples + rsv_punctual_count(job->setting.lights);
    return count * rays > job->scene->view->triangle_count;
}

static bool can_do(const rsv_direct_job *job, size_t count)
{
    rsv_context *context = job->elements->context;
    const rsv_device *device = rsv_context_device(context);
    return device && device->desc.rows && !job->scene->view->fog &&
           rsv_team_place_of(context).size == 1 && is_worthwhile(job, count);
}

// ---- creation -----------------------------------------------------------------------------------

static rsv_status bring_scene(direct_device *d)
{
    rsv_status status = RSV_OK;
    char message[RSV_DEVICE_MESSAGE_BYTES];
    rsv_device_direct_desc desc = {
        .scene = d->job->scene->view, .setting = d->job->setting, .most = (uint32_t)d->most
    };
    RSV_TRY(rsv_tracer_hierarchy(d->job->scene->tracer, &desc.bvh));
    status = d->table->create(rsv_context_device(d->context), &desc, &d->direct, message);
    if (status != RSV_OK) status = rsv_device_failed(d->context, status, message);
cleanup:
    return status;
}

static rsv_status open_device(direct_device *d, size_t count)
{
    rsv_status status = RSV_OK;
    d->most = count < NODES_AT_A_TIME ? count : NODES_AT_A_TIME;
    d->table = rsv_context_device(d->context)->table->direct;
    d->receivers = rsv_reserve(d->context, d->most, sizeof *d->receivers);
    d->estimate = rsv_reserve(d->context, d->most, sizeof *d->estimate);
    d->again = rsv_reserve(d->context, d->most, sizeof *d->again);
    RSV_TRY(d->receivers && d->estimate && d->again ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(bring_scene(d));
cleanup:
    return status;
}

static void close_device(direct_device *d)
{
    if (d->direct) d->table->destroy(d->direct);
    d->direct = NULL;
    rsv_free(d->context, d->receivers);
    rsv_free(d->context, d->estimate);
    rsv_free(d->context, d->again);
}

// ---- nodes --------------------------------------------------------------------------------------

/// Nodes whose receivers are set up.
typedef struct receiver_job {
    const direct_device *d;
    const uint32_t *node;
    bool preview; ///< from few points
} receiver_job;

static void set_up_receivers(void *data, rsv_span span)
{
    const receiver_job *r = data;
    const rsv_direct_job *job = r->d->job;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t node = r->node[k];
        uint32_t valid =
            r->preview ? rsv_direct_preview_points(job, node) : job->valid_points[node];
        rsv_direct_receive(job, node, valid, &r->d->receivers[k]);
    }
}

/// @param preview from few points
static rsv_status estimate(direct_device *d, const uint32_t *node, size_t count, bool preview)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    const rsv_direct_job *job = d->job;
    rsv_direct_rays rays = preview ? rsv_direct_preview_rays(job) : rsv_direct_look_rays(job);
    receiver_job receivers = { d, node, preview };
    rsv_parallel_for(d->context, count, 64, set_up_receivers, &receivers);
    rsv_status status =
        d->table->estimate(d->direct, d->receivers, (uint32_t)count, rays, d->estimate, message);
    if (status == RSV_OK) return RSV_OK;
    d->table->destroy(d->direct);
    d->direct = NULL;
    return rsv_device_failed(d->context, status, message);
}

/// Records the estimates of some nodes. @return number of nodes that need more samples
static size_t take(
    direct_device *d, const uint32_t *node, size_t count, bool preview, rsv_direct_light *light)
{
    size_t again = 0;
    for (size_t k = 0; k < count; k++) {
        const rsv_direct_estimate *e = &d->estimate[k];
        light->rays += e->rays;
        light->irradiance[node[k]] = e->irradiance;
        if (light->deviation) light->deviation[node[k]] = e->deviation;
        if (preview && e->partial) d->again[again++] = node[k];
    }
    return again;
}

rsv_status rsv_direct_by_device(const rsv_direct_job *job, const uint32_t *node, size_t count,
    rsv_direct_light *light, size_t *done)
{
    rsv_status status = RSV_OK;
    direct_device d = { .context = job->elements->context, .job = job };
    bool previews = rsv_direct_previews(job);
    *done = 0;
    if (!can_do(job, count)) return RSV_OK;
    RSV_TRY(open_device(&d, count));
    while (d.direct && *done < count) {
        size_t part = count - *done < d.most ? count - *done : d.most;
        RSV_TRY(estimate(&d, node + *done, part, previews));
        if (!d.direct) break;
        size_t again = take(&d, node + *done, part, previews, light);
        if (again) RSV_TRY(estimate(&d, d.again, again, false));
        if (!d.direct) break;
        take(&d, d.again, again, false, light);
        *done += part;
        RSV_TRY(rsv_progress(d.context, "direct", (double)*done / (double)count));
    }
cleanup:
    close_device(&d);
    return status;
}
