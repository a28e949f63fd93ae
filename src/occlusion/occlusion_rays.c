/// Ambient occlusion by rays: the share of a surface's hemisphere, weighted by the cosine, from which light
/// would arrive unhindered.
#include "occlusion.h"

#include "../core/parallel.h"
#include "../trace/packet.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH

/// Share of the directions of one camera ray, of all those of the pixel, that nothing hides.
static float find_openness(
    const rsv_occlusion *o, const rsv_surface_point *point, uint32_t first, uint32_t seed)
{
    const rsv_occlusion_setting *s = &o->setting;
    rsv_occlusion_spot spot = rsv_occlusion_spot_of(point);
    uint32_t open = 0;
    for (uint32_t done = 0; done < s->samples; done += LANES) {
        rsv_ray_packet packet = { 0 };
        memset(packet.mask, 0xff, sizeof packet.mask);
        uint32_t aimed = 0;
        for (uint32_t k = 0; k < LANES; k++) {
            rsv_ray ray;
            bool aims =
                rsv_occlusion_ray(s, &spot, first + done + k, seed, &ray) && done + k < s->samples;
            aimed |= (uint32_t)aims << k;
            if (!aims) ray.t_max = -1;
            rsv_packet_set_ray(&packet, k, ray);
        }
        rsv_tracer_occluded_packet(o->tracer, &packet, false);
        for (uint32_t k = 0; k < LANES; k++)
            open += (aimed >> k & 1) && packet.t_max[k] != -INFINITY;
    }
    return (float)open / (float)s->samples;
}

/// One row: camera rays in packets, then the rays of each surface that they meet.
static void render_row(const rsv_occlusion_job *job, uint32_t row, rsv_rgb *pixels)
{
    const rsv_occlusion_setting *s = &job->shared->setting;
    uint32_t samples = s->camera_rays, width = s->width;
    memset(pixels, 0, width * sizeof *pixels);
    for (uint32_t first = 0; first < width * samples; first += LANES) {
        uint32_t left = width * samples - first, count = left < LANES ? left : LANES;
        float x[LANES], y[LANES];
        rsv_seen_surface seen[LANES];
        for (uint32_t k = 0; k < count; k++)
            rsv_occlusion_place(s, row, (first + k) / samples, (first + k) % samples, &x[k], &y[k]);
        rsv_see_surfaces(job, count, x, y, seen);
        for (uint32_t k = 0; k < count; k++) {
            uint32_t column = (first + k) / samples, i = (first + k) % samples;
            float openness = 0;
            if (!rgb_is_black(seen[k].ambient))
                openness = find_openness(job->shared, &seen[k].point, i * s->samples,
                    rsv_occlusion_seed(s, row, column));
            rsv_rgb light = rgb_mad(seen[k].emission, openness, seen[k].ambient);
            pixels[column] = rgb_mad(pixels[column], 1 / (float)samples, light);
        }
    }
}

typedef struct picture_job {
    const rsv_occlusion_job *job;
    atomic_size_t done; ///< rows
} picture_job;

static void render_rows(void *data, rsv_span span)
{
    picture_job *picture = data;
    const rsv_occlusion_job *job = picture->job;
    rsv_context *context = job->shared->context;
    rsv_rgb *pixels = rsv_image_pixels(job->image, 0);
    for (size_t row = span.begin; row < span.end; row++) {
        if (rsv_cancelled(context)) continue;
        render_row(job, (uint32_t)row, pixels + row * job->shared->setting.width);
        rsv_item_done(
            context, "render", span.worker, &picture->done, job->shared->setting.height);
    }
}

rsv_status rsv_render_ray_occlusion(const rsv_occlusion_job *job)
{
    rsv_context *context = job->shared->context;
    picture_job picture = { job, 0 };
    rsv_parallel_for(context, job->shared->setting.height, 1, render_rows, &picture);
    return rsv_progress(context, "render", 1);
}
