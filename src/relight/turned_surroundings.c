#include "turned_surroundings.h"

static void add_field(rsv_rgb *sum, const rsv_rgb *value, size_t count)
{
    for (size_t n = 0; sum && value && n < count; n++)
        sum[n] = rgb_add(sum[n], value[n]);
}

/// Light found by shadow rays and photons.
static rsv_status sample(const rsv_light *like, rsv_light *turned)
{
    const rsv_source surroundings = { RSV_SOURCE_SURROUNDINGS, 0, "environment", NULL };
    const rsv_light_view *s = rsv_light_get_view(turned);
    rsv_light_part part = { 0 };
    uint16_t *valid = NULL;
    uint64_t rays = 0;
    rsv_status status;
    RSV_TRY(rsv_find_fine_valid(like, &valid));
    rsv_light_effort effort = rsv_full_light_effort(like, valid);
    RSV_TRY(rsv_light_part_estimate(turned, s->lights, &surroundings, &effort, &part, &rays));
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        add_field(rsv_light_field(turned, field), *rsv_light_part_field(&part, field),
            rsv_light_field_length(turned, field));
cleanup:
    rsv_light_part_free(s->context, &part);
    rsv_free(s->context, valid);
    return status;
}

rsv_status rsv_turned_surroundings_solve(const rsv_light *like, float rotation, rsv_light **result)
{
    rsv_status status;
    rsv_light_sources *sources = NULL;
    rsv_light *turned = NULL;
    RSV_TRY(rsv_light_sources_turn(
        rsv_light_get_sources(like), rsv_light_get_view(like)->scene.scene, rotation, &sources));
    RSV_TRY(rsv_light_begin_like(like, sources, &turned));
    RSV_TRY(sample(like, turned));
    rsv_light_gather(turned, rgb_gray(0));
    RSV_TRY(rsv_light_solve(turned));
    *result = turned;
    turned = NULL;
cleanup:
    rsv_light_destroy(turned);
    rsv_light_sources_release(sources);
    return status;
}
