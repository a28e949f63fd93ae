/// Ambient occlusion in screen space, as games do it (after Mittring 2007 and its later forms): points scattered in the
/// hemisphere above a pixel's surface count as occluded where the depth buffer holds something nearer at
/// their place in the picture. The set is turned from pixel to pixel in a 4x4 pattern, which a 4x4 blur then hides. It sees
/// nothing outside the picture or behind the front surface: the baseline, not a measurement.
#include "occlusion.h"

#include "../core/core_internal.h"
#include "../core/sampling.h"

#include <string.h>

#define TILE 4
#define DEPTH_BIAS 0.02f ///< of the reach: what is nearer by less is the surface itself

typedef struct screen {
    const rsv_occlusion_job *job;
    rsv_seen_surface *seen; ///< [height * width]
    float *depth;           ///< [height * width] along the view; INFINITY = nothing
    float *openness;        ///< [height * width] before the blur
    rsv_vec3 *kernel; ///< [samples] points of the unit hemisphere about +z, denser at its centre
} screen;

/// Pixel that shows a point, and its depth; false if it lies outside the picture or behind the camera.
static bool project(const screen *s, rsv_vec3 point, size_t *pixel, float *depth)
{
    const rsv_camera *camera = s->job->camera;
    uint32_t width = s->job->desc->width, height = s->job->desc->height;
    rsv_vec3 d = v3_sub(point, camera->position);
    bool orthographic = camera->vertical_fov == 0;
    *depth = v3_dot(d, camera->forward);
    if (!orthographic && *depth <= 0) return false;
    float half = orthographic ? camera->vertical_extent : *depth * tanf(camera->vertical_fov / 2);
    float scale = 0.5f * (float)height / half;
    float x = 0.5f * (float)width + scale * v3_dot(d, camera->right);
    float y = 0.5f * (float)height - scale * v3_dot(d, camera->up);
    if (!(x >= 0 && y >= 0 && x < (float)width && y < (float)height)) return false;
    *pixel = (size_t)y * width + (size_t)x;
    return true;
}

static void fill_kernel(screen *s)
{
    uint32_t count = s->job->samples;
    for (uint32_t i = 0; i < count; i++) {
        float x, y, fraction = ((float)i + 0.5f) / (float)count;
        rsv_sobol_2d(i, s->job->desc->seed, &x, &y);
        // cosine-distributed directions, so that their mean is what the surface receives
        s->kernel[i] =
            v3_scale(rsv_square_to_cosine_hemisphere(x, y), 0.1f + 0.9f * fraction * fraction);
    }
}

/// How much the stored surface at a scattered point takes away: 1 if it lies before it, less where it is
/// farther than the reach from the pixel's own surface (the range check).
static float occlusion_at(const screen *s, rsv_vec3 point, float own_depth)
{
    size_t pixel;
    float depth, reach = s->job->distance;
    if (!project(s, point, &pixel, &depth)) return 0;
    float stored = s->depth[pixel];
    if (!(stored < depth - DEPTH_BIAS * reach)) return 0;
    float t = f_min(reach / f_max(fabsf(own_depth - stored), 1e-20f), 1);
    return t * t * (3 - 2 * t);
}

static float find_openness(const screen *s, uint32_t column, uint32_t row)
{
    size_t pixel = (size_t)row * s->job->desc->width + column;
    const rsv_surface_point *p = &s->seen[pixel].point;
    rsv_vec3 t, b;
    v3_frame(p->normal, &t, &b);
    uint32_t cell = row % TILE * TILE + column % TILE;
    float angle = 2 * RSV_PI * rsv_unit_float(rsv_hash2(s->job->desc->seed, cell));
    float c = cosf(angle), sn = sinf(angle), occluded = 0;
    for (uint32_t i = 0; i < s->job->samples; i++) {
        rsv_vec3 k = s->kernel[i];
        rsv_vec3 offset = v3_scale(t, c * k.x - sn * k.y);
        offset = v3_mad(v3_mad(offset, sn * k.x + c * k.y, b), k.z, p->normal);
        occluded += occlusion_at(s, v3_mad(p->position, s->job->distance, offset), s->depth[pixel]);
    }
    return 1 - occluded / (float)s->job->samples;
}

/// Mean over one 4x4 tile of pixels about this one, of those that show something.
static float blurred_openness(const screen *s, uint32_t column, uint32_t row)
{
    int width = (int)s->job->desc->width, height = (int)s->job->desc->height, count = 0;
    float sum = 0;
    for (int y = (int)row - TILE / 2; y < (int)row + TILE / 2; y++)
        for (int x = (int)column - TILE / 2; x < (int)column + TILE / 2; x++) {
            if (x < 0 || y < 0 || x >= width || y >= height) continue;
            size_t pixel = (size_t)y * (size_t)width + (size_t)x;
            if (!s->seen[pixel].hit) continue;
            sum += s->openness[pixel];
            count++;
        }
    return sum / (float)count;
}

static void fill_buffers(screen *s)
{
    const rsv_camera *camera = s->job->camera;
    uint32_t width = s->job->desc->width, height = s->job->desc->height;
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->job->context))
    for (uint32_t row = 0; row < height; row++)
        for (uint32_t column = 0; column < width; column++) {
            size_t pixel = (size_t)row * width + column;
            s->seen[pixel] = rsv_see_surface(s->job, (float)column + 0.5f, (float)row + 0.5f);
            rsv_vec3 d = v3_sub(s->seen[pixel].point.position, camera->position);
            s->depth[pixel] = s->seen[pixel].hit ? v3_dot(d, camera->forward) : INFINITY;
        }
}

static void shade(screen *s)
{
    uint32_t width = s->job->desc->width, height = s->job->desc->height;
    rsv_rgb *out = rsv_image_pixels(s->job->image, 0);
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->job->context))
    for (uint32_t row = 0; row < height; row++)
        for (uint32_t column = 0; column < width; column++) {
            size_t pixel = (size_t)row * width + column;
            if (s->seen[pixel].hit) s->openness[pixel] = find_openness(s, column, row);
        }
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->job->context))
    for (uint32_t row = 0; row < height; row++)
        for (uint32_t column = 0; column < width; column++) {
            size_t pixel = (size_t)row * width + column;
            const rsv_seen_surface *seen = &s->seen[pixel];
            float openness = seen->hit ? blurred_openness(s, column, row) : 0;
            out[pixel] = rgb_mad(seen->emission, openness, seen->ambient);
        }
}

rsv_status rsv_render_screen_occlusion(const rsv_occlusion_job *job)
{
    rsv_status status = RSV_ERROR_MEMORY;
    size_t pixel_count = (size_t)job->desc->width * job->desc->height;
    screen s = { .job = job };
    s.seen = rsv_alloc(job->context, pixel_count, sizeof *s.seen);
    s.depth = rsv_alloc(job->context, pixel_count, sizeof *s.depth);
    s.openness = rsv_alloc(job->context, pixel_count, sizeof *s.openness);
    s.kernel = rsv_alloc(job->context, job->samples, sizeof *s.kernel);
    if (!s.seen || !s.depth || !s.openness || !s.kernel) goto cleanup;
    fill_kernel(&s);
    fill_buffers(&s);
    RSV_TRY(rsv_progress(job->context, "render", 0.5));
    shade(&s);
    status = rsv_progress(job->context, "render", 1);
cleanup:
    rsv_free(job->context, s.seen);
    rsv_free(job->context, s.depth);
    rsv_free(job->context, s.openness);
    rsv_free(job->context, s.kernel);
    return status;
}
