/// Measured luminaires of a scene, and how its lights hold them. Files without any hold nothing of these.
#include "luminaire_tensors.h"
#include "exchange.h"
#include "table.h"

#include <stdio.h>
#include <string.h>

#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])

typedef struct luminaire_row {
    uint32_t type;
    float size[3]; ///< width, length, height
    float lamp_lumens, watts;
} luminaire_row;

static const rsv_column row_columns[] = {
    RSV_CHOICE(luminaire_row, type, RSV_PHOTOMETRY_A + 1),
    RSV_FLOATS(luminaire_row, size, 3),
    RSV_FLOATS(luminaire_row, lamp_lumens, 1),
    RSV_FLOATS(luminaire_row, watts, 1),
};

static const rsv_column placed_columns[] = {
    RSV_CHOICE(rsv_punctual_light, luminaire, UINT32_MAX),
    RSV_FLOATS(rsv_punctual_light, side, 3),
    RSV_FLOATS(rsv_punctual_light, opening, 3),
};

static const char *name_of(char name[48], size_t index, const char *what)
{
    snprintf(name, 48, "%zu.%s", index, what);
    return name;
}

/// The arrays of one, in both directions.
static rsv_status exchange_angles(rsv_tensor_file *file, size_t index, rsv_luminaire *l)
{
    char name[48];
    rsv_status status;
    size_t vertical = l->vertical ? l->vertical_count : RSV_ANY_COUNT,
           horizontal = l->horizontal ? l->horizontal_count : RSV_ANY_COUNT;
    RSV_TRY(rsv_tensor_exchange(
        file, name_of(name, index, "vertical"), RSV_TENSOR_F32, 1, &l->vertical, &vertical));
    RSV_TRY(rsv_tensor_exchange(
        file, name_of(name, index, "horizontal"), RSV_TENSOR_F32, 1, &l->horizontal, &horizontal));
    if (vertical > UINT32_MAX || horizontal > UINT32_MAX)
        return rsv_tensor_fail(file, name, "has too many angles");
    l->vertical_count = (uint32_t)vertical, l->horizontal_count = (uint32_t)horizontal;
    size_t count = vertical * horizontal;
    RSV_TRY(rsv_tensor_exchange(
        file, name_of(name, index, "intensity"), RSV_TENSOR_F32, 1, &l->intensity, &count));
cleanup:
    return status;
}

static rsv_status write_rows(rsv_tensor_file *file, const rsv_scene_view *view)
{
    rsv_status status;
    size_t count = view->luminaire_count;
    luminaire_row *row = rsv_alloc(file->context, count, sizeof *row);
    const char **name = rsv_alloc(file->context, count, sizeof *name);
    RSV_TRY(row && name ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < count; k++) {
        const rsv_luminaire *l = &view->luminaire[k];
        row[k] = (luminaire_row){ (uint32_t)l->type,
            { (float)l->width, (float)l->length, (float)l->height }, (float)l->lamp_lumens,
            (float)l->watts };
        name[k] = l->name;
    }
    RSV_TRY(rsv_write_table(file, row_columns, COUNT_OF(row_columns), row, count, sizeof *row));
    RSV_TRY(rsv_write_names(file, "scene.luminaire.name", name, count));
cleanup:
    rsv_free(file->context, row);
    rsv_free(file->context, name);
    return status;
}

rsv_status rsv_write_luminaires(rsv_tensor_file *file, const rsv_scene_view *view)
{
    rsv_status status = RSV_OK;
    if (!view->luminaire_count) return RSV_OK;
    rsv_tensor_prefix(file, "scene.luminaire.");
    RSV_TRY(write_rows(file, view));
    for (size_t k = 0; k < view->luminaire_count; k++) {
        rsv_luminaire luminaire = view->luminaire[k];
        RSV_TRY(exchange_angles(file, k, &luminaire));
    }
    rsv_tensor_prefix(file, "scene.light.");
    RSV_TRY(rsv_write_table(file, placed_columns, COUNT_OF(placed_columns), view->light,
        view->light_count, sizeof *view->light));
cleanup:
    return status;
}

static rsv_status read_rows(rsv_tensor_file *file, rsv_luminaire **luminaire, size_t *count)
{
    rsv_status status;
    luminaire_row *row = NULL;
    const char **name = NULL;
    cJSON *list = NULL;
    RSV_TRY(rsv_read_table(file, row_columns, COUNT_OF(row_columns), &row, count, sizeof *row));
    *luminaire = rsv_alloc(file->context, *count, sizeof **luminaire);
    name = rsv_alloc(file->context, *count, sizeof *name);
    RSV_TRY(*luminaire && name ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_read_names(file, "scene.luminaire.name", *count, name, &list));
    for (size_t k = 0; k < *count; k++) {
        rsv_luminaire *l = &(*luminaire)[k];
        snprintf(l->name, sizeof l->name, "%s", name[k]);
        l->type = (rsv_photometry_type)row[k].type;
        l->width = (double)row[k].size[0], l->length = (double)row[k].size[1];
        l->height = (double)row[k].size[2];
        l->lamp_lumens = (double)row[k].lamp_lumens, l->watts = (double)row[k].watts;
    }
cleanup:
    rsv_free(file->context, row);
    rsv_free(file->context, name);
    cJSON_Delete(list);
    return status;
}

static rsv_status read_placed(rsv_tensor_file *file, rsv_punctual_light *light, size_t lights)
{
    rsv_punctual_light *placed = NULL;
    rsv_tensor_prefix(file, "scene.light.");
    rsv_status status = rsv_read_table(
        file, placed_columns, COUNT_OF(placed_columns), &placed, &lights, sizeof *placed);
    for (size_t k = 0; status == RSV_OK && k < lights; k++) {
        light[k].luminaire = placed[k].luminaire;
        light[k].side = placed[k].side;
        light[k].opening = placed[k].opening;
    }
    rsv_free(file->context, placed);
    return status;
}

rsv_status rsv_read_luminaires(rsv_tensor_file *file, rsv_punctual_light *light, size_t lights,
    rsv_luminaire **luminaire, size_t *count)
{
    rsv_status status;
    *count = 0;
    if (!rsv_note_get(file, "scene.luminaire.name")) return RSV_OK;
    *count = RSV_ANY_COUNT;
    rsv_tensor_prefix(file, "scene.luminaire.");
    RSV_TRY(read_rows(file, luminaire, count));
    for (size_t k = 0; k < *count; k++)
        RSV_TRY(exchange_angles(file, k, &(*luminaire)[k]));
    RSV_TRY(read_placed(file, light, lights));
cleanup:
    if (*count == RSV_ANY_COUNT || !*luminaire) *count = 0;
    return status;
}
