/// A glTF document at a moment of its animations.
#ifndef RSV_GLTF_POSE_H
#define RSV_GLTF_POSE_H

#include "gltf_clip.h"

typedef struct rsv_gltf_pose {
    rsv_context *context;
    rsv_gltf_document document; ///< the original, but with `node`: moved, and with moved weights
    rsv_gltf_node *node;
    float *weight; ///< of all nodes that have them moved
} rsv_gltf_pose;

/// @param document borrowed, and outlives the pose @param clips [clip_count] all at once; where two move the same, the
/// later counts
/// @param time s; NULL clips: nothing moves
rsv_status rsv_gltf_pose_create(rsv_context *context, const rsv_gltf_document *document,
    const rsv_gltf_clip *clips, size_t clip_count, double time, rsv_gltf_pose *pose);
void rsv_gltf_pose_destroy(rsv_gltf_pose *pose);

#endif
