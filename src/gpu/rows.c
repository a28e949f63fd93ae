/// Rays of rows of G on the device.
#include "rows.h"
#include "compact.h"
#include "lookup.h"
#include "row_kernels.h"
#include "scene.h"

#include <stdlib.h>

struct rsv_device_rows {
    rsv_gpu *gpu;
    rsv_device_rows_desc desc; ///< on the host; its arrays are only valid during creation
    rsv_gpu_block resident, room;
    rsv_gpu_scene scene;
    rsv_gpu_lookup lookup;
    rsv_row_args args;
    rsv_row_receiver *receiver;
    uint32_t *left;
    rsv_compactor compactor;
};

static size_t direction_count(const rsv_device_rows *r)
{
    return (size_t)RSV_DIRECTION_SETS * r->desc.directions->count;
}

static void lay_out_scene(void *task, rsv_gpu_block *b)
{
    rsv_device_rows *r = task;
    const rsv_device_rows_desc *d = &r->desc;
    rsv_row_args *a = &r->args;
    rsv_gpu_scene_place(&r->scene, b);
    a->scene = r->scene.there;
    a->bvh = r->scene.bvh;
    a->varied = r->scene.varied;
    a->target = rsv_gpu_place(b, 2 * d->scene->triangle_count, sizeof *a->target);
    a->x = rsv_gpu_place(b, direction_count(r), sizeof *a->x);
    a->y = rsv_gpu_place(b, direction_count(r), sizeof *a->y);
    a->z = rsv_gpu_place(b, direction_count(r), sizeof *a->z);
    rsv_gpu_lookup_place(&r->lookup, d->scene->triangle_count, b);
    a->elements = r->lookup.there;
}

static void upload_scene(rsv_device_rows *r)
{
    const rsv_device_rows_desc *d = &r->desc;
    const rsv_row_args *a = &r->args;
    const rsv_gpu_array array[] = { { a->target, d->target, 2 * d->scene->triangle_count,
                                        sizeof *a->target },
        { a->x, d->directions->x, direction_count(r), sizeof *a->x },
        { a->y, d->directions->y, direction_count(r), sizeof *a->y },
        { a->z, d->directions->z, direction_count(r), sizeof *a->z } };
    rsv_gpu_scene_upload(&r->scene, r->gpu);
    rsv_gpu_upload_all(r->gpu, array, sizeof array / sizeof array[0]);
    rsv_gpu_lookup_upload(&r->lookup, d->scene->triangle_count, r->gpu);
}

static void lay_out_room(void *task, rsv_gpu_block *b)
{
    rsv_device_rows *r = task;
    rsv_row_args *a = &r->args;
    size_t rays = (size_t)r->desc.most * a->rays;
    a->receiver = r->receiver = rsv_gpu_place(b, r->desc.most, sizeof *r->receiver);
    a->column = rsv_gpu_place(b, rays, sizeof *a->column);
    a->is_left = rsv_gpu_place(b, rays, sizeof *a->is_left);
    a->hit = rsv_gpu_place(b, rays, sizeof *a->hit);
    a->left = r->left = rsv_gpu_place(b, rays, sizeof *r->left);
    a->left_hit = rsv_gpu_place(b, rays, sizeof *a->left_hit);
    rsv_compactor_place(&r->compactor, b, rays);
}

static void destroy(rsv_device_rows *r)
{
    if (!r) return;
    rsv_gpu_release(r->gpu, &r->resident);
    rsv_gpu_release(r->gpu, &r->room);
    rsv_gpu_scene_destroy(&r->scene);
    free(r);
}

static rsv_status create(
    rsv_device *device, const rsv_device_rows_desc *desc, rsv_device_rows **rows, char *message)
{
    rsv_device_rows *r = rsv_gpu_new(sizeof *r, message);
    if (!r) return RSV_ERROR_MEMORY;
    r->gpu = (rsv_gpu *)device;
    r->desc = *desc;
    r->args.rays = desc->directions->count;
    r->args.seed = desc->seed;
    r->args.sky = desc->sky;
    r->lookup.host = desc->elements;
    rsv_status status = rsv_gpu_scene_create(desc->scene, desc->bvh, false, &r->scene, message);
    if (status == RSV_OK) {
        rsv_gpu_lay_out(r->gpu, &r->resident, lay_out_scene, r, "the scene of the rows");
        rsv_gpu_lay_out(r->gpu, &r->room, lay_out_room, r, "the rays of the rows");
        upload_scene(r);
        status = rsv_gpu_wait(r->gpu, message);
    }
    if (status == RSV_OK)
        *rows = r;
    else
        destroy(r);
    return status;
}

static rsv_status trace(rsv_device_rows *r, const rsv_row_receiver *receiver, uint32_t count,
    rsv_device_ends *ends, char *message)
{
    rsv_gpu *gpu = r->gpu;
    size_t rays = (size_t)count * r->args.rays;
    rsv_gpu_upload(gpu, r->receiver, receiver, count * sizeof *receiver);
    rsv_launch_row_ray(gpu, &r->args, rays);
    uint32_t left = rsv_compact(gpu, &r->compactor, r->args.is_left, rays, r->left);
    rsv_launch_row_left(gpu, &r->args, left);
    rsv_gpu_download(gpu, ends->column, r->args.column, rays * sizeof *ends->column);
    rsv_gpu_download(gpu, ends->left, r->left, left * sizeof *ends->left);
    rsv_gpu_download(gpu, ends->hit, r->args.left_hit, left * sizeof *ends->hit);
    ends->left_count = left;
    return rsv_gpu_wait(gpu, message);
}

const rsv_device_rows_table rsv_gpu_rows = { create, destroy, trace };
