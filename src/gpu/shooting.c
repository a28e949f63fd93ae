#include "shooting.h"
#include "lookup.h"
#include "scattering.h"
#include "shooting_kernels.h"
#include "sources.h"

#include <stdlib.h>

#define BINS ((size_t)RSV_GUIDE_SIDE * RSV_GUIDE_SIDE)

struct rsv_device_shooting {
    rsv_gpu *gpu;
    rsv_device_shooting_desc desc; ///< on the host; its arrays are only valid during creation
    rsv_gpu_block block;
    rsv_gpu_scene scene;
    rsv_gpu_scattering scattering;
    rsv_gpu_sources lights;
    rsv_gpu_lookup lookup[RSV_DEVICE_MAPS];
    rsv_photon_source *source; ///< [source_count] on the host, with addresses on the device
    rsv_photon_source *source_there;
    rsv_gpu_range range; ///< with addresses on the device
    rsv_gpu_range *range_there;
};

// ---- resident data -------------------------------------------------------------------------------

static void place_guide(rsv_photon_guide *guide, rsv_gpu_block *b)
{
    guide->row_cdf = rsv_gpu_place(b, RSV_GUIDE_SIDE, sizeof *guide->row_cdf);
    guide->cell_cdf = rsv_gpu_place(b, BINS, sizeof *guide->cell_cdf);
    guide->density = rsv_gpu_place(b, BINS, sizeof *guide->density);
}

static void place_origins(rsv_device_shooting *s, rsv_gpu_block *b)
{
    const rsv_photon_origins *host = s->desc.shooting.origins;
    rsv_photon_origins *o = &s->range.origins;
    *o = *host;
    o->scene = s->range_there ? &s->range_there->transport : NULL;
    o->lights = s->lights.there;
    o->origin = rsv_gpu_place(b, host->count, sizeof *host->origin);
    o->origin_table = rsv_gpu_place(b, host->count, sizeof *host->origin_table);
    o->emitter_table = rsv_gpu_place(b, s->desc.lights->emitter_count, sizeof *host->emitter_table);
    s->source_there = rsv_gpu_place(b, s->desc.source_count, sizeof *s->source_there);
    for (size_t k = 0; k < s->desc.source_count; k++) {
        s->source[k] = s->desc.source[k];
        place_guide(&s->source[k].guide, b);
    }
}

static void place_maps(rsv_device_shooting *s, rsv_gpu_block *b)
{
    s->range.map_count = s->desc.map_count;
    for (size_t m = 0; m < s->desc.map_count; m++) {
        const rsv_photon_map *host = &s->desc.map[m];
        rsv_photon_map *map = &s->range.map[m];
        size_t nodes = host->elements->node_count;
        s->lookup[m].host = host->elements;
        rsv_gpu_lookup_place(&s->lookup[m], s->scene.host->triangle_count, b);
        *map = *host;
        map->elements = s->lookup[m].there;
        map->flux = rsv_gpu_place(b, nodes, sizeof *map->flux);
        map->hits = rsv_gpu_place(b, nodes, sizeof *map->hits);
    }
}

static void lay_out(void *task, rsv_gpu_block *b)
{
    rsv_device_shooting *s = task;
    rsv_gpu_range *r = &s->range;
    s->range_there = rsv_gpu_place(b, 1, sizeof *s->range_there);
    r->rays = rsv_gpu_place(b, 1, sizeof *r->rays);
    rsv_gpu_scene_place(&s->scene, b);
    rsv_gpu_scattering_place(&s->scattering, b);
    rsv_gpu_sources_place(&s->lights, &s->scene, b);
    place_origins(s, b);
    place_maps(s, b);
    r->tracer.bvh = s->scene.bvh;
    r->transport.view = s->scene.there;
    r->transport.bsdf = s->scattering.bsdf;
    r->source = s->source_there;
    r->shooting.seed = s->desc.shooting.seed;
    if (!b->base) return;
    r->transport.tracer = &s->range_there->tracer;
    r->shooting.scene = &s->range_there->transport;
    r->shooting.origins = &s->range_there->origins;
}

