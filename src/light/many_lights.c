/// Emitters and punctual lights in light trees.
#include "light_internal.h"
#include "punctual_light.h"

#include "../core/core_internal.h"

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

static rsv_light_bounds punctual_bounds(const rsv_light *light)
{
    rsv_light_bounds bounds = { .low = light->position,
        .high = light->position,
        .axis = v3(0, 0, 1),
        .cos_spread = -1,
        .cos_emission = 0,
        .strength = f_max(rgb_luminance(light->intensity), 1e-30f) };
    if (light->kind == RSV_LIGHT_SPOT) {
        bounds.axis = light->direction;
        bounds.cos_spread = cosf(light->outer_cone_angle);
        bounds.cos_emission = COS_NARROWEST;
    }
    return bounds;
}

rsv_status rsv_lights_plant_trees(rsv_lights *lights)
{
    rsv_context *context = lights->context;
    rsv_status status = RSV_OK;
    size_t emitters = lights->sampled_count;
    size_t local = lights->punctual_count - lights->distant_count;
    rsv_light_tree_destroy(lights->emitter_tree);
    rsv_light_tree_destroy(lights->punctual_tree);
    lights->emitter_tree = lights->punctual_tree = NULL;
    if (emitters <= RSV_LOCAL_LIGHTS && local <= RSV_SUMMED_LIGHTS) return RSV_OK;
    rsv_light_bounds *bounds =
        rsv_alloc(context, emitters > local ? emitters : local, sizeof *bounds);
    if (!bounds) return RSV_ERROR_MEMORY;
    if (emitters > RSV_LOCAL_LIGHTS) {
        for (size_t i = 0; i < emitters; i++)
            bounds[i] = emitter_bounds(&lights->emitter[lights->sampled[i]]);
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
