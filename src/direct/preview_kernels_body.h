/// Included once per instruction set, with RSV_KERNELS the name of its table.
#include "preview_kernels.h"

#define LANES RSV_PACKET_WIDTH

/// One vector per lane.
typedef struct lanes3 {
    float x[LANES], y[LANES], z[LANES];
} __attribute__((aligned(64))) lanes3;

/// theta / sin(theta) from s = sin^2(theta / 2), as in polygon_irradiance.c, and from the sine: near half a turn, s is
/// 1 up to rounding.
static inline float angle_over_sine(float s, float sine)
{
    float y = s <= 0.5f ? s : 1 - s, sum = 5.872689042007551f;
    sum = sum * y - 8.694211360940244f;
    sum = sum * y + 6.85034163169621f;
    sum = sum * y - 2.3100163144858925f;
    sum = sum * y + 1.0091783377697539f;
    sum = sum * y + 0.3145556741415163f;
    sum = sum * y + 0.4645923161896395f;
    sum = sum * y + 0.5330295626025757f;
    sum = sum * y + 0.6666714347428405f;
    sum = sum * y + 0.9999999877216724f;
    float far = RSV_PI / f_max(sine, 1e-15f) - sum;
    return s <= 0.5f ? sum : far;
}

/// Twice one edge's term of Lambert's formula, from unit vectors to its ends.
static inline float edge_term(rsv_vec3 a, rsv_vec3 b, rsv_vec3 n)
{
    float cx = b.x - a.x, cy = b.y - a.y, cz = b.z - a.z;
    float s = f_min(0.25f * (cx * cx + cy * cy + cz * cz), 1);
    float vx = a.y * cz - a.z * cy, vy = a.z * cx - a.x * cz, vz = a.x * cy - a.y * cx;
    float across = n.x * vx + n.y * vy + n.z * vz;
    return angle_over_sine(s, sqrtf(vx * vx + vy * vy + vz * vz)) * across;
}

static inline float inverse_length(float x, float y, float z)
{
    return 1 / sqrtf(f_max(x * x + y * y + z * z, 1e-37f));
}

/// Corners of the polygon seen from each lane, as unit vectors, and how far above the horizon they were.
typedef struct polygon_view {
    lanes3 corner[3];
    float above[3][LANES];
    float height[LANES]; ///< of the lane above the polygon's plane
} __attribute__((aligned(64))) polygon_view;

static inline void look_at_corner(const rsv_receiver_block *restrict block, float x, float y,
    float z, lanes3 *restrict corner, float *restrict above)
{
    for (int k = 0; k < LANES; k++) {
        float dx = x - block->x[k], dy = y - block->y[k], dz = z - block->z[k];
        float scale = inverse_length(dx, dy, dz);
        above[k] = block->normal_x[k] * dx + block->normal_y[k] * dy + block->normal_z[k] * dz;
        corner->x[k] = dx * scale;
        corner->y[k] = dy * scale;
        corner->z[k] = dz * scale;
    }
}

static inline void find_height(const rsv_receiver_block *restrict block,
    const rsv_preview_polygon *restrict p, float *restrict height)
{
    for (int k = 0; k < LANES; k++) {
        float h = p->normal_x * (block->x[k] - p->x[0]) + p->normal_y * (block->y[k] - p->y[0]) +
                  p->normal_z * (block->z[k] - p->z[0]);
        height[k] = (p->double_sided ? fabsf(h) : h) > p->height ? 1.0f : 0.0f;
    }
}

/// Adds the term of an edge that is above the horizon for all lanes.
static inline void add_edge(const rsv_receiver_block *restrict block, const lanes3 *restrict a,
    const lanes3 *restrict b, float *restrict sum)
{
    for (int k = 0; k < LANES; k++)
        sum[k] += edge_term(v3(a->x[k], a->y[k], a->z[k]), v3(b->x[k], b->y[k], b->z[k]),
            v3(block->normal_x[k], block->normal_y[k], block->normal_z[k]));
}

/// Unit vectors to the places where a polygon's outline crosses the horizon.
typedef struct horizon_crossings {
    lanes3 leave; ///< goes down
    lanes3 enter; ///< rises
} horizon_crossings;

