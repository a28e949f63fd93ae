/// Stanford polygon files. Our own reader, because importers stumble over blank lines, elements between vertices and
/// faces and empty lists, take files that are cut off for whole, and read one triangle of a strip.
#include "../core/number_text.h"
#include "../core/vec.h"
#include "bare_mesh.h"
#include "ear_clipping.h"
#include "file_source.h"
#include "ply_header.h"
#include "scene_read.h"

#include <ctype.h>
#include <inttypes.h>
#include <string.h>

#define MOST_CORNERS 1000000 ///< of a polygon or strip

typedef struct ply_reader {
    rsv_context *context;
    rsv_ply_header header;
    char *bytes; ///< [size + 1]
    size_t size;
    const char *at, *end;
    size_t line;        ///< of text
    rsv_vec3 *position; ///< [vertex_count] less `origin`
    double origin[3];
    rsv_vec3 *normal; ///< [vertex_count]; NULL = none
    size_t vertex_count;
    int64_t *corner; ///< [corner_count] of the polygon in hand
    size_t corner_count, corner_capacity;
    uint32_t *index; ///< [3 * triangle_count]
    size_t index_count, index_capacity;
    size_t flat; ///< polygons of fewer than three corners
} ply_reader;

/// Fails with the place in the file where reading stopped.
static rsv_status fail_at(const ply_reader *r, const char *problem)
{
    if (r->header.format == RSV_PLY_ASCII)
        return rsv_fail(RSV_ERROR_FORMAT, "line %zu: %s", r->line, problem);
    return rsv_fail(RSV_ERROR_FORMAT, "byte %zu: %s", (size_t)(r->at - r->bytes), problem);
}

// ---- numbers ----------------------------------------------------------------------------------------

static rsv_status read_text_number(ply_reader *r, double *value)
{
    char *after = NULL;
    for (; r->at < r->end && isspace((unsigned char)*r->at); r->at++)
        r->line += *r->at == '\n' || (*r->at == '\r' && r->at[1] != '\n');
    if (r->at == r->end) return fail_at(r, "the file is cut off: more numbers are announced");
    *value = rsv_number_value(r->at, &after);
    if (after == r->at || (*after && !isspace((unsigned char)*after)))
        return fail_at(r, "a number with a decimal point is expected");
    r->at = after;
    return RSV_OK;
}

static double decode(const uint8_t *b, rsv_ply_type type, bool big)
{
    union {
        uint64_t bits;
        double value;
    } twice = { .bits = 0 };
    union {
        uint32_t bits;
        float value;
    } single = { .bits = 0 };
    unsigned size = rsv_ply_size(type);
    for (unsigned k = 0; k < size; k++)
        twice.bits |= (uint64_t)b[big ? size - 1 - k : k] << 8 * k;
    single.bits = (uint32_t)twice.bits;
    switch (type) {
    case RSV_PLY_INT8:
        return (int8_t)single.bits;
    case RSV_PLY_INT16:
        return (int16_t)single.bits;
    case RSV_PLY_INT32:
        return (int32_t)single.bits;
    case RSV_PLY_FLOAT:
        return (double)single.value;
    case RSV_PLY_DOUBLE:
        return twice.value;
    default:
        return (double)single.bits;
    }
}

static rsv_status read_number(ply_reader *r, rsv_ply_type type, double *value)
{
    if (r->header.format == RSV_PLY_ASCII) return read_text_number(r, value);
    if ((size_t)(r->end - r->at) < rsv_ply_size(type)) return fail_at(r, "the file is cut off");
    *value = decode((const uint8_t *)r->at, type, r->header.format == RSV_PLY_BIG);
    r->at += rsv_ply_size(type);
    return RSV_OK;
}

/// A whole number within bounds.
static rsv_status read_whole_number(
    ply_reader *r, rsv_ply_type type, double most, const char *what, int64_t *value)
{
    double number = 0;
    rsv_status status = read_number(r, type, &number);
    if (status != RSV_OK) return status;
    if (!(number >= -1 && number <= most && number == floor(number))) return fail_at(r, what);
    *value = (int64_t)number;
    return RSV_OK;
}

// ---- elements ---------------------------------------------------------------------------------------

