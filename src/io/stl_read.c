/// STL, text and binary. Written here because files vary more than importers accept: capitals, several solids,
/// polygons, bytes after the last triangle, binary files that begin with "solid", counts that were never filled in.
#include "../core/core.h"
#include "../core/number_text.h"
#include "../core/vec.h"
#include "bare_mesh.h"
#include "file_source.h"
#include "little_endian.h"
#include "scene_read.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define NAME_BYTES 128
#define WORD_BYTES 40

/// A binary file: a head of any content, a number of triangles, and these.
enum { HEAD_BYTES = 80, TABLE_START = 84, RECORD_BYTES = 50, NORMAL_BYTES = 12 };

typedef struct stl_reader {
    rsv_context *context;
    rsv_scene *scene;
    const rsv_load_desc *desc;
    const char *path;
    char *bytes; ///< [size + 1], a zero behind it
    size_t size;
    uint32_t material;
    char name[NAME_BYTES]; ///< of the solid in hand
    rsv_place *corner;     ///< [corner_count] three for each of its triangles
    size_t corner_count, corner_capacity;
    size_t triangle_count;    ///< of all solids so far
    bool in_single;           ///< binary: numbers are floats
    char unknown[WORD_BYTES]; ///< first of the words that begin a line and say nothing here
    size_t unknown_line;      ///< 0 = there is none
} stl_reader;

// ---- solids -----------------------------------------------------------------------------------------

static rsv_status add_corner(stl_reader *r, rsv_place p)
{
    rsv_status status = rsv_grow(r->context, (void **)&r->corner, &r->corner_capacity,
        r->corner_count + 1, sizeof *r->corner);
    if (status == RSV_OK) r->corner[r->corner_count++] = p;
    return status;
}

/// The mesh of the corners in hand.
static rsv_status end_solid(stl_reader *r)
{
    rsv_status status = RSV_OK;
    uint32_t *index = NULL;
    rsv_vec3 *position = NULL;
    double origin[3];
    size_t count = r->corner_count;
    if (count == 0) return RSV_OK;
    if (count > UINT32_MAX)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "solid '%s': more than 1.4e9 triangles", r->name);
    index = rsv_alloc(r->context, count, sizeof *index);
    position = rsv_alloc(r->context, count, sizeof *position);
    if (!index || !position) RSV_TRY(RSV_ERROR_MEMORY);
    rsv_bring_near(r->corner, count, origin, position);
    for (size_t i = 0; i < count; i++)
        index[i] = (uint32_t)i;
    RSV_TRY(rsv_add_bare_mesh(r->scene, r->desc, origin, r->in_single,
        (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
            .name = *r->name ? r->name : "unnamed",
            .positions = position,
            .vertex_count = count,
            .indices = index,
            .triangle_count = count / 3,
            .material = r->material }));
    r->triangle_count += count / 3;
    r->corner_count = 0;
cleanup:
    rsv_free(r->context, index);
    rsv_free(r->context, position);
    return status;
}

// ---- binary files -----------------------------------------------------------------------------------

