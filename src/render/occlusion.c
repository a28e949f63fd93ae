/// Ambient occlusion by rays: the share of a surface's hemisphere, weighted by the cosine, from which light
/// would arrive unhindered.
#include "occlusion.h"

#include "../core/core_internal.h"
#include "../core/stratified.h"
#include "../scene/material_at.h"

#include <string.h>

#define DEFAULT_SAMPLES 16
#define LANES RSV_PACKET_WIDTH
#define SCREEN_REACH 0.05f ///< default of the screen-space form, as a share of the scene's diagonal

/// What a white surface without obstacles reflects.
static rsv_rgb ambient_radiance(const rsv_occlusion *o, rsv_vec3 normal)
{
    if (!o->sky.pixel) return rgb_gray(1);
    return rgb_scale(rsv_sky_irradiance_at(&o->sky_irradiance, normal), 1 / RSV_PI);
}

static rsv_seen_surface surface_at(
    const rsv_occlusion *o, rsv_vec3 direction, uint32_t triangle, float u, float v)
{
    rsv_seen_surface seen = { .hit = true };
    const rsv_scene_view *view = o->view;
    uint32_t index = view->triangle_material[triangle];
    rsv_material varied;
    const rsv_material *material = &view->material[index];
    if (view->material_varies[index]) {
        varied = rsv_material_at(view, triangle, u, v, 0);
        material = &varied;
    }
    seen.point = rsv_surface_point_at(view, triangle, u, v, false);
    bool back = v3_dot(seen.point.geometric, direction) > 0;
    if (back) {
        seen.point.geometric = v3_neg(seen.point.geometric);
        seen.point.normal = v3_neg(seen.point.normal);
    }
    if (back && !material->double_sided && material->transmission == 0) return seen;
    if (material->unlit) {
        seen.emission = material->base_color;
        return seen;
    }
    seen.ambient = rgb_mul(material->base_color, ambient_radiance(o, seen.point.normal));
    if (!back || material->double_sided) seen.emission = material->emission;
    return seen;
}

void rsv_see_surfaces(const rsv_occlusion_job *job, uint32_t count, const float *x, const float *y,
    rsv_seen_surface *seen)
{
    const rsv_occlusion *o = job->shared;
    rsv_ray_packet packet = { 0 };
    memset(packet.mask, 0xff, sizeof packet.mask);
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t place = k < count ? k : 0;
        rsv_ray ray = rsv_lens_ray(&job->lens, x[place], y[place]);
        packet.origin_x[k] = ray.origin.x;
        packet.origin_y[k] = ray.origin.y;
        packet.origin_z[k] = ray.origin.z;
        packet.direction_x[k] = ray.direction.x;
        packet.direction_y[k] = ray.direction.y;
        packet.direction_z[k] = ray.direction.z;
        packet.t_max[k] = k < count ? INFINITY : -1;
    }
    rsv_tracer_closest_packet(o->tracer, &packet, true);
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 direction =
            v3(packet.direction_x[k], packet.direction_y[k], packet.direction_z[k]);
        if (packet.triangle[k] != RSV_NONE)
            seen[k] = surface_at(o, direction, packet.triangle[k], packet.u[k], packet.v[k]);
        else
            seen[k] = (rsv_seen_surface){ .emission = rsv_sky_radiance(&o->sky, direction) };
    }
}

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

rsv_status rsv_occlusion_create(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_occlusion **occlusion)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_status status = check_desc(view, desc);
    if (status != RSV_OK) return status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_occlusion *o = rsv_alloc(context, 1, sizeof *o);
    if (!o) return RSV_ERROR_MEMORY;
    o->context = context;
    o->view = view;
    o->desc = *desc;
    o->samples = desc->gather_rays ? desc->gather_rays : DEFAULT_SAMPLES;
    o->distance = default_distance(view, desc);
    if (view->environment) o->sky = rsv_sky_from_environment(view->environment);
    RSV_TRY(rsv_tracer_create(scene, &o->tracer));
    RSV_TRY(rsv_sky_irradiance_create(context, &o->sky, &o->sky_irradiance));
    if (desc->mode == RSV_RENDER_OCCLUSION_SCREEN) RSV_TRY(rsv_occlusion_screen_create(o));
    *occlusion = o;
    return RSV_OK;
cleanup:
    rsv_occlusion_destroy(o);
    return status;
}

void rsv_occlusion_destroy(rsv_occlusion *o)
{
    if (!o) return;
    rsv_occlusion_screen_destroy(o);
    rsv_tracer_destroy(o->tracer);
    rsv_sky_irradiance_destroy(o->context, &o->sky_irradiance);
    rsv_free(o->context, o);
}

rsv_status rsv_occlusion_render(rsv_occlusion *o, const rsv_camera *camera, rsv_image *image)
{
    rsv_occlusion_job job = { o, rsv_lens_of(camera, o->desc.width, o->desc.height), image };
    if (rsv_image_width(image) != o->desc.width || rsv_image_height(image) != o->desc.height)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "occlusion: the image is not %ux%u", o->desc.width, o->desc.height);
    return o->screen ? rsv_render_screen_occlusion(&job) : rsv_render_ray_occlusion(&job);
}

rsv_status rsv_render_occlusion(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image)
{
    rsv_status status;
    rsv_occlusion *occlusion = NULL;
    rsv_image *picture = NULL;
    rsv_context *context = rsv_scene_get_context(scene);
    RSV_TRY(rsv_occlusion_create(scene, desc, &occlusion));
    RSV_TRY(rsv_image_create(context, desc->width, desc->height, 1, &picture));
    RSV_TRY(
        rsv_occlusion_render(occlusion, &rsv_scene_get_view(scene)->camera[desc->camera], picture));
    *image = picture;
    picture = NULL;
cleanup:
    rsv_occlusion_destroy(occlusion);
    rsv_image_destroy(picture);
    return status;
}
