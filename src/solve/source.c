#include "source.h"

#include "../elements/element_keys.h"
#include "../elements/past.h"
#include "budget.h"
#include "goal.h"

rsv_status rsv_source_create_levels(rsv_solution *s)
{
    bool caustics = s->desc.photon_count > 0 && s->elements->node_count > 0 &&
                    rsv_photons_wanted(&s->scene, s->lights);
    bool sampled = rsv_lights_any_sampled(s->lights) || s->scene.view->light_count > 0;
    rsv_source_level_desc desc = { .levels = s->desc.direct_levels,
        .max_cells = rsv_budget_cells(s),
        .light_samples = s->desc.light_samples,
        .seed = rsv_level_seed(s) };
    rsv_status status = RSV_OK;
    uint8_t *hidden = NULL;
    rsv_goal_aim aim = rsv_goal_aim_of(s);
    if (rsv_goal_is_wanted(&aim)) {
        hidden = rsv_alloc(s->context, s->elements->cell_count, 1);
        RSV_TRY(hidden ? RSV_OK : RSV_ERROR_MEMORY);
        RSV_TRY(rsv_goal_hidden_cells(s, &aim, hidden));
    }
    desc.hidden = hidden;
    rsv_source_level_desc direct_desc = desc, caustic_desc = desc;
    direct_desc.direct = true;
    caustic_desc.photon_count = s->desc.photon_count;
    if (s->desc.direct_level && sampled)
        status = rsv_source_level_create(
            &s->scene, s->lights, s->elements, &direct_desc, &s->fine, &s->report.rays);
    if (status == RSV_OK && caustics)
        status = rsv_source_level_create(
            &s->scene, s->lights, s->elements, &caustic_desc, &s->caustics, &s->report.rays);
cleanup:
    rsv_free(s->context, hidden);
    return status;
}

void rsv_source_complete(rsv_solution *s)
{
#pragma omp parallel for schedule(static) num_threads(rsv_threads(s->context))
    for (size_t n = 0; n < s->elements->node_count; n++) {
        s->source[n] = rgb_add(s->source[n], s->gathered[n]);
        if (s->caustics.coarse_caustic)
            s->source[n] = rgb_add(s->source[n], s->caustics.coarse_caustic[n]);
    }
    rsv_elements_constrain(s->elements, s->gathered);
    rsv_elements_constrain(s->elements, s->source);
}

void rsv_source_add_gathered(rsv_solution *s)
{
    rsv_transport_environment(s->transport, s->bin_radiance, s->gathered);
#pragma omp parallel for schedule(static) num_threads(rsv_threads(s->context))
    for (size_t n = 0; n < s->elements->node_count; n++)
        s->gathered[n] = rgb_add(s->gathered[n], s->transport->gathered[n]);
    rsv_source_complete(s);
}

/// Direct light that is what it was before the scene was edited. @param known [node_count], out
static rsv_status recall_direct(rsv_solution *s, uint8_t *known)
{
    const rsv_elements *e = s->elements;
    rsv_status status;
    uint64_t *key = NULL;
    uint8_t *lit_anew = NULL;
    RSV_TRY(rsv_node_keys_create(e, &key));
    RSV_TRY(rsv_past_find_lit_anew(s->scene.past, e, &lit_anew));
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(s->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (e->node_hanging[n] != RSV_NONE || rsv_past_is_node_lit_anew(e, n, lit_anew)) continue;
        const rsv_past_node *then = rsv_past_find_node(s->scene.past, e, n, key[n]);
        known[n] = then != NULL;
        if (then) s->source[n] = then->light.direct;
    }
cleanup:
    rsv_free(s->context, key);
    rsv_free(s->context, lit_anew);
    return status;
}

/// @param known [node_count] nodes that are left as they are; NULL = none
static rsv_status find_direct(
    const rsv_solution *s, const uint8_t *known, rsv_rgb *irradiance, uint64_t *rays)
{
    return rsv_direct_irradiance(&s->scene, s->lights, s->elements, RSV_SUPPORT_POINTS,
        RSV_COARSE_LIGHT_FACTOR * s->desc.light_samples, s->desc.seed, s->valid_points, known,
        irradiance, NULL, rays);
}

rsv_status rsv_measure_direct(const rsv_solution *s, double *seconds, uint64_t *rays)
{
    rsv_rgb *again = rsv_alloc(s->context, s->elements->node_count, sizeof *again);
    if (!again) return RSV_ERROR_MEMORY;
    double start = rsv_seconds();
    *rays = 0;
    rsv_status status = find_direct(s, NULL, again, rays);
    *seconds = rsv_seconds() - start;
    rsv_free(s->context, again);
    return status;
}

rsv_status rsv_source_estimate(rsv_solution *s, const uint8_t *known)
{
    return find_direct(s, known, s->source, &s->report.rays);
}

rsv_status rsv_source_create(rsv_solution *s)
{
    rsv_status status;
    uint8_t *known = rsv_alloc(s->context, s->elements->node_count, 1);
    RSV_TRY(known ? RSV_OK : RSV_ERROR_MEMORY);
    if (s->scene.past) RSV_TRY(recall_direct(s, known));
    RSV_TRY(rsv_source_estimate(s, known));
    rsv_source_add_gathered(s);
cleanup:
    rsv_free(s->context, known);
    return status;
}

rsv_status rsv_source_divide_environment(rsv_solution *s)
{
    rsv_environment_light *environment = s->lights->environment;
    s->bin_radiance = rsv_alloc(s->context, RSV_ESCAPE_BINS, sizeof *s->bin_radiance);
    if (!s->bin_radiance) return RSV_ERROR_MEMORY;
    rsv_status status = environment ? rsv_environment_light_divide(environment) : RSV_OK;
    return status == RSV_OK ? rsv_escape_radiance(s->context, environment, s->bin_radiance)
                            : status;
}
