/// Frames on the device: what is resident, and the waves of a frame.
#include "frames.h"
#include "compact.h"
#include "frame_kernels.h"
#include "geometry.h"

#include <stdlib.h>

/// Of the device's memory, what branches on their way may take, all waves together.
#define TRAVELLER_SHARE 16
#define TRAVELLER_BYTES ((size_t)1 << 30)

struct rsv_device_frames {
    rsv_gpu *gpu;
    rsv_device_stage stage; ///< on the host; its arrays are valid during creation alone
    size_t pixels;          ///< of all eyes
    size_t slots;           ///< of a wave
    rsv_gpu_block scene, surroundings, room;
    rsv_gpu_geometry geometry;
    rsv_gpu_stage there; ///< with addresses on the device
    rsv_gpu_stage *stage_there;
    rsv_frame_args args;
    rsv_compactor compactor;
    uint32_t *begin_list;         ///< [pixels]
    uint32_t *list;               ///< [chain_depth][slots]
    rsv_gpu_traveller *traveller; ///< [chain_depth][slots]
};

// ---- what is resident ---------------------------------------------------------------------------

static void lay_out_scene(void *task, rsv_gpu_block *b)
{
    rsv_device_frames *f = task;
    const rsv_scene_view *view = f->stage.scene;
    rsv_gpu_stage *s = &f->there;
    f->stage_there = rsv_gpu_place(b, 1, sizeof *f->stage_there);
    rsv_gpu_geometry_place(&f->geometry, b);
    s->transport.view = f->geometry.view_there;
    s->bvh = f->geometry.bvh;
    s->transport.bsdf = rsv_gpu_place(b, view->material_count, sizeof *s->transport.bsdf);
    s->side = rsv_gpu_place(b, view->triangle_count + 1, sizeof *s->side);
    s->cell = rsv_gpu_place(b, f->stage.cell_count, sizeof *s->cell);
}

static void upload_scene(rsv_device_frames *f)
{
    const rsv_scene_view *view = f->stage.scene;
    const rsv_gpu_stage *s = &f->there;
    const rsv_gpu_array array[] = { { s->transport.bsdf, f->stage.bsdf, view->material_count,
                                        sizeof *f->stage.bsdf },
        { s->side, f->stage.side, view->triangle_count + 1, sizeof *f->stage.side } };
    rsv_gpu_geometry_upload(&f->geometry, f->gpu);
    rsv_gpu_upload_all(f->gpu, array, sizeof array / sizeof array[0]);
}

static void lay_out_room(void *task, rsv_gpu_block *b)
{
    rsv_device_frames *f = task;
    rsv_frame_args *a = &f->args;
    size_t depth = f->stage.chain_depth, most = 2 * f->slots > f->pixels ? 2 * f->slots : f->pixels;
    a->radiance = rsv_gpu_place(b, f->pixels, sizeof *a->radiance);
    a->sum = rsv_gpu_place(b, f->pixels, sizeof *a->sum);
    a->code = rsv_gpu_place(b, f->pixels, sizeof *a->code);
    a->hit = rsv_gpu_place(b, f->pixels, sizeof *a->hit);
    a->begins = rsv_gpu_place(b, f->pixels, sizeof *a->begins);
    a->alive = rsv_gpu_place(b, f->slots, sizeof *a->alive);
    a->found = rsv_gpu_place(b, f->slots, sizeof *a->found);
    a->found_by = rsv_gpu_place(b, f->slots, sizeof *a->found_by);
    f->begin_list = rsv_gpu_place(b, f->pixels, sizeof *f->begin_list);
    f->list = rsv_gpu_place(b, depth * f->slots, sizeof *f->list);
    f->traveller = rsv_gpu_place(b, depth * f->slots, sizeof *f->traveller);
    rsv_compactor_place(&f->compactor, b, most);
}

/// Two slots for each pixel, in so far as that is not too much.
static size_t count_slots(const rsv_device_frames *f)
{
    size_t wave = (f->stage.chain_depth ? f->stage.chain_depth : 1) * sizeof(rsv_gpu_traveller);
    size_t share = f->gpu->device.info.memory_bytes / TRAVELLER_SHARE;
    size_t pairs = (share < TRAVELLER_BYTES ? share : TRAVELLER_BYTES) / (2 * wave) + 1;
    return 2 * (f->pixels < pairs ? f->pixels : pairs);
}

static void set_constants(rsv_device_frames *f)
{
    const rsv_device_stage *s = &f->stage;
    f->pixels = (size_t)s->width * s->height * s->eyes;
    f->slots = count_slots(f);
    f->geometry = rsv_gpu_geometry_of(s->scene, s->bvh);
    f->args.width = s->width;
    f->args.eye_pixels = s->width * s->height;
    f->args.chain_depth = s->chain_depth;
    f->args.seed = s->seed;
}

static void destroy(rsv_device_frames *f)
{
    if (!f) return;
    rsv_gpu_release(f->gpu, &f->scene);
    rsv_gpu_release(f->gpu, &f->surroundings);
    rsv_gpu_release(f->gpu, &f->room);
    free(f);
}

