/// The list of a scene's sources, grouped, with the table for selection by power.
#include "lights_internal.h"

#include "../core/core.h"
#include "../scene/punctual.h"
#include "../scene/twins.h"
#include "emitter_cells.h"

#include <stdlib.h>

/// Sort key of emitters: emitters of one group (object, material) are adjacent.
typedef struct emitter_key {
    uint32_t object, material, triangle;
} emitter_key;

static int compare_ids(uint32_t a, uint32_t b) { return (a > b) - (a < b); }

static int compare_keys(const void *left, const void *right)
{
    const emitter_key *a = left, *b = right;
    int order = compare_ids(a->object, b->object);
    if (order == 0) order = compare_ids(a->material, b->material);
    return order ? order : compare_ids(a->triangle, b->triangle);
}

static bool is_emissive(const rsv_bsdf *bsdf)
{
    return bsdf->emissive && !bsdf->unlit && !rgb_is_black(bsdf->emission);
}

/// False for faces hidden by another face in the same place, which would otherwise emit twice.
static bool shines(const rsv_scene_view *scene, const rsv_bsdf *bsdf, size_t triangle)
{
    return is_emissive(&bsdf[scene->triangle_material[triangle]]) &&
           !rsv_twins_hide(scene, (uint32_t)triangle, false);
}

/// Keys of the emissive triangles, in order.
static rsv_status collect_triangles(rsv_context *context, const rsv_scene_view *scene,
    const rsv_bsdf *bsdf, emitter_key **keys, size_t *count)
{
    *count = 0;
    for (size_t i = 0; i < scene->triangle_count; i++)
        *count += shines(scene, bsdf, i);
    emitter_key *key = *keys = rsv_alloc(context, *count, sizeof *key);
    if (!key) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < scene->triangle_count; i++)
        if (shines(scene, bsdf, i))
            *key++ = (emitter_key){ scene->triangle_object[i], scene->triangle_material[i], i };
    qsort(*keys, *count, sizeof **keys, compare_keys);
    return RSV_OK;
}

static bool same_group(const emitter_key *a, const emitter_key *b)
{
    return a->object == b->object && a->material == b->material;
}

static void add_emitter(rsv_lights *lights, const rsv_emitter *emitter)
{
    rsv_emitter_group *group = &lights->group[emitter->group];
    group->count++;
    group->area += emitter->area;
    group->power += rsv_emitter_power(emitter);
    lights->emitter[lights->emitter_count++] = *emitter;
}

/// The emitters of one triangle.
/// @param cells those of the triangle and of others behind it @return how many are its own
static uint32_t fill_triangle(rsv_lights *lights, const rsv_bsdf *bsdf, const emitter_key *key,
    const rsv_emitter_cell *cells, size_t left)
{
    uint32_t count = 1;
    while (count < left && cells[count].rank == cells->rank)
        count++;
    lights->triangle_emitter[key->triangle] = (uint32_t)lights->emitter_count;
    for (uint32_t k = 0; k < count; k++) {
        rsv_emission_spread spread;
        rsv_emitter emitter = rsv_emitter_create(
            lights->scene, bsdf, key->triangle, cells[k].level, cells[k].place, &spread);
        emitter.cells = count;
        emitter.group = (uint32_t)lights->group_count - 1;
        add_emitter(lights, &emitter);
    }
    return count;
}

/// @param cells [cell_count] from rsv_divide_emitters
static void fill_emitters(rsv_lights *lights, const rsv_bsdf *bsdf, const emitter_key *keys,
    const rsv_emitter_cell *cells, size_t cell_count)
{
    for (size_t k = 0; k < cell_count;) {
        uint32_t i = cells[k].rank;
        if (i == 0 || !same_group(&keys[i], &keys[i - 1]))
            lights->group[lights->group_count++].first = (uint32_t)lights->emitter_count;
        k += fill_triangle(lights, bsdf, &keys[i], cells + k, cell_count - k);
    }
}

/// @param keys [count] in the order of ranks
static rsv_status divide(const rsv_scene *scene, const rsv_bsdf *bsdf, const emitter_key *keys,
    size_t count, rsv_emitter_cell **cells, size_t *cell_count)
{
    rsv_context *context = rsv_scene_get_context(scene);
    uint32_t *triangle = rsv_alloc(context, count, sizeof *triangle);
    if (!triangle) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++)
        triangle[k] = keys[k].triangle;
    rsv_status status = rsv_divide_emitters(scene, bsdf, triangle, count, cells, cell_count);
    rsv_free(context, triangle);
    return status;
}

/// Lists the emitters of groups that are not gathered.
static void list_sampled(rsv_lights *lights)
{
    for (size_t i = 0; i < lights->emitter_count; i++)
        if (!lights->group[lights->emitter[i].group].gathered)
            lights->sampled[lights->sampled_count++] = (uint32_t)i;
}

