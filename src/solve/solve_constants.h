/// Tuning constants of the room, with the measurements behind them. Constants without a measurement were chosen. Those
/// that other rooms use are in headers: RSV_COARSE_LIGHT_FACTOR and others in light.h, diffused_level.h and
/// solve_desc.h.
#ifndef RSV_SOLVE_CONSTANTS_H
#define RSV_SOLVE_CONSTANTS_H

// ---- Budgets of elements and memory (budget.c, builder.c) --------------------------------------------

/// Memory of elements during creation, relative to their own: the coarser ones at the same time, and tables of nodes.
#define MAKING_ELEMENTS 3
/// Bytes per triangle of elements on a mesh that needs no splits. Measured, with the next: terraces, 1e5 triangles: 394
/// bytes per element in all.
#define BYTES_PER_TRIANGLE 150
/// Bytes per cell of a level in the making.
#define BYTES_PER_CELL 250
/// Other memory of the process, for any scene: code that runs for the first time, stacks, a small picture.
#define BESIDES ((size_t)4 << 20)
/// Fraction of the remaining memory to plan for. The rest is a reserve.
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
/// Maximum factor of rays for few rows. Measured: cornell-spheres, 5,500 rows of 1,024 rays instead of 128: 6.4 instead
/// of 4.6 s of CPU time; blotches of its ceiling 5 % with 128 rays, 2.4 % with 512, 1.6 % with 1,024.
#define MOST_RAISED 8
/// Number of spacings tried between the last one that fits and one that does not, until this fraction of a budget is
/// used. Measured, with the next three: terraces:3e4 under 3,000 elements: 2,416; 497 without.
#define BISECTIONS 6
#define BUDGET_USED 0.8
/// Less is worth another search, after the largest cells were split.
#define BUDGET_MISSED 0.5
/// Cells are split until this fraction of a budget is used, in at most this many rounds.
#define BUDGET_FILLED 0.95
#define FILL_ROUNDS 12

// ---- Coarse elements (coarse_elements.c) -------------------------------------------------------------

/// On meshes finer than required, nodes follow leaders within this fraction of the spacing; pilots halve it where light
/// varies quickly. Measured: dragon of 202,520 triangles, medium: 33.0 million entries instead of 45.3 with a quarter
/// of the spacing everywhere; error by the certificate 1.49 and 1.43 %.
#define CLUSTER_RADIUS 1.0f
#define CLUSTER_RADIUS_WITHOUT_PILOTS 0.5f
/// Splits at contacts may add this many nodes times the root of the requested number, because contacts are along lines.
/// Measured, rows at draft: classroom 37,000, staircase 31,000, white room 52,000; without it 146,535, 167,493 and
/// 100,265.
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
/// Pilots may increase rows to this many times the requested number. If detailed surfaces take most of these anyway,
/// they may add this many times that number. After an edit, whose previous solution had its own pilots, they may add
/// the requested number. Measured: fireplace_room, medium, all light / path tracer: 1.0083 without the second, 1.0059
/// with it (62,885 and 100,926 rows); wooden_staircase 0.983 and 0.990.
#define MOST_NODES 8
#define MOST_ADDED 5
/// A pilot takes an eighth of the rays of a solution: worth it where it may add this part of the rows there are.
#define LEAST_GROWTH 0.25
/// Fraction of the mean indirect light below which relative errors are invisible.
#define PILOT_DARK 0.02f

// ---- Goals (goal.c, goal_weights.c) ------------------------------------------------------------------

/// Rays in each direction whose hits are weighted.
#define GOAL_SIDE 128
/// Rays in each direction that find visible surfaces.
#define VIEW_SIDE 384
/// Rays of each sensor at least, however many share the rays of a goal.
#define FEWEST_SENSOR_RAYS 64u
/// Relative residual of the adjoint solve.
#define GOAL_ACCURACY 1e-4
/// Importance is learned on elements larger than usual by this.
#define RSV_GOAL_LEARNED 2.0f
/// Elements of a goal are larger than usual by this at most.
#define RSV_GOAL_COARSEST 8.0f
/// Part of the typical density of importance from which on elements have their usual size. Measured, with the two
/// before: two-rooms, draft: 11,900 elements instead of 58,200; the estimated error of the mean is within 22 % of the
/// true one.
#define FULL_SIZE 0.5f
/// Maximum number of points, in each direction, at which the required size of a cell is evaluated.
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
/// Brightest neighbour : darkest, beyond which there is a jump that sharpening keeps away from. Measured: no black
/// specks where walls meet floors in two-rooms.
#define SMOOTH_CONTRAST 2
/// A place that keeps more than half of its light after this many orders is a pocket.
#define POCKET_ORDERS 256
/// After RSV_LOSSLESS_ORDERS, such a place holds more than the fourth root of that.
#define POCKET_LASTING 0.841f
/// Smallest loss per reflection that differs from none, because rows are sums in single precision.
#define LOSS_IN_DOUBT 3e-6
/// Less of the light than this may be lost in pockets that are left dark.
#define POCKET_SHARE 0.01
/// Rounding of stored irradiance, as a share of it, that no residual gets below.
#define ROUNDING 2.5e-7
/// Residual of the spectral radius, relative, and the applications that it may take. As A is nearly self-adjoint in the
/// inner product used, the radius itself is known to about the square of that over the distance of the next eigenvalue.
#define RADIUS_TOLERANCE 2e-3
#define RADIUS_STEPS 24
/// Errors of the operator are amplified by about 1 / (1 - spectral radius). Beyond this, a warning says so.
#define WORRYING_RADIUS 0.98

// ---- Contribution of each source (light_basis.c) -----------------------------------------------------

/// Sources that are each divided by as many photons as the whole; where there are more, they share as many as these.
/// Measured: a room of 100 lamps, draft: photons of a basis take about half of its time. Fewer give faint lights what
/// belongs to strong ones: modern_hall, 13 lights, with 4 such sources: lamps of a thousandth of the light get 10 to 50 %
/// too much.
#define RSV_FULL_PHOTON_SOURCES 16

// ---- Lights that follow moving objects (source.c, light_turns.c) ----------------------------------------------------

/// Growth of a level of direct light, in cells, after which it is built again: splits for shadows that have moved on
/// are never undone.
#define MOST_GROWTH 1.3f
/// While surfaces wait for their turn, cells of direct light are split in one of so many calls: numbering 65,000 nodes
/// again takes 0.2 s, twice in a call.
#define CALLS_PER_SPLIT 8
/// ... and the equation is solved to so many more orders in a call, from where the last one stopped.
#define ORDERS_IN_HASTE 2

// ---- Solvers (measure_solver.c, node_groups.c) -------------------------------------------------------

/// Orders of light that show how fast they die out, before a solver is chosen.
#define SCOUT_TERMS 5
/// The dense solve on groups must be cheap compared with one application of the operator.
#define MAX_GROUPS 128
#define NODES_PER_GROUP 16

#endif
