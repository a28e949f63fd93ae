/// The part of a ray inside fog: its density, distance sampling and equiangular sampling. Formulas only.
///
/// The extinction of channel c is sigma_c times a dimensionless density. The integral of the density along the ray, the
/// column (metres), serves all channels: the transmittance is exp(-sigma_c column). Density is 1 up to a height and
/// decays exponentially above it, so a ray has at most two pieces, and columns and their inverses have closed forms.
#ifndef RSV_FOG_RUN_H
#define RSV_FOG_RUN_H

#include "../core/vec.h"
#include "resolvent/scene.h"
#include "volume.h"

/// Of [begin, end] along the ray, metres. The density is greatest at one end and falls by exp(-rate) per metre from
/// there.
typedef struct rsv_fog_piece {
    double begin, end; ///< end may be INFINITY unless the density rises
    double densest;    ///< the greatest density
    double rate;       ///< 1/m, 0 = the same all along
    bool rises;        ///< densest at the end
    double column;     ///< metres; may be INFINITY
} rsv_fog_piece;

#define RSV_FOG_STATIONS 16

typedef struct rsv_fog_run {
    rsv_fog_piece piece[2]; ///< in order; the second may be empty
    double begin, end;      ///< of both, metres
    double column;          ///< of both; 0 = no fog on this ray
    /// Where density varies on a grid, in place of the pieces: the grid, the ray through it, and the columns up to places
    /// at equal distances from begin to end. NULL = it does not.
    const rsv_volume *volume;
    rsv_grid_line line;
    double station[RSV_FOG_STATIONS + 1];
} rsv_fog_run;

/// Column from the piece's begin to s.
RSV_INLINE double rsv_fog_piece_column(const rsv_fog_piece *p, double s)
{
    if (!(p->densest > 0)) return 0;
    if (p->rate == 0) return p->densest * (s - p->begin);
    if (!p->rises) return p->densest * -expm1(-p->rate * (s - p->begin)) / p->rate;
    double near = exp(-p->rate * (p->end - s));
    return p->densest * near * -expm1(-p->rate * (s - p->begin)) / p->rate;
}

/// Where the column from the piece's begin is `column`, at most the piece's.
RSV_INLINE double rsv_fog_piece_find(const rsv_fog_piece *p, double column)
{
    double s = p->begin, share = p->rate * column / p->densest;
    if (p->rate == 0)
        s = p->begin + column / p->densest;
    else if (!p->rises)
        s = p->begin - log1p(-share) / p->rate;
    else
        s = p->end + log(share + exp(-p->rate * (p->end - p->begin))) / p->rate;
    return s > p->begin ? (s < p->end ? s : p->end) : p->begin;
}

RSV_INLINE double rsv_fog_piece_density(const rsv_fog_piece *p, double s)
{
    return p->densest * exp(-p->rate * (p->rises ? p->end - s : s - p->begin));
}

/// Cuts [*begin, *end] down to where the ray is between two planes.
RSV_INLINE void rsv_fog_clip(
    double origin, double direction, double low, double high, double *begin, double *end)
{
    if (direction == 0) {
        if (!(origin >= low && origin <= high)) *end = *begin;
        return;
    }
    double a = (low - origin) / direction, b = (high - origin) / direction;
    *begin = fmax(*begin, fmin(a, b));
    *end = fmin(*end, fmax(a, b));
}

/// @param height of the ray's origin above the fog's base, metres @param slope metres of height per metre of ray
RSV_INLINE rsv_fog_piece rsv_fog_piece_of(
    double begin, double end, double height, double slope, double scale_height)
{
    rsv_fog_piece p = { begin, end, 1, 0, false, 0 };
    if (!(end > begin)) {
        p.end = begin;
        p.densest = 0;
        return p;
    }
    double at_begin = height + (slope != 0 ? slope * begin : 0);
    // both ends are on the same side of the base: test one point of the piece
    bool above = at_begin + slope * (end < INFINITY ? 0.5 * (end - begin) : 1) > 0;
    if (above && scale_height < INFINITY) {
        p.rises = slope < 0;
        p.rate = fabs(slope) / scale_height;
        p.densest = exp(-fmax(p.rises ? height + slope * end : at_begin, 0.0) / scale_height);
    }
    p.column = rsv_fog_piece_column(&p, end);
    return p;
}

/// Cuts [*begin, *end] of a ray down to the fog's box; never below *begin.
RSV_INLINE void rsv_fog_clip_to_box(
    const rsv_fog *fog, rsv_vec3 origin, rsv_vec3 direction, double *begin, double *end)
{
    rsv_fog_clip(origin.x, direction.x, fog->bounds_min.x, fog->bounds_max.x, begin, end);
    rsv_fog_clip(origin.y, direction.y, fog->bounds_min.y, fog->bounds_max.y, begin, end);
    rsv_fog_clip(origin.z, direction.z, fog->bounds_min.z, fog->bounds_max.z, begin, end);
    *end = fmax(*end, *begin);
}

RSV_INLINE double rsv_fog_station(const rsv_fog_run *run, int k)
{
    return run->begin + (run->end - run->begin) * k / RSV_FOG_STATIONS;
}

/// Columns of a run through a grid.
RSV_INLINE void rsv_fog_integrate(rsv_fog_run *run)
{
    run->station[0] = 0;
    for (int k = 0; k < RSV_FOG_STATIONS; k++)
        run->station[k + 1] =
            run->station[k] + rsv_volume_column(run->volume, &run->line, rsv_fog_station(run, k),
                                  rsv_fog_station(run, k + 1));
    run->column = run->station[RSV_FOG_STATIONS];
}

