/// Textures of materials that Assimp read.
#ifndef RSV_ASSIMP_TEXTURE_H
#define RSV_ASSIMP_TEXTURE_H

#include "assimp_file.h"
#include "scene_parts.h"

#define RSV_ASSIMP_MOST_TEXTURES 8 ///< of a material: as many as there are roles here, or more

/// Those that were sent so far: each once, however many materials use it.
typedef struct rsv_assimp_textures {
    rsv_context *context;
    const struct aiScene *file;
    rsv_assimp_maker maker;
    FILE *to;
    rsv_part_texture *sent; ///< [count], their names owned
    size_t count, capacity;
} rsv_assimp_textures;

/// Sends those textures of a material that have not been sent yet, and enters their numbers in the material. Where the
/// format lets a texture replace a colour, that colour becomes white. A warning names what is not used.
/// @param ref storage for material->textures
rsv_status rsv_assimp_take_textures(rsv_assimp_textures *textures, const struct aiMaterial *source,
    rsv_texture_ref ref[RSV_ASSIMP_MOST_TEXTURES], rsv_material *material);
void rsv_assimp_textures_release(rsv_assimp_textures *textures);

/// One set of texture coordinates, v running down. @return NULL = there is none, or no memory
float (*rsv_assimp_coordinates(rsv_context *context, const struct aiMesh *mesh, unsigned set))[2];

#endif
