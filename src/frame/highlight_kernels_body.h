/// Shares of highlights of sixteen pixels (highlights.h), included by glossy_filter_body.h.
#include "highlights.h"

/// What rsv_highlight_share asks for.
typedef struct highlight_points {
    rsv_lanes3 out;
    float even[LANES];
} __attribute__((aligned(64))) highlight_points;

/// Variances of normals that widen lobes (RSV_PIXEL_VARIANCE).
static inline void find_variances(
    const rsv_glossy_tile *restrict tile, uint32_t first, float *restrict variance)
{
    for (int k = 0; k < LANES; k++) {
        float x = 0, y = 0, z = 0, count = 0;
        for (int n = 0; n < 4; n++) {
            uint32_t at = (first ^ (n & 2 ? RSV_TILE : 0)) + (uint32_t)(k ^ (n & 1));
            bool shown = tile->depth[at] > 0;
            x += shown ? tile->normal[0][at] : 0;
            y += shown ? tile->normal[1][at] : 0;
            z += shown ? tile->normal[2][at] : 0;
            count += shown ? 1 : 0;
        }
        variance[k] = RSV_PIXEL_VARIANCE * rsv_normals_variance(x, y, z, count);
    }
}

static inline void find_highlight_points(const rsv_glossy_tile *restrict tile, uint32_t first,
    const rsv_camera *c, const rsv_highlight_lanes *restrict at, highlight_points *restrict to)
{
    const float flat = c->vertical_fov == 0 ? 1 : 0; // orthographic
    for (int k = 0; k < LANES; k++) {
        float x = c->position.x - at->x[k], y = c->position.y - at->y[k];
        float z = c->position.z - at->z[k];
        float scale = 1 / sqrtf(x * x + y * y + z * z);
        to->out[0][k] = flat > 0 ? -c->forward.x : x * scale;
        to->out[1][k] = flat > 0 ? -c->forward.y : y * scale;
        to->out[2][k] = flat > 0 ? -c->forward.z : z * scale;
    }
    for (int k = 0; k < LANES; k++) {
        uint32_t pixel = first + (uint32_t)k;
        const rsv_rgb even = rgb(tile->even[0][pixel], tile->even[1][pixel], tile->even[2][pixel]);
        to->even[k] = rgb_luminance(even);
    }
}

static inline void find_shares(const rsv_highlight_light *light, const rsv_glossy_tile *tile,
    uint32_t first, const highlight_points *p, const rsv_highlight_lanes *at, float *restrict share)
{
    const rsv_highlight_light l = *light;
    for (int k = 0; k < LANES; k++) {
        uint32_t pixel = first + (uint32_t)k;
        const rsv_highlight_point point = { v3(at->x[k], at->y[k], at->z[k]),
            v3(p->out[0][k], p->out[1][k], p->out[2][k]),
            v3(tile->normal[0][pixel], tile->normal[1][pixel], tile->normal[2][pixel]),
            tile->alpha[pixel], p->even[k], at->variance[k] };
        share[k] = rsv_highlight_share(&l, &point);
    }
}

static uint32_t find_highlights(const rsv_highlights *h, const rsv_glossy_tile *restrict tile,
    const rsv_frame_aim *restrict aim, rsv_highlight_row row, rsv_highlight_lanes *restrict found)
{
    _Alignas(64) int pixel[LANES], shown[LANES] = { 0 };
    const float *depth = tile->depth + row.first;
    highlight_points points;
    cell_places places;
    if (!any_positive(depth)) return 0;
    for (int k = 0; k < LANES; k++)
        pixel[k] = (int)row.first + k;
    find_places(aim, (rsv_cell_row){ row.column, row.row, 0 }, pixel, depth, &places);
    memcpy(found->x, places.x, sizeof places.x);
    memcpy(found->y, places.y, sizeof places.y);
    memcpy(found->z, places.z, sizeof places.z);
    memset(found->variance, 0, sizeof found->variance);
    if (row.moves) find_variances(tile, row.first, found->variance);
    find_highlight_points(tile, row.first, &aim->lens.camera, found, &points);
    for (uint32_t n = 0; n < h->count; n++) {
        find_shares(&h->light[n], tile, row.first, &points, found, found->share[n]);
        for (int k = 0; k < LANES; k++)
            shown[k] |= (depth[k] > 0) & (found->share[n][k] < 1);
    }
    return lanes_set(shown);
}
