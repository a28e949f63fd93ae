/// Rows of a tile and their history (history.h), included by packet_kernels_body.h.
#include "history.h"

/// A tile's row and one pixel more on each side, channel after channel of each pixel.
#define WIDE (RSV_TILE + 2)

/// Least and greatest radiance among a pixel and its neighbours. @param rows three of the window
static inline void find_range(
    const float (*restrict rows)[WIDE][4], float (*restrict low)[4], float (*restrict high)[4])
{
    float least[WIDE * 4], greatest[WIDE * 4];
    const float *above = rows[0][0], *here = rows[1][0], *below = rows[2][0];
    float *lowest = low[0], *highest = high[0];
    for (int k = 0; k < WIDE * 4; k++) {
        least[k] = f_min(f_min(above[k], here[k]), below[k]);
        greatest[k] = f_max(f_max(above[k], here[k]), below[k]);
    }
    for (int k = 0; k < RSV_TILE * 4; k++) {
        lowest[k] = f_min(f_min(least[k], least[k + 4]), least[k + 8]);
        highest[k] = f_max(f_max(greatest[k], greatest[k + 4]), greatest[k + 8]);
    }
}

/// If radiance varies less than this from pixel to pixel, relative to the maximum, there are no edges to smooth.
#define EVEN_RANGE 0.02f

/// Pixels around which radiance varies, a bit each. The others show their own sample.
static inline uint32_t find_uneven(const float (*restrict low)[4], const float (*restrict high)[4])
{
    _Alignas(64) int uneven[LANES];
    for (int k = 0; k < LANES; k++) {
        const float *l = low[k], *h = high[k];
        float range = f_max(f_max(h[0] - l[0], h[1] - l[1]), h[2] - l[2]);
        uneven[k] = range > EVEN_RANGE * f_max(f_max(h[0], h[1]), h[2]) ? 1 : 0;
    }
    return lanes_set(uneven);
}

/// Depth of the nearest surface among a pixel and its neighbours: edges move with the surface in front.
/// @param rows three of the window, starting at the pixel to the left of the first one
static inline void find_nearest(const float (*restrict rows)[WIDE], float *restrict depth)
{
    float least[LANES + 2];
    for (int k = 0; k < LANES + 2; k++)
        least[k] = f_min(f_min(rows[0][k], rows[1][k]), rows[2][k]);
    for (int k = 0; k < LANES; k++)
        depth[k] = f_min(f_min(least[k], least[k + 1]), least[k + 2]);
}

/// Where sixteen pixels were in the frame before.
typedef struct earlier_lanes {
    float x[LANES], y[LANES]; ///< middle of a pixel at whole numbers
    float distance[LANES];    ///< from the camera then
} __attribute__((aligned(64))) earlier_lanes;

/// Points at these depths along the rays of sixteen pixels.
typedef struct seen_lanes {
    float x[LANES], y[LANES], z[LANES];
} __attribute__((aligned(64))) seen_lanes;

static inline void find_seen(const rsv_frame_history *h, uint32_t column, uint32_t row,
    const float *restrict depth, seen_lanes *restrict point)
{
    const rsv_lens *lens = &h->lens;
    const rsv_camera *c = &lens->camera;
    bool orthographic = c->vertical_fov == 0;
    float upwards = (lens->half_height - ((float)row + h->place_y)) * lens->pixel_size;
    for (int k = 0; k < LANES; k++) {
        float across =
            ((float)((int)column + k) + h->place_x - lens->half_width) * lens->pixel_size;
        float x = c->right.x * across + upwards * c->up.x;
        float y = c->right.y * across + upwards * c->up.y;
        float z = c->right.z * across + upwards * c->up.z;
        float dx = c->forward.x + x, dy = c->forward.y + y, dz = c->forward.z + z;
        float scale = depth[k] / sqrtf(dx * dx + dy * dy + dz * dz);
        point->x[k] = c->position.x + (orthographic ? x + depth[k] * c->forward.x : dx * scale);
        point->y[k] = c->position.y + (orthographic ? y + depth[k] * c->forward.y : dy * scale);
        point->z[k] = c->position.z + (orthographic ? z + depth[k] * c->forward.z : dz * scale);
    }
}

