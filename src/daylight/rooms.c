/// Sensors room by room: neighbours with nothing between them share one.
#include "../core/core.h"
#include "../core/vec.h"
#include "resolvent/daylight.h"
#include "resolvent/trace.h"

#include <stdlib.h>

/// Of the usual distance to the nearest sensor: grids are linked along their diagonals, and not from one side of a
/// doorway to the other, for they keep 0.3 m away from walls.
#define REACH 1.45f

typedef struct room_job {
    rsv_tracer *tracer;
    const rsv_probe *sensor;
    size_t count;
    uint32_t *parent; ///< [count]
    float reach;      ///< m
} room_job;

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// @param nearest [count] scratch
static float find_reach(const room_job *job, float *nearest)
{
    for (size_t k = 0; k < job->count; k++) {
        nearest[k] = INFINITY;
        for (size_t j = 0; j < job->count; j++) {
            float apart = v3_length(v3_sub(job->sensor[j].position, job->sensor[k].position));
            if (j != k && apart > 0) nearest[k] = f_min(nearest[k], apart);
        }
    }
    qsort(nearest, job->count, sizeof *nearest, compare_floats);
    return REACH * nearest[job->count / 2];
}

static uint32_t root_of(const room_job *job, uint32_t k)
{
    while (job->parent[k] != k)
        k = job->parent[k] = job->parent[job->parent[k]];
    return k;
}

static bool are_linked(const room_job *job, size_t a, size_t b)
{
    rsv_vec3 from = job->sensor[a].position, way = v3_sub(job->sensor[b].position, from);
    if (v3_length(way) > job->reach) return false;
    rsv_ray ray = { from, way, 1 };
    return !rsv_tracer_occluded(job->tracer, &ray);
}

/// The first sensor of a room stands for it.
static void link_sensors(room_job *job)
{
    for (uint32_t k = 0; k < job->count; k++)
        for (uint32_t j = 0; j < k; j++) {
            uint32_t a = root_of(job, j), b = root_of(job, k);
            if (a != b && are_linked(job, j, k)) job->parent[a > b ? a : b] = a < b ? a : b;
        }
}

rsv_status rsv_daylight_rooms(const rsv_scene *scene, const rsv_probe *sensors, size_t count,
    uint32_t *room, size_t *room_count)
{
    rsv_context *context = rsv_scene_get_context(scene);
    room_job job = { .sensor = sensors, .count = count };
    rsv_status status;
    *room_count = 0;
    float *nearest = rsv_alloc(context, count, sizeof *nearest);
    job.parent = rsv_alloc(context, count, sizeof *job.parent);
    RSV_TRY(nearest && job.parent ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_tracer_create(scene, &job.tracer));
    for (uint32_t k = 0; k < count; k++)
        job.parent[k] = k;
    if (count) job.reach = find_reach(&job, nearest);
    link_sensors(&job);
    for (uint32_t k = 0; k < count; k++) {
        uint32_t first = root_of(&job, k);
        room[k] = first == k ? (uint32_t)(*room_count)++ : room[first];
    }
cleanup:
    rsv_tracer_destroy(job.tracer);
    rsv_free(context, nearest);
    rsv_free(context, job.parent);
    return status;
}
