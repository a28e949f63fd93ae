/// Elements for one picture, or for the readings of sensors, by importance.
///
/// w is the effect of a unit of irradiance at each node on the goal (the picture's mean luminance or the mean reading),
/// and z = (I - (G K)*)^-1 w the effect of a unit of *source* there, after all reflections. An element may be larger by
/// the fourth root of how much less important its area is, because the squared error of linear elements grows with the
/// fourth power of their size.
#ifndef RSV_GOAL_H
#define RSV_GOAL_H

#include "operator.h"

/// How much larger than usual elements may be.
typedef struct rsv_goal {
    rsv_elements *elements; ///< where that was found out
    rsv_rgb *size;          ///< [node_count] factor, in all channels
} rsv_goal;

/// The goal: a camera's picture, or the mean reading of sensors.
typedef struct rsv_goal_aim {
    uint32_t camera;        ///< RSV_NONE = the sensors
    const rsv_probe *point; ///< [point_count]
    size_t point_count;
} rsv_goal_aim;

/// The goal of a description.
rsv_goal_aim rsv_goal_aim_of(const rsv_solve_desc *desc);
bool rsv_goal_is_wanted(const rsv_goal_aim *aim);

/// RSV_ERROR_ARGUMENT where one is no receiver.
rsv_status rsv_check_probes(const rsv_probe *probes, size_t count);

/// w, times the weights of luminance: <w, E> over the free nodes and channels is the mean luminance of the picture, or
/// the mean luminance of the readings, as far as it comes from diffuse surfaces.
/// @param side camera rays across and down; sensors share as many @param weight [node_count]
rsv_status rsv_goal_weights(
    const rsv_operator *op, const rsv_goal_aim *aim, uint32_t side, uint32_t seed, rsv_rgb *weight);

/// The same for one ray: adds the weight of the radiance at its diffuse end. @param share fraction of the goal
void rsv_goal_weigh_end(
    const rsv_operator_view *op, const rsv_specular_path *end, float share, rsv_rgb *weight);
/// Converts, once, the weights of surfaces' light to those of entering irradiance, at free nodes (with P* on
/// translucent ones).
rsv_status rsv_goal_enter(const rsv_operator_view *op, rsv_rgb *weight);

/// z for given w. @param max_orders applications of G K at most @param importance [node_count]
rsv_status rsv_goal_importance(
    const rsv_operator *op, uint32_t max_orders, const rsv_rgb *weight, rsv_rgb *importance);

/// Importance per area, for evaluation between nodes. @param importance in and out, hanging nodes filled
void rsv_goal_density(const rsv_elements *elements, rsv_rgb *importance);

/// Finds the sizes of elements for a description, from an operator on coarse elements, which the goal keeps.
rsv_status rsv_goal_create(const rsv_operator *op, const rsv_solve_desc *desc, rsv_goal *goal);
void rsv_goal_destroy(rsv_goal *goal);

/// How much larger than usual a cell of other elements may be: the least at some places of it.
float rsv_goal_size_at(const rsv_goal *goal, const rsv_elements *elements, uint32_t cell);

/// Cells whose light no ray of the goal sees. @param hidden [cell_count]
rsv_status rsv_goal_hidden_cells(
    const rsv_operator *op, const rsv_goal_aim *aim, uint32_t seed, uint8_t *hidden);

#endif
