/// Faces in the same place, in variants of a scene whose vertices move.
#include "../core/parallel.h"
#include "scene.h"
#include "twin_overlap.h"
#include "twins_owner.h"

#include <string.h>

/// Maximum number of moved triangles to compare with. If there are more in one place, hits search for them.
#define MOST_LOOKS 16384

/// Triangles of a run, which is left out as a whole where nothing moved near it.
#define RUN 256

static void *copy_bytes(rsv_context *context, const void *from, size_t bytes)
{
    void *copy = rsv_alloc(context, bytes, 1);
    if (copy) memcpy(copy, from, bytes);
    return copy;
}

rsv_status rsv_scene_copy_twins(rsv_scene *variant)
{
    const rsv_twins_owner *from = variant->twins;
    rsv_context *context = variant->context;
    variant->twins = NULL;
    if (!variant->view.twins) return RSV_OK;
    rsv_twins_owner *own = rsv_alloc(context, 1, sizeof *own);
    if (!own) return RSV_ERROR_MEMORY;
    *own = *from;
    own->run = NULL;
    own->tree.node =
        copy_bytes(context, from->tree.node, (from->tree.node_count + 1) * sizeof *from->tree.node);
    own->tree.face =
        copy_bytes(context, from->tree.face, from->tree.face_count * sizeof *from->tree.face);
    own->flags = copy_bytes(context, from->flags, variant->triangle_count);
    own->first_rival = own->rival = NULL; // they do not hold once triangles have moved
    own->twins.node = own->tree.node;
    own->twins.face = own->tree.face;
    own->twins.flags = own->flags;
    own->twins.first_rival = own->twins.rival = NULL;
    variant->twins = own;
    variant->view.twins = &own->twins;
    bool complete = own->tree.node && own->tree.face && own->flags;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_scene_release_twins(rsv_scene *scene)
{
    if (!scene->twins) return;
    rsv_twin_tree_destroy(&scene->twins->tree);
    rsv_free(scene->context, scene->twins->flags);
    rsv_free(scene->context, scene->twins->first_rival);
    rsv_free(scene->context, scene->twins->rival);
    rsv_free(scene->context, scene->twins->run);
    rsv_free(scene->context, scene->twins);
    scene->twins = NULL;
}

// ---- moves ----------------------------------------------------------------------------------------

/// The triangles that moved, and those that they meet.
typedef struct move {
    const rsv_scene *scene;
    const rsv_vec3 *home; ///< [vertex_count] where the vertices were
    rsv_twin_tree moved;  ///< of the triangles that did
    uint8_t *run_moved;   ///< [runs] whether some of its triangles did
    float reach, rounding;
    atomic_bool met,
        apart; ///< out: whether new flags were set, and whether faces lie apart by more than rounding
} move;

/// A triangle that may have met one that moved.
typedef struct met_face {
    uint32_t triangle;
    rsv_vec3 normal; ///< unit
    rsv_twin_node box;
    rsv_twin_margin margin;
} met_face;

static bool vertex_moved(const move *m, uint32_t vertex)
{
    rsv_vec3 now = m->scene->position[vertex], then = m->home[vertex];
    return now.x != then.x || now.y != then.y || now.z != then.z;
}

static rsv_twin_node box_at(const move *m, const rsv_vec3 *position, uint32_t triangle)
{
    const uint32_t *corner = m->scene->triangle[triangle];
    rsv_vec3 a = position[corner[0]], b = position[corner[1]], c = position[corner[2]];
    return (rsv_twin_node){ .low = v3_min(v3_min(a, b), c), .high = v3_max(v3_max(a, b), c) };
}

static rsv_twin_node box_of(const move *m, uint32_t triangle)
{
    return box_at(m, m->scene->position, triangle);
}

static met_face face_of(const move *m, uint32_t triangle)
{
    const rsv_scene_view *view = &m->scene->view;
    const uint32_t *corner = view->triangle[triangle];
    rsv_twin_plane plane = rsv_twin_plane_of(view, triangle);
    met_face f = { .triangle = triangle, .box = box_of(m, triangle) };
    f.margin = rsv_twin_margin_of(&plane, m->rounding, m->reach);
    rsv_triangle_normal(
        view->position[corner[0]], view->position[corner[1]], view->position[corner[2]], &f.normal);
    return f;
}

static void flag(move *m, uint32_t triangle, uint8_t flags)
{
    _Atomic uint8_t *own = (_Atomic uint8_t *)&m->scene->twins->flags[triangle];
    uint8_t before = atomic_fetch_or_explicit(own, flags, memory_order_relaxed);
    if ((before | flags) != before) m->met = true;
}

static void meet(move *m, const met_face *f, uint32_t triangle)
{
    const rsv_scene_view *view = &m->scene->view;
    met_face other = face_of(m, triangle);
    rsv_twin_overlap overlap;
    rsv_twin_margin margin = rsv_twin_margin_between(f->margin, other.margin);
    if (triangle == f->triangle || fabsf(v3_dot(f->normal, other.normal)) < RSV_TWIN_PARALLEL ||
        !rsv_twins_overlap(view, (rsv_twin_face){ f->triangle, f->normal },
            (rsv_twin_face){ triangle, other.normal }, margin.reach, &overlap))
        return;
    flag(m, f->triangle, rsv_twin_flags(view, f->triangle, overlap.opposite));
    flag(m, triangle, rsv_twin_flags(view, triangle, overlap.opposite));
    if (overlap.gap > 0.25 * (double)margin.rounding) m->apart = true;
}

/// Compares a triangle with those around it that moved.
static void look_around(move *m, uint32_t triangle)
{
    const rsv_twin_tree *tree = &m->moved;
    met_face f = face_of(m, triangle);
    uint32_t looks = 0;
    for (uint32_t n = 0; n < tree->node_count && looks < MOST_LOOKS;) {
        const rsv_twin_node *node = &tree->node[n];
        bool meets = rsv_twin_boxes_meet(&f.box, node, m->reach + m->rounding);
        if (meets && node->next == n + 1)
            for (uint32_t k = node->first; k < node[1].first; k++, looks++)
                meet(m, &f, tree->face[k]);
        n = meets ? n + 1 : node->next;
    }
    if (looks >= MOST_LOOKS)
        flag(m, triangle, RSV_TWIN_OVER_FRONT | RSV_TWIN_OVER_BACK | RSV_TWIN_OPPOSITE);
}

/// Triangles that did not move are in the box of their run.
static void look_around_runs(void *data, rsv_span span)
{
    move *m = data;
    const rsv_twin_node *moved = &m->moved.node[0];
    float reach = m->reach + m->rounding;
    for (size_t r = span.begin; r < span.end; r++) {
        if (!m->run_moved[r] && !rsv_twin_boxes_meet(&m->scene->twins->run[r], moved, reach))
            continue;
        for (size_t t = RUN * r; t < RUN * (r + 1) && t < m->scene->triangle_count; t++) {
            rsv_twin_node box = box_of(m, (uint32_t)t);
            if (rsv_twin_boxes_meet(&box, moved, reach)) look_around(m, (uint32_t)t);
        }
    }
}

static size_t count_runs(const rsv_scene *scene) { return (scene->triangle_count + RUN - 1) / RUN; }

static void fit_runs(void *data, rsv_span span)
{
    const move *m = data;
    for (size_t r = span.begin; r < span.end; r++) {
        rsv_twin_node run = box_at(m, m->home, (uint32_t)(RUN * r));
        for (size_t t = RUN * r + 1; t < RUN * (r + 1) && t < m->scene->triangle_count; t++) {
            rsv_twin_node box = box_at(m, m->home, (uint32_t)t);
            run.low = v3_min(run.low, box.low);
            run.high = v3_max(run.high, box.high);
        }
        m->scene->twins->run[r] = run;
    }
}

/// Room for flags, and the runs' boxes.
static rsv_status prepare(rsv_scene *scene, move *m)
{
    rsv_context *context = scene->context;
    size_t runs = count_runs(scene);
    if (!scene->twins) {
        scene->twins = rsv_alloc(context, 1, sizeof *scene->twins);
        if (!scene->twins) return RSV_ERROR_MEMORY;
        rsv_twins_limits(&scene->view, &scene->twins->twins.reach, &scene->twins->twins.rounding);
    }
    rsv_twins_owner *owner = scene->twins;
    if (!owner->flags) owner->flags = rsv_alloc(context, scene->triangle_count, 1);
    if (!owner->run) {
        owner->run = rsv_alloc(context, runs, sizeof *owner->run);
        if (owner->run) rsv_parallel_for(context, runs, 0, fit_runs, m);
    }
    m->run_moved = rsv_alloc(context, runs, 1);
    return owner->flags && owner->run && m->run_moved ? RSV_OK : RSV_ERROR_MEMORY;
}

static const rsv_vec3 *home_of(const rsv_scene *scene)
{
    while (scene->base)
        scene = scene->base;
    return scene->position;
}

/// Lists the triangles that moved, and marks their runs. @param face [triangle_count] out @return their number
static uint32_t list_moved(const move *m, uint32_t *face)
{
    const rsv_scene *scene = m->scene;
    uint32_t count = 0, first = 0, end = (uint32_t)scene->vertex_count;
    while (first < end && !vertex_moved(m, first))
        first++;
    while (first < end && !vertex_moved(m, end - 1))
        end--;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        bool moved = false;
        for (int k = 0; k < 3 && !moved; k++) {
            uint32_t vertex = scene->triangle[t][k];
            moved = vertex >= first && vertex < end && vertex_moved(m, vertex);
        }
        if (!moved) continue;
        face[count++] = t;
        m->run_moved[t / RUN] = 1;
    }
    return count;
}

