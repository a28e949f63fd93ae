/// Pictures of ambient occlusion, in either form.
#include "occlusion.h"
#include "../core/descriptor.h"

#include "../core/core.h"
#include "../scene/scene.h"
#include "resolvent/measure.h"

#define DEFAULT_SAMPLES 16
#define SCREEN_REACH 0.05f ///< default of the screen-space form, as a share of the scene's diagonal

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

static rsv_occlusion_setting setting_of(const rsv_scene_view *view, const rsv_render_desc *desc)
{
    return (rsv_occlusion_setting){ .view = view,
        .sky = view->environment ? rsv_sky_from_environment(view->environment) : (rsv_sky){ 0 },
        .width = desc->width,
        .height = desc->height,
        .seed = desc->seed,
        .camera_rays = desc->samples,
        .samples = desc->gather_rays ? desc->gather_rays : DEFAULT_SAMPLES,
        .distance = default_distance(view, desc) };
}

rsv_status rsv_occlusion_create(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_occlusion **occlusion)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_render_desc settings = rsv_default_render_desc();
    rsv_status status = RSV_READ_DESC(rsv_render_desc, &settings, desc);
    if (status == RSV_OK) status = rsv_scene_require_committed(scene);
    if (status == RSV_OK) status = check_desc(view, &settings);
    if (status == RSV_OK) status = rsv_scene_refuse_fog(scene, "ambient occlusion");
    if (status != RSV_OK) return status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_occlusion *o = rsv_alloc(context, 1, sizeof *o);
    if (!o) return RSV_ERROR_MEMORY;
    o->context = context;
    o->setting = setting_of(view, &settings);
    RSV_TRY(rsv_tracer_create(scene, &o->tracer));
    RSV_TRY(rsv_sky_irradiance_create(context, &o->setting.sky, &o->setting.open));
    if (settings.mode == RSV_RENDER_OCCLUSION_SCREEN) RSV_TRY(rsv_occlusion_screen_create(o));
    RSV_TRY(rsv_occlusion_device_create(o->tracer, &o->setting, o->screen, &o->device));
    *occlusion = o;
    return RSV_OK;
cleanup:
    rsv_occlusion_destroy(o);
    return status;
}

void rsv_occlusion_destroy(rsv_occlusion *o)
{
    if (!o) return;
    rsv_occlusion_device_destroy(o->device);
    rsv_occlusion_screen_destroy(o);
    rsv_tracer_destroy(o->tracer);
    rsv_sky_irradiance_destroy(o->context, &o->setting.open);
    rsv_free(o->context, o);
}

rsv_status rsv_occlusion_render(rsv_occlusion *o, const rsv_camera *camera, rsv_image *image)
{
    uint32_t width = o->setting.width, height = o->setting.height;
    rsv_occlusion_job job = { o, rsv_lens_of(camera, width, height), image };
    bool done;
    if (rsv_image_width(image) != width || rsv_image_height(image) != height)
        return rsv_fail(RSV_ERROR_ARGUMENT, "occlusion: the image is not %ux%u", width, height);
    rsv_status status = rsv_occlusion_device_render(
        o->device, &job.lens, rsv_image_pixels(image, 0), &o->seconds, &done);
    if (status != RSV_OK || done) return status;
    double start = rsv_seconds();
    status = o->screen ? rsv_render_screen_occlusion(&job) : rsv_render_ray_occlusion(&job);
    o->seconds = rsv_seconds() - start;
    return status;
}

double rsv_occlusion_seconds(const rsv_occlusion *o) { return o->seconds; }

rsv_status rsv_render_occlusion(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image)
{
    rsv_status status;
    rsv_occlusion *occlusion = NULL;
    rsv_image *picture = NULL;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_render_desc settings = rsv_default_render_desc();
    RSV_TRY(RSV_READ_DESC(rsv_render_desc, &settings, desc));
    RSV_TRY(rsv_occlusion_create(scene, &settings, &occlusion));
    RSV_TRY(rsv_image_create(context, settings.width, settings.height, 1, &picture));
    RSV_TRY(rsv_occlusion_render(
        occlusion, &rsv_scene_get_view(scene)->camera[settings.camera], picture));
    *image = picture;
    picture = NULL;
cleanup:
    rsv_occlusion_destroy(occlusion);
    rsv_image_destroy(picture);
    return status;
}
