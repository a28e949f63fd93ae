/// <z, r>: the error of one picture or of sensors' mean reading, from residuals where they matter to it.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../solve/goal.h"
#include "moments.h"
#include "point_density.h"
#include "residual.h"
#include "resolvent/certify.h"

#define SEED_OF_GOAL 0x94d049bbu
#define SEED_OF_PHOTONS 0x3f84d5b5u
/// Camera rays in each direction, whose hits are weighted.
#define SIDE 256
/// Part of the points that are spread evenly, lest a spot of no importance on elements have some in truth.
#define EVEN_SHARE 0.1

typedef struct goal_job {
    const rsv_light_view *solution;
    rsv_certify_desc desc;
    uint32_t seed;
    rsv_rgb *importance; ///< [node_count] z per area
    rsv_point_density density;
    rsv_caustic_judge judge; ///< of caustics that no gather ray can find
    rsv_residual_job residual;
    rsv_visible_surface visible;
    double *term; ///< [desc.samples] (z r) / density of the point
} goal_job;

/// Of z in a cell, per area.
static double importance_of(const void *user, uint32_t cell)
{
    const goal_job *job = user;
    const uint32_t *node = job->solution->elements->cell_node[cell];
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        rsv_rgb d = job->importance[node[k]];
        sum += (double)(fabsf(d.r) + fabsf(d.g) + fabsf(d.b));
    }
    return sum / 3;
}

static rsv_face_point draw_point(const goal_job *job, uint32_t k, double *weight)
{
    return rsv_point_density_draw(&job->density, k, job->desc.samples, job->seed, weight);
}

static rsv_status judge_caustics(goal_job *job)
{
    uint64_t rays = 0;
    double weight;
    if (!rsv_has_unseen_caustics(job->solution)) return RSV_OK;
    rsv_status status = rsv_caustic_judge_create(job->solution, &job->judge);
    if (status != RSV_OK) return status;
    for (uint32_t k = 0; k < job->desc.samples; k++) {
        rsv_face_point point = draw_point(job, k, &weight);
        rsv_caustic_judge_add(&job->judge, &point);
    }
    return rsv_caustic_judge_shoot(&job->judge, rsv_hash2(job->seed, SEED_OF_PHOTONS), &rays);
}

static double measure_term(const goal_job *job, uint32_t k)
{
    const rsv_light_view *s = job->solution;
    uint64_t rays = 0;
    uint32_t stream = rsv_hash3(job->seed, k, 0x2ab1u);
    double weight;
    rsv_face_point point = draw_point(job, k, &weight);
    if (rsv_point_is_buried(&job->visible, &point, stream, &rays)) return 0;
    rsv_residual r = rsv_residual_at(&job->residual, &point, stream);
    rsv_rgb z =
        rsv_elements_interpolate(s->elements, job->importance, point.face, point.u, point.v);
    rsv_rgb term = rgb_mul(z, rgb_scale(rgb_add(r.residual[0], r.residual[1]), 0.5f));
    return ((double)term.r + (double)term.g + (double)term.b) * weight * job->density.area;
}

static void measure_span(void *data, rsv_span span)
{
    const goal_job *job = data;
    for (size_t k = span.begin; k < span.end; k++)
        if (!rsv_cancelled(job->solution->context)) job->term[k] = measure_term(job, (uint32_t)k);
}

static rsv_status measure_terms(goal_job *job)
{
    const rsv_light_view *s = job->solution;
    rsv_context *context = s->context;
    job->residual = rsv_residual_job_of(s, job->desc.gather_rays, job->desc.light_samples);
    job->residual.judge = job->judge.solution ? &job->judge : NULL;
    job->visible = rsv_visible_surface_of(&s->scene, s->elements);
    rsv_parallel_for(context, job->desc.samples, 8, measure_span, job);
    for (uint32_t k = 0; k < job->desc.samples; k++)
        if (!isfinite(job->term[k]))
            return rsv_fail(
                RSV_ERROR_SCENE, "certify: the light is not a finite number everywhere");
    return rsv_progress(context, "certify", 1);
}