/// Adds the part of an edge that is above the horizon, and notes where it crosses.
static inline void add_part(const rsv_receiver_block *restrict block,
    const polygon_view *restrict v, int from, int to, horizon_crossings *restrict crossings,
    float *restrict sum)
{
    const lanes3 *restrict a = &v->corner[from], *restrict b = &v->corner[to];
    lanes3 *leave = &crossings->leave, *enter = &crossings->enter;
    for (int k = 0; k < LANES; k++) {
        float nx = block->normal_x[k], ny = block->normal_y[k], nz = block->normal_z[k];
        float above_a = nx * a->x[k] + ny * a->y[k] + nz * a->z[k];
        float above_b = nx * b->x[k] + ny * b->y[k] + nz * b->z[k];
        bool in_a = above_a > 0, in_b = above_b > 0;
        // the great circle through both meets the horizon where a chord between them does
        float t = above_a / (in_a == in_b ? 1 : above_a - above_b);
        float cx = a->x[k] + t * (b->x[k] - a->x[k]), cy = a->y[k] + t * (b->y[k] - a->y[k]);
        float cz = a->z[k] + t * (b->z[k] - a->z[k]), scale = inverse_length(cx, cy, cz);
        cx *= scale, cy *= scale, cz *= scale;
        bool leaves = in_a & !in_b, enters = in_b & !in_a;
        leave->x[k] = leaves ? cx : leave->x[k];
        leave->y[k] = leaves ? cy : leave->y[k];
        leave->z[k] = leaves ? cz : leave->z[k];
        enter->x[k] = enters ? cx : enter->x[k];
        enter->y[k] = enters ? cy : enter->y[k];
        enter->z[k] = enters ? cz : enter->z[k];
        rsv_vec3 first = v3(in_a ? a->x[k] : cx, in_a ? a->y[k] : cy, in_a ? a->z[k] : cz);
        rsv_vec3 last = v3(in_b ? b->x[k] : cx, in_b ? b->y[k] : cy, in_b ? b->z[k] : cz);
        float term = edge_term(first, last, v3(nx, ny, nz));
        sum[k] += (in_a | in_b) ? term : 0;
    }
}

static void sum_clipped(const rsv_receiver_block *restrict block, const polygon_view *restrict view,
    float *restrict sum)
{
    horizon_crossings crossings = { 0 };
    for (int i = 0; i < 3; i++)
        add_part(block, view, i, i < 2 ? i + 1 : 0, &crossings, sum);
    add_edge(block, &crossings.leave, &crossings.enter,
        sum); // along the horizon, back to where the polygon rises again
}

static void find_irradiance(const rsv_receiver_block *restrict block,
    const rsv_preview_polygon *restrict polygon, float *restrict irradiance)
{
    polygon_view view;
    _Alignas(64) float sum[LANES] = { 0 };
    _Alignas(64) int lit[LANES];
    int any = 0, clipped = 0;
    for (int i = 0; i < 3; i++)
        look_at_corner(
            block, polygon->x[i], polygon->y[i], polygon->z[i], &view.corner[i], view.above[i]);
    find_height(block, polygon, view.height);
    for (int k = 0; k < LANES; k++) {
        int up = (view.above[0][k] > 0) + (view.above[1][k] > 0) + (view.above[2][k] > 0);
        lit[k] = ((int)block->valid >> k & 1) & (view.height[k] > 0) & (up > 0);
        any |= lit[k];
        clipped |= lit[k] & (up < 3);
    }
    if (any && !clipped)
        for (int i = 0; i < 3; i++)
            add_edge(block, &view.corner[i], &view.corner[i < 2 ? i + 1 : 0], sum);
    else if (any)
        sum_clipped(block, &view, sum);
    for (int k = 0; k < LANES; k++)
        irradiance[k] = lit[k] ? 0.5f * fabsf(sum[k]) : 0;
}

static void aim_packet(const rsv_receiver_block *restrict b, const rsv_preview_places *restrict at,
    rsv_ray_packet *restrict packet, float *restrict share, float *restrict cosine)
{
    for (int k = 0; k < LANES; k++) {
        float x = at->x[k] - b->x[k], y = at->y[k] - b->y[k], z = at->z[k] - b->z[k];
        float inverse = inverse_length(x, y, z);
        float here = (b->normal_x[k] * x + b->normal_y[k] * y + b->normal_z[k] * z) * inverse;
        float there = -(at->normal_x[k] * x + at->normal_y[k] * y + at->normal_z[k] * z) * inverse;
        float side = ((there < 0) & (at->double_sided[k] != 0)) ? -1.0f : 1.0f;
        there *= side;
        bool lit = (here > 0) & (there > 0) & (b->valid >> k & 1);
        // moved off the source's surface as rsv_shadow_ray does
        float off = side * 0x1p-20f * f_max(at->extent[k], 1 / inverse);
        packet->origin_x[k] = b->x[k];
        packet->origin_y[k] = b->y[k];
        packet->origin_z[k] = b->z[k];
        packet->direction_x[k] = x + off * at->normal_x[k];
        packet->direction_y[k] = y + off * at->normal_y[k];
        packet->direction_z[k] = z + off * at->normal_z[k];
        packet->t_max[k] = lit ? 1.0f : -1.0f;
        share[k] = lit ? here * there / (x * x + y * y + z * z + at->spread[k]) : 0;
        cosine[k] = here;
    }
}

const rsv_preview_kernels RSV_KERNELS = { find_irradiance, aim_packet };
