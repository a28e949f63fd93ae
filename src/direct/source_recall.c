#include "source_recall.h"

#include "../elements/element_keys.h"
#include "../elements/elements.h"
#include "direct.h"
#include "source_level.h"

#include <string.h>

/// Marks cells that share a node with one where light may be another.
static rsv_status widen(rsv_source_recall *r)
{
    const rsv_elements *e = r->coarse;
    uint8_t *beside = rsv_alloc(e->context, e->node_count, 1);
    if (!beside) return RSV_ERROR_MEMORY;
    for (size_t c = 0; c < e->cell_count; c++)
        for (int k = 0; k < 3; k++)
            beside[e->cell_node[c][k]] |= r->lit_anew[c];
    for (size_t c = 0; c < e->cell_count; c++) {
        const uint32_t *node = e->cell_node[c];
        r->anew[c] = beside[node[0]] | beside[node[1]] | beside[node[2]];
    }
    rsv_free(e->context, beside);
    return RSV_OK;
}

rsv_status rsv_source_recall_create(
    const rsv_past *past, const rsv_elements *coarse, rsv_source_recall **recall)
{
    rsv_status status;
    rsv_source_recall *r = rsv_alloc(coarse->context, 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    r->past = past;
    r->coarse = coarse;
    r->anew = rsv_alloc(coarse->context, coarse->cell_count, 1);
    RSV_TRY(r->anew ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_past_find_lit_anew(past, coarse, &r->lit_anew));
    RSV_TRY(widen(r));
    *recall = r;
    r = NULL;
cleanup:
    rsv_source_recall_destroy(r);
    return status;
}

void rsv_source_recall_destroy(rsv_source_recall *r)
{
    if (!r) return;
    rsv_context *context = r->coarse->context;
    rsv_free(context, r->lit_anew);
    rsv_free(context, r->anew);
    rsv_free(context, r);
}

bool rsv_source_recall_is_anew(const rsv_source_recall *r, const rsv_cell *cell)
{
    return r->anew[rsv_elements_find_around(r->coarse, cell)];
}

static void choose_as_then(void *user, const rsv_elements *e, uint8_t *split)
{
    const rsv_source_recall *r = user;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++)
        split[c] = rsv_past_was_cell_split(r->past, RSV_PAST_FINE, e, c) &&
                   !r->lit_anew[rsv_elements_find_around(r->coarse, &e->cell[c])];
    size_t marked = 0;
    for (size_t c = 0; c < e->cell_count; c++)
        marked += split[c];
    if (e->cell_count + 3 * marked > r->most_cells) memset(split, 0, e->cell_count);
}

rsv_status rsv_source_recall_splits(
    rsv_source_recall *r, size_t most_cells, const rsv_elements *elements, rsv_elements **finer)
{
    r->most_cells = most_cells;
    return rsv_elements_refine_where(elements, choose_as_then, r, finer);
}

static bool is_node_lit_anew(const rsv_source_recall *r, const rsv_elements *e, uint32_t node)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (r->lit_anew[rsv_elements_find_around(r->coarse, &e->cell[e->support[s] / 4])])
            return true;
    return false;
}

/// Points of the fine level, told by the many more of the coarse one where these agree.
static bool few_points_of(uint32_t valid, uint16_t *few)
{
    const uint16_t all = (1u << RSV_LEVEL_POINTS) - 1;
    *few = valid ? all : 0;
    return valid == 0 || valid == (1u << RSV_SUPPORT_POINTS) - 1;
}

rsv_status rsv_source_recall_nodes(
    const rsv_source_recall *r, const rsv_elements *e, const rsv_recalled_fields *f)
{
    uint64_t *key = NULL;
    rsv_status status = rsv_node_keys_create(e, &key);
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (status != RSV_OK || e->node_hanging[n] != RSV_NONE || f->lit[n]) continue;
        uint16_t few = 0;
        const rsv_past_light *fine = rsv_past_find_light(r->past, RSV_PAST_FINE, e, n, key[n]);
        const rsv_past_light *then =
            fine ? fine : rsv_past_find_light(r->past, RSV_PAST_COARSE, e, n, key[n]);
        if (!then || (!fine && !few_points_of(then->valid, &few))) continue;
        if (is_node_lit_anew(r, e, n)) continue; // its points are drawn by another number
        f->known[n] = f->lit[n] = 1;
        f->valid_points[n] = fine ? (uint16_t)fine->valid : few;
        f->direct[n] = then->direct;
        f->deviation[n] = then->deviation;
    }
    rsv_free(e->context, key);
    return status;
}
