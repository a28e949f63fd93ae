/// Daylight coefficients: the contribution of each patch of the sky to each sensor.
///
/// A sensor's reading is linear in the sky. Its own rays find light that arrives straight, or through mirrors and
/// refracting panes. For light from surfaces, the adjoint z = (I - (G K)*)^-1 w of the weights w of its rays gives the
/// effect of light at each element, and rays from the elements find how much light of each patch arrives there.
///
/// All of this uses RSV_DAYLIGHT_GROUPS independent randomisations, whose spread is the standard error.
#ifndef RSV_DAYLIGHT_H
#define RSV_DAYLIGHT_H

#include "../core/vec.h"
#include "../solve/light.h"
#include "resolvent/daylight.h"

#define RSV_DAYLIGHT_GROUPS 15
/// Of a patch: the groups, and the mean of the part that surfaces reflect.
#define RSV_DAYLIGHT_COLUMNS (RSV_DAYLIGHT_GROUPS + 1)

/// Lux by cd/m2, of one patch.
typedef struct rsv_patch_share {
    float column[RSV_DAYLIGHT_COLUMNS];
} __attribute__((aligned(64))) rsv_patch_share;

struct rsv_daylight {
    rsv_context *context;
    const rsv_light_view *light;
    rsv_daylight_desc desc;
    rsv_sky_patches patches;
    double north[2]; ///< cosine and sine of desc.north
    size_t sensor_count;
    rsv_probe *sensor;     ///< [sensor_count]
    rsv_patch_share *all;  ///< [sensor_count][patches.count]
    rsv_patch_share *bent; ///< the same, without light that arrives straight (also through panes)
    double *stored_error; ///< [sensor_count] of the reflected part, relative, that all groups share
    uint8_t *buried;      ///< [sensor_count]
};

/// Between the frame of the sky (-z north) and the scene's.
static inline rsv_vec3 rsv_daylight_to_sky(const rsv_daylight *d, rsv_vec3 v)
{
    float c = (float)d->north[0], s = (float)d->north[1];
    return v3(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
}

static inline rsv_vec3 rsv_daylight_to_scene(const rsv_daylight *d, rsv_vec3 v)
{
    float c = (float)d->north[0], s = (float)d->north[1];
    return v3(c * v.x - s * v.z, v.y, c * v.z + s * v.x);
}

/// Light that left the scene straight, nothing but clear panes in its way.
static inline bool rsv_daylight_is_straight(rsv_vec3 start, rsv_vec3 end)
{
    return v3_dot(start, end) > 1 - 2e-6f;
}

#endif