static inline void find_earlier(const rsv_frame_history *h, uint32_t column, uint32_t row,
    const float *restrict depth, earlier_lanes *restrict to)
{
    seen_lanes point;
    const rsv_lens *lens = &h->lens_before;
    float half_width = lens->half_width, half_height = lens->half_height;
    float pixel_size = lens->pixel_size, place_x = h->place_x, place_y = h->place_y;
    const rsv_camera *c = &lens->camera;
    const float flat = c->vertical_fov == 0 ? 1 : 0; // orthographic
    find_seen(h, column, row, depth, &point);
    for (int k = 0; k < LANES; k++) {
        float x = point.x[k] - c->position.x, y = point.y[k] - c->position.y,
              z = point.z[k] - c->position.z;
        float ahead = x * c->forward.x + y * c->forward.y + z * c->forward.z;
        float right = x * c->right.x + y * c->right.y + z * c->right.z;
        float up = x * c->up.x + y * c->up.y + z * c->up.z;
        float away = sqrtf(x * x + y * y + z * z);
        float scale = flat > 0 ? 1 : 1 / f_max(ahead, 1e-30f);
        float i = half_width + right * (scale / pixel_size) - place_x;
        float j = half_height - up * (scale / pixel_size) - place_y;
        i = f_min(f_max(i, -4), 1e5f), j = f_min(f_max(j, -4), 1e5f);
        bool seen = f_max(ahead, flat) > 0;
        to->x[k] = seen ? i : -4;
        to->y[k] = seen ? j : -4;
        to->distance[k] = flat > 0 ? ahead : away;
    }
}

/// Lookups of sixteen pixels in the previous frame.
typedef struct history_lanes {
    int left[LANES], top[LANES];            ///< pixel up and left of each place
    float across[4][LANES], down[4][LANES]; ///< weights of four columns and rows around it
    float shown[LANES][4];                  ///< radiance, and the number of frames
    float frames[LANES];                    ///< that it is the mean of
} __attribute__((aligned(64))) history_lanes;

/// Weights of four neighbours in a row, by a cubic that passes through them (Catmull and Rom 1974).
/// @param t [LANES] of the way from the second one to the third
static inline void cubic_weights(const float *restrict t, float (*restrict weight)[LANES])
{
    for (int k = 0; k < LANES; k++) {
        float x = t[k];
        weight[0][k] = x * (-0.5f + x * (1 - 0.5f * x));
        weight[1][k] = 1 + x * x * (-2.5f + 1.5f * x);
        weight[2][k] = x * (0.5f + x * (2 - 1.5f * x));
        weight[3][k] = x * x * (-0.5f + 0.5f * x);
    }
}

static inline void find_taps(const earlier_lanes *restrict from, history_lanes *restrict to)
{
    _Alignas(64) float x[LANES], y[LANES];
    for (int k = 0; k < LANES; k++) {
        to->left[k] = floor_of(from->x[k]);
        to->top[k] = floor_of(from->y[k]);
        x[k] = from->x[k] - (float)to->left[k];
        y[k] = from->y[k] - (float)to->top[k];
    }
    cubic_weights(x, to->across);
    cubic_weights(y, to->down);
}

static inline int into(int x, int count)
{
    int low = x < 0 ? 0 : x;
    return low < count ? low : count - 1;
}

/// Four pixels of each of four lines, the lines weighed.
/// @param line first pixel of each @param weight of the lines @param sum [16] out
static inline void add_lines(const float *const line[4], const float weight[4], float *restrict sum)
{
    const float *a = line[0], *b = line[1], *c = line[2], *d = line[3];
    for (int k = 0; k < 16; k++)
        sum[k] = weight[0] * a[k] + weight[1] * b[k] + weight[2] * c[k] + weight[3] * d[k];
}

