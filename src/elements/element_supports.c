/// Collects the cells around each node.
#include "../core/parallel.h"
#include "cut_cells.h"
#include "elements_internal.h"

#include <stdlib.h>
#include <string.h>

rsv_status rsv_elements_are_countable(const rsv_elements *e)
{
    if (e->cell_count < RSV_NONE / 4) return RSV_OK;
    return rsv_fail(RSV_ERROR_MEMORY, "elements: more than 2^30 cells; ask for fewer elements");
}

static int compare(const void *left, const void *right)
{
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

/// The cells around a node in their order: a few, but at the tip of a cone.
static void sort_support(uint32_t *support, size_t count)
{
    if (count > 32) qsort(support, count, sizeof *support, compare);
    for (size_t k = 1; k < count; k++) {
        uint32_t moved = support[k];
        size_t at = k;
        for (; at > 0 && support[at - 1] > moved; at--)
            support[at] = support[at - 1];
        support[at] = moved;
    }
}

static void count_corners(void *user, rsv_span span)
{
    const rsv_elements *e = user;
    for (size_t c = span.begin; c < span.end; c++)
        for (int k = 0; k < 3; k++)
            __atomic_fetch_add(&e->support_begin[e->cell_node[c][k] + 1], 1, __ATOMIC_RELAXED);
}

static void count_supports(rsv_elements *e)
{
    rsv_parallel_for(e->context, e->cell_count, 0, count_corners, e);
    for (size_t n = 0; n < e->node_count; n++)
        e->support_begin[n + 1] += e->support_begin[n];
}

typedef struct support_list {
    const rsv_elements *e;
    _Atomic uint32_t *taken; ///< [node_count] places, zeros at first
} support_list;

/// Each corner takes the next free place, in any order.
static void list_corners(void *user, rsv_span span)
{
    const support_list *list = user;
    const rsv_elements *e = list->e;
    for (size_t c = span.begin; c < span.end; c++)
        for (int k = 0; k < 3; k++) {
            uint32_t node = e->cell_node[c][k];
            uint32_t place = atomic_fetch_add_explicit(&list->taken[node], 1, memory_order_relaxed);
            e->support[e->support_begin[node] + place] = (uint32_t)(4 * c) + (uint32_t)k;
        }
}

static void sort_supports(void *user, rsv_span span)
{
    const rsv_elements *e = user;
    for (size_t n = span.begin; n < span.end; n++) {
        uint32_t begin = e->support_begin[n], end = e->support_begin[n + 1];
        if (begin == end) continue;
        sort_support(e->support + begin, end - begin);
        e->node_face[n] = e->cell[e->support[begin] / 4].face;
    }
}

/// Takes the area of hanging nodes to their parents.
static void hand_over_areas(rsv_elements *e)
{
    for (size_t h = e->hanging_count; h-- > 0;) {
        const rsv_hanging *hanging = &e->hanging[h];
        float area = e->node_area[hanging->node];
        for (int p = 0; p < RSV_PARENTS; p++)
            e->node_area[hanging->parent[p]] += hanging->weight[p] * area;
        e->node_area[hanging->node] = 0;
    }
}

static void add_cell_areas(void *user, rsv_span span)
{
    const rsv_elements *e = user;
    for (size_t n = span.begin; n < span.end; n++) {
        e->node_area[n] = 0;
        for (uint32_t s = e->support_begin[n + 1]; s-- > e->support_begin[n];) {
            uint32_t cell = e->support[s] / 4;
            float area = rsv_cell_area(e, cell), share[3];
            if (rsv_cell_sides(e, cell)) {
                rsv_cell_shares(e, cell, share);
                e->node_area[n] += share[e->support[s] & 3] * area;
            } else {
                e->node_area[n] += area / 3;
            }
        }
    }
}

void rsv_elements_find_node_areas(rsv_elements *e)
{
    rsv_parallel_for(e->context, e->node_count, 0, add_cell_areas, e);
    hand_over_areas(e);
}

void rsv_elements_find_areas(rsv_elements *e)
{
    for (size_t face = 0; face < e->face_count; face++)
        e->face_area[face] = rsv_triangle_area(e->scene, e->face_triangle[face]);
    rsv_elements_find_node_areas(e);
}

rsv_status rsv_elements_create_supports(rsv_elements *e)
{
    rsv_status status = rsv_elements_are_countable(e);
    if (status != RSV_OK) return status;
    support_list list = { e, rsv_alloc(e->context, e->node_count, sizeof *list.taken) };
    e->node_face = rsv_alloc(e->context, e->node_count, sizeof *e->node_face);
    e->node_area = rsv_alloc(e->context, e->node_count, sizeof *e->node_area);
    e->support_begin = rsv_alloc(e->context, e->node_count + 1, sizeof *e->support_begin);
    e->support = rsv_reserve(e->context, 3 * e->cell_count, sizeof *e->support);
    RSV_TRY(list.taken && e->node_face && e->node_area && e->support_begin && e->support
                ? RSV_OK
                : RSV_ERROR_MEMORY);
    count_supports(e);
    rsv_parallel_for(e->context, e->cell_count, 0, list_corners, &list);
    rsv_parallel_for(e->context, e->node_count, 0, sort_supports, e);
    rsv_elements_find_node_areas(e);
cleanup:
    rsv_free(e->context, (void *)list.taken);
    return status;
}

rsv_status rsv_elements_renumber(rsv_elements *e, size_t node_count)
{
    uint32_t *node_hanging = rsv_alloc(e->context, node_count, sizeof *node_hanging);
    if (!node_hanging) return RSV_ERROR_MEMORY;
    memset(node_hanging, 0xff, node_count * sizeof *node_hanging);
    memcpy(node_hanging, e->node_hanging, e->node_count * sizeof *node_hanging);
    rsv_free(e->context, e->node_hanging);
    rsv_free(e->context, e->node_face);
    rsv_free(e->context, e->node_area);
    rsv_free(e->context, e->support_begin);
    rsv_free(e->context, e->support);
    e->node_face = NULL;
    e->node_area = NULL;
    e->support_begin = e->support = NULL;
    e->node_hanging = node_hanging;
    e->node_count = node_count;
    return rsv_elements_create_supports(e);
}
