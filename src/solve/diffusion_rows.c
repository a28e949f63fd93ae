#include "diffusion_rows.h"

#include "../elements/elements.h"

static bool is_leaf(const rsv_scatter_cluster *c) { return c->right == 0; }

/// Rows of the nodes that have one, in the order of nodes.
static rsv_status list_rows(const rsv_subsurface *p, rsv_diffusion_rows *d)
{
    const rsv_scatter_sources *s = p->sources;
    rsv_context *context = s->context;
    d->node = rsv_alloc(context, p->row_count, sizeof *d->node);
    d->row_begin = rsv_alloc(context, p->row_count + 1, sizeof *d->row_begin);
    if (!d->node || !d->row_begin) return RSV_ERROR_MEMORY;
    for (uint32_t n = 0; n < p->row_count; n++) {
        bool has_row =
            s->elements->node_hanging[n] == RSV_NONE && rsv_scatter_body_of(s, n) != RSV_NONE;
        if (!has_row) continue;
        d->node[d->row_count++] = n;
        d->row_begin[d->row_count] = p->row_begin[n + 1]; // nodes without a row have no entries
    }
    d->column = p->column;
    d->weight = p->weight;
    return RSV_OK;
}

/// Levels from the leaves up. @param level out, [cluster_count]
static void find_levels(const rsv_scatter_sources *s, uint32_t *level, size_t *level_count)
{
    *level_count = 0;
    for (size_t i = s->cluster_count; i-- > 0;) { // children come after their parents
        const rsv_scatter_cluster *c = &s->cluster[i];
        uint32_t left = is_leaf(c) ? 0 : level[i + 1] + 1;
        uint32_t right = is_leaf(c) ? 0 : level[c->right] + 1;
        level[i] = left > right ? left : right;
        if (level[i] >= *level_count) *level_count = level[i] + 1;
    }
}

static void sort_by_level(const uint32_t *level, size_t first, rsv_diffusion_rows *d)
{
    for (size_t i = 0; i < d->mean_count; i++)
        d->level_begin[level[i] + 1]++;
    for (size_t l = 0; l < d->level_count; l++)
        d->level_begin[l + 1] += d->level_begin[l];
    for (size_t i = 0; i < d->mean_count; i++)
        d->mean[d->level_begin[level[i]]++] = (uint32_t)(first + i);
    for (size_t l = d->level_count; l > 0; l--) // each begin has moved to the next
        d->level_begin[l] = d->level_begin[l - 1];
    d->level_begin[0] = 0;
}

static void add_source(rsv_diffusion_rows *d, size_t *at, size_t source, float share)
{
    d->source[*at] = (uint32_t)source;
    d->share[(*at)++] = share;
}

/// Adds the sources of a cluster's mean: corners of its cells, or its children by their areas.
static void add_sources(
    const rsv_scatter_sources *s, uint32_t cluster, rsv_diffusion_rows *d, size_t *at)
{
    const rsv_scatter_cluster *c = &s->cluster[cluster];
    size_t first = s->elements->node_count;
    if (!is_leaf(c)) {
        float left = s->cluster[cluster + 1].area, right = s->cluster[c->right].area;
        float share = left + right > 0 ? left / (left + right) : 0;
        add_source(d, at, first + cluster + 1, share);
        add_source(d, at, first + c->right, 1 - share);
        return;
    }
    float scale = c->area > 0 ? 1 / (3 * c->area) : 0;
    for (uint32_t k = c->first_cell; k < c->first_cell + c->cell_count; k++)
        for (int corner = 0; corner < 3; corner++)
            add_source(d, at, s->elements->cell_node[s->cell[k]][corner],
                scale * rsv_cell_area(s->elements, s->cell[k]));
}

static rsv_status list_means(const rsv_scatter_sources *s, rsv_diffusion_rows *d)
{
    rsv_context *context = s->context;
    size_t most = 3 * s->cell_count + 2 * s->cluster_count, at = 0;
    rsv_status status = RSV_OK;
    uint32_t *level = rsv_alloc(context, s->cluster_count, sizeof *level);
    RSV_TRY(level ? RSV_OK : RSV_ERROR_MEMORY);
    d->mean_count = s->cluster_count;
    find_levels(s, level, &d->level_count);
    d->mean = rsv_alloc(context, d->mean_count, sizeof *d->mean);
    d->mean_begin = rsv_alloc(context, d->mean_count + 1, sizeof *d->mean_begin);
    d->level_begin = rsv_alloc(context, d->level_count + 1, sizeof *d->level_begin);
    d->source = rsv_alloc(context, most, sizeof *d->source);
    d->share = rsv_alloc(context, most, sizeof *d->share);
    RSV_TRY(d->mean && d->mean_begin && d->level_begin && d->source && d->share ? RSV_OK
                                                                                : RSV_ERROR_MEMORY);
    sort_by_level(level, s->elements->node_count, d);
    for (size_t k = 0; k < d->mean_count; k++) {
        add_sources(s, d->mean[k] - (uint32_t)s->elements->node_count, d, &at);
        d->mean_begin[k + 1] = (uint32_t)at;
    }
cleanup:
    rsv_free(context, level);
    return status;
}

rsv_status rsv_diffusion_rows_create(const rsv_subsurface *p, rsv_diffusion_rows *rows)
{
    *rows = (rsv_diffusion_rows){ 0 };
    rsv_status status = list_rows(p, rows);
    if (status == RSV_OK) status = list_means(p->sources, rows);
    if (status != RSV_OK) rsv_diffusion_rows_destroy(p->sources->context, rows);
    return status;
}

void rsv_diffusion_rows_destroy(rsv_context *context, rsv_diffusion_rows *rows)
{
    void *arrays[] = { rows->node, rows->row_begin, rows->mean, rows->mean_begin, rows->source,
        rows->share, rows->level_begin };
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        rsv_free(context, arrays[k]);
    *rows = (rsv_diffusion_rows){ 0 };
}
