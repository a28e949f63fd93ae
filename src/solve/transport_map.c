#include "transport_map.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "../operator/transport_rows.h"
#include "../solver/linear_solver.h"
#include "node_groups.h"

#include <string.h>

static const rsv_rgb *rgb_field(const float *field) { return (const rsv_rgb *)field; }

/// One of several fields that lie node by node.
typedef struct field_job {
    rsv_transport_map *map;
    size_t fields, f;
    const rsv_rgb *field;
    rsv_rgb *exitance;
} field_job;

/// For all nodes; on the calling thread only if there are few.
static void for_nodes(rsv_transport_map *m, void (*body)(void *, rsv_span), field_job *job)
{
    size_t nodes = m->linear.count;
    rsv_parallel_for(m->linear.context, nodes, nodes > RSV_PARALLEL_NODES ? 0 : nodes, body, job);
}

static void take_field(void *data, rsv_span span)
{
    const field_job job = *(const field_job *)data;
    for (size_t n = span.begin; n < span.end; n++)
        job.map->filled[n] = job.field[n * job.fields + job.f];
}

static void reflect_field(void *data, rsv_span span)
{
    const field_job job = *(const field_job *)data;
    const rsv_rgb *albedo = job.map->albedo, *scattered = job.map->scattered;
    for (size_t n = span.begin; n < span.end; n++)
        job.exitance[n * job.fields + job.f] = rgb_mul(albedo[n], scattered[n]);
}

/// Exitance of all nodes: hanging ones filled in, then diffused below the surface, then K's albedo.
static void scatter(rsv_transport_map *m, size_t fields, const rsv_rgb *field, rsv_rgb *exitance)
{
    field_job job = { m, fields, 0, field, exitance };
    for (; job.f < fields; job.f++) {
        for_nodes(m, take_field, &job);
        rsv_elements_constrain(m->elements, m->filled);
        rsv_subsurface_apply(m->subsurface, m->elements, m->filled, m->scattered);
        for_nodes(m, reflect_field, &job);
    }
}

static void apply(void *data, size_t columns, const float *field, float *image)
{
    rsv_transport_map *m = data;
    size_t fields = columns / 3;
    if (rsv_device_map_apply(m->device, fields, rgb_field(field), (rsv_rgb *)image)) return;
    scatter(m, fields, rgb_field(field), m->exitance);
    rsv_transport_gather(m->transport, fields, m->exitance, 0, m->linear.count, (rsv_rgb *)image);
}

static void residual(
    void *data, size_t columns, const float *source, const float *field, float *difference)
{
    rsv_transport_map *m = data;
    size_t fields = columns / 3;
    if (rsv_device_map_residual(
            m->device, fields, rgb_field(source), rgb_field(field), (rsv_rgb *)difference))
        return;
    scatter(m, fields, rgb_field(field), m->exitance);
    rsv_transport_residual(m->transport, fields, m->exitance, rgb_field(source), rgb_field(field),
        (rsv_rgb *)difference);
}

/// P*, the transpose of the scattering below surfaces, on one field after the other.
static void diffuse_transpose(rsv_transport_map *m, size_t fields, rsv_rgb *all)
{
    for (size_t f = 0; f < fields; f++) {
        for (size_t n = 0; n < m->linear.count; n++)
            m->scattered[n] = all[n * fields + f];
        rsv_subsurface_apply_transpose(m->subsurface, m->elements, m->scattered, m->filled);
        for (size_t n = 0; n < m->linear.count; n++)
            all[n * fields + f] = m->filled[n];
    }
}

static void reflect_all(void *data, rsv_span span)
{
    const field_job job = *(const field_job *)data;
    const rsv_rgb *albedo = job.map->albedo;
    for (size_t n = span.begin; n < span.end; n++)
        for (size_t k = n * job.fields; k < (n + 1) * job.fields; k++)
            job.exitance[k] = rgb_mul(albedo[n], job.exitance[k]);
}

/// K* G*.
static void apply_transpose(void *data, size_t columns, const float *field, float *image)
{
    rsv_transport_map *m = data;
    size_t fields = columns / 3;
    rsv_rgb *all = (rsv_rgb *)image;
    rsv_transport_apply_transpose(m->columns, fields, rgb_field(field), m->exitance, all);
    for_nodes(m, reflect_all, &(field_job){ .map = m, .fields = fields, .exitance = all });
    if (m->subsurface) diffuse_transpose(m, fields, all);
    rsv_elements_constrain_transpose(m->elements, fields, all);
}

