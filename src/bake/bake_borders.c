#include "bake_borders.h"

#include "../core/vec.h"

#include <math.h>

rsv_status rsv_bake_borders_add(rsv_bake_borders *q, rsv_vec3 point)
{
    rsv_status status =
        rsv_grow(q->context, (void **)&q->point, &q->capacity, q->count + 1, sizeof *q->point);
    if (status == RSV_OK) q->point[q->count++] = point;
    return status;
}

static int32_t cell_along(const rsv_bake_borders *q, float x)
{
    return (int32_t)floorf(f_min(f_max(x / q->cell, -1e9f), 1e9f));
}

/// Cells with the same key are treated as one: their points are compared, and found to be far away.
static uint64_t key_of(int32_t x, int32_t y, int32_t z)
{
    return (uint64_t)(uint32_t)x * 0x9e3779b97f4a7c15u ^
           (uint64_t)(uint32_t)y * 0xc2b2ae3d27d4eb4fu ^
           (uint64_t)(uint32_t)z * 0x165667b19e3779f9u;
}

rsv_status rsv_bake_borders_sort(rsv_bake_borders *q, float near, float cell)
{
    rsv_status status;
    q->near = near;
    q->cell = f_max(cell, 4 * near);
    q->next = rsv_alloc(q->context, q->count, sizeof *q->next);
    RSV_TRY(q->next ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_index_map_create(q->context, q->count, &q->first));
    for (uint32_t k = 0; k < q->count; k++) {
        rsv_vec3 p = q->point[k];
        uint64_t key = key_of(cell_along(q, p.x), cell_along(q, p.y), cell_along(q, p.z));
        uint32_t first = rsv_index_map_insert(&q->first, key, k);
        RSV_TRY(first == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
        q->next[k] = RSV_NONE;
        if (first == k) continue;
        q->next[k] = q->next[first];
        q->next[first] = k;
    }
cleanup:
    return status;
}

void rsv_bake_borders_destroy(rsv_bake_borders *q)
{
    rsv_free(q->context, q->point);
    rsv_free(q->context, q->next);
    rsv_index_map_destroy(&q->first);
}

typedef struct edge {
    rsv_vec3 from, along; ///< unit
    float length;
    float best; ///< share of the point found; < 0 = none yet
} edge;

static void judge(const rsv_bake_borders *q, uint32_t k, edge *e)
{
    rsv_vec3 way = v3_sub(q->point[k], e->from);
    float along = v3_dot(way, e->along);
    float aside = v3_length(v3_mad(way, -along, e->along));
    // nearer than this to an end, it is that end
    float least = f_max(4 * q->near, 1e-3f * e->length);
    if (aside > q->near || along < least || along > e->length - least) return;
    float share = along / e->length;
    if (e->best < 0 || fabsf(share - 0.5f) < fabsf(e->best - 0.5f)) e->best = share;
}

static void look_around(const rsv_bake_borders *q, rsv_vec3 at, edge *e)
{
    int32_t x = cell_along(q, at.x), y = cell_along(q, at.y), z = cell_along(q, at.z);
    for (int n = 0; n < 27; n++) {
        uint64_t key = key_of(x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1);
        uint32_t k = rsv_index_map_find(&q->first, key);
        for (; k != RSV_NONE; k = q->next[k])
            judge(q, k, e);
    }
}

bool rsv_bake_borders_find(const rsv_bake_borders *q, rsv_vec3 a, rsv_vec3 b, float *share)
{
    edge e = { .from = a, .length = v3_length(v3_sub(b, a)), .best = -1 };
    if (!(e.length > 8 * q->near)) return false;
    e.along = v3_scale(v3_sub(b, a), 1 / e.length);
    int steps = 1 + (int)(e.length / q->cell);
    for (int k = 0; k <= steps; k++)
        look_around(q, v3_mad(a, e.length * (float)k / (float)steps, e.along), &e);
    *share = e.best;
    return e.best > 0;
}
