/// Finds faces that lie in the same place.
#include "twins.h"

#include "../core/parallel.h"
#include "enclosed_lamps.h"
#include "scene.h"
#include "twin_body.h"
#include "twin_overlap.h"
#include "twins_owner.h"

#include <string.h>

/// Opposite faces may lie apart by this part of the scene's size: copies come out of programs of single precision.
#define REACH 0x1p-18f

/// Maximum number of other triangles that the four triangles of a leaf are compared with, and that they may find.
/// Beyond this (around the tip of a fan of a million slivers, or in a heap of inexact copies), time would grow with the
/// square. Such triangles are searched for at each hit instead.
#define MOST_LOOKS 16384
#define MOST_FOUND 128

/// Boxes that share no more than this part of an axis merely touch along it.
#define THIN 1e-4f

/// Points on a triangle that decide whether all of it is hidden, and on a lamp, whether part of it is.
#define PLACES 16
#define PLACES_OF_LAMP 256

/// A face, for quick looks.
typedef struct face_box {
    uint32_t triangle;
    rsv_vec3 low, high;
} face_box;

typedef struct finder {
    const rsv_scene *scene;
    const rsv_scene_view *view;
    rsv_twin_tree tree;
    uint8_t *flags; ///< [triangle_count]
    uint8_t
        *gave_up; ///< [tree.node_count] of leaves, whether they have not looked at all around them
    float reach, rounding; ///< see rsv_twins
    bool apart;            ///< out: some twins lie apart by more than rounding
} finder;

static void flag(const finder *f, uint32_t triangle, uint8_t flags)
{
    _Atomic uint8_t *known = (_Atomic uint8_t *)&f->flags[triangle];
    atomic_fetch_or_explicit(known, flags, memory_order_relaxed);
}

/// Results of a leaf.
typedef struct leaf_search {
    face_box box[RSV_TWIN_LEAF];    ///< its own triangles
    rsv_vec3 normal[RSV_TWIN_LEAF]; ///< theirs, unit
    uint32_t looks, found;
    bool apart;
} leaf_search;

uint8_t rsv_twin_flags(const rsv_scene_view *scene, uint32_t triangle, bool opposite)
{
    // a front is always seen before a back, unless it transmits light and the back does not
    bool sure = opposite && rsv_twin_is_opaque(scene, scene->triangle_material[triangle]);
    return (uint8_t)(RSV_TWIN_OVER_BACK | (sure ? 0 : RSV_TWIN_OVER_FRONT) |
                     (opposite ? RSV_TWIN_OPPOSITE : 0));
}

static rsv_twin_margin margin_of(const finder *f, uint32_t triangle)
{
    rsv_twin_plane plane = rsv_twin_plane_of(f->view, triangle);
    return rsv_twin_margin_of(&plane, f->rounding, f->reach);
}

static rsv_vec3 normal_of(const rsv_scene_view *view, uint32_t triangle)
{
    rsv_vec3 normal = { 0 };
    const uint32_t *corner = view->triangle[triangle];
    rsv_triangle_normal(
        view->position[corner[0]], view->position[corner[1]], view->position[corner[2]], &normal);
    return normal;
}

/// @param own of the leaf's triangles
static void compare(const finder *f, leaf_search *s, uint32_t own, uint32_t other)
{
    rsv_twin_overlap overlap;
    const rsv_twin_face face_a = { s->box[own].triangle, s->normal[own] };
    const rsv_twin_face face_b = { other, normal_of(f->view, other) };
    if (fabsf(v3_dot(face_a.normal, face_b.normal)) < RSV_TWIN_PARALLEL) return;
    rsv_twin_margin margin =
        rsv_twin_margin_between(margin_of(f, face_a.triangle), margin_of(f, other));
    if (!rsv_twins_overlap(f->view, face_a, face_b, margin.reach, &overlap)) return;
    flag(f, face_a.triangle, rsv_twin_flags(f->view, face_a.triangle, overlap.opposite));
    flag(f, face_b.triangle, rsv_twin_flags(f->view, face_b.triangle, overlap.opposite));
    s->found++;
    s->apart |= overlap.gap > 0.25 * (double)margin.rounding;
}

