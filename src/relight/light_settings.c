#include "light_settings.h"

#include "../scene/punctual.h"
#include "../scene/scene.h"
#include "../subsurface/scatter_profile.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LARGEST_SCALE 1e6f
#define LARGEST_OFFSET 1e6f ///< metres

rsv_status rsv_light_settings_allocate(
    rsv_context *context, size_t sources, size_t materials, rsv_light_settings *s)
{
    s->scale = rsv_alloc(context, sources, sizeof *s->scale);
    s->offset = rsv_alloc(context, sources, sizeof *s->offset);
    s->aim = rsv_alloc(context, sources, sizeof *s->aim);
    s->base_color = rsv_alloc(context, materials, sizeof *s->base_color);
    return s->scale && s->offset && s->aim && s->base_color ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_light_settings_free(rsv_context *context, rsv_light_settings *s)
{
    rsv_free(context, s->scale);
    rsv_free(context, s->offset);
    rsv_free(context, s->aim);
    rsv_free(context, s->base_color);
    *s = (rsv_light_settings){ 0 };
}

// ---- lights -----------------------------------------------------------------------------------

static rsv_status fail_unknown_light(const rsv_light_settings_home *home, const char *name)
{
    char known[512] = "";
    for (size_t k = 0; k < home->source_count; k++) {
        const rsv_source *source = &home->source[k];
        bool placed = source->node && strcmp(source->node, source->name) != 0;
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, placed ? "%s'%s' of node '%s'" : "%s'%s'",
            k ? ", " : "", source->name, placed ? source->node : "");
    }
    return rsv_fail(RSV_ERROR_ARGUMENT, "relight: there is no light '%s'; there are: %s", name,
        *known ? known : "none");
}

/// Whether a name is one of the sources' own. If not, it can be that of a node that placed a light.
static bool is_own_name(const rsv_light_settings_home *home, const char *name)
{
    for (size_t k = 0; k < home->source_count; k++)
        if (strcmp(home->source[k].name, name) == 0) return true;
    return false;
}

static bool is_meant(const rsv_source *source, const char *name, bool own)
{
    const char *called = own ? source->name : source->node;
    return called && strcmp(called, name) == 0;
}

static bool is_scale(float value) { return value >= 0 && value <= LARGEST_SCALE; }

static rsv_status read_scale(
    const rsv_light_settings_home *home, const rsv_light_scale *light, rsv_light_settings *wanted)
{
    bool known = false, gray = light->scale.r == light->scale.g && light->scale.g == light->scale.b;
    if (!is_scale(light->scale.r) || !is_scale(light->scale.g) || !is_scale(light->scale.b))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "relight: the factors of light '%s' must be from 0 to %g", light->name, LARGEST_SCALE);
    const bool own = is_own_name(home, light->name);
    for (size_t k = 0; k < home->source_count; k++) {
        if (!is_meant(&home->source[k], light->name, own)) continue;
        if (home->source[k].kind == RSV_SOURCE_SURROUNDINGS && !gray)
            return rsv_fail(
                RSV_ERROR_UNSUPPORTED, "relight: the environment takes one factor for all colours");
        wanted->scale[k] = light->scale;
        known = true;
    }
    return known ? RSV_OK : fail_unknown_light(home, light->name);
}

static rsv_status check_movable(const rsv_light_settings_home *home, const rsv_source *source)
{
    if (source->kind == RSV_SOURCE_SURROUNDINGS ||
        (source->kind == RSV_SOURCE_LIGHT &&
            rsv_punctual_is_distant(&home->scene->light[source->index])))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "relight: light '%s' is infinitely far away and cannot be moved", source->name);
    if (source->kind == RSV_SOURCE_MATERIAL &&
        (rsv_is_gathered(home->lights, source->index) ||
            rsv_emission_share(home->lights, source->index) > RSV_MOVABLE_SHARE))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "relight: lamp '%s' fills much of the view, and what it hides is part of the operator; "
            "move it in the "
            "scene and solve the scene again",
            source->name);
    return RSV_OK;
}

static rsv_status read_move(
    const rsv_light_settings_home *home, const rsv_light_move *move, rsv_light_settings *wanted)
{
    bool known = false;
    rsv_vec3 offset = move->offset;
    if (!isfinite(offset.x + offset.y + offset.z) || v3_max_abs(offset) > LARGEST_OFFSET)
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: light '%s' cannot be moved by more than %g m",
            move->name, LARGEST_OFFSET);
    const bool own = is_own_name(home, move->name);
    for (size_t k = 0; k < home->source_count; k++) {
        if (!is_meant(&home->source[k], move->name, own)) continue;
        rsv_status status = check_movable(home, &home->source[k]);
        if (status != RSV_OK) return status;
        wanted->offset[k] = offset;
        known = true;
    }
    return known ? RSV_OK : fail_unknown_light(home, move->name);
}

static bool can_turn(const rsv_light_settings_home *home, const rsv_source *source)
{
    return source->kind == RSV_SOURCE_LIGHT &&
           rsv_punctual_has_direction(&home->scene->light[source->index]);
}

