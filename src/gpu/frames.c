/// Frames on the device: resident data, and the waves of a frame.
#include "frames.h"
#include "compact.h"
#include "frame_kernels.h"
#include "scattering.h"
#include "sources.h"

#include <stdlib.h>

/// Fraction of device memory for branches in flight, all waves together.
#define TRAVELLER_SHARE 16
#define TRAVELLER_BYTES ((size_t)1 << 30)

struct rsv_device_frames {
    rsv_gpu *gpu;
    rsv_device_stage stage; ///< on the host; its arrays are only valid during creation
    size_t pixels;          ///< of all eyes
    size_t slots;           ///< of a wave
    rsv_gpu_block resident, surroundings, room;
    rsv_gpu_scene scene;
    rsv_gpu_scattering scattering;
    rsv_gpu_sources sources;
    rsv_gpu_stage there; ///< with addresses on the device
    rsv_gpu_stage *stage_there;
    rsv_frame_args args;
    rsv_compactor compactor;
    bool all_plain;               ///< nothing is left to rsv_frame_scatter
    uint8_t *plain;               ///< [material_count] on the host
    uint32_t *begin_list;         ///< [pixels]
    uint32_t *left_list;          ///< [items of a wave]
    uint32_t *list;               ///< [path_depth][slots]
    rsv_gpu_traveller *traveller; ///< [path_depth + 1][slots]
};

// ---- resident data -------------------------------------------------------------------------------

static void lay_out_scene(void *task, rsv_gpu_block *b)
{
    rsv_device_frames *f = task;
    const rsv_scene_view *view = f->stage.scene;
    rsv_gpu_stage *s = &f->there;
    f->stage_there = rsv_gpu_place(b, 1, sizeof *f->stage_there);
    rsv_gpu_scene_place(&f->scene, b);
    rsv_gpu_scattering_place(&f->scattering, b);
    s->transport.view = f->scene.there;
    s->transport.bsdf = f->scattering.bsdf;
    s->transport.tracer = f->stage_there ? &f->stage_there->tracer : NULL;
    s->tracer.bvh = f->scene.bvh;
    s->side = rsv_gpu_place(b, view->triangle_count + 1, sizeof *s->side);
    s->received = rsv_gpu_place(b, view->triangle_count, sizeof *s->received);
    s->plain = rsv_gpu_place(b, view->material_count, sizeof *s->plain);
    s->cell = rsv_gpu_place(b, f->stage.cell_count, sizeof *s->cell);
}

static void upload_scene(rsv_device_frames *f)
{
    const rsv_scene_view *view = f->stage.scene;
    const rsv_gpu_stage *s = &f->there;
    const rsv_gpu_array array[] = { { s->side, f->stage.side, view->triangle_count + 1,
                                        sizeof *f->stage.side },
        { s->received, f->stage.received, view->triangle_count, sizeof *f->stage.received },
        { s->plain, f->plain, view->material_count, sizeof *f->plain } };
    rsv_gpu_scene_upload(&f->scene, f->gpu);
    rsv_gpu_scattering_upload(&f->scattering, f->stage.bsdf, f->gpu);
    rsv_gpu_upload_all(f->gpu, array, sizeof array / sizeof array[0]);
}

/// Of all waves.
static size_t traveller_count(const rsv_device_frames *f)
{
    return (f->stage.path_depth + 1) * f->slots;
}

static void lay_out_room(void *task, rsv_gpu_block *b)
{
    rsv_device_frames *f = task;
    rsv_frame_args *a = &f->args;
    size_t depth = f->stage.path_depth, most = f->slots > f->pixels ? f->slots : f->pixels;
    a->radiance = rsv_gpu_place(b, f->pixels, sizeof *a->radiance);
    a->sum = rsv_gpu_place(b, f->pixels, sizeof *a->sum);
    a->code = rsv_gpu_place(b, f->pixels, sizeof *a->code);
    a->hit = rsv_gpu_place(b, f->pixels, sizeof *a->hit);
    a->begins = rsv_gpu_place(b, f->pixels, sizeof *a->begins);
    a->alive = rsv_gpu_place(b, f->slots, sizeof *a->alive);
    a->left = rsv_gpu_place(b, f->slots / RSV_FRAME_BRANCHES, sizeof *a->left);
    f->left_list = rsv_gpu_place(b, f->slots / RSV_FRAME_BRANCHES, sizeof *f->left_list);
    a->found = rsv_gpu_place(b, f->slots, sizeof *a->found);
    a->found_by = rsv_gpu_place(b, f->slots, sizeof *a->found_by);
    f->begin_list = rsv_gpu_place(b, f->pixels, sizeof *f->begin_list);
    f->list = rsv_gpu_place(b, depth * f->slots, sizeof *f->list);
    f->traveller = rsv_gpu_place(b, traveller_count(f), sizeof *f->traveller);
    rsv_compactor_place(&f->compactor, b, most);
}

