/// Included once per instruction set, with RSV_KERNELS the name of its table.
#include "look_up_kernels.h"

#include "../core/core.h"
#include "../core/hemisphere.h"
#include "lobe.h"

#include <string.h>

#define LANES RSV_DIRECTIONAL_LANES
#define CHROMA_UNIT (RSV_MAP_CHROMA_RANGE / (127 * 127))

/// Lobes side by side, and the sums of what they see.
typedef struct lobe_lanes {
    float mirrored_x[LANES], mirrored_y[LANES], mirrored_z[LANES];
    float normal_x[LANES], normal_y[LANES], normal_z[LANES]; ///< of the surface
    float level[LANES], tails[LANES], spot[LANES];           ///< weights of tails and spot
    float weight[LANES], luma[LANES], orange[LANES], green[LANES];
} lobe_lanes;

/// Receivers that lobes are to be looked up at.
typedef struct receiver_batch {
    const rsv_directional_map *map[LANES];
    uint32_t lane[LANES], count;
    float weight[LANES];
} receiver_batch;

// ---- one batch ------------------------------------------------------------------------------------

/// Places in the squares of sixteen maps.
typedef struct map_places {
    float x[LANES], y[LANES], level[LANES];
} map_places;

/// The frame of a map, about the surface's normal here.
static void find_places(const receiver_batch *b, const lobe_lanes *l, map_places *p)
{
    float a[LANES], c[LANES], nx[LANES], ny[LANES], nz[LANES], mx[LANES], my[LANES], mz[LANES];
    for (int k = 0; k < LANES; k++) {
        uint32_t n = b->lane[k];
        a[k] = (float)b->map[k]->tangent[0], c[k] = (float)b->map[k]->tangent[1];
        nx[k] = l->normal_x[n], ny[k] = l->normal_y[n], nz[k] = l->normal_z[n];
        mx[k] = l->mirrored_x[n], my[k] = l->mirrored_y[n], mz[k] = l->mirrored_z[n];
        p->level[k] = l->level[n];
    }
    for (int k = 0; k < LANES; k++) {
        // octahedral (core/octahedral.h), not unit
        float u = a[k] * (2.0f / 255) - 1, w = c[k] * (2.0f / 255) - 1;
        float height = 1 - fabsf(u) - fabsf(w);
        float folded_u = copysignf(1 - fabsf(w), u), folded_w = copysignf(1 - fabsf(u), w);
        float tx = height < 0 ? folded_u : u, tz = height < 0 ? folded_w : w, ty = height;
        float along = tx * nx[k] + ty * ny[k] + tz * nz[k];
        tx -= along * nx[k], ty -= along * ny[k], tz -= along * nz[k];
        float x = tx * mx[k] + ty * my[k] + tz * mz[k];
        float y = (ny[k] * tz - nz[k] * ty) * mx[k] + (nz[k] * tx - nx[k] * tz) * my[k] +
                  (nx[k] * ty - ny[k] * tx) * mz[k];
        float z = nx[k] * mx[k] + ny[k] * my[k] + nz[k] * mz[k];
        // the length of (x, y) does not matter
        rsv_hemisphere_to_square(v3(x, y, z), &p->x[k], &p->y[k]);
    }
}

/// Four cells around a place on one level: the second of each row counts by `x`, the second row by `y`.
typedef struct map_taps {
    int32_t row[2][LANES]; ///< first cell of each
    float x[LANES], y[LANES];
} map_taps;

/// Cells along a side of a level, and cells of all finer ones.
static float level_side(float level) { return level < 1 ? 8 : level < 2 ? 4 : 2; }
static float level_begin(float level) { return level < 1 ? 0 : level < 2 ? 64 : 80; }

/// @param finer 0 = the level at which places are or the next finer one, 1 = the one after that
static void find_luma_taps(const map_places *p, float finer, map_taps *t)
{
    for (int k = 0; k < LANES; k++) {
        float level = f_min(p->level[k], 1.999f) + finer;
        float side = level_side(level), begin = level_begin(level);
        float i = f_min(f_max(p->x[k] * side - 0.5f, 0), side - 1);
        float j = f_min(f_max(p->y[k] * side - 0.5f, 0), side - 1);
        float whole_i = f_min((float)(int32_t)i, side - 2);
        float whole_j = f_min((float)(int32_t)j, side - 2);
        t->row[0][k] = (int32_t)(begin + whole_j * side + whole_i);
        t->row[1][k] = t->row[0][k] + (int32_t)side;
        t->x[k] = i - whole_i, t->y[k] = j - whole_j;
    }
}

