/// Frames on a device: interface of the plug-in.
#ifndef RSV_DEVICE_FRAMES_H
#define RSV_DEVICE_FRAMES_H

#include "../bvh/bvh.h"
#include "../core/device.h"
#include "../sources/lights.h"
#include "../surface/medium.h"
#include "../trace/camera_ray.h"
#include "light_cells.h"
#include "resolvent/frame.h"
#include "tone.h"

/// Branches of specular paths are followed in waves, with room for each: deeper ones are for the processor.
#define RSV_DEVICE_CHAIN_DEPTH 64

/// A scene to make pictures of. All borrowed and copied to the device.
typedef struct rsv_device_stage {
    const rsv_scene_view *scene;
    const rsv_bsdf *bsdf; ///< [material_count]
    rsv_bvh_view bvh;
    const rsv_shown_side (*side)[2]; ///< [triangle_count + 1] as in rsv_light_table
    const rsv_shown_side (
        *received)[2]; ///< [triangle_count] cells of irradiance; RSV_SHOWN_SKY: none
    size_t cell_count;
    uint32_t width, height, eyes, path_depth, seed; ///< as in rsv_frame_desc
} rsv_device_stage;

/// The displayed light.
typedef struct rsv_device_light {
    const rsv_light_cell *cell;  ///< [cell_count]
    const rsv_scene_view *scene; ///< the stage's, for its materials as they are now
    const rsv_bsdf *bsdf;        ///< [material_count]
    const rsv_lights *lights;
    bool emission; ///< sources are shown, too
} rsv_device_light;

/// A frame of one eye.
typedef struct rsv_device_eye {
    rsv_lens lens;
    float place_x, place_y; ///< of the sample within each pixel
    float spread;
    rsv_medium medium; ///< the camera's
    rsv_frame_tone tone;
    uint32_t samples; ///< before this one
} rsv_device_eye;

typedef struct rsv_device_frames rsv_device_frames;

/// Failures set `message` [RSV_DEVICE_MESSAGE_BYTES] and leave results undefined.
typedef struct rsv_device_frames_table {
    rsv_status (*create)(rsv_device *device, const rsv_device_stage *stage,
        rsv_device_frames **frames, char *message);
    void (*destroy)(rsv_device_frames *frames);
    /// Called before the first frame, and when the light has changed.
    rsv_status (*set_light)(
        rsv_device_frames *frames, const rsv_device_light *light, char *message);
    /// Adds one sample to each pixel and shows the sums. @param eye [eyes] @param path_rays out
    rsv_status (*render)(
        rsv_device_frames *frames, const rsv_device_eye *eye, uint64_t *path_rays, char *message);
    /// Codes of one eye's picture, and its sums. @param pixel, sum [height * width]
    rsv_status (*pixels)(
        rsv_device_frames *frames, uint32_t eye, uint8_t (*pixel)[4], char *message);
    rsv_status (*sums)(rsv_device_frames *frames, uint32_t eye, float (*sum)[4], char *message);
} rsv_device_frames_table;

#endif
