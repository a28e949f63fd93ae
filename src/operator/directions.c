#include "directions.h"

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

rsv_status rsv_directions_create(
    rsv_context *context, uint32_t count, uint32_t seed, rsv_directions *directions)
{
    size_t total = (size_t)RSV_DIRECTION_SETS * count;
    *directions = (rsv_directions){ .context = context, .count = count };
    directions->x = rsv_alloc(context, total, sizeof(float));
    directions->y = rsv_alloc(context, total, sizeof(float));
    directions->z = rsv_alloc(context, total, sizeof(float));
    uint32_t *filled = rsv_alloc(context, count / 16, sizeof *filled);
    rsv_status status = RSV_ERROR_MEMORY;
    if (directions->x && directions->y && directions->z && filled) {
        for (uint32_t set = 0; set < RSV_DIRECTION_SETS; set++)
            fill_set(directions, set, seed, filled);
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
    *directions = (rsv_directions){ 0 };
}
