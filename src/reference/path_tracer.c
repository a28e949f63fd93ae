#include "../core/core.h"
#include "../scene/material_at.h"
#include "../scene/scene.h"
#include "reference_internal.h"

static rsv_status create_bsdfs(rsv_path_tracer *tracer)
{
    const rsv_scene_view *scene = tracer->scene;
    tracer->bsdf = rsv_alloc(tracer->context, scene->material_count, sizeof *tracer->bsdf);
    if (!tracer->bsdf) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < scene->material_count; i++)
        tracer->bsdf[i] = rsv_surface_common_bsdf(scene, (uint32_t)i);
    return RSV_OK;
}

/// Whether it redirects light of a point light in a direction that no path from elsewhere samples, as lenses, mirrors,
/// panes and polished surfaces do. Light that goes straight through thin sheets is found.
static bool mirrors(const rsv_bsdf *b)
{
    bool polished = b->metallic > 0 || b->transmission > 0 ||
                    ((b->ior > 1 || b->film.share > 0) && !rgb_is_black(b->specular_tint));
    if (b->lambert || b->unlit) return false;
    return (polished && b->alpha == 0) || (b->clearcoat > 0 && b->clearcoat_alpha == 0);
}

static void warn_of_unreachable_caustics(const rsv_path_tracer *tracer)
{
    if (tracer->scene->light_count == 0) return;
    for (size_t i = 0; i < tracer->scene->material_count; i++) {
        if (!mirrors(&tracer->bsdf[i])) continue;
        rsv_log(tracer->context, RSV_LOG_WARNING,
            "material '%s': mode reference leaves out its reflections and caustics of punctual lights; use an "
            "emissive surface to include them",
            tracer->scene->material[i].name);
        return;
    }
}

static rsv_status connect(rsv_path_tracer *tracer, const rsv_scene *scene)
{
    const rsv_transport_scene transport = { .scene = scene,
        .view = tracer->scene,
        .tracer = tracer->tracer,
        .bsdf = tracer->bsdf,
        .media = tracer->media };
    return rsv_connections_create(&transport, tracer->lights, &tracer->connections);
}

rsv_status rsv_path_tracer_create(const rsv_scene *scene, bool connected, rsv_path_tracer **result)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_path_tracer *tracer = NULL;
    RSV_TRY(rsv_scene_require_committed(scene));
    tracer = rsv_alloc(context, 1, sizeof *tracer);
    RSV_TRY(tracer ? RSV_OK : RSV_ERROR_MEMORY);
    tracer->context = context;
    tracer->scene = rsv_scene_get_view(scene);
    RSV_TRY(create_bsdfs(tracer));
    RSV_TRY(rsv_lights_create(scene, tracer->bsdf, &tracer->lights));
    rsv_lights_warn_if_dark(tracer->lights);
    RSV_TRY(rsv_tracer_create(scene, &tracer->tracer));
    tracer->media = rsv_media_of(tracer->scene, tracer->tracer, tracer->bsdf);
    tracer->fog = tracer->scene->fog;
    if (tracer->fog) RSV_TRY(rsv_fog_lights_create(context, tracer->lights, &tracer->fog_lights));
    tracer->blended = rsv_find_blended(tracer->scene);
    RSV_TRY(rsv_bodies_create(scene, tracer->tracer, &tracer->bodies));
    if (connected && !tracer->fog)
        RSV_TRY(connect(tracer, scene));
    else
        warn_of_unreachable_caustics(tracer);
    *result = tracer;
    tracer = NULL;
cleanup:
    rsv_path_tracer_destroy(tracer);
    return status;
}

void rsv_path_tracer_destroy(rsv_path_tracer *tracer)
{
    if (!tracer) return;
    rsv_connections_destroy(tracer->connections);
    rsv_bodies_destroy(tracer->bodies);
    rsv_tracer_destroy(tracer->tracer);
    if (tracer->fog) rsv_fog_lights_destroy(&tracer->fog_lights);
    rsv_lights_destroy(tracer->lights);
    rsv_free(tracer->context, tracer->bsdf);
    rsv_free(tracer->context, tracer);
}
