#include "assimp_texture.h"

#include "../core/vec.h"

#include <assimp/ObjMaterial.h>
#include <assimp/material.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Which materials a slot is for.
enum { OF_ANY, OF_PHONG = 1, OF_BLENDER = 2, OF_METALLIC = 4 };

/// How a kind of texture is used.
typedef struct slot {
    enum aiTextureType type;
    rsv_texture_role role;
    bool srgb;
    rsv_texture_use use;
    unsigned of; ///< OF_ANY, or which
} slot;

/// The first that a material has counts for its role and use. Blender writes roughness and metal where Phong has
/// others.
static const slot slots[] = {
    { aiTextureType_BASE_COLOR, RSV_TEXTURE_BASE_COLOR, true, RSV_TEXTURE_AS_IT_IS, OF_ANY },
    { aiTextureType_DIFFUSE, RSV_TEXTURE_BASE_COLOR, true, RSV_TEXTURE_AS_IT_IS, OF_ANY },
    { aiTextureType_OPACITY, RSV_TEXTURE_OPACITY, true, RSV_TEXTURE_GREY_IS_ALPHA, OF_ANY },
    { aiTextureType_NORMALS, RSV_TEXTURE_NORMAL, false, RSV_TEXTURE_AS_IT_IS, OF_ANY },
    { aiTextureType_NORMAL_CAMERA, RSV_TEXTURE_NORMAL, false, RSV_TEXTURE_AS_IT_IS, OF_ANY },
    { aiTextureType_HEIGHT, RSV_TEXTURE_NORMAL, false, RSV_TEXTURE_ARE_NORMALS, OF_ANY },
    { aiTextureType_EMISSION_COLOR, RSV_TEXTURE_EMISSION, true, RSV_TEXTURE_AS_IT_IS, OF_ANY },
    { aiTextureType_EMISSIVE, RSV_TEXTURE_EMISSION, true, RSV_TEXTURE_AS_IT_IS, OF_ANY },
    { aiTextureType_DIFFUSE_ROUGHNESS, RSV_TEXTURE_METALLIC_ROUGHNESS, false,
        RSV_TEXTURE_GREY_IS_GREEN, OF_ANY },
    { aiTextureType_SHININESS, RSV_TEXTURE_METALLIC_ROUGHNESS, false, RSV_TEXTURE_GREY_IS_GREEN,
        OF_PHONG | OF_BLENDER },
    { aiTextureType_METALNESS, RSV_TEXTURE_METALLIC_ROUGHNESS, false, RSV_TEXTURE_GREY_IS_BLUE,
        OF_METALLIC | OF_BLENDER },
    { aiTextureType_SPECULAR, RSV_TEXTURE_SPECULAR_COLOR, true, RSV_TEXTURE_AS_IT_IS,
        OF_PHONG | OF_BLENDER },
};

/// The state of a material while its textures are looked for.
typedef struct painted {
    const rsv_assimp_maker *maker;
    const struct aiMaterial *source;
    const char *name;
    bool is_phong; ///< by .mtl, of which the exponent is known
    bool is_metallic;
    bool is_packed; ///< roughness and metal are channels of one picture, as in glTF
} painted;

static bool has_number(const struct aiMaterial *source, const char *key)
{
    const struct aiMaterialProperty *property;
    return aiGetMaterialProperty(source, key, 0, 0, &property) == aiReturn_SUCCESS;
}

static bool has_same_picture(
    const struct aiMaterial *source, enum aiTextureType a, enum aiTextureType b)
{
    struct aiString path[2];
    return aiGetMaterialString(source, AI_MATKEY_TEXTURE(a, 0), &path[0]) == aiReturn_SUCCESS &&
           aiGetMaterialString(source, AI_MATKEY_TEXTURE(b, 0), &path[1]) == aiReturn_SUCCESS &&
           strcmp(path[0].data, path[1].data) == 0;
}

