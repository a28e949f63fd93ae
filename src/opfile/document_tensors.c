/// The file that the scene came from, for bakes: as it was, and which of its triangles those of the scene are.
#include "../scene/document.h"

#include "../scene/scene.h"
#include "exchange.h"

typedef struct document_tensors {
    uint32_t *triangle, *instance; ///< [triangle_count], [object_count], see scene.h
    uint8_t *bytes;                ///< [count]
    size_t triangle_count, object_count, count;
} document_tensors;

static rsv_status exchange(rsv_tensor_file *file, document_tensors *d)
{
    rsv_status status;
    const rsv_tensor_type u32 = RSV_TENSOR_U32;
    RSV_TRY(rsv_tensor_exchange(file, "triangle", u32, 1, &d->triangle, &d->triangle_count));
    RSV_TRY(rsv_tensor_exchange(file, "instance", u32, 1, &d->instance, &d->object_count));
    RSV_TRY(rsv_tensor_exchange(file, "glb", RSV_TENSOR_U8, 1, &d->bytes, &d->count));
cleanup:
    return status;
}

rsv_status rsv_write_document(rsv_tensor_file *file, const rsv_scene *scene)
{
    const rsv_scene_document *kept = rsv_scene_find_document(scene);
    if (!kept || !scene->triangle_source) return RSV_OK;
    document_tensors d = { .triangle = scene->triangle_source,
        .instance = scene->object_instance,
        .bytes = kept->bytes,
        .triangle_count = scene->triangle_count,
        .object_count = scene->object_count,
        .count = kept->count };
    rsv_tensor_prefix(file, "document.");
    return exchange(file, &d);
}

rsv_status rsv_read_document(rsv_tensor_file *file, rsv_scene *scene)
{
    document_tensors d = { .triangle_count = scene->triangle_count,
        .object_count = scene->object_count,
        .count = RSV_ANY_COUNT };
    rsv_tensor_prefix(file, "document.");
    if (!rsv_tensor_find(file, "glb")) return RSV_OK;
    rsv_status status = exchange(file, &d);
    scene->triangle_source = d.triangle; // the scene frees them, also after errors
    scene->object_instance = d.instance;
    return status == RSV_OK ? rsv_scene_set_document(scene, file->path, d.bytes, d.count) : status;
}
