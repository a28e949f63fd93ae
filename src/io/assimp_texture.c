#include "assimp_texture.h"

#include "../core/vec.h"

#include <assimp/material.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/// What a kind of texture becomes.
typedef struct slot {
    enum aiTextureType type;
    rsv_texture_role role;
    bool srgb, grey_is_alpha;
} slot;

/// The first that a material has counts for its role.
static const slot slots[] = {
    { aiTextureType_BASE_COLOR, RSV_TEXTURE_BASE_COLOR, true, false },
    { aiTextureType_DIFFUSE, RSV_TEXTURE_BASE_COLOR, true, false },
    { aiTextureType_OPACITY, RSV_TEXTURE_OPACITY, true, true },
    { aiTextureType_NORMALS, RSV_TEXTURE_NORMAL, false, false },
    { aiTextureType_NORMAL_CAMERA, RSV_TEXTURE_NORMAL, false, false },
    { aiTextureType_EMISSION_COLOR, RSV_TEXTURE_EMISSION, true, false },
    { aiTextureType_EMISSIVE, RSV_TEXTURE_EMISSION, true, false },
};

// ---- what is sent -----------------------------------------------------------------------------------

static rsv_wrap wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Mirror                                    ? RSV_WRAP_MIRROR
           : mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? RSV_WRAP_CLAMP
                                                                              : RSV_WRAP_REPEAT;
}

static bool is_same(const rsv_part_texture *a, const rsv_part_texture *b)
{
    return a->srgb == b->srgb && a->shines == b->shines && a->grey_is_alpha == b->grey_is_alpha &&
           a->wrap_u == b->wrap_u && a->wrap_v == b->wrap_v && strcmp(a->name, b->name) == 0;
}

/// Bytes of a texture within the file: "*3", or under the name of a file. Those that are not packed have none.
static void find_embedded(const struct aiScene *file, rsv_part_texture *texture)
{
    for (unsigned k = 0; k < file->mNumTextures; k++) {
        const struct aiTexture *embedded = file->mTextures[k];
        bool is_named =
            embedded->mFilename.length && strcmp(embedded->mFilename.data, texture->name) == 0;
        bool is_numbered = texture->name[0] == '*' && atoi(texture->name + 1) == (int)k;
        if ((!is_named && !is_numbered) || embedded->mHeight != 0) continue;
        texture->bytes = (const uint8_t *)embedded->pcData;
        texture->size = embedded->mWidth;
        return;
    }
}

/// @param number out: of those sent
static rsv_status send_texture(rsv_assimp_textures *t, rsv_part_texture wanted, uint32_t *number)
{
    rsv_status status;
    for (size_t k = 0; k < t->count; k++)
        if (is_same(&t->sent[k], &wanted)) {
            *number = (uint32_t)k;
            return RSV_OK;
        }
    RSV_TRY(rsv_grow(t->context, (void **)&t->sent, &t->capacity, t->count + 1, sizeof *t->sent));
    find_embedded(t->file, &wanted);
    rsv_send_texture(t->to, &wanted);
    char *name = strdup(wanted.name);
    if (!name) RSV_TRY(RSV_ERROR_MEMORY);
    wanted.name = name;
    wanted.bytes = NULL;
    *number = (uint32_t)t->count;
    t->sent[t->count++] = wanted;
cleanup:
    return status;
}

void rsv_assimp_textures_release(rsv_assimp_textures *t)
{
    for (size_t k = 0; k < t->count; k++)
        free((char *)(uintptr_t)t->sent[k].name);
    rsv_free(t->context, t->sent);
}

// ---- how it is laid on ------------------------------------------------------------------------------

/// Scale and offset; v runs up there and down here. Turns are about the middle.
static void set_transform(const struct aiMaterial *source, const slot *s, rsv_texture_ref *ref)
{
    struct aiUVTransform t;
    if (aiGetMaterialUVTransform(source, AI_MATKEY_UVTRANSFORM(s->type, 0), &t) != aiReturn_SUCCESS)
        return;
    float c = cosf(t.mRotation), i = sinf(t.mRotation);
    float a[2][2] = { { c * t.mScaling.x, -i * t.mScaling.y },
        { i * t.mScaling.x, c * t.mScaling.y } };
    // the middle turns in place
    float offset[2] = { t.mTranslation.x + 0.5f * (1 - c + i),
        t.mTranslation.y + 0.5f * (1 - c - i) };
    const float m[2][3] = { { a[0][0], -a[0][1], a[0][1] + offset[0] },
        { -a[1][0], a[1][1], 1 - a[1][1] - offset[1] } };
    for (int k = 0; k < 6; k++)
        if (!isfinite(m[k / 3][k % 3])) return;
    memcpy(ref->transform, m, sizeof m);
}

