/// Bare shadow rays, the yardstick for moved lights.
#include "benchmarks.h"

#include "parallel.h"
#include "resolvent/trace.h"

#include <math.h>
#include <stdlib.h>

struct cli_shadow_rays {
    rsv_tracer *tracer;
    rsv_ray_packet *packet; ///< [packet_count]
    size_t packet_count;
    uint32_t threads;
};

/// Metres between the ends of the rays at most, along each axis: a lamp.
static const float lamp_side = 0.1f;

static float dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// From a vertex to one of sixteen places around the light. False where it looks away.
static bool aim(const rsv_scene_view *view, uint32_t vertex, rsv_vec3 light, uint32_t lane,
    rsv_ray_packet *packet)
{
    rsv_vec3 at = view->position[vertex], normal = view->normal[vertex];
    rsv_vec3 origin = rsv_offset_origin(at, normal, 0);
    float x = ((float)(lane % 4) / 3 - 0.5f) * lamp_side;
    float z = ((float)(lane / 4) / 3 - 0.5f) * lamp_side;
    rsv_vec3 d = { light.x + x - origin.x, light.y - origin.y, light.z + z - origin.z };
    if (!(dot(d, normal) > 0)) return false;
    packet->origin_x[lane] = origin.x;
    packet->origin_y[lane] = origin.y;
    packet->origin_z[lane] = origin.z;
    packet->direction_x[lane] = d.x;
    packet->direction_y[lane] = d.y;
    packet->direction_z[lane] = d.z;
    return true;
}

/// Vertices in the order of the mesh, which lie side by side; round again where there are too few.
static void fill(cli_shadow_rays *rays, const rsv_scene_view *view, rsv_vec3 light)
{
    size_t wanted = rays->packet_count * RSV_PACKET_WIDTH, count = 0, most = 64 * wanted;
    for (size_t k = 0; k < most && count < wanted; k++) {
        rsv_ray_packet *packet = &rays->packet[count / RSV_PACKET_WIDTH];
        uint32_t vertex = (uint32_t)(k % view->vertex_count);
        count += aim(view, vertex, light, (uint32_t)(count % RSV_PACKET_WIDTH), packet);
    }
    rays->packet_count = count / RSV_PACKET_WIDTH;
    for (size_t p = 0; p < rays->packet_count; p++)
        for (int lane = 0; lane < RSV_PACKET_WIDTH; lane++)
            rays->packet[p].mask[lane] = UINT32_MAX;
}

rsv_status cli_shadow_rays_create(
    const rsv_scene *scene, rsv_vec3 light, size_t count, uint32_t threads, cli_shadow_rays **rays)
{
    cli_shadow_rays *r = *rays = calloc(1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    r->threads = threads;
    r->packet_count = count / RSV_PACKET_WIDTH;
    r->packet = aligned_alloc(64, (r->packet_count + 1) * sizeof *r->packet);
    if (!r->packet) return RSV_ERROR_MEMORY;
    for (size_t p = 0; p <= r->packet_count; p++)
        r->packet[p] = (rsv_ray_packet){ .t_min = { 0 } };
    fill(r, rsv_scene_get_view(scene), light);
    return rsv_tracer_create(scene, &r->tracer);
}

typedef struct occlusion_job {
    const cli_shadow_rays *rays;
    bool coherent;
} occlusion_job;

static void trace_packets(void *user, size_t begin, size_t end)
{
    const occlusion_job *job = user;
    for (size_t p = begin; p < end; p++) {
        rsv_ray_packet *packet = &job->rays->packet[p];
        for (int lane = 0; lane < RSV_PACKET_WIDTH; lane++)
            packet->t_max[lane] = 0.999f;
        rsv_tracer_occluded_packet(job->rays->tracer, packet, job->coherent);
    }
}

double cli_shadow_rays_time(const cli_shadow_rays *rays, bool coherent)
{
    occlusion_job job = { rays, coherent };
    double start = cli_seconds();
    cli_parallel_for(rays->threads, rays->packet_count, 64, trace_packets, &job);
    return cli_seconds() - start;
}

void cli_shadow_rays_destroy(cli_shadow_rays *rays)
{
    if (!rays) return;
    rsv_tracer_destroy(rays->tracer);
    free(rays->packet);
    free(rays);
}
