/// Data that a light keeps while surfaces of its scene move, and one motion of them; for the files that follow it.
#ifndef RSV_LIGHT_MOTION_H
#define RSV_LIGHT_MOTION_H

#include "../direct/source_level.h"
#include "../operator/tracked_rows.h"
#include "../scene/moved.h"
#include "../update/divided_elements.h"
#include "light_internal.h"

/// While triangles wait, the light of what stays is computed in turns, one in a call, too: that of coarse elements (rows,
/// direct light), and direct light on its own elements. Measured on a walking figure of 13,676 triangles, a call: the
/// 160,000 rays of rows that it touches take 0.25 s, direct light around its shadow 0.1 s.
#define RSV_COARSE_TURNS 4
#define RSV_LEVEL_TURNS 2

/// Turns of elements: those whose number leaves the remainder `turn` when divided by `count`.
typedef struct rsv_light_turn {
    rsv_scene_change change; ///< boxes of motions since their last turn
    uint32_t count, turn;    ///< count 0 = all have their turn
} rsv_light_turn;

/// Data kept between motions.
typedef struct rsv_following {
    rsv_elements *elements;     ///< of the operator, retained
    rsv_elements *first;        ///< those of before anything moved
    float contact_size;         ///< of `first`
    uint16_t *valid_points;     ///< [node_count] of the operator
    rsv_transport *rows;        ///< tracked rows
    rsv_rgb *direct;            ///< [node_count] next-event estimates, W/m2
    rsv_scene_change undivided; ///< boxes of motions since the level of direct light was divided
    rsv_scene_change unsettled; ///< of those since `elements` were divided from `first`
    bool split;                 ///< `elements` are split otherwise than they would be from `first`
    uint8_t
        *waits; ///< [triangle_count] 1 = it moved, and keeps its light until its turn; NULL = none
    size_t waiting;          ///< how many do
    size_t next_turn;        ///< the triangle that had the last one
    size_t turns;            ///< since caustics were computed
    uint32_t calls;          ///< in which somebody had to wait
    uint8_t *caustics_moved; ///< [triangle_count] RSV_MOVE_TURN = it moved since then; NULL = none
    rsv_scene_change caustics_behind; ///< boxes of motions since then
    rsv_photon_log *photons;          ///< those that caustics were computed from; NULL = not kept
    /// Boxes of motions since the last turns of coarse elements and of those of direct light, and which are next.
    rsv_scene_change coarse_behind[RSV_COARSE_TURNS], level_behind[RSV_LEVEL_TURNS];
    uint32_t coarse_turn, level_turn;
} rsv_following;

/// One motion.
typedef struct rsv_light_motion {
    rsv_light *s;
    rsv_scene_difference difference;
    rsv_scene_change change;
    rsv_light_shafts shafts;
    uint8_t *moved; ///< [triangle_count] RSV_MOVE_... of their light, also from earlier motions
    uint8_t *anew;  ///< [node_count] RSV_MOVE_... of the row
    bool begins;    ///< it is the first one
    bool settles;   ///< all is at rest: elements are divided as a solve would
    bool hurries;   ///< triangles will have to wait: what can be left to a later call is
    bool caustics;  ///< they are computed again now
    rsv_light_turn coarse, level; ///< whose light is computed again, where surfaces stay
    bool whole;                   ///< cells of direct light are not split now
    bool divides;                 ///< coarse elements are others than before
    rsv_rgb *albedo;              ///< [node_count] of these; taken over by the operator
    rsv_rows_patched rows;
    size_t lit, kept_lit;
} rsv_light_motion;

/// Whether triangles will have to wait in this call.
bool rsv_light_hurries(const rsv_light_motion *m, size_t most);

/// Decides whose light is computed again. @param most triangles at most; 0 = all
rsv_status rsv_light_take_turns(rsv_light_motion *m, size_t most);

/// Decides which elements of surfaces that stay have their turn. Call it once all boxes are known.
void rsv_light_take_turns_of_elements(rsv_light_motion *m);

/// What moved since caustics were computed. @param shafts out, for `motion` @return whether it is their turn
bool rsv_light_begin_caustics(
    rsv_light_motion *m, rsv_light_shafts *shafts, rsv_level_motion *motion);

/// Forgets that, if it was their turn.
void rsv_light_end_caustics(rsv_light_motion *m);

/// Elements of the light's own, of its own scene.
rsv_status rsv_following_create(rsv_light *light, rsv_following **following);

/// Divides coarse elements again where surfaces touch now, and transfers the light's fields to them. Rows and operator
/// are still the previous ones; `anew` refers to the new elements.
/// @param division out: for the rows; freed by the caller, without elements and valid points
rsv_status rsv_light_divide(rsv_light_motion *m, bool from_first, rsv_divided_elements *division);

#endif
