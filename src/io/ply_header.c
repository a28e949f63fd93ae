#include "ply_header.h"

#include "../core/core.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_LINES 4096
#define LINE_BYTES 1024

typedef struct ply_header {
    bool is_ascii, has_format;
    uint64_t count;     ///< of the element at hand
    uint64_t row_bytes; ///< least that one of them takes
    uint64_t needed;    ///< least that all elements before it take
    char element[64];   ///< its name
    char unused[256];   ///< names of what has no effect, with commas
} ply_header;

/// Bytes of a value in a binary file; 0 = no such type.
static unsigned size_of_type(const char *type)
{
    static const struct {
        const char *name;
        unsigned size;
    } types[] = { { "char", 1 }, { "uchar", 1 }, { "short", 2 }, { "ushort", 2 }, { "int", 4 },
        { "uint", 4 }, { "float", 4 }, { "double", 8 }, { "int8", 1 }, { "uint8", 1 },
        { "int16", 2 }, { "uint16", 2 }, { "int32", 4 }, { "uint32", 4 }, { "float32", 4 },
        { "float64", 8 } };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(type, types[i].name) == 0) return types[i].size;
    return 0;
}

static bool read_format(ply_header *header, const char *line)
{
    char format[32], version[16];
    if (header->has_format || sscanf(line, "format %31s %15s", format, version) != 2) return false;
    header->is_ascii = strcmp(format, "ascii") == 0;
    header->has_format = header->is_ascii || strcmp(format, "binary_little_endian") == 0 ||
                         strcmp(format, "binary_big_endian") == 0;
    return header->has_format;
}

/// Adds up the element that ends here.
static bool end_element(ply_header *header)
{
    if (header->row_bytes && header->count > (UINT64_MAX - header->needed) / header->row_bytes)
        return false;
    header->needed += header->count * header->row_bytes;
    header->count = header->row_bytes = 0;
    return true;
}

static void note_unused(ply_header *header, const char *name)
{
    size_t used = strlen(header->unused);
    if (header->count == 0) return;
    if (used + strlen(name) + 8 > sizeof header->unused)
        return; // a list without an end helps nobody
    snprintf(header->unused + used, sizeof header->unused - used, "%s%s", used ? ", " : "", name);
}

static bool is_one_of(const char *name, const char *const *list)
{
    for (; *list; list++)
        if (strcmp(name, *list) == 0) return true;
    return false;
}

static void judge_property(ply_header *header, const char *name)
{
    static const char *const of_vertex[] = { "x", "y", "z", "nx", "ny", "nz", NULL };
    static const char *const of_face[] = { "vertex_indices", "vertex_index", NULL };
    bool is_vertex = strcmp(header->element, "vertex") == 0;
    bool is_face =
        strcmp(header->element, "face") == 0 || strcmp(header->element, "tristrips") == 0;
    if (is_vertex || is_face) {
        if (!is_one_of(name, is_vertex ? of_vertex : of_face)) note_unused(header, name);
    } else if (*header->element) {
        note_unused(header, header->element);
        header->element[0] = '\0'; // once is enough
    }
}

static bool begin_element(ply_header *header, const char *line)
{
    char *name = header->element, count[24];
    if (!end_element(header) || sscanf(line, "element %63s %23s", name, count) != 2) return false;
    if (!isdigit((unsigned char)*count)) return false;
    return sscanf(count, "%" SCNu64, &header->count) == 1 && header->count < UINT32_MAX;
}

/// A list may be empty: its count is all that is certain. In text a value takes a digit and a separator.
static bool read_property(ply_header *header, const char *line)
{
    char type[16], item[16], name[64];
    unsigned size;
    if (sscanf(line, "property list %15s %15s %63s", type, item, name) == 3) {
        size = size_of_type(item) ? size_of_type(type) : 0;
    } else {
        if (sscanf(line, "property %15s %63s", type, name) != 2) return false;
        size = size_of_type(type);
    }
    judge_property(header, name);
    header->row_bytes += header->is_ascii ? 2 : size;
    return header->has_format && size > 0;
}

static bool starts_with(const char *line, const char *word)
{
    return strncmp(line, word, strlen(word)) == 0;
}

static bool read_line(ply_header *header, const char *line)
{
    if (starts_with(line, "comment") || starts_with(line, "obj_info")) return true;
    if (starts_with(line, "format ")) return read_format(header, line);
    if (starts_with(line, "element ")) return header->has_format && begin_element(header, line);
    return starts_with(line, "property ") && read_property(header, line);
}

/// Cuts the line break off; false if the line is too long, or not text.
static bool trim_line(char *line)
{
    size_t length = strlen(line);
    if (!length || line[length - 1] != '\n') return false;
    while (length && (line[length - 1] == '\n' || line[length - 1] == '\r'))
        line[--length] = 0;
    for (size_t i = 0; i < length; i++)
        if (iscntrl((unsigned char)line[i]) && line[i] != '\t') return false;
    return true;
}

static rsv_status check_size(ply_header *header, FILE *file)
{
    struct stat info;
    long begin = ftell(file);
    if (begin < 0 || fstat(fileno(file), &info) != 0)
        return rsv_fail(RSV_ERROR_IO, "%s", strerror(errno));
    uint64_t left = (uint64_t)(info.st_size > begin ? info.st_size - begin : 0);
    // the last line of a text may lack its break
    if (!end_element(header) || header->needed > left + header->is_ascii)
        return rsv_fail(RSV_ERROR_FORMAT,
            "its header announces at least %" PRIu64 " bytes of elements, but only %" PRIu64
            " follow: the file is cut off or its counts are wrong",
            header->needed, left);
    return RSV_OK;
}

/// @param header all zero
static rsv_status check_header(FILE *file, ply_header *header)
{
    char line[LINE_BYTES];
    for (unsigned number = 1; number <= MAX_LINES; number++) {
        if (!fgets(line, sizeof line, file))
            return rsv_fail(RSV_ERROR_FORMAT, "its header has no end_header");
        if (!trim_line(line))
            return rsv_fail(RSV_ERROR_FORMAT, "line %u of its header is not text", number);
        if (strcmp(line, "end_header") == 0) return check_size(header, file);
        bool understood = number == 1 ? strcmp(line, "ply") == 0 : read_line(header, line);
        if (!understood)
            return rsv_fail(
                RSV_ERROR_FORMAT, "line %u of its header is malformed: %.60s", number, line);
    }
    return rsv_fail(RSV_ERROR_FORMAT, "its header is longer than %d lines", MAX_LINES);
}

rsv_status rsv_ply_check(const rsv_context *context, const char *path)
{
    ply_header header = { .is_ascii = false };
    FILE *file = fopen(path, "rb");
    if (!file) return rsv_fail(RSV_ERROR_IO, "%s", strerror(errno));
    rsv_status status = check_header(file, &header);
    fclose(file);
    if (status == RSV_OK && *header.unused)
        rsv_log(context, RSV_LOG_WARNING, "%s: properties and elements that are not used: %s", path,
            header.unused);
    return status;
}
