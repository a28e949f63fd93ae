#include "bake_document.h"
#include "bake_unpack.h"

#include "../core/number_text.h"
#include "../io/atomic_file.h"
#include "../io/gltf_archive.h"
#include "../io/gltf_write.h"
#include "../scene/document.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// ---- reading --------------------------------------------------------------------------------------

static size_t append_bytes(rsv_bake_document *d, const void *data, size_t count)
{
    size_t begin = (d->byte_count + 3) & ~(size_t)3;
    if (rsv_grow(d->context, (void **)&d->bytes, &d->byte_capacity, begin + count + 4, 1) !=
        RSV_OK) {
        d->exhausted = true;
        return 0;
    }
    memset(d->bytes + d->byte_count, 0, begin - d->byte_count);
    if (count) memcpy(d->bytes + begin, data, count);
    d->byte_count = begin + count;
    return begin;
}

static double number_of(const cJSON *object, const char *name, double otherwise)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : otherwise;
}

/// Joins all buffers into one, which keeps other properties of the first.
static rsv_status join_buffers(rsv_bake_document *d)
{
    const rsv_gltf_document *gltf = d->gltf;
    size_t *begin = rsv_alloc(d->context, gltf->buffer_count, sizeof *begin);
    if (!begin) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < gltf->buffer_count; k++)
        begin[k] = append_bytes(d, gltf->buffer[k].data, gltf->buffer[k].size);
    rsv_bake_unpack(d);
    cJSON *view, *buffers = rsv_bake_array(d, d->root, "buffers");
    cJSON_ArrayForEach(view, cJSON_GetObjectItemCaseSensitive(d->root, "bufferViews"))
    {
        double buffer = number_of(view, "buffer", 0), offset = number_of(view, "byteOffset", 0);
        if (!(buffer >= 0 && buffer < (double)gltf->buffer_count)) continue;
        if (buffer == 0 && begin[0] == 0) continue;
        rsv_bake_number(d, view, "buffer", 0);
        rsv_bake_number(d, view, "byteOffset", offset + (double)begin[(size_t)buffer]);
    }
    while (cJSON_GetArraySize(buffers) > 1)
        cJSON_DeleteItemFromArray(buffers, 1);
    if (!cJSON_GetArraySize(buffers)) rsv_bake_append(d, buffers, cJSON_CreateObject());
    cJSON_DeleteItemFromObjectCaseSensitive(cJSON_GetArrayItem(buffers, 0), "uri");
    rsv_free(d->context, begin);
    return RSV_OK;
}

static const char *mime_type(const uint8_t *bytes, size_t count)
{
    static const uint8_t png[] = { 0x89, 'P', 'N', 'G' }, jpeg[] = { 0xff, 0xd8, 0xff };
    if (count > 4 && memcmp(bytes, png, sizeof png) == 0) return "image/png";
    if (count > 4 && memcmp(bytes, jpeg, sizeof jpeg) == 0) return "image/jpeg";
    return NULL;
}

/// Embeds images that are separate files.
static void embed_images(rsv_bake_document *d)
{
    size_t k = 0;
    cJSON *image;
    cJSON_ArrayForEach(image, cJSON_GetObjectItemCaseSensitive(d->root, "images"))
    {
        if (k >= d->gltf->image_count) break;
        const rsv_gltf_image *data = &d->gltf->image[k++];
        const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(image, "uri"));
        const char *type = data->bytes ? mime_type(data->bytes, data->size) : NULL;
        if (!uri || strncmp(uri, "data:", 5) == 0 || !type) continue;
        cJSON_DeleteItemFromObjectCaseSensitive(image, "uri");
        rsv_bake_number(d, image, "bufferView", rsv_bake_add_view(d, data->bytes, data->size, 0));
        rsv_bake_string(d, image, "mimeType", type);
    }
}

