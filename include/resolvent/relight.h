/// @file relight.h
/// Changes lights and colours of a solved operator. The rows of G stay, so no rays are traced for them.
#ifndef RESOLVENT_RELIGHT_H
#define RESOLVENT_RELIGHT_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A factor for the sources with a given name: punctual lights and emissive materials, or, if none has that name,
/// lights placed by a node of that name. If no node has it either, `*` in the name matches any text. "environment" is the
/// environment. If a name is ambiguous, "#3" selects source number 3 (rsv_light_find_source).
typedef struct rsv_light_scale {
    const char *name;
    /// Factors of the strength of the source in the scene that was solved, 0..1e6; equal for all channels of the
    /// environment. They do not compound: 0.5 followed by 0.5 gives 0.5, and 0 can be followed by 1.
    rsv_rgb scale;
} rsv_light_scale;

/// A new base colour for a diffuse, opaque material without textures.
typedef struct rsv_albedo_change {
    const char *material;
    rsv_rgb base_color; ///< 0..1
} rsv_albedo_change;

/// A new position for a source: a punctual light other than a directional one, or all triangles of an emissive
/// material.
typedef struct rsv_light_move {
    const char *name;
    rsv_vec3 offset; ///< metres from its original position, at most 1e6 along each axis
} rsv_light_move;

/// A new direction for a spot light, luminaire or directional light. Luminaires without rotational symmetry rotate with
/// it.
typedef struct rsv_light_aim {
    const char *name;
    rsv_vec3 direction; ///< of any non-zero length
} rsv_light_aim;

typedef enum rsv_light_kind {
    RSV_LIGHT_MATERIAL,    ///< everything with an emissive material
    RSV_LIGHT_PUNCTUAL,    ///< a punctual light
    RSV_LIGHT_SURROUNDINGS ///< the environment
} rsv_light_kind;

/// Number of a light source. Emissive materials come first, in the order of the scene, then punctual lights, the
/// environment, and lights added by rsv_relighter_add_light().
/// @param index of the material or light in rsv_scene_view; 0 for the environment
/// @return RSV_NONE if it is not a source
RSV_API uint32_t rsv_light_find_source(const rsv_light *light, rsv_light_kind kind, uint32_t index);

/// Changes to lights and colours. Everything that is not named stays as in the scene that was solved.
typedef struct rsv_relight_desc {
    size_t size;                  ///< sizeof this structure; rsv_default_relight_desc() sets it
    const rsv_light_scale *light; ///< [light_count]
    size_t light_count;
    const rsv_albedo_change *albedo; ///< [albedo_count]
    size_t albedo_count;
    const rsv_light_move *move; ///< [move_count]
    size_t move_count;
    const rsv_light_aim *aim; ///< [aim_count]
    size_t aim_count;
    bool turn;      ///< whether to rotate the environment to `rotation`
    float rotation; ///< degrees about +y, counter-clockwise from above, as in rsv_environment
} rsv_relight_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_relight_desc().
RSV_API void rsv_relight_desc_init(rsv_relight_desc *desc, size_t size);
static inline rsv_relight_desc rsv_default_relight_desc(void)
{
    rsv_relight_desc desc;
    rsv_relight_desc_init(&desc, sizeof desc);
    return desc;
}

/// Changes a light and solves again. E0 is the sum of the contributions of all sources, each multiplied by its scale.
/// They come from the operator file, or are computed here, which costs as much as the direct light of a solve. These
/// parts are sampled again, on elements that are split further where necessary: light that translucent bodies receive
/// directly, moved lights, and suns of a rotated environment. Other light of a rotated environment is known for each
/// direction.
///
/// The original scene and its other lights stay unchanged; rsv_light_scene returns the scene with the changes. The
/// solution must not be used by other threads during the call.
///
/// The rows of G stay unchanged. A moved lamp moves its light and the shadows in it. What its body hides of other
/// lights and of reflected light stays hidden at its original position.
///
/// @return RSV_ERROR_ARGUMENT for unknown names (the message lists the known ones), factors and offsets out of range,
/// directions of length 0, and the rotation of an environment if there is none. RSV_ERROR_UNSUPPORTED for materials
/// whose colour is part of G, for lamps that only gather rays find (unequal scales, moves), for moving directional
/// lights, and for aiming lights that shine equally in all directions. After any other error, the light may only be
/// destroyed.
RSV_API rsv_status rsv_light_relight(rsv_light *light, const rsv_relight_desc *desc);

