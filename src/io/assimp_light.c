/// Neither format specifies the unit of a light's strength. Programs write a strength and a fall-off in the file's unit
/// of length: the irradiance is strength / (attenuation x distance^2), so the intensity in W/sr is strength /
/// attenuation x (metres per unit)^2. Blender writes its watts, next to other numbers that have no meaning.
#include "assimp_light.h"

#include "../core/vec.h"
#include "../scene/punctual.h"
#include "fbx_scan.h"
#include "file_source.h"
#include "light_units.h"

#include <stdio.h>
#include <string.h>

#include <assimp/commonMetaData.h>

#define PI 3.14159265358979323846
#define FIRST_WITH_WATTS 2080  ///< version of Blender, as rsv_blender_version has it
#define USUAL_FOV 0.785398163f ///< of a camera that does not say its own, radians

// ---- what the file says as a whole ------------------------------------------------------------------

/// The program that wrote the file; "" = it does not say.
static const char *generator_of(const struct aiScene *file)
{
    const struct aiMetadata *metadata = file->mMetaData;
    for (unsigned i = 0; metadata && i < metadata->mNumProperties; i++) {
        const struct aiMetadataEntry *entry = &metadata->mValues[i];
        if (entry->mType == AI_AISTRING && entry->mData &&
            strcmp(metadata->mKeys[i].data, AI_METADATA_SOURCE_GENERATOR) == 0)
            return ((const struct aiString *)entry->mData)->data;
    }
    return "";
}

bool rsv_assimp_by_blender(const struct aiScene *file)
{
    int version = rsv_blender_version(generator_of(file));
    return version == 0 || version >= FIRST_WITH_WATTS;
}

static rsv_status warn_of_shifted_films(
    rsv_context *context, const rsv_file_source *files, const char *path)
{
    char *bytes = NULL;
    size_t size = 0;
    rsv_status status = rsv_file_read(context, files, path, &bytes, &size);
    if (status == RSV_OK && rsv_fbx_shifts_film(bytes, size))
        rsv_log(context, RSV_LOG_WARNING,
            "%s: the shift of a camera's film is left out; --shift-x and --shift-y of 'render' "
            "bring it back",
            path);
    rsv_free(context, bytes);
    return status;
}

rsv_status rsv_assimp_learn(rsv_context *context, const rsv_assimp_reading *reading,
    const struct aiScene *file, rsv_assimp_facts *facts)
{
    const rsv_file_kind kind = reading->kind;
    const char *path = reading->path;
    *facts = (rsv_assimp_facts){ .kind = kind,
        .metres_per_unit = reading->metres_per_unit,
        .watts = rsv_assimp_by_blender(file),
        .photometric = reading->light_units == RSV_LIGHT_UNITS_PHOTOMETRIC };
    bool needed = file->mNumLights + file->mNumCameras > 0;
    if (file->mNumLights && facts->watts && reading->light_units == RSV_LIGHT_UNITS_AUTO)
        rsv_log(context, RSV_LOG_INFO, "lights are in watts, as Blender exports them");
    if (kind == RSV_FILE_COLLADA)
        return rsv_collada_scan(context, reading->files, path, &facts->collada);
    if (!needed || kind != RSV_FILE_FBX) return RSV_OK;
    facts->has_decay = file->mNumLights && rsv_file_mentions(reading->files, path, "DecayType");
    facts->has_fov = file->mNumCameras && rsv_file_mentions(reading->files, path, "FieldOfView");
    return file->mNumCameras ? warn_of_shifted_films(context, reading->files, path) : RSV_OK;
}

void rsv_assimp_forget(rsv_context *context, rsv_assimp_facts *facts)
{
    rsv_collada_release(context, &facts->collada);
}

/// A value of the text that the light or camera stands in; NAN = it says none.
static double said(const rsv_collada_object *object, rsv_collada_value value)
{
    return object ? object->value[value] : NAN;
}

static rsv_vec3 transform(const double m[16], struct aiVector3D v, double w)
{
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = m[i] * v.x + m[4 + i] * v.y + m[8 + i] * v.z + m[12 + i] * w;
    return v3((float)r[0], (float)r[1], (float)r[2]);
}

// ---- lights -----------------------------------------------------------------------------------------

static void warn_of_decay(const rsv_context *context, const char *name)
{
    rsv_log(context, RSV_LOG_WARNING,
        "light '%s': falls off with the square of the distance; the attenuation in the file is ignored",
        name);
}