/// Embeds luminaires in the same way.
static void embed_luminaires(rsv_bake_document *d)
{
    size_t k = 0;
    cJSON *light, *extensions = cJSON_GetObjectItemCaseSensitive(d->root, "extensions");
    const cJSON *ies = cJSON_GetObjectItemCaseSensitive(extensions, "EXT_lights_ies");
    cJSON_ArrayForEach(light, cJSON_GetObjectItemCaseSensitive(ies, "lights"))
    {
        if (k >= d->gltf->luminaire_count) break;
        const rsv_gltf_image *data = &d->gltf->luminaire[k++];
        const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(light, "uri"));
        if (!uri || strncmp(uri, "data:", 5) == 0 || !data->bytes) continue;
        cJSON_DeleteItemFromObjectCaseSensitive(light, "uri");
        cJSON_DeleteItemFromObjectCaseSensitive(light, "mimeType");
        rsv_bake_number(d, light, "bufferView", rsv_bake_add_view(d, data->bytes, data->size, 0));
        rsv_bake_string(d, light, "mimeType", "application/x-ies-lm-63");
    }
}

/// @param archive [count] the scene's document, or the scene as a file
static rsv_status read_archive(rsv_bake_document *d, const uint8_t *archive, size_t count)
{
    char message[512];
    rsv_status status = rsv_gltf_open_archive(archive, count, &d->gltf);
    if (status == RSV_ERROR_MEMORY) return status;
    if (status != RSV_OK) {
        snprintf(message, sizeof message, "%s", rsv_last_error());
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: bake: the glTF document in it is damaged: it %s; solve the scene again", d->name,
            message);
    }
    d->root = cJSON_ParseWithLength(d->gltf->text, d->gltf->text_bytes);
    return cJSON_IsObject(d->root)
               ? RSV_OK
               : rsv_fail(RSV_ERROR_FORMAT, "%s: bake: its JSON cannot be read", d->name);
}

/// The document that the scene keeps, or the scene as it is now.
static rsv_status read_document(rsv_bake_document *d, const rsv_scene *scene)
{
    rsv_status status;
    uint8_t *bytes;
    size_t count;
    const rsv_scene_document *kept = rsv_scene_find_document(scene);
    d->name = kept ? kept->name : "scene";
    d->is_made = !kept;
    if (kept) return read_archive(d, kept->bytes, kept->count);
    status = rsv_scene_write_document(scene, &bytes, &count);
    if (status != RSV_OK) return status;
    status = read_archive(d, bytes, count);
    rsv_free(d->context, bytes);
    return status;
}

rsv_status rsv_bake_document_open(const rsv_scene *scene, rsv_bake_document *d)
{
    rsv_status status;
    *d = (rsv_bake_document){ .context = rsv_scene_get_context(scene) };
    RSV_TRY(read_document(d, scene));
    RSV_TRY(join_buffers(d));
    embed_images(d);
    embed_luminaires(d);
cleanup:
    if (status != RSV_OK) rsv_bake_document_close(d);
    return status;
}

void rsv_bake_document_close(rsv_bake_document *d)
{
    rsv_gltf_close(d->gltf);
    cJSON_Delete(d->root);
    rsv_free(d->context, d->bytes);
    *d = (rsv_bake_document){ .context = d->context };
}

// ---- changing -------------------------------------------------------------------------------------

static cJSON *noted(rsv_bake_document *d, cJSON *item)
{
    d->exhausted |= !item;
    return item;
}

cJSON *rsv_bake_array(rsv_bake_document *d, cJSON *parent, const char *name)
{
    cJSON *array = cJSON_GetObjectItemCaseSensitive(parent, name);
    return array ? array : noted(d, cJSON_AddArrayToObject(parent, name));
}

cJSON *rsv_bake_object(rsv_bake_document *d, cJSON *parent, const char *name)
{
    cJSON *object = cJSON_GetObjectItemCaseSensitive(parent, name);
    return object ? object : noted(d, cJSON_AddObjectToObject(parent, name));
}

static void put(rsv_bake_document *d, cJSON *parent, const char *name, cJSON *item)
{
    if (!noted(d, item)) return;
    if (cJSON_GetObjectItemCaseSensitive(parent, name))
        d->exhausted |= !cJSON_ReplaceItemInObjectCaseSensitive(parent, name, item);
    else
        d->exhausted |= !cJSON_AddItemToObject(parent, name, item);
}

