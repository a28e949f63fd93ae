/// Present or requested settings of all sources and colours of a scene.
#ifndef RSV_LIGHT_SETTINGS_H
#define RSV_LIGHT_SETTINGS_H

#include "../solve/light_basis.h"
#include "resolvent/relight.h"

typedef struct rsv_light_settings {
    rsv_rgb *scale;      ///< [source_count] factors of the strength that a source has by itself
    rsv_vec3 *offset;    ///< [source_count] metres from where it began
    rsv_vec3 *aim;       ///< [source_count] unit; 0 = the direction that it began with
    rsv_rgb *base_color; ///< [material_count]
    float rotation;      ///< of the surroundings, degrees
} rsv_light_settings;

/// @param settings free it with rsv_light_settings_free, even after an error
rsv_status rsv_light_settings_allocate(
    rsv_context *context, size_t sources, size_t materials, rsv_light_settings *settings);
void rsv_light_settings_free(rsv_context *context, rsv_light_settings *settings);

/// Everything that settings are read against.
typedef struct rsv_light_settings_home {
    const rsv_scene *scene;
    const rsv_lights *lights; ///< as they began
    const rsv_source *source; ///< [source_count]
    size_t source_count;
    const rsv_light_settings *settings; ///< as they began
} rsv_light_settings_home;

/// Settings from a description; everything else has its original value. Errors as in rsv_light_relight.
rsv_status rsv_light_settings_read(
    const rsv_light_settings_home *home, const rsv_relight_desc *desc, rsv_light_settings *wanted);

/// A lamp that fills more than this fraction of the view of surfaces cannot be moved: what its body hides is part of
/// the operator.
#define RSV_MOVABLE_SHARE 0.015

/// The factor of all lamps that gather rays find: their light is stored as one sum.
rsv_status rsv_gathered_scale(
    const rsv_light_settings_home *home, const rsv_light_settings *settings, rsv_rgb *scale);

#endif