/// @return false = the material has none of that kind that can be used
static bool describe(const rsv_assimp_textures *t, const struct aiMaterial *source, const slot *s,
    char name[RSV_PART_PATH_BYTES], rsv_part_texture *texture, rsv_texture_ref *ref)
{
    struct aiString path = { .length = 0 };
    enum aiTextureMapping mapping = aiTextureMapping_UV;
    enum aiTextureMapMode mode[2] = { aiTextureMapMode_Wrap, aiTextureMapMode_Wrap };
    unsigned set = 0;
    if (aiGetMaterialTexture(source, s->type, 0, &path, &mapping, &set, NULL, NULL, mode, NULL) !=
            aiReturn_SUCCESS ||
        path.length == 0)
        return false;
    snprintf(name, RSV_PART_PATH_BYTES, "%s", path.data);
    if (mapping != aiTextureMapping_UV || set > 1) {
        rsv_log(t->context, RSV_LOG_WARNING,
            "texture '%.200s': it uses texture coordinates other than the first two sets, and is ignored",
            name);
        return false;
    }
    *texture = (rsv_part_texture){ .name = name,
        .srgb = s->srgb,
        .shines = s->role == RSV_TEXTURE_EMISSION,
        .grey_is_alpha = s->grey_is_alpha,
        .wrap_u = wrap_of(mode[0]),
        .wrap_v = wrap_of(mode[1]) };
    *ref = rsv_default_texture_ref(s->role, 0);
    ref->uv_set = set;
    set_transform(source, s, ref);
    return true;
}

static bool has_role(const rsv_material *material, rsv_texture_role role)
{
    for (size_t k = 0; k < material->texture_count; k++)
        if (material->textures[k].role == role) return true;
    return false;
}

/// In FBX and COLLADA a texture stands in place of a colour; in .mtl it multiplies it, and emission of none is meant to show it.
static void make_white(rsv_file_kind kind, rsv_texture_role role, float strength, rsv_material *m)
{
    if (role == RSV_TEXTURE_BASE_COLOR && kind != RSV_FILE_OBJ) m->base_color = rgb_gray(1);
    if (role != RSV_TEXTURE_EMISSION) return;
    if (kind != RSV_FILE_OBJ || rgb_is_black(m->emission)) m->emission = rgb_gray(strength);
}

// ---- what is not used -------------------------------------------------------------------------------

static const char *name_of_type(int type)
{
    static const char *const names[] = { [aiTextureType_SPECULAR] = "specular",
        [aiTextureType_AMBIENT] = "ambient",
        [aiTextureType_HEIGHT] = "bump",
        [aiTextureType_SHININESS] = "shininess",
        [aiTextureType_DISPLACEMENT] = "displacement",
        [aiTextureType_LIGHTMAP] = "lightmap",
        [aiTextureType_REFLECTION] = "reflection",
        [aiTextureType_METALNESS] = "metalness",
        [aiTextureType_DIFFUSE_ROUGHNESS] = "roughness",
        [aiTextureType_AMBIENT_OCCLUSION] = "occlusion" };
    bool known = (size_t)type < sizeof names / sizeof *names && names[type];
    return known ? names[type] : "other";
}

static bool is_slot(int type)
{
    for (size_t k = 0; k < sizeof slots / sizeof *slots; k++)
        if ((int)slots[k].type == type) return true;
    return false;
}

static void warn_of_unused(
    const rsv_context *context, const struct aiMaterial *source, const char *material)
{
    char list[256] = "";
    for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; type++) {
        if (is_slot(type) || !aiGetMaterialTextureCount(source, (enum aiTextureType)type)) continue;
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", name_of_type(type));
    }
    if (*list)
        rsv_log(context, RSV_LOG_WARNING, "material '%s': textures that are not used: %s", material,
            list);
}

rsv_status rsv_assimp_take_textures(rsv_assimp_textures *t, const struct aiMaterial *source,
    rsv_texture_ref ref[RSV_ASSIMP_MOST_TEXTURES], rsv_material *material)
{
    rsv_status status = RSV_OK;
    float strength = 1;
    unsigned one = 1;
    if (aiGetMaterialFloatArray(source, AI_MATKEY_EMISSIVE_INTENSITY, &strength, &one) !=
            aiReturn_SUCCESS ||
        !(strength > 0))
        strength = 1;
    material->textures = ref;
    for (size_t k = 0; k < sizeof slots / sizeof *slots; k++) {
        char name[RSV_PART_PATH_BYTES];
        rsv_part_texture texture;
        rsv_texture_ref *use = &ref[material->texture_count];
        if (has_role(material, slots[k].role)) continue;
        if (!describe(t, source, &slots[k], name, &texture, use)) continue;
        RSV_TRY(send_texture(t, texture, &use->texture));
        material->texture_count++;
        make_white(t->kind, slots[k].role, strength, material);
    }
    warn_of_unused(t->context, source, material->name);
cleanup:
    return status;
}

float (*rsv_assimp_coordinates(rsv_context *context, const struct aiMesh *mesh, unsigned set))[2]
{
    if (!mesh->mTextureCoords[set]) return NULL;
    float(*uv)[2] = rsv_alloc(context, mesh->mNumVertices, sizeof *uv);
    for (unsigned k = 0; uv && k < mesh->mNumVertices; k++) {
        const struct aiVector3D *from = &mesh->mTextureCoords[set][k];
        uv[k][0] = isfinite(from->x) ? from->x : 0;
        uv[k][1] = isfinite(from->y) ? 1 - from->y : 0;
    }
    return uv;
}