void rsv_bake_number(rsv_bake_document *d, cJSON *parent, const char *name, double value)
{
    put(d, parent, name, cJSON_CreateNumber(value));
}

void rsv_bake_string(rsv_bake_document *d, cJSON *parent, const char *name, const char *value)
{
    put(d, parent, name, cJSON_CreateString(value));
}

int rsv_bake_append(rsv_bake_document *d, cJSON *array, cJSON *item)
{
    if (!noted(d, item) || !array || !cJSON_AddItemToArray(array, item)) d->exhausted = true;
    return cJSON_GetArraySize(array) - 1;
}

cJSON *rsv_bake_extension(rsv_bake_document *d, cJSON *parent, const char *name)
{
    cJSON *used = rsv_bake_array(d, d->root, "extensionsUsed");
    const cJSON *entry;
    bool listed = false;
    cJSON_ArrayForEach(entry, used) if (cJSON_IsString(entry)) listed |=
        strcmp(entry->valuestring, name) == 0;
    if (!listed) rsv_bake_append(d, used, cJSON_CreateString(name));
    return rsv_bake_object(d, rsv_bake_object(d, parent, "extensions"), name);
}

/// Removes member `name` of `object` if nothing is left in it.
static void remove_empty(cJSON *object, const char *name)
{
    const cJSON *emptied = cJSON_GetObjectItemCaseSensitive(object, name);
    if (emptied && !emptied->child) cJSON_DeleteItemFromObjectCaseSensitive(object, name);
}

void rsv_bake_remove_extension(cJSON *object, const char *name)
{
    cJSON_DeleteItemFromObjectCaseSensitive(
        cJSON_GetObjectItemCaseSensitive(object, "extensions"), name);
    remove_empty(object, "extensions");
}

static void unlist(cJSON *root, const char *list, const char *name)
{
    cJSON *names = cJSON_GetObjectItemCaseSensitive(root, list), *entry, *next;
    for (entry = names ? names->child : NULL; entry; entry = next) {
        next = entry->next;
        if (cJSON_IsString(entry) && strcmp(entry->valuestring, name) == 0)
            cJSON_Delete(cJSON_DetachItemViaPointer(names, entry));
    }
    remove_empty(root, list);
}

void rsv_bake_unlist_extension(rsv_bake_document *d, const char *name)
{
    unlist(d->root, "extensionsUsed", name);
    unlist(d->root, "extensionsRequired", name);
}

int rsv_bake_add_view(rsv_bake_document *d, const void *data, size_t bytes, int target)
{
    size_t begin = append_bytes(d, data, bytes);
    cJSON *view = noted(d, cJSON_CreateObject());
    rsv_bake_number(d, view, "buffer", 0);
    rsv_bake_number(d, view, "byteOffset", (double)begin);
    rsv_bake_number(d, view, "byteLength", (double)bytes);
    if (target) rsv_bake_number(d, view, "target", target);
    return rsv_bake_append(d, rsv_bake_array(d, d->root, "bufferViews"), view);
}

static int add_accessor(
    rsv_bake_document *d, int view, int component, size_t count, const char *type)
{
    cJSON *accessor = noted(d, cJSON_CreateObject());
    rsv_bake_number(d, accessor, "bufferView", view);
    rsv_bake_number(d, accessor, "componentType", component);
    rsv_bake_number(d, accessor, "count", (double)count);
    rsv_bake_string(d, accessor, "type", type);
    return rsv_bake_append(d, rsv_bake_array(d, d->root, "accessors"), accessor);
}