/// A part of the rows omits what depends on others: hanging nodes and translucent bodies.
static void scatter_rows(
    void *data, size_t columns, const float *field, size_t begin, size_t end, float *scattered)
{
    rsv_transport_map *m = data;
    size_t fields = columns / 3;
    rsv_rgb *exitance = (rsv_rgb *)scattered;
    if (begin == 0 && end == m->linear.count) {
        scatter(m, fields, rgb_field(field), exitance);
        return;
    }
    const rsv_subsurface *p = m->subsurface;
    for (size_t n = begin; n < end; n++) {
        if (m->elements->node_hanging[n] != RSV_NONE ||
            (p && p->row_begin[n] != p->row_begin[n + 1]))
            continue;
        for (size_t f = 0; f < fields; f++)
            exitance[n * fields + f] = rgb_mul(m->albedo[n], rgb_field(field)[n * fields + f]);
    }
}

static void gather_rows(
    void *data, size_t columns, const float *scattered, size_t begin, size_t end, float *image)
{
    const rsv_transport_map *m = data;
    rsv_transport_gather(
        m->transport, columns / 3, rgb_field(scattered), begin, end, (rsv_rgb *)image);
}

/// Shoots from a node and from the hanging nodes that follow it. @return entries read
static size_t shoot_node(
    const rsv_transport_map *m, size_t node, rsv_rgb amount, size_t fields, rsv_rgb *irradiance)
{
    size_t entries =
        rsv_transport_shoot(m->columns, node, rgb_mul(m->albedo[node], amount), fields, irradiance);
    for (uint32_t k = m->child_begin[node]; k < m->child_begin[node + 1]; k++) {
        const rsv_hanging *h = &m->elements->hanging[m->child[k] / RSV_PARENTS];
        rsv_rgb part = rgb_scale(amount, h->weight[m->child[k] % RSV_PARENTS]);
        entries += shoot_node(m, h->node, part, fields, irradiance);
    }
    return entries;
}

static double shoot(void *data, size_t columns, size_t node, const float *amount, float *field)
{
    const rsv_transport_map *m = data;
    size_t fields = columns / 3, entries = 0, all = rsv_transport_entries(m->transport);
    for (size_t f = 0; f < fields; f++)
        entries += shoot_node(m, node, rgb_field(amount)[f], fields, (rsv_rgb *)field + f);
    return all ? (double)entries / ((double)all * (double)fields) : 0;
}

static void add_entry(double *sums, size_t groups, uint32_t group, rsv_rgb value)
{
    size_t channel = groups * groups;
    sums[group] += (double)value.r;
    sums[channel + group] += (double)value.g;
    sums[2 * channel + group] += (double)value.b;
}

/// The entries of one row, into the row of its group.
static void sum_row(const rsv_transport_map *m, size_t row, double *sums)
{
    const rsv_transport *t = m->transport;
    size_t groups = m->linear.group_count;
    double *own = sums + m->linear.group[row] * groups;
    rsv_transport_row entry = rsv_transport_row_at(t, row);
    for (size_t k = 0; k < entry.count; k++) {
        uint32_t node = entry.column[k];
        add_entry(own, groups, m->place[node], rgb_scale(m->albedo[node], t->scale[row]));
    }
    for (size_t k = 0; k < entry.tinted_count; k++) {
        uint32_t node = entry.tinted_column[k];
        rsv_rgb albedo = rgb_mul(m->albedo[node], entry.tinted_weight[k]);
        add_entry(own, groups, m->place[node], rgb_scale(albedo, t->scale[row]));
    }
}

enum { STRIPES = 16 };

typedef struct group_sums {
    const rsv_transport_map *map;
    double *sums;
} group_sums;

static void sum_stripes(void *job, rsv_span span)
{
    const group_sums *g = job;
    const rsv_linear_map *linear = &g->map->linear;
    for (size_t stripe = span.begin; stripe < span.end; stripe++)
        for (size_t row = 0; row < linear->count; row++)
            if (linear->group[row] != RSV_NONE && linear->group[row] % STRIPES == stripe)
                sum_row(g->map, row, g->sums);
}

/// Light that leaves a translucent body is taken to leave where it entered: close enough between groups. Workers take
/// stripes of groups and go through all rows for them: each sum has the order of the rows.
static void sum_groups(void *data, double *sums)
{
    const rsv_transport_map *m = data;
    rsv_parallel_for(m->linear.context, STRIPES, 1, sum_stripes, &(group_sums){ m, sums });
}

