#include "surfaces.h"

#include "denoise_constants.h"

#define OUTSIDE (-1e10f) ///< place in margins: like no surface

typedef struct surface_job {
    const rsv_plane_grid *grid;
    const rsv_denoise_half *half;
    const rsv_surface_planes *surfaces;
} surface_job;

static bool is_inside(const rsv_plane_grid *grid, size_t column, size_t row)
{
    return column >= MARGIN && column - MARGIN < grid->width && row >= MARGIN &&
           row - MARGIN < grid->height;
}

static void read_row(const void *user, size_t row)
{
    const surface_job *job = user;
    const rsv_surface_planes *s = job->surfaces;
    for (size_t column = 0; column < job->grid->stride; column++) {
        size_t p = row * job->grid->stride + column;
        size_t from = rsv_plane_source(job->grid, column, row);
        rsv_rgb a = job->half[0].normal[from], b = job->half[1].normal[from];
        rsv_rgb apart = rgb_sub(a, b);
        s->normal[0][p] = 0.5f * (a.r + b.r);
        s->normal[1][p] = 0.5f * (a.g + b.g);
        s->normal[2][p] = 0.5f * (a.b + b.b);
        s->normal_variance[p] = 0.25f * (apart.r * apart.r + apart.g * apart.g + apart.b * apart.b);
        s->place[p] = is_inside(job->grid, column, row)
                          ? 0.5f * (job->half[0].place[from].r + job->half[1].place[from].r)
                          : OUTSIDE;
    }
}

/// Mean over three pixels across the direction of a step.
static float mean_step(const float *place, ptrdiff_t step, ptrdiff_t across)
{
    float sum = 0;
    for (ptrdiff_t k = -1; k <= 1; k++)
        sum += place[k * across + step] - place[k * across];
    return sum / 3;
}

/// The lesser of the slopes to both sides: edges and margins are none.
static float slope_of(const float *place, ptrdiff_t step, ptrdiff_t across)
{
    float after = mean_step(place, step, across), before = -mean_step(place, -step, across);
    float lesser = fabsf(after) < fabsf(before) ? after : before;
    return fabsf(lesser) < *place ? lesser : 0;
}

static void find_slopes(const void *user, size_t y)
{
    const surface_job *job = user;
    const rsv_surface_planes *s = job->surfaces;
    ptrdiff_t stride = (ptrdiff_t)job->grid->stride;
    for (size_t x = 0; x < job->grid->width; x++) {
        size_t p = rsv_plane_place(job->grid, x, y);
        float sx = slope_of(s->place + p, 1, stride), sy = slope_of(s->place + p, stride, 1);
        float deviation = PLACE_TOLERANCE * s->place[p];
        s->slope[0][p] = sx;
        s->slope[1][p] = sy;
        s->place_scale[p] = 1 / f_max(deviation * deviation + 2 * (sx * sx + sy * sy), 1e-30f);
    }
}

void rsv_find_surfaces(const rsv_plane_grid *grid, const rsv_denoise_half half[2], float *planes,
    rsv_surface_planes *surfaces)
{
    size_t size = rsv_plane_size(grid);
    surface_job job = { grid, half, surfaces };
    *surfaces =
        (rsv_surface_planes){ { planes, planes + size, planes + 2 * size }, planes + 3 * size,
            planes + 4 * size, { planes + 5 * size, planes + 6 * size }, planes + 7 * size };
    rsv_for_plane_rows(grid, grid->rows, read_row, &job);
    rsv_for_plane_rows(grid, grid->height, find_slopes, &job);
}
