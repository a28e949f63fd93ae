/// Products of 4x4 matrices, column-major, in double: node hierarchies can be deep.
#ifndef RSV_MATRIX_H
#define RSV_MATRIX_H

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
