#include "world.h"

#include "../core/references.h"
#include "../elements/cell_visibility.h"
#include "../scene/scene.h"
#include "../scene/variant.h"
#include "../trace/tracer_update.h"

void rsv_world_find_bsdfs(rsv_world *w)
{
    w->scene.no_insides = true;
    for (uint32_t m = 0; m < w->scene.view->material_count; m++) {
        const rsv_bsdf *bsdf = &w->bsdf[m];
        w->bsdf[m] = rsv_surface_common_bsdf(w->scene.view, m);
        w->scene.no_insides = w->scene.no_insides && !rsv_bounds_body(bsdf);
    }
}

static rsv_status begin(rsv_context *context, const rsv_scene *scene, rsv_world **world)
{
    rsv_world *w = *world = rsv_alloc(context, 1, sizeof *w);
    if (!w) return RSV_ERROR_MEMORY;
    w->context = context;
    w->references = 1;
    w->scene.scene = scene;
    w->scene.view = rsv_scene_get_view(scene);
    w->bsdf = rsv_alloc(context, w->scene.view->material_count, sizeof *w->bsdf);
    if (!w->bsdf) return RSV_ERROR_MEMORY;
    w->scene.bsdf = w->bsdf;
    rsv_world_find_bsdfs(w);
    return RSV_OK;
}

static void use_tracer(rsv_world *w, const rsv_tracer *tracer)
{
    w->scene.tracer = tracer;
    w->scene.media = rsv_media_of(w->scene.view, tracer, w->bsdf);
}

rsv_status rsv_world_create(const rsv_scene *scene, rsv_world **world)
{
    rsv_world *w = NULL;
    rsv_status status;
    double start = rsv_seconds();
    RSV_TRY(rsv_scene_refuse_endless_fog(scene, "a solution"));
    RSV_TRY(begin(rsv_scene_get_context(scene), scene, &w));
    RSV_TRY(rsv_tracer_create(scene, &w->tracer));
    use_tracer(w, w->tracer);
    w->build_seconds = rsv_seconds() - start;
    *world = w;
    return RSV_OK;
cleanup:
    rsv_world_release(w);
    return status;
}

rsv_status rsv_world_vary(rsv_world *base, rsv_world **variant)
{
    rsv_world *w = NULL;
    rsv_scene *scene = NULL;
    rsv_status status = rsv_scene_vary(base->scene.scene, &scene);
    if (status != RSV_OK) return status;
    status = begin(base->context, scene, &w);
    if (!w) {
        rsv_scene_destroy(scene);
        return status;
    }
    w->variant = scene;
    w->base = rsv_world_retain(base);
    RSV_TRY(status);
    // a scene whose triangles are moved must not be shared
    if (base->variant && base->tracer) RSV_TRY(rsv_tracer_create(scene, &w->tracer));
    use_tracer(w, w->tracer ? w->tracer : base->scene.tracer);
    *variant = w;
    return RSV_OK;
cleanup:
    rsv_world_release(w);
    return status;
}

rsv_status rsv_world_vary_places(rsv_world *w, const bool *moves)
{
    rsv_status status;
    RSV_TRY(rsv_scene_vary_positions(w->variant));
    if (!w->tracer) RSV_TRY(rsv_tracer_create(w->variant, &w->tracer));
    use_tracer(w, w->tracer);
    RSV_TRY(rsv_tracer_set_apart(w->tracer, moves));
cleanup:
    return status;
}

rsv_status rsv_world_vary_triangles(rsv_world *w, const uint8_t *moves)
{
    rsv_status status;
    RSV_TRY(rsv_scene_vary_positions(w->variant));
    RSV_TRY(rsv_scene_vary_normals(w->variant));
    if (!w->tracer) RSV_TRY(rsv_tracer_create(w->variant, &w->tracer));
    use_tracer(w, w->tracer);
    RSV_TRY(rsv_tracer_set_triangles_apart(w->tracer, moves));
cleanup:
    return status;
}

rsv_status rsv_world_follow_places(rsv_world *w)
{
    rsv_status status = rsv_scene_update_bounds(w->variant);
    return status == RSV_OK ? rsv_tracer_update(w->tracer) : status;
}

rsv_status rsv_world_follow_places_in_haste(rsv_world *w)
{
    rsv_status status = rsv_scene_update_bounds_only(w->variant);
    return status == RSV_OK ? rsv_tracer_update(w->tracer) : status;
}

rsv_world *rsv_world_retain(rsv_world *w)
{
    rsv_references_add(&w->references);
    return w;
}

void rsv_world_release(rsv_world *w)
{
    if (!w || !rsv_references_drop(&w->references)) return;
    rsv_world *base = w->base;
    rsv_tracer_destroy(w->tracer);
    rsv_scene_destroy(w->variant);
    rsv_free(w->context, w->bsdf);
    rsv_free(w->context, w);
    rsv_world_release(base);
}
