/// Backs of single-sided surfaces, which are black here as in the format of glTF, and most often a mistake of whoever made them.
#ifndef RSV_BACKS_H
#define RSV_BACKS_H

#include "resolvent/trace.h"

/// What a camera sees of backs.
typedef struct rsv_seen_backs {
    double share;      ///< of the picture
    uint32_t material; ///< of most of them; RSV_NONE = it sees none
} rsv_seen_backs;

/// By some thousand rays, the same for the same scene and camera. Bodies that let light through have no backs.
rsv_seen_backs rsv_look_for_backs(const rsv_tracer *tracer, const rsv_camera *camera);

/// Says in a warning where a camera sees more of them than a hundredth of its picture.
void rsv_warn_of_backs(const rsv_tracer *tracer, const rsv_camera *camera);

#endif
