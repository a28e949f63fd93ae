#include "ply_header.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define MAX_LINES 4096
#define LINE_BYTES 1024

unsigned rsv_ply_size(rsv_ply_type type)
{
    static const unsigned size[] = { [RSV_PLY_NONE] = 0,
        [RSV_PLY_INT8] = 1,
        [RSV_PLY_UINT8] = 1,
        [RSV_PLY_INT16] = 2,
        [RSV_PLY_UINT16] = 2,
        [RSV_PLY_INT32] = 4,
        [RSV_PLY_UINT32] = 4,
        [RSV_PLY_FLOAT] = 4,
        [RSV_PLY_DOUBLE] = 8 };
    return size[type];
}

static rsv_ply_type type_of(const char *name)
{
    static const struct {
        const char *name;
        rsv_ply_type type;
    } known[] = { { "char", RSV_PLY_INT8 }, { "uchar", RSV_PLY_UINT8 }, { "short", RSV_PLY_INT16 },
        { "ushort", RSV_PLY_UINT16 }, { "int", RSV_PLY_INT32 }, { "uint", RSV_PLY_UINT32 },
        { "float", RSV_PLY_FLOAT }, { "double", RSV_PLY_DOUBLE }, { "int8", RSV_PLY_INT8 },
        { "uint8", RSV_PLY_UINT8 }, { "int16", RSV_PLY_INT16 }, { "uint16", RSV_PLY_UINT16 },
        { "int32", RSV_PLY_INT32 }, { "uint32", RSV_PLY_UINT32 }, { "float32", RSV_PLY_FLOAT },
        { "float64", RSV_PLY_DOUBLE } };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(name, known[i].name) == 0) return known[i].type;
    return RSV_PLY_NONE;
}

static bool read_format(rsv_ply_header *header, const char *line, bool *has_format)
{
    static const char *const names[] = { [RSV_PLY_ASCII] = "ascii",
        [RSV_PLY_LITTLE] = "binary_little_endian",
        [RSV_PLY_BIG] = "binary_big_endian" };
    char format[32], version[16];
    if (*has_format || sscanf(line, "format %31s %15s", format, version) != 2) return false;
    for (int k = 0; k < 3; k++)
        if (strcmp(format, names[k]) == 0) {
            header->format = (rsv_ply_format)k;
            *has_format = true;
        }
    return *has_format;
}

static void note_unused(rsv_ply_header *header, const char *name)
{
    size_t used = strlen(header->unused);
    if (used + strlen(name) + 8 > sizeof header->unused) return; // keep the list short
    snprintf(header->unused + used, sizeof header->unused - used, "%s%s", used ? ", " : "", name);
}

static bool begin_element(rsv_ply_header *header, const char *line)
{
    char name[64], count[24];
    if (header->element_count == RSV_PLY_ELEMENTS) return false;
    if (sscanf(line, "element %63s %23s", name, count) != 2) return false;
    rsv_ply_element *e = &header->element[header->element_count];
    *e = (rsv_ply_element){ .first_property = header->property_count };
    if (!isdigit((unsigned char)*count) || sscanf(count, "%" SCNu64, &e->count) != 1 ||
        e->count >= UINT32_MAX)
        return false;
    if (strcmp(name, "vertex") == 0) e->kind = RSV_PLY_VERTEX;
    if (strcmp(name, "face") == 0) e->kind = RSV_PLY_FACE;
    if (strcmp(name, "tristrips") == 0) e->kind = RSV_PLY_STRIPS;
    for (uint32_t k = 0; k < header->element_count; k++)
        if (e->kind == RSV_PLY_VERTEX && header->element[k].kind == RSV_PLY_VERTEX) return false;
    if (e->kind == RSV_PLY_OTHER && e->count) note_unused(header, name);
    header->element_count++;
    return true;
}

static uint8_t role_of(const rsv_ply_element *e, const char *name, bool is_list)
{
    static const char *const of_vertex[] = { "x", "y", "z", "nx", "ny", "nz" };
    for (uint8_t k = 0; k < 6 && e->kind == RSV_PLY_VERTEX && !is_list; k++)
        if (strcmp(name, of_vertex[k]) == 0) return k;
    bool has_corners = e->kind == RSV_PLY_FACE || e->kind == RSV_PLY_STRIPS;
    if (has_corners && is_list &&
        (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0))
        return RSV_PLY_INDICES;
    return RSV_PLY_UNUSED;
}

