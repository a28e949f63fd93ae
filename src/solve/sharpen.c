#include "sharpen.h"

#include "../core/parallel.h"
#include "solve_constants.h"

#include <string.h>

typedef struct value_range {
    rsv_rgb low, high;
} value_range;

/// Values of a node and its neighbours.
static value_range range_around(const rsv_elements *e, const rsv_rgb *value, size_t node)
{
    value_range range = { value[node], value[node] };
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        for (int k = 0; k < 3; k++) {
            rsv_rgb near = value[e->cell_node[e->support[s] / 4][k]];
            range.low = rgb(
                f_min(range.low.r, near.r), f_min(range.low.g, near.g), f_min(range.low.b, near.b));
            range.high = rgb(f_max(range.high.r, near.r), f_max(range.high.g, near.g),
                f_max(range.high.b, near.b));
        }
    }
    return range;
}

/// `sharp` where a channel is smooth, else `value`.
static float choose(float value, float sharp, float low, float high)
{
    bool smooth = high <= SMOOTH_CONTRAST * low && sharp >= low && sharp <= high;
    return smooth ? sharp : value;
}

typedef struct sharpen_job {
    const rsv_elements *elements;
    const rsv_rgb *value, *twice;
    rsv_rgb *once; ///< in: averaged once; out: the sharp field
} sharpen_job;

static void sharpen_nodes(void *data, rsv_span span)
{
    const sharpen_job job = *(const sharpen_job *)data;
    const rsv_elements *e = job.elements;
    const rsv_rgb *value = job.value, *twice = job.twice;
    rsv_rgb *once = job.once;
    for (size_t n = span.begin; n < span.end; n++) {
        if (e->node_hanging[n] != RSV_NONE) continue; // constrained below
        value_range range = range_around(e, value, n);
        rsv_rgb low = range.low, high = range.high;
        rsv_rgb sharp = rgb_sub(rgb_scale(once[n], 3), rgb_scale(twice[n], 2));
        // lights of different colours have edges in different places; `once` is free as soon as it is read
        once[n] = rgb(choose(value[n].r, sharp.r, low.r, high.r),
            choose(value[n].g, sharp.g, low.g, high.g), choose(value[n].b, sharp.b, low.b, high.b));
    }
}

void rsv_sharpen(const rsv_elements *e, rsv_rgb *value, rsv_rgb *once, rsv_rgb *twice)
{
    rsv_elements_average(e, value, once);
    rsv_elements_average(e, once, twice);
    sharpen_job job = { e, value, twice, once };
    rsv_parallel_for(e->context, e->node_count, 0, sharpen_nodes, &job);
    memcpy(value, once, e->node_count * sizeof *value);
    rsv_elements_constrain(e, value);
}
