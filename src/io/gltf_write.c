/// A committed scene as binary glTF: one node and mesh per object, geometry in world space.
///
/// The binary chunk holds three arrays: positions, normals and indices. The accessors of each object are
/// ranges of them. It is streamed from the scene's own arrays.
#include "gltf_write.h"
#include "../core/core.h"
#include "../core/vec.h"
#include "../scene/material_fields.h"
#include "../scene/punctual.h"
#include "../scene/scene.h"
#include "atomic_file.h"
#include "data_uri.h"
#include "resolvent/io.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HALF_PI 1.5707963267948966

/// An object's ranges in the scene's arrays.
typedef struct object_range {
    size_t first_triangle, triangle_count;
    uint32_t first_vertex, vertex_count;
} object_range;

typedef struct writer {
    rsv_context *context;
    const rsv_scene_view *view;
    object_range *object; ///< [object_count]
    cJSON *root, *nodes, *roots, *extensions_used;
    size_t node_count;
    bool exhausted; ///< some piece of JSON could not be allocated
} writer;

// ---- JSON -----------------------------------------------------------------------------------------

static cJSON *noted(writer *w, cJSON *item)
{
    if (!item) w->exhausted = true;
    return item;
}

static cJSON *add_object(writer *w, cJSON *parent, const char *key)
{
    return noted(w, cJSON_AddObjectToObject(parent, key));
}

static cJSON *add_array(writer *w, cJSON *parent, const char *key)
{
    return noted(w, cJSON_AddArrayToObject(parent, key));
}

static void add_string(writer *w, cJSON *parent, const char *key, const char *value)
{
    noted(w, cJSON_AddStringToObject(parent, key, value));
}

/// The shortest decimal that is read back as the same float.
static double shortest(float value)
{
    char text[32];
    for (int digits = 6; digits < 9; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value) return strtod(text, NULL);
    }
    return value;
}

static void add_number(writer *w, cJSON *parent, const char *key, double value)
{
    noted(w, cJSON_AddNumberToObject(parent, key, value));
}

static void add_float(writer *w, cJSON *parent, const char *key, float value)
{
    add_number(w, parent, key, shortest(value));
}

static void append(writer *w, cJSON *array, cJSON *item)
{
    if (noted(w, item) && !cJSON_AddItemToArray(array, item)) {
        cJSON_Delete(item);
        w->exhausted = true;
    }
}

static cJSON *append_object(writer *w, cJSON *array)
{
    cJSON *item = cJSON_CreateObject();
    append(w, array, item);
    return w->exhausted ? NULL : item;
}

static void add_floats(writer *w, cJSON *parent, const char *key, const float *value, int count)
{
    cJSON *array = add_array(w, parent, key);
    for (int i = 0; i < count; i++)
        append(w, array, cJSON_CreateNumber(shortest(value[i])));
}

static void add_rgb(writer *w, cJSON *parent, const char *key, rsv_rgb value)
{
    add_floats(w, parent, key, (const float[]){ value.r, value.g, value.b }, 3);
}

/// An object for `name` in parent's "extensions", and its entry in "extensionsUsed".
static cJSON *add_extension(writer *w, cJSON *parent, const char *name)
{
    bool listed = false;
    const cJSON *entry;
    cJSON_ArrayForEach(entry, w->extensions_used) listed =
        listed || !strcmp(entry->valuestring, name);
    if (!listed) append(w, w->extensions_used, cJSON_CreateString(name));
    cJSON *extensions = cJSON_GetObjectItemCaseSensitive(parent, "extensions");
    if (!extensions) extensions = add_object(w, parent, "extensions");
    return add_object(w, extensions, name);
}

// ---- materials ------------------------------------------------------------------------------------

static void add_emission(writer *w, cJSON *json, rsv_rgb emission)
{
    float strength = f_max(rgb_max(emission), 1); // the factor itself may not exceed 1
    if (rgb_is_black(emission)) return;
    add_rgb(w, json, "emissiveFactor",
        rgb(emission.r / strength, emission.g / strength, emission.b / strength));
    if (strength > 1)
        add_float(w, add_extension(w, json, "KHR_materials_emissive_strength"), "emissiveStrength",
            strength);
}

static const float *value_of(const rsv_material *m, const rsv_material_field *f)
{
    return (const float *)(const void *)((const char *)m + f->offset);
}

