/// Tuning constants of the room, with the measurements behind them. Constants without a measurement were chosen.
#ifndef RSV_BAKE_CONSTANTS_H
#define RSV_BAKE_CONSTANTS_H

/// Light below this fraction of the mean is dark: relative errors are invisible there.
#define DARK 0.05f

// ---- Which side of a surface is shown (bake_side.c) --------------------------------------------------

/// A side is narrow if rays from it travel less than this many metres on average, limited to FAR: nobody looks from
/// inside cushions or from behind skirting boards, but from rooms. Measured: white room: armchair, cornice and skirting
/// boards were black without it; fireplace room: ceiling and panels under windows as bright as outside.
#define NARROW 0.35
#define FAR 2.0f
/// It is narrower than another side if rays from it travel less than this fraction of the distance.
#define NARROWER 0.5
/// A front that receives less than this fraction of the light of its back is in the dark.
#define DARK_FRONT 0.05
/// Rays from each side of a surface.
#define SIDE_RAYS 64
/// Where neighbours' normals have a cosine of less, a surface has a crease.
#define SIDE_CREASE 0.7f
/// A piece between creases whose front receives this many times the light of its back shows the front, whatever the
/// whole surface does: a slab above a ceiling is hidden, but the beam below it, on the same mesh, has a visible face.
#define LIGHTER 1.5

// ---- Visible parts (bake_open.c) ---------------------------------------------------------------------

/// Rays from a place, and how far they may get in the mean within bodies of two-sided surfaces, metres: less than in a
/// room.
#define POCKET_RAYS 8
#define POCKET 0.5f

// ---- Charts (bake_chart.c, bake_layout.c, bake_pack.c) -----------------------------------------------

/// Neighbours that meet sharper are in different charts (cosine).
#define CHART_CREASE 0.77f
/// Cosine between a triangle's normal and that of the first in its chart.
#define CHART_DEVIATION 0.6f
/// Attempts to undo overlaps within charts, ...
#define OVERLAP_ROUNDS 4
/// ... and to find a density that fits, to this share. Measured, with narrower maps tried once at the density found: 15
/// packings of a map instead of 72.
#define DENSITY_ROUNDS 12
#define DENSITY_EXACT 1.005f
/// A larger map must show this much more.
#define WORTH_IT 1.02f
/// Charts that fill less than this of their rectangle are divided, if that is more than this fraction of all surfaces,
/// and if they have few triangles: parts of many triangles are slivers, whose borders are too close to each other for
/// stitching. Measured, coverage at medium with charts packed by shape: staircase 32.1 to 70.2 %, fireplace room 28.0
/// to 68.3 %.
#define HOLLOW 0.4
#define HOLLOW_SHARE 0.002
#define HOLLOW_TRIANGLES 40
/// Default sides of maps, and the fraction of them that charts of a few texels may fill.
#define FIRST_SIDE 1024
#define LAST_SIDE 4096
#define SMALL_CHARTS 0.4
/// Charts that get more texels are smaller than this part of the map.
#define SMALL_PART 64
/// Texels along a side by which the second texture coordinates of a file are judged.
#define CHECK_TEXELS 256
/// Share of the texels per square metre of a part below which a triangle has none, and share of a part's surface that
/// may be without: slivers that rounding makes flat.
#define COLLAPSED 1e-3
#define MOST_COLLAPSED 0.01
/// Texels at the rim of a map that stay empty, for filtering on a border to touch.
#define RIM 1
/// Runs of a chart are tried so far apart first: most places are refused by one of the first.
#define RUN_STRIDE 16
/// Charts up to this many texels along a side are sought from where the last of their size was found: maps of many
/// thousands would take minutes otherwise.
#define LARGEST_KIND 64

// ---- Shadow rays and noise (bake_map_light.c, bake_filter.c) ------------------------------------------

