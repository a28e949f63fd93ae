#include "contact.h"

#include "../core/team.h"
#include "elements_internal.h"
#include "hover.h"

#include <string.h>

#define CONTACT_LEVELS 2
/// Smaller cells, as parts of the spacing, are left alone: they come from meshes finer than wanted.
#define CONTACT_SIZE 0.125f
/// A cell with honest corners on both sides of a wall interpolates through it: the line over which it does is
/// made thinner than it can be seen.
#define THIN_WALL_LEVELS 4
#define THIN_WALL_SIZE 0.03f
/// Nodes that splitting a cell adds beside those that it shares with its neighbours, about.
#define NODES_PER_SPLIT 2

typedef enum cut { CUT_NONE, CUT_CONTACT, CUT_THROUGH } cut;

/// How other geometry meets a cell: not at all, or by standing upon it, or so that corners which are not
/// buried are kept apart.
static cut classify(
    const rsv_transport_scene *scene, const rsv_elements *e, uint32_t cell, uint64_t *rays)
{
    rsv_cell_shape shape = rsv_cell_shape_of(e, cell);
    rsv_vec3 place[3];
    bool covered[3], blocked[3];
    cut found = CUT_NONE;
    *rays += 6;
    for (int k = 0; k < 3; k++) {
        place[k] = rsv_cell_hover(&shape, shape.corner[k]);
        covered[k] = rsv_is_covered(scene->tracer, &shape, shape.corner[k]);
    }
    if (covered[0] != covered[1] || covered[1] != covered[2]) found = CUT_CONTACT;
    for (int k = 0; k < 3; k++) {
        blocked[k] = rsv_is_blocked(scene->tracer, place[k], place[(k + 1) % 3]);
        if (blocked[k]) found = CUT_CONTACT;
    }
    if (found == CUT_NONE) return found;
    bool honest[3];
    for (int k = 0; k < 3; k++)
        honest[k] = !covered[k] && !rsv_is_buried(scene, place[k], shape.normal, cell, rays);
    for (int k = 0; k < 3; k++)
        if (blocked[k] && honest[k] && honest[(k + 1) % 3]) found = CUT_THROUGH;
    return found;
}

static float cell_size(const rsv_elements *e, uint32_t cell)
{
    return sqrtf(2 * rsv_cell_area(e, cell));
}

/// Whether a cell that is cut so is to be split once it went through so many splits.
/// @param size of the cell @param least smaller cells are left alone in any case
static bool is_worth_splitting(cut found, float size, float spacing, float least, uint32_t splits)
{
    if (found == CUT_THROUGH)
        return splits < THIN_WALL_LEVELS && size > f_max(least, THIN_WALL_SIZE * spacing);
    return found == CUT_CONTACT && splits < CONTACT_LEVELS &&
           size > f_max(least, CONTACT_SIZE * spacing);
}

/// Nodes that further splits would add if no cell below some size were split. What cuts a cell is taken for a line: it
/// meets twice as many cells of half the size.
static double nodes_for(const rsv_elements *e, const uint8_t *cuts, float least, uint32_t splits)
{
    double cells = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        float size = cell_size(e, c);
        for (uint32_t k = 0; is_worth_splitting(cuts[c], size, e->spacing, least, splits + k);
             k++) {
            cells += 1 << k;
            size /= 2;
        }
    }
    return NODES_PER_SPLIT * cells;
}

/// The size below which cells have to be left alone so that there are about `most_nodes` more at the most.
/// @param least size that is known to be too small @param splits that the cells went through
static float affordable_size(
    const rsv_elements *e, const uint8_t *cuts, size_t most_nodes, float least, uint32_t splits)
{
    while (nodes_for(e, cuts, least, splits) > (double)most_nodes)
        least *= 1.2f;
    return least;
}

/// @param cuts [cell_count], out
static void find_cuts(const rsv_transport_scene *scene, const rsv_elements *e, float least,
    uint8_t *cuts, uint64_t *rays)
{
    uint64_t traced = 0;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context)) \
    reduction(+ : traced)
    for (uint32_t c = 0; c < e->cell_count; c++)
        if (cell_size(e, c) > least && e->cell[c].level < RSV_MAX_LEVEL)
            cuts[c] = (uint8_t)classify(scene, e, c, &traced);
    *rays += traced;
}

