/// Cells and their neighbours, sixteen side by side (glossy_cells.h), included by packet_kernels_body.h.
#include "glossy_cells.h"

// ---- input from tiles ----------------------------------------------------------------------------

static inline bool any_positive(const float *restrict x)
{
    int any = 0;
    for (int k = 0; k < LANES; k++)
        any |= x[k] > 0;
    return any;
}

/// Points of sixteen cells.
typedef struct cell_places {
    float x[LANES], y[LANES], z[LANES];
} __attribute__((aligned(64))) cell_places;

/// Numbers of the pixels that stand for cells.
static inline void pick(
    const float *restrict plane, const int *restrict pixel, bool regular, float *restrict to)
{
    const float *from = plane + pixel[0];
    if (regular)
        for (int k = 0; k < LANES; k++)
            to[k] = from[2 * k];
    else
        for (int k = 0; k < LANES; k++)
            to[k] = plane[pixel[k]];
}

/// Whether the same corner of each cell stands for it.
static inline bool is_regular(const int *restrict pixel)
{
    int other = 0;
    for (int k = 0; k < LANES; k++)
        other |= pixel[k] ^ (pixel[0] + 2 * k);
    return other == 0;
}

/// Finds the pixels of a row that stand for cells: the first of four with a lobe. @param speaker out, -1 = none
/// @param depth of the pixels, 0 where there are none, out
static inline void find_speakers(const rsv_glossy_tile *restrict tile, uint32_t frame,
    uint32_t line, int *restrict speaker, float *restrict depth)
{
    for (int k = 0; k < LANES; k++)
        speaker[k] = -1, depth[k] = 0;
    for (uint32_t n = 4; n-- > 0;) { // the first choice comes last
        uint32_t corner = rsv_glossy_speaker(frame, n);
        int place = (int)((2 * line + corner / 2) * RSV_TILE + corner % 2);
        const float *from = tile->depth + place;
        for (int k = 0; k < LANES; k++) {
            float at = from[2 * k];
            speaker[k] = at > 0 ? place + 2 * k : speaker[k];
            depth[k] = at > 0 ? at : depth[k];
        }
    }
}

/// Points that pixels of a tile show. @param pixel of the tile
static inline void find_places(const rsv_frame_aim *restrict aim, rsv_cell_row row,
    const int *restrict pixel, const float *restrict depth, cell_places *restrict to)
{
    const rsv_lens *lens = &aim->lens;
    const rsv_camera *c = &lens->camera;
    const float flat = c->vertical_fov == 0 ? 1 : 0; // orthographic
    for (int k = 0; k < LANES; k++) {
        int i = (int)row.column + pixel[k] % RSV_TILE, j = (int)row.row + pixel[k] / RSV_TILE;
        float across = ((float)i + aim->place_x - lens->half_width) * lens->pixel_size;
        float upwards = (lens->half_height - ((float)j + aim->place_y)) * lens->pixel_size;
        float x = c->right.x * across + upwards * c->up.x;
        float y = c->right.y * across + upwards * c->up.y;
        float z = c->right.z * across + upwards * c->up.z;
        float dx = c->forward.x + x, dy = c->forward.y + y, dz = c->forward.z + z;
        float scale = depth[k] / sqrtf(dx * dx + dy * dy + dz * dz);
        float fx = x + depth[k] * c->forward.x, fy = y + depth[k] * c->forward.y,
              fz = z + depth[k] * c->forward.z;
        to->x[k] = c->position.x + (flat > 0 ? fx : dx * scale);
        to->y[k] = c->position.y + (flat > 0 ? fy : dy * scale);
        to->z[k] = c->position.z + (flat > 0 ? fz : dz * scale);
    }
}

