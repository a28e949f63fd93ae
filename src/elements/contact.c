#include "contact.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "cut_cells.h"
#include "elements_constants.h"
#include "elements_internal.h"
#include "known_cells.h"
#include "open_corners.h"

#include <string.h>

/// The cells around a node and from where they are seen on its behalf.
typedef struct fan {
    uint32_t begin, count;
    rsv_vec3 corner; ///< the node itself
    rsv_vec3 place[MAX_FAN], normal[MAX_FAN];
    float lift[MAX_FAN]; ///< of places above their cells
    bool open[MAX_FAN];  ///< false = from nowhere: all of the cell is buried
    bool sheltered[MAX_FAN];
} fan;

static fan fan_of(const rsv_elements *e, uint32_t node)
{
    fan f = { .begin = e->support_begin[node] };
    f.count = e->support_begin[node + 1] - f.begin;
    for (uint32_t s = 0; s < f.count && f.count <= MAX_FAN; s++) {
        uint32_t support = e->support[f.begin + s];
        rsv_cell_shape shape = rsv_cell_shape_of(e, support / 4);
        f.open[s] =
            rsv_cell_outlook(e->cell_openness[support / 4], &shape, support & 3, &f.place[s]);
        f.corner = shape.corner[support & 3];
        f.normal[s] = shape.normal;
        f.lift[s] = v3_length(
            v3_sub(rsv_cell_above(e->cell_openness[support / 4], &shape, f.corner), f.corner));
        f.sheltered[s] = e->cell_openness[support / 4] & RSV_CELL_SHELTERED;
    }
    return f;
}

/// Whether something is between two cells of a fan, or on one of them. A gap ends at cells inside it, also at folds. At
/// sharp folds, such as between a pot's side and its base, visibility is tested through a point above both cells. Cells
/// at gentle folds count as connected, because the straight line would run through the surface itself.
static bool is_walled(const rsv_transport_scene *scene, const fan *f, uint32_t a, uint32_t b)
{
    if (f->sheltered[a] != f->sheltered[b]) return true;
    float cosine = v3_dot(f->normal[a], f->normal[b]);
    if (cosine > 0.999f) return rsv_is_blocked(scene, f->place[a], f->place[b]);
    if (fabsf(cosine) > FOLD_COSINE) return false;
    rsv_vec3 before = v3_mad(v3_mad(f->corner, f->lift[a], f->normal[a]), f->lift[b], f->normal[b]);
    return rsv_is_blocked(scene, f->place[a], before) || rsv_is_blocked(scene, before, f->place[b]);
}

/// Groups the cells of a fan that see each other, directly or through others. Buried cells belong to no group and are
/// added to the first.
/// @param group [count], out @return number of groups
static uint32_t group_fan(
    const rsv_transport_scene *scene, const fan *f, uint32_t *group, uint64_t *rays)
{
    uint32_t groups = 0;
    memset(group, 0xff, f->count * sizeof *group);
    for (uint32_t start = 0; start < f->count; start++) {
        if (!f->open[start] && group[start] == RSV_NONE) group[start] = 0;
        if (group[start] != RSV_NONE) continue;
        uint32_t open[MAX_FAN], waiting = 0;
        open[waiting++] = start;
        group[start] = groups;
        while (waiting) {
            uint32_t here = open[--waiting];
            for (uint32_t s = 0; s < f->count; s++) {
                if (group[s] != RSV_NONE || !f->open[s]) continue;
                ++*rays;
                if (is_walled(scene, f, here, s)) continue;
                group[s] = groups;
                open[waiting++] = s;
            }
        }
        groups++;
    }
    return groups;
}

/// Whether any cell around a node does not see the first open one: rare, so the grouping is left to few nodes.
static bool is_divided(
    const rsv_transport_scene *scene, const rsv_elements *e, uint32_t node, uint64_t *rays)
{
    fan f = fan_of(e, node);
    if (f.count > MAX_FAN) return false;
    *rays += f.count;
    uint32_t first = 0;
    while (first < f.count && !f.open[first])
        first++;
    for (uint32_t s = first + 1; s < f.count; s++)
        if (f.open[s] && is_walled(scene, &f, first, s)) return true;
    return false;
}

/// Finds the sides of a node. @param side out: of each of its supports @return how many there are
static uint32_t find_sides(const rsv_transport_scene *scene, const rsv_elements *e, uint32_t node,
    uint8_t *side, uint64_t *rays)
{
    fan f = fan_of(e, node);
    uint32_t group[MAX_FAN], groups = group_fan(scene, &f, group, rays);
    for (uint32_t s = 0; s < f.count; s++)
        side[f.begin + s] = (uint8_t)group[s];
    return groups;
}

/// One node per side; fresh ones are numbered from *next on.
static void separate_node(
    rsv_elements *e, uint32_t node, const uint8_t *side, uint32_t sides, uint32_t *next)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        uint32_t support = e->support[s];
        if (side[s] > 0) e->cell_node[support / 4][support & 3] = *next + side[s] - 1;
    }
    *next += sides ? sides - 1 : 0;
}

