/// Phong materials of the older formats, and metallic-roughness ones, as rsv_material.
///
/// Phong models state a highlight, not a reflectance, and no two programs agree on its meaning. Here, a surface with a
/// specular colour is a dielectric whose highlight is scaled by that colour. If the file asks for ray-traced reflection
/// (`illum` 3 and above in .mtl), the colour is that of a mirror instead. Opacity is coverage, except with ray-traced
/// refraction, which is glass.
#include "assimp_file.h"

#include "../core/vec.h"
#include "assimp_light.h"
#include "file_source.h"
#include "light_units.h"
#include "phong.h"

#include <assimp/material.h>
#include <string.h>

#define KEY_ILLUM "$mat.illum", 0, 0 ///< given by newer versions alone

// Blender's exporters of .obj, in C++ since 3.1 and in Python before, and of .fbx
#define SHININESS_OF_OBJ 1000
#define SHININESS_OF_OLD_OBJ 900
#define SHININESS_OF_FBX 100

/// The terms of a Phong material.
typedef struct phong {
    rsv_rgb diffuse, specular, filter;
    float shininess, opacity, ior;
    bool traced; ///< reflection or refraction should be ray-traced
} phong;

static float read_float(
    const struct aiMaterial *source, const char *key, unsigned type, unsigned index, float fallback)
{
    float value;
    unsigned count = 1;
    bool found =
        aiGetMaterialFloatArray(source, key, type, index, &value, &count) == aiReturn_SUCCESS &&
        count == 1;
    return found && isfinite(value) ? value : fallback;
}

static bool has_float(
    const struct aiMaterial *source, const char *key, unsigned type, unsigned index)
{
    return isfinite(read_float(source, key, type, index, INFINITY));
}

static rsv_rgb read_color(const struct aiMaterial *source, const char *key, unsigned type,
    unsigned index, rsv_rgb fallback)
{
    struct aiColor4D c;
    if (aiGetMaterialColor(source, key, type, index, &c) != aiReturn_SUCCESS) return fallback;
    bool usable = isfinite(c.r) && isfinite(c.g) && isfinite(c.b);
    return usable ? rgb(f_max(c.r, 0), f_max(c.g, 0), f_max(c.b, 0)) : fallback;
}

static int read_int(
    const struct aiMaterial *source, const char *key, unsigned type, unsigned index, int fallback)
{
    int value;
    unsigned count = 1;
    bool found =
        aiGetMaterialIntegerArray(source, key, type, index, &value, &count) == aiReturn_SUCCESS &&
        count == 1;
    return found ? value : fallback;
}

static bool is_traced(const struct aiMaterial *source, rsv_file_kind kind, rsv_rgb specular)
{
    if (kind != RSV_FILE_OBJ) return false;
    int illum = read_int(source, KEY_ILLUM, -1);
    if (illum >= 0) return illum >= 3;
    // the importer for .mtl knows illum 0 to 2 and calls all others Gouraud
    int shading = read_int(source, AI_MATKEY_SHADING_MODEL, aiShadingMode_Phong);
    return shading == aiShadingMode_Gouraud && !rgb_is_black(specular);
}

static phong read_phong(const struct aiMaterial *source, rsv_file_kind kind)
{
    phong p = { .diffuse = read_color(source, AI_MATKEY_COLOR_DIFFUSE, rgb_gray(0.8f)),
        .specular = read_color(source, AI_MATKEY_COLOR_SPECULAR, rgb_gray(0)),
        .filter = read_color(source, AI_MATKEY_COLOR_TRANSPARENT, rgb_gray(1)),
        .shininess = f_max(read_float(source, AI_MATKEY_SHININESS, 0), 0),
        .opacity = read_float(source, AI_MATKEY_OPACITY, 1),
        .ior = read_float(source, AI_MATKEY_REFRACTI, 1) };
    float strength = read_float(source, AI_MATKEY_SHININESS_STRENGTH, 1);
    p.specular = rgb_scale(p.specular, f_max(strength, 0));
    // COLLADA's <lambert> and <constant> have no highlight, whatever the importer makes up for them
    int shading = read_int(source, AI_MATKEY_SHADING_MODEL, aiShadingMode_Phong);
    if (kind == RSV_FILE_COLLADA && shading == aiShadingMode_NoShading) p.diffuse = rgb_gray(0);
    if (kind == RSV_FILE_COLLADA &&
        (shading == aiShadingMode_NoShading || shading == aiShadingMode_Gouraud))
        p.specular = rgb_gray(0);
    p.traced = is_traced(source, kind, p.specular);
    return p;
}

