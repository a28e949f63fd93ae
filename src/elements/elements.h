/// Elements without UVs: piecewise linear functions on a subdivision of the scene's own triangles.
///
/// A *face* is one scattering side of a triangle. Each face has a regular barycentric grid with 2^level cells along an
/// edge (after Yuksel's mesh colors), and any cell may be split further, 4-to-1. The corners of cells are *nodes*. A
/// node is the same as an element: the hat function that is 1 at the node and 0 at its neighbours. Faces that meet
/// smoothly and have the same material share the nodes along their common edge; nodes are separate across creases and
/// material borders.
///
/// Where a large cell meets smaller ones, the nodes in the middle of its edge *hang*: their value is the linear
/// interpolant along that edge, so the field is continuous.
#ifndef RSV_ELEMENTS_H
#define RSV_ELEMENTS_H

#include "../core/core.h"
#include "../core/triangle_grid.h"
#include "../surface/entry.h"

/// Approximate number of nodes added by splitting a cell, without those shared with neighbours.
#define RSV_NODES_PER_SPLIT 2
/// Splits halve cells, so the cells of a goal may be larger than requested by this factor.
#define RSV_GROWTH_TOLERANCE 1.4f
/// Nodes below which waking the threads takes longer than the work.
#define RSV_PARALLEL_NODES 16384

#define RSV_MAX_LEVEL 14 ///< cells along an edge: at most 2^14, all levels together

/// A triangle of the subdivision in barycentric lattice coordinates (i, j) of its level: an upright cell
/// has corners (i, j), (i+1, j), (i, j+1); a flipped one (i+1, j+1), (i, j+1), (i+1, j).
typedef struct rsv_cell {
    uint32_t face;
    uint16_t i, j;
    uint8_t level, flipped;
} rsv_cell;

#define RSV_PARENTS 4

/// A node whose value is the weighted mean of other nodes: of two if it hangs on the edge of a larger cell, of up to
/// four if its mesh is finer than required (cluster.h).
typedef struct rsv_hanging {
    uint32_t node, parent[RSV_PARENTS];
    float weight[RSV_PARENTS]; ///< sum 1; parents of weight 0 count for nothing
} rsv_hanging;

/// A node that follows a leader (cluster.h), and the weight of the leader's value in its own.
typedef struct rsv_led {
    uint32_t follower;
    float weight;
} rsv_led;

