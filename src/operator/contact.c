#include "contact.h"

#include "../core/index_map.h"

/// Test segments run this far above the surface and inside the cell, in parts of its size.
#define LIFT 0.02f
#define INSET 0.05f

rsv_cell_shape rsv_cell_shape_of(const rsv_elements *e, uint32_t cell)
{
    rsv_cell_shape shape;
    uint32_t face = e->cell[cell].face, triangle = e->face_triangle[face];
    rsv_surface_point point = { 0 };
    for (int k = 0; k < 3; k++) {
        float u, v;
        rsv_cell_corner(&e->cell[cell], k, &u, &v);
        point = rsv_surface_point_at(e->scene, triangle, u, v, e->face_back[face]);
        shape.corner[k] = point.position;
    }
    shape.centre =
        v3_scale(v3_add(v3_add(shape.corner[0], shape.corner[1]), shape.corner[2]), 1.0f / 3);
    shape.normal = point.geometric;
    shape.extent = point.extent;
    shape.size = sqrtf(2 * ldexpf(e->face_area[face], -2 * e->cell[cell].level));
    return shape;
}

/// Where rays leave the cell from: clear of rounding errors, no more.
static rsv_vec3 leave(const rsv_cell_shape *shape, rsv_vec3 place)
{
    rsv_vec3 inside = v3_mad(place, INSET, v3_sub(shape->centre, place));
    return rsv_offset_origin(inside, shape->normal, shape->extent);
}

rsv_vec3 rsv_cell_hover(const rsv_cell_shape *shape, rsv_vec3 place)
{
    return v3_mad(leave(shape, place), LIFT * shape->size, shape->normal);
}

bool rsv_is_blocked(const rsv_tracer *tracer, rsv_vec3 from, rsv_vec3 to)
{
    rsv_ray there = { from, v3_sub(to, from), 1 };
    return rsv_tracer_occluded(tracer, &there);
}

bool rsv_is_covered(const rsv_tracer *tracer, const rsv_cell_shape *shape, rsv_vec3 place)
{
    return rsv_is_blocked(tracer, leave(shape, place), rsv_cell_hover(shape, place));
}

/// Something passes through the cell, or lies on part of it.
static bool is_cut(const rsv_tracer *tracer, const rsv_elements *e, uint32_t cell)
{
    rsv_cell_shape shape = rsv_cell_shape_of(e, cell);
    rsv_vec3 place[3];
    int covered = 0;
    for (int k = 0; k < 3; k++) {
        place[k] = rsv_cell_hover(&shape, shape.corner[k]);
        covered += rsv_is_covered(tracer, &shape, shape.corner[k]);
    }
    if (covered == 1 || covered == 2) return true;
    for (int k = 0; k < 3; k++)
        if (rsv_is_blocked(tracer, place[k], place[(k + 1) % 3])) return true;
    return false;
}

rsv_status rsv_elements_refine_contacts(
    const rsv_tracer *tracer, uint32_t levels, rsv_elements **elements, uint64_t *rays)
{
    rsv_context *context = (*elements)->context;
    for (uint32_t level = 0; level < levels; level++) {
        const rsv_elements *e = *elements;
        uint8_t *split = rsv_alloc(context, e->cell_count, 1);
        if (!split) return RSV_ERROR_MEMORY;
        size_t marked = 0;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(context)) reduction(+ : marked)
        for (size_t c = 0; c < e->cell_count; c++) {
            split[c] = e->cell[c].level < RSV_MAX_LEVEL && is_cut(tracer, e, (uint32_t)c);
            marked += split[c];
        }
        *rays += 3 * e->cell_count;
        rsv_elements *finer = NULL;
        rsv_status status = marked ? rsv_elements_refine(e, split, &finer) : RSV_OK;
        rsv_free(context, split);
        if (status != RSV_OK) return status;
        if (!marked) break;
        rsv_elements_destroy(*elements);
        *elements = finer;
    }
    return RSV_OK;
}

/// Whether something stands between two cells that share an edge.
static bool is_walled(const rsv_tracer *tracer, const rsv_elements *e, uint32_t a, uint32_t b)
{
    rsv_cell_shape here = rsv_cell_shape_of(e, a), there = rsv_cell_shape_of(e, b);
    // across a fold the straight line would run through the surface itself
    if (v3_dot(here.normal, there.normal) < 0.999f) return false;
    return rsv_is_blocked(
        tracer, rsv_cell_hover(&here, here.centre), rsv_cell_hover(&there, there.centre));
}

typedef struct wall_list {
    uint32_t
        *other; ///< [3 * cell_count] cell across the edge opposite to a corner, RSV_NONE = none
    uint8_t *walled; ///< [3 * cell_count]
} wall_list;