static bool is_usual(const rsv_material *m, const rsv_material_field *f)
{
    bool usual = true;
    for (int k = 0; k < f->channels; k++)
        usual = usual && value_of(m, f)[k] == f->usual;
    return usual;
}

static bool is_in(const rsv_material_field *f, const char *extension)
{
    return f->extension && strcmp(f->extension, extension) == 0;
}

/// Whether some field of an extension has another value than where it is not there.
static bool is_used(const rsv_material *m, const char *extension)
{
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++)
        if (is_in(f, extension) && !is_usual(m, f)) return true;
    return false;
}

static void add_members(writer *w, cJSON *json, const rsv_material *m, const char *extension)
{
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++) {
        const float *value = value_of(m, f);
        if (!is_in(f, extension) || isinf(*value)) continue; // infinite is usual, and no JSON
        if (f->channels == 1)
            add_float(w, json, f->key, *value);
        else
            add_floats(w, json, f->key, value, f->channels);
    }
}

static bool is_first_of_its_extension(const rsv_material_field *field)
{
    for (const rsv_material_field *f = rsv_material_fields(); f < field; f++)
        if (is_in(f, field->extension)) return false;
    return true;
}

static void add_extensions(writer *w, cJSON *json, const rsv_material *m)
{
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++) {
        if (!f->extension || !is_first_of_its_extension(f) || !is_used(m, f->extension)) continue;
        cJSON *object = is_in(f, RSV_IN_EXTRAS)
                            ? add_object(w, add_object(w, json, "extras"), "resolvent")
                            : add_extension(w, json, f->extension);
        add_members(w, object, m, f->extension);
    }
}

static void add_coverage(writer *w, cJSON *json, const rsv_material *m)
{
    if (m->alpha_cutoff > 0) {
        add_string(w, json, "alphaMode", "MASK");
        add_float(w, json, "alphaCutoff", m->alpha_cutoff);
    } else if (m->opacity < 1) {
        add_string(w, json, "alphaMode", "BLEND");
    }
}

static void add_material(writer *w, cJSON *materials, const rsv_material *m)
{
    cJSON *json = append_object(w, materials);
    add_string(w, json, "name", m->name);
    cJSON *pbr = add_object(w, json, "pbrMetallicRoughness");
    const float base_color[4] = { m->base_color.r, m->base_color.g, m->base_color.b, m->opacity };
    add_floats(w, pbr, "baseColorFactor", base_color, 4);
    add_float(w, pbr, "metallicFactor", m->metallic);
    add_float(w, pbr, "roughnessFactor", m->roughness);
    add_coverage(w, json, m);
    if (m->double_sided) noted(w, cJSON_AddTrueToObject(json, "doubleSided"));
    if (m->unlit) { // excludes the extensions below, which it makes meaningless
        add_extension(w, json, "KHR_materials_unlit");
        return;
    }
    add_emission(w, json, m->emission);
    add_extensions(w, json, m);
}

static void add_materials(writer *w)
{
    if (!w->view->material_count) return;
    if (w->view->texture_count || w->view->color)
        rsv_log(w->context, RSV_LOG_WARNING,
            "textures and vertex colours are not written: materials keep their factors alone");
    cJSON *materials = add_array(w, w->root, "materials");
    for (size_t i = 0; i < w->view->material_count; i++)
        add_material(w, materials, &w->view->material[i]);
}

// ---- nodes, cameras, lights -----------------------------------------------------------------------

static cJSON *add_node(writer *w, const char *name)
{
    cJSON *node = append_object(w, w->nodes);
    append(w, w->roots, cJSON_CreateNumber((double)w->node_count++));
    add_string(w, node, "name", name);
    return node;
}

/// A node's matrix from its axes and its place.
static void add_frame(writer *w, cJSON *node, rsv_vec3 x, rsv_vec3 y, rsv_vec3 z, rsv_vec3 position)
{
    const float matrix[16] = { x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, position.x,
        position.y, position.z, 1 };
    add_floats(w, node, "matrix", matrix, 16);
}

