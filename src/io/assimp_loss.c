#include "assimp_loss.h"

#include "assimp_light.h"

#include <assimp/material.h>
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOST_NAMES 12 ///< that a warning lists

static void strip_mesh(struct aiMesh *mesh, rsv_assimp_losses *losses)
{
    losses->skinned += mesh->mNumBones > 0;
    losses->morphed += mesh->mNumAnimMeshes > 0;
    losses->colored += mesh->mColors[0] != NULL;
    for (unsigned i = 0; i < mesh->mNumFaces && mesh->mFaces; i++) {
        losses->lines += mesh->mFaces[i].mNumIndices == 1 || mesh->mFaces[i].mNumIndices == 2;
        losses->broken += mesh->mFaces[i].mNumIndices == 0;
    }
    // the arrays stay allocated until this process ends
    mesh->mNumBones = 0;
    mesh->mNumAnimMeshes = 0;
}

void rsv_assimp_strip(struct aiScene *file, rsv_assimp_losses *losses)
{
    *losses = (rsv_assimp_losses){ .animations = file->mNumAnimations };
    for (unsigned i = 0; i < file->mNumMeshes; i++)
        strip_mesh(file->mMeshes[i], losses);
    file->mNumAnimations = 0;
}

// ---- materials --------------------------------------------------------------------------------------

/// Properties that assimp_material.c reads, that textures bring along, that say the same as another, or nothing about
/// how a surface looks.
static bool is_known(const char *key)
{
    static const char *const known[] = { "?mat.name", "$mat.shadingm", "$mat.twosided",
        "$mat.illum", "$clr.diffuse", "$clr.specular", "$clr.emissive", "$clr.transparent",
        "$clr.ambient", "$clr.base", "$mat.opacity", "$mat.transparencyfactor", "$mat.shininess",
        "$mat.shinpercent", "$mat.refracti", "$mat.metallicFactor", "$mat.roughnessFactor",
        "$mat.sheen.roughnessFactor", "$clr.sheen.factor", "$mat.clearcoat.factor",
        "$mat.clearcoat.roughnessFactor", "$mat.transmission.factor", "$mat.emissiveIntensity",
        "$mat.wireframe", "$mat.blend", "$mat.gltf.pbrMetallicRoughness" };
    static const char *const prefixes[] = { "$tex.", "$raw.", "?bg.", "?sh." };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (strcmp(key, known[k]) == 0) return true;
    for (size_t k = 0; k < sizeof prefixes / sizeof *prefixes; k++)
        if (strncmp(key, prefixes[k], strlen(prefixes[k])) == 0) return true;
    return false;
}

/// Whether a property changes nothing: zero, or a scale of 1.
static bool is_idle(const struct aiMaterialProperty *property)
{
    bool is_scale = strstr(property->mKey.data, "scal") || strstr(property->mKey.data, "mult");
    if (!property->mData) return true;
    if (property->mType == aiPTI_Float) {
        for (size_t i = 0; i + sizeof(float) <= property->mDataLength; i += sizeof(float)) {
            float value;
            memcpy(&value, property->mData + i, sizeof value);
            if (value != 0 && !(is_scale && value == 1)) return false;
        }
        return true;
    }
    for (size_t i = 0; i < property->mDataLength; i++)
        if (property->mData[i]) return false;
    return true;
}

typedef struct name_list {
    char text[400];
    const char *seen[64];
    size_t count;
} name_list;

static void add_name(name_list *list, const char *name)
{
    size_t used = strlen(list->text);
    for (size_t k = 0; k < list->count; k++)
        if (strcmp(list->seen[k], name) == 0) return;
    if (list->count == sizeof list->seen / sizeof *list->seen) return;
    list->seen[list->count++] = name;
    if (list->count > MOST_NAMES) return;
    // "$mat.anisotropyFactor": users know the part after the point
    const char *point = strchr(name, '.');
    snprintf(list->text + used, sizeof list->text - used, "%s%.40s", used ? ", " : "",
        *name == '$' && point ? point + 1 : name);
    for (char *c = list->text; *c; c++)
        if (iscntrl((unsigned char)*c)) *c = '?';
}

static void warn_of_properties(
    const rsv_context *context, const char *path, const struct aiScene *file)
{
    name_list list = { .count = 0 };
    const bool by_blender = rsv_assimp_by_blender(file);
    for (unsigned i = 0; i < file->mNumMaterials; i++) {
        const struct aiMaterial *material = file->mMaterials[i];
        for (unsigned k = 0; k < material->mNumProperties; k++) {
            const struct aiMaterialProperty *property = material->mProperties[k];
            // in files by Blender, reflection comes from metals (assimp_material.c)
            bool metal = by_blender && strstr(property->mKey.data, ".reflectiv");
            if (is_known(property->mKey.data) || is_idle(property) || metal) continue;
            add_name(&list, property->mKey.data);
        }
    }
    if (list.count)
        rsv_log(context, RSV_LOG_WARNING, "%s: properties of its materials that are not used: %s%s",
            path, list.text, list.count > MOST_NAMES ? ", ..." : "");
}

// ---- the rest ---------------------------------------------------------------------------------------

static void add_part(char *text, size_t size, size_t count, const char *what)
{
    size_t used = strlen(text);
    if (count) snprintf(text + used, size - used, "%s%zu %s", used ? ", " : "", count, what);
}

void rsv_assimp_warn_of_losses(const rsv_context *context, const char *path,
    const struct aiScene *file, const rsv_assimp_losses *losses)
{
    char text[512] = "";
    add_part(text, sizeof text, losses->skinned,
        losses->skinned == 1 ? "mesh with bones (shown as it is stored)"
                             : "meshes with bones (shown as they are stored)");
    add_part(text, sizeof text, losses->morphed,
        losses->morphed == 1 ? "mesh with morph targets (shown without)"
                             : "meshes with morph targets (shown without)");
    add_part(text, sizeof text, losses->colored,
        losses->colored == 1 ? "mesh with colours of its vertices"
                             : "meshes with colours of their vertices");
    add_part(text, sizeof text, losses->animations,
        losses->animations == 1 ? "animation" : "animations");
    add_part(text, sizeof text, losses->lines,
        losses->lines == 1 ? "line or point" : "lines and points");
    add_part(text, sizeof text, losses->broken,
        losses->broken == 1 ? "face without corners" : "faces without corners");
    if (*text) rsv_log(context, RSV_LOG_WARNING, "%s: not used: %s", path, text);
    warn_of_properties(context, path, file);
}
