/// Every reader of files behind one function, for fuzzing and for replaying inputs that fuzzing found.
#ifndef RSV_FUZZ_READERS_H
#define RSV_FUZZ_READERS_H

#include <stddef.h>
#include <stdint.h>

/// Reads a file of these bytes with the reader of the extension: .glb .gltf .obj .ply .stl .dae .fbx .exr .hdr .png
/// .jpg .safetensors (checksum corrected first, so that the code behind it is reached), .csv of points, .txt of light
/// scripts, .epw and .wea of weather, .ies and .ldt of luminaires, and .history .scene .rows that a solve left for the
/// next one (kept_files.h). Refusing the file is fine; crashing, hanging or leaking is not.
void fuzz_read(const char *extension, const uint8_t *data, size_t size);

#endif
