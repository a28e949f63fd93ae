#include "frame_device.h"

#include "../trace/hierarchy.h"

#include <stdio.h>
#include <string.h>

struct rsv_frame_device {
    rsv_context *context;
    const rsv_light_table *table;
    uint32_t eyes;
    size_t pixels; ///< of one
    const rsv_device_frames_table *device;
    rsv_device_frames *frames; ///< NULL = it has failed
    bool dim;                  ///< the table's light is not there yet
    bool fresh[RSV_MAX_EYES];  ///< pictures that have not been fetched yet
};

// ---- support -------------------------------------------------------------------------------------

/// Notes why not.
static bool can_show(const rsv_light_view *s, const rsv_frame_desc *desc)
{
    if (desc->path_depth <= RSV_DEVICE_CHAIN_DEPTH) return true;
    rsv_log(s->context, RSV_LOG_WARNING,
        "frames are rendered on the CPU: the device follows paths to depth %d, not %u",
        RSV_DEVICE_CHAIN_DEPTH, desc->path_depth);
    return false;
}

// ---- creation -----------------------------------------------------------------------------------

/// Where the irradiance of each side is. @param received [triangle_count]
static void find_received(const rsv_light_table *t, rsv_shown_side (*received)[2])
{
    for (uint32_t k = 0; k < t->triangle_count; k++)
        for (int back = 0; back < 2; back++) {
            uint32_t face = t->solution->elements->face_of[back][k];
            bool known = face != RSV_NONE && rsv_holds_irradiance(t, face);
            received[k][back] =
                known ? rsv_face_grid(t, face) : (rsv_shown_side){ 0, 0, RSV_SHOWN_SKY };
        }
}

static rsv_status bring_stage(
    rsv_frame_device *d, rsv_device *device, const rsv_frame_desc *desc, rsv_bvh_view bvh)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    const rsv_light_view *s = d->table->solution;
    rsv_shown_side(*received)[2] =
        rsv_alloc(d->context, d->table->triangle_count, sizeof *received);
    if (!received) return RSV_ERROR_MEMORY;
    find_received(d->table, received);
    const rsv_device_stage stage = { .scene = s->scene.view,
        .bsdf = s->bsdf,
        .bvh = bvh,
        .side = (const rsv_shown_side(*)[2])d->table->side,
        .received = (const rsv_shown_side(*)[2])received,
        .cell_count = d->table->cell_count,
        .width = desc->width,
        .height = desc->height,
        .eyes = desc->eyes,
        .path_depth = desc->path_depth,
        .seed = desc->seed };
    rsv_status status = d->device->create(device, &stage, &d->frames, message);
    rsv_free(d->context, received);
    return status == RSV_OK ? RSV_OK : rsv_device_failed(d->context, status, message);
}

rsv_status rsv_frame_device_create(
    const rsv_light_table *table, const rsv_frame_desc *desc, rsv_frame_device **made)
{
    rsv_status status = RSV_OK;
    const rsv_light_view *s = table->solution;
    rsv_device *device = rsv_context_device(s->context);
    rsv_bvh_view bvh;
    *made = NULL;
    if (!device || !can_show(s, desc)) return RSV_OK;
    rsv_frame_device *d = rsv_alloc(s->context, 1, sizeof *d);
    if (!d) return RSV_ERROR_MEMORY;
    *d = (rsv_frame_device){ .context = s->context,
        .table = table,
        .eyes = desc->eyes,
        .pixels = (size_t)desc->width * desc->height,
        .device = device->table->frames,
        .dim = true };
    RSV_TRY(rsv_tracer_hierarchy(s->scene.tracer, &bvh));
    RSV_TRY(bring_stage(d, device, desc, bvh));
    if (d->frames) {
        *made = d;
        d = NULL;
    }
cleanup:
    rsv_frame_device_destroy(d);
    return status;
}

void rsv_frame_device_destroy(rsv_frame_device *d)
{
    if (!d) return;
    if (d->frames) d->device->destroy(d->frames);
    rsv_free(d->context, d);
}

void rsv_frame_device_refresh(rsv_frame_device *d)
{
    if (d) d->dim = true;
}

// ---- frames -------------------------------------------------------------------------------------

/// After a failure there are no frames on the device any more.
static rsv_status check(rsv_frame_device *d, rsv_status status, const char *message)
{
    if (status == RSV_OK) return RSV_OK;
    d->device->destroy(d->frames);
    d->frames = NULL;
    return rsv_device_failed(d->context, status, message);
}

static rsv_status bring_light(rsv_frame_device *d)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    const rsv_light_view *s = d->table->solution;
    const rsv_device_light light = { .cell = d->table->cell,
        .scene = s->scene.view,
        .bsdf = s->bsdf,
        .lights = s->lights,
        .emission = rsv_shows_emission(d->table) };
    if (!d->dim) return RSV_OK;
    d->dim = false;
    return check(d, d->device->set_light(d->frames, &light, message), message);
}

static rsv_device_eye eye_of(const rsv_eye_picture *e)
{
    return (rsv_device_eye){ .lens = e->aim.lens,
        .place_x = e->aim.place_x,
        .place_y = e->aim.place_y,
        .spread = e->spread,
        .medium = e->medium,
        .tone = e->tone,
        .samples = e->samples };
}

rsv_status rsv_frame_device_render(
    rsv_frame_device *d, const rsv_eye_picture *picture, uint64_t *path_rays, bool *done)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    rsv_device_eye eye[RSV_MAX_EYES];
    rsv_status status = d && d->frames ? bring_light(d) : RSV_OK;
    *done = false;
    if (status != RSV_OK || !d || !d->frames) return status;
    for (uint32_t k = 0; k < d->eyes; k++) {
        eye[k] = eye_of(&picture[k]);
        d->fresh[k] = true;
    }
    status = check(d, d->device->render(d->frames, eye, path_rays, message), message);
    *done = d->frames != NULL;
    return status;
}

void rsv_frame_device_pixels(rsv_frame_device *d, uint32_t eye, uint8_t (*pixel)[4])
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    if (!d->frames || !d->fresh[eye]) return;
    d->fresh[eye] = false;
    if (check(d, d->device->pixels(d->frames, eye, pixel, message), message) != RSV_OK ||
        !d->frames)
        memset(pixel, 0, d->pixels * sizeof *pixel); // a lost frame is black, not an older one
}

void rsv_frame_device_sums(rsv_frame_device *d, uint32_t eye, float (*sum)[4])
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    if (!d->frames) return;
    if (check(d, d->device->sums(d->frames, eye, sum, message), message) != RSV_OK || !d->frames)
        memset(sum, 0, d->pixels * sizeof *sum);
}
