#include "resolvent_rt_file.h"

#include <cjson/cJSON.h>

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef RSV_RT_ZLIB
#include <math.h>
#include <zlib.h>
#endif

static int fail(rsv_rt_file *file, const char *format, ...)
{
    va_list arguments;
    int length = snprintf(file->message, sizeof file->message, "%s: ", file->path);
    va_start(arguments, format);
    vsnprintf(file->message + length, sizeof file->message - (size_t)length, format, arguments);
    va_end(arguments);
    return -1;
}

/// Keeps the end of a path that is too long for a message.
static void keep_path(rsv_rt_file *file, const char *path)
{
    size_t length = strlen(path), most = sizeof file->path - 1;
    if (length <= most)
        memcpy(file->path, path, length + 1);
    else
        snprintf(file->path, sizeof file->path, "...%s", path + length - (most - 3));
}

// ---- the file -------------------------------------------------------------------------------------

static int read_all(rsv_rt_file *file, const char *path)
{
    FILE *stream = fopen(path, "rb");
    long size = -1;
    int result = 0;
    if (!stream) return fail(file, "cannot be opened");
    if (fseek(stream, 0, SEEK_END) == 0) size = ftell(stream);
    if (size < 8 || fseek(stream, 0, SEEK_SET) != 0) {
        result = fail(file, "it is too short for a safetensors file");
    } else {
        file->size = (size_t)size;
        file->bytes = malloc(file->size);
        if (!file->bytes)
            result = fail(file, "out of memory");
        else if (fread(file->bytes, 1, file->size, stream) != file->size)
            result = fail(file, "it cannot be read");
    }
    fclose(stream);
    return result;
}

int rsv_rt_file_open(rsv_rt_file *file, const char *path)
{
    uint64_t length = 0;
    memset(file, 0, sizeof *file);
    keep_path(file, path);
    if (read_all(file, path) != 0) return -1;
    for (int k = 7; k >= 0; k--)
        length = length << 8 | file->bytes[k];
    if (length > file->size - 8) return fail(file, "it is cut off, or not a safetensors file");
    file->header = cJSON_ParseWithLength((const char *)file->bytes + 8, (size_t)length);
    if (!cJSON_IsObject(file->header)) return fail(file, "its header is not a JSON object");
    file->data = 8 + (size_t)length;
    return 0;
}

void rsv_rt_file_close(rsv_rt_file *file)
{
    cJSON_Delete(file->header);
    free(file->bytes);
    free(file->owned);
    file->header = NULL;
    file->bytes = NULL;
    file->owned = NULL;
}

static const char *note(const rsv_rt_file *file, const char *name)
{
    const cJSON *notes = cJSON_GetObjectItemCaseSensitive(file->header, "__metadata__");
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(notes, name));
    return text ? text : "";
}

// ---- arrays ---------------------------------------------------------------------------------------

static size_t type_bytes(const char *type)
{
    return !strcmp(type, "U64")                           ? 8
           : !strcmp(type, "U32") || !strcmp(type, "F32") ? 4
           : !strcmp(type, "U16")                         ? 2
                                                          : 1;
}

/// Whether there is such an array; it may still be damaged.
static int has(const rsv_rt_file *file, const char *name)
{
    return cJSON_IsObject(cJSON_GetObjectItemCaseSensitive(file->header, name));
}

const void *rsv_rt_file_array(rsv_rt_file *file, const char *name, const char *type, size_t *count)
{
    const cJSON *entry = cJSON_GetObjectItemCaseSensitive(file->header, name);
    const cJSON *range = cJSON_GetObjectItemCaseSensitive(entry, "data_offsets");
    const char *its = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(entry, "dtype"));
    const cJSON *first = cJSON_GetArrayItem(range, 0), *last = cJSON_GetArrayItem(range, 1);
    size_t bytes = type_bytes(type), room = file->size - file->data, begin, end;
    if (!its || strcmp(its, type) != 0 || !cJSON_IsNumber(first) || !cJSON_IsNumber(last)) {
        fail(file, "array '%s' is missing, or not of type %s", name, type);
        return NULL;
    }
    if (!(first->valuedouble >= 0 && first->valuedouble <= last->valuedouble &&
            last->valuedouble <= (double)room)) {
        fail(file, "array '%s' reaches beyond the end of the file", name);
        return NULL;
    }
    begin = (size_t)first->valuedouble;
    end = (size_t)last->valuedouble;
    if ((end - begin) % bytes || (file->data + begin) % bytes) {
        fail(file, "array '%s' is not aligned to its numbers", name);
        return NULL;
    }
    if (count) *count = (end - begin) / bytes;
    return file->bytes + file->data + begin;
}

