#include "photon_origin_body.h"

#include "../sources/punctual_light.h"

#include <stdlib.h>

// ---- origins -------------------------------------------------------------------------------------

static double light_flux(const rsv_photon_origins *o, const rsv_punctual_light *light)
{
    if (!rsv_punctual_is_distant(light)) return rsv_punctual_flux(o->scene->view, light);
    return (double)rgb_luminance(light->intensity) * RSV_PI * o->radius * o->radius;
}

static double sun_flux(const rsv_photon_origins *o, const rsv_sun *sun)
{
    return (double)rgb_luminance(sun->radiance) * sun->solid_angle * M_PI * o->radius * o->radius;
}

/// One point of a group speaks for all.
static rsv_medium group_medium(const rsv_photon_origins *o, uint32_t group)
{
    const rsv_emitter *e = &o->lights->emitter[o->lights->group[group].first];
    rsv_vec3 centre = v3_barycentric(e->corner[0], e->corner[1], e->corner[2], 1.0f / 3, 1.0f / 3);
    float extent = rsv_triangle_extent(o->scene->view, e->triangle);
    return rsv_medium_above(
        &o->scene->media, rsv_offset_origin(centre, e->normal, extent), e->normal);
}

static rsv_medium origin_medium(const rsv_photon_origins *o, rsv_origin_kind kind, uint32_t index)
{
    if (kind == RSV_ORIGIN_GROUP) return group_medium(o, index);
    const rsv_punctual_light *light = &o->scene->view->light[index];
    if (kind == RSV_ORIGIN_SUN || rsv_punctual_is_distant(light)) return (rsv_medium){ .depth = 0 };
    return rsv_medium_above(&o->scene->media, light->position, v3(0, 1, 0));
}

static void add_origin(rsv_photon_origins *o, rsv_origin_kind kind, uint32_t index, double flux)
{
    if (!(flux > 0)) return;
    o->origin[o->count++] =
        (rsv_photon_origin){ kind, index, flux, 1, origin_medium(o, kind, index) };
}

static int compare_origins(const void *left, const void *right)
{
    const rsv_photon_origin *a = left, *b = right;
    if (a->flux != b->flux) return a->flux < b->flux ? 1 : -1;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    return (a->index > b->index) - (a->index < b->index);
}

/// Everything that photons start from, the strongest first.
static rsv_status list_origins(rsv_photon_origins *o)
{
    const rsv_lights *lights = o->lights;
    const rsv_scene_view *view = o->scene->view;
    uint32_t suns = lights->environment ? lights->environment->sun_count : 0;
    size_t capacity = lights->group_count + view->light_count + suns;
    o->origin = rsv_alloc(lights->context, capacity, sizeof *o->origin);
    if (!o->origin) return RSV_ERROR_MEMORY;
    for (uint32_t g = 0; g < lights->group_count; g++)
        if (!lights->group[g].gathered) add_origin(o, RSV_ORIGIN_GROUP, g, lights->group[g].power);
    for (size_t k = 0; k < lights->punctual_count; k++) {
        uint32_t l = lights->punctual[k];
        add_origin(o, RSV_ORIGIN_LIGHT, l, light_flux(o, &view->light[l]));
    }
    for (uint32_t k = 0; k < suns; k++)
        add_origin(o, RSV_ORIGIN_SUN, k, sun_flux(o, &lights->environment->sun[k]));
    qsort(o->origin, o->count, sizeof *o->origin, compare_origins);
    return RSV_OK;
}

static rsv_status create_emitter_table(rsv_photon_origins *o, double *weight)
{
    rsv_status status = RSV_OK;
    for (size_t i = 0; i < o->lights->emitter_count; i++)
        weight[i] = rsv_emitter_power(&o->lights->emitter[i]);
    for (size_t g = 0; g < o->lights->group_count; g++) {
        uint32_t first = o->lights->group[g].first;
        RSV_TRY(rsv_alias_table_fill(o->lights->context, weight + first, o->lights->group[g].count,
            o->emitter_table + first));
    }
cleanup:
    return status;
}

/// Origins from `own` on share a source and are drawn by their flux.
static rsv_status create_origin_table(rsv_photon_origins *o, size_t own, double *weight)
{
    if (o->count <= own) return RSV_OK;
    double total = 0;
    for (size_t k = own; k < o->count; k++)
        total += weight[k] = o->origin[k].flux;
    for (size_t k = own; k < o->count; k++)
        o->origin[k].probability = (float)(o->origin[k].flux / total);
    return rsv_alias_table_fill(
        o->lights->context, weight + own, o->count - own, o->origin_table + own);
}

rsv_status rsv_photon_origins_create(
    const rsv_transport_scene *scene, const rsv_lights *lights, size_t own, rsv_photon_origins *o)
{
    rsv_context *context = lights->context;
    rsv_status status;
    double *weight = NULL;
    *o = (rsv_photon_origins){ .scene = scene, .lights = lights };
    o->centre = v3_scale(v3_add(scene->view->bounds_min, scene->view->bounds_max), 0.5f);
    o->radius = 1.001f * v3_length(v3_sub(scene->view->bounds_max, o->centre));
    RSV_TRY(list_origins(o));
    size_t most = lights->emitter_count > o->count ? lights->emitter_count : o->count;
    weight = rsv_alloc(context, most, sizeof *weight);
    o->emitter_table = rsv_alloc(context, lights->emitter_count, sizeof *o->emitter_table);
    o->origin_table = rsv_alloc(context, o->count, sizeof *o->origin_table);
    RSV_TRY(weight && o->emitter_table && o->origin_table ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(create_emitter_table(o, weight));
    RSV_TRY(create_origin_table(o, own, weight));
cleanup:
    rsv_free(context, weight);
    if (status != RSV_OK) rsv_photon_origins_destroy(o);
    return status;
}

void rsv_photon_origins_destroy(rsv_photon_origins *o)
{
    if (!o->lights) return;
    rsv_free(o->lights->context, o->origin);
    rsv_free(o->lights->context, o->origin_table);
    rsv_free(o->lights->context, o->emitter_table);
    *o = (rsv_photon_origins){ 0 };
}
