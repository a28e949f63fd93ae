/// A solution as a self-contained file.
#include "resolvent/opfile.h"

#include "../core/team.h"
#include "../scene/scene.h"
#include "exchange.h"
#include "program.h"
#include "sha256.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define FORMAT_NAME "resolvent-operator"
#define FORMAT_VERSION 2
#define SCALED_FORMAT_VERSION                                                                      \
    3 ///< of files with sources that are scaled; others are as in version 2

// ---- writing --------------------------------------------------------------------------------------

static rsv_status write_provenance(rsv_tensor_file *file, const char *scene_name, bool scaled)
{
    rsv_status status;
    char version[16];
    snprintf(version, sizeof version, "%d", scaled ? SCALED_FORMAT_VERSION : FORMAT_VERSION);
    RSV_TRY(rsv_note_set(file, "format", FORMAT_NAME));
    RSV_TRY(rsv_note_set(file, "format_version", version));
    RSV_TRY(rsv_note_set(file, "program_version", rsv_version()));
    RSV_TRY(rsv_note_set(file, "scene", scene_name ? scene_name : "unnamed"));
    RSV_TRY(rsv_note_set(file, "units",
        "W/m2 per linear RGB channel (irradiance), metres, y up; E = source + G K E"));
cleanup:
    return status;
}

static rsv_status write_receivers(rsv_tensor_file *file, const rsv_file_receivers *r)
{
    rsv_status status;
    if (!r) return RSV_OK;
    const size_t shape[2] = { r->count, 3 };
    rsv_tensor_prefix(file, "receiver.");
    RSV_TRY(rsv_tensor_add(file, "element", RSV_TENSOR_U32, 2, shape, r->element));
    RSV_TRY(rsv_tensor_add(file, "weight", RSV_TENSOR_F32, 2, shape, r->weight));
    RSV_TRY(rsv_note_set(file, "receivers", r->kind));
cleanup:
    return status;
}

/// Sizes and starts of rows are written as they lie in memory.
static rsv_status check_word(void)
{
    return sizeof(size_t) == sizeof(uint64_t)
               ? RSV_OK
               : rsv_fail(RSV_ERROR_UNSUPPORTED, "operator files need a 64-bit program");
}

rsv_status rsv_light_save_receivers(const rsv_light *solution, const char *scene_name,
    const rsv_file_receivers *receivers, const char *path)
{
    rsv_tensor_file file;
    rsv_light_basis *own = NULL;
    const rsv_light_view *s = rsv_light_get_view(solution);
    rsv_status status = check_word();
    if (status == RSV_OK) status = rsv_tensor_file_begin(s->context, path, &file);
    if (status != RSV_OK) return status;
    const rsv_light_basis *basis = s->basis;
    if (!rsv_light_basis_is_known(basis)) {
        RSV_TRY(rsv_light_basis_create(solution, &own));
        basis = own;
    }
    bool scaled = rsv_light_basis_is_scaled(basis);
    RSV_TRY(write_provenance(&file, scene_name, scaled));
    RSV_TRY(rsv_write_scene(&file, s->scene.scene));
    RSV_TRY(rsv_write_solution(&file, s, scaled ? basis->gathered_scale : s->gathered_scale));
    RSV_TRY(rsv_write_basis(&file, solution, basis));
    RSV_TRY(write_receivers(&file, receivers));
    if (!receivers) RSV_TRY(rsv_write_document(&file, s->scene.scene));
    RSV_TRY(rsv_tensor_file_write(&file));
cleanup:
    rsv_light_basis_destroy(own);
    rsv_tensor_file_end(&file);
    return status;
}

rsv_status rsv_light_save(const rsv_light *solution, const char *scene_name, const char *path)
{
    return rsv_light_save_receivers(solution, scene_name, NULL, path);
}

// ---- comparing ------------------------------------------------------------------------------------

_Static_assert(RSV_FINGERPRINT_DIGITS == RSV_SHA256_DIGITS, "a fingerprint is a SHA-256");

rsv_status rsv_scene_fingerprint(const rsv_scene *scene, char digits[RSV_FINGERPRINT_DIGITS + 1])
{
    rsv_tensor_file file;
    rsv_status status = rsv_scene_require_committed(scene);
    if (status != RSV_OK) return status;
    status = rsv_tensor_file_begin(rsv_scene_get_context(scene), "scene", &file);
    if (status == RSV_OK) status = rsv_write_scene(&file, scene);
    if (status == RSV_OK) rsv_tensor_file_digest(&file, digits);
    rsv_tensor_file_end(&file);
    return status;
}

static rsv_status compare_programs(rsv_context *context)
{
    char text[96], digits[RSV_SHA256_DIGITS + 1];
    rsv_program_digest(digits);
    snprintf(text, sizeof text, "%s-%s", rsv_version(), digits);
    return rsv_team_compare(context, "program", text);
}

rsv_status rsv_scene_compare(const rsv_scene *scene)
{
    rsv_context *context = rsv_scene_get_context(scene);
    char digits[RSV_FINGERPRINT_DIGITS + 1];
    if (!rsv_team_of(context)) return RSV_OK;
    rsv_status status;
    RSV_TRY(compare_programs(context));
    RSV_TRY(rsv_scene_fingerprint(scene, digits));
    RSV_TRY(rsv_team_compare(context, "scene", digits));
cleanup:
    return rsv_team_meet(context, status);
}

