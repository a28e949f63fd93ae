/// Faces in the same place, in variants of a scene whose vertices move.
#include "scene.h"
#include "twin_overlap.h"
#include "twins_owner.h"

#include <string.h>

/// Triangles that one which moved looks at: more are a heap, and hits will tell.
#define MOST_LOOKS 16384

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
    own->whole = (rsv_twin_tree){ 0 };
    own->tree.node =
        copy_bytes(context, from->tree.node, (from->tree.node_count + 1) * sizeof *from->tree.node);
    own->tree.face =
        copy_bytes(context, from->tree.face, from->tree.face_count * sizeof *from->tree.face);
    own->flags = copy_bytes(context, from->flags, variant->triangle_count);
    own->first_rival = own->rival = NULL;
    if (from->first_rival) {
        size_t count = variant->triangle_count;
        own->first_rival =
            copy_bytes(context, from->first_rival, (count + 1) * sizeof *own->first_rival);
        own->rival =
            copy_bytes(context, from->rival, (from->first_rival[count] + 1) * sizeof *own->rival);
    }
    own->twins.node = own->tree.node;
    own->twins.face = own->tree.face;
    own->twins.flags = own->flags;
    own->twins.first_rival = own->first_rival;
    own->twins.rival = own->rival;
    variant->twins = own;
    variant->view.twins = &own->twins;
    bool listed = !from->first_rival || (own->first_rival && own->rival);
    bool complete = own->tree.node && own->tree.face && own->flags && listed;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_scene_release_twins(rsv_scene *scene)
{
    if (!scene->twins) return;
    rsv_twin_tree_destroy(&scene->twins->tree);
    rsv_twin_tree_destroy(&scene->twins->whole);
    rsv_free(scene->context, scene->twins->flags);
    rsv_free(scene->context, scene->twins->first_rival);
    rsv_free(scene->context, scene->twins->rival);
    rsv_free(scene->context, scene->twins);
    scene->twins = NULL;
}

// ---- moves ----------------------------------------------------------------------------------------

/// What moved, and what it met.
typedef struct move {
    const rsv_scene *scene;
    const rsv_vec3 *home; ///< [vertex_count] where the vertices were
    float reach, rounding;
    bool met,
        apart; ///< out: whether new flags were set, and whether faces lie apart by more than rounding
} move;

/// A triangle that moved.
typedef struct moved_face {
    uint32_t triangle;
    rsv_vec3 normal; ///< unit
    rsv_twin_node box;
    float rounding, reach; ///< see rsv_twin_reach
} moved_face;

static bool has_moved(const move *m, uint32_t triangle)
{
    const uint32_t *corner = m->scene->triangle[triangle];
    for (int k = 0; k < 3; k++)
        if (v3_max_abs(v3_sub(m->scene->position[corner[k]], m->home[corner[k]])) > 0) return true;
    return false;
}

static moved_face face_of(const move *m, uint32_t triangle)
{
    const rsv_scene_view *view = &m->scene->view;
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]], b = view->position[corner[1]],
             c = view->position[corner[2]];
    rsv_twin_plane plane = rsv_twin_plane_of(view, triangle);
    moved_face f = { .triangle = triangle };
    f.box.low = v3_min(v3_min(a, b), c);
    f.box.high = v3_max(v3_max(a, b), c);
    f.rounding = rsv_twin_rounding(&plane, m->rounding);
    f.reach = rsv_twin_reach(&plane, f.rounding, m->reach);
    rsv_triangle_normal(a, b, c, &f.normal);
    return f;
}

static void flag(move *m, uint32_t triangle, uint8_t flags)
{
    uint8_t *own = &m->scene->twins->flags[triangle];
    m->met = m->met || (*own | flags) != *own;
    *own |= flags;
}

