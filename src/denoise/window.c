#include "window.h"

#include "denoise_constants.h"

#include <string.h>

/// A tile with what patches at its borders need.
#define WIDE (TILE_WIDTH + 2 * PATCH)
#define TALL (TILE_HEIGHT + 2 * PATCH)

/// A number for each pixel of a tile.
typedef float tile[TILE_HEIGHT][TILE_WIDTH];

/// Sums over the windows of a tile's pixels.
typedef struct tile_sums {
    tile half[2][3], weight[2];
} tile_sums;

typedef struct window_job {
    const rsv_plane_grid *grid;
    const rsv_surface_planes *surfaces;
    const rsv_light_planes *light; ///< [count]
    int count;
    size_t tiles_across;
} window_job;

/// A tile at work, and one offset within its windows.
typedef struct tile_work {
    const window_job *job;
    size_t first; ///< place of its first pixel
    int dx, dy;
    ptrdiff_t offset;
    bool is_noisy[RSV_KINDS_OF_LIGHT];
    tile_sums sums[RSV_KINDS_OF_LIGHT];
    tile by_surface, by_light;
    float difference[TALL][WIDE];
} tile_work;

/// About exp(-x), and 0 from 4 on.
static inline float likeness(float x)
{
    float root = f_max(1 - 0.25f * x, 0);
    root *= root;
    return root * root;
}

/// How alike the surfaces of pixels and of those at the offset are.
static void compare_surfaces(tile_work *w)
{
    const rsv_surface_planes *s = w->job->surfaces;
    float dx = (float)w->dx, dy = (float)w->dy;
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        size_t p = w->first + y * w->job->grid->stride;
        const float *nx = s->normal[0] + p, *ny = s->normal[1] + p, *nz = s->normal[2] + p;
        const float *variance = s->normal_variance + p, *place = s->place + p;
        const float *sx = s->slope[0] + p, *sy = s->slope[1] + p, *scale = s->place_scale + p;
        for (size_t x = 0; x < TILE_WIDTH; x++) {
            const ptrdiff_t q = (ptrdiff_t)x + w->offset;
            float a = nx[x] - nx[q], b = ny[x] - ny[q], c = nz[x] - nz[q];
            float lower = f_min(variance[x], variance[q]), both = variance[x] + variance[q];
            float turn = (a * a + b * b + c * c - 2 * lower) / (NORMAL_TOLERANCE + both);
            float off = place[q] - place[x] - dx * sx[x] - dy * sy[x];
            w->by_surface[y][x] = likeness(f_max(turn + off * off * scale[x], 0));
        }
    }
}

/// Squared differences of one half's light in excess of its noise.
static void compare_light(tile_work *w, const rsv_light_planes *light, int half)
{
    size_t corner = w->first - PATCH * w->job->grid->stride - PATCH;
    const float least = light->least;
    for (size_t y = 0; y < TALL; y++) {
        size_t p = corner + y * w->job->grid->stride;
        const float *r = light->half[half][0] + p, *g = light->half[half][1] + p;
        const float *b = light->half[half][2] + p, *variance = light->variance + p;
        for (size_t x = 0; x < WIDE; x++) {
            const ptrdiff_t q = (ptrdiff_t)x + w->offset;
            float dr = r[x] - r[q], dg = g[x] - g[q], db = b[x] - b[q];
            float lower = f_min(variance[x], variance[q]), both = variance[x] + variance[q];
            float excess = dr * dr + dg * dg + db * db - 2 * lower;
            w->difference[y][x] = f_min(excess / (LIGHT_TOLERANCE * both + least), 1e6f);
        }
    }
}

/// Weights by patches of light, at most those by surfaces.
static void weigh(tile_work *w)
{
    const float share = 1.0f / ((2 * PATCH + 1) * (2 * PATCH + 1));
    float column[WIDE], sum[TILE_WIDTH]; // loops one after the other become vectors
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        memcpy(column, w->difference[y], sizeof column);
        for (size_t k = 1; k <= 2 * PATCH; k++)
            for (size_t x = 0; x < WIDE; x++)
                column[x] += w->difference[y + k][x];
        memcpy(sum, column, sizeof sum);
        for (size_t k = 1; k <= 2 * PATCH; k++)
            for (size_t x = 0; x < TILE_WIDTH; x++)
                sum[x] += column[x + k];
        for (size_t x = 0; x < TILE_WIDTH; x++)
            w->by_light[y][x] = f_min(likeness(f_max(share * sum[x], 0)), w->by_surface[y][x]);
    }
}