/// The history at the position of a lane.
static inline void look_back(const rsv_frame_history *h, history_lanes *restrict at, int lane)
{
    _Alignas(64) float edge[4][16], sum[16];
    const float *line[4];
    int width = (int)h->width, first = at->left[lane] - 1, top = at->top[lane] - 1;
    bool inside = first >= 0 && first + 3 < width;
    for (int j = 0; j < 4; j++) {
        uint32_t row = (uint32_t)into(top + j, (int)h->height);
        const float(*pixel)[4] = h->shown_before + rsv_history_place(h, 0, row);
        line[j] = inside ? pixel[first] : edge[j];
        for (int i = 0; i < 4 && !inside; i++)
            memcpy(edge[j] + 4 * i, pixel[into(first + i, width)], sizeof *pixel);
    }
    const float weight[4] = { at->down[0][lane], at->down[1][lane], at->down[2][lane],
        at->down[3][lane] };
    add_lines(line, weight, sum);
    for (int c = 0; c < 4; c++)
        at->shown[lane][c] = at->across[0][lane] * sum[c] + at->across[1][lane] * sum[4 + c] +
                             at->across[2][lane] * sum[8 + c] + at->across[3][lane] * sum[12 + c];
    at->frames[lane] = at->shown[lane][3];
}

/// Depths that differ less belong to one surface.
#define SAME_DEPTH 0.1f

/// Lanes near whose places the picture showed something at about their distance, lane by lane.
/// @param right, below 0 or 1 pixel from the one up and left
static inline void find_alike(const rsv_frame_history *h, const history_lanes *restrict at,
    const earlier_lanes *restrict from, const int *restrict right, const int *restrict below,
    int *restrict shown)
{
    _Alignas(64) int index[LANES];
    _Alignas(64) float then[LANES];
    int width = (int)h->width, height = (int)h->height, stride = (int)h->stride;
    for (int k = 0; k < LANES; k++)
        index[k] =
            into(at->top[k] + below[k], height) * stride + into(at->left[k] + right[k], width);
    gather(h->depth_before, index, then);
    for (int k = 0; k < LANES; k++) {
        float distance = from->distance[k];
        shown[k] |= fabsf(then[k] - distance) < SAME_DEPTH * distance ? 1 : 0;
    }
}

/// The same for the pixel at a position, and then for the others around it, one bit each.
/// @param asked the lanes to process
static inline uint32_t find_shown(const rsv_frame_history *h, uint32_t asked,
    const history_lanes *restrict at, const earlier_lanes *restrict from)
{
    _Alignas(64) int shown[LANES], right[LANES], below[LANES];
    float last_x = (float)h->width - 0.5f, last_y = (float)h->height - 0.5f;
    for (int k = 0; k < LANES; k++) {
        shown[k] = 0;
        right[k] = from->x[k] - (float)at->left[k] > 0.5f ? 1 : 0;
        below[k] = from->y[k] - (float)at->top[k] > 0.5f ? 1 : 0;
    }
    find_alike(h, at, from, right, below, shown);
    for (int tap = 1; tap < 4 && (asked & ~lanes_set(shown)); tap++) {
        for (int k = 0; k < LANES; k++) {
            right[k] ^= tap & 1;
            below[k] ^= tap == 2 ? 1 : 0;
        }
        find_alike(h, at, from, right, below, shown);
    }
    for (int k = 0; k < LANES; k++) {
        float x = from->x[k], y = from->y[k];
        bool inside = (x > -0.5f) & (y > -0.5f) & (x < last_x) & (y < last_y);
        shown[k] = inside ? shown[k] : 0;
    }
    return lanes_set(shown) & asked;
}

/// The value at the centre of a pixel, interpolated from this frame's samples around it. @param middle of the window
static inline void interpolate(
    const rsv_frame_history *h, const float (*restrict middle)[4], float *restrict out)
{
    float x = 0.5f - h->place_x, y = 0.5f - h->place_y;
    const float(*beside)[4] = middle + (x < 0 ? -1 : 1);
    int line = y < 0 ? -WIDE : WIDE;
    x = fabsf(x), y = fabsf(y);
    for (int c = 0; c < 3; c++) {
        float here = middle[0][c] + x * (beside[0][c] - middle[0][c]);
        float there = middle[line][c] + x * (beside[line][c] - middle[line][c]);
        out[c] = here + y * (there - here);
    }
    out[3] = 1;
}

