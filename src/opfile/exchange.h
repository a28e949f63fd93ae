/// The parts of an operator file, each written and read by one description.
#ifndef RSV_EXCHANGE_H
#define RSV_EXCHANGE_H

#include "../solve/light_change.h"
#include "tensor_file.h"

rsv_status rsv_write_scene(rsv_tensor_file *file, const rsv_scene *scene);
rsv_status rsv_read_scene(rsv_tensor_file *file, rsv_scene **scene);
/// Writes the origin of a scene far from its origin; nothing for others.
rsv_status rsv_write_origin(rsv_tensor_file *file, const rsv_scene_view *scene);

/// The document that the scene keeps (scene/document.h). Scenes and files may have none.
rsv_status rsv_write_document(rsv_tensor_file *file, const rsv_scene *scene);
rsv_status rsv_read_document(rsv_tensor_file *file, rsv_scene *scene);

/// The text of a note that is a JSON object of numbers: the fields of a struct by name.
typedef enum rsv_field_kind {
    RSV_FIELD_U32,
    RSV_FIELD_BOOL,
    RSV_FIELD_FLOAT,
    RSV_FIELD_DOUBLE,
    RSV_FIELD_U64,
    RSV_FIELD_TEXT ///< char array
} rsv_field_kind;

typedef struct rsv_field {
    const char *name;
    rsv_field_kind kind;
    size_t offset, bytes;
} rsv_field;

rsv_status rsv_write_fields(rsv_tensor_file *file, const char *note, const rsv_field *field,
    size_t field_count, const void *object);
/// Fields that the note lacks stay as they are. RSV_ERROR_FORMAT for numbers that do not fit their fields.
rsv_status rsv_read_fields(rsv_tensor_file *file, const char *note, const rsv_field *field,
    size_t field_count, void *object);

/// A note that is a JSON array of texts.
rsv_status rsv_write_names(
    rsv_tensor_file *file, const char *note, const char *const *name, size_t count);
/// @param names out: `count` of them, whose texts belong to *list; free that with cJSON_Delete
rsv_status rsv_read_names(
    rsv_tensor_file *file, const char *note, size_t count, const char **names, cJSON **list);

/// Writes one set of elements.
/// @param prefix of the tensors, such as "element."
/// @param scene of the light
rsv_status rsv_write_elements(rsv_tensor_file *file, const char *prefix,
    const rsv_scene_view *scene, const rsv_elements *elements);
/// @param alike elements of the same scene; NULL = there are none yet
rsv_status rsv_read_elements(rsv_tensor_file *file, const char *prefix, const rsv_world *world,
    const rsv_elements *alike, rsv_elements **elements);

/// A field [count] of RGB values that must be finite, and not negative where `least` is 0. It may be missing.
rsv_status rsv_exchange_rgb(
    rsv_tensor_file *file, const char *name, rsv_rgb **field, size_t count, float least);
/// RSV_ERROR_FORMAT where an array is missing.
rsv_status rsv_exchange_needed(const rsv_tensor_file *file, const char *name, const void *array);

/// Elements of the air, which follow those of surfaces.
rsv_status rsv_write_voxels(rsv_tensor_file *file, const rsv_elements *elements);
/// @param elements read before; those of the air are added @return RSV_ERROR_FORMAT too if they are not as many as were
/// kept
rsv_status rsv_read_voxels(rsv_tensor_file *file, rsv_elements *elements);

/// Operator and light: elements, G, K, E0 and E. @param gathered_scale of the emission that rows found
rsv_status rsv_write_solution(
    rsv_tensor_file *file, const rsv_light_view *light, rsv_rgb gathered_scale);
rsv_status rsv_read_solution(rsv_tensor_file *file, rsv_world *world, rsv_light **light);

/// E0 light by light; where sources are scaled, also how they stand, and all as they are by themselves.
rsv_status rsv_write_basis(
    rsv_tensor_file *file, const rsv_light *light, const rsv_light_basis *basis);
rsv_status rsv_read_basis(rsv_tensor_file *file, rsv_light *light);

/// Places where light is shown, for readers at run time: each is a weighted mean of three elements.
typedef struct rsv_file_receivers {
    const char *kind; ///< "vertex", "texel"
    size_t count;
    const uint32_t (*element)[3]; ///< [count]
    const float (*weight)[3];     ///< [count]
} rsv_file_receivers;

/// rsv_light_save with receivers, and then without the document. @param receivers NULL = none
rsv_status rsv_light_save_receivers(const rsv_light *solution, const char *scene_name,
    const rsv_file_receivers *receivers, const char *path);

/// Prefixes of the sets of elements.
#define RSV_COARSE_PREFIX "element."
#define RSV_DIRECT_PREFIX "direct."
#define RSV_CAUSTIC_PREFIX "caustic."
#define RSV_DIFFUSED_PREFIX "diffused."
#define RSV_VOXEL_PREFIX "voxel."

#endif
