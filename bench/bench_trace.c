#include "benchmarks.h"

#include "parallel.h"
#include "resolvent/trace.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { picture_size = 512, tile_size = 4, ray_count = picture_size * picture_size };
enum { packet_count = ray_count / RSV_PACKET_WIDTH };

/// Each figure repeats its rays for at least this long and takes the fastest pass.
static const double measuring_time = 0.6;

/// One set of rays in both layouts, and the query that a pass makes.
typedef struct workload {
    const rsv_tracer *tracer;
    rsv_ray *rays;           ///< [ray_count]
    rsv_ray_packet *packets; ///< [packet_count], the same rays
    uint32_t threads;
    bool coherent;
} workload;

/// Traces a span of the rays or packets.
typedef void (*pass)(void *job, size_t begin, size_t end);

static rsv_vec3 mad(rsv_vec3 a, float s, rsv_vec3 b)
{
    return (rsv_vec3){ a.x + s * b.x, a.y + s * b.y, a.z + s * b.z };
}

static float dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static rsv_vec3 cross(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

static rsv_vec3 unit(rsv_vec3 a) { return mad((rsv_vec3){ 0, 0, 0 }, 1 / sqrtf(dot(a, a)), a); }

/// Uniform in [0, 1), a function of its arguments only (SplitMix64, Steele et al. 2014).
static float random_number(uint64_t index, uint64_t dimension)
{
    uint64_t z = 4 * index + dimension + 1;
    z *= 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (float)((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

/// Through the centre of the ray's pixel; sixteen rays in a row share a tile of 4 x 4 pixels.
static rsv_ray camera_ray(const rsv_camera *camera, uint32_t index)
{
    uint32_t tile = index / (tile_size * tile_size), within = index % (tile_size * tile_size);
    uint32_t tiles_across = picture_size / tile_size;
    uint32_t x = tile % tiles_across * tile_size + within % tile_size;
    uint32_t y = tile / tiles_across * tile_size + within / tile_size;
    float u = 2 * ((float)x + 0.5f) / picture_size - 1,
          v = 1 - 2 * ((float)y + 0.5f) / picture_size;
    if (camera->vertical_fov > 0) {
        float half = tanf(0.5f * camera->vertical_fov);
        rsv_vec3 direction =
            mad(mad(camera->forward, u * half, camera->right), v * half, camera->up);
        return (rsv_ray){ camera->position, direction, INFINITY };
    }
    float half = camera->vertical_extent;
    rsv_vec3 origin = mad(mad(camera->position, u * half, camera->right), v * half, camera->up);
    return (rsv_ray){ origin, camera->forward, INFINITY };
}

/// The geometric normal of a triangle, on the side that `ray` comes from.
static rsv_vec3 facing_normal(const rsv_scene_view *view, uint32_t triangle, const rsv_ray *ray)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]];
    rsv_vec3 normal =
        unit(cross(mad(view->position[corner[1]], -1, a), mad(view->position[corner[2]], -1, a)));
    return dot(normal, ray->direction) <= 0 ? normal : mad((rsv_vec3){ 0, 0, 0 }, -1, normal);
}

/// Cosine-distributed about `normal`: a point of the unit sphere added to the normal's tip.
static rsv_vec3 cosine_direction(rsv_vec3 normal, uint32_t index)
{
    float z = 1 - 2 * random_number(index, 0), phi = 6.2831853f * random_number(index, 1);
    float radius = sqrtf(fmaxf(0, 1 - z * z)) * 0.9999f;
    return mad(normal, 1, (rsv_vec3){ radius * cosf(phi), radius * sinf(phi), 0.9999f * z });
}

/// Rays that leave the surfaces the camera sees; where it sees none, the camera ray itself.
static void make_bounce_rays(const workload *camera, rsv_ray *bounce)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_tracer_scene(camera->tracer));
    for (uint32_t i = 0; i < ray_count; i++) {
        rsv_hit hit;
        bounce[i] = camera->rays[i];
        if (!rsv_tracer_closest(camera->tracer, &camera->rays[i], &hit)) continue;
        rsv_vec3 normal = facing_normal(view, hit.triangle, &camera->rays[i]);
        rsv_vec3 point = mad(camera->rays[i].origin, hit.t, camera->rays[i].direction);
        float extent = rsv_triangle_extent(view, hit.triangle);
        bounce[i] = (rsv_ray){ rsv_offset_origin(point, normal, extent),
            cosine_direction(normal, i), INFINITY };
    }
}

/// Segments between random pairs of points that the camera sees: the queries of shadow rays and form factors.
static void make_segments(const rsv_ray *bounce, rsv_ray *segments)
{
    for (uint32_t i = 0; i < ray_count; i++) {
        uint32_t other = (uint32_t)(random_number(i, 2) * ray_count);
        rsv_vec3 direction = mad(bounce[other].origin, -1, bounce[i].origin);
        segments[i] =
            (rsv_ray){ bounce[i].origin, direction, dot(direction, direction) > 0 ? 0.999f : -1 };
    }
}

static void fill_packets(const rsv_ray *rays, rsv_ray_packet *packets)
{
    for (uint32_t i = 0; i < ray_count; i++) {
        rsv_ray_packet *packet = &packets[i / RSV_PACKET_WIDTH];
        uint32_t lane = i % RSV_PACKET_WIDTH;
        packet->origin_x[lane] = rays[i].origin.x;
        packet->origin_y[lane] = rays[i].origin.y;
        packet->origin_z[lane] = rays[i].origin.z;
        packet->direction_x[lane] = rays[i].direction.x;
        packet->direction_y[lane] = rays[i].direction.y;
        packet->direction_z[lane] = rays[i].direction.z;
    }
}

