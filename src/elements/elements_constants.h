/// Tuning constants of the room, with the measurements behind them. Constants without a measurement were chosen. Those
/// that other rooms use are in elements.h.
#ifndef RSV_ELEMENTS_CONSTANTS_H
#define RSV_ELEMENTS_CONSTANTS_H

// ---- Whether places lie in the open (cell_visibility.c, open_corners.c) ------------------------------

/// Rays from a place near other geometry that test whether it is buried.
#define BURIAL_RAYS 8
/// How many of them must see backs. Measured: leaks of at most 1 % within a centimetre of walls (test_contacts).
#define BURIAL_MAJORITY 6
/// Steps from surface to surface, if the visible surfaces are buried too.
#define BURIAL_STEPS 4
/// Test segments run this far above the surface, in parts of the elements' spacing ...
#define LIFT 0.1f
/// ... and this far inside the cell, in parts of its size.
#define INSET 0.05f
/// Opaque surfaces closer than this above a surface cover it, as a fraction of the elements' spacing: cells of a
/// decimetre cannot resolve what a picture hung two centimetres off the wall hides. Measured: Gallery, medium, 7
/// bounces and more: 0.9950 of the path tracer, 0.9933 with 0.1; staircase, draft, first bounce: 0.971 instead of
/// 0.965.
#define COVER 0.2f
/// Transparent surfaces closer than this cover it.
#define CONTACT 0.02f
/// Number of elements whose spacing defines contact with a surface, independently of the quality: that of a draft.
#define DRAFT_ELEMENTS 3000
/// A lamp closer than this keeps its light on the cell to itself: nodes at its border would pass on more light than the
/// room gets from elsewhere. Lamps that leave part of the view open, such as strips, do not count. Measured:
/// CornellBox.glb, first bounce / path tracer: draft 1.62 without, 0.990 with; medium 1.084 and 0.994.
#define LAMP_GAP 0.5f
/// Clear surfaces that a segment passes; more of them block it.
#define CLEAR_STEPS 8
/// Surfaces that a search for the skin of a body meets, along a line or from surface to surface.
#define SKIN_STEPS 8
/// A corner that something keeps apart from the middle of its cell, closer to it than that as a part of the way, does
/// not count as open. Up to about there, light that ends at once, but in the wrong place, is less wrong than light that
/// fades all over the cell.
#define FAR_CORNER 0.5f

/// Shorter parts of the way between two corners of a cell do not count as open.
#define SLIVER 1e-3f

// ---- Where surfaces touch (contact.c, contact_splits.c, weld.c) --------------------------------------

/// Maximum number of cells around a node; nodes with more are left alone.
#define MAX_FAN 32
/// Cells that meet at a fold as sharp as that, a quarter turn more or less, see each other around it.
#define FOLD_COSINE 0.5f
/// Faces whose normals at a shared corner differ by more than this meet at a crease (cos 25 degrees).
#define CREASE_COSINE 0.906f
/// How often cells at contacts are split. Measured: a thick wall leaked 1.15 % of indirect light when only the size
/// decided.
#define CONTACT_LEVELS 2
/// Cells smaller than this fraction of the spacing are left alone, because their meshes are finer than required.
/// Measured: a room of 400,000 triangles: 137,000 rows instead of 775,000.
#define CONTACT_SIZE 0.125f
/// A cell with honest corners on both sides of a wall interpolates through it: the line over which it does is made
/// thinner than it can be seen. Measured: leaks of 1 % at most within a centimetre.
#define THIN_WALL_LEVELS 4
/// Smaller cells, as a fraction of the spacing, are left alone there.
#define THIN_WALL_SIZE 0.03f
/// Steps of the size down to which all may be split, where not all fit.
#define SIZE_STEP 1.2f
/// Part of the cells at contacts that may be larger than others are split down to.
#define WHOLE_CONTACTS 0.1f

// ---- Sizes of cells (spacing.c) ----------------------------------------------------------------------

/// Slivers may have this many times as many cells along an edge as their area requires. Measured: a wall of 20 km by 2
/// m: 132,098 elements at draft instead of 2.1 million.
#define SLIVER_FACTOR 4.0f
/// Levels of the finest grid on a face.
#define FINEST_GRID 11
/// sqrt(area) over the distance from which on surfaces lie in the open. Measured: classroom: its ground took 49,117 of
/// 50,230 m2, and elements indoors were 2.7 m apart.
#define REACHES 4.0f
/// Geometry that rises by less than this fraction of its coordinates is in the same plane.
#define RISE 1e-5f
/// Levels that elements grow by at most.
#define MOST_GROWTH 4
/// Share of the hemisphere that surfaces may fill, as a cell sees it that is as large as usual; a quarter of that for
/// each level that it grows: irradiance, and so its curvature, is in proportion. Measured: classroom: elements 0.55 m
/// apart, 0.95 m where ground close by counted in full. With the next two.
#define MOST_FACED 0.25f
/// Radii around the centre of such a cell in which nothing rises above it, so that its view is nearly uniform.
#define ALONE 2.0f
/// Directions in which a patch searches for geometry above it.
#define LOOKS 64
/// The search for the surface that counts ends when it changes by less.
#define SETTLED 0.02
/// Rounds of that search at most.
#define MAX_ROUNDS 32

// ---- Leaders and followers (cluster.c, follower.c), curvature (curvature.c) --------------------------

/// A turn by this angle counts like the radius.
#define TURN_PER_RADIUS 0.7f
/// Leaders lead this many radii far. Measured: dragon of 202,520 triangles, medium: 33.0 million entries instead of
/// 45.3, error by the certificate 1.49 and 1.43 %.
#define REACH 2.0f
/// Leaders of less weight say little about the field around a follower.
#define LEAST_WEIGHT 0.05f
/// Standard deviations of noise that pass for no curvature, and no difference of leaders.
#define NOISE 2.0f

// ---- Threads (element_field.c, element_nodes.c) ------------------------------------------------------

/// Cells that a thread takes at a time.
#define CELLS_AT_A_TIME 4096

// ---- Voxels (voxels.c) -------------------------------------------------------------------------------

/// Cells along each axis of the fog's box at least, and at most.
#define FEWEST_VOXELS 8
#define MOST_VOXELS 512
/// Places that a cell which walls cut is sampled at.
#define CUT_PLACES 64
/// Densities per axis that the mean over a voxel is taken of.
#define DENSITY_SIDE 8
/// Least mean density of a voxel, as a share of the greatest density, so that its area is not 0.
#define LEAST_DENSITY 1e-6f
/// Places that rejection sampling by density tries at most.
#define DENSITY_TRIES 64
/// Flat boxes may have this many times the requested number of cells.
#define FLAT_BOX 4

#endif