static rsv_status create(
    rsv_device *device, const rsv_device_stage *stage, rsv_device_frames **frames, char *message)
{
    rsv_device_frames *f = rsv_gpu_new(sizeof *f, message);
    if (!f) return RSV_ERROR_MEMORY;
    f->gpu = (rsv_gpu *)device;
    f->stage = *stage;
    set_constants(f);
    rsv_gpu_lay_out(f->gpu, &f->scene, lay_out_scene, f, "the scene of the frames");
    rsv_gpu_lay_out(f->gpu, &f->room, lay_out_room, f, "the pictures");
    f->args.stage = f->stage_there;
    upload_scene(f);
    rsv_status status = rsv_gpu_wait(f->gpu, message);
    if (status == RSV_OK)
        *frames = f;
    else
        destroy(f);
    return status;
}

/// Skies change size.
static void upload_sky(rsv_device_frames *f, const rsv_sky *sky)
{
    size_t bytes = sky->pixel ? (size_t)sky->width * sky->height * sizeof *sky->pixel : 0;
    f->there.sky = *sky;
    if (bytes == 0) return;
    if (!f->surroundings.base || bytes > f->surroundings.bytes) {
        rsv_gpu_release(f->gpu, &f->surroundings);
        rsv_gpu_place(&f->surroundings, bytes, 1);
        rsv_gpu_reserve(f->gpu, &f->surroundings, "the surroundings");
    }
    f->there.sky.pixel = (const rsv_rgb *)f->surroundings.base;
    rsv_gpu_upload(f->gpu, f->surroundings.base, sky->pixel, bytes);
}

static rsv_status set_light(rsv_device_frames *f, const rsv_device_light *light, char *message)
{
    f->there.emission = light->emission;
    upload_sky(f, &light->sky);
    rsv_gpu_upload(
        f->gpu, (void *)f->there.cell, light->cell, f->stage.cell_count * sizeof *light->cell);
    rsv_gpu_upload(f->gpu, f->stage_there, &f->there, sizeof f->there);
    return rsv_gpu_wait(f->gpu, message);
}

// ---- one frame ----------------------------------------------------------------------------------

/// Follows `count` items of a wave to their ends: pixels that begin where level is 0, else travellers of that level.
/// As many at a time as have slots for their branches; each part is done before the next one begins, so that every
/// level has one wave only.
static uint64_t follow(rsv_device_frames *f, uint32_t level, const uint32_t *list, size_t count)
{
    rsv_frame_args args = f->args;
    size_t most = f->slots / 2, next_level = level * f->slots;
    uint64_t rays = level ? count : 0;
    args.from = level ? f->traveller + next_level - f->slots : NULL;
    args.to = level < f->stage.chain_depth ? f->traveller + next_level : NULL;
    for (size_t begin = 0; begin < count && f->gpu->status == RSV_OK; begin += most) {
        size_t items = count - begin < most ? count - begin : most;
        args.list = list + begin;
        args.items = (uint32_t)items;
        if (level)
            rsv_launch_frame_follow(f->gpu, &args, items);
        else
            rsv_launch_frame_begin(f->gpu, &args, items);
        rsv_launch_frame_gather(f->gpu, &args, items);
        if (level == f->stage.chain_depth) continue;
        uint32_t *next = f->list + next_level;
        uint32_t alive = rsv_compact(f->gpu, &f->compactor, args.alive, 2 * items, next);
        if (alive) rays += follow(f, level + 1, next, alive);
    }
    return rays;
}

static rsv_status render(
    rsv_device_frames *f, const rsv_device_eye *eye, uint64_t *chain_rays, char *message)
{
    for (uint32_t k = 0; k < f->stage.eyes; k++)
        f->args.eye[k] = eye[k];
    rsv_launch_frame_camera(f->gpu, &f->args, f->pixels);
    uint32_t begins = rsv_compact(f->gpu, &f->compactor, f->args.begins, f->pixels, f->begin_list);
    *chain_rays = follow(f, 0, f->begin_list, begins);
    rsv_launch_frame_display(f->gpu, &f->args, f->pixels);
    return rsv_gpu_wait(f->gpu, message);
}

static rsv_status download(
    rsv_device_frames *f, void *to, const char *from, uint32_t eye, size_t bytes, char *message)
{
    size_t picture = (size_t)f->args.eye_pixels * bytes;
    rsv_gpu_download(f->gpu, to, from + eye * picture, picture);
    return rsv_gpu_wait(f->gpu, message);
}

static rsv_status pixels(rsv_device_frames *f, uint32_t eye, uint8_t (*pixel)[4], char *message)
{
    return download(f, pixel, (const char *)f->args.code, eye, sizeof *pixel, message);
}

static rsv_status sums(rsv_device_frames *f, uint32_t eye, float (*sum)[4], char *message)
{
    return download(f, sum, (const char *)f->args.sum, eye, sizeof *sum, message);
}

const rsv_device_frames_table rsv_gpu_frames = { create, destroy, set_light, render, pixels, sums };
