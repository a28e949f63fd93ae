/// Light for moving objects: probes (render/probe_grid.h) in files.
#include "../io/atomic_file.h"
#include "../opfile/exchange.h"
#include "../render/probe_grid.h"
#include "../scene/document.h"
#include "bake_basis.h"
#include "bake_document.h"
#include "bake_target.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <string.h>

static rsv_status light_probes(rsv_probe_grid *g)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < g->count && status == RSV_OK; k++) {
        if (g->valid[k]) rsv_probe_grid_light(g, k);
        if (k % g->size[0] == 0)
            status = rsv_progress(g->solution->context, "bake", (double)k / (double)g->count);
    }
    return status;
}

static void add_vector(cJSON *root, const char *name, double x, double y, double z)
{
    cJSON_AddItemToObject(root, name, cJSON_CreateDoubleArray((const double[]){ x, y, z }, 3));
}

static rsv_status write_bytes(
    const char *path, const void *const *part, const size_t *bytes, int parts)
{
    rsv_atomic_file file = { .descriptor = -1 };
    rsv_status status = rsv_atomic_file_open(&file, path);
    if (status != RSV_OK) return status;
    for (int k = 0; k < parts; k++)
        rsv_atomic_file_append(&file, part[k], bytes[k]);
    status = rsv_atomic_file_commit(&file);
    rsv_atomic_file_discard(&file);
    return status;
}

/// What the scene's file says of itself: `asset`, with its extras, and packets of XMP metadata.
static rsv_status add_metadata(const rsv_scene *scene, cJSON *root)
{
    rsv_bake_document d;
    if (!rsv_scene_find_document(scene)) return RSV_OK;
    rsv_status status = rsv_bake_document_open(scene, &d);
    if (status != RSV_OK) return status;
    cJSON *asset = cJSON_DetachItemFromObjectCaseSensitive(d.root, "asset");
    cJSON *extensions = cJSON_GetObjectItemCaseSensitive(d.root, "extensions");
    cJSON *packets = cJSON_DetachItemFromObjectCaseSensitive(extensions, "KHR_xmp_json_ld");
    if (asset) cJSON_AddItemToObject(root, "asset", asset);
    if (packets) cJSON_AddItemToObject(root, "KHR_xmp_json_ld", packets);
    rsv_bake_document_close(&d);
    return RSV_OK;
}

/// The description, as JSON; free with cJSON_free. NULL on exhaustion.
static char *describe(const rsv_probe_grid *g, const char *data_name, cJSON *root)
{
    size_t bytes = g->count * sizeof *g->coefficient;
    const double *from = g->solution->scene.view->origin;
    cJSON_AddStringToObject(root, "format", "resolvent-probes");
    cJSON_AddNumberToObject(root, "format_version", 1);
    cJSON_AddStringToObject(root, "units", "W/(sr m2), linear RGB; metres, y up");
    add_vector(root, "size", g->size[0], g->size[1], g->size[2]);
    add_vector(root, "origin", (double)g->origin.x + from[0], (double)g->origin.y + from[1],
        (double)g->origin.z + from[2]);
    add_vector(root, "spacing", (double)g->spacing.x, (double)g->spacing.y, (double)g->spacing.z);
    cJSON_AddStringToObject(root, "data", data_name);
    cJSON *sh = cJSON_AddObjectToObject(root, "coefficients");
    cJSON_AddNumberToObject(sh, "byteOffset", 0);
    cJSON_AddNumberToObject(sh, "byteLength", (double)bytes);
    cJSON_AddStringToObject(sh, "type", "F32");
    cJSON_AddItemToObject(sh, "shape",
        cJSON_CreateDoubleArray((const double[]){ (double)g->count, RSV_PROBE_HARMONICS, 3 }, 3));
    cJSON *valid = cJSON_AddObjectToObject(root, "valid");
    cJSON_AddNumberToObject(valid, "byteOffset", (double)bytes);
    cJSON_AddNumberToObject(valid, "byteLength", (double)g->count);
    cJSON_AddStringToObject(valid, "type", "U8");
    return cJSON_Print(root);
}

