/// Tuning constants of the room, which were chosen without measurements. Those that other rooms use are in
/// scene_change.h.
#ifndef RSV_UPDATE_CONSTANTS_H
#define RSV_UPDATE_CONSTANTS_H

// ---- What counts as unchanged (history.c, scene_change.c, motion_boxes.c) -------------------------------------------

/// An edit that changes the spacing of elements by less than this part leaves it as it was: a spacing of its own would
/// keep no element, and so no row.
#define LIKE_SPACING 0.1f
/// Boxes of changes are enlarged by this fraction of their coordinates, against rounding.
#define MARGIN 1e-5f
/// A box around moving triangles is split where the two halves together have at most this share of its surface.
#define SPLIT_GAIN 1.0f
/// Splits of the box around everything that moves, so that there are no more parts than a change holds.
#define BOX_LEVELS 4

// ---- How far an edit reaches (light_shafts.c) -------------------------------------------------------

/// The surroundings that affect a cell (elements_constants.h) extend at most this fraction of its size ...
#define REACH_OF_SIZE 0.6f
/// ... and this part of the spacing.
#define REACH_OF_SPACING 0.25f

#endif
