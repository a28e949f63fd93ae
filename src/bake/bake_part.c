#include "bake_part.h"

#include "../io/gltf_accessor.h"
#include "../io/matrix.h"
#include "../scene/scene.h"
#include "bake_side.h"

#include <stdio.h>
#include <string.h>

/// Names of instances may be cut after so many bytes.
#define MOST_OF_NAME 200

typedef struct walker {
    const rsv_bake_document *document;
    rsv_bake_parts *parts;
    bool *visited;     ///< [node_count]
    uint32_t *pending; ///< [node_count]
} walker;

// ---- geometry -------------------------------------------------------------------------------------

/// Corners of triangle `t` of a list, strip or fan.
static void find_corners(int mode, size_t t, size_t corner[3])
{
    const size_t list[3] = { 3 * t, 3 * t + 1, 3 * t + 2 };
    const size_t strip[3] = { t, t + 1 + t % 2, t + 2 - t % 2 }, fan[3] = { t + 1, t + 2, 0 };
    const size_t *from = mode == RSV_GLTF_TRIANGLES        ? list
                         : mode == RSV_GLTF_TRIANGLE_STRIP ? strip
                                                           : fan;
    memcpy(corner, from, sizeof list);
}

static rsv_status read_part(
    const rsv_bake_document *d, const rsv_gltf_primitive *primitive, rsv_bake_part *part)
{
    rsv_status status;
    uint32_t *index = NULL;
    size_t count;
    RSV_TRY(rsv_gltf_read_vectors(d->context, d->gltf, primitive->position, part->label,
        &part->position, &part->vertex_count));
    count = part->vertex_count;
    if (primitive->indices >= 0)
        RSV_TRY(rsv_gltf_read_indices(d->context, d->gltf, primitive->indices, part->label,
            part->vertex_count, &index, &count));
    part->triangle_count = primitive->mode == RSV_GLTF_TRIANGLES ? count / 3
                           : count < 3                           ? 0
                                                                 : count - 2;
    part->corner = rsv_alloc(d->context, part->triangle_count, sizeof *part->corner);
    part->triangle = rsv_alloc(d->context, part->triangle_count, sizeof *part->triangle);
    RSV_TRY(part->corner && part->triangle ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t t = 0; t < part->triangle_count; t++) {
        size_t at[3];
        find_corners(primitive->mode, t, at);
        part->triangle[t] = RSV_NONE;
        for (int k = 0; k < 3; k++)
            part->corner[t][k] = index ? index[at[k]] : (uint32_t)at[k];
    }
cleanup:
    rsv_free(d->context, index);
    return status;
}

static bool mirrors(const double m[16])
{
    double x = m[5] * m[10] - m[6] * m[9], y = m[6] * m[8] - m[4] * m[10];
    double z = m[4] * m[9] - m[5] * m[8];
    return m[0] * x + m[1] * y + m[2] * z < 0;
}

// ---- nodes ----------------------------------------------------------------------------------------

/// The primitives that loading a scene turns into instances, in the same order.
static rsv_status add_parts(walker *w, uint32_t index)
{
    rsv_status status = RSV_OK;
    const rsv_gltf_document *gltf = w->document->gltf;
    const rsv_gltf_node *node = &gltf->node[index];
    if (node->mesh < 0) return RSV_OK;
    if ((size_t)node->mesh >= gltf->mesh_count)
        return rsv_fail(RSV_ERROR_FORMAT, "%s: bake: node '%s' has mesh %d, which does not exist",
            w->document->name, node->name, node->mesh);
    const rsv_gltf_mesh *mesh = &gltf->mesh[node->mesh];
    for (size_t k = 0; k < mesh->primitive_count; k++) {
        const rsv_gltf_primitive *primitive = &mesh->primitive[k];
        if (primitive->position < 0 || primitive->mode < RSV_GLTF_TRIANGLES ||
            primitive->mode > RSV_GLTF_TRIANGLE_FAN)
            continue;
        rsv_bake_parts *parts = w->parts;
        RSV_TRY(rsv_grow(parts->context, (void **)&parts->part, &parts->capacity, parts->count + 1,
            sizeof *parts->part));
        rsv_bake_part *part = &parts->part[parts->count];
        *part = (rsv_bake_part){ .node = index,
            .mesh = (uint32_t)node->mesh,
            .primitive = (uint32_t)k,
            .instance = (uint32_t)parts->count,
            .mirrored = mirrors(w->parts->world[index]) };
        snprintf(part->label, sizeof part->label, "%.100s, primitive %zu", mesh->name, k);
        parts->count++;
        RSV_TRY(read_part(w->document, primitive, part));
    }
cleanup:
    return status;
}

/// Documents of operator files are what somebody wrote: that no node is met twice makes the walk end.
static rsv_status push_nodes(
    walker *w, const int *node, size_t count, const double *parent, size_t *pending)
{
    static const double identity[16] = { [0] = 1, [5] = 1, [10] = 1, [15] = 1 };
    for (size_t k = count; k-- > 0;) {
        bool exists = node[k] >= 0 && (size_t)node[k] < w->document->gltf->node_count;
        if (!exists || w->visited[node[k]])
            return rsv_fail(RSV_ERROR_FORMAT, "%s: bake: node %d %s", w->document->name, node[k],
                exists ? "has two parents, or is its own" : "does not exist");
        w->visited[node[k]] = true;
        rsv_matrix_multiply(parent ? parent : identity, w->document->gltf->node[node[k]].local,
            w->parts->world[node[k]]);
        w->pending[(*pending)++] = (uint32_t)node[k];
    }
    return RSV_OK;
}