/// Adds the samples of lanes to the mean of the history.
/// @param low, high radiance around them @param radiance in and out; unchanged in other lanes
static inline void add_samples(const rsv_frame_history *h, uint32_t lanes,
    const history_lanes *restrict at, const float *restrict low, const float *restrict high,
    float *restrict radiance)
{
    _Alignas(64) float share[4 * LANES];
    const float *old = at->shown[0], keep = h->keep;
    for (int k = 0; k < LANES; k++) {
        float count = keep * f_min(f_max(at->frames[k], 1), RSV_HISTORY_FRAMES - 1) + 1;
        share[4 * k] = share[4 * k + 1] = share[4 * k + 2] = 1 / count;
        share[4 * k + 3] = count;
    }
    for (int k = 0; k < 4 * LANES; k++) {
        float kept = f_min(f_max(old[k], low[k]), high[k]);
        float mean = kept + share[k] * (radiance[k] - kept);
        mean = k % 4 == 3 ? share[k] : mean;
        radiance[k] = lanes >> (k / 4) & 1 ? mean : radiance[k];
    }
}

/// Sixteen pixels of a tile's row.
typedef struct history_block {
    const rsv_history_window *window;
    uint32_t column, row;              ///< of the first one in the picture
    uint32_t line, first;              ///< and in the tile
    const float (*low)[4], (*high)[4]; ///< radiance around each
} history_block;

/// Prefetches the history for the next row: rows of a picture are far apart in memory.
static inline void approach_history(const rsv_frame_history *h, const history_lanes *restrict at)
{
    int width = (int)h->width, height = (int)h->height, left = into(at->left[0] - 1, width);
    size_t near = rsv_history_place(h, (uint32_t)left, (uint32_t)into(at->top[0] + 2, height));
    size_t far = rsv_history_place(h, (uint32_t)left, (uint32_t)into(at->top[0] + 3, height));
    size_t after = h->width - (size_t)left, count = after < LANES + 4 ? after : LANES + 4;
    __builtin_prefetch(h->depth_before + near);
    __builtin_prefetch(h->depth_before + near + count - 1);
    for (size_t k = 0; k < count; k += 4)
        __builtin_prefetch(h->shown_before[far + k]);
}

static inline void recall_block(
    const rsv_frame_history *h, const history_block *b, uint32_t uneven, float (*radiance)[4])
{
    _Alignas(64) float depth[LANES];
    earlier_lanes earlier;
    history_lanes at;
    const rsv_history_window *w = b->window;
    find_nearest((const float(*)[WIDE])(w->depth[b->line] + b->first), depth);
    find_earlier(h, b->column, b->row, depth, &earlier);
    find_taps(&earlier, &at);
    approach_history(h, &at);
    uint32_t shown = find_shown(h, uneven, &at, &earlier);
    memset(at.shown, 0, sizeof at.shown);
    memset(at.frames, 0, sizeof at.frames);
    for (uint32_t left = shown; left; left &= left - 1)
        look_back(h, &at, __builtin_ctz(left));
    add_samples(h, shown, &at, b->low[0], b->high[0], radiance[0]);
    for (uint32_t left = uneven & ~shown; left; left &= left - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(left);
        interpolate(h, w->now[b->line + 1] + b->first + lane + 1, radiance[lane]);
    }
}

/// One row of a tile: its samples and, where they vary, the history.
static void recall_row(const rsv_frame_history *h, const rsv_history_window *w, uint32_t column,
    uint32_t row, uint32_t line, float (*restrict radiance)[4])
{
    _Alignas(64) float low[RSV_TILE][4], high[RSV_TILE][4];
    memcpy(radiance, w->now[line + 1] + 1, RSV_TILE * sizeof *radiance);
    for (int k = 0; k < RSV_TILE; k++)
        radiance[k][3] = h->keep > 0 ? RSV_HISTORY_FRAMES : 1;
    if (!(h->keep > 0)) return;
    find_range(w->now + line, low, high);
    for (uint32_t first = 0; first < RSV_TILE; first += LANES) {
        const history_block block = { w, column + first, row, line, first,
            (const float(*)[4])low + first, (const float(*)[4])high + first };
        uint32_t uneven = find_uneven(block.low, block.high);
        if (uneven) recall_block(h, &block, uneven, radiance + first);
    }
}