/// Parts of an axis that both boxes span.
static float shared_span(float low_a, float high_a, float low_b, float high_b)
{
    return f_min(high_a, high_b) - f_max(low_a, low_b);
}

/// Whether two faces may share more than an edge: their boxes do so along two axes at the least. Most neighbours do
/// not.
static bool may_overlap(const face_box *a, const face_box *b, float reach)
{
    float x = shared_span(a->low.x, a->high.x, b->low.x, b->high.x);
    float y = shared_span(a->low.y, a->high.y, b->low.y, b->high.y);
    float z = shared_span(a->low.z, a->high.z, b->low.z, b->high.z);
    if (f_min(x, f_min(y, z)) < -reach) return false;
    int wide = x > THIN * f_min(a->high.x - a->low.x, b->high.x - b->low.x);
    wide += y > THIN * f_min(a->high.y - a->low.y, b->high.y - b->low.y);
    wide += z > THIN * f_min(a->high.z - a->low.z, b->high.z - b->low.z);
    return wide >= 2;
}

static face_box box_of(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]], b = view->position[corner[1]],
             c = view->position[corner[2]];
    return (face_box){ triangle, v3_min(v3_min(a, b), c), v3_max(v3_max(a, b), c) };
}

static void compare_leaves(
    const finder *f, const rsv_twin_node *leaf, const rsv_twin_node *other, leaf_search *s)
{
    uint32_t count = leaf[1].first - leaf->first;
    for (uint32_t b = other->first; b < other[1].first; b++) {
        face_box box = box_of(f->view, f->tree.face[b]);
        uint32_t before = leaf == other ? b - leaf->first : count; // pairs of one leaf count once
        for (uint32_t a = 0; a < before; a++)
            if (may_overlap(&s->box[a], &box, f->reach)) compare(f, s, a, box.triangle);
        s->looks += count;
    }
}

/// Whether a triangle of the leaf may lie within a node: by its box, and by its plane, as boxes of slanting walls hold
/// whole rooms.
static bool may_lie_in(const finder *f, const leaf_search *s, uint32_t k, const rsv_twin_node *node)
{
    const face_box *box = &s->box[k];
    const rsv_twin_node own = { .low = box->low, .high = box->high };
    if (!rsv_twin_boxes_meet(&own, node, f->reach)) return false;
    rsv_vec3 to = v3_sub(node->low, f->view->position[f->view->triangle[box->triangle][0]]);
    rsv_vec3 size = v3_sub(node->high, node->low), n = s->normal[k];
    float near =
        v3_dot(n, to) + f_min(n.x * size.x, 0) + f_min(n.y * size.y, 0) + f_min(n.z * size.z, 0);
    float far =
        v3_dot(n, to) + f_max(n.x * size.x, 0) + f_max(n.y * size.y, 0) + f_max(n.z * size.z, 0);
    float slack = f->reach + f->rounding;
    return near <= slack && far >= -slack;
}

static bool leaf_meets(
    const finder *f, const leaf_search *s, const rsv_twin_node *leaf, const rsv_twin_node *node)
{
    if (!rsv_twin_boxes_meet(leaf, node, f->reach)) return false;
    for (uint32_t k = 0; k < leaf[1].first - leaf->first; k++)
        if (may_lie_in(f, s, k, node)) return true;
    return false;
}

static bool has_enough(const leaf_search *s)
{
    return s->looks > MOST_LOOKS || s->found > MOST_FOUND;
}

static leaf_search begin_search(const finder *f, const rsv_twin_node *leaf)
{
    leaf_search s = { 0 };
    for (uint32_t k = 0; k < leaf[1].first - leaf->first; k++) {
        s.box[k] = box_of(f->view, f->tree.face[leaf->first + k]);
        s.normal[k] = normal_of(f->view, s.box[k].triangle);
    }
    return s;
}

