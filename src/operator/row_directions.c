#include "row_directions.h"

#include "../core/octahedral.h"

#include <string.h>

rsv_status rsv_row_directions_create(
    rsv_context *context, size_t count, size_t most, rsv_row_directions **directions)
{
    rsv_row_directions *d = *directions = rsv_alloc(context, 1, sizeof *d);
    if (!d) return RSV_ERROR_MEMORY;
    d->count = count;
    d->row = rsv_alloc(context, count, sizeof *d->row);
    d->tinted_bin = rsv_reserve(context, most, sizeof *d->tinted_bin);
    d->rays = rsv_alloc(context, RSV_DIRECTION_SETS * RSV_DIRECTION_BINS, sizeof *d->rays);
    return d->row && d->tinted_bin && d->rays ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_row_directions_destroy(rsv_context *context, rsv_row_directions *d)
{
    if (!d) return;
    rsv_free(context, d->row);
    rsv_free(context, d->tinted_bin);
    rsv_free(context, d->rays);
    rsv_free(context, d);
}

void rsv_row_directions_begin(const rsv_directions *table, rsv_row_directions *d)
{
    d->shut_unit = table->count > 1024 ? table->count / 1024 : 1;
    for (size_t set = 0; set < RSV_DIRECTION_SETS; set++)
        for (size_t k = set * table->count; k < (set + 1) * table->count; k++)
            d->rays[set * RSV_DIRECTION_BINS + table->bin[k]]++;
}

static void set_tangent(rsv_vec3 tangent, rsv_row_direction *row)
{
    float x, y;
    rsv_octahedral_from_direction(tangent, &x, &y);
    row->tangent[0] = (uint16_t)(x * UINT16_MAX + 0.5f);
    row->tangent[1] = (uint16_t)(y * UINT16_MAX + 0.5f);
}

rsv_vec3 rsv_row_direction_tangent(const rsv_row_direction *row)
{
    const float scale = 1.0f / UINT16_MAX;
    return rsv_octahedral_to_direction(
        (float)row->tangent[0] * scale, (float)row->tangent[1] * scale);
}

void rsv_row_directions_note(const rsv_directions *table, size_t first, const rsv_row_scratch *s,
    uint32_t shut_unit, rsv_row_direction *row)
{
    uint32_t shut[RSV_DIRECTION_BINS] = { 0 };
    *row = (rsv_row_direction){ .set = (uint8_t)(first / table->count) };
    set_tangent(s->tangent, row);
    for (uint32_t ray = 0; ray < table->count; ray++) {
        uint8_t bin = table->bin[first + ray];
        row->ends[bin] = (uint8_t)(row->ends[bin] + (s->column[ray] != RSV_NONE));
        shut[bin] += s->whole && s->copies[ray] == 0;
    }
    for (uint32_t bin = 0; bin < RSV_DIRECTION_BINS; bin++) {
        uint32_t units = (shut[bin] + shut_unit / 2) / shut_unit;
        units = units < 15 ? units : 15;
        row->shut[bin / 2] = (uint8_t)(row->shut[bin / 2] | units << 4 * (bin & 1));
    }
}
