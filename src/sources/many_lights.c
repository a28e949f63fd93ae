/// Emitters and punctual lights in light trees.
#include "lights_internal.h"
#include "punctual_light.h"

#include "../core/core.h"

#include <stdlib.h>
#include <string.h>

/// Narrow bounds of emission still have a width, or rounding would empty them.
#define COS_NARROWEST 0.99995f

static rsv_light_bounds emitter_bounds(const rsv_emitter *e)
{
    return (rsv_light_bounds){ .low = v3_min(e->corner[0], v3_min(e->corner[1], e->corner[2])),
        .high = v3_max(e->corner[0], v3_max(e->corner[1], e->corner[2])),
        .axis = e->normal,
        .cos_spread = e->double_sided ? -1 : 1,
        .cos_emission = 0,
        .strength = f_max(rgb_luminance(e->radiance) * e->area, 1e-30f) };
}

static rsv_light_bounds punctual_bounds(const rsv_punctual_light *light)
{
    float radius = rsv_punctual_radius(light) + RSV_LUMINAIRE_GAP;
    bool is_point = light->kind != RSV_PUNCTUAL_LUMINAIRE;
    rsv_vec3 reach = is_point ? v3(0, 0, 0) : v3(radius, radius, radius);
    rsv_light_bounds bounds = { .low = v3_sub(light->position, reach),
        .high = v3_add(light->position, reach),
        .axis = v3(0, 0, 1),
        .cos_spread = -1,
        .cos_emission = 0,
        .strength = f_max(rgb_luminance(light->intensity), 1e-30f) };
    if (rsv_punctual_has_cone(light)) {
        bounds.axis = light->direction;
        bounds.cos_spread = cosf(light->outer_cone_angle);
        bounds.cos_emission = COS_NARROWEST;
    }
    return bounds;
}

/// Share of the light that the emitters which are weighed one by one give together, where there are too many to weigh
/// all.
#define MOST_OF_THE_LIGHT 0.9

static double strength(const rsv_lights *lights, uint32_t emitter)
{
    return rsv_emitter_power(&lights->emitter[emitter]);
}

/// The strongest emitters, strongest first; those as strong in the order of `sampled`.
/// @return how many: RSV_LOCAL_LIGHTS at most
static size_t find_strongest(const rsv_lights *lights, uint32_t strongest[RSV_LOCAL_LIGHTS])
{
    size_t count = 0;
    for (size_t i = 0; i < lights->sampled_count; i++) {
        uint32_t emitter = lights->sampled[i];
        double own = strength(lights, emitter);
        if (count == RSV_LOCAL_LIGHTS && own <= strength(lights, strongest[count - 1])) continue;
        size_t at = count < RSV_LOCAL_LIGHTS ? count++ : count - 1;
        for (; at > 0 && strength(lights, strongest[at - 1]) < own; at--)
            strongest[at] = strongest[at - 1];
        strongest[at] = emitter;
    }
    return count;
}

/// The fewest emitters that give most of the light, or all that give any if these are few. @return how many; 0 = too
/// many
static size_t find_most_of_the_light(const rsv_lights *lights, uint32_t few[RSV_LOCAL_LIGHTS])
{
    double total = 0, sum = 0;
    size_t shining = 0;
    for (size_t i = 0; i < lights->sampled_count; i++) {
        double own = strength(lights, lights->sampled[i]);
        total += own;
        shining += own > 0;
    }
    if (shining == 0) return 0;
    size_t count = find_strongest(lights, few);
    if (shining <= RSV_LOCAL_LIGHTS) return shining;
    for (size_t k = 0; k < count; k++) {
        sum += strength(lights, few[k]);
        if (sum >= MOST_OF_THE_LIGHT * total) return k + 1;
    }
    return 0;
}

static int compare_indices(const void *a, const void *b)
{
    uint32_t left = *(const uint32_t *)a, right = *(const uint32_t *)b;
    return left < right ? -1 : left > right;
}

/// Puts the emitters that are weighed first in `sampled`; both parts ascend. Dark ones, such as cells of a texture next
/// to a bright spot, are not worth weighing.
static void choose_weighed(rsv_lights *lights)
{
    lights->weighed_count = 0;
    if (lights->sampled_count == 0) return;
    qsort(lights->sampled, lights->sampled_count, sizeof *lights->sampled, compare_indices);
    uint32_t few[RSV_LOCAL_LIGHTS];
    size_t count = find_most_of_the_light(lights, few), left = count;
    lights->weighed_count = count;
    if (count == 0) return;
    qsort(few, count, sizeof *few, compare_indices);
    // from the end on, all others move up by as many of the few as came behind them
    for (size_t i = lights->sampled_count; i-- > 0;) {
        if (left > 0 && lights->sampled[i] == few[left - 1])
            left--;
        else
            lights->sampled[i + count - left] = lights->sampled[i];
    }
    memcpy(lights->sampled, few, count * sizeof *few);
}

/// Of those that are not weighed.
static bool any_shines(const rsv_lights *lights)
{
    for (size_t i = lights->weighed_count; i < lights->sampled_count; i++)
        if (strength(lights, lights->sampled[i]) > 0) return true;
    return false;
}

rsv_status rsv_lights_plant_trees(rsv_lights *lights)
{
    rsv_context *context = lights->context;
    rsv_status status = RSV_OK;
    choose_weighed(lights);
    size_t emitters = any_shines(lights) ? lights->sampled_count - lights->weighed_count : 0;
    size_t local = lights->punctual_count - lights->distant_count;
    rsv_light_tree_destroy(lights->emitter_tree);
    rsv_light_tree_destroy(lights->punctual_tree);
    lights->emitter_tree = lights->punctual_tree = NULL;
    if (emitters == 0 && local <= RSV_SUMMED_LIGHTS) return RSV_OK;
    rsv_light_bounds *bounds =
        rsv_alloc(context, emitters > local ? emitters : local, sizeof *bounds);
    if (!bounds) return RSV_ERROR_MEMORY;
    if (emitters > 0) {
        const uint32_t *index = lights->sampled + lights->weighed_count;
        for (size_t i = 0; i < emitters; i++)
            bounds[i] = emitter_bounds(&lights->emitter[index[i]]);
        RSV_TRY(rsv_light_tree_create(context, bounds, emitters, &lights->emitter_tree));
    }
    if (local > RSV_SUMMED_LIGHTS) {
        const uint32_t *index = lights->punctual + lights->distant_count;
        for (size_t i = 0; i < local; i++)
            bounds[i] = punctual_bounds(&lights->scene->light[index[i]]);
        RSV_TRY(rsv_light_tree_create(context, bounds, local, &lights->punctual_tree));
    }
cleanup:
    rsv_free(context, bounds);
    return status;
}