static rsv_status walk(walker *w)
{
    rsv_status status;
    const rsv_gltf_document *gltf = w->document->gltf;
    size_t pending = 0;
    RSV_TRY(push_nodes(w, gltf->root, gltf->root_count, NULL, &pending));
    while (pending) {
        uint32_t index = w->pending[--pending];
        const rsv_gltf_node *node = &gltf->node[index];
        RSV_TRY(add_parts(w, index));
        w->parts->order[w->parts->order_count++] = index;
        RSV_TRY(push_nodes(w, node->child, node->child_count, w->parts->world[index], &pending));
    }
cleanup:
    return status;
}

/// Whether materials are those of the scene, by their names. One more is the default of primitives without.
static bool has_materials(const rsv_gltf_document *gltf, const rsv_scene *scene)
{
    if (gltf->material_count > scene->material_count) return false;
    for (size_t m = 0; m < gltf->material_count; m++)
        if (strcmp(gltf->material[m].value.name, scene->material[m].name) != 0) return false;
    return true;
}

/// Whether a part is what an object of the scene was made of, by their names. Those of instances go on with a number.
static bool is_part_of(
    const rsv_gltf_document *gltf, const rsv_bake_part *part, const rsv_scene *scene, uint32_t o)
{
    const char *node = gltf->node[part->node].name;
    return strncmp(node, scene->object_name[o], strnlen(node, MOST_OF_NAME)) == 0;
}

/// The part that triangle `t` of the scene is of, and which of its triangles; NULL = the document is another scene's.
static rsv_bake_part *find_part(const rsv_bake_document *d, const rsv_scene *scene, size_t t,
    const rsv_bake_parts *parts, uint32_t *source)
{
    uint32_t object = scene->triangle_object[t];
    uint32_t instance = d->is_made ? object : scene->object_instance[object];
    rsv_bake_part *part = instance < parts->count ? &parts->part[instance] : NULL;
    if (!d->is_made) *source = scene->triangle_source[t];
    if (!part || *source >= part->triangle_count || !is_part_of(d->gltf, part, scene, object))
        return NULL;
    return part;
}

/// Tells each part which triangles of the scene are its own.
static rsv_status match(const rsv_bake_document *d, const rsv_scene *scene, rsv_bake_parts *parts)
{
    bool fits = (d->is_made || scene->triangle_source) && has_materials(d->gltf, scene);
    uint32_t source = 0;
    for (size_t t = 0; fits && t < scene->triangle_count; t++, source++) {
        if (t == 0 || scene->triangle_object[t] != scene->triangle_object[t - 1]) source = 0;
        rsv_bake_part *part = find_part(d, scene, t, parts, &source);
        fits = part && part->triangle[source] == RSV_NONE;
        if (fits) part->triangle[source] = (uint32_t)t;
    }
    if (fits) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT,
        "%s: bake: the document that it holds is that of another scene; solve anew", d->name);
}

bool rsv_bake_carries_light(const rsv_light_view *solution, const rsv_bake_part *part)
{
    for (size_t t = 0; t < part->triangle_count; t++)
        if (part->triangle[t] != RSV_NONE)
            return solution->elements->face_of[0][part->triangle[t]] != RSV_NONE;
    return false;
}

static rsv_status check_lit(
    const rsv_bake_document *d, const rsv_light_view *solution, const rsv_bake_parts *parts)
{
    for (size_t k = 0; k < parts->count; k++)
        if (rsv_bake_carries_light(solution, &parts->part[k])) return RSV_OK;
    return rsv_fail(RSV_ERROR_SCENE,
        "%s: bake: nothing here reflects diffusely, so there is no light to keep", d->name);
}

rsv_status rsv_bake_parts_create(
    const rsv_bake_document *d, const rsv_light_view *solution, rsv_bake_parts *parts)
{
    rsv_status status;
    size_t nodes = d->gltf->node_count;
    *parts = (rsv_bake_parts){ .context = d->context };
    walker w = { .document = d,
        .parts = parts,
        .visited = rsv_alloc(d->context, nodes, sizeof *w.visited),
        .pending = rsv_alloc(d->context, nodes, sizeof *w.pending) };
    parts->world = rsv_alloc(d->context, nodes, sizeof *parts->world);
    parts->order = rsv_alloc(d->context, nodes, sizeof *parts->order);
    RSV_TRY(parts->world && parts->order && w.visited && w.pending ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(walk(&w));
    RSV_TRY(match(d, solution->scene.scene, parts));
    RSV_TRY(check_lit(d, solution, parts));
    for (size_t k = 0; k < parts->count; k++)
        RSV_TRY(rsv_bake_choose_sides(solution, &parts->part[k]));
cleanup:
    rsv_free(d->context, w.visited);
    rsv_free(d->context, w.pending);
    if (status != RSV_OK) rsv_bake_parts_destroy(parts);
    return status;
}

void rsv_bake_parts_destroy(rsv_bake_parts *parts)
{
    for (size_t k = 0; k < parts->count; k++) {
        rsv_free(parts->context, parts->part[k].position);
        rsv_free(parts->context, parts->part[k].corner);
        rsv_free(parts->context, parts->part[k].triangle);
        rsv_free(parts->context, parts->part[k].back);
    }
    rsv_free(parts->context, parts->part);
    rsv_free(parts->context, parts->world);
    rsv_free(parts->context, parts->order);
    *parts = (rsv_bake_parts){ .context = parts->context };
}
