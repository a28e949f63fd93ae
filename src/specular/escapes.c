#include "escapes.h"

#include "../core/core.h"
#include "../core/octahedral.h"

#include <string.h>

#define HALF (RSV_ESCAPE_BINS / 2)

// ---- radiance of the bins -----------------------------------------------------------------------

/// Sums over a part of the sky, by bin.
typedef struct bin_sums {
    double radiance[3], solid_angle;
} bin_sums;

static void add_to_bin(void *user, rsv_vec3 direction, double solid_angle, rsv_rgb radiance)
{
    bin_sums *sums = (bin_sums *)user + rsv_octahedral_bin(direction, RSV_ESCAPE_SIDE);
    sums->radiance[0] += solid_angle * radiance.r;
    sums->radiance[1] += solid_angle * radiance.g;
    sums->radiance[2] += solid_angle * radiance.b;
    sums->solid_angle += solid_angle;
}

/// Adds the average of `sky` over each bin.
static void add_averages(const rsv_sky *sky, bin_sums *sums, rsv_rgb *radiance)
{
    memset(sums, 0, HALF * sizeof *sums);
    rsv_sky_visit(sky, add_to_bin, sums);
    for (size_t bin = 0; bin < HALF; bin++) {
        double scale = sums[bin].solid_angle > 0 ? 1 / sums[bin].solid_angle : 0;
        const double *sum = sums[bin].radiance;
        radiance[bin] = rgb_add(radiance[bin],
            rgb((float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale)));
    }
}

rsv_status rsv_escape_radiance(
    rsv_context *context, const rsv_environment_light *light, rsv_rgb *radiance)
{
    memset(radiance, 0, RSV_ESCAPE_BINS * sizeof *radiance);
    if (!light) return RSV_OK;
    bin_sums *sums = rsv_alloc(context, HALF, sizeof *sums);
    if (!sums) return RSV_ERROR_MEMORY;
    add_averages(&light->gathered, sums, radiance);
    memcpy(radiance + HALF, radiance, HALF * sizeof *radiance);
    add_averages(&light->sampled, sums, radiance + HALF);
    rsv_free(context, sums);
    return RSV_OK;
}

// ---- rows ---------------------------------------------------------------------------------------

