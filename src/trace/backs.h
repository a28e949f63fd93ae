/// Mistakes in what cameras see: nothing, or backs of single-sided surfaces, which are black here as in glTF.
#ifndef RSV_BACKS_H
#define RSV_BACKS_H

#include "resolvent/trace.h"

/// Backs seen by a camera.
typedef struct rsv_seen_backs {
    double share;      ///< of the picture
    uint32_t material; ///< of most of them; RSV_NONE = it sees none
    bool anything;     ///< whether it sees any surface at all
} rsv_seen_backs;

/// By some thousand rays, the same for the same scene and camera. Bodies that let light through have no backs.
rsv_seen_backs rsv_look_for_backs(const rsv_tracer *tracer, const rsv_camera *camera);

/// Warns where they are more than a hundredth of the picture, and where a camera sees no surface, sky or fog.
void rsv_warn_of_view(const rsv_tracer *tracer, const rsv_camera *camera);

#endif
