/// Tuning constants of the room, with the measurements behind them. Constants without a measurement were chosen. Those
/// that devices or other rooms use are in direct_sample.h, photon_guide.h, photon_map.h, photon_path.h, photon_turn.h
/// and source_level.h.
#ifndef RSV_DIRECT_CONSTANTS_H
#define RSV_DIRECT_CONSTANTS_H

// ---- Shadow rays (direct_receiver.c) -----------------------------------------------------------------

/// Points of a node that are looked at first where `samples` is less than RSV_DIRECT_LANES.
#define PREVIEW_POINTS 4

// ---- Lights close to surfaces (near_punctual.c) --------------------------------------------------------

/// A light is near a node if it is closer than this many sides of its cells.
#define NEAR_LIGHT 4.0f
/// Sides of parts, by their distance to the light.
#define NEAR_LIGHT_PART 0.5f
/// Divisions at most, of lights that lie on a surface.
#define NEAR_LIGHT_DEPTH 16

// ---- Photons (photons.c, photon_guide.c) -----------------------------------------------

/// Fraction of photons for bins whose pilot rays were useful, and fraction divided equally among all bins, because
/// there are few pilot rays. The others start with the source's own distribution.
#define GUIDED_SHARE 0.6f
#define EVEN_SHARE 0.3f
/// The strongest origins have a guide each; all others share one.
#define OWN_GUIDES 63
/// Rounds of pilot rays, each on bins that are finer where the last ones found something.
#define MOST_PILOTS 4
/// Fraction of useful photons that may be left beyond each side of the finer bins, and number of bins kept there.
#define OUTSIDE 0.01f
#define OUTER_BINS 4

// ---- Levels of finer elements (source_level.c) -------------------------------------------------------

/// Caustics have sharper edges than shadows: they may split cells this many times more.
#define CAUSTIC_LEVELS 2
/// Cells are split where irradiance bends by more than this share of the local level.
#define BEND 0.1f
/// Below this share of the scene's mean irradiance, a bend is invisible.
#define DARK 0.05f
/// A cell's bend in caustic light is more than noise if one of its nodes has caught this many photons. (One,
/// not all: the rim of a caustic is dark on one side.)
#define PHOTONS_TO_SPLIT 24.0f
/// Cells are at most so much larger than the spacing, but in the open.
#define OPEN_TOLERANCE 1.5f

// ---- Portions of work (direct_device.c, photons.c, shooting_device.c) --------------------------------

/// Nodes that a device takes at a time: enough for any.
#define NODES_AT_A_TIME ((size_t)1 << 14)
/// Photons that a thread takes at a time.
#define PHOTONS_PER_CHUNK 4096
/// Chunks per worker between two calls of a sink's `collect`.
#define CHUNKS_PER_WAVE 4
/// Photons of a device between two looks at the clock.
#define PHOTONS_AT_A_TIME ((uint32_t)1 << 22)

// ---- Voxels (voxel_direct.c) -------------------------------------------------------------------------

/// Rays from a point light that is as near to a voxel as that is large.
#define NEAR_LIGHT_SAMPLES 256

// ---- Levels that follow moving objects (source_follow.c) --------------------------------------------

/// Fraction of a level's cells that must need splitting before the level is split, which renumbers all of it. Measured:
/// moving a bucket by 6 cm in a classroom needs 0.0005 of 376,000 cells; numbering takes 0.3 s, the rest of the level
/// 0.3 s.
#define SPLIT_SHARE 0.001f

#endif
