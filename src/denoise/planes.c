#include "planes.h"

static size_t whole(size_t count, size_t of) { return (count + of - 1) / of * of; }

rsv_plane_grid rsv_plane_grid_of(rsv_context *context, uint32_t width, uint32_t height)
{
    return (rsv_plane_grid){ context, width, height, whole(width, TILE_WIDTH) + (size_t)2 * MARGIN,
        whole(height, TILE_HEIGHT) + (size_t)2 * MARGIN };
}

float *rsv_planes_create(const rsv_plane_grid *grid, size_t count)
{
    return rsv_alloc(grid->context, count, rsv_plane_size(grid) * sizeof(float));
}

typedef struct row_job {
    void (*body)(const void *job, size_t y);
    const void *job;
} row_job;

static void run_rows(void *user, rsv_span span)
{
    const row_job *rows = user;
    for (size_t y = span.begin; y < span.end; y++)
        rows->body(rows->job, y);
}

void rsv_for_plane_rows(const rsv_plane_grid *grid, size_t rows,
    void (*body)(const void *job, size_t y), const void *job)
{
    row_job wrapped = { body, job };
    rsv_parallel_for(grid->context, rows, 8, run_rows, &wrapped);
}