rsv_status rsv_elements_refine_contacts(
    const rsv_transport_scene *scene, size_t most_nodes, rsv_elements **elements, uint64_t *rays)
{
    rsv_context *context = (*elements)->context;
    float least = THIN_WALL_SIZE * (*elements)->spacing;
    size_t most = (*elements)->node_count + most_nodes;
    for (uint32_t level = 0; level < THIN_WALL_LEVELS; level++) {
        const rsv_elements *e = *elements;
        uint8_t *split = rsv_alloc(context, e->cell_count, 1);
        if (!split) return RSV_ERROR_MEMORY;
        size_t marked = 0;
        find_cuts(scene, e, least, split, rays);
        size_t left = most > e->node_count ? most - e->node_count : 0;
        least = affordable_size(e, split, left, least, level);
        for (uint32_t c = 0; c < e->cell_count; c++) {
            split[c] = is_worth_splitting(split[c], cell_size(e, c), e->spacing, least, level);
            marked += split[c];
        }
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

#define MAX_FAN 32 ///< cells around a node; nodes with more are left alone

/// The cells around a node and where they hover next to it.
typedef struct fan {
    uint32_t begin, count;
    rsv_vec3 place[MAX_FAN], normal[MAX_FAN];
} fan;

static fan fan_of(const rsv_elements *e, uint32_t node)
{
    fan f = { .begin = e->support_begin[node] };
    f.count = e->support_begin[node + 1] - f.begin;
    for (uint32_t s = 0; s < f.count && f.count <= MAX_FAN; s++) {
        uint32_t support = e->support[f.begin + s];
        rsv_cell_shape shape = rsv_cell_shape_of(e, support / 4);
        f.place[s] = rsv_cell_hover(&shape, shape.corner[support & 3]);
        f.normal[s] = shape.normal;
    }
    return f;
}

/// Whether something stands between two cells of a fan. Across a fold the straight line would run through the
/// surface itself, so folded cells count as connected.
static bool is_walled(const rsv_tracer *tracer, const fan *f, uint32_t a, uint32_t b)
{
    return v3_dot(f->normal[a], f->normal[b]) > 0.999f &&
           rsv_is_blocked(tracer, f->place[a], f->place[b]);
}

/// Groups the cells of a fan that see each other, directly or by way of others.
/// @param group [count], out @return number of groups
static uint32_t group_fan(const rsv_tracer *tracer, const fan *f, uint32_t *group, uint64_t *rays)
{
    uint32_t groups = 0;
    memset(group, 0xff, f->count * sizeof *group);
    for (uint32_t start = 0; start < f->count; start++) {
        if (group[start] != RSV_NONE) continue;
        uint32_t open[MAX_FAN], waiting = 0;
        open[waiting++] = start;
        group[start] = groups;
        while (waiting) {
            uint32_t here = open[--waiting];
            for (uint32_t s = 0; s < f->count; s++) {
                if (group[s] != RSV_NONE) continue;
                ++*rays;
                if (is_walled(tracer, f, here, s)) continue;
                group[s] = groups;
                open[waiting++] = s;
            }
        }
        groups++;
    }
    return groups;
}

/// Whether any cell around a node does not see the first one: rare, so the grouping is left to few nodes.
static bool is_divided(
    const rsv_tracer *tracer, const rsv_elements *e, uint32_t node, uint64_t *rays)
{
    if (e->node_hanging[node] != RSV_NONE) return false;
    fan f = fan_of(e, node);
    if (f.count > MAX_FAN) return false;
    *rays += f.count;
    for (uint32_t s = 1; s < f.count; s++)
        if (is_walled(tracer, &f, 0, s)) return true;
    return false;
}

/// One node per side; fresh ones are numbered from *next on.
static void separate_node(
    const rsv_tracer *tracer, rsv_elements *e, uint32_t node, uint32_t *next, uint64_t *rays)
{
    fan f = fan_of(e, node);
    uint32_t group[MAX_FAN], groups = group_fan(tracer, &f, group, rays);
    for (uint32_t s = 0; s < f.count; s++) {
        uint32_t support = e->support[f.begin + s];
        if (group[s] > 0) e->cell_node[support / 4][support & 3] = *next + group[s] - 1;
    }
    *next += groups - 1;
}

/// The larger cell on whose edge a node hangs, and the corners of that edge.
typedef struct hanging_edge {
    uint32_t cell;
    int corner[2];
} hanging_edge;

static hanging_edge find_edge(const rsv_elements *e, const rsv_hanging *hanging)
{
    uint32_t p = hanging->parent[0];
    for (uint32_t s = e->support_begin[p]; s < e->support_begin[p + 1]; s++) {
        uint32_t cell = e->support[s] / 4;
        int corner = (int)(e->support[s] & 3);
        for (int k = 0; k < 3; k++)
            if (k != corner && e->cell_node[cell][k] == hanging->parent[1])
                return (hanging_edge){ cell, { corner, k } };
    }
    return (hanging_edge){ RSV_NONE, { 0, 0 } };
}

/// Whether a wall stands between the larger cell and the smaller ones that a hanging node belongs to.
static bool hangs_across_wall(const rsv_tracer *tracer, const rsv_elements *e,
    const rsv_hanging *hanging, const hanging_edge *edge)
{
    uint32_t support = e->support[e->support_begin[hanging->node]];
    rsv_cell_shape small = rsv_cell_shape_of(e, support / 4);
    rsv_cell_shape large = rsv_cell_shape_of(e, edge->cell);
    rsv_vec3 place = small.corner[support & 3];
    if (v3_dot(small.normal, large.normal) < 0.999f) return false;
    return rsv_is_blocked(tracer, rsv_cell_hover(&small, place), rsv_cell_hover(&large, place));
}

/// Lets go of nodes that hang across a wall and remembers the edges of the others.
static void release_hanging(const rsv_tracer *tracer, rsv_elements *e, hanging_edge *edge)
{
    size_t kept = 0;
    for (size_t h = 0; h < e->hanging_count; h++) {
        rsv_hanging hanging = e->hanging[h];
        hanging_edge found = find_edge(e, &hanging);
        bool released = found.cell != RSV_NONE && hangs_across_wall(tracer, e, &hanging, &found);
        e->node_hanging[hanging.node] = released ? RSV_NONE : (uint32_t)kept;
        if (released) continue;
        e->hanging[kept] = hanging;
        edge[kept++] = found;
    }
    e->hanging_count = kept;
}

/// Parents follow the larger cell to its side of a wall.
static void reattach_hanging(rsv_elements *e, const hanging_edge *edge)
{
    for (size_t h = 0; h < e->hanging_count; h++)
        for (int p = 0; p < 2 && edge[h].cell != RSV_NONE; p++)
            e->hanging[h].parent[p] = e->cell_node[edge[h].cell][edge[h].corner[p]];
}

rsv_status rsv_elements_separate(
    const rsv_tracer *tracer, const rsv_elements *earlier, rsv_elements *e, uint64_t *rays)
{
    hanging_edge *edge = rsv_alloc(e->context, e->hanging_count, sizeof *edge);
    uint8_t *divided = rsv_alloc(e->context, e->node_count, 1);
    if (!edge || !divided) {
        rsv_free(e->context, edge);
        rsv_free(e->context, divided);
        return RSV_ERROR_MEMORY;
    }
    size_t hanging_before = e->hanging_count;
    rsv_team_place place = rsv_team_place_of(e->context);
    uint64_t traced = 0;
    release_hanging(tracer, e, edge);
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context)) \
    reduction(+ : traced)
    for (uint32_t node = 0; node < e->node_count; node++) {
        if (!rsv_team_owns(place, node, RSV_TEAM_BLOCK)) continue;
        // walls took away some of the cells around each node that they divided: such have no twin
        bool whole = earlier && rsv_elements_find_twin(e, node, earlier) != RSV_NONE;
        divided[node] = !whole && is_divided(tracer, e, node, &traced);
    }
    rsv_team_merge(e->context, divided, sizeof *divided, e->node_count, RSV_TEAM_BLOCK);
    traced = rsv_team_total(e->context, traced) + hanging_before;
    uint32_t next = (uint32_t)e->node_count;
    for (uint32_t node = 0; node < e->node_count; node++)
        if (divided[node]) separate_node(tracer, e, node, &next, &traced);
    reattach_hanging(e, edge);
    *rays += traced;
    rsv_free(e->context, edge);
    rsv_free(e->context, divided);
    bool changed = next > e->node_count || e->hanging_count < hanging_before;
    return changed ? rsv_elements_renumber(e, next) : RSV_OK;
}
