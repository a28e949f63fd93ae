/// Light that reaches the camera through a wide lobe after specular events, `C W S+ L`: traced from the sources and
/// connected to the camera (Dutre et al. 1993).
///
/// Camera rays scattered by a nearly matt coat hit a small lamp or a sun behind another rough surface so rarely that
/// pictures would show specks instead of this light. Light paths that end on the coat are many and weak. Each path is
/// counted once, by its events alone: W is the first surface that the camera sees, all of its lobes are wide
/// (rsv_rough_is_wide), and photons start from the source. Camera paths count all others.
#ifndef RSV_SHOT_LIGHT_H
#define RSV_SHOT_LIGHT_H

#include "../solve/light.h"
#include "resolvent/render.h"

/// Whether there may be any.
bool rsv_shot_light_wanted(const rsv_light_view *solution);

/// Guides of such light towards what one camera sees.
typedef struct rsv_shot_light rsv_shot_light;

/// @param solution,camera borrowed @param medium that the camera is in, borrowed
rsv_status rsv_shot_light_create(const rsv_light_view *solution, const rsv_render_desc *desc,
    const rsv_camera *camera, const rsv_medium *medium, rsv_shot_light **shot);
/// @param shot NULL is allowed
void rsv_shot_light_destroy(rsv_shot_light *shot);

/// Adds it to a picture of this camera and, where there are layers, to that of emission. One light path per camera ray,
/// but no fewer than a few tens of thousands.
/// @param desc of the size at creation
rsv_status rsv_shot_light_add(
    const rsv_shot_light *shot, const rsv_render_desc *desc, rsv_image *image);

#endif