/// One value of an element that is no list, or a list's values; corners are kept. @param v out, by role
static rsv_status read_property(ply_reader *r, const rsv_ply_property *p, double v[6])
{
    rsv_status status = RSV_OK;
    int64_t count = 1, corner = 0;
    double value;
    if (p->count_type)
        RSV_TRY(
            read_whole_number(r, p->count_type, 1e9, "the length of a list is invalid", &count));
    if (count < 0) RSV_TRY(fail_at(r, "the length of a list is invalid"));
    if (p->role == RSV_PLY_INDICES) {
        if (count > MOST_CORNERS) RSV_TRY(fail_at(r, "a polygon has more than a million corners"));
        RSV_TRY(rsv_grow(r->context, (void **)&r->corner, &r->corner_capacity, (size_t)count + 1,
            sizeof *r->corner));
        r->corner_count = (size_t)count;
    }
    for (int64_t k = 0; k < count; k++) {
        if (p->role != RSV_PLY_INDICES) {
            RSV_TRY(read_number(r, p->type, &value));
            if (p->role < RSV_PLY_UNUSED) v[p->role] = value;
            continue;
        }
        RSV_TRY(read_whole_number(
            r, p->type, UINT32_MAX, "a corner is not a valid vertex number", &corner));
        r->corner[k] = corner;
    }
cleanup:
    return status;
}

static rsv_status read_row(ply_reader *r, const rsv_ply_element *e, double v[6])
{
    rsv_status status = RSV_OK;
    r->corner_count = 0;
    for (uint32_t k = 0; k < e->property_count && status == RSV_OK; k++)
        status = read_property(r, &r->header.property[e->first_property + k], v);
    return status;
}

static unsigned roles_of(const rsv_ply_header *header, const rsv_ply_element *e)
{
    unsigned roles = 0;
    for (uint32_t k = 0; k < e->property_count; k++)
        roles |= 1u << header->property[e->first_property + k].role;
    return roles;
}

static rsv_status read_vertices(ply_reader *r, const rsv_ply_element *e)
{
    rsv_status status = RSV_ERROR_MEMORY;
    unsigned roles = roles_of(&r->header, e);
    if ((roles & 7) != 7)
        return rsv_fail(RSV_ERROR_FORMAT, "its vertices lack one of the properties x, y and z");
    size_t count = r->vertex_count = (size_t)e->count;
    rsv_place *place = rsv_alloc(r->context, count, sizeof *place);
    r->position = rsv_alloc(r->context, count, sizeof *r->position);
    bool has_normals = (roles >> 3 & 7) == 7;
    if (has_normals) r->normal = rsv_alloc(r->context, count, sizeof *r->normal);
    if (!place || !r->position || (has_normals && !r->normal)) goto cleanup;
    for (size_t n = 0; n < count; n++) {
        double v[6] = { 0 };
        RSV_TRY(read_row(r, e, v));
        if (!isfinite((float)v[0]) || !isfinite((float)v[1]) || !isfinite((float)v[2]))
            RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "the position of vertex %zu is not finite", n));
        place[n] = (rsv_place){ { v[0], v[1], v[2] } };
        if (r->normal) r->normal[n] = v3((float)v[3], (float)v[4], (float)v[5]);
    }
    rsv_bring_near(place, count, r->origin, r->position);
    status = RSV_OK;
cleanup:
    rsv_free(r->context, place);
    return status;
}

/// Corners as they are: vertices may follow the faces. @param a, b, c corners of the polygon or strip in hand
static rsv_status add_triangle(ply_reader *r, size_t a, size_t b, size_t c)
{
    rsv_status status = rsv_grow(
        r->context, (void **)&r->index, &r->index_capacity, r->index_count + 3, sizeof *r->index);
    if (status != RSV_OK) return status;
    const size_t chosen[3] = { a, b, c };
    for (int k = 0; k < 3; k++)
        r->index[r->index_count++] = (uint32_t)r->corner[chosen[k]];
    return RSV_OK;
}

static rsv_status add_strip(ply_reader *r)
{
    rsv_status status = RSV_OK;
    size_t begin = 0;
    for (size_t k = 0; k < r->corner_count && status == RSV_OK; k++) {
        if (r->corner[k] < 0) begin = k + 1; // -1 ends a strip
        if (r->corner[k] < 0 || k < begin + 2) continue;
        bool odd = (k - begin) % 2;
        status = add_triangle(r, odd ? k - 1 : k - 2, odd ? k - 2 : k - 1, k);
    }
    return status;
}

