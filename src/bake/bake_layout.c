#include "bake_layout.h"

#include "../core/vec.h"
#include "../io/gltf_accessor.h"
#include "bake_constants.h"
#include "bake_pack.h"

// ---- texture coordinates of the file --------------------------------------------------------------

/// Whether triangles that hold more than a sliver of a part's surface have next to no area in its chart: light on them
/// would be that of a point or a line.
static bool is_collapsed(const rsv_bake_layout *b, const rsv_bake_charts *charts)
{
    const rsv_bake_part *part = &b->parts->part[charts->chart->part];
    double all = 0, collapsed = 0;
    for (uint32_t k = 0; k < charts->triangle_count; k++) {
        const rsv_bake_chart alone = { .first = k, .triangle_count = 1 };
        uint32_t triangle = part->triangle[charts->triangle[k]];
        double area = (double)rsv_triangle_area(b->s->scene.view, triangle);
        all += area; // the chart's scale is that of areas in the mean
        if (rsv_bake_chart_area(charts, &alone) < COLLAPSED * area) collapsed += area;
    }
    return collapsed > MOST_COLLAPSED * all;
}

/// Whether this number of charts, of a few texels each, would crowd a map of that side.
static bool is_crowded(const rsv_bake_layout *b, size_t charts, uint32_t side)
{
    double least = b->desc->padding + 2.0;
    return (double)charts * least * least > SMALL_CHARTS * side * side;
}

/// Whether texture coordinates have so many islands (such as one per triangle) that their charts would crowd the map.
static rsv_status find_pieces(
    const rsv_bake_layout *b, size_t k, const float (*uv)[2], const char **why)
{
    rsv_bake_charts charts = { .context = b->s->context };
    uint32_t side = b->desc->map_size ? b->desc->map_size : FIRST_SIDE;
    rsv_status status =
        rsv_bake_keep_charts(&charts, b->s, &b->parts->part[k], (uint32_t)k, uv, false);
    if (is_crowded(b, charts.count, side)) *why = "are in too many pieces for the map";
    rsv_bake_charts_destroy(&charts);
    return status;
}

/// Why a part's second texture coordinates cannot hold light; NULL = they can.
static rsv_status judge_uv(
    const rsv_bake_layout *b, size_t k, const float (*uv)[2], const char **why)
{
    rsv_status status;
    const rsv_bake_part *part = &b->parts->part[k];
    rsv_bake_charts charts = { .context = b->s->context };
    rsv_bake_map map = { 0 };
    uint8_t *overlap = NULL;
    size_t upon = 0;
    *why = NULL;
    for (size_t n = 0; n < part->vertex_count && !*why; n++)
        for (int c = 0; c < 2; c++)
            if (!(uv[n][c] >= -1e-4f && uv[n][c] <= 1.0001f)) *why = "leave the unit square";
    if (*why) return RSV_OK;
    RSV_TRY(rsv_bake_keep_charts(&charts, b->s, part, (uint32_t)k, uv, true));
    RSV_TRY(find_pieces(b, k, uv, why));
    overlap = rsv_alloc(b->s->context, charts.triangle_count, 1);
    RSV_TRY(overlap ? RSV_OK : RSV_ERROR_MEMORY);
    charts.chart->texels[0] = charts.chart->texels[1] = CHECK_TEXELS;
    RSV_TRY(rsv_bake_map_create(&charts, b->parts->part,
        (rsv_bake_extent){ CHECK_TEXELS, CHECK_TEXELS, 1 }, &map, overlap));
    for (size_t t = 0; t < charts.triangle_count; t++)
        upon += overlap[t];
    if (upon) *why = "overlap";
    if (is_collapsed(b, &charts)) *why = "collapse triangles into points or lines";
    if (charts.chart->size[0] == 0 || charts.chart->size[1] == 0) *why = "have no area";
cleanup:
    rsv_bake_map_destroy(b->s->context, &map);
    rsv_bake_charts_destroy(&charts);
    rsv_free(b->s->context, overlap);
    return status;
}

static rsv_status read_uv(rsv_bake_layout *b, size_t k)
{
    const rsv_bake_part *part = &b->parts->part[k];
    int accessor = b->document->gltf->mesh[part->mesh].primitive[part->primitive].uv[1];
    rsv_gltf_attribute read;
    const char *why = NULL;
    if (!b->desc->keep_uv || accessor < 0) return RSV_OK;
    rsv_status status =
        rsv_gltf_read_attribute(b->s->context, b->document->gltf, accessor, part->label, &read);
    if (status != RSV_OK) return status;
    b->uv[k] = read.values;
    if (read.width != 2 || read.count != part->vertex_count)
        return rsv_fail(RSV_ERROR_FORMAT,
            "mesh '%s': accessor %d holds no texture coordinates of its vertices", part->label,
            accessor);
    status = judge_uv(b, k, (const float(*)[2])b->uv[k], &why);
    if (status != RSV_OK || !why) return status;
    rsv_log(b->s->context, RSV_LOG_WARNING,
        "mesh '%s': its second texture coordinates %s; new ones are made", part->label, why);
    rsv_free(b->s->context, b->uv[k]);
    b->uv[k] = NULL;
    return RSV_OK;
}

