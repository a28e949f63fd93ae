/// A glTF file for partial changes: its JSON as it is, and all its buffers as one.
///
/// Everything else stays unchanged: nodes, animations, cameras, extras, unknown extensions. External buffers and images
/// are embedded, so that the result is self-contained.
#ifndef RSV_BAKE_DOCUMENT_H
#define RSV_BAKE_DOCUMENT_H

#include "../core/core.h"
#include "../io/gltf_document.h"

#include <cjson/cJSON.h>

/// Target of a buffer view.
enum { RSV_BAKE_VERTICES = 34962, RSV_BAKE_INDICES = 34963 };

typedef struct rsv_bake_document {
    rsv_context *context;
    const char *name; ///< of the file, for messages; borrowed
    bool is_made;     ///< of the scene as it is: an object is a node, a mesh and a primitive
    const rsv_gltf_document *gltf; ///< the same file, parsed
    cJSON *root;
    uint8_t *bytes; ///< of the only buffer
    size_t byte_count, byte_capacity;
    bool exhausted; ///< an allocation failed; reported when it is written
} rsv_bake_document;

/// The document of a scene, which must outlive this; or one generated from the scene, if it has none.
rsv_status rsv_bake_document_open(const rsv_scene *scene, rsv_bake_document *document);
void rsv_bake_document_close(rsv_bake_document *document);
/// Writes binary glTF. The file appears complete or not at all.
rsv_status rsv_bake_document_write(rsv_bake_document *document, const char *path);

/// The array `name` of an object, made if it is missing. NULL on exhaustion, as the others.
cJSON *rsv_bake_array(rsv_bake_document *document, cJSON *parent, const char *name);
/// The object `name`, created if necessary.
cJSON *rsv_bake_object(rsv_bake_document *document, cJSON *parent, const char *name);
void rsv_bake_number(rsv_bake_document *document, cJSON *parent, const char *name, double value);
void rsv_bake_string(
    rsv_bake_document *document, cJSON *parent, const char *name, const char *value);
/// Appends an item and returns its index.
int rsv_bake_append(rsv_bake_document *document, cJSON *array, cJSON *item);
/// An object for extension `name` of `parent`, which is listed as used.
cJSON *rsv_bake_extension(rsv_bake_document *document, cJSON *parent, const char *name);
/// Takes extension `name` out of an object, and its "extensions" if nothing else is left there.
void rsv_bake_remove_extension(cJSON *object, const char *name);
/// Takes an extension that nothing uses any more out of the file's lists.
void rsv_bake_unlist_extension(rsv_bake_document *document, const char *name);

/// Appends data as a buffer view of its own. @param target one of the two above, 0 = neither @return its index
int rsv_bake_add_view(rsv_bake_document *document, const void *data, size_t bytes, int target);

/// Appends vectors of floats as an accessor. @param width 1..4 @param bounded whether to add min and max
int rsv_bake_add_floats(
    rsv_bake_document *document, const float *data, size_t count, int width, bool bounded);
/// Appends indices.
int rsv_bake_add_indices(rsv_bake_document *document, const uint32_t *index, size_t count);

#endif
