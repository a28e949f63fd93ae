/// What the numbers mean that a glTF file gives as strengths of its lights.
///
/// KHR_lights_punctual speaks of candela and lux; this library of W/sr and W/m2. Few programs but Blender mean the former, and
/// that offers three ways to write a lamp of W watts: W 683 / (4 pi) candela (its default since 3.4), W / (4 pi), and W itself
/// (all that versions before 3.4 did). The file does not say which, but watts are numbers that somebody typed: the way that
/// leads back to ones of few digits is the one that was taken.
#ifndef RSV_LIGHT_UNITS_H
#define RSV_LIGHT_UNITS_H

#include "gltf_document.h"
#include "resolvent/io.h"

#define RSV_LUMENS_PER_WATT 683.0 ///< at 555 nm, by definition

/// What strengths are to be multiplied by.
typedef struct rsv_light_scale {
    double local;     ///< of lights with a place, to W/sr
    double distant;   ///< of directional ones, to W/m2
    double emission;  ///< of materials, to W/(m2 sr)
    const char *said; ///< why, in a line; NULL = nothing to tell
} rsv_light_scale;

rsv_light_scale rsv_gltf_light_scale(const rsv_gltf_document *document, rsv_light_units wanted);

/// The version that Blender gives itself in a text such as "Khronos glTF Blender I/O v3.4.50", times 1000: 3004. 0 = it says
/// none, -1 = the text does not speak of Blender.
int rsv_blender_version(const char *generator);

#endif
