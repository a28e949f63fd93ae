/// Grids of OpenVDB files: what the library and its plug-in for them have in common.
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

/// OpenVDB and what it needs take 30 MB and more: they are in a plug-in, which is loaded when there is a file to read.
#define RSV_VDB_PLUG_IN "libresolvent_vdb.so"
#define RSV_VDB_CONVERT "rsv_vdb_convert"
#define RSV_VDB_MESSAGE_BYTES 400

/// Writes header and densities of the file's grid "density", or its first one of single numbers. In a child process alone:
/// OpenVDB trusts files. @param message out: continues a sentence that begins with the file
typedef rsv_status (*rsv_vdb_converter)(
    const char *path, FILE *answer, char message[RSV_VDB_MESSAGE_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
