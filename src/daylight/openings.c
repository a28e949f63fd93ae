/// Which rooms get their daylight by horizontal openings: EN 17037 has other values for those.
#include "../core/core.h"
#include "../core/parallel.h"
#include "../core/sampling.h"
#include "resolvent/daylight.h"
#include "resolvent/trace.h"

#define RAYS 256      ///< of each sensor
#define MOST_PANES 64 ///< surfaces that a ray passes, at most
#define OTHER_SHARE                                                                                \
    0.05 ///< of the sky that a room sees: less through other openings does not count
#define HORIZONTAL                                                                                 \
    0.9659f ///< cosine of 15 degrees, the pitch up to which EN 1873 speaks of rooflights

typedef struct opening_job {
    const rsv_scene_view *view;
    rsv_tracer *tracer;
    const rsv_probe *sensor;
    uint32_t (*seen)
        [2]; ///< [sensor count] rays to the sky: all, and those by other than horizontal openings
} opening_job;

static bool lets_through(const rsv_material *m)
{
    return m->transmission > 0 || m->diffuse_transmission > 0 || m->opacity < 1;
}

static rsv_vec3 normal_of(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]];
    return v3_normalize(
        v3_cross(v3_sub(view->position[corner[1]], a), v3_sub(view->position[corner[2]], a)));
}

/// What a ray meets on its straight way out.
typedef enum way_out { BLOCKED, BY_HORIZONTAL, BY_OTHER } way_out;

/// Panes pass the ray straight, whether or not they scatter. Openings without a pane are not known to be horizontal.
static way_out follow(const opening_job *job, rsv_vec3 origin, rsv_vec3 direction)
{
    way_out way = BY_OTHER;
    for (int panes = 0; panes < MOST_PANES; panes++) {
        rsv_ray ray = { origin, direction, INFINITY };
        rsv_hit hit;
        if (!rsv_tracer_closest(job->tracer, &ray, &hit)) return way;
        if (!lets_through(&job->view->material[job->view->triangle_material[hit.triangle]]))
            return BLOCKED;
        rsv_vec3 normal = normal_of(job->view, hit.triangle);
        bool horizontal = fabsf(normal.y) >= HORIZONTAL;
        way = horizontal && (panes == 0 || way == BY_HORIZONTAL) ? BY_HORIZONTAL : BY_OTHER;
        if (v3_dot(normal, direction) < 0) normal = v3_neg(normal);
        origin = rsv_offset_origin(v3_add(origin, v3_scale(direction, hit.t)), normal,
            rsv_triangle_extent(job->view, hit.triangle));
    }
    return BLOCKED;
}

static void look_out(void *data, rsv_span span)
{
    const opening_job *job = data;
    for (size_t s = span.begin; s < span.end; s++) {
        rsv_vec3 normal = v3_normalize(job->sensor[s].normal);
        rsv_vec3 origin = rsv_tracer_receiver_origin(job->tracer, job->sensor[s].position, normal);
        for (uint32_t k = 0; k < RAYS; k++) {
            float x, y;
            rsv_sobol_2d(k, (uint32_t)s, &x, &y);
            rsv_vec3 direction = v3_turned_to(normal, rsv_square_to_cosine_hemisphere(x, y));
            way_out way = direction.y > 0 ? follow(job, origin, direction) : BLOCKED;
            job->seen[s][0] += way != BLOCKED;
            job->seen[s][1] += way == BY_OTHER;
        }
    }
}

/// @param seen [sensor count] of sensors @param room of sensors @param wanted the room
static bool is_rooflit(
    const uint32_t (*seen)[2], size_t count, const uint32_t *room, uint32_t wanted)
{
    double all = 0, other = 0;
    for (size_t s = 0; s < count; s++)
        if (room[s] == wanted) all += seen[s][0], other += seen[s][1];
    return all > 0 && other <= OTHER_SHARE * all;
}

rsv_status rsv_daylight_rooflit(const rsv_scene *scene, const rsv_probe *sensors, size_t count,
    const uint32_t *room, size_t room_count, bool *rooflit)
{
    rsv_context *context = rsv_scene_get_context(scene);
    opening_job job = { .view = rsv_scene_get_view(scene), .sensor = sensors };
    rsv_status status;
    job.seen = rsv_alloc(context, count, sizeof *job.seen);
    RSV_TRY(job.seen ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_tracer_create(scene, &job.tracer));
    rsv_parallel_for(context, count, 16, look_out, &job);
    for (size_t r = 0; r < room_count; r++)
        rooflit[r] = is_rooflit((const uint32_t(*)[2])job.seen, count, room, (uint32_t)r);
cleanup:
    rsv_tracer_destroy(job.tracer);
    rsv_free(context, job.seen);
    return status;
}
