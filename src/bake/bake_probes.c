/// Light for what moves: a grid of probes, each with the radiance around it in spherical harmonics of order 2.
///
/// Radiance is fitted to irradiance readings for 32 normals: those of McLaren's cubature of degree 9 (1963), vertices of an
/// icosahedron and a dodecahedron. Irradiance is radiance with its harmonics scaled (Ramamoorthi and Hanrahan
/// 2001), and those of degree 3, and of 4 nearly, are absent from it: the fit is a projection.
#include "resolvent/bake.h"

#include "../core/vec.h"
#include "../io/atomic_file.h"
#include "../solve/solution.h"
#include "bake_desc.h"
#include "resolvent/render.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979323846
#define NORMALS 32
#define HARMONICS 9
#define MOST_PROBES ((size_t)1 << 20)
/// Without a spacing, so many probes along the longest side.
#define PROBES_ALONG 16
/// A probe that sees more backs than this share is inside something.
#define MOST_BACKS 0.25f

typedef struct probe_bake {
    const rsv_solution *s;
    const rsv_bake_desc *desc;
    uint32_t size[3];
    rsv_vec3 origin, spacing;
    size_t count;
    rsv_vec3 normal[NORMALS];
    double weight[NORMALS];            ///< sum 1
    rsv_rgb (*coefficient)[HARMONICS]; ///< [count]
    uint8_t *valid;                    ///< [count]
} probe_bake;

static void choose_normals(probe_bake *b)
{
    const float golden = 1.6180339887f;
    int n = 0;
    for (int k = 0; k < 12; k++) { // cyclic permutations of (0, +-1, +-golden)
        float v[3] = { 0, 0, 0 };
        v[(k / 4 + 1) % 3] = k & 1 ? -1.0f : 1.0f;
        v[(k / 4 + 2) % 3] = k & 2 ? -golden : golden;
        b->normal[n] = v3_normalize(v3(v[0], v[1], v[2]));
        b->weight[n++] = 5.0 / 168;
    }
    for (int k = 0; k < 8; k++) {
        b->normal[n] = v3_normalize(v3(k & 1 ? -1 : 1, k & 2 ? -1 : 1, k & 4 ? -1 : 1));
        b->weight[n++] = 9.0 / 280;
    }
    for (int k = 0; k < 12; k++) { // cyclic permutations of (0, +-golden, +-1 / golden)
        float v[3] = { 0, 0, 0 };
        v[(k / 4 + 1) % 3] = k & 1 ? -golden : golden;
        v[(k / 4 + 2) % 3] = k & 2 ? -1 / golden : 1 / golden;
        b->normal[n] = v3_normalize(v3(v[0], v[1], v[2]));
        b->weight[n++] = 9.0 / 280;
    }
}

/// Real spherical harmonics of a unit vector, in the order (0,0) (1,-1) (1,0) (1,1) (2,-2) .. (2,2).
static void harmonics(rsv_vec3 n, double y[HARMONICS])
{
    double x = (double)n.x, v = (double)n.y, z = (double)n.z;
    const double value[HARMONICS] = { 0.28209479177, 0.48860251190 * v, 0.48860251190 * z,
        0.48860251190 * x, 1.09254843059 * x * v, 1.09254843059 * v * z,
        0.31539156525 * (3 * z * z - 1), 1.09254843059 * x * z, 0.54627421529 * (x * x - v * v) };
    memcpy(y, value, sizeof value);
}

// ---- the grid -------------------------------------------------------------------------------------

/// Probes lie in the middle of equal cells that fill the scene's bounds.
static rsv_status lay_grid(probe_bake *b)
{
    const rsv_scene_view *view = b->s->scene.view;
    rsv_vec3 extent = v3_sub(view->bounds_max, view->bounds_min);
    float spacing =
        b->desc->probe_spacing > 0 ? b->desc->probe_spacing : v3_max_abs(extent) / PROBES_ALONG;
    double all = 1;
    float *origin = &b->origin.x, *step = &b->spacing.x;
    for (int a = 0; a < 3; a++) {
        float length = (&extent.x)[a], cells = ceilf(length / spacing - 1e-3f);
        all *= fmax((double)cells, 1);
        if (all > (double)MOST_PROBES)
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "bake: probes %g m apart would be more than %zu; ask for a wider spacing",
                (double)spacing, MOST_PROBES);
        b->size[a] = cells < 1 ? 1 : (uint32_t)cells;
        step[a] = length > 0 ? length / (float)b->size[a] : spacing;
        origin[a] = (&view->bounds_min.x)[a] + 0.5f * step[a];
    }
    b->count = (size_t)all;
    return RSV_OK;
}

