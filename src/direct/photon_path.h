/// Photons on their way from a source to where they land: plain C, also for device code.
#ifndef RSV_PHOTON_PATH_H
#define RSV_PHOTON_PATH_H

#if !defined(RSV_DEVICE_CODE)
#include "photon_air.h"
#endif
#include "../trace/ray.h"
#include "photon_guide.h"
#include "photon_map.h"
#include "photon_origin.h"
#include "photon_turn.h"

/// Origins of light paths that share one guide.
typedef struct rsv_photon_source {
    uint32_t first, count;  ///< origins
    double flux;            ///< of all of them: luminance, W
    double share;           ///< of all photons
    rsv_photon_guide guide; ///< towards specular surfaces
} rsv_photon_source;

/// How many of all photons leave from a source.
RSV_INLINE uint32_t rsv_photons_of_source(const rsv_photon_source *source, uint32_t all)
{
    return (uint32_t)ceil(source->share * all);
}

struct rsv_fog_witness; // specular/fog_flight.h

/// Data common to all photons.
typedef struct rsv_shooting {
    const rsv_transport_scene *scene;
    const rsv_photon_origins *origins;
    uint32_t seed;
} rsv_shooting;

/// A photon at a surface.
typedef struct rsv_photon {
    rsv_specular_path path;
    rsv_rgb flux; ///< that it left with, W
    float level;  ///< weight that it keeps: that after the first surface
    rsv_random random;
} rsv_photon;

RSV_INLINE bool rsv_is_specular(const rsv_bsdf *bsdf)
{
    return (!bsdf->lambert && !bsdf->unlit) || bsdf->opacity < 1;
}

/// Applies the attenuation of fog. Devices get no scenes with fog.
RSV_INLINE void rsv_photon_dim(const rsv_transport_scene *scene, rsv_specular_path *path)
{
#if defined(RSV_DEVICE_CODE)
    (void)scene, (void)path;
#else
    rsv_specular_dim(scene, path);
#endif
}

/// Follows a photon to its first surface. False if that is not specular, or if there is none.
RSV_INLINE bool rsv_photon_arrive(
    const rsv_transport_scene *scene, const rsv_photon_emission *e, rsv_specular_path *path)
{
    rsv_ray ray = { e->origin, e->direction, INFINITY };
    rsv_hit hit;
    if (!rsv_ray_meets(scene->tracer, &ray, &hit)) return false;
    *path = rsv_specular_begin(scene, e->medium, e->direction, hit);
    rsv_photon_dim(scene, path);
    return rsv_is_specular(&scene->bsdf[rsv_specular_material(scene, path)]);
}

/// Photon `index` of `count` from source `id`, as it leaves.
RSV_INLINE rsv_photon_emission rsv_photon_set_out(const rsv_shooting *s,
    const rsv_photon_source *source, uint32_t id, uint32_t index, uint32_t count,
    rsv_photon *photon)
{
    float x, y;
    photon->random = rsv_random_from(s->seed ^ 0x3c6ef35fu, id, index);
    rsv_sobol_2d(index, rsv_hash2(s->seed, id), &x, &y);
    float density = rsv_photon_guide_warp(&source->guide, &x, &y);
    rsv_photon_emission e =
        rsv_photon_emit(s->origins, source->first, source->count, x, y, &photon->random);
    photon->flux = rgb_scale(e.flux, 1 / (density * (float)count));
    photon->level = 0;
    return e;
}

/// The same at its first surface. False if it is of no use.
RSV_INLINE bool rsv_photon_begin(const rsv_shooting *s, const rsv_photon_source *source,
    uint32_t id, uint32_t index, uint32_t count, rsv_photon *photon)
{
    rsv_photon_emission e = rsv_photon_set_out(s, source, id, index, count, photon);
    return rsv_photon_arrive(s->scene, &e, &photon->path);
}

/// Draws a specular event of a photon. At the first surface that it does not merely pass it always leaves, with less
/// flux, so that faint coats have as many photons as their light is worth.
RSV_INLINE rsv_bsdf_event rsv_photon_draw(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_random *random)
{
    rsv_bsdf storage;
    bool covered = rsv_specular_bsdf(scene, path, &storage)->opacity >= 1;
    if (!covered || path->turns > 0) return rsv_specular_draw_event(scene, path, random);
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(random);
    return rsv_specular_draw_specular(scene, path, u);
}

/// Follows a photon through the fog on its segment. False if it ends there, or leaves the scene.
/// @param air receives segments after a specular event; NULL = none
RSV_INLINE bool rsv_photon_cross(const rsv_transport_scene *scene, rsv_specular_path *path,
    rsv_specular_move move, rsv_random *random, const struct rsv_fog_witness *air)
{
#if !defined(RSV_DEVICE_CODE)
    if (scene->view->fog && path->turns > 0)
        return rsv_photon_cross_fog(scene, path, move, random, air);
#endif
    (void)random, (void)air;
    rsv_photon_dim(scene, path);
    return move == RSV_SPECULAR_MOVED;
}