/// One RGB field after the other.
static rsv_status correct_by_krylov(
    void *data, size_t columns, const float *residual, rsv_correction *wanted, float *correction)
{
    rsv_transport_map *m = data;
    size_t fields = columns / 3, nodes = m->linear.count;
    const struct rsv_krylov_table *krylov = rsv_context_team(m->linear.context)->table->krylov;
    char message[RSV_MESSAGE_BYTES];
    wanted->applications = 0;
    wanted->converged = true;
    for (size_t f = 0; f < fields; f++) {
        rsv_krylov_report report;
        for (size_t n = 0; n < nodes; n++)
            m->filled[n] = rgb_field(residual)[n * fields + f];
        rsv_status status =
            krylov->solve(m->krylov, m->filled, wanted->relative, m->exitance, &report, message);
        if (status != RSV_OK) return rsv_fail(status, "solve: %s", message);
        for (size_t n = 0; n < nodes; n++)
            ((rsv_rgb *)correction)[n * fields + f] = m->exitance[n];
        wanted->applications += report.applications / (double)fields;
        wanted->converged = wanted->converged && report.converged;
    }
    return RSV_OK;
}

/// K on one field, for PETSc.
static void scatter_whole(void *user, const rsv_rgb *field, rsv_rgb *exitance)
{
    scatter(user, 1, field, exitance);
}

static void report_traffic(const rsv_transport_map *m, const rsv_team *team)
{
    rsv_context *context = m->linear.context;
    rsv_krylov_traffic own = team->table->krylov->traffic(m->krylov);
    uint64_t received = rsv_team_total(context, own.received);
    uint64_t senders = rsv_team_total(context, own.senders);
    if (team->size > 1)
        rsv_log(context, RSV_LOG_INFO,
            "solve: one application of the operator sends %llu numbers in %llu messages between "
            "%u processes",
            (unsigned long long)received, (unsigned long long)senders, team->size);
}

static rsv_status add_krylov(rsv_transport_map *m)
{
    rsv_team *team = rsv_context_team(m->linear.context);
    char message[RSV_MESSAGE_BYTES];
    if (m->krylov) return RSV_OK;
    if (!team)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "solve: solver 'petsc' requires a context with a team, which may have one process");
    const rsv_krylov_system system = { .team = team,
        .transport = m->transport,
        .elements = m->elements,
        .albedo = m->albedo,
        .context = m->linear.context,
        .parallel_for = rsv_parallel_for,
        .scatter = m->subsurface ? scatter_whole : NULL,
        .user = m };
    rsv_status status = team->table->krylov->create(&system, &m->krylov, message);
    if (status != RSV_OK) return rsv_fail(status, "solve: %s", message);
    report_traffic(m, team);
    return rsv_team_meet(m->linear.context, rsv_progress(m->linear.context, "solve", 0));
}

/// The same on the device.
static rsv_status correct_on_device(
    void *data, size_t columns, const float *residual, rsv_correction *wanted, float *correction)
{
    rsv_transport_map *m = data;
    rsv_device_solve solve = { .solver = m->device_solver,
        .relative = wanted->relative,
        .max_applications = wanted->applications };
    RSV_ASSERT(columns == 3);
    (void)columns;
    rsv_status status =
        rsv_device_map_solve(m->device, &solve, rgb_field(residual), (rsv_rgb *)correction);
    m->linear.outside = rsv_device_map_solves(m->device, m->device_solver);
    wanted->applications = solve.applications;
    wanted->converged = solve.converged;
    return status;
}

static const rsv_linear_map_table rows_only = { .apply = apply,
    .residual = residual,
    .scatter_rows = scatter_rows,
    .gather_rows = gather_rows,
    .sum_groups = sum_groups };

rsv_status rsv_transport_map_create(const rsv_elements *elements, rsv_transport *transport,
    rsv_subsurface *subsurface, const rsv_rgb *albedo, size_t fields, rsv_transport_map **map)
{
    rsv_context *context = elements->context;
    rsv_status status = RSV_OK;
    size_t nodes = elements->node_count;
    rsv_transport_map *m = rsv_alloc(context, 1, sizeof *m);
    if (!m) return RSV_ERROR_MEMORY;
    m->linear =
        (rsv_linear_map){ .context = context, .table = &m->table, .data = m, .count = nodes };
    m->table = rows_only;
    m->transport = transport;
    m->elements = elements;
    m->albedo = albedo;
    m->subsurface = subsurface;
    m->fields = fields;
    m->filled = rsv_alloc(context, nodes, sizeof *m->filled);
    m->scattered = rsv_alloc(context, nodes, sizeof *m->scattered);
    m->exitance = rsv_alloc(context, nodes, fields * sizeof *m->exitance);
    if (!m->filled || !m->scattered || !m->exitance) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(rsv_device_map_create(elements, transport, subsurface, albedo, &m->device));
    *map = m;
    m = NULL;
cleanup:
    rsv_transport_map_destroy(m);
    return status;
}