static void find_chroma_taps(const map_places *p, map_taps *t)
{
    for (int k = 0; k < LANES; k++) {
        float i = f_min(f_max(p->x[k] * 4 - 0.5f, 0), 3),
              j = f_min(f_max(p->y[k] * 4 - 0.5f, 0), 3);
        float whole_i = f_min((float)(int32_t)i, 2), whole_j = f_min((float)(int32_t)j, 2);
        t->row[0][k] = (int32_t)(whole_j * 4 + whole_i);
        t->row[1][k] = t->row[0][k] + 4;
        t->x[k] = i - whole_i, t->y[k] = j - whole_j;
    }
}

/// Luminance on one level, times 255^2.
static void read_luma(const receiver_batch *b, const map_taps *t, float luma[LANES])
{
    int32_t row[2][LANES];
    for (int k = 0; k < LANES; k++) {
        uint16_t pair[2];
        memcpy(&pair[0], b->map[k]->luma + t->row[0][k], 2);
        memcpy(&pair[1], b->map[k]->luma + t->row[1][k], 2);
        row[0][k] = pair[0], row[1][k] = pair[1];
    }
    for (int k = 0; k < LANES; k++) {
        float a = (float)(row[0][k] & 255), c = (float)(row[0][k] >> 8);
        float d = (float)(row[1][k] & 255), e = (float)(row[1][k] >> 8);
        float upper = a * a + t->x[k] * (c * c - a * a), lower = d * d + t->x[k] * (e * e - d * d);
        luma[k] = upper + t->y[k] * (lower - upper);
    }
}

RSV_INLINE float signed_square(int32_t code)
{
    float value = (float)code;
    return value * fabsf(value);
}

/// One of the four codes in a row of chroma: two cells of two.
RSV_INLINE int32_t code_of(uint32_t row, int index) { return (int8_t)(row >> 8 * index); }

/// Both parts of colour, times 127^2.
static void read_chroma(
    const receiver_batch *b, const map_taps *t, float orange[LANES], float green[LANES])
{
    uint32_t row[2][LANES];
    for (int k = 0; k < LANES; k++) {
        memcpy(&row[0][k], b->map[k]->chroma[t->row[0][k]], 4);
        memcpy(&row[1][k], b->map[k]->chroma[t->row[1][k]], 4);
    }
    for (int part = 0; part < 2; part++) {
        float *out = part ? green : orange;
        for (int k = 0; k < LANES; k++) {
            float a = signed_square(code_of(row[0][k], part));
            float c = signed_square(code_of(row[0][k], part + 2));
            float d = signed_square(code_of(row[1][k], part));
            float e = signed_square(code_of(row[1][k], part + 2));
            float upper = a + t->x[k] * (c - a), lower = d + t->x[k] * (e - d);
            out[k] = upper + t->y[k] * (lower - upper);
        }
    }
}

/// Luminance and colour of the middle of each lobe in the map of its receiver, in shares of the largest luminance.
typedef struct map_spots {
    float luma[LANES], orange[LANES], green[LANES];
} map_spots;

static void find_spots(const receiver_batch *b, const lobe_lanes *l, map_spots *s)
{
    map_places places;
    map_taps taps;
    float finer[LANES], coarser[LANES], mean[3][LANES];
    find_places(b, l, &places);
    find_luma_taps(&places, 0, &taps);
    read_luma(b, &taps, finer);
    find_luma_taps(&places, 1, &taps);
    read_luma(b, &taps, coarser);
    find_chroma_taps(&places, &taps);
    read_chroma(b, &taps, s->orange, s->green);
    for (int part = 0; part < 3; part++)
        for (int k = 0; k < LANES; k++)
            mean[part][k] = (float)b->map[k]->mean[part];
    for (int k = 0; k < LANES; k++) {
        float level = places.level[k], share = level < 1 ? level : level - 1;
        float luma = (finer[k] + share * (coarser[k] - finer[k])) * (1.0f / (255 * 255));
        float ratio = luma / f_max(mean[0][k], 1);
        s->luma[k] = luma;
        s->orange[k] = s->orange[k] * CHROMA_UNIT + ratio * mean[1][k];
        s->green[k] = s->green[k] * CHROMA_UNIT + ratio * mean[2][k];
    }
}

