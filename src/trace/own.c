/// The tracer without Embree: two hierarchies of the room bvh, one for fixed and one for moving triangles.
#include "../core/core.h"
#include "../scene/material_at.h"
#include "../scene/scene.h"
#include "own_internal.h"
#include "tracer_update.h"

static bool is_apart(const rsv_tracer *tracer, size_t triangle)
{
    return tracer->apart && tracer->apart[triangle];
}

/// A hierarchy of the triangles that are set apart, or of all others.
static rsv_status build_part(rsv_tracer *tracer, bool apart, rsv_bvh *bvh)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->head.scene);
    rsv_status status = RSV_OK;
    size_t count = 0;
    uint32_t *number = rsv_reserve(tracer->head.context, view->triangle_count + 1, sizeof *number);
    uint32_t(*corner)[3] =
        rsv_reserve(tracer->head.context, view->triangle_count + 1, sizeof *corner);
    RSV_TRY(number && corner ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < view->triangle_count; t++) {
        if (is_apart(tracer, t) != apart) continue;
        for (int k = 0; k < 3; k++)
            corner[count][k] = view->triangle[t][k];
        number[count++] = t;
    }
    rsv_bvh_destroy(bvh);
    RSV_TRY(rsv_bvh_build(
        tracer->head.context, view->position, (const uint32_t(*)[3])corner, count, bvh));
    for (size_t k = 0; k < count; k++)
        bvh->triangle[k].index = number[bvh->triangle[k].index];
    if (rsv_find_cut_out(view)) bvh->view.holes = view;
cleanup:
    rsv_free(tracer->head.context, number);
    rsv_free(tracer->head.context, corner);
    return status;
}

rsv_status rsv_tracer_create(const rsv_scene *scene, rsv_tracer **result)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_tracer *tracer = NULL;
    if (rsv_context_settings(context)->embree_device)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "ray tracing: this library is built without Embree; leave embree_device NULL");
    RSV_TRY(rsv_scene_require_committed(scene));
    tracer = rsv_alloc(context, 1, sizeof *tracer);
    RSV_TRY(tracer ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_tracer_head_begin(scene, &tracer->head));
    RSV_TRY(build_part(tracer, false, &tracer->fixed));
    *result = tracer;
    return RSV_OK;
cleanup:
    rsv_tracer_destroy(tracer);
    return status;
}

void rsv_tracer_destroy(rsv_tracer *tracer)
{
    if (!tracer) return;
    rsv_bvh_destroy(&tracer->fixed);
    rsv_bvh_destroy(&tracer->moving);
    rsv_free(tracer->head.context, tracer->apart);
    rsv_tracer_head_end(&tracer->head);
    rsv_free(tracer->head.context, tracer);
}

const rsv_scene *rsv_tracer_scene(const rsv_tracer *tracer) { return tracer->head.scene; }

// ---- triangles that move ---------------------------------------------------------------------------

static rsv_status build_both(rsv_tracer *tracer)
{
    rsv_status status = build_part(tracer, false, &tracer->fixed);
    return status == RSV_OK ? build_part(tracer, true, &tracer->moving) : status;
}

static rsv_status begin_apart(rsv_tracer *tracer)
{
    if (tracer->apart) return RSV_OK;
    size_t triangles = rsv_scene_get_view(tracer->head.scene)->triangle_count;
    tracer->apart = rsv_alloc(tracer->head.context, triangles, 1);
    return tracer->apart ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status rsv_tracer_set_apart(rsv_tracer *tracer, const bool *moves)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->head.scene);
    if (tracer->apart) return RSV_OK;
    rsv_status status = begin_apart(tracer);
    if (status != RSV_OK) return status;
    for (size_t t = 0; t < view->triangle_count; t++)
        tracer->apart[t] = moves[view->triangle_material[t]];
    return build_both(tracer);
}

rsv_status rsv_tracer_set_triangles_apart(rsv_tracer *tracer, const uint8_t *moves)
{
    size_t triangles = rsv_scene_get_view(tracer->head.scene)->triangle_count;
    bool more = false;
    for (size_t t = 0; t < triangles; t++)
        more |= moves[t] && !is_apart(tracer, t);
    if (!more) return RSV_OK;
    rsv_status status = begin_apart(tracer);
    if (status != RSV_OK) return status;
    for (size_t t = 0; t < triangles; t++)
        tracer->apart[t] |= moves[t] != 0;
    return build_both(tracer);
}

bool rsv_tracer_is_apart(const rsv_tracer *tracer) { return tracer->apart != NULL; }

rsv_status rsv_tracer_update(rsv_tracer *tracer)
{
    if (!tracer->apart) return RSV_OK; // nothing moves yet
    rsv_bvh_destroy(&tracer->head.hierarchy->bvh);
    rsv_tracer_head_find_twins(&tracer->head);
    return build_part(tracer, true, &tracer->moving);
}