typedef struct rsv_elements {
    rsv_context *context;
    uint32_t references; ///< holders; rsv_elements_destroy by the last one frees
    const rsv_scene_view *scene;
    const rsv_bsdf *bsdf; ///< [material_count], borrowed
    float spacing;        ///< requested distance between nodes, metres

    uint32_t *face_of[2]; ///< [triangle_count] front and back; RSV_NONE = does not scatter
    size_t face_count;
    uint32_t *face_triangle; ///< [face_count]
    uint8_t *face_back;      ///< [face_count]
    uint8_t *face_level;     ///< [face_count] of the regular grid
    uint8_t *face_halvings;  ///< [face_count] of the radius of clusters there (cluster.h)
    uint32_t *face_slot;     ///< [face_count] first slot of the grid
    float *face_area;        ///< [face_count] m2
    uint32_t (
        *face_corner)[3];     ///< [face_count] welded corners: equal where faces continue smoothly
    uint32_t (*face_edge)[3]; ///< [face_count] welded edges 0-1, 0-2, 1-2

    uint32_t *slot; ///< a cell, or RSV_SLOT_SPLIT | first of the four slots of its children
    size_t slot_count;
    uint8_t *slot_openness; ///< [slot_count] openness of cells before they were split, with
                            ///< RSV_OPENNESS_KNOWN; NULL = of none

    size_t cell_count;
    rsv_cell *cell;           ///< [cell_count]
    uint32_t (*cell_node)[3]; ///< [cell_count]
    uint8_t *cell_openness;   ///< [cell_count] open_corners.h; NULL = not judged
    uint32_t *cell_cut;       ///< [cell_count] index into `cut_side`, RSV_NONE; NULL = none is cut
    /// [cut_count] at the corners of a cell that a wall cuts, a linear function that is positive on one side of the wall
    /// and negative on the other; 0 = in the wall (cut_cells.h)
    float (*cut_side)[3];
    size_t cut_count;

    size_t node_count;   ///< on surfaces, and behind them those of `voxels`
    uint32_t *node_face; ///< [node_count] one of the faces around the node; RSV_NONE in the air
    float *node_area;    ///< [node_count] integral of the hat, m2; hanging nodes: 0, their share is
                         ///< in the parents
    uint32_t *support_begin; ///< [node_count + 1]
    uint32_t *support;       ///< cell * 4 + corner, the cells around each node

    float cluster_radius;  ///< metres, before halvings; 0 = no clusters yet
    size_t follower_count; ///< the first of `hanging` follow leaders, the others hang on edges
    size_t hanging_count;
    rsv_hanging *hanging;   ///< parents before children
    uint32_t *node_hanging; ///< [node_count] index into `hanging`, RSV_NONE = free node
    uint32_t *led_begin;    ///< [node_count + 1] into `led`; NULL = no clusters
    rsv_led *led;           ///< those that follow each node
    uint32_t *
        node_draw; ///< [node_count] number that selects the random numbers of each node's points: that of an
                   ///< earlier version of the scene; NULL = its own
    struct rsv_voxels *voxels; ///< of the fog in the air (voxels.h); NULL = it is clear
} rsv_elements;

#define RSV_SLOT_SPLIT 0x80000000u

struct rsv_spacing; // spacing.h

/// Nodes on surfaces: the first ones. Those behind them lie in the air and have no support.
size_t rsv_elements_surface_nodes(const rsv_elements *elements);

/// Cells of about that spacing on every face with a diffuse lobe, larger ones where it lies in the open.
rsv_status rsv_elements_create(const rsv_scene *scene, const rsv_bsdf *bsdf,
    const struct rsv_spacing *spacing, rsv_elements **elements);

/// The same elements with the marked cells split 4-to-1, and further cells where needed so that cells
/// that share an edge differ by one level at most.
/// @param split [cell_count of `coarser`]; non-zero = split
rsv_status rsv_elements_refine(
    const rsv_elements *coarser, const uint8_t *split, rsv_elements **elements);

/// Marks cells to split. @param elements with cells only @param split [cell_count], zeros
typedef void (*rsv_split_chooser)(void *user, const rsv_elements *elements, uint8_t *split);

/// The same, the cells being split again and again until none is chosen.
rsv_status rsv_elements_refine_where(
    const rsv_elements *coarser, rsv_split_chooser choose, void *user, rsv_elements **elements);

/// Finds the areas of faces and nodes again after triangles changed their sizes.
void rsv_elements_find_areas(rsv_elements *elements);

/// Rebuilds supports after cell_node was changed to use `node_count` nodes; fresh nodes do not hang.
rsv_status rsv_elements_renumber(rsv_elements *elements, size_t node_count);

/// The same elements of the same triangles of another scene. @param scene, bsdf borrowed
rsv_status rsv_elements_copy(const rsv_elements *elements, const rsv_scene_view *scene,
    const rsv_bsdf *bsdf, rsv_elements **copy);

/// Adds an owner of the same elements; every owner destroys them once. @param elements NULL is allowed
rsv_elements *rsv_elements_retain(rsv_elements *elements);
void rsv_elements_destroy(rsv_elements *elements);

/// Memory they take.
size_t rsv_elements_bytes(const rsv_elements *elements);

/// As in cut_side, of a cell; NULL = no wall cuts it.
RSV_INLINE const float *rsv_cell_sides(const rsv_elements *elements, uint32_t cell)
{
    if (!elements->cell_cut || elements->cell_cut[cell] == RSV_NONE) return NULL;
    return elements->cut_side[elements->cell_cut[cell]];
}