static void add_lens(writer *w, cJSON *json, const rsv_camera *camera)
{
    rsv_vec3 low = w->view->bounds_min, high = w->view->bounds_max;
    float size = v3_length(v3_sub(high, low));
    if (camera->vertical_fov > 0) {
        add_string(w, json, "type", "perspective");
        cJSON *lens = add_object(w, json, "perspective");
        add_float(w, lens, "yfov", camera->vertical_fov);
        if (camera->aspect > 0) add_float(w, lens, "aspectRatio", camera->aspect);
        add_float(w, lens, "znear", 1e-3f * size);
    } else {
        float aspect = camera->aspect > 0 ? camera->aspect : 1;
        add_string(w, json, "type", "orthographic");
        cJSON *lens = add_object(w, json, "orthographic");
        add_float(w, lens, "xmag", aspect * camera->vertical_extent);
        add_float(w, lens, "ymag", camera->vertical_extent);
        add_float(w, lens, "znear", 0);
        add_float(w, lens, "zfar", size + v3_length(v3_sub(camera->position, low)));
    }
}

static void add_cameras(writer *w)
{
    if (!w->view->camera_count) return;
    cJSON *cameras = add_array(w, w->root, "cameras");
    for (size_t i = 0; i < w->view->camera_count; i++) {
        const rsv_camera *camera = &w->view->camera[i];
        cJSON *json = append_object(w, cameras);
        add_string(w, json, "name", camera->name);
        add_lens(w, json, camera);
        cJSON *node = add_node(w, camera->name);
        add_number(w, node, "camera", (double)i);
        add_frame(w, node, camera->right, camera->up, v3_neg(camera->forward), camera->position);
    }
}

static void add_light_shape(writer *w, cJSON *json, const rsv_punctual_light *light)
{
    add_string(w, json, "type", rsv_punctual_kind(light->kind).name);
    if (!rsv_punctual_has_cone(light)) return;
    // the format wants inner < outer <= pi/2, which floats may miss by their rounding
    double outer = fmin(shortest(light->outer_cone_angle), HALF_PI);
    double inner = fmin(shortest(light->inner_cone_angle), outer * (1 - 1e-7));
    cJSON *spot = add_object(w, json, "spot");
    add_number(w, spot, "innerConeAngle", inner);
    add_number(w, spot, "outerConeAngle", outer);
    if (!(light->exponent > 0) && !light->smooth_cone) return;
    cJSON *extras = add_object(w, json, "extras");
    if (light->exponent > 0) add_float(w, extras, "cosExponent", light->exponent);
    if (light->smooth_cone)
        noted(w, cJSON_AddTrueToObject(add_object(w, extras, "resolvent"), "smooth_cone"));
}

/// Has a node of its own that looks along -z.
static cJSON *add_light_node(writer *w, const rsv_punctual_light *light)
{
    cJSON *node = add_node(w, light->name);
    rsv_vec3 x = v3(1, 0, 0), y = v3(0, 1, 0), z = v3(0, 0, 1);
    if (v3_length(light->direction) > 0) {
        z = v3_neg(light->direction);
        v3_frame(z, &x, &y);
    }
    if (light->kind == RSV_PUNCTUAL_LUMINAIRE) x = light->side, y = v3_cross(z, x);
    add_frame(w, node, x, y, z, light->position);
    return node;
}

static void add_light(writer *w, cJSON *lights, const rsv_punctual_light *light)
{
    cJSON *json = append_object(w, lights);
    float strength = rgb_max(light->intensity), scale = strength > 0 ? strength : 1;
    add_string(w, json, "name", light->name);
    add_rgb(w, json, "color",
        rgb(light->intensity.r / scale, light->intensity.g / scale, light->intensity.b / scale));
    add_float(w, json, "intensity", strength);
    add_light_shape(w, json, light);
    add_number(w, add_extension(w, add_light_node(w, light), "KHR_lights_punctual"), "light",
        (double)cJSON_GetArraySize(lights) - 1);
}

static void add_lights(writer *w)
{
    cJSON *lights = NULL;
    for (size_t i = 0; i < w->view->light_count; i++) {
        const rsv_punctual_light *light = &w->view->light[i];
        if (light->kind == RSV_PUNCTUAL_LUMINAIRE) continue;
        if (!lights)
            lights = add_array(w, add_extension(w, w->root, "KHR_lights_punctual"), "lights");
        add_light(w, lights, light);
    }
}

// ---- luminaires -----------------------------------------------------------------------------------

