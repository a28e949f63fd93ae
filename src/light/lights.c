/// The list of a scene's sources, grouped, with the table for selection by power.
#include "light_internal.h"

#include "../core/core_internal.h"
#include "../scene/material_at.h"

#include <stdlib.h>

/// Places on a textured emitter from which its mean radiance is estimated.
#define RADIANCE_POINTS 64

/// Where a surface does not cover, it does not shine.
static rsv_rgb emission_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width)
{
    rsv_material m = rsv_material_at(scene, triangle, u, v, width);
    return rgb_scale(m.emission, m.opacity);
}

/// Mean over the triangle, each place standing for its share of the area.
static rsv_rgb mean_radiance(const rsv_scene_view *scene, uint32_t triangle, float area)
{
    rsv_rgb sum = rgb_gray(0);
    float width = sqrtf(area / RADIANCE_POINTS);
    for (uint32_t k = 0; k < RADIANCE_POINTS; k++) {
        float x, y, u, v;
        rsv_sobol_2d(k, 0, &x, &y);
        rsv_square_to_triangle(x, y, &u, &v);
        sum = rgb_add(sum, emission_at(scene, triangle, u, v, width));
    }
    return rgb_scale(sum, 1.0f / RADIANCE_POINTS);
}

rsv_rgb rsv_emitter_radiance(const rsv_lights *lights, uint32_t emitter, float u, float v)
{
    const rsv_emitter *e = &lights->emitter[emitter];
    if (!e->varies) return e->radiance;
    return emission_at(lights->scene, e->triangle, u, v, 0);
}

static bool emission_varies(const rsv_material *m)
{
    if (m->alpha_cutoff == 0 && m->opacity < 1) return true;
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->textures[i].role == RSV_TEXTURE_EMISSION ||
            m->textures[i].role == RSV_TEXTURE_OPACITY)
            return true;
    return false;
}

static rsv_emitter emitter_from_triangle(
    const rsv_scene_view *scene, const rsv_bsdf *bsdf, uint32_t triangle)
{
    const uint32_t *index = scene->triangle[triangle];
    const rsv_bsdf *material = &bsdf[scene->triangle_material[triangle]];
    rsv_emitter emitter = {
        .radiance = material->emission, .triangle = triangle, .double_sided = material->double_sided
    };
    for (int i = 0; i < 3; i++)
        emitter.corner[i] = scene->position[index[i]];
    rsv_vec3 cross = v3_cross(
        v3_sub(emitter.corner[1], emitter.corner[0]), v3_sub(emitter.corner[2], emitter.corner[0]));
    emitter.normal = v3_normalize(cross);
    emitter.area = 0.5f * v3_length(cross);
    emitter.varies = emission_varies(&scene->material[scene->triangle_material[triangle]]);
    if (emitter.varies) emitter.radiance = mean_radiance(scene, triangle, emitter.area);
    return emitter;
}

double rsv_emitter_power(const rsv_emitter *emitter)
{
    int sides = emitter->double_sided ? 2 : 1;
    return sides * (double)RSV_PI * rgb_luminance(emitter->radiance) * emitter->area;
}

/// What orders the emitters: those of one group (object, material) side by side.
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

/// Keys of the emissive triangles, in order.
static rsv_status collect_emitters(rsv_context *context, const rsv_scene_view *scene,
    const rsv_bsdf *bsdf, emitter_key **keys, size_t *count)
{
    *count = 0;
    for (size_t i = 0; i < scene->triangle_count; i++)
        *count += is_emissive(&bsdf[scene->triangle_material[i]]);
    emitter_key *key = *keys = rsv_alloc(context, *count, sizeof *key);
    if (!key) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < scene->triangle_count; i++)
        if (is_emissive(&bsdf[scene->triangle_material[i]]))
            *key++ = (emitter_key){ scene->triangle_object[i], scene->triangle_material[i], i };
    qsort(*keys, *count, sizeof **keys, compare_keys);
    return RSV_OK;
}

