/// What a solve takes over from the one before an edit of the scene, and leaves to the next one.
///
/// - history.h: what that solve knew of elements and their light; it tells elements what they need not find out
///   (known_cells.h of elements), and kept_elements.h and kept_light.h take over splits, receiver points and direct light;
/// - store.h: where all of that is kept, in a folder or in memory;
/// - row_store.h: rows of G, kept while they are traced and taken over ray by ray;
/// - scene_change.h: where the two versions of the scene differ; element_keys.h: what is the same in both.
#ifndef RSV_UPDATE_H
#define RSV_UPDATE_H

#include "history.h"
#include "level_before.h"

/// All of it is borrowed.
typedef struct rsv_update {
    rsv_store *store;           ///< keeps rows while they are traced; NULL = nobody does
    rsv_store *earlier;         ///< that of an earlier version of the scene; NULL = none
    const rsv_history *history; ///< what the solve of that knew; NULL = nothing
    const rsv_level_before *before; ///< direct light before something moved; NULL = not known
} rsv_update;

/// @return NULL = nothing is known
RSV_INLINE const rsv_history *rsv_history_of(const rsv_transport_scene *scene)
{
    return scene->update ? scene->update->history : NULL;
}

/// @return NULL = nothing is known
RSV_INLINE const rsv_level_before *rsv_level_before_of(const rsv_transport_scene *scene)
{
    return scene->update ? scene->update->before : NULL;
}

#endif
