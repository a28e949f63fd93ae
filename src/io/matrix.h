/// 4x4 matrices, column-major, in double: node hierarchies can be deep.
#ifndef RSV_MATRIX_H
#define RSV_MATRIX_H

#include "resolvent/io.h"

#include <string.h>

/// The rotation that takes the axis that points up to y, times a scale.
static inline void rsv_matrix_upright(rsv_axis up, double scale, double matrix[16])
{
    static const double row[3][3][3] = { [RSV_AXIS_X] = { { 0, -1, 0 }, { 1, 0, 0 }, { 0, 0, 1 } },
        [RSV_AXIS_Y] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } },
        [RSV_AXIS_Z] = { { 1, 0, 0 }, { 0, 0, 1 }, { 0, -1, 0 } } };
    memset(matrix, 0, 16 * sizeof *matrix);
    for (int i = 0; i < 9; i++)
        matrix[4 * (i % 3) + i / 3] = scale * row[up][i / 3][i % 3];
    matrix[15] = 1;
}

/// result = a b; must not alias either
static inline void rsv_matrix_multiply(const double a[16], const double b[16], double result[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0;
            for (int k = 0; k < 4; k++)
                sum += a[4 * k + row] * b[4 * column + k];
            result[4 * column + row] = sum;
        }
}

#endif
