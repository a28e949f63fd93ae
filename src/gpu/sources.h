/// The sources of a scene on the device.
#ifndef RSV_GPU_SOURCES_H
#define RSV_GPU_SOURCES_H

#include "../sources/lights.h"
#include "scene.h"

/// All with addresses on the device.
typedef struct rsv_gpu_sources {
    const rsv_lights *host; ///< borrowed until it is uploaded
    bool seen;              ///< includes the whole sky and its gathered part, for viewing
    rsv_lights lights;
    rsv_light_tree emitter_tree, punctual_tree;
    rsv_environment_light environment;
    rsv_lights *there; ///< the first of these, on the device
} rsv_gpu_sources;

/// Part of a task's layout, after the scene, whose lights it adds.
void rsv_gpu_sources_place(rsv_gpu_sources *sources, rsv_gpu_scene *scene, rsv_gpu_block *block);
void rsv_gpu_sources_upload(
    const rsv_gpu_sources *sources, const rsv_gpu_scene *scene, rsv_gpu *gpu);

#endif
