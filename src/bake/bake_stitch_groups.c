#include "bake_stitch_groups.h"

static uint32_t first_of(uint32_t *root, uint32_t k)
{
    while (root[k] != k)
        k = root[k] = root[root[k]];
    return k;
}

/// @param user a stitch that touches the texel, plus one; 0 = none so far
static void touch(uint32_t *user, uint32_t *root, uint32_t k)
{
    if (!*user) *user = k + 1;
    uint32_t a = first_of(root, k), b = first_of(root, *user - 1);
    root[a > b ? a : b] = a < b ? a : b;
}

/// @param root [count] out: of each stitch the first one of its group
/// @param user [texels of the map] zeros
static void join_stitches(const rsv_bake_map *map, const rsv_bake_stitch *stitch, size_t count,
    uint32_t *root, uint32_t *user)
{
    for (uint32_t k = 0; k < count; k++) {
        root[k] = k;
        for (int side = 0; side < 2; side++) {
            uint32_t at[2];
            float part[2];
            rsv_bake_map_locate(map, stitch[k].point[side], at, part);
            uint32_t *corner = &user[(size_t)at[1] * map->width + at[0]];
            for (size_t i = 0; i < 4; i++)
                touch(corner + (i >> 1) * map->width + (i & 1), root, k);
        }
    }
    for (uint32_t k = 0; k < count; k++)
        root[k] = first_of(root, k);
}

/// @param next [stitch_count] zeros
static void sort(
    rsv_bake_stitch_groups *g, const rsv_bake_stitch *stitch, const uint32_t *root, size_t *next)
{
    for (size_t k = 0; k < g->stitch_count; k++)
        next[root[k]]++;
    for (size_t k = 0; k < g->stitch_count; k++) {
        if (root[k] != k) continue;
        size_t first = g->first_stitch[g->count++];
        g->first_stitch[g->count] = first + next[k];
        next[k] = first;
    }
    for (size_t k = 0; k < g->stitch_count; k++)
        g->stitch[next[root[k]]++] = stitch[k];
}

rsv_status rsv_bake_stitch_groups_create(rsv_context *context, const rsv_bake_map *map,
    const rsv_bake_stitch *stitch, size_t count, rsv_bake_stitch_groups *g)
{
    rsv_status status;
    uint32_t *root = rsv_alloc(context, count, sizeof *root);
    uint32_t *user = rsv_alloc(context, (size_t)map->width * map->height, sizeof *user);
    size_t *next = rsv_alloc(context, count, sizeof *next);
    *g = (rsv_bake_stitch_groups){ .stitch_count = count,
        .stitch = rsv_alloc(context, count, sizeof *g->stitch),
        .first_stitch = rsv_alloc(context, count + 1, sizeof *g->first_stitch),
        .first_texel = rsv_alloc(context, count + 1, sizeof *g->first_texel) };
    RSV_TRY(root && user && next && g->stitch && g->first_stitch && g->first_texel
                ? RSV_OK
                : RSV_ERROR_MEMORY);
    join_stitches(map, stitch, count, root, user);
    sort(g, stitch, root, next);
cleanup:
    rsv_free(context, root);
    rsv_free(context, user);
    rsv_free(context, next);
    return status;
}

void rsv_bake_stitch_groups_destroy(rsv_context *context, rsv_bake_stitch_groups *g)
{
    rsv_free(context, g->stitch);
    rsv_free(context, g->first_stitch);
    rsv_free(context, g->first_texel);
}
