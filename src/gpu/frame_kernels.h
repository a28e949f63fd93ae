/// Frames: camera rays to what they show, and waves of the branches that mirrors and glass send on. The arithmetic is
/// that of src/frame; only the order in which a pixel's branches are added up differs.
#ifndef RSV_FRAME_KERNELS_H
#define RSV_FRAME_KERNELS_H

#include "../bvh/bvh_trace.h"
#include "../frame/device_frames.h"
#include "../render/branch.h"
#include "launch.h"

/// A solved scene; it and all it points to lie on the device.
typedef struct rsv_gpu_stage {
    rsv_transport_scene transport; ///< its view is that of rsv_gpu_geometry
    rsv_bvh_view bvh;
    const rsv_shown_side (*side)[2];
    const rsv_light_cell *cell;
    rsv_sky sky;
    bool emission;
} rsv_gpu_stage;

/// A branch on its way: the chain has set out along its direction.
typedef struct rsv_gpu_traveller {
    rsv_chain chain;
    rsv_vec3 origin;
    uint32_t path, pixel;
} rsv_gpu_traveller;

/// A wave has two slots for the branches of each of its items. Pixels of all eyes are numbered through.
typedef struct rsv_frame_args {
    const rsv_gpu_stage *stage;
    rsv_device_eye eye[RSV_MAX_EYES];
    uint32_t width, eye_pixels, chain_depth, seed;
    float (*radiance)[4], (*sum)[4]; ///< [pixels] of this sample, of all
    uint32_t *code;                  ///< [pixels] four bytes each
    rsv_hit *hit;                    ///< [pixels] of camera rays that chains begin at
    uint8_t *begins;                 ///< [pixels] whether one does
    const uint32_t *list;            ///< of a wave: pixels that begin, or slots of `from`
    uint32_t items;                  ///< of the wave
    const rsv_gpu_traveller *from;
    rsv_gpu_traveller *to; ///< [2 x items]
    uint8_t *alive;        ///< [2 x items] slots in use
    rsv_rgb *found;        ///< [items] radiance
    uint32_t *found_by;    ///< [items] pixel
} rsv_frame_args;

// ---- camera rays --------------------------------------------------------------------------------

RSV_INLINE rsv_ray rsv_frame_camera_ray(const rsv_frame_args *a, uint32_t pixel)
{
    const rsv_device_eye *eye = &a->eye[pixel / a->eye_pixels];
    uint32_t row = pixel % a->eye_pixels / a->width, column = pixel % a->eye_pixels % a->width;
    return rsv_lens_ray(&eye->lens, (float)column + eye->place_x, (float)row + eye->place_y);
}

RSV_INLINE rsv_rgb rsv_frame_sky(const rsv_gpu_stage *stage, rsv_vec3 direction)
{
    return stage->emission ? rsv_sky_radiance(&stage->sky, direction) : rgb_gray(0);
}

RSV_INLINE bool rsv_frame_meets_back(
    const rsv_gpu_stage *stage, const rsv_hit *hit, rsv_vec3 direction)
{
    const rsv_vec3 *position = stage->transport.view->position;
    const uint32_t *corner = stage->transport.view->triangle[hit->triangle];
    rsv_vec3 a = position[corner[0]];
    rsv_vec3 normal = v3_cross(v3_sub(position[corner[1]], a), v3_sub(position[corner[2]], a));
    return v3_dot(normal, direction) > 0;
}

RSV_INLINE void rsv_frame_camera_item(const rsv_frame_args *a, uint32_t pixel)
{
    const rsv_gpu_stage *stage = a->stage;
    rsv_ray ray = rsv_frame_camera_ray(a, pixel);
    rsv_bvh_view bvh = stage->bvh;
    rsv_rgb shown = rgb_gray(0);
    rsv_hit hit;
    a->begins[pixel] = 0;
    if (!rsv_bvh_closest(&bvh, &ray, &hit)) {
        shown = rsv_frame_sky(stage, ray.direction);
    } else {
        rsv_shown_side side =
            stage->side[hit.triangle][rsv_frame_meets_back(stage, &hit, ray.direction)];
        // seen from within a body: dimmed on the way
        bool plain = side.kind == RSV_SHOWN_STORED && !a->eye[pixel / a->eye_pixels].medium.depth;
        if (plain) {
            shown = rsv_radiance_at(stage->cell, rsv_place_in_grid(side, hit.u, hit.v));
        } else {
            a->hit[pixel] = hit;
            a->begins[pixel] = 1;
        }
    }
    float *radiance = a->radiance[pixel];
    radiance[0] = shown.r, radiance[1] = shown.g, radiance[2] = shown.b, radiance[3] = 0;
}

RSV_KERNEL(frame_camera, rsv_frame_args, rsv_frame_camera_item)

// ---- chains -------------------------------------------------------------------------------------

/// Sets one ideal branch out, if it is to be followed. @param slot of the branch
RSV_INLINE bool rsv_frame_branch(const rsv_frame_args *a, const rsv_chain *chain,
    const rsv_surface_point *point, uint32_t path, uint32_t pixel, bool transmit,
    const rsv_bsdf_branches *branches, rsv_gpu_traveller *slot)
{
    rsv_rgb weight = transmit ? branches->transmit : branches->reflect;
    rsv_vec3 direction = transmit ? branches->transmit_direction : branches->reflect_direction;
    rsv_ray ray;
    if (chain->events >= a->chain_depth || !rsv_branch_survives(chain, path, transmit, &weight) ||
        !rsv_chain_depart(point, transmit, direction, &ray))
        return false;
    rsv_gpu_traveller t;
    t.chain = *chain;
    t.origin = ray.origin;
    t.path = rsv_branch_path(path, transmit);
    t.pixel = pixel;
    rsv_chain_set_out(&a->stage->transport, &t.chain, transmit, direction, weight);
    *slot = t;
    return true;
}

