#include "image_exr.h"

#include <stdio.h>
#include <string.h>

void rsv_exr_keep_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    exr_get_user_data(exr, &user);
    rsv_exr_stream *stream = user;
    if (stream && !stream->message[0])
        snprintf(stream->message, sizeof stream->message, "%s", message);
}

static rsv_status status_of(const rsv_exr_stream *stream, exr_result_t result)
{
    switch (result) {
    case EXR_ERR_SUCCESS:
        return RSV_OK;
    case EXR_ERR_OUT_OF_MEMORY: // what damaged PIZ data is called, too
        return stream->input ? RSV_ERROR_FORMAT : RSV_ERROR_MEMORY;
    case EXR_ERR_FEATURE_NOT_IMPLEMENTED:
        return RSV_ERROR_UNSUPPORTED;
    default:
        return stream->input ? RSV_ERROR_FORMAT : RSV_ERROR_IO;
    }
}

rsv_status rsv_exr_check(const rsv_exr_stream *stream, exr_result_t result)
{
    rsv_status status = status_of(stream, result);
    if (status == RSV_OK) return RSV_OK;
    if (stream->output && stream->output->error) // the library does not know why
        return rsv_fail(RSV_ERROR_IO, "cannot write '%s': %s", stream->output->target,
            strerror(stream->output->error));
    const char *message =
        stream->message[0] ? stream->message : exr_get_default_error_message(result);
    return rsv_fail(status, "cannot %s '%s': %s (OpenEXR)", stream->input ? "read" : "write",
        stream->input ? stream->input->path : stream->output->target, message);
}

bool rsv_exr_split_channel(
    const char *channel, char layer[RSV_LAYER_NAME_BYTES], const char **component)
{
    const char *dot = strrchr(channel, '.');
    size_t length = dot ? (size_t)(dot - channel) : 0;
    *component = dot ? dot + 1 : channel;
    if (length >= RSV_LAYER_NAME_BYTES) return false;
    memcpy(layer, channel, length);
    layer[length] = 0;
    return true;
}
