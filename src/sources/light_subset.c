#include "light_subset.h"

#include "../core/core.h"
#include "lights_internal.h"

#include <string.h>

static uint32_t material_of(const rsv_lights *lights, const rsv_emitter_group *group)
{
    return lights->scene->triangle_material[lights->emitter[group->first].triangle];
}

rsv_status rsv_list_sources(const rsv_lights *lights, rsv_source **sources, size_t *count)
{
    const rsv_scene_view *view = lights->scene;
    size_t most = view->material_count + view->light_count + 1;
    rsv_source *list = *sources = rsv_alloc(lights->context, most, sizeof *list);
    if (!list) return RSV_ERROR_MEMORY;
    *count = 0;
    for (uint32_t m = 0; m < view->material_count; m++)
        for (size_t g = 0; g < lights->group_count; g++)
            if (material_of(lights, &lights->group[g]) == m) {
                list[(*count)++] =
                    (rsv_source){ RSV_SOURCE_MATERIAL, m, view->material[m].name, NULL };
                break;
            }
    for (uint32_t l = 0; l < view->light_count; l++)
        list[(*count)++] =
            (rsv_source){ RSV_SOURCE_LIGHT, l, view->light[l].name, view->light_node[l] };
    if (lights->environment)
        list[(*count)++] = (rsv_source){ RSV_SOURCE_SURROUNDINGS, 0, "environment", NULL };
    return RSV_OK;
}

bool rsv_is_gathered(const rsv_lights *lights, uint32_t material)
{
    for (size_t g = 0; g < lights->group_count; g++)
        if (material_of(lights, &lights->group[g]) == material && lights->group[g].gathered)
            return true;
    return false;
}

/// Sources that are to shine.
double rsv_emission_share(const rsv_lights *lights, uint32_t material)
{
    double share = 0;
    for (size_t g = 0; g < lights->group_count; g++)
        if (material_of(lights, &lights->group[g]) == material) share += lights->group[g].share;
    return share;
}

typedef struct chosen_sources {
    const rsv_source *source;
    size_t count;
} chosen_sources;

static bool is_chosen(const chosen_sources *s, rsv_source_kind kind, uint32_t index)
{
    for (size_t k = 0; k < s->count; k++)
        if (s->source[k].kind == kind && s->source[k].index == index) return true;
    return false;
}

/// Gathered groups are neither sampled nor traced from; other groups must not be either.
static void mute_groups(rsv_lights *subset, const rsv_lights *all, const chosen_sources *s)
{
    for (size_t g = 0; g < all->group_count; g++) {
        rsv_emitter_group *group = &subset->group[g];
        *group = all->group[g];
        group->muted = !is_chosen(s, RSV_SOURCE_MATERIAL, material_of(all, group));
        group->gathered = group->gathered || group->muted;
    }
    subset->sampled_count = 0;
    for (size_t k = 0; k < all->sampled_count; k++)
        if (!subset->group[all->emitter[all->sampled[k]].group].gathered)
            subset->sampled[subset->sampled_count++] = all->sampled[k];
}

/// Distant lights stay ahead of the others.
static void mute_lights(rsv_lights *subset, const rsv_lights *all, const chosen_sources *s)
{
    subset->distant_count = subset->punctual_count = 0;
    for (size_t k = 0; k < all->punctual_count; k++) {
        if (!is_chosen(s, RSV_SOURCE_LIGHT, all->punctual[k])) continue;
        subset->punctual[subset->punctual_count++] = all->punctual[k];
        subset->distant_count += k < all->distant_count;
    }
}

rsv_status rsv_light_subset_create(
    const rsv_lights *all, const rsv_source *source, size_t count, rsv_lights **result)
{
    rsv_status status = RSV_OK;
    rsv_context *context = all->context;
    const chosen_sources s = { source, count };
    rsv_lights *subset = rsv_alloc(context, 1, sizeof *subset);
    if (!subset) return RSV_ERROR_MEMORY;
    *subset = *all;
    subset->emitter_tree = subset->punctual_tree = NULL;
    subset->group = rsv_alloc(context, all->group_count, sizeof *subset->group);
    subset->sampled = rsv_alloc(context, all->sampled_count, sizeof *subset->sampled);
    subset->punctual = rsv_alloc(context, all->punctual_count, sizeof *subset->punctual);
    if (!subset->group || !subset->sampled || !subset->punctual) RSV_TRY(RSV_ERROR_MEMORY);
    mute_groups(subset, all, &s);
    mute_lights(subset, all, &s);
    if (!is_chosen(&s, RSV_SOURCE_SURROUNDINGS, 0)) subset->environment = NULL;
    RSV_TRY(rsv_lights_plant_trees(subset));
    *result = subset;
    subset = NULL;
cleanup:
    rsv_light_subset_destroy(subset);
    return status;
}

void rsv_light_subset_destroy(rsv_lights *subset)
{
    if (!subset) return;
    rsv_free(subset->context, subset->group);
    rsv_free(subset->context, subset->sampled);
    rsv_free(subset->context, subset->punctual);
    rsv_light_tree_destroy(subset->emitter_tree);
    rsv_light_tree_destroy(subset->punctual_tree);
    rsv_free(subset->context, subset);
}

/// Emitters of groups that are not gathered.
static rsv_status list_sampled(rsv_lights *lights)
{
    lights->sampled_count = 0;
    for (size_t k = 0; k < lights->emitter_count; k++)
        if (!lights->group[lights->emitter[k].group].gathered)
            lights->sampled[lights->sampled_count++] = (uint32_t)k;
    return rsv_lights_plant_trees(lights);
}

rsv_status rsv_lights_gather_like(rsv_lights *lights, const rsv_lights *like)
{
    for (size_t g = 0; g < lights->group_count; g++) {
        uint32_t triangle = lights->emitter[lights->group[g].first].triangle;
        uint32_t twin = like->triangle_emitter[triangle];
        if (twin != RSV_NONE)
            lights->group[g].gathered = like->group[like->emitter[twin].group].gathered;
    }
    return list_sampled(lights);
}

rsv_status rsv_lights_gather_sources(
    rsv_lights *lights, const rsv_source *source, const bool *gathered, size_t count)
{
    for (size_t k = 0; k < count; k++)
        for (size_t g = 0; g < lights->group_count; g++)
            if (source[k].kind == RSV_SOURCE_MATERIAL &&
                material_of(lights, &lights->group[g]) == source[k].index)
                lights->group[g].gathered = gathered[k];
    return list_sampled(lights);
}
