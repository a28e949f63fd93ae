/// 4x4 matrices, column-major, in double: node hierarchies can be deep, and far from the origin.
#ifndef RSV_MATRIX_H
#define RSV_MATRIX_H

#include "resolvent/io.h"

#include <math.h>
#include <stdbool.h>
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

/// T * R * S, of any length of the quaternion `q` (x, y, z, w). False if that is zero.
static inline bool rsv_matrix_place(
    const double t[3], const double q[4], const double s[3], double m[16])
{
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 0)) return false;
    double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
    const double rotation[3][3] = {
        { 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w) },
        { 2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w) },
        { 2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y) },
    };
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++)
            m[4 * column + row] = rotation[column][row] * s[column];
        m[4 * column + 3] = 0;
        m[12 + column] = t[column];
    }
    m[15] = 1;
    return true;
}

/// Determinant of the linear part, up to a positive factor.
static inline double rsv_matrix_handedness(const double m[16])
{
    double x = m[5] * m[10] - m[6] * m[9], y = m[6] * m[8] - m[4] * m[10];
    double z = m[4] * m[9] - m[5] * m[8];
    return m[0] * x + m[1] * y + m[2] * z;
}

#endif