/// A luminaire as LM-63 within the document, with its highest intensity as candela of 1 W/sr.
static void add_profile(writer *w, cJSON *lights, const rsv_luminaire *luminaire)
{
    cJSON *json = append_object(w, lights);
    char *text = NULL, *uri = NULL;
    if (rsv_luminaire_print(w->context, luminaire, &text) == RSV_OK)
        uri = rsv_data_uri(w->context, "application/x-ies-lm-63", text, strlen(text));
    if (uri)
        add_string(w, json, "uri", uri);
    else
        w->exhausted = true;
    add_string(w, json, "mimeType", "application/x-ies-lm-63");
    add_string(w, json, "name", luminaire->name);
    rsv_free(w->context, text);
    rsv_free(w->context, uri);
}

static void add_luminaires(writer *w)
{
    if (!w->view->luminaire_count) return;
    cJSON *lights = add_array(w, add_extension(w, w->root, "EXT_lights_ies"), "lights");
    for (size_t k = 0; k < w->view->luminaire_count; k++)
        add_profile(w, lights, &w->view->luminaire[k]);
    for (size_t i = 0; i < w->view->light_count; i++) {
        const rsv_punctual_light *light = &w->view->light[i];
        if (light->kind != RSV_PUNCTUAL_LUMINAIRE) continue;
        float strength = rgb_max(light->intensity), scale = strength > 0 ? 1 / strength : 0;
        cJSON *json = add_extension(w, add_light_node(w, light), "EXT_lights_ies");
        add_number(w, json, "light", light->luminaire);
        add_number(w, json, "multiplier", RSV_LUMEN_PER_WATT * (double)strength);
        add_rgb(w, json, "color", strength > 0 ? rgb_scale(light->intensity, scale) : rgb_gray(1));
        const float opening[] = { light->opening.x, light->opening.y, light->opening.z };
        if (rsv_punctual_is_extended(light))
            add_floats(w, add_object(w, json, "extras"), "opening", opening, 3);
    }
}

// ---- geometry -------------------------------------------------------------------------------------

enum { POSITIONS, NORMALS, INDICES };

/// Commit writes objects one after the other, so that each is one run of triangles and of vertices.
static rsv_status find_objects(writer *w)
{
    const rsv_scene_view *view = w->view;
    w->object = rsv_alloc(w->context, view->object_count, sizeof *w->object);
    if (!w->object) return RSV_ERROR_MEMORY;
    for (size_t t = 0; t < view->triangle_count; t++) {
        object_range *range = &w->object[view->triangle_object[t]];
        if (!range->triangle_count++) {
            range->first_triangle = t;
            range->first_vertex = view->triangle[t][0];
        }
        for (int k = 0; k < 3; k++) {
            RSV_ASSERT(view->triangle[t][k] >= range->first_vertex);
            uint32_t end = view->triangle[t][k] - range->first_vertex + 1;
            if (end > range->vertex_count) range->vertex_count = end;
        }
    }
    return RSV_OK;
}

static cJSON *append_accessor(writer *w, cJSON *accessors, int view, size_t offset, size_t count)
{
    const int type_float = 5126, type_uint = 5125;
    cJSON *json = append_object(w, accessors);
    add_number(w, json, "bufferView", view);
    add_number(w, json, "byteOffset", (double)offset);
    add_number(w, json, "componentType", view == INDICES ? type_uint : type_float);
    add_number(w, json, "count", (double)count);
    add_string(w, json, "type", view == INDICES ? "SCALAR" : "VEC3");
    return json;
}

static void add_bounds(writer *w, cJSON *accessor, const object_range *range)
{
    const rsv_vec3 *position = &w->view->position[range->first_vertex];
    rsv_vec3 low = position[0], high = position[0];
    for (size_t i = 1; i < range->vertex_count; i++) {
        low = v3_min(low, position[i]);
        high = v3_max(high, position[i]);
    }
    add_floats(w, accessor, "min", &low.x, 3);
    add_floats(w, accessor, "max", &high.x, 3);
}

static void add_objects(writer *w)
{
    cJSON *meshes = add_array(w, w->root, "meshes");
    cJSON *accessors = add_array(w, w->root, "accessors");
    for (size_t i = 0; i < w->view->object_count; i++) {
        const object_range *range = &w->object[i];
        const char *name = w->view->object_name[i];
        size_t vertex_offset = range->first_vertex * sizeof(rsv_vec3);
        cJSON *positions =
            append_accessor(w, accessors, POSITIONS, vertex_offset, range->vertex_count);
        add_bounds(w, positions, range);
        append_accessor(w, accessors, NORMALS, vertex_offset, range->vertex_count);
        append_accessor(w, accessors, INDICES, range->first_triangle * 3 * sizeof(uint32_t),
            3 * range->triangle_count);

        cJSON *mesh = append_object(w, meshes);
        add_string(w, mesh, "name", name);
        cJSON *primitive = append_object(w, add_array(w, mesh, "primitives"));
        cJSON *attributes = add_object(w, primitive, "attributes");
        add_number(w, attributes, "POSITION", (double)(3 * i));
        add_number(w, attributes, "NORMAL", (double)(3 * i + 1));
        add_number(w, primitive, "indices", (double)(3 * i + 2));
        add_number(w, primitive, "material", w->view->triangle_material[range->first_triangle]);
        add_number(w, add_node(w, name), "mesh", (double)i);
    }
}