/// All slots for each pixel, in so far as that is not too much.
static size_t count_slots(const rsv_device_frames *f)
{
    size_t wave = (f->stage.path_depth + 1) * sizeof(rsv_gpu_traveller);
    size_t share = f->gpu->device.info.memory_bytes / TRAVELLER_SHARE;
    size_t room = share < TRAVELLER_BYTES ? share : TRAVELLER_BYTES;
    size_t items = room / (RSV_FRAME_BRANCHES * wave) + 1;
    return RSV_FRAME_BRANCHES * (f->pixels < items ? f->pixels : items);
}

static void set_constants(rsv_device_frames *f)
{
    const rsv_device_stage *s = &f->stage;
    f->pixels = (size_t)s->width * s->height * s->eyes;
    f->slots = count_slots(f);
    f->args.width = s->width;
    f->args.eye_pixels = s->width * s->height;
    f->args.path_depth = s->path_depth;
    f->args.seed = s->seed;
}

static void destroy(rsv_device_frames *f)
{
    if (!f) return;
    rsv_gpu_release(f->gpu, &f->resident);
    rsv_gpu_release(f->gpu, &f->surroundings);
    rsv_gpu_release(f->gpu, &f->room);
    rsv_gpu_scene_destroy(&f->scene);
    rsv_gpu_scattering_destroy(&f->scattering);
    free(f->plain);
    free(f);
}

/// Whether the light of a material is known without its diffuse part, where that is not stored.
static bool is_plain(const rsv_device_stage *s, size_t material)
{
    const rsv_bsdf *bsdf = &s->bsdf[material];
    return !s->scene->material_varies[material] && !bsdf->rough && bsdf->diffuse <= 0;
}

static bool all_plain(const rsv_device_stage *s, const uint8_t *plain)
{
    for (size_t t = 0; t < s->scene->triangle_count; t++)
        for (int back = 0; back < 2; back++)
            if (s->side[t][back].kind != RSV_SHOWN_STORED && !plain[s->scene->triangle_material[t]])
                return false;
    return true;
}

static rsv_status prepare_materials(rsv_device_frames *f, char *message)
{
    size_t count = f->stage.scene->material_count;
    rsv_status status =
        rsv_gpu_scene_create(f->stage.scene, f->stage.bvh, true, &f->scene, message);
    if (status == RSV_OK) status = rsv_gpu_scattering_create(count, &f->scattering, message);
    if (status != RSV_OK) return status;
    f->plain = rsv_gpu_new(count + 1, message);
    if (!f->plain) return RSV_ERROR_MEMORY;
    for (size_t m = 0; m < count; m++)
        f->plain[m] = is_plain(&f->stage, m);
    f->all_plain = all_plain(&f->stage, f->plain);
    return RSV_OK;
}

static rsv_status create(
    rsv_device *device, const rsv_device_stage *stage, rsv_device_frames **frames, char *message)
{
    rsv_device_frames *f = rsv_gpu_new(sizeof *f, message);
    if (!f) return RSV_ERROR_MEMORY;
    f->gpu = (rsv_gpu *)device;
    f->stage = *stage;
    set_constants(f);
    rsv_status status = prepare_materials(f, message);
    if (status != RSV_OK) {
        destroy(f);
        return status;
    }
    rsv_gpu_lay_out(f->gpu, &f->resident, lay_out_scene, f, "the scene of the frames");
    rsv_gpu_lay_out(f->gpu, &f->room, lay_out_room, f, "the pictures");
    f->args.stage = f->stage_there;
    f->args.varied = f->scene.bvh.holes != NULL;
    upload_scene(f);
    rsv_gpu_clear(f->gpu, f->args.sum, f->pixels * sizeof *f->args.sum); // fourth components, too
    // including padding
    rsv_gpu_clear(f->gpu, f->traveller, traveller_count(f) * sizeof *f->traveller);
    status = rsv_gpu_wait(f->gpu, message);
    if (status == RSV_OK)
        *frames = f;
    else
        destroy(f);
    return status;
}

