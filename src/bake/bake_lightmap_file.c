#include "bake_lightmap_file.h"

#include "../core/index_map.h"
#include "../core/srgb.h"
#include "../core/vec.h"
#include "../io/atomic_file.h"
#include "../io/image_codes.h"
#include "bake_directions.h"
#include "bake_ktx2.h"
#include "bake_primitive.h"
#include "resolvent/image.h"
#include "resolvent/luminaire.h"

#include <stdio.h>
#include <string.h>

// ---- pictures -------------------------------------------------------------------------------------

/// sRGB, as in MOZ_lightmap, which has more codes for dark values.
static uint8_t code_of(float value)
{
    return (uint8_t)(255 * rsv_srgb_encode((double)f_min(f_max(value, 0), 1)) + 0.5);
}

/// Adds the map to the file: a texture of sRGB codes.
static rsv_status add_texture(rsv_lightmap_bake *b, int *texture)
{
    rsv_status status;
    rsv_bake_document *d = &b->document;
    size_t texels = (size_t)b->layout.map.width * b->layout.map.height, bytes;
    uint8_t(*codes)[3] = rsv_alloc(d->context, texels, sizeof *codes), *png = NULL;
    RSV_TRY(codes ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < texels; k++)
        for (int c = 0; c < 3; c++)
            codes[k][c] = code_of((&b->layout.map.light[k].r)[c] / b->scale);
    RSV_TRY(rsv_image_png_from_codes(d->context, (const uint8_t(*)[3])codes, b->layout.map.width,
        b->layout.map.height, &png, &bytes));
    cJSON *image = cJSON_CreateObject(), *sampler = cJSON_CreateObject(),
          *json = cJSON_CreateObject();
    rsv_bake_string(d, image, "name", "lightmap");
    rsv_bake_number(d, image, "bufferView", rsv_bake_add_view(d, png, bytes, 0));
    rsv_bake_string(d, image, "mimeType", "image/png");
    const char *const keys[] = { "magFilter", "minFilter", "wrapS", "wrapT" };
    const int values[] = { 9729, 9729, 33071, 33071 }; // linear, clamped
    for (int k = 0; k < 4; k++)
        rsv_bake_number(d, sampler, keys[k], values[k]);
    rsv_bake_number(
        d, json, "source", rsv_bake_append(d, rsv_bake_array(d, d->root, "images"), image));
    rsv_bake_number(
        d, json, "sampler", rsv_bake_append(d, rsv_bake_array(d, d->root, "samplers"), sampler));
    *texture = rsv_bake_append(d, rsv_bake_array(d, d->root, "textures"), json);
cleanup:
    rsv_free(d->context, codes);
    rsv_free(d->context, png);
    return status;
}

/// Values of the files beside the document for W/m2.
static float unit_of(const rsv_lightmap_bake *b)
{
    return b->desc->photometric ? (float)RSV_LUMEN_PER_WATT : 1;
}

/// An image of the map's size in full precision, beside the file: "room.glb" -> "room.lightmap.exr".
static rsv_status write_exr(
    const rsv_lightmap_bake *b, const char *output, const char *suffix, const rsv_rgb *texel)
{
    rsv_image *image = NULL;
    char path[RSV_PATH_BYTES];
    snprintf(path, sizeof path, "%.*s.%s.exr", (int)(strlen(output) - 4), output, suffix);
    rsv_status status =
        rsv_image_create(b->s->context, b->layout.map.width, b->layout.map.height, 1, &image);
    if (status != RSV_OK) return status;
    rsv_rgb *pixel = rsv_image_pixels(image, 0);
    for (size_t k = 0; k < (size_t)b->layout.map.width * b->layout.map.height; k++)
        pixel[k] = rgb_scale(texel[k], unit_of(b));
    status = rsv_image_write(image, path, 0);
    rsv_image_destroy(image);
    return status;
}

