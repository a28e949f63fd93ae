/// All sources of a committed scene, and how to sample them: emissive triangles ("emitters"), punctual lights and the
/// environment. Triangles with textured emission are divided into cells, each an emitter, down to bright texels, so
/// that selection by brightness follows the texture (emitter_cells.h).
///
/// Emitters with the same object and material form a group. Decisions are made by group, such as whether a source is so
/// large that gathering finds it better than next-event estimation.
#ifndef RSV_LIGHTS_H
#define RSV_LIGHTS_H

#include "../bsdf/bsdf.h"
#include "environment.h"
#include "light_tree.h"
#include "polygon_irradiance.h"
#include "resolvent/trace.h"

/// Halvings of a textured triangle's sides at most.
#define RSV_EMITTER_LEVELS 15

typedef struct rsv_emitter {
    rsv_vec3 corner[3];
    rsv_vec3 normal;  ///< unit, geometric, front
    rsv_rgb radiance; ///< its mean, if the emission is textured
    float area;
    uint32_t triangle; ///< in the scene
    float u[3], v[3];  ///< of the corners, on that triangle
    uint32_t group;
    /// Of the cell: two bits per division say which of four parts, from RSV_EMITTER_LEVELS pairs on down.
    uint32_t place;
    uint32_t
        cells; ///< that the triangle is divided into: side by side, in the order of their places
    bool double_sided;
    bool varies; ///< the emission is textured
} rsv_emitter;

typedef struct rsv_emitter_group {
    uint32_t first, count; ///< emitters are stored group by group
    double area;           ///< m2
    double power;          ///< luminance flux, W (both sides if double-sided)
    double share;          ///< cosine-weighted part of the hemisphere that it fills, without
                           ///< occlusion, on average over the scene's surfaces; 0..1
    /// Fills so much of the view of surfaces that gather rays find it best, so it is not used in next-event estimation
    /// and light tracing. In a closed uniform furnace, the solution is then exact.
    bool gathered;
    bool muted; ///< gives no light at all: the others of a subset (light_subset.h)
} rsv_emitter_group;

/// A group that fills more than this fraction is gathered. If all emitters together fill more than the second fraction,
/// groups that are not much brighter (by the factor) than the mean of the view are gathered too.
#define RSV_GATHERED_SHARE 0.25
#define RSV_GATHERED_TOTAL_SHARE 0.5
#define RSV_GATHERED_CONTRAST 4

typedef struct rsv_lights {
    rsv_context *context;
    const rsv_scene_view *scene;
    rsv_emitter *emitter;
    rsv_emitter_group *group;
    size_t emitter_count, group_count;
    uint32_t *triangle_emitter; ///< [triangle_count] the first of its emitters; RSV_NONE = none
    uint32_t *sampled;          ///< indices of the emitters that next-event estimation samples
    size_t sampled_count;
    /// The first of `sampled` are weighed one by one at every receiver: all emitting ones if there are at most
    /// RSV_LOCAL_LIGHTS, otherwise the few that give most of the light, if there are such. The others are in the tree.
    size_t weighed_count;
    rsv_light_tree *emitter_tree; ///< over those of `sampled` not weighed; NULL = none shines
    uint32_t *punctual;           ///< [light_count] those that shine: distant ones, then the others
    size_t distant_count, punctual_count;
    bool extended; ///< some of these have a size: rays to them go to different places
    rsv_light_tree *punctual_tree; ///< over those not distant; NULL = RSV_SUMMED_LIGHTS or fewer
    rsv_environment_light *environment; ///< NULL = black surroundings
} rsv_lights;

/// The environment stays undivided.
/// @param bsdf [material_count], borrowed
rsv_status rsv_lights_create(const rsv_scene *scene, const rsv_bsdf *bsdf, rsv_lights **lights);

/// Warns if nothing emits.
void rsv_lights_warn_if_dark(const rsv_lights *lights);
void rsv_lights_destroy(rsv_lights *lights);

/// Takes over where sources stand after some were moved, nothing else having changed.
rsv_status rsv_lights_follow(rsv_lights *lights);

/// Updates the strengths of emitters and punctual lights; the environment stays as it is.
/// @param bsdf [material_count], borrowed
/// @param followed out: false, with nothing changed, if other materials are emissive now; create the lights again
rsv_status rsv_lights_follow_strengths(rsv_lights *lights, const rsv_bsdf *bsdf, bool *followed);

/// The place of the smallest cell around a point of a triangle.
RSV_INLINE uint32_t rsv_emitter_place(float u, float v)
{
    float b[3] = { 1 - u - v, u, v };
    uint32_t place = 0;
    for (int level = 0; level < RSV_EMITTER_LEVELS; level++) {
        uint32_t part = b[0] >= 0.5f ? 0 : b[1] >= 0.5f ? 1 : b[2] >= 0.5f ? 2 : 3;
        for (uint32_t k = 0; k < 3; k++)
            b[k] = part == 3 ? 1 - 2 * b[k] : 2 * b[k] - (k == part ? 1 : 0);
        place = place << 2 | part;
    }
    return place;
}

