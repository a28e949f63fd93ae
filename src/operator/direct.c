#include "direct.h"

#include <string.h>

#define LANES 16
#define BURIAL_RAYS 6 ///< all of them must see backs before a point counts as buried

/// The receiver points of one node.
typedef struct node_points {
    rsv_surface_point point[LANES];
    rsv_vec3 origin[LANES];
    uint32_t count;
    uint16_t valid;
} node_points;

typedef struct direct_job {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_elements *elements;
    uint32_t points, samples, seed;
} direct_job;

static const rsv_bsdf *node_bsdf(const direct_job *job, uint32_t node)
{
    uint32_t triangle = job->elements->face_triangle[job->elements->node_face[node]];
    return &job->scene->bsdf[job->scene->view->triangle_material[triangle]];
}

static bool sees_back(const rsv_transport_scene *scene, const rsv_ray *ray)
{
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, ray, &hit)) return false;
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[hit.triangle]];
    rsv_chain chain =
        rsv_chain_begin(scene, ray->direction, hit.triangle, hit.u, hit.v, hit.t);
    return chain.back && !bsdf->double_sided && bsdf->transmission == 0;
}

static bool is_buried(const direct_job *job, const rsv_surface_point *point, rsv_vec3 origin,
    uint32_t seed, uint64_t *rays)
{
    rsv_vec3 t, b;
    v3_frame(point->geometric, &t, &b);
    for (uint32_t k = 0; k < BURIAL_RAYS; k++) {
        float x, y;
        rsv_sobol_2d(k, seed, &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_ray ray = { origin, v3_mad(v3_mad(v3_scale(t, d.x), d.y, b), d.z, point->geometric),
            INFINITY };
        ++*rays;
        if (!sees_back(job->scene, &ray)) return false;
    }
    return true;
}

static void set_up_points(const direct_job *job, uint32_t node, const uint16_t *valid_points,
    node_points *p, uint64_t *rays)
{
    const rsv_elements *e = job->elements;
    p->count = job->points;
    p->valid = valid_points ? valid_points[node] : 0;
    for (uint32_t k = 0; k < p->count; k++) {
        uint32_t face;
        float u, v;
        rsv_elements_sample_support(e, node, k, p->count, job->seed, &face, &u, &v);
        p->point[k] =
            rsv_surface_point_at(job->scene->view, e->face_triangle[face], u, v, e->face_back[face]);
        p->origin[k] =
            rsv_offset_origin(p->point[k].position, p->point[k].geometric, p->point[k].extent);
        if (!valid_points &&
            !is_buried(job, &p->point[k], p->origin[k], rsv_hash3(job->seed, node, k), rays))
            p->valid |= (uint16_t)(1u << k);
    }
}

static void clear_packet(rsv_ray_packet *packet)
{
    for (int k = 0; k < LANES; k++)
        packet->t_max[k] = -1;
}

static void set_shadow_ray(rsv_ray_packet *packet, int lane, rsv_vec3 origin, rsv_vec3 direction,
    float distance)
{
    packet->origin_x[lane] = origin.x;
    packet->origin_y[lane] = origin.y;
    packet->origin_z[lane] = origin.z;
    packet->direction_x[lane] = direction.x;
    packet->direction_y[lane] = direction.y;
    packet->direction_z[lane] = direction.z;
    // stop short of the emitter's own surface by more than the rounding of its distance
    packet->t_max[lane] = distance * (1 - 0x1p-14f);
}

static bool faces_both(const rsv_surface_point *point, rsv_vec3 direction)
{
    return v3_dot(point->normal, direction) > 0 && v3_dot(point->geometric, direction) > 0;
}

/// Sixteen shadow rays: lane = point + points * repetition.
static void sample_emitters(const direct_job *job, uint32_t node, uint32_t first_sample,
    const node_points *p, const rsv_local_lights *local, const rsv_bsdf *bsdf, rsv_rgb *shadowed,
    rsv_rgb *open, uint64_t *rays)
{
    rsv_ray_packet packet;
    rsv_rgb contribution[LANES], entered[LANES];
    memset(&packet, 0, sizeof packet);
    memset(packet.mask, 0xff, sizeof packet.mask);
    clear_packet(&packet);
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t at = k % p->count, index = first_sample + k;
        contribution[k] = entered[k] = rgb_gray(0);
        if (!(p->valid >> at & 1)) continue;
        float x, y, select, unused;
        rsv_sobol_2d(index, rsv_hash3(job->seed, node, 1), &x, &y);
        rsv_sobol_2d(index, rsv_hash3(job->seed, node, 2), &select, &unused);
        rsv_light_sample sample;
        if (!rsv_local_lights_sample(&local[at], select, x, y, &sample)) continue;
        if (!faces_both(&p->point[at], sample.direction)) continue;
        float cos = v3_dot(p->point[at].normal, sample.direction);
        contribution[k] = rgb_scale(sample.radiance, cos / sample.pdf_solid_angle);
        entered[k] = rgb_mul(contribution[k], rsv_bsdf_entry(bsdf, cos));
        set_shadow_ray(&packet, (int)k, p->origin[at], sample.direction, sample.distance);
    }
    rsv_tracer_occluded_packet(job->scene->tracer, &packet, true);
    for (int k = 0; k < LANES; k++) {
        *open = rgb_add(*open, contribution[k]);
        if (packet.t_max[k] > 0) *shadowed = rgb_add(*shadowed, entered[k]);
    }
    *rays += LANES;
}

