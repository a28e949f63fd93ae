/// Light in fog for engines: the mean fluence of each cell of the grid over it, as a 3-D texture, and a description.
#include "../elements/voxels.h"
#include "../io/atomic_file.h"
#include "../opfile/exchange.h"
#include "bake_basis.h"
#include "bake_ktx2.h"
#include "bake_target.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <string.h>

/// Fluence of a cell; if walls cut it, the mean over its parts.
static rsv_rgb cell_fluence(const rsv_light_view *s, size_t cell)
{
    const rsv_voxels *v = s->elements->voxels;
    size_t first = rsv_elements_surface_nodes(s->elements);
    rsv_rgb sum = rgb_gray(0);
    float volume = 0;
    for (uint32_t k = v->begin[cell]; k < v->begin[cell + 1]; k++) {
        float own = rsv_voxel_volume(v, k);
        rsv_rgb e = rgb_add(s->source[first + k], s->indirect[first + k]);
        sum = rgb_mad(sum, 4 * own, e);
        volume += own;
    }
    return rgb_positive(rgb_scale(sum, 1 / volume));
}

static rsv_status read_cells(
    const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value)
{
    for (size_t cell = 0; cell < reader->count; cell++)
        value[cell] = cell_fluence(light, cell);
    return RSV_OK;
}

static rsv_vec3 origin_of(const rsv_voxels *v) { return v3_mad(v->low, 0.5f, v->size); }

static rsv_status describe_grid(const rsv_bake_reader *reader, rsv_tensor_file *file)
{
    const rsv_light_view *s = reader->receiver;
    const rsv_voxels *v = s->elements->voxels;
    const size_t three = 3;
    rsv_status status;
    RSV_TRY(rsv_tensor_add(file, "fog.size", RSV_TENSOR_U32, 1, &three, v->side));
    RSV_TRY(rsv_tensor_add(file, "fog.low", RSV_TENSOR_F32, 1, &three, &v->low));
    RSV_TRY(rsv_tensor_add(file, "fog.spacing", RSV_TENSOR_F32, 1, &three, &v->size));
    RSV_TRY(rsv_write_origin(file, s->scene.view));
cleanup:
    return status;
}

static void add_three(cJSON *root, const char *name, double x, double y, double z)
{
    cJSON_AddItemToObject(root, name, cJSON_CreateDoubleArray((const double[]){ x, y, z }, 3));
}

/// The description, as JSON; free with cJSON_free. NULL on exhaustion.
static char *describe(const rsv_light_view *s, const char *data_name)
{
    const rsv_voxels *v = s->elements->voxels;
    const rsv_fog *fog = s->scene.view->fog;
    const double *from = s->scene.view->origin;
    rsv_vec3 first = origin_of(v);
    rsv_rgb a = fog->extinction, b = fog->albedo;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "format", "resolvent-fog");
    cJSON_AddNumberToObject(root, "format_version", 1);
    cJSON_AddStringToObject(root, "units", "fluence, W/m2, linear RGB; metres, y up");
    add_three(root, "size", v->side[0], v->side[1], v->side[2]);
    add_three(root, "origin", (double)first.x + from[0], (double)first.y + from[1],
        (double)first.z + from[2]);
    add_three(root, "spacing", (double)v->size.x, (double)v->size.y, (double)v->size.z);
    add_three(root, "extinction", (double)a.r, (double)a.g, (double)a.b);
    add_three(root, "albedo", (double)b.r, (double)b.g, (double)b.b);
    cJSON_AddNumberToObject(root, "anisotropy", (double)fog->anisotropy);
    cJSON_AddStringToObject(root, "texture", data_name);
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    return text;
}

static rsv_status write_description(const char *output, const char *text)
{
    rsv_atomic_file file = { .descriptor = -1 };
    rsv_status status = rsv_atomic_file_open(&file, output);
    if (status != RSV_OK) return status;
    rsv_atomic_file_append(&file, text, strlen(text));
    status = rsv_atomic_file_commit(&file);
    rsv_atomic_file_discard(&file);
    return status;
}

/// "room.json" and "room.fog.ktx2".
static rsv_status write_files(const rsv_light_view *s, const rsv_rgb *fluence, const char *output)
{
    char path[RSV_PATH_BYTES];
    const char *slash = strrchr(output, '/');
    snprintf(path, sizeof path, "%.*s.fog.ktx2", (int)(strlen(output) - strlen(".json")), output);
    char *text = describe(s, path + (slash ? slash + 1 - output : 0));
    if (!text) return rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", output);
    rsv_status status =
        rsv_bake_write_ktx2_volume(s->context, path, s->elements->voxels->side, fluence);
    if (status == RSV_OK) status = write_description(output, text);
    cJSON_free(text);
    return status;
}

static rsv_status write_fog(
    const rsv_light_view *s, const rsv_bake_desc *desc, const char *output, rsv_bake_report *report)
{
    const rsv_voxels *v = s->elements->voxels;
    if (!v)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "bake: there is no fog in the scene; --fog EXTINCTION fills it, or bake something else");
    rsv_rgb *fluence = rsv_alloc(s->context, v->cell_count, sizeof *fluence);
    if (!fluence) return RSV_ERROR_MEMORY;
    rsv_status status = RSV_OK;
    rsv_bake_reader reader = { .kind = "fog",
        .units = "W/m2 per linear RGB channel (fluence)",
        .receiver = s,
        .count = v->cell_count,
        .width = 1,
        .sum = fluence,
        .read = read_cells,
        .describe = describe_grid };
    report->light_scale = 1;
    memcpy(report->probe_count, v->side, sizeof v->side);
    report->valid_probes = v->cell_count;
    if (desc->dry_run) goto cleanup;
    RSV_TRY(read_cells(&reader, s, fluence));
    if (desc->basis) RSV_TRY(rsv_bake_write_basis(s, &reader, desc, output, &report->lights));
    RSV_TRY(write_files(s, fluence, output));
cleanup:
    rsv_free(s->context, fluence);
    return status;
}

const rsv_bake_target rsv_bake_target_fog = { ".json", write_fog };
