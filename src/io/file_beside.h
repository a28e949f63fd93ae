/// Files that a scene names by a path of the computer it was made on.
#ifndef RSV_FILE_BESIDE_H
#define RSV_FILE_BESIDE_H

#include "resolvent/io.h"

/// Looks for the file that the scene at `scene` calls `name`: as it stands (from the scene's folder, if it is relative), with the slashes of
/// Windows turned, and by its last part alone in the scene's folder and the ones that textures are usually put in.
/// @param path out [size] @return whether there is a regular file
bool rsv_find_beside(
    const rsv_file_source *files, const char *scene, const char *name, char *path, size_t size);

#endif