static void fill_cells(const rsv_glossy_tile *restrict tile, const rsv_frame_aim *restrict aim,
    rsv_cell_row row, const rsv_glossy_cells *cells, int *restrict speaker)
{
    const rsv_glossy_geometry *g = &cells->now;
    const rsv_glossy_light *even = &cells->even;
    _Alignas(64) int pixel[LANES];
    _Alignas(64) float depth[LANES];
    cell_places places;
    size_t at = cells->first + (size_t)(row.row / 2 + row.line) * cells->stride + row.column / 2;
    find_speakers(tile, cells->frame, row.line, speaker, depth);
    memcpy(g->depth + at, depth, sizeof depth);
    memset(cells->fresh.count + at, 0, sizeof depth);
    if (!any_positive(depth)) return;
    for (int k = 0; k < LANES; k++)
        pixel[k] = speaker[k] < 0 ? 0 : speaker[k];
    find_places(aim, row, pixel, depth, &places);
    memcpy(g->x + at, places.x, sizeof places.x);
    memcpy(g->y + at, places.y, sizeof places.y);
    memcpy(g->z + at, places.z, sizeof places.z);
    bool regular = is_regular(pixel);
    pick(tile->normal[0], pixel, regular, g->nx + at);
    pick(tile->normal[1], pixel, regular, g->ny + at);
    pick(tile->normal[2], pixel, regular, g->nz + at);
    pick(tile->alpha, pixel, regular, g->alpha + at);
    pick(tile->even[0], pixel, regular, even->r + at);
    pick(tile->even[1], pixel, regular, even->g + at);
    pick(tile->even[2], pixel, regular, even->b + at);
}

#include "highlight_kernels_body.h"

static void pack_pixels(const rsv_glossy_tile *restrict tile, rsv_glossy_pixels *restrict to)
{
    for (int k = 0; k < RSV_GLOSSY_TILE_PIXELS; k++) {
        float depth = tile->depth[k];
        to->depth[k] = depth;
        for (int c = 0; c < 3; c++) {
            float albedo = depth > 0 ? tile->albedo[c][k] : 0,
                  normal = depth > 0 ? tile->normal[c][k] : 0;
            to->albedo[c][k] = (uint16_t)(int)(f_min(albedo, 1) * 65535 + 0.5f);
            to->normal[c][k] = (int16_t)(int)(normal * 32767);
        }
    }
}

#define ANY_WEIGHT 1e-4f

// ---- neighbours ---------------------------------------------------------------------------------

/// Sixteen cells that look around.
typedef struct cell_lanes {
    float x[LANES], y[LANES], z[LANES], depth[LANES], nx[LANES], ny[LANES], nz[LANES], alpha[LANES];
    float sharp[LANES];                ///< how quickly neighbours count less by their normals
    float near[LANES];                 ///< weights by position in the picture
    float closer[LANES], width[LANES]; ///< weights by depth, and by the width of their lobes
} __attribute__((aligned(64))) cell_lanes;

static inline void load_cells(
    const rsv_glossy_geometry *g, size_t at, float reach, cell_lanes *restrict c)
{
    for (int k = 0; k < LANES; k++) {
        float alpha = g->alpha[at + k], radius = 0.8f + f_min(20 * alpha, 2.4f);
        c->x[k] = g->x[at + k], c->y[k] = g->y[at + k], c->z[k] = g->z[at + k];
        c->nx[k] = g->nx[at + k], c->ny[k] = g->ny[at + k], c->nz[k] = g->nz[at + k];
        c->depth[k] = g->depth[at + k];
        c->alpha[k] = alpha;
        c->sharp[k] = f_max(2, 1 / (2 * alpha * alpha + 0.002f));
        c->near[k] = 1 / (radius * radius * reach * reach);
        c->closer[k] = 1 / (c->depth[k] + 1e-6f);
        c->width[k] = 1 / (0.5f * alpha + 0.02f);
    }
}

/// How much a neighbour at `at` counts, by its surface and by distance^2 in cells.
static inline void weigh(const cell_lanes *restrict c, const rsv_glossy_geometry *g, size_t at,
    float distance2, float *restrict weight)
{
    for (int k = 0; k < LANES; k++) {
        float cos = c->nx[k] * g->nx[at + k] + c->ny[k] * g->ny[at + k] + c->nz[k] * g->nz[at + k];
        float above = c->nx[k] * (g->x[at + k] - c->x[k]) + c->ny[k] * (g->y[at + k] - c->y[k]) +
                      c->nz[k] * (g->z[at + k] - c->z[k]);
        float wider = fabsf(g->alpha[at + k] - c->alpha[k]);
        float alike = f_max(1 - (1 - cos) * c->sharp[k], 0);
        float level = f_max(1 - 40 * fabsf(above) * c->closer[k], 0);
        float same = f_max(1 - wider * c->width[k], 0);
        float close = f_max(1 - distance2 * c->near[k], 0);
        weight[k] = g->depth[at + k] > 0 ? alike * alike * level * same * close : 0;
    }
}