/// The fog along a ray of unit direction up to `length` metres, which may be INFINITY.
RSV_INLINE rsv_fog_run rsv_fog_run_of(
    const rsv_fog *fog, rsv_vec3 origin, rsv_vec3 direction, float length)
{
    rsv_fog_run run;
    double begin = 0, end = length;
    rsv_fog_clip_to_box(fog, origin, direction, &begin, &end);
    run.begin = begin;
    run.end = end;
    run.volume = fog->volume;
    if (run.volume) {
        run.line = rsv_volume_line(run.volume, origin, direction);
        rsv_fog_integrate(&run);
        return run;
    }
    const rsv_grid_line none = { { 0, 0, 0 }, { 0, 0, 0 } };
    run.line = none;
    double height = (double)origin.y - fog->base_height, slope = direction.y;
    double crossing = slope != 0 && fog->scale_height < INFINITY ? -height / slope : begin;
    double middle = fmin(fmax(crossing, begin), end);
    run.piece[0] = rsv_fog_piece_of(begin, middle, height, slope, fog->scale_height);
    run.piece[1] = rsv_fog_piece_of(middle, end, height, slope, fog->scale_height);
    run.column = run.piece[0].column + run.piece[1].column;
    return run;
}

/// The last station at or before s.
RSV_INLINE int rsv_fog_station_before(const rsv_fog_run *run, double s)
{
    double share = (s - run->begin) / (run->end - run->begin) * RSV_FOG_STATIONS;
    return share > 0 ? (share < RSV_FOG_STATIONS - 1 ? (int)share : RSV_FOG_STATIONS - 1) : 0;
}

/// Column from the ray's begin to s in [begin, end].
RSV_INLINE double rsv_fog_column(const rsv_fog_run *run, double s)
{
    if (run->volume) {
        int k = rsv_fog_station_before(run, s);
        double from = rsv_fog_station(run, k);
        if (!(s > from)) return run->station[k];
        return run->station[k] +
               rsv_volume_column(run->volume, &run->line, from, fmin(s, run->end));
    }
    if (s <= run->piece[0].end) return rsv_fog_piece_column(&run->piece[0], s);
    return run->piece[0].column + rsv_fog_piece_column(&run->piece[1], s);
}

/// Inverse of rsv_fog_column. @param column at most the run's
RSV_INLINE double rsv_fog_find(const rsv_fog_run *run, double column)
{
    if (run->volume) {
        int k = 0;
        while (k < RSV_FOG_STATIONS - 1 && run->station[k + 1] < column)
            k++;
        return rsv_volume_find(run->volume, &run->line, rsv_fog_station(run, k),
            rsv_fog_station(run, k + 1), column - run->station[k]);
    }
    if (column <= run->piece[0].column && run->piece[0].column > 0)
        return rsv_fog_piece_find(&run->piece[0], column);
    if (!(run->piece[1].column > 0)) return run->end;
    return rsv_fog_piece_find(&run->piece[1], column - run->piece[0].column);
}

RSV_INLINE double rsv_fog_density(const rsv_fog_run *run, double s)
{
    if (run->volume) return rsv_volume_density(run->volume, &run->line, s);
    return rsv_fog_piece_density(&run->piece[s > run->piece[0].end], s);
}

RSV_INLINE float rsv_fog_pass(float extinction, double column)
{
    return extinction > 0 ? (float)exp(-(double)extinction * column) : 1;
}

/// Share of each channel that passes a column (Beer and Lambert).
RSV_INLINE rsv_rgb rsv_fog_transmittance(const rsv_fog *fog, double column)
{
    return rgb(rsv_fog_pass(fog->extinction.r, column), rsv_fog_pass(fog->extinction.g, column),
        rsv_fog_pass(fog->extinction.b, column));
}

/// Column after which light of one channel has met the medium, with density sigma exp(-sigma column).
/// @param u in [0, 1) @return INFINITY without extinction
RSV_INLINE double rsv_fog_free_column(float extinction, float u)
{
    return extinction > 0 ? -log1p(-(double)u) / (double)extinction : INFINITY;
}

/// Equiangular sampling (Kulla and Fajardo 2012): distances along a ray, uniform in the angle seen from a point beside
/// it, so that the density is proportional to 1 / distance^2 from that point.
typedef struct rsv_equiangular {
    double foot;       ///< metres along the ray to the place nearest to the point
    double height;     ///< metres from there to the point
    double low, angle; ///< of the interval as the point sees it, radians
} rsv_equiangular;

/// @param direction unit @param begin, end of the interval, metres; the end may be INFINITY
RSV_INLINE rsv_equiangular rsv_equiangular_of(
    rsv_vec3 origin, rsv_vec3 direction, rsv_vec3 point, double begin, double end)
{
    rsv_equiangular e;
    double x = (double)point.x - origin.x, y = (double)point.y - origin.y;
    double z = (double)point.z - origin.z;
    e.foot = x * direction.x + y * direction.y + z * direction.z;
    double a = x - e.foot * direction.x, b = y - e.foot * direction.y, c = z - e.foot * direction.z;
    // a point on the ray itself would take all the density
    e.height = fmax(sqrt(a * a + b * b + c * c), 1e-6 * (1e-6 + fabs(e.foot)));
    e.low = atan2(begin - e.foot, e.height);
    e.angle = (end < INFINITY ? atan2(end - e.foot, e.height) : M_PI / 2) - e.low;
    return e;
}

/// @param u in [0, 1)
RSV_INLINE double rsv_equiangular_sample(const rsv_equiangular *e, float u)
{
    return e->foot + e->height * tan(e->low + (double)u * e->angle);
}

/// Density per metre at s within the interval.
RSV_INLINE double rsv_equiangular_pdf(const rsv_equiangular *e, double s)
{
    double along = s - e->foot;
    return e->height / (e->angle * (e->height * e->height + along * along));
}

#endif
