#include "device_map.h"

#include "../core/team.h"
#include "../operator/transport_lists.h"

struct rsv_device_map {
    rsv_context *context;
    const rsv_device_transport_table *table;
    rsv_parents parents;
    rsv_diffusion_rows diffusion;
    rsv_device_transport *transport; ///< NULL = the device has failed
};

rsv_status rsv_device_map_create(const rsv_elements *elements, const rsv_transport *transport,
    const rsv_subsurface *subsurface, const rsv_rgb *albedo, rsv_device_map **map)
{
    rsv_context *context = elements->context;
    rsv_device *device = elements->voxels ? NULL : rsv_context_device(context);
    char message[RSV_DEVICE_MESSAGE_BYTES];
    rsv_status status;
    *map = NULL;
    rsv_transport_list list[RSV_TRANSPORT_LISTS];
    // in a team, rows are divided
    if (!device || rsv_team_of(context) ||
        !rsv_transport_list_rows((rsv_transport *)(uintptr_t)transport, list))
        return RSV_OK;
    rsv_device_map *m = rsv_alloc(context, 1, sizeof *m);
    if (!m) return RSV_ERROR_MEMORY;
    m->context = context;
    m->table = device->table->transport;
    RSV_TRY(rsv_parents_create(elements, &m->parents));
    if (subsurface) RSV_TRY(rsv_diffusion_rows_create(subsurface, &m->diffusion));
    const rsv_device_system system = { .node_count = elements->node_count,
        .row_begin = *list[0].begin,
        .tinted_begin = *list[1].begin,
        .column = *list[0].column,
        .tinted_column = *list[1].column,
        .tinted_weight = *list[1].weight,
        .scale = transport->scale,
        .albedo = albedo,
        .parents = m->parents,
        .diffusion = subsurface ? &m->diffusion : NULL };
    status = m->table->create(device, &system, &m->transport, message);
    if (status != RSV_OK) RSV_TRY(rsv_device_failed(context, status, message));
    if (m->transport) {
        *map = m;
        m = NULL;
    }
cleanup:
    rsv_device_map_destroy(m);
    return status;
}

void rsv_device_map_destroy(rsv_device_map *m)
{
    if (!m) return;
    if (m->transport) m->table->destroy(m->transport);
    rsv_parents_destroy(m->context, &m->parents);
    rsv_diffusion_rows_destroy(m->context, &m->diffusion);
    rsv_free(m->context, m);
}

/// There is no device for this map any more. @return as rsv_device_failed
static rsv_status lose(rsv_device_map *m, rsv_status status, const char *message)
{
    m->table->destroy(m->transport);
    m->transport = NULL;
    return rsv_device_failed(m->context, status, message);
}

bool rsv_device_map_apply(rsv_device_map *m, size_t fields, const rsv_rgb *field, rsv_rgb *image)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    if (!m || !m->transport) return false;
    rsv_status status = m->table->apply(m->transport, fields, field, image, message);
    if (status != RSV_OK) lose(m, status, message);
    return status == RSV_OK;
}

bool rsv_device_map_residual(rsv_device_map *m, size_t fields, const rsv_rgb *source,
    const rsv_rgb *field, rsv_rgb *residual)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    if (!m || !m->transport) return false;
    rsv_status status = m->table->residual(m->transport, fields, source, field, residual, message);
    if (status != RSV_OK) lose(m, status, message);
    return status == RSV_OK;
}

bool rsv_device_map_solves(const rsv_device_map *m, rsv_solver solver)
{
    return m && m->transport && m->table->solves(solver);
}

static bool is_cancelled(void *context) { return rsv_cancelled(context); }

rsv_status rsv_device_map_solve(
    rsv_device_map *m, rsv_device_solve *solve, const rsv_rgb *residual, rsv_rgb *correction)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    solve->stops = is_cancelled;
    solve->user = m->context;
    rsv_status status = m->table->solve(m->transport, solve, residual, correction, message);
    if (status == RSV_OK) return RSV_OK;
    solve->converged = false;
    solve->applications = 0;
    return lose(m, status, message);
}

rsv_status rsv_device_map_measure(
    rsv_device_map *m, uint32_t repetitions, double *copy_rate, double *seconds, size_t *bytes)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    if (!m || !m->transport)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "device: no device holds this operator");
    rsv_status status =
        m->table->measure(m->transport, repetitions, copy_rate, seconds, bytes, message);
    if (status == RSV_OK) return RSV_OK;
    lose(m, status, message);
    return rsv_fail(status, "device: %s", message); // there is no fallback
}