static float float_at(const char *b)
{
    uint32_t bits = rsv_read_u32(b);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/// Number of triangles: the count in the file, unless a program that streamed the file left it open.
static rsv_status count_records(const stl_reader *r, size_t *count)
{
    if (r->size < TABLE_START)
        return rsv_fail(RSV_ERROR_FORMAT,
            "cannot be read: %zu bytes are not an STL file: neither text that begins with 'solid' nor "
            "a binary head of 84 bytes",
            r->size);
    size_t held = (r->size - TABLE_START) / RECORD_BYTES;
    uint32_t said = rsv_read_u32(r->bytes + HEAD_BYTES);
    *count = said;
    if ((said == 0 || said == UINT32_MAX) && held > 0) *count = held;
    if (*count > held)
        return rsv_fail(RSV_ERROR_FORMAT,
            "cannot be read: it announces %zu triangles, but holds %zu: the file is cut off, or not an STL file",
            *count, held);
    size_t rest = r->size - TABLE_START - *count * RECORD_BYTES;
    if (rest)
        rsv_log(r->context, RSV_LOG_WARNING, "%s: %zu bytes after its last triangle are not used",
            r->path, rest);
    return RSV_OK;
}

static rsv_status read_binary(stl_reader *r)
{
    rsv_status status;
    size_t count = 0, colored = 0;
    RSV_TRY(count_records(r, &count));
    for (size_t t = 0; t < count; t++) {
        const char *record = r->bytes + TABLE_START + t * RECORD_BYTES;
        for (int k = 0; k < 3; k++) {
            const char *at = record + NORMAL_BYTES + 12 * k;
            const rsv_place p = { { (double)float_at(at), (double)float_at(at + 4),
                (double)float_at(at + 8) } };
            if (!isfinite(p.at[0] + p.at[1] + p.at[2]))
                RSV_TRY(rsv_fail(RSV_ERROR_FORMAT,
                    "triangle %zu: a corner is not finite; is the file damaged?", t));
            RSV_TRY(add_corner(r, p));
        }
        colored += record[RECORD_BYTES - 2] || record[RECORD_BYTES - 1];
    }
    if (memmem(r->bytes, TABLE_START, "COLOR=", 6))
        rsv_log(r->context, RSV_LOG_WARNING, "%s: the colour in its header is not used", r->path);
    if (colored)
        rsv_log(r->context, RSV_LOG_WARNING,
            "%s: the attributes (colours) of %zu of its triangles are not used", r->path, colored);
    RSV_TRY(end_solid(r));
cleanup:
    return status;
}

// ---- text -------------------------------------------------------------------------------------------

/// Behind a byte order mark and blanks.
static const char *text_start(const stl_reader *r)
{
    const char *at = r->bytes;
    if (strncmp(at, "\xef\xbb\xbf", 3) == 0) at += 3;
    return at + strspn(at, " \t\r\n");
}

/// Many binary files begin with "solid", too; their counts and numbers have zeros.
static bool is_text(const stl_reader *r)
{
    size_t looked_at = r->size < 512 ? r->size : 512;
    return strncasecmp(text_start(r), "solid", 5) == 0 && !memchr(r->bytes, 0, looked_at);
}

/// Where text is read; its end is the zero behind the file, or one within.
typedef struct cursor {
    const char *at;
    size_t line;
} cursor;

static void skip_blanks(cursor *c)
{
    for (; isspace((unsigned char)*c->at); c->at++)
        c->line += *c->at == '\n';
}

/// The next word, in small letters and cut to fit; empty at the end.
static void next_word(cursor *c, char word[WORD_BYTES])
{
    size_t length = 0;
    skip_blanks(c);
    for (; *c->at && !isspace((unsigned char)*c->at); c->at++) {
        unsigned char letter = (unsigned char)*c->at;
        if (length < WORD_BYTES - 1) word[length++] = iscntrl(letter) ? '?' : (char)tolower(letter);
    }
    word[length] = '\0';
}

/// How much of a line is a name: all of it, unless a facet follows, or another solid with one.
static size_t length_of_name(const char *at)
{
    size_t length = strcspn(at, "\r\n"), name = length;
    for (size_t k = 0; k < length && at[k]; k++) {
        if (k > 0 && !isspace((unsigned char)at[k - 1])) continue;
        if (strncasecmp(at + k, "solid", 5) == 0 && isspace((unsigned char)at[k + 5]) &&
            name == length)
            name = k;
        if (strncasecmp(at + k, "facet", 5) == 0 && isspace((unsigned char)at[k + 5]))
            return name < k ? name : k;
    }
    return length;
}

/// Reads the rest of the line, or up to a facet in it, without blanks around it. @param name NULL = skip it
static void rest_of_line(cursor *c, char *name)
{
    size_t length = length_of_name(c->at), blanks = strspn(c->at, " \t");
    const char *start = c->at + (blanks < length ? blanks : length), *end = c->at + length;
    c->at = end;
    if (!name) return;
    while (end > start && isspace((unsigned char)end[-1]))
        end--;
    length = (size_t)(end - start) < NAME_BYTES - 1 ? (size_t)(end - start) : NAME_BYTES - 1;
    for (size_t i = 0; i < length; i++)
        name[i] = iscntrl((unsigned char)start[i]) ? '?' : start[i];
    name[length] = '\0';
}

static rsv_status read_numbers(cursor *c, const char *of, double number[3])
{
    for (int k = 0; k < 3; k++) {
        char *end = NULL;
        skip_blanks(c);
        number[k] = rsv_number_value(c->at, &end);
        bool whole = end != c->at && (!*end || isspace((unsigned char)*end));
        if (!*c->at)
            return rsv_fail(
                RSV_ERROR_FORMAT, "line %zu: the file is cut off within a '%s'", c->line, of);
        if (!whole || !isfinite((float)number[k])) {
            char word[WORD_BYTES];
            next_word(c, word);
            return rsv_fail(RSV_ERROR_FORMAT,
                "line %zu: '%s' needs three finite numbers with decimal points, not '%s'", c->line,
                of, word);
        }
        c->at = end;
    }
    return RSV_OK;
}

/// The corners of one loop, "outer loop" being read; more than three make a fan.
static rsv_status read_loop(stl_reader *r, cursor *c)
{
    rsv_status status = RSV_OK;
    char word[WORD_BYTES];
    rsv_place first = { { 0 } }, last = first;
    size_t count = 0;
    for (next_word(c, word); strcmp(word, "vertex") == 0; next_word(c, word)) {
        rsv_place p;
        RSV_TRY(read_numbers(c, "vertex", p.at));
        if (count >= 3) {
            RSV_TRY(add_corner(r, first));
            RSV_TRY(add_corner(r, last));
        }
        if (count++ == 0) first = p;
        last = p;
        RSV_TRY(add_corner(r, p));
    }
    if (strcmp(word, "endloop") != 0)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "line %zu: expected 'vertex' or 'endloop', not '%s'%s",
            c->line, *word ? word : "the end", *word ? "" : ": the file is cut off"));
    if (count < 3)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "line %zu: a loop of %zu corners; a triangle has three",
            c->line, count));
