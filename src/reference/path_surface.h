/// Where a path of the reference has come to, and how that responds to light.
#ifndef RSV_PATH_SURFACE_H
#define RSV_PATH_SURFACE_H

#include "reference_internal.h"

/// Where a ray arrived. Normals are unit and on the side the ray came from.
typedef struct rsv_path_surface {
    const rsv_bsdf *bsdf;
    rsv_bsdf own; ///< `bsdf` points to it if the material varies
    rsv_vec3 point, wo;
    rsv_vec3 geometric_normal;
    rsv_vec3 normal; ///< for scattering
    /// Normal with which the diffuse lobe receives light, for any viewer: `normal`, except where that was turned to
    /// keep mirrored light.
    rsv_vec3 receiving;
    /// Coarse triangles with smooth convex normals represent a curved surface: the normal that decides which light is
    /// above it, and the offset to it from the point. Elsewhere, and if something is in between, the geometric normal
    /// and zero.
    rsv_vec3 horizon, rise;
    float extent; ///< for rsv_offset_origin
    uint32_t triangle, material;
    rsv_channel channel; ///< that scatters here, of a body that disperses light
    float u, v;
    bool front;
    /// For translucent bodies: light that leaves here diffusely entered elsewhere (translucent), or was just followed
    /// to where it entered, and only its direction remains to be chosen (entry).
    bool translucent, entry;
} rsv_path_surface;

void rsv_path_surface_meet(
    const rsv_path_tracer *tracer, const rsv_ray *ray, const rsv_hit *hit, rsv_path_surface *s);

/// Where rays that leave it along `direction` begin. @param transmitted below it
rsv_vec3 rsv_path_surface_departure(
    const rsv_path_surface *s, bool transmitted, rsv_vec3 direction);

/// Whether light along `direction` is on that side of the surface.
bool rsv_path_surface_leads(const rsv_path_surface *s, bool transmitted, rsv_vec3 direction);

/// Whether light along `direction` gets here through the surface.
bool rsv_path_surface_is_below(const rsv_path_surface *s, rsv_vec3 direction);

/// Whether the diffuse lobe has a normal of its own.
static inline bool rsv_path_surface_turned(const rsv_path_surface *s)
{
    return v3_dot(s->receiving, s->normal) < 1 - 1e-6f;
}

/// Response of the lobes in `lobes`; nothing where the normals disagree on wi's side.
rsv_bsdf_value rsv_path_surface_respond(const rsv_path_surface *s, rsv_vec3 wi, rsv_lobe_set lobes);

/// Straight transmittance from the ray's end to its origin.
/// @param sheets include the transmission of thin sheets, besides light past the coverage of surfaces
rsv_rgb rsv_straight_transmittance(const rsv_path_tracer *tracer, rsv_ray ray, bool sheets);

#endif
