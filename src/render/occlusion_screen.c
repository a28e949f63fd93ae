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

#define BLOCK 4 ///< pixels of a packet lie in a square

struct rsv_occlusion_screen {
    rsv_seen_surface *seen; ///< [height * width]
    float *depth;           ///< [height * width] along the view; INFINITY = nothing
    float *openness;        ///< [height * width] before the blur
    rsv_vec3 *kernel; ///< [samples] points of the unit hemisphere about +z, denser at its centre
    float turn[TILE * TILE][2]; ///< cosine and sine by which each pixel of a tile turns the kernel
};

/// One picture in the making.
typedef struct screen {
    const rsv_occlusion_job *job;
    const rsv_occlusion *shared;
    struct rsv_occlusion_screen *buffer;
} screen;

/// Pixel that shows a point, and its depth; false if it lies outside the picture or behind the camera.
static bool project(const screen *s, rsv_vec3 point, size_t *pixel, float *depth)
{
    const rsv_lens *lens = &s->job->lens;
    const rsv_camera *camera = &lens->camera;
    rsv_vec3 d = v3_sub(point, camera->position);
    bool orthographic = camera->vertical_fov == 0;
    *depth = v3_dot(d, camera->forward);
    if (!orthographic && *depth <= 0) return false;
    float scale = 1 / (orthographic ? lens->pixel_size : *depth * lens->pixel_size);
    float x = lens->half_width + scale * v3_dot(d, camera->right);
    float y = lens->half_height - scale * v3_dot(d, camera->up);
    if (!(x >= 0 && y >= 0 && x < 2 * lens->half_width && y < 2 * lens->half_height)) return false;
    *pixel = (size_t)y * s->shared->desc.width + (size_t)x;
    return true;
}

static void fill_kernel(rsv_occlusion *o)
{
    uint32_t count = o->samples;
    for (uint32_t i = 0; i < count; i++) {
        float x, y, fraction = ((float)i + 0.5f) / (float)count;
        rsv_sobol_2d(i, o->desc.seed, &x, &y);
        // cosine-distributed directions, so that their mean is what the surface receives
        o->screen->kernel[i] =
            v3_scale(rsv_square_to_cosine_hemisphere(x, y), 0.1f + 0.9f * fraction * fraction);
    }
    for (uint32_t cell = 0; cell < TILE * TILE; cell++) {
        float angle = 2 * RSV_PI * rsv_unit_float(rsv_hash2(o->desc.seed, cell));
        o->screen->turn[cell][0] = cosf(angle);
        o->screen->turn[cell][1] = sinf(angle);
    }
}

/// How much the stored surface at a scattered point takes away: 1 if it lies before it, less where it is
/// farther than the reach from the pixel's own surface (the range check).
static float occlusion_at(const screen *s, rsv_vec3 point, float own_depth)
{
    size_t pixel;
    float depth, reach = s->shared->distance;
    if (!project(s, point, &pixel, &depth)) return 0;
    float stored = s->buffer->depth[pixel];
    if (!(stored < depth - DEPTH_BIAS * reach)) return 0;
    float t = f_min(reach / f_max(fabsf(own_depth - stored), 1e-20f), 1);
    return t * t * (3 - 2 * t);
}

static float find_openness(const screen *s, uint32_t column, uint32_t row)
{
    size_t pixel = (size_t)row * s->shared->desc.width + column;
    const rsv_surface_point *p = &s->buffer->seen[pixel].point;
    rsv_vec3 t, b;
    v3_frame(p->normal, &t, &b);
    const float *turn = s->buffer->turn[row % TILE * TILE + column % TILE];
    float c = turn[0], sn = turn[1], occluded = 0;
    for (uint32_t i = 0; i < s->shared->samples; i++) {
        rsv_vec3 k = s->buffer->kernel[i];
        rsv_vec3 offset = v3_scale(t, c * k.x - sn * k.y);
        offset = v3_mad(v3_mad(offset, sn * k.x + c * k.y, b), k.z, p->normal);
        occluded += occlusion_at(
            s, v3_mad(p->position, s->shared->distance, offset), s->buffer->depth[pixel]);
    }
    return 1 - occluded / (float)s->shared->samples;
}