/// Which sides of walls nodes have cells on.
typedef struct side_job {
    const rsv_transport_scene *scene;
    const rsv_elements *e;
    uint8_t *
        divided; ///< [node_count] non-zero where walls stand around a node; then, how many sides it has
    uint8_t *side; ///< [3 cell_count] of each support
    _Atomic uint64_t rays;
} side_job;

static void find_sides_of_nodes(void *user, rsv_span span)
{
    side_job *job = user;
    uint64_t rays = 0;
    for (size_t node = span.begin; node < span.end; node++)
        if (job->divided[node])
            job->divided[node] =
                (uint8_t)find_sides(job->scene, job->e, (uint32_t)node, job->side, &rays);
    atomic_fetch_add(&job->rays, rays);
}

/// @param divided [node_count] non-zero where walls stand around a node @param next out: number of nodes then
static rsv_status separate_nodes(const rsv_transport_scene *scene, rsv_elements *e,
    uint8_t *divided, uint32_t *next, uint64_t *rays)
{
    uint8_t *side = rsv_reserve(e->context, 3 * e->cell_count, 1);
    if (!side) return RSV_ERROR_MEMORY;
    side_job job = { scene, e, divided, side, 0 };
    rsv_parallel_for(e->context, e->node_count, 256, find_sides_of_nodes, &job);
    *next = (uint32_t)e->node_count;
    for (uint32_t node = 0; node < e->node_count; node++)
        if (divided[node]) separate_node(e, node, side, divided[node], next);
    *rays += job.rays;
    rsv_free(e->context, side);
    return RSV_OK;
}

/// The larger cell on whose edge a node hangs, and the corners of that edge.
typedef struct hanging_edge {
    uint32_t cell;
    uint8_t corner[2];
    bool walled; ///< off from the smaller cells
} hanging_edge;

static hanging_edge find_edge(const rsv_elements *e, const rsv_hanging *hanging)
{
    uint32_t p = hanging->parent[0];
    for (uint32_t s = e->support_begin[p]; s < e->support_begin[p + 1]; s++) {
        uint32_t cell = e->support[s] / 4;
        int corner = (int)(e->support[s] & 3);
        for (int k = 0; k < 3; k++)
            if (k != corner && e->cell_node[cell][k] == hanging->parent[1])
                return (hanging_edge){ cell, { (uint8_t)corner, (uint8_t)k }, false };
    }
    return (hanging_edge){ RSV_NONE, { 0, 0 }, false };
}

/// Whether a gap ends at the edge on which a node hangs: one of the cells about it lies in there, and another does not.
static bool hangs_at_gap(const rsv_elements *e, uint32_t node, uint32_t large)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if ((e->cell_openness[e->support[s] / 4] ^ e->cell_openness[large]) & RSV_CELL_SHELTERED)
            return true;
    return false;
}

/// Whether a wall keeps the open ends of an edge apart: what hangs between them is on one of its sides.
static bool is_edge_cut(const rsv_transport_scene *scene, uint8_t openness,
    const rsv_cell_shape *shape, const hanging_edge *edge)
{
    rsv_vec3 end[2];
    if (!(openness & RSV_CELL_CUT_THROUGH)) return false;
    for (int k = 0; k < 2; k++)
        end[k] =
            rsv_cell_above(openness, shape, rsv_cell_inset(shape, shape->corner[edge->corner[k]]));
    return rsv_is_blocked(scene, end[0], end[1]);
}

/// Whether a wall stands between the larger cell and the smaller ones that a hanging node belongs to.
static bool hangs_across_wall(const rsv_transport_scene *scene, const rsv_elements *e,
    const rsv_hanging *hanging, const hanging_edge *edge)
{
    if (hangs_at_gap(e, hanging->node, edge->cell)) return true;
    uint32_t support = e->support[e->support_begin[hanging->node]];
    rsv_cell_shape small = rsv_cell_shape_of(e, support / 4);
    rsv_cell_shape large = rsv_cell_shape_of(e, edge->cell);
    if (v3_dot(small.normal, large.normal) < 0.999f) return false;
    uint8_t on_small = e->cell_openness[support / 4], on_large = e->cell_openness[edge->cell];
    uint32_t corner = support & 3, from = (uint32_t)edge->corner[0], to = (uint32_t)edge->corner[1];
    rsv_vec3 near, far;
    if (!rsv_cell_outlook(on_small, &small, corner, &near) ||
        !rsv_cell_outlook(on_large, &large, from, &far))
        return false;
    if (on_small >> corner & on_large >> from & on_large >> to & 1) {
        if (is_edge_cut(scene, on_large, &large, edge)) return true;
        far = rsv_cell_above(on_large, &large, rsv_cell_inset(&large, small.corner[corner]));
    }
    return rsv_is_blocked(scene, near, far);
}

