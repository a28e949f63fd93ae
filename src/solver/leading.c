#include "leading.h"

#include <math.h>

/// Number of basis vectors: little memory compared with the entries of a map.
#define BASIS 8
/// Number of squarings of a small matrix, after which only its leading eigenvector is left.
#define SQUARINGS 40
/// Smallest remainder of a vector after orthogonalisation that is more than rounding.
#define ROUNDING 1e-6

/// One channel of the iteration: A V = V H + the part outside the subspace.
typedef struct channel {
    double h[BASIS + 1][BASIS];
    double value, residual;
    double ritz[BASIS]; ///< leading eigenvector of H
    bool dead;          ///< the map has nothing in this channel
} channel;

typedef struct iteration {
    const rsv_linear_map *map;
    const float *weight;     ///< [count x 3]; NULL = 1
    float *basis[BASIS + 1]; ///< [count x 3]
    channel channel[3];
} iteration;

/// <a, b>, all channels in one pass.
static void product(const iteration *q, const float *a, const float *b, double sum[3])
{
    const float one[3] = { 1, 1, 1 };
    double x = 0, y = 0, z = 0;
    for (size_t i = 0; i < 3 * q->map->count; i += 3) {
        const float *w = q->weight ? q->weight + i : one;
        x += (double)w[0] * a[i] * b[i];
        y += (double)w[1] * a[i + 1] * b[i + 1];
        z += (double)w[2] * a[i + 2] * b[i + 2];
    }
    sum[0] = x, sum[1] = y, sum[2] = z;
}

static void scale(float *a, size_t count, const double factor[3])
{
    for (size_t i = 0; i < 3 * count; i += 3)
        for (size_t c = 0; c < 3; c++)
            a[i + c] = (float)(a[i + c] * factor[c]);
}

static void subtract(float *a, const float *b, size_t count, const double factor[3])
{
    for (size_t i = 0; i < 3 * count; i += 3)
        for (size_t c = 0; c < 3; c++)
            a[i + c] -= (float)(factor[c] * b[i + c]);
}

/// Takes the earlier vectors out of the last one and gives it the length 1.
static void orthogonalise(iteration *q, uint32_t step)
{
    size_t count = q->map->count;
    float *next = q->basis[step + 1];
    double before[3], left[3], h[3];
    product(q, next, next, before);
    for (uint32_t k = 0; k <= step; k++) {
        product(q, next, q->basis[k], h);
        subtract(next, q->basis[k], count, h);
        for (size_t c = 0; c < 3; c++)
            q->channel[c].h[k][step] = h[c];
    }
    product(q, next, next, left);
    for (size_t c = 0; c < 3; c++) {
        left[c] = sqrt(left[c]);
        if (left[c] <= ROUNDING * sqrt(before[c])) left[c] = 0;
        q->channel[c].h[step + 1][step] = left[c];
        left[c] = left[c] > 0 ? 1 / left[c] : 0;
    }
    scale(next, count, left);
}

static void square(double a[BASIS][BASIS], uint32_t size)
{
    double b[BASIS][BASIS] = { { 0 } }, most = 0;
    for (uint32_t i = 0; i < size; i++)
        for (uint32_t j = 0; j < size; j++) {
            for (uint32_t k = 0; k < size; k++)
                b[i][j] += a[i][k] * a[k][j];
            most = fmax(most, fabs(b[i][j]));
        }
    for (uint32_t i = 0; i < size; i++)
        for (uint32_t j = 0; j < size; j++)
            a[i][j] = most > 0 ? b[i][j] / most : 0;
}

