/// Reuse of results from a solve before an edit of the scene, and storage for the next one.
///
/// - history.h: the elements of that solve and their light; it answers elements (known_cells.h), and kept_elements.h and
///   kept_light.h reuse splits, receiver points and direct light;
/// - store.h: storage for all of this, in a folder or in memory;
/// - row_store.h: rows of G, stored as they are traced and reused ray by ray;
/// - scene_change.h: the differences between the two versions of the scene; element_keys.h: what they have in common.
#ifndef RSV_UPDATE_H
#define RSV_UPDATE_H

#include "history.h"
#include "level_before.h"

/// All of it is borrowed.
typedef struct rsv_update {
    rsv_store *store;           ///< stores rows as they are traced; NULL = none
    rsv_store *earlier;         ///< that of an earlier version of the scene; NULL = none
    const rsv_history *history; ///< results of that solve; NULL = none
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
