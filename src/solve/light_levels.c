/// Levels of direct light and caustics for sources that stand elsewhere.
#include "../core/parallel.h"
#include "light_internal.h"
#include "source.h"

#include <math.h>

enum { FINE = 2, CAUSTIC = 3 }; // fields of a part

/// A value of coarser elements where a node of finer ones is.
static rsv_rgb value_at(
    const rsv_elements *coarser, const rsv_rgb *value, const rsv_elements *finer, uint32_t node)
{
    uint32_t face;
    float u, v, w[3];
    rsv_elements_place_node(finer, node, &face, &u, &v); // a little off
    uint32_t cell = rsv_elements_locate(coarser, face, u, v, w);
    uint32_t own = finer->support[finer->support_begin[node]] / 4;
    float parts = exp2f((float)(finer->cell[own].level - coarser->cell[cell].level));
    const uint32_t *corner = coarser->cell_node[cell];
    rsv_rgb sum = rgb_gray(0);
    for (int k = 0; k < 3; k++) {
        float weight = roundf(w[k] * parts) / parts;
        if (weight > 0) sum = rgb_mad(sum, weight, value[corner[k]]);
    }
    return sum;
}

typedef struct carry_job {
    const rsv_elements *coarser, *finer;
    const rsv_rgb *value;
    rsv_rgb *carried;
} carry_job;

static void carry_nodes(void *data, rsv_span span)
{
    const carry_job *job = data;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->carried[n] = value_at(job->coarser, job->value, job->finer, n);
}

/// @param field of coarser elements; out: of finer ones
static rsv_status carry_over(
    const rsv_elements *coarser, const rsv_elements *finer, rsv_rgb **field)
{
    if (!*field) return RSV_OK;
    rsv_rgb *carried = rsv_alloc(finer->context, finer->node_count, sizeof *carried);
    if (!carried) return RSV_ERROR_MEMORY;
    carry_job job = { coarser, finer, *field, carried };
    rsv_parallel_for(finer->context, finer->node_count, 0, carry_nodes, &job);
    rsv_free(finer->context, *field);
    *field = carried;
    return RSV_OK;
}

/// Puts a finer level in the place of the former.
static rsv_status replace(rsv_source_level *level, rsv_source_level *finer, size_t field,
    rsv_light_part *const *part, size_t part_count)
{
    rsv_status status;
    for (size_t k = 0; k < part_count; k++)
        RSV_TRY(carry_over(level->elements, finer->elements, rsv_light_part_field(part[k], field)));
    RSV_TRY(carry_over(level->elements, finer->elements, &level->direct));
    RSV_TRY(carry_over(level->elements, finer->elements, &level->caustic));
    rsv_free(finer->elements->context, level->deviation);
    rsv_free(finer->elements->context, level->valid_points);
    level->deviation = NULL;
    level->valid_points = NULL;
    rsv_elements_destroy(level->elements);
    level->elements = finer->elements;
    finer->elements = NULL;
cleanup:
    return status;
}

static rsv_status refine(rsv_light *s, const rsv_level_limits *limits, size_t field,
    rsv_light_part *const *part, size_t part_count)
{
    rsv_source_level finer = { 0 }, *level = field == FINE ? &s->field.fine : &s->field.caustics;
    if (!level->elements) return RSV_OK;
    rsv_status status = rsv_source_refine_level(s, limits, field == CAUSTIC, &finer);
    if (status == RSV_OK && finer.elements->cell_count > level->elements->cell_count)
        status = replace(level, &finer, field, part, part_count);
    rsv_source_level_destroy(s->context, &finer);
    return status;
}

rsv_status rsv_light_refine_levels(rsv_light *s, rsv_light_part *const *part, size_t part_count)
{
    rsv_status status;
    uint8_t *hidden = NULL;
    RSV_TRY(rsv_source_hidden_cells(s, &hidden));
    const rsv_level_limits limits = { SIZE_MAX, hidden };
    RSV_TRY(refine(s, &limits, FINE, part, part_count));
    RSV_TRY(refine(s, &limits, CAUSTIC, part, part_count));
cleanup:
    rsv_free(s->context, hidden);
    rsv_light_publish(s);
    return status;
}