rsv_status rsv_escape_row_create(rsv_context *context, uint32_t capacity, rsv_escape_row *row)
{
    *row = (rsv_escape_row){ 0 };
    row->bin = rsv_alloc(context, capacity, sizeof *row->bin);
    row->tinted_bin = rsv_alloc(context, capacity, sizeof *row->tinted_bin);
    row->tinted_weight = rsv_alloc(context, capacity, sizeof *row->tinted_weight);
    return row->bin && row->tinted_bin && row->tinted_weight ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_escape_row_destroy(rsv_context *context, rsv_escape_row *row)
{
    rsv_free(context, row->bin);
    rsv_free(context, row->tinted_bin);
    rsv_free(context, row->tinted_weight);
}

void rsv_escape_row_add(rsv_escape_row *row, rsv_vec3 direction, rsv_rgb weight, uint32_t turns)
{
    uint32_t bin = rsv_octahedral_bin(direction, RSV_ESCAPE_SIDE) + (turns ? HALF : 0);
    if (fabsf(weight.r - 1) + fabsf(weight.g - 1) + fabsf(weight.b - 1) < 1e-4f) {
        row->bin[row->count++] = (uint16_t)bin;
        return;
    }
    row->tinted_bin[row->tinted_count] = (uint16_t)bin;
    row->tinted_weight[row->tinted_count++] = weight;
}

rsv_status rsv_escapes_create(rsv_context *context, size_t row_count, rsv_escapes *escapes)
{
    *escapes = (rsv_escapes){ 0 };
    escapes->begin = rsv_alloc(context, row_count + 1, sizeof *escapes->begin);
    escapes->tinted_begin = rsv_alloc(context, row_count + 1, sizeof *escapes->tinted_begin);
    return escapes->begin && escapes->tinted_begin ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_status reserve(
    rsv_context *context, rsv_escape_list *list, size_t count, size_t tinted_count)
{
    rsv_status status;
    RSV_TRY(rsv_grow(context, (void **)&list->bin, &list->bin_capacity, count, sizeof *list->bin));
    RSV_TRY(rsv_grow(context, (void **)&list->tinted_bin, &list->tinted_bin_capacity, tinted_count,
        sizeof *list->tinted_bin));
    RSV_TRY(rsv_grow(context, (void **)&list->tinted_weight, &list->tinted_weight_capacity,
        tinted_count, sizeof *list->tinted_weight));
cleanup:
    return status;
}

/// To a list that has the room.
static void append(rsv_escape_list *list, const uint16_t *bin, size_t count,
    const uint16_t *tinted_bin, const rsv_rgb *tinted_weight, size_t tinted_count)
{
    if (count) memcpy(list->bin + list->count, bin, count * sizeof *bin);
    if (tinted_count) {
        memcpy(
            list->tinted_bin + list->tinted_count, tinted_bin, tinted_count * sizeof *tinted_bin);
        memcpy(list->tinted_weight + list->tinted_count, tinted_weight,
            tinted_count * sizeof *tinted_weight);
    }
    list->count += count;
    list->tinted_count += tinted_count;
}

rsv_status rsv_escapes_store(rsv_context *context, rsv_escapes *escapes, size_t index,
    const rsv_escape_row *row, rsv_escape_list *list)
{
    escapes->begin[index + 1] = row->count; // summed up in the end
    escapes->tinted_begin[index + 1] = row->tinted_count;
    rsv_status status =
        reserve(context, list, list->count + row->count, list->tinted_count + row->tinted_count);
    if (status == RSV_OK)
        append(list, row->bin, row->count, row->tinted_bin, row->tinted_weight, row->tinted_count);
    return status;
}

rsv_status rsv_escapes_append(rsv_context *context, rsv_escapes *escapes, rsv_escape_list *list)
{
    rsv_escape_list *all = &escapes->list;
    rsv_status status =
        reserve(context, all, all->count + list->count, all->tinted_count + list->tinted_count);
    if (status == RSV_OK)
        append(
            all, list->bin, list->count, list->tinted_bin, list->tinted_weight, list->tinted_count);
    list->count = list->tinted_count = 0;
    return status;
}

void rsv_escapes_finish(rsv_escapes *escapes, size_t row_count)
{
    for (size_t row = 0; row < row_count; row++) {
        escapes->begin[row + 1] += escapes->begin[row];
        escapes->tinted_begin[row + 1] += escapes->tinted_begin[row];
    }
}

void rsv_escape_list_destroy(rsv_context *context, rsv_escape_list *list)
{
    rsv_free(context, list->bin);
    rsv_free(context, list->tinted_bin);
    rsv_free(context, list->tinted_weight);
    *list = (rsv_escape_list){ 0 };
}

rsv_rgb rsv_escapes_sum(const rsv_escapes *escapes, size_t row, const rsv_rgb *radiance)
{
    const rsv_escape_list *list = &escapes->list;
    rsv_rgb sum = rgb_gray(0);
    for (size_t k = escapes->begin[row]; k < escapes->begin[row + 1]; k++)
        sum = rgb_add(sum, radiance[list->bin[k]]);
    for (size_t k = escapes->tinted_begin[row]; k < escapes->tinted_begin[row + 1]; k++)
        sum = rgb_add(sum, rgb_mul(list->tinted_weight[k], radiance[list->tinted_bin[k]]));
    return sum;
}

float rsv_escapes_sum_squares(const rsv_escapes *escapes, size_t row, const rsv_rgb *radiance)
{
    const rsv_escape_list *list = &escapes->list;
    float sum = 0;
    for (size_t k = escapes->begin[row]; k < escapes->begin[row + 1]; k++) {
        float luminance = rgb_luminance(radiance[list->bin[k]]);
        sum += luminance * luminance;
    }
    for (size_t k = escapes->tinted_begin[row]; k < escapes->tinted_begin[row + 1]; k++) {
        float luminance =
            rgb_luminance(rgb_mul(list->tinted_weight[k], radiance[list->tinted_bin[k]]));
        sum += luminance * luminance;
    }
    return sum;
}

void rsv_escapes_destroy(rsv_context *context, rsv_escapes *escapes)
{
    rsv_free(context, escapes->begin);
    rsv_free(context, escapes->tinted_begin);
    rsv_escape_list_destroy(context, &escapes->list);
}

static void mark_bins(const uint16_t *bin, size_t count, uint16_t *seen)
{
    for (size_t k = 0; k < count; k++) // straight escapes have the first bins
        if (bin[k] < RSV_ESCAPE_BINS / 2) seen[bin[k]] = 1;
}

void rsv_escapes_mark(const rsv_escapes *e, size_t row, uint16_t *seen)
{
    size_t begin = e->begin[row], tinted = e->tinted_begin[row];
    mark_bins(e->list.bin + begin, e->begin[row + 1] - begin, seen);
    mark_bins(e->list.tinted_bin + tinted, e->tinted_begin[row + 1] - tinted, seen);
}