/// Mean over one 4x4 tile of pixels about this one, of those that show something.
static float blurred_openness(const screen *s, uint32_t column, uint32_t row)
{
    int width = (int)s->shared->desc.width, height = (int)s->shared->desc.height, count = 0;
    float sum = 0;
    for (int y = (int)row - TILE / 2; y < (int)row + TILE / 2; y++)
        for (int x = (int)column - TILE / 2; x < (int)column + TILE / 2; x++) {
            if (x < 0 || y < 0 || x >= width || y >= height) continue;
            size_t pixel = (size_t)y * (size_t)width + (size_t)x;
            if (!s->buffer->seen[pixel].hit) continue;
            sum += s->buffer->openness[pixel];
            count++;
        }
    return sum / (float)count;
}

/// What a block of pixels sees.
static void fill_block(screen *s, uint32_t column, uint32_t row)
{
    uint32_t width = s->shared->desc.width, height = s->shared->desc.height, count = 0;
    float x[BLOCK * BLOCK] = { 0 }, y[BLOCK * BLOCK] = { 0 };
    size_t pixel[BLOCK * BLOCK];
    rsv_seen_surface seen[BLOCK * BLOCK];
    for (uint32_t j = row; j < row + BLOCK && j < height; j++)
        for (uint32_t i = column; i < column + BLOCK && i < width; i++) {
            x[count] = (float)i + 0.5f;
            y[count] = (float)j + 0.5f;
            pixel[count++] = (size_t)j * width + i;
        }
    rsv_see_surfaces(s->job, count, x, y, seen);
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 d = v3_sub(seen[k].point.position, s->job->lens.camera.position);
        s->buffer->seen[pixel[k]] = seen[k];
        s->buffer->depth[pixel[k]] =
            seen[k].hit ? v3_dot(d, s->job->lens.camera.forward) : INFINITY;
    }
}

static void fill_buffers(screen *s)
{
    uint32_t width = s->shared->desc.width, height = s->shared->desc.height;
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->shared->context))
    for (uint32_t row = 0; row < height; row += BLOCK)
        for (uint32_t column = 0; column < width; column += BLOCK)
            fill_block(s, column, row);
}

static void shade(screen *s)
{
    uint32_t width = s->shared->desc.width, height = s->shared->desc.height;
    rsv_rgb *out = rsv_image_pixels(s->job->image, 0);
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->shared->context))
    for (uint32_t row = 0; row < height; row++)
        for (uint32_t column = 0; column < width; column++) {
            size_t pixel = (size_t)row * width + column;
            if (s->buffer->seen[pixel].hit)
                s->buffer->openness[pixel] = find_openness(s, column, row);
        }
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->shared->context))
    for (uint32_t row = 0; row < height; row++)
        for (uint32_t column = 0; column < width; column++) {
            size_t pixel = (size_t)row * width + column;
            const rsv_seen_surface *seen = &s->buffer->seen[pixel];
            float openness = seen->hit ? blurred_openness(s, column, row) : 0;
            out[pixel] = rgb_mad(seen->emission, openness, seen->ambient);
        }
}

rsv_status rsv_render_screen_occlusion(const rsv_occlusion_job *job)
{
    rsv_context *context = job->shared->context;
    screen s = { job, job->shared, job->shared->screen };
    fill_buffers(&s);
    rsv_status status = rsv_progress(context, "render", 0.5);
    if (status != RSV_OK) return status;
    shade(&s);
    return rsv_progress(context, "render", 1);
}

rsv_status rsv_occlusion_screen_create(rsv_occlusion *o)
{
    size_t pixel_count = (size_t)o->desc.width * o->desc.height;
    struct rsv_occlusion_screen *b = o->screen = rsv_alloc(o->context, 1, sizeof *b);
    if (!b) return RSV_ERROR_MEMORY;
    b->seen = rsv_alloc(o->context, pixel_count, sizeof *b->seen);
    b->depth = rsv_alloc(o->context, pixel_count, sizeof *b->depth);
    b->openness = rsv_alloc(o->context, pixel_count, sizeof *b->openness);
    b->kernel = rsv_alloc(o->context, o->samples, sizeof *b->kernel);
    if (!b->seen || !b->depth || !b->openness || !b->kernel) return RSV_ERROR_MEMORY;
    fill_kernel(o);
    return RSV_OK;
}

void rsv_occlusion_screen_destroy(rsv_occlusion *o)
{
    if (!o->screen) return;
    rsv_free(o->context, o->screen->seen);
    rsv_free(o->context, o->screen->depth);
    rsv_free(o->context, o->screen->openness);
    rsv_free(o->context, o->screen->kernel);
    rsv_free(o->context, o->screen);
}
