#include "window.h"

#include "denoise_constants.h"

#include <string.h>

/// A tile with what patches at its borders need.
#define WIDE (TILE_WIDTH + 2 * PATCH)
#define TALL (TILE_HEIGHT + 2 * PATCH)

/// Sums over the windows of a tile's pixels.
typedef struct tile_sums {
    float by_light[2][4][TILE_HEIGHT][TILE_WIDTH];    ///< of each half: three channels, and the weights
    float by_surfaces[7][TILE_HEIGHT][TILE_WIDTH]; ///< three channels of both halves, and the weights
} tile_sums;

typedef struct window_job {
    const rsv_plane_grid *grid;
    const rsv_surface_planes *surfaces;
    const rsv_light_planes *light;
    const rsv_filtered_planes *filtered;
    float least;
    size_t tiles_across;
} window_job;

/// Numbers of one tile and one offset.
typedef struct tile_weights {
    float surface[TILE_HEIGHT][TILE_WIDTH];
    float light[TILE_HEIGHT][TILE_WIDTH];
    float difference[TALL][WIDE];
} tile_weights;

/// About exp(-x), and 0 from 4 on.
static inline float likeness(float x)
{
    float root = f_max(1 - 0.25f * x, 0);
    root *= root;
    return root * root;
}

/// How alike the surfaces of pixels and of those at an offset are.
static void weigh_surfaces(const window_job *job, size_t first, int dx, int dy, tile_weights *w)
{
    const rsv_surface_planes *s = job->surfaces;
    ptrdiff_t offset = (ptrdiff_t)dy * (ptrdiff_t)job->grid->stride + dx;
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        size_t p = first + y * job->grid->stride;
        const float *nx = s->normal[0] + p, *ny = s->normal[1] + p, *nz = s->normal[2] + p;
        const float *variance = s->normal_variance + p, *place = s->place + p;
        const float *sx = s->slope[0] + p, *sy = s->slope[1] + p, *scale = s->place_scale + p;
        for (size_t x = 0; x < TILE_WIDTH; x++) {
            const ptrdiff_t q = (ptrdiff_t)x + offset;
            float a = nx[x] - nx[q], b = ny[x] - ny[q], c = nz[x] - nz[q];
            float lower = f_min(variance[x], variance[q]), both = variance[x] + variance[q];
            float turn = f_max(a * a + b * b + c * c - 2 * lower, 0) / (NORMAL_TOLERANCE + both);
            float off = place[q] - place[x] - (float)dx * sx[x] - (float)dy * sy[x];
            float inside = place[q] >= 0 ? 1.0f : 0.0f;
            w->surface[y][x] = inside * likeness(turn + off * off * scale[x]);
        }
    }
}

/// Squared differences of one half's light in excess of its noise.
static void compare_light(
    const window_job *job, int half, size_t first, ptrdiff_t offset, tile_weights *w)
{
    const rsv_light_planes *l = job->light;
    size_t corner = first - PATCH * job->grid->stride - PATCH;
    float least = job->least;
    for (size_t y = 0; y < TALL; y++) {
        size_t p = corner + y * job->grid->stride;
        const float *r = l->half[half][0] + p, *g = l->half[half][1] + p, *b = l->half[half][2] + p;
        const float *variance = l->variance + p;
        for (size_t x = 0; x < WIDE; x++) {
            const ptrdiff_t q = (ptrdiff_t)x + offset;
            float dr = r[x] - r[q], dg = g[x] - g[q], db = b[x] - b[q];
            float lower = f_min(variance[x], variance[q]), both = variance[x] + variance[q];
            float excess = dr * dr + dg * dg + db * db - 2 * lower;
            w->difference[y][x] = f_min(excess / (LIGHT_TOLERANCE * both + least), 1e6f);
        }
    }
}

/// Weights by the light of patches, at most those by surfaces.
static void weigh_light(tile_weights *w)
{
    const float share = 1.0f / ((2 * PATCH + 1) * (2 * PATCH + 1));
    float column[WIDE];
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        for (size_t x = 0; x < WIDE; x++) {
            float sum = w->difference[y][x];
            for (size_t k = 1; k <= 2 * PATCH; k++)
                sum += w->difference[y + k][x];
            column[x] = sum;
        }
        for (size_t x = 0; x < TILE_WIDTH; x++) {
            float sum = column[x];
            for (size_t k = 1; k <= 2 * PATCH; k++)
                sum += column[x + k];
            w->light[y][x] = f_min(likeness(f_max(share * sum, 0)), w->surface[y][x]);
        }
    }
}

