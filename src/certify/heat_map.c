/// Where the error is, as a picture: the estimate of e^2 at one surface point per pixel, averaged over its neighbours
/// on the same surface.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../core/srgb.h"
#include "../render/camera_path.h"
#include "../trace/camera_ray.h"
#include "error_field.h"

#define SEED_OF_PIXELS 0x51ed270bu
#define SEED_OF_PHOTONS 0x7c3a92d1u
/// Averages extend this many pixels in each direction ...
#define REACH 5
/// ... over surfaces of one material whose normals agree so far (cosine).
#define SAME_NORMAL 0.9f
#define BAR_HEIGHT 12

/// Data of one pixel.
typedef struct heat_pixel {
    rsv_face_point point;
    double squared; ///< e_a e_b, luminance
    rsv_vec3 normal;
    uint32_t material; ///< RSV_NONE = nothing diffuse
} heat_pixel;

typedef struct heat_job {
    const rsv_light_view *solution;
    const rsv_error_field *field;
    rsv_heat_map_desc desc;
    const rsv_camera *camera;
    rsv_residual_job residual;
    rsv_caustic_judge judge; ///< of caustics that no gather ray can find
    rsv_medium medium;       ///< the camera's
    uint32_t seed;
    heat_pixel *pixel; ///< [height * width]
    atomic_size_t rows_done;
} heat_job;

/// The end of a camera ray that matters most.
typedef struct brightest_end {
    rsv_specular_path path;
    float weight;
} brightest_end;

void rsv_heat_map_desc_init(rsv_heat_map_desc *desc, size_t size)
{
    const rsv_heat_map_desc defaults = {
        .size = sizeof defaults, .width = 256, .height = 256, .gather_rays = 128
    };
    rsv_desc_fill(desc, size, &defaults);
}

static void keep_brightest(void *user, const rsv_specular_path *path, rsv_rgb weight)
{
    brightest_end *end = user;
    float luminance = rgb_luminance(weight);
    if (luminance > end->weight) *end = (brightest_end){ *path, luminance };
}

static bool find_surface(const heat_job *job, uint32_t x, uint32_t y, rsv_face_point *point)
{
    const rsv_light_view *s = job->solution;
    rsv_ray ray = rsv_camera_ray(
        job->camera, job->desc.width, job->desc.height, (float)x + 0.5f, (float)y + 0.5f);
    rsv_hit hit;
    if (!rsv_tracer_closest(s->tracer, &ray, &hit)) return false;
    brightest_end end = { 0 };
    rsv_specular_path path = rsv_specular_begin(&s->scene, &job->medium, ray.direction, hit);
    const rsv_camera_setting setting = { &s->scene, s->lights, NULL, RSV_CAMERA_PATH_DEPTH, false,
        NULL, 0, false, false };
    rsv_camera_path(&setting, path, rsv_hash3(job->seed, x, y), NULL, keep_brightest, &end);
    if (end.weight == 0) return false;
    uint32_t face = s->elements->face_of[end.path.back][end.path.triangle];
    *point = (rsv_face_point){ face, end.path.u, end.path.v };
    return face != RSV_NONE;
}

/// The mean over half of the sets.
static double reflected_luminance(const heat_job *job, int half, const rsv_face_point *point)
{
    double sum = 0;
    if (!job->field->reflected[0]) return 0;
    for (int set = half; set < RSV_SAMPLE_SETS; set += 2)
        sum += (double)rgb_luminance(
            rsv_error_field_at(job->solution, job->field->reflected[set], point));
    return 2 * sum / RSV_SAMPLE_SETS;
}

static heat_pixel place_pixel(const heat_job *job, uint32_t x, uint32_t y)
{
    const rsv_elements *e = job->solution->elements;
    heat_pixel pixel = { .material = RSV_NONE };
    rsv_face_point *p = &pixel.point;
    if (!find_surface(job, x, y, p)) return pixel;
    uint32_t triangle = e->face_triangle[p->face];
    pixel.material = e->scene->triangle_material[triangle];
    pixel.normal =
        rsv_surface_point_at(e->scene, triangle, p->u, p->v, e->face_back[p->face]).geometric;
    return pixel;
}