static float ratio(float unshadowed, float shadowed, float open)
{
    return open > 0 ? unshadowed * (shadowed / open) : 0;
}

static rsv_rgb from_emitters(const direct_job *job, uint32_t node, const node_points *p, uint64_t *rays)
{
    if (job->lights->sampled_count == 0) return rgb_gray(0);
    rsv_local_lights local[LANES];
    rsv_rgb unshadowed = rgb_gray(0), shadowed = rgb_gray(0), open = rgb_gray(0);
    float valid = (float)__builtin_popcount(p->valid);
    bool by_power = false;
    for (uint32_t k = 0; k < p->count; k++) {
        if (!(p->valid >> k & 1)) continue;
        rsv_lights_at(job->lights, p->point[k].position, p->point[k].normal, &local[k]);
        unshadowed = rgb_mad(unshadowed, 1 / valid, local[k].unshadowed);
        by_power = by_power || local[k].by_power;
    }
    if (!by_power && rgb_is_black(unshadowed)) return unshadowed;
    const rsv_bsdf *bsdf = node_bsdf(job, node);
    for (uint32_t first = 0; first < job->samples; first += LANES)
        sample_emitters(job, node, first, p, local, bsdf, &shadowed, &open, rays);
    if (by_power)
        return rgb_scale(shadowed, (float)p->count / (valid * (float)job->samples));
    return rgb(ratio(unshadowed.r, shadowed.r, open.r), ratio(unshadowed.g, shadowed.g, open.g),
        ratio(unshadowed.b, shadowed.b, open.b));
}

static rsv_rgb from_punctual(const direct_job *job, uint32_t node, const node_points *p, uint64_t *rays)
{
    rsv_rgb sum = rgb_gray(0);
    const rsv_bsdf *bsdf = node_bsdf(job, node);
    for (size_t l = 0; l < job->scene->view->light_count; l++) {
        rsv_ray_packet packet;
        rsv_rgb arriving[LANES];
        memset(&packet, 0, sizeof packet);
        memset(packet.mask, 0xff, sizeof packet.mask);
        clear_packet(&packet);
        for (uint32_t k = 0; k < p->count; k++) {
            rsv_vec3 direction;
            float distance;
            arriving[k] = rgb_gray(0);
            if (!(p->valid >> k & 1) ||
                !rsv_punctual_light(&job->scene->view->light[l], p->point[k].position, &direction,
                    &distance, &arriving[k]) ||
                !faces_both(&p->point[k], direction))
                continue;
            float cos = v3_dot(p->point[k].normal, direction);
            arriving[k] = rgb_mul(rgb_scale(arriving[k], cos), rsv_bsdf_entry(bsdf, cos));
            set_shadow_ray(&packet, (int)k, p->origin[k], direction, distance);
        }
        rsv_tracer_occluded_packet(job->scene->tracer, &packet, true);
        for (uint32_t k = 0; k < p->count; k++)
            if (packet.t_max[k] > 0) sum = rgb_add(sum, arriving[k]);
        *rays += p->count;
    }
    return rgb_scale(sum, 1 / (float)__builtin_popcount(p->valid));
}

rsv_status rsv_direct_irradiance(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *elements, uint32_t points, uint32_t samples, uint32_t seed,
    const uint16_t *valid_points, const uint8_t *known, rsv_rgb *irradiance, uint8_t *node_valid,
    uint64_t *rays)
{
    rsv_context *context = elements->context;
    direct_job job = { scene, lights, elements, points, samples, seed };
    uint64_t traced = 0;
    size_t done = 0;
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(context)) reduction(+ : traced)
    for (size_t node = 0; node < elements->node_count; node++) {
        if (known && known[node]) continue;
        irradiance[node] = rgb_gray(0);
        node_valid[node] = 1;
        if (elements->node_hanging[node] != RSV_NONE || rsv_cancelled(context)) continue;
        node_points p;
        set_up_points(&job, (uint32_t)node, valid_points, &p, &traced);
        node_valid[node] = p.valid != 0;
        if (p.valid)
            irradiance[node] = rgb_add(from_emitters(&job, (uint32_t)node, &p, &traced),
                from_punctual(&job, (uint32_t)node, &p, &traced));
        if (rsv_thread_index() == 0 && (++done & 1023) == 0)
            rsv_progress(context, "direct",
                fmin((double)(done * (size_t)rsv_threads(context)) / (double)elements->node_count, 1));
    }
    *rays += traced;
    rsv_elements_constrain(elements, irradiance);
    return rsv_progress(context, "direct", 1);
}

void rsv_fill_buried(const rsv_elements *e, const uint8_t *node_valid, rsv_rgb *value)
{
    for (size_t node = 0; node < e->node_count; node++) {
        if (node_valid[node] || e->node_hanging[node] != RSV_NONE) continue;
        rsv_rgb sum = rgb_gray(0);
        uint32_t neighbours = 0;
        for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
            for (int k = 0; k < 3; k++) {
                uint32_t other = e->cell_node[e->support[s] / 4][k];
                if (!node_valid[other] || e->node_hanging[other] != RSV_NONE) continue;
                sum = rgb_add(sum, value[other]);
                neighbours++;
            }
        }
        value[node] = neighbours ? rgb_scale(sum, 1 / (float)neighbours) : rgb_gray(0);
    }
    rsv_elements_constrain(e, value);
}