/// Adds the pixels at an offset, times weights. @param sum [3 or 4] planes of a tile: channels, and the weights
static void add_weighted(const window_job *job, int half, size_t shifted,
    const float weight[TILE_HEIGHT][TILE_WIDTH], float (*sum)[TILE_HEIGHT][TILE_WIDTH])
{
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        size_t q = shifted + y * job->grid->stride;
        const float *r = job->light->half[half][0] + q, *g = job->light->half[half][1] + q,
                    *b = job->light->half[half][2] + q;
        for (size_t x = 0; x < TILE_WIDTH; x++) {
            float of = weight[y][x];
            sum[0][y][x] += of * r[x];
            sum[1][y][x] += of * g[x];
            sum[2][y][x] += of * b[x];
        }
    }
}

static void add_weights(const float weight[TILE_HEIGHT][TILE_WIDTH],
    float sum[TILE_HEIGHT][TILE_WIDTH])
{
    for (size_t y = 0; y < TILE_HEIGHT; y++)
        for (size_t x = 0; x < TILE_WIDTH; x++)
            sum[y][x] += weight[y][x];
}

static void add_offset(
    const window_job *job, size_t first, int dx, int dy, tile_weights *w, tile_sums *sums)
{
    ptrdiff_t offset = (ptrdiff_t)dy * (ptrdiff_t)job->grid->stride + dx;
    size_t shifted = first + (size_t)offset;
    weigh_surfaces(job, first, dx, dy, w);
    add_weights(w->surface, sums->by_surfaces[6]);
    for (int half = 0; half < 2; half++) {
        compare_light(job, half, first, offset, w);
        weigh_light(w);
        add_weighted(job, half, shifted, w->surface, sums->by_surfaces + (ptrdiff_t)3 * half);
        add_weighted(job, 1 - half, shifted, w->light, sums->by_light[1 - half]);
        add_weights(w->light, sums->by_light[1 - half][3]);
    }
}

static void store(const window_job *job, size_t first, const float sum[TILE_HEIGHT][TILE_WIDTH],
    const float weight[TILE_HEIGHT][TILE_WIDTH], float *plane)
{
    for (size_t y = 0; y < TILE_HEIGHT; y++)
        for (size_t x = 0; x < TILE_WIDTH; x++)
            plane[first + y * job->grid->stride + x] =
                weight[y][x] > 0 ? sum[y][x] / weight[y][x] : 0;
}

static void filter_tile(const window_job *job, size_t tile, tile_sums *sums, tile_weights *w)
{
    size_t first = rsv_plane_place(job->grid, tile % job->tiles_across * TILE_WIDTH,
        tile / job->tiles_across * TILE_HEIGHT);
    memset(sums, 0, sizeof *sums);
    for (int dy = -RADIUS; dy <= RADIUS; dy++)
        for (int dx = -RADIUS; dx <= RADIUS; dx++)
            add_offset(job, first, dx, dy, w, sums);
    for (int half = 0; half < 2; half++)
        for (int c = 0; c < 3; c++) {
            store(job, first, sums->by_light[half][c], sums->by_light[half][3],
                job->filtered->half[RSV_MEAN_BY_LIGHT][half][c]);
            store(job, first, sums->by_surfaces[3 * half + c], sums->by_surfaces[6],
                job->filtered->half[RSV_MEAN_BY_SURFACES][half][c]);
        }
}

static void filter_tiles(void *user, rsv_span span)
{
    const window_job *job = user;
    tile_sums sums;
    tile_weights weights;
    for (size_t tile = span.begin; tile < span.end; tile++)
        filter_tile(job, tile, &sums, &weights);
}

void rsv_filter_windows(const rsv_plane_grid *grid, const rsv_surface_planes *surfaces,
    const rsv_light_planes *light, float least, const rsv_filtered_planes *filtered)
{
    window_job job = { grid, surfaces, light, filtered, least, (grid->stride - 2 * MARGIN) / TILE_WIDTH };
    size_t tiles = job.tiles_across * ((grid->rows - 2 * MARGIN) / TILE_HEIGHT);
    rsv_parallel_for(grid->context, tiles, 1, filter_tiles, &job);
}