static rsv_vec3 place_of(const probe_bake *b, size_t probe)
{
    size_t x = probe % b->size[0], y = probe / b->size[0] % b->size[1];
    size_t z = probe / b->size[0] / b->size[1];
    return v3(b->origin.x + (float)x * b->spacing.x, b->origin.y + (float)y * b->spacing.y,
        b->origin.z + (float)z * b->spacing.z);
}

/// Whether a ray from a probe meets the back of something opaque.
static bool sees_back(const probe_bake *b, rsv_vec3 from, rsv_vec3 direction)
{
    const rsv_scene_view *view = b->s->scene.view;
    const rsv_ray ray = { .origin = from, .direction = direction, .t_max = INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(b->s->tracer, &ray, &hit)) return false;
    const uint32_t *v = view->triangle[hit.triangle];
    const rsv_material *m = &view->material[view->triangle_material[hit.triangle]];
    rsv_vec3 normal = v3_cross(v3_sub(view->position[v[1]], view->position[v[0]]),
        v3_sub(view->position[v[2]], view->position[v[0]]));
    return v3_dot(normal, direction) > 0 && !m->double_sided && m->transmission == 0;
}

static void find_valid(probe_bake *b)
{
#pragma omp parallel for schedule(dynamic, 16) num_threads(rsv_threads(b->s->context))
    for (size_t k = 0; k < b->count; k++) {
        rsv_vec3 place = place_of(b, k);
        int backs = 0;
        for (int n = 0; n < NORMALS; n++)
            backs += sees_back(b, place, b->normal[n]);
        b->valid[k] = (float)backs <= MOST_BACKS * NORMALS;
    }
}

// ---- light ----------------------------------------------------------------------------------------

static void fit(const probe_bake *b, const rsv_probe_reading *reading, rsv_rgb *coefficient)
{
    static const double kept[HARMONICS] = { PI, 2 * PI / 3, 2 * PI / 3, 2 * PI / 3, PI / 4, PI / 4,
        PI / 4, PI / 4, PI / 4 }; // of radiance in irradiance
    double sum[HARMONICS][3] = { { 0 } };
    for (int n = 0; n < NORMALS; n++) {
        double y[HARMONICS];
        harmonics(b->normal[n], y);
        for (int h = 0; h < HARMONICS; h++)
            for (int c = 0; c < 3; c++)
                sum[h][c] +=
                    4 * PI * b->weight[n] * y[h] / kept[h] * (double)(&reading[n].irradiance.r)[c];
    }
    for (int h = 0; h < HARMONICS; h++)
        coefficient[h] = rgb((float)sum[h][0], (float)sum[h][1], (float)sum[h][2]);
}

/// Readings of all valid probes of a row, all normals.
static rsv_status light_row(
    probe_bake *b, size_t first, rsv_probe *probe, rsv_probe_reading *reading)
{
    size_t count = 0, at = 0;
    for (size_t k = first; k < first + b->size[0]; k++)
        for (int n = 0; n < NORMALS && b->valid[k]; n++)
            probe[count++] = (rsv_probe){ .position = place_of(b, k), .normal = b->normal[n] };
    if (!count) return RSV_OK;
    rsv_status status = rsv_probe_irradiance(
        b->s, RSV_PROBE_OPERATOR, probe, count, b->desc->probe_samples, b->s->desc.seed, reading);
    for (size_t k = first; status == RSV_OK && k < first + b->size[0]; k++)
        if (b->valid[k]) {
            fit(b, reading + at, b->coefficient[k]);
            at += NORMALS;
        }
    return status;
}

