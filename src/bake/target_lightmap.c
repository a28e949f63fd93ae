/// Light in a picture over the surfaces of a glTF file.
#include "../core/vec.h"
#include "bake_basis.h"
#include "bake_constants.h"
#include "bake_judge.h"
#include "bake_lightmap_file.h"
#include "bake_map_light.h"
#include "bake_open.h"
#include "bake_operator.h"
#include "bake_primitive.h"
#include "bake_relit.h"
#include "bake_seam.h"
#include "bake_target.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// Value of the largest code: as requested, or the brightness that most texels do not exceed; and how many do.
static rsv_status find_scale(rsv_lightmap_bake *b)
{
    size_t texels = (size_t)b->layout.map.width * b->layout.map.height, shown = 0, brighter = 0;
    float *value = rsv_alloc(b->s->context, texels, sizeof *value);
    if (!value) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < texels; k++)
        if (b->layout.map.distance[k] < 0.5f) value[shown++] = rgb_max(b->layout.map.light[k]);
    qsort(value, shown, sizeof *value, compare_floats);
    b->scale = RSV_PI * b->desc->light_scale;
    if (!(b->scale > 0) && shown) b->scale = value[(size_t)ceil(BRIGHTEST * (double)(shown - 1))];
    if (!(b->scale > 0)) b->scale = shown && value[shown - 1] > 0 ? value[shown - 1] : 1;
    for (size_t k = shown; k-- > 0 && value[k] > b->scale;)
        brighter++;
    b->saturated = shown ? (double)brighter / (double)shown : 0;
    rsv_free(b->s->context, value);
    return RSV_OK;
}

static rsv_bake_sheet sheet_of(const rsv_lightmap_bake *b)
{
    return (rsv_bake_sheet){ &b->layout.charts, b->parts.part, &b->layout.map, b->layout.density };
}

/// @param light out, [texels]
static rsv_status estimate_map(
    const rsv_lightmap_bake *b, const rsv_light_view *solution, rsv_rgb *light)
{
    const rsv_bake_sheet sheet = sheet_of(b);
    const rsv_bake_accuracy accuracy = { .error = b->desc->error,
        .largest = LARGEST_DEVIATION * b->desc->error,
        .dark = DARK * (float)b->s->report.mean_irradiance,
        .seed = b->s->desc.seed };
    return rsv_bake_light_map(solution, &sheet, &accuracy, light);
}

/// The map under one light, with its seams closed, so that no combination of lights shows larger jumps.
static rsv_status read_map(
    const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value)
{
    const rsv_lightmap_bake *b = reader->receiver;
    rsv_bake_map map = b->layout.map;
    double largest, all = rsv_bake_map_sum(&map);
    map.light = value;
    rsv_status status = estimate_map(b, light, value);
    if (status != RSV_OK) return status;
    double share = all > 0 ? rsv_bake_map_sum(&map) / all : 0;
    return rsv_bake_close_seams(
        light, &b->layout, share * b->s->report.mean_irradiance, &map, NULL, &largest);
}

/// @param b its map becomes the sum of the lights
static rsv_status write_basis(rsv_lightmap_bake *b, const char *output, size_t *lights)
{
    size_t texels = (size_t)b->layout.map.width * b->layout.map.height;
    rsv_bake_reader reader = rsv_bake_surface_reader("texel", b, texels, read_map);
    reader.sum = b->layout.map.light;
    return rsv_bake_write_basis(b->s, &reader, b->desc, output, lights);
}

static rsv_status write_operator(const rsv_lightmap_bake *b, const char *output)
{
    const rsv_bake_map *map = &b->layout.map;
    return rsv_bake_write_operator(
        b->s, "texel", map->receiver, (size_t)map->width * map->height, output);
}

static bool is_translucent(const rsv_light_view *s, const rsv_surface_place *place)
{
    uint32_t face = s->elements->face_of[place->back][place->triangle];
    return face != RSV_NONE && rsv_is_translucent(s, face);
}

/// Shows the visitor the texels whose middles are on surfaces: those beyond borders continue the light, for filtering.
static void show_texels(const rsv_lightmap_bake *b, const rsv_bake_visitor *visitor)
{
    const rsv_bake_map *map = &b->layout.map;
    const rsv_bake_sheet sheet = sheet_of(b);
    const rsv_bake_cover cover = rsv_bake_cover_of(b->s);
    const uint32_t size[2] = { map->width, map->height };
    for (uint32_t k = 0; k < map->width * map->height; k++) {
        const uint32_t at[2] = { k % map->width, k / map->width };
        rsv_bake_patch patch;
        if (!(map->distance[k] < ON_BORDER) || !visitor->wants(visitor->user, at, size)) continue;
        rsv_bake_texel_patch(&sheet, k, &patch);
        if (!rsv_bake_keep_open(&cover, &patch)) continue;
        const rsv_bake_value value = { .at = { at[0], at[1] },
            .irradiance = map->light[k],
            .place = patch.place,
            .place_count = patch.count,
            .translucent = is_translucent(b->s, patch.place) };
        visitor->take(visitor->user, &value);
    }
}

