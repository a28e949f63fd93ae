#include "solo.h"

#include "../core/core.h"
#include "light_internal.h"

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
                list[(*count)++] = (rsv_source){ RSV_SOURCE_MATERIAL, m, view->material[m].name };
                break;
            }
    for (uint32_t l = 0; l < view->light_count; l++)
        list[(*count)++] = (rsv_source){ RSV_SOURCE_LIGHT, l, view->light[l].name };
    if (lights->environment)
        list[(*count)++] = (rsv_source){ RSV_SOURCE_SURROUNDINGS, 0, "environment" };
    return RSV_OK;
}

bool rsv_is_gathered(const rsv_lights *lights, uint32_t material)
{
    for (size_t g = 0; g < lights->group_count; g++)
        if (material_of(lights, &lights->group[g]) == material && lights->group[g].gathered)
            return true;
    return false;
}

/// Sources that are to be heard.
typedef struct soloists {
    const rsv_source *source;
    size_t count;
} soloists;

static bool plays(const soloists *s, rsv_source_kind kind, uint32_t index)
{
    for (size_t k = 0; k < s->count; k++)
        if (s->source[k].kind == kind && s->source[k].index == index) return true;
    return false;
}

/// Groups that are gathered take no part in what samples and shoots: neither shall the others.
static void mute_groups(rsv_lights *solo, const rsv_lights *all, const soloists *s)
{
    for (size_t g = 0; g < all->group_count; g++) {
        rsv_emitter_group *group = &solo->group[g];
        *group = all->group[g];
        group->muted = !plays(s, RSV_SOURCE_MATERIAL, material_of(all, group));
        group->gathered = group->gathered || group->muted;
    }
    solo->sampled_count = 0;
    for (size_t k = 0; k < all->sampled_count; k++)
        if (!solo->group[all->emitter[all->sampled[k]].group].gathered)
            solo->sampled[solo->sampled_count++] = all->sampled[k];
}

/// Distant lights stay ahead of the others.
static void mute_lights(rsv_lights *solo, const rsv_lights *all, const soloists *s)
{
    solo->distant_count = solo->punctual_count = 0;
    for (size_t k = 0; k < all->punctual_count; k++) {
        if (!plays(s, RSV_SOURCE_LIGHT, all->punctual[k])) continue;
        solo->punctual[solo->punctual_count++] = all->punctual[k];
        solo->distant_count += k < all->distant_count;
    }
}

rsv_status rsv_solo_create(
    const rsv_lights *all, const rsv_source *source, size_t count, rsv_lights **result)
{
    rsv_status status = RSV_OK;
    rsv_context *context = all->context;
    const soloists s = { source, count };
    rsv_lights *solo = rsv_alloc(context, 1, sizeof *solo);
    if (!solo) return RSV_ERROR_MEMORY;
    *solo = *all;
    solo->emitter_tree = solo->punctual_tree = NULL;
    solo->group = rsv_alloc(context, all->group_count, sizeof *solo->group);
    solo->sampled = rsv_alloc(context, all->sampled_count, sizeof *solo->sampled);
    solo->punctual = rsv_alloc(context, all->punctual_count, sizeof *solo->punctual);
    if (!solo->group || !solo->sampled || !solo->punctual) RSV_TRY(RSV_ERROR_MEMORY);
    mute_groups(solo, all, &s);
    mute_lights(solo, all, &s);
    if (!plays(&s, RSV_SOURCE_SURROUNDINGS, 0)) solo->environment = NULL;
    RSV_TRY(rsv_lights_plant_trees(solo));
    *result = solo;
    solo = NULL;
cleanup:
    rsv_solo_destroy(solo);
    return status;
}

void rsv_solo_destroy(rsv_lights *solo)
{
    if (!solo) return;
    rsv_free(solo->context, solo->group);
    rsv_free(solo->context, solo->sampled);
    rsv_free(solo->context, solo->punctual);
    rsv_light_tree_destroy(solo->emitter_tree);
    rsv_light_tree_destroy(solo->punctual_tree);
    rsv_free(solo->context, solo);
}

rsv_status rsv_lights_gather_like(rsv_lights *lights, const rsv_lights *like)
{
    for (size_t g = 0; g < lights->group_count; g++) {
        uint32_t triangle = lights->emitter[lights->group[g].first].triangle;
        uint32_t twin = like->triangle_emitter[triangle];
        if (twin != RSV_NONE)
            lights->group[g].gathered = like->group[like->emitter[twin].group].gathered;
    }
    lights->sampled_count = 0;
    for (size_t k = 0; k < lights->emitter_count; k++)
        if (!lights->group[lights->emitter[k].group].gathered)
            lights->sampled[lights->sampled_count++] = (uint32_t)k;
    return rsv_lights_plant_trees(lights);
}
