#include "material_keys.h"

#include "../core/key.h"
#include "../core/parallel.h"
#include "../scene/texture.h"
#include "element_keys.h"

/// Textures that change how light enters a surface; by a normal map all surfaces receive.
static bool counts(rsv_texture_role role, const rsv_bsdf *b)
{
    if (role == RSV_TEXTURE_NORMAL) return true;
    return !b->lambert && role != RSV_TEXTURE_BASE_COLOR && role != RSV_TEXTURE_OPACITY &&
           role != RSV_TEXTURE_EMISSION;
}

static uint64_t add_numbers(uint64_t key, const float *number, size_t count)
{
    return rsv_key_add_bytes(key, number, count * sizeof *number);
}

static uint64_t add_color(uint64_t key, rsv_rgb c) { return add_numbers(key, &c.r, 3); }

/// Followed by all texels, and how they are looked up.
static uint64_t add_texture(uint64_t key, const rsv_texture *t)
{
    const rsv_texture_level *finest = &t->level[0];
    size_t numbers = (size_t)finest->width * finest->height * t->channel_count;
    key = rsv_key_add(key, (uint64_t)finest->width << 32 | finest->height);
    key = rsv_key_add(key,
        t->channel_count << 16 | (uint32_t)t->wrap_u << 8 | (uint32_t)t->wrap_v << 4 | t->nearest);
    return t->unorm ? rsv_key_add_bytes(key, t->unorm, numbers * sizeof *t->unorm)
                    : add_numbers(key, t->value, numbers);
}

static uint64_t add_reference(uint64_t key, const rsv_scene_view *scene, const rsv_texture_ref *ref)
{
    key = rsv_key_add(key, (uint64_t)ref->role << 32 | ref->uv_set);
    key = add_numbers(key, ref->transform[0], 6);
    return add_texture(key, &scene->texture[ref->texture]);
}

/// Key of the uniform properties of a material, and of the means of its textures.
static uint64_t key_of_mean(const rsv_material *m, const rsv_bsdf *b)
{
    uint64_t key = rsv_key_add(1, b->double_sided);
    if (b->lambert) return key;
    const float kind[] = { b->ior, b->transmission, m->thickness, b->metallic, b->diffuse, b->alpha,
        b->passed, b->dispersion, b->brush_along, b->brush_across };
    const rsv_layer_values layers = rsv_bsdf_layer_values(b);
    key = add_numbers(add_color(key, b->specular_tint), layers.value, RSV_LAYER_VALUES);
    return rsv_key_add(add_numbers(key, kind, sizeof kind / sizeof *kind), 1 + b->coated);
}

static rsv_material_key key_of(const rsv_transport_scene *scene, uint32_t index)
{
    const rsv_material *m = &scene->view->material[index];
    const rsv_bsdf *b = &scene->bsdf[index];
    rsv_material_key own = { 0 };
    if (m->alpha_cutoff > 0 || b->opacity < 1) return own;
    own.key = key_of_mean(m, b);
    for (size_t k = 0; k < m->texture_count; k++) {
        if (!counts(m->textures[k].role, b)) continue;
        own.key = add_numbers(own.key, &m->textures[k].scale, 1);
        own.key = add_reference(own.key, scene->view, &m->textures[k]);
        own.placed = true;
    }
    return own;
}

static rsv_material_key key_of_normal_map(const rsv_scene_view *scene, uint32_t index)
{
    const rsv_material *m = &scene->material[index];
    rsv_material_key own = { 0 };
    for (size_t k = 0; k < m->texture_count; k++) {
        if (m->textures[k].role != RSV_TEXTURE_NORMAL) continue;
        own.key = add_numbers(own.key, &m->textures[k].scale, 1);
        own.key = add_reference(own.key, scene, &m->textures[k]);
        own.placed = true;
    }
    return own;
}

typedef struct material_job {
    const rsv_scene_view *view;
    const rsv_transport_scene *scene; ///< NULL = only normal maps
    rsv_material_key *key;            ///< [material_count]
} material_job;

static void key_materials(void *data, rsv_span span)
{
    const material_job *job = data;
    for (uint32_t m = (uint32_t)span.begin; m < span.end; m++)
        job->key[m] = job->scene ? key_of(job->scene, m) : key_of_normal_map(job->view, m);
}

rsv_status rsv_normal_map_keys_create(
    rsv_context *context, const rsv_scene_view *scene, rsv_material_key **keys)
{
    material_job job = { scene, NULL, rsv_alloc(context, scene->material_count, sizeof **keys) };
    *keys = job.key;
    if (!job.key) return RSV_ERROR_MEMORY;
    rsv_parallel_for(context, scene->material_count, 1, key_materials, &job);
    return RSV_OK;
}

rsv_status rsv_material_keys_create(
    rsv_context *context, const rsv_transport_scene *scene, rsv_material_key **keys)
{
    size_t count = scene->view->material_count;
    material_job job = { scene->view, scene, rsv_alloc(context, count, sizeof **keys) };
    *keys = job.key;
    if (!job.key) return RSV_ERROR_MEMORY;
    rsv_parallel_for(context, count, 1, key_materials, &job);
    return RSV_OK;
}

uint64_t rsv_key_add_uvs(uint64_t key, const rsv_scene_view *scene, uint32_t triangle)
{
    for (int set = 0; set < 2; set++)
        for (int k = 0; k < 3 && scene->uv[set]; k++)
            key = add_numbers(key, scene->uv[set][scene->triangle[triangle][k]], 2);
    return key;
}

uint64_t rsv_surface_key(
    const rsv_scene_view *scene, const rsv_material_key *keys, uint32_t triangle)
{
    const rsv_material_key *own = &keys[scene->triangle_material[triangle]];
    if (!own->key) return 0;
    uint64_t key = rsv_key_add(rsv_triangle_key(scene, triangle), own->key);
    return own->placed ? rsv_key_add_uvs(key, scene, triangle) : key;
}
