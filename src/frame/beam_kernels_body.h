/// Part of packet_kernels_body.h: finding the triangles of a beam, and packets that meet them.
#include "../bvh/bvh_trace.h"
#include "../sources/double3.h"
#include "../trace/packet_settle.h"

/// Beams that visit more nodes are not worth it.
#define MOST_NODES 96

/// Nearest points count as behind the farthest only where they are so by more than rounding.
#define BEHIND 1.00002f

/// A half space: points whose offset from the eye, times `normal`, is at least -offset.
typedef struct beam_plane {
    float normal[3], offset;
    float size; ///< of the normal
} beam_plane;

/// A beam in the making. Depths are multiples of corner directions.
typedef struct beam_search {
    const rsv_beams *beams;
    rsv_vec3 eye;
    beam_plane plane[5];               ///< four sides, and the farthest depth that may be seen
    rsv_float4 side[3];                ///< the four sides' normals, by component
    rsv_float4 corner[3];              ///< directions along the beam's edges, by component
    float longest;                     ///< of them
    uint32_t flip;                     ///< as in rsv_bvh_ray
    float nearest[RSV_BEAM_TRIANGLES]; ///< depth of each triangle
    rsv_beam *beam;
} beam_search;

static inline float vector_size(const float a[3])
{
    return fabsf(a[0]) + fabsf(a[1]) + fabsf(a[2]);
}

static inline beam_plane beam_plane_of(rsv_vec3 normal, float offset)
{
    beam_plane plane = { { normal.x, normal.y, normal.z }, offset, 0 };
    plane.size = vector_size(plane.normal);
    return plane;
}

static inline float greatest(rsv_float4 a) { return f_max(f_max(a[0], a[1]), f_max(a[2], a[3])); }

static inline float least(rsv_float4 a) { return f_min(f_min(a[0], a[1]), f_min(a[2], a[3])); }

