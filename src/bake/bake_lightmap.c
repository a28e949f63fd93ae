/// Light in a picture over the surfaces of a glTF file.
#include "resolvent/bake.h"

#include "../core/index_map.h"
#include "../core/vec.h"
#include "../io/atomic_file.h"
#include "../io/gltf_accessor.h"
#include "../io/image_internal.h"
#include "bake_basis.h"
#include "bake_desc.h"
#include "bake_pack.h"
#include "bake_primitive.h"
#include "bake_seam.h"
#include "bake_texels.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Attempts to undo overlaps within charts, and to find a density that fits.
#define MOST_ROUNDS 4
#define MOST_SIZES 12
/// Part of the texels that a full map could hold at best: where the search for a density begins.
#define FULLEST 0.98
/// A larger map must show this much more.
#define WORTH_IT 1.02f
/// Sides of maps where none is asked for, and the part of them that charts of a few texels may fill.
#define FIRST_SIDE 1024
#define LAST_SIDE 4096
#define SMALL_CHARTS 0.4
/// Codes end at this share of the texels: the brightest few are clipped, for the sake of the others' precision.
#define BRIGHTEST 0.995
/// Texels along a side by which the second texture coordinates of a file are judged.
#define CHECK_TEXELS 256

typedef struct lightmap_bake {
    const rsv_solution *s;
    const rsv_bake_desc *desc;
    rsv_bake_document document;
    rsv_bake_parts parts;
    cJSON **primitive; ///< [parts.count]
    float **uv;      ///< [parts.count] second texture coordinates of the file; NULL = make new ones
    uint8_t **layer; ///< [parts.count] triangles that need a chart of their own; NULL = none
    rsv_bake_charts charts;
    rsv_bake_map map;
    float density;
    float scale; ///< W/m2 of the largest code
    double largest_seam;
} lightmap_bake;

// ---- texture coordinates of the file --------------------------------------------------------------

static bool carries_light(const lightmap_bake *b, const rsv_bake_part *part)
{
    for (size_t t = 0; t < part->triangle_count; t++)
        if (part->triangle[t] != RSV_NONE)
            return b->s->elements->face_of[0][part->triangle[t]] != RSV_NONE;
    return false;
}

/// Why a part's second texture coordinates cannot hold light; NULL = they can.
static rsv_status judge_uv(const lightmap_bake *b, size_t k, const float (*uv)[2], const char **why)
{
    rsv_status status;
    const rsv_bake_part *part = &b->parts.part[k];
    rsv_bake_charts charts = { .context = b->s->context };
    rsv_bake_map map = { 0 };
    uint8_t *overlap = NULL;
    size_t upon = 0;
    *why = NULL;
    for (size_t n = 0; n < part->vertex_count && !*why; n++)
        for (int c = 0; c < 2; c++)
            if (!(uv[n][c] >= -1e-4f && uv[n][c] <= 1.0001f)) *why = "leave the unit square";
    if (*why) return RSV_OK;
    RSV_TRY(rsv_bake_keep_chart(&charts, b->s, part, 0, uv));
    overlap = rsv_alloc(b->s->context, charts.triangle_count, 1);
    RSV_TRY(overlap ? RSV_OK : RSV_ERROR_MEMORY);
    charts.chart->texels[0] = charts.chart->texels[1] = CHECK_TEXELS;
    RSV_TRY(rsv_bake_map_create(&charts, part, CHECK_TEXELS, CHECK_TEXELS, 1, &map, overlap));
    for (size_t t = 0; t < charts.triangle_count; t++)
        upon += overlap[t];
    if (upon) *why = "overlap";
    if (charts.chart->size[0] == 0 || charts.chart->size[1] == 0) *why = "have no area";
cleanup:
    rsv_bake_map_destroy(b->s->context, &map);
    rsv_bake_charts_destroy(&charts);
    rsv_free(b->s->context, overlap);
    return status;
}

