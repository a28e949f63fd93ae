/// Sensors on grids above the floors.
#include "../core/core.h"
#include "../core/vec.h"
#include "rooms.h"

#define LEVEL_HEIGHT 0.05f ///< metres: surfaces so close in height are one level
#define LEVELS 4096
#define FLOOR_SHARE 0.25 ///< of the largest level's area: less is furniture
#define FACES_UP 0.99f
#define CLEARANCE 0.3f ///< metres to walls and furniture
#define ASIDE 8
#define MOST_SENSORS 4000
#define MOST_CELLS (1 << 22)
#define SLIVER_REACH 3.0f ///< spacings from a sensor in a doorway to one of a room

typedef struct grid_job {
    rsv_context *context;
    const rsv_scene_view *view;
    rsv_tracer *tracer;
    double *area; ///< [LEVELS] of surfaces that face up
    float height, spacing;
    bool in_solids; ///< keep sensors that backs of walls surround
    rsv_probe *sensor;
    size_t count, capacity;
} grid_job;

/// Twice its area, upwards.
static rsv_vec3 normal_of(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]];
    return v3_cross(v3_sub(view->position[corner[1]], a), v3_sub(view->position[corner[2]], a));
}

/// The level of a triangle that faces up; RSV_NONE = it does not.
static uint32_t level_of(const grid_job *job, uint32_t triangle)
{
    rsv_vec3 n = normal_of(job->view, triangle);
    bool both = job->view->material[job->view->triangle_material[triangle]].double_sided;
    float up = both ? fabsf(n.y) : n.y;
    if (!(up > FACES_UP * v3_length(n)) || !(v3_length(n) > 0)) return RSV_NONE;
    float y = job->view->position[job->view->triangle[triangle][0]].y - job->view->bounds_min.y;
    float level = y / LEVEL_HEIGHT;
    return level >= 0 && level < LEVELS ? (uint32_t)level : RSV_NONE;
}

static void find_levels(grid_job *job)
{
    for (uint32_t t = 0; t < job->view->triangle_count; t++) {
        uint32_t level = level_of(job, t);
        if (level != RSV_NONE) job->area[level] += 0.5 * (double)v3_length(normal_of(job->view, t));
    }
}

/// A floor whose surface is split between two levels by rounding counts as one.
static bool is_floor(const grid_job *job, uint32_t level)
{
    double most = 0, near = job->area[level];
    for (int k = 0; k < LEVELS; k++)
        most = fmax(most, job->area[k]);
    if (level > 0) near = fmax(near, job->area[level - 1]);
    if (level + 1 < LEVELS) near = fmax(near, job->area[level + 1]);
    return near >= FLOOR_SHARE * most;
}

/// The directions in which a sensor looks for walls.
static rsv_vec3 aside(int k)
{
    float turn = 2 * RSV_PI / ASIDE * (float)k;
    return v3(cosf(turn), 0, sinf(turn));
}

static bool is_clear(const grid_job *job, rsv_vec3 at)
{
    for (int k = 0; k < ASIDE; k++) {
        rsv_ray ray = { at, aside(k), CLEARANCE };
        if (rsv_tracer_occluded(job->tracer, &ray)) return false;
    }
    return true;
}

/// Whether a ray ends on the back of a surface that has none to show.
static bool meets_back(const grid_job *job, rsv_vec3 at, rsv_vec3 direction)
{
    rsv_ray ray = { at, direction, INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(job->tracer, &ray, &hit)) return false;
    return !job->view->material[job->view->triangle_material[hit.triangle]].double_sided &&
           v3_dot(normal_of(job->view, hit.triangle), direction) > 0;
}

/// As in a column or a thick wall that stands on the floor. It may end in faces of the floor, the ceiling and other walls,
/// so not all that surrounds the sensor needs to be backs.
static bool is_inside_solid(const grid_job *job, rsv_vec3 at)
{
    int backs = 0;
    for (int k = 0; k < ASIDE && !job->in_solids; k++)
        backs += meets_back(job, at, aside(k));
    return backs > ASIDE / 2;
}

/// Whether a sensor above (x, z) stands over that floor, roofed over, with nothing next to it.
static bool stands(const grid_job *job, uint32_t triangle, rsv_vec3 at)
{
    rsv_ray down = { at, v3(0, -1, 0), INFINITY }, up = { at, v3(0, 1, 0), INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(job->tracer, &down, &hit) || hit.triangle != triangle) return false;
    return rsv_tracer_occluded(job->tracer, &up) && is_clear(job, at) && !is_inside_solid(job, at);
}

static rsv_status add_sensor(grid_job *job, rsv_vec3 at)
{
    rsv_status status = rsv_grow(
        job->context, (void **)&job->sensor, &job->capacity, job->count + 1, sizeof *job->sensor);
    if (status == RSV_OK) job->sensor[job->count++] = (rsv_probe){ at, v3(0, 1, 0) };
    return status;
}

