#include "bake_basis.h"

#include "../core/number_text.h"
#include "../opfile/exchange.h"
#include "../relight/light_response.h"
#include "../relight/turned_surroundings.h"
#include "bake_basis_pack.h"
#include "bake_constants.h"

#include <stdio.h>
#include <string.h>

void rsv_bake_name_beside(const char *output, const char *kind, char path[RSV_PATH_BYTES])
{
    const char *slash = strrchr(output, '/'), *dot = strrchr(output, '.');
    size_t length = dot && (!slash || dot > slash) ? (size_t)(dot - output) : strlen(output);
    snprintf(path, RSV_PATH_BYTES, "%.*s.%s.safetensors", (int)length, output, kind);
}

// ---- before the work ------------------------------------------------------------------------------

rsv_status rsv_bake_check_lights(const rsv_light_view *s, const rsv_bake_desc *desc)
{
    size_t count = 0;
    if (!desc->basis || desc->dry_run) return RSV_OK;
    rsv_status status = rsv_light_responses_count(s->light, &count);
    if (status == RSV_OK && count > MANY_LIGHTS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "bake: the basis of %zu lights is computed light by light; join lights that you will "
            "not change separately",
            count);
    return status;
}

// ---- reading --------------------------------------------------------------------------------------

rsv_bake_reader rsv_bake_surface_reader(const char *kind, const void *receiver, size_t count,
    rsv_status (*read)(const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value))
{
    return (rsv_bake_reader){ .kind = kind,
        .units = "W/m2 per linear RGB channel (irradiance)",
        .receiver = receiver,
        .count = count,
        .width = 1,
        .read = read };
}

/// A basis on its way into its file.
typedef struct basis {
    const rsv_light_view *s;
    const rsv_bake_reader *reader;
    rsv_light_responses *responses;
    size_t turned; ///< angles of the surroundings beyond the first
    size_t count;  ///< of all: responses, then those angles
    bool is_packed;
    rsv_rgb *value; ///< [count][reader->count * width]; packed, of one light after the other
    const char **name, **definition; ///< [count]
    rsv_packed_light *packed;        ///< [count]
    float *packed_scale;             ///< [count]
} basis;

static size_t values_of_one(const basis *b) { return b->reader->count * b->reader->width; }

static rsv_rgb *values_of(const basis *b, size_t light)
{
    return b->value + (b->is_packed ? 0 : light * values_of_one(b));
}

/// Sum of the lights, with the environment as it is.
static void add_up(const basis *b, size_t light)
{
    const rsv_rgb *value = values_of(b, light);
    rsv_rgb *sum = b->reader->sum;
    if (!sum || light >= b->responses->count) return;
    for (size_t i = 0; i < values_of_one(b); i++)
        sum[i] = light == 0 ? value[i] : rgb_add(sum[i], value[i]);
}

/// Reads a light at all receivers. @param index of it in the basis
static rsv_status read_light(basis *b, const rsv_light_view *light, size_t index)
{
    rsv_status status;
    memset(values_of(b, index), 0,
        values_of_one(b) * sizeof *b->value); // probes within walls are left out
    RSV_TRY(b->reader->read(b->reader, light, values_of(b, index)));
    add_up(b, index);
    if (!b->is_packed) goto cleanup;
    RSV_TRY(rsv_bake_pack_light(
        b->s->context, &b->value->r, b->reader->count, 3 * b->reader->width, &b->packed[index]));
    b->packed_scale[index] = b->packed[index].scale;
cleanup:
    return status;
}

static rsv_status read_turned(basis *b)
{
    rsv_status status = RSV_OK;
    float first = b->s->scene.view->environment->rotation;
    for (size_t k = 1; k <= b->turned; k++) {
        rsv_light *sky = NULL;
        float rotation = first + 360 * (float)k / (float)(b->turned + 1);
        status = rsv_turned_surroundings_solve(b->s->light, rotation, &sky);
        if (status == RSV_OK)
            status = read_light(b, rsv_light_get_view(sky), b->responses->count + k - 1);
        rsv_light_destroy(sky);
        if (status == RSV_OK)
            status = rsv_progress(b->s->context, "turn", (double)k / (double)b->turned);
        if (status != RSV_OK) break;
    }
    return status;
}

/// Before the work: what it takes.
static void say_bytes(const basis *b, double bytes)
{
    if (b->is_packed && b->count > MANY_LIGHTS)
        rsv_log(b->s->context, RSV_LOG_WARNING,
            "bake: the basis of %zu lights at %zu receivers takes about %.3g MB in its file",
            b->count, b->reader->count, 1e-7 * bytes);
    else if (!b->is_packed && (bytes > LARGE_BASIS || b->count > MANY_LIGHTS))
        rsv_log(b->s->context, RSV_LOG_WARNING,
            "bake: the basis of %zu lights at %zu receivers takes %.3g MB, in memory and in its file; packed "
            "(--packed) it is about a tenth of that",
            b->count, b->reader->count, 1e-6 * bytes);
}

static rsv_status check_bytes(const basis *b)
{
    const size_t given = b->s->desc.max_bytes;
    const double most = given ? (double)given : LARGEST_BASIS;
    double bytes = (double)b->count * (double)values_of_one(b) * sizeof *b->value;
    if (!b->is_packed && bytes > most)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "bake: the basis of %zu lights at %zu receivers takes %.3g GB of memory, more than "
            "the %.3g GB available; pack it (--packed), bake fewer receivers, or join lights",
            b->count, b->reader->count, 1e-9 * bytes, 1e-9 * most);
    say_bytes(b, bytes);
    return RSV_OK;
}

