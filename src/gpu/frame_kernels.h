/// Frames: camera rays, and waves of branches through mirrors and glass. The arithmetic is that of src/frame; only the
/// order in which a pixel's branches are added up differs.
#ifndef RSV_FRAME_KERNELS_H
#define RSV_FRAME_KERNELS_H

#include "../frame/device_frames.h"
#include "../render/camera_step.h"
#include "../trace/ray.h"
#include "launch.h"

/// A solved scene; it and all it points to lie on the device.
typedef struct rsv_gpu_stage {
    rsv_transport_scene transport; ///< its view is that of rsv_gpu_scene
    rsv_tracer tracer;
    const rsv_shown_side (*side)[2], (*received)[2];
    const rsv_light_cell *cell;
    const rsv_lights *lights;
    rsv_sky sky; ///< the whole one
    const uint8_t
        *plain; ///< [material_count] whether a kernel without textures and rough lobes can show it
    bool emission;
} rsv_gpu_stage;

/// A surface sends on a mirrored and a transmitted branch, and one that its rough lobes draw.
#define RSV_FRAME_BRANCHES 3

/// A branch on its way: the specular path has set out along its direction. Or one that has arrived.
typedef struct rsv_gpu_traveller {
    rsv_specular_path path;
    rsv_rough_departure departure;
    rsv_vec3 origin;
    bool missed; ///< has left the scene
    uint32_t trail, pixel;
} rsv_gpu_traveller;

