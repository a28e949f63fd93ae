/// @file update.h
/// Solves a scene again after an edit: objects moved, added or removed, materials or lights changed. Whatever the edit
/// cannot have affected is reused from the solution before; the rest is computed again.
///
///     rsv_update_store *store = NULL;
///     rsv_update_store_create(context, &store);
///     rsv_operator_update(scene, &desc, store, &solution, NULL);  // the first time: everything
///     rsv_operator_update(edited, &desc, store, &next, &report);  // then, for a fraction of the cost
///
/// `edited` is a new scene, built or loaded again. What stayed in place is recognised by its position, not by a name. The
/// result is a complete solution. It equals that of rsv_light_create up to sampling error, and is the same byte for byte
/// for any number of threads. Errors do not accumulate: reused light was sampled in identical surroundings.
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

/// What was kept of the solution before, and what was computed again. Rays and rows are in proportion to time; all of `kept_...`
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

/// Takes a light to another version of its scene in which surfaces are elsewhere or have other shapes, and punctual lights
/// shine from elsewhere: a later frame of an animation, or the scene after something was dragged. In place, and where
/// little moves at a small part of the cost of a solve: only what moved, rays that its old or new place touches, and light that
/// it may have hidden or let through are computed again, and elements are divided again where surfaces touch now. Where much
/// moves, an update can cost less. Splits pile up on the way; called again with the same scene, once all rests, it divides
/// elements as a solve would.
///
/// The first time, rows are traced as a whole, so that their rays are known from then on: 7 bytes each and more. Orders are
/// not kept apart any more (rsv_light_order_count is 0), and parts of single lights (relight.h) are forgotten: lights keep
/// their present strengths, and one that was relit to 0 cannot be switched on again. Renderers of the light show it after
/// that; whoever holds its operator keeps what that was.
///
/// RSV_ERROR_UNSUPPORTED, and the light as it was, where `scene` has other triangles, materials or lights, where light follows
/// what scatters below its surface and changes its shape, and in teams of several processes. After any other failure the light
/// can only be destroyed.
/// @param scene of the same context; may be destroyed after the call
/// @param report NULL is allowed
RSV_API rsv_status rsv_light_follow(
    rsv_light *light, const rsv_scene *scene, rsv_update_report *report);

#ifdef __cplusplus
}
#endif

#endif
