#include "isosurface.h"

#include "../core/index_map.h"
#include "../core/parallel.h"

#include <string.h>

/// Vertices keep this share of an edge away from its ends: slivers would have no normal in float.
#define EDGE_MARGIN 0.1f
#define NEWTON_STEPS 4
#define TRIAL_CELLS 24

typedef struct grid {
    rsv_context *context;
    rsv_field field;
    rsv_vec3 low;
    float cell;
    uint32_t count[3]; ///< nodes along each axis
    float *value;      ///< [count[0] * count[1] * count[2]], x fastest
    rsv_index_map edges;
    rsv_isosurface *out;
} grid;

static uint32_t node_at(const grid *g, uint32_t x, uint32_t y, uint32_t z)
{
    return (z * g->count[1] + y) * g->count[0] + x;
}

static rsv_vec3 position_of(const grid *g, uint32_t node)
{
    uint32_t x = node % g->count[0], y = node / g->count[0] % g->count[1];
    uint32_t z = node / g->count[0] / g->count[1];
    return v3_mad(g->low, g->cell, v3((float)x, (float)y, (float)z));
}

/// The vertex on the edge between two nodes on either side of the surface.
static rsv_status edge_vertex(grid *g, uint32_t inside, uint32_t outside, uint32_t *vertex)
{
    rsv_status status;
    rsv_isosurface *out = g->out;
    uint32_t low = inside < outside ? inside : outside, high = inside ^ outside ^ low;
    uint64_t key = (uint64_t)high << 32 | low;
    *vertex = rsv_index_map_insert(&g->edges, key, (uint32_t)out->vertex_count);
    if (*vertex == UINT32_MAX) return RSV_ERROR_MEMORY;
    if (*vertex != out->vertex_count) return RSV_OK;
    RSV_TRY(rsv_grow(g->context, (void **)&out->position, &out->vertex_capacity,
        out->vertex_count + 1, sizeof *out->position));
    float a = g->value[inside], b = g->value[outside];
    float t = f_min(f_max(a / (a - b), EDGE_MARGIN), 1 - EDGE_MARGIN);
    rsv_vec3 p = position_of(g, inside), q = position_of(g, outside);
    out->position[out->vertex_count++] = v3_mad(p, t, v3_sub(q, p));
cleanup:
    return status;
}

/// @param outwards any direction from inside to outside
static rsv_status add_triangle(grid *g, const uint32_t corner[3], rsv_vec3 outwards)
{
    rsv_status status;
    rsv_isosurface *out = g->out;
    RSV_TRY(rsv_grow(g->context, (void **)&out->index, &out->index_capacity,
        3 * out->triangle_count + 3, sizeof *out->index));
    rsv_vec3 a = out->position[corner[0]], e = v3_sub(out->position[corner[1]], a),
             f = v3_sub(out->position[corner[2]], a);
    bool turned = v3_dot(v3_cross(e, f), outwards) < 0;
    uint32_t *index = &out->index[3 * out->triangle_count++];
    index[0] = corner[0];
    index[1] = corner[turned ? 2 : 1];
    index[2] = corner[turned ? 1 : 2];
cleanup:
    return status;
}

/// Cuts one tetrahedron: into a triangle if one node is on its own side, into two triangles if two nodes are on each
/// side.
static rsv_status cut_tetrahedron(grid *g, const uint32_t node[4])
{
    rsv_status status = RSV_OK;
    uint32_t inside[4], outside[4], corner[4];
    int inside_count = 0, outside_count = 0, corner_count = 0;
    rsv_vec3 outwards = v3(0, 0, 0);
    for (int i = 0; i < 4; i++)
        if (g->value[node[i]] < 0)
            inside[inside_count++] = node[i];
        else
            outside[outside_count++] = node[i];
    if (!inside_count || !outside_count) return RSV_OK;
    for (int i = 0; i < inside_count; i++)
        for (int k = 0; k < outside_count; k++) {
            // of two against two, the second pair is taken backwards: around the quadrangle
            int o = i == 1 && inside_count == 2 ? outside_count - 1 - k : k;
            RSV_TRY(edge_vertex(g, inside[i], outside[o], &corner[corner_count++]));
            outwards =
                v3_add(outwards, v3_sub(position_of(g, outside[o]), position_of(g, inside[i])));
        }
    RSV_TRY(add_triangle(g, corner, outwards));
    if (corner_count == 4) {
        const uint32_t second[3] = { corner[0], corner[2], corner[3] };
        RSV_TRY(add_triangle(g, second, outwards));
    }
cleanup:
    return status;
}