/// The tree of moved triangles. It is usually small compared with the scene, and built each time.
static rsv_status plant_moved(move *m)
{
    const rsv_scene *scene = m->scene;
    rsv_status status = RSV_OK;
    uint32_t *face = rsv_reserve(scene->context, scene->triangle_count, sizeof *face);
    if (!face) return RSV_ERROR_MEMORY;
    uint32_t count = list_moved(m, face);
    if (count)
        status = rsv_twin_tree_create(scene->context, &scene->view, face, count, NULL, &m->moved);
    rsv_free(scene->context, face);
    return status;
}

void rsv_scene_fit_twins(rsv_scene *scene)
{
    if (scene->owns_positions && scene->view.twins)
        rsv_twin_tree_fit(&scene->view, &scene->twins->tree);
}

rsv_status rsv_scene_move_twins(rsv_scene *scene)
{
    rsv_status status;
    move m = { .scene = scene, .home = home_of(scene) };
    if (!scene->owns_positions) return RSV_OK;
    RSV_TRY(prepare(scene, &m));
    rsv_twins_owner *owner = scene->twins;
    rsv_scene_fit_twins(scene);
    m.reach = owner->twins.reach;
    m.rounding = owner->twins.rounding;
    RSV_TRY(plant_moved(&m));
    if (m.moved.node_count)
        rsv_parallel_for(scene->context, count_runs(scene), 16, look_around_runs, &m);
    if (m.apart) owner->twins.extent = RSV_TWIN_CLEAR * 0x1p20f;
    if (m.met) RSV_TRY(rsv_twins_plant(scene));
    status = RSV_OK;
cleanup:
    rsv_twin_tree_destroy(&m.moved);
    rsv_free(scene->context, m.run_moved);
    return status;
}