static void measure_pixel(const heat_job *job, uint32_t x, uint32_t y)
{
    heat_pixel *pixel = &job->pixel[(size_t)y * job->desc.width + x];
    if (pixel->material == RSV_NONE) return;
    rsv_residual r = rsv_residual_at(&job->residual, &pixel->point, rsv_hash3(job->seed, x, y));
    double error[2] = { 0 };
    for (int half = 0; half < 2; half++)
        error[half] =
            (double)rgb_luminance(r.residual[half]) + reflected_luminance(job, half, &pixel->point);
    pixel->squared = isfinite(error[0] * error[1]) ? error[0] * error[1] : 0;
}

static void place_rows(void *data, rsv_span span)
{
    const heat_job *job = data;
    uint32_t width = job->desc.width;
    for (uint32_t y = (uint32_t)span.begin; y < span.end; y++)
        for (uint32_t x = 0; x < width && !rsv_cancelled(job->solution->context); x++)
            job->pixel[(size_t)y * width + x] = place_pixel(job, x, y);
}

static rsv_status judge_caustics(heat_job *job)
{
    size_t count = (size_t)job->desc.width * (job->desc.height - BAR_HEIGHT);
    uint64_t rays = 0;
    if (!rsv_has_unseen_caustics(job->solution)) return RSV_OK;
    rsv_status status = rsv_caustic_judge_create(job->solution, &job->judge);
    if (status != RSV_OK) return status;
    for (size_t k = 0; k < count; k++)
        if (job->pixel[k].material != RSV_NONE)
            rsv_caustic_judge_add(&job->judge, &job->pixel[k].point);
    job->residual.judge = &job->judge;
    return rsv_caustic_judge_shoot(&job->judge, rsv_hash2(job->seed, SEED_OF_PHOTONS), &rays);
}

static void measure_rows(void *data, rsv_span span)
{
    heat_job *job = data;
    rsv_context *context = job->solution->context;
    size_t height = job->desc.height - BAR_HEIGHT;
    for (uint32_t y = (uint32_t)span.begin; y < span.end; y++) {
        for (uint32_t x = 0; x < job->desc.width && !rsv_cancelled(context); x++)
            measure_pixel(job, x, y);
        rsv_item_done(context, "heat map", span.worker, &job->rows_done, height);
    }
}

static bool is_alike(const heat_pixel *a, const heat_pixel *b)
{
    return a->material == b->material && v3_dot(a->normal, b->normal) > SAME_NORMAL;
}

/// Root mean square over the neighbourhood. Noise that the halves do not share averages out before the root.
static double smoothed(const heat_job *job, uint32_t x, uint32_t y)
{
    uint32_t width = job->desc.width, height = job->desc.height - BAR_HEIGHT;
    const heat_pixel *centre = &job->pixel[(size_t)y * width + x];
    uint32_t left = x < REACH ? 0 : x - REACH, top = y < REACH ? 0 : y - REACH;
    double sum = 0, count = 0;
    for (uint32_t v = top; v <= y + REACH && v < height; v++)
        for (uint32_t u = left; u <= x + REACH && u < width; u++) {
            const heat_pixel *p = &job->pixel[(size_t)v * width + u];
            if (!is_alike(centre, p)) continue;
            sum += p->squared;
            count += 1;
        }
    return sqrt(fmax(sum / fmax(count, 1), 0));
}

/// Black, violet, red, orange, yellow, white: brighter all the way.
static rsv_rgb heat_colour(double place)
{
    static const double stop[6][3] = { { 0, 0, 0.05 }, { 0.28, 0.05, 0.45 }, { 0.72, 0.13, 0.34 },
        { 0.96, 0.45, 0.12 }, { 0.98, 0.82, 0.25 }, { 1, 1, 0.95 } };
    double at = 5 * fmin(fmax(place, 0), 1);
    int k = at < 4 ? (int)at : 4;
    float c[3];
    for (int i = 0; i < 3; i++)
        c[i] = (float)rsv_srgb_decode(stop[k][i] + (at - k) * (stop[k + 1][i] - stop[k][i]));
    return rgb(c[0], c[1], c[2]);
}

static const double decades = 3; // of RSV_HEAT_MAP_LOW .. RSV_HEAT_MAP_HIGH

static rsv_rgb colour_of_error(double relative)
{
    if (!(relative > RSV_HEAT_MAP_LOW)) return heat_colour(0);
    return heat_colour(log10(relative / RSV_HEAT_MAP_LOW) / decades);
}