/// The surroundings of a leaf's triangles are unknown: hits search for duplicates.
static void take_all_flags(const finder *f, uint32_t own)
{
    const rsv_twin_tree *tree = &f->tree;
    for (uint32_t k = tree->node[own].first; k < tree->node[own + 1].first; k++)
        flag(f, tree->face[k], RSV_TWIN_OVER_FRONT | RSV_TWIN_OVER_BACK | RSV_TWIN_OPPOSITE);
}

/// Compares the triangles of a leaf with one another and with all around them in later leaves.
static leaf_search search_after(const finder *f, uint32_t own)
{
    const rsv_twin_tree *tree = &f->tree;
    const rsv_twin_node *leaf = &tree->node[own];
    leaf_search s = begin_search(f, leaf);
    for (uint32_t n = own; n < tree->node_count && !has_enough(&s);) {
        const rsv_twin_node *node = &tree->node[n];
        bool meets = n == own || leaf_meets(f, &s, leaf, node);
        if (meets && node->next == n + 1) compare_leaves(f, leaf, node, &s);
        n = meets ? n + 1 : node->next;
    }
    return s;
}

/// Compares the triangles of a leaf with those of earlier leaves that gave up.
static leaf_search search_before(const finder *f, uint32_t own)
{
    const rsv_twin_tree *tree = &f->tree;
    const rsv_twin_node *leaf = &tree->node[own];
    leaf_search s = begin_search(f, leaf);
    for (uint32_t n = 0; n < own && !has_enough(&s);) {
        const rsv_twin_node *node = &tree->node[n];
        bool meets = leaf_meets(f, &s, leaf, node);
        if (meets && f->gave_up[n]) compare_leaves(f, leaf, node, &s);
        n = meets ? n + 1 : node->next;
    }
    return s;
}

/// The search of all leaves.
typedef struct search_job {
    const finder *finder;
    leaf_search (*search)(const finder *f, uint32_t leaf);
    uint8_t *gave_up; ///< [tree.node_count] out: whether a leaf has not looked at all around it
    atomic_bool apart, some; ///< out: twins that lie apart, leaves that gave up
} search_job;

static void search_leaves(void *data, rsv_span span)
{
    search_job *job = data;
    const rsv_twin_tree *tree = &job->finder->tree;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        if (tree->node[n].next != n + 1) continue;
        leaf_search s = job->search(job->finder, n);
        if (s.apart) job->apart = true;
        if (!has_enough(&s)) continue;
        take_all_flags(job->finder, n);
        job->gave_up[n] = 1;
        job->some = true;
    }
}

static bool search_all(finder *f, leaf_search (*search)(const finder *, uint32_t), uint8_t *gave_up)
{
    search_job job = { f, search, gave_up, false, false };
    rsv_parallel_for(f->scene->context, f->tree.node_count, 256, search_leaves, &job);
    f->apart = f->apart || job.apart;
    return job.some;
}

static rsv_status find_pairs(finder *f)
{
    rsv_context *context = f->scene->context;
    uint8_t *again = rsv_alloc(context, f->tree.node_count, 1);
    if (!again) return RSV_ERROR_MEMORY;
    if (search_all(f, search_after, f->gave_up)) search_all(f, search_before, again);
    rsv_free(context, again);
    return RSV_OK;
}

/// Of the triangle that reaches farthest.
typedef struct reach_job {
    const finder *finder;
    _Atomic double reach, rounding; ///< out
} reach_job;

static void find_reach(void *data, rsv_span span)
{
    reach_job *job = data;
    rsv_twin_margin most = { 0, 0 };
    for (size_t k = span.begin; k < span.end; k++) {
        rsv_twin_margin own = margin_of(job->finder, job->finder->tree.face[k]);
        most.reach = f_max(most.reach, own.reach);
        most.rounding = f_max(most.rounding, own.rounding);
    }
    rsv_atomic_max(&job->reach, (double)most.reach);
    rsv_atomic_max(&job->rounding, (double)most.rounding);
}

static void narrow(finder *f)
{
    reach_job job = { f, 0, 0 };
    rsv_parallel_for(f->scene->context, f->tree.face_count, 0, find_reach, &job);
    f->reach = (float)job.reach;
    f->rounding = (float)job.rounding;
}