/// Leading eigenvalue and vector of H, shifted so that -value, which scenes of two facing walls have too, does not
/// count.
static void find_ritz(channel *s, uint32_t size)
{
    double a[BASIS][BASIS], shift = 0, length = 0, image = 0;
    uint32_t column = 0;
    for (uint32_t i = 0; i < size; i++)
        for (uint32_t j = 0; j < size; j++)
            shift = fmax(shift, fabs(s->h[i][j]));
    for (uint32_t i = 0; i < size; i++)
        for (uint32_t j = 0; j < size; j++)
            a[i][j] = s->h[i][j] + (i == j ? shift : 0);
    for (int k = 0; k < SQUARINGS && shift > 0; k++)
        square(a, size);
    for (uint32_t j = 0; j < size; j++) {
        double sum = 0;
        for (uint32_t i = 0; i < size; i++)
            sum += a[i][j] * a[i][j];
        if (sum > length) length = sum, column = j;
    }
    for (uint32_t i = 0; i < size; i++)
        s->ritz[i] = length > 0 ? a[i][column] / sqrt(length) : i == 0;
    for (uint32_t i = 0; i < size; i++)
        for (uint32_t j = 0; j < size; j++)
            image += s->ritz[i] * s->h[i][j] * s->ritz[j];
    s->value = image;
    s->residual = s->h[size][size - 1] * fabs(s->ritz[size - 1]);
}

/// The leading Ritz vector becomes the first of the next basis.
static void restart(iteration *q)
{
    for (size_t i = 0; i < 3 * q->map->count; i++) {
        const channel *s = &q->channel[i % 3];
        double sum = 0;
        for (uint32_t k = 0; k < BASIS; k++)
            sum += s->ritz[k] * (double)q->basis[k][i];
        q->basis[0][i] = (float)sum;
    }
}

static void set_length(iteration *q)
{
    size_t count = q->map->count;
    double length[3];
    product(q, q->basis[0], q->basis[0], length);
    for (size_t c = 0; c < 3; c++) {
        length[c] = sqrt(length[c]);
        q->channel[c].dead = length[c] == 0;
        length[c] = length[c] > 0 ? 1 / length[c] : 0;
    }
    scale(q->basis[0], count, length);
}

/// One step in all channels. @return whether the leading value is known
static bool extend(iteration *q, uint32_t step, double tolerance)
{
    bool known = true;
    q->map->table->apply(q->map->data, 3, q->basis[step], q->basis[step + 1]);
    orthogonalise(q, step);
    for (size_t c = 0; c < 3; c++) {
        channel *s = &q->channel[c];
        if (s->dead) continue;
        find_ritz(s, step + 1);
        known = known && s->residual <= tolerance * fabs(s->value);
    }
    return known;
}

static rsv_status iterate(
    iteration *q, double tolerance, uint32_t max_steps, rsv_leading_value *leading)
{
    rsv_status status = RSV_OK;
    bool known = false;
    for (uint32_t step = 0; !known && status == RSV_OK; step = (step + 1) % BASIS) {
        if (step == 0 && leading->applications > 0) restart(q);
        if (step == 0) set_length(q);
        known = extend(q, step, tolerance) || ++leading->applications >= max_steps;
        status = rsv_progress(
            q->map->context, "spectrum", (double)leading->applications / (double)max_steps);
    }
    return status;
}

rsv_status rsv_leading_eigenvalue(const rsv_linear_map *map, const float *weight, double tolerance,
    uint32_t max_steps, rsv_leading_value *leading)
{
    iteration q = { .map = map, .weight = weight };
    rsv_status status = RSV_ERROR_MEMORY;
    *leading = (rsv_leading_value){ 0 };
    for (uint32_t k = 0; k <= BASIS; k++) {
        q.basis[k] = rsv_alloc(map->context, 3 * map->count, sizeof *q.basis[k]);
        if (!q.basis[k]) goto cleanup;
    }
    for (size_t i = 0; i < 3 * map->count; i++)
        q.basis[0][i] = 1;
    RSV_TRY(iterate(&q, tolerance, max_steps, leading));
    for (size_t c = 0; c < 3; c++) {
        const channel *s = &q.channel[c];
        if (s->dead || s->value < leading->value) continue;
        leading->value = s->value;
        leading->residual = s->residual;
    }
cleanup:
    for (uint32_t k = 0; k <= BASIS; k++)
        rsv_free(map->context, q.basis[k]);
    return status;
}
