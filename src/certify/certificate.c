#include "../core/descriptor.h"
#include "resolvent/certify.h"

#include "../core/parallel.h"
#include "../elements/voxels.h"
#include "amplification.h"
#include "error_field.h"
#include "point_density.h"

/// Makes the points independent of everything that the build draws from its seed.
#define SEED_OF_POINTS 0x7f4a7c15u
#define SEED_OF_PHOTONS 0x51c0a7e9u
#define SEED_OF_AIR 0x2c9277b5u

/// State of an examination.
typedef struct examination {
    const rsv_light_view *solution;
    rsv_certify_desc desc;
    rsv_point_density density;
    rsv_caustic_judge judge;     ///< of caustics that no gather ray can find
    rsv_residual_sample *sample; ///< [desc.samples]
    double *value, *weight;      ///< [desc.samples] scratch: one number per valid sample
    rsv_error_field *field;
    rsv_certificate *certificate;
} examination;

void rsv_certify_desc_init(rsv_certify_desc *desc, size_t size)
{
    const rsv_certify_desc defaults = {
        .size = sizeof defaults, .samples = 2048, .gather_rays = 512, .light_samples = 64
    };
    rsv_desc_fill(desc, size, &defaults);
}

static bool is_finite(const rsv_residual *r)
{
    return isfinite(rgb_luminance(r->residual[0]) + rgb_luminance(r->residual[1]) +
                    rgb_luminance(r->irradiance[0]) + rgb_luminance(r->irradiance[1]));
}

/// Each set is spread over all surfaces.
static void draw_points(examination *x)
{
    uint32_t seed = rsv_hash2(x->desc.seed, SEED_OF_POINTS), count = x->desc.samples;
    for (uint32_t k = 0; k < count; k++)
        x->sample[k].point = rsv_point_density_draw(&x->density, k / RSV_SAMPLE_SETS,
            count / RSV_SAMPLE_SETS, rsv_hash2(seed, k % RSV_SAMPLE_SETS), &x->sample[k].weight);
}

static rsv_status judge_caustics(examination *x)
{
    rsv_status status = rsv_caustic_judge_create(x->solution, &x->judge);
    if (status != RSV_OK) return status;
    for (uint32_t k = 0; k < x->desc.samples; k++)
        rsv_caustic_judge_add(&x->judge, &x->sample[k].point);
    return rsv_caustic_judge_shoot(
        &x->judge, rsv_hash2(x->desc.seed, SEED_OF_PHOTONS), &x->certificate->rays);
}

/// Data for sampling points on surfaces, or in the air.
typedef struct sampling_job {
    examination *x;
    rsv_residual_job residual;
    rsv_visible_surface visible; ///< of surfaces
    const double *sum;           ///< [voxels] areas of voxels, summed up; of air
    atomic_uint_least64_t rays;
    atomic_size_t done;
    atomic_uint broken;
} sampling_job;

/// @return whether the light there is a finite number, or the point is buried
static bool take_sample(const sampling_job *job, uint32_t k, uint64_t *rays)
{
    rsv_residual_sample *sample = &job->x->sample[k];
    uint32_t stream = rsv_hash3(rsv_hash2(job->x->desc.seed, SEED_OF_POINTS), k, 0x1b87u);
    if (rsv_point_is_buried(&job->visible, &sample->point, stream, rays)) return true;
    sample->at = rsv_residual_at(&job->residual, &sample->point, stream);
    sample->valid = is_finite(&sample->at);
    *rays += sample->at.rays;
    return sample->valid;
}

static void take_span(void *data, rsv_span span)
{
    sampling_job *job = data;
    rsv_context *context = job->x->solution->context;
    uint64_t rays = 0;
    for (size_t k = span.begin; k < span.end && !rsv_cancelled(context); k++) {
        if (!take_sample(job, (uint32_t)k, &rays)) atomic_fetch_add(&job->broken, 1);
        rsv_item_done(context, "certify", span.worker, &job->done, job->x->desc.samples);
    }
    atomic_fetch_add(&job->rays, rays);
}

static rsv_status take_samples(examination *x)
{
    const rsv_light_view *s = x->solution;
    rsv_context *context = s->context;
    sampling_job job = { .x = x };
    job.residual = rsv_residual_job_of(s, x->desc.gather_rays, x->desc.light_samples);
    if (x->judge.solution) job.residual.judge = &x->judge;
    job.visible = rsv_visible_surface_of(&s->scene, s->elements);
    rsv_parallel_for(context, x->desc.samples, 8, take_span, &job);
    x->certificate->rays += job.rays;
    if (job.broken > 0)
        return rsv_fail(RSV_ERROR_SCENE,
            "certify: at %u of %u points the light is not a finite number", job.broken,
            x->desc.samples);
    if (job.residual.stored_caustics)
        rsv_log(context, RSV_LOG_WARNING,
            "certify: gather rays cannot find punctual lights, so photons check their caustics; detail finer "
            "than small parts of the elements is missed");
    return rsv_progress(context, "certify", 1);
}

