#include "gltf_accessor.h"

#include "../core/core.h"

#include <math.h>
#include <string.h>

/// A run of elements in memory.
typedef struct elements {
    const uint8_t *data; ///< NULL = all zero
    size_t stride;
    int component_type;
} elements;

/// Finds `count` elements of `element_bytes` each, and checks that they lie in their buffer view and the
/// view in its buffer. @return NULL = they do, or what is wrong
static const char *locate(const rsv_gltf_document *document, rsv_gltf_span span, size_t count,
    size_t element_bytes, elements *found)
{
    if ((size_t)span.buffer_view >= document->buffer_view_count)
        return "refers to a buffer view that does not exist";
    const rsv_gltf_buffer_view *view = &document->buffer_view[span.buffer_view];
    if ((size_t)view->buffer >= document->buffer_count)
        return "lies in a buffer that does not exist";
    const rsv_gltf_buffer *buffer = &document->buffer[view->buffer];
    if (!buffer->data && count) return "lies in a buffer without data";
    if (view->offset > buffer->size || view->length > buffer->size - view->offset)
        return "lies in a buffer view that reaches past the end of its buffer";
    size_t stride = view->stride ? view->stride : element_bytes;
    size_t last; // begin of the last element
    if (count && (__builtin_mul_overflow(count - 1, stride, &last) ||
                     __builtin_add_overflow(last, span.offset, &last) || last > view->length ||
                     element_bytes > view->length - last))
        return "reaches past the end of its buffer view";
    *found = (elements){ buffer->data ? buffer->data + view->offset + span.offset : NULL, stride,
        span.component_type };
    return NULL;
}

