#include "occlusion.h"
#include "occlusion_kernels.h"
#include "scene.h"

#include <stdlib.h>

/// Rays in flight at a time: enough for any device.
#define RAYS_AT_A_TIME ((size_t)1 << 22)

struct rsv_device_occlusion {
    rsv_gpu *gpu;
    rsv_device_occlusion_desc
        desc; ///< on the host; its pointers are only valid during creation
    rsv_gpu_block resident, room;
    rsv_gpu_scene scene;
    rsv_occlusion_setting setting; ///< with addresses on the device, as the next one
    rsv_occlusion_screen screen;
    rsv_occlusion_setting *setting_there;
    rsv_occlusion_screen *screen_there;
    bool on_screen;
    size_t pixels, most; ///< of the picture; whose rays are traced together
    rsv_occlusion_args args;
};

static size_t sky_pixels(const rsv_sky *sky)
{
    return sky->pixel ? (size_t)sky->width * sky->height : 0;
}

static size_t open_nodes(const rsv_sky_irradiance *open)
{
    return open->node ? (size_t)RSV_SKY_IRRADIANCE_NODES * RSV_SKY_IRRADIANCE_NODES : 0;
}

/// An array that may be missing.
static void *place_some(rsv_gpu_block *b, size_t count, size_t size)
{
    return count ? rsv_gpu_place(b, count, size) : NULL;
}

static void lay_out_scene(void *task, rsv_gpu_block *b)
{
    rsv_device_occlusion *o = task;
    const rsv_occlusion_setting *s = o->desc.setting;
    rsv_gpu_scene_place(&o->scene, b);
    o->setting_there = rsv_gpu_place(b, 1, sizeof *o->setting_there);
    o->screen_there = rsv_gpu_place(b, 1, sizeof *o->screen_there);
    o->setting.view = o->scene.there;
    o->setting.sky.pixel = place_some(b, sky_pixels(&s->sky), sizeof *s->sky.pixel);
    o->setting.open.node = place_some(b, open_nodes(&s->open), sizeof *s->open.node);
    o->screen.kernel = place_some(b, o->on_screen ? s->samples : 0, sizeof *o->screen.kernel);
}

static void lay_out_room(void *task, rsv_gpu_block *b)
{
    rsv_device_occlusion *o = task;
    o->args.pixel = rsv_gpu_place(b, o->pixels, sizeof *o->args.pixel);
    o->args.seen = o->screen.seen = rsv_gpu_place(b, o->pixels, sizeof *o->args.seen);
    if (o->on_screen) {
        o->screen.depth = rsv_gpu_place(b, o->pixels, sizeof *o->screen.depth);
        o->screen.openness = rsv_gpu_place(b, o->pixels, sizeof *o->screen.openness);
    } else {
        o->args.open = rsv_gpu_place(b, o->most * o->setting.samples, sizeof *o->args.open);
    }
}

static void upload_scene(rsv_device_occlusion *o)
{
    const rsv_occlusion_setting *s = o->desc.setting;
    const rsv_gpu_array array[] = { { o->setting_there, &o->setting, 1, sizeof o->setting },
        { o->screen_there, &o->screen, 1, sizeof o->screen },
        { o->setting.sky.pixel, s->sky.pixel, sky_pixels(&s->sky), sizeof *s->sky.pixel },
        { o->setting.open.node, s->open.node, open_nodes(&s->open), sizeof *s->open.node },
        { o->screen.kernel, o->on_screen ? o->desc.screen->kernel : NULL,
            o->on_screen ? s->samples : 0, sizeof *o->screen.kernel } };
    rsv_gpu_scene_upload(&o->scene, o->gpu);
    rsv_gpu_upload_all(o->gpu, array, sizeof array / sizeof array[0]);
}

static void set_constants(rsv_device_occlusion *o)
{
    const rsv_occlusion_setting *s = o->desc.setting;
    size_t most = RAYS_AT_A_TIME / s->samples + 1;
    o->setting = *s;
    o->on_screen = o->desc.screen != NULL;
    if (o->on_screen) o->screen = *o->desc.screen;
    o->pixels = (size_t)s->width * s->height;
    o->most = most < o->pixels ? most : o->pixels;
}

static void destroy(rsv_device_occlusion *o)
{
    if (!o) return;
    rsv_gpu_release(o->gpu, &o->resident);
    rsv_gpu_release(o->gpu, &o->room);
    rsv_gpu_scene_destroy(&o->scene);
    free(o);
}

static bool any_varies(const rsv_device_occlusion_desc *desc)
{
    const rsv_scene_view *view = desc->setting->view;
    for (size_t m = 0; m < view->material_count; m++)
        if (view->material_varies[m]) return true;
    return desc->bvh.holes != NULL;
}

static rsv_status create(rsv_device *device, const rsv_device_occlusion_desc *desc,
    rsv_device_occlusion **occlusion, char *message)
{
    rsv_device_occlusion *o = rsv_gpu_new(sizeof *o, message);
    if (!o) return RSV_ERROR_MEMORY;
    o->gpu = (rsv_gpu *)device;
    o->desc = *desc;
    set_constants(o);
    rsv_status status =
        rsv_gpu_scene_create(desc->setting->view, desc->bvh, true, &o->scene, message);
    if (status == RSV_OK) {
        rsv_gpu_lay_out(o->gpu, &o->resident, lay_out_scene, o, "the scene of the occlusion");
        rsv_gpu_lay_out(o->gpu, &o->room, lay_out_room, o, "the picture of the occlusion");
        o->args.setting = o->setting_there;
        o->args.screen = o->screen_there;
        o->args.bvh = o->scene.bvh;
        o->args.varied = any_varies(desc);
        upload_scene(o);
        status = rsv_gpu_wait(o->gpu, message);
    }
    if (status == RSV_OK)
        *occlusion = o;
    else
        destroy(o);
    return status;
}

/// One camera ray per pixel, and rays from its hit.
static void render_by_rays(rsv_device_occlusion *o)
{
    rsv_occlusion_args *a = &o->args;
    rsv_launch_occlusion_camera(o->gpu, a, o->pixels);
    for (size_t first = 0; first < o->pixels; first += o->most) {
        size_t count = o->pixels - first < o->most ? o->pixels - first : o->most;
        a->first_pixel = (uint32_t)first;
        rsv_launch_occlusion_ray(o->gpu, a, count * o->setting.samples);
        rsv_launch_occlusion_add(o->gpu, a, count);
    }
}

static rsv_status render(
    rsv_device_occlusion *o, const rsv_lens *lens, uint32_t camera_ray, char *message)
{
    o->args.lens = *lens;
    o->args.camera_ray = camera_ray;
    if (o->on_screen) {
        rsv_launch_screen_camera(o->gpu, &o->args, o->pixels);
        rsv_launch_screen_open(o->gpu, &o->args, o->pixels);
        rsv_launch_screen_shade(o->gpu, &o->args, o->pixels);
    } else {
        render_by_rays(o);
    }
    return rsv_gpu_wait(o->gpu, message);
}

static rsv_status picture(rsv_device_occlusion *o, rsv_rgb *pixel, char *message)
{
    rsv_gpu_download(o->gpu, pixel, o->args.pixel, o->pixels * sizeof *pixel);
    return rsv_gpu_wait(o->gpu, message);
}

const rsv_device_occlusion_table rsv_gpu_occlusion = { create, destroy, render, picture };
