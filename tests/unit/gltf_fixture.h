/// Small glTF files, written by the tests of their reader.
#ifndef RSV_TEST_GLTF_FIXTURE_H
#define RSV_TEST_GLTF_FIXTURE_H

#include "file_fixture.h"

#include "resolvent/io.h"

static inline rsv_scene *load(fixture *f, const char *path)
{
    rsv_scene *scene = NULL;
    if (rsv_scene_load(f->context, path, &scene) != RSV_OK) fail_msg("%s", rsv_last_error());
    return scene;
}

static inline void assert_refused(
    fixture *f, const char *path, rsv_status expected, const char *mentioned)
{
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_scene_load(f->context, path, &scene), expected);
    assert_null(scene);
    assert_mentions(rsv_last_error(), path);
    assert_mentions(rsv_last_error(), mentioned);
    assert_null(strchr(rsv_last_error(), '\n'));
}

/// Contents of a file's binary part.
typedef struct buffer {
    uint8_t data[4096];
    size_t bytes;
} buffer;

static inline size_t append_bytes(buffer *b, const void *data, size_t bytes)
{
    size_t offset = b->bytes;
    assert_true(offset + bytes <= sizeof b->data);
    memcpy(b->data + offset, data, bytes);
    b->bytes += bytes;
    return offset;
}

/// The four corners of the unit square as floats, then the test's own data.
static inline buffer square_buffer(void)
{
    const float corner[12] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    buffer b = { .bytes = 0 };
    append_bytes(&b, corner, sizeof corner);
    return b;
}

/// Writes shape.gltf and shape.bin: `rest` holds everything but asset and buffers.
static inline const char *write_gltf(const folder *place, const buffer *b, const char *rest)
{
    static char text[65536];
    write_bytes(path_in(place, "shape.bin"), b->data, b->bytes);
    int length = snprintf(text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"shape.bin\",\"byteLength\":%zu}],"
        "%s}",
        b->bytes, rest);
    assert_in_range(length, 1, sizeof text - 1);
    const char *path = path_in(place, "shape.gltf");
    write_bytes(path, text, (size_t)length);
    return path;
}

/// A file that is put together accessor by accessor, each in a buffer view of its own.
typedef struct sketch {
    buffer bytes;
    char views[4096], accessors[8192];
    int count;
} sketch;

static inline void append_text(char *text, size_t capacity, const char *more)
{
    size_t used = strlen(text);
    assert_true(used + strlen(more) < capacity);
    snprintf(text + used, capacity - used, "%s", more);
}

/// @param component 5120 signed bytes, 5121 bytes, 5122, 5123 shorts, 5126 floats @param more further members, or ""
/// @return its index
static inline int add_accessor(sketch *s, const void *data, size_t bytes, int component,
    size_t count, const char *type, const char *more)
{
    char line[512];
    while (s->bytes.bytes % 4)
        s->bytes.bytes++;
    size_t offset = append_bytes(&s->bytes, data, bytes);
    snprintf(line, sizeof line, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}",
        s->count ? "," : "", offset, bytes);
    append_text(s->views, sizeof s->views, line);
    snprintf(line, sizeof line,
        "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"%s}",
        s->count ? "," : "", s->count, component, count, type, more);
    append_text(s->accessors, sizeof s->accessors, line);
    return s->count++;
}

/// `count` vectors of `width` floats.
static inline int add_vectors(sketch *s, const float *value, size_t count, int width)
{
    static const char *const type[] = { "", "SCALAR", "VEC2", "VEC3", "VEC4" };
    return add_accessor(
        s, value, count * (size_t)width * sizeof *value, 5126, count, type[width], "");
}

/// Writes it. @param rest everything but asset, buffers, their views and accessors
static inline const char *write_sketch(const folder *place, const sketch *s, const char *rest)
{
    static char text[65536];
    snprintf(text, sizeof text, "\"bufferViews\":[%s],\"accessors\":[%s],%s", s->views,
        s->accessors, rest);
    return write_gltf(place, &s->bytes, text);
}

/// Accessor 0: the four corners of the unit square; 1: its two triangles.
static inline sketch square_sketch(void)
{
    const float corner[12] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    const uint8_t index[6] = { 0, 1, 2, 0, 2, 3 };
    sketch s = { .count = 0 };
    add_vectors(&s, corner, 4, 3);
    add_accessor(&s, index, sizeof index, 5121, 6, "SCALAR", "");
    return s;
}

static inline void assert_bounds(const rsv_scene *scene, rsv_vec3 low, rsv_vec3 high)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_vec3 a = view->bounds_min, b = view->bounds_max;
    float tolerance = 1e-5f * fmaxf(1, fmaxf(v3_max_abs(low), v3_max_abs(high)));
    if (v3_max_abs(v3_sub(a, low)) > tolerance || v3_max_abs(v3_sub(b, high)) > tolerance)
        fail_msg("bounds (%g %g %g) (%g %g %g), not (%g %g %g) (%g %g %g)", (double)a.x,
            (double)a.y, (double)a.z, (double)b.x, (double)b.y, (double)b.z, (double)low.x,
            (double)low.y, (double)low.z, (double)high.x, (double)high.y, (double)high.z);
}

#endif