/// Lists the punctual lights that are not black, distant ones first.
static void list_punctual(rsv_lights *lights)
{
    const rsv_scene_view *scene = lights->scene;
    lights->punctual_count = 0;
    lights->extended = false;
    for (int distant = 1; distant >= 0; distant--) {
        for (size_t i = 0; i < scene->light_count; i++)
            if (rsv_punctual_is_distant(&scene->light[i]) == distant &&
                !rgb_is_black(scene->light[i].intensity))
                lights->punctual[lights->punctual_count++] = (uint32_t)i;
        if (distant) lights->distant_count = lights->punctual_count;
    }
    for (size_t k = 0; k < lights->punctual_count; k++)
        lights->extended |= rsv_punctual_is_extended(&scene->light[lights->punctual[k]]);
}

void rsv_lights_warn_if_dark(const rsv_lights *lights)
{
    bool lit = lights->emitter_count > 0 || lights->punctual_count > 0;
    lit = lit || (lights->environment && !rgb_is_black(rsv_sky_flux(&lights->environment->whole)));
    if (!lit)
        rsv_log(lights->context, RSV_LOG_WARNING,
            "the scene has no light (emissive material, punctual light or environment): pictures "
            "will be black; `--env sky` or `--env white` lights any scene");
}

rsv_status rsv_lights_create(const rsv_scene *scene, const rsv_bsdf *bsdf, rsv_lights **lights)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    emitter_key *keys = NULL;
    rsv_emitter_cell *cells = NULL;
    size_t count, emitters;
    rsv_lights *created = rsv_alloc(context, 1, sizeof *created);
    if (!created) return RSV_ERROR_MEMORY;
    created->context = context;
    created->scene = view;
    RSV_TRY(collect_triangles(context, view, bsdf, &keys, &count));
    RSV_TRY(divide(scene, bsdf, keys, count, &cells, &emitters));
    created->emitter = rsv_alloc(context, emitters, sizeof *created->emitter);
    created->group = rsv_alloc(context, count, sizeof *created->group);
    created->triangle_emitter =
        rsv_alloc(context, view->triangle_count, sizeof *created->triangle_emitter);
    created->punctual = rsv_alloc(context, view->light_count, sizeof *created->punctual);
    created->sampled = rsv_alloc(context, emitters, sizeof *created->sampled);
    bool complete = created->emitter && created->group && created->triangle_emitter &&
                    created->punctual && created->sampled;
    RSV_TRY(complete ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t i = 0; i < view->triangle_count; i++)
        created->triangle_emitter[i] = RSV_NONE;
    fill_emitters(created, bsdf, keys, cells, emitters);
    rsv_lights_choose_gathered(created);
    list_sampled(created);
    list_punctual(created);
    RSV_TRY(rsv_lights_plant_trees(created));
    RSV_TRY(rsv_environment_light_create(scene, &created->environment));
    *lights = created;
    created = NULL;
cleanup:
    rsv_free(context, keys);
    rsv_free(context, cells);
    rsv_lights_destroy(created);
    return status;
}

rsv_status rsv_lights_follow(rsv_lights *lights)
{
    for (size_t i = 0; i < lights->emitter_count; i++)
        rsv_emitter_follow(lights->scene, &lights->emitter[i]);
    return rsv_lights_plant_trees(lights);
}

static uint32_t material_of(const rsv_lights *lights, const rsv_emitter_group *group)
{
    return lights->scene->triangle_material[lights->emitter[group->first].triangle];
}

/// Whether the materials that emit are those of the groups.
static bool same_materials_emit(const rsv_lights *lights, const rsv_bsdf *bsdf)
{
    for (size_t g = 0; g < lights->group_count; g++)
        if (!is_emissive(&bsdf[material_of(lights, &lights->group[g])])) return false;
    for (uint32_t m = 0; m < lights->scene->material_count; m++) {
        size_t g = 0;
        if (!is_emissive(&bsdf[m])) continue;
        while (g < lights->group_count && material_of(lights, &lights->group[g]) != m)
            g++;
        if (g == lights->group_count) return false;
    }
    return true;
}

rsv_status rsv_lights_follow_strengths(rsv_lights *lights, const rsv_bsdf *bsdf, bool *followed)
{
    *followed = same_materials_emit(lights, bsdf);
    if (!*followed) return RSV_OK;
    for (size_t g = 0; g < lights->group_count; g++) {
        rsv_emitter_group *group = &lights->group[g];
        const rsv_bsdf *material = &bsdf[material_of(lights, group)];
        group->power = 0;
        for (size_t i = group->first; i < group->first + group->count; i++) {
            rsv_emitter_set_strength(lights->scene, material, &lights->emitter[i]);
            group->power += rsv_emitter_power(&lights->emitter[i]);
        }
    }
    list_punctual(lights);
    return rsv_lights_plant_trees(lights);
}

void rsv_lights_destroy(rsv_lights *lights)
{
    if (!lights) return;
    rsv_context *context = lights->context;
    rsv_environment_light_destroy(lights->environment);
    rsv_free(context, lights->emitter);
    rsv_free(context, lights->group);
    rsv_free(context, lights->triangle_emitter);
    rsv_free(context, lights->punctual);
    rsv_light_tree_destroy(lights->emitter_tree);
    rsv_light_tree_destroy(lights->punctual_tree);
    rsv_free(context, lights->sampled);
    rsv_free(context, lights);
}

bool rsv_lights_any_sampled(const rsv_lights *lights)
{
    return lights->sampled_count > 0 || rsv_environment_light_is_sampled(lights->environment);
}