static rsv_status plant_tree(finder *f)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_context *context = f->scene->context;
    uint32_t count = (uint32_t)f->view->triangle_count;
    uint32_t *all = rsv_reserve(context, count, sizeof *all);
    if (!all) return RSV_ERROR_MEMORY;
    for (uint32_t t = 0; t < count; t++)
        all[t] = t;
    RSV_TRY(rsv_twin_tree_create(context, f->view, all, count, f->flags, &f->tree));
cleanup:
    rsv_free(context, all);
    return status;
}

void rsv_twins_limits(const rsv_scene_view *scene, float *reach, float *rounding)
{
    float size = v3_max_abs(v3_sub(scene->bounds_max, scene->bounds_min));
    float farthest = f_max(v3_max_abs(scene->bounds_min), v3_max_abs(scene->bounds_max));
    *rounding = RSV_TWIN_ROUNDING * farthest;
    *reach = f_max(REACH * size, 2 * *rounding);
}

static rsv_status finder_create(const rsv_scene *scene, finder *f)
{
    rsv_status status = RSV_ERROR_MEMORY;
    const rsv_scene_view *view = &scene->view;
    *f = (finder){ .scene = scene, .view = view };
    rsv_twins_limits(view, &f->reach, &f->rounding);
    f->flags = rsv_alloc(scene->context, view->triangle_count, 1);
    if (!f->flags) goto cleanup;
    RSV_TRY(plant_tree(f));
    f->gave_up = rsv_alloc(scene->context, f->tree.node_count, 1);
    if (!f->gave_up) RSV_TRY(RSV_ERROR_MEMORY);
    narrow(f);
cleanup:
    return status;
}

static void finder_destroy(finder *f)
{
    rsv_twin_tree_destroy(&f->tree);
    rsv_free(f->scene->context, f->gave_up);
    rsv_free(f->scene->context, f->flags);
}

// ---- results -------------------------------------------------------------------------------------

/// The faces seen at points spread over a triangle, by rays towards one of its sides.
typedef struct showing {
    bool some;      ///< of the triangle itself
    uint32_t other; ///< the face seen in its place; RSV_NONE = none
} showing;

static bool is_lamp(const rsv_scene_view *view, uint32_t triangle)
{
    const rsv_material *m = &view->material[view->triangle_material[triangle]];
    return !rgb_is_black(m->emission) && !m->unlit;
}

static showing look_at(const rsv_scene_view *view, uint32_t triangle, bool back)
{
    rsv_vec3 normal = rsv_twin_plane_of(view, triangle).normal;
    showing seen = { false, RSV_NONE };
    int places = is_lamp(view, triangle) ? PLACES_OF_LAMP : PLACES;
    for (int k = 0; k < places; k++) {
        // Hammersley's points, folded into the triangle
        float u = ((float)k + 0.5f) / (float)places, v = 0.5f / (float)places, digit = 0.5f;
        for (int n = k; n; n /= 2, digit /= 2)
            v += digit * (float)(n % 2);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        rsv_hit hit = { triangle, 0, u, v };
        rsv_twins_search(view, back ? normal : v3_neg(normal), &hit);
        if (hit.triangle == triangle)
            seen.some = true;
        else
            seen.other = hit.triangle < seen.other ? hit.triangle : seen.other;
    }
    return seen;
}

/// Whether a face that is seen in the place of a triangle's middle is so in all of its places: an exact copy, mostly.
static bool covers_all(const rsv_scene_view *view, uint32_t triangle, uint32_t other)
{
    if (view->material[view->triangle_material[other]].alpha_cutoff > 0) return false;
    rsv_twin_plane plane = rsv_twin_plane_of(view, other);
    float rounding = rsv_twin_rounding(&plane, view->twins->rounding);
    rsv_twin_limits limits = rsv_twin_limits_of(&plane, rounding, rounding);
    for (int k = 0; k < 3; k++) {
        float u, v;
        rsv_vec3 corner = view->position[view->triangle[triangle][k]];
        if (!rsv_twin_covers(&plane, &limits, corner, &u, &v)) return false;
    }
    return true;
}