/// For repeated changes, as in an interactive program: keeps the contributions to E0, and starts each solve from the
/// last.
typedef struct rsv_relighter rsv_relighter;

/// Creating it takes 0.4 to 1.3 s in typical scenes, so keep it while changes may follow. If the light does not have
/// the contributions of its sources, they are computed first. The light must outlive the relighter, and keeps its last
/// state.
RSV_API rsv_status rsv_relighter_create(rsv_light *light, rsv_relighter **relighter);
RSV_API void rsv_relighter_destroy(rsv_relighter *relighter);

/// Prepares the first change of each kind, which takes as long as a solve and sorting the receivers. Worthwhile if many
/// changes follow. The contribution of every source, bounces included, is then kept (up to 512 MiB). While only
/// strengths change, rsv_relighter_change gives the right light at once, without steps. After other changes, the first
/// change of strengths solves for every source again once everything has settled.
RSV_API rsv_status rsv_relighter_prepare(rsv_relighter *relighter);

/// A source and its present state.
typedef struct rsv_relight_source {
    const char *name;
    /// Unscaled: radiance of a lamp, intensity of a light, 1 for the environment
    rsv_rgb strength;
    rsv_rgb scale;     ///< present
    rsv_vec3 position; ///< present; of a lamp, the mean of its vertices
    bool movable;
    const char *node; ///< node that placed the light, if several share a name; NULL = none
    rsv_light_kind kind;
    uint32_t index; ///< of the material or light in the scene
} rsv_relight_source;

RSV_API size_t rsv_relighter_source_count(const rsv_relighter *relighter);
RSV_API rsv_relight_source rsv_relighter_source(const rsv_relighter *relighter, size_t index);

/// Adds a punctual light to the solution and its scene, as the last source. It can be named like the others; a desc
/// that does not name it leaves it unchanged. Its caustics are computed if the scene had any before.
/// @return RSV_ERROR_ARGUMENT if there is a source of that name, and errors as in rsv_scene_add_light
RSV_API rsv_status rsv_relighter_add_light(
    rsv_relighter *relighter, const rsv_punctual_light *light);

/// Changes E0. Then call rsv_relighter_step and rsv_relighter_settle to solve. Rays are traced for sources that have
/// moved since the last call, few of them until the light settles. The first move takes longer than later ones. Errors
/// are those of rsv_light_relight; after RSV_ERROR_ARGUMENT and RSV_ERROR_UNSUPPORTED, everything is unchanged.
/// @param desc changes relative to the state at creation of the relighter
RSV_API rsv_status rsv_relighter_change(rsv_relighter *relighter, const rsv_relight_desc *desc);

typedef struct rsv_relight_progress {
    uint32_t orders; ///< applications of G K in this step
    double residual; ///< largest change by the last of them, relative to the largest E0
    bool converged;  ///< residual <= 1e-3
} rsv_relight_progress;

/// Improves the solution for the present sources, with at least one application of G K, until it has converged or time
/// is up. Does nothing once it has converged. Orders of light and translucent surfaces keep their last settled state.
/// @param progress out; may be NULL
RSV_API rsv_status rsv_relighter_step(
    rsv_relighter *relighter, double milliseconds, rsv_relight_progress *progress);

/// Completes the solution: all rays of moved sources, all orders of light, translucent surfaces. Does nothing if it is
/// complete. Elements are kept, and limit how sharp moved shadows and caustics are.
RSV_API rsv_status rsv_relighter_settle(rsv_relighter *relighter);

/// Like rsv_relighter_settle, but first splits elements of direct light and caustics where moved sources require it.
/// The result is that of rsv_light_relight. Returning to the original settings also restores the original elements.
RSV_API rsv_status rsv_relighter_refine(rsv_relighter *relighter);

/// Number of times that elements were replaced, by rsv_relighter_refine or by returning to the original settings. If it
/// has grown, create everything that shows the light (frame renderers, movers) again.
RSV_API uint32_t rsv_relighter_replacements(const rsv_relighter *relighter);

/// Whether the solution is complete, so that rsv_relighter_settle would do nothing.
RSV_API bool rsv_relighter_is_settled(const rsv_relighter *relighter);

/// Shadow rays and photon steps traced for changes since creation.
RSV_API uint64_t rsv_relighter_rays(const rsv_relighter *relighter);

#ifdef __cplusplus
}
#endif

#endif
