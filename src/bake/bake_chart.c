#include "bake_chart.h"

#include "../core/index_map.h"
#include "../core/vec.h"
#include "bake_constants.h"

#include <stdlib.h>
#include <string.h>

/// Neighbourhood of a part's triangles.
typedef struct surface {
    const rsv_bake_part *part;
    rsv_vec3 (*corner)[3];    ///< [triangle_count] world space, in the order of the file
    rsv_vec3 *normal;         ///< [triangle_count]
    uint32_t (*neighbour)[3]; ///< [triangle_count] across edges 0-1, 1-2, 2-0; RSV_NONE = none
    uint32_t *queue;          ///< [triangle_count]
    uint8_t *taken;           ///< [triangle_count]
} surface;

/// The finalizer of SplitMix64 (Steele et al. 2014): mirrored positions, which differ only in signs, get different
/// results.
static uint64_t mix(uint64_t h)
{
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 27) * 0x94d049bb133111ebu;
    return h ^ h >> 31;
}

/// Equal positions have equal numbers.
static uint64_t hash_point(rsv_vec3 p)
{
    uint32_t bits[3];
    p = v3_add(p, v3(0, 0, 0)); // -0 is 0
    memcpy(bits, &p, sizeof bits);
    return mix(mix((uint64_t)bits[0] << 32 | bits[1]) ^ bits[2]);
}

uint64_t rsv_bake_edge_key(rsv_vec3 a, rsv_vec3 b) { return hash_point(a) + hash_point(b); }

// ---- the surface ----------------------------------------------------------------------------------

static void find_corners(surface *f, const rsv_scene_view *view)
{
    for (size_t t = 0; t < f->part->triangle_count; t++) {
        if (f->part->triangle[t] == RSV_NONE) continue;
        const uint32_t *v = view->triangle[f->part->triangle[t]];
        const int order[3] = { 0, f->part->mirrored ? 2 : 1, f->part->mirrored ? 1 : 2 };
        for (int k = 0; k < 3; k++)
            f->corner[t][k] = view->position[v[order[k]]];
        rsv_vec3 cross = v3_cross(v3_sub(view->position[v[1]], view->position[v[0]]),
            v3_sub(view->position[v[2]], view->position[v[0]]));
        f->normal[t] = v3_normalize(cross);
    }
}

