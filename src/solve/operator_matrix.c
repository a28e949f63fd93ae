/// The factors of G K as sparse matrices, for other linear algebra.
#include "operator.h"

#include <string.h>

/// A matrix that grows row by row, at its end or, where rows are found in another order, by parts.
typedef struct matrix_rows {
    rsv_sparse_matrix *matrix;
    size_t row; ///< in hand
    size_t column_capacity, weight_capacity;
} matrix_rows;

static rsv_status begin(
    const rsv_operator_view *op, size_t row_count, size_t column_count, matrix_rows *rows)
{
    rsv_sparse_matrix *m = rsv_alloc(op->context, 1, sizeof *m);
    *rows = (matrix_rows){ .matrix = m };
    if (!m) return RSV_ERROR_MEMORY;
    m->context = op->context;
    m->row_count = row_count;
    m->column_count = column_count;
    m->row_start = rsv_alloc(op->context, row_count + 1, sizeof *m->row_start);
    return m->row_start ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Allocates memory for further entries.
static rsv_status reserve(matrix_rows *rows, size_t count)
{
    rsv_sparse_matrix *m = rows->matrix;
    size_t needed = m->row_start[rows->row] + count;
    rsv_status status = rsv_grow(
        m->context, (void **)&m->column, &rows->column_capacity, needed, sizeof *m->column);
    if (status != RSV_OK) return status;
    return rsv_grow(
        m->context, (void **)&m->weight, &rows->weight_capacity, needed, sizeof *m->weight);
}

/// Adds an entry to the row in hand; there is room for it. The next row's start is where it ends so far.
static void add_entry(matrix_rows *rows, size_t *end, uint32_t column, float weight)
{
    rows->matrix->column[*end] = column;
    rows->matrix->weight[*end] = weight;
    ++*end;
}

static void end_row(matrix_rows *rows, size_t end) { rows->matrix->row_start[++rows->row] = end; }

static rsv_status add_unit_row(matrix_rows *rows)
{
    rsv_status status = reserve(rows, 1);
    size_t end = rows->matrix->row_start[rows->row];
    if (status != RSV_OK) return status;
    add_entry(rows, &end, (uint32_t)rows->row, 1);
    end_row(rows, end);
    return RSV_OK;
}

static float channel_of(rsv_rgb value, uint32_t channel)
{
    return channel == 0 ? value.r : channel == 1 ? value.g : value.b;
}

// ---- G --------------------------------------------------------------------------------------------

static rsv_status find_propagation(const rsv_operator_view *op, uint32_t channel, matrix_rows *rows)
{
    rsv_transport *t = op->transport;
    rsv_status status = rsv_transport_complete(t);
    if (status == RSV_OK) status = begin(op, t->row_count, t->row_count, rows);
    for (size_t r = 0; status == RSV_OK && r < t->row_count; r++) {
        rsv_transport_row row = rsv_transport_row_at(t, r);
        float scale = t->scale[r];
        status = reserve(rows, row.count + row.tinted_count);
        if (status != RSV_OK) break;
        size_t end = rows->matrix->row_start[r];
        for (size_t k = 0; k < row.count; k++)
            add_entry(rows, &end, row.column[k], scale);
        for (size_t k = 0; k < row.tinted_count; k++)
            add_entry(rows, &end, row.tinted_column[k],
                scale * channel_of(row.tinted_weight[k], channel));
        end_row(rows, end);
    }
    return status;
}

// ---- C --------------------------------------------------------------------------------------------

/// A hanging node's value in terms of free nodes. Hanging parents have their rows already.
static rsv_status add_hanging_row(
    const rsv_elements *e, const matrix_rows *parents, size_t index, matrix_rows *rows)
{
    const rsv_hanging *h = &e->hanging[index];
    const rsv_sparse_matrix *known = parents->matrix;
    rsv_status status = RSV_OK;
    size_t end = rows->matrix->row_start[rows->row];
    for (int p = 0; p < RSV_PARENTS && status == RSV_OK; p++) {
        uint32_t of_parent = e->node_hanging[h->parent[p]];
        if (!(h->weight[p] > 0)) continue;
        size_t first = of_parent == RSV_NONE ? 0 : known->row_start[of_parent];
        size_t last = of_parent == RSV_NONE ? 1 : known->row_start[of_parent + 1];
        status = reserve(rows, end - rows->matrix->row_start[rows->row] + last - first);
        for (size_t k = first; status == RSV_OK && k < last; k++)
            add_entry(rows, &end, of_parent == RSV_NONE ? h->parent[p] : known->column[k],
                of_parent == RSV_NONE ? h->weight[p] : h->weight[p] * known->weight[k]);
    }
    if (status == RSV_OK) end_row(rows, end);
    return status;
}

static rsv_status find_interpolation(const rsv_operator_view *op, matrix_rows *rows)
{
    const rsv_elements *e = op->elements;
    rsv_status status;
    matrix_rows hanging = { 0 }; // row by row in the order of e->hanging
    RSV_TRY(begin(op, e->hanging_count, e->node_count, &hanging));
    for (size_t h = 0; h < e->hanging_count; h++)
        RSV_TRY(add_hanging_row(e, &hanging, h, &hanging));
    RSV_TRY(begin(op, e->node_count, e->node_count, rows));
    for (size_t n = 0; n < e->node_count; n++) {
        if (e->node_hanging[n] == RSV_NONE)
            RSV_TRY(add_unit_row(rows));
        else
            RSV_TRY(add_hanging_row(e, &hanging, e->node_hanging[n], rows));
    }
cleanup:
    rsv_sparse_matrix_destroy(hanging.matrix);
    return status;
}

// ---- S and M --------------------------------------------------------------------------------------

static size_t cluster_count(const rsv_operator_view *op)
{
    return op->subsurface ? op->subsurface->sources->cluster_count : 0;
}

static rsv_status find_subsurface(const rsv_operator_view *op, uint32_t channel, matrix_rows *rows)
{
    const rsv_subsurface *p = op->subsurface;
    size_t nodes = op->elements->node_count;
    rsv_status status = begin(op, nodes, nodes + cluster_count(op), rows);
    for (size_t n = 0; status == RSV_OK && n < nodes; n++) {
        if (!p || !rsv_subsurface_has_row(p, (uint32_t)n)) {
            status = add_unit_row(rows);
            continue;
        }
        status = reserve(rows, p->row_begin[n + 1] - p->row_begin[n]);
        if (status != RSV_OK) break;
        size_t end = rows->matrix->row_start[n];
        for (size_t k = p->row_begin[n]; k < p->row_begin[n + 1]; k++)
            add_entry(rows, &end, p->column[k], channel_of(p->weight[k], channel));
        end_row(rows, end);
    }
    return status;
}

/// The mean over the cells of a cluster: of each, the mean of its corners, by area.
static rsv_status add_cluster_row(
    const rsv_scatter_sources *s, const rsv_scatter_cluster *cluster, matrix_rows *rows)
{
    const rsv_elements *e = s->elements;
    double area = 0;
    rsv_status status = reserve(rows, 3 * (size_t)cluster->cell_count);
    if (status != RSV_OK) return status;
    size_t end = rows->matrix->row_start[rows->row];
    const uint32_t *cell = s->cell + cluster->first_cell;
    for (uint32_t k = 0; k < cluster->cell_count; k++)
        area += (double)rsv_cell_area(e, cell[k]);
    for (uint32_t k = 0; k < cluster->cell_count; k++)
        for (int corner = 0; corner < 3; corner++)
            add_entry(rows, &end, e->cell_node[cell[k]][corner],
                area > 0 ? (float)((double)rsv_cell_area(e, cell[k]) / 3 / area) : 0);
    end_row(rows, end);
    return RSV_OK;
}

static rsv_status find_clusters(const rsv_operator_view *op, matrix_rows *rows)
{
    size_t nodes = op->elements->node_count, clusters = cluster_count(op);
    rsv_status status = begin(op, nodes + clusters, nodes, rows);
    for (size_t n = 0; status == RSV_OK && n < nodes; n++)
        status = add_unit_row(rows);
    for (size_t c = 0; status == RSV_OK && c < clusters; c++)
        status =
            add_cluster_row(op->subsurface->sources, &op->subsurface->sources->cluster[c], rows);
    return status;
}

// ---- one of them ----------------------------------------------------------------------------------

static rsv_status find_factor(
    const rsv_operator_view *op, rsv_operator_factor factor, uint32_t channel, matrix_rows *rows)
{
    switch (factor) {
    case RSV_FACTOR_INTERPOLATION:
        return find_interpolation(op, rows);
    case RSV_FACTOR_PROPAGATION:
        return find_propagation(op, channel, rows);
    case RSV_FACTOR_SUBSURFACE:
        return find_subsurface(op, channel, rows);
    case RSV_FACTOR_CLUSTERS:
        return find_clusters(op, rows);
    }
    return rsv_fail(RSV_ERROR_ARGUMENT, "operator: there is no factor %d", (int)factor);
}

rsv_status rsv_operator_matrix(const rsv_operator *op, rsv_operator_factor factor, uint32_t channel,
    rsv_sparse_matrix **matrix)
{
    matrix_rows rows = { 0 };
    if (channel > 2)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "operator: colour channel %u; there are 0, 1 and 2", channel);
    rsv_status status = find_factor(rsv_operator_get_view(op), factor, channel, &rows);
    if (status == RSV_OK)
        status = reserve(&rows, 1); // arrays that exist, even if nothing is in them
    if (status == RSV_OK)
        *matrix = rows.matrix;
    else
        rsv_sparse_matrix_destroy(rows.matrix);
    return status;
}

void rsv_sparse_matrix_destroy(rsv_sparse_matrix *matrix)
{
    if (!matrix) return;
    rsv_context *context = matrix->context;
    rsv_free(context, matrix->row_start);
    rsv_free(context, matrix->column);
    rsv_free(context, matrix->weight);
    rsv_free(context, matrix);
}