/// The same for any neighbour at a similar depth, with a small weight, for cells without similar ones.
static inline void weigh_any(
    const cell_lanes *restrict c, const rsv_glossy_geometry *g, size_t at, float *restrict weight)
{
    for (int k = 0; k < LANES; k++) {
        float behind = fabsf(g->depth[at + k] - c->depth[k]);
        float wider = fabsf(g->alpha[at + k] - c->alpha[k]);
        float level = f_max(1 - 4 * behind * c->closer[k], 0);
        float same = f_max(1 - wider * c->width[k], 0);
        weight[k] += g->depth[at + k] > 0 ? ANY_WEIGHT * level * same : 0;
    }
}

/// A sum of samples.
typedef struct light_lanes {
    float r[LANES], g[LANES], b[LANES], count[LANES], reach[LANES];
} __attribute__((aligned(64))) light_lanes;

static inline light_lanes no_light(void)
{
    light_lanes none;
    memset(&none, 0, sizeof none);
    return none;
}

static inline void add_lanes(
    const rsv_glossy_light *l, size_t at, const float *restrict weight, light_lanes *restrict sum)
{
    const float *r = l->r + at, *g = l->g + at, *b = l->b + at, *reach = l->reach + at;
    const float *count = l->count + at;
    for (int k = 0; k < LANES; k++) {
        float w = weight[k] * count[k];
        float sr = w * r[k], sg = w * g[k], sb = w * b[k], sreach = w * reach[k];
        sum->r[k] += w > 0 ? sr : 0; // empty cells hold anything
        sum->g[k] += w > 0 ? sg : 0;
        sum->b[k] += w > 0 ? sb : 0;
        sum->reach[k] += w > 0 ? sreach : 0;
        sum->count[k] += w;
    }
}

static inline float least_of(const float *restrict x)
{
    float value = x[0];
    for (int k = 1; k < LANES; k++)
        value = f_min(value, x[k]);
    return value;
}

// ---- samples of this frame ----------------------------------------------------------------------

static inline void add_fresh(const rsv_glossy_cells *cells, size_t at, const cell_lanes *restrict c,
    light_lanes *restrict sum)
{
    _Alignas(64) float weight[LANES];
    float near = least_of(c->near);
    for (int dy = -3; dy <= 3; dy++)
        for (int dx = -3; dx <= 3; dx++) {
            size_t there = at + (size_t)((ptrdiff_t)dy * cells->stride + dx);
            if ((float)(dx * dx + dy * dy) * near >= 1) continue; // too far for all
            if (!any_positive(cells->fresh.count + there)) continue;
            weigh(c, &cells->now, there, (float)(dx * dx + dy * dy), weight);
            add_lanes(&cells->fresh, there, weight, sum);
        }
}

// ---- frames before ------------------------------------------------------------------------------

/// Places in a picture, in pixels.
typedef struct picture_lanes {
    float x[LANES], y[LANES];
} __attribute__((aligned(64))) picture_lanes;

/// Where points lie in a picture; far outside for those behind the camera.
static inline void project(const rsv_lens *lens, const float *restrict px, const float *restrict py,
    const float *restrict pz, picture_lanes *restrict to)
{
    const rsv_camera *c = &lens->camera;
    bool orthographic = c->vertical_fov == 0;
    for (int k = 0; k < LANES; k++) {
        float x = px[k] - c->position.x, y = py[k] - c->position.y, z = pz[k] - c->position.z;
        float ahead = x * c->forward.x + y * c->forward.y + z * c->forward.z;
        float right = x * c->right.x + y * c->right.y + z * c->right.z;
        float up = x * c->up.x + y * c->up.y + z * c->up.z;
        float scale = 1 / ((orthographic ? 1 : ahead) * lens->pixel_size);
        bool seen = orthographic | (ahead > 0);
        to->x[k] = seen ? lens->half_width + right * scale : -1e6f;
        to->y[k] = seen ? lens->half_height - up * scale : -1e6f;
    }
}

