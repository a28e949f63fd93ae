/// A picture in progress, row by row: camera rays in packets, and the results of each pixel.
#ifndef RSV_PICTURE_ROW_H
#define RSV_PICTURE_ROW_H

#include "../solve/light.h"
#include "../trace/film.h"
#include "camera_path.h"
#include "picture_guides.h"
#include "pixel_direct.h"
#include "pixel_noise.h"
#include "resolvent/render.h"

/// Layers after the picture itself: emission, then one per kept order.
#define RSV_PICTURE_LAYERS (1 + RSV_KEPT_ORDERS)

/// One pass over a picture.
typedef struct rsv_picture_job {
    const rsv_light_view *solution;
    const rsv_render_desc *desc;
    const rsv_camera *camera;
    rsv_film film;
    rsv_medium medium; ///< the camera's
    rsv_image *image;
    uint32_t layer_count; ///< of light, layer 0 included; the image has guides behind them
    bool guides;          ///< whether it has them
    float spread;         ///< of a camera ray: the angle of a pixel
    rsv_sky sky;          ///< beyond the scene
    rsv_camera_setting setting;
    uint32_t seed;          ///< of the pass
    rsv_pixel_noise *noise; ///< [height * width] of the first pass; NULL = not needed
    const uint32_t *count;  ///< [height * width] camera rays of this pass; NULL = desc->samples
    uint32_t parts, part;   ///< camera rays are dealt out to so many pictures, of which this is one
    uint32_t before;        ///< camera rays per pixel that are in the image already
    bool gathers_sources;   ///< gather rays bring what else surfaces store of light from sources
    uint32_t gather_seed;   ///< of the pattern of gather rays; 0: parts share one
    const uint8_t *where;   ///< [height * width] pixels whose light is gathered; NULL = all
} rsv_picture_job;

/// Camera rays of one row, traced together.
typedef struct rsv_picture_batch {
    rsv_ray_packet packet;
    uint32_t column[RSV_PACKET_WIDTH], sample[RSV_PACKET_WIDTH], count;
} rsv_picture_batch;

/// One row of the picture in the making.
typedef struct rsv_picture_row {
    const rsv_picture_job *job;
    rsv_rgb *layer[1 + RSV_PICTURE_LAYERS]; ///< [width] each
    rsv_rgb *guide[RSV_PICTURE_GUIDES];     ///< [width] each; NULL = none
    rsv_pixel_noise *noise;                 ///< [width] of this row and pass
    rsv_pixel_direct direct;
    rsv_picture_batch batch;
    uint32_t row;
    // data about the current ray for rsv_camera_path's callback
    uint32_t column;
    rsv_pixel_sample sample;
    bool is_diffuse; ///< what is added is reflected diffusely by the first surface
} rsv_picture_row;

/// Whether the pixel in hand gathers indirect light.
RSV_INLINE bool rsv_picture_gathers(const rsv_picture_row *row)
{
    const rsv_picture_job *job = row->job;
    if (job->desc->mode != RSV_RENDER_FINAL || !job->desc->gather_rays) return false;
    return !job->where || job->where[(size_t)row->row * job->desc->width + row->column];
}

/// @return RSV_ERROR_MEMORY: it must still be destroyed
rsv_status rsv_picture_row_create(const rsv_picture_job *job, rsv_picture_row *row);
void rsv_picture_row_destroy(rsv_picture_row *row);

/// rsv_camera_setting.cross_fog of a row.
rsv_rgb rsv_picture_cross_fog(
    void *row, const rsv_ray *segment, rsv_rgb throughput, uint32_t trail);

/// Renders a row of pixels into the job's image.
rsv_status rsv_picture_row_render(rsv_picture_row *row, uint32_t index);

#endif
