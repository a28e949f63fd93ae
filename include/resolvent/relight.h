/// @file relight.h
/// Other lights and colours on a solved operator: rows of G stay as they are, so no rays are traced for them.
#ifndef RESOLVENT_RELIGHT_H
#define RESOLVENT_RELIGHT_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A source by the name of its punctual light or emissive material, or, if none is called so, of the node that placed the
/// light; "environment" is the surroundings. All sources of a name are meant. "#3", where nothing else is called so, is the
/// source of number 3 alone (rsv_light_find_source), for those that names do not tell apart.
typedef struct rsv_light_scale {
    const char *name;
    /// Factors of the strength that the source has in the scene it was solved for, 0..1e6; of the surroundings: all three
    /// alike. They do not compound: 0.5 and then 0.5 again is 0.5, and 0 can be followed by 1.
    rsv_rgb scale;
} rsv_light_scale;

/// A new base colour for a material that is diffuse, opaque and of one colour all over.
typedef struct rsv_albedo_change {
    const char *material;
    rsv_rgb base_color; ///< 0..1
} rsv_albedo_change;

/// A source in another place: a punctual light that is not distant, or all triangles of an emissive material.
typedef struct rsv_light_move {
    const char *name;
    rsv_vec3 offset; ///< metres from where it began, at most 1e6 along each axis
} rsv_light_move;

/// A spot light, luminaire or directional light that shines another way. What of it is not round turns along.
typedef struct rsv_light_aim {
    const char *name;
    rsv_vec3 direction; ///< of any length above 0
} rsv_light_aim;

typedef enum rsv_light_kind {
    RSV_LIGHT_MATERIAL,    ///< all that emits by one material
    RSV_LIGHT_PUNCTUAL,    ///< a punctual light
    RSV_LIGHT_SURROUNDINGS ///< the environment
} rsv_light_kind;

/// The number of a source of light: materials that emit come first, in the order of the scene, then punctual lights, then
/// the surroundings, then lights that rsv_relighter_add_light() added.
/// @param index of the material or light in rsv_scene_view; 0 for surroundings
/// @return RSV_NONE where it is no source
RSV_API uint32_t rsv_light_find_source(const rsv_light *light, rsv_light_kind kind, uint32_t index);

/// What is not named is as it was when relighting began.
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
    bool turn;      ///< whether the surroundings turn to `rotation`
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

/// Changes a light and solves again: E0 is the sum of the sources' parts, each times its scale. The scene that it was made
/// of stays as it is, as do other lights of it: rsv_light_scene says how this one has it from then on. The parts come from
/// the file, or are sampled here if it has none, which costs as much as the direct light of the solve. What translucent
/// bodies show directly is sampled again, and so are lights that move and the suns of surroundings that turn, on elements
/// split further for that; the rest of these is known direction by direction. Nobody else may use the solution meanwhile.
///
/// Rows of G stay as they are: a lamp that moves takes its light and the shadows in it along, but what its own body
/// hides of other lights and of what surfaces reflect stays hidden where it began.
///
/// RSV_ERROR_ARGUMENT for unknown names (the message lists the known ones), factors and offsets out of range and
/// surroundings that are to turn where there are none, directions of length 0,
/// RSV_ERROR_UNSUPPORTED for materials whose colour is part of G, for unequal scales of lamps that only
/// gather rays find, for moving these or what is infinitely far away, and for turning what
/// shines alike to all sides. After other errors the solution may be used no
/// more.
RSV_API rsv_status rsv_light_relight(rsv_light *light, const rsv_relight_desc *desc);

/// The same over and over, while somebody looks on: keeps the parts of E0 and starts each solve from the last.
typedef struct rsv_relighter rsv_relighter;

/// The light must outlive it, and stays as it was last put. Setting up takes 0.4 to 1.3 s in scenes of usual size: keep a
/// relighter for as long as changes may follow. Where the light has no parts yet, they are sampled first.
RSV_API rsv_status rsv_relighter_create(rsv_light *light, rsv_relighter **relighter);
RSV_API void rsv_relighter_destroy(rsv_relighter *relighter);

