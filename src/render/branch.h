/// Ideal branches of camera chains: which are followed, and what they are called. Plain C, also for device code.
#ifndef RSV_BRANCH_H
#define RSV_BRANCH_H

#include "../chain/chain_walk.h"
#include "../core/sampling.h"

#define RSV_FAINT_BRANCH 0.01f ///< branches below this weight play roulette

/// Whether an ideal branch is to be followed.
/// @param carried of the chain so far @param weight of the branch; made up for those that are not
RSV_INLINE bool rsv_weight_survives(rsv_rgb carried, uint32_t path, bool transmit, rsv_rgb *weight)
{
    float most = rgb_max(rgb_mul(carried, *weight));
    if (most <= 0) return false;
    if (most >= RSV_FAINT_BRANCH) return true;
    if (rsv_unit_float(rsv_hash2(path, transmit)) * RSV_FAINT_BRANCH >= most) return false;
    *weight = rgb_scale(*weight, RSV_FAINT_BRANCH / most);
    return true;
}

RSV_INLINE bool rsv_branch_survives(
    const rsv_chain *chain, uint32_t path, bool transmit, rsv_rgb *weight)
{
    return rsv_weight_survives(chain->weight, path, transmit, weight);
}

/// The path of the link at the end of an ideal branch.
RSV_INLINE uint32_t rsv_branch_path(uint32_t path, bool transmit)
{
    return rsv_hash2(path, 2 + transmit);
}

#endif