static rsv_rgb colour_of_bar(uint32_t x, uint32_t width)
{
    double place = (x + 0.5) / width, decade = place * decades;
    bool tick = decade >= 1 && decade - floor(decade) < decades / width;
    return tick ? rgb_gray(0.2f) : heat_colour(place);
}

static void paint(const heat_job *job, double irradiance, rsv_image *image)
{
    uint32_t width = job->desc.width, height = job->desc.height;
    rsv_rgb *colour = rsv_image_pixels(image, 0), *number = rsv_image_pixels(image, 1);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            size_t at = (size_t)y * width + x;
            bool in_bar = y >= height - BAR_HEIGHT;
            colour[at] = in_bar ? colour_of_bar(x, width) : rgb_gray(0.1f);
            if (in_bar || job->pixel[at].material == RSV_NONE || irradiance <= 0) continue;
            double relative = smoothed(job, x, y) / irradiance;
            colour[at] = colour_of_error(relative);
            number[at] = rgb_gray((float)relative);
        }
}

static rsv_status check_desc(const rsv_light_view *s, const rsv_heat_map_desc *desc)
{
    if (desc->width < 16 || desc->height < 32 || desc->width > 16384 || desc->height > 16384)
        return rsv_fail(RSV_ERROR_ARGUMENT, "heat map: size %ux%u is not in 16x32 .. 16384x16384",
            desc->width, desc->height);
    if (desc->camera >= s->scene.view->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "heat map: camera %u does not exist, the scene has %zu",
            desc->camera, s->scene.view->camera_count);
    if (desc->gather_rays < 1 || desc->gather_rays > 1u << 16)
        return rsv_fail(RSV_ERROR_ARGUMENT, "heat map: gather_rays is %u; it must be 1 to 65536",
            desc->gather_rays);
    return RSV_OK;
}

rsv_status rsv_certify_picture(const rsv_light *light, const rsv_certify_desc *certify,
    const rsv_heat_map_desc *desc, rsv_certificate *certificate, rsv_image **result)
{
    const rsv_light_view *s = rsv_light_get_view(light);
    rsv_status status;
    rsv_certify_desc sampling = rsv_default_certify_desc();
    rsv_error_field field = { 0 };
    rsv_image *image = NULL;
    heat_job job = { .solution = s, .field = &field, .desc = rsv_default_heat_map_desc() };
    RSV_TRY(RSV_READ_DESC(rsv_certify_desc, &sampling, certify));
    RSV_TRY(RSV_READ_DESC(rsv_heat_map_desc, &job.desc, desc));
    job.seed = rsv_hash2(sampling.seed, SEED_OF_PIXELS);
    RSV_TRY(check_desc(s, &job.desc));
    RSV_TRY(rsv_examine(s, &sampling, certificate, &field));
    job.residual = rsv_residual_job_of(s, job.desc.gather_rays, sampling.light_samples);
    job.camera = job.desc.viewpoint ? job.desc.viewpoint : &s->scene.view->camera[job.desc.camera];
    job.medium = rsv_medium_above(&s->scene.media, job.camera->position, job.camera->forward);
    job.pixel = rsv_alloc(s->context, (size_t)job.desc.width * job.desc.height, sizeof *job.pixel);
    RSV_TRY(job.pixel ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_image_create(s->context, job.desc.width, job.desc.height, 2, &image));
    RSV_TRY(rsv_image_set_layer_name(image, 1, "relative_error"));
    rsv_parallel_for(s->context, job.desc.height - BAR_HEIGHT, 1, place_rows, &job);
    RSV_TRY(rsv_progress(s->context, "heat map", 0)); // cancelled pixels have no places
    RSV_TRY(judge_caustics(&job));
    rsv_parallel_for(s->context, job.desc.height - BAR_HEIGHT, 1, measure_rows, &job);
    RSV_TRY(rsv_progress(s->context, "heat map", 1));
    paint(&job, certificate->irradiance_rms, image);
    *result = image;
    image = NULL;
cleanup:
    rsv_image_destroy(image);
    rsv_caustic_judge_destroy(&job.judge);
    rsv_free(s->context, job.pixel);
    rsv_error_field_destroy(s->context, &field);
    return status;
}
