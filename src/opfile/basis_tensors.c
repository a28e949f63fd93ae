/// E0 light by light, and how each source stands.
#include "exchange.h"
#include "table.h"

#include <stdio.h>
#include <string.h>

#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])
#define PREFIX "light."

static const char *const part_names[RSV_LIGHT_FIELDS] = { "source", "coarse_caustic", "direct",
    "caustic" };

/// Parts that a solution has no field for are left out.
static rsv_status exchange_part(
    rsv_tensor_file *file, const rsv_light *s, size_t index, rsv_light_part *part)
{
    rsv_status status = RSV_OK;
    char prefix[32];
    snprintf(prefix, sizeof prefix, PREFIX "%zu.", index);
    rsv_tensor_prefix(file, prefix);
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++) {
        size_t length = rsv_light_field_length(s, field);
        rsv_rgb **array = rsv_light_part_field(part, field);
        if (!length) continue;
        RSV_TRY(rsv_exchange_rgb(file, part_names[field], array, length, 0));
        if (file->reading) RSV_TRY(rsv_exchange_needed(file, part_names[field], *array));
    }
cleanup:
    return status;
}

// ---- sources that are scaled ----------------------------------------------------------------------

/// A source, and how it stands.
typedef struct standing {
    uint32_t kind, index; ///< as in rsv_source
    rsv_rgb scale, strength;
    bool gathered;
} standing;

static const rsv_column standing_columns[] = {
    RSV_CHOICE(standing, kind, RSV_SOURCE_SURROUNDINGS + 1),
    RSV_CHOICE(standing, index, UINT32_MAX),
    RSV_FLOATS(standing, scale, 3),
    RSV_FLOATS(standing, strength, 3),
    RSV_FLAG(standing, gathered),
};

static rsv_status write_standing(
    rsv_tensor_file *file, const rsv_light_view *s, const rsv_light_basis *b)
{
    rsv_status status;
    const rsv_environment *sky = s->scene.view->environment;
    standing *row = rsv_alloc(file->context, b->source_count, sizeof *row);
    RSV_TRY(row ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < b->source_count; k++)
        row[k] = (standing){ (uint32_t)b->source[k].kind, b->source[k].index, b->scale[k],
            b->strength[k], b->gathered[k] };
    rsv_tensor_prefix(file, PREFIX);
    RSV_TRY(rsv_write_table(
        file, standing_columns, COUNT_OF(standing_columns), row, b->source_count, sizeof *row));
    if (sky && b->environment) {
        const size_t shape[3] = { sky->height, sky->width, 3 };
        RSV_TRY(rsv_tensor_add(file, "environment", RSV_TENSOR_F32, 3, shape, b->environment));
    }
cleanup:
    rsv_free(file->context, row);
    return status;
}

/// A place of its own for each source that a scene can have; SIZE_MAX = it has none such.
static size_t place_of(const rsv_scene_view *scene, const standing *row)
{
    switch (row->kind) {
    case RSV_SOURCE_MATERIAL:
        return row->index < scene->material_count ? row->index : SIZE_MAX;
    case RSV_SOURCE_LIGHT:
        return row->index < scene->light_count ? scene->material_count + row->index : SIZE_MAX;
    default:
        return row->index == 0 && scene->environment ? scene->material_count + scene->light_count
                                                     : SIZE_MAX;
    }
}

static rsv_status check_standing(
    rsv_tensor_file *file, const rsv_scene_view *scene, const standing *row, size_t count)
{
    rsv_status status = RSV_OK;
    bool *taken =
        rsv_alloc(file->context, scene->material_count + scene->light_count + 1, sizeof *taken);
    RSV_TRY(taken ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < count; k++) {
        size_t place = place_of(scene, &row[k]);
        RSV_TRY(rsv_check_numbers(file, "scale", &row[k].scale.r, 3, 0));
        RSV_TRY(rsv_check_numbers(file, "strength", &row[k].strength.r, 3, 0));
        if (place == SIZE_MAX || taken[place])
            RSV_TRY(rsv_tensor_fail(
                file, "index", "names a source that the scene lacks, or one twice"));
        taken[place] = true;
    }
cleanup:
    rsv_free(file->context, taken);
    return status;
}

static rsv_status read_environment(
    rsv_tensor_file *file, const rsv_scene_view *scene, rsv_light_basis *b)
{
    const rsv_environment *sky = scene->environment;
    const rsv_tensor *pixels = rsv_tensor_find(file, "environment");
    if (!pixels) return RSV_OK;
    if (!sky || pixels->type != RSV_TENSOR_F32 || pixels->rank != 3 ||
        pixels->shape[0] != sky->height || pixels->shape[1] != sky->width || pixels->shape[2] != 3)
        return rsv_tensor_fail(file, "environment", "is not of the shape of the scene's");
    size_t count = (size_t)sky->width * sky->height;
    rsv_status status = rsv_check_numbers(file, "environment", pixels->data, 3 * count, 0);
    if (status != RSV_OK) return status;
    b->environment = rsv_alloc(file->context, count, sizeof *b->environment);
    if (!b->environment) return RSV_ERROR_MEMORY;
    memcpy(b->environment, pixels->data, count * sizeof *b->environment);
    return RSV_OK;
}