/// `color` divided by its largest channel; white if it is black.
static rsv_rgb hue_of(rsv_rgb color)
{
    float largest = rgb_max(color);
    return largest > 0 ? rgb_scale(color, 1 / largest) : rgb_gray(1);
}

static void become_glass(const phong *p, rsv_material *material)
{
    material->transmission = 1;
    material->thickness = 1;
    material->roughness = 0;
    material->ior = p->ior;
    // programs disagree on whether the filter transmits or absorbs this colour; only its hue is safe
    material->base_color = hue_of(p->filter);
}

/// Turns a share of the surface into ideal metal: the specular colour's share of the total reflectance.
static void become_mirror(const phong *p, rsv_material *material)
{
    float mirror = rgb_max(p->specular), rest = rgb_max(p->diffuse);
    material->metallic = mirror / f_max(mirror + rest, 1);
    material->roughness = 0;
    if (mirror < rest) return;
    material->metallic = 1;
    material->base_color = p->specular;
}

static void become_plastic(const phong *p, rsv_material *material)
{
    material->specular = f_min(rgb_max(p->specular), 1);
    material->specular_color = hue_of(p->specular);
    material->roughness = rsv_roughness_of_shininess(p->shininess);
    material->ior = p->ior > 1 ? p->ior : 1.5f;
}

static void take_phong(const struct aiMaterial *source, rsv_file_kind kind, rsv_material *material)
{
    phong p = read_phong(source, kind);
    bool filters = p.filter.r != 1 || p.filter.g != 1 || p.filter.b != 1;
    material->base_color = p.diffuse;
    material->specular = 0;
    material->opacity = p.opacity;
    if (p.traced && p.ior > 1 && (filters || p.opacity < 1)) {
        material->opacity = 1;
        become_glass(&p, material);
    } else if (p.traced) {
        become_mirror(&p, material);
    } else if (!rgb_is_black(p.specular)) {
        become_plastic(&p, material);
    }
}

static void take_metallic_roughness(const struct aiMaterial *source, rsv_material *material)
{
    rsv_rgb diffuse = read_color(source, AI_MATKEY_COLOR_DIFFUSE, rgb_gray(0.8f));
    material->base_color = read_color(source, AI_MATKEY_BASE_COLOR, diffuse);
    material->metallic = read_float(source, AI_MATKEY_METALLIC_FACTOR, 0);
    material->roughness = read_float(source, AI_MATKEY_ROUGHNESS_FACTOR, 1);
    material->opacity = read_float(source, AI_MATKEY_OPACITY, 1);
    material->transmission = read_float(source, AI_MATKEY_TRANSMISSION_FACTOR, 0);
    material->ior = read_float(source, AI_MATKEY_REFRACTI, 1.5f);
    if (material->transmission > 0) material->thickness = 1;
    material->clearcoat = read_float(source, AI_MATKEY_CLEARCOAT_FACTOR, 0);
    material->clearcoat_roughness = read_float(source, AI_MATKEY_CLEARCOAT_ROUGHNESS_FACTOR, 0);
    material->sheen_color = read_color(source, AI_MATKEY_SHEEN_COLOR_FACTOR, rgb_gray(0));
    material->sheen_roughness = read_float(source, AI_MATKEY_SHEEN_ROUGHNESS_FACTOR, 0);
}

// ---- Blender ----------------------------------------------------------------------------------------

/// By the first line; "v" stands before the version in files of the exporter in Python.
static float shininess_of_obj(const rsv_file_source *files, const char *path)
{
    char line[128] = "";
    FILE *file = rsv_file_open(files, path);
    if (!file) return 0;
    if (!fgets(line, sizeof line, file)) line[0] = '\0';
    fclose(file);
    if (strncmp(line, "# Blender ", 10) != 0) return 0;
    return line[10] == 'v' ? SHININESS_OF_OLD_OBJ : SHININESS_OF_OBJ;
}

rsv_assimp_maker rsv_assimp_maker_of(
    const rsv_file_source *files, const char *path, rsv_file_kind kind, const struct aiScene *file)
{
    rsv_assimp_maker maker = { .kind = kind };
    if (kind == RSV_FILE_OBJ) maker.blender_shininess = shininess_of_obj(files, path);
    bool by_blender = kind != RSV_FILE_OBJ && rsv_assimp_by_blender(file);
    if (kind == RSV_FILE_FBX && by_blender) maker.blender_shininess = SHININESS_OF_FBX;
    maker.blender_collada = kind == RSV_FILE_COLLADA && by_blender;
    return maker;
}

