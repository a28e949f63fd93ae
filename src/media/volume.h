/// Densities on a grid of points, and their integral along a ray.
///
/// Density is trilinear between points and 0 outside the grid. Along a ray it is cubic within a cell, so that Gauss's rule
/// with two points integrates it exactly.
#ifndef RSV_MEDIA_VOLUME_H
#define RSV_MEDIA_VOLUME_H

#include "../core/vec.h"

#include <math.h>
#include <stdbool.h>

#define RSV_VOLUME_BLOCK 8 ///< cells along each axis of a block

typedef struct rsv_volume {
    uint32_t side[3];      ///< points along each axis, at least 2
    rsv_vec3 low, spacing; ///< the first point; metres from point to point
    float densest;
    float *density; ///< [side[2]][side[1]][side[0]]
    uint32_t block_side[3];
    float *
        block_densest; ///< [block_side[2]][block_side[1]][block_side[0]] over points of each block, borders included
    struct rsv_volume
        *earlier; ///< that the scene had before; variants of it may still refer to that
} rsv_volume;

/// A ray in units of cells: origin + s slope, s in metres.
typedef struct rsv_grid_line {
    double origin[3], slope[3];
} rsv_grid_line;

/// The cells along a line.
typedef struct rsv_grid_walk {
    rsv_grid_line line;
    int32_t cell[3], last[3]; ///< the cell of the piece; the last one along each axis
    double next[3];           ///< metres to the next plane
    double at, end;
} rsv_grid_walk;

RSV_INLINE rsv_grid_line rsv_volume_line(const rsv_volume *v, rsv_vec3 origin, rsv_vec3 direction)
{
    rsv_grid_line line;
    line.origin[0] = ((double)origin.x - v->low.x) / v->spacing.x;
    line.origin[1] = ((double)origin.y - v->low.y) / v->spacing.y;
    line.origin[2] = ((double)origin.z - v->low.z) / v->spacing.z;
    line.slope[0] = (double)direction.x / v->spacing.x;
    line.slope[1] = (double)direction.y / v->spacing.y;
    line.slope[2] = (double)direction.z / v->spacing.z;
    return line;
}

RSV_INLINE void rsv_grid_aim(rsv_grid_walk *w, int axis)
{
    double slope = w->line.slope[axis], plane = w->cell[axis] + (slope > 0 ? 1 : 0);
    bool leaves = slope > 0 ? w->cell[axis] >= w->last[axis] : w->cell[axis] <= 0;
    w->next[axis] = slope == 0 || leaves ? INFINITY : (plane - w->line.origin[axis]) / slope;
}

/// Finds the cell that a walk begins in, along one axis.
RSV_INLINE void rsv_grid_enter(rsv_grid_walk *w, int axis, int32_t last)
{
    double place = floor(w->line.origin[axis] + w->at * w->line.slope[axis]);
    w->last[axis] = last;
    w->cell[axis] = (int32_t)fmin(fmax(place, 0.0), (double)last);
    rsv_grid_aim(w, axis);
}

/// @param begin, end metres, within the grid @param last the last cell along each axis
RSV_INLINE rsv_grid_walk rsv_grid_begin(
    const rsv_grid_line *line, const int32_t last[3], double begin, double end)
{
    rsv_grid_walk w;
    w.line = *line;
    w.at = begin;
    w.end = end;
    rsv_grid_enter(&w, 0, last[0]); // one by one: gcc's analyser does not follow a loop
    rsv_grid_enter(&w, 1, last[1]);
    rsv_grid_enter(&w, 2, last[2]);
    return w;
}

/// Where the walk leaves its cell, metres. @param axis out: that it goes on along
RSV_INLINE double rsv_grid_exit(const rsv_grid_walk *w, int *axis)
{
    *axis = w->next[0] < w->next[1] ? 0 : 1;
    if (w->next[2] < w->next[*axis]) *axis = 2;
    return fmin(fmax(w->next[*axis], w->at), w->end);
}

RSV_INLINE void rsv_grid_advance(rsv_grid_walk *w, int axis, double exit)
{
    w->at = exit;
    if (!(exit < w->end)) return;
    w->cell[axis] += w->line.slope[axis] > 0 ? 1 : -1;
    rsv_grid_aim(w, axis);
}

RSV_INLINE void rsv_volume_last_cell(const rsv_volume *v, int32_t last[3])
{
    for (int k = 0; k < 3; k++)
        last[k] = (int32_t)v->side[k] - 2;
}

RSV_INLINE double rsv_volume_blend(double a, double b, double share) { return a + share * (b - a); }