static painted describe_material(
    const rsv_assimp_maker *maker, const struct aiMaterial *source, const char *name)
{
    bool is_obj = maker->kind == RSV_FILE_OBJ, by_blender = maker->blender_shininess > 0;
    bool stated = has_number(source, "$mat.metallicFactor") ||
                  (is_obj && has_number(source, "$mat.roughnessFactor"));
    bool mapped = aiGetMaterialTextureCount(source, aiTextureType_DIFFUSE_ROUGHNESS) > 0;
    return (painted){ .maker = maker,
        .source = source,
        .name = name,
        .is_phong = is_obj && !stated && !by_blender,
        .is_metallic = stated || mapped || is_obj,
        .is_packed =
            has_same_picture(source, aiTextureType_DIFFUSE_ROUGHNESS, aiTextureType_METALNESS) };
}

static bool is_meant(const painted *p, const slot *s)
{
    bool by_blender = p->maker->blender_shininess > 0;
    return s->of == OF_ANY || (s->of & OF_PHONG && p->is_phong) ||
           (s->of & OF_METALLIC && p->is_metallic) || (s->of & OF_BLENDER && by_blender);
}

// ---- textures that are used -------------------------------------------------------------------------

static rsv_wrap wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Mirror                                    ? RSV_WRAP_MIRROR
           : mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? RSV_WRAP_CLAMP
                                                                              : RSV_WRAP_REPEAT;
}

static bool is_same(const rsv_part_texture *a, const rsv_part_texture *b)
{
    return a->srgb == b->srgb && a->shines == b->shines && a->use == b->use &&
           a->shininess == b->shininess && a->wrap_u == b->wrap_u && a->wrap_v == b->wrap_v &&
           strcmp(a->name, b->name) == 0;
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

/// Of a texture that says how shiny a Phong material is.
static float shininess_of(const painted *p, const slot *s)
{
    float value = 0;
    unsigned one = 1;
    if (s->type != aiTextureType_SHININESS || !p->is_phong) return 0;
    if (aiGetMaterialFloatArray(p->source, AI_MATKEY_SHININESS, &value, &one) != aiReturn_SUCCESS)
        return 0;
    return value > 0 && isfinite(value) ? value : 0;
}

/// How strongly .mtl wants bumps; others do not say it, or not in numbers that the importer hands on.
static float bump_scale(const painted *p, const slot *s)
{
    float value = 1;
    unsigned one = 1;
    if (s->type != aiTextureType_HEIGHT || p->maker->kind != RSV_FILE_OBJ) return 1;
    if (aiGetMaterialFloatArray(p->source, AI_MATKEY_OBJ_BUMPMULT_HEIGHT(0), &value, &one) !=
            aiReturn_SUCCESS ||
        !isfinite(value) || value == 0)
        return 1;
    return value;
}

/// @return false = the material has none of that kind that can be used
static bool describe(const rsv_assimp_textures *t, const painted *p, const slot *s,
    char name[RSV_PART_PATH_BYTES], rsv_part_texture *texture, rsv_texture_ref *ref)
{
    struct aiString path = { .length = 0 };
    enum aiTextureMapping mapping = aiTextureMapping_UV;
    enum aiTextureMapMode mode[2] = { aiTextureMapMode_Wrap, aiTextureMapMode_Wrap };
    unsigned set = 0;
    if (aiGetMaterialTexture(p->source, s->type, 0, &path, &mapping, &set, NULL, NULL, mode,
            NULL) != aiReturn_SUCCESS ||
        path.length == 0)
        return false;
    snprintf(name, RSV_PART_PATH_BYTES, "%s", path.data);
    if (mapping != aiTextureMapping_UV || set > 1) {
        rsv_log(t->context, RSV_LOG_WARNING,
            "texture '%.200s': it uses texture coordinates other than the first two sets, and is ignored",
            name);
        return false;
    }
    bool packed = p->is_packed && s->role == RSV_TEXTURE_METALLIC_ROUGHNESS;
    *texture = (rsv_part_texture){ .name = name,
        .srgb = s->srgb,
        .shines = s->role == RSV_TEXTURE_EMISSION,
        .use = packed ? RSV_TEXTURE_AS_IT_IS : s->use,
        .shininess = shininess_of(p, s),
        .wrap_u = wrap_of(mode[0]),
        .wrap_v = wrap_of(mode[1]) };
    *ref = rsv_default_texture_ref(s->role, 0);
    ref->uv_set = set;
    ref->scale = bump_scale(p, s);
    set_transform(p->source, s, ref);
    return true;
}

/// Whether an earlier slot already provides the same property.
static bool is_told(const bool *taken, size_t index, bool packed)
{
    const slot *s = &slots[index];
    for (size_t k = 0; k < index; k++)
        if (taken[k] && slots[k].role == s->role &&
            (s->role != RSV_TEXTURE_METALLIC_ROUGHNESS || packed || slots[k].use == s->use))
            return true;
    return false;
}

/// In .mtl a texture multiplies the colour beside it; an emission of zero is then meant to show the texture alone. In
/// other formats, and in all files by Blender, the texture replaces the colour.
static void make_white(
    const rsv_assimp_maker *maker, const slot *s, const rsv_part_texture *texture, rsv_material *m)
{
    bool multiplies = maker->kind == RSV_FILE_OBJ;
    bool replaces = !multiplies || maker->blender_shininess > 0;
    bool is_metal = s->role == RSV_TEXTURE_METALLIC_ROUGHNESS;
    if (s->role == RSV_TEXTURE_BASE_COLOR && !multiplies) m->base_color = rgb_gray(1);
    if (s->role == RSV_TEXTURE_SPECULAR_COLOR && !multiplies) m->specular_color = rgb_gray(1);
    if (is_metal && (replaces || texture->shininess > 0)) {
        if (s->use == RSV_TEXTURE_GREY_IS_GREEN) m->roughness = 1;
        if (s->use == RSV_TEXTURE_GREY_IS_BLUE) m->metallic = 1;
        if (texture->use == RSV_TEXTURE_AS_IT_IS) m->roughness = m->metallic = 1;
    }
}

/// `strength` is FBX's factor for an emission texture.
static void make_shine(rsv_file_kind kind, float strength, rsv_material *m)
{
    if (kind != RSV_FILE_OBJ || rgb_is_black(m->emission)) m->emission = rgb_gray(strength);
}

// ---- textures that are not used ---------------------------------------------------------------------

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

static bool is_used(const painted *p, int type)
{
    for (size_t k = 0; k < sizeof slots / sizeof *slots; k++)
        if ((int)slots[k].type == type && is_meant(p, &slots[k])) return true;
    return false;
}

static void warn_of_unused(const rsv_context *context, const painted *p)
{
    char list[256] = "";
    for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; type++) {
        if (is_used(p, type) || !aiGetMaterialTextureCount(p->source, (enum aiTextureType)type))
            continue;
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", name_of_type(type));
    }
    if (*list)
        rsv_log(context, RSV_LOG_WARNING, "material '%s': textures that are not used: %s", p->name,
            list);
}

