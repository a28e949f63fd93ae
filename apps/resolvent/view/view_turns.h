/// Which moving objects the light follows in a frame, if the budget is too small for all: those first that change the
/// picture most. The others wait where they are.
#ifndef CLI_VIEW_TURNS_H
#define CLI_VIEW_TURNS_H

#include "resolvent/scene.h"

typedef struct cli_turns {
    double budget_ms; ///< per frame; 0 = no limit
    bool *moved;      ///< [object_count] objects that are to go on now
    double *since;    ///< [object_count] cli_seconds() when they began to wait; 0 = they do not
    float *weight;    ///< [object_count] change of the picture
    uint32_t *order;  ///< [object_count] heaviest first
    size_t object_count;
    size_t going, waiting;    ///< objects, in this frame
    double least_ms, each_ms; ///< of a step: without objects, and for each; 0 = not known yet
    size_t most_triangles;    ///< whose own light is computed again in a step; 0 = all
    uint32_t late_frames;     ///< in which objects had to wait
    uint32_t steps;
    double sum_ms, longest_ms; ///< of the steps
} cli_turns;

/// Decides for a frame. @param shown,wanted versions of a scene @return false without memory
bool cli_turns_take(cli_turns *turns, const rsv_scene_view *shown, const rsv_scene_view *wanted,
    const rsv_camera *camera);

/// Learns how long the step took.
void cli_turns_note(cli_turns *turns, double ms);

/// How long the first of those that wait has waited, ms.
double cli_turns_lag(const cli_turns *turns);

void cli_turns_end(cli_turns *turns);

#endif