/// Adds what the receivers of a batch know to the sums of their lobes.
static void look_up_batch(receiver_batch *b, lobe_lanes *l)
{
    map_spots spots;
    for (uint32_t k = b->count; k < LANES; k++)
        b->map[k] = b->map[0], b->lane[k] = b->lane[0], b->weight[k] = 0;
    find_spots(b, l, &spots);
    for (uint32_t k = 0; k < b->count; k++) {
        const rsv_directional_map *map = b->map[k];
        uint32_t n = b->lane[k];
        float spot = b->weight[k] * map->scale * l->spot[n];
        float tails = b->weight[k] * map->scale * l->tails[n] * (1.0f / 32767);
        l->weight[n] += b->weight[k];
        l->luma[n] += spot * spots.luma[k] + tails * (float)map->mean[0];
        l->orange[n] += spot * spots.orange[k] + tails * (float)map->mean[1];
        l->green[n] += spot * spots.green[k] + tails * (float)map->mean[2];
    }
    b->count = 0;
}

// ---- receivers ------------------------------------------------------------------------------------

/// What lookups of a packet work with.
typedef struct look_up {
    const rsv_directional *directional;
    lobe_lanes lanes;
    receiver_batch batch;
} look_up;

static void add_receiver(look_up *u, uint32_t receiver, float weight, uint32_t lane)
{
    receiver_batch *b = &u->batch;
    b->map[b->count] = &u->directional->map[receiver];
    b->lane[b->count] = lane;
    b->weight[b->count++] = weight;
    if (b->count == LANES) look_up_batch(b, &u->lanes);
}

/// Hanging nodes are means of others; buried ones know nothing.
static void add_node(look_up *u, uint32_t node, float weight, uint32_t lane)
{
    const rsv_directional *d = u->directional;
    const rsv_receiver_word *word = &d->word[node / 64];
    uint64_t bit = UINT64_C(1) << node % 64;
    if (!(weight > 0)) return;
    if (word->bits & bit) {
        uint32_t below = (uint32_t)__builtin_popcountll(word->bits & (bit - 1));
        add_receiver(u, (uint32_t)word->below + below, weight, lane);
        return;
    }
    uint32_t hanging = d->elements->node_hanging[node];
    if (hanging == RSV_NONE) return;
    const rsv_hanging *h = &d->elements->hanging[hanging];
    for (int p = 0; p < RSV_PARENTS; p++)
        add_node(u, h->parent[p], weight * h->weight[p], lane);
}

// ---- lobes ----------------------------------------------------------------------------------------

static void set_lanes(const rsv_directional_packet *p, lobe_lanes *l)
{
    for (int k = 0; k < LANES; k++) {
        float alpha = p->alpha[k], roughness = sqrtf(f_max(alpha, 0));
        float cos = p->normal_x[k] * p->outgoing_x[k] + p->normal_y[k] * p->outgoing_y[k] +
                    p->normal_z[k] * p->outgoing_z[k];
        float x = 2 * cos * p->normal_x[k] - p->outgoing_x[k];
        float y = 2 * cos * p->normal_y[k] - p->outgoing_y[k];
        float z = 2 * cos * p->normal_z[k] - p->outgoing_z[k];
        float height = x * p->surface_x[k] + y * p->surface_y[k] + z * p->surface_z[k];
        l->mirrored_x[k] = x, l->mirrored_y[k] = y, l->mirrored_z[k] = z;
        l->normal_x[k] = p->surface_x[k], l->normal_y[k] = p->surface_y[k];
        l->normal_z[k] = p->surface_z[k];
        l->level[k] = rsv_lobe_level(roughness);
        l->tails[k] = rsv_lobe_tails(roughness);
        l->spot[k] = (1 - l->tails[k]) * rsv_lobe_above(height, cos, alpha);
        l->weight[k] = l->luma[k] = l->orange[k] = l->green[k] = 0;
    }
}

static void finish(const lobe_lanes *l, rsv_directional_packet *p)
{
    for (int k = 0; k < LANES; k++) {
        float scale = l->weight[k] > 0 ? 1 / l->weight[k] : 0;
        float y = scale * l->luma[k], co = scale * 2 * l->orange[k], cg = scale * l->green[k];
        p->red[k] = f_max(y + co - cg, 0);
        p->green[k] = f_max(y + cg, 0);
        p->blue[k] = f_max(y - co - cg, 0);
    }
}

static void look_up_lanes(const rsv_directional *d, uint32_t lanes, rsv_directional_packet *p)
{
    look_up u;
    u.directional = d;
    u.batch.count = 0;
    set_lanes(p, &u.lanes);
    for (uint32_t lane = 0; lane < lanes; lane++)
        for (int k = 0; k < 3; k++)
            add_node(&u, p->node[k][lane], p->weight[k][lane], lane);
    if (u.batch.count) look_up_batch(&u.batch, &u.lanes);
    finish(&u.lanes, p);
}

const rsv_look_up_kernels RSV_KERNELS = { look_up_lanes };