// ---- charts and their places ----------------------------------------------------------------------

static rsv_status make_charts(rsv_bake_layout *b)
{
    rsv_status status = RSV_OK;
    rsv_bake_charts_destroy(&b->charts);
    for (uint32_t k = 0; k < b->parts->count; k++) {
        const rsv_bake_part *part = &b->parts->part[k];
        if (!rsv_bake_carries_light(b->s, part)) continue;
        if (b->uv[k])
            RSV_TRY(rsv_bake_keep_charts(
                &b->charts, b->s, part, k, (const float(*)[2])b->uv[k], false));
        else
            RSV_TRY(rsv_bake_add_charts(&b->charts, b->s, part, k, b->layer[k]));
    }
cleanup:
    return status;
}

/// m2, as if all were of the same detail.
static double charts_area(const rsv_bake_charts *c)
{
    double area = 0;
    for (size_t k = 0; k < c->count; k++)
        area += (double)(c->chart[k].detail * c->chart[k].detail) *
                rsv_bake_chart_area(c, &c->chart[k]);
    return area;
}

/// The layer of a part's triangles, made if there is none; NULL on exhaustion.
static uint8_t *layer_of(rsv_bake_layout *b, uint32_t part)
{
    if (!b->layer[part])
        b->layer[part] =
            rsv_alloc(b->s->context, b->parts->part[part].triangle_count, sizeof **b->layer);
    return b->layer[part];
}

static bool is_upright(const float corner[3][2])
{
    float size[2];
    for (int a = 0; a < 2; a++)
        size[a] = f_max(corner[0][a], f_max(corner[1][a], corner[2][a])) -
                  f_min(corner[0][a], f_min(corner[1][a], corner[2][a]));
    return size[1] > size[0];
}

/// Moves the upright triangles of large charts that are mostly empty, such as frames, one layer up: their sides become
/// charts. @param any out
static rsv_status divide_hollow_charts(rsv_bake_layout *b, bool *any)
{
    double all = charts_area(&b->charts);
    *any = false;
    for (size_t c = 0; c < b->charts.count; c++) {
        const rsv_bake_chart *chart = &b->charts.chart[c];
        double box = (double)chart->size[0] * (double)chart->size[1];
        bool hollow =
            rsv_bake_chart_area(&b->charts, chart) < HOLLOW * box && box > HOLLOW_SHARE * all;
        if (!hollow || chart->triangle_count > HOLLOW_TRIANGLES || b->uv[chart->part]) continue;
        uint8_t *layer = layer_of(b, chart->part);
        if (!layer) return RSV_ERROR_MEMORY;
        for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++)
            if (is_upright((const float(*)[2])b->charts.corner[k]))
                layer[b->charts.triangle[k]]++, *any = true;
    }
    return RSV_OK;
}

/// Largest side in texels: as requested, or large enough that charts of a few texels do not fill the map.
static uint32_t largest_side(const rsv_bake_layout *b)
{
    uint32_t side = b->desc->map_size;
    if (side) return side;
    for (side = FIRST_SIDE; side < LAST_SIDE && is_crowded(b, b->charts.count, side);)
        side *= 2;
    return side;
}

/// The largest density, up to `most`, at which everything fits into a square; 0 = none.
/// @param step next fraction of `most` to try if that is too much; then it gets smaller
static rsv_status find_density(
    rsv_bake_layout *b, uint32_t side, float most, float step, float *density)
{
    rsv_status status;
    float low = 0, high = most, middle = most;
    for (int k = 0; k < DENSITY_ROUNDS && !(low > 0 && high < DENSITY_EXACT * low); k++) {
        uint32_t needed;
        RSV_TRY(rsv_bake_pack(&b->charts, middle, b->desc->padding, side, side, &needed));
        if (needed != UINT32_MAX)
            low = middle;
        else
            high = middle;
        middle = low > 0 ? sqrtf(low * high) : step * high;
        step *= step;
    }
    *density = low;
cleanup:
    return status;
}