typedef struct edge_job {
    const rsv_transport_scene *scene;
    const rsv_elements *e;
    hanging_edge *edge; ///< [hanging_count], out
    _Atomic uint64_t rays;
} edge_job;

static void find_edges(void *user, rsv_span span)
{
    edge_job *job = user;
    const rsv_elements *e = job->e;
    uint64_t rays = 0;
    for (size_t h = span.begin; h < span.end; h++) {
        hanging_edge *edge = &job->edge[h];
        *edge = find_edge(e, &e->hanging[h]);
        edge->walled =
            edge->cell != RSV_NONE && (hangs_across_wall(job->scene, e, &e->hanging[h], edge) ||
                                          is_divided(job->scene, e, e->hanging[h].node, &rays));
    }
    atomic_fetch_add(&job->rays, rays);
}

/// Lets go of nodes that hang across a wall, or between whose cells one stands, and remembers the edges of the others.
static void release_hanging(
    const rsv_transport_scene *scene, rsv_elements *e, hanging_edge *edge, uint64_t *rays)
{
    edge_job job = { scene, e, edge, 0 };
    rsv_parallel_for(e->context, e->hanging_count, 256, find_edges, &job);
    size_t kept = 0;
    for (size_t h = 0; h < e->hanging_count; h++) {
        e->node_hanging[e->hanging[h].node] = edge[h].walled ? RSV_NONE : (uint32_t)kept;
        if (edge[h].walled) continue;
        e->hanging[kept] = e->hanging[h];
        edge[kept++] = edge[h];
    }
    e->hanging_count = kept;
    *rays += job.rays;
}

/// Parents follow the larger cell to its side of a wall.
static void reattach_hanging(rsv_elements *e, const hanging_edge *edge)
{
    for (size_t h = 0; h < e->hanging_count; h++)
        for (int p = 0; p < 2 && edge[h].cell != RSV_NONE; p++)
            e->hanging[h].parent[p] = e->cell_node[edge[h].cell][edge[h].corner[p]];
}

/// Around which nodes walls stand.
typedef struct division {
    const rsv_transport_scene *scene;
    const rsv_elements *earlier, *e;
    const uint8_t *undivided; ///< [node_count] known
    uint8_t *divided;         ///< [node_count], out
    rsv_team_place place;
    _Atomic uint64_t rays;
} division;

static void judge_nodes(void *user, rsv_span span)
{
    division *d = user;
    uint64_t rays = 0;
    for (size_t n = span.begin; n < span.end; n++) {
        uint32_t node = (uint32_t)n;
        if (!rsv_team_owns(d->place, node, RSV_TEAM_BLOCK)) continue;
        // walls took away some of the cells around each node that they divided: such have no twin
        bool known = d->undivided[node] ||
                     (d->earlier && rsv_elements_find_twin(d->e, node, d->earlier) != RSV_NONE);
        d->divided[node] = !known && d->e->node_hanging[node] == RSV_NONE &&
                           is_divided(d->scene, d->e, node, &rays);
    }
    atomic_fetch_add(&d->rays, rays);
}

rsv_status rsv_elements_separate(
    const rsv_transport_scene *scene, const rsv_elements *earlier, rsv_elements *e, uint64_t *rays)
{
    rsv_status status = rsv_elements_find_open_corners(scene, earlier, e, rays);
    if (status != RSV_OK) return status;
    hanging_edge *edge = rsv_alloc(e->context, e->hanging_count, sizeof *edge);
    uint8_t *divided = rsv_alloc(e->context, e->node_count, 1);
    uint8_t *undivided = rsv_alloc(e->context, e->node_count, 1);
    RSV_TRY(edge && divided && undivided ? RSV_OK : RSV_ERROR_MEMORY);
    const rsv_known_cells *known_cells = scene->known_cells;
    if (known_cells) RSV_TRY(known_cells->find_undivided(known_cells->user, e, undivided));
    size_t hanging_before = e->hanging_count;
    release_hanging(scene, e, edge, rays);
    division d = { scene, earlier, e, undivided, divided, rsv_team_place_of(e->context), 0 };
    rsv_parallel_for(e->context, e->node_count, 256, judge_nodes, &d);
    rsv_team_merge(e->context, divided, sizeof *divided, e->node_count, RSV_TEAM_BLOCK);
    uint64_t traced = rsv_team_total(e->context, d.rays) + hanging_before;
    uint32_t next;
    RSV_TRY(separate_nodes(scene, e, divided, &next, &traced));
    reattach_hanging(e, edge);
    *rays += traced;
    if (next > e->node_count || e->hanging_count < hanging_before)
        RSV_TRY(rsv_elements_renumber(e, next));
    RSV_TRY(rsv_elements_find_cuts(scene, e, rays));
    rsv_elements_find_node_areas(e);
cleanup:
    rsv_free(e->context, edge);
    rsv_free(e->context, divided);
    rsv_free(e->context, undivided);
    return status;
}