static float emission_strength(const struct aiMaterial *source)
{
    float strength = 1;
    unsigned one = 1;
    bool known = aiGetMaterialFloatArray(source, AI_MATKEY_EMISSIVE_INTENSITY, &strength, &one) ==
                 aiReturn_SUCCESS;
    return known && strength > 0 ? strength : 1;
}

rsv_status rsv_assimp_take_textures(rsv_assimp_textures *t, const struct aiMaterial *source,
    rsv_texture_ref ref[RSV_ASSIMP_MOST_TEXTURES], rsv_material *material)
{
    rsv_status status = RSV_OK;
    bool taken[sizeof slots / sizeof *slots] = { false };
    const painted p = describe_material(&t->maker, source, material->name);
    material->textures = ref;
    for (size_t k = 0; k < sizeof slots / sizeof *slots; k++) {
        char name[RSV_PART_PATH_BYTES];
        rsv_part_texture texture;
        rsv_texture_ref *use = &ref[material->texture_count];
        if (!is_meant(&p, &slots[k]) || is_told(taken, k, p.is_packed)) continue;
        if (material->texture_count == RSV_ASSIMP_MOST_TEXTURES) continue;
        if (!describe(t, &p, &slots[k], name, &texture, use)) continue;
        RSV_TRY(send_texture(t, texture, &use->texture));
        material->texture_count++;
        taken[k] = true;
        make_white(&t->maker, &slots[k], &texture, material);
        if (slots[k].role == RSV_TEXTURE_EMISSION)
            make_shine(t->maker.kind, emission_strength(source), material);
    }
    warn_of_unused(t->context, &p);
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