/// At a place in a cell that a wall cuts, weights of the corners on that side of the wall alone.
RSV_INLINE void rsv_keep_side(const float side[3], float weight[3])
{
    float here = side[0] * weight[0] + side[1] * weight[1] + side[2] * weight[2], sum = 0;
    int kept = 0;
    for (int k = 2; k >= 0; k--) {
        int is_kept = here < 0 ? side[k] < 0 : side[k] > 0;
        kept = is_kept ? k : kept;
        weight[k] = is_kept ? weight[k] : 0;
        sum += weight[k];
    }
    for (int k = 0; k < 3; k++)
        weight[k] = sum > 0 ? weight[k] / sum : (float)(k == kept);
}

/// Cell that contains barycentric (u, v) of `face`, and the weights of its three nodes there.
RSV_INLINE uint32_t rsv_elements_locate(
    const rsv_elements *elements, uint32_t face, float u, float v, float weight[3])
{
    rsv_triangle_place place = rsv_triangle_grid_find(1 << elements->face_level[face], u, v);
    float b0 = place.b0, b1 = place.b1, b2 = place.b2;
    uint32_t slot = elements->slot[elements->face_slot[face] + place.index];
    while (slot & RSV_SLOT_SPLIT) { // by arithmetic: no processor predicts which child it is
        int at_0 = b0 >= 0.5f, at_1 = (b1 >= 0.5f) & !at_0, at_2 = (b2 >= 0.5f) & !at_0 & !at_1;
        int middle = 1 - at_0 - at_1 - at_2;
        float scale = (float)(2 - 4 * middle);
        b0 = scale * b0 + (float)(middle - at_0);
        b1 = scale * b1 + (float)(middle - at_1);
        b2 = scale * b2 + (float)(middle - at_2);
        slot = elements->slot[(slot & ~RSV_SLOT_SPLIT) + (uint32_t)(at_1 + 2 * at_2 + 3 * middle)];
    }
    weight[0] = f_min(f_max(b0, 0), 1);
    weight[1] = f_min(f_max(b1, 0), 1 - weight[0]);
    weight[2] = 1 - weight[0] - weight[1];
    const float *side = rsv_cell_sides(elements, slot);
    if (side) rsv_keep_side(side, weight);
    return slot;
}

/// Linear interpolation of `value` [node_count].
RSV_INLINE rsv_rgb rsv_elements_interpolate(
    const rsv_elements *elements, const rsv_rgb *value, uint32_t face, float u, float v)
{
    float w[3];
    const uint32_t *node = elements->cell_node[rsv_elements_locate(elements, face, u, v, w)];
    return rgb_mad(
        rgb_mad(rgb_scale(value[node[0]], w[0]), w[1], value[node[1]]), w[2], value[node[2]]);
}

/// Mean of the interpolated field over each node's hat function. @param average [node_count], not `value`
void rsv_elements_average(const rsv_elements *elements, const rsv_rgb *value, rsv_rgb *average);

/// Replaces the values of hanging nodes by their interpolants.
void rsv_elements_constrain(const rsv_elements *elements, rsv_rgb *value);

/// The transposed of that: hands weights on hanging nodes to their parents and leaves 0. @param weight [node_count x
/// fields]
void rsv_elements_constrain_transpose(const rsv_elements *elements, size_t fields, rsv_rgb *weight);

/// One of the cell's nodes, drawn with its weight as probability. It may hang: values of hanging nodes are
/// kept up to date by rsv_elements_constrain.
/// @param random uniform in [0, 1)
RSV_INLINE uint32_t rsv_elements_pick_node(
    const rsv_elements *elements, uint32_t cell, const float weight[3], float random)
{
    int k = random < weight[0] ? 0 : random < weight[0] + weight[1] ? 1 : 2;
    return elements->cell_node[cell][k];
}