/// A wave has a slot for each of the branches of each of its items. Pixels of all eyes are numbered through.
typedef struct rsv_frame_args {
    const rsv_gpu_stage *stage;
    rsv_device_eye eye[RSV_MAX_EYES];
    uint32_t width, eye_pixels, path_depth, seed;
    float (*radiance)[4], (*sum)[4]; ///< [pixels] of this sample, of all
    uint32_t *code;                  ///< [pixels] four bytes each
    bool varied;                     ///< some surfaces have holes
    rsv_hit *hit;                    ///< [pixels] of camera rays that specular paths begin at
    uint8_t *begins;                 ///< [pixels] whether one does
    const uint32_t *list; ///< of a wave: first pixels, or slots of `from`; of remaining work: items
    uint32_t items;       ///< of the wave
    const rsv_gpu_traveller *from;
    rsv_gpu_traveller *to; ///< [RSV_FRAME_BRANCHES x items]
    uint8_t *alive;        ///< [RSV_FRAME_BRANCHES x items] slots in use
    uint8_t *left;         ///< [items] whether the item's first slot is work for rsv_frame_scatter
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

RSV_INLINE void rsv_frame_camera_item(const rsv_frame_args *a, uint32_t pixel, bool varied)
{
    const rsv_gpu_stage *stage = a->stage;
    rsv_ray ray = rsv_frame_camera_ray(a, pixel);
    rsv_tracer tracer = { rsv_bvh_with_holes(stage->tracer.bvh, varied) };
    rsv_rgb shown = rgb_gray(0);
    rsv_hit hit;
    a->begins[pixel] = 0;
    if (!rsv_ray_meets(&tracer, &ray, &hit)) {
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

RSV_KERNEL_VARIED(frame_camera, rsv_frame_args, rsv_frame_camera_item)

// ---- specular paths -------------------------------------------------------------------------------------

/// Sets a branch out. @return false = the direction belongs to the other side of the surface
RSV_INLINE bool rsv_frame_set_out(const rsv_frame_args *a, const rsv_surface_point *point,
    const rsv_camera_branch *b, rsv_gpu_traveller *t)
{
    rsv_ray ray;
    if (!rsv_specular_depart(point, b->transmit, b->direction, &ray)) return false;
    t->origin = ray.origin;
    t->trail = b->trail;
    rsv_specular_set_out(&a->stage->transport, &t->path, b->transmit, b->direction, b->weight);
    return true;
}

/// Whether transmitted light continues straight past a blended surface.
RSV_INLINE bool rsv_frame_passes(const rsv_gpu_stage *stage, const rsv_specular_path *path)
{
    uint32_t material = rsv_specular_material(&stage->transport, path);
    return stage->transport.bsdf[material].transmission == 0 &&
           rsv_is_blended(stage->transport.view, material);
}

/// Starts one ideal branch, if it is to be followed. @param slot of the branch
RSV_INLINE bool rsv_frame_branch(const rsv_frame_args *a, const rsv_gpu_traveller *at,
    const rsv_surface_point *point, bool transmit, const rsv_bsdf_branches *branches,
    rsv_gpu_traveller *slot)
{
    rsv_camera_branch branch;
    if (!rsv_ideal_branch(&at->path, at->trail, a->path_depth, transmit, branches, &branch))
        return false;
    rsv_gpu_traveller t = *at;
    // sources sampled at a rough surface are sampled past blended surfaces too
    if (!transmit || !rsv_frame_passes(a->stage, &at->path)) t.departure.pdf_solid_angle = 0;
    if (!rsv_frame_set_out(a, point, &branch, &t)) return false;
    *slot = t;
    return true;
}

RSV_INLINE bool rsv_frame_shows_emission(
    const rsv_gpu_stage *stage, const rsv_specular_path *path, const rsv_bsdf *bsdf)
{
    return stage->emission && rsv_side_shows_emission(bsdf, path->back);
}

/// Share of the emission that is seen there: cameras see less of some lamps than mirrors do.
RSV_INLINE float rsv_frame_emission_seen(
    const rsv_frame_args *a, const rsv_gpu_traveller *at, const rsv_bsdf *bsdf)
{
    if (!rsv_hides_emission(bsdf)) return 1;
    rsv_vec3 start = rsv_frame_camera_ray(a, at->pixel).direction;
    return rsv_runs_straight(start, at->path.direction) ? bsdf->camera_emission : 1;
}

/// A specular path at a surface. @return the surface's light; its branches go to the slots of `item`
RSV_INLINE rsv_rgb rsv_frame_arrive(
    const rsv_frame_args *a, const rsv_gpu_traveller *at, uint32_t item)
{
    const rsv_gpu_stage *stage = a->stage;
    const rsv_specular_path *path = &at->path;
    rsv_rgb throughput = rsv_specular_throughput(&stage->transport, path, &path->medium);
    rsv_shown_side side = stage->side[path->triangle][path->back];
    if (side.kind == RSV_SHOWN_STORED)
        return rgb_mul(
            throughput, rsv_radiance_at(stage->cell, rsv_place_in_grid(side, path->u, path->v)));
    const rsv_bsdf *bsdf = &stage->transport.bsdf[rsv_specular_material(&stage->transport, path)];
    rsv_surface_point point =
        rsv_surface_point_at(stage->transport.view, path->triangle, path->u, path->v, path->back);
    rsv_bsdf_branches branches = rsv_specular_branches_of(bsdf, path, &point);
    for (uint32_t k = 0; k < 2; k++) {
        size_t slot = (size_t)RSV_FRAME_BRANCHES * item + k;
        a->alive[slot] = rsv_frame_branch(a, at, &point, k == 1, &branches, &a->to[slot]);
    }
    if (!rsv_frame_shows_emission(stage, path, bsdf)) return rgb_gray(0);
    float seen = rsv_frame_emission_seen(a, at, bsdf) * bsdf->opacity;
    return rgb_mul(throughput, rgb_scale(bsdf->emission, seen));
}

RSV_INLINE void rsv_frame_find(
    const rsv_frame_args *a, uint32_t item, uint32_t pixel, rsv_rgb found)
{
    a->found[item] = found;
    a->found_by[item] = pixel;
}

/// Whether a kernel without textures and rough lobes can shade a traveller's surface.
RSV_INLINE bool rsv_frame_is_plain(const rsv_gpu_stage *stage, const rsv_gpu_traveller *at)
{
    if (at->departure.pdf_solid_angle != 0) return false;
    return stage->side[at->path.triangle][at->path.back].kind == RSV_SHOWN_STORED ||
           stage->plain[rsv_specular_material(&stage->transport, &at->path)];
}

RSV_INLINE void rsv_frame_leave(const rsv_frame_args *a, uint32_t item, const rsv_gpu_traveller *t)
{
    a->left[item] = 1;
    a->to[(size_t)RSV_FRAME_BRANCHES * item] = *t;
    rsv_frame_find(a, item, t->pixel, rgb_gray(0));
}

RSV_INLINE void rsv_frame_clear_slots(const rsv_frame_args *a, uint32_t item)
{
    a->left[item] = 0;
    for (uint32_t k = 0; k < RSV_FRAME_BRANCHES; k++)
        a->alive[(size_t)RSV_FRAME_BRANCHES * item + k] = 0;
}

RSV_INLINE void rsv_frame_begin_item(const rsv_frame_args *a, uint32_t item)
{
    uint32_t pixel = a->list[item], within = pixel % a->eye_pixels;
    const rsv_device_eye *eye = &a->eye[pixel / a->eye_pixels];
    rsv_hit hit = a->hit[pixel];
    rsv_gpu_traveller t;
    rsv_vec3 direction = rsv_frame_camera_ray(a, pixel).direction;
    t.path = rsv_specular_begin(&a->stage->transport, &eye->medium, direction, hit);
    t.path.channel = RSV_CHANNEL_ALL; // a frame has too few samples to separate colours
    rsv_specular_set_spread(&t.path, eye->spread, hit.t);
    t.departure.pdf_solid_angle = t.departure.sky_pdf = 0;
    t.departure.shot = t.missed = false;
    t.departure.point = t.departure.side = t.origin = v3(0, 0, 0);
    uint32_t seed = rsv_pixel_seed(a->seed, within / a->width, within % a->width);
    t.trail = rsv_hash2(seed, eye->samples);
    t.pixel = pixel;
    rsv_frame_clear_slots(a, item);
    if (rsv_frame_is_plain(a->stage, &t))
        rsv_frame_find(a, item, pixel, rsv_frame_arrive(a, &t, item));
    else
        rsv_frame_leave(a, item, &t);
}

RSV_KERNEL(frame_begin, rsv_frame_args, rsv_frame_begin_item)

RSV_INLINE void rsv_frame_follow_item(const rsv_frame_args *a, uint32_t item, bool varied)
{
    const rsv_gpu_stage *stage = a->stage;
    rsv_gpu_traveller t = a->from[a->list[item]];
    rsv_ray ray = { t.origin, t.path.direction, INFINITY };
    rsv_tracer tracer = { rsv_bvh_with_holes(stage->tracer.bvh, varied) };
    rsv_hit hit;
    rsv_frame_clear_slots(a, item);
    t.missed = !rsv_ray_meets(&tracer, &ray, &hit);
    if (!t.missed) rsv_specular_arrive(&stage->transport, &t.path, &hit);
    if (t.missed && t.departure.pdf_solid_angle == 0)
        rsv_frame_find(a, item, t.pixel,
            rgb_mul(rsv_specular_throughput(&stage->transport, &t.path, &t.path.medium),
                rsv_frame_sky(stage, ray.direction)));
    else if (!t.missed && rsv_frame_is_plain(stage, &t))
        rsv_frame_find(a, item, t.pixel, rsv_frame_arrive(a, &t, item));
    else
        rsv_frame_leave(a, item, &t);
}

RSV_KERNEL_VARIED(frame_follow, rsv_frame_args, rsv_frame_follow_item)

// ---- textures and rough lobes -------------------------------------------------------------------

/// The branch that rough lobes draw, and the sources that they are aimed at.
/// @param found gets the light of these
RSV_INLINE bool rsv_frame_rough_branch(const rsv_frame_args *a, const rsv_gpu_traveller *at,
    const rsv_bsdf_branches *branches, rsv_rough_surface *surface, rsv_gpu_traveller *slot,
    rsv_rgb *found)
{
    const rsv_gpu_stage *stage = a->stage;
    rsv_gpu_traveller t = *at;
    rsv_rough_numbers numbers = rsv_rough_numbers_of(at->trail, t.path.triangle);
    if (!rsv_rough_arrive(&t.path, &numbers, branches, surface)) return false;
    if (stage->emission)
        *found = rgb_add(*found, rsv_rough_light(surface, stage->lights, false, numbers.light));
    rsv_camera_branch branch;
    if (!rsv_rough_branch(surface, &numbers, at->trail, a->path_depth, &branch)) return false;
    t.departure = rsv_rough_depart(surface, branch.direction, 0);
    if (!rsv_frame_set_out(a, &surface->point, &branch, &t)) return false;
    *slot = t;
    return true;
}

/// Radiance of a surface that is in the table, without its emission.
RSV_INLINE rsv_rgb rsv_frame_unlit(
    const rsv_gpu_stage *stage, rsv_shown_side side, const rsv_specular_path *path)
{
    uint32_t material = rsv_specular_material(&stage->transport, path);
    const float *emission = stage->cell[1 + material].corner[0];
    rsv_rgb shown = rsv_radiance_at(stage->cell, rsv_place_in_grid(side, path->u, path->v));
    // nothing is shown on the back of a one-sided surface
    if (side.cell == 0) return rgb_gray(0);
    return rgb_positive(rgb_sub(shown, rgb(emission[0], emission[1], emission[2])));
}

/// Radiance of the diffuse light of a surface.
RSV_INLINE rsv_rgb rsv_frame_diffuse(const rsv_gpu_stage *stage, const rsv_specular_path *path,
    const rsv_bsdf *bsdf, const rsv_bsdf_branches *branches)
{
    rsv_shown_side shown = stage->side[path->triangle][path->back];
    rsv_shown_side side = stage->received[path->triangle][path->back];
    if (shown.kind == RSV_SHOWN_STORED) return rsv_frame_unlit(stage, shown, path);
    if (side.kind != RSV_SHOWN_STORED || rgb_is_black(branches->diffuse)) return rgb_gray(0);
    rsv_rgb irradiance = rsv_radiance_at(stage->cell, rsv_place_in_grid(side, path->u, path->v));
    return rgb_scale(rgb_mul(rgb_mul(branches->diffuse, bsdf->base_color), irradiance), 1 / RSV_PI);
}

/// A traveller at a surface of any kind. @return the surface's light
RSV_INLINE rsv_rgb rsv_frame_scatter_at(
    const rsv_frame_args *a, const rsv_gpu_traveller *at, uint32_t item)
{
    const rsv_gpu_stage *stage = a->stage;
    const rsv_specular_path *path = &at->path;
    const rsv_transport_scene *scene = &stage->transport;
    rsv_rough_surface surface;
    rsv_rough_see(scene, path, &surface);
    const rsv_bsdf *bsdf = surface.bsdf;
    rsv_bsdf_branches branches = rsv_specular_branches_of(bsdf, path, &surface.point);
    rsv_gpu_traveller *to = a->to + (size_t)RSV_FRAME_BRANCHES * item;
    uint8_t *alive = a->alive + (size_t)RSV_FRAME_BRANCHES * item;
    rsv_rgb shown = rsv_frame_diffuse(stage, path, bsdf, &branches);
    if (rsv_frame_shows_emission(stage, path, bsdf))
        shown = rgb_mad(shown,
            bsdf->opacity * rsv_frame_emission_seen(a, at, bsdf) *
                rsv_rough_emission_weight(scene, stage->lights, path, &at->departure),
            bsdf->emission);
    rsv_rgb found = rgb_mul(rsv_specular_throughput(scene, path, &path->medium), shown);
    for (uint32_t k = 0; k < 2; k++)
        alive[k] = rsv_frame_branch(a, at, &surface.point, k == 1, &branches, &to[k]);
    if (branches.rough)
        alive[2] = rsv_frame_rough_branch(a, at, &branches, &surface, &to[2], &found);
    return found;
}

/// Work left by other kernels. @param k of `list`
RSV_INLINE void rsv_frame_scatter_item(const rsv_frame_args *a, uint32_t k)
{
    const rsv_gpu_stage *stage = a->stage;
    uint32_t item = a->list[k];
    rsv_gpu_traveller t = a->to[(size_t)RSV_FRAME_BRANCHES * item];
    rsv_rgb found = rgb_gray(0);
    if (!t.missed)
        found = rsv_frame_scatter_at(a, &t, item);
    else if (stage->emission)
        found = rgb_mul(rsv_specular_throughput(&stage->transport, &t.path, &t.path.medium),
            rsv_rough_sky(stage->lights, t.path.direction, &t.departure));
    a->found[item] = found;
}

RSV_KERNEL(frame_scatter, rsv_frame_args, rsv_frame_scatter_item)

// ---- pixels -------------------------------------------------------------------------------------

/// Items of a pixel are adjacent: the first one adds up all of them.
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