static rsv_status allocate(basis *b)
{
    rsv_context *context = b->s->context;
    size_t held = b->is_packed ? 1 : b->count;
    b->value = rsv_alloc(context, held * values_of_one(b), sizeof *b->value);
    b->name = rsv_alloc(context, b->count, sizeof *b->name);
    b->definition = rsv_alloc(context, b->count, sizeof *b->definition);
    b->packed = rsv_alloc(context, b->count, sizeof *b->packed);
    b->packed_scale = rsv_alloc(context, b->count, sizeof *b->packed_scale);
    bool allocated = b->value && b->name && b->definition && b->packed && b->packed_scale;
    return allocated ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_status read_lights(basis *b)
{
    rsv_status status = RSV_OK;
    const rsv_light_responses *responses = b->responses;
    b->count = responses->count + b->turned;
    RSV_TRY(allocate(b));
    for (size_t k = 0; k < b->count; k++) {
        b->name[k] = k < responses->count ? responses->name[k] : "environment";
        b->definition[k] = k < responses->count ? responses->definition[k] : "environment";
    }
    for (size_t k = 0; k < responses->count; k++)
        RSV_TRY(read_light(b, responses->view[k], k));
    if (b->turned) RSV_TRY(read_turned(b));
cleanup:
    return status;
}

// ---- the file -------------------------------------------------------------------------------------

/// Rotated environments are distinguished by their number, which comes last.
static rsv_status check_turns(const basis *b)
{
    if (!b->s->scene.view->environment)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "bake: there is no environment to rotate; add one, or leave out the turns");
    if (!b->responses->sky_last)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "bake: a light is named 'environment', like the environment itself, which then cannot be rotated "
            "separately; rename the light");
    return RSV_OK;
}

static rsv_status describe(const basis *b, rsv_tensor_file *file)
{
    rsv_status status;
    char text[RSV_NUMBER_BYTES];
    RSV_TRY(rsv_note_set(file, "format", "resolvent-light-basis"));
    RSV_TRY(rsv_note_set(file, "format_version", b->is_packed ? "3" : b->turned ? "2" : "1"));
    RSV_TRY(rsv_note_set(file, "units", b->reader->units));
    RSV_TRY(rsv_note_set(file, "receivers", b->reader->kind));
    RSV_TRY(rsv_write_names(file, "light.name", b->name, b->count));
    RSV_TRY(rsv_write_names(file, "light.definition", b->definition, b->count));
    if (b->turned) {
        snprintf(text, sizeof text, "%zu", b->turned + 1);
        RSV_TRY(rsv_note_set(file, "surroundings.turns", text));
        rsv_number_text(text, 9, (double)b->s->scene.view->environment->rotation);
        RSV_TRY(rsv_note_set(file, "surroundings.rotation", text));
    }
    if (b->reader->describe) RSV_TRY(b->reader->describe(b->reader, file));
cleanup:
    return status;
}

/// Values as they are, or packed: "basis.packed.0", ...
static rsv_status add_values(const basis *b, rsv_tensor_file *file)
{
    rsv_status status = RSV_OK;
    char text[96];
    const size_t shape[3] = { b->count, b->reader->count, 3 * b->reader->width };
    if (!b->is_packed)
        return rsv_tensor_add(file, "basis.value", RSV_TENSOR_F32, 3, shape, b->value);
    snprintf(text, sizeof text, "[%zu,%zu,%zu]", shape[0], shape[1], shape[2]);
    RSV_TRY(rsv_note_set(file, "basis.shape", text));
    RSV_TRY(rsv_tensor_add(file, "basis.scale", RSV_TENSOR_F32, 1, shape, b->packed_scale));
    for (size_t k = 0; k < b->count; k++) {
        snprintf(text, sizeof text, "basis.packed.%zu", k);
        RSV_TRY(
            rsv_tensor_add(file, text, RSV_TENSOR_U8, 1, &b->packed[k].count, b->packed[k].bytes));
    }
cleanup:
    return status;
}

static void free_basis(basis *b)
{
    rsv_context *context = b->s->context;
    for (size_t k = 0; b->packed && k < b->count; k++)
        rsv_free(context, b->packed[k].bytes);
    rsv_free(context, b->packed);
    rsv_free(context, b->packed_scale);
    rsv_free(context, b->value);
    rsv_free(context, b->name);
    rsv_free(context, b->definition);
    rsv_light_responses_destroy(b->responses);
}

rsv_status rsv_bake_write_basis(const rsv_light_view *solution, const rsv_bake_reader *reader,
    const rsv_bake_desc *desc, const char *output, size_t *lights)
{
    rsv_status status;
    basis b = {
        .s = solution, .reader = reader, .turned = desc->turns - 1, .is_packed = desc->packed
    };
    char path[RSV_PATH_BYTES];
    rsv_bake_name_beside(output, "light", path);
    rsv_tensor_file file;
    status = rsv_tensor_file_begin(solution->context, path, &file);
    if (status != RSV_OK) return status;
    RSV_TRY(rsv_light_responses_count(solution->light, &b.count));
    b.count += b.turned;
    RSV_TRY(check_bytes(&b));
    RSV_TRY(rsv_light_responses_create(solution->light, &b.responses));
    if (b.turned) RSV_TRY(check_turns(&b));
    RSV_TRY(read_lights(&b));
    *lights = b.count;
    RSV_TRY(describe(&b, &file));
    RSV_TRY(add_values(&b, &file));
    RSV_TRY(rsv_tensor_file_write(&file));
cleanup:
    rsv_tensor_file_end(&file);
    free_basis(&b);
    return status;
}
