/// A small dense matrix as a linear map that offers every operation, for the tests of solvers.
#ifndef RSV_TEST_DENSE_MAP_H
#define RSV_TEST_DENSE_MAP_H

#include "solver/linear_map.h"

#include <string.h>

#define DENSE_MAX 24

typedef struct dense_map {
    rsv_linear_map linear;
    double a[DENSE_MAX][DENSE_MAX];
    uint32_t group[DENSE_MAX];
} dense_map;

static inline void dense_rows(
    void *data, size_t columns, const float *field, size_t begin, size_t end, float *image)
{
    const dense_map *m = data;
    for (size_t i = begin; i < end; i++)
        for (size_t c = 0; c < columns; c++) {
            double sum = 0;
            for (size_t j = 0; j < m->linear.count; j++)
                sum += m->a[i][j] * field[j * columns + c];
            image[i * columns + c] = (float)sum;
        }
}

static inline void dense_apply(void *data, size_t columns, const float *field, float *image)
{
    dense_rows(data, columns, field, 0, ((dense_map *)data)->linear.count, image);
}

static inline void dense_transpose(void *data, size_t columns, const float *field, float *image)
{
    const dense_map *m = data;
    for (size_t j = 0; j < m->linear.count; j++)
        for (size_t c = 0; c < columns; c++) {
            double sum = 0;
            for (size_t i = 0; i < m->linear.count; i++)
                sum += m->a[i][j] * field[i * columns + c];
            image[j * columns + c] = (float)sum;
        }
}

static inline void dense_residual(
    void *data, size_t columns, const float *source, const float *field, float *residual)
{
    const dense_map *m = data;
    for (size_t i = 0; i < m->linear.count; i++)
        for (size_t c = 0; c < columns; c++) {
            double sum = (double)source[i * columns + c] - (double)field[i * columns + c];
            for (size_t j = 0; j < m->linear.count; j++)
                sum += m->a[i][j] * (double)field[j * columns + c];
            residual[i * columns + c] = (float)sum;
        }
}

static inline void dense_copy(
    void *data, size_t columns, const float *field, size_t begin, size_t end, float *copy)
{
    (void)data;
    memcpy(copy + begin * columns, field + begin * columns, (end - begin) * columns * sizeof *copy);
}

static inline double dense_shoot(
    void *data, size_t columns, size_t node, const float *amount, float *field)
{
    const dense_map *m = data;
    for (size_t i = 0; i < m->linear.count; i++)
        for (size_t c = 0; c < columns; c++)
            field[i * columns + c] += (float)(m->a[i][node] * amount[c]);
    return 1 / (double)m->linear.count;
}

static inline void dense_sum(void *data, double *sums)
{
    const dense_map *m = data;
    size_t groups = m->linear.group_count;
    for (size_t channel = 0; channel < 3; channel++)
        for (size_t i = 0; i < m->linear.count; i++)
            for (size_t j = 0; j < m->linear.count; j++)
                sums[(channel * groups + m->group[i]) * groups + m->group[j]] += m->a[i][j];
}

/// A zero matrix of `count` rows, with pairs of neighbours as groups.
static inline dense_map *dense_begin(rsv_context *context, size_t count)
{
    static const rsv_linear_map_table table = { .apply = dense_apply,
        .apply_transpose = dense_transpose,
        .residual = dense_residual,
        .scatter_rows = dense_copy,
        .gather_rows = dense_rows,
        .shoot = dense_shoot,
        .sum_groups = dense_sum };
    dense_map *m = calloc(1, sizeof *m);
    assert_non_null(m);
    for (uint32_t i = 0; i < count; i++)
        m->group[i] = i / 2;
    m->linear = (rsv_linear_map){ .context = context,
        .table = &table,
        .data = m,
        .count = count,
        .group = m->group,
        .group_count = (count + 1) / 2 };
    return m;
}

#endif
