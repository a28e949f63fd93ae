/// The system (I - G K) x = b as solvers outside of this library see it: rows and fields divided among the processes of
/// a team. PETSc's are reached through the team's plug-in (src/mpi).
#ifndef RSV_KRYLOV_H
#define RSV_KRYLOV_H

#include "../core/parallel.h"
#include "../diffusion/subsurface.h"
#include "../operator/transport.h"
#include "resolvent/team.h"

typedef struct rsv_krylov rsv_krylov;

/// Parts of the system; borrowed.
typedef struct rsv_krylov_system {
    rsv_team *team;
    const rsv_transport *transport; ///< the rows of this process, and whose the others are
    const rsv_elements *elements;   ///< which nodes hang
    const rsv_rgb *albedo;          ///< [node_count]
    /// rsv_parallel_for, which plug-ins cannot call by its name
    void (*parallel_for)(const rsv_context *context, size_t count, size_t grain,
        void (*body)(void *job, rsv_span span), void *job);
    const rsv_context *context; ///< whose workers apply the rows
    /// exitance = K field on all nodes, if light leaves elsewhere than it entered; NULL = K is only the albedo
    void (*scatter)(void *user, const rsv_rgb *field, rsv_rgb *exitance);
    void *user;
} rsv_krylov_system;

/// Communication for one application of G K.
typedef struct rsv_krylov_traffic {
    size_t received; ///< numbers that this process needs from others
    size_t senders;  ///< processes that they come from
} rsv_krylov_traffic;

/// How a system was solved.
typedef struct rsv_krylov_report {
    double applications; ///< of G K
    bool converged;      ///< false if the method gave up
} rsv_krylov_report;

/// All calls are collective. Failures are the same in all processes and set `message` [RSV_MESSAGE_BYTES].
struct rsv_krylov_table {
    rsv_status (*create)(const rsv_krylov_system *system, rsv_krylov **krylov, char *message);
    void (*destroy)(rsv_krylov *krylov);
    /// Solves (I - G K) correction = residual for whole RGB fields, known to all processes before and after.
    /// @param relative tolerance, unless PETSc's options say another
    rsv_status (*solve)(rsv_krylov *krylov, const rsv_rgb *residual, double relative,
        rsv_rgb *correction, rsv_krylov_report *report, char *message);
    /// The eigenvalues of G K with the largest magnitude, of all channels together.
    /// @param count in: number wanted, out: number found @param value [2 x count] real and imaginary parts
    rsv_status (*eigenvalues)(rsv_krylov *krylov, size_t *count, double *value, char *message);
    rsv_krylov_traffic (*traffic)(const rsv_krylov *krylov);
};

#endif
