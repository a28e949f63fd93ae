#include "bake_unpack.h"

#include <math.h>
#include <string.h>

static const char draco[] = "KHR_draco_mesh_compression";
static const char meshopt[] = "EXT_meshopt_compression";

static cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static void add_views(rsv_bake_document *d, cJSON *views)
{
    const rsv_gltf_document *gltf = d->gltf;
    for (size_t k = (size_t)cJSON_GetArraySize(views); k < gltf->buffer_view_count; k++) {
        const rsv_gltf_buffer_view *view = &gltf->buffer_view[k];
        cJSON *json = cJSON_CreateObject();
        rsv_bake_append(d, views, json);
        rsv_bake_number(d, json, "buffer", view->buffer);
        rsv_bake_number(d, json, "byteLength", (double)view->length);
        if (view->stride) rsv_bake_number(d, json, "byteStride", (double)view->stride);
        rsv_bake_number(d, json, "target", view->stride ? RSV_BAKE_VERTICES : RSV_BAKE_INDICES);
    }
}

/// Whether all of an accessor lies in its view. Accessors that no mesh uses were never read.
static bool lies_within(const rsv_gltf_accessor *a, const rsv_gltf_buffer_view *view)
{
    size_t element = (size_t)a->component_count * sizeof(float);
    return a->count && view->stride >= element && view->length >= element &&
           a->count - 1 <= (view->length - element) / view->stride;
}

/// Packing rounds, so limits of float vectors are those of the unpacked data. For other types they are optional and
/// removed.
static void renew_limits(rsv_bake_document *d, cJSON *json, const rsv_gltf_accessor *accessor)
{
    const rsv_gltf_buffer_view *view = &d->gltf->buffer_view[accessor->span.buffer_view];
    const uint8_t *data = d->gltf->buffer[view->buffer].data + view->offset;
    cJSON_DeleteItemFromObjectCaseSensitive(json, "min");
    cJSON_DeleteItemFromObjectCaseSensitive(json, "max");
    if (accessor->span.component_type != RSV_GLTF_FLOAT || !lies_within(accessor, view)) return;
    cJSON *min = rsv_bake_array(d, json, "min"), *max = rsv_bake_array(d, json, "max");
    for (int c = 0; c < accessor->component_count; c++) {
        float low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < accessor->count; k++) {
            float value;
            memcpy(&value, data + k * view->stride + (size_t)c * sizeof value, sizeof value);
            low = fminf(low, value);
            high = fmaxf(high, value);
        }
        rsv_bake_append(d, min, cJSON_CreateNumber((double)low));
        rsv_bake_append(d, max, cJSON_CreateNumber((double)high));
    }
}

/// Accessors that the parser moved to views of index `first` and above.
static void move_accessors(rsv_bake_document *d, int first)
{
    size_t k = 0;
    cJSON *json;
    cJSON_ArrayForEach(json, member(d->root, "accessors"))
    {
        if (k >= d->gltf->accessor_count) break;
        const rsv_gltf_accessor *accessor = &d->gltf->accessor[k++];
        if (accessor->span.buffer_view < first ||
            (size_t)accessor->span.buffer_view >= d->gltf->buffer_view_count)
            continue;
        rsv_bake_number(d, json, "bufferView", accessor->span.buffer_view);
        rsv_bake_number(d, json, "count", (double)accessor->count);
        cJSON_DeleteItemFromObjectCaseSensitive(json, "byteOffset");
        cJSON_DeleteItemFromObjectCaseSensitive(json, "sparse");
        renew_limits(d, json, accessor);
    }
}

/// Views that the parser has unpacked name the buffers that it made for them.
static void move_views(rsv_bake_document *d)
{
    size_t k = 0;
    bool any = false;
    cJSON *json;
    cJSON_ArrayForEach(json, member(d->root, "bufferViews"))
    {
        if (k >= d->gltf->buffer_view_count) break;
        const rsv_gltf_buffer_view *view = &d->gltf->buffer_view[k++];
        if (!member(member(json, "extensions"), meshopt)) continue;
        rsv_bake_number(d, json, "buffer", view->buffer);
        rsv_bake_number(d, json, "byteLength", (double)view->length);
        cJSON_DeleteItemFromObjectCaseSensitive(json, "byteOffset");
        rsv_bake_remove_extension(json, meshopt);
        any = true;
    }
    if (!any) return;
    cJSON_ArrayForEach(json, member(d->root, "buffers"))
    {
        rsv_bake_remove_extension(json, meshopt);
    }
    rsv_bake_unlist_extension(d, meshopt);
}

void rsv_bake_unpack(rsv_bake_document *d)
{
    move_views(d);
    cJSON *views = member(d->root, "bufferViews"), *mesh, *primitive;
    int first = cJSON_GetArraySize(views);
    if ((size_t)first >= d->gltf->buffer_view_count) return;
    add_views(d, views);
    move_accessors(d, first);
    cJSON_ArrayForEach(mesh, member(d->root, "meshes"))
    {
        cJSON_ArrayForEach(primitive, member(mesh, "primitives"))
        {
            rsv_bake_remove_extension(primitive, draco);
        }
    }
    rsv_bake_unlist_extension(d, draco);
}
