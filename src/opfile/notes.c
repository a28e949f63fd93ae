/// Notes: structs as JSON objects, names as JSON arrays.
#include "exchange.h"

#include "../core/number_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static rsv_status fail_memory(const rsv_tensor_file *file)
{
    return rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory", file->path);
}

static rsv_status fail_note(const rsv_tensor_file *file, const char *note)
{
    return rsv_fail(RSV_ERROR_FORMAT, "%s: note '%s' is missing or unusable; solve the scene again",
        file->path, note);
}

static double number_of(const rsv_field *field, const void *place)
{
    switch (field->kind) {
    case RSV_FIELD_U32:
        return *(const uint32_t *)place;
    case RSV_FIELD_BOOL:
        return *(const bool *)place;
    case RSV_FIELD_FLOAT:
        return *(const float *)place;
    case RSV_FIELD_DOUBLE:
        return *(const double *)place;
    case RSV_FIELD_U64:
        return (double)*(const uint64_t *)place;
    case RSV_FIELD_TEXT:
        break;
    }
    return 0;
}

static bool is_within(double value, double most)
{
    return value >= 0 && value <= most && value == floor(value);
}

static bool store(const rsv_field *field, const cJSON *item, void *place)
{
    if (field->kind == RSV_FIELD_TEXT) {
        const char *text = cJSON_GetStringValue(item);
        if (!text || strlen(text) >= field->bytes) return false;
        memcpy(place, text, strlen(text) + 1);
        return true;
    }
    double value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    bool is_whole = field->kind == RSV_FIELD_U32    ? is_within(value, UINT32_MAX)
                    : field->kind == RSV_FIELD_BOOL ? is_within(value, 1)
                                                    : is_within(value, 0x1p53);
    bool is_real = field->kind == RSV_FIELD_FLOAT || field->kind == RSV_FIELD_DOUBLE;
    if (is_real ? !isfinite(value) : !is_whole) return false;
    if (field->kind == RSV_FIELD_U32) *(uint32_t *)place = (uint32_t)value;
    if (field->kind == RSV_FIELD_BOOL) *(bool *)place = value != 0;
    if (field->kind == RSV_FIELD_U64) *(uint64_t *)place = (uint64_t)value;
    if (field->kind == RSV_FIELD_FLOAT) *(float *)place = (float)value;
    if (field->kind == RSV_FIELD_DOUBLE) *(double *)place = value;
    return true;
}

/// All 17 digits: the JSON library is content with a number that is almost the same.
static cJSON *add_number(cJSON *json, const char *name, double value)
{
    char text[RSV_NUMBER_BYTES];
    rsv_number_text(text, 17, value);
    return cJSON_AddRawToObject(json, name, text);
}

static rsv_status write_json(rsv_tensor_file *file, const char *note, cJSON *json, bool complete)
{
    char *text = complete ? cJSON_PrintUnformatted(json) : NULL;
    rsv_status status = text ? rsv_note_set(file, note, text) : fail_memory(file);
    cJSON_free(text);
    cJSON_Delete(json);
    return status;
}

rsv_status rsv_write_fields(rsv_tensor_file *file, const char *note, const rsv_field *field,
    size_t field_count, const void *object)
{
    bool complete = true;
    cJSON *json = cJSON_CreateObject();
    for (size_t k = 0; k < field_count; k++) {
        const char *place = (const char *)object + field[k].offset;
        bool is_text = field[k].kind == RSV_FIELD_TEXT;
        if (!is_text && !isfinite(number_of(&field[k], place))) continue; // JSON has no infinity
        cJSON *item = is_text ? cJSON_AddStringToObject(json, field[k].name, place)
                              : add_number(json, field[k].name, number_of(&field[k], place));
        complete = complete && item;
    }
    return write_json(file, note, json, complete);
}

rsv_status rsv_read_fields(rsv_tensor_file *file, const char *note, const rsv_field *field,
    size_t field_count, void *object)
{
    const char *text = rsv_note_get(file, note);
    cJSON *json = text ? cJSON_Parse(text) : NULL;
    bool sound = cJSON_IsObject(json);
    for (size_t k = 0; sound && k < field_count; k++) {
        const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, field[k].name);
        sound = !item || store(&field[k], item, (char *)object + field[k].offset);
    }
    cJSON_Delete(json);
    return sound ? RSV_OK : fail_note(file, note);
}

rsv_status rsv_write_names(
    rsv_tensor_file *file, const char *note, const char *const *name, size_t count)
{
    bool complete = true;
    cJSON *json = cJSON_CreateArray();
    for (size_t k = 0; complete && k < count; k++)
        complete = cJSON_AddItemToArray(json, cJSON_CreateString(name[k]));
    return write_json(file, note, json, complete && json);
}

rsv_status rsv_read_names(
    rsv_tensor_file *file, const char *note, size_t count, const char **names, cJSON **list)
{
    const char *text = rsv_note_get(file, note);
    *list = text ? cJSON_Parse(text) : NULL;
    bool sound = cJSON_IsArray(*list);
    size_t k = 0;
    const cJSON *item = NULL;
    if (!sound) return fail_note(file, note);
    cJSON_ArrayForEach(item, *list)
    {
        if (k == count || !cJSON_IsString(item)) {
            sound = false;
            break;
        }
        names[k++] = item->valuestring;
    }
    return sound && k == count ? RSV_OK : fail_note(file, note);
}