static rsv_status cut_cell(grid *g, uint32_t x, uint32_t y, uint32_t z)
{
    // the six orders in which a walk along the axes leads from one end of the diagonal to the other
    static const uint8_t order[6][2] = { { 1, 3 }, { 1, 5 }, { 2, 3 }, { 2, 6 }, { 4, 5 },
        { 4, 6 } };
    rsv_status status = RSV_OK;
    uint32_t node[8];
    int inside = 0;
    for (uint32_t i = 0; i < 8; i++) {
        node[i] = node_at(g, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
        inside += g->value[node[i]] < 0;
    }
    for (int i = 0; i < 6 && inside && inside < 8; i++) {
        const uint32_t tetrahedron[4] = { node[0], node[order[i][0]], node[order[i][1]], node[7] };
        RSV_TRY(cut_tetrahedron(g, tetrahedron));
    }
cleanup:
    return status;
}

static rsv_vec3 gradient(const grid *g, rsv_vec3 p)
{
    float h = 0.1f * g->cell;
    rsv_vec3 x = v3(h, 0, 0), y = v3(0, h, 0), z = v3(0, 0, h);
    rsv_vec3 d = v3(g->field(v3_add(p, x)) - g->field(v3_sub(p, x)),
        g->field(v3_add(p, y)) - g->field(v3_sub(p, y)),
        g->field(v3_add(p, z)) - g->field(v3_sub(p, z)));
    return v3_scale(d, 0.5f / h);
}

/// Newton's steps along the gradient, none longer than keeps neighbours in order.
static void settle_vertices(void *job, rsv_span span)
{
    const grid *g = job;
    rsv_isosurface *out = g->out;
    for (size_t i = span.begin; i < span.end; i++) {
        rsv_vec3 p = out->position[i];
        for (int step = 0; step < NEWTON_STEPS; step++) {
            rsv_vec3 slope = gradient(g, p);
            float steepness = v3_dot(slope, slope);
            if (!(steepness > 0)) break;
            rsv_vec3 move = v3_scale(slope, -g->field(p) / steepness);
            float length = v3_length(move), longest = 0.25f * g->cell;
            p = v3_mad(p, length > longest ? longest / length : 1, move);
        }
        out->position[i] = p;
        out->normal[i] = v3_normalize(gradient(g, p));
    }
}

static void fill_span(void *job, rsv_span span)
{
    const grid *g = job;
    for (size_t i = span.begin; i < span.end; i++)
        g->value[i] = g->field(position_of(g, (uint32_t)i));
}

static rsv_status fill_grid(grid *g, rsv_vec3 high, uint32_t cells)
{
    rsv_vec3 size = v3_sub(high, g->low);
    g->cell = v3_max_abs(size) / (float)cells;
    const float side[3] = { size.x, size.y, size.z };
    for (int i = 0; i < 3; i++)
        g->count[i] = (uint32_t)ceilf(side[i] / g->cell) + 1;
    size_t node_count = (size_t)g->count[0] * g->count[1] * g->count[2];
    if (node_count >= RSV_NONE)
        return rsv_fail(RSV_ERROR_ARGUMENT, "isosurface: %u cells are too many", cells);
    g->value = rsv_alloc(g->context, node_count, sizeof *g->value);
    if (!g->value) return RSV_ERROR_MEMORY;
    rsv_parallel_for(g->context, node_count, 1024, fill_span, g);
    return RSV_OK;
}

void rsv_isosurface_release(rsv_context *context, rsv_isosurface *surface)
{
    rsv_free(context, surface->position);
    rsv_free(context, surface->normal);
    rsv_free(context, surface->index);
    *surface = (rsv_isosurface){ 0 };
}

rsv_status rsv_isosurface_create(rsv_context *context, rsv_field field, rsv_vec3 low, rsv_vec3 high,
    uint32_t cells, rsv_isosurface *surface)
{
    rsv_status status;
    grid g = { .context = context, .field = field, .low = low, .out = surface };
    *surface = (rsv_isosurface){ 0 };
    RSV_TRY(rsv_index_map_create(context, (size_t)16 * cells * cells, &g.edges));
    RSV_TRY(fill_grid(&g, high, cells));
    for (uint32_t z = 0; z + 1 < g.count[2]; z++)
        for (uint32_t y = 0; y + 1 < g.count[1]; y++)
            for (uint32_t x = 0; x + 1 < g.count[0]; x++)
                RSV_TRY(cut_cell(&g, x, y, z));
    surface->normal = rsv_alloc(context, surface->vertex_count, sizeof *surface->normal);
    if (!surface->normal) RSV_TRY(RSV_ERROR_MEMORY);
    rsv_parallel_for(context, surface->vertex_count, 0, settle_vertices, &g);
cleanup:
    rsv_free(context, g.value);
    rsv_index_map_destroy(&g.edges);
    if (status != RSV_OK) rsv_isosurface_release(context, surface);
    return status;
}

rsv_status rsv_isosurface_of_size(rsv_context *context, rsv_field field, rsv_vec3 low,
    rsv_vec3 high, size_t triangles, rsv_isosurface *surface)
{
    rsv_status status;
    // the number of triangles grows with the square of the cells: one coarse trial gives the factor
    RSV_TRY(rsv_isosurface_create(context, field, low, high, TRIAL_CELLS, surface));
    double ratio = (double)triangles / (double)(surface->triangle_count + 1);
    rsv_isosurface_release(context, surface);
    uint32_t cells = (uint32_t)lround(TRIAL_CELLS * sqrt(ratio));
    RSV_TRY(rsv_isosurface_create(context, field, low, high, cells < 4 ? 4 : cells, surface));
cleanup:
    return status;
}