static rsv_status read_aim(
    const rsv_light_settings_home *home, const rsv_light_aim *aim, rsv_light_settings *wanted)
{
    bool known = false;
    float length = v3_length(aim->direction);
    if (!(length > 0) || !isfinite(length))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "relight: light '%s' cannot be turned: no direction", aim->name);
    const bool own = is_own_name(home, aim->name);
    for (size_t k = 0; k < home->source_count; k++) {
        if (!is_meant(&home->source[k], aim->name, own)) continue;
        if (!can_turn(home, &home->source[k]))
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "relight: light '%s' cannot be turned: only spot lights, luminaires and "
                "directional lights can",
                aim->name);
        wanted->aim[k] = v3_scale(aim->direction, 1 / length);
        known = true;
    }
    return known ? RSV_OK : fail_unknown_light(home, aim->name);
}

rsv_status rsv_gathered_scale(
    const rsv_light_settings_home *home, const rsv_light_settings *settings, rsv_rgb *scale)
{
    const char *first = NULL;
    *scale = rgb_gray(1);
    for (size_t k = 0; k < home->source_count; k++) {
        const rsv_source *source = &home->source[k];
        if (source->kind != RSV_SOURCE_MATERIAL || !rsv_is_gathered(home->lights, source->index))
            continue;
        rsv_rgb own = settings->scale[k];
        if (first && (own.r != scale->r || own.g != scale->g || own.b != scale->b))
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "relight: lamps '%s' and '%s' fill much of the view and are stored together; scale "
                "both alike or solve anew",
                first, source->name);
        first = source->name;
        *scale = own;
    }
    return RSV_OK;
}

// ---- materials ----------------------------------------------------------------------------------

static rsv_status find_material(const rsv_scene *scene, const char *name, uint32_t *material)
{
    char known[512] = "";
    for (*material = 0; *material < scene->material_count; ++*material) {
        size_t used = strlen(known);
        if (strcmp(scene->material[*material].name, name) == 0) return RSV_OK;
        snprintf(known + used, sizeof known - used, "%s'%s'", *material ? ", " : "",
            scene->material[*material].name);
    }
    return rsv_fail(
        RSV_ERROR_ARGUMENT, "relight: there is no material '%s'; there are: %s", name, known);
}

static bool is_share(float value) { return value >= 0 && value <= 1; }

static rsv_status read_albedo(
    const rsv_scene *scene, const rsv_albedo_change *change, rsv_light_settings *wanted)
{
    uint32_t m;
    rsv_rgb c = change->base_color;
    rsv_status status = find_material(scene, change->material, &m);
    if (status != RSV_OK) return status;
    const rsv_material *material = &scene->material[m];
    if (!is_share(c.r) || !is_share(c.g) || !is_share(c.b))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "relight: the colour of material '%s' must be in 0 .. 1", change->material);
    bool plain = material->metallic == 0 && material->transmission == 0 && material->opacity == 1 &&
                 material->diffuse_transmission == 0 && !rsv_material_scatters_below(material);
    if (!plain)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "relight: the colour of material '%s' is part of the operator (metal, glass, ...); solve the scene again",
            change->material);
    wanted->base_color[m] = c;
    return RSV_OK;
}

// ---- all of it ----------------------------------------------------------------------------------

static void begin_as_home(const rsv_light_settings_home *home, rsv_light_settings *wanted)
{
    size_t sources = home->source_count;
    if (sources) memcpy(wanted->scale, home->settings->scale, sources * sizeof *wanted->scale);
    if (sources) memcpy(wanted->offset, home->settings->offset, sources * sizeof *wanted->offset);
    if (sources) memcpy(wanted->aim, home->settings->aim, sources * sizeof *wanted->aim);
    memcpy(wanted->base_color, home->settings->base_color,
        home->scene->material_count * sizeof *wanted->base_color);
    wanted->rotation = home->settings->rotation;
}

static rsv_status read_turn(
    const rsv_scene *scene, const rsv_relight_desc *desc, rsv_light_settings *wanted)
{
    if (!desc->turn) return RSV_OK;
    if (!scene->environment.pixels)
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: there is no environment to rotate");
    if (!isfinite(desc->rotation))
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: the rotation must be finite");
    wanted->rotation = desc->rotation;
    return RSV_OK;
}

rsv_status rsv_light_settings_read(
    const rsv_light_settings_home *home, const rsv_relight_desc *desc, rsv_light_settings *wanted)
{
    rsv_status status;
    rsv_rgb gathered;
    begin_as_home(home, wanted);
    for (size_t i = 0; i < desc->light_count; i++)
        RSV_TRY(read_scale(home, &desc->light[i], wanted));
    RSV_TRY(rsv_gathered_scale(home, wanted, &gathered));
    for (size_t i = 0; i < desc->move_count; i++)
        RSV_TRY(read_move(home, &desc->move[i], wanted));
    for (size_t i = 0; i < desc->aim_count; i++)
        RSV_TRY(read_aim(home, &desc->aim[i], wanted));
    for (size_t i = 0; i < desc->albedo_count; i++)
        RSV_TRY(read_albedo(home->scene, &desc->albedo[i], wanted));
    RSV_TRY(read_turn(home->scene, desc, wanted));
cleanup:
    return status;
}