/// Sources as rows gathered them, and the factor of those.
static rsv_status take_gathered(rsv_light *s, const rsv_light_basis *b)
{
    rsv_rgb scale = rgb_gray(1);
    for (size_t k = 0; k < b->source_count; k++)
        if (b->gathered[k]) scale = b->scale[k];
    rsv_light_restore_gathered(s, scale);
    return rsv_lights_gather_sources(
        rsv_light_get_sources(s)->lights, b->source, b->gathered, b->source_count);
}

static rsv_status read_standing(rsv_tensor_file *file, rsv_light *s, rsv_light_basis **basis)
{
    rsv_status status;
    standing *row = NULL;
    size_t count = RSV_ANY_COUNT;
    const rsv_scene_view *scene = rsv_light_get_view(s)->scene.view;
    RSV_TRY(rsv_read_table(
        file, standing_columns, COUNT_OF(standing_columns), &row, &count, sizeof *row));
    RSV_TRY(check_standing(file, scene, row, count));
    RSV_TRY(rsv_light_basis_allocate(file->context, count, basis));
    rsv_light_basis *b = *basis;
    for (size_t k = 0; k < count; k++) {
        b->source[k] = (rsv_source){ (rsv_source_kind)row[k].kind, row[k].index, NULL, NULL };
        b->scale[k] = row[k].scale;
        b->strength[k] = row[k].strength;
        b->gathered[k] = row[k].gathered;
    }
    rsv_light_basis_name_sources(b, scene);
    RSV_TRY(read_environment(file, scene, b));
    RSV_TRY(take_gathered(s, b));
    RSV_TRY(rsv_light_basis_check(s, b));
cleanup:
    rsv_free(file->context, row);
    return status;
}

// ---- all of it ------------------------------------------------------------------------------------

/// Sources as they are by themselves, and how they stand.
static rsv_status write_scaled(rsv_tensor_file *file, const rsv_light *s, const rsv_light_basis *b)
{
    rsv_status status;
    const char **name = rsv_alloc(file->context, b->source_count, sizeof *name);
    RSV_TRY(name ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < b->source_count; k++)
        name[k] = b->source[k].name;
    RSV_TRY(rsv_write_names(file, PREFIX "name", name, b->source_count));
    RSV_TRY(write_standing(file, rsv_light_get_view(s), b));
    for (size_t k = 0; k < b->source_count; k++)
        RSV_TRY(exchange_part(file, s, k, &b->part[k]));
cleanup:
    rsv_free(file->context, name);
    return status;
}

/// The part of a source; NULL = not known.
static rsv_light_part *part_of(const rsv_light_basis *basis, const rsv_source *source)
{
    for (size_t k = 0; k < basis->source_count; k++)
        if (basis->source[k].kind == source->kind && basis->source[k].index == source->index)
            return &basis->part[k];
    return NULL;
}

/// Sources in the order in which a reader will find them.
static rsv_status write_unscaled(
    rsv_tensor_file *file, const rsv_light *s, const rsv_light_basis *basis)
{
    rsv_status status;
    rsv_source *source = NULL;
    const char **name = NULL;
    size_t count = 0;
    RSV_TRY(rsv_list_sources(rsv_light_get_view(s)->lights, &source, &count));
    name = rsv_alloc(file->context, count, sizeof *name);
    RSV_TRY(name ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < count; k++)
        name[k] = source[k].name;
    RSV_TRY(rsv_write_names(file, PREFIX "name", name, count));
    bool apart = rsv_light_has_parts(rsv_light_get_view(s)) && count > 1;
    for (size_t k = 0; apart && k < count; k++) {
        rsv_light_part *part = part_of(basis, &source[k]);
        if (part) RSV_TRY(exchange_part(file, s, k, part));
    }
cleanup:
    rsv_free(file->context, source);
    rsv_free(file->context, name);
    return status;
}

rsv_status rsv_write_basis(rsv_tensor_file *file, const rsv_light *s, const rsv_light_basis *basis)
{
    return rsv_light_basis_is_scaled(basis) ? write_scaled(file, s, basis)
                                            : write_unscaled(file, s, basis);
}

rsv_status rsv_read_basis(rsv_tensor_file *file, rsv_light *s)
{
    rsv_status status;
    rsv_light_basis *basis = NULL;
    rsv_tensor_prefix(file, PREFIX);
    bool scaled = rsv_tensor_find(file, "scale") != NULL;
    if (scaled)
        RSV_TRY(read_standing(file, s, &basis));
    else
        RSV_TRY(rsv_light_basis_create_empty(s, &basis));
    bool apart = scaled || rsv_light_keeps_parts(s, basis);
    for (size_t k = 0; apart && k < basis->source_count; k++)
        RSV_TRY(exchange_part(file, s, k, &basis->part[k]));
    rsv_light_set_basis(s, basis);
    basis = NULL;
cleanup:
    rsv_light_basis_destroy(basis);
    return status;
}
