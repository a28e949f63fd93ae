/// Ambient occlusion by rays: the share of a surface's hemisphere, weighted by the cosine, from which light
/// would arrive unhindered.
#include "occlusion.h"

#include "../core/stratified.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH

/// Share of the directions of one camera ray, of `total` in the pixel, that nothing hides.
static float find_openness(const rsv_occlusion *job, const rsv_surface_point *point, uint32_t first,
    uint32_t total, uint32_t seed)
{
    rsv_vec3 origin = rsv_offset_origin(point->position, point->geometric, point->extent), t, b;
    uint32_t open = 0;
    v3_frame(point->normal, &t, &b);
    for (uint32_t done = 0; done < job->samples; done += LANES) {
        rsv_ray_packet packet = { 0 };
        memset(packet.mask, 0xff, sizeof packet.mask);
        for (uint32_t k = 0; k < LANES; k++) {
            float x, y;
            rsv_stratified_2d((first + done + k) % total, total, seed, &x, &y);
            rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
            rsv_vec3 direction = v3_mad(v3_mad(v3_scale(t, d.x), d.y, b), d.z, point->normal);
            bool above = v3_dot(direction, point->geometric) > 0;
            packet.origin_x[k] = origin.x;
            packet.origin_y[k] = origin.y;
            packet.origin_z[k] = origin.z;
            packet.direction_x[k] = direction.x;
            packet.direction_y[k] = direction.y;
            packet.direction_z[k] = direction.z;
            packet.t_max[k] = above && done + k < job->samples ? job->distance : -1;
        }
        uint32_t aimed = 0;
        for (uint32_t k = 0; k < LANES; k++)
            aimed |= (uint32_t)(packet.t_max[k] > 0) << k;
        rsv_tracer_occluded_packet(job->tracer, &packet, false);
        for (uint32_t k = 0; k < LANES; k++)
            open += (aimed >> k & 1) && packet.t_max[k] != -INFINITY;
    }
    return (float)open / (float)job->samples;
}

/// One row: camera rays in packets, then the rays of each surface that they meet.
static void render_row(const rsv_occlusion_job *job, uint32_t row, rsv_rgb *pixels)
{
    const rsv_occlusion *o = job->shared;
    uint32_t samples = o->desc.samples, width = o->desc.width;
    memset(pixels, 0, width * sizeof *pixels);
    for (uint32_t first = 0; first < width * samples; first += LANES) {
        uint32_t left = width * samples - first, count = left < LANES ? left : LANES;
        float x[LANES], y[LANES];
        rsv_seen_surface seen[LANES];
        for (uint32_t k = 0; k < count; k++) {
            uint32_t column = (first + k) / samples, i = (first + k) % samples;
            rsv_stratified_2d(i, samples, rsv_hash3(o->desc.seed, row, column), &x[k], &y[k]);
            x[k] += (float)column, y[k] += (float)row;
        }
        rsv_see_surfaces(job, count, x, y, seen);
        for (uint32_t k = 0; k < count; k++) {
            uint32_t column = (first + k) / samples, i = (first + k) % samples;
            uint32_t seed = rsv_hash2(rsv_hash3(o->desc.seed, row, column), 0x5bd1e995u);
            float openness = 0;
            if (!rgb_is_black(seen[k].ambient))
                openness =
                    find_openness(o, &seen[k].point, i * o->samples, samples * o->samples, seed);
            rsv_rgb light = rgb_mad(seen[k].emission, openness, seen[k].ambient);
            pixels[column] = rgb_mad(pixels[column], 1 / (float)samples, light);
        }
    }
}

rsv_status rsv_render_ray_occlusion(const rsv_occlusion_job *job)
{
    const rsv_occlusion *o = job->shared;
    uint32_t width = o->desc.width, height = o->desc.height, done = 0;
    rsv_rgb *pixels = rsv_image_pixels(job->image, 0);
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(o->context))
    for (uint32_t row = 0; row < height; row++) {
        if (rsv_cancelled(o->context)) continue;
        render_row(job, row, pixels + (size_t)row * width);
        uint32_t finished;
#pragma omp atomic capture
        finished = ++done;
        if (rsv_thread_index() == 0) rsv_progress(o->context, "render", (double)finished / height);
    }
    return rsv_progress(o->context, "render", 1);
}