/// Where cells lay in the frame before. Mirrored things move as their images behind the surface do.
static inline void find_before(const rsv_glossy_cells *cells, const cell_lanes *restrict c,
    const float *restrict reach, uint32_t column, uint32_t row, picture_lanes *restrict to)
{
    _Alignas(64) float px[LANES], py[LANES], pz[LANES];
    picture_lanes now;
    const rsv_vec3 eye = cells->lens.camera.position;
    for (int k = 0; k < LANES; k++) {
        float mirrored = f_max(1 - 6 * c->alpha[k], 0) * reach[k] / (c->depth[k] + 1e-6f);
        px[k] = c->x[k] + mirrored * (c->x[k] - eye.x);
        py[k] = c->y[k] + mirrored * (c->y[k] - eye.y);
        pz[k] = c->z[k] + mirrored * (c->z[k] - eye.z);
    }
    project(&cells->lens, px, py, pz, &now);
    project(&cells->lens_before, px, py, pz, to);
    for (int k = 0; k < LANES; k++) {
        float dx = 0.5f * (to->x[k] - now.x[k]), dy = 0.5f * (to->y[k] - now.y[k]);
        dx = fabsf(dx) < 2e-3f ? 0 : dx;
        dy = fabsf(dy) < 2e-3f ? 0 : dy;
        to->x[k] = (float)((int)column + k) + f_min(f_max(dx, -1e5f), 1e5f);
        to->y[k] = (float)row + f_min(f_max(dy, -1e5f), 1e5f);
    }
}

static inline void gather_plane(const float *plane, const int *restrict index, float *restrict to)
{
    gather(plane, index, to);
}

/// Weight of a cell of the previous frame for these. @param index of it @param weight in and out
static inline void check_before(const rsv_glossy_geometry *g, const cell_lanes *restrict c,
    const int *restrict index, float *restrict weight)
{
    _Alignas(64) float x[LANES], y[LANES], z[LANES], depth[LANES], nx[LANES], ny[LANES], nz[LANES];
    gather_plane(g->x, index, x);
    gather_plane(g->y, index, y);
    gather_plane(g->z, index, z);
    gather_plane(g->depth, index, depth);
    gather_plane(g->nx, index, nx);
    gather_plane(g->ny, index, ny);
    gather_plane(g->nz, index, nz);
    for (int k = 0; k < LANES; k++) {
        float cos = c->nx[k] * nx[k] + c->ny[k] * ny[k] + c->nz[k] * nz[k];
        float above =
            c->nx[k] * (x[k] - c->x[k]) + c->ny[k] * (y[k] - c->y[k]) + c->nz[k] * (z[k] - c->z[k]);
        bool same = (depth[k] > 0) & (cos > 0.9f) & (fabsf(above) < 0.02f * c->depth[k]);
        weight[k] = same ? weight[k] : 0;
    }
}

static inline void add_before(const rsv_glossy_light *l, const int *restrict index,
    const float *restrict weight, light_lanes *restrict sum, float *restrict samples)
{
    _Alignas(64) float r[LANES], g[LANES], b[LANES], count[LANES], reach[LANES];
    gather_plane(l->r, index, r);
    gather_plane(l->g, index, g);
    gather_plane(l->b, index, b);
    gather_plane(l->count, index, count);
    gather_plane(l->reach, index, reach);
    for (int k = 0; k < LANES; k++) {
        float w = count[k] > 0 ? weight[k] : 0;
        sum->r[k] += w * r[k];
        sum->g[k] += w * g[k];
        sum->b[k] += w * b[k];
        sum->reach[k] += w * reach[k];
        sum->count[k] += w;
        samples[k] += w * count[k];
    }
}

