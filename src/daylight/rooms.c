/// Sensors room by room: neighbours with nothing between them share one, but not those on both sides of a doorway.
#include "rooms.h"

#include "../core/core.h"
#include "../core/vec.h"

#include <stdlib.h>

/// Of the usual distance to the nearest sensor: grids are linked along their diagonals.
#define REACH 1.45f
#define PASSAGE 1.2f          ///< m: what is narrower between walls is a doorway or a corridor
#define PASSAGE_STEP 0.05f    ///< m: thinner walls may be missed
#define PASSAGE_AXES 16       ///< directions in which passages are looked for
#define PARALLEL 0.8f         ///< cosine between the walls of a passage, at least
#define MOST_STEPS 64         ///< of a link
#define PASSAGE_HEIGHT 0.9f   ///< m above the sensors: over furniture, below lintels
#define PASSAGE_HEADROOM 0.8f ///< of the height above the sensors, at most

/// Neighbours with nothing between them.
typedef struct sensor_link {
    uint32_t a, b;
    bool narrow; ///< the way leads through a doorway, or along a corridor
} sensor_link;

typedef struct room_job {
    rsv_context *context;
    const rsv_tracer *tracer;
    const rsv_probe *sensor;
    size_t count;
    float reach;       ///< m
    uint32_t *parent;  ///< [count]
    uint32_t *size;    ///< [count] of the group of which this sensor is the first
    uint8_t *sliver;   ///< [count] 1 = that group is no room
    sensor_link *link; ///< [link_count]
    size_t link_count, link_capacity;
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

/// Above the middle of furniture, where that is possible.
static float passage_height(const room_job *job, rsv_vec3 at)
{
    rsv_ray up = { at, v3(0, 1, 0), PASSAGE_HEIGHT / PASSAGE_HEADROOM };
    rsv_hit hit;
    bool roofed = rsv_tracer_closest(job->tracer, &up, &hit);
    return roofed ? PASSAGE_HEADROOM * hit.t : PASSAGE_HEIGHT;
}

/// A wall to one side.
typedef struct side_wall {
    float distance; ///< m, PASSAGE if there is none so near
    rsv_vec3 normal;
} side_wall;

static side_wall wall_aside(const room_job *job, rsv_vec3 at, rsv_vec3 aside)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_tracer_scene(job->tracer));
    rsv_ray ray = { at, aside, PASSAGE };
    rsv_hit hit;
    if (!rsv_tracer_closest(job->tracer, &ray, &hit)) return (side_wall){ .distance = PASSAGE };
    const uint32_t *corner = view->triangle[hit.triangle];
    rsv_vec3 a = view->position[corner[0]];
    rsv_vec3 normal =
        v3_cross(v3_sub(view->position[corner[1]], a), v3_sub(view->position[corner[2]], a));
    return (side_wall){ hit.t, v3_normalize(normal) };
}

/// Whether two walls that face each other, or turn their backs, leave little room between them.
static bool is_in_passage(const room_job *job, rsv_vec3 at)
{
    for (int k = 0; k < PASSAGE_AXES; k++) {
        float turn = RSV_PI * (float)k / PASSAGE_AXES;
        rsv_vec3 aside = v3(cosf(turn), 0, sinf(turn));
        side_wall one = wall_aside(job, at, aside);
        if (one.distance >= PASSAGE) continue;
        side_wall other = wall_aside(job, at, v3_neg(aside));
        if (one.distance + other.distance < PASSAGE &&
            fabsf(v3_dot(one.normal, other.normal)) > PARALLEL)
            return true;
    }
    return false;
}

/// Whether the way leads through a passage.
static bool is_narrow(const room_job *job, uint32_t a, uint32_t b)
{
    rsv_vec3 from = job->sensor[a].position, to = job->sensor[b].position, way = v3_sub(to, from);
    float height = f_min(passage_height(job, from), passage_height(job, to));
    int steps = (int)f_min(ceilf(v3_length(way) / PASSAGE_STEP), MOST_STEPS);
    for (int k = 0; k <= steps; k++) {
        rsv_vec3 at = v3_mad(from, (float)k / (float)steps, way);
        at.y += height;
        if (is_in_passage(job, at)) return true;
    }
    return false;
}

static rsv_status find_links(room_job *job)
{
    for (uint32_t k = 0; k < job->count; k++)
        for (uint32_t j = 0; j < k; j++) {
            if (!are_linked(job, j, k)) continue;
            rsv_status status = rsv_grow(job->context, (void **)&job->link, &job->link_capacity,
                job->link_count + 1, sizeof *job->link);
            if (status != RSV_OK) return status;
            job->link[job->link_count++] = (sensor_link){ j, k, is_narrow(job, j, k) };
        }
    return RSV_OK;
}

/// The first sensor of a group stands for it.
static void unite(room_job *job, uint32_t a, uint32_t b)
{
    a = root_of(job, a), b = root_of(job, b);
    job->parent[a > b ? a : b] = a < b ? a : b;
}

/// Of the groups that are slivers so far: those of few sensors, and those of small extent, still are.
/// @param extent m @param box [count] scratch: of each group: low x, z, high x, z
static void mark_slivers(room_job *job, float extent, float (*box)[4])
{
    uint32_t *size = job->size;
    for (uint32_t k = 0; k < job->count; k++) {
        box[k][0] = box[k][1] = INFINITY, box[k][2] = box[k][3] = -INFINITY;
        size[k] = 0;
    }
    for (uint32_t k = 0; k < job->count; k++) {
        uint32_t r = root_of(job, k);
        rsv_vec3 p = job->sensor[k].position;
        box[r][0] = f_min(box[r][0], p.x), box[r][1] = f_min(box[r][1], p.z);
        box[r][2] = f_max(box[r][2], p.x), box[r][3] = f_max(box[r][3], p.z);
        size[r]++;
    }
    for (uint32_t k = 0; k < job->count; k++)
        job->sliver[k] &= size[k] < RSV_ROOM_LEAST ||
                          hypotf(box[k][2] - box[k][0], box[k][3] - box[k][1]) < extent;
}