/// The face seen at all points of a side of a triangle. One ray suffices for exact copies.
static showing look_once(const rsv_scene_view *view, uint32_t triangle, bool back)
{
    rsv_hit hit = { triangle, 0, 1 / 3.0f, 1 / 3.0f };
    rsv_vec3 normal = rsv_twin_plane_of(view, triangle).normal;
    rsv_twins_search(view, back ? normal : v3_neg(normal), &hit);
    if (hit.triangle != triangle && covers_all(view, triangle, hit.triangle))
        return (showing){ false, hit.triangle };
    // a face that shows its centre is not hidden
    if (hit.triangle == triangle && back && !is_lamp(view, triangle))
        return (showing){ true, RSV_NONE };
    return look_at(view, triangle, back);
}

/// Whether it is a guess which of two faces with the same orientation is meant to be visible. Lamps in the plane of a
/// ceiling are. Where there are faces of both windings, this is usual: things stand on the copy of a floor whose
/// outside nobody sees.

static bool is_guess(const rsv_scene_view *view, const uint8_t *flags, uint32_t t, uint32_t other)
{
    return other != RSV_NONE && view->triangle_material[t] != view->triangle_material[other] &&
           is_lamp(view, t) == is_lamp(view, other) &&
           !((flags[t] | flags[other]) & RSV_TWIN_OPPOSITE);
}

/// Lamps of which others hide a part.
static void note_parts(
    const rsv_twins_owner *owner, const rsv_scene_view *view, uint32_t triangle, showing seen)
{
    if (seen.some && seen.other != RSV_NONE && is_lamp(view, triangle))
        owner->flags[triangle] |= RSV_TWIN_PARTLY;
}

typedef struct hidden_job {
    const rsv_scene_view *view;
    rsv_twins_owner *owner;
    uint8_t
        *guessed; ///< [tree.face_count] out: whether another is shown in a face's place by a guess
} hidden_job;

static void look_at_faces(void *data, rsv_span span)
{
    const hidden_job *job = data;
    const rsv_scene_view *view = job->view;
    rsv_twins_owner *owner = job->owner;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t t = owner->tree.face[k];
        bool two = view->material[view->triangle_material[t]].double_sided;
        if (owner->flags[t] & RSV_TWIN_OVER_FRONT) {
            showing seen = look_once(view, t, false);
            if (!seen.some) owner->flags[t] |= RSV_TWIN_HIDDEN;
            job->guessed[k] = is_guess(view, owner->flags, t, seen.other);
            note_parts(owner, view, t, seen);
        }
        if (two) {
            showing seen = look_once(view, t, true);
            if (!seen.some) owner->flags[t] |= RSV_TWIN_BACK_HIDDEN;
            note_parts(owner, view, t, seen);
        }
    }
}

/// Marks the faces that others hide. @param guessed out: first in whose place others are shown by a guess; RSV_NONE =
/// none
static rsv_status find_hidden(rsv_scene *scene, rsv_twins_owner *owner, uint32_t *guessed)
{
    const rsv_twin_tree *tree = &owner->tree;
    hidden_job job = { &scene->view, owner, rsv_alloc(scene->context, tree->face_count, 1) };
    if (!job.guessed) return RSV_ERROR_MEMORY;
    rsv_parallel_for(scene->context, tree->face_count, 64, look_at_faces, &job);
    *guessed = RSV_NONE;
    for (uint32_t k = 0; k < tree->face_count; k++)
        if (job.guessed[k] && tree->face[k] < *guessed) *guessed = tree->face[k];
    rsv_free(scene->context, job.guessed);
    return RSV_OK;
}

static const char *object_of(const rsv_scene_view *view, uint32_t triangle)
{
    return view->object_name[view->triangle_object[triangle]];
}

static const char *material_of(const rsv_scene_view *view, uint32_t triangle)
{
    return view->material[view->triangle_material[triangle]].name;
}

