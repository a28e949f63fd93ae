#include "scatter_integral.h"

#define NODES 8

/// Gauss-Legendre on [-1, 1].
static const float gauss_node[NODES] = { -0.96028986f, -0.79666648f, -0.52553241f, -0.18343464f,
    0.18343464f, 0.52553241f, 0.79666648f, 0.96028986f };
static const float gauss_weight[NODES] = { 0.10122854f, 0.22238103f, 0.31370665f, 0.36268378f,
    0.36268378f, 0.31370665f, 0.22238103f, 0.10122854f };
/// Range of the edge parameter that one rule covers.
#define PANEL 2.5f

typedef struct point_2d {
    float x, y;
} point_2d;

static float cross_2d(point_2d a, point_2d b) { return a.x * b.y - a.y * b.x; }

/// Integrals of p and of p times position, per channel: parts of each ray of a fan, which are added up at the end.
typedef struct moments {
    float mass[3][NODES], x[3][NODES], y[3][NODES];
} moments;

static float sum_over_rays(const float part[NODES])
{
    return ((part[0] + part[1]) + (part[2] + part[3])) +
           ((part[4] + part[5]) + (part[6] + part[7]));
}

/// 1 - (1 + x) exp(-x), with `e` = exp(-x).
static inline float ramp(float x, float e)
{
    float series = x * x * (0.5f - x * (1.0f / 3 - x / 8));
    return x > 0.05f ? 1 - (1 + x) * e : series;
}

/// int_0^r s^2 p(s) ds, times 8 pi; `wide` = exp(-r / (3 d)).
static inline float radial_moment(float d, float r, float wide)
{
    float x = r / d;
    return d * (ramp(x, wide * wide * wide) + 9 * ramp(x / 3, wide));
}

/// int sqrt(s^2 - h^2) ds / int s ds from h to r: by how much height shortens a radial moment.
static inline float shortening(float h, float r, float rho)
{
    bool flat = h <= 1e-4f * r;
    float log = rsv_log_above_one(flat ? 1 : (r + rho) / h);
    return flat ? 1 : (r * rho - h * h * log) / (rho * rho);
}

static float arsinh(float x)
{
    float y = fabsf(x);
    return copysignf(rsv_log_above_one(y + sqrtf(y * y + 1)), x);
}

/// Height of the point above the plane, and the integrals up to it, from which rays in the plane start.
typedef struct foot_height {
    float h, wide[3], moment[3];
} foot_height;

/// Rays in the plane, from the foot to points of an edge.
typedef struct ray_fan {
    float x[NODES], y[NODES]; ///< ends, metres
    float r[NODES];           ///< distance of the ends from the place
    float angle[NODES];       ///< of the plane, per ray
    float arm[NODES];         ///< angle of a first moment, per metre
} ray_fan;

/// Along a ray p has its distribution function for integral. Its first moment is taken as if the plane went through
/// the place, and shortened.
static void add_fan(
    const rsv_scatter_profile *profile, const foot_height *foot, const ray_fan *fan, moments *sum)
{
    for (int c = 0; c < 3; c++) {
        float d = profile->d[c], before = foot->wide[c], before3 = before * before * before;
        float *mass = sum->mass[c], *x = sum->x[c], *y = sum->y[c];
#pragma omp simd
        for (int k = 0; k < NODES; k++) {
            float wide = rsv_exp_negative(-fan->r[k] / (3 * d));
            float share = 0.25f * (before3 - wide * wide * wide) + 0.75f * (before - wide);
            float first = (radial_moment(d, fan->r[k], wide) - foot->moment[c]) * fan->arm[k];
            mass[k] += fan->angle[k] * share;
            x[k] += first * fan->x[k];
            y[k] += first * fan->y[k];
        }
    }
}

