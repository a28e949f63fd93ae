/// Constants of plans by error.
#ifndef RSV_PLAN_CONSTANTS_H
#define RSV_PLAN_CONSTANTS_H

/// The settings of quality `draft` suit a picture with this many pixels and this relative MSE. Smaller pictures show
/// less of the elements' error, which decreases with their number; the error of their rays decreases with the rays.
#define USUAL_ELEMENTS 3000
#define USUAL_PIXELS 32400.0
#define USUAL_ERROR 0.005
#define USUAL_RAYS 128
#define LEAST_ELEMENTS 500.0
#define MOST_ELEMENTS 1e6
#define LEAST_RAYS 64
#define MOST_RAYS 1024
/// Noise of rows lies in blotches, which the eye sees before grain of the same size. Rows that have fewer rays than
/// this for each pixel cost less than the picture: they get more of them. Pictures with more noise than usual may have
/// fewer in proportion.
#define ROW_RAYS_PER_PIXEL 20.0
/// Bound of what the solver leaves, relative to the mean irradiance, for a relative error of 1. The bound is of the
/// worst place, several times what others have.
#define SOLVER_SHARE 0.01
/// Light paths for caustics, and fraction of the usual elements at contacts, that suit this error. The noise of
/// caustics decreases with the paths. The error at contacts, which are along lines, decreases with the root of their
/// elements.
#define USUAL_PHOTONS 250000
#define USUAL_CONTACTS 0.6
#define LEAST_PHOTONS 40000.0
#define MOST_PHOTONS 6e6
/// Below this error, pilots for curved light and a search for what the camera does not see are worthwhile, except in
/// simple scenes, of fewer triangles than elements: these begin with elements and rows for this error, or EASED times
/// the target, and the look at elements decides whether they are enough. cornell-blocks at 160x160 for 0.001 took 3.9 s
/// with pilots, 512 rays and a goal camera, 2.0 s without, at the same error (0.0011). For 0.000225, where the look
/// decides nothing, beginning at 0.002 left 0.0003. In the modern hall (28,655 triangles) at 160x90 for 0.0009, such a
/// beginning left 0.0017 instead of 0.0012 in the same time.
#define DEMANDING 0.002
#define EASED 4.0
#define REFINEMENTS 3
/// Fraction of the target error that elements may cause in any case. The noise of samples may always use this fraction,
/// because samples are cheaper than elements.
#define ELEMENTS_SHARE 0.75
#define LEAST_NOISE_SHARE 0.2
/// The same in pictures that are filtered, where what is left is hard to get rid of: in the classroom, 220 samples
/// instead of 135 took 50 of 190 CPU s, and the error was mostly due to elements.
#define LEAST_FILTERED_NOISE_SHARE 0.5
/// Fraction of the target error that elements usually cause, and its standard deviation: 0.1 in cornell-blocks, 0.3 in
/// the modern hall, 1 in the staircase and the white room. Estimates count as far as they are more certain.
#define USUAL_ELEMENTS_SHARE 0.3
#define ELEMENTS_SHARE_SPREAD 0.5
/// Least fraction in pictures that are filtered. It is not worthwhile to know it better there: a longer look would take
/// as long as the picture, and samples are few. In the hall, the staircase, the white room and the classroom at 320x180
/// and 7 %, pictures whose noise was to be all of the target had 0.7, 2.4, 2.1 and 3.1 times the squared error requested.
#define FILTERED_ELEMENTS_SHARE 0.5
/// Cost of a camera ray with a gather ray, and of one without, in rays of rows, all included. Measured in the white
/// room and the Japanese classroom: 0.6 to 1.7 us for a ray of rows, 13 and 9 us for a camera ray.
#define GATHERED_COST 20.0
#define SAMPLE_COST 14.0
/// Cost of a row beside its rays, in rays: elements, pilots, solver. Measured in the modern hall and the white room at
/// draft: 0.9 and 1.3 ms.
#define ROW_COST 1000.0
/// An error beyond the target makes a remedy so much dearer: it is accepted where others cost several times as much.
#define EXCESS_POWER 4
/// Fraction of the error of elements that gather rays leave, because only the first order of indirect light is
/// gathered. In cornell-blocks with 40 elements, 0.0015 is left; in two-rooms at draft, 0.0013 of 0.009.
#define GATHERED_LEFT 0.2
/// Part of the noise of gather rays that the filter leaves, at 160x90 with 4 and 8 camera rays: 0.1 in the modern hall,
/// 0.3 to 0.4 in the white room, where some gather rays are sparks.
#define FILTERED_GATHERING 0.2
/// The light that gather rays come to has a part of the same error, so that stored light differs less from gathered
/// light than from the truth. Relative MSE, stored against gathered and against the path tracer: gallery 0.0021 and
/// 0.0035, two-rooms 0.0095 and 0.0148, hall 0.0038 and 0.0060, staircase 0.0125 and 0.0174.
#define BEYOND_GATHERING 1.5
/// A finer solution has so many times the elements as its error is too large, times REFINED_BY, within these limits.
/// Its rows have twice the rays if the error is too large by more than RAYS_EXCESS. In the Japanese classroom, three
/// times the elements with the same rays left a fifth of the error; a third round of pilots on top of that took 2.5 times the
/// rays and left no less. A round that leaves more than LEAST_PROGRESS of the error has not helped: the next one has
/// STUCK_RAYS times the rays instead, with as many elements, and is the last if it does not help either.
#define LEAST_REFINEMENT 2.0
#define MOST_REFINEMENT 4.0
#define REFINED_BY 1.5
#define RAYS_EXCESS 3.0
#define LEAST_PROGRESS 0.8
#define STUCK_RAYS 4
/// Where elements err too much, pixels gather whose squared error is above this fraction of the target, if they are no
/// more than this share of the picture, with so many rays per camera ray. Japanese classroom, 160x90, for 0.0049: of an
/// error of 0.0092, 0.0038 is left where 6 % of the pixels gather, 0.0028 at 12 %, 0.0023 at 20 %.
#define SELECTED_ABOVE 0.2
#define MOST_SELECTED 0.5
#define SELECTED_RAYS 4
/// Gather rays that select pixels, and those of each camera ray at most.
#define SELECTING_RAYS 2e6
#define MOST_SELECTING_RAYS 8
#define MOST_ROUNDS 4
/// Between the seeds of pictures.
#define OTHER_SEED 0x9e3779b9u
/// Targets above this begin with one camera ray in each half, others with two.
#define GENEROUS (2 * USUAL_ERROR)
/// The error of elements is estimated at SPOTS pixels with FIRST_RAYS gather rays each. If that leaves more than
/// DOUBTFUL_SHARE of the target error uncertain, more rays follow at as many others, for up to LOOK_SHARE of the cost
/// of rows and samples. Few pixels have most of the error: 800 with 32 rays each cost about as much as 3200 with 8, but
/// by the spread of errors in the classroom leave .0018 uncertain, calculated, instead of .0010. GATHER_RAY_COST is that of a gather ray alone, like GATHERED_COST.
#define SPOTS 3200
#define FIRST_RAYS 8
#define LOOK_SHARE 0.3
#define GATHER_RAY_COST (GATHERED_COST - SAMPLE_COST)
#define DOUBTFUL_SHARE 0.25
#define MOST_SAMPLES 4096
/// Passes where the picture is noisy, and how far noise may exceed what is allowed after the first.
#define MOST_PASSES 8
#define RETAKE 1.1
/// Estimates of the relative error that exceed the target by less than this count as reaching it.
#define TOLERANCE 1.15

#endif
