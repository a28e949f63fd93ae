/// Steps of specular paths from surface to surface, without the ray tracing. Plain C, also for device code.
#ifndef RSV_SPECULAR_WALK_H
#define RSV_SPECULAR_WALK_H

#include "../surface/lift.h"
#include "../surface/medium.h"
#include "../trace/offset.h"
#include "resolvent/trace.h"

#include <string.h>

/// Scene data for specular paths.
typedef struct rsv_transport_scene {
    const rsv_scene *scene;
    const rsv_scene_view *view;
    const rsv_tracer *tracer;
    const rsv_bsdf *bsdf; ///< [material_count] rsv_surface_common_bsdf
    rsv_media media;
    /// No opaque surface has just one side, so no place counts as inside a body. False = not known
    bool no_insides;
    const struct rsv_fog_lights *fog_lights;   ///< lights for anisotropic fog; NULL = none
    const struct rsv_known_cells *known_cells; ///< of an earlier version; NULL = none
    const struct rsv_update *update;           ///< data reused from before an edit; NULL = none
} rsv_transport_scene;

/// A specular path at one of its surfaces. Set by rsv_specular_begin, moved by rsv_specular_step.
typedef struct rsv_specular_path {
    rsv_vec3 direction;  ///< unit, of the segment that arrived here
    rsv_rgb weight;      ///< throughput of basic radiance up to this surface, all media included
    rsv_medium medium;   ///< that the segment ran through
    float length;        ///< of that segment, metres; 0 = its fog has been handled
    rsv_channel channel; ///< of its light, once a body has dispersed it
    float start_ior;     ///< of the medium that the specular path started in
    bool settled;        ///< has hit the surface of a body, so the medium at its start is known
    uint32_t triangle;
    float u, v;
    bool back;       ///< arrived at the triangle's back
    uint32_t events; ///< specular events so far
    /// Of those, all but RSV_LOBE_PASS. 0 = light that comes this way is counted where shadow rays find it
    /// (sources/partition.h); counted by specular paths that draw their events.
    uint32_t turns;
    uint32_t rays; ///< rays traced so far
    float spread;  ///< metres by which the footprint grows per metre
    float width;   ///< of the footprint on this surface, over which textures are averaged
} rsv_specular_path;

/// Footprint of a gather ray: an eighth of the cone of one of the 250 or so that share a hemisphere. Wider averages mix
/// maps that vary together (where a metal has no transmission) and neighbours in an atlas: a frosted lampshade lost 60
/// % of its light at full width. Chance directions average anyway.
#define RSV_GATHER_SPREAD 0.02f

RSV_INLINE uint32_t rsv_specular_material(
    const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    return scene->view->triangle_material[path->triangle];
}

/// The channel of light that goes on through the surface: of a body that disperses it, drawn by where the path arrived.
RSV_INLINE rsv_channel rsv_specular_channel(
    const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    if (path->channel != RSV_CHANNEL_OPEN) return path->channel;
    if (scene->bsdf[rsv_specular_material(scene, path)].dispersion == 0) return RSV_CHANNEL_OPEN;
    uint32_t bits[3];
    const float place[3] = { path->u, path->v, path->direction.x };
    memcpy(bits, place, sizeof bits);
    uint32_t third = (uint32_t)(3 * (uint64_t)rsv_hash3(bits[0], bits[1], bits[2]) >> 32);
    return (rsv_channel)(RSV_CHANNEL_RED + third);
}

/// Whether a segment ends at the back of a triangle.
RSV_INLINE bool rsv_meets_back(
    const rsv_transport_scene *scene, uint32_t triangle, rsv_vec3 direction)
{
    const uint32_t *corner = scene->view->triangle[triangle];
    rsv_vec3 a = scene->view->position[corner[0]];
    rsv_vec3 normal = v3_cross(
        v3_sub(scene->view->position[corner[1]], a), v3_sub(scene->view->position[corner[2]], a));
    return v3_dot(normal, direction) > 0;
}

/// Moves to the surface that a segment ends at; direction and medium are set.
RSV_INLINE void rsv_specular_end_segment(
    const rsv_transport_scene *scene, rsv_specular_path *path, const rsv_hit *hit, bool back)
{
    path->triangle = hit->triangle;
    path->u = hit->u;
    path->v = hit->v;
    path->length = hit->t;
    path->width += path->spread * hit->t;
    path->back = back;
    uint32_t material = rsv_specular_material(scene, path);
    // the medium of a body is uniform
    if (scene->bsdf[material].solid) {
        if (path->back) rsv_medium_arrive_inside(&path->medium, material);
        if (!path->settled) path->start_ior = rsv_medium_ior(&path->medium, scene->bsdf);
        path->settled = true;
    }
    if (path->medium.depth)
        path->weight =
            rgb_mul(path->weight, rsv_medium_transmittance(&path->medium, scene->bsdf, hit->t));
}

/// The specular path at its first surface, hit by a ray along unit `direction`.
/// @param medium that it starts in; NULL = outside all bodies
RSV_INLINE rsv_specular_path rsv_specular_begin(
    const rsv_transport_scene *scene, const rsv_medium *medium, rsv_vec3 direction, rsv_hit hit)
{
    const rsv_medium outside = { { 0 }, 0 };
    rsv_specular_path path;
    path.direction = direction;
    path.weight = rgb_gray(1);
    path.medium = medium ? *medium : outside;
    path.start_ior = rsv_medium_ior(&path.medium, scene->bsdf);
    path.settled = false;
    path.channel = RSV_CHANNEL_OPEN;
    path.events = path.turns = path.rays = 0;
    path.spread = RSV_GATHER_SPREAD;
    path.width = 0;
    rsv_specular_end_segment(scene, &path, &hit, rsv_meets_back(scene, hit.triangle, direction));
    return path;
}

