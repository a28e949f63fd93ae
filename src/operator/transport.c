/// The assembled operator: products with fields, and how far its rows scatter.
#include "operator_constants.h"
#include "transport_rows.h"

void rsv_transport_destroy(rsv_transport *transport)
{
    if (!transport) return;
    rsv_context *context = transport->context;
    transport->table->destroy(transport);
    rsv_free(context, transport->scale);
    rsv_free(context, transport->gathered);
    rsv_escapes_destroy(context, &transport->escapes);
    rsv_division_destroy(transport->division);
    rsv_free(context, transport);
}

size_t rsv_transport_entries(const rsv_transport *transport)
{
    return transport->table->entries(transport);
}

size_t rsv_transport_bytes(const rsv_transport *t)
{
    const rsv_escape_list *l = &t->escapes.list;
    size_t per_row = sizeof *t->scale + sizeof *t->gathered + sizeof *t->escapes.begin +
                     sizeof *t->escapes.tinted_begin;
    return t->table->bytes(t) + t->row_count * per_row + l->bin_capacity * sizeof *l->bin +
           l->tinted_bin_capacity * sizeof *l->tinted_bin +
           l->tinted_weight_capacity * sizeof *l->tinted_weight;
}

rsv_status rsv_transport_complete(rsv_transport *t)
{
    return t->division ? t->table->complete(t) : RSV_OK;
}

// ---- products -------------------------------------------------------------------------------------

void rsv_transport_gather(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance)
{
    t->table->gather(t, fields, exitance, begin, end, irradiance);
    rsv_division_share(t->division, irradiance, fields * sizeof *irradiance);
}

void rsv_transport_residual(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual)
{
    t->table->residual(t, fields, exitance, source, irradiance, residual);
    rsv_division_share(t->division, residual, fields * sizeof *residual);
}

static rsv_rgb sum_row(const rsv_transport_row *row, size_t fields, const rsv_rgb *exitance)
{
    rsv_rgb sum = rgb_gray(0);
    for (size_t k = 0; k < row->count; k++)
        sum = rgb_add(sum, exitance[row->column[k] * fields]);
    for (size_t k = 0; k < row->tinted_count; k++)
        sum =
            rgb_add(sum, rgb_mul(row->tinted_weight[k], exitance[row->tinted_column[k] * fields]));
    return sum;
}

void rsv_gather_by_rows(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance)
{
#pragma omp parallel for schedule(dynamic, 256)                                                    \
    num_threads(rsv_threads(t->context)) if (rsv_transport_entries(t) * fields > PARALLEL_ENTRIES)
    for (size_t k = begin; k < end; k++) {
        rsv_transport_row row = rsv_transport_row_at(t, k);
        for (size_t f = 0; f < fields; f++)
            irradiance[k * fields + f] =
                rgb_scale(sum_row(&row, fields, exitance + f), t->scale[k]);
    }
}

void rsv_transport_apply(const rsv_transport *t, const rsv_rgb *exitance, rsv_rgb *irradiance)
{
    rsv_gather_by_rows(t, 1, exitance, 0, t->row_count, irradiance);
    rsv_division_share(t->division, irradiance, sizeof *irradiance);
}

static void add_row(
    const rsv_transport_row *row, size_t fields, const rsv_rgb *exitance, double sum[3])
{
    for (size_t k = 0; k < row->count; k++) {
        rsv_rgb b = exitance[row->column[k] * fields];
        sum[0] += (double)b.r, sum[1] += (double)b.g, sum[2] += (double)b.b;
    }
    for (size_t k = 0; k < row->tinted_count; k++) {
        rsv_rgb b = exitance[row->tinted_column[k] * fields], w = row->tinted_weight[k];
        sum[0] += (double)b.r * w.r, sum[1] += (double)b.g * w.g, sum[2] += (double)b.b * w.b;
    }
}

void rsv_residual_by_rows(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual)
{
#pragma omp parallel for schedule(dynamic, 64)                                                     \
    num_threads(rsv_threads(t->context)) if (rsv_transport_entries(t) * fields > PARALLEL_ENTRIES)
    for (size_t n = 0; n < t->row_count; n++) {
        double scale = t->scale[n];
        rsv_transport_row row = rsv_transport_row_at(t, n);
        for (size_t f = 0; f < fields; f++) {
            size_t k = n * fields + f;
            double sum[3] = { 0, 0, 0 };
            add_row(&row, fields, exitance + f, sum);
            residual[k] = rgb((float)(source[k].r + sum[0] * scale - irradiance[k].r),
                (float)(source[k].g + sum[1] * scale - irradiance[k].g),
                (float)(source[k].b + sum[2] * scale - irradiance[k].b));
        }
    }
}

void rsv_transport_environment(
    const rsv_transport *transport, const rsv_rgb *bin_radiance, rsv_rgb *irradiance)
{
    const rsv_transport *t = transport;
#pragma omp parallel for schedule(static) num_threads(rsv_threads(t->context))
    for (size_t row = 0; row < t->row_count; row++) {
        rsv_rgb sum = rsv_escapes_sum(&t->escapes, row, bin_radiance);
        irradiance[row] = rgb_scale(sum, RSV_PI * t->scale[row]);
    }
    rsv_division_share(t->division, irradiance, sizeof *irradiance);
}

void rsv_transport_deviation(const rsv_transport *transport, const rsv_rgb *exitance,
    const rsv_rgb *bin_radiance, float *deviation)
{
    const rsv_transport *t = transport;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(t->context))
    for (size_t row = 0; row < t->row_count; row++) {
        float sum = 0, squares = 0;
        rsv_transport_row entry = rsv_transport_row_at(t, row);
        for (size_t k = 0; k < entry.count; k++) {
            float luminance = rgb_luminance(exitance[entry.column[k]]);
            sum += luminance;
            squares += luminance * luminance;
        }
        for (size_t k = 0; k < entry.tinted_count; k++) {
            float luminance =
                rgb_luminance(rgb_mul(entry.tinted_weight[k], exitance[entry.tinted_column[k]]));
            sum += luminance;
            squares += luminance * luminance;
        }
        // radiance of the surroundings against exitance of surfaces
        sum += RSV_PI * rgb_luminance(rsv_escapes_sum(&t->escapes, row, bin_radiance));
        squares += RSV_PI * RSV_PI * rsv_escapes_sum_squares(&t->escapes, row, bin_radiance);
        float mean = sum * t->scale[row], variance = squares * t->scale[row] - mean * mean;
        deviation[row] = STRATIFIED * sqrtf(f_max(variance, 0) * t->scale[row]);
    }
    rsv_division_share(t->division, deviation, sizeof *deviation);
}
