/// Measures the error of a bake: random values are compared with independent estimates of the same light, which do not
/// use the stored light of elements there.
#ifndef RSV_BAKE_JUDGE_H
#define RSV_BAKE_JUDGE_H

#include "bake_direct.h"
#include "resolvent/bake.h"

typedef struct rsv_bake_judged {
    rsv_rgb light; ///< as baked
    rsv_bake_patch patch;
} rsv_bake_judged;

typedef struct rsv_bake_judge {
    const rsv_light_view *light;
    uint32_t wanted; ///< values, about
    rsv_bake_judged *value;
    size_t count, capacity;
    rsv_bake_visitor visitor; ///< receives the values of the bake
} rsv_bake_judge;

/// If `wanted` is 0, no errors are measured.
rsv_status rsv_bake_judge_create(
    const rsv_light_view *light, uint32_t wanted, rsv_bake_judge *judge);

/// @param dark W/m2, lower limit of the light to which errors are relative @param report out: the errors
rsv_status rsv_bake_judge_finish(const rsv_bake_judge *judge, float dark, rsv_bake_report *report);

void rsv_bake_judge_destroy(rsv_bake_judge *judge);

#endif
