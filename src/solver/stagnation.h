/// When a solver is given up, here and on devices.
#ifndef RSV_STAGNATION_H
#define RSV_STAGNATION_H

/// Applications of A without an improvement by half a percent, ...
#define RSV_PATIENCE 64
#define RSV_IMPROVEMENT 0.995
/// ... and growth beyond all sense.
#define RSV_BLOW_UP 1e6

#endif
