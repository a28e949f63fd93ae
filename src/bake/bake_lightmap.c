/// Light in a picture over the surfaces of a glTF file.
#include "resolvent/bake.h"

#include "../core/index_map.h"
#include "../core/vec.h"
#include "../io/atomic_file.h"
#include "../io/image_internal.h"
#include "bake_basis.h"
#include "bake_desc.h"
#include "bake_directions.h"
#include "bake_layout.h"
#include "bake_primitive.h"
#include "bake_seam.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Codes end at this share of the texels: the brightest few are clipped, for the sake of the others' precision.
#define BRIGHTEST 0.995

/// How often charts whose seams stay open get more texels.
#define MOST_REFINEMENTS 3

typedef struct lightmap_bake {
    const rsv_solution *s;
    const rsv_bake_desc *desc;
    rsv_bake_document document;
    rsv_bake_parts parts;
    cJSON **primitive; ///< [parts.count]
    rsv_bake_layout layout;
    float scale; ///< W/m2 of the largest code
    double largest_seam;
} lightmap_bake;

// ---- pictures -------------------------------------------------------------------------------------

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// The brightness that most texels do not exceed.
static rsv_status find_scale(lightmap_bake *b)
{
    size_t texels = (size_t)b->layout.map.width * b->layout.map.height, shown = 0;
    float *value = rsv_alloc(b->s->context, texels, sizeof *value);
    if (!value) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < texels; k++)
        if (b->layout.map.distance[k] < 0.5f) value[shown++] = rgb_max(b->layout.map.light[k]);
    qsort(value, shown, sizeof *value, compare_floats);
    b->scale = shown ? value[(size_t)(BRIGHTEST * (double)(shown - 1))] : 0;
    if (!(b->scale > 0)) b->scale = shown && value[shown - 1] > 0 ? value[shown - 1] : 1;
    rsv_free(b->s->context, value);
    return RSV_OK;
}

static uint8_t code_of(float value) { return (uint8_t)(255 * f_min(f_max(value, 0), 1) + 0.5f); }

/// Adds the map to the file: a texture of linear codes.
static rsv_status add_texture(lightmap_bake *b, int *texture)
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

/// A picture of the map's size in full precision, beside the file: "room.glb" -> "room.lightmap.exr".
static rsv_status write_exr(
    const lightmap_bake *b, const char *output, const char *suffix, const rsv_rgb *texel)
{
    rsv_image *image = NULL;
    char path[RSV_PATH_BYTES];
    snprintf(path, sizeof path, "%.*s.%s.exr", (int)(strlen(output) - 4), output, suffix);
    rsv_status status =
        rsv_image_create(b->s->context, b->layout.map.width, b->layout.map.height, 1, &image);
    if (status != RSV_OK) return status;
    memcpy(rsv_image_pixels(image, 0), texel,
        (size_t)b->layout.map.width * b->layout.map.height * sizeof *texel);
    status = rsv_image_write(image, path, 0);
    rsv_image_destroy(image);
    return status;
}

/// Where the light of each texel comes from: V of bake_directions.h, a picture for each of its components.
static rsv_status write_directions(const lightmap_bake *b, const char *output)
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

/// The first set of texture coordinates after the first that no part has.
static int free_set(const lightmap_bake *b)
{
    for (int set = 1;; set++) {
        char name[32];
        bool used = false;
        snprintf(name, sizeof name, "TEXCOORD_%d", set);
        for (size_t k = 0; k < b->parts.count; k++)
            used |=
                cJSON_GetObjectItemCaseSensitive(
                    cJSON_GetObjectItemCaseSensitive(b->primitive[k], "attributes"), name) != NULL;
        if (!used) return set;
    }
}

/// A part's vertices: one for every chart that it is in.
static rsv_status split_vertices(
    lightmap_bake *b, uint32_t part_index, rsv_bake_mesh *mesh, float (**uv)[2])
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

/// Unlit materials show their colour, whatever the light.
static bool is_unlit(const cJSON *material)
{
    const cJSON *extensions = cJSON_GetObjectItemCaseSensitive(material, "extensions");
    return cJSON_GetObjectItemCaseSensitive(extensions, "KHR_materials_unlit") != NULL;
}

static rsv_status write_part(lightmap_bake *b, uint32_t k, int texture, int set)
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

static rsv_status write_file(lightmap_bake *b, const char *output)
{
    rsv_status status;
    int texture, set = free_set(b);
    RSV_TRY(add_texture(b, &texture));
    for (uint32_t k = 0; k < b->parts.count; k++)
        if (rsv_bake_carries_light(b->s, &b->parts.part[k]))
            RSV_TRY(write_part(b, k, texture, set));
    RSV_TRY(write_exr(b, output, "lightmap", b->layout.map.light));
    if (b->desc->directional) RSV_TRY(write_directions(b, output));
    RSV_TRY(rsv_bake_document_write(&b->document, output));
cleanup:
    return status;
}