/// The triangle between the foot (0, 0) and an edge, signed. With t = e sinh u along an edge at distance e the
/// angle is du / cosh u: smooth however close the edge passes.
static void add_edge(const rsv_scatter_profile *profile, const foot_height *foot, point_2d a,
    point_2d b, moments *sum)
{
    float dx = b.x - a.x, dy = b.y - a.y, length = sqrtf(dx * dx + dy * dy);
    if (!(length > 0)) return;
    dx /= length, dy /= length;
    float signed_distance = a.x * dy - a.y * dx, e = fabsf(signed_distance), h = foot->h;
    if (e < 1e-6f * length) return;
    float t0 = a.x * dx + a.y * dy, u0 = arsinh(t0 / e), u1 = arsinh((t0 + length) / e);
    int panels = 1 + (int)((u1 - u0) / PANEL);
    float half = 0.5f * (u1 - u0) / (float)panels;
    for (int panel = 0; panel < panels; panel++) {
        ray_fan fan;
        float middle = u0 + half * (float)(2 * panel + 1);
#pragma omp simd
        for (int k = 0; k < NODES; k++) {
            float u = middle + half * gauss_node[k];
            float shrunk = rsv_exp_negative(-fabsf(u)), grown = 1 / shrunk;
            float cosh_u = 0.5f * (grown + shrunk);
            float sinh_u = copysignf(0.5f * (grown - shrunk), u);
            float along = e * sinh_u - t0, rho = e * cosh_u;
            fan.x[k] = a.x + along * dx;
            fan.y[k] = a.y + along * dy;
            fan.r[k] = sqrtf(h * h + rho * rho);
            fan.angle[k] = copysignf(half * gauss_weight[k] / cosh_u, signed_distance);
            fan.arm[k] = fan.angle[k] * shortening(h, fan.r[k], rho) / rho;
        }
        add_fan(profile, foot, &fan, sum);
    }
}

static foot_height height_over(const rsv_scatter_profile *profile, float h)
{
    foot_height result = { .h = h };
    for (int c = 0; c < 3; c++) {
        result.wide[c] = rsv_exp_negative(-h / (3 * profile->d[c]));
        result.moment[c] = radial_moment(profile->d[c], h, result.wide[c]);
    }
    return result;
}

void rsv_scatter_integrate(
    const rsv_scatter_profile *profile, const rsv_vec3 corner[3], rsv_rgb weight[3])
{
    rsv_vec3 n = v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])), t, b;
    float area2 = v3_length(n);
    for (int k = 0; k < 3; k++)
        weight[k] = rgb_gray(0);
    if (!(area2 > 0)) return;
    n = v3_scale(n, 1 / area2);
    v3_frame(n, &t, &b);
    point_2d p[3];
    for (int k = 0; k < 3; k++)
        p[k] = (point_2d){ v3_dot(t, corner[k]), v3_dot(b, corner[k]) };
    foot_height foot = height_over(profile, fabsf(v3_dot(n, corner[0])));
    moments sum = { 0 };
    for (int k = 0; k < 3; k++)
        add_edge(profile, &foot, p[k], p[(k + 1) % 3], &sum);
    float mass[3], x[3], y[3];
    for (int c = 0; c < 3; c++) {
        mass[c] = sum_over_rays(sum.mass[c]) / (2 * RSV_PI);
        x[c] = sum_over_rays(sum.x[c]) / (8 * RSV_PI);
        y[c] = sum_over_rays(sum.y[c]) / (8 * RSV_PI);
    }
    for (int k = 0; k < 3; k++) {
        // barycentric weight at the foot and its gradient
        point_2d q = p[(k + 1) % 3], r = p[(k + 2) % 3];
        float at_foot = cross_2d(q, r) / area2, gx = (q.y - r.y) / area2, gy = (r.x - q.x) / area2;
        weight[k] = rgb(at_foot * mass[0] + gx * x[0] + gy * y[0],
            at_foot * mass[1] + gx * x[1] + gy * y[1], at_foot * mass[2] + gx * x[2] + gy * y[2]);
    }
}
