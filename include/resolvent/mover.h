/// @file mover.h
/// A rigid object that moves through a solved scene. It is lit by the scene and visible in it, but not part of the
/// operator.
///
/// Direct light is traced at its vertices, with shadows of the scene and of the object. Indirect light comes from a
/// grid of probes in spherical harmonics of order 2 (Ramamoorthi and Hanrahan 2001) that fills the scene. Probes are
/// lit when the object comes near, and points of the object use only the probes that they see, so walls do not leak. In
/// frames (frame.h), its image through glass and smooth mirrors is traced, and so is its shadow in the light of
/// sources.
///
/// Not included: indirect light, caustics and rough reflections that the object blocks, and the light that it reflects
/// back. Its surfaces are shaded as diffuse, with the base colour of their material.
#ifndef RESOLVENT_MOVER_H
#define RESOLVENT_MOVER_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Options of a moving object. Start from rsv_default_mover_desc().
typedef struct rsv_mover_desc {
    size_t size;            ///< sizeof this structure; rsv_default_mover_desc() sets it
    float probe_spacing;    ///< metres; 0 = a sixteenth of the scene's longest side
    uint32_t probe_samples; ///< rays per direction of a probe, 32..65536, default 64
    /// Shadow rays per vertex, 1..64, default 16; a quarter as many per pixel and frame in its shadow
    uint32_t light_samples;
} rsv_mover_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_mover_desc().
RSV_API void rsv_mover_desc_init(rsv_mover_desc *desc, size_t size);
static inline rsv_mover_desc rsv_default_mover_desc(void)
{
    rsv_mover_desc desc;
    rsv_mover_desc_init(&desc, sizeof desc);
    return desc;
}

typedef struct rsv_mover rsv_mover;

/// Creates a moving object, at its position in `body`. RSV_ERROR_ARGUMENT for values out of range.
/// @param light must outlive the mover
/// @param body committed; its triangles form the object; must outlive the mover
/// @param desc NULL = defaults
RSV_API rsv_status rsv_mover_create(
    const rsv_light *light, const rsv_scene *body, const rsv_mover_desc *desc, rsv_mover **mover);
RSV_API void rsv_mover_destroy(rsv_mover *mover);

/// Moves the object and lights it at its new position.
/// @param offset metres from its position in `body`, at most 1e6 along each axis
/// @param turn degrees about the vertical axis through its centre, counter-clockwise from above
RSV_API rsv_status rsv_mover_place(rsv_mover *mover, rsv_vec3 offset, float turn);

/// Lights the object again after the solution's light has changed.
RSV_API void rsv_mover_refresh(rsv_mover *mover);

/// Irradiance at its vertices, W/m2, [vertex_count of `body`].
RSV_API const rsv_rgb *rsv_mover_irradiance(const rsv_mover *mover);

/// Present position of a point of `body`.
RSV_API rsv_vec3 rsv_mover_point(const rsv_mover *mover, rsv_vec3 point);

#ifdef __cplusplus
}
#endif

#endif
