#include "scene.h"

#include <math.h>

rsv_material rsv_default_material(void)
{
    return (rsv_material){
        .base_color = { 1, 1, 1 },
        .roughness = 1,
        .ior = 1.5f,
        .specular = 1,
        .specular_color = { 1, 1, 1 },
        .attenuation_color = { 1, 1, 1 },
        .attenuation_distance = INFINITY,
        .diffuse_transmission_color = { 1, 1, 1 },
        .opacity = 1,
    };
}

/// Clamps to [low, high]; what is not a number becomes `fallback`. True if it was out of range.
static bool clamp(float *value, float low, float high, float fallback)
{
    float clamped = isnan(*value) ? fallback : fminf(fmaxf(*value, low), high);
    bool changed = clamped != *value;
    *value = clamped;
    return changed;
}

static bool clamp_rgb(rsv_rgb *value, float high, float fallback)
{
    bool r = clamp(&value->r, 0, high, fallback);
    bool g = clamp(&value->g, 0, high, fallback);
    bool b = clamp(&value->b, 0, high, fallback);
    return r || g || b;
}

void rsv_material_clamp(const rsv_context *context, rsv_material *material)
{
    static const float largest = 1e30f; // products of a few such values stay finite in double
    static const char unbounded[] =
        ": a surface that returns more light than it receives has no bounded answer";
    const struct {
        bool changed;
        const char *field;
        const char *why;
    } fields[] = {
        { clamp_rgb(&material->base_color, 1, 1), "base_color", unbounded },
        { clamp(&material->metallic, 0, 1, 0), "metallic", "" },
        { clamp(&material->roughness, 0, 1, 1), "roughness", "" },
        { clamp(&material->ior, 1, largest, 1.5f), "ior", "" },
        { clamp(&material->specular, 0, 1, 1), "specular", "" },
        { clamp_rgb(&material->specular_color, 1, 1), "specular_color", unbounded },
        { clamp(&material->transmission, 0, 1, 0), "transmission", "" },
        { clamp(&material->thickness, 0, largest, 0), "thickness", "" },
        { clamp_rgb(&material->attenuation_color, 1, 1), "attenuation_color", unbounded },
        { clamp(&material->attenuation_distance, 1e-30f, INFINITY, INFINITY),
            "attenuation_distance", "" },
        { clamp_rgb(&material->emission, largest, 0), "emission", "" },
        { clamp(&material->clearcoat, 0, 1, 0), "clearcoat", "" },
        { clamp(&material->clearcoat_roughness, 0, 1, 0), "clearcoat_roughness", "" },
        { clamp_rgb(&material->sheen_color, 1, 0), "sheen_color", unbounded },
        { clamp(&material->sheen_roughness, 0, 1, 0), "sheen_roughness", "" },
        { clamp(&material->diffuse_transmission, 0, 1, 0), "diffuse_transmission", "" },
        { clamp_rgb(&material->diffuse_transmission_color, 1, 1), "diffuse_transmission_color",
            unbounded },
        { clamp_rgb(&material->scatter_distance, largest, 0), "scatter_distance", "" },
        { clamp(&material->opacity, 0, 1, 1), "opacity", "" },
        { clamp(&material->alpha_cutoff, 0, largest, 0.5f), "alpha_cutoff", "" },
    };
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (fields[i].changed)
            rsv_log(context, RSV_LOG_WARNING,
                "material '%s': %s was outside its range and is clamped%s", material->name,
                fields[i].field, fields[i].why);
}