static void warn_of_guess(const rsv_scene *scene, uint32_t guessed)
{
    const rsv_scene_view *view = &scene->view;
    if (scene->is_part || guessed == RSV_NONE) return;
    uint32_t shown = look_at(view, guessed, false).other;
    rsv_log(scene->context, RSV_LOG_WARNING,
        "objects '%s' and '%s': faces of materials '%s' and '%s' lie in the same place and "
        "face the same way; the latter are shown, which may be wrong: delete one of them",
        object_of(view, guessed), object_of(view, shown), material_of(view, guessed),
        material_of(view, shown));
}

/// Marks faces of bodies that look into them, where opposite ones lie in the same place.
static void find_inside_out(void *job, rsv_span span)
{
    const finder *f = job;
    const rsv_scene_view *view = f->view;
    float gap = 4 * (f->reach + f->rounding);
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t t = f->tree.face[k];
        if ((f->flags[t] & RSV_TWIN_OPPOSITE) && rsv_twin_is_body(view, view->triangle_material[t]))
            if (rsv_twin_is_inside_out(view, &f->tree, gap, t)) f->flags[t] |= RSV_TWIN_INSIDE_OUT;
    }
}

rsv_status rsv_twins_plant(rsv_scene *scene)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_twins_owner *owner = scene->twins;
    uint32_t count = 0, next = 0;
    for (size_t t = 0; t < scene->triangle_count; t++)
        count += owner->flags[t] && !(owner->flags[t] & RSV_TWIN_HIDDEN);
    uint32_t *face = rsv_reserve(scene->context, count, sizeof *face);
    if (!face) return RSV_ERROR_MEMORY;
    for (uint32_t t = 0; t < scene->triangle_count; t++)
        if (owner->flags[t] && !(owner->flags[t] & RSV_TWIN_HIDDEN)) face[next++] = t;
    scene->view.twins = NULL;
    rsv_twin_tree_destroy(&owner->tree);
    RSV_TRY(rsv_twin_tree_create(scene->context, &scene->view, face, count, NULL, &owner->tree));
    owner->twins.flags = owner->flags;
    owner->twins.node = owner->tree.node;
    owner->twins.face = owner->tree.face;
    owner->twins.node_count = owner->tree.node_count;
    owner->twins.face_count = owner->tree.face_count;
    scene->view.twins = &owner->twins;
cleanup:
    rsv_free(scene->context, face);
    return status;
}

static rsv_status keep(rsv_scene *scene, const finder *f)
{
    rsv_status status = RSV_ERROR_MEMORY;
    uint32_t guessed;
    rsv_context *context = scene->context;
    rsv_twins_owner *owner = scene->twins = rsv_alloc(context, 1, sizeof *owner);
    if (!owner) return RSV_ERROR_MEMORY;
    owner->flags = rsv_alloc(context, scene->triangle_count, 1);
    if (!owner->flags) goto cleanup;
    memcpy(owner->flags, f->flags, scene->triangle_count);
    owner->twins = (rsv_twins){ .reach = f->reach,
        .rounding = f->rounding,
        .extent = f->apart ? RSV_TWIN_CLEAR * 0x1p20f : 0 };
    RSV_TRY(rsv_twins_plant(scene));
    RSV_TRY(rsv_twins_find_rivals(scene));
    RSV_TRY(find_hidden(scene, owner, &guessed));
    warn_of_guess(scene, guessed);
cleanup:
    return status;
}

rsv_status rsv_scene_find_twins(rsv_scene *scene)
{
    rsv_status status;
    finder f;
    uint32_t count = 0;
    RSV_TRY(finder_create(scene, &f));
    RSV_TRY(find_pairs(&f));
    for (size_t t = 0; t < scene->triangle_count; t++)
        count += f.flags[t] != 0;
    rsv_parallel_for(scene->context, f.tree.face_count, 64, find_inside_out, &f);
    if (count) RSV_TRY(keep(scene, &f));
    if (!scene->is_part) rsv_warn_of_enclosed_lamps(scene, &f.tree);
cleanup:
    finder_destroy(&f);
    return status;
}
