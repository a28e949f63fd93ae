/// Clear coats whose normals are not those of what they cover: by a map of their own, or without the one below. For device
/// code too.
#ifndef RSV_COAT_NORMAL_H
#define RSV_COAT_NORMAL_H

#include "../core/vec.h"
#include "resolvent/scene.h"

/// @return NULL = the material has none
RSV_INLINE const rsv_texture_ref *rsv_find_texture(const rsv_material *m, rsv_texture_role role)
{
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->textures[i].role == role) return &m->textures[i];
    return NULL;
}

RSV_INLINE bool rsv_same_map(const rsv_texture_ref *a, const rsv_texture_ref *b)
{
    bool same = a->texture == b->texture && a->uv_set == b->uv_set && a->scale == b->scale;
    for (int k = 0; k < 6; k++)
        same = same && a->transform[k / 3][k % 3] == b->transform[k / 3][k % 3];
    return same;
}

RSV_INLINE bool rsv_coat_has_own_normals(const rsv_material *m)
{
    if (!(m->clearcoat > 0)) return false;
    const rsv_texture_ref *below = rsv_find_texture(m, RSV_TEXTURE_NORMAL);
    const rsv_texture_ref *coat = rsv_find_texture(m, RSV_TEXTURE_CLEARCOAT_NORMAL);
    if (!below || !coat) return below || coat;
    return !rsv_same_map(below, coat);
}

#endif
