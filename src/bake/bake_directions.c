#include "bake_directions.h"

#include "../core/parallel.h"
#include "../render/probe_gather.h"
#include "bake_constants.h"

/// A point of the node's support that is not buried. @return false where there is none
static bool find_place(const rsv_light_view *s, uint32_t node, rsv_surface_point *place)
{
    const rsv_elements *e = s->elements;
    uint16_t valid = s->valid_points[node];
    if (!valid || e->node_hanging[node] != RSV_NONE || e->node_face[node] == RSV_NONE) return false;
    rsv_support_point points[RSV_SUPPORT_POINTS];
    rsv_elements_sample_support(e, node, RSV_SUPPORT_POINTS, s->desc.seed, points);
    const rsv_support_point *p = &points[__builtin_ctz(valid)];
    uint32_t face = e->cell[p->support / 4].face;
    *place = rsv_surface_point_at(e->scene, e->face_triangle[face], p->u, p->v, e->face_back[face]);
    return true;
}

/// Shortens a channel's d where the surface's own normal reads next to nothing.
static void limit(float *x, float *y, float *z)
{
    float length = sqrtf(*x * *x + *y * *y + *z * *z);
    float scale = length > LONGEST ? LONGEST / length : 1;
    *x *= scale, *y *= scale, *z *= scale;
}

/// Least squares for E(m) = E (1 + cos TILT + sin TILT d . t) / 2, with t the tangents towards which m tilts.
/// @param e irradiance for the surface's own normal
static void fit(
    rsv_rgb e, const rsv_vec3 tangent[TILTS], const rsv_rgb reading[TILTS], rsv_rgb d[3])
{
    float scale = 4 / (TILTS * sinf(TILT));
    rsv_rgb per_light =
        rgb(e.r > 0 ? scale / e.r : 0, e.g > 0 ? scale / e.g : 0, e.b > 0 ? scale / e.b : 0);
    for (int a = 0; a < 3; a++)
        d[a] = rgb_gray(0);
    for (int k = 0; k < TILTS; k++) {
        d[0] = rgb_mad(d[0], tangent[k].x, rgb_mul(per_light, reading[k]));
        d[1] = rgb_mad(d[1], tangent[k].y, rgb_mul(per_light, reading[k]));
        d[2] = rgb_mad(d[2], tangent[k].z, rgb_mul(per_light, reading[k]));
    }
    limit(&d[0].r, &d[1].r, &d[2].r);
    limit(&d[0].g, &d[1].g, &d[2].g);
    limit(&d[0].b, &d[1].b, &d[2].b);
}

static void read_node(
    const rsv_probe_job *job, uint32_t node, const rsv_surface_point *place, rsv_rgb d[3])
{
    rsv_vec3 x, y, tangent[TILTS];
    rsv_rgb reading[TILTS];
    v3_frame(place->normal, &x, &y);
    for (int k = 0; k < TILTS; k++) {
        float turn = 2 * RSV_PI * (float)k / TILTS;
        tangent[k] = v3_mad(v3_scale(x, cosf(turn)), sinf(turn), y);
        const rsv_probe probe = { place->position,
            v3_mad(v3_scale(place->normal, cosf(TILT)), sinf(TILT), tangent[k]) };
        reading[k] = rsv_probe_read(job, &probe, node).irradiance;
    }
    const rsv_probe upright = { place->position, place->normal };
    fit(rsv_probe_read(job, &upright, node).irradiance, tangent, reading, d);
}

/// All nodes read.
typedef struct directions_job {
    const rsv_light_view *light;
    rsv_probe_job probe;
    rsv_rgb *const *axis; ///< [3][node_count] out
    atomic_size_t done;   ///< nodes
} directions_job;

static void read_span(void *data, rsv_span span)
{
    directions_job *job = data;
    const rsv_light_view *s = job->light;
    for (size_t n = span.begin; n < span.end; n++) {
        rsv_surface_point place;
        rsv_rgb d[3] = { 0 };
        if (rsv_cancelled(s->context)) return;
        if (find_place(s, (uint32_t)n, &place)) read_node(&job->probe, (uint32_t)n, &place, d);
        for (int a = 0; a < 3; a++)
            job->axis[a][n] = d[a];
        rsv_item_done(
            s->context, "directions", span.worker, &job->done, s->elements->node_count);
    }
}

static rsv_status read_nodes(const rsv_light_view *s, rsv_rgb *const axis[3])
{
    directions_job job = { s, rsv_probe_job_of(s, TILT_SAMPLES, s->desc.seed, true), axis, 0 };
    rsv_parallel_for(s->context, s->elements->node_count, 16, read_span, &job);
    return rsv_progress(s->context, "directions", 1);
}

rsv_status rsv_bake_directions_create(const rsv_light_view *solution, rsv_bake_directions *d)
{
    rsv_status status;
    size_t count = solution->elements->node_count;
    rsv_rgb *noisy[3] = { NULL };
    *d = (rsv_bake_directions){ .solution = solution };
    for (int a = 0; a < 3; a++) {
        noisy[a] = rsv_alloc(solution->context, count, sizeof *noisy[a]);
        d->axis[a] = rsv_alloc(solution->context, count, sizeof *d->axis[a]);
        RSV_TRY(noisy[a] && d->axis[a] ? RSV_OK : RSV_ERROR_MEMORY);
    }
    RSV_TRY(read_nodes(solution, noisy));
    for (int a = 0; a < 3; a++) {
        rsv_elements_constrain(solution->elements, noisy[a]);
        rsv_elements_average(solution->elements, noisy[a], d->axis[a]);
        rsv_elements_constrain(solution->elements, d->axis[a]);
    }
cleanup:
    for (int a = 0; a < 3; a++)
        rsv_free(solution->context, noisy[a]);
    return status;
}

void rsv_bake_directions_destroy(rsv_bake_directions *d)
{
    for (int a = 0; a < 3; a++)
        rsv_free(d->solution->context, d->axis[a]);
    *d = (rsv_bake_directions){ 0 };
}

void rsv_bake_directions_at(
    const rsv_bake_directions *directions, const rsv_bake_receiver *r, rsv_rgb out[3])
{
    const rsv_light_view *s = directions->solution;
    for (int a = 0; a < 3; a++)
        out[a] = rgb_gray(0);
    if (r->triangle == RSV_NONE) return;
    rsv_surface_point point = rsv_surface_point_at(s->scene.view, r->triangle, r->u, r->v, r->back);
    const float normal[3] = { point.normal.x, point.normal.y, point.normal.z };
    uint32_t face = s->elements->face_of[r->back][r->triangle];
    for (int a = 0; a < 3; a++) {
        out[a] = rgb_gray(normal[a]);
        if (face != RSV_NONE)
            out[a] = rgb_add(out[a],
                rsv_elements_interpolate(s->elements, directions->axis[a], face, r->u, r->v));
    }
}
