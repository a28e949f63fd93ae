#include "image_exr.h"

#include <string.h>

void rsv_exr_keep_silent(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr, (void)code, (void)message; // results say enough
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

/// Translates OpenEXR's error codes for users.
static const char *meaning_of(exr_result_t result)
{
    switch (result) {
    case EXR_ERR_OUT_OF_MEMORY:
        return "it is damaged, or too large for memory";
    case EXR_ERR_FILE_ACCESS:
    case EXR_ERR_FILE_BAD_HEADER:
        return "it is not an EXR file, or its header is damaged";
    case EXR_ERR_MISSING_REQ_ATTR:
    case EXR_ERR_NO_ATTR_BY_NAME:
        return "its header lacks an attribute that every EXR file has";
    case EXR_ERR_NAME_TOO_LONG:
    case EXR_ERR_INVALID_ATTR:
    case EXR_ERR_ATTR_TYPE_MISMATCH:
    case EXR_ERR_ATTR_SIZE_MISMATCH:
        return "an attribute of its header is not valid";
    case EXR_ERR_FEATURE_NOT_IMPLEMENTED:
        return "it is stored in a way that is not supported; save it as scan lines with ZIP "
               "compression";
    default:
        return "its pixels are damaged or cut off";
    }
}

rsv_status rsv_exr_check(const rsv_exr_stream *stream, exr_result_t result)
{
    rsv_status status = status_of(stream, result);
    if (status == RSV_OK) return RSV_OK;
    if (stream->output && stream->output->error) // the library does not know why
        return rsv_fail(RSV_ERROR_IO, "cannot write '%s': %s", stream->output->target,
            strerror(stream->output->error));
    if (stream->input)
        return rsv_fail(status, "cannot read '%s': %s", stream->input->path, meaning_of(result));
    return rsv_fail(status, "cannot write '%s': %s", stream->output->target,
        result == EXR_ERR_OUT_OF_MEMORY ? "out of memory" : "its pixels cannot be packed");
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