static inline rsv_float4 product4(const rsv_float4 a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// @param low, high of the rays, across and upwards
static inline void aim_beam(
    const rsv_beam_lens *lens, const float low[2], const float high[2], beam_search *s)
{
    const rsv_camera *c = &lens->lens.camera;
    s->eye = c->position;
    s->plane[0] = beam_plane_of(v3_mad(lens->across, -low[0], lens->depth), 0);
    s->plane[1] = beam_plane_of(v3_sub(v3_scale(lens->depth, high[0]), lens->across), 0);
    s->plane[2] = beam_plane_of(v3_mad(lens->upwards, -low[1], lens->depth), 0);
    s->plane[3] = beam_plane_of(v3_sub(v3_scale(lens->depth, high[1]), lens->upwards), 0);
    s->plane[4] = beam_plane_of(v3_neg(lens->depth), INFINITY);
    s->longest = 0;
    for (int k = 0; k < 4; k++) {
        rsv_vec3 d = v3_mad(v3_mad(c->forward, k & 1 ? high[0] : low[0], c->right),
            k & 2 ? high[1] : low[1], c->up);
        s->corner[0][k] = d.x, s->corner[1][k] = d.y, s->corner[2][k] = d.z;
        s->longest = f_max(s->longest, v3_max_abs(d));
        for (int axis = 0; axis < 3; axis++)
            s->side[axis][k] = s->plane[k].normal[axis];
    }
    s->flip = 0;
    for (int axis = 0; axis < 3; axis++)
        if (s->corner[axis][0] + s->corner[axis][3] < 0) s->flip |= 1u << axis;
}

// ---- triangles ----------------------------------------------------------------------------------

static inline void round_vector(rsv_double3 from, double sign, float to[3])
{
    to[0] = (float)(sign * from.x), to[1] = (float)(sign * from.y), to[2] = (float)(sign * from.z);
}

/// @return the sixfold volume between triangle and eye
static inline double see_triangle(rsv_vec3 eye, const rsv_bvh_triangle *t, rsv_beam_triangle *seen)
{
    const rsv_double3 p[3] = { d3_between(eye, t->a), d3_between(eye, t->b),
        d3_between(eye, t->c) };
    rsv_double3 n = d3_cross(d3_sub(p[1], p[0]), d3_sub(p[2], p[0]));
    double volume = d3_dot(p[0], n), sign = volume < 0 ? -1 : 1;
    round_vector(n, sign, seen->normal);
    for (int k = 0; k < 3; k++) {
        round_vector(d3_cross(p[(k + 1) % 3], p[(k + 2) % 3]), sign, seen->side[k]);
        seen->slack[k] = 0x1p-22f * vector_size(seen->side[k]);
    }
    seen->reach = (float)(sign * volume);
    seen->front = (float)sign;
    seen->triangle = t->index;
    return sign * volume;
}

/// Whether all corners lie beyond one side of the beam.
static inline bool lies_beside(const beam_search *s, const rsv_bvh_triangle *t)
{
    rsv_vec3 a = v3_sub(t->a, s->eye), b = v3_sub(t->b, s->eye), c = v3_sub(t->c, s->eye);
    float p[3][3] = { { a.x, a.y, a.z }, { b.x, b.y, b.z }, { c.x, c.y, c.z } };
    float reach = 0x1p-21f * f_max(v3_max_abs(a), f_max(v3_max_abs(b), v3_max_abs(c)));
    rsv_float4 at[3];
    for (int k = 0; k < 3; k++)
        at[k] = product4(s->side, p[k]);
    for (int k = 0; k < 4; k++)
        if (f_max(f_max(at[0][k], at[1][k]), at[2][k]) < -reach * s->plane[k].size) return true;
    return false;
}

/// Removes triangles behind the farthest visible depth.
static inline void drop_hidden(beam_search *s)
{
    uint32_t kept = 0;
    for (uint32_t k = 0; k < s->beam->count; k++) {
        if (s->nearest[k] > s->plane[4].offset) continue;
        s->nearest[kept] = s->nearest[k];
        s->beam->of[kept++] = s->beam->of[k];
    }
    s->beam->count = kept;
}

/// Adds a triangle if rays may meet it. @return whether the beam can still be had
static inline bool add_triangle(beam_search *s, const rsv_bvh_triangle *t)
{
    rsv_beam_triangle seen;
    if (lies_beside(s, t)) return true;
    double volume = see_triangle(s->eye, t, &seen);
    if (volume == 0) return true; // seen from its edge, or no area
    float most = f_max(f_max(seen.slack[0], seen.slack[1]), seen.slack[2]);
    if (!(volume > 1e-30 && volume < 1e30 && most < 1e30f)) return false;
    rsv_float4 along = product4(s->corner, seen.normal);
    bool covers = true;
    for (int k = 0; k < 3; k++) {
        float slack = 8 * seen.slack[k] * s->longest;
        rsv_float4 weight = product4(s->corner, seen.side[k]);
        if (greatest(weight) < -slack) return true;
        covers &= least(weight) > slack;
    }
    if (!(greatest(along) > 0)) return true;
    float nearest = seen.reach / greatest(along);
    if (nearest > s->plane[4].offset) return true;
    const rsv_scene_view *holes = s->beams->bvh.holes;
    if (holes && holes->material[holes->triangle_material[t->index]].alpha_cutoff > 0) return false;
    if (covers && least(along) > 0)
        s->plane[4].offset = f_min(s->plane[4].offset, BEHIND * (seen.reach / least(along)));
    if (s->beam->count == RSV_BEAM_TRIANGLES) drop_hidden(s);
    if (s->beam->count == RSV_BEAM_TRIANGLES) return false;
    s->nearest[s->beam->count] = nearest;
    s->beam->of[s->beam->count++] = seen;
    return true;
}

/// Orders triangles as the scene does.
static inline void sort_triangles(rsv_beam *beam)
{
    for (uint32_t k = 0; k < beam->count; k++) {
        uint32_t j = k, triangle = beam->of[k].triangle;
        for (; j > 0 && triangle < beam->of[beam->order[j - 1]].triangle; j--)
            beam->order[j] = beam->order[j - 1];
        beam->order[j] = (uint8_t)k;
    }
}

// ---- nodes --------------------------------------------------------------------------------------

typedef int32_t words4 __attribute__((vector_size(16)));

/// Boxes of a node's children as seen from the eye, four and four.
typedef struct children_boxes {
    rsv_float4 place[2][3][2]; ///< [0 = low, 1 = high][axis][half]
    float reach;               ///< by which rounding may have moved them, as in rsv_bvh_visit
} children_boxes;

static inline void place_children(
    const rsv_bvh_node *node, rsv_vec3 eye, children_boxes *restrict boxes)
{
    _Alignas(16) float place[48];
    uint8_t byte[48];
    const float to[3] = { node->origin[0] - eye.x, node->origin[1] - eye.y,
        node->origin[2] - eye.z };
    float farthest = 0, size = 0;
    memcpy(byte, node->low, 24);
    memcpy(byte + 24, node->high, 24);
    for (int k = 0; k < 48; k++)
        place[k] = (float)byte[k];
    memcpy(boxes->place, place, sizeof place);
    for (int axis = 0; axis < 3; axis++) {
        float step = rsv_power_of_two(node->exponents >> 8 * axis & 0xff);
        for (int k = 0; k < 4; k++) {
            rsv_float4 *four = &boxes->place[k / 2][axis][k % 2];
            *four = *four * step + to[axis];
        }
        farthest = f_max(farthest, fabsf(to[axis]));
        size = f_max(size, step);
    }
    boxes->reach = 0x1p-21f * (farthest + 255 * size);
}

/// Children whose boxes reach into the beam, a bit each.
static inline uint32_t find_inside(const beam_search *s, const children_boxes *boxes)
{
    words4 inside[2] = { { 1, 2, 4, 8 }, { 16, 32, 64, 128 } };
    for (int n = 0; n < 5; n++) {
        const beam_plane *p = &s->plane[n];
        const rsv_float4 *x = boxes->place[p->normal[0] > 0][0],
                         *y = boxes->place[p->normal[1] > 0][1],
                         *z = boxes->place[p->normal[2] > 0][2];
        float slack = p->offset + boxes->reach * p->size;
        for (int half = 0; half < 2; half++)
            inside[half] &=
                x[half] * p->normal[0] + y[half] * p->normal[1] + z[half] * p->normal[2] + slack >=
                0;
    }
    words4 all = inside[0] | inside[1];
    return (uint32_t)(all[0] | all[1] | all[2] | all[3]);
}

/// Tests the children of a node, as rsv_bvh_visit.
static inline void visit_children(const beam_search *s, const rsv_bvh_node *node,
    rsv_bvh_group *children, rsv_bvh_group *triangles)
{
    children_boxes boxes;
    place_children(node, s->eye, &boxes);
    uint32_t hits = 0;
    for (uint32_t inside = find_inside(s, &boxes); inside; inside &= inside - 1) {
        uint32_t k = rsv_lowest_bit(inside);
        uint32_t meta = node->meta[k >> 2] >> (8 * (k & 3)) & 0xff, first = meta & 31;
        hits |= (meta >> 5) << (first >= 24 ? first ^ s->flip : first);
    }
    children->first = node->first_child;
    children->bits = (hits & 0xff000000u) | node->exponents >> 24;
    triangles->first = node->first_triangle;
    triangles->bits = hits & 0xffffffu;
}

static bool search_beam(beam_search *s)
{
    rsv_bvh_group stack[RSV_BVH_DEPTH], group = { 0, 1u << 24 << s->flip }, triangles = { 0, 0 };
    const rsv_bvh_view *bvh = &s->beams->bvh;
    int depth = 0;
    if (bvh->node_count == 0) return true;
    for (int visited = 0; visited < MOST_NODES; visited++) {
        uint32_t node = rsv_bvh_take_child(&group, s->flip);
        if (group.bits >> 24) stack[depth++] = group;
        visit_children(s, &bvh->node[node], &group, &triangles);
        for (; triangles.bits; triangles.bits &= triangles.bits - 1)
            if (!add_triangle(s, &bvh->triangle[triangles.first + rsv_lowest_bit(triangles.bits)]))
                return false;
        if (group.bits >> 24) continue;
        if (depth == 0) return true;
        group = stack[--depth];
    }
    return false;
}

static bool gather_beam(const rsv_beams *beams, const rsv_beam_lens *lens, const float low[2],
    const float high[2], rsv_beam *beam)
{
    beam_search s = { .beams = beams, .beam = beam };
    // pixels run downwards
    float scale = lens->lens.pixel_size;
    const float least_place[2] = { (low[0] - lens->lens.half_width) * scale - lens->slack,
        (lens->lens.half_height - high[1]) * scale - lens->slack };
    const float greatest_place[2] = { (high[0] - lens->lens.half_width) * scale + lens->slack,
        (lens->lens.half_height - low[1]) * scale + lens->slack };
    beam->count = 0;
    beam->twins = beams->bvh.twins;
    aim_beam(lens, least_place, greatest_place, &s);
    if (!search_beam(&s)) return false;
    drop_hidden(&s);
    sort_triangles(beam);
    return true;
}

// ---- packets ------------------------------------------------------------------------------------

/// Weights of the triangle's corners, after the smallest of the three with their tolerances. @return whether any lane
/// may hit it
static inline bool weigh_corners(const rsv_beam_triangle *restrict t,
    const rsv_ray_packet *restrict p, float (*restrict weight)[LANES])
{
    int met = 0;
    for (int k = 0; k < LANES; k++) {
        float x = p->direction_x[k], y = p->direction_y[k], z = p->direction_z[k];
        float a = t->side[0][0] * x + t->side[0][1] * y + t->side[0][2] * z;
        float b = t->side[1][0] * x + t->side[1][1] * y + t->side[1][2] * z;
        float c = t->side[2][0] * x + t->side[2][1] * y + t->side[2][2] * z;
        weight[0][k] = f_min(f_min(a + t->slack[0], b + t->slack[1]), c + t->slack[2]);
        weight[1][k] = b;
        weight[2][k] = c;
        weight[3][k] = a + b + c;
        met |= weight[0][k] >= 0;
    }
    return met;
}

/// A lane's bits, of any type: selections between floats in memory would be compiled to branches.
typedef uint32_t __attribute__((may_alias)) lane_word;

/// @param where all bits, or none
static inline void choose(uint32_t where, float value, float *chosen)
{
    lane_word bits, *to = (lane_word *)chosen;
    memcpy(&bits, &value, sizeof bits);
    *to = (bits & where) | (*to & ~where);
}

/// Takes the triangle over where it is the nearest so far.
static inline void meet_triangle(const rsv_beam_triangle *restrict t,
    const float (*restrict weight)[LANES], rsv_ray_packet *restrict p)
{
    _Alignas(64) float distance[LANES], u[LANES], v[LANES];
    _Alignas(64) uint32_t nearer[LANES];
    float nx = t->front * t->normal[0], ny = t->front * t->normal[1], nz = t->front * t->normal[2];
    for (int k = 0; k < LANES; k++) {
        float along = t->normal[0] * p->direction_x[k] + t->normal[1] * p->direction_y[k] +
                      t->normal[2] * p->direction_z[k];
        float inverse = 1 / weight[3][k];
        distance[k] = t->reach / along;
        u[k] = f_min(f_max(weight[1][k] * inverse, 0), 1);
        v[k] = f_min(f_max(weight[2][k] * inverse, 0), 1);
        bool met = (weight[0][k] >= 0) & (weight[3][k] > 0) & (distance[k] > 0) &
                   (distance[k] <= p->t_max[k]) & (distance[k] < INFINITY);
        nearer[k] = met ? UINT32_MAX : 0;
    }
    for (int k = 0; k < LANES; k++) {
        choose(nearer[k], distance[k], &p->t_max[k]);
        choose(nearer[k], u[k], &p->u[k]);
        choose(nearer[k], v[k], &p->v[k]);
        choose(nearer[k], nx, &p->normal_x[k]);
        choose(nearer[k], ny, &p->normal_y[k]);
        choose(nearer[k], nz, &p->normal_z[k]);
        p->triangle[k] = (t->triangle & nearer[k]) | (p->triangle[k] & ~nearer[k]);
    }
}

static void meet_packet(const rsv_beam *restrict beam, rsv_ray_packet *restrict p)
{
    _Alignas(64) float weight[4][LANES];
    memset(p->triangle, 0xff, sizeof p->triangle);
    for (uint32_t k = 0; k < beam->count; k++) {
        const rsv_beam_triangle *t = &beam->of[beam->order[k]];
        if (weigh_corners(t, p, weight)) meet_triangle(t, weight, p);
    }
    if (beam->twins) rsv_packet_settle(beam->twins, p);
}
