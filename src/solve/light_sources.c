#include "light_sources.h"

#include "../core/core.h"
#include "../core/references.h"
#include "../specular/escapes.h"

#include <string.h>

static rsv_status begin(rsv_context *context, rsv_light_sources **sources)
{
    rsv_light_sources *s = *sources = rsv_alloc(context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    s->context = context;
    s->references = 1;
    s->bin_radiance = rsv_alloc(context, RSV_ESCAPE_BINS, sizeof *s->bin_radiance);
    return s->bin_radiance ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Divides the environment between gather rays and shadow rays.
static rsv_status divide_environment(rsv_light_sources *s)
{
    rsv_environment_light *environment = s->lights->environment;
    rsv_status status = environment ? rsv_environment_light_divide(environment) : RSV_OK;
    return status == RSV_OK ? rsv_escape_radiance(s->context, environment, s->bin_radiance)
                            : status;
}

static rsv_status find_fog_lights(rsv_light_sources *s)
{
    if (!s->lights->scene->fog) return RSV_OK;
    return rsv_fog_lights_create(s->context, s->lights, &s->fog_lights);
}

rsv_status rsv_light_sources_create(
    const rsv_world *world, const rsv_lights *like, rsv_light_sources **sources)
{
    rsv_status status;
    rsv_light_sources *s = NULL;
    RSV_TRY(begin(world->context, &s));
    RSV_TRY(rsv_lights_create(world->scene.scene, world->bsdf, &s->lights));
    if (like) RSV_TRY(rsv_lights_gather_like(s->lights, like));
    RSV_TRY(divide_environment(s));
    RSV_TRY(find_fog_lights(s));
    *sources = s;
    s = NULL;
cleanup:
    rsv_light_sources_release(s);
    return status;
}

rsv_status rsv_light_sources_select(
    rsv_light_sources *whole, const rsv_source *source, size_t count, rsv_light_sources **sources)
{
    rsv_status status;
    rsv_light_sources *s = NULL;
    RSV_TRY(begin(whole->context, &s));
    s->whole = rsv_light_sources_retain(whole);
    RSV_TRY(rsv_light_subset_create(whole->lights, source, count, &s->lights));
    memcpy(s->bin_radiance, whole->bin_radiance, RSV_ESCAPE_BINS * sizeof *s->bin_radiance);
    RSV_TRY(find_fog_lights(s));
    *sources = s;
    s = NULL;
cleanup:
    rsv_light_sources_release(s);
    return status;
}

rsv_status rsv_light_sources_turn(
    rsv_light_sources *whole, const rsv_scene *scene, float rotation, rsv_light_sources **sources)
{
    static const rsv_source surroundings = { RSV_SOURCE_SURROUNDINGS, 0, "environment", NULL };
    rsv_status status;
    rsv_light_sources *s = NULL;
    RSV_TRY(rsv_light_sources_select(whole, &surroundings, 1, &s));
    RSV_TRY(rsv_environment_light_create_turned(scene, rotation, &s->environment));
    s->lights->environment = s->environment;
    RSV_TRY(rsv_escape_radiance(s->context, s->environment, s->bin_radiance));
    *sources = s;
    s = NULL;
cleanup:
    rsv_light_sources_release(s);
    return status;
}

rsv_light_sources *rsv_light_sources_retain(rsv_light_sources *s)
{
    rsv_references_add(&s->references);
    return s;
}

void rsv_light_sources_release(rsv_light_sources *s)
{
    if (!s || !rsv_references_drop(&s->references)) return;
    rsv_environment_light_destroy(s->environment);
    rsv_fog_lights_destroy(&s->fog_lights);
    if (s->whole)
        rsv_light_subset_destroy(s->lights);
    else
        rsv_lights_destroy(s->lights);
    rsv_free(s->context, s->bin_radiance);
    rsv_light_sources *whole = s->whole;
    rsv_free(s->context, s);
    rsv_light_sources_release(whole);
}
