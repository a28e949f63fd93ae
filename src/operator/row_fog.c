/// Rows where there is fog: each ray has a free flight, and ends in a voxel if that is shorter than its way to a
/// surface. Rows of voxels are isotropic rays of the same kind.
#include "../core/stratified.h"
#include "../elements/voxels.h"
#include "../specular/fog_flight.h"
#include "../trace/packet.h"
#include "row_tracer_internal.h"

#define LANES RSV_SUPPORT_POINTS

void rsv_row_land(const rsv_row_tracer *tracer, rsv_row_scratch *s, uint32_t ray,
    const rsv_gather *gather, rsv_rgb entered)
{
    rsv_rgb glow = rsv_fog_glow(tracer->scene->view->fog), weight = gather->path.weight;
    if (!rgb_is_black(glow))
        s->emission = rgb_add(s->emission, rgb_mul(rgb_mul(glow, weight), entered));
    uint32_t node = rsv_elements_find_voxel(tracer->elements, tracer->scene->tracer, gather->place);
    if (node != RSV_NONE) rsv_row_record_node(s, ray, node, weight, entered);
}

static rsv_ray ray_of_lane(const rsv_ray_packet *p, int k)
{
    bool meets = p->triangle[k] != RSV_NONE;
    return (rsv_ray){ v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]),
        v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]),
        meets ? p->t_max[k] : INFINITY };
}

/// The free flight of a row's ray, stratified among all of the row.
static rsv_fog_flight fly(
    const rsv_row_tracer *tracer, const rsv_row_receiver *r, uint32_t ray, const rsv_ray *way)
{
    rsv_fog_flight none = { false, v3(0, 0, 0), rgb_gray(1) };
    if (r->medium.depth) return none;
    float u_channel, u;
    rsv_sobol_2d(ray, rsv_hash3(tracer->seed, r->index, 0xf09u), &u, &u_channel);
    return rsv_fog_fly(tracer->scene->view->fog, way, rgb_gray(1), u_channel, u);
}

/// A ray that fog has met on its way to the first surface.
static rsv_gather follow_from_fog(const rsv_row_tracer *tracer, const rsv_fog_flight *flight,
    rsv_vec3 direction, rsv_random *random)
{
    const rsv_emission_wanted wanted = rsv_row_emission_wanted(tracer);
    rsv_specular_path path = rsv_specular_in_air(tracer->scene, NULL, direction);
    path.weight = flight->weight;
    return rsv_specular_gather_from_fog(tracer->scene, path, flight->place, random, &wanted);
}

void rsv_row_balance_flights(const rsv_row_tracer *tracer, rsv_row_scratch *s)
{
    const rsv_fog *fog = tracer->scene->view->fog;
    rsv_rgb sum = s->flights;
    float rays = (float)tracer->directions.count;
    // fog that scatters nothing dims each ray as much as it does
    if (!fog || rsv_fog_is_gray(fog) || rsv_fog_only_dims(fog)) return;
    if (!(sum.r > 0) || !(sum.g > 0) || !(sum.b > 0)) return;
    rsv_rgb scale = rgb(rays / sum.r, rays / sum.g, rays / sum.b);
    for (uint32_t k = 0; k < s->tinted_count; k++)
        s->tinted_weight[k] = rgb_mul(s->tinted_weight[k], scale);
    for (uint32_t k = 0; k < s->escapes.tinted_count; k++)
        s->escapes.tinted_weight[k] = rgb_mul(s->escapes.tinted_weight[k], scale);
    s->emission = rgb_mul(s->emission, scale);
}

void rsv_row_process_in_fog(const rsv_row_tracer *tracer, rsv_row_scratch *s, uint32_t first_ray,
    const rsv_row_receiver *r, const float *cos_receiver, const rsv_ray_packet *packet)
{
    for (int k = 0; k < LANES; k++) {
        uint32_t ray = first_ray + (uint32_t)k;
        bool meets = packet->triangle[k] != RSV_NONE;
        s->kind[ray] = RSV_TARGET_SPECULAR;
        if (!meets && !(packet->t_max[k] > 0)) {
            s->flights = rgb_add(s->flights, rgb_gray(1));
            continue;
        }
        rsv_ray way = ray_of_lane(packet, k);
        rsv_fog_flight flight = fly(tracer, r, ray, &way);
        s->flights = rgb_add(s->flights, flight.weight);
        rsv_rgb entered = rsv_row_entering(tracer, r, cos_receiver[k]);
        if (flight.lands) {
            rsv_random random = rsv_random_from(tracer->seed ^ 0x2b7e1516u, r->index, ray);
            rsv_gather gather = follow_from_fog(tracer, &flight, way.direction, &random);
            rsv_row_record_gather(tracer, s, ray, &gather, entered, rsv_random_float(&random));
        } else if (meets) {
            rsv_specular_path path = rsv_row_begin_path(tracer, r, packet, (uint32_t)k);
            path.length = 0;
            path.weight = rgb_mul(path.weight, flight.weight);
            rsv_row_follow_path(tracer, s, ray, r, cos_receiver[k], path);
        } else {
            rsv_escape_row_add(&s->escapes, way.direction, rgb_mul(flight.weight, entered), 0);
        }
    }
}

/// A cosine-distributed direction about z, turned into one of all: the mirror image of z about it.
static rsv_vec3 to_sphere(float x, float y, float z)
{
    return v3(2 * z * x, 2 * z * y, 2 * z * z - 1);
}

static void aim(
    const rsv_row_tracer *tracer, const rsv_row_receiver *r, uint32_t first, rsv_ray_packet *packet)
{
    const rsv_elements *e = tracer->elements;
    const rsv_directions *d = &tracer->directions;
    uint32_t voxel = r->index - (uint32_t)rsv_elements_surface_nodes(e);
    size_t at = rsv_directions_of(d, tracer->seed, r->index) + first;
    uint32_t across = rsv_hash3(tracer->seed, r->index, 0xa1u), along = rsv_hash(across);
    for (uint32_t k = 0; k < LANES; k++) {
        float u[3];
        rsv_sobol_2d(first + k, across, &u[0], &u[1]);
        u[2] = rsv_sobol_1d(first + k, along);
        rsv_ray ray = { rsv_voxel_place(e->voxels, voxel, u),
            to_sphere(d->x[at + k], d->y[at + k], d->z[at + k]), INFINITY };
        rsv_packet_set_ray(packet, k, ray);
    }
}

void rsv_row_trace_voxel(const rsv_row_tracer *tracer, uint32_t node, rsv_row_scratch *s)
{
    static const float cos[LANES] = { 0 };
    rsv_row_receiver r = { .index = node, .valid = UINT16_MAX, .in_air = true };
    uint32_t rays = tracer->directions.count;
    rsv_ray_packet packet = rsv_row_begin(tracer, &r, s);
    for (uint32_t first = 0; first < rays; first += LANES) {
        aim(tracer, &r, first, &packet);
        rsv_tracer_closest_packet(tracer->scene->tracer, &packet, false);
        rsv_row_process_in_fog(tracer, s, first, &r, cos, &packet);
    }
    rsv_row_balance_flights(tracer, s);
    s->rays += rays;
}
