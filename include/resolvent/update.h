/// @file update.h
/// Solves a scene again after an edit: objects moved, added or removed, materials or lights changed. Everything that
/// the edit cannot have affected is reused from the previous solution; the rest is computed again.
///
///     rsv_update_store *store = NULL;
///     rsv_update_store_create(context, &store);
///     rsv_operator_update(scene, &desc, store, &solution, NULL);  // the first time: everything
///     rsv_operator_update(edited, &desc, store, &next, &report);  // then, for a fraction of the cost
///
/// `edited` is a new scene, built or loaded again. Objects that have not moved are recognised by position, not by name.
/// The result is a complete solution. It equals that of rsv_light_create up to sampling error, and is the same for any
/// number of threads, byte for byte. Errors do not accumulate, because reused light was sampled in identical
/// surroundings.
#ifndef RESOLVENT_UPDATE_H
#define RESOLVENT_UPDATE_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Data of the last solution of a scene, in memory: its elements, their direct and indirect light, and the end points
/// of the rays of rows (about 5 bytes per ray). It does not refer to scenes and solutions, which may be destroyed. Only
/// one update at a time. To keep the data after the program ends, use folders instead: `checkpoint` and `earlier` of
/// rsv_solve_desc.
typedef struct rsv_update_store rsv_update_store;

/// Creates an empty store. @param context must outlive it; scenes may belong to other contexts
RSV_API rsv_status rsv_update_store_create(rsv_context *context, rsv_update_store **store);
RSV_API void rsv_update_store_destroy(rsv_update_store *store); ///< NULL is allowed

/// Empties the store. The next update then solves its scene from scratch.
RSV_API void rsv_update_store_clear(rsv_update_store *store);

/// Memory of the store. An update needs about twice as much.
RSV_API size_t rsv_update_store_bytes(const rsv_update_store *store);

/// What an update reused and computed. Rays and rows are proportional to time. All `kept_...` fields are 0 if the scene
/// was solved from scratch.
typedef struct rsv_update_report {
    size_t rows;            ///< coarse elements with a row of their own
    size_t kept_elements;   ///< of these, elements that existed before, with unchanged surroundings
    size_t kept_rows;       ///< of these, rows of which no ray was traced
    uint64_t row_rays;      ///< rays of rows, including those of pilots
    uint64_t kept_row_rays; ///< of these, rays that were reused
    size_t lit_elements;    ///< elements, coarse and fine, for which direct light is sampled
    size_t kept_lit_elements; ///< of these, elements whose direct light was reused
    size_t
        waiting_triangles; ///< triangles whose light waits for a later call (rsv_light_follow_part)
    double seconds;        ///< time of the update
    double spared_seconds; ///< approximate time saved by reused rows
} rsv_update_report;

/// Builds and solves the operator of an edited scene, as rsv_light_create does, reusing what is still valid in the
/// store. The store then holds the new solution's data. After an error or cancellation, the store is unchanged.
///
/// If the scene has nothing in common with the previous one, or the settings differ, it is solved from scratch. With a
/// goal, only rows are reused. In a team, each process has its own store, for its part of the rows.
///
/// @param desc NULL = defaults; RSV_ERROR_ARGUMENT if it names folders (`checkpoint`, `earlier`)
/// @param report out; may be NULL
RSV_API rsv_status rsv_operator_update(const rsv_scene *scene, const rsv_solve_desc *desc,
    rsv_update_store *store, rsv_light **light, rsv_update_report *report);

/// Updates a light, in place, to another version of its scene, in which surfaces have moved or changed shape, or
/// punctual lights have moved: a later frame of an animation, or the scene after a user dragged something. If little
/// moves, this costs a small part of a solve. These are computed again: surfaces that moved, rays that meet their old
/// or new place, and light that they may block or let through. Elements are split where surfaces touch now. If much
/// moves, rsv_operator_update can be cheaper. Splits accumulate during a motion. To divide elements as a solve would,
/// call it again with the same scene once everything rests.
///
/// The first call traces all rows again and stores their rays, with at least 7 bytes per ray. Orders are no longer kept
/// separately (rsv_light_order_count is 0). The contributions of single lights (relight.h) are dropped: lights keep
/// their present strengths, and a light that was relit to 0 cannot be switched on again. Frame renderers of the light
/// show the change. An operator that was retained before stays as it was.
///
/// @return RSV_ERROR_UNSUPPORTED, with the light unchanged, if `scene` has other triangles, materials or lights, if a
/// translucent body changes its shape, and in teams of several processes. After any other error, the light can only be
/// destroyed
/// @param scene of the same context; may be destroyed after the call
/// @param report out; may be NULL
RSV_API rsv_status rsv_light_follow(
    rsv_light *light, const rsv_scene *scene, rsv_update_report *report);

/// As rsv_light_follow, with a limit to the work for surfaces that move, so that a large or deforming object, such as a
/// skinned figure, can be followed at interactive rates. Its geometry is up to date in every frame. The light that it
/// receives itself is computed for at most `most_triangles` of its triangles in a call; the others keep their light,
/// which moves with them, until their turn. While triangles wait, the light of what stays follows in turns, too: shadows
/// of sources within two calls, indirect light within four, and sharper edges of shadows within eight per level of
/// elements; and elements are not divided where surfaces touch. At rest, call it until report.waiting_triangles is 0, and
/// once more, as for rsv_light_follow: the light is then the same as without a limit. Or call rsv_light_follow once.
///
/// @param most_triangles 0 = no limit
RSV_API rsv_status rsv_light_follow_part(
    rsv_light *light, const rsv_scene *scene, size_t most_triangles, rsv_update_report *report);

#ifdef __cplusplus
}
#endif

#endif
