/// Checks caustics that no gather ray can find, with photons that are independent of the solution.
///
/// Photons of two separate passes are counted in parts of the cells around points. The light that they bring to a part,
/// minus that stored there, is an unbiased estimate of the mean error of the caustic over it; there are two of them.
#ifndef RSV_CAUSTIC_JUDGE_H
#define RSV_CAUSTIC_JUDGE_H

#include "../solve/light.h"
#include "surface_points.h"

/// How often a cell is divided into four.
#define RSV_JUDGED_LEVELS 3
#define RSV_JUDGED_PARTS 64 ///< 4^RSV_JUDGED_LEVELS

/// Flux that landed in the parts of a cell, in units of rsv_caustic_judge.unit.
typedef struct rsv_judged_cell {
    int64_t flux[2][RSV_JUDGED_PARTS][3]; ///< of each pass
} rsv_judged_cell;

typedef struct rsv_caustic_judge {
    const rsv_light_view *solution;
    uint32_t
        *slot; ///< [cell_count of the caustic level] its judged cell; RSV_NONE = no point is there
    rsv_judged_cell *cell; ///< [cell_count]
    uint32_t cell_count;
    double unit;    ///< W
    double photons; ///< that land per W of luminance, in one pass
} rsv_caustic_judge;

/// @param solution with caustics @param judge out; destroyed by the caller, even after an error
rsv_status rsv_caustic_judge_create(const rsv_light_view *solution, rsv_caustic_judge *judge);
void rsv_caustic_judge_destroy(rsv_caustic_judge *judge);

/// Registers a point to be checked. Call it before photons are traced.
void rsv_caustic_judge_add(rsv_caustic_judge *judge, const rsv_face_point *point);

/// Shoots both passes.
rsv_status rsv_caustic_judge_shoot(rsv_caustic_judge *judge, uint32_t seed, uint64_t *rays);

/// The caustic minus its stored value, around a registered point. @param difference out: two independent estimates,
/// W/m2
void rsv_caustic_judge_at(
    const rsv_caustic_judge *judge, const rsv_face_point *point, rsv_rgb difference[2]);

#endif
