/// How much larger than its residual an error may be: a bound of the norm of (I - G K)^-1.
#ifndef RSV_AMPLIFICATION_H
#define RSV_AMPLIFICATION_H

#include "../solve/light.h"

typedef struct rsv_amplification {
    /// Of root-mean-square errors, weighted by area and by the transmission of coats; INFINITY if light hardly dies
    /// out.
    double factor;
    double
        coat_factor; ///< root of the largest over the least share that coats let through: area is the only weight then
} rsv_amplification;

/// @param max_albedo largest albedo at the nodes
rsv_status rsv_amplification_of(
    const rsv_light_view *solution, double max_albedo, rsv_amplification *amplification);

#endif
