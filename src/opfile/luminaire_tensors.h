/// Measured luminaires of a scene in an operator file.
#ifndef RSV_LUMINAIRE_TENSORS_H
#define RSV_LUMINAIRE_TENSORS_H

#include "resolvent/scene.h"
#include "tensor_file.h"

rsv_status rsv_write_luminaires(rsv_tensor_file *file, const rsv_scene_view *view);

/// @param light [lights] whose luminaires are filled in
/// @param luminaire out: [count]; free each with rsv_luminaire_free and the array with rsv_free, even after an error
rsv_status rsv_read_luminaires(rsv_tensor_file *file, rsv_punctual_light *light, size_t lights,
    rsv_luminaire **luminaire, size_t *count);

#endif