static size_t vertex_bytes(const writer *w) { return w->view->vertex_count * sizeof(rsv_vec3); }

static size_t index_bytes(const writer *w)
{
    return w->view->triangle_count * 3 * sizeof(uint32_t);
}

static void add_buffer_views(writer *w)
{
    const int target_vertices = 34962, target_indices = 34963;
    size_t offset = 0;
    cJSON *views = add_array(w, w->root, "bufferViews");
    for (int run = POSITIONS; run <= INDICES; run++) {
        size_t bytes = run == INDICES ? index_bytes(w) : vertex_bytes(w);
        cJSON *json = append_object(w, views);
        add_number(w, json, "buffer", 0);
        add_number(w, json, "byteOffset", (double)offset);
        add_number(w, json, "byteLength", (double)bytes);
        if (run != INDICES) add_number(w, json, "byteStride", sizeof(rsv_vec3));
        add_number(w, json, "target", run == INDICES ? target_indices : target_vertices);
        offset += bytes;
    }
    cJSON *buffers = add_array(w, w->root, "buffers");
    add_number(w, append_object(w, buffers), "byteLength", (double)offset);
}

// ---- the file -------------------------------------------------------------------------------------

static bool is_far(const rsv_scene_view *view)
{
    return view->origin[0] != 0 || view->origin[1] != 0 || view->origin[2] != 0;
}

/// Adds a node above all others that restores the scene's origin, so that the floats below it keep their precision.
static void add_origin(writer *w)
{
    cJSON *node = add_node(w, "origin"), *translation = add_array(w, node, "translation");
    for (int axis = 0; axis < 3; axis++)
        append(w, translation, cJSON_CreateNumber(w->view->origin[axis]));
    w->roots = add_array(w, node, "children");
}

/// The JSON chunk; free with cJSON_free. NULL on exhaustion.
static char *print_json(writer *w)
{
    w->root = noted(w, cJSON_CreateObject());
    cJSON *asset = add_object(w, w->root, "asset");
    add_string(w, asset, "version", "2.0");
    char generator[64];
    snprintf(generator, sizeof generator, "Resolvent %s", rsv_version());
    add_string(w, asset, "generator", generator);
    w->extensions_used = add_array(w, w->root, "extensionsUsed");
    add_number(w, w->root, "scene", 0);
    w->roots = add_array(w, append_object(w, add_array(w, w->root, "scenes")), "nodes");
    w->nodes = add_array(w, w->root, "nodes");
    if (is_far(w->view)) add_origin(w);
    add_objects(w);
    add_cameras(w);
    add_lights(w);
    add_luminaires(w);
    add_materials(w);
    add_buffer_views(w);
    if (!cJSON_GetArraySize(w->extensions_used)) // the format knows no empty arrays
        cJSON_DeleteItemFromObject(w->root, "extensionsUsed");
    return w->exhausted ? NULL : cJSON_PrintUnformatted(w->root);
}

/// Where the bytes go: into a file, or into memory.
typedef struct sink {
    rsv_atomic_file *file; ///< NULL = memory
    uint8_t *bytes;
    size_t count;
} sink;

static void append_bytes(sink *to, const void *data, size_t count)
{
    if (to->file)
        rsv_atomic_file_append(to->file, data, count);
    else if (count)
        memcpy(to->bytes + to->count, data, count);
    to->count += count;
}

static void append_word(sink *to, size_t value)
{
    const uint8_t little_endian[4] = { value & 255, value >> 8 & 255, value >> 16 & 255,
        value >> 24 & 255 };
    append_bytes(to, little_endian, 4);
}