static rsv_status judge(const rsv_lightmap_bake *b, rsv_bake_report *report)
{
    rsv_bake_judge judge;
    rsv_status status = rsv_bake_judge_create(b->s, b->desc->judged, &judge);
    if (status == RSV_OK && judge.wanted) {
        show_texels(b, &judge.visitor);
        status = rsv_bake_judge_finish(&judge, DARK * (float)b->s->report.mean_irradiance, report);
    }
    rsv_bake_judge_destroy(&judge);
    return status;
}

static void fill_report(const rsv_lightmap_bake *b, rsv_bake_report *report)
{
    report->charts = b->layout.charts.count;
    report->map_width = b->layout.map.width;
    report->map_height = b->layout.map.height;
    report->density = b->layout.density;
    report->coverage = rsv_bake_map_coverage(&b->layout.map);
    report->light_scale = b->scale / RSV_PI;
    report->saturated = b->saturated;
    report->largest_seam = b->largest_seam;
}

static rsv_status open_document(rsv_lightmap_bake *b)
{
    rsv_status status;
    RSV_TRY(rsv_bake_document_open(b->s->scene.scene, &b->document));
    RSV_TRY(rsv_bake_parts_create(&b->document, b->s, &b->parts));
    RSV_TRY(rsv_bake_separate(&b->document, &b->parts, &b->primitive));
    RSV_TRY(rsv_bake_follow_relight(b->s, &b->parts, b->primitive, &b->document));
    RSV_TRY(rsv_bake_layout_create(b->s, b->desc, &b->document, &b->parts, &b->layout));
cleanup:
    return status;
}

static void close_document(rsv_lightmap_bake *b)
{
    rsv_bake_layout_destroy(&b->layout);
    rsv_free(b->s->context, b->primitive);
    rsv_bake_parts_destroy(&b->parts);
    rsv_bake_document_close(&b->document);
}

/// Gives charts whose seams do not close more texels. Light that elements store will do to find them.
static rsv_status find_detail(rsv_lightmap_bake *b)
{
    rsv_status status = RSV_OK;
    size_t charts = b->layout.charts.count;
    uint8_t *open = rsv_alloc(b->s->context, charts, 1);
    bool again = true;
    if (!open) return RSV_ERROR_MEMORY;
    for (int round = 0; again && round < MOST_REFINEMENTS; round++) {
        memset(open, 0, charts);
        rsv_bake_map_light(b->s, &b->layout.map);
        RSV_TRY(rsv_bake_close_seams(b->s, &b->layout, b->s->report.mean_irradiance, &b->layout.map,
            open, &b->largest_seam));
        RSV_TRY(rsv_bake_layout_refine(&b->layout, open, &again));
    }
cleanup:
    rsv_free(b->s->context, open);
    return status;
}

/// Lights the map and closes its seams.
static rsv_status light_map(rsv_lightmap_bake *b)
{
    rsv_status status;
    RSV_TRY(find_detail(b));
    RSV_TRY(estimate_map(b, b->s, b->layout.map.light));
    RSV_TRY(rsv_bake_close_seams(
        b->s, &b->layout, b->s->report.mean_irradiance, &b->layout.map, NULL, &b->largest_seam));
cleanup:
    return status;
}

static void warn_if_coarse(const rsv_lightmap_bake *b)
{
    if (b->layout.density < b->desc->density)
        rsv_log(b->s->context, RSV_LOG_WARNING,
            "bake: %.4g texels per metre instead of %.4g, to fit into %u x %u texels",
            (double)b->layout.density, (double)b->desc->density, b->layout.side, b->layout.side);
}

static rsv_status write_lightmap(const rsv_light_view *solution, const rsv_bake_desc *desc,
    const char *output, rsv_bake_report *report)
{
    rsv_status status;
    rsv_lightmap_bake b = { .s = solution,
        .desc = desc,
        .document.context = solution->context,
        .parts.context = solution->context };
    RSV_TRY(rsv_bake_check_operator(solution, b.desc));
    RSV_TRY(open_document(&b));
    RSV_TRY(light_map(&b));
    warn_if_coarse(&b);
    if (b.desc->basis && !b.desc->dry_run) RSV_TRY(write_basis(&b, output, &report->lights));
    RSV_TRY(find_scale(&b));
    fill_report(&b, report);
    if (desc->visitor) show_texels(&b, desc->visitor);
    RSV_TRY(judge(&b, report));
    if (b.desc->dry_run) goto cleanup;
    if (b.desc->operator_file) RSV_TRY(write_operator(&b, output));
    RSV_TRY(rsv_lightmap_bake_write(&b, output));
cleanup:
    close_document(&b);
    return status;
}

const rsv_bake_target rsv_bake_target_lightmap = { ".glb", write_lightmap };
