/// Unified glare rating of observers in a solved scene: of measured luminaires that have an opening, and of lamps.
#ifndef CLI_OBSERVER_GLARE_H
#define CLI_OBSERVER_GLARE_H

#include "resolvent/render.h"

typedef struct cli_observer {
    double ugr;        ///< -INFINITY = nothing glares
    double background; ///< cd/m2: the light at the eye that is not of glare sources, over pi
    double vertical;   ///< lux at the eye
    uint32_t sources;  ///< that are seen
} cli_observer;

/// @param eye where observers are and the way they look, up being y @param observer [count] out
rsv_status cli_rate_observers(const rsv_light *light, const rsv_probe *eye, size_t count,
    uint32_t samples, cli_observer *observer);

#endif
