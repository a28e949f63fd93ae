/// Media along paths: the bodies that a segment of a path is in, and how they attenuate it.
///
/// Paths know their medium from the surfaces they cross: below the front of a solid body is its inside, beyond the back
/// its outside. A path that arrives at the back of a body must have been inside. This settles the medium of paths that
/// start in an unknown one, and of meshes that have holes or overlap.
///
/// Scattering functions use basic radiance L / ior^2 (bsdf/bsdf.h), which smooth and rough interfaces and diffuse
/// surfaces do not scale. Sources and receivers use radiance, so a path that ends in another medium than it started in
/// gets one factor (ior of its start / ior of its end)^2. Photons carry flux, which needs no factor.
///
/// Inline functions are also for device code.
#ifndef RSV_MEDIUM_H
#define RSV_MEDIUM_H

#include "../bsdf/bsdf.h"
#include "../core/vec.h"
#include "resolvent/trace.h"

/// More bodies than this within each other are left out, the outermost first.
#define RSV_MEDIUM_DEPTH 4

/// The bodies that hold a place, by material, the outermost first. All zero: outside all bodies.
typedef struct rsv_medium {
    uint32_t body[RSV_MEDIUM_DEPTH];
    uint32_t depth;
} rsv_medium;

/// Place of the innermost body of this material, -1 = none.
RSV_INLINE int rsv_medium_find(const rsv_medium *medium, uint32_t material)
{
    int k = (int)medium->depth;
    while (--k >= 0 && medium->body[k] != material)
        ;
    return k;
}

RSV_INLINE void rsv_medium_remove(rsv_medium *medium, int place)
{
    medium->depth--;
    for (int k = place; k + 1 < RSV_MEDIUM_DEPTH; k++)
        medium->body[k] = medium->body[k + 1];
}

/// Passes the surface of a solid body inwards.
RSV_INLINE void rsv_medium_enter(rsv_medium *medium, uint32_t material)
{
    if (medium->depth == RSV_MEDIUM_DEPTH) rsv_medium_remove(medium, 0);
    medium->body[medium->depth++] = material;
}

RSV_INLINE void rsv_medium_leave(rsv_medium *medium, uint32_t material)
{
    int place = rsv_medium_find(medium, material);
    if (place >= 0) rsv_medium_remove(medium, place);
}

/// Has come to the surface of a solid body from inside: adds the body if the medium lacks it.
RSV_INLINE void rsv_medium_arrive_inside(rsv_medium *medium, uint32_t material)
{
    if (rsv_medium_find(medium, material) < 0) rsv_medium_enter(medium, material);
}

/// Passes the surface of a solid body. @param back from inside
RSV_INLINE void rsv_medium_cross(rsv_medium *medium, uint32_t material, bool back)
{
    if (back)
        rsv_medium_leave(medium, material);
    else
        rsv_medium_enter(medium, material);
}

/// The innermost body, if the depth is not 0. @param bsdf [material_count]
///
/// Callers test the depth, and NULL is never returned: ptxas 13.0 tests such a pointer too early on Hopper, and reads
/// through NULL (CS2R, a predicated write, and ISETP five cycles later).
RSV_INLINE const rsv_bsdf *rsv_medium_body(const rsv_medium *medium, const rsv_bsdf *bsdf)
{
    return &bsdf[medium->body[medium->depth - 1]];
}

/// Of the innermost body; 1 outside. @param bsdf [material_count]
RSV_INLINE float rsv_medium_ior(const rsv_medium *medium, const rsv_bsdf *bsdf)
{
    return medium->depth ? rsv_medium_body(medium, bsdf)->ior : 1;
}

RSV_INLINE bool rsv_medium_absorbs(const rsv_medium *medium, const rsv_bsdf *bsdf)
{
    return medium->depth && !rgb_is_black(rsv_medium_body(medium, bsdf)->absorption);
}

/// Transmittance over `distance` metres (Beer-Lambert). An infinite distance means that the body's surface is
/// incomplete, and nothing is absorbed.
RSV_INLINE rsv_rgb rsv_medium_transmittance(
    const rsv_medium *medium, const rsv_bsdf *bsdf, float distance)
{
    if (!rsv_medium_absorbs(medium, bsdf) || !(distance < INFINITY)) return rgb_gray(1);
    rsv_rgb a = rsv_medium_body(medium, bsdf)->absorption;
    return rgb(expf(-a.r * distance), expf(-a.g * distance), expf(-a.b * distance));
}

/// Where to look up the medium of a place.
typedef struct rsv_media {
    const rsv_scene_view *view;
    const rsv_tracer *tracer;
    const rsv_bsdf *bsdf; ///< [material_count]
    bool bodies;          ///< there are solid ones
} rsv_media;

rsv_media rsv_media_of(const rsv_scene_view *view, const rsv_tracer *tracer, const rsv_bsdf *bsdf);

/// The medium above a point: that of the first solid surface that one of a few rays hits.
/// @param origin off the surface @param normal unit
rsv_medium rsv_medium_above(const rsv_media *media, rsv_vec3 origin, rsv_vec3 normal);

#endif
