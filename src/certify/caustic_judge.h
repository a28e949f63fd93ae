/// Caustics that no gather ray can find, judged by photons that the solution knows nothing of.
///
/// Photons of two passes of their own are counted in parts of the cells that points lie in: what they bring to a part, less
/// what is stored there, is the mean of the caustic's error over it, twice without bias.
#ifndef RSV_CAUSTIC_JUDGE_H
#define RSV_CAUSTIC_JUDGE_H

#include "../solve/light.h"
#include "surface_points.h"

/// A cell is split in four so many times.
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

/// @param solution with caustics @param judge out; to be destroyed by the caller, whatever is returned
rsv_status rsv_caustic_judge_create(const rsv_light_view *solution, rsv_caustic_judge *judge);
void rsv_caustic_judge_destroy(rsv_caustic_judge *judge);

/// Before photons are shot: that a point is to be judged.
void rsv_caustic_judge_add(rsv_caustic_judge *judge, const rsv_face_point *point);

/// Shoots both passes.
rsv_status rsv_caustic_judge_shoot(rsv_caustic_judge *judge, uint32_t seed, uint64_t *rays);

/// The caustic less what is stored of it around a point that was added. @param difference out: two independent estimates, W/m2
void rsv_caustic_judge_at(
    const rsv_caustic_judge *judge, const rsv_face_point *point, rsv_rgb difference[2]);

#endif
