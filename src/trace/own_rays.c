/// Rays through the hierarchies of own.c, one at a time.
#include "../bvh/bvh_trace.h"
#include "near.h"
#include "own_internal.h"
#include "packet.h"

/// The nearest hit, or any hit. Of two in one place, the fixed triangle comes first.
static bool trace(const rsv_tracer *tracer, const rsv_ray *ray, bool any, rsv_hit *hit)
{
    bool met = rsv_bvh_trace(&tracer->fixed.view, ray, any, hit);
    if (!tracer->apart || (met && any)) return met;
    rsv_ray shorter = *ray;
    rsv_hit moving;
    if (met) shorter.t_max = hit->t;
    if (!rsv_bvh_trace(&tracer->moving.view, &shorter, any, &moving)) return met;
    *hit = moving;
    return true;
}

bool rsv_tracer_closest(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit)
{
    if (!trace(tracer, ray, false, hit)) return false;
    if (tracer->head.twins) rsv_twins_settle(tracer->head.twins, ray->direction, hit);
    return true;
}

bool rsv_tracer_occluded(const rsv_tracer *tracer, const rsv_ray *ray)
{
    rsv_hit hit;
    return trace(tracer, ray, true, &hit);
}

// ---- packets ---------------------------------------------------------------------------------------

static rsv_ray ray_of(const rsv_ray_packet *p, int k)
{
    return (rsv_ray){ v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]),
        v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]), p->t_max[k] };
}

static void store_hit(
    const rsv_scene_view *scene, const rsv_hit *hit, rsv_ray_packet *packet, int k)
{
    const uint32_t *corner = scene->triangle[hit->triangle];
    rsv_vec3 a = scene->position[corner[0]];
    rsv_vec3 normal =
        v3_cross(v3_sub(scene->position[corner[1]], a), v3_sub(scene->position[corner[2]], a));
    packet->normal_x[k] = normal.x;
    packet->normal_y[k] = normal.y;
    packet->normal_z[k] = normal.z;
    packet->triangle[k] = hit->triangle;
    packet->t_max[k] = hit->t;
    packet->u[k] = hit->u;
    packet->v[k] = hit->v;
}

void rsv_tracer_closest_packet(const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent)
{
    const rsv_scene_view *scene = rsv_scene_get_view(tracer->head.scene);
    (void)coherent;
    for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_ray ray = ray_of(packet, k);
        rsv_hit hit;
        packet->triangle[k] = RSV_NONE;
        if (ray.t_max > 0 && rsv_tracer_closest(tracer, &ray, &hit))
            store_hit(scene, &hit, packet, k);
    }
}

void rsv_tracer_occluded_packet(const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent)
{
    (void)coherent;
    for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_ray ray = ray_of(packet, k);
        if (ray.t_max > 0 && rsv_tracer_occluded(tracer, &ray)) packet->t_max[k] = -INFINITY;
    }
}

// ---- triangles near a point ----------------------------------------------------------------------

/// Distance along one axis from a place to child k, or less by rounding.
static float apart_along(const rsv_bvh_node *node, int axis, int k, float place)
{
    float step = rsv_power_of_two(node->exponents >> (8 * axis) & 0xff);
    float low = node->origin[axis] + rsv_bvh_byte(node->low[axis], k) * step;
    float high = node->origin[axis] + rsv_bvh_byte(node->high[axis], k) * step;
    float slack = 0x1p-20f * (fabsf(place) + fabsf(node->origin[axis]) + 255 * step);
    return f_max(f_max(low - place, place - high) - slack, 0);
}

static bool child_is_near(const rsv_bvh_node *node, int k, rsv_vec3 point, float radius)
{
    float x = apart_along(node, 0, k, point.x), y = apart_along(node, 1, k, point.y),
          z = apart_along(node, 2, k, point.z);
    return x * x + y * y + z * z <= radius * radius;
}

/// State of a search in one hierarchy.
typedef struct near_search {
    const rsv_bvh_view *bvh;
    rsv_vec3 point;
    float radius;
    rsv_near_visitor visit;
    void *user;
    uint32_t stack[8 * RSV_BVH_DEPTH];
    int depth;
} near_search;

static void visit_child(near_search *s, const rsv_bvh_node *node, int k)
{
    uint32_t meta = node->meta[k >> 2] >> (8 * (k & 3)) & 0xff, first = meta & 31;
    if (meta == 0 || !child_is_near(node, k, s->point, s->radius)) return;
    if (first >= 24) {
        uint32_t before = node->exponents >> 24 & ((1u << (first - 24)) - 1);
        s->stack[s->depth++] = node->first_child + rsv_count_bits(before);
        return;
    }
    for (uint32_t bits = meta >> 5, t = node->first_triangle + first; bits; bits >>= 1, t++)
        s->visit(s->user, s->bvh->triangle[t].index, &s->radius);
}

static void search_near(near_search *s, const rsv_bvh_view *bvh)
{
    s->bvh = bvh;
    s->depth = 0;
    if (bvh->node_count) s->stack[s->depth++] = 0;
    while (s->depth) {
        const rsv_bvh_node *node = &bvh->node[s->stack[--s->depth]];
        for (int k = 0; k < 8; k++)
            visit_child(s, node, k);
    }
}

void rsv_tracer_visit_near(
    const rsv_tracer *tracer, rsv_vec3 point, float radius, rsv_near_visitor visit, void *user)
{
    near_search search = { .point = point, .radius = radius, .visit = visit, .user = user };
    search_near(&search, &tracer->fixed.view);
    if (tracer->apart) search_near(&search, &tracer->moving.view);
}
