/// Rays of rough lobes: some cells of a tile trace one each, and the light at its hit is looked up.
///
/// Sources count as in pictures: those of next-event estimation are sampled and hit by chance, combined by the power
/// heuristic. Surfaces that rays hit have their stored light: that of their diffuse lobe, and of their rough ones as if
/// their own illumination were uniform. Mirrors and glass pass the ray on.
#ifndef RSV_GLOSSY_RAYS_H
#define RSV_GLOSSY_RAYS_H

#include "../render/rough_light.h"
#include "glossy_cells.h"
#include "highlights.h"
#include "packet_kernels.h"

/// Rays that are on their way together, and where their light goes.
typedef struct rsv_glossy_rays {
    const rsv_packet_kernels *kernels;
    const rsv_light_table *table;
    rsv_ray_packet packet;
    rsv_packet_places places;
    size_t cell[RSV_LANES];    ///< of rsv_glossy_cells
    rsv_rgb weight[RSV_LANES]; ///< of the ray's light
    rsv_rgb known[RSV_LANES];  ///< found already
    rsv_rgb albedo[RSV_LANES]; ///< that the sum is divided by
    rsv_rough_departure departure[RSV_LANES];
    uint32_t trail[RSV_LANES];
    uint32_t count;
    uint64_t rays, poor; ///< of the frame; poor cells (RSV_GLOSSY_POOR)
} rsv_glossy_rays;

void rsv_glossy_rays_create(
    const rsv_packet_kernels *kernels, const rsv_light_table *table, rsv_glossy_rays *rays);

/// Input of a frame for the rays.
typedef struct rsv_glossy_task {
    const rsv_glossy_cells *cells;
    const rsv_frame_aim *aim;
    const rsv_highlights *highlights;
    float spread; ///< of camera rays
    uint32_t seed;
    bool moves; ///< the camera
} rsv_glossy_task;

/// The camera's path to a pixel with a lobe. @param place the point that it shows
rsv_specular_path rsv_glossy_path(const rsv_transport_scene *scene, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, uint32_t pixel, rsv_vec3 place);

/// Variance of the normals across a cell, by those of the triangle's corners: sum over both directions, radian^2.
float rsv_corners_variance(const rsv_rough_surface *surface);

/// A pixel of a tile for rsv_highlight_share. @param variance of its normals
rsv_highlight_point rsv_highlight_point_of(
    const rsv_glossy_tile *tile, uint32_t pixel, const rsv_rough_surface *surface, float variance);

/// Widens lobes by the variance of normals within a pixel, in moving pictures.
/// @param variance as known so far @return that variance
float rsv_widen_highlights(rsv_rough_surface *surface, bool moves, float variance);

/// Adds the highlights of a tile's pixels that their cells do not have (highlights.h).
/// @param column, row of its first pixel @param radiance [RSV_TILE_PIXELS] in and out
void rsv_show_highlights(const rsv_glossy_rays *rays, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, uint32_t column, uint32_t row, float (*radiance)[4]);

/// Fills the cells of a tile: their places, and the samples of those whose turn it is.
/// @param column, row of its first pixel
void rsv_glossy_rays_of_tile(rsv_glossy_rays *rays, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, uint32_t column, uint32_t row);

#endif
