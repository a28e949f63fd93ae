#include "surfaces.h"

#include <stdlib.h>

#define UV_SETS (sizeof((rsv_scene_view *)0)->uv / sizeof *((rsv_scene_view *)0)->uv)

rsv_status rsv_gpu_surfaces_create(const rsv_scene_view *host, rsv_gpu_surfaces *s, char *message)
{
    *s = (rsv_gpu_surfaces){ .host = host };
    s->material = rsv_gpu_new((host->material_count + 1) * sizeof *s->material, message);
    s->texture = rsv_gpu_new((host->texture_count + 1) * sizeof *s->texture, message);
    s->use = rsv_gpu_new((host->material_count + 1) * sizeof *s->use, message);
    s->scattering = rsv_gpu_new((host->material_count + 1) * sizeof *s->scattering, message);
    bool all = s->material && s->texture && s->use && s->scattering;
    return all ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_gpu_surfaces_destroy(rsv_gpu_surfaces *s)
{
    free(s->material);
    free(s->texture);
    free(s->use);
    free(s->scattering);
    *s = (rsv_gpu_surfaces){ .host = NULL };
}

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

void rsv_gpu_surfaces_place(rsv_gpu_surfaces *s, rsv_gpu_geometry *g, rsv_gpu_block *b)
{
    const rsv_scene_view *host = s->host;
    rsv_scene_view *view = &g->view;
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
    s->bsdf = rsv_gpu_place(b, host->material_count, sizeof *s->bsdf);
    s->tables = rsv_gpu_place(b, 1, sizeof *s->tables);
}

void rsv_gpu_surfaces_upload_materials(
    const rsv_gpu_surfaces *s, const rsv_gpu_geometry *g, const rsv_bsdf *bsdf, rsv_gpu *gpu)
{
    const rsv_scene_view *host = s->host;
    for (size_t m = 0; m < host->material_count; m++) {
        s->material[m] = host->material[m];
        s->material[m].name = NULL;
        s->material[m].textures = s->use[m];
        s->scattering[m] = bsdf[m];
        s->scattering[m].tables = s->tables;
    }
    const rsv_gpu_array array[] = { { g->view.material, s->material, host->material_count,
                                        sizeof *s->material },
        { s->bsdf, s->scattering, host->material_count, sizeof *s->scattering } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
}

void rsv_gpu_surfaces_upload(
    const rsv_gpu_surfaces *s, const rsv_gpu_geometry *g, const rsv_bsdf *bsdf, rsv_gpu *gpu)
{
    const rsv_scene_view *host = s->host, *view = &g->view;
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
    rsv_gpu_upload(gpu, s->tables, bsdf->tables, sizeof *s->tables); // all share them
    rsv_gpu_surfaces_upload_materials(s, g, bsdf, gpu);
}