/// Radiance at the specular path's start per radiance in `medium` at its present end: its weight and the
/// factor for media of different index.
RSV_INLINE rsv_rgb rsv_specular_throughput(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const rsv_medium *medium)
{
    float ratio = path->start_ior / rsv_medium_ior(medium, scene->bsdf);
    return rgb_scale(path->weight, ratio * ratio);
}

/// The medium on the far side of the specular path's surface.
RSV_INLINE rsv_medium rsv_specular_medium_beyond(
    const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    rsv_medium medium = path->medium;
    uint32_t material = rsv_specular_material(scene, path);
    if (scene->bsdf[material].solid) rsv_medium_cross(&medium, material, path->back);
    return medium;
}

/// Gives a specular path at its first surface another footprint. @param distance to that surface
RSV_INLINE void rsv_specular_set_spread(rsv_specular_path *path, float spread, float distance)
{
    path->spread = spread;
    path->width = spread * distance;
}

/// The shading normal, or the geometric one for a silhouette seen under an interpolated normal that already turns away.
RSV_INLINE rsv_vec3 rsv_specular_facing_normal(
    const rsv_specular_path *path, const rsv_surface_point *seen)
{
    return v3_dot(seen->normal, path->direction) >= 0 ? seen->geometric : seen->normal;
}

/// Normal for the surface's BSDF: the visible one, unless mirrored light would be lost.
RSV_INLINE rsv_vec3 rsv_specular_bsdf_normal(
    const rsv_bsdf *bsdf, const rsv_specular_path *path, const rsv_surface_point *seen)
{
    rsv_vec3 normal = rsv_specular_facing_normal(path, seen);
    if (bsdf->lambert) return normal;
    return rsv_bsdf_specular_normal(normal, seen->geometric, v3_neg(path->direction));
}

/// Branch weights at a known surface point and BSDF. Light past its coverage counts as transmitted straight.
RSV_INLINE rsv_bsdf_branches rsv_specular_branches_of(
    const rsv_bsdf *bsdf, const rsv_specular_path *path, const rsv_surface_point *seen)
{
    rsv_vec3 normal = rsv_specular_bsdf_normal(bsdf, path, seen);
    rsv_bsdf_branches branches =
        rsv_bsdf_evaluate_branches(bsdf, v3_neg(path->direction), normal, !path->back);
    if (bsdf->opacity >= 1) return branches;
    branches.reflect = rgb_scale(branches.reflect, bsdf->opacity);
    branches.diffuse = rgb_scale(branches.diffuse, bsdf->opacity);
    branches.transmit = rgb_mad(rgb_gray(1 - bsdf->opacity), bsdf->opacity, branches.transmit);
    branches.transmit_direction = path->direction;
    return branches;
}

/// The ray that leaves a surface point; false = lost, for the direction belongs to the other side of the surface.
RSV_INLINE bool rsv_specular_depart(
    const rsv_surface_point *point, bool transmit, rsv_vec3 direction, rsv_ray *ray)
{
    rsv_vec3 leave = transmit ? v3_neg(point->geometric) : point->geometric;
    ray->origin = rsv_moved_off(point->position, leave, point->extent);
    ray->direction = direction;
    ray->t_max = INFINITY;
    if (!transmit) ray->origin = rsv_lifted_origin(point, ray->origin, direction);
    // an interpolated normal can send light through the surface: it is lost, as to the reference
    return v3_dot(direction, transmit ? leave : point->horizon) > 0;
}

/// The specular path on its way along that ray. @param weight multiplies the throughput
RSV_INLINE void rsv_specular_set_out(const rsv_transport_scene *scene, rsv_specular_path *path,
    bool transmit, rsv_vec3 direction, rsv_rgb weight)
{
    rsv_channel channel = transmit ? rsv_specular_channel(scene, path) : path->channel;
    const rsv_bsdf *bsdf = &scene->bsdf[rsv_specular_material(scene, path)];
    if (path->channel != channel && rsv_bsdf_disperses(bsdf)) {
        path->channel = channel;
        weight = rgb_mul(weight, rsv_channel_weight(channel));
    }
    if (transmit) path->medium = rsv_specular_medium_beyond(scene, path);
    path->direction = direction;
    path->weight = rgb_mul(path->weight, weight);
    path->rays++;
}

/// Its arrival, where the side of the surface is known.
RSV_INLINE void rsv_specular_arrive_at(
    const rsv_transport_scene *scene, rsv_specular_path *path, const rsv_hit *hit, bool back)
{
    path->events++;
    rsv_specular_end_segment(scene, path, hit, back);
}

/// Its arrival.
RSV_INLINE void rsv_specular_arrive(
    const rsv_transport_scene *scene, rsv_specular_path *path, const rsv_hit *hit)
{
    rsv_specular_arrive_at(scene, path, hit, rsv_meets_back(scene, hit->triangle, path->direction));
}

#endif