/// Packs at the requested density or, if that is too much or none is requested, at about the largest that fits, into
/// the narrowest map.
static rsv_status pack(rsv_bake_layout *b, uint32_t *width, uint32_t *height)
{
    rsv_status status;
    uint32_t side = b->side = largest_side(b);
    float most = (float)sqrt((double)side * side / fmax(charts_area(&b->charts), 1e-30));
    bool again = b->density > 0; // with somewhat more to pack
    if (b->desc->density > 0) most = f_min(b->desc->density, most);
    if (again) most = f_min(b->density, most);
    RSV_TRY(find_density(b, side, most, again ? 0.99f : 0.9f, &b->density));
    if (b->density == 0)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "bake: %zu charts do not fit into %u x %u texels; ask for a larger map",
            b->charts.count, side, side);
    float enough = b->density == most ? most : b->density / WORTH_IT;
    *height = UINT32_MAX;
    for (uint32_t eighths = 3; eighths < 8 && *height == UINT32_MAX; eighths++) {
        *width = side * eighths / 8;
        RSV_TRY(rsv_bake_pack(&b->charts, enough, b->desc->padding, *width, side, height));
    }
    if (*height == UINT32_MAX) {
        *width = side;
        RSV_TRY(rsv_bake_pack(&b->charts, b->density, b->desc->padding, side, side, height));
    } else {
        b->density = enough;
    }
    *height = (*height + 3) & ~3u;
cleanup:
    return status;
}

/// Moves triangles that lie upon others to one layer up. @return whether there are any
static bool set_apart(rsv_bake_layout *b, const uint8_t *overlap, rsv_status *status)
{
    bool any = false;
    for (size_t c = 0; c < b->charts.count; c++) {
        const rsv_bake_chart *chart = &b->charts.chart[c];
        for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++) {
            if (!overlap[k] || b->uv[chart->part] || chart->triangle_count == 1) continue;
            uint8_t *layer = layer_of(b, chart->part);
            if (!layer) *status = RSV_ERROR_MEMORY;
            if (!layer) return false;
            layer[b->charts.triangle[k]]++;
            any = true;
        }
    }
    return any;
}

/// Packs the charts and draws them.
static rsv_status draw(rsv_bake_layout *b, uint8_t *overlap)
{
    uint32_t width = 0, height = 0;
    rsv_status status = pack(b, &width, &height);
    if (status != RSV_OK) return status;
    rsv_bake_map_destroy(b->s->context, &b->map);
    return rsv_bake_map_create(&b->charts, b->parts->part,
        (rsv_bake_extent){ width, height, b->desc->padding }, &b->map, overlap);
}

static rsv_status lay_out(rsv_bake_layout *b)
{
    rsv_status status;
    bool again = true;
    RSV_TRY(make_charts(b));
    RSV_TRY(divide_hollow_charts(b, &again));
    for (int round = 0; round < OVERLAP_ROUNDS && (again || round == 0); round++) {
        if (again) RSV_TRY(make_charts(b));
        uint8_t *overlap = rsv_alloc(b->s->context, b->charts.triangle_count, 1);
        status = overlap ? draw(b, overlap) : RSV_ERROR_MEMORY;
        again = status == RSV_OK && set_apart(b, overlap, &status);
        rsv_free(b->s->context, overlap);
        RSV_TRY(status);
        RSV_TRY(rsv_progress(b->s->context, "bake", 0.2 * (round + 1)));
    }
cleanup:
    return status;
}

rsv_status rsv_bake_layout_refine(rsv_bake_layout *b, const uint8_t *chosen, bool *any)
{
    *any = false;
    for (size_t c = 0; c < b->charts.count; c++) {
        rsv_bake_chart *chart = &b->charts.chart[c];
        size_t texels = (size_t)chart->texels[0] * chart->texels[1];
        if (!chosen[c] || texels * SMALL_PART > (size_t)b->map.width * b->map.height) continue;
        chart->detail *= 2;
        *any = true;
    }
    return *any ? draw(b, NULL) : RSV_OK;
}

static rsv_status find_uvs(rsv_bake_layout *b)
{
    rsv_status status;
    b->uv = rsv_alloc(b->s->context, b->parts->count, sizeof *b->uv);
    b->layer = rsv_alloc(b->s->context, b->parts->count, sizeof *b->layer);
    RSV_TRY(b->uv && b->layer ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < b->parts->count; k++)
        if (rsv_bake_carries_light(b->s, &b->parts->part[k])) RSV_TRY(read_uv(b, k));
cleanup:
    return status;
}

rsv_status rsv_bake_layout_create(const rsv_light_view *solution, const rsv_bake_desc *desc,
    const rsv_bake_document *document, const rsv_bake_parts *parts, rsv_bake_layout *b)
{
    *b = (rsv_bake_layout){ .s = solution,
        .desc = desc,
        .document = document,
        .parts = parts,
        .charts.context = solution->context };
    rsv_status status = find_uvs(b);
    return status == RSV_OK ? lay_out(b) : status;
}

void rsv_bake_layout_destroy(rsv_bake_layout *b)
{
    if (!b->s) return;
    rsv_context *context = b->s->context;
    for (size_t k = 0; k < b->parts->count; k++) {
        if (b->uv) rsv_free(context, b->uv[k]);
        if (b->layer) rsv_free(context, b->layer[k]);
    }
    rsv_free(context, b->uv);
    rsv_free(context, b->layer);
    rsv_bake_map_destroy(context, &b->map);
    rsv_bake_charts_destroy(&b->charts);
}
