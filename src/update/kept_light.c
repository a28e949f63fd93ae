#include "kept_light.h"

#include "../core/parallel.h"
#include "element_keys.h"
#include "moved_elements.h"

#include <string.h>

/// Marks cells that share a node with one where light may be another.
static rsv_status widen(rsv_kept_light *r)
{
    const rsv_elements *e = r->coarse;
    uint8_t *beside = rsv_alloc(e->context, e->node_count, 1);
    if (!beside) return RSV_ERROR_MEMORY;
    for (size_t c = 0; c < e->cell_count; c++)
        for (int k = 0; k < 3; k++)
            beside[e->cell_node[c][k]] |= r->light_changed[c];
    for (size_t c = 0; c < e->cell_count; c++) {
        const uint32_t *node = e->cell_node[c];
        r->changed[c] = beside[node[0]] | beside[node[1]] | beside[node[2]];
    }
    rsv_free(e->context, beside);
    return RSV_OK;
}

/// Light on moved objects has always changed, or is left as it is for now.
static void mark_moved(const rsv_kept_light *r)
{
    const rsv_elements *e = r->coarse;
    for (size_t c = 0; c < e->cell_count; c++) {
        uint8_t moved = r->before->moved[e->face_triangle[e->cell[c].face]];
        if (moved != RSV_MOVE_NONE) r->light_changed[c] = moved == RSV_MOVE_TURN;
    }
}

rsv_status rsv_kept_light_create(const rsv_history *history, const rsv_level_before *before,
    const rsv_elements *coarse, rsv_kept_light **kept)
{
    rsv_status status;
    rsv_kept_light *r = rsv_alloc(coarse->context, 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    r->history = history;
    r->before = before;
    r->coarse = coarse;
    r->changed = rsv_alloc(coarse->context, coarse->cell_count, 1);
    RSV_TRY(r->changed ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(before ? rsv_light_shafts_find_changed(before->shafts, coarse, &r->light_changed)
                   : rsv_history_find_light_changed(history, coarse, &r->light_changed));
    if (before) mark_moved(r);
    RSV_TRY(widen(r));
    *kept = r;
    r = NULL;
cleanup:
    rsv_kept_light_destroy(r);
    return status;
}

void rsv_kept_light_destroy(rsv_kept_light *r)
{
    if (!r) return;
    rsv_context *context = r->coarse->context;
    rsv_free(context, r->light_changed);
    rsv_free(context, r->changed);
    rsv_free(context, r);
}

bool rsv_kept_light_is_changed(const rsv_kept_light *r, const rsv_cell *cell)
{
    return r->changed[rsv_elements_find_around(r->coarse, cell)];
}

static bool was_split(const rsv_kept_light *r, const rsv_elements *e, uint32_t cell)
{
    return r->before ? rsv_level_before_was_split(r->before, e, cell)
                     : rsv_history_was_split(r->history, RSV_HISTORY_FINE, e, cell);
}

typedef struct split_job {
    const rsv_kept_light *light;
    const rsv_elements *elements;
    uint8_t *split;
} split_job;

static void mark_splits(void *data, rsv_span span)
{
    const split_job *job = data;
    const rsv_kept_light *r = job->light;
    const rsv_elements *e = job->elements;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++)
        job->split[c] = was_split(r, e, c) &&
                        !r->light_changed[rsv_elements_find_around(r->coarse, &e->cell[c])];
}

static void choose_as_before(void *user, const rsv_elements *e, uint8_t *split)
{
    const rsv_kept_light *r = user;
    split_job job = { r, e, split };
    rsv_parallel_for(e->context, e->cell_count, 256, mark_splits, &job);
    size_t marked = 0;
    for (size_t c = 0; c < e->cell_count; c++)
        marked += split[c];
    if (e->cell_count + 3 * marked > r->most_cells) memset(split, 0, e->cell_count);
}

rsv_status rsv_kept_light_splits(
    rsv_kept_light *r, size_t most_cells, const rsv_elements *elements, rsv_elements **finer)
{
    r->most_cells = most_cells;
    return rsv_elements_refine_where(elements, choose_as_before, r, finer);
}

static bool is_node_light_changed(const rsv_kept_light *r, const rsv_elements *e, uint32_t node)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (r->light_changed[rsv_elements_find_around(r->coarse, &e->cell[e->support[s] / 4])])
            return true;
    return false;
}

/// Points of the fine level, from the larger number on the coarse one if these agree.
static bool few_points_of(uint32_t valid, uint32_t points, uint16_t *few)
{
    *few = (uint16_t)(valid ? (1u << points) - 1 : 0);
    return valid == 0 || valid == (1u << RSV_SUPPORT_POINTS) - 1;
}