/// Lists hanging nodes by their parents, as RSV_PARENTS x index + which parent.
static rsv_status list_children(rsv_transport_map *m)
{
    const rsv_elements *e = m->elements;
    rsv_context *context = m->linear.context;
    size_t links = RSV_PARENTS * e->hanging_count;
    uint32_t *begin = m->child_begin = rsv_alloc(context, e->node_count + 2, sizeof *begin);
    m->child = rsv_alloc(context, links, sizeof *m->child);
    if (!begin || !m->child) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < links; k++) {
        const rsv_hanging *h = &e->hanging[k / RSV_PARENTS];
        begin[h->parent[k % RSV_PARENTS] + 2] += h->weight[k % RSV_PARENTS] > 0;
    }
    for (size_t n = 0; n <= e->node_count; n++)
        begin[n + 1] += begin[n];
    // begin[n + 1] now is where n's list starts, and moves to its end as the list fills
    for (size_t k = 0; k < links; k++) {
        const rsv_hanging *h = &e->hanging[k / RSV_PARENTS];
        if (h->weight[k % RSV_PARENTS] > 0)
            m->child[begin[h->parent[k % RSV_PARENTS] + 1]++] = (uint32_t)k;
    }
    return RSV_OK;
}

rsv_status rsv_transport_map_transpose(rsv_transport_map *m)
{
    if (m->columns) return RSV_OK;
    rsv_status status = rsv_transport_complete(m->transport);
    if (status == RSV_OK) status = list_children(m);
    if (status == RSV_OK) status = rsv_transport_columns_create(m->transport, &m->columns);
    if (status != RSV_OK) return status;
    m->table.apply_transpose = apply_transpose;
    if (!m->subsurface) m->table.shoot = shoot; // else light leaves elsewhere than it entered
    return RSV_OK;
}

static rsv_status add_groups(rsv_transport_map *m)
{
    if (m->group) return RSV_OK;
    size_t nodes = m->linear.count;
    m->group = rsv_alloc(m->linear.context, nodes, sizeof *m->group);
    m->place = rsv_alloc(m->linear.context, nodes, sizeof *m->place);
    if (!m->group || !m->place) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_group_nodes(m->elements, m->place, &m->linear.group_count);
    if (status != RSV_OK) return status;
    for (size_t n = 0; n < nodes; n++)
        m->group[n] = m->elements->node_hanging[n] == RSV_NONE ? m->place[n] : RSV_NONE;
    m->linear.group = m->group;
    return RSV_OK;
}

rsv_status rsv_transport_map_prepare(rsv_transport_map *m, rsv_solver solver)
{
    m->linear.outside = m->fields == 1 && rsv_device_map_solves(m->device, solver);
    if (m->linear.outside) {
        m->table.correct = correct_on_device;
        m->device_solver = solver;
        return RSV_OK;
    }
    const rsv_solver_needs needs = rsv_solver_needs_of(solver);
    rsv_status status = RSV_OK;
    if (needs.outside) {
        status = add_krylov(m);
        m->table.correct = correct_by_krylov;
    }
    if (status == RSV_OK && needs.columns) status = rsv_transport_map_transpose(m);
    if (status == RSV_OK && (needs.rows || needs.groups))
        status = rsv_transport_complete(m->transport);
    if (status == RSV_OK && needs.groups) status = add_groups(m);
    return status;
}

void rsv_transport_map_mask(const rsv_transport_map *m, size_t fields, rsv_rgb *field)
{
    for (size_t n = 0; n < m->linear.count; n++)
        if (m->elements->node_hanging[n] != RSV_NONE)
            memset(field + n * fields, 0, fields * sizeof *field);
}

void rsv_transport_map_destroy(rsv_transport_map *m)
{
    if (!m) return;
    rsv_context *context = m->linear.context;
    void *arrays[] = { m->filled, m->scattered, m->exitance, m->group, m->place, m->child_begin,
        m->child };
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        rsv_free(context, arrays[k]);
    rsv_transport_columns_destroy(m->columns);
    rsv_device_map_destroy(m->device);
    if (m->krylov) rsv_context_team(context)->table->krylov->destroy(m->krylov);
    rsv_free(context, m);
}
