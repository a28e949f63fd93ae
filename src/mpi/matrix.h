/// G K and I - G K as PETSc matrices.
///
/// Unknowns are numbered along the curve that divides the rows, with red, green and blue of a node side by side: one
/// matrix of three uncoupled channels, so that one pass over the rows and one exchange of values serves all of them.
#ifndef RSV_DIST_MATRIX_H
#define RSV_DIST_MATRIX_H

#include "plug_in.h"

#include <petscksp.h>

/// A system, and the data for its products in this process.
typedef struct rsv_mpi_rows {
    rsv_krylov_system system;
    MPI_Comm communicator;
    size_t first, count;   ///< this process's rows, along the curve
    const uint32_t *order; ///< [node_count] the curve
    uint32_t *identity;    ///< owned: that of one process
    size_t needed_count;
    uint32_t *needed; ///< nodes whose values its rows need, or their parents
    size_t hanging_count;
    uint32_t *hanging; ///< hanging nodes that its rows need: indices into the elements' list
    rsv_rgb *filled;   ///< [node_count] E, where needed
    rsv_rgb *exitance; ///< [node_count] B = K E
    Vec values;        ///< [3 x needed_count]
    VecScatter exchange;
    rsv_krylov_traffic traffic;
} rsv_mpi_rows;

PetscErrorCode rsv_mpi_rows_create(const rsv_krylov_system *system, rsv_mpi_rows *rows);
void rsv_mpi_rows_destroy(rsv_mpi_rows *rows);

/// y = G K x, without forming the product.
PetscErrorCode rsv_mpi_shell_gather(rsv_mpi_rows *rows, Mat *matrix);
/// y = x - G K x, as a shell matrix.
PetscErrorCode rsv_mpi_shell_system(rsv_mpi_rows *rows, Mat *matrix);
/// I - G K, entry by entry, for preconditioners that look at entries.
PetscErrorCode rsv_mpi_assembled_system(rsv_mpi_rows *rows, Mat *matrix);

/// Converts between a field that all processes have and a vector.
PetscErrorCode rsv_mpi_set(const rsv_mpi_rows *rows, const rsv_rgb *field, Vec x);
PetscErrorCode rsv_mpi_get(const rsv_mpi_rows *rows, Vec x, rsv_rgb *field);

#endif
