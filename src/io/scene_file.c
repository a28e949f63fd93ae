/// Which reader a file goes to.
#include "../core/descriptor.h"
#include "../scene/scene.h"
#include "file_source.h"
#include "scene_read.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

void rsv_load_desc_init(rsv_load_desc *desc, size_t size)
{
    const rsv_load_desc defaults = { .size = sizeof defaults,
        .metres_per_unit = 1,
        .up = RSV_AXIS_Y,
        .crease_angle = 0.785398163f,
        .keep_document = true };
    rsv_desc_fill(desc, size, &defaults);
}

static rsv_file_kind kind_of_extension(const char *path)
{
    static const struct {
        const char *extension;
        rsv_file_kind kind;
    } known[] = { { ".gltf", RSV_FILE_GLTF }, { ".glb", RSV_FILE_GLTF }, { ".obj", RSV_FILE_OBJ },
        { ".ply", RSV_FILE_PLY }, { ".fbx", RSV_FILE_FBX }, { ".dae", RSV_FILE_COLLADA },
        { ".stl", RSV_FILE_STL } };
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof known / sizeof *known; i++)
        if (strcasecmp(dot, known[i].extension) == 0) return known[i].kind;
    return RSV_FILE_UNKNOWN;
}

/// By the first bytes, for files of another name.
static rsv_file_kind kind_of_content(FILE *file)
{
    static const struct {
        const char *start;
        rsv_file_kind kind;
    } known[] = { { "glTF", RSV_FILE_GLTF }, { "{", RSV_FILE_GLTF }, { "ply\n", RSV_FILE_PLY },
        { "ply\r", RSV_FILE_PLY }, { "Kaydara FBX Binary", RSV_FILE_FBX },
        { "solid ", RSV_FILE_STL } };
    char start[32] = "";
    size_t length = fread(start, 1, sizeof start - 1, file);
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        size_t needed = strlen(known[i].start);
        if (length >= needed && strncasecmp(start, known[i].start, needed) == 0)
            return known[i].kind;
    }
    return RSV_FILE_UNKNOWN;
}

rsv_status rsv_find_file_kind(const rsv_file_source *source, const char *path, rsv_file_kind *kind)
{
    FILE *file = rsv_file_open(source, path);
    if (!file && (errno == EISDIR || errno == ENOTSUP))
        return rsv_fail(RSV_ERROR_IO, "is a folder, pipe or device, not a regular file");
    if (!file) return rsv_fail(RSV_ERROR_IO, "cannot be opened: %s", strerror(errno));
    *kind = kind_of_extension(path);
    if (*kind == RSV_FILE_UNKNOWN) *kind = kind_of_content(file);
    fclose(file);
    if (*kind == RSV_FILE_UNKNOWN)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "is not a scene that can be read; use .gltf, .glb, .obj, .ply, .fbx, .dae or .stl");
    return RSV_OK;
}

static rsv_status check_desc(const rsv_load_desc *desc)
{
    if (!(desc->metres_per_unit > 0) || !isfinite(desc->metres_per_unit))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "%g metres per unit is not valid", (double)desc->metres_per_unit);
    if (!(desc->crease_angle >= 0))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "a crease angle of %g is not valid", (double)desc->crease_angle);
    if ((unsigned)desc->light_units > RSV_LIGHT_UNITS_PHOTOMETRIC)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "units of light %d do not exist", (int)desc->light_units);
    if (desc->files && (!desc->files->size || !desc->files->read))
        return rsv_fail(RSV_ERROR_ARGUMENT, "its source of files lacks a callback");
    return RSV_OK;
}

void rsv_set_sides(const rsv_load_desc *desc, rsv_scene *scene)
{
    for (size_t k = 0; k < scene->material_count; k++) {
        rsv_material *m = &scene->material[k];
        bool shines = m->emission.r + m->emission.g + m->emission.b > 0;
        if (m->transmission == 0 && (shines ? desc->emit_both : desc->two_sided))
            m->double_sided = true;
    }
}

rsv_status rsv_name_file(rsv_status status, const char *path)
{
    char message[768];
    snprintf(message, sizeof message, "%s", rsv_last_error());
    // messages say what to do after a semicolon; for broken files that is mostly the same
    bool advises = strchr(message, ';') || status != RSV_ERROR_FORMAT;
    return rsv_fail(status, "%s: %s%s", path, message, advises ? "" : "; export it again");
}

rsv_status rsv_scene_load_with(
    rsv_context *context, const char *path, const rsv_load_desc *desc, rsv_scene **scene)
{
    rsv_status status;
    rsv_scene *loaded = NULL;
    rsv_file_kind kind;
    rsv_load_desc settings = rsv_default_load_desc();
    RSV_TRY(RSV_READ_DESC(rsv_load_desc, &settings, desc));
    desc = &settings;
    RSV_TRY(check_desc(desc));
    RSV_TRY(rsv_find_file_kind(desc->files, path, &kind));
    RSV_TRY(rsv_scene_create(context, &loaded));
    loaded->is_part = desc->is_part;
    if (desc->variant && kind != RSV_FILE_GLTF)
        RSV_TRY(rsv_fail(
            RSV_ERROR_ARGUMENT, "has no variant '%.200s': only glTF has variants", desc->variant));
    if (kind == RSV_FILE_GLTF)
        RSV_TRY(rsv_gltf_read(path, desc, loaded));
    else if (kind == RSV_FILE_PLY)
        RSV_TRY(rsv_ply_read(path, desc, loaded));
    else if (kind == RSV_FILE_STL)
        RSV_TRY(rsv_stl_read(path, desc, loaded));
    else
        RSV_TRY(rsv_assimp_read(path, kind, desc, loaded));
    rsv_set_sides(desc, loaded);
    RSV_TRY(rsv_scene_load_luminaires(loaded, desc->luminaire, desc->luminaire_count));
    RSV_TRY(rsv_scene_commit(loaded));
    *scene = loaded;
    return RSV_OK;
cleanup:
    rsv_scene_destroy(loaded);
    return rsv_name_file(status, path);
}

rsv_status rsv_scene_load(rsv_context *context, const char *path, rsv_scene **scene)
{
    return rsv_scene_load_with(context, path, NULL, scene);
}

rsv_status rsv_scene_load_memory(rsv_context *context, const char *name, const void *bytes,
    size_t count, const rsv_load_desc *desc, rsv_scene **scene)
{
    rsv_known_files known = { .file = { { name, bytes, count } }, .count = 1 };
    const rsv_file_source source = rsv_known_source(&known);
    rsv_load_desc with = rsv_default_load_desc();
    rsv_status status = RSV_READ_DESC(rsv_load_desc, &with, desc);
    if (status != RSV_OK) return status;
    with.files = &source;
    return rsv_scene_load_with(context, name, &with, scene);
}