static rsv_status find_neighbours(const rsv_elements *e, wall_list *walls)
{
    rsv_index_map edges;
    rsv_status status = rsv_index_map_create(e->context, 2 * e->cell_count, &edges);
    for (size_t c = 0; c < e->cell_count && status == RSV_OK; c++) {
        for (size_t k = 0; k < 3; k++) {
            uint32_t p = e->cell_node[c][(k + 1) % 3], q = e->cell_node[c][(k + 2) % 3];
            uint64_t key = p < q ? (uint64_t)p << 32 | q : (uint64_t)q << 32 | p;
            uint32_t mine = (uint32_t)(3 * c + k), first = rsv_index_map_insert(&edges, key, mine);
            if (first == UINT32_MAX) status = RSV_ERROR_MEMORY;
            walls->other[mine] = RSV_NONE;
            if (first == UINT32_MAX || first == mine) continue;
            walls->other[mine] = first / 3;
            walls->other[first] = (uint32_t)c;
        }
    }
    rsv_index_map_destroy(&edges);
    return status;
}

/// The cell next to `cell` around `node`, across the edge opposite to corner k; RSV_NONE at a wall.
static uint32_t open_neighbour(const wall_list *walls, uint32_t cell, int k)
{
    return walls->walled[3 * cell + (uint32_t)k] ? RSV_NONE : walls->other[3 * cell + (uint32_t)k];
}

#define MAX_FAN 32 ///< cells around a node; nodes with more are left alone

/// Groups the cells around a node that can be reached from each other without passing a wall.
/// @param group [count], out @return number of groups
static int group_fan(
    const rsv_elements *e, const wall_list *walls, uint32_t begin, uint32_t count, int *group)
{
    int groups = 0;
    for (uint32_t s = 0; s < count; s++)
        group[s] = -1;
    for (uint32_t start = 0; start < count; start++) {
        if (group[start] >= 0) continue;
        uint32_t open[MAX_FAN], waiting = 0;
        open[waiting++] = start;
        group[start] = groups;
        while (waiting) {
            uint32_t entry = e->support[begin + open[--waiting]], cell = entry / 4;
            int corner = (int)(entry & 3);
            for (int turn = 1; turn <= 2; turn++) {
                uint32_t next = open_neighbour(walls, cell, (corner + turn) % 3);
                for (uint32_t s = 0; next != RSV_NONE && s < count; s++) {
                    if (e->support[begin + s] / 4 != next || group[s] >= 0) continue;
                    group[s] = groups;
                    open[waiting++] = s;
                }
            }
        }
        groups++;
    }
    return groups;
}

static bool touches_wall(const rsv_elements *e, const wall_list *walls, uint32_t node)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        uint32_t cell = e->support[s] / 4, corner = e->support[s] & 3;
        if (walls->walled[3 * cell + (corner + 1) % 3] ||
            walls->walled[3 * cell + (corner + 2) % 3])
            return true;
    }
    return false;
}

/// Splits one node; fresh nodes are numbered from *next on.
static void separate_node(rsv_elements *e, const wall_list *walls, uint32_t node, uint32_t *next)
{
    uint32_t begin = e->support_begin[node], count = e->support_begin[node + 1] - begin;
    int group[MAX_FAN];
    if (count > MAX_FAN || e->node_hanging[node] != RSV_NONE || !touches_wall(e, walls, node))
        return;
    int groups = group_fan(e, walls, begin, count, group);
    for (uint32_t s = 0; s < count; s++)
        if (group[s] > 0)
            e->cell_node[e->support[begin + s] / 4][e->support[begin + s] & 3] =
                *next + (uint32_t)group[s] - 1;
    *next += (uint32_t)(groups - 1);
}

rsv_status rsv_elements_separate(const rsv_tracer *tracer, rsv_elements *e, uint64_t *rays)
{
    rsv_status status = RSV_OK;
    wall_list walls = { rsv_alloc(e->context, 3 * e->cell_count, sizeof(uint32_t)),
        rsv_alloc(e->context, 3 * e->cell_count, 1) };
    if (!walls.other || !walls.walled) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(find_neighbours(e, &walls));
    size_t walled = 0;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context)) reduction(+ : walled)
    for (size_t edge = 0; edge < 3 * e->cell_count; edge++) {
        if (walls.other[edge] == RSV_NONE) continue;
        walls.walled[edge] = is_walled(tracer, e, (uint32_t)(edge / 3), walls.other[edge]);
        walled += walls.walled[edge];
    }
    *rays += 3 * e->cell_count;
    if (walled == 0) goto cleanup;
    uint32_t next = (uint32_t)e->node_count;
    for (uint32_t node = 0; node < e->node_count; node++)
        separate_node(e, &walls, node, &next);
    if (next > e->node_count) RSV_TRY(rsv_elements_renumber(e, next));
cleanup:
    rsv_free(e->context, walls.other);
    rsv_free(e->context, walls.walled);
    return status;
}
