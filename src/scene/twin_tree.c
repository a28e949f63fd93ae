#include "twin_tree.h"

#include "../core/key.h"
#include "../core/morton.h"
#include "../core/parallel.h"

#include <stdlib.h>

/// A triangle and its position on a space-filling curve, whose steps are fine enough for a pencil on a desk in a town.
/// Copies are adjacent.
typedef struct curve_place {
    uint64_t place;
    uint32_t hash, face;
} curve_place;

static int compare_places(const void *left, const void *right)
{
    const curve_place *a = left, *b = right;
    if (a->place != b->place) return a->place < b->place ? -1 : 1;
    if (a->hash != b->hash) return a->hash < b->hash ? -1 : 1;
    return (a->face > b->face) - (a->face < b->face);
}

static uint64_t place_of(const rsv_scene_view *scene, uint32_t triangle)
{
    rsv_vec3 sum = { 0 }, size = v3_sub(scene->bounds_max, scene->bounds_min);
    for (int k = 0; k < 3; k++)
        sum = v3_add(sum, v3_sub(scene->position[scene->triangle[triangle][k]], scene->bounds_min));
    sum = v3_scale(sum, 1 / (3 * v3_max_abs(size)));
    return rsv_morton_key(sum.x, sum.y, sum.z, RSV_MORTON_BITS);
}

/// The same for all triangles with these corners.
static uint32_t hash_of(const rsv_scene_view *scene, uint32_t triangle)
{
    uint64_t sum = 0;
    for (int k = 0; k < 3; k++)
        sum += rsv_key_add_vector(0, scene->position[scene->triangle[triangle][k]]);
    return (uint32_t)(sum >> 32);
}

static bool same_place(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// Whether one of two triangles does for both: they have one material and their corners in one order.
static bool are_copies(const rsv_scene_view *scene, uint32_t a, uint32_t b)
{
    const uint32_t *of_a = scene->triangle[a], *of_b = scene->triangle[b];
    uint32_t material = scene->triangle_material[a];
    // copies may be cut out elsewhere
    if (material != scene->triangle_material[b] || scene->material[material].alpha_cutoff > 0)
        return false;
    for (int turn = 0; turn < 3; turn++) {
        bool same = true;
        for (int k = 0; k < 3 && same; k++)
            same = same_place(scene->position[of_a[k]], scene->position[of_b[(k + turn) % 3]]);
        if (same) return true;
    }
    return false;
}

/// Whether a later face of the same place and hash is a copy. Windings and materials may alternate.
static bool has_later_copy(
    const rsv_scene_view *scene, const curve_place *place, uint32_t count, uint8_t *flags)
{
    enum { look_ahead = 16 };
    for (uint32_t k = 1; k < count && k <= look_ahead; k++) {
        if (place[k].hash != place->hash || place[k].place != place->place) return false;
        if (!are_copies(scene, place->face, place[k].face)) continue;
        flags[place->face] = RSV_TWIN_COPY;
        flags[place[k].face] |= RSV_TWIN_LAST;
        return true;
    }
    return false;
}

typedef struct place_job {
    const rsv_scene_view *scene;
    const uint32_t *face; ///< [count]
    curve_place *place;   ///< [count] out
} place_job;

static void find_places(void *data, rsv_span span)
{
    const place_job *job = data;
    const rsv_scene_view *scene = job->scene;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t face = job->face[k];
        job->place[k] = (curve_place){ place_of(scene, face), hash_of(scene, face), face };
    }
}

static rsv_status sort_faces(const rsv_scene_view *scene, const uint32_t *face, uint32_t count,
    uint8_t *flags, rsv_twin_tree *tree)
{
    curve_place *place = rsv_reserve(tree->context, count, sizeof *place);
    if (!place) return RSV_ERROR_MEMORY;
    rsv_parallel_for(tree->context, count, 0, find_places, &(place_job){ scene, face, place });
    qsort(place, count, sizeof *place, compare_places);
    tree->face_count = 0;
    for (uint32_t k = 0; k < count; k++)
        if (!flags || !has_later_copy(scene, &place[k], count - k, flags))
            tree->face[tree->face_count++] = place[k].face;
    rsv_free(tree->context, place);
    return RSV_OK;
}

/// Nodes over faces from `first` on. Halves of halves: no deeper than the logarithm of their number.
static void add_nodes(rsv_twin_tree *tree, uint32_t first, uint32_t count)
{
    uint32_t node = tree->node_count++, half = count / 2;
    tree->node[node].first = first;
    if (count > RSV_TWIN_LEAF) {
        add_nodes(tree, first, half);
        add_nodes(tree, first + half, count - half);
    }
    tree->node[node].next = tree->node_count;
}

static void fit_leaf(const rsv_scene_view *scene, const rsv_twin_tree *tree, rsv_twin_node *node)
{
    node->low = node->high = scene->position[scene->triangle[tree->face[node->first]][0]];
    for (uint32_t k = 3 * node->first; k < 3 * node[1].first; k++) {
        rsv_vec3 p = scene->position[scene->triangle[tree->face[k / 3]][k % 3]];
        node->low = v3_min(node->low, p);
        node->high = v3_max(node->high, p);
    }
}

void rsv_twin_tree_fit(const rsv_scene_view *scene, rsv_twin_tree *tree)
{
    for (uint32_t n = tree->node_count; n-- > 0;) {
        rsv_twin_node *node = &tree->node[n];
        if (node->next == n + 1) {
            fit_leaf(scene, tree, node);
            continue;
        }
        const rsv_twin_node *left = node + 1, *right = &tree->node[left->next];
        node->low = v3_min(left->low, right->low);
        node->high = v3_max(left->high, right->high);
    }
}

rsv_status rsv_twin_tree_create(rsv_context *context, const rsv_scene_view *scene,
    const uint32_t *face, uint32_t face_count, uint8_t *flags, rsv_twin_tree *tree)
{
    rsv_status status = RSV_ERROR_MEMORY;
    *tree = (rsv_twin_tree){ .context = context };
    // leaves of two triangles at the least
    tree->node = rsv_reserve(context, (size_t)face_count + 2, sizeof *tree->node);
    tree->face = rsv_reserve(context, face_count, sizeof *tree->face);
    if (!tree->node || !tree->face) goto cleanup;
    RSV_TRY(sort_faces(scene, face, face_count, flags, tree));
    if (tree->face_count) add_nodes(tree, 0, tree->face_count);
    tree->node[tree->node_count] = (rsv_twin_node){ .first = tree->face_count };
    rsv_twin_tree_fit(scene, tree);
cleanup:
    if (status != RSV_OK) rsv_twin_tree_destroy(tree);
    return status;
}

void rsv_twin_tree_destroy(rsv_twin_tree *tree)
{
    if (!tree->context) return;
    rsv_free(tree->context, tree->node);
    rsv_free(tree->context, tree->face);
    *tree = (rsv_twin_tree){ 0 };
}
