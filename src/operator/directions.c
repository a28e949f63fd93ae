#include "directions.h"

#include "../core/hemisphere.h"

/// Writes one randomised net, grouped by cells of 2^across x 2^down, 16 points each.
static void fill_set(const rsv_directions *d, uint32_t set, uint32_t seed, uint32_t *filled)
{
    uint32_t cells = d->count / 16, across = 1;
    while (across * across < cells)
        across *= 2;
    uint32_t down = cells / across;
    for (uint32_t c = 0; c < cells; c++)
        filled[c] = 0;
    for (uint32_t n = 0; n < d->count; n++) {
        float x, y;
        rsv_sobol_2d(n, rsv_hash2(seed, set), &x, &y);
        uint32_t cell = (uint32_t)(y * (float)down) * across + (uint32_t)(x * (float)across);
        // within its cell a direction goes to a random lane: lanes are places on the receiver
        uint32_t lane = (filled[cell]++ + rsv_hash3(seed, set, cell)) & 15;
        size_t at = (size_t)set * d->count + cell * 16 + lane;
        rsv_vec3 direction = rsv_square_to_cosine_hemisphere(x, y);
        d->x[at] = direction.x;
        d->y[at] = direction.y;
        d->z[at] = direction.z;
    }
}

/// Sorts a set by bins, within a bin by number.
static void sort_set(const rsv_directions *d, uint32_t set)
{
    size_t first = (size_t)set * d->count;
    uint32_t begin[RSV_DIRECTION_BINS + 1] = { 0 };
    for (size_t k = first; k < first + d->count; k++) {
        d->bin[k] = (uint8_t)rsv_hemisphere_cell(v3(d->x[k], d->y[k], d->z[k]), RSV_DIRECTION_SIDE);
        begin[d->bin[k] + 1]++;
    }
    for (uint32_t bin = 0; bin < RSV_DIRECTION_BINS; bin++)
        begin[bin + 1] += begin[bin];
    for (uint32_t n = 0; n < d->count; n++)
        d->sorted[first + begin[d->bin[first + n]]++] = (uint16_t)n;
}

rsv_status rsv_directions_create(
    rsv_context *context, uint32_t count, uint32_t seed, rsv_directions *directions)
{
    size_t total = (size_t)RSV_DIRECTION_SETS * count;
    *directions = (rsv_directions){ .context = context, .count = count };
    directions->x = rsv_alloc(context, total, sizeof(float));
    directions->y = rsv_alloc(context, total, sizeof(float));
    directions->z = rsv_alloc(context, total, sizeof(float));
    directions->bin = rsv_alloc(context, total, sizeof *directions->bin);
    directions->sorted = rsv_alloc(context, total, sizeof *directions->sorted);
    uint32_t *filled = rsv_alloc(context, count / 16, sizeof *filled);
    rsv_status status = RSV_ERROR_MEMORY;
    if (directions->x && directions->y && directions->z && directions->bin && directions->sorted &&
        filled) {
        for (uint32_t set = 0; set < RSV_DIRECTION_SETS; set++) {
            fill_set(directions, set, seed, filled);
            sort_set(directions, set);
        }
        status = RSV_OK;
    }
    rsv_free(context, filled);
    if (status != RSV_OK) rsv_directions_destroy(directions);
    return status;
}

void rsv_directions_destroy(rsv_directions *directions)
{
    if (!directions->context) return;
    rsv_free(directions->context, directions->x);
    rsv_free(directions->context, directions->y);
    rsv_free(directions->context, directions->z);
    rsv_free(directions->context, directions->bin);
    rsv_free(directions->context, directions->sorted);
    *directions = (rsv_directions){ 0 };
}
