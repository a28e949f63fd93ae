#include "bake_basis.h"

#include "../io/atomic_file.h"
#include "../opfile/exchange.h"

#include <stdio.h>
#include <string.h>

/// "room.glb" -> "room.light.safetensors"
static void name_file(const char *output, char path[RSV_PATH_BYTES])
{
    const char *slash = strrchr(output, '/'), *dot = strrchr(output, '.');
    size_t length = dot && (!slash || dot > slash) ? (size_t)(dot - output) : strlen(output);
    snprintf(path, RSV_PATH_BYTES, "%.*s.light.safetensors", (int)length, output);
}

static void evaluate(const rsv_light_responses *responses, const rsv_bake_receiver *receiver,
    size_t count, rsv_rgb *value)
{
    for (size_t l = 0; l < responses->count; l++) {
        const rsv_solution *light = &responses->light[l];
#pragma omp parallel for schedule(static) num_threads(rsv_threads(responses->context))
        for (size_t n = 0; n < count; n++)
            value[l * count + n] = rsv_bake_irradiance(light, &receiver[n]);
    }
}

rsv_status rsv_bake_write_basis(const rsv_solution *solution, const rsv_bake_receiver *receiver,
    size_t count, const char *kind, const char *output, size_t *lights)
{
    rsv_status status;
    rsv_light_responses *responses = NULL;
    rsv_rgb *value = NULL;
    char path[RSV_PATH_BYTES];
    name_file(output, path);
    rsv_tensor_file file;
    status = rsv_tensor_file_begin(solution->context, path, &file);
    if (status != RSV_OK) return status;
    RSV_TRY(rsv_light_responses_create(solution, &responses));
    *lights = responses->count;
    value = rsv_alloc(solution->context, responses->count * count, sizeof *value);
    RSV_TRY(value ? RSV_OK : RSV_ERROR_MEMORY);
    evaluate(responses, receiver, count, value);
    const size_t shape[3] = { responses->count, count, 3 };
    RSV_TRY(rsv_note_set(&file, "format", "resolvent-light-basis"));
    RSV_TRY(rsv_note_set(&file, "format_version", "1"));
    RSV_TRY(rsv_note_set(&file, "units", "W/m2 per linear RGB channel (irradiance)"));
    RSV_TRY(rsv_note_set(&file, "receivers", kind));
    RSV_TRY(rsv_write_names(&file, "light.name", responses->name, responses->count));
    RSV_TRY(rsv_tensor_add(&file, "basis.value", RSV_TENSOR_F32, 3, shape, value));
    RSV_TRY(rsv_tensor_file_write(&file));
cleanup:
    rsv_tensor_file_end(&file);
    rsv_free(solution->context, value);
    rsv_light_responses_destroy(responses);
    return status;
}
