#include "../core/parallel.h"
#include "../solve/light.h"
#include "moments.h"
#include "point_density.h"
#include "resolvent/certify.h"

/// Points at which two solutions are compared: lookups cost next to nothing.
#define POINTS 50000
#define OTHER_SEED 0x6a09e667u

static double luminance_at(const rsv_light_view *s, const rsv_face_point *p)
{
    rsv_rgb e = rgb_add(rsv_light_view_direct(s, p->face, p->u, p->v, !s->desc.direct_level),
        rsv_elements_interpolate(s->elements, s->indirect, p->face, p->u, p->v));
    return (double)rgb_luminance(e);
}

/// Two solutions, compared at drawn points.
typedef struct comparison {
    const rsv_light_view *a, *b;
    rsv_point_density density;
    rsv_visible_surface visible;
    double *square, *weight; ///< [POINTS] out; weight 0 = buried
} comparison;

static void compare_at_points(void *data, rsv_span span)
{
    const comparison *c = data;
    for (uint32_t k = (uint32_t)span.begin; k < span.end; k++) {
        uint64_t rays = 0;
        double *weight = &c->weight[k];
        rsv_face_point p = rsv_point_density_draw(&c->density, k, POINTS, OTHER_SEED, weight);
        if (rsv_point_is_buried(&c->visible, &p, k, &rays)) *weight = 0;
        double difference = luminance_at(c->a, &p) - luminance_at(c->b, &p);
        c->square[k] = *weight > 0 ? difference * difference : 0;
    }
}

/// Mean square of the difference of two solutions of one scene.
static rsv_status mean_squared_difference(
    const rsv_light_view *a, const rsv_light_view *b, double *mean)
{
    rsv_context *context = a->context;
    comparison c = { .a = a, .b = b };
    rsv_status status = RSV_ERROR_MEMORY;
    c.square = rsv_alloc(context, POINTS, sizeof *c.square);
    c.weight = rsv_alloc(context, POINTS, sizeof *c.weight);
    if (!c.square || !c.weight) goto cleanup;
    RSV_TRY(rsv_point_density_of_light(a, &c.density));
    c.visible = rsv_visible_surface_of(&a->scene, a->elements);
    rsv_parallel_for(context, POINTS, 256, compare_at_points, &c);
    *mean = rsv_moments_by_weight(c.square, c.weight, POINTS).mean;
cleanup:
    rsv_point_density_destroy(&c.density);
    rsv_free(context, c.square);
    rsv_free(context, c.weight);
    return status;
}

rsv_status rsv_split_error(
    const rsv_light *light, const rsv_certificate *certificate, rsv_error_split *split)
{
    const rsv_light_view *s = rsv_light_get_view(light);
    rsv_light *other = NULL;
    rsv_solve_desc desc = s->desc;
    double difference, error = certificate->error_estimate_rms;
    rsv_status status = RSV_OK;
    *split = (rsv_error_split){ .truncation = fmin(s->report.truncation_bound, error) };
    if (s->elements->face_count == 0) return RSV_OK;
    desc.seed = rsv_hash2(desc.seed, OTHER_SEED);
    desc.checkpoint = desc.earlier = NULL; // they are of the other seed
    RSV_TRY(rsv_light_create(s->scene.scene, &desc, &other));
    RSV_TRY(mean_squared_difference(s, rsv_light_get_view(other), &difference));
    double rest = error * error - split->truncation * split->truncation;
    split->sampling = sqrt(fmin(difference / 2, rest));
    split->discretisation = sqrt(fmax(rest - difference / 2, 0));
cleanup:
    rsv_light_destroy(other);
    return status;
}