/// Means stored at the cells' previous positions, and their number of samples.
static inline void recall(const rsv_glossy_cells *cells, const cell_lanes *restrict c,
    const picture_lanes *restrict place, light_lanes *restrict mean)
{
    _Alignas(64) float weight[LANES], samples[LANES];
    _Alignas(64) int index[LANES];
    *mean = no_light();
    memset(samples, 0, sizeof samples);
    for (int tap = 0; tap < 4; tap++) {
        for (int k = 0; k < LANES; k++) {
            float x = place->x[k], y = place->y[k];
            float left = floorf(x), top = floorf(y), fx = x - left, fy = y - top;
            int i = (int)left + (tap & 1), j = (int)top + (tap >> 1);
            bool inside = (i >= 0) & (j >= 0) & (i < (int)cells->width) & (j < (int)cells->height);
            weight[k] = inside ? (tap & 1 ? fx : 1 - fx) * (tap >> 1 ? fy : 1 - fy) : 0;
            index[k] = (int)cells->first + (inside ? j * (int)cells->stride + i : 0);
        }
        if (!any_positive(weight)) continue;
        check_before(&cells->before, c, index, weight);
        add_before(&cells->kept_before, index, weight, mean, samples);
    }
    for (int k = 0; k < LANES; k++) {
        float scale = mean->count[k] > 1e-3f ? 1 / mean->count[k] : 0;
        mean->r[k] *= scale, mean->g[k] *= scale, mean->b[k] *= scale, mean->reach[k] *= scale;
        mean->count[k] = f_min(samples[k] * scale * cells->keep, cells->most);
    }
}

// ---- both together ------------------------------------------------------------------------------

/// `to` = where x is more than `least`, `yes`, or else `no`.
static inline void choose_lanes(const float *restrict x, float least, const float *restrict yes,
    const float *restrict no, float *restrict to)
{
    for (int k = 0; k < LANES; k++) {
        float a = yes[k], b = no[k];
        to[k] = x[k] > least ? a : b;
    }
}

static inline void keep_light(const rsv_glossy_cells *cells, size_t at,
    const light_lanes *restrict old, const light_lanes *restrict fresh)
{
    const rsv_glossy_light *to = &cells->kept, *even = &cells->even;
    light_lanes mean;
    for (int k = 0; k < LANES; k++) {
        float n = old->count[k], count = n + fresh->count[k];
        float scale = count > 1e-3f ? 1 / count : 0;
        mean.r[k] = scale * (n * old->r[k] + fresh->r[k]);
        mean.g[k] = scale * (n * old->g[k] + fresh->g[k]);
        mean.b[k] = scale * (n * old->b[k] + fresh->b[k]);
        mean.reach[k] = scale * (n * old->reach[k] + fresh->reach[k]);
        mean.count[k] = count;
    }
    choose_lanes(mean.count, 1e-3f, mean.r, even->r + at, to->r + at);
    choose_lanes(mean.count, 1e-3f, mean.g, even->g + at, to->g + at);
    choose_lanes(mean.count, 1e-3f, mean.b, even->b + at, to->b + at);
    memcpy(to->reach + at, mean.reach, sizeof mean.reach);
    const float none[LANES] = { 0 };
    choose_lanes(cells->now.depth + at, 0, mean.count, none, to->count + at);
}

/// This frame's samples and the frames before, for sixteen cells.
static void blend_cells(const rsv_glossy_cells *cells, uint32_t column, uint32_t row)
{
    _Alignas(64) float reach[LANES];
    picture_lanes before;
    size_t at = cells->first + (size_t)row * cells->stride + column;
    cell_lanes c;
    light_lanes fresh = no_light(), old = no_light();
    if (!any_positive(cells->now.depth + at)) {
        memset(cells->kept.count + at, 0, LANES * sizeof(float));
        return;
    }
    load_cells(&cells->now, at, 1, &c);
    add_fresh(cells, at, &c, &fresh);
    for (int k = 0; k < LANES; k++)
        reach[k] = fresh.count[k] > 1e-3f ? fresh.reach[k] / fresh.count[k] : 0;
    if (cells->keep > 0) {
        find_before(cells, &c, reach, column, row, &before);
        recall(cells, &c, &before, &old);
    }
    keep_light(cells, at, &old, &fresh);
}