/// Polygons are cut into triangles where their vertices are known, else like fans.
static rsv_status add_polygon(ply_reader *r)
{
    rsv_status status = RSV_OK;
    size_t count = r->corner_count;
    uint32_t *cut = NULL;
    bool known = r->position != NULL;
    if (count < 3) {
        r->flat++;
        return RSV_OK;
    }
    for (size_t k = 0; k < count; k++) {
        if (r->corner[k] < 0) return fail_at(r, "a corner is not a valid vertex number");
        known = known && (size_t)r->corner[k] < r->vertex_count;
    }
    if (count == 3) return add_triangle(r, 0, 1, 2);
    cut = rsv_alloc(r->context, count - 2, 3 * sizeof *cut);
    if (!cut) return RSV_ERROR_MEMORY;
    if (known) RSV_TRY(rsv_clip_ears(r->context, r->position, r->corner, count, cut));
    for (size_t t = 0; t < count - 2; t++)
        RSV_TRY(known ? add_triangle(r, cut[3 * t], cut[3 * t + 1], cut[3 * t + 2])
                      : add_triangle(r, 0, t + 1, t + 2));
cleanup:
    rsv_free(r->context, cut);
    return status;
}

static rsv_status read_element(ply_reader *r, const rsv_ply_element *e)
{
    rsv_status status = RSV_OK;
    if (e->kind == RSV_PLY_VERTEX) return read_vertices(r, e);
    for (uint64_t n = 0; n < e->count && e->property_count; n++) {
        double v[6];
        RSV_TRY(read_row(r, e, v));
        if (e->kind == RSV_PLY_FACE) RSV_TRY(add_polygon(r));
        if (e->kind == RSV_PLY_STRIPS) RSV_TRY(add_strip(r));
    }
cleanup:
    return status;
}

// ---- the whole file ---------------------------------------------------------------------------------

static rsv_status check_indices(const ply_reader *r)
{
    for (size_t k = 0; k < r->index_count; k++)
        if (r->index[k] >= r->vertex_count)
            return rsv_fail(RSV_ERROR_FORMAT,
                "a face refers to vertex %u (index out of range): there are only %zu", r->index[k],
                r->vertex_count);
    return r->index_count ? RSV_OK : rsv_fail(RSV_ERROR_FORMAT, "it holds no triangle or polygon");
}

/// Text has as many digits as it likes.
static bool has_single_places(const rsv_ply_header *header)
{
    for (uint32_t k = 0; k < header->element_count; k++) {
        const rsv_ply_element *e = &header->element[k];
        if (e->kind != RSV_PLY_VERTEX || header->format == RSV_PLY_ASCII) continue;
        for (uint32_t p = e->first_property; p < e->first_property + e->property_count; p++)
            if (header->property[p].role < 3 && header->property[p].type == RSV_PLY_FLOAT)
                return true;
    }
    return false;
}

static void warn_of_losses(const ply_reader *r, const char *path)
{
    size_t rest = (size_t)(r->end - r->at);
    for (; rest && r->header.format == RSV_PLY_ASCII &&
           isspace((unsigned char)r->end[-(ptrdiff_t)rest]);)
        rest--;
    if (*r->header.unused)
        rsv_log(r->context, RSV_LOG_WARNING,
            "%s: properties, elements and comments that are not used: %s", path, r->header.unused);
    if (r->flat)
        rsv_log(r->context, RSV_LOG_WARNING, "%s: not used: %zu faces of fewer than three corners",
            path, r->flat);
    if (rest)
        rsv_log(r->context, RSV_LOG_WARNING, "%s: %zu bytes after its last element are not used",
            path, rest);
}

rsv_status rsv_ply_read(const char *path, const rsv_load_desc *desc, rsv_scene *scene)
{
    rsv_status status;
    uint32_t material;
    ply_reader *r = rsv_alloc(rsv_scene_get_context(scene), 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    r->context = rsv_scene_get_context(scene);
    RSV_TRY(rsv_file_read(r->context, desc->files, path, &r->bytes, &r->size));
    RSV_TRY(rsv_ply_read_header(r->bytes, r->size, &r->header));
    r->at = r->bytes + r->header.bytes;
    r->end = r->bytes + r->size;
    r->line = r->header.lines + 1;
    for (uint32_t k = 0; k < r->header.element_count; k++)
        RSV_TRY(read_element(r, &r->header.element[k]));
    RSV_TRY(check_indices(r));
    warn_of_losses(r, path);
    RSV_TRY(rsv_add_bare_material(scene, &material));
    RSV_TRY(rsv_add_bare_mesh(scene, desc, r->origin, has_single_places(&r->header),
        (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
            .name = "unnamed",
            .positions = r->position,
            .normals = r->normal,
            .vertex_count = r->vertex_count,
            .indices = r->index,
            .triangle_count = r->index_count / 3,
            .material = material }));
cleanup:
    rsv_free(r->context, r->bytes);
    rsv_free(r->context, r->position);
    rsv_free(r->context, r->normal);
    rsv_free(r->context, r->corner);
    rsv_free(r->context, r->index);
    rsv_free(rsv_scene_get_context(scene), r);
    return status;
}
