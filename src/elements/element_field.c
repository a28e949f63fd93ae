/// Fields on elements: sampling a node's hat function, constraints, averages.
#include "elements_internal.h"

#include "../core/parallel.h"
#include "elements_constants.h"

#include <string.h>

/// Barycentric weight of a corner with density proportional to itself over a triangle: the inverse of the
/// distribution function 3 b^2 - 2 b^3.
static float sample_hat(float x) { return 0.5f - sinf(asinf(1 - 2 * x) / 3); }

/// The place on the face where the hat function of a cell's corner k has weight b, and the next corner c.
static rsv_support_point place_in_cell(const rsv_elements *e, uint32_t support, float b, float c)
{
    const rsv_cell *cell = &e->cell[support / 4];
    int k = (int)(support & 3);
    float u0, v0, u1, v1, u2, v2, rest = 1 - b - c;
    rsv_cell_corner(cell, k, &u0, &v0);
    rsv_cell_corner(cell, (k + 1) % 3, &u1, &v1);
    rsv_cell_corner(cell, (k + 2) % 3, &u2, &v2);
    return (rsv_support_point){ support, b * u0 + c * u1 + rest * u2, b * v0 + c * v1 + rest * v2 };
}

void rsv_elements_place_node(
    const rsv_elements *e, uint32_t node, uint32_t *face, float *u, float *v)
{
    const float inset = 0.02f;
    uint32_t support = e->support[e->support_begin[node]];
    rsv_support_point place = place_in_cell(e, support, 1 - 2 * inset, inset);
    *face = e->cell[support / 4].face;
    *u = place.u;
    *v = place.v;
}

rsv_surface_point rsv_elements_node_point(
    const rsv_scene_view *scene, const rsv_elements *e, uint32_t node)
{
    uint32_t face = e->node_face[node];
    float u = 1.0f / 3, v = u; // of one that buried neighbours left without a cell
    if (e->support_begin[node] < e->support_begin[node + 1]) {
        uint32_t support = e->support[e->support_begin[node]];
        const rsv_cell *cell = &e->cell[support / 4];
        face = cell->face;
        rsv_cell_corner(cell, (int)(support & 3), &u, &v);
    }
    return rsv_surface_point_at(scene, e->face_triangle[face], u, v, e->face_back[face]);
}

/// Goes through the cells around a node, and then through those around each node that follows it.
typedef struct support_walk {
    const rsv_elements *elements;
    uint32_t lot, lots;    ///< followers visited, the node itself ahead of them
    uint32_t support, end; ///< of the lot in hand
    float weight;          ///< of the node's value in that of the follower
} support_walk;

static void enter_lot(support_walk *w, uint32_t node, float weight)
{
    w->support = w->elements->support_begin[node];
    w->end = w->elements->support_begin[node + 1];
    w->weight = weight;
}

static support_walk walk_support(const rsv_elements *e, uint32_t node)
{
    support_walk w = { .elements = e };
    if (e->led_begin) {
        w.lot = e->led_begin[node];
        w.lots = e->led_begin[node + 1];
    }
    enter_lot(&w, node, 1);
    return w;
}

static float area_in_hand(const support_walk *w)
{
    return w->weight * rsv_cell_area(w->elements, w->elements->support[w->support] / 4);
}

static bool walk_on(support_walk *w)
{
    if (++w->support < w->end) return true;
    if (w->lot == w->lots) {
        w->support--; // rounding must not lead beyond the last one
        return false;
    }
    const rsv_led *led = &w->elements->led[w->lot++];
    enter_lot(w, led->follower, led->weight);
    return true;
}

void rsv_elements_visit_support(const rsv_elements *e, uint32_t node,
    void (*visit)(void *user, uint32_t support, float weight), void *user)
{
    if (e->support_begin[node] == e->support_begin[node + 1]) return;
    support_walk walk = walk_support(e, node);
    do
        visit(user, e->support[walk.support], walk.weight);
    while (walk_on(&walk));
}

/// Area of everything whose light a node receives, in so far as it does.
static float support_area(const rsv_elements *e, uint32_t node)
{
    support_walk walk = walk_support(e, node);
    float area = 0;
    do
        area += area_in_hand(&walk);
    while (walk_on(&walk));
    return area;
}

/// Whether a node is the cell's own corner k, and not one that stands in for a buried corner.
static bool is_own_corner(const rsv_elements *e, uint32_t node, uint32_t cell, uint32_t k)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (e->support[s] == 4 * cell + k) return true;
    return false;
}