/// Photons caught in a body would take thousands of rays, and hardly ever land: in clear air, they end.
RSV_INLINE bool rsv_photon_goes_on(
    const rsv_transport_scene *scene, rsv_specular_path *path, rsv_random *random)
{
    bool caught = path->medium.depth > 0 && !scene->view->fog;
    return caught ? path->events < RSV_SPECULAR_MAX_EVENTS : rsv_specular_goes_on(path, random);
}

/// Goes on to the next surface, past this one or by one of its specular lobes. False if the photon ends.
/// @param level as in rsv_photon @param air as in rsv_photon_cross
RSV_INLINE bool rsv_photon_step(const rsv_transport_scene *scene, rsv_specular_path *path,
    float *level, rsv_random *random, const struct rsv_fog_witness *air)
{
    rsv_bsdf_event event = rsv_photon_draw(scene, path, random);
    bool passes = event.lobe == RSV_LOBE_PASS;
    bool specular = event.lobe == RSV_LOBE_REFLECT || event.lobe == RSV_LOBE_TRANSMIT;
    if (!(passes || specular) || !rsv_photon_goes_on(scene, path, random)) return false;
    bool first = path->turns == 0 && !passes;
    rsv_rgb weight = event.weight;
    if (!passes) weight = rgb_mul(weight, rsv_photon_turn(scene, path, &event));
    rsv_specular_move move = rsv_specular_follow(scene, path, &event, weight);
    if (!rsv_photon_cross(scene, path, move, random, air)) return false;
    float left = rgb_max(path->weight);
    if (path->turns == 0) return true;
    if (first) *level = left;
    if (left >= *level) return left > 0;
    if (rsv_random_float(random) * *level >= left) return false;
    path->weight = rgb_scale(path->weight, *level / left);
    return true;
}

/// Finds the next surface where the photon lands, after at least one specular event. Shadow rays find light that only
/// passes blended surfaces. False if the photon ends.
/// @param air as in rsv_photon_cross
RSV_INLINE bool rsv_photon_scatter(const rsv_transport_scene *scene, rsv_specular_path *path,
    float *level, rsv_random *random, const struct rsv_fog_witness *air)
{
    while (rsv_photon_step(scene, path, level, random, air)) {
        if (path->turns > 0) return true;
        if (!rsv_is_specular(&scene->bsdf[rsv_specular_material(scene, path)])) return false;
    }
    return false;
}

/// The part of a photon's flux that enters the surface where it lands.
RSV_INLINE rsv_rgb rsv_photon_enter(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_rgb flux)
{
    rsv_vec3 shading, geometric;
    rsv_bsdf storage;
    rsv_specular_normals(scene, path, &shading, &geometric);
    const rsv_bsdf *bsdf = rsv_specular_bsdf(scene, path, &storage);
    rsv_rgb entered = rgb_scale(rsv_bsdf_entry(bsdf, -v3_dot(shading, path->direction)),
        rsv_photon_tilt(shading, geometric, path->direction));
    return rgb_mul(flux, entered);
}

/// Adds that part to the maps.
RSV_INLINE void rsv_photon_land(const rsv_transport_scene *scene, const rsv_specular_path *path,
    rsv_rgb flux, const rsv_photon_map *map, size_t map_count)
{
    rsv_rgb entered = rsv_photon_enter(scene, path, flux);
    for (size_t m = 0; m < map_count; m++)
        rsv_photon_map_deposit(&map[m], path->back, path->triangle, path->u, path->v, entered);
}

// ---- pilots -------------------------------------------------------------------------------------

/// Worth of photons whose first landing is of no use; later ones may be.
#define RSV_UNWANTED_PHOTON 0.1f

/// A pilot ray into a bin of a source's guide. False if it finds nothing specular.
RSV_INLINE bool rsv_photon_pilot(const rsv_shooting *s, const rsv_photon_source *source,
    const rsv_guide_grid *grid, int bin, rsv_random *random, rsv_specular_path *path)
{
    const float *across = grid->x + bin % RSV_GUIDE_SIDE, *down = grid->y + bin / RSV_GUIDE_SIDE;
    float x = across[0] + (across[1] - across[0]) * rsv_random_float(random);
    float y = down[0] + (down[1] - down[0]) * rsv_random_float(random);
    rsv_photon_emission e = rsv_photon_emit(s->origins, source->first, source->count, x, y, random);
    return rsv_photon_arrive(s->scene, &e, path);
}

/// The random numbers of a bin's pilot rays.
RSV_INLINE rsv_random rsv_pilot_numbers(const rsv_shooting *s, uint32_t id, int bin)
{
    return rsv_random_from(s->seed ^ 0x9107u, id, (uint32_t)bin);
}

#endif
