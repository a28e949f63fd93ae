/// Fog in frames: its light and transmittance between the eye and the hits of camera rays, on a grid of columns and
/// slices in front of the eye (froxels; Wronski 2014), from which pixels interpolate.
///
/// A column is a ray through every few pixels. Along it, light of voxels is integrated in closed form up to each slice,
/// as mode operator does for every camera ray. In cells that walls cut, the voxel is that of the nearest of 4 x 4 x 4
/// points.
#ifndef RSV_FOG_FRONT_H
#define RSV_FOG_FRONT_H

#include "../solve/light.h"
#include "../trace/camera_ray.h"

#define RSV_FOG_COLUMNS 160 ///< along the longer side of a picture
#define RSV_FOG_SLICES 48   ///< of a column

/// Voxels as a light shows them.
typedef struct rsv_fog_shine {
    const rsv_light_view *solution;
    uint32_t *part;    ///< [cut cells][64] the voxel of each place
    uint32_t *cut;     ///< [cell_count] first of `part`; RSV_NONE = the cell is whole
    rsv_rgb *radiance; ///< [voxel count] that fog there scatters and emits
    uint32_t layer;    ///< RSV_NONE = all; 0 = emission; n = light scattered n times
    bool gray;
} rsv_fog_shine;

rsv_status rsv_fog_shine_create(const rsv_light_view *solution, rsv_fog_shine *shine);
void rsv_fog_shine_destroy(rsv_fog_shine *shine);
/// After the light or the layer has changed.
void rsv_fog_shine_refresh(rsv_fog_shine *shine, uint32_t layer);

/// Radiance of fog along a ray up to its t_max. @param passed out: transmittance
rsv_rgb rsv_fog_shine_along(const rsv_fog_shine *shine, const rsv_ray *ray, rsv_rgb *passed);

/// Light of fog up to a slice, and its amount.
typedef struct rsv_fog_slice {
    float radiance[3];
    float column; ///< metres, rsv_fog_run.column
} rsv_fog_slice;

/// Columns of one eye.
typedef struct rsv_fog_front {
    uint32_t step; ///< pixels from column to column
    uint32_t across, down;
    float far;            ///< metres to the last slice
    rsv_fog_slice *slice; ///< [down][across][RSV_FOG_SLICES + 1]
} rsv_fog_front;

/// @param width, height of the largest picture
rsv_status rsv_fog_front_create(
    rsv_context *context, uint32_t width, uint32_t height, rsv_fog_front *front);
void rsv_fog_front_destroy(rsv_context *context, rsv_fog_front *front);

/// Before the columns of a frame. @param width, height of its picture
void rsv_fog_front_begin(rsv_fog_front *front, const rsv_fog_shine *shine, const rsv_camera *camera,
    uint32_t width, uint32_t height);
/// A row of columns.
void rsv_fog_front_fill(
    const rsv_fog_front *front, const rsv_fog_shine *shine, const rsv_lens *lens, uint32_t row);

/// Adds the fog in front of a pixel. @param x, y position in the picture, pixels @param distance INFINITY = no hit
/// @param radiance in and out
void rsv_fog_front_add(const rsv_fog_front *front, const rsv_fog_shine *shine, const float place[2],
    float distance, float radiance[4]);

#endif