/// How much of Blender's `metallic` a file says. In .mtl it is the ambient colour of surfaces that reflect.
static float blender_metallic(const struct aiMaterial *source, rsv_file_kind kind)
{
    if (kind != RSV_FILE_OBJ) return read_float(source, AI_MATKEY_REFLECTIVITY, 0);
    int illum = read_int(source, KEY_ILLUM, -1);
    bool reflects = illum == 3 || illum == 6;
    float ambient = rgb_max(read_color(source, AI_MATKEY_COLOR_AMBIENT, rgb_gray(1)));
    return reflects ? ambient : 0;
}

/// The exporters write the sockets of a Principled BSDF in Phong's terms. 8 % of `specular` is the reflectance of its
/// dielectric.
static void take_blender(
    const struct aiMaterial *source, const rsv_assimp_maker *maker, rsv_material *material)
{
    bool is_obj = maker->kind == RSV_FILE_OBJ;
    float shininess = read_float(source, AI_MATKEY_SHININESS, 0) / maker->blender_shininess;
    float specular = is_obj ? rgb_max(read_color(source, AI_MATKEY_COLOR_SPECULAR, rgb_gray(0.5f)))
                            : 2 * read_float(source, AI_MATKEY_SHININESS_STRENGTH, 0.25f);
    float root = sqrtf(0.08f * f_min(f_max(specular, 0), 1));
    material->base_color = read_color(source, AI_MATKEY_COLOR_DIFFUSE, rgb_gray(0.8f));
    material->roughness = 1 - sqrtf(f_min(f_max(shininess, 0), 1));
    material->metallic = f_min(f_max(blender_metallic(source, maker->kind), 0), 1);
    material->specular = root > 0 ? 1 : 0;
    if (root > 0) material->ior = (1 + root) / (1 - root);
    material->opacity = read_float(source, AI_MATKEY_OPACITY, 1);
}

/// Blender's COLLADA has <lambert> for all materials, without their roughness.
static void take_blender_collada(
    const rsv_context *context, const struct aiMaterial *source, rsv_material *material)
{
    float metallic = f_min(f_max(read_float(source, AI_MATKEY_REFLECTIVITY, 0), 0), 1);
    take_phong(source, RSV_FILE_COLLADA, material);
    if (metallic == 0) return;
    material->metallic = metallic;
    material->roughness = 0.5f;
    rsv_log(context, RSV_LOG_WARNING,
        "material '%s': the file does not give the roughness of the metal; 0.5 is used",
        material->name);
}

/// Whether a file states metal and roughness as such. The importer of .fbx makes a roughness of every shininess.
static bool is_metallic_roughness(const struct aiMaterial *source, rsv_file_kind kind)
{
    bool made = kind == RSV_FILE_FBX && has_float(source, AI_MATKEY_SHININESS);
    return has_float(source, AI_MATKEY_METALLIC_FACTOR) ||
           (has_float(source, AI_MATKEY_ROUGHNESS_FACTOR) && !made);
}

static void warn_of_losses(const rsv_context *context, const rsv_material *material)
{
    if (material->metallic > 0 && material->metallic < 1)
        rsv_log(context, RSV_LOG_WARNING,
            "material '%s': its mirror reflection gets the diffuse colour", material->name);
}

void rsv_assimp_material(const rsv_context *context, const rsv_assimp_maker *maker,
    const struct aiMaterial *source, char *name, rsv_material *material)
{
    struct aiString given = { .length = 0 };
    *material = rsv_default_material();
    if (aiGetMaterialString(source, AI_MATKEY_NAME, &given) != aiReturn_SUCCESS) given.length = 0;
    rsv_assimp_name(&given, "unnamed", name);
    material->name = name;
    if (is_metallic_roughness(source, maker->kind))
        take_metallic_roughness(source, material);
    else if (maker->blender_shininess > 0)
        take_blender(source, maker, material);
    else if (maker->blender_collada)
        take_blender_collada(context, source, material);
    else
        take_phong(source, maker->kind, material);
    rsv_rgb emission = read_color(source, AI_MATKEY_COLOR_EMISSIVE, rgb_gray(0));
    material->emission = rgb_scale(emission, read_float(source, AI_MATKEY_EMISSIVE_INTENSITY, 1));
    if (!(maker->blender_shininess > 0) && !maker->blender_collada)
        warn_of_losses(context, material);
}