/// Finds an array that must have `wanted` values: 64 bits, as products of sizes in a file can exceed 32.
static const void *sized(rsv_rt_file *file, const char *name, const char *type, uint64_t wanted)
{
    size_t count;
    const void *array = rsv_rt_file_array(file, name, type, &count);
    if (!array || count == wanted) return array;
    fail(file, "array '%s' has %zu numbers instead of %llu", name, count,
        (unsigned long long)wanted);
    return NULL;
}

/// Length of one dimension of an array; 0 if it has no such dimension.
static uint32_t extent(const rsv_rt_file *file, const char *name, int dimension)
{
    const cJSON *entry = cJSON_GetObjectItemCaseSensitive(file->header, name);
    const cJSON *shape = cJSON_GetObjectItemCaseSensitive(entry, "shape");
    const cJSON *length = cJSON_GetArrayItem(shape, dimension);
    int whole = cJSON_IsNumber(length) && length->valuedouble >= 0 &&
                length->valuedouble <= (double)UINT32_MAX;
    return whole ? (uint32_t)length->valuedouble : 0;
}

/// The names are one JSON text in the notes: parsed once, kept in the header.
static const cJSON *light_names(const rsv_rt_file *file)
{
    cJSON *names = cJSON_GetObjectItemCaseSensitive(file->header, "light.name");
    if (names) return names;
    names = cJSON_Parse(note(file, "light.name"));
    if (names) cJSON_AddItemToObject(file->header, "light.name", names);
    return names;
}

const char *rsv_rt_file_light(const rsv_rt_file *file, uint32_t light)
{
    return cJSON_GetStringValue(cJSON_GetArrayItem(light_names(file), (int)light));
}

// ---- the operator ---------------------------------------------------------------------------------

static int read_tinted(rsv_rt_file *file, rsv_rt_operator *t, size_t *entries)
{
    *entries = 0;
    if (!has(file, "transport.tinted.column")) return 0;
    t->tinted_row_start =
        sized(file, "transport.tinted.row_start", "U64", (uint64_t)t->element_count + 1);
    t->tinted_column = rsv_rt_file_array(file, "transport.tinted.column", "U32", entries);
    if (!t->tinted_row_start || !t->tinted_column) return -1;
    t->tinted_weight = sized(file, "transport.tinted.weight", "F32", 3 * (uint64_t)*entries);
    return t->tinted_weight ? 0 : -1;
}

static int read_hanging(rsv_rt_file *file, rsv_rt_operator *t)
{
    size_t count;
    if (!has(file, "element.hanging.node")) return 0;
    t->hanging_node = rsv_rt_file_array(file, "element.hanging.node", "U32", &count);
    if (!t->hanging_node) return -1;
    t->hanging_count = (uint32_t)count;
    t->hanging_parent = sized(file, "element.hanging.parent", "U32", 4 * (uint64_t)count);
    t->hanging_weight = sized(file, "element.hanging.weight", "F32", 4 * (uint64_t)count);
    return t->hanging_parent && t->hanging_weight ? 0 : -1;
}

