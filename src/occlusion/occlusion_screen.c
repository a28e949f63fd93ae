#include "occlusion.h"

#include "../core/parallel.h"

#define BLOCK 4 ///< pixels of a packet lie in a square

/// Points of a hemisphere, and how the pixels of a tile turn them.
static void fill_kernel(const rsv_occlusion_setting *setting, rsv_occlusion_screen *screen)
{
    uint32_t count = setting->samples;
    for (uint32_t i = 0; i < count; i++) {
        float x, y, fraction = ((float)i + 0.5f) / (float)count;
        rsv_sobol_2d(i, setting->seed, &x, &y);
        // cosine-distributed directions, so that their mean is the irradiance
        screen->kernel[i] =
            v3_scale(rsv_square_to_cosine_hemisphere(x, y), 0.1f + 0.9f * fraction * fraction);
    }
    for (uint32_t cell = 0; cell < RSV_SCREEN_TILE * RSV_SCREEN_TILE; cell++) {
        float angle = 2 * RSV_PI * rsv_unit_float(rsv_hash2(setting->seed, cell));
        screen->turn[cell][0] = cosf(angle);
        screen->turn[cell][1] = sinf(angle);
    }
}

/// Depth and normals of a block of pixels.
static void fill_block(
    const rsv_occlusion_job *job, const rsv_screen_picture *s, uint32_t column, uint32_t row)
{
    uint32_t width = s->setting->width, height = s->setting->height, count = 0;
    float x[BLOCK * BLOCK] = { 0 }, y[BLOCK * BLOCK] = { 0 };
    size_t pixel[BLOCK * BLOCK];
    rsv_seen_surface seen[BLOCK * BLOCK];
    for (uint32_t j = row; j < row + BLOCK && j < height; j++)
        for (uint32_t i = column; i < column + BLOCK && i < width; i++) {
            x[count] = (float)i + 0.5f;
            y[count] = (float)j + 0.5f;
            pixel[count++] = (size_t)j * width + i;
        }
    rsv_see_surfaces(job, count, x, y, seen);
    for (uint32_t k = 0; k < count; k++)
        rsv_screen_note(s, pixel[k], &seen[k]);
}

/// One picture: passes over it, each of which needs the one before as a whole.
typedef struct screen_job {
    const rsv_occlusion_job *job;
    rsv_screen_picture picture;
} screen_job;

static void fill_rows_of_blocks(void *data, rsv_span span)
{
    const screen_job *s = data;
    for (uint32_t row = (uint32_t)span.begin; row < span.end; row++)
        for (uint32_t column = 0; column < s->picture.setting->width; column += BLOCK)
            fill_block(s->job, &s->picture, column, row * BLOCK);
}

static void open_rows(void *data, rsv_span span)
{
    const screen_job *s = data;
    for (uint32_t row = (uint32_t)span.begin; row < span.end; row++)
        for (uint32_t column = 0; column < s->picture.setting->width; column++)
            rsv_screen_open(&s->picture, column, row);
}

static void shade_rows(void *data, rsv_span span)
{
    const screen_job *s = data;
    uint32_t width = s->picture.setting->width;
    rsv_rgb *out = rsv_image_pixels(s->job->image, 0);
    for (uint32_t row = (uint32_t)span.begin; row < span.end; row++)
        for (uint32_t column = 0; column < width; column++)
            out[(size_t)row * width + column] = rsv_screen_shade(&s->picture, column, row);
}

rsv_status rsv_render_screen_occlusion(const rsv_occlusion_job *job)
{
    const rsv_occlusion *o = job->shared;
    screen_job s = { job, { &o->setting, o->screen, job->lens } };
    size_t height = o->setting.height;
    rsv_parallel_for(o->context, (height + BLOCK - 1) / BLOCK, 1, fill_rows_of_blocks, &s);
    rsv_status status = rsv_progress(o->context, "render", 0.5);
    if (status != RSV_OK) return status;
    rsv_parallel_for(o->context, height, 1, open_rows, &s);
    rsv_parallel_for(o->context, height, 1, shade_rows, &s);
    return rsv_progress(o->context, "render", 1);
}

rsv_status rsv_occlusion_screen_create(rsv_occlusion *o)
{
    size_t pixel_count = (size_t)o->setting.width * o->setting.height;
    rsv_occlusion_screen *b = o->screen = rsv_alloc(o->context, 1, sizeof *b);
    if (!b) return RSV_ERROR_MEMORY;
    b->seen = rsv_alloc(o->context, pixel_count, sizeof *b->seen);
    b->depth = rsv_alloc(o->context, pixel_count, sizeof *b->depth);
    b->openness = rsv_alloc(o->context, pixel_count, sizeof *b->openness);
    b->kernel = rsv_alloc(o->context, o->setting.samples, sizeof *b->kernel);
    if (!b->seen || !b->depth || !b->openness || !b->kernel) return RSV_ERROR_MEMORY;
    fill_kernel(&o->setting, b);
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