cleanup:
    return status;
}

/// Skips a line that is not of the format; it is reported once, at the end.
static void pass_over(stl_reader *r, cursor *c, const char *word)
{
    if (!r->unknown_line) {
        memcpy(r->unknown, word, sizeof r->unknown);
        r->unknown_line = c->line;
    }
    rest_of_line(c, NULL);
}

/// A facet's normal says nothing that its corners do not, and in many files is no number.
static void pass_numbers(cursor *c)
{
    for (int k = 0; k < 3; k++) {
        char *end = NULL;
        skip_blanks(c);
        rsv_number_value(c->at, &end);
        if (end == c->at) return;
        c->at = end;
    }
}

/// One statement. @param inside whether a solid has begun and not ended
static rsv_status read_statement(stl_reader *r, cursor *c, const char *word, bool *inside)
{
    char loop[WORD_BYTES];
    if (strcmp(word, "solid") == 0) {
        rsv_status status = end_solid(r);
        rest_of_line(c, r->name);
        *inside = true;
        return status;
    }
    if (strcmp(word, "endsolid") == 0) {
        rest_of_line(c, NULL);
        *inside = false;
        return end_solid(r);
    }
    if (strcmp(word, "normal") == 0) {
        pass_numbers(c);
        return RSV_OK;
    }
    if (strcmp(word, "outer") == 0 || strcmp(word, "inner") == 0) {
        next_word(c, loop);
        if (strcmp(loop, "loop") == 0) return read_loop(r, c);
        return rsv_fail(RSV_ERROR_FORMAT, "line %zu: expected 'loop' after '%s'", c->line, word);
    }
    if (strcmp(word, "facet") != 0 && strcmp(word, "endfacet") != 0) pass_over(r, c, word);
    return RSV_OK;
}

static rsv_status read_text(stl_reader *r)
{
    rsv_status status = RSV_OK;
    cursor c = { text_start(r), 1 };
    bool inside = false;
    char word[WORD_BYTES];
    for (next_word(&c, word); *word; next_word(&c, word))
        RSV_TRY(read_statement(r, &c, word, &inside));
    if (c.at < r->bytes + r->size)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "line %zu: a zero byte; text has none", c.line));
    RSV_TRY(end_solid(r));
    if (inside)
        rsv_log(r->context, RSV_LOG_WARNING, "%s: it ends without 'endsolid'; is the file cut off?",
            r->path);
    if (r->unknown_line)
        rsv_log(r->context, RSV_LOG_WARNING,
            "%s: '%s' in line %zu is not an STL keyword; this line and any others like it are ignored",
            r->path, r->unknown, r->unknown_line);
cleanup:
    return status;
}

// ---- the whole file ---------------------------------------------------------------------------------

rsv_status rsv_stl_read(const char *path, const rsv_load_desc *desc, rsv_scene *scene)
{
    rsv_status status;
    stl_reader r = {
        .context = rsv_scene_get_context(scene), .scene = scene, .desc = desc, .path = path
    };
    RSV_TRY(rsv_file_read(r.context, desc->files, path, &r.bytes, &r.size));
    if (r.size == 0) RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "cannot be read: the file is empty"));
    RSV_TRY(rsv_add_bare_material(scene, &r.material));
    r.in_single = !is_text(&r);
    RSV_TRY(r.in_single ? read_binary(&r) : read_text(&r));
    if (r.triangle_count == 0) RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "it holds no triangle"));
cleanup:
    rsv_free(r.context, r.bytes);
    rsv_free(r.context, r.corner);
    return status;
}