uint32_t rsv_elements_find_around(const rsv_elements *coarser, const rsv_cell *cell)
{
    float u[3], v[3], weight[3];
    for (int k = 0; k < 3; k++)
        rsv_cell_corner(cell, k, &u[k], &v[k]);
    return rsv_elements_locate(
        coarser, cell->face, (u[0] + u[1] + u[2]) / 3, (v[0] + v[1] + v[2]) / 3, weight);
}

uint32_t rsv_elements_find_slot(const rsv_elements *other, const rsv_cell *cell)
{
    uint32_t level = other->face_level[cell->face];
    float u[3], v[3];
    if (cell->level < level) return RSV_NONE;
    for (int k = 0; k < 3; k++)
        rsv_cell_corner(cell, k, &u[k], &v[k]);
    rsv_triangle_place place =
        rsv_triangle_grid_find(1 << level, (u[0] + u[1] + u[2]) / 3, (v[0] + v[1] + v[2]) / 3);
    float b[3] = { place.b0, place.b1, place.b2 };
    uint32_t slot = other->face_slot[cell->face] + place.index;
    for (; level < cell->level; level++) {
        if (!(other->slot[slot] & RSV_SLOT_SPLIT)) return RSV_NONE;
        uint32_t child = 0;
        while (child < 3 && b[child] < 0.5f)
            child++;
        for (uint32_t k = 0; k < 3; k++)
            b[k] = child == 3 ? 1 - 2 * b[k] : k == child ? 2 * b[k] - 1 : 2 * b[k];
        slot = (other->slot[slot] & ~RSV_SLOT_SPLIT) + child;
    }
    return slot;
}

uint32_t rsv_elements_find_same_cell(const rsv_elements *other, const rsv_cell *cell)
{
    float u[3], v[3], weight[3];
    for (int k = 0; k < 3; k++)
        rsv_cell_corner(cell, k, &u[k], &v[k]);
    uint32_t found = rsv_elements_locate(
        other, cell->face, (u[0] + u[1] + u[2]) / 3, (v[0] + v[1] + v[2]) / 3, weight);
    return other->cell[found].level == cell->level ? found : RSV_NONE;
}

static bool is_same_cell(const rsv_cell *a, const rsv_cell *b)
{
    return a->face == b->face && a->i == b->i && a->j == b->j && a->level == b->level &&
           a->flipped == b->flipped;
}

/// Whether a corner of a cell at a node of other elements is the one given. Looking at all of these few takes less than
/// looking for the cell.
static bool has_corner(const rsv_elements *e, uint32_t node, const rsv_cell *cell, uint32_t corner)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if ((e->support[s] & 3) == corner && is_same_cell(&e->cell[e->support[s] / 4], cell))
            return true;
    return false;
}

/// Whether the cells around a node are those around a node of other elements, corner by corner.
static bool has_same_cells(
    const rsv_elements *e, uint32_t node, const rsv_elements *other, uint32_t twin)
{
    uint32_t begin = e->support_begin[node], end = e->support_begin[node + 1];
    if (other->support_begin[twin + 1] - other->support_begin[twin] != end - begin) return false;
    for (uint32_t s = begin; s < end; s++)
        if (!has_corner(other, twin, &e->cell[e->support[s] / 4], e->support[s] & 3)) return false;
    return true;
}

uint32_t rsv_elements_find_twin(const rsv_elements *e, uint32_t node, const rsv_elements *other)
{
    uint32_t face, k = 0;
    float u, v, weight[3];
    rsv_elements_place_node(e, node, &face, &u, &v);
    uint32_t cell = rsv_elements_locate(other, face, u, v, weight);
    while (k < 3 && weight[k] <= 0.9f)
        k++;
    if (k == 3) return RSV_NONE;
    uint32_t twin = other->cell_node[cell][k];
    if (!is_own_corner(other, twin, cell, k)) return RSV_NONE;
    if (!has_same_cells(e, node, other, twin)) return RSV_NONE;
    // clusters are divided again
    float area = support_area(e, node);
    return fabsf(support_area(other, twin) - area) <= 1e-6f * area ? twin : RSV_NONE;
}

void rsv_elements_sample_support(
    const rsv_elements *e, uint32_t node, uint32_t count, uint32_t seed, rsv_support_point *points)
{
    rsv_elements_sample_support_as(e, node, rsv_elements_draw_of(e, node), count, seed, points);
}