static void upload_origins(const rsv_device_shooting *s)
{
    const rsv_photon_origins *host = s->desc.shooting.origins, *o = &s->range.origins;
    const rsv_gpu_array array[] = { { o->origin, host->origin, host->count, sizeof *host->origin },
        { o->origin_table, host->origin_table, host->count, sizeof *host->origin_table },
        { o->emitter_table, host->emitter_table,
            host->emitter_table ? s->desc.lights->emitter_count : 0, sizeof *host->emitter_table },
        { s->source_there, s->source, s->desc.source_count, sizeof *s->source } };
    rsv_gpu_upload_all(s->gpu, array, sizeof array / sizeof array[0]);
    for (size_t k = 0; k < s->desc.source_count; k++) {
        const rsv_photon_guide *from = &s->desc.source[k].guide, *to = &s->source[k].guide;
        const rsv_gpu_array guide[] = { { to->row_cdf, from->row_cdf, RSV_GUIDE_SIDE,
                                            sizeof *from->row_cdf },
            { to->cell_cdf, from->cell_cdf, BINS, sizeof *from->cell_cdf },
            { to->density, from->density, BINS, sizeof *from->density } };
        rsv_gpu_upload_all(s->gpu, guide, sizeof guide / sizeof guide[0]);
    }
}

static void upload(rsv_device_shooting *s)
{
    const rsv_gpu_range *r = &s->range;
    rsv_gpu_scene_upload(&s->scene, s->gpu);
    rsv_gpu_scattering_upload(&s->scattering, s->desc.shooting.scene->bsdf, s->gpu);
    rsv_gpu_sources_upload(&s->lights, &s->scene, s->gpu);
    upload_origins(s);
    rsv_gpu_clear(s->gpu, r->rays, sizeof *r->rays);
    for (size_t m = 0; m < r->map_count; m++) {
        size_t nodes = s->desc.map[m].elements->node_count;
        rsv_gpu_lookup_upload(&s->lookup[m], s->scene.host->triangle_count, s->gpu);
        rsv_gpu_clear(s->gpu, r->map[m].flux, nodes * sizeof *r->map[m].flux);
        rsv_gpu_clear(s->gpu, r->map[m].hits, nodes * sizeof *r->map[m].hits);
    }
    rsv_gpu_upload(s->gpu, s->range_there, r, sizeof *r);
}

static void destroy(rsv_device_shooting *s)
{
    if (!s) return;
    rsv_gpu_release(s->gpu, &s->block);
    rsv_gpu_scene_destroy(&s->scene);
    rsv_gpu_scattering_destroy(&s->scattering);
    free(s->source);
    free(s);
}

static rsv_status create(rsv_device *device, const rsv_device_shooting_desc *desc,
    rsv_device_shooting **shooting, char *message)
{
    const rsv_scene_view *view = desc->shooting.scene->view;
    rsv_device_shooting *s = rsv_gpu_new(sizeof *s, message);
    if (!s) return RSV_ERROR_MEMORY;
    s->gpu = (rsv_gpu *)device;
    s->desc = *desc;
    s->lights.host = desc->lights;
    s->source = rsv_gpu_new((desc->source_count + 1) * sizeof *s->source, message);
    rsv_status status = rsv_gpu_scene_create(view, desc->bvh, true, &s->scene, message);
    if (status == RSV_OK)
        status = rsv_gpu_scattering_create(view->material_count, &s->scattering, message);
    if (status == RSV_OK && !s->source) status = RSV_ERROR_MEMORY;
    if (status == RSV_OK) {
        rsv_gpu_lay_out(s->gpu, &s->block, lay_out, s, "the scene of the photons");
        upload(s);
        status = rsv_gpu_wait(s->gpu, message);
    }
    if (status == RSV_OK)
        *shooting = s;
    else
        destroy(s);
    return status;
}

// ---- photons ------------------------------------------------------------------------------------

static rsv_status shoot(rsv_device_shooting *s, uint32_t source, uint32_t first, uint32_t photons,
    uint32_t count, char *message)
{
    const rsv_shooting_args args = { s->range_there, source, first, count };
    rsv_launch_shooting(s->gpu, &args, photons);
    return rsv_gpu_wait(s->gpu, message);
}

static rsv_status collect(
    rsv_device_shooting *s, const rsv_photon_map *map, uint64_t *rays, char *message)
{
    int64_t traced = 0;
    for (size_t m = 0; m < s->range.map_count; m++) {
        size_t nodes = map[m].elements->node_count;
        const rsv_photon_map *there = &s->range.map[m];
        rsv_gpu_download(s->gpu, map[m].flux, there->flux, nodes * sizeof *map[m].flux);
        rsv_gpu_download(s->gpu, map[m].hits, there->hits, nodes * sizeof *map[m].hits);
    }
    rsv_gpu_download(s->gpu, &traced, s->range.rays, sizeof traced);
    rsv_status status = rsv_gpu_wait(s->gpu, message);
    if (status == RSV_OK) *rays += (uint64_t)traced;
    return status;
}

const rsv_device_shooting_table rsv_gpu_shooting = { create, destroy, shoot, collect };
