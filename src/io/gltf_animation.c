/// From an animated glTF file to scenes at its moments.
#include "../core/core.h"
#include "../core/descriptor.h"
#include "../scene/document.h"
#include "../scene/moment.h"
#include "../scene/moved.h"
#include "../scene/scene.h"
#include "gltf_archive.h"
#include "gltf_pose.h"
#include "resolvent/animation.h"
#include "scene_read.h"

#include <math.h>
#include <string.h>

struct rsv_animation {
    rsv_context *context;
    char *path;
    const rsv_gltf_document *document;
    rsv_gltf_clip *clip; ///< [count]
    rsv_clip *shown;     ///< [count] for users
    size_t count;
    rsv_load_desc desc; ///< with a name of its own for the variant
    char *variant;
    rsv_scene *rest; ///< as nodes and weights stand; NULL = not needed yet
    /// That keeps the document, in place of `rest`: its materials and strengths of lights count, because it may have
    /// been read with other units or relit; NULL = the animation is one of a file
    const rsv_scene *keeper;
};

static rsv_status read_clips(rsv_animation *a)
{
    size_t count = a->document->animation_count;
    a->clip = rsv_alloc(a->context, count, sizeof *a->clip);
    a->shown = rsv_alloc(a->context, count, sizeof *a->shown);
    if (!a->clip || !a->shown) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        rsv_gltf_clip *clip = &a->clip[k];
        rsv_status status = rsv_gltf_clip_create(a->context, a->document, k, clip);
        if (status != RSV_OK) return status;
        a->count = k + 1;
        a->shown[k] = (rsv_clip){ clip->name, clip->start, clip->end, clip->count };
    }
    return RSV_OK;
}

static rsv_status open_file(rsv_animation *a, const char *path)
{
    rsv_file_kind kind;
    rsv_status status = rsv_find_file_kind(a->desc.files, path, &kind);
    if (status != RSV_OK) return status;
    if (kind != RSV_FILE_GLTF)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "only glTF files (.gltf, .glb) can be animated; convert it to glTF");
    return rsv_gltf_open(a->desc.files, path, &a->document);
}

rsv_status rsv_animation_open(
    rsv_context *context, const char *path, const rsv_load_desc *desc, rsv_animation **animation)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_animation *a = rsv_alloc(context, 1, sizeof *a);
    if (!a) return status;
    *a = (rsv_animation){ .context = context, .desc = rsv_default_load_desc() };
    RSV_TRY(RSV_READ_DESC(rsv_load_desc, &a->desc, desc));
    a->path = rsv_copy_string(context, path);
    if (a->desc.variant) a->desc.variant = a->variant = rsv_copy_string(context, a->desc.variant);
    RSV_TRY(a->path && (a->variant || !a->desc.variant) ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(open_file(a, path));
    RSV_TRY(read_clips(a));
    *animation = a;
    return RSV_OK;
cleanup:
    rsv_animation_destroy(a);
    return rsv_name_file(status, path);
}

/// Lights as the scene has them that keeps the document, at the places of the document.
static rsv_status take_strengths(const rsv_scene *keeper, rsv_scene *scene)
{
    if (scene->light_count != keeper->light_count)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "lights were added");
    for (size_t k = 0; k < scene->light_count; k++) {
        rsv_punctual_light *light = &scene->light[k];
        const rsv_punctual_light placed = *light;
        *light = keeper->light[k];
        light->name = placed.name;
        light->position = placed.position;
        light->direction = placed.direction;
        light->side = placed.side;
    }
    return RSV_OK;
}

/// A scene of the document. @param rest NULL = it is the one at rest
static rsv_status build(
    rsv_animation *a, const rsv_gltf_document *document, const rsv_scene *rest, rsv_scene **result)
{
    rsv_status status;
    rsv_scene *scene = NULL;
    RSV_TRY(rsv_scene_create(a->context, &scene));
    scene->is_part = a->desc.is_part;
    if (rest) RSV_TRY(rsv_scene_begin_moment(scene, rest));
    RSV_TRY(rsv_gltf_fill(document, &a->desc, rest != NULL, scene));
    if (rest)
        RSV_TRY(rsv_scene_end_moment(scene));
    else
        rsv_set_sides(&a->desc, scene);
    RSV_TRY(rsv_scene_load_luminaires(scene, a->desc.luminaire, a->desc.luminaire_count));
    RSV_TRY(rsv_scene_commit(scene));
    if (a->keeper) RSV_TRY(take_strengths(a->keeper, scene));
    *result = scene;
    return RSV_OK;
cleanup:
    rsv_scene_destroy(scene);
    return status;
}

