/// @file lightmix.h
/// Pictures of one view under lights of changing strength and colour, without tracing rays: the contribution of each source is
/// rendered once and kept, and every further picture is a weighted sum of these.
#ifndef RESOLVENT_LIGHTMIX_H
#define RESOLVENT_LIGHTMIX_H

#include "resolvent/relight.h"
#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_light_mix rsv_light_mix;

/// @param relighter borrowed; its light and that light's scene have to outlive the mix, too
/// @param picture modes final and operator, without layers; copied, its viewpoint borrowed
/// RSV_ERROR_ARGUMENT: other modes, layers
RSV_API rsv_status rsv_light_mix_create(
    rsv_relighter *relighter, const rsv_render_desc *picture, rsv_light_mix **mix);
RSV_API void rsv_light_mix_destroy(rsv_light_mix *mix);

/// The view as rsv_relighter_change last left the light; no steps are needed before. Sources whose factors have always been
/// alike are kept as one picture. New ones are rendered where factors part for the first time, as if all other sources were
/// off, and where places, colours or surroundings have changed. Where all together would take more than 512 MiB, none are
/// kept and each picture is rendered.
/// @return errors as of rsv_relighter_change and rsv_render: after one, the light may be used no more
RSV_API rsv_status rsv_light_mix_take(rsv_light_mix *mix, rsv_image **image);

/// Pictures rendered so far.
RSV_API size_t rsv_light_mix_rendered(const rsv_light_mix *mix);

#ifdef __cplusplus
}
#endif

#endif
