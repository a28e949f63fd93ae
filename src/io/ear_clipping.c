#include "ear_clipping.h"

#include "../core/core.h"
#include "../core/vec.h"

/// Each ear takes a look at all corners.
#define MOST_CORNERS 2000

/// A polygon, seen along its normal.
typedef struct flat_polygon {
    double (*p)[2]; ///< [count]
    uint32_t *left; ///< [left_count] corners not yet clipped, in order
    size_t left_count;
} flat_polygon;

/// Area vector by Newell's method, in double.
static void find_normal(
    const rsv_vec3 *position, const int64_t *corner, size_t count, double normal[3])
{
    normal[0] = normal[1] = normal[2] = 0;
    for (size_t k = 0; k < count; k++) {
        rsv_vec3 a = position[corner[k]], b = position[corner[(k + 1) % count]];
        normal[0] += ((double)a.y - (double)b.y) * ((double)a.z + (double)b.z);
        normal[1] += ((double)a.z - (double)b.z) * ((double)a.x + (double)b.x);
        normal[2] += ((double)a.x - (double)b.x) * ((double)a.y + (double)b.y);
    }
}

/// Drops the coordinate along which the normal is longest; counter-clockwise stays so.
static void flatten(const rsv_vec3 *position, const int64_t *corner, size_t count, double (*p)[2])
{
    double normal[3];
    find_normal(position, corner, count, normal);
    int axis = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    if (fabs(normal[2]) > fabs(normal[axis])) axis = 2;
    for (size_t k = 0; k < count; k++) {
        rsv_vec3 v = position[corner[k]];
        const double c[3] = { (double)v.x, (double)v.y, (double)v.z };
        p[k][0] = normal[axis] < 0 ? c[(axis + 2) % 3] : c[(axis + 1) % 3];
        p[k][1] = normal[axis] < 0 ? c[(axis + 1) % 3] : c[(axis + 2) % 3];
    }
}

static double twice_area(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
}

/// Whether corner `k` of the remaining polygon is convex, and no other corner lies in its triangle.
static bool is_ear(const flat_polygon *f, size_t k)
{
    size_t n = f->left_count;
    uint32_t ia = f->left[(k + n - 1) % n], ib = f->left[k], ic = f->left[(k + 1) % n];
    const double *a = f->p[ia], *b = f->p[ib], *c = f->p[ic];
    if (twice_area(a, b, c) <= 0) return false;
    for (size_t m = 0; m < n; m++) {
        uint32_t i = f->left[m];
        if (i == ia || i == ib || i == ic) continue;
        const double *q = f->p[i];
        bool at_corner = (q[0] == a[0] && q[1] == a[1]) || (q[0] == b[0] && q[1] == b[1]) ||
                         (q[0] == c[0] && q[1] == c[1]);
        if (!at_corner && twice_area(a, b, q) >= 0 && twice_area(b, c, q) >= 0 &&
            twice_area(c, a, q) >= 0)
            return false;
    }
    return true;
}

static void clip(flat_polygon *f, size_t k, uint32_t cut[3])
{
    size_t n = f->left_count;
    cut[0] = f->left[(k + n - 1) % n];
    cut[1] = f->left[k];
    cut[2] = f->left[(k + 1) % n];
    for (size_t m = k; m + 1 < n; m++)
        f->left[m] = f->left[m + 1];
    f->left_count--;
}

rsv_status rsv_clip_ears(rsv_context *context, const rsv_vec3 *position, const int64_t *corner,
    size_t count, uint32_t *cut)
{
    rsv_status status = RSV_OK;
    flat_polygon f = { .p = rsv_alloc(context, count, sizeof *f.p),
        .left = rsv_alloc(context, count, sizeof *f.left),
        .left_count = count };
    if (!f.p || !f.left) RSV_TRY(RSV_ERROR_MEMORY);
    flatten(position, corner, count, f.p);
    for (size_t k = 0; k < count; k++)
        f.left[k] = (uint32_t)k;
    size_t start = 1;
    for (size_t t = 0; t < count - 2; t++) {
        size_t k = count > MOST_CORNERS ? 1 : start % f.left_count, tried = 0;
        for (; count <= MOST_CORNERS && tried < f.left_count && !is_ear(&f, k); tried++)
            k = (k + 1) % f.left_count;
        clip(&f, k, &cut[3 * t]);
        start = k;
    }
cleanup:
    rsv_free(context, f.p);
    rsv_free(context, f.left);
    return status;
}
