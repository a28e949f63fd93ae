#include "directional_map.h"

/// Sums of four cells each. @param side of the finer level
static void coarsen(uint32_t side, const rsv_cell4 *finer, rsv_cell4 *coarser)
{
    for (uint32_t j = 0; j < side; j += 2)
        for (uint32_t i = 0; i < side; i += 2) {
            const rsv_cell4 *first = finer + j * side + i;
            *coarser++ = first[0] + first[1] + (first[side] + first[side + 1]);
        }
}

/// Cells of no weight take what is around them.
static void fill(uint32_t side, const rsv_cell4 *coarser, rsv_cell4 *finer)
{
    for (uint32_t j = 0; j < side; j++)
        for (uint32_t i = 0; i < side; i++)
            if (!(finer[j * side + i][3] > 0))
                finer[j * side + i] = coarser[j / 2 * (side / 2) + i / 2];
}

static void find_levels(rsv_map_cells *m)
{
    rsv_cell4 *level[] = { m->cell, m->cell + 64, m->cell + 80, m->cell + 84 };
    bool complete = true;
    for (uint32_t k = 0; k < 3; k++)
        coarsen(8u >> k, level[k], level[k + 1]);
    for (uint32_t k = 0; k < RSV_DIRECTION_BINS; k++)
        complete &= m->cell[k][3] > 0;
    for (uint32_t k = 3; k-- > 0 && !complete;)
        fill(8u >> k, level[k + 1], level[k]);
}

#define PLANE (RSV_MAP_LUMA + 4) ///< the mean is the one after the levels

/// The three numbers of cells, each for itself, divided by the weights.
typedef struct map_planes {
    float luma[PLANE], orange[PLANE], green[PLANE];
} map_planes;

static void split(const rsv_map_cells *m, map_planes *p)
{
    float weight[PLANE];
    for (size_t k = 0; k < PLANE; k++) {
        p->luma[k] = m->cell[k][0], p->orange[k] = m->cell[k][1];
        p->green[k] = m->cell[k][2], weight[k] = m->cell[k][3];
    }
    for (size_t k = 0; k < PLANE; k++) {
        float scale = 1 / f_max(weight[k], 1e-20f);
        p->luma[k] *= scale, p->orange[k] *= scale, p->green[k] *= scale;
    }
}

static void encode_luma(const float *luma, float scale, uint8_t *code)
{
    for (size_t k = 0; k < RSV_MAP_LUMA; k++)
        code[k] = (uint8_t)(int32_t)(sqrtf(f_min(f_max(luma[k] * scale, 0), 1)) * 255 + 0.5f);
}

static int16_t mean_code(float share)
{
    return (int16_t)(int32_t)copysignf(f_min(fabsf(share), 1) * 32767 + 0.5f, share);
}

/// What the mean's colour leaves over. @param chroma, luma of the second level @param mean of both, as stored
static void encode_chroma(const float *chroma, const float *luma, float scale, const int16_t *mean,
    size_t part, int8_t (*code)[2])
{
    float ratio = rsv_map_ratio(mean[0], mean[1 + part]), value[RSV_MAP_CHROMA];
    for (size_t k = 0; k < RSV_MAP_CHROMA; k++) {
        float left = (chroma[k] - ratio * luma[k]) * (scale * (1 / RSV_MAP_CHROMA_RANGE));
        value[k] = copysignf(sqrtf(f_min(fabsf(left), 1)) * 127 + 0.5f, left);
    }
    for (size_t k = 0; k < RSV_MAP_CHROMA; k++)
        code[k][part] = (int8_t)(int32_t)value[k];
}

void rsv_directional_map_pack(rsv_map_cells *cells, rsv_directional_map *map)
{
    map_planes p;
    float largest = 0;
    find_levels(cells);
    split(cells, &p);
    for (size_t k = 0; k < RSV_DIRECTION_BINS; k++)
        largest = f_max(largest, p.luma[k]);
    // its reciprocal must be finite: less light than this is none
    map->scale = largest > 1e-30f ? largest : 0;
    if (!(map->scale > 0)) return;
    float scale = 1 / largest;
    encode_luma(p.luma, scale, map->luma);
    map->mean[0] = mean_code(p.luma[RSV_MAP_LUMA] * scale);
    map->mean[1] = mean_code(p.orange[RSV_MAP_LUMA] * scale);
    map->mean[2] = mean_code(p.green[RSV_MAP_LUMA] * scale);
    encode_chroma(p.orange + 64, p.luma + 64, scale, map->mean, 0, map->chroma);
    encode_chroma(p.green + 64, p.luma + 64, scale, map->mean, 1, map->chroma);
}