int rsv_bake_add_floats(
    rsv_bake_document *d, const float *data, size_t count, int width, bool bounded)
{
    static const char *const type[] = { "", "SCALAR", "VEC2", "VEC3", "VEC4" };
    size_t floats = count * (size_t)width;
    int view = rsv_bake_add_view(d, data, floats * sizeof *data, RSV_BAKE_VERTICES);
    int index = add_accessor(d, view, RSV_GLTF_FLOAT, count, type[width]);
    if (!bounded || !count) return index;
    cJSON *accessor = cJSON_GetArrayItem(rsv_bake_array(d, d->root, "accessors"), index);
    cJSON *min = rsv_bake_array(d, accessor, "min"), *max = rsv_bake_array(d, accessor, "max");
    for (size_t c = 0; c < (size_t)width; c++) {
        float low = data[c], high = data[c];
        for (size_t k = c; k < floats; k += (size_t)width) {
            low = data[k] < low ? data[k] : low;
            high = data[k] > high ? data[k] : high;
        }
        rsv_bake_append(d, min, cJSON_CreateNumber((double)low));
        rsv_bake_append(d, max, cJSON_CreateNumber((double)high));
    }
    return index;
}

int rsv_bake_add_indices(rsv_bake_document *d, const uint32_t *index, size_t count)
{
    int view = rsv_bake_add_view(d, index, count * sizeof *index, RSV_BAKE_INDICES);
    return add_accessor(d, view, RSV_GLTF_UNSIGNED_INT, count, "SCALAR");
}

// ---- writing --------------------------------------------------------------------------------------

static void append_chunk(
    rsv_atomic_file *file, uint32_t type, const void *data, size_t bytes, uint8_t padding)
{
    const uint8_t pad[4] = { padding, padding, padding, padding };
    size_t rest = -bytes & 3;
    const uint32_t header[2] = { (uint32_t)(bytes + rest), type };
    rsv_atomic_file_append(file, header, sizeof header);
    rsv_atomic_file_append(file, data, bytes);
    rsv_atomic_file_append(file, pad, rest);
}

/// cJSON takes 15 digits for enough where they come close. A number that needs more becomes text of its own, so that
/// all are read back as they were.
static void keep_digits(rsv_bake_document *d, cJSON *item)
{
    char digits[RSV_NUMBER_BYTES];
    for (cJSON *child = item->child; child; child = child->next)
        keep_digits(d, child);
    if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble)) return;
    rsv_number_text(digits, 15, item->valuedouble);
    if (rsv_number_value(digits, NULL) == item->valuedouble) return;
    rsv_number_text(digits, 17, item->valuedouble);
    size_t bytes = strlen(digits) + 1;
    item->valuestring = cJSON_malloc(bytes);
    d->exhausted |= !item->valuestring;
    if (!item->valuestring) return;
    memcpy(item->valuestring, digits, bytes);
    item->type = (item->type & ~0xff) | cJSON_Raw;
}

rsv_status rsv_bake_document_write(rsv_bake_document *d, const char *path)
{
    rsv_status status;
    rsv_atomic_file file = { .descriptor = -1 };
    cJSON *buffer = cJSON_GetArrayItem(rsv_bake_array(d, d->root, "buffers"), 0);
    rsv_bake_number(d, buffer, "byteLength", (double)d->byte_count);
    keep_digits(d, d->root);
    char *text = cJSON_PrintUnformatted(d->root);
    if (d->exhausted || !text) {
        status = rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", path);
        goto cleanup;
    }
    size_t length = strlen(text),
           total = 28 + ((length + 3) & ~3ull) + ((d->byte_count + 3) & ~3ull);
    if (total > UINT32_MAX) {
        status =
            rsv_fail(RSV_ERROR_UNSUPPORTED, "%s: it would exceed 4 GiB, the limit of .glb", path);
        goto cleanup;
    }
    const uint32_t header[3] = { RSV_GLB_MAGIC, 2, (uint32_t)total };
    RSV_TRY(rsv_atomic_file_open(&file, path));
    rsv_atomic_file_append(&file, header, sizeof header);
    append_chunk(&file, RSV_GLB_JSON, text, length, ' ');
    append_chunk(&file, RSV_GLB_BINARY, d->bytes, d->byte_count, 0);
    status = rsv_atomic_file_commit(&file);
cleanup:
    rsv_atomic_file_discard(&file);
    cJSON_free(text);
    return status;
}
