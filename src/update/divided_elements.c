#include "divided_elements.h"

#include "../core/parallel.h"
#include "../elements/cluster.h"
#include "../elements/contact.h"
#include "../elements/open_corners.h"
#include "level_before.h"

#include <string.h>

typedef struct divider {
    const rsv_elements_before *before;
    rsv_transport_scene scene; ///< with known results
    rsv_light_shafts shafts;   ///< nothing but the change
    rsv_level_before known;
    rsv_known_cells answers;
    rsv_divided_elements *d;
    uint64_t *rays;
} divider;

static void begin(divider *v, const rsv_transport_scene *scene)
{
    const rsv_elements_before *b = v->before;
    v->shafts = (rsv_light_shafts){ .change = b->change };
    v->known = (rsv_level_before){ .elements = b->elements,
        .valid_points = b->valid_points,
        .shafts = &v->shafts,
        .moved = b->moved };
    v->answers = rsv_level_before_answers(&v->known);
    v->scene = *scene;
    v->scene.known_cells = &v->answers;
}

// ---- cells ----------------------------------------------------------------------------------------

/// Whether a cell was cut from the start and left whole: there was no room for its splits.
static bool was_left_whole(const rsv_elements_before *b, const rsv_elements *e, uint32_t cell)
{
    uint32_t then = rsv_elements_find_same_cell(b->first, &e->cell[cell]);
    if (then == RSV_NONE || b->first->cell_openness[then] != e->cell_openness[cell]) return false;
    return rsv_cell_wants_contact_split(b->first, then, b->contact_size);
}

typedef struct split_job {
    const rsv_elements_before *before;
    const rsv_elements *elements;
    uint8_t *split;
    atomic_uint_least64_t count;
} split_job;

static void mark_contacts(void *data, rsv_span span)
{
    split_job *job = data;
    const rsv_elements_before *b = job->before;
    const rsv_elements *e = job->elements;
    size_t count = 0;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++) {
        if (!rsv_cell_wants_contact_split(e, c, b->contact_size)) continue;
        job->split[c] = !was_left_whole(b, e, c);
        count += job->split[c];
    }
    atomic_fetch_add(&job->count, count);
}

/// Marks cells to split, if there is memory for them. @return number of cells
static size_t mark_cells(const divider *v, const rsv_elements *e, uint8_t *split)
{
    split_job job = { .before = v->before, .elements = e, .split = split };
    rsv_parallel_for(e->context, e->cell_count, 256, mark_contacts, &job);
    size_t count = job.count;
    if (e->node_count + RSV_NODES_PER_SPLIT * count <= v->before->most_nodes) return count;
    memset(split, 0, e->cell_count);
    return 0;
}

/// Splits cells until none needs it. Cells that existed before were checked after the motion.
static rsv_status split_cells(const divider *v)
{
    const rsv_elements *coarser = v->before->start, *judged = v->before->elements;
    rsv_context *context = coarser->context;
    rsv_elements *e = NULL;
    rsv_status status = RSV_OK;
    uint8_t *split = rsv_alloc(context, coarser->cell_count, 1);
    size_t marked = split && coarser == judged ? mark_cells(v, coarser, split) : 0;
    do {
        rsv_elements *finer = NULL;
        RSV_TRY(split ? RSV_OK : RSV_ERROR_MEMORY);
        RSV_TRY(rsv_elements_refine(coarser, split, &finer));
        status = rsv_elements_find_open_corners(&v->scene, judged, finer, v->rays);
        rsv_elements_destroy(e);
        judged = coarser = e = finer;
        rsv_free(context, split);
        split = rsv_alloc(context, e->cell_count, 1);
        marked = split ? mark_cells(v, e, split) : 1;
    } while (marked && status == RSV_OK);
cleanup:
    rsv_free(context, split);
    v->d->elements = e;
    return status;
}

// ---- nodes ----------------------------------------------------------------------------------------

/// A number for the position of a node that did not exist originally, independent of the way that led there.
static uint32_t draw_at(const rsv_elements *e, uint32_t node)
{
    uint32_t support = e->support[e->support_begin[node]];
    const rsv_cell *c = &e->cell[support / 4];
    uint32_t place = rsv_hash2(((uint32_t)c->i << 16) | c->j,
        ((uint32_t)c->level << 3) | ((uint32_t)c->flipped << 2) | (support & 3));
    return rsv_hash2(c->face, place);
}

static bool has_support(const rsv_elements *e, uint32_t node)
{
    return e->support_begin[node] < e->support_begin[node + 1];
}

/// Nodes that follow, hang or have no cells are not in the table.
static bool is_free(const rsv_elements *e, uint32_t node)
{
    return e->node_hanging[node] == RSV_NONE && has_support(e, node);
}

typedef struct node_job {
    const divider *divider;
    uint8_t *known;
} node_job;