/// Corner `k` of a cell in barycentric coordinates of its face.
RSV_INLINE void rsv_cell_corner(const rsv_cell *cell, int k, float *u, float *v)
{
    float size = 1.0f / (float)(1 << cell->level);
    int di = cell->flipped ? k != 1 : k == 1, dj = cell->flipped ? k != 2 : k == 2;
    *u = (float)(cell->i + di) * size;
    *v = (float)(cell->j + dj) * size;
}

/// The children of a cell: 0..2 keep a corner of the parent, 3 is the middle one, turned over.
rsv_cell rsv_child_cell(rsv_cell parent, int k);

/// Area of a cell, m2.
RSV_INLINE float rsv_cell_area(const rsv_elements *elements, uint32_t cell)
{
    const rsv_cell *c = &elements->cell[cell];
    return elements->face_area[c->face] / (float)(1u << (2 * c->level));
}

/// Where to find a node on other elements of the same faces: its place, pulled a little into one of its own
/// cells, so that a lookup does not end on the far side of a wall that runs along the cell's edge.
void rsv_elements_place_node(
    const rsv_elements *elements, uint32_t node, uint32_t *face, float *u, float *v);

/// Where a node is. @param scene the elements' own or a variant of it
rsv_surface_point rsv_elements_node_point(
    const rsv_scene_view *scene, const rsv_elements *elements, uint32_t node);

/// The cell of coarser elements of the same faces in which a cell lies.
uint32_t rsv_elements_find_around(const rsv_elements *coarser, const rsv_cell *cell);

/// The slot of a cell in other elements of the same faces, even if it is split there; RSV_NONE = it is part of a larger
/// cell.
uint32_t rsv_elements_find_slot(const rsv_elements *other, const rsv_cell *cell);

/// The very same cell of other elements of the same faces, or RSV_NONE.
uint32_t rsv_elements_find_same_cell(const rsv_elements *other, const rsv_cell *cell);

/// The node of other elements of the same faces with exactly the same cells around it, so that results for its support
/// remain valid; otherwise RSV_NONE. Either node may hang.
uint32_t rsv_elements_find_twin(
    const rsv_elements *elements, uint32_t node, const rsv_elements *other);

#define RSV_SUPPORT_POINTS 16 ///< receiver points over the support of a node, one per packet lane

/// A point of a node's support.
typedef struct rsv_support_point {
    uint32_t support; ///< cell * 4 + corner
    float u, v;       ///< place on the cell's face
} rsv_support_point;

/// Calls visit for each cell around a node and around those that follow it.
/// @param support cell * 4 + corner @param weight of the node's value in that of the corner
void rsv_elements_visit_support(const rsv_elements *elements, uint32_t node,
    void (*visit)(void *user, uint32_t support, float weight), void *user);

/// A stratified sample of a node's support with density proportional to its hat function, those of its followers
/// included in so far as they take its value. Points of one cell come one after the other.
/// Drawn by node_draw. @param seed differs between independent samples @param points [count]
void rsv_elements_sample_support(const rsv_elements *elements, uint32_t node, uint32_t count,
    uint32_t seed, rsv_support_point *points);
/// The same with the random numbers of a node of another index.
void rsv_elements_sample_support_as(const rsv_elements *elements, uint32_t node, uint32_t index,
    uint32_t count, uint32_t seed, rsv_support_point *points);

/// How light enters at a node. @param sample [count], of which those count whose bit of `valid` is set
rsv_surface_entry rsv_elements_entry(const rsv_elements *elements, uint32_t node,
    const rsv_support_point *sample, uint32_t count, uint32_t valid);

/// The number by which points of a node are drawn.
RSV_INLINE uint32_t rsv_elements_draw_of(const rsv_elements *elements, uint32_t node)
{
    return elements->node_draw ? elements->node_draw[node] : node;
}

#endif