/// Factor for the colour of a point or spot light, to W/sr.
static double intensity_factor(
    const rsv_context *context, const rsv_assimp_facts *facts, const struct aiLight *source)
{
    const double square = facts->metres_per_unit * facts->metres_per_unit;
    double quadratic = (double)source->mAttenuationQuadratic;
    if (facts->watts) return 1 / (4 * PI);
    bool falls_off = quadratic > 0 && (facts->kind != RSV_FILE_FBX || facts->has_decay);
    if (!falls_off || source->mAttenuationLinear > 0 ||
        (double)source->mAttenuationConstant * square > 1.001 * quadratic)
        warn_of_decay(context, source->mName.data);
    if (!falls_off) return 1; // as if meant for a distance of a metre
    // a decay that starts at no distance, as Maya writes it
    return isfinite(quadratic) ? square / quadratic : square;
}

/// Half the angles of a spot light. Of COLLADA's falloff Assimp makes a guess; it is a power of the cosine.
static void take_cone(const rsv_assimp_facts *facts, const struct aiLight *source, size_t order,
    rsv_punctual_light *light)
{
    double outer = (double)source->mAngleOuterCone / 2, inner = (double)source->mAngleInnerCone / 2;
    if (facts->kind == RSV_FILE_COLLADA) {
        const rsv_collada_object *text =
            rsv_collada_find(&facts->collada, RSV_COLLADA_LIGHT, source->mName.data, order);
        double exponent = said(text, RSV_COLLADA_FALLOFF_EXPONENT);
        if (text && isnan(said(text, RSV_COLLADA_OUTER_CONE)) &&
            isnan(said(text, RSV_COLLADA_PENUMBRA))) {
            outer = inner;
            if (exponent > 0) light->exponent = (float)exponent;
        }
    }
    light->outer_cone_angle = f_min(f_max((float)outer, 0), RSV_PI / 2);
    light->inner_cone_angle = f_min(f_max((float)inner, 0), light->outer_cone_angle);
}

/// How each of Assimp's kinds of light is converted; ambient light is not.
typedef struct light_kind {
    enum aiLightSourceType source;
    rsv_punctual_light_kind kind;
    bool is_surface; ///< of no known size, seen from afar: shines with the cosine of Lambert's law
} light_kind;

static const light_kind light_kinds[] = {
    { aiLightSource_POINT, RSV_PUNCTUAL_POINT, false },
    { aiLightSource_SPOT, RSV_PUNCTUAL_SPOT, false },
    { aiLightSource_DIRECTIONAL, RSV_PUNCTUAL_DIRECTIONAL, false },
    { aiLightSource_AREA, RSV_PUNCTUAL_SPOT, true },
};

/// @return NULL = there is none
static const light_kind *kind_of(const rsv_assimp_facts *facts, const struct aiLight *source)
{
    enum aiLightSourceType type = source->mType;
    if (facts->kind == RSV_FILE_FBX && type == aiLightSource_UNDEFINED) type = aiLightSource_AREA;
    for (size_t k = 0; k < sizeof light_kinds / sizeof *light_kinds; k++)
        if (light_kinds[k].source == type) return &light_kinds[k];
    return NULL;
}

static void become_surface(const rsv_context *context, rsv_punctual_light *light)
{
    light->inner_cone_angle = light->outer_cone_angle = RSV_PI / 2;
    light->exponent = 1;
    rsv_log(context, RSV_LOG_WARNING,
        "light '%s': an area or volume light whose size is not in the file; it becomes a point light with the "
        "cosine falloff of a surface",
        light->name);
}

static bool leave_out(const rsv_context *context, const char *name, const char *why)
{
    rsv_log(context, RSV_LOG_WARNING, "light '%s': %s", name, why);
    return false;
}

bool rsv_assimp_light(const rsv_context *context, const rsv_assimp_facts *facts,
    const struct aiLight *source, size_t order, const double world[16], rsv_punctual_light *light)
{
    const char *name = light->name;
    const light_kind *kind = kind_of(facts, source);
    const struct aiColor3D color = source->mColorDiffuse;
    if (!kind)
        return leave_out(context, name,
            "ambient light is left out; an environment (--env white) gives light from everywhere");
    if (color.r < 0 || color.g < 0 || color.b < 0)
        return leave_out(context, name, "negative light is left out");
    *light = (rsv_punctual_light){ .name = name,
        .kind = kind->kind,
        .position = transform(world, source->mPosition, 1),
        .direction = transform(world, source->mDirection, 0) };
    double factor = rsv_punctual_is_distant(light) ? 1 : intensity_factor(context, facts, source);
    if (kind->is_surface) {
        // a surface sends 1 / pi of its flux along its normal, a point 1 / (4 pi)
        if (facts->watts) factor *= 4;
        become_surface(context, light);
    } else if (rsv_punctual_has_cone(light)) {
        take_cone(facts, source, order, light);
    }
    if (facts->photometric) factor /= RSV_LUMENS_PER_WATT;
    light->intensity = rgb((float)((double)color.r * factor), (float)((double)color.g * factor),
        (float)((double)color.b * factor));
    return true;
}

