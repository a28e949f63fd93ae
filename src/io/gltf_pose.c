#include "gltf_pose.h"

#include "../core/core.h"
#include "matrix.h"

#include <string.h>

static size_t count_weights(const rsv_gltf_clip *clips, size_t clip_count)
{
    size_t count = 0;
    for (size_t c = 0; c < clip_count; c++)
        for (size_t k = 0; k < clips[c].count; k++)
            if (clips[c].track[k].path == RSV_GLTF_WEIGHTS) count += clips[c].track[k].width;
    return count;
}

static rsv_status allocate(rsv_gltf_pose *pose, size_t weights)
{
    size_t nodes = pose->document.node_count;
    pose->node = rsv_alloc(pose->context, nodes, sizeof *pose->node);
    pose->weight = rsv_alloc(pose->context, weights, sizeof *pose->weight);
    if (!pose->node || !pose->weight) return RSV_ERROR_MEMORY;
    if (nodes) memcpy(pose->node, pose->document.node, nodes * sizeof *pose->node);
    pose->document.node = pose->node;
    return RSV_OK;
}

/// @param weight where those of the node are to lie @param room [width] for numbers
static void move_node(
    rsv_gltf_node *node, const rsv_gltf_track *track, double time, float *weight, double *room)
{
    double *part = track->path == RSV_GLTF_TRANSLATION ? node->translation
                   : track->path == RSV_GLTF_ROTATION  ? node->rotation
                                                       : node->scale;
    rsv_gltf_track_at(track, time, room);
    if (track->path != RSV_GLTF_WEIGHTS) {
        memcpy(part, room, track->width * sizeof *part);
        return;
    }
    for (size_t k = 0; k < track->width; k++)
        weight[k] = (float)room[k];
    node->weight = weight;
    node->weight_count = track->width;
}

static rsv_status play(rsv_gltf_pose *pose, const rsv_gltf_clip *clip, double time, size_t *weights)
{
    rsv_status status = RSV_OK;
    size_t widest = 4;
    for (size_t k = 0; k < clip->count; k++)
        if (clip->track[k].width > widest) widest = clip->track[k].width;
    double *room = rsv_alloc(pose->context, widest, sizeof *room);
    if (!room) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < clip->count; k++) {
        const rsv_gltf_track *track = &clip->track[k];
        move_node(&pose->node[track->node], track, time, pose->weight + *weights, room);
        if (track->path == RSV_GLTF_WEIGHTS) *weights += track->width;
    }
    for (size_t k = 0; k < clip->count && status == RSV_OK; k++) {
        rsv_gltf_node *node = &pose->node[clip->track[k].node];
        if (clip->track[k].path == RSV_GLTF_WEIGHTS) continue;
        if (!rsv_matrix_place(node->translation, node->rotation, node->scale, node->local))
            status = rsv_fail(RSV_ERROR_FORMAT,
                "animation '%s': at %g s the rotation of node '%s' is zero", clip->name, time,
                node->name);
    }
    rsv_free(pose->context, room);
    return status;
}

rsv_status rsv_gltf_pose_create(rsv_context *context, const rsv_gltf_document *document,
    const rsv_gltf_clip *clips, size_t clip_count, double time, rsv_gltf_pose *pose)
{
    rsv_status status;
    size_t weights = 0;
    *pose = (rsv_gltf_pose){ .context = context, .document = *document };
    RSV_TRY(allocate(pose, count_weights(clips, clip_count)));
    for (size_t c = 0; c < clip_count; c++)
        RSV_TRY(play(pose, &clips[c], time, &weights));
cleanup:
    if (status != RSV_OK) rsv_gltf_pose_destroy(pose);
    return status;
}

void rsv_gltf_pose_destroy(rsv_gltf_pose *pose)
{
    rsv_free(pose->context, pose->node);
    rsv_free(pose->context, pose->weight);
    *pose = (rsv_gltf_pose){ .context = pose->context };
}
