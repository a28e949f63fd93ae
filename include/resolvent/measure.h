/// @file measure.h
/// Costs of single parts of the work, compared with lower limits. For benchmarks; resolvent.h does not include it.
#ifndef RESOLVENT_MEASURE_H
#define RESOLVENT_MEASURE_H

#include "resolvent/device.h"
#include "resolvent/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Times an application of G K, and right after it a bare loop that sums a field over the same indices.
/// @param ratio out, [repetitions] time of the bare loop / time of the application
RSV_API rsv_status rsv_measure_application(
    const rsv_light *light, uint32_t repetitions, double *ratio);

/// Times an application of G K, and copies, on the device of the solution's context, by the device's clock.
/// @param copy_rate out, [repetitions]: bytes per second, read and written, of copies too large for any cache
/// @param seconds out, [repetitions]: time of an application
/// @param bytes out: minimum number of bytes that an application moves
RSV_API rsv_status rsv_measure_device(const rsv_light *light, uint32_t repetitions,
    double *copy_rate, double *seconds, size_t *bytes);

/// Cost of a solver.
typedef struct rsv_solver_cost {
    rsv_solver solver; ///< the solver that was used, never RSV_SOLVER_AUTO
    rsv_stop_reason stop_reason;
    double applications; ///< of G K, or passes over its entries that cost as much
    double seconds;      ///< total, with transposed copies, coarse levels and calls of `observe`
    double residual;     ///< max |residual| / max E0, largest of the channels
} rsv_solver_cost;

/// Solves the coarse system of a solution again, from zero and without keeping orders separately.
/// @param tolerance of the residual, defined as in rsv_solver_cost
/// @param observe called with each residual that the solver computes; NULL = none
RSV_API rsv_status rsv_measure_solver(const rsv_light *light, rsv_solver solver, double tolerance,
    void (*observe)(void *user, double applications, double residual), void *user,
    rsv_solver_cost *cost);

/// Cost of dividing the rows of G among processes, as numbers that depend little on the machine.
typedef struct rsv_division_cost {
    uint32_t parts;
    double imbalance;     ///< time to trace the most expensive part / mean of all parts
    double received_mean; ///< numbers that a part needs from others for one application of G K
    double received_most; ///< the same for the part that needs most
    double senders_mean;  ///< number of parts that they come from
} rsv_division_cost;

/// Divides the rows of a solution as a team of that many processes would, by costs measured on a few rows. Then traces
/// all rows again to measure the cost of the parts.
/// @param parts [count]
/// @param cost out, [count]
RSV_API rsv_status rsv_measure_division(
    const rsv_light *light, const uint32_t *parts, size_t count, rsv_division_cost *cost);

/// Cost of assembly compared with ray tracing alone.
typedef struct rsv_assembly_cost {
    uint64_t rays;           ///< first-hit rays of the rows
    double assembly_seconds; ///< the rows of G: aiming, tracing, element lookup, storage
    double tracing_seconds;  ///< ray tracing alone, with the same packets of rays
    double single_seconds;   ///< ray tracing alone, with the same rays one by one
} rsv_assembly_cost;

/// Assembles the coarse rows of a solution again, and then traces the same rays without using the results. Both run
/// right after each other, so that the ratio does not depend on the load of the machine.
/// @param light of a scene with only Lambertian surfaces, so that every ray ends at its first hit
RSV_API rsv_status rsv_measure_assembly(const rsv_light *light, rsv_assembly_cost *cost);

/// Computes the direct light of the coarse elements again. @param seconds out: total time @param rays out: shadow rays
RSV_API rsv_status rsv_measure_direct(const rsv_light *light, double *seconds, uint64_t *rays);

/// Traces the camera rays of a frame in the same packets and tiles, without using the results: the minimum time of a
/// frame.
/// @return seconds
RSV_API double rsv_frame_trace_only(rsv_frame_renderer *renderer, const rsv_frame_view *view);

/// Seconds that the last picture took until it was in device memory, or in the image if it was made on the CPU.
RSV_API double rsv_occlusion_seconds(const rsv_occlusion *occlusion);

/// Times relighting with all scales changed, by the device's clock. @param seconds out, [repetitions]
RSV_API rsv_status rsv_device_basis_measure(
    rsv_device_basis *basis, uint32_t repetitions, double *seconds);

#ifdef __cplusplus
}
#endif

#endif
