/// What an FBX file says that Assimp's structures do not hold.
#ifndef RSV_FBX_SCAN_H
#define RSV_FBX_SCAN_H

#include <stddef.h>

/// How many models have the property `Visibility` at 0, in a text or a binary file. 0 where the file cannot be read.
size_t rsv_fbx_count_invisible(const char *path);

#endif