static rsv_status read_uv(lightmap_bake *b, size_t k)
{
    const rsv_bake_part *part = &b->parts.part[k];
    int accessor = b->document.gltf->mesh[part->mesh].primitive[part->primitive].uv[1];
    size_t count, width;
    const char *why;
    if (!b->desc->keep_uv || accessor < 0) return RSV_OK;
    rsv_status status = rsv_gltf_read_attribute(
        b->s->context, b->document.gltf, accessor, part->label, &b->uv[k], &count, &width);
    if (status == RSV_OK) status = judge_uv(b, k, (const float(*)[2])b->uv[k], &why);
    if (status != RSV_OK || !why) return status;
    rsv_log(b->s->context, RSV_LOG_WARNING,
        "mesh '%s': its second texture coordinates %s; new ones are made", part->label, why);
    rsv_free(b->s->context, b->uv[k]);
    b->uv[k] = NULL;
    return RSV_OK;
}

// ---- charts and their places ----------------------------------------------------------------------

static rsv_status make_charts(lightmap_bake *b)
{
    rsv_status status = RSV_OK;
    rsv_bake_charts_destroy(&b->charts);
    for (uint32_t k = 0; k < b->parts.count; k++) {
        const rsv_bake_part *part = &b->parts.part[k];
        if (!carries_light(b, part)) continue;
        if (b->uv[k])
            RSV_TRY(rsv_bake_keep_chart(&b->charts, b->s, part, k, (const float(*)[2])b->uv[k]));
        else
            RSV_TRY(rsv_bake_add_charts(&b->charts, b->s, part, k, b->layer[k]));
    }
    if (!b->charts.count)
        status = rsv_fail(RSV_ERROR_SCENE,
            "%s: bake: nothing here reflects diffusely, so there is no light to keep",
            b->document.path);
cleanup:
    return status;
}

static double charts_area(const rsv_bake_charts *c)
{
    double area = 0;
    for (size_t k = 0; k < c->count; k++)
        area += (double)c->chart[k].size[0] * (double)c->chart[k].size[1];
    return area;
}

/// Texels along a side at most: as asked for, or so many that charts of a few texels do not fill the map.
static uint32_t largest_side(const lightmap_bake *b)
{
    uint32_t side = b->desc->map_size, least = b->desc->padding + 2;
    if (side) return side;
    double needed = (double)b->charts.count * least * least;
    for (side = FIRST_SIDE; side < LAST_SIDE && needed > SMALL_CHARTS * side * side;)
        side *= 2;
    return side;
}

/// The largest density, up to `most`, at which everything fits; 0 = none does.
static rsv_status find_density(
    lightmap_bake *b, uint32_t width, uint32_t rows, float most, float *density, uint32_t *height)
{
    rsv_status status;
    float low = 0, high = most, middle = most;
    *density = 0;
    for (int k = 0; k < MOST_SIZES; k++) {
        uint32_t needed;
        RSV_TRY(rsv_bake_pack(&b->charts, middle, b->desc->padding, width, rows, &needed));
        if (needed != UINT32_MAX) {
            *density = low = middle;
            *height = needed;
        } else {
            high = middle;
        }
        if (low == most) break;
        middle = low > 0 ? sqrtf(low * high) : 0.5f * high;
    }
cleanup:
    return status;
}

/// Packs at the density asked for or, where that is too much or none is asked for, at the largest that fits: in
/// the shape of map that allows the most, and in the smallest of those.
static rsv_status pack(lightmap_bake *b, uint32_t *width, uint32_t *height)
{
    rsv_status status;
    uint32_t side = largest_side(b);
    float most = (float)sqrt(FULLEST * side * side / charts_area(&b->charts));
    if (b->desc->density > 0) most = f_min(b->desc->density, most);
    b->density = 0;
    for (uint32_t eighths = 3; eighths <= 8; eighths++) {
        uint32_t tried = side * eighths / 8, needed = 0;
        float density;
        RSV_TRY(find_density(b, tried, side, most, &density, &needed));
        bool better = density > WORTH_IT * b->density;
        if (density == 0 || !better) continue;
        b->density = density;
        *width = tried;
        *height = needed;
    }
    if (b->density == 0)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "bake: %zu charts do not fit into %u x %u texels; ask for a larger map",
            b->charts.count, side, side);
    if (b->density < b->desc->density)
        rsv_log(b->s->context, RSV_LOG_WARNING,
            "bake: %.4g texels per metre instead of %.4g, to fit into %u x %u texels",
            (double)b->density, (double)b->desc->density, side, side);
    RSV_TRY(rsv_bake_pack(&b->charts, b->density, b->desc->padding, *width, side, height));
    *height = (*height + 3) & ~3u;