void rsv_elements_sample_support_as(const rsv_elements *e, uint32_t node, uint32_t index,
    uint32_t count, uint32_t seed, rsv_support_point *points)
{
    uint32_t stream = rsv_hash2(seed, index);
    support_walk walk = walk_support(e, node);
    float total = support_area(e, node), below = 0, area = area_in_hand(&walk);
    for (uint32_t k = 0; k < count; k++) {
        float jitter = rsv_unit_float(rsv_hash(stream + k));
        float target = total * ((float)k + jitter) / (float)count;
        while (target >= below + area && walk_on(&walk)) {
            below += area;
            area = area_in_hand(&walk);
        }
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        float b = sample_hat(x);
        points[k] = place_in_cell(e, e->support[walk.support], b, (1 - b) * y);
    }
}

rsv_surface_entry rsv_elements_entry(const rsv_elements *e, uint32_t node,
    const rsv_support_point *sample, uint32_t count, uint32_t valid)
{
    uint32_t material = e->scene->triangle_material[e->face_triangle[e->node_face[node]]];
    rsv_surface_entry entry = rsv_surface_entry_of(material);
    for (uint32_t k = 0; k < count && rsv_coat_varies(e->scene, material); k++) {
        uint32_t triangle = e->face_triangle[e->cell[sample[k].support / 4].face];
        if (valid >> k & 1)
            rsv_surface_entry_add(&entry, e->scene, e->bsdf, triangle, sample[k].u, sample[k].v);
    }
    rsv_surface_entry_finish(&entry);
    return entry;
}

static void constrain_node(const rsv_hanging *hanging, rsv_rgb *value)
{
    rsv_rgb sum = rgb_scale(value[hanging->parent[0]], hanging->weight[0]);
    for (int p = 1; p < RSV_PARENTS; p++)
        sum = rgb_mad(sum, hanging->weight[p], value[hanging->parent[p]]);
    value[hanging->node] = sum;
}

/// A field and its result.
typedef struct field_job {
    const rsv_elements *e;
    const rsv_rgb *value;
    rsv_rgb *result;
} field_job;

static void constrain_followers(void *user, rsv_span span)
{
    const field_job *job = user;
    for (size_t h = span.begin; h < span.end; h++)
        constrain_node(&job->e->hanging[h], job->result);
}

void rsv_elements_constrain(const rsv_elements *e, rsv_rgb *value)
{
    // leaders are free, so that followers do not wait for each other
    field_job job = { e, value, value };
    size_t grain = e->follower_count > RSV_PARALLEL_NODES ? 0 : RSV_PARALLEL_NODES;
    rsv_parallel_for(e->context, e->follower_count, grain, constrain_followers, &job);
    for (size_t h = e->follower_count; h < e->hanging_count; h++)
        constrain_node(&e->hanging[h], value);
}

void rsv_elements_constrain_transpose(const rsv_elements *elements, size_t fields, rsv_rgb *weight)
{
    for (size_t h = elements->hanging_count; h-- > 0;) { // children come after their parents
        const rsv_hanging *hanging = &elements->hanging[h];
        rsv_rgb *own = weight + hanging->node * fields;
        for (int p = 0; p < RSV_PARENTS; p++) {
            rsv_rgb *parent = weight + hanging->parent[p] * fields;
            for (size_t f = 0; hanging->weight[p] != 0 && f < fields; f++)
                parent[f] = rgb_mad(parent[f], hanging->weight[p], own[f]);
        }
        memset(own, 0, fields * sizeof *own);
    }
}

static void average_nodes(void *user, rsv_span span)
{
    const field_job *job = user;
    const rsv_elements *e = job->e;
    const rsv_rgb *value = job->value;
    for (size_t node = span.begin; node < span.end; node++) {
        if (e->node_hanging[node] != RSV_NONE) continue; // constrained below
        rsv_rgb sum = rgb_gray(0);
        float weight = 0;
        for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
            const uint32_t *corner = e->cell_node[e->support[s] / 4];
            uint32_t k = e->support[s] & 3;
            if (corner[k] != node) continue; // bridged
            const float *side = rsv_cell_sides(e, e->support[s] / 4);
            float area = rsv_cell_area(e, e->support[s] / 4);
            sum = rgb_mad(sum, 0.5f * area, value[node]);
            for (uint32_t next = 1; next < 3; next++) {
                uint32_t other = (k + next) % 3;
                bool apart = side && side[k] * side[other] <= 0; // by a wall
                sum = rgb_mad(sum, 0.25f * area, value[apart ? node : corner[other]]);
            }
            weight += area;
        }
        job->result[node] = weight > 0 ? rgb_scale(sum, 1 / weight) : value[node];
    }
}

void rsv_elements_average(const rsv_elements *e, const rsv_rgb *value, rsv_rgb *average)
{
    field_job job = { e, value, average };
    rsv_parallel_for(e->context, e->node_count, 0, average_nodes, &job);
    rsv_elements_constrain(e, average);
}