/// Adds a property to the element that the header described last. A list may be empty: only its count adds to the least
/// size of a record. In text, a value takes at least a digit and a separator.
static bool read_property(rsv_ply_header *header, const char *line)
{
    char type[16], item[16], name[64];
    if (header->element_count == 0 || header->property_count == RSV_PLY_PROPERTIES) return false;
    rsv_ply_element *e = &header->element[header->element_count - 1];
    rsv_ply_property *p = &header->property[header->property_count];
    bool is_list = sscanf(line, "property list %15s %15s %63s", type, item, name) == 3;
    if (!is_list && sscanf(line, "property %15s %63s", type, name) != 2) return false;
    *p = (rsv_ply_property){ .type = type_of(is_list ? item : type),
        .count_type = is_list ? type_of(type) : RSV_PLY_NONE,
        .role = role_of(e, name, is_list) };
    if (!p->type || (is_list && (!p->count_type || p->count_type >= RSV_PLY_FLOAT))) return false;
    if (p->role == RSV_PLY_INDICES && p->type >= RSV_PLY_FLOAT) return false;
    if (p->role == RSV_PLY_UNUSED && e->kind != RSV_PLY_OTHER && e->count)
        note_unused(header, name);
    e->row_bytes +=
        header->format == RSV_PLY_ASCII ? 2 : rsv_ply_size(is_list ? p->count_type : p->type);
    e->property_count++;
    header->property_count++;
    return true;
}

static bool starts_with(const char *line, const char *word)
{
    return strncmp(line, word, strlen(word)) == 0;
}

/// Programs for scans name pictures in comments.
static void note_remark(rsv_ply_header *header, const char *line)
{
    if (strncasecmp(line, "comment texture", strlen("comment texture")) == 0)
        note_unused(header, line + strlen("comment "));
}

static bool read_line(rsv_ply_header *header, const char *line, bool *has_format)
{
    if (starts_with(line, "comment") || starts_with(line, "obj_info") || !*line) {
        note_remark(header, line);
        return true;
    }
    if (starts_with(line, "format ")) return read_format(header, line, has_format);
    if (starts_with(line, "element ")) return *has_format && begin_element(header, line);
    return starts_with(line, "property ") && *has_format && read_property(header, line);
}

/// The next line, tabs as blanks and none at its ends; lines end in LF, CR LF or CR.
/// @return where the one after it begins; NULL if it is too long, or not text
static const char *next_line(const char *at, const char *end, char line[LINE_BYTES])
{
    size_t length = 0;
    for (; at < end && *at != '\n' && *at != '\r'; at++) {
        char c = *at == '\t' ? ' ' : *at;
        if (length == LINE_BYTES - 1 || iscntrl((unsigned char)c)) return NULL;
        if (c != ' ' || length) line[length++] = c;
    }
    if (at == end) return NULL;
    while (length && line[length - 1] == ' ')
        length--;
    line[length] = '\0';
    return at + (*at == '\r' && at + 1 < end && at[1] == '\n' ? 2 : 1);
}

static rsv_status check_size(const rsv_ply_header *header, size_t size)
{
    uint64_t needed = 0, left = size - header->bytes;
    bool fits = true;
    for (uint32_t k = 0; k < header->element_count && fits; k++) {
        const rsv_ply_element *e = &header->element[k];
        fits = !e->row_bytes || e->count <= (UINT64_MAX - needed) / e->row_bytes;
        if (fits) needed += e->count * e->row_bytes;
    }
    // the last line of a text may lack its break
    if (fits && needed <= left + (header->format == RSV_PLY_ASCII)) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT,
        "its header announces at least %" PRIu64 " bytes of elements, but only %" PRIu64
        " follow: the file is cut off or its counts are wrong",
        needed, left);
}

rsv_status rsv_ply_read_header(const char *bytes, size_t size, rsv_ply_header *header)
{
    char line[LINE_BYTES];
    const char *at = bytes, *end = bytes + size;
    bool has_format = false;
    if (size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) at += 3; // byte order mark
    *header = (rsv_ply_header){ .format = RSV_PLY_ASCII };
    while (header->lines < MAX_LINES) {
        size_t number = ++header->lines;
        if (at == end) return rsv_fail(RSV_ERROR_FORMAT, "its header has no end_header");
        at = next_line(at, end, line);
        if (!at) return rsv_fail(RSV_ERROR_FORMAT, "line %zu of its header is not text", number);
        header->bytes = (size_t)(at - bytes);
        if (has_format && strcmp(line, "end_header") == 0) return check_size(header, size);
        bool understood =
            number == 1 ? strcasecmp(line, "ply") == 0 : read_line(header, line, &has_format);
        if (!understood)
            return rsv_fail(
                RSV_ERROR_FORMAT, "line %zu of its header is malformed: %.60s", number, line);
    }
    return rsv_fail(RSV_ERROR_FORMAT, "its header is longer than %d lines", MAX_LINES);
}