/// Slivers with a link to a room join it: the first that they meet.
static void join_slivers(room_job *job)
{
    for (size_t k = 0; k < job->link_count; k++) {
        uint32_t a = root_of(job, job->link[k].a), b = root_of(job, job->link[k].b);
        if (job->sliver[a] == job->sliver[b]) continue;
        unite(job, a, b);
        job->sliver[root_of(job, a)] = 0;
    }
}

/// Rooms are what wide ways connect. Corridors fall apart by that and are put together again; doorways join a room.
static void form_groups(room_job *job, float (*box)[4])
{
    for (size_t k = 0; k < job->link_count; k++)
        if (!job->link[k].narrow) unite(job, job->link[k].a, job->link[k].b);
    mark_slivers(job, PASSAGE / 2, box);
    for (size_t k = 0; k < job->link_count; k++) {
        uint32_t a = root_of(job, job->link[k].a), b = root_of(job, job->link[k].b);
        if (job->sliver[a] && job->sliver[b]) unite(job, a, b);
    }
    mark_slivers(job, 2 * PASSAGE, box); // through the thickest wall, a doorway is shorter
    join_slivers(job);
}

static size_t number_rooms(const room_job *job, uint32_t *room)
{
    size_t rooms = 0;
    for (uint32_t k = 0; k < job->count; k++) {
        uint32_t first = root_of(job, k);
        room[k] = first == k ? (uint32_t)rooms++ : room[first];
    }
    return rooms;
}

rsv_status rsv_rooms_find(rsv_context *context, const rsv_tracer *tracer, rsv_sensor_list sensors,
    uint32_t *room, size_t *room_count)
{
    size_t count = sensors.count;
    room_job job = { .context = context, .tracer = tracer, .sensor = sensors.sensor, count };
    rsv_status status;
    *room_count = 0;
    float(*box)[4] = rsv_alloc(context, count, sizeof *box);
    job.parent = rsv_alloc(context, count, sizeof *job.parent);
    job.size = rsv_alloc(context, count, sizeof *job.size);
    job.sliver = rsv_alloc(context, count, sizeof *job.sliver);
    RSV_TRY(box && job.parent && job.size && job.sliver ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t k = 0; k < count; k++)
        job.parent[k] = k, job.sliver[k] = 1;
    if (count) job.reach = find_reach(&job, &box[0][0]);
    RSV_TRY(find_links(&job));
    form_groups(&job, box);
    *room_count = number_rooms(&job, room);
cleanup:
    rsv_free(context, box);
    rsv_free(context, job.parent);
    rsv_free(context, job.size);
    rsv_free(context, job.sliver);
    rsv_free(context, job.link);
    return status;
}

rsv_status rsv_daylight_rooms(const rsv_scene *scene, const rsv_probe *sensors, size_t count,
    uint32_t *room, size_t *room_count)
{
    rsv_sensor_list list = { (rsv_probe *)sensors, count };
    rsv_tracer *tracer = NULL;
    *room_count = 0;
    rsv_status status = rsv_tracer_create(scene, &tracer);
    if (status == RSV_OK)
        status = rsv_rooms_find(rsv_scene_get_context(scene), tracer, list, room, room_count);
    rsv_tracer_destroy(tracer);
    return status;
}

// ---- slivers ----------------------------------------------------------------------------------------

/// Whether a sensor of a sliver sees one of a proper room nearby.
/// @param size of rooms
static bool sees_room(const room_job *job, const uint32_t *room, const size_t *size, size_t sensor)
{
    for (size_t j = 0; j < job->count; j++)
        if (size[room[j]] >= RSV_ROOM_LEAST && are_linked(job, sensor, j)) return true;
    return false;
}

/// @param size, sliver out, [room_count]: sensors of each room, and whether it is none
static void find_slivers(const room_job *job, const uint32_t *room, size_t *size, uint8_t *sliver)
{
    for (size_t k = 0; k < job->count; k++)
        size[room[k]]++;
    for (size_t k = 0; k < job->count; k++)
        if (size[room[k]] < RSV_ROOM_LEAST && sees_room(job, room, size, k)) sliver[room[k]] = 1;
}

rsv_status rsv_rooms_drop_slivers(
    rsv_context *context, const rsv_tracer *tracer, float reach, rsv_sensor_list *sensors)
{
    room_job job = { context, tracer, sensors->sensor, sensors->count, .reach = reach };
    size_t rooms = 0, kept = 0, *size = NULL;
    uint8_t *sliver = NULL;
    rsv_status status;
    uint32_t *room = rsv_alloc(context, job.count, sizeof *room);
    RSV_TRY(room ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_rooms_find(context, tracer, *sensors, room, &rooms));
    size = rsv_alloc(context, rooms, sizeof *size);
    sliver = rsv_alloc(context, rooms, sizeof *sliver);
    RSV_TRY(size && sliver ? RSV_OK : RSV_ERROR_MEMORY);
    find_slivers(&job, room, size, sliver);
    for (size_t k = 0; k < job.count; k++)
        if (!sliver[room[k]]) sensors->sensor[kept++] = sensors->sensor[k];
    sensors->count = kept;
cleanup:
    rsv_free(context, room);
    rsv_free(context, size);
    rsv_free(context, sliver);
    return status;
}
