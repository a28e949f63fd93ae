/// What the room tunes by, with what was measured of it. The rest is chosen, not measured.
#ifndef RSV_OPERATOR_CONSTANTS_H
#define RSV_OPERATOR_CONSTANTS_H

// ---- Rows and their rays (directions.c, transport.c) -------------------------------------------------

/// Standard deviation of stratified rows over that of as many independent rays. Measured: cornell-blocks, 0.52 at 64 rays,
/// 0.40 at 1024.
#define STRATIFIED 0.45f

// ---- Rows that follow what moves (tracked_rows.c) ----------------------------------------------------

/// Room for what moves out of a scene, on each side, as a part of its size: beyond, all rows are traced anew. Twice the room
/// halves the precision of the corners of paths, which is 1/65536 of it.
#define TRAIL_ROOM 0.5f

// ---- What rows cost (row_costs.c) --------------------------------------------------------------------

/// Rows along the curve that are taken to cost alike, ...
#define STRETCH 16
/// ... and the rays of the one in their middle that tell how much. Measured, dearest part over the mean, on a busy machine:
/// terraces:1e6 over 8 parts 1.020, over 64 1.073; gallery:1 over 8 1.08. With the next two.
#define COST_RAYS 64
/// Probes that a thread takes at a time: neighbours, as in the assembly.
#define COST_TURN 16
/// A probe that takes so many times the one before is timed once more: the machine may have been busy. Measured: without
/// it, and with probes along the curve, terraces:1e6 over 8 parts 1.08 to 1.20.
#define DOUBTFUL 4

// ---- Portions of work (rows.c, row_device.c, rows_stored.c, transport.c) -----------------------------

/// Blocks of rows that are traced before these move to the operator: enough to keep all threads busy to the end. Measured:
/// terraces:3e5, medium: 649 MB at the peak, 1212 where all rows were traced first.
#define BLOCKS_PER_THREAD 64
/// Rays in flight on a device: enough for any.
#define RAYS_AT_A_TIME ((size_t)1 << 22)
/// Entries below which waking the threads takes longer than the work.
#define PARALLEL_ENTRIES 65536

#endif