/// Adds one half's light at the offset, by the weights of the other half.
static void add_weighted(tile_work *w, const rsv_light_planes *light, int half, tile_sums *sums)
{
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        size_t q = w->first + (size_t)w->offset + y * w->job->grid->stride;
        const float *r = light->half[half][0] + q, *g = light->half[half][1] + q;
        const float *b = light->half[half][2] + q;
        for (size_t x = 0; x < TILE_WIDTH; x++) {
            float weight = w->by_light[y][x];
            sums->half[half][0][y][x] += weight * r[x];
            sums->half[half][1][y][x] += weight * g[x];
            sums->half[half][2][y][x] += weight * b[x];
            sums->weight[half][y][x] += weight;
        }
    }
}

static void add_offset(tile_work *w, int dx, int dy)
{
    w->dx = dx;
    w->dy = dy;
    w->offset = (ptrdiff_t)dy * (ptrdiff_t)w->job->grid->stride + dx;
    compare_surfaces(w);
    for (int kind = 0; kind < w->job->count; kind++) {
        const rsv_light_planes *light = &w->job->light[kind];
        for (int half = 0; half < 2 && w->is_noisy[kind]; half++) {
            compare_light(w, light, half);
            weigh(w);
            add_weighted(w, light, 1 - half, &w->sums[kind]);
        }
    }
}

static float mean_of(const tile_sums *sums, int half, int channel, size_t x, size_t y)
{
    return sums->half[half][channel][y][x] / sums->weight[half][y][x];
}

static void store(const tile_work *w, const rsv_light_planes *light, const tile_sums *sums)
{
    for (size_t y = 0; y < TILE_HEIGHT; y++) {
        size_t p = w->first + y * w->job->grid->stride;
        for (size_t x = 0; x < TILE_WIDTH; x++) {
            bool filtered = light->variance[p + x] > 0 && sums->weight[0][y][x] > 0 &&
                            sums->weight[1][y][x] > 0;
            for (int half = 0; half < 2; half++)
                for (int c = 0; c < 3; c++)
                    light->filtered[half][c][p + x] =
                        filtered ? mean_of(sums, half, c, x, y) : light->half[half][c][p + x];
        }
    }
}

static bool is_noisy(const tile_work *w, const rsv_light_planes *light)
{
    float most = 0;
    for (size_t y = 0; y < TILE_HEIGHT; y++)
        for (size_t x = 0; x < TILE_WIDTH; x++)
            most = f_max(most, light->variance[w->first + y * w->job->grid->stride + x]);
    return most > 0;
}

static void filter_tile(tile_work *w)
{
    memset(w->sums, 0, sizeof w->sums);
    bool any = false;
    for (int kind = 0; kind < w->job->count; kind++)
        any |= w->is_noisy[kind] = is_noisy(w, &w->job->light[kind]);
    for (int dy = -RADIUS; dy <= RADIUS && any; dy++)
        for (int dx = -RADIUS; dx <= RADIUS; dx++)
            add_offset(w, dx, dy);
    for (int kind = 0; kind < w->job->count; kind++)
        store(w, &w->job->light[kind], &w->sums[kind]);
}

static void filter_tiles(void *user, rsv_span span)
{
    const window_job *job = user;
    tile_work work = { .job = job };
    for (size_t index = span.begin; index < span.end; index++) {
        work.first = rsv_plane_place(job->grid, index % job->tiles_across * TILE_WIDTH,
            index / job->tiles_across * TILE_HEIGHT);
        filter_tile(&work);
    }
}

void rsv_filter_windows(const rsv_plane_grid *grid, const rsv_surface_planes *surfaces,
    const rsv_light_planes *light, int count)
{
    window_job job = { grid, surfaces, light, count, (grid->stride - 2 * MARGIN) / TILE_WIDTH };
    RSV_ASSERT(count <= RSV_KINDS_OF_LIGHT);
    size_t tiles = job.tiles_across * ((grid->rows - 2 * MARGIN) / TILE_HEIGHT);
    rsv_parallel_for(grid->context, tiles, 1, filter_tiles, &job);
}
