/// @file update.h
/// Solving a scene again after an edit: objects moved, added or removed, materials or lights changed. What the edit
/// cannot have touched is taken over from the solution before; the rest is found anew.
///
///     rsv_update_store *store = NULL;
///     rsv_update_store_create(context, &store);
///     rsv_operator_update(scene, &desc, store, &solution, NULL);  // for the first time: as a whole
///     rsv_operator_update(edited, &desc, store, &next, &report);  // over and over, at a part of the cost
///
/// `edited` is another scene, built or loaded anew: what stays where it was is known again by its place, not by a name. The
/// solution is a whole one, that of rsv_light_create within its sampling error, and the same bytes for any number of
/// threads. Errors do not add up: light that is taken over is light that was sampled for the very same surroundings.
#ifndef RESOLVENT_UPDATE_H
#define RESOLVENT_UPDATE_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What the last solution of a scene knew, in memory: its elements, their direct and indirect light, and where the rays of
/// its rows ended, some 5 bytes a ray. It keeps nothing of the scenes and solutions themselves, which may be destroyed.
/// One update at a time. (To outlive the program, keep the same in folders: `checkpoint` and `earlier` of rsv_solve_desc.)
typedef struct rsv_update_store rsv_update_store;

/// An empty one. @param context outlives it; scenes may be of others
RSV_API rsv_status rsv_update_store_create(rsv_context *context, rsv_update_store **store);
RSV_API void rsv_update_store_destroy(rsv_update_store *store); ///< NULL is allowed

/// Forgets all: the next update solves its scene as a whole.
RSV_API void rsv_update_store_clear(rsv_update_store *store);

/// Memory it takes; while an update runs, about twice that.
RSV_API size_t rsv_update_store_bytes(const rsv_update_store *store);

/// What was kept of the solution before, and what was found anew. Rays and rows are in proportion to time; all of `kept_...`
/// is 0 where the scene was solved as a whole.
typedef struct rsv_update_report {
    size_t rows;            ///< coarse elements with a row of their own
    size_t kept_elements;   ///< of these, that were there before, with nothing changed around them
    size_t kept_rows;       ///< of these, rows of which no ray was traced
    uint64_t row_rays;      ///< of rows, those of pilots included
    uint64_t kept_row_rays; ///< of these, not traced: they end where they did
    size_t lit_elements;    ///< elements, coarse and fine, that light is sampled at
    size_t kept_lit_elements; ///< of these, whose direct light was not sampled again
    double seconds;           ///< that the update took
    double spared_seconds;    ///< by rows that were kept, about
} rsv_update_report;

/// Builds the operator of an edited scene and solves it, as rsv_light_create does, with what still holds of what the store
/// knows, which it replaces by what is known then. After a failure, be it that the caller cancels, the store is as it was.
///
/// Any scene will do: where nothing is in common with the one before, or the settings are others, it is solved as a whole.
/// With a goal nothing but rows is taken over. In a team every process has a store of its own, for its part of the rows.
///
/// @param desc NULL = the default; RSV_ERROR_ARGUMENT where it names folders (`checkpoint`, `earlier`)
/// @param report NULL is allowed
RSV_API rsv_status rsv_operator_update(const rsv_scene *scene, const rsv_solve_desc *desc,
    rsv_update_store *store, rsv_light **light, rsv_update_report *report);

#ifdef __cplusplus
}
#endif

#endif
