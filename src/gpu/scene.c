#include "scene.h"

#include <stdlib.h>

#define UV_SETS (sizeof((rsv_scene_view *)0)->uv / sizeof *((rsv_scene_view *)0)->uv)

rsv_status rsv_gpu_scene_create(
    const rsv_scene_view *host, rsv_bvh_view bvh, bool varied, rsv_gpu_scene *s, char *message)
{
    *s = (rsv_gpu_scene){ .host = host, .host_bvh = bvh, .varied = varied || bvh.holes };
    s->bvh = bvh;
    s->material = rsv_gpu_new((host->material_count + 1) * sizeof *s->material, message);
    s->texture = rsv_gpu_new((host->texture_count + 1) * sizeof *s->texture, message);
    s->use = rsv_gpu_new((host->material_count + 1) * sizeof *s->use, message);
    s->luminaire = rsv_gpu_new((host->luminaire_count + 1) * sizeof *s->luminaire, message);
    return s->material && s->texture && s->use && s->luminaire ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_gpu_scene_destroy(rsv_gpu_scene *s)
{
    free(s->material);
    free(s->texture);
    free(s->use);
    free(s->luminaire);
    *s = (rsv_gpu_scene){ .host = NULL };
}

// ---- materials that vary -------------------------------------------------------------------------

/// Numbers in all levels of a texture.
static size_t count_numbers(const rsv_texture *t)
{
    const rsv_texture_level *last = &t->level[t->level_count - 1];
    return (last->first + (size_t)last->width * last->height) * t->channel_count;
}

static void place_texture(const rsv_texture *host, rsv_texture *t, rsv_gpu_block *b)
{
    *t = *host;
    t->name = NULL;
    if (host->unorm) t->unorm = rsv_gpu_place(b, count_numbers(host), sizeof *host->unorm);
    if (host->value) t->value = rsv_gpu_place(b, count_numbers(host), sizeof *host->value);
}

static void place_variation(rsv_gpu_scene *s, rsv_gpu_block *b)
{
    const rsv_scene_view *host = s->host;
    rsv_scene_view *view = &s->view;
    size_t vertices = host->vertex_count;
    for (size_t k = 0; k < UV_SETS; k++)
        view->uv[k] = host->uv[k] ? rsv_gpu_place(b, vertices, sizeof *host->uv[k]) : NULL;
    view->tangent = host->tangent ? rsv_gpu_place(b, vertices, sizeof *host->tangent) : NULL;
    view->color = host->color ? rsv_gpu_place(b, vertices, sizeof *host->color) : NULL;
    view->material_varies = rsv_gpu_place(b, host->material_count, sizeof *host->material_varies);
    view->texture = rsv_gpu_place(b, host->texture_count, sizeof *host->texture);
    for (size_t m = 0; m < host->material_count; m++)
        s->use[m] =
            rsv_gpu_place(b, host->material[m].texture_count, sizeof *host->material[m].textures);
    for (size_t t = 0; t < host->texture_count; t++)
        place_texture(&host->texture[t], &s->texture[t], b);
}

static void upload_variation(const rsv_gpu_scene *s, rsv_gpu *gpu)
{
    const rsv_scene_view *host = s->host, *view = &s->view;
    size_t vertices = host->vertex_count;
    const rsv_gpu_array array[] = { { view->tangent, host->tangent, host->tangent ? vertices : 0,
                                        sizeof *host->tangent },
        { view->color, host->color, host->color ? vertices : 0, sizeof *host->color },
        { view->material_varies, host->material_varies, host->material_count,
            sizeof *host->material_varies },
        { view->texture, s->texture, host->texture_count, sizeof *s->texture } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
    for (size_t k = 0; k < UV_SETS; k++)
        if (host->uv[k])
            rsv_gpu_upload(gpu, (void *)view->uv[k], host->uv[k], vertices * sizeof *host->uv[k]);
    for (size_t m = 0; m < host->material_count; m++)
        rsv_gpu_upload(gpu, s->use[m], host->material[m].textures,
            host->material[m].texture_count * sizeof *s->use[m]);
    for (size_t t = 0; t < host->texture_count; t++) {
        const rsv_texture *from = &host->texture[t];
        const rsv_gpu_array texels[] = { { s->texture[t].unorm, from->unorm,
                                             from->unorm ? count_numbers(from) : 0,
                                             sizeof *from->unorm },
            { s->texture[t].value, from->value, from->value ? count_numbers(from) : 0,
                sizeof *from->value } };
        rsv_gpu_upload_all(gpu, texels, sizeof texels / sizeof texels[0]);
    }
}

// ---- faces in the same place -------------------------------------------------------------------

static void place_twins(rsv_gpu_scene *s, rsv_gpu_block *b)
{
    const rsv_twins *host = s->host->twins;
    if (!host) return;
    s->twins = *host;
    s->twins.first_rival = s->twins.rival = NULL;
    s->twins.flags = rsv_gpu_place(b, s->host->triangle_count, sizeof *host->flags);
    s->twins.node = rsv_gpu_place(b, (size_t)host->node_count + 1, sizeof *host->node);
    s->twins.face = rsv_gpu_place(b, host->face_count, sizeof *host->face);
    s->view.twins = rsv_gpu_place(b, 1, sizeof *host);
    s->bvh.twins = s->there;
}

static void upload_twins(const rsv_gpu_scene *s, rsv_gpu *gpu)
{
    const rsv_twins *host = s->host->twins;
    if (!host) return;
    const rsv_gpu_array array[] = { { s->view.twins, &s->twins, 1, sizeof s->twins },
        { s->twins.flags, host->flags, s->host->triangle_count, sizeof *host->flags },
        { s->twins.node, host->node, (size_t)host->node_count + 1, sizeof *host->node },
        { s->twins.face, host->face, host->face_count, sizeof *host->face } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
}

// ---- luminaires ---------------------------------------------------------------------------------

static void place_luminaires(rsv_gpu_scene *s, rsv_gpu_block *b)
{
    const rsv_scene_view *host = s->host;
    s->view.luminaire = rsv_gpu_place(b, host->luminaire_count, sizeof *host->luminaire);
    for (size_t k = 0; k < host->luminaire_count; k++) {
        rsv_luminaire *l = &s->luminaire[k];
        *l = host->luminaire[k];
        l->vertical = rsv_gpu_place(b, l->vertical_count, sizeof *l->vertical);
        l->horizontal = rsv_gpu_place(b, l->horizontal_count, sizeof *l->horizontal);
        l->intensity =
            rsv_gpu_place(b, (size_t)l->vertical_count * l->horizontal_count, sizeof *l->intensity);
    }
}

static void upload_luminaires(const rsv_gpu_scene *s, rsv_gpu *gpu)
{
    const rsv_scene_view *host = s->host;
    for (size_t k = 0; k < host->luminaire_count; k++) {
        const rsv_luminaire *from = &host->luminaire[k], *to = &s->luminaire[k];
        const rsv_gpu_array array[] = { { to->vertical, from->vertical, from->vertical_count,
                                            sizeof *from->vertical },
            { to->horizontal, from->horizontal, from->horizontal_count, sizeof *from->horizontal },
            { to->intensity, from->intensity, (size_t)from->vertical_count * from->horizontal_count,
                sizeof *from->intensity } };
        rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
    }
    rsv_gpu_upload(
        gpu, (void *)s->view.luminaire, s->luminaire, host->luminaire_count * sizeof *s->luminaire);
}

// ---- all ----------------------------------------------------------------------------------------

void rsv_gpu_scene_place(rsv_gpu_scene *s, rsv_gpu_block *b)
{
    const rsv_scene_view *host = s->host;
    rsv_scene_view *view = &s->view;
    s->there = rsv_gpu_place(b, 1, sizeof *s->there);
    view->position = rsv_gpu_place(b, host->vertex_count, sizeof *host->position);
    view->normal = rsv_gpu_place(b, host->vertex_count, sizeof *host->normal);
    view->triangle = rsv_gpu_place(b, host->triangle_count, sizeof *host->triangle);
    view->triangle_material =
        rsv_gpu_place(b, host->triangle_count, sizeof *host->triangle_material);
    view->material = rsv_gpu_place(b, host->material_count, sizeof *host->material);
    s->bvh.node = rsv_gpu_place(b, s->host_bvh.node_count, sizeof *s->bvh.node);
    s->bvh.triangle = rsv_gpu_place(b, s->host_bvh.triangle_count, sizeof *s->bvh.triangle);
    s->bvh.holes = s->host_bvh.holes ? s->there : NULL;
    place_luminaires(s, b);
    if (s->varied) place_variation(s, b);
    place_twins(s, b);
}

void rsv_gpu_scene_upload(const rsv_gpu_scene *s, rsv_gpu *gpu)
{
    const rsv_scene_view *host = s->host, *view = &s->view;
    const rsv_bvh_view *bvh = &s->host_bvh;
    const rsv_gpu_array array[] = { { s->there, view, 1, sizeof *view },
        { view->position, host->position, host->vertex_count, sizeof *host->position },
        { view->normal, host->normal, host->vertex_count, sizeof *host->normal },
        { view->triangle, host->triangle, host->triangle_count, sizeof *host->triangle },
        { view->triangle_material, host->triangle_material, host->triangle_count,
            sizeof *host->triangle_material },
        { s->bvh.node, bvh->node, bvh->node_count, sizeof *bvh->node },
        { s->bvh.triangle, bvh->triangle, bvh->triangle_count, sizeof *bvh->triangle } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
    upload_luminaires(s, gpu);
    if (s->varied) upload_variation(s, gpu);
    upload_twins(s, gpu);
    rsv_gpu_scene_upload_materials(s, gpu);
}

void rsv_gpu_scene_upload_materials(const rsv_gpu_scene *s, rsv_gpu *gpu)
{
    const rsv_scene_view *host = s->host;
    for (size_t m = 0; m < host->material_count; m++) {
        rsv_material *material = &s->material[m];
        *material = host->material[m];
        material->name = NULL;
        material->textures = s->use[m];
        if (!s->varied) material->texture_count = 0;
    }
    rsv_gpu_upload(
        gpu, (void *)s->view.material, s->material, host->material_count * sizeof *s->material);
}