int rsv_rt_file_operator(rsv_rt_file *file, rsv_rt_operator *t)
{
    size_t entries, tinted, count;
    memset(t, 0, sizeof *t);
    if (strcmp(note(file, "format"), "resolvent-operator") != 0)
        return fail(file, "it is not an operator file");
    if (strcmp(note(file, "format_version"), "2") != 0 &&
        strcmp(note(file, "format_version"), "3") != 0)
        return fail(file, "its format version is '%.16s', this loader reads 2 and 3",
            note(file, "format_version"));
    if (has(file, "subsurface.column"))
        return fail(
            file, "it has translucent materials; bake a basis, which holds their light too");
    t->scale = rsv_rt_file_array(file, "transport.scale", "F32", &count);
    if (!t->scale) return -1;
    t->element_count = (uint32_t)count;
    t->row_start = sized(file, "transport.row_start", "U64", (uint64_t)count + 1);
    t->column = rsv_rt_file_array(file, "transport.column", "U32", &entries);
    t->albedo = sized(file, "albedo", "F32", 3 * (uint64_t)count);
    if (!t->row_start || !t->column || !t->albedo) return -1;
    if (read_tinted(file, t, &tinted) != 0 || read_hanging(file, t) != 0) return -1;
    uint8_t *scratch = malloc(count ? count : 1);
    if (!scratch) return fail(file, "out of memory");
    rsv_rt_status status = rsv_rt_operator_check(t, entries, tinted, scratch);
    free(scratch);
    return status == RSV_RT_OK ? 0 : fail(file, "%s", rsv_rt_status_text(status));
}

// ---- direct light ---------------------------------------------------------------------------------

/// Adds an array of the file, if it is there.
static int add(rsv_rt_file *file, const char *name, size_t count, float *sum)
{
    if (!has(file, name)) return 0;
    const float *array = sized(file, name, "F32", count);
    if (!array) return -1;
    for (size_t k = 0; k < count; k++)
        sum[k] += array[k];
    return 0;
}

/// Lights of a relit file are stored as they are by themselves. @param value [lights][floats]
static int apply_scales(rsv_rt_file *file, uint32_t lights, size_t floats, float *value)
{
    if (!has(file, "light.scale")) return 0;
    const float *scale = sized(file, "light.scale", "F32", 3 * (uint64_t)lights);
    if (!scale) return -1;
    for (uint32_t l = 0; l < lights; l++)
        for (size_t k = 0; k < floats; k++)
            value[l * floats + k] *= scale[3 * l + k % 3];
    return 0;
}

/// Adds every light by itself, and the light that the rows gathered.
static int add_parts(rsv_rt_file *file, uint32_t lights, size_t floats)
{
    char name[64];
    for (uint32_t l = 0; l < lights; l++) {
        float *value = file->owned + l * floats;
        snprintf(name, sizeof name, "light.%u.source", l);
        if (add(file, name, floats, value) != 0) return -1;
        snprintf(name, sizeof name, "light.%u.coarse_caustic", l);
        if (add(file, name, floats, value) != 0) return -1;
    }
    if (apply_scales(file, lights, floats, file->owned) != 0) return -1;
    return add(file, "source.gathered", floats, file->owned + lights * floats);
}

int rsv_rt_file_direct(rsv_rt_file *file, rsv_rt_basis *direct)
{
    size_t floats;
    memset(direct, 0, sizeof *direct);
    if (!rsv_rt_file_array(file, "source", "F32", &floats)) return -1;
    uint32_t lights = (uint32_t)cJSON_GetArraySize(light_names(file));
    int apart = has(file, "light.0.source");
    uint32_t count = apart ? lights + 1 : 1; // one light alone is the whole
    file->owned = calloc(floats ? floats : 1, count * sizeof(float));
    if (!file->owned) return fail(file, "out of memory");
    if ((apart ? add_parts(file, lights, floats) : add(file, "source", floats, file->owned)) != 0)
        return -1;
    direct->light_count = count;
    direct->receiver_count = (uint32_t)(floats / 3);
    direct->value_count = 1;
    direct->value = file->owned;
    return 0;
}

// ---- receivers ------------------------------------------------------------------------------------