// ---- cameras ----------------------------------------------------------------------------------------

/// The projection of a COLLADA camera: any one or two of xfov, yfov and aspect, or of their like.
/// @return false if it says none
static bool take_projection(const rsv_collada_object *text, double metres, rsv_camera *camera)
{
    const bool is_flat =
        !isnan(said(text, RSV_COLLADA_XMAG)) || !isnan(said(text, RSV_COLLADA_YMAG));
    double width = said(text, is_flat ? RSV_COLLADA_XMAG : RSV_COLLADA_XFOV);
    double height = said(text, is_flat ? RSV_COLLADA_YMAG : RSV_COLLADA_YFOV);
    double aspect = said(text, RSV_COLLADA_ASPECT);
    if (!is_flat) { // half the extent at a distance of 1
        width = tan(width * PI / 360);
        height = tan(height * PI / 360);
    }
    if (!(width > 0) && !(height > 0)) return false;
    if (!(aspect > 0)) aspect = width > 0 && height > 0 ? width / height : 1;
    if (!(height > 0)) height = width / aspect;
    camera->aspect = (float)aspect;
    camera->vertical_fov = is_flat ? 0 : (float)(2 * atan(height));
    camera->vertical_extent = is_flat ? (float)(height * metres) : 0;
    return true;
}

/// The projection of any other camera.
static void take_fov(const rsv_context *context, const rsv_assimp_facts *facts,
    const struct aiCamera *source, rsv_camera *camera)
{
    bool is_given =
        facts->kind != RSV_FILE_FBX || facts->has_fov; // else the importer makes up a degree
    float aspect = source->mAspect > 0 && isfinite(source->mAspect) ? source->mAspect : 1;
    float whole =
        source
            ->mHorizontalFOV; // the header calls it half an angle, every importer stores the whole
    camera->aspect = aspect;
    if (is_given && whole > 0 && whole < RSV_PI) {
        camera->vertical_fov = 2 * atanf(tanf(whole / 2) / aspect);
    } else if (source->mOrthographicWidth > 0) {
        camera->vertical_extent = source->mOrthographicWidth / aspect;
    } else {
        camera->vertical_fov = USUAL_FOV;
        rsv_log(context, RSV_LOG_WARNING,
            "camera '%s': its field of view is not usable; 45 degrees is used", camera->name);
    }
}

/// Cameras have no shifted films here, pictures have.
static void warn_of_shift(
    const rsv_context *context, const rsv_collada_object *text, const rsv_camera *camera)
{
    double x = said(text, RSV_COLLADA_SHIFT_X), y = said(text, RSV_COLLADA_SHIFT_Y);
    double aspect = camera->aspect > 0 ? (double)camera->aspect : 1;
    x = isfinite(x) ? x : 0;
    y = isfinite(y) ? y : 0;
    if (x == 0 && y == 0) return;
    rsv_log(context, RSV_LOG_WARNING,
        "camera '%s': the shift of its film is left out; --shift-x %.4g --shift-y %.4g of 'render' "
        "bring it back",
        camera->name, aspect < 1 ? x / aspect : x, aspect < 1 ? y : y * aspect);
}

rsv_status rsv_assimp_camera(const rsv_context *context, const rsv_assimp_facts *facts,
    const struct aiCamera *source, size_t order, const double world[16], rsv_camera *camera)
{
    const char *name = camera->name;
    *camera = (rsv_camera){ .name = name,
        .position = transform(world, source->mPosition, 1),
        .forward = v3_normalize(transform(world, source->mLookAt, 0)) };
    rsv_vec3 up = transform(world, source->mUp, 0);
    camera->right = v3_normalize(v3_cross(camera->forward, up));
    camera->up = v3_cross(camera->right, camera->forward);
    if (!(v3_length(camera->right) > 0))
        return rsv_fail(RSV_ERROR_FORMAT, "camera '%s': it has no direction", name);
    if (facts->kind != RSV_FILE_COLLADA) {
        take_fov(context, facts, source, camera);
        return RSV_OK;
    }
    const rsv_collada_object *text =
        rsv_collada_find(&facts->collada, RSV_COLLADA_CAMERA, source->mName.data, order);
    if (text && take_projection(text, facts->metres_per_unit, camera)) {
        warn_of_shift(context, text, camera);
        return RSV_OK;
    }
    if (!text) { // named in a way of its own by the importer
        take_fov(context, facts, source, camera);
        return RSV_OK;
    }
    camera->aspect = said(text, RSV_COLLADA_ASPECT) > 0 ? (float)said(text, RSV_COLLADA_ASPECT) : 1;
    camera->vertical_fov = USUAL_FOV;
    rsv_log(context, RSV_LOG_WARNING,
        "camera '%s': its field of view is not in the file; 45 degrees is used", name);
    return RSV_OK;
}
