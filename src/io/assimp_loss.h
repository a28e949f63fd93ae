/// Contents of a file that a scene has no use for: removed before they can cause trouble, and each named once.
#ifndef RSV_ASSIMP_LOSS_H
#define RSV_ASSIMP_LOSS_H

#include "assimp_file.h"

typedef struct rsv_assimp_losses {
    size_t skinned, morphed, colored; ///< meshes
    size_t animations, lines;         ///< lines and points
    size_t broken;                    ///< faces without corners, and meshes without faces
} rsv_assimp_losses;

/// Removes bones, morph targets, colours and animations from what was imported.
void rsv_assimp_strip(struct aiScene *file, rsv_assimp_losses *losses);

/// Warns of what was lost, including properties of materials.
void rsv_assimp_warn_of_losses(const rsv_context *context, const char *path,
    const struct aiScene *file, const rsv_assimp_losses *losses);

#endif
