#include "sharpen.h"

#include "../core/parallel.h"
#include "solve_constants.h"

#include <string.h>

typedef struct luminance_range {
    float low, high;
} luminance_range;

/// Luminance of a node and its neighbours.
static luminance_range range_around(const rsv_elements *e, const rsv_rgb *value, size_t node)
{
    float own = rgb_luminance(value[node]);
    luminance_range range = { own, own };
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        for (int k = 0; k < 3; k++) {
            float luminance = rgb_luminance(value[e->cell_node[e->support[s] / 4][k]]);
            range.low = f_min(range.low, luminance);
            range.high = f_max(range.high, luminance);
        }
    }
    return range;
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
        luminance_range range = range_around(e, value, n);
        rsv_rgb sharp = rgb_sub(rgb_scale(once[n], 3), rgb_scale(twice[n], 2));
        float luminance = rgb_luminance(sharp);
        bool smooth = range.high <= SMOOTH_CONTRAST * range.low && luminance >= range.low &&
                      luminance <= range.high;
        once[n] = smooth ? sharp : value[n]; // `once` is free as soon as it is read
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