int rsv_rt_file_receivers(
    rsv_rt_file *file, const rsv_rt_operator *transport, rsv_rt_receivers *receivers)
{
    const char *name = "receiver.element";
    memset(receivers, 0, sizeof *receivers);
    if (!has(file, name))
        return fail(file, "it has no receivers; `resolvent bake --operator` writes them");
    uint32_t count = extent(file, name, 0);
    receivers->element = sized(file, name, "U32", 3 * (uint64_t)count);
    receivers->weight = sized(file, "receiver.weight", "F32", 3 * (uint64_t)count);
    if (!receivers->element || !receivers->weight) return -1;
    receivers->count = count;
    rsv_rt_status status = rsv_rt_receivers_check(receivers, transport->element_count);
    return status == RSV_RT_OK ? 0 : fail(file, "%s", rsv_rt_status_text(status));
}

// ---- baked bases ----------------------------------------------------------------------------------

/// Reads the size of a basis: the shape of its array or, if it is packed, a note.
static int read_shape(rsv_rt_file *file, int packed, rsv_rt_basis *basis)
{
    const char *name = "basis.value";
    uint32_t shape[3] = { extent(file, name, 0), extent(file, name, 1), extent(file, name, 2) };
    cJSON *noted = packed ? cJSON_Parse(note(file, "basis.shape")) : NULL;
    for (int k = 0; packed && k < 3; k++) {
        const cJSON *length = cJSON_GetArrayItem(noted, k);
        int whole = cJSON_IsNumber(length) && length->valuedouble >= 0 &&
                    length->valuedouble <= (double)UINT32_MAX;
        shape[k] = whole ? (uint32_t)length->valuedouble : 0;
    }
    cJSON_Delete(noted);
    basis->light_count = shape[0];
    basis->receiver_count = shape[1];
    basis->value_count = shape[2] / 3;
    uint64_t receivers = (uint64_t)basis->light_count * basis->receiver_count;
    if (receivers > UINT64_MAX >> 8 || basis->value_count > RSV_RT_SH_COUNT)
        return fail(file, "its basis is larger than any");
    return 0;
}

#ifdef RSV_RT_ZLIB

static float from_half(uint16_t half)
{
    int exponent = half >> 10 & 31, mantissa = half & 1023;
    float size =
        exponent ? ldexpf((float)(1024 + mantissa), exponent - 25) : ldexpf((float)mantissa, -24);
    return half & 0x8000 ? -size : size;
}

/// Green and blue are stored by how far their halves are from the channel before.
/// @param plane [width][2][receivers] low bytes of a channel's differences, then high ones; on return those of its
/// halves
static void join_planes(
    unsigned char *plane, size_t receivers, size_t width, float scale, float *value)
{
    for (size_t c = 0; c < width; c++) {
        unsigned char *low = plane + 2 * c * receivers, *high = low + receivers;
        const unsigned char *before = c % 3 ? low - 2 * receivers : NULL;
        uint16_t code = 0;
        for (size_t n = 0; n < receivers; n++) {
            uint16_t difference = (uint16_t)(low[n] | high[n] << 8);
            code = (uint16_t)(code + (difference >> 1 ^ (difference & 1 ? 0xffff : 0)));
            uint16_t base = before ? (uint16_t)(before[n] | before[receivers + n] << 8) : 0;
            uint16_t half = (uint16_t)(base + code);
            value[n * width + c] = scale * from_half(half);
            low[n] = (unsigned char)half;
            high[n] = (unsigned char)(half >> 8);
        }
    }
}

/// Zlib cannot compress by a larger factor: a damaged file must not make us allocate any amount of memory.
#define MOST_DEFLATED 1100

static int unpack_lights(
    rsv_rt_file *file, const rsv_rt_basis *basis, const float *scale, unsigned char *plane)
{
    size_t width = 3 * (size_t)basis->value_count, count, receivers = basis->receiver_count;
    char name[64];
    for (uint32_t l = 0; l < basis->light_count; l++) {
        snprintf(name, sizeof name, "basis.packed.%u", l);
        const void *bytes = rsv_rt_file_array(file, name, "U8", &count);
        uLongf made = (uLongf)(2 * receivers * width);
        if (!bytes) return -1;
        if (uncompress(plane, &made, bytes, (uLong)count) != Z_OK || made != 2 * receivers * width)
            return fail(file, "array '%s' is damaged", name);
        join_planes(plane, receivers, width, scale[l], file->owned + l * receivers * width);
    }
    return 0;
}

