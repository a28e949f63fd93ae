/// Which unit a glTF file means by the strengths of its lights.
///
/// KHR_lights_punctual specifies candela and lux; this library uses W/sr and W/m2. Blender is one of the few programs
/// that write candela, and it offers three ways to write a lamp of W watts: W 683 / (4 pi) candela (the default since
/// 3.4), W / (4 pi), and W itself (the only way before 3.4). The file does not say which was used. But watts are
/// numbers that somebody typed: the way that leads back to numbers with few digits is the right one.
#ifndef RSV_LIGHT_UNITS_H
#define RSV_LIGHT_UNITS_H

#include "gltf_document.h"
#include "resolvent/io.h"

#define RSV_LUMENS_PER_WATT 683.0 ///< at 555 nm, by definition

/// Factors for the strengths in a file.
typedef struct rsv_light_scale {
    double local;     ///< for point and spot lights, to W/sr
    double distant;   ///< for directional lights, to W/m2
    double emission;  ///< for emissive materials, to W/(m2 sr)
    const char *said; ///< why, in a line; NULL = nothing to tell
} rsv_light_scale;

rsv_light_scale rsv_gltf_light_scale(const rsv_gltf_document *document, rsv_light_units wanted);

/// The version that Blender gives itself in a text such as "Khronos glTF Blender I/O v3.4.50", times 1000: 3004. 0 = it
/// says none, -1 = the text does not speak of Blender.
int rsv_blender_version(const char *generator);

#endif
