/// What the room tunes by, with what was measured of it. The rest is chosen, not measured. What other rooms read too stands
/// in headers: RSV_COARSE_LIGHT_FACTOR and others in light.h, diffused_level.h and solve_desc.h.
#ifndef RSV_SOLVE_CONSTANTS_H
#define RSV_SOLVE_CONSTANTS_H

// ---- Budgets of elements and memory (budget.c, builder.c) --------------------------------------------

/// What elements take while they are made: the coarser ones beside the finer ones, and tables of nodes.
#define MAKING_ELEMENTS 3
/// Bytes per triangle of elements on a mesh that needs no splits. Measured, with the next: terraces, 1e5 triangles: 394
/// bytes per element in all.
#define BYTES_PER_TRIANGLE 150
/// Bytes per cell of a level in the making.
#define BYTES_PER_CELL 250
/// What the process takes besides, however small the scene: code that is run for the first time, stacks, a small picture.
#define BESIDES ((size_t)4 << 20)
/// Part of the memory left that is planned for: the rest is for what no plan foresees.
#define PLANNED 0.85
/// Part of it for the levels of direct light and caustics.
#define LEVELS 0.3
/// Rows of fewer rays are noisier than larger elements are wrong.
#define FEWEST_RAYS 256
/// Where budgets are exceeded, elements grow by this factor at most at a time; ...
#define LARGEST_STEP 4.0f
/// ... always by it, and no pilot splits them, as soon as a step leaves more than this part of them.
#define LEAST_PROGRESS 0.95
/// Spacings that are tried in search of the fewest elements.
#define SPACINGS_TRIED 7
/// Rows that are few get at most so many times the rays. Measured: cornell-spheres, 5,500 rows of 1,024 rays instead of 128,
/// 6.4 instead of 4.6 s of processor time; blotches of its ceiling 5 % with 128 rays, 2.4 % with 512, 1.6 % with 1,024.
#define MOST_RAISED 8
/// Between the last spacing that fits and one that does not, so many are tried until so much of a budget is used. Measured,
/// with the next three: terraces:3e4 under 3,000 elements: 2,416; 497 without.
#define BISECTIONS 6
#define BUDGET_USED 0.8
/// Less is worth another search, after the largest cells were split.
#define BUDGET_MISSED 0.5
/// Those are split until so much of a budget is used, in so many rounds at most.
#define BUDGET_FILLED 0.95
#define FILL_ROUNDS 12

// ---- Coarse elements (coarse_elements.c) -------------------------------------------------------------

/// Where meshes are finer than the wanted spacing, nodes follow leaders within this part of it; pilots halve that where
/// light changes quickly. Measured: dragon of 202,520 triangles, medium: 33.0 million entries instead of 45.3 with a
/// quarter of the spacing everywhere, error by the certificate 1.49 and 1.43 %.
#define CLUSTER_RADIUS 1.0f
#define CLUSTER_RADIUS_WITHOUT_PILOTS 0.5f
/// Splits at contacts may add this many nodes times the root of those that were asked for: they lie along lines. Measured,
/// rows at draft: classroom 37,000, staircase 31,000, white room 52,000; without 146,535, 167,493 and 100,265.
#define CONTACT_NODES 300
/// Elements of a scene that moves may pile up splits up to this many times the nodes there were before anything moved.
#define MOST_DIVISION 1.25

// ---- Pilots: solutions with few rays (pilot.c) -------------------------------------------------------

/// Rays of each row, and orders of light.
#define RSV_PILOT_RAYS 128
#define RSV_PILOT_ORDERS 3
/// Cells are split where indirect or gathered light bends by more than this part of its level, ...
#define PILOT_BEND 0.2f
/// ... or by more, up to this, where that would be more cells than pilots may split.
#define LARGEST_BEND 2.0f
/// Pilots may bring rows to so many times those that were asked for, or, where detailed surfaces take most of these anyway,
/// add so many times. After an edit, whose solution before had pilots of its own, they may add as many as were asked for.
/// Measured: fireplace_room, medium, all light over the path tracer 1.0083 without the second, 1.0059 with it (62,885 and
/// 100,926 rows); wooden_staircase 0.983 and 0.990.
#define MOST_NODES 8
#define MOST_ADDED 5
/// A pilot takes an eighth of the rays of a solution: worth it where it may add this part of the rows there are.
#define LEAST_GROWTH 0.25
/// Part of the mean indirect light below which nobody sees a relative error.
#define PILOT_DARK 0.02f

