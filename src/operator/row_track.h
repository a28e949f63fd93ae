/// Additional data of each ray of a row, so that rays affected by a moving object can be traced again individually: how
/// far they got, which entries are theirs, and the corners of specular paths.
#ifndef RSV_ROW_TRACK_H
#define RSV_ROW_TRACK_H

#include "../core/core.h"
#include "../core/vec.h"
#include "../specular/specular_walk.h"

/// A lattice of 2^16 points a side over the scene, on which corners of specular paths are kept.
typedef struct rsv_trail_frame {
    rsv_vec3 low, high; ///< metres
} rsv_trail_frame;

/// A corner of a ray's specular path. Those of one ray follow each other, from the surface that it met first.
typedef struct rsv_trail_point {
    uint16_t ray;
    uint16_t at[3]; ///< on the lattice
} rsv_trail_point;

typedef struct rsv_row_track {
    rsv_trail_frame frame;
    uint16_t *reach;      ///< [rays] metres to the first hit, from rsv_reach_of
    uint16_t *tinted_ray; ///< [rays] of each tinted entry
    uint16_t *bin_ray, *tinted_bin_ray; ///< [rays] of each escape
    uint16_t *light_ray;                ///< [rays] of each emission
    rsv_rgb *light;                     ///< [rays] their light, as the row counts it
    uint32_t light_count;
    rsv_rgb *color;         ///< [rays] of the lights, each once; scratch memory for storing the row
    uint16_t *light_color;  ///< [rays] index of each light's
    rsv_trail_point *trail; ///< [trail_count] in the order of rays and of their paths
    size_t trail_count, trail_capacity;
    rsv_context *context;
    bool failed; ///< no memory for trails
} rsv_row_track;

rsv_status rsv_row_track_create(rsv_context *context, uint32_t rays, rsv_row_track **track);
void rsv_row_track_destroy(rsv_row_track *track); ///< NULL is allowed

/// Forgets the row before.
void rsv_row_track_clear(rsv_row_track *track);

/// Notes where a segment of a ray's specular path ends: at a surface, or where it leaves the frame.
void rsv_row_track_visit(rsv_row_track *track, uint32_t ray, const rsv_scene_view *scene,
    const rsv_specular_path *path, bool left_scene, rsv_vec3 from);

/// Upper half of a float, rounded up: a distance in sixteen bits, to 0.8 %.
RSV_INLINE uint16_t rsv_reach_of(float metres)
{
    union {
        float value;
        uint32_t bits;
    } f = { .value = metres > 0 ? metres : 0 };
    return (uint16_t)((f.bits + 0xffffu) >> 16);
}

RSV_INLINE float rsv_reach_metres(uint16_t reach)
{
    union {
        uint32_t bits;
        float value;
    } f = { .bits = (uint32_t)reach << 16 };
    return f.value;
}

/// A place on the lattice, in metres.
RSV_INLINE rsv_vec3 rsv_trail_place(const rsv_trail_frame *f, const uint16_t at[3])
{
    const float part = 1.0f / 65535;
    return v3(f->low.x + (f->high.x - f->low.x) * (float)at[0] * part,
        f->low.y + (f->high.y - f->low.y) * (float)at[1] * part,
        f->low.z + (f->high.z - f->low.z) * (float)at[2] * part);
}

#endif