static rsv_status light_probes(probe_bake *b)
{
    rsv_status status = RSV_OK;
    rsv_context *context = b->s->context;
    rsv_probe *probe = rsv_alloc(context, (size_t)NORMALS * b->size[0], sizeof *probe);
    rsv_probe_reading *reading = rsv_alloc(context, (size_t)NORMALS * b->size[0], sizeof *reading);
    RSV_TRY(probe && reading ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t first = 0; first < b->count; first += b->size[0]) {
        RSV_TRY(light_row(b, first, probe, reading));
        RSV_TRY(rsv_progress(context, "bake", (double)first / (double)b->count));
    }
cleanup:
    rsv_free(context, probe);
    rsv_free(context, reading);
    return status;
}

// ---- files ----------------------------------------------------------------------------------------

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

/// The description, as JSON; free with cJSON_free. NULL on exhaustion.
static char *describe(const probe_bake *b, const char *data_name)
{
    size_t bytes = b->count * sizeof *b->coefficient;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "format", "resolvent-probes");
    cJSON_AddNumberToObject(root, "format_version", 1);
    cJSON_AddStringToObject(root, "units", "W/(sr m2), linear RGB; metres, y up");
    add_vector(root, "size", b->size[0], b->size[1], b->size[2]);
    add_vector(root, "origin", (double)b->origin.x, (double)b->origin.y, (double)b->origin.z);
    add_vector(root, "spacing", (double)b->spacing.x, (double)b->spacing.y, (double)b->spacing.z);
    cJSON_AddStringToObject(root, "data", data_name);
    cJSON *sh = cJSON_AddObjectToObject(root, "coefficients");
    cJSON_AddNumberToObject(sh, "byteOffset", 0);
    cJSON_AddNumberToObject(sh, "byteLength", (double)bytes);
    cJSON_AddStringToObject(sh, "type", "F32");
    cJSON_AddItemToObject(sh, "shape",
        cJSON_CreateDoubleArray((const double[]){ (double)b->count, HARMONICS, 3 }, 3));
    cJSON *valid = cJSON_AddObjectToObject(root, "valid");
    cJSON_AddNumberToObject(valid, "byteOffset", (double)bytes);
    cJSON_AddNumberToObject(valid, "byteLength", (double)b->count);
    cJSON_AddStringToObject(valid, "type", "U8");
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    return text;
}

/// "room.json" and "room.bin".
static rsv_status write_files(const probe_bake *b, const char *output)
{
    char path[RSV_PATH_BYTES];
    const char *slash = strrchr(output, '/');
    snprintf(path, sizeof path, "%.*s.bin", (int)(strlen(output) - strlen(".json")), output);
    char *text = describe(b, path + (slash ? slash + 1 - output : 0));
    if (!text) return rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", output);
    const void *const parts[] = { b->coefficient, b->valid };
    const size_t bytes[] = { b->count * sizeof *b->coefficient, b->count };
    rsv_status status = write_bytes(path, parts, bytes, 2);
    if (status == RSV_OK)
        status = write_bytes(output, (const void *[]){ text }, (size_t[]){ strlen(text) }, 1);
    cJSON_free(text);
    return status;
}

rsv_status rsv_bake_probes(const rsv_solution *solution, const char *input, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    (void)input;
    rsv_status status;
    rsv_bake_desc defaults = rsv_default_bake_desc();
    probe_bake b = { .s = solution, .desc = desc ? desc : &defaults };
    RSV_TRY(rsv_bake_check_desc(b.desc));
    if (b.desc->basis)
        RSV_TRY(rsv_fail(RSV_ERROR_UNSUPPORTED, "bake: probes are not kept light by light"));
    RSV_TRY(lay_grid(&b));
    choose_normals(&b);
    b.valid = rsv_alloc(solution->context, b.count, 1);
    b.coefficient = rsv_alloc(solution->context, b.count, sizeof *b.coefficient);
    RSV_TRY(b.valid && b.coefficient ? RSV_OK : RSV_ERROR_MEMORY);
    find_valid(&b);
    *report = (rsv_bake_report){ .light_scale = 1 };
    memcpy(report->probe_count, b.size, sizeof b.size);
    for (size_t k = 0; k < b.count; k++)
        report->valid_probes += b.valid[k];
    if (b.desc->dry_run) goto cleanup;
    RSV_TRY(light_probes(&b));
    RSV_TRY(write_files(&b, output));
cleanup:
    rsv_free(solution->context, b.valid);
    rsv_free(solution->context, b.coefficient);
    return status;
}