typedef double (*sample_value)(const examination *x, size_t k);

/// Moments of one number of each sample.
static rsv_moments moments(examination *x, sample_value value_of)
{
    size_t count = 0;
    for (size_t k = 0; k < x->desc.samples; k++) {
        if (!x->sample[k].valid) continue;
        x->weight[count] = x->sample[k].weight;
        x->value[count++] = value_of(x, k);
    }
    return rsv_moments_by_weight(x->value, x->weight, count);
}

static double luminance(rsv_rgb color) { return (double)rgb_luminance(color); }

static double squared_residual(const examination *x, size_t k)
{
    const rsv_residual *r = &x->sample[k].at;
    return luminance(r->residual[0]) * luminance(r->residual[1]);
}

static double squared_direct(const examination *x, size_t k)
{
    const rsv_residual *r = &x->sample[k].at;
    return luminance(r->direct[0]) * luminance(r->direct[1]);
}

static double squared_gathered(const examination *x, size_t k)
{
    const rsv_residual *r = &x->sample[k].at;
    return (luminance(r->residual[0]) - luminance(r->direct[0])) *
           (luminance(r->residual[1]) - luminance(r->direct[1]));
}

static double squared_irradiance(const examination *x, size_t k)
{
    const rsv_residual *r = &x->sample[k].at;
    return luminance(r->irradiance[0]) * luminance(r->irradiance[1]);
}

/// Of the operator that was solved.
static double largest_albedo(const rsv_light_view *s)
{
    float largest = 0;
    for (size_t n = 0; n < s->elements->node_count; n++)
        largest = f_max(largest, rgb_max(s->exitance_albedo[n]));
    return (double)largest;
}

/// (largest / least refractive index around the points)^2.
static double medium_factor(const examination *x)
{
    float least = INFINITY, most = 0;
    for (size_t k = 0; k < x->desc.samples; k++) {
        if (!x->sample[k].valid) continue;
        least = f_min(least, x->sample[k].at.ior);
        most = f_max(most, x->sample[k].at.ior);
    }
    return most > 0 ? (double)(most / least) * (double)(most / least) : 1;
}

// ---- fog ----------------------------------------------------------------------------------------

/// The area of all voxels (node_area), summed up. @param sum [count] out
static double sum_areas(const rsv_elements *e, double *sum)
{
    double total = 0;
    const float *area = e->node_area + rsv_elements_surface_nodes(e);
    for (size_t k = 0; k < e->voxels->count; k++)
        sum[k] = total += (double)area[k];
    return total;
}

/// One of the voxels, by area.
static uint32_t draw_voxel(const sampling_job *job, size_t k, uint32_t stream)
{
    size_t voxels = job->x->solution->elements->voxels->count;
    double place = (double)k + (double)rsv_unit_float(stream);
    double at = job->sum[voxels - 1] * place / job->x->desc.samples;
    return (uint32_t)rsv_interval_at(job->sum, voxels, at);
}

static void measure_voxels(void *data, rsv_span span)
{
    sampling_job *job = data;
    examination *x = job->x;
    uint32_t seed = rsv_hash2(x->desc.seed, SEED_OF_AIR);
    uint64_t rays = 0;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t stream = rsv_hash3(seed, (uint32_t)k, 0x1b87u);
        x->value[k] = 0;
        if (rsv_cancelled(x->solution->context)) continue;
        rsv_residual r = rsv_residual_in_air(&job->residual, draw_voxel(job, k, stream), stream);
        if (is_finite(&r)) x->value[k] = luminance(r.residual[0]) * luminance(r.residual[1]);
        rays += r.rays;
    }
    atomic_fetch_add(&job->rays, rays);
}

/// Mean of the squared residual in the air.
static rsv_moments measure_air(examination *x, const double *sum)
{
    const rsv_light_view *s = x->solution;
    sampling_job job = { .x = x, .sum = sum };
    job.residual = rsv_residual_job_of(s, x->desc.gather_rays, x->desc.light_samples);
    rsv_parallel_for(s->context, x->desc.samples, 8, measure_voxels, &job);
    x->certificate->rays += job.rays;
    return rsv_moments_of(x->value, x->desc.samples);
}

/// Contribution of the residual in the air to the bound: squared, per area of the surfaces. Errors there reach surfaces
/// as those on surfaces do. @param squared out
static rsv_status judge_air(examination *x, double *squared)
{
    const rsv_light_view *s = x->solution;
    *squared = 0;
    if (!s->elements->voxels) return RSV_OK;
    double *sum = rsv_alloc(s->context, s->elements->voxels->count, sizeof *sum);
    if (!sum) return RSV_ERROR_MEMORY;
    double total = sum_areas(s->elements, sum);
    rsv_moments m = measure_air(x, sum);
    *squared = fmax(m.ci95[1], 0) * total / (double)x->density.area;
    rsv_free(s->context, sum);
    return rsv_progress(s->context, "certify", 1);
}

