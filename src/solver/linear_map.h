/// A square linear map A on fields, for solvers of x = b + A x.
///
/// A *field* is [count x columns] floats, row-major: `columns` scalar fields that share one pass over the data of A.
/// Column c belongs to colour channel c % 3, for which A may have separate entries. Three columns are one RGB field, 3
/// n columns the fields of n light sources.
///
/// A is the product G K of a local *scattering* K and a *gathering* G. Users of rows or columns see the two separately;
/// a plain matrix has K = 1.
#ifndef RSV_LINEAR_MAP_H
#define RSV_LINEAR_MAP_H

#include "../core/core.h"

/// Request for a correction, and its result.
typedef struct rsv_correction {
    double relative; ///< length of the new residual over that of the old one
    double
        applications; ///< of A; in: approximate limit, out: number used
    bool converged;   ///< out: false if it gave up
} rsv_correction;

/// Results depend only on the arguments, to the last bit, not on the number of threads. NULL is allowed where noted.
typedef struct rsv_linear_map_table {
    /// image = A field
    void (*apply)(void *data, size_t columns, const float *field, float *image);
    /// image = A* field; NULL = not known
    void (*apply_transpose)(void *data, size_t columns, const float *field, float *image);
    /// residual = source + A field - field, with sums in double; NULL = by `apply`
    void (*residual)(
        void *data, size_t columns, const float *source, const float *field, float *residual);
    /// scattered = K field in rows [begin, end). Called for all rows first; for a part of them it may leave out
    /// rows that depend on others. NULL, as gather_rows = rows are not known
    void (*scatter_rows)(
        void *data, size_t columns, const float *field, size_t begin, size_t end, float *scattered);
    /// image = G scattered in rows [begin, end)
    void (*gather_rows)(
        void *data, size_t columns, const float *scattered, size_t begin, size_t end, float *image);
    /// field += A times `amount` at one node: a column of A. NULL = not known
    /// @param amount [columns] @return the share of A's entries that this took
    double (*shoot)(void *data, size_t columns, size_t node, const float *amount, float *field);
    /// correction with (I - A) correction close to a residual, by a solver outside of this library. NULL = there is
    /// none
    rsv_status (*correct)(void *data, size_t columns, const float *residual, rsv_correction *wanted,
        float *correction);
    /// Sums of A's entries over pairs of groups, channel by channel; may be an approximation. NULL = not known
    /// @param sums [3 x group_count x group_count], zero before
    void (*sum_groups)(void *data, double *sums);
} rsv_linear_map_table;

typedef struct rsv_linear_map {
    rsv_context *context;
    const rsv_linear_map_table *table;
    void *data;
    size_t count; ///< rows and columns of A
    const uint32_t *
        group; ///< [count] a coarse level: groups of similar nodes; RSV_NONE = a row of A that is 0. NULL =
               ///< there is no coarse level
    size_t group_count;
    bool
        outside; ///< `correct` is the algorithm of a solver of this library, run elsewhere
} rsv_linear_map;

/// A* as a map. It has no rows, columns or groups.
/// @param map with apply_transpose; borrowed, must not move
rsv_linear_map rsv_linear_map_transposed(const rsv_linear_map *map);

#endif
