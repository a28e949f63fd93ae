/// Solved light at many points. A lookup mostly waits for memory, so the points of a block go through each step
/// together, and data for the next step is prefetched.
#include "../core/parallel.h"
#include "light.h"

#include <math.h>
#include <string.h>

#define BLOCK 32
#define MAX_TERMS 4

/// A field on the elements of one level; several fields share the places found there.
typedef struct term {
    int level;
    const rsv_rgb *value; ///< [node_count]
} term;

/// The sum of a lookup, in the order of rsv_light_view_irradiance, so that sums are equal to the last bit.
typedef struct lookup {
    const rsv_elements *coarse; ///< whose faces all levels share
    const rsv_elements *level[3];
    term term[MAX_TERMS];
    int level_count, term_count;
} lookup;

static void add_term(lookup *l, const rsv_elements *elements, const rsv_rgb *value)
{
    int level = 0;
    while (level < l->level_count && l->level[level] != elements)
        level++;
    if (level == l->level_count) l->level[l->level_count++] = elements;
    l->term[l->term_count++] = (term){ level, value };
}

static lookup plan_lookup(const rsv_light_view *s, uint32_t order)
{
    lookup l = { .coarse = s->elements };
    if (order != RSV_NONE && order > 0) {
        if (order < s->order_count) add_term(&l, s->elements, s->order[order]);
        return l;
    }
    if (s->fine.direct) {
        add_term(&l, s->elements, s->gathered);
        if (s->caustics.caustic) add_term(&l, s->caustics.elements, s->caustics.caustic);
        add_term(&l, s->fine.elements, s->fine.direct);
    } else {
        add_term(&l, s->elements, s->source);
    }
    if (order == RSV_NONE) add_term(&l, s->elements, s->indirect);
    return l;
}

/// Places of a block's points on one level.
typedef struct places {
    uint32_t cell[BLOCK];
    float weight[BLOCK][3];
} places;

/// Points without a face get no place.
static void locate(const rsv_elements *e, const rsv_triangle_point *points, const uint32_t *face,
    size_t count, places *p)
{
    for (size_t k = 0; k < count; k++)
        if (face[k] != RSV_NONE) __builtin_prefetch(&e->slot[e->face_slot[face[k]]]);
    for (size_t k = 0; k < count; k++) {
        if (face[k] == RSV_NONE) continue;
        p->cell[k] = rsv_elements_locate(e, face[k], points[k].u, points[k].v, p->weight[k]);
        __builtin_prefetch(e->cell_node[p->cell[k]]);
    }
}

static void add_field(const rsv_elements *e, const rsv_rgb *value, const places *p,
    const uint32_t *face, size_t count, rsv_rgb *sum)
{
    for (size_t k = 0; k < count; k++)
        if (face[k] != RSV_NONE) __builtin_prefetch(&value[e->cell_node[p->cell[k]][0]]);
    for (size_t k = 0; k < count; k++) {
        if (face[k] == RSV_NONE) continue;
        const uint32_t *node = e->cell_node[p->cell[k]];
        const float *w = p->weight[k];
        sum[k] =
            rgb_add(sum[k], rgb_mad(rgb_mad(rgb_scale(value[node[0]], w[0]), w[1], value[node[1]]),
                                w[2], value[node[2]]));
    }
}

static void look_up(
    const lookup *l, const rsv_triangle_point *points, size_t count, rsv_rgb *irradiance)
{
    uint32_t face[BLOCK];
    places found[3];
    for (size_t k = 0; k < count; k++)
        face[k] = l->coarse->face_of[points[k].back_side][points[k].triangle];
    for (int k = 0; k < l->level_count; k++)
        locate(l->level[k], points, face, count, &found[k]);
    memset(irradiance, 0, count * sizeof *irradiance);
    for (int k = 0; k < l->term_count; k++) {
        const term *t = &l->term[k];
        add_field(l->level[t->level], t->value, &found[t->level], face, count, irradiance);
    }
}

static rsv_status check_points(
    const rsv_light_view *s, const rsv_triangle_point *points, size_t count)
{
    const size_t triangles = s->scene.view->triangle_count;
    for (size_t k = 0; k < count; k++) {
        if (points[k].triangle >= triangles)
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "irradiance: point %zu is on triangle %u; the scene has %zu triangles", k,
                points[k].triangle, triangles);
        if (!isfinite(points[k].u) || !isfinite(points[k].v))
            return rsv_fail(
                RSV_ERROR_ARGUMENT, "irradiance: u and v of point %zu are not finite", k);
    }
    return RSV_OK;
}

typedef struct points_job {
    const lookup *lookup;
    const rsv_triangle_point *points;
    rsv_rgb *irradiance;
} points_job;

static void look_up_span(void *data, rsv_span span)
{
    const points_job *job = data;
    for (size_t begin = span.begin; begin < span.end; begin += BLOCK) {
        size_t end = begin + BLOCK < span.end ? begin + BLOCK : span.end;
        look_up(job->lookup, job->points + begin, end - begin, job->irradiance + begin);
    }
}

rsv_status rsv_light_irradiance_points(const rsv_light *light, const rsv_triangle_point *points,
    size_t count, uint32_t order, rsv_rgb *irradiance)
{
    const rsv_light_view *s = rsv_light_get_view(light);
    rsv_status status = check_points(s, points, count);
    if (status != RSV_OK) return status;
    const lookup l = plan_lookup(s, order);
    points_job job = { &l, points, irradiance };
    rsv_parallel_for(s->context, count, 0, look_up_span, &job);
    return RSV_OK;
}