static rsv_status judge_bound(examination *x)
{
    rsv_certificate *c = x->certificate;
    rsv_amplification a;
    double air;
    rsv_status status = judge_air(x, &air);
    if (status != RSV_OK) return status;
    c->max_albedo = largest_albedo(x->solution);
    c->medium_factor = medium_factor(x);
    status = rsv_amplification_of(x->solution, c->max_albedo, &a);
    if (status != RSV_OK) return status;
    c->amplification = c->medium_factor * a.coat_factor * a.factor;
    double most = fmax(c->residual_ci95[1], 0);
    if (air > 0) most = sqrt(most * most + air);
    c->error_bound_rms = most > 0 ? c->amplification * most : 0;
    return RSV_OK;
}

static void judge_residual(examination *x)
{
    rsv_certificate *c = x->certificate;
    for (size_t k = 0; k < x->desc.samples; k++)
        c->samples += x->sample[k].valid;
    rsv_moments residual = rsv_moments_root(moments(x, squared_residual));
    c->residual_rms = residual.mean;
    c->residual_ci95[0] = residual.ci95[0], c->residual_ci95[1] = residual.ci95[1];
    c->residual_direct_rms = rsv_moments_root(moments(x, squared_direct)).mean;
    c->residual_gathered_rms = rsv_moments_root(moments(x, squared_gathered)).mean;
    c->irradiance_rms = rsv_moments_root(moments(x, squared_irradiance)).mean;
}

static rsv_status judge_error(examination *x)
{
    rsv_certificate *c = x->certificate;
    if (c->samples == 0) return RSV_OK;
    double area = x->density.area / x->desc.samples;
    rsv_status status =
        rsv_error_field_create(x->solution, x->sample, x->desc.samples, area, x->field);
    if (status != RSV_OK) return status;
    rsv_moments error =
        rsv_moments_root(rsv_mean_squared_error(x->solution, x->sample, x->desc.samples, x->field));
    c->error_estimate_rms = error.mean;
    c->error_estimate_ci95[0] = error.ci95[0], c->error_estimate_ci95[1] = error.ci95[1];
    return RSV_OK;
}

static rsv_status examine(examination *x)
{
    const rsv_light_view *s = x->solution;
    rsv_status status = RSV_OK;
    if (s->elements->face_count == 0) return RSV_OK;
    RSV_TRY(rsv_point_density_of_light(s, &x->density));
    x->sample = rsv_alloc(s->context, x->desc.samples, sizeof *x->sample);
    x->value = rsv_alloc(s->context, x->desc.samples, sizeof *x->value);
    x->weight = rsv_alloc(s->context, x->desc.samples, sizeof *x->weight);
    RSV_TRY(x->sample && x->value && x->weight ? RSV_OK : RSV_ERROR_MEMORY);
    draw_points(x);
    if (rsv_has_unseen_caustics(s)) RSV_TRY(judge_caustics(x));
    RSV_TRY(take_samples(x));
    judge_residual(x);
    RSV_TRY(judge_bound(x));
    RSV_TRY(judge_error(x));
cleanup:
    rsv_caustic_judge_destroy(&x->judge);
    rsv_point_density_destroy(&x->density);
    rsv_free(s->context, x->sample);
    rsv_free(s->context, x->value);
    rsv_free(s->context, x->weight);
    return status;
}

rsv_status rsv_examine(const rsv_light_view *solution, const rsv_certify_desc *desc,
    rsv_certificate *certificate, rsv_error_field *field)
{
    double start = rsv_seconds();
    examination x = {
        .solution = solution, .desc = *desc, .field = field, .certificate = certificate
    };
    *field = (rsv_error_field){ 0 };
    rsv_status status = rsv_check_certify_desc(&x.desc);
    if (status != RSV_OK) return status;
    x.desc.samples = (x.desc.samples + RSV_SAMPLE_SETS - 1) / RSV_SAMPLE_SETS * RSV_SAMPLE_SETS;
    *certificate = (rsv_certificate){ 0 };
    status = examine(&x);
    certificate->seconds = rsv_seconds() - start;
    return status;
}

rsv_status rsv_certify(
    const rsv_light *light, const rsv_certify_desc *desc, rsv_certificate *certificate)
{
    const rsv_light_view *solution = rsv_light_get_view(light);
    rsv_error_field field;
    rsv_certify_desc settings = rsv_default_certify_desc();
    rsv_status status = RSV_READ_DESC(rsv_certify_desc, &settings, desc);
    if (status != RSV_OK) return status;
    status = rsv_examine(solution, &settings, certificate, &field);
    rsv_error_field_destroy(solution->context, &field);
    return status;
}