cleanup:
    return status;
}

/// Moves triangles that lie upon others to one layer up. @return whether there are any
static bool set_apart(lightmap_bake *b, const uint8_t *overlap, rsv_status *status)
{
    bool any = false;
    for (size_t c = 0; c < b->charts.count; c++) {
        const rsv_bake_chart *chart = &b->charts.chart[c];
        for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++) {
            if (!overlap[k] || b->uv[chart->part] || chart->triangle_count == 1) continue;
            uint8_t **layer = &b->layer[chart->part];
            if (!*layer)
                *layer = rsv_alloc(
                    b->s->context, b->parts.part[chart->part].triangle_count, sizeof **layer);
            if (!*layer) *status = RSV_ERROR_MEMORY;
            if (!*layer) return false;
            (*layer)[b->charts.triangle[k]]++;
            any = true;
        }
    }
    return any;
}

static rsv_status lay_out(lightmap_bake *b)
{
    rsv_status status = RSV_OK;
    bool again = true;
    for (int round = 0; round < MOST_ROUNDS && again; round++) {
        uint32_t width = 0, height = 0;
        RSV_TRY(make_charts(b));
        RSV_TRY(pack(b, &width, &height));
        rsv_bake_map_destroy(b->s->context, &b->map);
        uint8_t *overlap = rsv_alloc(b->s->context, b->charts.triangle_count, 1);
        RSV_TRY(overlap ? RSV_OK : RSV_ERROR_MEMORY);
        status = rsv_bake_map_create(
            &b->charts, b->parts.part, width, height, b->desc->padding, &b->map, overlap);
        again = status == RSV_OK && set_apart(b, overlap, &status);
        rsv_free(b->s->context, overlap);
        RSV_TRY(status);
        RSV_TRY(rsv_progress(b->s->context, "bake", 0.2 * (round + 1)));
    }
cleanup:
    return status;
}

// ---- pictures -------------------------------------------------------------------------------------

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// The brightness that most texels do not exceed.
static rsv_status find_scale(lightmap_bake *b)
{
    size_t texels = (size_t)b->map.width * b->map.height, shown = 0;
    float *value = rsv_alloc(b->s->context, texels, sizeof *value);
    if (!value) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < texels; k++)
        if (b->map.distance[k] < 0.5f) value[shown++] = rgb_max(b->map.light[k]);
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
    size_t texels = (size_t)b->map.width * b->map.height, bytes;
    uint8_t(*codes)[3] = rsv_alloc(d->context, texels, sizeof *codes), *png = NULL;
    RSV_TRY(codes ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < texels; k++)
        for (int c = 0; c < 3; c++)
            codes[k][c] = code_of((&b->map.light[k].r)[c] / b->scale);
    RSV_TRY(rsv_image_png_from_codes(
        d->context, (const uint8_t(*)[3])codes, b->map.width, b->map.height, &png, &bytes));
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