/// Twice the signed area of a triangle seen from above.
static float turn_of(rsv_vec3 a, rsv_vec3 b, float x, float z)
{
    return (b.x - a.x) * (z - a.z) - (b.z - a.z) * (x - a.x);
}

/// Grid points of the whole scene that lie over one triangle; those on an edge belong to whichever the ray downwards
/// meets.
static rsv_status fill_triangle(grid_job *job, uint32_t triangle)
{
    const rsv_scene_view *v = job->view;
    rsv_vec3 c[3], low = v3(INFINITY, 0, INFINITY), high = v3(-INFINITY, 0, -INFINITY);
    for (int k = 0; k < 3; k++) {
        c[k] = v->position[v->triangle[triangle][k]];
        low.x = f_min(low.x, c[k].x), low.z = f_min(low.z, c[k].z);
        high.x = f_max(high.x, c[k].x), high.z = f_max(high.z, c[k].z);
    }
    float s = job->spacing, x0 = v->bounds_min.x + s / 2, z0 = v->bounds_min.z + s / 2;
    rsv_status status = RSV_OK;
    for (float j = ceilf((low.z - z0) / s - 1e-3f); z0 + j * s <= high.z + 1e-3f * s; j++)
        for (float i = ceilf((low.x - x0) / s - 1e-3f); x0 + i * s <= high.x + 1e-3f * s; i++) {
            float x = x0 + i * s, z = z0 + j * s;
            float a = turn_of(c[0], c[1], x, z), b = turn_of(c[1], c[2], x, z),
                  d = turn_of(c[2], c[0], x, z);
            float slack = 1e-4f * s * s;
            bool inside = (a >= -slack && b >= -slack && d >= -slack) ||
                          (a <= slack && b <= slack && d <= slack);
            rsv_vec3 at = v3(x, c[0].y + job->height, z);
            if (inside && stands(job, triangle, at)) status = add_sensor(job, at);
            if (status != RSV_OK) return status;
        }
    return RSV_OK;
}

static rsv_status fill(grid_job *job)
{
    rsv_status status = RSV_OK;
    job->count = 0;
    for (uint32_t t = 0; t < job->view->triangle_count && status == RSV_OK; t++) {
        uint32_t level = level_of(job, t);
        if (level != RSV_NONE && is_floor(job, level)) status = fill_triangle(job, t);
        if (job->count > MOST_SENSORS) break;
    }
    return status;
}

/// So that the scene's outline holds no more grid points than can be looked at.
static float widest_needed(const grid_job *job)
{
    rsv_vec3 size = v3_sub(job->view->bounds_max, job->view->bounds_min);
    return sqrtf(size.x * size.z / MOST_CELLS);
}

static rsv_status drop_slivers(grid_job *job)
{
    rsv_sensor_list list = { job->sensor, job->count };
    rsv_status status =
        rsv_rooms_drop_slivers(job->context, job->tracer, SLIVER_REACH * job->spacing, &list);
    if (status == RSV_OK && list.count < job->count)
        rsv_log(job->context, RSV_LOG_INFO,
            "daylight: %zu sensors in doorways and other gaps between rooms are left out",
            job->count - list.count);
    job->count = list.count;
    return status;
}

rsv_status rsv_daylight_sensors(
    const rsv_scene *scene, double height, double spacing, rsv_probe **sensors, size_t *count)
{
    grid_job job = { .context = rsv_scene_get_context(scene),
        .view = rsv_scene_get_view(scene),
        .height = (float)height };
    rsv_status status;
    *sensors = NULL, *count = 0;
    if (!(height > 0 && height < 1e3) || !(spacing > 0 && spacing < 1e3))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "daylight: sensors need a height and a spacing above 0, in metres");
    job.spacing = f_max((float)spacing, widest_needed(&job));
    job.area = rsv_alloc(job.context, LEVELS, sizeof *job.area);
    RSV_TRY(job.area ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_tracer_create(scene, &job.tracer));
    find_levels(&job);
    RSV_TRY(fill(&job));
    job.in_solids = job.count == 0; // all walls may face outwards
    if (job.in_solids) RSV_TRY(fill(&job));
    for (int k = 0; job.count > MOST_SENSORS && k < 64; k++) {
        job.spacing *= 1.25f;
        RSV_TRY(fill(&job));
    }
    RSV_TRY(job.count
                ? RSV_OK
                : rsv_fail(RSV_ERROR_SCENE, "daylight: no floor under a roof was found to put "
                                            "sensors on; list them with --points"));
    RSV_TRY(drop_slivers(&job));
    *sensors = job.sensor, *count = job.count;
    job.sensor = NULL;
cleanup:
    rsv_tracer_destroy(job.tracer);
    rsv_free(job.context, job.area);
    rsv_free(job.context, job.sensor);
    return status;
}

void rsv_daylight_free_sensors(const rsv_scene *scene, rsv_probe *sensors)
{
    rsv_free(rsv_scene_get_context(scene), sensors);
}
