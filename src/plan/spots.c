#include "spots.h"

#include "../core/sampling.h"

#include <math.h>
#include <string.h>

static uint32_t at_most(double value, uint32_t most)
{
    return value < most ? (uint32_t)value : most;
}

/// A pixel of block `index` of `blocks` along a side.
static size_t place(uint32_t index, uint32_t blocks, uint32_t side, uint32_t random)
{
    double unit = (double)rsv_unit_float(random);
    return at_most((index + unit) * side / blocks, side - 1);
}

void rsv_choose_spots(uint32_t width, uint32_t height, uint32_t number, uint32_t seed,
    uint32_t samples, uint32_t *count)
{
    double edge = sqrt((double)width * height / number);
    uint32_t columns = at_most(ceil(width / edge), width);
    uint32_t rows = at_most(ceil(height / edge), height);
    memset(count, 0, (size_t)width * height * sizeof *count);
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t random = rsv_hash3(seed, i, j);
            size_t x = place(i, columns, width, random);
            size_t y = place(j, rows, height, rsv_hash(random));
            count[y * width + x] = samples;
        }
}
