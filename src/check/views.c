/// Things that cameras should not see.
#include "check_internal.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "../trace/backs.h"

#define LARGEST_SHARE_OF_BACKS 0.01
#define LARGEST_LEAK 0.03 ///< of all directions; more is a window or an open side

enum { DIRECTIONS = 16384 };

static rsv_status check_backs(rsv_checker *c, const rsv_tracer *tracer, const rsv_camera *camera)
{
    const rsv_seen_backs seen = rsv_look_for_backs(tracer, camera);
    const rsv_finding found = { .mistake = RSV_MISTAKE_BACKS, .amount = seen.share };
    if (seen.share <= LARGEST_SHARE_OF_BACKS) return RSV_OK;
    return rsv_check_tell(c, &found, camera->name,
        "camera '%.80s': %.0f %% of its view is the backs of single-sided surfaces (mostly "
        "'%.80s'), which are black; flip their normals, or use --two-sided",
        camera->name, 100 * seen.share, c->view->material[seen.material].name);
}

/// Light that leaves through gaps is lost, and light from outside comes in.
static rsv_status check_leaks(rsv_checker *c, const rsv_tracer *tracer, const rsv_camera *camera)
{
    size_t gone = 0;
    for (uint32_t k = 0; k < DIRECTIONS; k++) {
        float x, y;
        rsv_hit hit;
        rsv_sobol_2d(k, 1, &x, &y);
        const rsv_ray ray = { camera->position, rsv_square_to_sphere(x, y), INFINITY };
        gone += !rsv_tracer_closest(tracer, &ray, &hit);
    }
    const rsv_finding found = { .mistake = RSV_MISTAKE_LEAKS, .amount = (double)gone / DIRECTIONS };
    if (gone == 0 || found.amount > LARGEST_LEAK) return RSV_OK;
    return rsv_check_tell(c, &found, camera->name,
        "camera '%.80s': %.2g %% of all directions from it leave an otherwise closed room: light "
        "leaks there through gaps, or through a small window",
        camera->name, 100 * found.amount);
}

rsv_status rsv_check_views(rsv_checker *c)
{
    rsv_status status;
    rsv_tracer *tracer = NULL;
    if (c->view->triangle_count == 0) return RSV_OK;
    RSV_TRY(rsv_tracer_create(c->scene, &tracer));
    for (size_t k = 0; k < c->view->camera_count; k++) {
        RSV_TRY(check_backs(c, tracer, &c->view->camera[k]));
        RSV_TRY(check_leaks(c, tracer, &c->view->camera[k]));
    }
cleanup:
    rsv_tracer_destroy(tracer);
    return status;
}