static void lay_out_sources(void *task, rsv_gpu_block *b)
{
    rsv_device_frames *f = task;
    rsv_gpu_sources_place(&f->sources, &f->scene, b);
}

/// Sources change in number, skies in size.
static void bring_sources(rsv_device_frames *f, const rsv_lights *lights)
{
    rsv_gpu_block *block = &f->surroundings, measured = { 0 };
    f->sources.host = lights;
    f->sources.seen = true;
    lay_out_sources(f, &measured);
    if (!block->base || measured.bytes > block->bytes) {
        rsv_gpu_release(f->gpu, block);
        rsv_gpu_lay_out(f->gpu, block, lay_out_sources, f, "the sources of light");
    } else {
        block->placed = 0;
        lay_out_sources(f, block);
    }
    rsv_gpu_sources_upload(&f->sources, &f->scene, f->gpu);
    f->there.lights = f->sources.there;
    f->there.sky = lights->environment ? f->sources.environment.whole : (rsv_sky){ 0 };
}

static rsv_status set_light(rsv_device_frames *f, const rsv_device_light *light, char *message)
{
    f->there.emission = light->emission;
    f->scene.host = light->scene;
    bring_sources(f, light->lights);
    const rsv_gpu_array array[] = { { f->there.cell, light->cell, f->stage.cell_count,
                                        sizeof *light->cell },
        { f->scene.there, &f->scene.view, 1, sizeof f->scene.view },
        { f->stage_there, &f->there, 1, sizeof f->there } };
    rsv_gpu_scene_upload_materials(&f->scene, f->gpu);
    rsv_gpu_scattering_upload(&f->scattering, light->bsdf, f->gpu);
    rsv_gpu_upload_all(f->gpu, array, sizeof array / sizeof array[0]);
    return rsv_gpu_wait(f->gpu, message);
}

// ---- one frame ----------------------------------------------------------------------------------

/// Textures and rough lobes are for a kernel of their own: others stay small.
static void scatter(rsv_device_frames *f, const rsv_frame_args *wave)
{
    rsv_frame_args args = *wave;
    args.list = f->left_list;
    uint32_t left = rsv_compact(f->gpu, &f->compactor, args.left, args.items, f->left_list);
    if (left) rsv_launch_frame_scatter(f->gpu, &args, left);
}

/// Follows `count` items of a wave to their ends: pixels that begin where level is 0, else travellers of that level.
/// As many at a time as have slots for their branches; each part is done before the next one begins, so that every
/// level has one wave only.
static uint64_t follow(rsv_device_frames *f, uint32_t level, const uint32_t *list, size_t count)
{
    rsv_frame_args args = f->args;
    size_t most = f->slots / RSV_FRAME_BRANCHES, next_level = level * f->slots;
    uint64_t rays = level ? count : 0;
    args.from = level ? f->traveller + next_level - f->slots : NULL;
    args.to = f->traveller + next_level;
    for (size_t begin = 0; begin < count && f->gpu->status == RSV_OK; begin += most) {
        size_t items = count - begin < most ? count - begin : most;
        args.list = list + begin;
        args.items = (uint32_t)items;
        if (level)
            rsv_launch_frame_follow(f->gpu, &args, items);
        else
            rsv_launch_frame_begin(f->gpu, &args, items);
        if (!f->all_plain) scatter(f, &args);
        rsv_launch_frame_gather(f->gpu, &args, items);
        if (level == f->stage.path_depth) continue;
        uint32_t *next = f->list + next_level;
        uint32_t alive =
            rsv_compact(f->gpu, &f->compactor, args.alive, RSV_FRAME_BRANCHES * items, next);
        if (alive) rays += follow(f, level + 1, next, alive);
    }
    return rays;
}

static rsv_status render(
    rsv_device_frames *f, const rsv_device_eye *eye, uint64_t *path_rays, char *message)
{
    for (uint32_t k = 0; k < f->stage.eyes; k++)
        f->args.eye[k] = eye[k];
    rsv_launch_frame_camera(f->gpu, &f->args, f->pixels);
    uint32_t begins = rsv_compact(f->gpu, &f->compactor, f->args.begins, f->pixels, f->begin_list);
    *path_rays = follow(f, 0, f->begin_list, begins);
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
