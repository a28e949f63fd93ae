/// Vector arithmetic on fields of several columns, each with factors of its own. Long sums are in double and
/// added up in an order that does not depend on the number of threads.
#ifndef RSV_COLUMNS_H
#define RSV_COLUMNS_H

#include "../core/core.h"

/// Shape of the fields of a run: [count x columns].
typedef struct rsv_field_shape {
    rsv_context *context;
    size_t count, columns;
    double *partial; ///< [rsv_partial_length] sums of blocks of rows
} rsv_field_shape;

/// Doubles that `partial` holds.
size_t rsv_partial_length(size_t count, size_t columns);

/// product[c] = <a_c, b_c>
void rsv_columns_dot(const rsv_field_shape *shape, const float *a, const float *b, double *product);
/// norm[c] = max |a_c|; NAN if a value is not a number
void rsv_columns_max(const rsv_field_shape *shape, const float *a, double *norm);
/// y += factor x; a factor of 0 leaves a column as it is
void rsv_columns_add(const rsv_field_shape *shape, const double *factor, const float *x, float *y);
/// y = x + factor y
void rsv_columns_scale_add(
    const rsv_field_shape *shape, const float *x, const double *factor, float *y);
/// y = factor x
void rsv_columns_scale(
    const rsv_field_shape *shape, const double *factor, const float *x, float *y);
/// y += x
void rsv_columns_sum(const rsv_field_shape *shape, const float *x, float *y);
/// y -= x
void rsv_columns_subtract(const rsv_field_shape *shape, const float *x, float *y);

#endif
