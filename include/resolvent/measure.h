/// @file measure.h
/// What parts of the work cost by themselves, beside the least that they could cost: what benchmarks ask for, and programs do not.
/// resolvent.h does not include it.
#ifndef RESOLVENT_MEASURE_H
#define RESOLVENT_MEASURE_H

#include "resolvent/device.h"
#include "resolvent/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Times an application of G K beside a bare loop that sums a field over the same indices, one right after the other.
/// @param ratio out, [repetitions] the bare loop's time over the application's
RSV_API rsv_status rsv_measure_application(
    const rsv_light *light, uint32_t repetitions, double *ratio);

/// Times an application of G K on the device of the solution's context, and copies there, by its clock.
/// @param copy_rate out, [repetitions]: bytes per second, read and written, of copies too large for any cache
/// @param seconds out, [repetitions]: of an application
/// @param bytes out: that an application must move at least
RSV_API rsv_status rsv_measure_device(const rsv_light *light, uint32_t repetitions,
    double *copy_rate, double *seconds, size_t *bytes);

/// What a solver did.
typedef struct rsv_solver_cost {
    rsv_solver solver; ///< in the end, where RSV_SOLVER_AUTO was asked for
    rsv_stop_reason stop_reason;
    double applications; ///< of G K, or passes over its entries that cost as much
    double seconds;      ///< all included: transposed copies, coarse levels, observing
    double residual;     ///< largest max |residual| / max E0 of a colour channel
} rsv_solver_cost;

/// Solves the coarse system of a solution once more, from nothing and without keeping orders apart.
/// @param tolerance of the residual, on the scale of rsv_solver_cost
/// @param observe called whenever the solver knows a residual; NULL = none
RSV_API rsv_status rsv_measure_solver(const rsv_light *light, rsv_solver solver, double tolerance,
    void (*observe)(void *user, double applications, double residual), void *user,
    rsv_solver_cost *cost);

/// What it would mean to divide the rows of G among processes, by numbers that do not depend on how many there are.
typedef struct rsv_division_cost {
    uint32_t parts;
    double imbalance;     ///< time that tracing the dearest part took, over the mean of all parts
    double received_mean; ///< numbers that a part needs from others for one application of G K
    double received_most; ///< of the part that needs most
    double senders_mean;  ///< parts that they come from
} rsv_division_cost;

/// Divides the rows of a solution as a team of so many processes would, by costs measured on a few of them, then traces
/// all once more to see what the parts cost.
/// @param parts [count] @param cost out, [count]
RSV_API rsv_status rsv_measure_division(
    const rsv_light *light, const uint32_t *parts, size_t count, rsv_division_cost *cost);

/// What assembly costs beside ray tracing alone.
typedef struct rsv_assembly_cost {
    uint64_t rays;           ///< first-hit rays of the rows
    double assembly_seconds; ///< the rows of G: aiming, tracing, element lookup, storage
    double tracing_seconds;  ///< the same packets of rays through the ray tracer alone
    double single_seconds;   ///< the same rays one by one through the ray tracer alone
} rsv_assembly_cost;

/// Assembles the coarse rows of a solution again, and traces the very same rays without doing anything with
/// them, in the same run, so that the ratio does not depend on how busy the machine is.
/// @param light of a scene whose surfaces are all Lambertian, so that every ray ends at its first hit
RSV_API rsv_status rsv_measure_assembly(const rsv_light *light, rsv_assembly_cost *cost);

/// Finds the direct light of the coarse elements again. @param seconds, rays out: all that takes, shadow rays alone
RSV_API rsv_status rsv_measure_direct(const rsv_light *light, double *seconds, uint64_t *rays);

/// Traces the camera rays of a frame through the ray tracer, in the same packets and tiles, and does nothing with
/// what they meet: what a frame costs by ray tracing alone. @return seconds
RSV_API double rsv_frame_trace_only(rsv_frame_renderer *renderer, const rsv_frame_view *view);

/// Seconds that the last picture took until it lay where it was made: in a device's memory, or in the image.
RSV_API double rsv_occlusion_seconds(const rsv_occlusion *occlusion);

/// Times relighting with all scales replaced, by the device's clock. @param seconds out, [repetitions]
RSV_API rsv_status rsv_device_basis_measure(
    rsv_device_basis *basis, uint32_t repetitions, double *seconds);

#ifdef __cplusplus
}
#endif

#endif