RSV_INLINE rsv_rgb rsv_frame_emission(
    const rsv_gpu_stage *stage, const rsv_chain *chain, const rsv_bsdf *bsdf)
{
    bool shows = (bsdf->emissive || bsdf->unlit) && (!chain->back || bsdf->double_sided);
    return shows && stage->emission ? rgb_scale(bsdf->emission, bsdf->opacity) : rgb_gray(0);
}

/// A chain that has arrived at a surface. @return what that shows; its branches go to the slots of `item`
RSV_INLINE rsv_rgb rsv_frame_arrive(
    const rsv_frame_args *a, const rsv_chain *chain, uint32_t path, uint32_t pixel, uint32_t item)
{
    const rsv_gpu_stage *stage = a->stage;
    rsv_rgb throughput = rsv_chain_throughput(&stage->transport, chain, &chain->medium);
    rsv_shown_side side = stage->side[chain->triangle][chain->back];
    if (side.kind == RSV_SHOWN_STORED)
        return rgb_mul(
            throughput, rsv_radiance_at(stage->cell, rsv_place_in_grid(side, chain->u, chain->v)));
    const rsv_bsdf *bsdf = &stage->transport.bsdf[rsv_chain_material(&stage->transport, chain)];
    rsv_surface_point point = rsv_surface_point_at(
        stage->transport.view, chain->triangle, chain->u, chain->v, chain->back);
    rsv_bsdf_branches branches = rsv_chain_branches_of(bsdf, chain, &point);
    for (uint32_t k = 0; k < 2; k++)
        a->alive[2 * item + k] = rsv_frame_branch(
            a, chain, &point, path, pixel, k == 1, &branches, &a->to[2 * item + k]);
    return rgb_mul(throughput, rsv_frame_emission(stage, chain, bsdf));
}

RSV_INLINE void rsv_frame_find(
    const rsv_frame_args *a, uint32_t item, uint32_t pixel, rsv_rgb found)
{
    a->found[item] = found;
    a->found_by[item] = pixel;
}

RSV_INLINE void rsv_frame_begin_item(const rsv_frame_args *a, uint32_t item)
{
    uint32_t pixel = a->list[item], within = pixel % a->eye_pixels;
    const rsv_device_eye *eye = &a->eye[pixel / a->eye_pixels];
    rsv_hit hit = a->hit[pixel];
    rsv_vec3 direction = rsv_frame_camera_ray(a, pixel).direction;
    rsv_chain chain = rsv_chain_begin(
        &a->stage->transport, &eye->medium, direction, hit.triangle, hit.u, hit.v, hit.t);
    rsv_chain_set_spread(&chain, eye->spread, hit.t);
    uint32_t seed = rsv_pixel_seed(a->seed, within / a->width, within % a->width);
    a->alive[2 * item] = a->alive[2 * item + 1] = 0;
    rsv_frame_find(
        a, item, pixel, rsv_frame_arrive(a, &chain, rsv_hash2(seed, eye->samples), pixel, item));
}

RSV_KERNEL(frame_begin, rsv_frame_args, rsv_frame_begin_item)

RSV_INLINE void rsv_frame_follow_item(const rsv_frame_args *a, uint32_t item)
{
    const rsv_gpu_stage *stage = a->stage;
    rsv_gpu_traveller t = a->from[a->list[item]];
    rsv_ray ray = { t.origin, t.chain.direction, INFINITY };
    rsv_bvh_view bvh = stage->bvh;
    rsv_hit hit;
    rsv_rgb found;
    a->alive[2 * item] = a->alive[2 * item + 1] = 0;
    if (rsv_bvh_closest(&bvh, &ray, &hit)) {
        rsv_chain_arrive(&stage->transport, &t.chain, &hit);
        found = rsv_frame_arrive(a, &t.chain, t.path, t.pixel, item);
    } else {
        found = rgb_mul(rsv_chain_throughput(&stage->transport, &t.chain, &t.chain.medium),
            rsv_frame_sky(stage, ray.direction));
    }
    rsv_frame_find(a, item, t.pixel, found);
}

RSV_KERNEL(frame_follow, rsv_frame_args, rsv_frame_follow_item)

/// Items of a pixel follow each other: the first one adds up what all have found.
RSV_INLINE void rsv_frame_gather_item(const rsv_frame_args *a, uint32_t item)
{
    uint32_t pixel = a->found_by[item];
    if (item > 0 && a->found_by[item - 1] == pixel) return;
    float *radiance = a->radiance[pixel];
    for (uint32_t k = item; k < a->items && a->found_by[k] == pixel; k++) {
        radiance[0] += a->found[k].r;
        radiance[1] += a->found[k].g;
        radiance[2] += a->found[k].b;
    }
}

RSV_KERNEL(frame_gather, rsv_frame_args, rsv_frame_gather_item)

// ---- display ------------------------------------------------------------------------------------

RSV_INLINE void rsv_frame_display_item(const rsv_frame_args *a, uint32_t pixel)
{
    rsv_frame_tone tone = a->eye[pixel / a->eye_pixels].tone;
    uint32_t code = 255u << 24;
    for (int k = 0; k < 3; k++) {
        float sum = a->radiance[pixel][k] + (tone.first ? 0 : a->sum[pixel][k]);
        a->sum[pixel][k] = sum;
        code |= (uint32_t)rsv_tone_code(sum * tone.scale, tone.soft) << 8 * k;
    }
    a->code[pixel] = code;
}

RSV_KERNEL(frame_display, rsv_frame_args, rsv_frame_display_item)

#endif
