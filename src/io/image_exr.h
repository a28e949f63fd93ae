/// Code shared by the reader and the writer of OpenEXR files. Both use OpenEXR's C core.
#ifndef RSV_IMAGE_EXR_H
#define RSV_IMAGE_EXR_H

#include "image_internal.h"

#include <openexr.h>

/// The user data of an OpenEXR context: where its bytes are.
typedef struct rsv_exr_stream {
    const rsv_image_file *input; ///< when reading
    rsv_atomic_file *output;     ///< when writing
} rsv_exr_stream;

/// Keeps the library's messages from standard error.
void rsv_exr_keep_silent(exr_const_context_t exr, exr_result_t code, const char *message);

/// Turns a failed call into an error that names the file and the problem.
rsv_status rsv_exr_check(const rsv_exr_stream *stream, exr_result_t result);

/// Splits "direct.R" into layer "direct" and component "R"; a plain "R" has layer "". False if the
/// layer's name is too long for us.
bool rsv_exr_split_channel(
    const char *channel, char layer[RSV_LAYER_NAME_BYTES], const char **component);

#endif