/// Density within a cell. @param share of the cell's edges, cut to [0, 1]
RSV_INLINE double rsv_volume_in_cell(
    const rsv_volume *v, const int32_t cell[3], const double share[3])
{
    size_t line = v->side[0], plane = line * v->side[1];
    const float *d =
        v->density + (size_t)cell[2] * plane + (size_t)cell[1] * line + (size_t)cell[0];
    double x = fmin(fmax(share[0], 0.0), 1.0), y = fmin(fmax(share[1], 0.0), 1.0);
    double z = fmin(fmax(share[2], 0.0), 1.0);
    double near = rsv_volume_blend(
        rsv_volume_blend(d[0], d[1], x), rsv_volume_blend(d[line], d[line + 1], x), y);
    d += plane;
    double far = rsv_volume_blend(
        rsv_volume_blend(d[0], d[1], x), rsv_volume_blend(d[line], d[line + 1], x), y);
    return rsv_volume_blend(near, far, z);
}

/// Density on a line at s, which lies in that cell.
RSV_INLINE double rsv_volume_on_line(
    const rsv_volume *v, const rsv_grid_line *line, const int32_t cell[3], double s)
{
    double share[3];
    for (int k = 0; k < 3; k++)
        share[k] = line->origin[k] + s * line->slope[k] - cell[k];
    return rsv_volume_in_cell(v, cell, share);
}

/// Density on a line at s; 0 outside the grid.
RSV_INLINE double rsv_volume_density(const rsv_volume *v, const rsv_grid_line *line, double s)
{
    int32_t cell[3];
    for (int k = 0; k < 3; k++) {
        double place = line->origin[k] + s * line->slope[k], last = (double)v->side[k] - 1;
        // by rounding, the ends of a clipped ray may lie a little outside
        if (!(place > -1e-3 && place < last + 1e-3)) return 0;
        cell[k] = (int32_t)fmin(fmax(floor(place), 0.0), last - 1);
    }
    return rsv_volume_on_line(v, line, cell, s);
}

/// Integral over [begin, end] within one cell.
RSV_INLINE double rsv_volume_piece(
    const rsv_volume *v, const rsv_grid_line *line, const int32_t cell[3], double begin, double end)
{
    double middle = 0.5 * (begin + end), half = 0.5 * (end - begin),
           aside = half * 0.57735026918962576;
    return half * (rsv_volume_on_line(v, line, cell, middle - aside) +
                      rsv_volume_on_line(v, line, cell, middle + aside));
}

RSV_INLINE bool rsv_volume_is_clear(const rsv_volume *v, const int32_t cell[3])
{
    size_t x = (size_t)cell[0] / RSV_VOLUME_BLOCK, y = (size_t)cell[1] / RSV_VOLUME_BLOCK;
    size_t z = (size_t)cell[2] / RSV_VOLUME_BLOCK;
    return !(v->block_densest[(z * v->block_side[1] + y) * v->block_side[0] + x] > 0);
}

/// Integral of the density over [begin, end] of a line within the grid, metres.
RSV_INLINE double rsv_volume_column(
    const rsv_volume *v, const rsv_grid_line *line, double begin, double end)
{
    int32_t last[3];
    double sum = 0;
    rsv_volume_last_cell(v, last);
    rsv_grid_walk w = rsv_grid_begin(line, last, begin, end);
    while (w.at < end) {
        int axis;
        double exit = rsv_grid_exit(&w, &axis);
        if (exit > w.at && !rsv_volume_is_clear(v, w.cell))
            sum += rsv_volume_piece(v, line, w.cell, w.at, exit);
        rsv_grid_advance(&w, axis, exit);
    }
    return sum;
}

/// Where the integral from `begin` on is `column`, which is at most that over the cell's piece: by Newton's method within
/// an interval that shrinks.
RSV_INLINE double rsv_volume_invert(const rsv_volume *v, const rsv_grid_line *line,
    const int32_t cell[3], const double piece[2], double column)
{
    double low = piece[0], high = piece[1], s = 0.5 * (low + high);
    for (int k = 0; k < 50 && high - low > 1e-12 * fabs(high); k++) {
        double excess = rsv_volume_piece(v, line, cell, piece[0], s) - column;
        if (fabs(excess) <= 1e-13 * column) break;
        if (excess > 0)
            high = s;
        else
            low = s;
        double density = rsv_volume_on_line(v, line, cell, s);
        double guess = density > 0 ? s - excess / density : low;
        s = guess > low && guess < high ? guess : 0.5 * (low + high);
    }
    return s;
}

/// Where the integral from `begin` on is `column`; `end` if it is less all along.
RSV_INLINE double rsv_volume_find(
    const rsv_volume *v, const rsv_grid_line *line, double begin, double end, double column)
{
    int32_t last[3];
    rsv_volume_last_cell(v, last);
    rsv_grid_walk w = rsv_grid_begin(line, last, begin, end);
    while (w.at < end) {
        int axis;
        double exit = rsv_grid_exit(&w, &axis);
        if (exit > w.at && !rsv_volume_is_clear(v, w.cell)) {
            double here = rsv_volume_piece(v, line, w.cell, w.at, exit);
            const double piece[2] = { w.at, exit };
            if (here >= column && here > 0)
                return rsv_volume_invert(v, line, w.cell, piece, column);
            column -= here;
        }
        rsv_grid_advance(&w, axis, exit);
    }
    return end;
}

#endif