/// Queries overwrite t_max, so every pass resets it.
static void set_lengths(rsv_ray_packet *packet, const rsv_ray *rays)
{
    for (uint32_t lane = 0; lane < RSV_PACKET_WIDTH; lane++)
        packet->t_max[lane] = rays[lane].t_max;
}

static void closest_single(void *job, size_t begin, size_t end)
{
    const workload *work = job;
    for (size_t i = begin; i < end; i++) {
        rsv_hit hit;
        rsv_tracer_closest(work->tracer, &work->rays[i], &hit);
    }
}

static void closest_packet(void *job, size_t begin, size_t end)
{
    const workload *work = job;
    for (size_t i = begin; i < end; i++) {
        set_lengths(&work->packets[i], &work->rays[i * RSV_PACKET_WIDTH]);
        rsv_tracer_closest_packet(work->tracer, &work->packets[i], work->coherent);
    }
}

static void occluded_single(void *job, size_t begin, size_t end)
{
    const workload *work = job;
    for (size_t i = begin; i < end; i++)
        rsv_tracer_occluded(work->tracer, &work->rays[i]);
}

static void occluded_packet(void *job, size_t begin, size_t end)
{
    const workload *work = job;
    for (size_t i = begin; i < end; i++) {
        set_lengths(&work->packets[i], &work->rays[i * RSV_PACKET_WIDTH]);
        rsv_tracer_occluded_packet(work->tracer, &work->packets[i], work->coherent);
    }
}

static double rays_per_second(pass trace, size_t count, workload *work)
{
    double started = cli_seconds(), fastest = INFINITY;
    while (cli_seconds() - started < measuring_time && !cli_interrupted()) {
        double pass_started = cli_seconds();
        cli_parallel_for(work->threads, count, 1024 * count / ray_count, trace, work);
        fastest = fmin(fastest, cli_seconds() - pass_started);
    }
    return ray_count / fastest;
}

/// Measures both layouts of one set of rays.
static void measure_pair(workload *work, pass single, pass packet, const char *single_name,
    const char *packet_name, cJSON *result)
{
    fill_packets(work->rays, work->packets);
    cJSON_AddNumberToObject(result, single_name, rays_per_second(single, ray_count, work));
    cJSON_AddNumberToObject(result, packet_name, rays_per_second(packet, packet_count, work));
}

static void measure_all(workload *work, rsv_ray *rays, rsv_ray *bounce, cJSON *result)
{
    const rsv_scene *scene = rsv_tracer_scene(work->tracer);
    const rsv_camera *camera = rsv_scene_get_view(scene)->camera;
    for (uint32_t i = 0; i < ray_count; i++)
        rays[i] = camera_ray(camera, i);
    work->rays = rays;
    work->coherent = true;
    measure_pair(work, closest_single, closest_packet, "camera_single", "camera_packet", result);
    make_bounce_rays(work, bounce);
    work->rays = bounce;
    work->coherent = false;
    measure_pair(work, closest_single, closest_packet, "cosine_single", "cosine_packet", result);
    make_segments(bounce, rays);
    work->rays = rays;
    measure_pair(
        work, occluded_single, occluded_packet, "occlusion_single", "occlusion_packet", result);
}

static rsv_status measure_scene(const rsv_scene *scene, uint32_t threads, cJSON *result)
{
    rsv_tracer *tracer = NULL;
    double started = cli_seconds();
    rsv_status status = rsv_tracer_create(scene, &tracer);
    if (status != RSV_OK) return status;
    cJSON_AddNumberToObject(result, "bvh_s", cli_seconds() - started);
    rsv_ray *rays = calloc(ray_count, sizeof *rays), *bounce = calloc(ray_count, sizeof *bounce);
    rsv_ray_packet *packets = aligned_alloc(64, packet_count * sizeof *packets);
    if (rays && bounce && packets) {
        for (size_t i = 0; i < packet_count; i++)
            packets[i] = (rsv_ray_packet){ 0 };
        workload work = { .tracer = tracer, .packets = packets, .threads = threads };
        measure_all(&work, rays, bounce, cJSON_AddObjectToObject(result, "rays_per_second"));
        if (cli_interrupted()) status = RSV_ERROR_CANCELLED;
    } else {
        status = RSV_ERROR_MEMORY;
    }
    free(rays);
    free(bounce);
    free(packets);
    rsv_tracer_destroy(tracer);
    return status;
}

bool cli_bench_trace(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_scene(bench->session, bench->scene, NULL);
    if (!scene) return false;
    cJSON_AddNumberToObject(result, "triangles", (double)rsv_scene_get_view(scene)->triangle_count);
    rsv_status status = measure_scene(scene, bench->threads, result);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_trace(const cJSON *result)
{
    const cJSON *member;
    cJSON_ArrayForEach(member, result)
    {
        if (cJSON_IsNumber(member)) printf("  %-20s %.4g\n", member->string, member->valuedouble);
    }
    cJSON_ArrayForEach(member, cJSON_GetObjectItem(result, "rays_per_second"))
    {
        printf("  %-20s %.4g M rays/s\n", member->string, 1e-6 * member->valuedouble);
    }
}