/// Two triangles at an edge are neighbours; if more meet, the third and later ones have no neighbour there.
static rsv_status find_neighbours(rsv_context *context, surface *f)
{
    rsv_status status;
    rsv_index_map edges = { 0 };
    size_t count = f->part->triangle_count;
    memset(f->neighbour, 0xff, count * sizeof *f->neighbour);
    RSV_TRY(rsv_index_map_create(context, 2 * count, &edges));
    for (size_t t = 0; t < count; t++) {
        if (f->part->triangle[t] == RSV_NONE) continue;
        for (size_t k = 0; k < 3; k++) {
            uint32_t own = (uint32_t)(3 * t + k);
            uint64_t key = rsv_bake_edge_key(f->corner[t][k], f->corner[t][(k + 1) % 3]);
            uint32_t other = rsv_index_map_insert(&edges, key, own);
            RSV_TRY(other == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
            if (other == own || f->neighbour[other / 3][other % 3] != RSV_NONE) continue;
            f->neighbour[other / 3][other % 3] = (uint32_t)t;
            f->neighbour[t][k] = other / 3;
        }
    }
cleanup:
    rsv_index_map_destroy(&edges);
    return status;
}

static void destroy_surface(rsv_context *context, surface *f)
{
    rsv_free(context, f->corner);
    rsv_free(context, f->normal);
    rsv_free(context, f->neighbour);
    rsv_free(context, f->queue);
    rsv_free(context, f->taken);
}

static rsv_status create_surface(const rsv_light_view *s, const rsv_bake_part *part, surface *f)
{
    rsv_context *context = s->context;
    size_t count = part->triangle_count;
    *f = (surface){ .part = part,
        .corner = rsv_alloc(context, count, sizeof *f->corner),
        .normal = rsv_alloc(context, count, sizeof *f->normal),
        .neighbour = rsv_alloc(context, count, sizeof *f->neighbour),
        .queue = rsv_alloc(context, count, sizeof *f->queue),
        .taken = rsv_alloc(context, count, 1) };
    if (!f->corner || !f->normal || !f->neighbour || !f->queue || !f->taken)
        return RSV_ERROR_MEMORY;
    find_corners(f, s->scene.view);
    return find_neighbours(context, f);
}

// ---- growing --------------------------------------------------------------------------------------

/// Triangles around `seed` that lie flat with it, into the queue. @return how many
static size_t grow(surface *f, uint32_t seed, const uint8_t *layer)
{
    size_t count = 1;
    f->queue[0] = seed;
    f->taken[seed] = 1;
    for (size_t k = 0; k < count; k++) {
        uint32_t t = f->queue[k];
        for (int e = 0; e < 3; e++) {
            uint32_t n = f->neighbour[t][e];
            if (n == RSV_NONE || f->taken[n] || (layer && layer[n] != layer[seed])) continue;
            if (v3_dot(f->normal[n], f->normal[t]) < CHART_CREASE) continue;
            if (v3_dot(f->normal[n], f->normal[seed]) < CHART_DEVIATION) continue;
            f->taken[n] = 1;
            f->queue[count++] = n;
        }
    }
    return count;
}

/// A chart's own axes: along its longest border edge, which in a rectangle is a side.
static void find_axes(const surface *f, size_t count, rsv_vec3 axis[2])
{
    rsv_vec3 normal = v3(0, 0, 0), longest = v3(1, 0, 0);
    float most = 0;
    for (size_t k = 0; k < count; k++) {
        uint32_t t = f->queue[k];
        normal = v3_add(normal, v3_cross(v3_sub(f->corner[t][1], f->corner[t][0]),
                                    v3_sub(f->corner[t][2], f->corner[t][0])));
        for (int e = 0; e < 3; e++) {
            rsv_vec3 edge = v3_sub(f->corner[t][(e + 1) % 3], f->corner[t][e]);
            uint32_t n = f->neighbour[t][e];
            bool border = n == RSV_NONE || v3_dot(f->normal[n], f->normal[t]) < CHART_CREASE;
            if (!border && count > 1) continue;
            if (v3_length(edge) > most) most = v3_length(edge), longest = edge;
        }
    }
    if (f->part->mirrored) normal = v3_neg(normal);
    if (most == 0) longest = v3_sub(f->corner[f->queue[0]][1], f->corner[f->queue[0]][0]);
    normal = v3_normalize(normal);
    axis[0] = v3_normalize(v3_sub(longest, v3_scale(normal, v3_dot(longest, normal))));
    axis[1] = v3_cross(normal, axis[0]);
}

/// Allocates one more chart with a number of triangles. @return where its corners go
static rsv_status begin_chart(
    rsv_bake_charts *c, uint32_t part, size_t count, rsv_bake_chart **chart)
{
    rsv_status status;
    size_t needed = c->triangle_count + count;
    RSV_TRY(rsv_grow(c->context, (void **)&c->chart, &c->capacity, c->count + 1, sizeof *c->chart));
    RSV_TRY(rsv_grow(
        c->context, (void **)&c->triangle, &c->triangle_capacity, needed, sizeof *c->triangle));
    RSV_TRY(
        rsv_grow(c->context, (void **)&c->corner, &c->corner_capacity, needed, sizeof *c->corner));
    *chart = &c->chart[c->count++];
    **chart = (rsv_bake_chart){ .part = part,
        .first = (uint32_t)c->triangle_count,
        .triangle_count = (uint32_t)count,
        .detail = 1 };
    c->triangle_count = needed;
cleanup:
    return status;
}

/// Shifts corners so that the chart begins at 0 along both axes, and measures it.
static void settle_chart(rsv_bake_charts *c, rsv_bake_chart *chart)
{
    for (int axis = 0; axis < 2; axis++) {
        float low = INFINITY, high = -INFINITY;
        for (size_t k = chart->first; k < chart->first + chart->triangle_count; k++)
            for (int v = 0; v < 3; v++) {
                low = f_min(low, c->corner[k][v][axis]);
                high = f_max(high, c->corner[k][v][axis]);
            }
        for (size_t k = chart->first; k < chart->first + chart->triangle_count; k++)
            for (int v = 0; v < 3; v++)
                c->corner[k][v][axis] -= low;
        chart->size[axis] = high - low;
    }
}

static rsv_status add_chart(rsv_bake_charts *c, const surface *f, uint32_t part, size_t count)
{
    rsv_bake_chart *chart;
    rsv_vec3 axis[2];
    rsv_status status = begin_chart(c, part, count, &chart);
    if (status != RSV_OK) return status;
    find_axes(f, count, axis);
    for (size_t k = 0; k < count; k++) {
        c->triangle[chart->first + k] = f->queue[k];
        for (int v = 0; v < 3; v++)
            for (int a = 0; a < 2; a++)
                c->corner[chart->first + k][v][a] =
                    v3_dot(axis[a], v3_sub(f->corner[f->queue[k]][v], f->corner[f->queue[0]][0]));
    }
    settle_chart(c, chart);
    return RSV_OK;
}

rsv_status rsv_bake_add_charts(rsv_bake_charts *c, const rsv_light_view *solution,
    const rsv_bake_part *part, uint32_t part_index, const uint8_t *layer)
{
    surface f;
    rsv_status status = create_surface(solution, part, &f);
    for (uint32_t t = 0; status == RSV_OK && t < part->triangle_count; t++)
        if (part->triangle[t] != RSV_NONE && !f.taken[t])
            status = add_chart(c, &f, part_index, grow(&f, t, layer));
    destroy_surface(solution->context, &f);
    return status;
}

// ---- charts of the file ---------------------------------------------------------------------------

static double uv_area(const uint32_t v[3], const float (*uv)[2])
{
    return 0.5 * fabs((double)(uv[v[1]][0] - uv[v[0]][0]) * (uv[v[2]][1] - uv[v[0]][1]) -
                      (double)(uv[v[2]][0] - uv[v[0]][0]) * (uv[v[1]][1] - uv[v[0]][1]));
}

/// Factor from a part's texture coordinates to metres, on average; 0 = they have no area.
static float metres_of(const rsv_light_view *s, const rsv_bake_part *part, const float (*uv)[2])
{
    double area = 0, flat = 0;
    for (size_t t = 0; t < part->triangle_count; t++) {
        if (part->triangle[t] == RSV_NONE) continue;
        area += (double)rsv_triangle_area(s->scene.view, part->triangle[t]);
        flat += uv_area(part->corner[t], uv);
    }
    return flat > 0 ? (float)sqrt(area / flat) : 0;
}

/// Makes charts of those triangles of a part that have the same island, in the order of their first ones.
/// @param island [triangle_count] a triangle of the same island, the first one being its own; RSV_NONE = in no chart
static rsv_status keep(rsv_bake_charts *c, const rsv_bake_part *part, uint32_t part_index,
    const float (*uv)[2], float metres, const uint32_t *island)
{
    rsv_status status;
    uint32_t *count = rsv_alloc(c->context, part->triangle_count, sizeof *count);
    uint32_t *next = rsv_alloc(c->context, part->triangle_count, sizeof *next);
    size_t first_chart = c->count;
    RSV_TRY(count && next ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t t = 0; t < part->triangle_count; t++)
        if (island[t] != RSV_NONE) count[island[t]]++;
    for (size_t t = 0; t < part->triangle_count; t++) {
        rsv_bake_chart *chart;
        if (!count[t]) continue;
        RSV_TRY(begin_chart(c, part_index, count[t], &chart));
        next[t] = chart->first;
    }
    for (uint32_t t = 0; t < part->triangle_count; t++) {
        if (island[t] == RSV_NONE) continue;
        uint32_t at = next[island[t]]++;
        for (int k = 0; k < 3; k++)
            for (int a = 0; a < 2; a++)
                c->corner[at][k][a] = metres * uv[part->corner[t][k]][a];
        c->triangle[at] = t;
    }
    for (size_t k = first_chart; k < c->count; k++)
        settle_chart(c, &c->chart[k]);
cleanup:
    rsv_free(c->context, count);
    rsv_free(c->context, next);
    return status;
}

static uint64_t hash_vertex(const rsv_bake_part *part, const float (*uv)[2], uint32_t vertex)
{
    return mix(
        hash_point(part->position[vertex]) ^ mix(hash_point(v3(uv[vertex][0], uv[vertex][1], 0))));
}

static uint32_t root_of(uint32_t *island, uint32_t t)
{
    while (island[t] != t)
        t = island[t] = island[island[t]];
    return t;
}

/// Triangles that share an edge both in space and in the map are of one island; it is known by the first of them.
/// @param island [triangle_count] each triangle itself, RSV_NONE = of no island
static rsv_status join_islands(
    rsv_context *context, const rsv_bake_part *part, const float (*uv)[2], uint32_t *island)
{
    rsv_status status;
    rsv_index_map edges = { 0 };
    RSV_TRY(rsv_index_map_create(context, 2 * part->triangle_count, &edges));
    for (uint32_t t = 0; t < part->triangle_count; t++) {
        if (island[t] == RSV_NONE) continue;
        for (int k = 0; k < 3; k++) {
            uint64_t key = hash_vertex(part, uv, part->corner[t][k]) +
                           hash_vertex(part, uv, part->corner[t][(k + 1) % 3]);
            uint32_t other = rsv_index_map_insert(&edges, key, t);
            RSV_TRY(other == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
            uint32_t a = root_of(island, t), b = root_of(island, other);
            island[a > b ? a : b] = a > b ? b : a;
        }
    }
    for (uint32_t t = 0; t < part->triangle_count; t++)
        if (island[t] != RSV_NONE) island[t] = root_of(island, t);
cleanup:
    rsv_index_map_destroy(&edges);
    return status;
}

rsv_status rsv_bake_keep_charts(rsv_bake_charts *c, const rsv_light_view *solution,
    const rsv_bake_part *part, uint32_t part_index, const float (*uv)[2], bool whole)
{
    rsv_status status = RSV_OK;
    uint32_t first = RSV_NONE;
    uint32_t *island = rsv_alloc(c->context, part->triangle_count, sizeof *island);
    if (!island) return RSV_ERROR_MEMORY;
    for (uint32_t t = 0; t < part->triangle_count; t++) {
        bool none = part->triangle[t] == RSV_NONE;
        if (!none && first == RSV_NONE) first = t;
        island[t] = none ? RSV_NONE : whole ? first : t;
    }
    if (!whole) status = join_islands(c->context, part, uv, island);
    if (status == RSV_OK)
        status = keep(c, part, part_index, uv, metres_of(solution, part, uv), island);
    rsv_free(c->context, island);
    return status;
}

double rsv_bake_chart_area(const rsv_bake_charts *c, const rsv_bake_chart *chart)
{
    double area = 0;
    for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++) {
        const float(*p)[2] = (const float(*)[2])c->corner[k];
        area += 0.5 * fabs((double)(p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                           (double)(p[2][0] - p[0][0]) * (p[1][1] - p[0][1]));
    }
    return area;
}

void rsv_bake_charts_destroy(rsv_bake_charts *c)
{
    rsv_free(c->context, c->chart);
    rsv_free(c->context, c->triangle);
    rsv_free(c->context, c->corner);
    *c = (rsv_bake_charts){ .context = c->context };
}