/// "room.json" and "room.probes.bin": a buffer of the scene may well be called room.bin.
static rsv_status write_files(const rsv_probe_grid *g, const char *output)
{
    char path[RSV_PATH_BYTES];
    const char *slash = strrchr(output, '/');
    snprintf(path, sizeof path, "%.*s.probes.bin", (int)(strlen(output) - strlen(".json")), output);
    cJSON *root = cJSON_CreateObject();
    char *text = NULL;
    rsv_status status = add_metadata(g->solution->scene.scene, root);
    if (status == RSV_OK) text = describe(g, path + (slash ? slash + 1 - output : 0), root);
    cJSON_Delete(root);
    if (status != RSV_OK) return status;
    if (!text) return rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", output);
    const void *const parts[] = { g->coefficient, g->valid };
    const size_t bytes[] = { g->count * sizeof *g->coefficient, g->count };
    status = write_bytes(path, parts, bytes, 2);
    if (status == RSV_OK)
        status = write_bytes(output, (const void *[]){ text }, (size_t[]){ strlen(text) }, 1);
    cJSON_free(text);
    return status;
}

// ---- light by light -------------------------------------------------------------------------------

/// The same probes under another light. Each light draws numbers of its own, so that together they are another estimate
/// of the whole, which takes the place of the first.
static rsv_status read_probes(
    const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value)
{
    rsv_probe_grid grid = *(const rsv_probe_grid *)reader->receiver;
    grid.solution = grid.job.solution = light;
    grid.coefficient = (rsv_rgb(*)[RSV_PROBE_HARMONICS])value;
    return light_probes(&grid);
}

static rsv_status describe_grid(const rsv_bake_reader *reader, rsv_tensor_file *file)
{
    const rsv_probe_grid *g = reader->receiver;
    const size_t three = 3;
    rsv_status status;
    RSV_TRY(rsv_tensor_add(file, "probe.size", RSV_TENSOR_U32, 1, &three, g->size));
    RSV_TRY(rsv_tensor_add(file, "probe.origin", RSV_TENSOR_F32, 1, &three, &g->origin));
    RSV_TRY(rsv_tensor_add(file, "probe.spacing", RSV_TENSOR_F32, 1, &three, &g->spacing));
    RSV_TRY(rsv_tensor_add(file, "probe.valid", RSV_TENSOR_U8, 1, &g->count, g->valid));
    RSV_TRY(rsv_write_origin(file, g->solution->scene.view));
cleanup:
    return status;
}

static rsv_bake_reader reader_of(const rsv_probe_grid *grid)
{
    return (rsv_bake_reader){ .kind = "probe",
        .units = "W/(sr m2) per linear RGB channel (radiance)",
        .receiver = grid,
        .count = grid->count,
        .width = RSV_PROBE_HARMONICS,
        .sum = grid->coefficient[0],
        .read = read_probes,
        .describe = describe_grid };
}

static rsv_status write_probes(const rsv_light_view *solution, const rsv_bake_desc *desc,
    const char *output, rsv_bake_report *report)
{
    rsv_status status;
    rsv_probe_grid grid = { 0 };
    RSV_TRY(rsv_probe_grid_create(solution, desc->probe_spacing, desc->probe_samples, true, &grid));
    report->light_scale = 1;
    memcpy(report->probe_count, grid.size, sizeof grid.size);
    if (!desc->dry_run) {
        RSV_TRY(light_probes(&grid));
        rsv_probe_grid_judge(&grid);
    }
    for (size_t k = 0; k < grid.count; k++)
        report->valid_probes += grid.valid[k] != 0;
    if (desc->dry_run) goto cleanup;
    rsv_bake_reader reader = reader_of(&grid);
    if (desc->basis)
        RSV_TRY(rsv_bake_write_basis(solution, &reader, desc, output, &report->lights));
    RSV_TRY(write_files(&grid, output));
cleanup:
    rsv_probe_grid_destroy(&grid);
    return status;
}

const rsv_bake_target rsv_bake_target_probes = { ".json", write_probes };