static void meet(move *m, const moved_face *f, uint32_t triangle)
{
    const rsv_scene_view *view = &m->scene->view;
    moved_face other = face_of(m, triangle);
    rsv_twin_overlap overlap;
    float rounding = f_max(f->rounding, other.rounding);
    float reach = f_max(f_min(f->reach, other.reach), rounding);
    if (triangle == f->triangle || fabsf(v3_dot(f->normal, other.normal)) < RSV_TWIN_PARALLEL ||
        !rsv_twins_overlap(view, (rsv_twin_face){ f->triangle, f->normal },
            (rsv_twin_face){ triangle, other.normal }, reach, &overlap))
        return;
    flag(m, f->triangle, rsv_twin_flags(view, f->triangle, overlap.opposite));
    flag(m, triangle, rsv_twin_flags(view, triangle, overlap.opposite));
    m->apart = m->apart || overlap.gap > 0.25 * (double)rounding;
}

static bool boxes_meet(const rsv_twin_node *a, const rsv_twin_node *b, float reach)
{
    return a->low.x <= b->high.x + reach && b->low.x <= a->high.x + reach &&
           a->low.y <= b->high.y + reach && b->low.y <= a->high.y + reach &&
           a->low.z <= b->high.z + reach && b->low.z <= a->high.z + reach;
}

static void look_around(move *m, uint32_t triangle)
{
    const rsv_twin_tree *tree = &m->scene->twins->whole;
    moved_face f = face_of(m, triangle);
    uint32_t looks = 0;
    for (uint32_t n = 0; n < tree->node_count && looks < MOST_LOOKS;) {
        const rsv_twin_node *node = &tree->node[n];
        bool meets = boxes_meet(&f.box, node, m->reach + m->rounding);
        if (meets && node->next == n + 1)
            for (uint32_t k = node->first; k < node[1].first; k++, looks++)
                meet(m, &f, tree->face[k]);
        n = meets ? n + 1 : node->next;
    }
    if (looks >= MOST_LOOKS)
        flag(m, triangle, RSV_TWIN_OVER_FRONT | RSV_TWIN_OVER_BACK | RSV_TWIN_OPPOSITE);
}

/// A tree of all triangles, and room for flags.
static rsv_status prepare(rsv_scene *scene)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_context *context = scene->context;
    uint32_t count = (uint32_t)scene->triangle_count, *all = NULL;
    if (!scene->twins) {
        RSV_TRY((scene->twins = rsv_alloc(context, 1, sizeof *scene->twins)) ? RSV_OK
                                                                             : RSV_ERROR_MEMORY);
        rsv_twins_limits(&scene->view, &scene->twins->twins.reach, &scene->twins->twins.rounding);
    }
    if (!scene->twins->flags) scene->twins->flags = rsv_alloc(context, count, 1);
    all = rsv_reserve(context, count, sizeof *all);
    RSV_TRY(scene->twins->flags && all ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < count; t++)
        all[t] = t;
    RSV_TRY(rsv_twin_tree_create(context, &scene->view, all, count, NULL, &scene->twins->whole));
cleanup:
    rsv_free(context, all);
    return status;
}

static const rsv_vec3 *home_of(const rsv_scene *scene)
{
    while (scene->base)
        scene = scene->base;
    return scene->position;
}

/// The lists of rivals do not hold once triangles have moved.
static void forget_rivals(rsv_scene *scene)
{
    rsv_twins_owner *owner = scene->twins;
    if (!owner) return;
    rsv_free(scene->context, owner->first_rival);
    rsv_free(scene->context, owner->rival);
    owner->first_rival = owner->rival = NULL;
    owner->twins.first_rival = owner->twins.rival = NULL;
}

rsv_status rsv_scene_move_twins(rsv_scene *scene)
{
    rsv_status status;
    if (!scene->owns_positions) return RSV_OK;
    forget_rivals(scene);
    if (!scene->twins || !scene->twins->whole.node) RSV_TRY(prepare(scene));
    rsv_twins_owner *owner = scene->twins;
    rsv_twin_tree_fit(&scene->view, &owner->whole);
    if (scene->view.twins) rsv_twin_tree_fit(&scene->view, &owner->tree);
    move m = { scene, home_of(scene), owner->twins.reach, owner->twins.rounding, false, false };
    for (uint32_t t = 0; t < scene->triangle_count; t++)
        if (has_moved(&m, t)) look_around(&m, t);
    if (m.apart) owner->twins.extent = RSV_TWIN_CLEAR * 0x1p20f;
    if (m.met) RSV_TRY(rsv_twins_plant(scene));
    status = RSV_OK;
cleanup:
    return status;
}
