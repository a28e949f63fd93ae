/// Beams: the triangles that all camera rays of a part of a picture may hit, found at once.
///
/// The rays of a few hundred neighbouring pixels mostly hit the same few triangles. A beam, the pyramid around these
/// rays, traverses the hierarchy of ../bvh once for all of them, and lists the triangles in it that are not hidden.
/// Packets are then tested only against these. If a beam finds too many, and with cut-out surfaces, orthographic
/// cameras, and once triangles move (rsv_tracer_set_apart), packets are traced in the usual way.
///
/// Hits are those of the ray tracer, up to rounding: the test is that of Embree's robust mode, with edge functions that
/// are exact opposites for the two triangles at an edge, and tolerances larger than rounding (Davidovic, Engelhardt,
/// Georgiev, Slusallek and Dachsbacher, "3D Rasterization: A Bridge between Rasterization and Ray Casting", 2012).
#ifndef RSV_BEAM_H
#define RSV_BEAM_H

#include "../bvh/bvh.h"
#include "../trace/camera_ray.h"

/// Triangles of a beam at most.
#define RSV_BEAM_TRIANGLES 32

/// A triangle seen from the eye. Its corners weigh as side[k] . direction for a ray that meets it, all of them
/// positive.
typedef struct rsv_beam_triangle {
    float side[3][3]; ///< normals of planes through the eye and the edge opposite corner k, inwards
    float normal[3];  ///< of its own plane, away from the eye
    float reach;      ///< rays meet that plane at reach / (normal . direction)
    float slack[3];   ///< weights above -slack count as positive
    float front;      ///< -1 where the normal is that of the back
    uint32_t triangle;
} rsv_beam_triangle;

typedef struct rsv_beam {
    uint32_t count;
    rsv_beam_triangle of[RSV_BEAM_TRIANGLES]; ///< [count]
    /// [count] indices into `of`, the scene's order: of two triangles at one distance, rays meet the last, as Embree's
    /// do.
    uint8_t order[RSV_BEAM_TRIANGLES];
    const rsv_scene_view *twins; ///< the scene, if faces of it lie in the same place; else NULL
} rsv_beam;

/// How beams see through the lens of a frame: places of points as (across, upwards, 1) * depth, as in rsv_lens_ray.
typedef struct rsv_beam_lens {
    bool usable;
    rsv_lens lens;
    rsv_vec3 across, upwards, depth; ///< products with a point's offset from the eye
    float slack;                     ///< by which rounding may move rays, in across and upwards
} rsv_beam_lens;

rsv_beam_lens rsv_beam_lens_of(const rsv_lens *lens);

/// Data for beams. Valid until triangles move.
typedef struct rsv_beams {
    const rsv_tracer *tracer;
    rsv_bvh_view bvh;
    bool hold;
} rsv_beams;

/// Has the tracer's hierarchy built, a second or so per million triangles, unless there are too many of them.
rsv_status rsv_beams_create(const rsv_tracer *tracer, rsv_beams *beams);

/// Call it before every frame.
void rsv_beams_refresh(rsv_beams *beams, const rsv_tracer *tracer);

#endif
