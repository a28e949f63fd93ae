#include "turned_surroundings.h"

#include "../solve/source.h"

/// A solution without light on the surfaces and rows of another.
static void darken(const rsv_solution *s, rsv_solution *dark)
{
    *dark = *s;
    dark->lights = NULL;
    dark->bin_radiance = dark->gathered = dark->source = dark->irradiance = dark->indirect = NULL;
    dark->fine.direct = dark->caustics.caustic = dark->caustics.coarse_caustic = NULL;
    dark->diffused = (rsv_diffused_level){ 0 };
    for (uint32_t order = 0; order < RSV_KEPT_ORDERS; order++)
        dark->order[order] = NULL;
}

/// The surroundings alone, at their new angle.
static rsv_status find_light(
    const rsv_solution *s, const rsv_source *surroundings, float rotation, rsv_solution *turned)
{
    rsv_lights all = *s->lights;
    rsv_status status =
        rsv_environment_light_create_turned(s->scene.scene, rotation, &all.environment);
    if (status == RSV_OK) status = rsv_light_subset_create(&all, surroundings, 1, &turned->lights);
    if (status != RSV_OK) rsv_environment_light_destroy(all.environment);
    return status;
}

/// What shadow rays and photons find.
static rsv_status sample(
    const rsv_solution *s, const rsv_source *surroundings, rsv_solution *turned)
{
    rsv_light_part part = { 0 };
    uint16_t *valid = NULL;
    uint64_t rays = 0;
    rsv_status status = rsv_find_fine_valid(s, &valid);
    if (status == RSV_OK) {
        rsv_light_effort effort = rsv_full_light_effort(s, valid);
        status = rsv_light_part_estimate(s, turned->lights, surroundings, &effort, &part, &rays);
    }
    turned->source = part.direct;
    turned->caustics.coarse_caustic = part.coarse_caustic;
    turned->fine.direct = part.fine;
    turned->caustics.caustic = part.caustic;
    rsv_free(s->context, valid);
    return status;
}

/// What rows found, bin by bin.
static rsv_status gather(rsv_solution *turned)
{
    rsv_context *context = turned->context;
    turned->bin_radiance = rsv_alloc(context, RSV_ESCAPE_BINS, sizeof *turned->bin_radiance);
    turned->gathered = rsv_alloc(context, turned->elements->node_count, sizeof *turned->gathered);
    if (!turned->bin_radiance || !turned->gathered) return RSV_ERROR_MEMORY;
    rsv_status status =
        rsv_escape_radiance(context, turned->lights->environment, turned->bin_radiance);
    if (status == RSV_OK)
        rsv_transport_environment(turned->transport, turned->bin_radiance, turned->gathered);
    return status;
}

rsv_status rsv_turned_surroundings_solve(
    const rsv_solution *s, float rotation, rsv_solution *turned)
{
    rsv_status status;
    const rsv_source surroundings = { RSV_SOURCE_SURROUNDINGS, 0, "environment" };
    darken(s, turned);
    RSV_TRY(find_light(s, &surroundings, rotation, turned));
    RSV_TRY(sample(s, &surroundings, turned));
    RSV_TRY(gather(turned));
    rsv_source_complete(turned);
    RSV_TRY(rsv_solve_orders(turned, s->desc.max_orders));
    RSV_TRY(rsv_diffused_level_create(turned));
cleanup:
    return status;
}

void rsv_turned_surroundings_free(rsv_solution *turned)
{
    rsv_context *context = turned->context;
    if (turned->lights) rsv_environment_light_destroy(turned->lights->environment);
    rsv_light_subset_destroy(turned->lights);
    rsv_diffused_level_destroy(context, &turned->diffused);
    rsv_free(context, turned->bin_radiance);
    rsv_free(context, turned->gathered);
    rsv_free(context, turned->source);
    rsv_free(context, turned->irradiance);
    rsv_free(context, turned->indirect);
    rsv_free(context, turned->fine.direct);
    rsv_free(context, turned->caustics.caustic);
    rsv_free(context, turned->caustics.coarse_caustic);
    for (uint32_t order = 0; order < RSV_KEPT_ORDERS; order++)
        rsv_free(context, turned->order[order]);
}
