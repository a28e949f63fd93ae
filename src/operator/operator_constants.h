/// Tuning constants of the room, with the measurements behind them. Constants without a measurement were chosen.
#ifndef RSV_OPERATOR_CONSTANTS_H
#define RSV_OPERATOR_CONSTANTS_H

// ---- Rows and their rays (directions.c, transport.c) -------------------------------------------------

/// Standard deviation of stratified rows over that of as many independent rays. Measured: cornell-blocks, 0.52 at 64
/// rays, 0.40 at 1024.
#define STRATIFIED 0.45f

// ---- Rows that follow moving objects (tracked_rows.c) -----------------------------------------------

/// Margin around a scene for objects that move out of it, on each side, relative to its size. Beyond it, all rows are
/// traced again. Twice the margin halves the precision of the corners of paths, which is 1/65536 of it.
#define TRAIL_ROOM 0.5f

// ---- Cost of rows (row_costs.c) ----------------------------------------------------------------------

/// Rows along the curve that are assumed to cost the same, ...
#define STRETCH 16
/// ... and rays of the middle one, which is timed. Measured, most expensive part / mean, on a busy machine:
/// terraces:1e6 over 8 parts 1.020, over 64 1.073; gallery:1 over 8 1.08. With the next two.
#define COST_RAYS 64
/// Probes that a thread takes at a time: neighbours, as in the assembly.
#define COST_TURN 16
/// A probe that takes this many times as long as the previous one is timed again, because the machine may have been
/// busy. Measured: without this, and with probes in the order of the curve, terraces:1e6 over 8 parts 1.08 to 1.20.
#define DOUBTFUL 4

// ---- Portions of work (rows.c, row_device.c, rows_stored.c, transport.c) -----------------------------

/// Blocks of rows that are traced before these move to the operator: enough to keep all threads busy to the end.
/// Measured: terraces:3e5, medium: 649 MB at the peak, 1212 where all rows were traced first.
#define BLOCKS_PER_THREAD 64
/// Rays in flight on a device: enough for any.
#define RAYS_AT_A_TIME ((size_t)1 << 22)
/// Entries below which waking the threads takes longer than the work.
#define PARALLEL_ENTRIES 65536

#endif