static bool same_group(const emitter_key *a, const emitter_key *b)
{
    return a->object == b->object && a->material == b->material;
}

static void fill_emitters(rsv_lights *lights, const rsv_bsdf *bsdf, const emitter_key *keys)
{
    for (size_t i = 0; i < lights->emitter_count; i++) {
        if (i == 0 || !same_group(&keys[i], &keys[i - 1]))
            lights->group[lights->group_count++].first = (uint32_t)i;
        rsv_emitter *emitter = &lights->emitter[i];
        *emitter = emitter_from_triangle(lights->scene, bsdf, keys[i].triangle);
        emitter->group = (uint32_t)lights->group_count - 1;
        lights->triangle_emitter[emitter->triangle] = (uint32_t)i;
        rsv_emitter_group *group = &lights->group[emitter->group];
        group->count++;
        group->area += emitter->area;
        group->power += rsv_emitter_power(emitter);
    }
}

/// Lists the emitters of groups that are not gathered.
static void list_sampled(rsv_lights *lights)
{
    for (size_t i = 0; i < lights->emitter_count; i++)
        if (!lights->group[lights->emitter[i].group].gathered)
            lights->sampled[lights->sampled_count++] = (uint32_t)i;
}

static bool is_distant(const rsv_light *light) { return light->kind == RSV_LIGHT_DIRECTIONAL; }

/// Lists the punctual lights that are not black, distant ones first.
static void list_punctual(rsv_lights *lights)
{
    const rsv_scene_view *scene = lights->scene;
    for (int distant = 1; distant >= 0; distant--) {
        for (size_t i = 0; i < scene->light_count; i++)
            if (is_distant(&scene->light[i]) == distant && !rgb_is_black(scene->light[i].intensity))
                lights->punctual[lights->punctual_count++] = (uint32_t)i;
        if (distant) lights->distant_count = lights->punctual_count;
    }
}

static void warn_if_dark(const rsv_lights *lights)
{
    bool lit = lights->emitter_count > 0 || lights->punctual_count > 0;
    lit = lit || (lights->environment && lights->environment->sampler.flux > 0);
    if (!lit)
        rsv_log(lights->context, RSV_LOG_WARNING,
            "the scene has no light (emissive material, punctual light or environment): pictures "
            "will be black");
}

rsv_status rsv_lights_create(const rsv_scene *scene, const rsv_bsdf *bsdf, rsv_lights **lights)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    emitter_key *keys = NULL;
    size_t count;
    rsv_lights *created = rsv_alloc(context, 1, sizeof *created);
    if (!created) return RSV_ERROR_MEMORY;
    created->context = context;
    created->scene = view;
    RSV_TRY(collect_emitters(context, view, bsdf, &keys, &count));
    created->emitter_count = count;
    created->emitter = rsv_alloc(context, count, sizeof *created->emitter);
    created->group = rsv_alloc(context, count, sizeof *created->group);
    created->triangle_emitter =
        rsv_alloc(context, view->triangle_count, sizeof *created->triangle_emitter);
    created->punctual = rsv_alloc(context, view->light_count, sizeof *created->punctual);
    created->sampled = rsv_alloc(context, count, sizeof *created->sampled);
    bool complete = created->emitter && created->group && created->triangle_emitter &&
                    created->punctual && created->sampled;
    RSV_TRY(complete ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t i = 0; i < view->triangle_count; i++)
        created->triangle_emitter[i] = RSV_NONE;
    fill_emitters(created, bsdf, keys);
    rsv_lights_choose_gathered(created);
    list_sampled(created);
    list_punctual(created);
    RSV_TRY(rsv_lights_plant_trees(created));
    RSV_TRY(rsv_environment_light_create(scene, &created->environment));
    warn_if_dark(created);
    *lights = created;
    created = NULL;
cleanup:
    rsv_free(context, keys);
    rsv_lights_destroy(created);
    return status;
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
