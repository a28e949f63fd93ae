/// Light of specular paths where they end or scatter, added to their pixels.
#ifndef RSV_SPECULAR_LIGHT_H
#define RSV_SPECULAR_LIGHT_H

#include "../mover/mover.h"
#include "../specular/specular_path.h"
#include "fog_front.h"
#include "glossy_tile.h"
#include "light_table.h"
#include "packet_kernels.h"

typedef struct rsv_specular_light {
    const rsv_light_table *table;
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    rsv_sky sky;
    uint32_t max_events;
    const rsv_mover *mover;     ///< NULL = none
    const rsv_fog_shine *shine; ///< NULL = the air is clear
    rsv_glossy_tile
        *gloss;    ///< receives the rough lobes at camera rays' hits; NULL = paths follow them
    rsv_vec3 eye;  ///< of the camera
    rsv_vec3 forward;
    bool parallel; ///< it is orthographic
    float (*radiance)[4]; ///< of pixels
    float *depth;   ///< metres along the path to the main surface of pixels; NULL = not needed
    float *carried; ///< its share
    uint32_t pixel, trail; ///< of the specular path in hand; trail as in camera_path.h
} rsv_specular_light;

/// Updates the solution's lights.
void rsv_specular_light_refresh(rsv_specular_light *light);

/// Adds radiance to the pixel in hand.
RSV_INLINE void rsv_add_light(rsv_specular_light *light, rsv_rgb radiance)
{
    float *sum = light->radiance[light->pixel];
    sum[0] += radiance.r, sum[1] += radiance.g, sum[2] += radiance.b;
}

/// Adds the light beyond the scene.
void rsv_add_sky(rsv_specular_light *light, rsv_vec3 direction, rsv_rgb weight);

/// Adds the stored light of the surface that a lane's ray hit. @param places in whole cells
void rsv_add_stored(rsv_specular_light *light, rsv_rgb throughput, const rsv_ray_packet *rays,
    const rsv_packet_places *places, uint32_t lane);

/// Adds the surface's own emission. @param bsdf of the surface
void rsv_add_emission(rsv_specular_light *light, const rsv_specular_path *path,
    const rsv_bsdf *bsdf, rsv_rgb throughput);

/// A diffuse surface that is not in the table, for rsv_camera_path too.
/// @param light an rsv_specular_light @param weight radiance at the camera per B / pi
void rsv_add_diffuse_end(void *light, const rsv_specular_path *path, rsv_rgb weight);

/// The same of a surface whose base color is known.
void rsv_add_diffuse_light(
    rsv_specular_light *light, const rsv_specular_path *path, rsv_rgb albedo, rsv_rgb weight);

/// Adds the light of the rough lobes of a surface behind mirrors and glass, as if their illumination were uniform.
/// @param point, bsdf of the surface
void rsv_add_even_gloss(rsv_specular_light *light, const rsv_specular_path *path,
    const rsv_surface_point *point, const rsv_bsdf *bsdf, rsv_rgb throughput);

/// Whether a point of the pixel in hand is seen through nothing but panes, and no lobe of the pixel is noted yet.
/// @param direction of the specular path that has come there
bool rsv_sees_through_panes(
    const rsv_specular_light *light, rsv_vec3 direction, rsv_vec3 point, rsv_rgb throughput);

/// Notes the lobes of a surface that the camera ray itself met, or through panes. @param distance to it from the eye
void rsv_note_gloss(rsv_specular_light *light, const rsv_specular_path *path,
    const rsv_surface_point *point, const rsv_bsdf *bsdf, float distance, rsv_rgb throughput);

/// All of a specular path, followed to its ends one by one.
void rsv_add_whole_path(rsv_specular_light *light, const rsv_specular_path *path);

/// The mover, where it ends a specular path. @param body, lane its hit
void rsv_add_mover(rsv_specular_light *light, const rsv_specular_path *path,
    const rsv_ray_packet *body, uint32_t lane);

/// Stored light of the surface that a lane's ray hit, with the mover's shadow. @param shown without the shadow
rsv_rgb rsv_shade_stored(const rsv_light_table *table, const rsv_mover *mover,
    const rsv_ray_packet *rays, uint32_t lane, uint32_t stream, rsv_rgb shown);

#endif
