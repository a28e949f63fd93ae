#include "occlusion_device.h"

#include "../core/core.h"
#include "../trace/hierarchy.h"

struct rsv_occlusion_device {
    rsv_context *context;
    uint32_t camera_rays;
    const rsv_device_occlusion_table *table;
    rsv_device_occlusion *occlusion; ///< NULL = it has failed
};

static rsv_status bring_scene(
    rsv_occlusion_device *d, rsv_device *device, const rsv_device_occlusion_desc *desc)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    rsv_status status = d->table->create(device, desc, &d->occlusion, message);
    return status == RSV_OK ? RSV_OK : rsv_device_failed(d->context, status, message);
}

rsv_status rsv_occlusion_device_create(const rsv_tracer *tracer,
    const rsv_occlusion_setting *setting, const rsv_occlusion_screen *screen,
    rsv_occlusion_device **made)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(rsv_tracer_scene(tracer));
    rsv_device *device = rsv_context_device(context);
    rsv_device_occlusion_desc desc = { setting, screen, { 0 } };
    *made = NULL;
    if (!device) return RSV_OK;
    rsv_occlusion_device *d = rsv_alloc(context, 1, sizeof *d);
    if (!d) return RSV_ERROR_MEMORY;
    d->context = context;
    d->camera_rays = screen ? 1 : setting->camera_rays;
    d->table = device->table->occlusion;
    RSV_TRY(rsv_tracer_hierarchy(tracer, &desc.bvh));
    RSV_TRY(bring_scene(d, device, &desc));
    if (d->occlusion) {
        *made = d;
        d = NULL;
    }
cleanup:
    rsv_occlusion_device_destroy(d);
    return status;
}

void rsv_occlusion_device_destroy(rsv_occlusion_device *d)
{
    if (!d) return;
    if (d->occlusion) d->table->destroy(d->occlusion);
    rsv_free(d->context, d);
}

/// After a failure there are no pictures on the device any more.
static rsv_status check(rsv_occlusion_device *d, rsv_status status, const char *message)
{
    if (status == RSV_OK) return RSV_OK;
    d->table->destroy(d->occlusion);
    d->occlusion = NULL;
    return rsv_device_failed(d->context, status, message);
}

rsv_status rsv_occlusion_device_render(
    rsv_occlusion_device *d, const rsv_lens *lens, rsv_rgb *pixel, double *seconds, bool *done)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    rsv_status status = RSV_OK;
    double start = rsv_seconds();
    *done = false;
    for (uint32_t k = 0; d && d->occlusion && k < d->camera_rays; k++) {
        RSV_TRY(check(d, d->table->render(d->occlusion, lens, k, message), message));
        RSV_TRY(rsv_progress(d->context, "render", (double)(k + 1) / d->camera_rays));
    }
    *seconds = rsv_seconds() - start;
    if (d && d->occlusion)
        RSV_TRY(check(d, d->table->picture(d->occlusion, pixel, message), message));
    *done = d && d->occlusion;
cleanup:
    return status;
}