/// The same in shared exponents: "room.glb" -> "room.lightmap.ktx2".
static rsv_status write_ktx2(const rsv_lightmap_bake *b, const char *output)
{
    const rsv_bake_map *map = &b->layout.map;
    char path[RSV_PATH_BYTES];
    size_t brighter = 0, texels = (size_t)map->width * map->height;
    rsv_rgb *value = rsv_alloc(b->s->context, texels, sizeof *value);
    if (!value) return RSV_ERROR_MEMORY;
    snprintf(path, sizeof path, "%.*s.lightmap.ktx2", (int)(strlen(output) - 4), output);
    for (size_t k = 0; k < texels; k++) {
        value[k] = rgb_scale(map->light[k], unit_of(b));
        brighter += rgb_max(value[k]) > RSV_RGB9E5_MOST;
    }
    if (brighter)
        rsv_log(b->s->context, RSV_LOG_WARNING,
            "bake: %zu texels exceed 65408 %s and are clipped in '%s'; the .exr holds them",
            brighter, b->desc->photometric ? "lux" : "W/m2", path);
    rsv_status status = rsv_bake_write_ktx2(b->s->context, path, map->width, map->height, value);
    rsv_free(b->s->context, value);
    return status;
}

/// Where the light of each texel comes from: V of bake_directions.h, a picture for each of its components.
static rsv_status write_directions(const rsv_lightmap_bake *b, const char *output)
{
    rsv_status status;
    const rsv_bake_map *map = &b->layout.map;
    size_t texels = (size_t)map->width * map->height;
    rsv_bake_directions directions;
    rsv_rgb *axis[3] = { NULL };
    RSV_TRY(rsv_bake_directions_create(b->s, &directions));
    for (int a = 0; a < 3; a++)
        axis[a] = rsv_alloc(b->s->context, texels, sizeof *axis[a]);
    RSV_TRY(axis[0] && axis[1] && axis[2] ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < texels; k++) {
        rsv_rgb v[3];
        rsv_bake_directions_at(&directions, &map->receiver[k], v);
        for (int a = 0; a < 3; a++)
            axis[a][k] = rgb_mul(v[a], map->light[k]);
    }
    static const char *const suffixes[] = { "lightmap-x", "lightmap-y", "lightmap-z" };
    for (int a = 0; a < 3; a++)
        RSV_TRY(write_exr(b, output, suffixes[a], axis[a]));
cleanup:
    for (int a = 0; a < 3; a++)
        rsv_free(b->s->context, axis[a]);
    rsv_bake_directions_destroy(&directions);
    return status;
}

// ---- the file -------------------------------------------------------------------------------------

/// Whether a texture of this JSON is looked up by a set of coordinates; an older lightmap does not count.
static bool is_looked_up_by(const cJSON *json, int set)
{
    const cJSON *item;
    if (cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(json, "texCoord")) == set)
        return true;
    cJSON_ArrayForEach(
        item, json) if (!(item->string && strcmp(item->string, "MOZ_lightmap") == 0) &&
                        is_looked_up_by(item, set)) return true;
    return false;
}

/// The set of texture coordinates for the map: the second, as loaders expect it, unless the file shows something by it.
static int map_set(const rsv_lightmap_bake *b)
{
    int set = 1;
    while (is_looked_up_by(cJSON_GetObjectItemCaseSensitive(b->document.root, "materials"), set))
        set++;
    return set;
}

