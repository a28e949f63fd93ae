/// Ambient occlusion by rays: the share of a surface's hemisphere, weighted by the cosine, from which light
/// would arrive unhindered.
#include "occlusion.h"

#include "../core/core_internal.h"
#include "../core/stratified.h"
#include "../scene/material_at.h"
#include "../trace/camera_ray.h"

#include <string.h>

#define DEFAULT_SAMPLES 16
#define LANES RSV_PACKET_WIDTH
#define SCREEN_REACH 0.05f ///< default of the screen-space form, as a share of the scene's diagonal

/// What a white surface without obstacles reflects.
static rsv_rgb ambient_radiance(const rsv_occlusion_job *job, rsv_vec3 normal)
{
    if (!job->sky.pixel) return rgb_gray(1);
    return rgb_scale(rsv_sky_irradiance_at(&job->sky_irradiance, normal), 1 / RSV_PI);
}

rsv_seen_surface rsv_see_surface(const rsv_occlusion_job *job, float x, float y)
{
    rsv_ray ray = rsv_camera_ray(job->camera, job->desc->width, job->desc->height, x, y);
    rsv_seen_surface seen = { .hit = false };
    rsv_hit hit;
    if (!rsv_tracer_closest(job->tracer, &ray, &hit)) {
        if (job->sky.pixel) seen.emission = rsv_sky_radiance(&job->sky, ray.direction);
        return seen;
    }
    rsv_material material = rsv_material_at(job->view, hit.triangle, hit.u, hit.v, 0);
    seen.hit = true;
    seen.point = rsv_surface_point_at(job->view, hit.triangle, hit.u, hit.v, false);
    bool back = v3_dot(seen.point.geometric, ray.direction) > 0;
    if (back) seen.point = rsv_surface_point_at(job->view, hit.triangle, hit.u, hit.v, true);
    if (back && !material.double_sided && material.transmission == 0) return seen;
    if (material.unlit) {
        seen.emission = material.base_color;
        return seen;
    }
    seen.ambient = rgb_mul(material.base_color, ambient_radiance(job, seen.point.normal));
    if (!back || material.double_sided) seen.emission = material.emission;
    return seen;
}

/// Share of the directions of one camera ray, of `total` in the pixel, that nothing hides.
static float find_openness(const rsv_occlusion_job *job, const rsv_surface_point *point,
    uint32_t first, uint32_t total, uint32_t seed)
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

static rsv_rgb render_pixel(const rsv_occlusion_job *job, uint32_t column, uint32_t row)
{
    uint32_t samples = job->desc->samples, total = samples * job->samples;
    uint32_t seed = rsv_hash3(job->desc->seed, row, column);
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t i = 0; i < samples; i++) {
        float x, y;
        rsv_stratified_2d(i, samples, seed, &x, &y);
        rsv_seen_surface seen = rsv_see_surface(job, (float)column + x, (float)row + y);
        float openness = 0;
        if (!rgb_is_black(seen.ambient))
            openness = find_openness(
                job, &seen.point, i * job->samples, total, rsv_hash2(seed, 0x5bd1e995u));
        sum = rgb_add(sum, rgb_mad(seen.emission, openness, seen.ambient));
    }
    return rgb_scale(sum, 1 / (float)samples);
}

rsv_status rsv_render_ray_occlusion(const rsv_occlusion_job *job)
{
    uint32_t width = job->desc->width, height = job->desc->height, done = 0;
    rsv_rgb *pixels = rsv_image_pixels(job->image, 0);
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(job->context))
    for (uint32_t row = 0; row < height; row++) {
        if (rsv_cancelled(job->context)) continue;
        for (uint32_t column = 0; column < width; column++)
            pixels[(size_t)row * width + column] = render_pixel(job, column, row);
        uint32_t finished;
#pragma omp atomic capture
        finished = ++done;
        if (rsv_thread_index() == 0)
            rsv_progress(job->context, "render", (double)finished / height);
    }
    return rsv_progress(job->context, "render", 1);
}

static rsv_status check_desc(const rsv_scene_view *view, const rsv_render_desc *desc)
{
    if (desc->mode != RSV_RENDER_OCCLUSION && desc->mode != RSV_RENDER_OCCLUSION_SCREEN)
        return rsv_fail(RSV_ERROR_ARGUMENT, "occlusion: the mode is not one of occlusion");
    if (desc->width == 0 || desc->height == 0 || desc->width > 65536 || desc->height > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT, "occlusion: size %ux%u is not in 1x1 .. 65536x65536",
            desc->width, desc->height);
    if (desc->samples == 0 || (uint64_t)desc->samples * desc->gather_rays > 1u << 30)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "occlusion: %u samples of %u rays are not possible for a pixel", desc->samples,
            desc->gather_rays);
    if (!(desc->occlusion_distance >= 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "occlusion: a distance of %g m is not possible",
            (double)desc->occlusion_distance);
    if (desc->camera >= view->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "occlusion: camera %u does not exist, the scene has %zu", desc->camera,
            view->camera_count);
    return RSV_OK;
}

static float default_distance(const rsv_scene_view *view, const rsv_render_desc *desc)
{
    if (desc->occlusion_distance > 0) return desc->occlusion_distance;
    if (desc->mode == RSV_RENDER_OCCLUSION) return INFINITY;
    return SCREEN_REACH * v3_length(v3_sub(view->bounds_max, view->bounds_min));
}

rsv_status rsv_render_occlusion(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image)
{
    rsv_status status;
    rsv_tracer *tracer = NULL;
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_occlusion_job job = { .context = rsv_scene_get_context(scene), .view = view, .desc = desc };
    RSV_TRY(check_desc(view, desc));
    RSV_TRY(rsv_image_create(job.context, desc->width, desc->height, 1, &job.image));
    RSV_TRY(rsv_tracer_create(scene, &tracer));
    job.tracer = tracer;
    if (view->environment) job.sky = rsv_sky_from_environment(view->environment);
    RSV_TRY(rsv_sky_irradiance_create(job.context, &job.sky, &job.sky_irradiance));
    job.camera = &view->camera[desc->camera];
    job.samples = desc->gather_rays ? desc->gather_rays : DEFAULT_SAMPLES;
    job.distance = default_distance(view, desc);
    if (desc->mode == RSV_RENDER_OCCLUSION)
        RSV_TRY(rsv_render_ray_occlusion(&job));
    else
        RSV_TRY(rsv_render_screen_occlusion(&job));
    *image = job.image;
    job.image = NULL;
cleanup:
    rsv_tracer_destroy(tracer);
    rsv_sky_irradiance_destroy(job.context, &job.sky_irradiance);
    rsv_image_destroy(job.image);
    return status;
}