/// Samples that a cell shows by itself.
#define ENOUGH_SAMPLES 32.0f

static inline bool all_enough(const float *restrict count, const float *restrict depth)
{
    int few = 0;
    for (int k = 0; k < LANES; k++)
        few |= (depth[k] > 0) & (count[k] < ENOUGH_SAMPLES);
    return !few;
}

/// Light of sixteen cells: those with few samples search around.
static void smooth_cells(const rsv_glossy_cells *cells, uint32_t column, uint32_t row)
{
    _Alignas(64) float weight[LANES];
    size_t at = cells->first + (size_t)row * cells->stride + column;
    const rsv_glossy_light *kept = &cells->kept, *to = &cells->shown;
    cell_lanes c;
    light_lanes sum = no_light();
    if (!any_positive(cells->now.depth + at)) return;
    if (all_enough(kept->count + at, cells->now.depth + at)) {
        memcpy(to->r + at, kept->r + at, LANES * sizeof(float));
        memcpy(to->g + at, kept->g + at, LANES * sizeof(float));
        memcpy(to->b + at, kept->b + at, LANES * sizeof(float));
        return;
    }
    load_cells(&cells->now, at, 2, &c);
    for (int dy = -4; dy <= 4; dy += 2)
        for (int dx = -4; dx <= 4; dx += 2) {
            size_t there = at + (size_t)((ptrdiff_t)dy * cells->stride + dx);
            weigh(&c, &cells->now, there, (float)(dx * dx + dy * dy), weight);
            weigh_any(&c, &cells->now, there, weight);
            if (dx || dy)
                for (int k = 0; k < LANES; k++)
                    weight[k] *= f_max(1 - kept->count[at + k] / ENOUGH_SAMPLES, 0);
            add_lanes(kept, there, weight, &sum);
        }
    for (int k = 0; k < LANES; k++) {
        float scale = sum.count[k] > 1e-2f * ANY_WEIGHT ? 1 / sum.count[k] : 0;
        sum.r[k] *= scale, sum.g[k] *= scale, sum.b[k] *= scale;
    }
    choose_lanes(sum.count, 1e-2f * ANY_WEIGHT, sum.r, kept->r + at, to->r + at);
    choose_lanes(sum.count, 1e-2f * ANY_WEIGHT, sum.g, kept->g + at, to->g + at);
    choose_lanes(sum.count, 1e-2f * ANY_WEIGHT, sum.b, kept->b + at, to->b + at);
}

// ---- back to pixels -----------------------------------------------------------------------------

/// Sixteen pixels, and the light they take from cells.
typedef struct pixel_lanes {
    float depth[LANES], closer[LANES], nx[LANES], ny[LANES], nz[LANES];
    float r[LANES], g[LANES], b[LANES], weight[LANES];
} __attribute__((aligned(64))) pixel_lanes;

typedef float vector_lanes __attribute__((vector_size(4 * LANES)));

/// Numbers of the cells that sixteen pixels in a row lie in, or of their neighbours to the side.
/// @param plane from the cell before the first one on
static inline void spread_cells(const float *plane, bool beside, float *restrict to)
{
    vector_lanes cells;
    memcpy(&cells, plane, sizeof cells);
    if (beside)
        cells =
            __builtin_shufflevector(cells, cells, 0, 2, 1, 3, 2, 4, 3, 5, 4, 6, 5, 7, 6, 8, 7, 9);
    else
        cells =
            __builtin_shufflevector(cells, cells, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 8);
    memcpy(to, &cells, sizeof cells);
}

