#include "bake_part.h"

#include "../io/gltf_accessor.h"
#include "../scene/scene.h"
#include "bake_side.h"

#include <stdio.h>
#include <string.h>

/// Names of instances may be cut after this many bytes.
#define MOST_OF_NAME 200

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
    rsv_gltf_indices read = { 0 };
    RSV_TRY(rsv_gltf_read_vectors(d->context, d->gltf, primitive->position, part->label,
        &part->position, &part->vertex_count));
    read.count = part->vertex_count;
    if (primitive->indices >= 0)
        RSV_TRY(rsv_gltf_read_indices(
            d->context, d->gltf, primitive->indices, part->label, part->vertex_count, &read));
    part->triangle_count = primitive->mode == RSV_GLTF_TRIANGLES ? read.count / 3
                           : read.count < 3                      ? 0
                                                                 : read.count - 2;
    part->corner = rsv_alloc(d->context, part->triangle_count, sizeof *part->corner);
    part->triangle = rsv_alloc(d->context, part->triangle_count, sizeof *part->triangle);
    RSV_TRY(part->corner && part->triangle ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t t = 0; t < part->triangle_count; t++) {
        size_t at[3];
        find_corners(primitive->mode, t, at);
        part->triangle[t] = RSV_NONE;
        for (int k = 0; k < 3; k++)
            part->corner[t][k] = read.index ? read.index[at[k]] : (uint32_t)at[k];
    }
cleanup:
    rsv_free(d->context, read.index);
    return status;
}

/// The primitives that loading a scene turns into instances, in the same order.
static rsv_status add_parts(
    const rsv_bake_document *d, const rsv_gltf_parts *shown, rsv_bake_parts *parts)
{
    rsv_status status = RSV_OK;
    parts->part = rsv_alloc(parts->context, shown->count, sizeof *parts->part);
    if (!parts->part) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < shown->count; k++) {
        const rsv_gltf_part *from = &shown->part[k];
        const rsv_gltf_mesh *mesh = &d->gltf->mesh[from->mesh];
        rsv_bake_part *part = &parts->part[parts->count++];
        *part = (rsv_bake_part){ .node = from->node,
            .mesh = from->mesh,
            .primitive = from->primitive,
            .copy = from->copy,
            .instance = (uint32_t)k,
            .mirrored = from->mirrored };
        snprintf(
            part->label, sizeof part->label, "%.100s, primitive %u", mesh->name, part->primitive);
        RSV_TRY(read_part(d, &mesh->primitive[from->primitive], part));
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

/// Whether a part became an object of the scene, by their names. Names of instances end in a number.
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

/// Finds the triangles of each part in the scene.
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
        "%s: bake: the glTF document in it belongs to another scene; solve the scene again",
        d->name);
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
        "%s: bake: no surface reflects diffusely, so there is no light to store", d->name);
}

/// Documents of operator files are not trusted.
static rsv_status find_shown(const rsv_bake_document *d, rsv_gltf_parts *shown)
{
    char message[512];
    rsv_status status = rsv_gltf_parts_create(d->context, d->gltf, shown);
    if (status == RSV_OK || status == RSV_ERROR_MEMORY) return status;
    snprintf(message, sizeof message, "%s", rsv_last_error());
    return rsv_fail(status, "%s: bake: %s", d->name, message);
}

rsv_status rsv_bake_parts_create(
    const rsv_bake_document *d, const rsv_light_view *solution, rsv_bake_parts *parts)
{
    rsv_status status;
    *parts = (rsv_bake_parts){ .context = d->context };
    RSV_TRY(find_shown(d, &parts->shown));
    RSV_TRY(add_parts(d, &parts->shown, parts));
    RSV_TRY(match(d, solution->scene.scene, parts));
    RSV_TRY(check_lit(d, solution, parts));
    for (size_t k = 0; k < parts->count; k++)
        RSV_TRY(rsv_bake_choose_sides(solution, &parts->part[k]));
cleanup:
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
    if (parts->shown.context) rsv_gltf_parts_destroy(&parts->shown);
    *parts = (rsv_bake_parts){ .context = parts->context };
}
