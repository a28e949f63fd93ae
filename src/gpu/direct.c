#include "direct.h"
#include "direct_kernels.h"
#include "scattering.h"
#include "sources.h"

#include <stdlib.h>

struct rsv_device_direct {
    rsv_gpu *gpu;
    rsv_device_direct_desc desc; ///< on the host; its arrays are only valid during creation
    rsv_gpu_block resident, room;
    rsv_gpu_scene scene;
    rsv_gpu_sources sources;
    rsv_gpu_scattering scattering;
    rsv_node_receivers *receivers;
    bool any_sampled;
    uint32_t punctual_count;
    rsv_direct_args args;
};

static void lay_out_scene(void *task, rsv_gpu_block *b)
{
    rsv_device_direct *d = task;
    rsv_gpu_scene_place(&d->scene, b);
    rsv_gpu_sources_place(&d->sources, &d->scene, b);
    rsv_gpu_scattering_place(&d->scattering, b);
}

static void lay_out_room(void *task, rsv_gpu_block *b)
{
    rsv_device_direct *d = task;
    rsv_direct_args *a = &d->args;
    size_t most = d->desc.most;
    a->receivers = d->receivers = rsv_gpu_place(b, most, sizeof *a->receivers);
    a->local = rsv_gpu_place(b, most * a->setting.points, sizeof *a->local);
    a->sums = rsv_gpu_place(b, most, sizeof *a->sums);
    a->estimate = rsv_gpu_place(b, most, sizeof *a->estimate);
}

static void upload_scene(rsv_device_direct *d)
{
    rsv_gpu_scene_upload(&d->scene, d->gpu);
    rsv_gpu_sources_upload(&d->sources, &d->scene, d->gpu);
    rsv_gpu_scattering_upload(&d->scattering, d->desc.setting.bsdf, d->gpu);
}

static void destroy(rsv_device_direct *d)
{
    if (!d) return;
    rsv_gpu_release(d->gpu, &d->resident);
    rsv_gpu_release(d->gpu, &d->room);
    rsv_gpu_scene_destroy(&d->scene);
    rsv_gpu_scattering_destroy(&d->scattering);
    free(d);
}

static void set_constants(rsv_device_direct *d)
{
    const rsv_lights *lights = d->desc.setting.lights;
    const rsv_environment_light *sky = lights->environment;
    d->sources.host = lights;
    d->any_sampled =
        lights->sampled_count > 0 || (sky && (sky->sampler.flux > 0 || sky->sun_count));
    d->punctual_count = rsv_punctual_count(lights);
    d->args.setting = d->desc.setting;
}

/// Whether the emission of a source must be looked up.
static bool any_varies(const rsv_lights *lights)
{
    for (size_t k = 0; k < lights->sampled_count; k++)
        if (lights->emitter[lights->sampled[k]].varies) return true;
    return false;
}

static rsv_status create_materials(rsv_device_direct *d, char *message)
{
    const rsv_device_direct_desc *desc = &d->desc;
    rsv_status status = rsv_gpu_scene_create(
        desc->scene, desc->bvh, any_varies(desc->setting.lights), &d->scene, message);
    if (status != RSV_OK) return status;
    return rsv_gpu_scattering_create(desc->scene->material_count, &d->scattering, message);
}

static rsv_status create(rsv_device *device, const rsv_device_direct_desc *desc,
    rsv_device_direct **direct, char *message)
{
    rsv_device_direct *d = rsv_gpu_new(sizeof *d, message);
    if (!d) return RSV_ERROR_MEMORY;
    d->gpu = (rsv_gpu *)device;
    d->desc = *desc;
    set_constants(d);
    rsv_status status = create_materials(d, message);
    if (status == RSV_OK) {
        rsv_gpu_lay_out(d->gpu, &d->resident, lay_out_scene, d, "the scene of the direct light");
        rsv_gpu_lay_out(d->gpu, &d->room, lay_out_room, d, "the receivers of the direct light");
        d->args.bvh = d->scene.bvh;
        d->args.varied = d->scene.varied;
        d->args.setting.lights = d->sources.there;
        d->args.setting.bsdf = d->scattering.bsdf;
        upload_scene(d);
        status = rsv_gpu_wait(d->gpu, message);
    }
    if (status == RSV_OK)
        *direct = d;
    else
        destroy(d);
    return status;
}

static rsv_status estimate(rsv_device_direct *d, const rsv_node_receivers *receivers,
    uint32_t count, rsv_direct_rays rays, rsv_direct_estimate *estimate, char *message)
{
    rsv_direct_args *a = &d->args;
    a->rays = rays;
    rsv_gpu_upload(d->gpu, d->receivers, receivers, count * sizeof *receivers);
    if (d->any_sampled) {
        rsv_launch_direct_weigh(d->gpu, a, (size_t)count * a->setting.points);
        rsv_launch_direct_emitters(d->gpu, a, count);
        rsv_launch_direct_finish(d->gpu, a, count);
    } else {
        rsv_launch_direct_nothing(d->gpu, a, count);
    }
    for (a->light = 0; a->light < d->punctual_count; a->light++)
        rsv_launch_direct_punctual(d->gpu, a, count);
    rsv_gpu_download(d->gpu, estimate, a->estimate, count * sizeof *estimate);
    return rsv_gpu_wait(d->gpu, message);
}

const rsv_device_direct_table rsv_gpu_direct = { create, destroy, estimate };