/// Adds cells of one line: those that pixels lie in, or their neighbours to the side. @param near by the line
static inline void add_line(
    const rsv_glossy_cells *cells, size_t at, bool beside, float near, pixel_lanes *restrict p)
{
    const rsv_glossy_geometry *g = &cells->now;
    const rsv_glossy_light *l = &cells->shown;
    _Alignas(64) float depth[LANES], nx[LANES], ny[LANES], nz[LANES], red[LANES], green[LANES],
        blue[LANES];
    float share = near * (beside ? 0.25f : 0.75f);
    spread_cells(g->depth + at - 1, beside, depth);
    spread_cells(g->nx + at - 1, beside, nx);
    spread_cells(g->ny + at - 1, beside, ny);
    spread_cells(g->nz + at - 1, beside, nz);
    spread_cells(l->r + at - 1, beside, red);
    spread_cells(l->g + at - 1, beside, green);
    spread_cells(l->b + at - 1, beside, blue);
    for (int k = 0; k < LANES; k++) {
        float cos = p->nx[k] * nx[k] + p->ny[k] * ny[k] + p->nz[k] * nz[k];
        float behind = (depth[k] - p->depth[k]) * p->closer[k];
        float alike = f_max(1 - 8 * (1 - cos), 1e-3f), level = 1 / (1 + 400 * behind * behind);
        float weight = share * alike * alike * level;
        float w = depth[k] > 0 ? weight : 0;
        float r = w * red[k], g_ = w * green[k], b = w * blue[k];
        p->r[k] += w > 0 ? r : 0; // empty cells hold anything
        p->g[k] += w > 0 ? g_ : 0;
        p->b[k] += w > 0 ? b : 0;
        p->weight[k] += w;
    }
}

/// Sixteen pixels as they were packed. @param first of them
static inline void unpack_pixels(
    const rsv_glossy_pixels *pixels, uint32_t first, pixel_lanes *restrict p)
{
    const int16_t *nx = pixels->normal[0] + first, *ny = pixels->normal[1] + first,
                  *nz = pixels->normal[2] + first;
    const float *depth = pixels->depth + first;
    memset(p, 0, sizeof *p);
    for (int k = 0; k < LANES; k++) {
        p->depth[k] = depth[k];
        p->closer[k] = 1 / (depth[k] + 1e-6f);
        p->nx[k] = (float)nx[k] * (1.0f / 32767);
        p->ny[k] = (float)ny[k] * (1.0f / 32767);
        p->nz[k] = (float)nz[k] * (1.0f / 32767);
    }
}

/// Adds the light of sixteen pixels, times their albedo. @param radiance [LANES][4] in and out
static inline void add_lobes(const rsv_glossy_pixels *pixels, uint32_t first,
    const pixel_lanes *restrict p, float *restrict radiance)
{
    const uint16_t *red = pixels->albedo[0] + first, *green = pixels->albedo[1] + first,
                   *blue = pixels->albedo[2] + first;
    _Alignas(64) float light[4 * LANES];
    for (int k = 0; k < LANES; k++) {
        float scale = (1.0f / 65535) / f_max(p->weight[k], 1e-30f);
        scale = f_min(p->depth[k], p->weight[k]) > 0 ? scale : 0;
        light[4 * k] = scale * p->r[k] * (float)red[k];
        light[4 * k + 1] = scale * p->g[k] * (float)green[k];
        light[4 * k + 2] = scale * p->b[k] * (float)blue[k];
        light[4 * k + 3] = 0;
    }
    for (int k = 0; k < 4 * LANES; k++)
        radiance[k] += light[k];
}

static void light_pixels(const rsv_glossy_cells *cells, const rsv_glossy_pixels *restrict pixels,
    uint32_t x, uint32_t y, size_t cell, float (*restrict radiance)[4])
{
    uint32_t first = y * RSV_TILE + x;
    ptrdiff_t line = y & 1 ? (ptrdiff_t)cells->stride : -(ptrdiff_t)cells->stride;
    pixel_lanes p;
    if (!any_positive(pixels->depth + first)) return;
    unpack_pixels(pixels, first, &p);
    for (int beside = 0; beside < 2; beside++) {
        add_line(cells, cell, beside, 0.75f, &p);
        add_line(cells, (size_t)((ptrdiff_t)cell + line), beside, 0.25f, &p);
    }
    add_lobes(pixels, first, &p, radiance[first]);
}