/// A part's vertices: one for every chart that it is in.
static rsv_status split_vertices(
    rsv_lightmap_bake *b, uint32_t part_index, rsv_bake_mesh *mesh, float (**uv)[2])
{
    rsv_status status = RSV_OK;
    const rsv_bake_part *part = &b->parts.part[part_index];
    rsv_context *context = b->s->context;
    rsv_index_map vertices = { 0 };
    size_t most = 3 * part->triangle_count;
    *mesh = (rsv_bake_mesh){ .context = context, .changed = true };
    mesh->parent = rsv_alloc(context, part->vertex_count, sizeof *mesh->parent);
    mesh->attribute = rsv_alloc(context, most, sizeof *mesh->attribute);
    mesh->corner = rsv_alloc(context, part->triangle_count, sizeof *mesh->corner);
    *uv = rsv_alloc(context, most, sizeof **uv);
    RSV_TRY(mesh->parent && mesh->attribute && mesh->corner && *uv ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_index_map_create(context, part->vertex_count, &vertices));
    mesh->attribute_count = part->vertex_count;
    for (uint32_t n = 0; n < part->vertex_count; n++)
        mesh->parent[n][0] = mesh->parent[n][1] = n;
    for (size_t c = 0; c < b->layout.charts.count; c++) {
        const rsv_bake_chart *chart = &b->layout.charts.chart[c];
        if (chart->part != part_index) continue;
        for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++) {
            for (int v = 0; v < 3; v++) {
                uint32_t from = part->corner[b->layout.charts.triangle[k]][v];
                uint32_t fresh = (uint32_t)mesh->vertex_count;
                uint32_t to = rsv_index_map_insert(&vertices, (uint64_t)c << 32 | from, fresh);
                RSV_TRY(to == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
                mesh->corner[mesh->triangle_count][v] = to;
                if (to != fresh) continue;
                float point[2];
                rsv_bake_chart_point(chart, b->layout.charts.corner[k][v], point);
                (*uv)[fresh][0] = point[0] / (float)b->layout.map.width;
                (*uv)[fresh][1] = point[1] / (float)b->layout.map.height;
                mesh->attribute[mesh->vertex_count++] = from;
            }
            mesh->triangle_count++;
        }
    }
cleanup:
    rsv_index_map_destroy(&vertices);
    return status;
}

/// Sets must be without gaps: those before that a primitive lacks become the same.
static void set_coordinates(rsv_bake_document *d, cJSON *primitive, int set, int accessor)
{
    cJSON *attributes = cJSON_GetObjectItemCaseSensitive(primitive, "attributes");
    for (int k = 0; k <= set; k++) {
        char name[32];
        snprintf(name, sizeof name, "TEXCOORD_%d", k);
        if (k == set || !cJSON_GetObjectItemCaseSensitive(attributes, name))
            rsv_bake_number(d, attributes, name, accessor);
    }
}

/// Unlit materials show their colour in any light.
static bool is_unlit(const cJSON *material)
{
    const cJSON *extensions = cJSON_GetObjectItemCaseSensitive(material, "extensions");
    return cJSON_GetObjectItemCaseSensitive(extensions, "KHR_materials_unlit") != NULL;
}

static rsv_status write_part(rsv_lightmap_bake *b, uint32_t k, int texture, int set)
{
    rsv_status status;
    rsv_bake_document *d = &b->document;
    rsv_bake_mesh mesh = { .context = d->context };
    float(*uv)[2] = NULL;
    RSV_TRY(split_vertices(b, k, &mesh, &uv));
    RSV_TRY(rsv_bake_replace_vertices(d, b->primitive[k], &b->parts.part[k], &mesh));
    set_coordinates(
        d, b->primitive[k], set, rsv_bake_add_floats(d, uv[0], mesh.vertex_count, 2, false));
    cJSON *material = rsv_bake_material(d, b->primitive[k]);
    if (material && !is_unlit(material)) {
        cJSON *extension = rsv_bake_extension(d, material, "MOZ_lightmap");
        rsv_bake_number(d, extension, "index", texture);
        rsv_bake_number(d, extension, "texCoord", set);
        rsv_bake_number(d, extension, "intensity", (double)b->scale);
    }
cleanup:
    rsv_bake_mesh_destroy(&mesh);
    rsv_free(d->context, uv);
    return status;
}

rsv_status rsv_lightmap_bake_write(rsv_lightmap_bake *b, const char *output)
{
    rsv_status status;
    int texture, set = map_set(b);
    RSV_TRY(add_texture(b, &texture));
    for (uint32_t k = 0; k < b->parts.count; k++)
        if (rsv_bake_carries_light(b->s, &b->parts.part[k]))
            RSV_TRY(write_part(b, k, texture, set));
#if !defined(RSV_WITHOUT_OPENEXR) // in web pages, the basis holds light in full precision
    RSV_TRY(write_exr(b, output, "lightmap", b->layout.map.light));
#endif
    if (b->desc->ktx2) RSV_TRY(write_ktx2(b, output));
    if (b->desc->directional) RSV_TRY(write_directions(b, output));
    RSV_TRY(rsv_bake_document_write(&b->document, output));
cleanup:
    return status;
}