/// Known light of a node, if it is still valid. @param valid out: receiver points that are not buried
static const rsv_history_light *find_light(const rsv_kept_light *r, const rsv_elements *e,
    uint32_t n, uint64_t key, uint32_t points, uint16_t *valid)
{
    const rsv_history_light *fine = rsv_history_find_light(r->history, RSV_HISTORY_FINE, e, n, key);
    const rsv_history_light *then =
        fine ? fine : rsv_history_find_light(r->history, RSV_HISTORY_COARSE, e, n, key);
    if (!then || (!fine && !few_points_of(then->valid, points, valid))) return NULL;
    if (is_node_light_changed(r, e, n)) return NULL; // its points are drawn by another number
    if (fine) *valid = (uint16_t)fine->valid;
    return then;
}

typedef struct node_job {
    const rsv_kept_light *light;
    const rsv_elements *elements;
    const rsv_kept_light_fields *fields;
    const uint64_t *key;        ///< [node_count], if the history knows them
    bool count_all;             ///< lit nodes too
    atomic_uint_least64_t kept; ///< nodes of which it is known
} node_job;

/// As rsv_kept_light_nodes, of the level before.
static void take_nodes(void *data, rsv_span span)
{
    node_job *job = data;
    const rsv_kept_light *r = job->light;
    const rsv_elements *e = job->elements;
    const rsv_kept_light_fields *f = job->fields;
    const rsv_level_before *b = r->before;
    size_t known = 0;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        if (e->node_hanging[n] != RSV_NONE || (f->lit[n] && !job->count_all)) continue;
        if (is_node_light_changed(r, e, n)) continue;
        uint32_t twin = rsv_level_before_find(b, e, n);
        if (twin == RSV_NONE) continue;
        known += b->valid_points[twin] != 0;
        if (f->lit[n]) continue;
        f->known[n] = f->lit[n] = 1;
        f->valid_points[n] = b->valid_points[twin];
        f->direct[n] = b->direct[twin];
        f->deviation[n] = b->deviation[twin];
    }
    atomic_fetch_add(&job->kept, known);
}

/// As rsv_kept_light_nodes, of the history.
static void remember_nodes(void *data, rsv_span span)
{
    node_job *job = data;
    const rsv_elements *e = job->elements;
    const rsv_kept_light_fields *f = job->fields;
    size_t known = 0;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        if (e->node_hanging[n] != RSV_NONE || (f->lit[n] && !job->count_all)) continue;
        uint16_t valid = 0;
        const rsv_history_light *then =
            find_light(job->light, e, n, job->key[n], f->points, &valid);
        if (!then) continue;
        known += valid != 0;
        if (f->lit[n]) continue;
        f->known[n] = f->lit[n] = 1;
        f->valid_points[n] = valid;
        f->direct[n] = then->direct;
        f->deviation[n] = then->deviation;
    }
    atomic_fetch_add(&job->kept, known);
}

rsv_status rsv_kept_light_nodes(
    const rsv_kept_light *r, const rsv_elements *e, const rsv_kept_light_fields *f, size_t *kept)
{
    uint64_t *key = NULL;
    rsv_status status = r->before ? RSV_OK : rsv_node_keys_create(e, &key);
    node_job job = {
        .light = r, .elements = e, .fields = f, .key = key, .count_all = kept != NULL
    };
    if (status == RSV_OK)
        rsv_parallel_for(
            e->context, e->node_count, 256, r->before ? take_nodes : remember_nodes, &job);
    if (kept) *kept = job.kept;
    rsv_free(e->context, key);
    return status;
}

typedef struct direct_job {
    const rsv_history *history;
    const rsv_elements *elements;
    const uint64_t *key;
    const uint8_t *light_changed;
    rsv_rgb *direct;
    uint8_t *known;
} direct_job;

static void remember_direct(void *data, rsv_span span)
{
    const direct_job *job = data;
    const rsv_elements *e = job->elements;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        if (e->node_hanging[n] != RSV_NONE || rsv_node_light_is_changed(e, n, job->light_changed))
            continue;
        const rsv_history_node *then = rsv_history_find_node(job->history, e, n, job->key[n]);
        job->known[n] = then != NULL;
        if (then) job->direct[n] = then->light.direct;
    }
}

rsv_status rsv_kept_direct(
    const rsv_history *history, const rsv_elements *e, rsv_rgb *direct, uint8_t *known)
{
    rsv_status status;
    uint64_t *key = NULL;
    uint8_t *light_changed = NULL;
    RSV_TRY(rsv_node_keys_create(e, &key));
    RSV_TRY(rsv_history_find_light_changed(history, e, &light_changed));
    direct_job job = { history, e, key, light_changed, direct, known };
    rsv_parallel_for(e->context, e->node_count, 256, remember_direct, &job);
cleanup:
    rsv_free(e->context, key);
    rsv_free(e->context, light_changed);
    return status;
}