/// E~ at a node; the coarse elements' own direct light where the solution leaves that to the renderer.
static rsv_rgb irradiance_at_node(const rsv_light_view *s, uint32_t node)
{
    const rsv_elements *e = s->elements;
    uint32_t face;
    float u, v;
    if (!s->desc.direct_level || e->support_begin[node] == e->support_begin[node + 1])
        return rgb_add(s->source[node], s->indirect[node]);
    rsv_elements_place_node(e, node, &face, &u, &v);
    return rsv_light_view_irradiance(s, e->face_triangle[face], u, v, e->face_back[face], RSV_NONE);
}

/// <w, E~>: the goal's reading of diffuse surfaces.
static double reading_of(const rsv_light_view *s, const rsv_rgb *weight)
{
    double sum = 0;
    for (uint32_t n = 0; n < s->elements->node_count; n++) {
        if (rgb_is_black(weight[n])) continue;
        rsv_rgb seen = rgb_mul(weight[n], irradiance_at_node(s, n));
        sum += (double)seen.r + (double)seen.g + (double)seen.b;
    }
    return sum;
}

static rsv_status find_importance(
    goal_job *job, const rsv_goal_aim *aim, rsv_goal_certificate *certificate)
{
    const rsv_light_view *s = job->solution;
    rsv_status status;
    rsv_rgb *weight = rsv_alloc(s->context, s->elements->node_count, sizeof *weight);
    RSV_TRY(weight ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_goal_weights(s->op, aim, SIDE, s->desc.seed, weight));
    certificate->reading = reading_of(s, weight);
    RSV_TRY(rsv_goal_importance(s->op, s->desc.max_orders, weight, job->importance));
    rsv_goal_density(s->elements, job->importance);
cleanup:
    rsv_free(s->context, weight);
    return status;
}

static rsv_status certify_aim(const rsv_light_view *s, const rsv_certify_desc *desc,
    const rsv_goal_aim *aim, rsv_goal_certificate *certificate)
{
    rsv_status status;
    goal_job job = { .solution = s, .desc = rsv_default_certify_desc() };
    *certificate = (rsv_goal_certificate){ 0 };
    RSV_TRY(RSV_READ_DESC(rsv_certify_desc, &job.desc, desc));
    RSV_TRY(rsv_check_certify_desc(&job.desc));
    RSV_TRY(rsv_light_refuse_fog(s, "the error of one picture or of readings"));
    if (s->elements->cell_count == 0) return RSV_OK;
    job.seed = rsv_hash2(job.desc.seed, SEED_OF_GOAL);
    job.importance = rsv_alloc(s->context, s->elements->node_count, sizeof *job.importance);
    job.term = rsv_alloc(s->context, job.desc.samples, sizeof *job.term);
    RSV_TRY(job.importance && job.term ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(find_importance(&job, aim, certificate));
    RSV_TRY(rsv_point_density_create(s->elements, EVEN_SHARE, importance_of, &job, &job.density));
    RSV_TRY(judge_caustics(&job));
    RSV_TRY(measure_terms(&job));
    rsv_moments error = rsv_moments_of(job.term, job.desc.samples);
    certificate->error = error.mean;
    certificate->error_ci95[0] = error.ci95[0], certificate->error_ci95[1] = error.ci95[1];
cleanup:
    rsv_free(s->context, job.importance);
    rsv_caustic_judge_destroy(&job.judge);
    rsv_point_density_destroy(&job.density);
    rsv_free(s->context, job.term);
    return status;
}

rsv_status rsv_certify_goal(const rsv_light *light, const rsv_certify_desc *desc, uint32_t camera,
    rsv_goal_certificate *certificate)
{
    const rsv_light_view *s = rsv_light_get_view(light);
    rsv_goal_aim aim = { .camera = camera };
    if (camera >= s->scene.view->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "certify: camera %u does not exist, the scene has %zu",
            camera, s->scene.view->camera_count);
    return certify_aim(s, desc, &aim, certificate);
}

rsv_status rsv_certify_points(const rsv_light *light, const rsv_certify_desc *desc,
    const rsv_probe *points, size_t point_count, rsv_goal_certificate *certificate)
{
    rsv_goal_aim aim = { RSV_NONE, points, point_count };
    if (point_count == 0) return rsv_fail(RSV_ERROR_ARGUMENT, "certify: there are no points");
    rsv_status status = rsv_check_probes(points, point_count);
    return status == RSV_OK ? certify_aim(rsv_light_get_view(light), desc, &aim, certificate)
                            : status;
}
