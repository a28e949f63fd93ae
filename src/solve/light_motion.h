/// Data that a light keeps while surfaces of its scene move, and one motion of them; for the files that follow it.
#ifndef RSV_LIGHT_MOTION_H
#define RSV_LIGHT_MOTION_H

#include "../operator/tracked_rows.h"
#include "../scene/moved.h"
#include "../update/divided_elements.h"
#include "light_internal.h"

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
} rsv_following;

/// One motion.
typedef struct rsv_light_motion {
    rsv_light *s;
    rsv_scene_difference difference;
    rsv_scene_change change;
    rsv_light_shafts shafts;
    uint8_t *anew;   ///< [node_count] 1 = the row is another one
    bool begins;     ///< it is the first one
    bool divides;    ///< coarse elements are others than before
    rsv_rgb *albedo; ///< [node_count] of these; taken over by the operator
    rsv_rows_patched rows;
    size_t lit, kept_lit;
} rsv_light_motion;

/// Elements of the light's own, of its own scene.
rsv_status rsv_following_create(rsv_light *light, rsv_following **following);

/// Divides coarse elements again where surfaces touch now, and transfers the light's fields to them. Rows and operator
/// are still the previous ones; `anew` refers to the new elements.
/// @param division out: for the rows; freed by the caller, without elements and valid points
rsv_status rsv_light_divide(rsv_light_motion *m, bool from_first, rsv_divided_elements *division);

#endif