// ---- Goals (goal.c, goal_weights.c) ------------------------------------------------------------------

/// Rays each way that weigh what is seen.
#define GOAL_SIDE 128
/// Rays each way that tell what is seen at all.
#define VIEW_SIDE 384
/// Rays of each sensor at least, however many share the rays of a goal.
#define FEWEST_SENSOR_RAYS 64u
/// Relative residual of the adjoint solve.
#define GOAL_ACCURACY 1e-4
/// Importance is learned on elements larger than usual by this.
#define RSV_GOAL_LEARNED 2.0f
/// Elements of a goal are larger than usual by this at most.
#define RSV_GOAL_COARSEST 8.0f
/// Part of the typical density of importance from which on elements have their usual size. Measured, with the two before:
/// two-rooms, draft: 11,900 elements instead of 58,200; the estimated error of the mean is within 22 % of the true one.
#define FULL_SIZE 0.5f
/// Places each way at which a cell is asked for its size, at most.
#define MOST_PLACES 4

// ---- Light below surfaces (diffused_level.c) ---------------------------------------------------------

/// Receiver points of a node.
#define DIFFUSED_POINTS 4
/// Cells are split until they are this small against the narrowest d ...
#define CELLS_PER_PROFILE 1.5f
/// ... or this many times as many as the coarse elements.
#define DIFFUSED_CELLS 2
/// Nodes of finer meshes follow leaders within this share of that size.
#define CLUSTER_SHARE 0.7f

// ---- Light and its orders (light_change.c, operator.c, orders.c, sharpen.c) --------------------------

/// Places on each element where textured albedo is looked up.
#define ALBEDO_POINTS 16
/// Brightest neighbour : darkest, beyond which there is a jump that sharpening keeps away from. Measured: no black specks
/// where walls meet floors in two-rooms.
#define SMOOTH_CONTRAST 2
/// A place that still holds more than half of its light after so many orders is a pocket.
#define POCKET_ORDERS 256
/// After RSV_LOSSLESS_ORDERS, such a place holds more than the fourth root of that.
#define POCKET_LASTING 0.841f
/// Loss per reflection that is told from none: rows are sums in single precision.
#define LOSS_IN_DOUBT 3e-6
/// Less of the light than this may be lost in pockets that are left dark.
#define POCKET_SHARE 0.01
/// Rounding of stored irradiance, as a share of it, that no residual gets below.
#define ROUNDING 2.5e-7
/// Residual of the spectral radius, relative, and the applications that it may take. As A is symmetric, nearly, in some inner
/// product, the radius itself is known to about the square of that over the distance of the next eigenvalue.
#define RADIUS_TOLERANCE 2e-3
#define RADIUS_STEPS 24
/// Errors of the operator are amplified by about 1 / (1 - spectral radius): beyond this the reader must know.
#define WORRYING_RADIUS 0.98

// ---- What each source does (light_basis.c) ----------------------------------------------------------

/// Sources that are each divided by as many photons as the whole; where there are more, they share as many as these. Measured: a
/// room of 100 lamps, draft: photons of a basis take about half of its time.
#define RSV_FULL_PHOTON_SOURCES 16

// ---- Lights that follow what moves (source.c) --------------------------------------------------------

/// Cells of a level of direct light, over those it was built with, from which on it is built anew: splits for shadows that have
/// moved on are never undone.
#define MOST_GROWTH 1.3f

// ---- Solvers (measure_solver.c, node_groups.c) -------------------------------------------------------

/// Orders of light that show how fast they die out, before a solver is chosen.
#define SCOUT_TERMS 5
/// The dense solve on groups must stay cheap beside one application of the operator.
#define MAX_GROUPS 128
#define NODES_PER_GROUP 16

#endif