/// Indices relative to their object's first vertex, in blocks.
static void append_indices(const writer *w, sink *to)
{
    enum { BLOCK = 4096 };
    uint32_t block[BLOCK][3];
    for (size_t begin = 0; begin < w->view->triangle_count; begin += BLOCK) {
        size_t count =
            w->view->triangle_count - begin < BLOCK ? w->view->triangle_count - begin : BLOCK;
        for (size_t i = 0; i < count; i++) {
            uint32_t first = w->object[w->view->triangle_object[begin + i]].first_vertex;
            for (int k = 0; k < 3; k++)
                block[i][k] = w->view->triangle[begin + i][k] - first;
        }
        append_bytes(to, block, count * sizeof *block);
    }
}

/// How long the parts of a file are.
typedef struct extent {
    size_t json_length, json_bytes, binary_bytes, total;
} extent;

static rsv_status measure(const writer *w, const char *json, extent *e)
{
    e->json_length = strlen(json);
    e->json_bytes = (e->json_length + 3) / 4 * 4;
    e->binary_bytes = 2 * vertex_bytes(w) + index_bytes(w); // all multiples of 4
    e->total = 12 + 8 + e->json_bytes + 8 + e->binary_bytes;
    if (e->total <= UINT32_MAX) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "the scene needs %zu bytes, but a .glb file can hold at most 4 GiB", e->total);
}

/// Header, JSON chunk and binary chunk; see "GLB File Format Specification" of glTF 2.0.
static void write_chunks(const writer *w, const char *json, const extent *e, sink *to)
{
    append_bytes(to, "glTF", 4);
    append_word(to, 2);
    append_word(to, e->total);
    append_word(to, e->json_bytes);
    append_bytes(to, "JSON", 4);
    append_bytes(to, json, e->json_length);
    append_bytes(to, "   ", e->json_bytes - e->json_length);
    append_word(to, e->binary_bytes);
    append_bytes(to, "BIN\0", 4);
    append_bytes(to, w->view->position, vertex_bytes(w));
    append_bytes(to, w->view->normal, vertex_bytes(w));
    append_indices(w, to);
}

/// @param path for messages @param json out: to be freed with cJSON_free even after an error
static rsv_status prepare(writer *w, const char *path, char **json, extent *e)
{
    rsv_status status = RSV_OK;
    RSV_TRY(find_objects(w));
    *json = print_json(w);
    RSV_TRY(*json ? RSV_OK : rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing glTF", path));
    RSV_TRY(measure(w, *json, e));
cleanup:
    return status;
}

static void release(writer *w, char *json)
{
    cJSON_free(json);
    cJSON_Delete(w->root);
    rsv_free(w->context, w->object);
}

/// glTF has no place for these.
static void say_left_out(const writer *w, const char *path)
{
    if (w->view->fog)
        rsv_log(w->context, RSV_LOG_WARNING,
            "%s: the scene's fog is not written, glTF cannot store it; specify it again with --fog",
            path);
    if (w->view->environment)
        rsv_log(w->context, RSV_LOG_WARNING,
            "%s: the scene's environment is not written, glTF cannot store it; specify it again with --env",
            path);
}

rsv_status rsv_scene_save(const rsv_scene *scene, const char *path)
{
    rsv_status status;
    writer w = { .context = rsv_scene_get_context(scene), .view = rsv_scene_get_view(scene) };
    rsv_atomic_file file = { .descriptor = -1 };
    char *json = NULL;
    extent e;
    RSV_TRY(rsv_scene_require_committed(scene));
    say_left_out(&w, path);
    RSV_TRY(rsv_atomic_file_open(&file, path));
    RSV_TRY(prepare(&w, path, &json, &e));
    write_chunks(&w, json, &e, &(sink){ .file = &file });
    status = rsv_atomic_file_commit(&file);
cleanup:
    rsv_atomic_file_discard(&file);
    release(&w, json);
    return status;
}

rsv_status rsv_scene_write_document(const rsv_scene *scene, uint8_t **bytes, size_t *count)
{
    rsv_status status;
    writer w = { .context = rsv_scene_get_context(scene), .view = rsv_scene_get_view(scene) };
    char *json = NULL;
    extent e;
    RSV_TRY(prepare(&w, "scene", &json, &e));
    *bytes = rsv_alloc(w.context, e.total, 1);
    RSV_TRY(*bytes ? RSV_OK : RSV_ERROR_MEMORY);
    write_chunks(&w, json, &e, &(sink){ .bytes = *bytes });
    *count = e.total;
cleanup:
    release(&w, json);
    return status;
}