static double component(const uint8_t *data, int type)
{
    switch (type) {
    case RSV_GLTF_BYTE:
        return (int8_t)data[0];
    case RSV_GLTF_UNSIGNED_BYTE:
        return data[0];
    case RSV_GLTF_SHORT:
        return (int16_t)(uint16_t)(data[0] | data[1] << 8);
    case RSV_GLTF_UNSIGNED_SHORT:
        return (uint16_t)(data[0] | data[1] << 8);
    default:
        break;
    }
    uint32_t bits =
        data[0] | (uint32_t)data[1] << 8 | (uint32_t)data[2] << 16 | (uint32_t)data[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return type == RSV_GLTF_FLOAT ? (double)value : (double)bits;
}

/// Factor of normalised integers; their lower end is clamped to -1.
static double normalization(const rsv_gltf_accessor *accessor)
{
    if (!accessor->normalized) return 1;
    switch (accessor->span.component_type) {
    case RSV_GLTF_BYTE:
        return 1.0 / 127;
    case RSV_GLTF_UNSIGNED_BYTE:
        return 1.0 / 255;
    case RSV_GLTF_SHORT:
        return 1.0 / 32767;
    case RSV_GLTF_UNSIGNED_SHORT:
        return 1.0 / 65535;
    default:
        return 1;
    }
}

static void read_element(
    const elements *from, size_t i, size_t component_count, double scale, float *value)
{
    size_t step = rsv_gltf_component_bytes(from->component_type);
    for (size_t k = 0; k < component_count; k++) {
        double v =
            scale * component(from->data + i * from->stride + k * step, from->component_type);
        value[k] = (float)(scale != 1 ? fmax(v, -1) : v);
    }
}

/// For messages: "mesh", "skin", "node" or "animation", and its name.
typedef struct owner_label {
    const char *kind, *name;
} owner_label;

static rsv_status refuse(int accessor, owner_label owner, const char *problem)
{
    return rsv_fail(
        RSV_ERROR_FORMAT, "%s '%s': accessor %d %s", owner.kind, owner.name, accessor, problem);
}

/// Replaces the elements that a sparse accessor lists.
static const char *apply_sparse(
    const rsv_gltf_document *document, const rsv_gltf_accessor *accessor, float *values_out)
{
    size_t width = (size_t)accessor->component_count;
    elements indices, values;
    int index_type = accessor->sparse_indices.component_type;
    if (index_type != RSV_GLTF_UNSIGNED_BYTE && index_type != RSV_GLTF_UNSIGNED_SHORT &&
        index_type != RSV_GLTF_UNSIGNED_INT)
        return "has sparse indices that are not unsigned integers";
    const char *problem = locate(document, accessor->sparse_indices, accessor->sparse_count,
        rsv_gltf_component_bytes(index_type), &indices);
    if (problem) return problem;
    problem = locate(document, accessor->sparse_values, accessor->sparse_count,
        width * rsv_gltf_component_bytes(accessor->span.component_type), &values);
    if (problem) return problem;
    double scale = normalization(accessor);
    for (size_t i = 0; i < accessor->sparse_count; i++) {
        size_t target = (size_t)component(indices.data + i * indices.stride, index_type);
        if (target >= accessor->count) return "has a sparse index past its end";
        read_element(&values, i, width, scale, values_out + target * width);
    }
    return NULL;
}

/// Decodes `*values` [count * component_count] of an accessor whose type has been checked. The caller frees them.
static rsv_status decode(rsv_context *context, const rsv_gltf_document *document, int accessor,
    owner_label owner, float **values)
{
    const rsv_gltf_accessor *a = &document->accessor[accessor];
    size_t width = (size_t)a->component_count;
    elements from = { .data = NULL };
    const char *problem = NULL;
    if (a->span.buffer_view >= 0)
        problem = locate(document, a->span, a->count,
            width * rsv_gltf_component_bytes(a->span.component_type), &from);
    else if (a->count > RSV_GLTF_MAX_ZERO_FILLED)
        problem = "has no buffer view and too large a count";
    if (problem) return refuse(accessor, owner, problem);

    float *decoded = rsv_alloc(context, a->count, width * sizeof *decoded);
    if (!decoded) return RSV_ERROR_MEMORY;
    double scale = normalization(a);
    for (size_t i = 0; from.data && i < a->count; i++)
        read_element(&from, i, width, scale, decoded + i * width);
    if (a->sparse_count) problem = apply_sparse(document, a, decoded);
    if (problem) {
        rsv_free(context, decoded);
        return refuse(accessor, owner, problem);
    }
    *values = decoded;
    return RSV_OK;
}

static rsv_status read_vectors(rsv_context *context, const rsv_gltf_document *document,
    int accessor, owner_label owner, float **values)
{
    if ((size_t)accessor >= document->accessor_count)
        return refuse(accessor, owner, "does not exist");
    const rsv_gltf_accessor *a = &document->accessor[accessor];
    int type = a->span.component_type;
    if (a->component_count < 2 || a->component_count > 4 || !rsv_gltf_component_bytes(type) ||
        type == RSV_GLTF_UNSIGNED_INT)
        return refuse(accessor, owner, "must hold vectors of float or of 8- or 16-bit integers");
    return decode(context, document, accessor, owner, values);
}

rsv_status rsv_gltf_read_attribute(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, rsv_gltf_attribute *attribute)
{
    rsv_status status = read_vectors(
        context, document, accessor, (owner_label){ "mesh", owner }, &attribute->values);
    if (status != RSV_OK) return status;
    attribute->count = document->accessor[accessor].count;
    attribute->width = (size_t)document->accessor[accessor].component_count;
    return RSV_OK;
}

rsv_status rsv_gltf_read_instances(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *node, size_t width, float **values)
{
    const owner_label owner = { "node", node };
    rsv_status status = read_vectors(context, document, accessor, owner, values);
    if (status != RSV_OK || (size_t)document->accessor[accessor].component_count == width)
        return status;
    rsv_free(context, *values);
    *values = NULL;
    return refuse(accessor, owner, width == 3 ? "must hold VEC3" : "must hold VEC4");
}

rsv_status rsv_gltf_read_matrices(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *skin, float (**matrices)[16], size_t *count)
{
    const owner_label owner = { "skin", skin };
    if ((size_t)accessor >= document->accessor_count)
        return refuse(accessor, owner, "does not exist");
    const rsv_gltf_accessor *a = &document->accessor[accessor];
    if (a->component_count != 16 || a->span.component_type != RSV_GLTF_FLOAT)
        return refuse(accessor, owner, "must hold MAT4 of float");
    *count = a->count;
    return decode(context, document, accessor, owner, (float **)matrices);
}

rsv_status rsv_gltf_read_keys(rsv_context *context, const rsv_gltf_document *document, int accessor,
    const char *animation, rsv_gltf_numbers *numbers)
{
    static const char *const needed[] = { "", "must hold SCALAR", "", "must hold VEC3",
        "must hold VEC4" };
    const owner_label owner = { "animation", animation };
    if ((size_t)accessor >= document->accessor_count)
        return refuse(accessor, owner, "does not exist");
    const rsv_gltf_accessor *a = &document->accessor[accessor];
    int type = a->span.component_type;
    if ((size_t)a->component_count != numbers->width)
        return refuse(accessor, owner, needed[numbers->width]);
    if (!rsv_gltf_component_bytes(type) || type == RSV_GLTF_UNSIGNED_INT)
        return refuse(accessor, owner, "must hold floats or normalised 8- or 16-bit integers");
    rsv_status status = decode(context, document, accessor, owner, &numbers->value);
    if (status != RSV_OK) return status;
    numbers->count = a->count;
    for (size_t k = 0; k < numbers->count * numbers->width; k++) {
        if (isfinite(numbers->value[k])) continue;
        rsv_free(context, numbers->value);
        numbers->value = NULL;
        return refuse(accessor, owner, "holds a number that is not finite");
    }
    return RSV_OK;
}

rsv_status rsv_gltf_read_vectors(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, rsv_vec3 **vectors, size_t *count)
{
    rsv_gltf_attribute read;
    rsv_status status = rsv_gltf_read_attribute(context, document, accessor, owner, &read);
    if (status != RSV_OK) return status;
    *vectors = (rsv_vec3 *)read.values;
    *count = read.count;
    if (read.width == 3) return RSV_OK;
    rsv_free(context, read.values);
    *vectors = NULL;
    return refuse(accessor, (owner_label){ "mesh", owner }, "must hold VEC3");
}

rsv_status rsv_gltf_read_indices(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *mesh, size_t vertex_count, rsv_gltf_indices *indices)
{
    const owner_label owner = { "mesh", mesh };
    if ((size_t)accessor >= document->accessor_count)
        return refuse(accessor, owner, "does not exist");
    const rsv_gltf_accessor *a = &document->accessor[accessor];
    int type = a->span.component_type;
    bool is_index = type == RSV_GLTF_UNSIGNED_BYTE || type == RSV_GLTF_UNSIGNED_SHORT ||
                    type == RSV_GLTF_UNSIGNED_INT;
    if (a->component_count != 1 || !is_index || a->sparse_count)
        return refuse(accessor, owner, "must hold plain SCALAR indices of unsigned integers");
    elements from;
    const char *problem =
        locate(document, a->span, a->count, rsv_gltf_component_bytes(type), &from);
    if (problem) return refuse(accessor, owner, problem);

    uint32_t *decoded = rsv_alloc(context, a->count, sizeof *decoded);
    if (!decoded) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < a->count; i++) {
        decoded[i] = (uint32_t)component(from.data + i * from.stride, type);
        if (decoded[i] >= vertex_count) {
            rsv_fail(RSV_ERROR_FORMAT,
                "mesh '%s': accessor %d: index %zu refers to vertex %u, but there are only %zu",
                mesh, accessor, i, decoded[i], vertex_count);
            rsv_free(context, decoded);
            return RSV_ERROR_FORMAT;
        }
    }
    indices->index = decoded;
    indices->count = a->count;
    return RSV_OK;
}