/// The same in full precision, beside the file: "room.glb" -> "room.lightmap.exr".
static rsv_status write_exr(const lightmap_bake *b, const char *output)
{
    rsv_image *image = NULL;
    char path[RSV_PATH_BYTES];
    snprintf(path, sizeof path, "%.*s.lightmap.exr", (int)(strlen(output) - 4), output);
    rsv_status status = rsv_image_create(b->s->context, b->map.width, b->map.height, 1, &image);
    if (status != RSV_OK) return status;
    memcpy(rsv_image_pixels(image, 0), b->map.light,
        (size_t)b->map.width * b->map.height * sizeof *b->map.light);
    status = rsv_image_write(image, path, 0);
    rsv_image_destroy(image);
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
    for (size_t c = 0; c < b->charts.count; c++) {
        const rsv_bake_chart *chart = &b->charts.chart[c];
        if (chart->part != part_index) continue;
        for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++) {
            for (int v = 0; v < 3; v++) {
                uint32_t from = part->corner[b->charts.triangle[k]][v];
                uint32_t fresh = (uint32_t)mesh->vertex_count;
                uint32_t to = rsv_index_map_insert(&vertices, (uint64_t)c << 32 | from, fresh);
                RSV_TRY(to == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
                mesh->corner[mesh->triangle_count][v] = to;
                if (to != fresh) continue;
                float point[2];
                rsv_bake_chart_point(chart, b->charts.corner[k][v], point);
                (*uv)[fresh][0] = point[0] / (float)b->map.width;
                (*uv)[fresh][1] = point[1] / (float)b->map.height;
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
    if (material) {
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
        if (carries_light(b, &b->parts.part[k])) RSV_TRY(write_part(b, k, texture, set));
    RSV_TRY(write_exr(b, output));
    RSV_TRY(rsv_bake_document_write(&b->document, output));
cleanup:
    return status;
}

static void fill_report(const lightmap_bake *b, rsv_bake_report *report)
{
    *report = (rsv_bake_report){ .charts = b->charts.count,
        .map_width = b->map.width,
        .map_height = b->map.height,
        .density = b->density,
        .coverage = rsv_bake_map_coverage(&b->map),
        .light_scale = b->scale,
        .largest_seam = b->largest_seam };
}

static rsv_status open_file(lightmap_bake *b, const char *input)
{
    rsv_status status;
    rsv_context *context = b->s->context;
    RSV_TRY(rsv_bake_document_open(context, input, &b->document));
    RSV_TRY(rsv_bake_parts_create(&b->document, b->s, &b->parts));
    RSV_TRY(rsv_bake_separate(&b->document, &b->parts, &b->primitive));
    b->uv = rsv_alloc(context, b->parts.count, sizeof *b->uv);
    b->layer = rsv_alloc(context, b->parts.count, sizeof *b->layer);
    RSV_TRY(b->uv && b->layer ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < b->parts.count; k++)
        if (carries_light(b, &b->parts.part[k])) RSV_TRY(read_uv(b, k));
cleanup:
    return status;
}

static void close_file(lightmap_bake *b)
{
    rsv_context *context = b->s->context;
    for (size_t k = 0; k < b->parts.count; k++) {
        if (b->uv) rsv_free(context, b->uv[k]);
        if (b->layer) rsv_free(context, b->layer[k]);
    }
    rsv_free(context, b->uv);
    rsv_free(context, b->layer);
    rsv_free(context, b->primitive);
    rsv_bake_map_destroy(context, &b->map);
    rsv_bake_charts_destroy(&b->charts);
    rsv_bake_parts_destroy(&b->parts);
    rsv_bake_document_close(&b->document);
}

rsv_status rsv_bake_lightmap(const rsv_solution *solution, const char *input, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    rsv_status status;
    rsv_bake_desc defaults = rsv_default_bake_desc();
    lightmap_bake b = { .s = solution,
        .desc = desc ? desc : &defaults,
        .document.context = solution->context,
        .parts.context = solution->context,
        .charts.context = solution->context };
    RSV_TRY(rsv_bake_check_desc(b.desc));
    RSV_TRY(open_file(&b, input));
    RSV_TRY(lay_out(&b));
    rsv_bake_map_light(solution, &b.map);
    RSV_TRY(rsv_bake_close_seams(solution, &b.charts, &b.parts, &b.map, &b.largest_seam));
    RSV_TRY(find_scale(&b));
    fill_report(&b, report);
    if (b.desc->dry_run) goto cleanup;
    RSV_TRY(write_file(&b, output));
    if (b.desc->basis)
        RSV_TRY(rsv_bake_write_basis(solution, b.map.receiver, (size_t)b.map.width * b.map.height,
            "texel", output, &report->lights));
cleanup:
    close_file(&b);
    return status;
}
