/// The assembled operator: products with fields, and how far its rows scatter.
#include "../core/parallel.h"
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

static void gather_rows(void *job, rsv_span span)
{
    const rsv_row_product p = *(const rsv_row_product *)job;
    const rsv_transport *t = p.transport;
    for (size_t k = p.begin + span.begin; k < p.begin + span.end; k++) {
        rsv_transport_row row = rsv_transport_row_at(t, k);
        for (size_t f = 0; f < p.fields; f++)
            p.irradiance[k * p.fields + f] =
                rgb_scale(sum_row(&row, p.fields, p.exitance + f), t->scale[k]);
    }
}

void rsv_gather_by_rows(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance)
{
    rsv_row_product p = { t, fields, exitance, begin, irradiance };
    size_t grain = rsv_transport_entries(t) * fields > PARALLEL_ENTRIES ? 256 : end - begin;
    rsv_parallel_for(t->context, end - begin, grain, gather_rows, &p);
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

typedef struct residual_job {
    const rsv_transport *transport;
    size_t fields;
    const rsv_rgb *exitance, *source, *irradiance;
    rsv_rgb *residual;
} residual_job;

static void subtract_rows(void *job, rsv_span span)
{
    const residual_job r = *(const residual_job *)job;
    for (size_t n = span.begin; n < span.end; n++) {
        double scale = r.transport->scale[n];
        rsv_transport_row row = rsv_transport_row_at(r.transport, n);
        for (size_t f = 0; f < r.fields; f++) {
            size_t k = n * r.fields + f;
            double sum[3] = { 0, 0, 0 };
            add_row(&row, r.fields, r.exitance + f, sum);
            r.residual[k] = rgb((float)(r.source[k].r + sum[0] * scale - r.irradiance[k].r),
                (float)(r.source[k].g + sum[1] * scale - r.irradiance[k].g),
                (float)(r.source[k].b + sum[2] * scale - r.irradiance[k].b));
        }
    }
}

void rsv_residual_by_rows(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual)
{
    residual_job r = { t, fields, exitance, source, irradiance, residual };
    size_t grain = rsv_transport_entries(t) * fields > PARALLEL_ENTRIES ? 64 : t->row_count;
    rsv_parallel_for(t->context, t->row_count, grain, subtract_rows, &r);
}

typedef struct environment_job {
    const rsv_transport *transport;
    const rsv_rgb *bin_radiance;
    rsv_rgb *irradiance;
} environment_job;

static void gather_environment(void *job, rsv_span span)
{
    const environment_job *g = job;
    const rsv_transport *t = g->transport;
    for (size_t row = span.begin; row < span.end; row++) {
        rsv_rgb sum = rsv_escapes_sum(&t->escapes, row, g->bin_radiance);
        g->irradiance[row] = rgb_scale(sum, RSV_PI * t->scale[row]);
    }
}

void rsv_transport_environment(
    const rsv_transport *transport, const rsv_rgb *bin_radiance, rsv_rgb *irradiance)
{
    environment_job g = { transport, bin_radiance, irradiance };
    rsv_parallel_for(transport->context, transport->row_count, 0, gather_environment, &g);
    rsv_division_share(transport->division, irradiance, sizeof *irradiance);
}

typedef struct deviation_job {
    const rsv_transport *transport;
    const rsv_rgb *exitance, *bin_radiance;
    float *deviation;
} deviation_job;

static void measure_deviations(void *job, rsv_span span)
{
    const deviation_job *d = job;
    const rsv_transport *t = d->transport;
    const rsv_rgb *exitance = d->exitance, *bin_radiance = d->bin_radiance;
    for (size_t row = span.begin; row < span.end; row++) {
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
        d->deviation[row] = STRATIFIED * sqrtf(f_max(variance, 0) * t->scale[row]);
    }
}

void rsv_transport_deviation(const rsv_transport *transport, const rsv_rgb *exitance,
    const rsv_rgb *bin_radiance, float *deviation)
{
    deviation_job d = { transport, exitance, bin_radiance, deviation };
    rsv_parallel_for(transport->context, transport->row_count, 256, measure_deviations, &d);
    rsv_division_share(transport->division, deviation, sizeof *deviation);
}