static void match_nodes(void *data, rsv_span span)
{
    const node_job *job = data;
    const rsv_elements_before *b = job->divider->before;
    rsv_divided_elements *d = job->divider->d;
    const rsv_elements *e = d->elements;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        uint32_t first = has_support(e, n) ? rsv_elements_find_twin(e, n, b->first) : RSV_NONE;
        e->node_draw[n] = first != RSV_NONE   ? rsv_elements_draw_of(b->first, first)
                          : has_support(e, n) ? draw_at(e, n)
                                              : n;
        uint32_t twin = is_free(e, n) ? rsv_elements_find_twin(e, n, b->elements) : RSV_NONE;
        bool same = twin != RSV_NONE && is_free(b->elements, twin) &&
                    rsv_elements_draw_of(b->elements, twin) == e->node_draw[n];
        d->node_before[n] = same ? twin : RSV_NONE;
        d->valid_points[n] = same ? b->valid_points[twin] : 0;
        job->known[n] = same;
    }
}

/// Nodes that receive the same light as before, and the numbers by which points are drawn.
static rsv_status find_nodes(const divider *v, uint8_t *known)
{
    rsv_elements *e = v->d->elements;
    e->node_draw = rsv_alloc(e->context, e->node_count, sizeof *e->node_draw);
    if (!e->node_draw) return RSV_ERROR_MEMORY;
    node_job job = { v, known };
    rsv_parallel_for(e->context, e->node_count, 256, match_nodes, &job);
    return RSV_OK;
}

static rsv_status allocate(rsv_divided_elements *d, size_t nodes_before)
{
    rsv_context *context = d->elements->context;
    size_t nodes = d->elements->node_count;
    d->valid_points = rsv_alloc(context, nodes, sizeof *d->valid_points);
    d->node_before = rsv_alloc(context, nodes, sizeof *d->node_before);
    d->node_now = rsv_reserve(context, nodes_before, sizeof *d->node_now);
    return d->valid_points && d->node_before && d->node_now ? RSV_OK : RSV_ERROR_MEMORY;
}

/// New ends of rays that ended at the old nodes: known if all cells that lead to a node lead to the same new one.
static rsv_status find_ends(const divider *v)
{
    const rsv_elements *then = v->before->elements, *e = v->d->elements;
    uint32_t *now = v->d->node_now;
    uint8_t *lost = rsv_alloc(e->context, then->node_count, 1);
    if (!lost) return RSV_ERROR_MEMORY;
    memset(now, 0xff, then->node_count * sizeof *now);
    for (uint32_t c = 0; c < then->cell_count; c++) {
        uint32_t same = rsv_elements_find_same_cell(e, &then->cell[c]);
        for (int k = 0; k < 3; k++) {
            uint32_t node = then->cell_node[c][k];
            uint32_t other = same == RSV_NONE ? RSV_NONE : e->cell_node[same][k];
            if (now[node] == RSV_NONE) now[node] = other;
            lost[node] = lost[node] || other == RSV_NONE || now[node] != other;
        }
    }
    for (uint32_t n = 0; n < then->node_count; n++)
        if (lost[n]) now[n] = RSV_NONE;
    rsv_free(e->context, lost);
    return RSV_OK;
}

static rsv_status number_nodes(const divider *v)
{
    const rsv_elements_before *b = v->before;
    rsv_divided_elements *d = v->d;
    rsv_elements *e = d->elements;
    rsv_status status;
    uint8_t *known = NULL;
    RSV_TRY(rsv_elements_separate(&v->scene, NULL, e, v->rays));
    if (b->elements->cluster_radius > 0)
        RSV_TRY(rsv_elements_cluster(e, b->elements->cluster_radius));
    RSV_TRY(allocate(d, b->elements->node_count));
    known = rsv_alloc(e->context, e->node_count, 1);
    RSV_TRY(known ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(find_nodes(v, known));
    RSV_TRY(rsv_find_buried(&v->scene, e, b->draw, known, d->valid_points, v->rays));
    RSV_TRY(rsv_elements_bridge_buried(e, d->valid_points));
    RSV_TRY(find_ends(v));
cleanup:
    rsv_free(e->context, known);
    return status;
}

rsv_status rsv_elements_divide(const rsv_transport_scene *scene, const rsv_elements_before *before,
    rsv_divided_elements *divided, uint64_t *rays)
{
    divider v = { .before = before, .d = divided, .rays = rays };
    rsv_context *context = before->elements->context;
    *divided = (rsv_divided_elements){ 0 };
    begin(&v, scene);
    rsv_status status = split_cells(&v);
    if (status == RSV_OK) status = number_nodes(&v);
    if (status != RSV_OK) rsv_divided_elements_free(context, divided);
    return status;
}

void rsv_divided_elements_free(rsv_context *context, rsv_divided_elements *d)
{
    rsv_elements_destroy(d->elements);
    rsv_free(context, d->valid_points);
    rsv_free(context, d->node_before);
    rsv_free(context, d->node_now);
    *d = (rsv_divided_elements){ 0 };
}
