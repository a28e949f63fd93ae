#include "glb.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DEEPEST_NODE = 64, FLOATS = 5126, SHORTS = 5123, LONGS = 5125 };

static int fail(glb_scene *s, const char *what)
{
    snprintf(s->message, sizeof s->message, "%s", what);
    return -1;
}

// ---- JSON -----------------------------------------------------------------------------------------

static const cJSON *get(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static double number(const cJSON *object, const char *name, double otherwise)
{
    const cJSON *item = get(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : otherwise;
}

static void numbers(const cJSON *array, float *value, int count)
{
    for (int k = 0; k < count && cJSON_GetArraySize(array) >= count; k++)
        value[k] = (float)cJSON_GetNumberValue(cJSON_GetArrayItem(array, k));
}

/// The item of a list of the file that an object names by index; NULL if it names none.
static const cJSON *linked(
    const glb_scene *s, const char *list, const cJSON *object, const char *key)
{
    int index = (int)number(object, key, -1);
    return index < 0 ? NULL : cJSON_GetArrayItem(get(s->json, list), index);
}

// ---- arrays ---------------------------------------------------------------------------------------

static uint32_t little_endian(const unsigned char *b)
{
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/// Bytes of a buffer view, within the file. @return NULL where they are not
static const unsigned char *find_view(const glb_scene *s, const cJSON *view, double *bytes)
{
    uint32_t json_bytes = little_endian(s->bytes + 12), size = little_endian(s->bytes + 8);
    double begin = number(view, "byteOffset", 0), from = 28.0 + json_bytes + begin;
    *bytes = number(view, "byteLength", -1);
    return !view || begin < 0 || *bytes < 0 || from + *bytes > size ? NULL
                                                                    : s->bytes + (size_t)from;
}

/// Packed elements of an accessor, within the file.
typedef struct array {
    const unsigned char *data;
    uint32_t count;
    int type;
} array;

/// @param elements numbers of each element
static int find_array(
    const glb_scene *s, const cJSON *owner, const char *key, uint32_t elements, array *found)
{
    double view_bytes;
    const cJSON *accessor = linked(s, "accessors", owner, key);
    const cJSON *view = linked(s, "bufferViews", accessor, "bufferView");
    const unsigned char *data = find_view(s, view, &view_bytes);
    double count = number(accessor, "count", -1), begin = number(accessor, "byteOffset", 0);
    found->type = (int)number(accessor, "componentType", 0);
    double bytes = elements * (found->type == SHORTS ? 2.0 : 4.0);
    double stride = number(view, "byteStride", bytes);
    if (!data || stride != bytes || begin < 0 || count < 0 || begin + count * bytes > view_bytes)
        return -1;
    found->data = data + (size_t)begin;
    found->count = (uint32_t)count;
    return found->type == FLOATS || found->type == SHORTS || found->type == LONGS ? 0 : -1;
}

// ---- triangles ------------------------------------------------------------------------------------

static void transform(const float m[16], const float p[3], float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

static void multiply(const float a[16], const float b[16], float out[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            float sum = 0;
            for (int k = 0; k < 4; k++)
                sum += a[4 * k + row] * b[4 * column + k];
            out[4 * column + row] = sum;
        }
}

/// Makes room for more vertices.
static int add_vertices(glb_scene *s, uint32_t count)
{
    size_t all = (size_t)s->vertex_count + count;
    void *position = realloc(s->position, all * sizeof *s->position);
    if (position) s->position = position;
    void *color = realloc(s->color, all * sizeof *s->color);
    if (color) s->color = color;
    void *mapped = realloc(s->place, all * sizeof *s->place);
    if (mapped) s->place = mapped;
    if (!position || !color || !mapped || all > UINT32_MAX) return fail(s, "out of memory");
    memset(s->position + s->vertex_count, 0, count * sizeof *s->position);
    memset(s->place + s->vertex_count, 0, count * sizeof *s->place);
    for (size_t k = s->vertex_count; k < all; k++)
        for (int c = 0; c < 4; c++)
            s->color[k][c] = 1;
    s->vertex_count = (uint32_t)all;
    return 0;
}

/// Where a primitive's vertices begin: at its first receiver, or behind all receivers if it has none.
static int place_vertices(glb_scene *s, const cJSON *primitive, uint32_t count, uint32_t *base)
{
    double receiver = number(get(primitive, "extras"), "resolvent_first_receiver", -1);
    *base = s->vertex_count;
    if (receiver < 0 || s->map_width > 0) return add_vertices(s, count);
    if (receiver + count > s->receiver_count) return fail(s, "it was not baked with that basis");
    *base = (uint32_t)receiver;
    s->lit_count += count;
    return 0;
}

/// Colours that light multiplies as it does base colours. Vertices with light in them have those from before the bake.
static int read_colors(glb_scene *s, const cJSON *attributes, uint32_t base, uint32_t count)
{
    array color;
    const char *key = s->map_width > 0 ? "COLOR_0" : "_COLOR";
    const cJSON *accessor = linked(s, "accessors", attributes, key);
    const char *type = cJSON_GetStringValue(get(accessor, "type"));
    uint32_t width = type && strcmp(type, "VEC4") == 0 ? 4 : 3;
    if (!accessor || (s->map_width == 0 && base >= s->receiver_count)) return 0;
    if (find_array(s, attributes, key, width, &color) != 0 || color.type != FLOATS ||
        color.count != count)
        return fail(s, "colours of vertices are not as `resolvent bake` writes them");
    for (uint32_t k = 0; k < count; k++)
        memcpy(s->color[base + k], color.data + 4 * width * (size_t)k, 4 * width);
    return 0;
}

/// The lightmap of a primitive's material; NULL if it has none.
static const cJSON *lightmap_of(const glb_scene *s, const cJSON *primitive)
{
    return get(get(linked(s, "materials", primitive, "material"), "extensions"), "MOZ_lightmap");
}

/// Where vertices are in the lightmap.
static int read_places(glb_scene *s, const cJSON *primitive, uint32_t base, uint32_t count)
{
    array place;
    char key[32];
    const cJSON *map = lightmap_of(s, primitive);
    if (!map || s->map_width == 0) return 0;
    snprintf(key, sizeof key, "TEXCOORD_%d", (int)number(map, "texCoord", 1));
    if (find_array(s, get(primitive, "attributes"), key, 2, &place) != 0 || place.type != FLOATS ||
        place.count != count)
        return fail(s, "places in the lightmap are not as `resolvent bake` writes them");
    memcpy(s->place + base, place.data, count * sizeof *s->place);
    s->lit_count += count;
    return 0;
}

/// The size of the first lightmap that a material names, a PNG; all are the same one. Without it, light is in vertices.
static int find_map(glb_scene *s)
{
    double bytes = 0;
    const cJSON *material, *map = NULL;
    cJSON_ArrayForEach(material, get(s->json, "materials"))
    {
        if (!map) map = get(get(material, "extensions"), "MOZ_lightmap");
    }
    if (!map) return add_vertices(s, s->receiver_count);
    const cJSON *image = linked(s, "images", linked(s, "textures", map, "index"), "source");
    const unsigned char *png = find_view(s, linked(s, "bufferViews", image, "bufferView"), &bytes);
    if (!png || bytes < 24 || memcmp(png, "\x89PNG", 4) != 0)
        return fail(s, "its lightmap is not a PNG as `resolvent bake` writes it");
    s->map_width = (uint32_t)png[18] << 8 | png[19]; // big-endian, and no map is larger
    s->map_height = (uint32_t)png[22] << 8 | png[23];
    if (s->map_width * s->map_height != s->receiver_count)
        return fail(s, "it was not baked with that basis");
    return 0;
}

static void read_material(const glb_scene *s, const cJSON *primitive, glb_part *part)
{
    const cJSON *material = linked(s, "materials", primitive, "material");
    const cJSON *strength = get(get(material, "extensions"), "KHR_materials_emissive_strength");
    const char *name = cJSON_GetStringValue(get(material, "name"));
    const char *mode = cJSON_GetStringValue(get(material, "alphaMode"));
    *part = (glb_part){ .name = name ? name : "",
        .base_color = { 1, 1, 1, 1 },
        .mapped = s->map_width > 0 && lightmap_of(s, primitive),
        .first = s->index_count };
    if (mode && strcmp(mode, "MASK") == 0)
        part->cutoff = (float)number(material, "alphaCutoff", 0.5);
    numbers(get(get(material, "pbrMetallicRoughness"), "baseColorFactor"), part->base_color, 4);
    numbers(get(material, "emissiveFactor"), part->emission, 3);
    for (int c = 0; c < 3; c++)
        part->emission[c] *= (float)number(strength, "emissiveStrength", 1);
}

static int add_indices(glb_scene *s, const array *index, uint32_t base, uint32_t vertices)
{
    void *larger = realloc(s->index, (s->index_count + (size_t)index->count) * sizeof *s->index);
    if (!larger) return fail(s, "out of memory");
    s->index = larger;
    for (uint32_t k = 0; k < index->count; k++) {
        const unsigned char *at = index->data + (size_t)k * (index->type == SHORTS ? 2 : 4);
        uint32_t vertex = index->type == SHORTS ? at[0] | (uint32_t)at[1] << 8 : little_endian(at);
        if (vertex >= vertices) return fail(s, "an index points beyond the vertices");
        s->index[s->index_count++] = base + vertex;
    }
    return 0;
}

static int add_primitive(glb_scene *s, const cJSON *primitive, const float world[16])
{
    array position, index;
    uint32_t base;
    const cJSON *attributes = get(primitive, "attributes");
    glb_part *larger = realloc(s->part, (s->part_count + 1) * sizeof *s->part);
    if (!larger) return fail(s, "out of memory");
    s->part = larger;
    if (find_array(s, attributes, "POSITION", 3, &position) != 0 ||
        find_array(s, primitive, "indices", 1, &index) != 0 || position.type != FLOATS)
        return fail(s, "a primitive lacks indexed triangles as `resolvent bake` writes them");
    if (place_vertices(s, primitive, position.count, &base) != 0 ||
        read_colors(s, attributes, base, position.count) != 0 ||
        read_places(s, primitive, base, position.count) != 0)
        return -1;
    for (uint32_t k = 0; k < position.count; k++) {
        float local[3];
        memcpy(local, position.data + 12 * (size_t)k, sizeof local);
        transform(world, local, s->position[base + k]);
    }
    read_material(s, primitive, &s->part[s->part_count]);
    if (add_indices(s, &index, base, position.count) != 0) return -1;
    s->part[s->part_count++].count = index.count;
    return 0;
}

// ---- nodes ----------------------------------------------------------------------------------------

/// A node's matrix, given whole or as translation, rotation (a quaternion) and scale.
static void local_matrix(const cJSON *node, float m[16])
{
    float t[3] = { 0, 0, 0 }, q[4] = { 0, 0, 0, 1 }, s[3] = { 1, 1, 1 };
    numbers(get(node, "translation"), t, 3);
    numbers(get(node, "rotation"), q, 4);
    numbers(get(node, "scale"), s, 3);
    float x = q[0], y = q[1], z = q[2], w = q[3];
    const float whole[16] = { s[0] * (1 - 2 * (y * y + z * z)), s[0] * 2 * (x * y + z * w),
        s[0] * 2 * (x * z - y * w), 0, s[1] * 2 * (x * y - z * w), s[1] * (1 - 2 * (x * x + z * z)),
        s[1] * 2 * (y * z + x * w), 0, s[2] * 2 * (x * z + y * w), s[2] * 2 * (y * z - x * w),
        s[2] * (1 - 2 * (x * x + y * y)), 0, t[0], t[1], t[2], 1 };
    memcpy(m, whole, sizeof whole);
    numbers(get(node, "matrix"), m, 16);
}

static int add_node(glb_scene *s, const cJSON *node, const float parent[16], int depth)
{
    float local[16], world[16];
    const cJSON *primitive, *child, *camera = linked(s, "cameras", node, "camera");
    int nodes = cJSON_GetArraySize(get(s->json, "nodes"));
    if (depth > DEEPEST_NODE || s->node_count++ >= (uint32_t)nodes)
        return fail(s, "its nodes are no trees, or nested too deeply");
    local_matrix(node, local);
    multiply(parent, local, world);
    cJSON_ArrayForEach(
        primitive, get(linked(s, "meshes", node, "mesh"),
                       "primitives")) if (add_primitive(s, primitive, world) != 0) return -1;
    const cJSON *lens = get(camera, "perspective");
    if (lens && s->fov == 0) {
        memcpy(s->camera, world, sizeof world);
        s->fov = (float)number(lens, "yfov", 0.7);
        s->aspect = (float)number(lens, "aspectRatio", 1);
    }
    cJSON_ArrayForEach(child, get(node, "children"))
    {
        const cJSON *next = cJSON_GetArrayItem(get(s->json, "nodes"), child->valueint);
        if (add_node(s, next, world, depth + 1) != 0) return -1;
    }
    return 0;
}

/// Everything from the front, a little above, as `resolvent render` sees a scene that has no camera.
static void frame(glb_scene *s)
{
    const float back[3] = { 0, 0.35f / sqrtf(1.1225f), 1 / sqrtf(1.1225f) }, half_fov = 0.39269908f;
    float low[3], high[3], radius = 1e-6f;
    for (uint32_t k = 0; k < s->vertex_count; k++)
        for (int c = 0; c < 3; c++) {
            low[c] = k ? fminf(low[c], s->position[k][c]) : s->position[k][c];
            high[c] = k ? fmaxf(high[c], s->position[k][c]) : s->position[k][c];
        }
    for (uint32_t k = 0; k < s->vertex_count; k++) {
        float square = 0;
        for (int c = 0; c < 3; c++)
            square += powf(s->position[k][c] - (low[c] + high[c]) / 2, 2);
        radius = fmaxf(radius, sqrtf(square));
    }
    memset(s->camera, 0, sizeof s->camera);
    s->camera[0] = s->camera[15] = 1;
    s->camera[5] = back[2], s->camera[6] = -back[1];
    for (int c = 0; c < 3; c++) {
        s->camera[8 + c] = back[c];
        s->camera[12 + c] = (low[c] + high[c]) / 2 + 1.05f * radius / sinf(half_fov) * back[c];
    }
    s->fov = 2 * half_fov;
    s->aspect = 1;
    s->nearest = radius / 500;
    s->farthest = 100 * radius;
}

static int read_file(glb_scene *s, const char *path)
{
    FILE *file = fopen(path, "rb");
    long size = file && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    int complete = 0;
    if (size >= 28 && fseek(file, 0, SEEK_SET) == 0 && (s->bytes = malloc((size_t)size)))
        complete = fread(s->bytes, 1, (size_t)size, file) == (size_t)size;
    if (file) fclose(file);
    if (!complete || memcmp(s->bytes, "glTF", 4) != 0) return fail(s, "it is not a .glb file");
    if (little_endian(s->bytes + 8) > (uint64_t)size ||
        little_endian(s->bytes + 12) > (uint64_t)size - 28)
        return fail(s, "it is cut off");
    return 0;
}

/// Whether the light belongs to what was read.
static int check_light(glb_scene *s)
{
    if (s->part_count == 0) return fail(s, "it shows nothing");
    if (s->lit_count == 0)
        return fail(s, "it carries no baked light: `resolvent bake --basis` gives it");
    if (s->map_width == 0 && s->lit_count != s->receiver_count)
        return fail(s, "it was not baked with that basis");
    return 0;
}

int glb_load(glb_scene *s, const char *path, uint32_t receivers)
{
    const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    memset(s, 0, sizeof *s);
    s->receiver_count = receivers;
    s->nearest = 0.01f;
    s->farthest = 1000;
    if (read_file(s, path) != 0) return -1;
    s->json = cJSON_ParseWithLength((const char *)s->bytes + 20, little_endian(s->bytes + 12));
    if (find_map(s) != 0) return -1;
    const cJSON *node, *scenes = get(s->json, "scenes");
    const cJSON *scene = cJSON_GetArrayItem(scenes, (int)number(s->json, "scene", 0));
    cJSON_ArrayForEach(node, get(scene, "nodes"))
    {
        const cJSON *root = cJSON_GetArrayItem(get(s->json, "nodes"), node->valueint);
        if (add_node(s, root, identity, 0) != 0) return -1;
    }
    if (check_light(s) != 0) return -1;
    if (s->fov == 0) frame(s);
    return 0;
}

void glb_free(glb_scene *s)
{
    cJSON_Delete(s->json);
    free(s->bytes);
    free(s->position);
    free(s->color);
    free(s->place);
    free(s->index);
    free(s->part);
}
