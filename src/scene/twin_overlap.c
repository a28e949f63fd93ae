#include "twin_overlap.h"

#include "../core/vec.h"

/// Overlaps narrower than this part of the narrower triangle are rounding.
#define NARROW 1e-3

/// A triangle in the plane of another, counter-clockwise; heights are above that plane.
typedef struct flat_triangle {
    double x[3], y[3], height[3];
    double area, longest; ///< twice the area
} flat_triangle;

static double length_of(double x, double y) { return sqrt(x * x + y * y); }

/// @param drop the axis along which one looks; x and y are those that follow it
static flat_triangle flatten(
    const rsv_scene_view *scene, uint32_t triangle, rsv_vec3 from, rsv_vec3 normal, int drop)
{
    flat_triangle t = { .longest = 0 };
    for (int k = 0; k < 3; k++) {
        rsv_vec3 p = scene->position[scene->triangle[triangle][k]];
        double to[3] = { (double)p.x - from.x, (double)p.y - from.y, (double)p.z - from.z };
        t.x[k] = to[(drop + 1) % 3];
        t.y[k] = to[(drop + 2) % 3];
        t.height[k] = to[0] * normal.x + to[1] * normal.y + to[2] * normal.z;
    }
    t.area = (t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (t.x[2] - t.x[0]) * (t.y[1] - t.y[0]);
    if (t.area < 0) {
        double x = t.x[1], y = t.y[1], height = t.height[1];
        t.x[1] = t.x[2], t.y[1] = t.y[2], t.height[1] = t.height[2];
        t.x[2] = x, t.y[2] = y, t.height[2] = height;
        t.area = -t.area;
    }
    for (int k = 0; k < 3; k++)
        t.longest =
            fmax(t.longest, length_of(t.x[(k + 1) % 3] - t.x[k], t.y[(k + 1) % 3] - t.y[k]));
    return t;
}

static double width_of(const flat_triangle *t) { return t->longest > 0 ? t->area / t->longest : 0; }

/// How far a point lies inside an edge of a triangle.
static double depth_of(const flat_triangle *t, int edge, double x, double y)
{
    int next = (edge + 1) % 3;
    double dx = t->x[next] - t->x[edge], dy = t->y[next] - t->y[edge];
    return (dx * (y - t->y[edge]) - dy * (x - t->x[edge])) / length_of(dx, dy);
}

/// Whether an edge of one triangle has the other beyond it.
static bool has_beyond(const flat_triangle *t, const flat_triangle *other, double margin)
{
    for (int edge = 0; edge < 3; edge++) {
        double deepest = -INFINITY;
        for (int k = 0; k < 3; k++)
            deepest = fmax(deepest, depth_of(t, edge, other->x[k], other->y[k]));
        if (deepest <= margin) return true;
    }
    return false;
}

#define MOST_CORNERS 6 ///< of what two triangles share

typedef struct polygon {
    int count;
    double x[MOST_CORNERS + 1], y[MOST_CORNERS + 1];
} polygon;

/// Clips a polygon at an edge (Sutherland and Hodgman 1974).
static polygon clip(const polygon *p, const flat_triangle *t, int edge)
{
    polygon kept = { 0 };
    for (int k = 0; k < p->count; k++) {
        int next = (k + 1) % p->count;
        double here = depth_of(t, edge, p->x[k], p->y[k]);
        double there = depth_of(t, edge, p->x[next], p->y[next]);
        if (here >= 0 && kept.count <= MOST_CORNERS) {
            kept.x[kept.count] = p->x[k];
            kept.y[kept.count++] = p->y[k];
        }
        if ((here < 0) != (there < 0) && kept.count <= MOST_CORNERS) {
            double share = here / (here - there);
            kept.x[kept.count] = p->x[k] + share * (p->x[next] - p->x[k]);
            kept.y[kept.count++] = p->y[k] + share * (p->y[next] - p->y[k]);
        }
    }
    return kept;
}

/// Centre of the overlap of two triangles. False if they do not overlap.
static bool find_middle(const flat_triangle *t, const flat_triangle *other, double *x, double *y)
{
    polygon shared = { .count = 3 };
    for (int k = 0; k < 3; k++)
        shared.x[k] = other->x[k], shared.y[k] = other->y[k];
    for (int edge = 0; edge < 3; edge++)
        shared = clip(&shared, t, edge);
    *x = *y = 0;
    for (int k = 0; k < shared.count; k++) {
        *x += shared.x[k] / shared.count;
        *y += shared.y[k] / shared.count;
    }
    return shared.count >= 3;
}

/// Height of a triangle at a place, above the plane that it was flattened into.
static double height_at(const flat_triangle *t, double x, double y)
{
    double u =
        ((x - t->x[0]) * (t->y[2] - t->y[0]) - (t->x[2] - t->x[0]) * (y - t->y[0])) / t->area;
    double v =
        ((t->x[1] - t->x[0]) * (y - t->y[0]) - (x - t->x[0]) * (t->y[1] - t->y[0])) / t->area;
    return (1 - u - v) * t->height[0] + u * t->height[1] + v * t->height[2];
}

bool rsv_twins_overlap(const rsv_scene_view *scene, rsv_twin_face a, rsv_twin_face b, float reach,
    rsv_twin_overlap *overlap)
{
    rsv_vec3 n = a.normal;
    int drop = fabsf(n.x) > fabsf(n.y) ? (fabsf(n.x) > fabsf(n.z) ? 0 : 2)
                                       : (fabsf(n.y) > fabsf(n.z) ? 1 : 2);
    rsv_vec3 from = scene->position[scene->triangle[a.triangle][0]];
    flat_triangle other = flatten(scene, b.triangle, from, n, drop);
    double low = fmin(other.height[0], fmin(other.height[1], other.height[2]));
    double high = fmax(other.height[0], fmax(other.height[1], other.height[2]));
    if (low > (double)reach || high < -(double)reach) return false;
    flat_triangle own = flatten(scene, a.triangle, from, n, drop);
    double margin = NARROW * fmin(width_of(&own), width_of(&other)), x, y;
    if (has_beyond(&own, &other, margin) || has_beyond(&other, &own, margin) ||
        !find_middle(&own, &other, &x, &y))
        return false;
    overlap->opposite = v3_dot(a.normal, b.normal) < 0;
    overlap->gap = fabs(height_at(&other, x, y) - height_at(&own, x, y));
    return overlap->gap <= (double)reach;
}