/// Shadow rays of each half of a texel at first, and texels to each side that say whether they will do.
#define PILOT_SAMPLES 2
#define LATTICE_PILOT_SAMPLES 3 ///< many triangles have three points alone
#define PILOT_REACH 3
/// Largest change of light between patches for which a mean may replace the values between them: its error is about an
/// eighth of the square.
#define MOST_SLOPE 0.25f
/// Of each half where they will not.
#define LEAST_SAMPLES 8
#define MOST_LIGHT_SAMPLES 256
/// Places of a patch that sources are weighed at, at most.
#define WEIGHED_PLACES 16
/// Emitters closer than this many times their radius are weighted exactly, others like points, with an error below the
/// square of one over this.
#define NEAR_EMITTER 8
/// Points on emitters farther than this many times their radius are sampled by area instead of solid angle: weights
/// differ by a factor of less than four.
#define FAR_EMITTER 3
/// Emitters whose planes are seen under a smaller sine than this are drawn from in double precision.
#define EDGE_ON 0.02f
/// Upper limit for each half if those did not suffice, and number of increases.
#define MOST_REFINED_SAMPLES 2048
#define LIGHT_REFINEMENTS 2
/// Deviation of a patch / target error of the median one: 99 of 100 then have less than five times that error.
#define LARGEST_DEVIATION 1.9f
/// Patches that a penumbra is followed by beyond where pilots found it.
#define PENUMBRA_ROUNDS 12
/// Variance of a mean of stratified samples over that of independent ones.
#define STRATIFIED 0.3f
/// By how much the filter lowers the deviation of a texel.
#define FILTER_GAIN 2.5f
/// Texels to each side over which variances are means, which are compared, and which are mixed.
#define VARIANCE_REACH 1
#define PATCH_REACH 1
#define FILTER_REACH 3
/// Larger values mix texels that differ more.
#define FILTER_STRENGTH 0.6f

// ---- Indirect light gathered at vertices (bake_mend.c) ------------------------------------------------

/// Rays that find near geometry; gather rays of a group, and groups of a vertex, which give the noise.
#define NEAR_RAYS 16
#define MEND_RAYS 64
#define MEND_GROUPS 8
/// Fewer groups if the noise of the added light is below this fraction of the light. Measured, vertices of
/// cornell-blocks at draft: a quarter less time than with all groups, the same errors compared with path tracing
/// (median 1.9 %, 99th percentile 16 %).
#define LEAST_MEND_GROUPS 3
#define MEND_NOISE 0.01f
/// Share of the whole light to which errors of the light of one source are relative, where it gives less.
#define PART_OF_WHOLE 0.25f
/// Change of stored light within an element, relative to the light, and the element's edge / the harmonic mean of the
/// distances seen from there: from the first value on, stored light gets less weight; from the second on, none.
/// Measured, vertices of studio at draft: the 99th percentile of errors is 26 % instead of 83 %; at medium 15 % instead
/// of 18 %.
#define DOUBTED_CHANGE 0.1f
#define WRONG_CHANGE 0.25f
#define DOUBTED_NEAR 0.5f
#define WRONG_NEAR 1.2f

// ---- The error of a bake (bake_judge.c) --------------------------------------------------------------

/// Shadow rays of each half of a value that is judged, and gather rays of a batch. More of both where these are off by
/// more than JUDGED_NOISE: sun in polished metal is found by few gather rays.
#define JUDGED_SHADOW_RAYS 1024
#define MOST_JUDGED_SHADOW_RAYS 32768
#define JUDGED_GATHER_RAYS 512
#define LEAST_JUDGED_BATCHES 4
#define MOST_JUDGED_BATCHES 32
#define JUDGED_NOISE 0.004f

// ---- Noise of stored light (bake_smooth.c) ------------------------------------------------------------

/// Cells between a node and the others that a plane is fitted to, and how many nodes these may be.
#define FIT_RINGS 4
#define MOST_AROUND 64
/// Number of deviations for an estimate of noise, and factor of their median for normal noise.
#define LEAST_DEPARTURES 6
#define DEVIATION_BY_MEDIAN 1.4826f
/// Deviations to each side in a confidence interval.
#define CONFIDENCE 1.5f

