#include "sources.h"

// ---- trees --------------------------------------------------------------------------------------

static size_t tree_nodes(const rsv_light_tree *tree)
{
    return tree ? 2 * tree->light_count - 1 : 0;
}

/// @return the tree's address on the device; NULL = there is none
static rsv_light_tree *place_tree(
    const rsv_light_tree *host, rsv_light_tree *tree, rsv_gpu_block *b)
{
    if (!host) return NULL;
    *tree = *host;
    tree->node = rsv_gpu_place(b, tree_nodes(host), sizeof *host->node);
    tree->leaf = rsv_gpu_place(b, host->light_count, sizeof *host->leaf);
    return rsv_gpu_place(b, 1, sizeof *tree);
}

static void upload_tree(
    const rsv_light_tree *host, const rsv_light_tree *tree, rsv_light_tree *there, rsv_gpu *gpu)
{
    if (!host) return;
    rsv_gpu_upload(gpu, tree->node, host->node, tree_nodes(host) * sizeof *host->node);
    rsv_gpu_upload(gpu, tree->leaf, host->leaf, host->light_count * sizeof *host->leaf);
    rsv_gpu_upload(gpu, there, tree, sizeof *tree);
}

// ---- surroundings -------------------------------------------------------------------------------

/// The sky besides the suns; absent if all of it is gathered.
static bool has_sky(const rsv_environment_light *light) { return light && light->sampler.flux > 0; }

static size_t pixels_of(const rsv_sky *sky)
{
    return sky->pixel ? (size_t)sky->width * sky->height : 0;
}

static void place_picture(const rsv_sky *host, bool wanted, rsv_sky *sky, rsv_gpu_block *b)
{
    sky->pixel = NULL;
    if (wanted && host->pixel) sky->pixel = rsv_gpu_place(b, pixels_of(host), sizeof *host->pixel);
}

static void upload_picture(const rsv_sky *host, const rsv_sky *sky, rsv_gpu *gpu)
{
    if (sky->pixel)
        rsv_gpu_upload(gpu, (void *)sky->pixel, host->pixel, pixels_of(host) * sizeof *host->pixel);
}

static size_t sky_rows(const rsv_environment_light *light)
{
    return has_sky(light) ? light->sampler.rows : 0;
}

static size_t sky_cells(const rsv_environment_light *light)
{
    return sky_rows(light) * (has_sky(light) ? light->sampler.columns : 0);
}

static size_t open_nodes(const rsv_environment_light *light)
{
    return has_sky(light) ? (size_t)RSV_SKY_IRRADIANCE_NODES * RSV_SKY_IRRADIANCE_NODES : 0;
}

static rsv_environment_light *place_environment(
    const rsv_environment_light *host, bool seen, rsv_environment_light *light, rsv_gpu_block *b)
{
    if (!host) return NULL;
    *light = *host;
    place_picture(&host->whole, seen, &light->whole, b);
    place_picture(&host->gathered, seen, &light->gathered, b);
    place_picture(&host->sampled, seen || has_sky(host), &light->sampled, b);
    light->sampler.row_cdf = rsv_gpu_place(b, sky_rows(host), sizeof *host->sampler.row_cdf);
    light->sampler.cell_cdf = rsv_gpu_place(b, sky_cells(host), sizeof *host->sampler.cell_cdf);
    light->sampler.density = rsv_gpu_place(b, sky_cells(host), sizeof *host->sampler.density);
    light->open.node = rsv_gpu_place(b, open_nodes(host), sizeof *host->open.node);
    return rsv_gpu_place(b, 1, sizeof *light);
}

static void upload_environment(const rsv_environment_light *host,
    const rsv_environment_light *light, rsv_environment_light *there, rsv_gpu *gpu)
{
    if (!host) return;
    const rsv_sky_sampler *from = &host->sampler, *to = &light->sampler;
    const rsv_gpu_array array[] = { { there, light, 1, sizeof *light },
        { to->row_cdf, from->row_cdf, sky_rows(host), sizeof *from->row_cdf },
        { to->cell_cdf, from->cell_cdf, sky_cells(host), sizeof *from->cell_cdf },
        { to->density, from->density, sky_cells(host), sizeof *from->density },
        { light->open.node, host->open.node, open_nodes(host), sizeof *host->open.node } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
    upload_picture(&host->whole, &light->whole, gpu);
    upload_picture(&host->gathered, &light->gathered, gpu);
    upload_picture(&host->sampled, &light->sampled, gpu);
}

// ---- all ----------------------------------------------------------------------------------------

void rsv_gpu_sources_place(rsv_gpu_sources *s, rsv_gpu_scene *g, rsv_gpu_block *b)
{
    const rsv_lights *host = s->host;
    rsv_lights *lights = &s->lights;
    *lights = *host;
    lights->scene = g->there;
    size_t triangles = g->host->triangle_count;
    g->view.light = rsv_gpu_place(b, g->host->light_count, sizeof *g->host->light);
    lights->emitter = rsv_gpu_place(b, host->emitter_count, sizeof *host->emitter);
    lights->group = rsv_gpu_place(b, host->group_count, sizeof *host->group);
    lights->triangle_emitter = rsv_gpu_place(b, triangles, sizeof *host->triangle_emitter);
    lights->sampled = rsv_gpu_place(b, host->sampled_count, sizeof *host->sampled);
    lights->punctual = rsv_gpu_place(b, host->punctual_count, sizeof *host->punctual);
    lights->emitter_tree = place_tree(host->emitter_tree, &s->emitter_tree, b);
    lights->punctual_tree = place_tree(host->punctual_tree, &s->punctual_tree, b);
    lights->environment = place_environment(host->environment, s->seen, &s->environment, b);
    s->there = rsv_gpu_place(b, 1, sizeof *s->there);
}

void rsv_gpu_sources_upload(const rsv_gpu_sources *s, const rsv_gpu_scene *g, rsv_gpu *gpu)
{
    const rsv_lights *host = s->host, *lights = &s->lights;
    const rsv_gpu_array array[] = { { s->there, lights, 1, sizeof *lights },
        { g->view.light, g->host->light, g->host->light_count, sizeof *g->host->light },
        { lights->emitter, host->emitter, host->emitter_count, sizeof *host->emitter },
        { lights->group, host->group, host->group_count, sizeof *host->group },
        { lights->triangle_emitter, host->triangle_emitter, g->host->triangle_count,
            sizeof *host->triangle_emitter },
        { lights->sampled, host->sampled, host->sampled_count, sizeof *host->sampled },
        { lights->punctual, host->punctual, host->punctual_count, sizeof *host->punctual } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
    upload_tree(host->emitter_tree, &s->emitter_tree, lights->emitter_tree, gpu);
    upload_tree(host->punctual_tree, &s->punctual_tree, lights->punctual_tree, gpu);
    upload_environment(host->environment, &s->environment, lights->environment, gpu);
}
