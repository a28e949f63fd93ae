/// The error of a bake, measured: values at random beside the same light estimated anew, from rays of their own and without what
/// elements store at them.
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
    rsv_bake_visitor visitor; ///< to be shown the values of the bake
} rsv_bake_judge;

/// Zero to be told apart: nothing is judged if `wanted` is 0.
rsv_status rsv_bake_judge_create(
    const rsv_light_view *light, uint32_t wanted, rsv_bake_judge *judge);

/// @param dark W/m2 beside which errors are measured @param report out: what was found of errors
rsv_status rsv_bake_judge_finish(const rsv_bake_judge *judge, float dark, rsv_bake_report *report);

void rsv_bake_judge_destroy(rsv_bake_judge *judge);

#endif