/// Whether the document still describes the scene that keeps it.
static rsv_status check_keeper(rsv_animation *a)
{
    rsv_scene *described = NULL;
    rsv_scene_difference difference = { .moved = NULL };
    rsv_status status;
    RSV_TRY(build(a, a->document, a->keeper, &described));
    RSV_TRY(rsv_scene_find_moved(a->keeper, described, &difference));
    if (difference.moved_count || difference.lights_moved) status = RSV_ERROR_UNSUPPORTED;
cleanup:
    rsv_free(a->context, difference.moved);
    rsv_scene_destroy(described);
    if (status != RSV_ERROR_UNSUPPORTED) return status;
    return rsv_fail(status,
        "its scene is no longer that of the glTF file in it (lights were moved, added or "
        "replaced), so its animations do not fit; solve the glTF file again");
}

/// @param kept of the scene
static rsv_status open_kept(
    const rsv_scene *scene, const rsv_scene_document *kept, rsv_animation **animation)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_animation *a = rsv_alloc(scene->context, 1, sizeof *a);
    if (!a) return status;
    *a = (rsv_animation){
        .context = scene->context, .desc = rsv_default_load_desc(), .keeper = scene
    };
    a->desc.is_part = scene->is_part;
    a->path = rsv_copy_string(scene->context, kept->name);
    RSV_TRY(a->path ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_gltf_open_archive(kept->bytes, kept->count, &a->document));
    RSV_TRY(read_clips(a));
    if (a->count) RSV_TRY(check_keeper(a));
    *animation = a;
    return RSV_OK;
cleanup:
    rsv_animation_destroy(a);
    return rsv_name_file(status, kept->name);
}

rsv_status rsv_animation_open_document(const rsv_scene *scene, rsv_animation **animation)
{
    rsv_status status = rsv_scene_require_committed(scene);
    if (status != RSV_OK) return status;
    const rsv_scene_document *kept = rsv_scene_find_document(scene);
    if (kept) return open_kept(scene, kept, animation);
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "the scene keeps no glTF file whose animations could be played; solve a .gltf or .glb file, "
        "without --time, --variant and --no-document");
}

void rsv_animation_destroy(rsv_animation *a)
{
    if (!a) return;
    for (size_t k = 0; k < a->count; k++)
        rsv_gltf_clip_destroy(&a->clip[k]);
    rsv_free(a->context, a->clip);
    rsv_free(a->context, a->shown);
    rsv_scene_destroy(a->rest);
    rsv_gltf_close(a->document);
    rsv_free(a->context, a->path);
    rsv_free(a->context, a->variant);
    rsv_free(a->context, a);
}

size_t rsv_animation_clip_count(const rsv_animation *a) { return a->count; }

const rsv_clip *rsv_animation_clip(const rsv_animation *a, size_t index)
{
    return index < a->count ? &a->shown[index] : NULL;
}

uint32_t rsv_animation_find_clip(const rsv_animation *a, const char *name)
{
    for (size_t k = 0; k < a->count; k++)
        if (strcmp(a->shown[k].name, name) == 0) return (uint32_t)k;
    return RSV_NONE;
}

static rsv_status check_moment(const rsv_animation *a, uint32_t clip, double time)
{
    if (!a->count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "it holds no animation; load it without a time");
    if (clip != RSV_NONE && clip >= a->count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "it has no clip %u, but %zu", clip, a->count);
    if (!isfinite(time)) return rsv_fail(RSV_ERROR_ARGUMENT, "%g is not a valid time", time);
    return RSV_OK;
}

rsv_status rsv_animation_scene(rsv_animation *a, uint32_t clip, double time, rsv_scene **scene)
{
    rsv_status status;
    rsv_gltf_pose pose = { .context = a->context };
    bool all = clip == RSV_NONE;
    RSV_TRY(check_moment(a, clip, time));
    if (!a->rest && !a->keeper) RSV_TRY(build(a, a->document, NULL, &a->rest));
    RSV_TRY(rsv_gltf_pose_create(
        a->context, a->document, a->clip + (all ? 0 : clip), all ? a->count : 1, time, &pose));
    RSV_TRY(build(a, &pose.document, a->keeper ? a->keeper : a->rest, scene));
cleanup:
    rsv_gltf_pose_destroy(&pose);
    return status == RSV_OK ? RSV_OK : rsv_name_file(status, a->path);
}