// ---- Texels and seams (bake_texels.c, bake_seam.c, bake_stitch.c, target_lightmap.c) -----------------

/// Texels whose middle is within one triangle, and in another by this share of a texel or of its height, show that a
/// chart overlaps itself; borders may touch, and rounding moves them by far less.
#define OVERLAP_DEPTH 0.05f
/// A texel whose middle is this near to a border, in texels, is on it.
#define ON_BORDER 1e-2f
/// How much brighter or darker a texel beyond a border may be than the border.
#define MOST_BEYOND 0.5f
/// Samples along a border edge: per texel, and maximum.
#define SAMPLES_PER_TEXEL 2
#define MOST_SAMPLES 64
/// Jumps beyond this share are seen.
#define SEEN 0.01
/// Cosine between normals from which on a surface is smooth, and share by which light may differ on both sides.
#define SEAM_SMOOTH 0.94f
#define CONTINUOUS 0.002f
/// Number of passes towards the solved light, before both sides are made equal.
#define TRUE_PASSES 5
/// An invisible jump, how often it is checked, and when to give up. Measured: cornell-marble: 0.5 % by conjugate
/// gradients; 1,000 passes of Kaczmarz's method left 3.1 %.
#define CLOSED 0.005
#define STEPS_PER_LOOK 25
#define MOST_STEPS 2000
/// Light below 0 is cut off, which opens jumps again, ever smaller ones.
#define STITCH_ROUNDS 40
/// Factor of the weight of remaining jumps in the next round, and number of the rounds in which it applies. Measured:
/// wooden_staircase, draft: largest seam 0.58 % instead of 5.3 %, modern_hall 0.45 % instead of 0.91 %.
#define STRESS 2
#define STRESSED_ROUNDS 12
/// Texels on surfaces change this much less than those beyond borders, which are otherwise invisible.
#define STIFFNESS 0.2f
/// How often charts whose seams stay open get more texels. Measured: white room, draft: largest seam 6.1 % without, 2 %
/// after three rounds, below 1 % after five.
#define MOST_REFINEMENTS 6
/// Codes end at this share of the texels: the brightest few are clipped, for the sake of the others' precision.
#define BRIGHTEST 0.999

// ---- Vertices (bake_cells.c, bake_tessellate.c) ------------------------------------------------------

/// How far on the way to the middle of a cell its corners are looked up.
#define PULL 1e-3f
/// Points this close to an edge are on it: a fraction of the finest cells, or the rounding of coordinates, relative to
/// the largest.
#define ON_EDGE 1e-3f
#define ROUNDED 4e-7f
/// Unlit vertices with this many times the mean light are white: viewers show them unchanged, as a photograph would.
#define UNLIT_WHITE 4
/// Light that is no brighter than this times another was only rounded.
#define SAME 1.00001f
/// Error of light that decides where triangles are divided, as a share of the tolerance: noise must not divide any.
#define QUIET 0.25f
/// Vertices are doubled where light differs by more than this.
#define JUMP 0.02f

// ---- Bases (bake_basis.c) -----------------------------------------------------------------------------

/// Bytes of a basis that is announced before it is made, and that is refused where no limit of memory was given.
#define LARGE_BASIS (256 * 1e6)
#define LARGEST_BASIS (16 * 1e9)
/// More lights take minutes: that is said too. Measured: a room of 100 lamps, draft, 128 x 112 texels: 48 s of CPU
/// time.
#define MANY_LIGHTS 32

// ---- Light by direction and relit light (bake_directions.c, bake_relit.c) ----------------------------

/// Of the normals that are read, radians: bumps are seldom steeper.
#define TILT 0.78539816f
#define TILTS 3
/// Of each reading.
#define TILT_SAMPLES 64
/// d, at most.
#define LONGEST 4.0f
/// Relative difference that is due to rounding.
#define ROUNDING 1e-5f

#endif