/// The map under one light, its seams closed too: lights together then show no larger jumps, whatever their strengths.
static rsv_status read_map(const rsv_bake_reader *reader, const rsv_solution *light, rsv_rgb *value)
{
    const lightmap_bake *b = reader->receiver;
    rsv_bake_map map = b->layout.map;
    double largest, all = rsv_bake_map_sum(&map);
    map.light = value;
    rsv_bake_map_light(light, &map);
    double share = all > 0 ? rsv_bake_map_sum(&map) / all : 0;
    return rsv_bake_close_seams(light, &b->layout.charts, &b->parts,
        share * b->s->report.mean_irradiance, &map, NULL, &largest);
}

static rsv_status write_basis(const lightmap_bake *b, const char *output, size_t *lights)
{
    size_t texels = (size_t)b->layout.map.width * b->layout.map.height;
    rsv_bake_reader reader = rsv_bake_surface_reader("texel", NULL, texels);
    reader.receiver = b;
    reader.read = read_map;
    return rsv_bake_write_basis(b->s, &reader, b->desc, output, lights);
}

static void fill_report(const lightmap_bake *b, rsv_bake_report *report)
{
    *report = (rsv_bake_report){ .charts = b->layout.charts.count,
        .map_width = b->layout.map.width,
        .map_height = b->layout.map.height,
        .density = b->layout.density,
        .coverage = rsv_bake_map_coverage(&b->layout.map),
        .light_scale = b->scale,
        .largest_seam = b->largest_seam };
}

static rsv_status open_file(lightmap_bake *b, const char *input)
{
    rsv_status status;
    RSV_TRY(rsv_bake_document_open(b->s->context, input, &b->document));
    RSV_TRY(rsv_bake_parts_create(&b->document, b->s, &b->parts));
    RSV_TRY(rsv_bake_separate(&b->document, &b->parts, &b->primitive));
    RSV_TRY(rsv_bake_layout_create(b->s, b->desc, &b->document, &b->parts, &b->layout));
cleanup:
    return status;
}

static void close_file(lightmap_bake *b)
{
    rsv_bake_layout_destroy(&b->layout);
    rsv_free(b->s->context, b->primitive);
    rsv_bake_parts_destroy(&b->parts);
    rsv_bake_document_close(&b->document);
}

/// Lights the map and closes its seams; charts where that fails get more texels.
static rsv_status light_map(lightmap_bake *b)
{
    rsv_status status = RSV_OK;
    size_t charts = b->layout.charts.count;
    uint8_t *open = rsv_alloc(b->s->context, charts, 1);
    bool again = true;
    if (!open) return RSV_ERROR_MEMORY;
    for (int round = 0; again; round++) {
        memset(open, 0, charts);
        rsv_bake_map_light(b->s, &b->layout.map);
        RSV_TRY(rsv_bake_close_seams(b->s, &b->layout.charts, &b->parts,
            b->s->report.mean_irradiance, &b->layout.map, open, &b->largest_seam));
        again = round < MOST_REFINEMENTS;
        if (again) RSV_TRY(rsv_bake_layout_refine(&b->layout, open, &again));
    }
cleanup:
    rsv_free(b->s->context, open);
    return status;
}

static void warn_if_coarse(const lightmap_bake *b)
{
    if (b->layout.density < b->desc->density)
        rsv_log(b->s->context, RSV_LOG_WARNING,
            "bake: %.4g texels per metre instead of %.4g, to fit into %u x %u texels",
            (double)b->layout.density, (double)b->desc->density, b->layout.side, b->layout.side);
}

rsv_status rsv_bake_lightmap(const rsv_solution *solution, const char *input, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    rsv_status status;
    rsv_bake_desc defaults = rsv_default_bake_desc();
    lightmap_bake b = { .s = solution,
        .desc = desc ? desc : &defaults,
        .document.context = solution->context,
        .parts.context = solution->context };
    RSV_TRY(rsv_bake_check_desc(b.desc));
    RSV_TRY(open_file(&b, input));
    RSV_TRY(light_map(&b));
    warn_if_coarse(&b);
    RSV_TRY(find_scale(&b));
    fill_report(&b, report);
    if (b.desc->dry_run) goto cleanup;
    RSV_TRY(write_file(&b, output));
    if (b.desc->basis) RSV_TRY(write_basis(&b, output, &report->lights));
cleanup:
    close_file(&b);
    return status;
}