// ---- reading --------------------------------------------------------------------------------------

static rsv_status check_provenance(const rsv_tensor_file *file)
{
    const char *format = rsv_note_get(file, "format");
    const char *text = rsv_note_get(file, "format_version");
    if (!format || strcmp(format, FORMAT_NAME) != 0 || !text)
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: it is a safetensors file, but not an operator file; `resolvent solve` writes those",
            file->path);
    long version = strtol(text, NULL, 10);
    if (version == FORMAT_VERSION || version == SCALED_FORMAT_VERSION) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "%s: its format version is %.16s, this program reads versions %d and %d: %s", file->path,
        text, FORMAT_VERSION, SCALED_FORMAT_VERSION,
        version > SCALED_FORMAT_VERSION ? "use a newer Resolvent or solve the scene again"
                                        : "solve the scene again");
}

/// Adds the name of the file to messages of other rooms.
static rsv_status name_file(const char *path, rsv_status status)
{
    char message[768];
    size_t length = strlen(path);
    if (status != RSV_ERROR_FORMAT && status != RSV_ERROR_ARGUMENT) return status;
    snprintf(message, sizeof message, "%s", rsv_last_error());
    if (strncmp(message, path, length) == 0) return status;
    return rsv_fail(
        RSV_ERROR_FORMAT, "%s: %s; the file was changed, solve the scene again", path, message);
}

/// @param digits out: the checksum
static rsv_status read_file(rsv_tensor_file *file, rsv_scene **scene, rsv_light **solution,
    char digits[RSV_SHA256_DIGITS + 1])
{
    rsv_status status;
    rsv_world *world = NULL;
    RSV_TRY(check_word());
    RSV_TRY(check_provenance(file));
    RSV_TRY(rsv_tensor_file_verify(file));
    snprintf(digits, RSV_SHA256_DIGITS + 1, "%s", rsv_note_get(file, RSV_CHECKSUM_NOTE));
    RSV_TRY(rsv_read_scene(file, scene));
    RSV_TRY(rsv_read_document(file, *scene));
    RSV_TRY(rsv_world_create(*scene, &world));
    RSV_TRY(rsv_read_solution(file, world, solution));
    RSV_TRY(rsv_read_basis(file, *solution));
    const rsv_light_view *light = rsv_light_get_view(*solution);
    // what is switched off can be switched on again
    if (!light->basis || !rsv_light_basis_is_scaled(light->basis))
        rsv_lights_warn_if_dark(light->lights);
cleanup:
    rsv_world_release(world);
    return status;
}

rsv_status rsv_light_load(
    rsv_context *context, const char *path, rsv_scene **scene, rsv_light **solution)
{
    rsv_tensor_file file;
    rsv_scene *read_scene = NULL;
    rsv_light *s = NULL;
    char digits[RSV_SHA256_DIGITS + 1];
    rsv_status status = rsv_tensor_file_open(context, path, &file);
    if (status != RSV_OK) return status;
    RSV_TRY(name_file(path, read_file(&file, &read_scene, &s, digits)));
    RSV_TRY(rsv_team_compare(context, "operator file", digits));
    *scene = read_scene;
    *solution = s;
    read_scene = NULL;
    s = NULL;
cleanup:
    rsv_light_destroy(s);
    rsv_scene_destroy(read_scene);
    rsv_tensor_file_end(&file);
    return status;
}

rsv_status rsv_operator_compare(rsv_context *context, const char *path)
{
    rsv_tensor_file file = { 0 };
    if (!rsv_team_of(context)) return RSV_OK;
    rsv_status status;
    RSV_TRY(compare_programs(context));
    if (!rsv_is_operator_file(path))
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT,
            "%s: it is not an operator file; `resolvent solve SCENE -o FILE.safetensors` writes one",
            path));
    RSV_TRY(rsv_tensor_file_open(context, path, &file));
    RSV_TRY(check_provenance(&file));
    const char *digits = rsv_note_get(&file, RSV_CHECKSUM_NOTE);
    RSV_TRY(rsv_team_compare(context, "operator file", digits ? digits : "none"));
cleanup:
    rsv_tensor_file_end(&file);
    return rsv_team_meet(context, status);
}

rsv_status rsv_operator_scene_name(rsv_context *context, const char *path, char *name, size_t bytes)
{
    rsv_tensor_file file;
    rsv_status status = rsv_tensor_file_open(context, path, &file);
    if (status != RSV_OK) return status;
    RSV_TRY(check_provenance(&file));
    const char *scene = rsv_note_get(&file, "scene");
    snprintf(name, bytes, "%s", scene ? scene : "unnamed");
cleanup:
    rsv_tensor_file_end(&file);
    return status;
}

bool rsv_is_operator_file(const char *path)
{
    uint8_t start[9];
    struct stat info;
    // opening a pipe would wait for its writer
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode)) return false;
    FILE *file = fopen(path, "rb");
    bool read = file && fread(start, 1, sizeof start, file) == sizeof start;
    if (file) fclose(file);
    // a length below 4 GiB ends in zeros, which no text does; then comes a JSON object
    return read && start[8] == '{' && !start[4] && !start[5] && !start[6] && !start[7];
}