/// Does beforehand most of what the first change of each kind would have to set up: worth its time (that of a solve, and
/// of sorting the receivers) where changes are to follow one another. From then on what every source does by itself,
/// bounces included, is kept, up to 512 MiB: while strengths alone change, rsv_relighter_change makes them right at once
/// and no steps are needed. After sources or colours have changed, the first change of strengths once all has settled
/// solves for every source again.
RSV_API rsv_status rsv_relighter_prepare(rsv_relighter *relighter);

/// What can be changed of a source, and how it stands.
typedef struct rsv_relight_source {
    const char *name;
    rsv_rgb
        strength; ///< unscaled: of a lamp its radiance, of a light its intensity, of surroundings 1
    rsv_rgb scale;     ///< present
    rsv_vec3 position; ///< present; of a lamp, the mean of its vertices
    bool movable;
    const char *node; ///< that placed a light, where several share a name; NULL = none
    rsv_light_kind kind;
    uint32_t index; ///< of the material or light in the scene
} rsv_relight_source;

RSV_API size_t rsv_relighter_source_count(const rsv_relighter *relighter);
RSV_API rsv_relight_source rsv_relighter_source(const rsv_relighter *relighter, size_t index);

/// Adds a punctual light to the solution and its scene; the last source then. It can be named like the others, and a desc that does
/// not name it leaves it as it was added. Its caustics are found where the scene had any before.
/// RSV_ERROR_ARGUMENT if there is a source of that name, or as in rsv_scene_add_light.
RSV_API rsv_status rsv_relighter_add_light(
    rsv_relighter *relighter, const rsv_punctual_light *light);

/// Changes E0; rsv_relighter_step and rsv_relighter_settle find what follows of it. Rays are traced for sources that
/// stand elsewhere than at the last call, few of them until the light settles. The first move takes longer: it sets up
/// what the next ones share. Errors as in rsv_light_relight; the first two kinds leave everything as it was.
/// @param desc against how things were when the relighter was created
RSV_API rsv_status rsv_relighter_change(rsv_relighter *relighter, const rsv_relight_desc *desc);

typedef struct rsv_relight_progress {
    uint32_t orders; ///< applications of G K in this step
    double residual; ///< largest change of the last of them, relative to the largest E0
    bool converged;  ///< residual <= 1e-3
} rsv_relight_progress;

/// Carries the solution towards the present sources, one application of G K at least, until it has converged or
/// the time is over. Does nothing once it has. Orders of light and translucent surfaces stay as they last settled.
/// @param progress may be NULL
RSV_API rsv_status rsv_relighter_step(
    rsv_relighter *relighter, double milliseconds, rsv_relight_progress *progress);

/// Makes everything exact: sources that moved with all their rays, every order of light, translucent surfaces. Does nothing
/// where it is exact already. Elements stay as they are: shadows and caustics that moved are as sharp as these allow.
RSV_API rsv_status rsv_relighter_settle(rsv_relighter *relighter);

/// The same after splitting elements of direct light and caustics further, where sources that moved ask for that. Then the
/// solution is what rsv_light_relight makes of it. Settings that go back to the beginning bring its elements back, too.
RSV_API rsv_status rsv_relighter_refine(rsv_relighter *relighter);

/// How often elements were replaced, by rsv_relighter_refine or by a change that goes back to the beginning: whenever this
/// has grown, what shows the light (frame renderers, movers) has to be created again.
RSV_API uint32_t rsv_relighter_replacements(const rsv_relighter *relighter);

/// Whether nothing is left for rsv_relighter_settle.
RSV_API bool rsv_relighter_is_settled(const rsv_relighter *relighter);

/// Shadow rays and steps of photons traced for changes since it was created.
RSV_API uint64_t rsv_relighter_rays(const rsv_relighter *relighter);

#ifdef __cplusplus
}
#endif

#endif