static int read_packed(rsv_rt_file *file, rsv_rt_basis *basis)
{
    uint64_t one = 3 * (uint64_t)basis->value_count * basis->receiver_count;
    const float *scale = sized(file, "basis.scale", "F32", basis->light_count);
    if (!scale) return -1;
    if (2 * one * basis->light_count / MOST_DEFLATED > file->size)
        return fail(file, "it is too short for its basis");
    unsigned char *plane = malloc((size_t)(2 * one) + 1);
    free(file->owned);
    file->owned = malloc((size_t)(one * basis->light_count) * sizeof(float) + 1);
    int result = plane && file->owned ? unpack_lights(file, basis, scale, plane)
                                      : fail(file, "out of memory");
    free(plane);
    basis->value = file->owned;
    return result;
}

#else

static int read_packed(rsv_rt_file *file, rsv_rt_basis *basis)
{
    (void)basis;
    return fail(file, "its basis is packed: bake without --packed, or compile the loader with "
                      "RSV_RT_ZLIB");
}

#endif

int rsv_rt_file_basis(rsv_rt_file *file, rsv_rt_basis *basis)
{
    const char *version = note(file, "format_version");
    int packed = strcmp(version, "3") == 0;
    memset(basis, 0, sizeof *basis);
    if (strcmp(note(file, "format"), "resolvent-light-basis") != 0)
        return fail(file, "it holds no light basis");
    if (!packed && strcmp(version, "1") != 0 && strcmp(version, "2") != 0)
        return fail(file, "it is a light basis of a version that is not known here");
    if (read_shape(file, packed, basis) != 0) return -1;
    uint64_t values = 3 * (uint64_t)basis->light_count * basis->receiver_count * basis->value_count;
    if (packed && read_packed(file, basis) != 0) return -1;
    if (!packed) basis->value = sized(file, "basis.value", "F32", values);
    if (!basis->value) return -1;
    if (basis->value_count && (uint32_t)cJSON_GetArraySize(light_names(file)) == basis->light_count)
        return 0;
    return fail(file, "the number of light names is not the number of lights");
}

int rsv_rt_file_probes(rsv_rt_file *file, const rsv_rt_basis *basis, rsv_rt_probe_grid *grid)
{
    const uint32_t *size = sized(file, "probe.size", "U32", 3);
    const float *origin = sized(file, "probe.origin", "F32", 3);
    const float *spacing = sized(file, "probe.spacing", "F32", 3);
    memset(grid, 0, sizeof *grid);
    grid->valid = sized(file, "probe.valid", "U8", basis->receiver_count);
    if (!size || !origin || !spacing || !grid->valid) return -1;
    double probes = (double)size[0] * size[1] * size[2];
    if (basis->value_count != RSV_RT_SH_COUNT || probes != (double)basis->receiver_count)
        return fail(file, "its grid has other probes than its basis");
    for (int a = 0; a < 3; a++) {
        if (!(spacing[a] > 0 && origin[a] - origin[a] == 0))
            return fail(file, "its grid of probes has no extent");
        grid->size[a] = size[a];
        grid->origin[a] = origin[a];
        grid->spacing[a] = spacing[a];
    }
    return 0;
}

/// Parses a number as files write it, with a point in any locale: cJSON does what strtof would not.
static float number_of(const char *text)
{
    cJSON *number = cJSON_Parse(text);
    float value = cJSON_IsNumber(number) ? (float)number->valuedouble : 0;
    cJSON_Delete(number);
    return value - value == 0 ? value : 0;
}

rsv_rt_file_turns rsv_rt_file_find_turns(const rsv_rt_file *file, const rsv_rt_basis *basis)
{
    rsv_rt_file_turns turns = { 0, 0, 0 };
    unsigned long count = strtoul(note(file, "surroundings.turns"), NULL, 10);
    if (count < 2 || count > basis->light_count) return turns;
    turns.count = (uint32_t)count;
    turns.first = basis->light_count - turns.count;
    turns.rotation = number_of(note(file, "surroundings.rotation"));
    return turns;
}
