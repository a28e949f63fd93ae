/// Files that a scene names by a path of the computer it was made on.
#ifndef RSV_FILE_BESIDE_H
#define RSV_FILE_BESIDE_H

#include "resolvent/io.h"

/// Looks for the file that the scene at `scene` calls `name`. Tried are the name itself (relative to the scene's
/// folder), the name with backslashes turned into slashes, and its last part alone, in the scene's folder and in
/// folders where textures are commonly kept. @param path out [size] @return whether there is such a regular file
bool rsv_find_beside(
    const rsv_file_source *files, const char *scene, const char *name, char *path, size_t size);

#endif
