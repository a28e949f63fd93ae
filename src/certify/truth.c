#include "../solve/light.h"
#include "moments.h"
#include "point_density.h"
#include "resolvent/certify.h"
#include "resolvent/render.h"

/// Separates the points from those of certificates of the same seed.
#define SEED_OF_TRUTH 0x3c6ef372u

struct rsv_truth {
    rsv_context *context;
    size_t count;
    rsv_face_point *point;    ///< [count]
    double *weight;           ///< [count] of the points
    rsv_surface_place *place; ///< [count]
    rsv_probe_reading *reading[2];
};

static rsv_status place_points(
    const rsv_light_view *s, uint32_t points, uint32_t seed, rsv_truth *truth)
{
    const rsv_elements *e = s->elements;
    rsv_point_density density = { 0 };
    uint64_t rays = 0;
    rsv_status status = rsv_point_density_of_light(s, &density);
    rsv_visible_surface visible = rsv_visible_surface_of(&s->scene, e);
    for (uint32_t k = 0; k < points && e->face_count > 0 && status == RSV_OK; k++) {
        double weight;
        rsv_face_point p = rsv_point_density_draw(&density, k, points, seed, &weight);
        uint32_t stream = rsv_hash3(seed, k, 1);
        if (rsv_point_is_buried(&visible, &p, stream, &rays)) continue;
        truth->point[truth->count] = p;
        truth->weight[truth->count] = weight;
        truth->place[truth->count++] = (rsv_surface_place){ e->face_triangle[p.face], p.u, p.v,
            e->face_back[p.face], rsv_point_width(s, &p) };
    }
    rsv_point_density_destroy(&density);
    return status;
}

rsv_status rsv_truth_create(
    const rsv_light *light, uint32_t points, uint32_t paths, uint32_t seed, rsv_truth **result)
{
    const rsv_light_view *s = rsv_light_get_view(light);
    rsv_context *context = s->context;
    if (points < 16 || points > 1u << 24)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "truth: points is %u; it must be 16 to %u", points, 1u << 24);
    rsv_truth *truth = rsv_alloc(context, 1, sizeof *truth);
    if (!truth) return RSV_ERROR_MEMORY;
    rsv_status status = RSV_ERROR_MEMORY;
    truth->context = context;
    truth->point = rsv_alloc(context, points, sizeof *truth->point);
    truth->weight = rsv_alloc(context, points, sizeof *truth->weight);
    truth->place = rsv_alloc(context, points, sizeof *truth->place);
    truth->reading[0] = rsv_alloc(context, points, sizeof *truth->reading[0]);
    truth->reading[1] = rsv_alloc(context, points, sizeof *truth->reading[1]);
    if (!truth->point || !truth->weight || !truth->place || !truth->reading[0] ||
        !truth->reading[1])
        goto cleanup;
    seed = rsv_hash2(seed, SEED_OF_TRUTH);
    RSV_TRY(place_points(s, points, seed, truth));
    for (uint32_t half = 0; half < 2; half++)
        RSV_TRY(rsv_surface_reference(s->scene.scene, truth->place, truth->count, paths,
            rsv_hash2(seed, 1 + half), truth->reading[half]));
    *result = truth;
    truth = NULL;
cleanup:
    rsv_truth_destroy(truth);
    return status;
}

void rsv_truth_destroy(rsv_truth *truth)
{
    if (!truth) return;
    rsv_free(truth->context, truth->point);
    rsv_free(truth->context, truth->weight);
    rsv_free(truth->context, truth->place);
    rsv_free(truth->context, truth->reading[0]);
    rsv_free(truth->context, truth->reading[1]);
    rsv_free(truth->context, truth);
}

rsv_status rsv_truth_error(
    const rsv_truth *truth, const rsv_light *light, double *error_rms, double ci95[2])
{
    const rsv_light_view *s = rsv_light_get_view(light);
    const rsv_elements *e = s->elements;
    double *product = rsv_alloc(truth->context, truth->count, sizeof *product);
    if (!product) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < truth->count; k++) {
        const rsv_face_point *p = &truth->point[k];
        rsv_rgb stored = rsv_light_view_irradiance(
            s, e->face_triangle[p->face], p->u, p->v, e->face_back[p->face], RSV_NONE);
        rsv_rgb error[2] = { rgb_sub(truth->reading[0][k].irradiance, stored),
            rgb_sub(truth->reading[1][k].irradiance, stored) };
        product[k] = (double)rgb_luminance(error[0]) * (double)rgb_luminance(error[1]);
    }
    rsv_moments error =
        rsv_moments_root(rsv_moments_by_weight(product, truth->weight, truth->count));
    rsv_free(truth->context, product);
    *error_rms = error.mean;
    ci95[0] = error.ci95[0], ci95[1] = error.ci95[1];
    return RSV_OK;
}
