/// An animation of a glTF file: its keys, and the values it gives to what it moves at a given time.
#ifndef RSV_GLTF_CLIP_H
#define RSV_GLTF_CLIP_H

#include "gltf_accessor.h"

/// Keys as the file has them; values NULL = not read yet.
typedef struct rsv_gltf_keys {
    rsv_gltf_numbers time, number;
} rsv_gltf_keys;

typedef struct rsv_gltf_track {
    uint32_t node;
    rsv_gltf_path path;
    rsv_gltf_interpolation interpolation;
    const float *time; ///< [key_count] s, never falling
    const float *
        value; ///< [key_count][width]; a cubic spline's [key_count][3][width]: tangent in, value, tangent out
    size_t key_count, width;
} rsv_gltf_track;

typedef struct rsv_gltf_clip {
    rsv_context *context;
    const char *name;
    rsv_gltf_keys *keys;   ///< [sampler_count] that tracks refer to
    rsv_gltf_track *track; ///< [count]
    size_t count, sampler_count;
    double start, end; ///< s, of all keys; both 0 without any
} rsv_gltf_clip;

/// Reads an animation. Refuses keys that are out of order or do not fit; warns of channels that move nothing here.
rsv_status rsv_gltf_clip_create(
    rsv_context *context, const rsv_gltf_document *document, size_t index, rsv_gltf_clip *clip);
void rsv_gltf_clip_destroy(rsv_gltf_clip *clip);

/// Before the first key its value, after the last one that. @param value out: [width]; rotations are not of length 1
void rsv_gltf_track_at(const rsv_gltf_track *track, double time, double *value);

#endif
