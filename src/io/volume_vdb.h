/// Grids of OpenVDB files.
#ifndef RSV_VOLUME_VDB_H
#define RSV_VOLUME_VDB_H

#include "resolvent/scene.h"

#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What precedes the densities, [side[2]][side[1]][side[0]] floats.
typedef struct rsv_vdb_header {
    uint32_t side[3];
    float low[3], high[3]; ///< first and last point, metres
} rsv_vdb_header;

/// Writes header and densities of the file's grid "density", or its first one of single numbers. In a child process alone:
/// OpenVDB trusts files. Messages continue a sentence that begins with the file.
/// Hidden, as all of the library's own, though its file is compiled with default visibility.
__attribute__((visibility("hidden"))) rsv_status rsv_vdb_convert(const char *path, FILE *answer);

#ifdef __cplusplus
}
#endif

#endif