/// Whether its two sides may shine differently: other faces cover a part of one.
bool rsv_emitter_sides_differ(const rsv_scene_view *scene, const rsv_emitter *emitter);

/// The emitter at barycentric (u, v) of a triangle; RSV_NONE = it does not emit.
RSV_SHARED uint32_t rsv_emitter_at(const rsv_lights *lights, uint32_t triangle, float u, float v);

/// Radiance of a side of an emitter at barycentric (u, v) of the emitter itself.
RSV_SHARED rsv_rgb rsv_emitter_radiance(
    const rsv_lights *lights, uint32_t emitter, bool back, float u, float v);

/// Luminance flux of both sides that emit, W.
RSV_INLINE double rsv_emitter_power(const rsv_emitter *emitter)
{
    int sides = emitter->double_sided ? 2 : 1;
    return sides * (double)RSV_PI * rgb_luminance(emitter->radiance) * emitter->area;
}

/// Whether rsv_local_lights_sample has anything to find.
bool rsv_lights_any_sampled(const rsv_lights *lights);

#define RSV_LOCAL_LIGHTS 64

/// Emitters, suns and the sampled part of the sky as one receiver sees them: selection probabilities proportional to
/// the unshadowed irradiance (luminance), for the emitters that are weighed; the others by a light tree.
typedef struct rsv_local_lights {
    const rsv_lights *lights;
    rsv_vec3 point, normal;
    uint32_t count;   ///< emitters in `probability`, ahead of suns and sky
    float tree_share; ///< probability of a choice by the tree
    /// Rough irradiance (luminance) of the emitters in the tree; 0 only if they give none.
    float tree_estimate;
    float probability[RSV_LOCAL_LIGHTS + RSV_MAX_SUNS + 1];
    /// Irradiance of all but the emitters in the tree without occlusion, emitters with their mean radiance.
    rsv_rgb unshadowed;
} rsv_local_lights;

/// Whether no sampled source gives light here, occlusion or not.
RSV_INLINE bool rsv_local_lights_are_dark(const rsv_local_lights *local)
{
    return !(local->tree_share > 0) && rgb_is_black(local->unshadowed);
}

RSV_SHARED void rsv_lights_at(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, rsv_local_lights *local);

/// The same in less time: emitters are chosen by a guess of their irradiance, and `unshadowed` is none to go by.
RSV_SHARED void rsv_lights_about(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, rsv_local_lights *local);

typedef struct rsv_light_sample {
    rsv_vec3 direction; ///< unit, towards the source
    float distance;     ///< metres to the source; INFINITY for suns and sky
    rsv_rgb radiance;   ///< arriving along direction, without occlusion
    rsv_rgb
        mean_radiance; ///< mean of the emitter, as in `unshadowed`; 0 = chosen by the tree
    float pdf_solid_angle; ///< including the selection of the source
    uint32_t emitter;      ///< RSV_NONE for suns and sky
    bool from_sky;         ///< not from an emitter or a sun
    float u, v;            ///< place on the emitter, if it varies
    bool back;             ///< which side of the emitter
} rsv_light_sample;

/// Whether `unshadowed` counts its source: all but emitters that the tree chose.
RSV_INLINE bool rsv_light_sample_is_weighed(const rsv_light_sample *sample)
{
    return !rgb_is_black(sample->mean_radiance);
}

/// Samples a source towards the receiver. Emitters: uniform in the solid angle of the chosen triangle (Arvo
/// 1995) where that is numerically sound, uniform in area otherwise. False if nothing can
/// contribute.
RSV_SHARED bool rsv_local_lights_sample(
    const rsv_local_lights *local, float u_select, float u1, float u2, rsv_light_sample *sample);

/// Density with which rsv_local_lights_sample would have drawn the point at `distance` along
/// `direction` on `emitter`.
RSV_SHARED float rsv_local_lights_pdf(
    const rsv_local_lights *local, uint32_t emitter, rsv_vec3 direction, float distance);

/// Density with which rsv_local_lights_sample would have drawn `direction` from the sky.
RSV_SHARED float rsv_local_lights_sky_pdf(const rsv_local_lights *local, rsv_vec3 direction);
/// The same for sun k, if the direction lies within it.
RSV_SHARED float rsv_local_lights_sun_pdf(
    const rsv_local_lights *local, uint32_t k, rsv_vec3 direction);

#if defined(RSV_DEVICE_CODE)
#include "emitter_body.h"
#include "local_lights_body.h"
#endif

#endif
