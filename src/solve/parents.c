#include "parents.h"

/// Free nodes that a node's value comes from, and their weights.
typedef struct mean {
    uint32_t *node;
    float *weight;
    size_t count, node_capacity, weight_capacity;
} mean;

static rsv_status add(rsv_context *context, mean *m, size_t first, uint32_t node, float weight)
{
    for (size_t k = first; k < m->count; k++)
        if (m->node[k] == node) {
            m->weight[k] += weight;
            return RSV_OK;
        }
    rsv_status status =
        rsv_grow(context, (void **)&m->node, &m->node_capacity, m->count + 1, sizeof *m->node);
    if (status == RSV_OK)
        status = rsv_grow(
            context, (void **)&m->weight, &m->weight_capacity, m->count + 1, sizeof *m->weight);
    if (status != RSV_OK) return status;
    m->node[m->count] = node;
    m->weight[m->count++] = weight;
    return RSV_OK;
}

/// The mean of a hanging node, of parents whose own means are known.
static rsv_status add_parents(
    const rsv_elements *e, const rsv_hanging *h, const size_t *begin, mean *m)
{
    size_t first = m->count;
    for (int p = 0; p < RSV_PARENTS; p++) {
        uint32_t own = e->node_hanging[h->parent[p]];
        if (h->weight[p] == 0) continue;
        size_t from = own == RSV_NONE ? 0 : begin[own], to = own == RSV_NONE ? 0 : begin[own + 1];
        rsv_status status =
            own == RSV_NONE ? add(e->context, m, first, h->parent[p], h->weight[p]) : RSV_OK;
        for (size_t k = from; k < to && status == RSV_OK; k++)
            status = add(e->context, m, first, m->node[k], h->weight[p] * m->weight[k]);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

/// Means by hanging node, put into the order of nodes.
static rsv_status sort_by_node(
    const rsv_elements *e, const mean *m, const size_t *begin, rsv_parents *parents)
{
    size_t at = 0;
    parents->begin = rsv_alloc(e->context, e->node_count + 1, sizeof *parents->begin);
    parents->node = rsv_alloc(e->context, m->count, sizeof *parents->node);
    parents->weight = rsv_alloc(e->context, m->count, sizeof *parents->weight);
    if (!parents->begin || !parents->node || !parents->weight) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < e->node_count; n++) {
        uint32_t h = e->node_hanging[n];
        for (size_t k = h == RSV_NONE ? 0 : begin[h]; h != RSV_NONE && k < begin[h + 1]; k++) {
            parents->node[at] = m->node[k];
            parents->weight[at++] = m->weight[k];
        }
        parents->begin[n + 1] = (uint32_t)at;
    }
    return RSV_OK;
}

rsv_status rsv_parents_create(const rsv_elements *e, rsv_parents *parents)
{
    rsv_status status = RSV_OK;
    mean m = { 0 };
    size_t *begin = rsv_alloc(e->context, e->hanging_count + 1, sizeof *begin);
    *parents = (rsv_parents){ 0 };
    RSV_TRY(begin ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t h = 0; h < e->hanging_count; h++) { // parents before children
        RSV_TRY(add_parents(e, &e->hanging[h], begin, &m));
        begin[h + 1] = m.count;
    }
    RSV_TRY(sort_by_node(e, &m, begin, parents));
cleanup:
    if (status != RSV_OK) rsv_parents_destroy(e->context, parents);
    rsv_free(e->context, m.node);
    rsv_free(e->context, m.weight);
    rsv_free(e->context, begin);
    return status;
}

void rsv_parents_destroy(rsv_context *context, rsv_parents *parents)
{
    rsv_free(context, parents->begin);
    rsv_free(context, parents->node);
    rsv_free(context, parents->weight);
    *parents = (rsv_parents){ 0 };
}
