/// Rows of a tile and what was shown before (history.h), included by packet_kernels_body.h.
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

/// Radiance that differs less from pixel to pixel, relative to the greatest, has no edges to be smoothed.
#define EVEN_RANGE 0.02f

/// Pixels around which radiance varies, a bit each. The others show their own sample.
static inline uint32_t find_uneven(
    const float (*restrict low)[4], const float (*restrict high)[4], int first)
{
    _Alignas(64) int uneven[LANES];
    for (int k = 0; k < LANES; k++) {
        const float *l = low[first + k], *h = high[first + k];
        float range = f_max(f_max(h[0] - l[0], h[1] - l[1]), h[2] - l[2]);
        uneven[k] = range > EVEN_RANGE * f_max(f_max(h[0], h[1]), h[2]) ? 1 : 0;
    }
    return lanes_set(uneven);
}

/// Depth of the nearest surface among a pixel and its neighbours: edges move with what is before them.
/// @param rows three of the window, from the pixel to the left of the first one on
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
static inline void find_seen(const rsv_frame_history *h, uint32_t column, uint32_t row,
    const float *restrict depth, float (*restrict point)[LANES])
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
        point[0][k] = c->position.x + (orthographic ? x + depth[k] * c->forward.x : dx * scale);
        point[1][k] = c->position.y + (orthographic ? y + depth[k] * c->forward.y : dy * scale);
        point[2][k] = c->position.z + (orthographic ? z + depth[k] * c->forward.z : dz * scale);
    }
}

static inline void find_earlier(const rsv_frame_history *h, uint32_t column, uint32_t row,
    const float *restrict depth, earlier_lanes *restrict to)
{
    _Alignas(64) float point[3][LANES];
    const rsv_lens *lens = &h->lens_before;
    const rsv_camera *c = &lens->camera;
    bool orthographic = c->vertical_fov == 0;
    find_seen(h, column, row, depth, point);
    for (int k = 0; k < LANES; k++) {
        float x = point[0][k] - c->position.x, y = point[1][k] - c->position.y,
              z = point[2][k] - c->position.z;
        float ahead = x * c->forward.x + y * c->forward.y + z * c->forward.z;
        float right = x * c->right.x + y * c->right.y + z * c->right.z;
        float up = x * c->up.x + y * c->up.y + z * c->up.z;
        float scale = 1 / ((orthographic ? 1 : ahead) * lens->pixel_size);
        bool seen = orthographic | (ahead > 0);
        float i = lens->half_width + right * scale - h->place_x;
        float j = lens->half_height - up * scale - h->place_y;
        to->x[k] = seen ? f_min(f_max(i, -4), 1e5f) : -4;
        to->y[k] = seen ? f_min(f_max(j, -4), 1e5f) : -4;
        to->distance[k] = orthographic ? ahead : sqrtf(x * x + y * y + z * z);
    }
}

/// Weights of four neighbours in a row, by a cubic that passes through them (Catmull and Rom 1974).
static inline void cubic_weights(float t, float weight[4])
{
    weight[0] = t * (-0.5f + t * (1 - 0.5f * t));
    weight[1] = 1 + t * t * (-2.5f + 1.5f * t);
    weight[2] = t * (0.5f + t * (2 - 1.5f * t));
    weight[3] = t * t * (-0.5f + 0.5f * t);
}

static inline int into(int x, uint32_t count)
{
    int last = (int)count - 1;
    return x < 0 ? 0 : x > last ? last : x;
}

/// What was shown at a place, and of how many frames that is the mean.
static inline rsv_float4 shown_at(const rsv_frame_history *h, float x, float y)
{
    float left = floorf(x), top = floorf(y), across[4], down[4];
    int first = (int)left - 1;
    rsv_float4 sum = { 0, 0, 0, 0 };
    bool inside = first >= 0 && first + 3 < (int)h->width;
    cubic_weights(x - left, across);
    cubic_weights(y - top, down);
    for (int j = 0; j < 4; j++) {
        const rsv_float4 *row = (const rsv_float4 *)h->shown_before[rsv_history_place(
            h, 0, (uint32_t)into((int)top - 1 + j, h->height))];
        rsv_float4 line = { 0, 0, 0, 0 };
        if (inside)
            for (int i = 0; i < 4; i++)
                line += across[i] * row[first + i];
        else
            for (int i = 0; i < 4; i++)
                line += across[i] * row[into(first + i, h->width)];
        sum += down[j] * line;
    }
    return sum;
}

/// Depths that differ less belong to one surface.
#define SAME_DEPTH 0.1f

/// Whether the picture showed something at about this distance there.
static inline bool was_shown(const rsv_frame_history *h, float x, float y, float distance)
{
    if (!(x > -0.5f && y > -0.5f && x < (float)h->width - 0.5f && y < (float)h->height - 0.5f))
        return false;
    int left = (int)floorf(x), top = (int)floorf(y);
    for (int tap = 0; tap < 4; tap++) {
        uint32_t i = (uint32_t)into(left + (tap & 1), h->width),
                 j = (uint32_t)into(top + (tap >> 1), h->height);
        float then = h->depth_before[rsv_history_place(h, i, j)];
        if (fabsf(then - distance) < SAME_DEPTH * distance) return true;
    }
    return false;
}

/// What the middle of a pixel shows, between the samples of this frame around it. @param middle of the window
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

/// Adds a pixel's sample to the mean of what was shown before. @param low, high radiance around it
static inline void recall_pixel(const rsv_frame_history *h, const float (*restrict now)[4],
    const float *restrict low, const float *restrict high, rsv_float4 old, float *restrict out)
{
    float count = h->keep * f_min(f_max(old[3], 1), RSV_HISTORY_FRAMES - 1);
    float share = 1 / (count + 1);
    for (int c = 0; c < 3; c++) {
        float kept = f_min(f_max(old[c], low[c]), high[c]);
        out[c] = kept + share * (now[0][c] - kept);
    }
    out[3] = count + 1;
}

/// One row of a tile: its samples, and what was shown before where they vary.
static void recall_row(const rsv_frame_history *h, const rsv_history_window *w, uint32_t column,
    uint32_t row, uint32_t line, float (*restrict radiance)[4])
{
    _Alignas(64) float low[RSV_TILE][4], high[RSV_TILE][4], depth[LANES];
    earlier_lanes earlier;
    memcpy(radiance, w->now[line + 1] + 1, RSV_TILE * sizeof *radiance);
    for (int k = 0; k < RSV_TILE; k++)
        radiance[k][3] = h->keep > 0 ? RSV_HISTORY_FRAMES : 1;
    if (!(h->keep > 0)) return;
    find_range(w->now + line, low, high);
    for (int first = 0; first < RSV_TILE; first += LANES) {
        uint32_t uneven = find_uneven(low, high, first);
        if (!uneven) continue;
        find_nearest((const float(*)[WIDE])(w->depth[line] + first), depth);
        find_earlier(h, column + (uint32_t)first, row, depth, &earlier);
        for (; uneven; uneven &= uneven - 1) {
            int lane = __builtin_ctz(uneven), k = first + lane;
            const float(*now)[4] = w->now[line + 1] + k + 1;
            float x = earlier.x[lane], y = earlier.y[lane];
            if (was_shown(h, x, y, earlier.distance[lane]))
                recall_pixel(h, now, low[k], high[k], shown_at(h, x, y), radiance[k]);
            else
                interpolate(h, now, radiance[k]);
        }
    }
}
