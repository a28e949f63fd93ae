#include "light_settings.h"

#include "../scene/placed_luminaire.h"
#include "../scene/punctual.h"
#include "../scene/scene.h"
#include "../subsurface/scatter_profile.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
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

/// Which sources are meant.
typedef struct selection {
    const char *name;
    bool own; ///< a source has this name; otherwise it may be that of a node that placed a light
    bool pattern;  ///< no source and no node has this name; `*` in it matches any text
    size_t number; ///< of the only source that is meant; SIZE_MAX = those of the name
} selection;

/// Whether an earlier source has the same name, and the same node.
static bool is_repeated(const rsv_light_settings_home *home, size_t k)
{
    const rsv_source *source = &home->source[k];
    for (size_t j = 0; j < k; j++) {
        const char *node = home->source[j].node;
        bool same_node =
            node && source->node ? strcmp(node, source->node) == 0 : node == source->node;
        if (same_node && strcmp(home->source[j].name, source->name) == 0) return true;
    }
    return false;
}

static rsv_status fail_unknown_light(const rsv_light_settings_home *home, const selection *s)
{
    char known[512] = "";
    for (size_t k = 0; k < home->source_count; k++) {
        if (is_repeated(home, k)) continue;
        const rsv_source *source = &home->source[k];
        bool placed = source->node && strcmp(source->node, source->name) != 0;
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, placed ? "%s'%s' of node '%s'" : "%s'%s'",
            k ? ", " : "", source->name, placed ? source->node : "");
    }
    return rsv_fail(RSV_ERROR_ARGUMENT, "relight: there is no light '%s'; there are: %s", s->name,
        *known ? known : "none");
}

/// @param own whether to look at the sources' own names, or at those of nodes
static bool is_known(const rsv_light_settings_home *home, const char *name, bool own)
{
    for (size_t k = 0; k < home->source_count; k++) {
        const char *called = own ? home->source[k].name : home->source[k].node;
        if (called && strcmp(called, name) == 0) return true;
    }
    return false;
}

/// The number in "#3"; SIZE_MAX = it is none.
static size_t number_in(const char *name)
{
    size_t digits = name[0] == '#' ? strspn(name + 1, "0123456789") : 0;
    bool whole = digits > 0 && digits < 10 && !name[1 + digits];
    return whole ? (size_t)strtoul(name + 1, NULL, 10) : SIZE_MAX;
}

static selection select_sources(const rsv_light_settings_home *home, const char *name)
{
    bool own = is_known(home, name, true), called = own || is_known(home, name, false);
    return (selection){ name, own, !called, called ? SIZE_MAX : number_in(name) };
}

static bool is_meant(const rsv_light_settings_home *home, const selection *s, size_t k)
{
    if (s->number != SIZE_MAX) return k == s->number;
    if (s->pattern)
        return rsv_name_is_meant(s->name, home->source[k].name) ||
               rsv_name_is_meant(s->name, home->source[k].node);
    const char *called = s->own ? home->source[k].name : home->source[k].node;
    return called && strcmp(called, s->name) == 0;
}

static bool is_scale(float value) { return value >= 0 && value <= LARGEST_SCALE; }

static rsv_status read_scale(
    const rsv_light_settings_home *home, const rsv_light_scale *light, rsv_light_settings *wanted)
{
    const selection meant = select_sources(home, light->name);
    bool known = false, gray = light->scale.r == light->scale.g && light->scale.g == light->scale.b;
    if (!is_scale(light->scale.r) || !is_scale(light->scale.g) || !is_scale(light->scale.b))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "relight: the factors of light '%s' must be from 0 to %g", meant.name, LARGEST_SCALE);
    for (size_t k = 0; k < home->source_count; k++) {
        if (!is_meant(home, &meant, k)) continue;
        if (home->source[k].kind == RSV_SOURCE_SURROUNDINGS && !gray)
            return rsv_fail(
                RSV_ERROR_UNSUPPORTED, "relight: the environment takes one factor for all colours");
        wanted->scale[k] = light->scale;
        known = true;
    }
    return known ? RSV_OK : fail_unknown_light(home, &meant);
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
            "relight: lamp '%s' fills much of the view, so the operator depends on its place; move it "
            "in the scene and solve the scene again",
            source->name);
    return RSV_OK;
}

static rsv_status read_move(
    const rsv_light_settings_home *home, const rsv_light_move *move, rsv_light_settings *wanted)
{
    const selection meant = select_sources(home, move->name);
    bool known = false;
    rsv_vec3 offset = move->offset;
    if (!isfinite(offset.x + offset.y + offset.z) || v3_max_abs(offset) > LARGEST_OFFSET)
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: light '%s' cannot be moved by more than %g m",
            meant.name, LARGEST_OFFSET);
    for (size_t k = 0; k < home->source_count; k++) {
        if (!is_meant(home, &meant, k)) continue;
        rsv_status status = check_movable(home, &home->source[k]);
        if (status != RSV_OK) return status;
        wanted->offset[k] = offset;
        known = true;
    }
    return known ? RSV_OK : fail_unknown_light(home, &meant);
}

static bool can_turn(const rsv_light_settings_home *home, const rsv_source *source)
{
    return source->kind == RSV_SOURCE_LIGHT &&
           rsv_punctual_has_direction(&home->scene->light[source->index]);
}

static rsv_status read_aim(
    const rsv_light_settings_home *home, const rsv_light_aim *aim, rsv_light_settings *wanted)
{
    const selection meant = select_sources(home, aim->name);
    bool known = false;
    float length = v3_length(aim->direction);
    if (!(length > 0) || !isfinite(length))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "relight: light '%s' cannot be turned: no direction", meant.name);
    for (size_t k = 0; k < home->source_count; k++) {
        if (!is_meant(home, &meant, k)) continue;
        if (!can_turn(home, &home->source[k]))
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "relight: light '%s' cannot be turned: only spot lights, luminaires and "
                "directional lights can",
                meant.name);
        wanted->aim[k] = v3_scale(aim->direction, 1 / length);
        known = true;
    }
    return known ? RSV_OK : fail_unknown_light(home, &meant);
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
                "relight: lamps '%s' and '%s' fill much of the view and are stored together; "
                "scale both by the same factor, or solve the scene again",
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
