#include "mixture.h"

#include "denoise_constants.h"

#define CHOICES (1 + RSV_MEAN_KINDS)
/// A filtered pixel counts as having at least this part of the error of the unfiltered one.
#define LEAST_ERROR 0.02f

typedef struct mixture_job {
    const rsv_plane_grid *grid;
    const rsv_light_planes *light;
    const rsv_filtered_planes *filtered;
    float *error[CHOICES]; ///< of the unfiltered pixel and of the means
    float *row_sum[CHOICES];
    float least;
    float **mixed;
} mixture_job;

static float square(float x) { return x * x; }

/// Squared errors of one channel: half a's noise is independent of half b, so that what (mean of a - b)^2 has in excess
/// of b's variance is an error of the mean. @param error added to
static void add_errors(const mixture_job *job, int channel, size_t p, float error[CHOICES])
{
    float a = job->light->half[0][channel][p], b = job->light->half[1][channel][p];
    error[0] += 0.25f * square(a - b);
    for (int kind = 0; kind < RSV_MEAN_KINDS; kind++) {
        float of_a = job->filtered->half[kind][0][channel][p];
        float of_b = job->filtered->half[kind][1][channel][p];
        error[1 + kind] += 0.5f * (square(of_a - b) + square(of_b - a) - square(a - b)) -
                           0.25f * square(of_a - of_b);
    }
}

/// Sum over channels and halves of unfiltered and filtered light.
static float light_at(const mixture_job *job, size_t p)
{
    float sum = 0;
    for (int half = 0; half < 2; half++)
        for (int c = 0; c < 3; c++)
            sum += job->light->half[half][c][p] +
                   job->filtered->half[RSV_MEAN_BY_SURFACES][half][c][p];
    return 0.25f * sum;
}

static void find_errors(const void *user, size_t y)
{
    const mixture_job *job = user;
    for (size_t x = 0; x < job->grid->width; x++) {
        size_t p = rsv_plane_place(job->grid, x, y);
        float error[CHOICES] = { 0 }, scale = 1 / (square(light_at(job, p)) + job->least);
        for (int c = 0; c < 3; c++)
            add_errors(job, c, p, error);
        for (int k = 0; k < CHOICES; k++)
            job->error[k][p] = scale * error[k];
    }
}

static void sum_across(const void *user, size_t y)
{
    const mixture_job *job = user;
    for (int k = 0; k < CHOICES; k++)
        for (size_t x = 0; x < job->grid->width; x++) {
            size_t p = rsv_plane_place(job->grid, x, y);
            const float *error = job->error[k] + p;
            float sum = 0;
            for (int i = -ERROR_RADIUS; i <= ERROR_RADIUS; i++)
                sum += error[i];
            job->row_sum[k][p] = sum;
        }
}

/// Sums of errors around a pixel, which stand for their means.
static void errors_around(const mixture_job *job, size_t p, float error[CHOICES])
{
    ptrdiff_t stride = (ptrdiff_t)job->grid->stride;
    for (int k = 0; k < CHOICES; k++) {
        const float *sum = job->row_sum[k] + p;
        error[k] = 0;
        for (int i = -ERROR_RADIUS; i <= ERROR_RADIUS; i++)
            error[k] += sum[i * stride];
    }
}

static void mix_row(const void *user, size_t y)
{
    const mixture_job *job = user;
    for (size_t x = 0; x < job->grid->width; x++) {
        size_t p = rsv_plane_place(job->grid, x, y);
        float error[CHOICES], share[CHOICES] = { 1 }, all = 1;
        errors_around(job, p, error);
        for (int k = 1; k < CHOICES; k++) {
            share[k] = error[0] > 0 ? square(error[0] / f_max(error[k], LEAST_ERROR * error[0])) : 0;
            all += share[k];
        }
        for (int c = 0; c < 3; c++) {
            float sum = job->light->half[0][c][p] + job->light->half[1][c][p];
            for (int k = 1; k < CHOICES; k++)
                sum += share[k] * (job->filtered->half[k - 1][0][c][p] +
                                      job->filtered->half[k - 1][1][c][p]);
            job->mixed[c][p] = 0.5f * sum / all;
        }
    }
}

void rsv_mix_by_errors(const rsv_plane_grid *grid, const rsv_light_planes *light,
    const rsv_filtered_planes *filtered, float least, float *planes, float *mixed[3])
{
    mixture_job job = { .grid = grid, .light = light, .filtered = filtered, .least = least, .mixed = mixed };
    for (size_t k = 0; k < CHOICES; k++) {
        job.error[k] = planes + k * rsv_plane_size(grid);
        job.row_sum[k] = planes + (CHOICES + k) * rsv_plane_size(grid);
    }
    rsv_for_plane_rows(grid, grid->height, find_errors, &job);
    rsv_for_plane_rows(grid, grid->height, sum_across, &job);
    rsv_for_plane_rows(grid, grid->height, mix_row, &job);
}
