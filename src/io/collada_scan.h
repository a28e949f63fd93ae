/// What a COLLADA file says of its cameras and lights that Assimp's structures cannot hold, or hold wrongly.
#ifndef RSV_COLLADA_SCAN_H
#define RSV_COLLADA_SCAN_H

#include "resolvent/io.h"

#include <stddef.h>

#define RSV_COLLADA_NAME_BYTES 128

typedef enum rsv_collada_kind { RSV_COLLADA_CAMERA, RSV_COLLADA_LIGHT } rsv_collada_kind;

/// A value of a camera or light that a file may leave out.
typedef enum rsv_collada_value {
    RSV_COLLADA_XFOV, ///< degrees
    RSV_COLLADA_YFOV, ///< degrees
    RSV_COLLADA_ASPECT,
    RSV_COLLADA_XMAG, ///< half a width, in units of the file
    RSV_COLLADA_YMAG,
    RSV_COLLADA_FALLOFF_ANGLE, ///< degrees
    RSV_COLLADA_FALLOFF_EXPONENT,
    RSV_COLLADA_OUTER_CONE, ///< degrees; of some exporters, as the next
    RSV_COLLADA_PENUMBRA,
    RSV_COLLADA_SHIFT_X, ///< of Blender's film, parts of its longer side
    RSV_COLLADA_SHIFT_Y,
    RSV_COLLADA_VALUE_COUNT
} rsv_collada_value;

typedef struct rsv_collada_object {
    rsv_collada_kind kind;
    char id[RSV_COLLADA_NAME_BYTES];
    double value[RSV_COLLADA_VALUE_COUNT]; ///< NAN = not given
} rsv_collada_object;

/// A node's reference to a camera or light.
typedef struct rsv_collada_instance {
    rsv_collada_kind kind;
    char node[RSV_COLLADA_NAME_BYTES]; ///< as Assimp names it: by its id
    char id[RSV_COLLADA_NAME_BYTES];   ///< of the camera or light
} rsv_collada_instance;

/// An id, or a reference to one.
typedef struct rsv_collada_name {
    char text[RSV_COLLADA_NAME_BYTES];
} rsv_collada_name;

typedef struct rsv_collada {
    rsv_collada_object *object; ///< [object_count]
    size_t object_count, object_capacity;
    rsv_collada_instance *instance; ///< [instance_count], in the order of the file
    size_t instance_count, instance_capacity;
    rsv_collada_name *id; ///< [id_count] every id that can be referred to
    size_t id_count, id_capacity;
    rsv_collada_name *reference; ///< [reference_count] without the '#' of this file
    size_t reference_count, reference_capacity;
    char unused[400]; ///< names of elements that are not read, separated by commas
} rsv_collada;

/// Reads a file that Assimp has accepted as COLLADA, and skips what it does not understand. Warns of references to ids
/// that the file does not contain, and of kinds of elements that are not used.
rsv_status rsv_collada_scan(
    rsv_context *context, const rsv_file_source *files, const char *path, rsv_collada *collada);
void rsv_collada_release(rsv_context *context, rsv_collada *collada);

/// The camera or light that a node refers to, `order`-th of its kind; NULL = not found.
const rsv_collada_object *rsv_collada_find(
    const rsv_collada *collada, rsv_collada_kind kind, const char *node, size_t order);

#endif
