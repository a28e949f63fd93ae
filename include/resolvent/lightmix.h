/// @file lightmix.h
/// Pictures of one view under changing strengths and colours of lights. The contribution of each source is rendered
/// once and kept. Every further picture is a weighted sum of these, and traces no rays.
#ifndef RESOLVENT_LIGHTMIX_H
#define RESOLVENT_LIGHTMIX_H

#include "resolvent/relight.h"
#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_light_mix rsv_light_mix;

/// @param relighter borrowed; its light and that light's scene must also outlive the mix
/// @param picture modes final and operator, without layers; copied, its viewpoint borrowed
/// @return RSV_ERROR_ARGUMENT for other modes and layers
RSV_API rsv_status rsv_light_mix_create(
    rsv_relighter *relighter, const rsv_render_desc *picture, rsv_light_mix **mix);
RSV_API void rsv_light_mix_destroy(rsv_light_mix *mix);

/// Renders the view with the light that rsv_relighter_change set; rsv_relighter_step is not necessary. Sources that
/// have always had the same factors share one picture. Pictures are added when factors differ for the first time, and
/// rendered again when positions, colours or the environment change. If all pictures would take more than 512 MiB, none
/// are kept, and every view is rendered.
/// @return errors as in rsv_relighter_change and rsv_render; after an error, the light may only be destroyed
RSV_API rsv_status rsv_light_mix_take(rsv_light_mix *mix, rsv_image **image);

/// Number of pictures rendered so far.
RSV_API size_t rsv_light_mix_rendered(const rsv_light_mix *mix);

#ifdef __cplusplus
}
#endif

#endif
