#include "material_fields.h"
#include "scene.h"

#include <math.h>
#include <stddef.h>

const rsv_material_field *rsv_material_fields(void)
{
    static const rsv_material_field fields[] = {
#define NUMBER(field, channels, usual, low, high, extension, key)                                  \
    { #field, offsetof(rsv_material, field), channels, usual, low, high, extension, key },
#define FLAG(field)
        RSV_MATERIAL_FIELDS(NUMBER, FLAG)
#undef NUMBER
#undef FLAG
            { .name = NULL }
    };
    return fields;
}

static float *value_of(rsv_material *material, const rsv_material_field *field)
{
    return (float *)(void *)((char *)material + field->offset);
}

rsv_material rsv_default_material(void)
{
    rsv_material material = { 0 };
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++)
        for (int k = 0; k < f->channels; k++)
            value_of(&material, f)[k] = f->usual;
    return material;
}

/// Clamps to [low, high]; NaN becomes `fallback`. True if it was out of range.
static bool clamp(float *value, float low, float high, float fallback)
{
    float clamped = isnan(*value) ? fallback : fminf(fmaxf(*value, low), high);
    bool changed = clamped != *value;
    *value = clamped;
    return changed;
}

void rsv_material_clamp(const rsv_context *context, rsv_material *material)
{
    for (const rsv_material_field *f = rsv_material_fields(); f->name; f++) {
        bool changed = false, returns_light = f->channels == 3 && f->high == 1;
        for (int k = 0; k < f->channels; k++)
            changed |= clamp(&value_of(material, f)[k], f->low, f->high, f->usual);
        if (changed)
            rsv_log(context, RSV_LOG_WARNING,
                "material '%s': %s was outside its range and is clamped%s", material->name, f->name,
                returns_light
                    ? ": a surface that returns more light than it receives has no bounded solution"
                    : "");
    }
}
