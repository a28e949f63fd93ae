#include "bake_stitch.h"

#include "../core/parallel.h"
#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_stitch_groups.h"

/// The four texels that filtering mixes at a point.
typedef struct footprint {
    size_t texel[4];
    float weight[4];
    float give[4];    ///< how readily each changes
    float compliance; ///< sum of give weight^2
    rsv_rgb shown;
} footprint;

static footprint footprint_of(const rsv_bake_map *map, const float point[2])
{
    footprint f = { .compliance = 0, .shown = { 0, 0, 0 } };
    uint32_t at[2];
    float part[2];
    rsv_bake_map_locate(map, point, at, part);
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t right = k & 1, below = k >> 1;
        f.texel[k] = (size_t)(at[1] + below) * map->width + at[0] + right;
        f.weight[k] = (right ? part[0] : 1 - part[0]) * (below ? part[1] : 1 - part[1]);
        f.give[k] = map->distance[f.texel[k]] > 0 ? 1 : STIFFNESS;
        f.compliance += f.give[k] * f.weight[k] * f.weight[k];
        f.shown = rgb_mad(f.shown, f.weight[k], map->light[f.texel[k]]);
    }
    return f;
}

static rsv_rgb lit(rsv_rgb light) { return rgb_positive(light); }

/// One step of Kaczmarz's method (1937): sets a point to the solved light, by the smallest change of texels.
static void show_truly(rsv_bake_map *map, const float point[2], rsv_rgb solved)
{
    footprint f = footprint_of(map, point);
    rsv_rgb more = rgb_sub(solved, f.shown);
    for (int k = 0; k < 4; k++) {
        rsv_rgb *light = &map->light[f.texel[k]];
        *light = lit(rgb_mad(*light, f.give[k] * f.weight[k] / f.compliance, more));
    }
}

/// The brightness to which a jump is relative.
static float brightness(const rsv_bake_map *map, const rsv_bake_stitch *stitch, rsv_rgb *jump)
{
    rsv_rgb a = rsv_bake_map_lookup(map, stitch->point[0]);
    rsv_rgb b = rsv_bake_map_lookup(map, stitch->point[1]);
    if (jump) *jump = rgb_sub(b, a);
    return f_max(stitch->least, 0.5f * rgb_max(rgb_add(a, b)));
}

double rsv_bake_jump(const rsv_bake_map *map, const rsv_bake_stitch *stitch)
{
    rsv_rgb jump;
    float against = brightness(map, stitch, &jump);
    return (double)(f_max(fabsf(jump.r), f_max(fabsf(jump.g), fabsf(jump.b))) / against);
}

static double largest_jump(const rsv_bake_map *map, const rsv_bake_stitch *stitch, size_t count)
{
    double most = 0;
    for (size_t k = 0; k < count; k++)
        most = fmax(most, rsv_bake_jump(map, &stitch[k]));
    return most;
}

// ---- drawing both sides together ------------------------------------------------------------------

/// Relative jumps as a linear map of the texels: row k is the value of its second side minus that of its first. For one
/// group, or for all, one after the other.
typedef struct jumps {
    const rsv_bake_stitch *stitch; ///< [count]
    size_t count, texel_count;
    uint32_t (*texel)[8]; ///< [count] among those that any stitch touches
    float (*weight)[8];   ///< [count] filtering over brightness, times the root of the texel's give
    size_t *place;        ///< [texel_count] in the map
    float *root;          ///< [texel_count] of the texel's give
    // of the iteration
    rsv_rgb *jump, *change;        ///< [count]: the remaining jumps, and their change by a step
    rsv_rgb *step, *slope, *moved; ///< [texel_count]
} jumps;

static void destroy_jumps(rsv_context *context, jumps *j)
{
    rsv_free(context, j->texel);
    rsv_free(context, j->weight);
    rsv_free(context, j->place);
    rsv_free(context, j->root);
    rsv_free(context, j->jump);
    rsv_free(context, j->change);
    rsv_free(context, j->step);
    rsv_free(context, j->slope);
    rsv_free(context, j->moved);
}

/// @param number [texels of the map] of those touched so far, plus one; 0 = none
/// @param first the first texel of the group that the row is of
static void add_side(
    jumps *j, const rsv_bake_map *map, uint32_t *number, uint32_t first, size_t row, uint32_t side)
{
    footprint f = footprint_of(map, j->stitch[row].point[side]);
    float factor = (side ? 1 : -1) / brightness(map, &j->stitch[row], NULL);
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t *own = &number[f.texel[k]];
        if (!*own) {
            j->place[j->texel_count] = f.texel[k];
            j->root[j->texel_count++] = sqrtf(f.give[k]);
            *own = (uint32_t)j->texel_count;
        }
        j->texel[row][4 * side + k] = *own - 1 - first;
        j->weight[row][4 * side + k] = factor * f.weight[k] * sqrtf(f.give[k]);
    }
}

static rsv_status create_jumps(
    rsv_context *context, const rsv_bake_map *map, const rsv_bake_stitch_groups *g, jumps *j)
{
    rsv_status status;
    size_t texels = (size_t)map->width * map->height, count = g->stitch_count,
           most = count < texels / 8 ? 8 * count : texels;
    uint32_t *number = rsv_alloc(context, texels, sizeof *number);
    *j = (jumps){ .stitch = g->stitch,
        .count = count,
        .texel = rsv_alloc(context, count, sizeof *j->texel),
        .weight = rsv_alloc(context, count, sizeof *j->weight),
        .place = rsv_alloc(context, most, sizeof *j->place),
        .root = rsv_alloc(context, most, sizeof *j->root),
        .jump = rsv_alloc(context, count, sizeof *j->jump),
        .change = rsv_alloc(context, count, sizeof *j->change),
        .step = rsv_alloc(context, most, sizeof *j->step),
        .slope = rsv_alloc(context, most, sizeof *j->slope),
        .moved = rsv_alloc(context, most, sizeof *j->moved) };
    RSV_TRY(number && j->texel && j->weight && j->place && j->root && j->jump && j->change &&
                    j->step && j->slope && j->moved
                ? RSV_OK
                : RSV_ERROR_MEMORY);
    for (size_t c = 0; c < g->count; c++) {
        g->first_texel[c] = (uint32_t)j->texel_count;
        for (size_t k = g->first_stitch[c]; k < g->first_stitch[c + 1]; k++)
            for (uint32_t side = 0; side < 2; side++)
                add_side(j, map, number, g->first_texel[c], k, side);
    }
    g->first_texel[g->count] = (uint32_t)j->texel_count;
cleanup:
    rsv_free(context, number);
    return status;
}

/// The part of one group.
static jumps jumps_of(const jumps *all, const rsv_bake_stitch_groups *g, size_t group)
{
    size_t k = g->first_stitch[group], t = g->first_texel[group];
    return (jumps){ .stitch = all->stitch + k,
        .count = g->first_stitch[group + 1] - k,
        .texel_count = g->first_texel[group + 1] - t,
        .texel = all->texel + k,
        .weight = all->weight + k,
        .place = all->place + t,
        .root = all->root + t,
        .jump = all->jump + k,
        .change = all->change + k,
        .step = all->step + t,
        .slope = all->slope + t,
        .moved = all->moved + t };
}

static double square(const rsv_rgb *v, size_t count)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += (double)(v[k].r * v[k].r + v[k].g * v[k].g + v[k].b * v[k].b);
    return sum;
}

static void apply(const jumps *j, const rsv_rgb *texel, rsv_rgb *jump)
{
    for (size_t k = 0; k < j->count; k++) {
        jump[k] = rgb_gray(0);
        for (int i = 0; i < 8; i++)
            jump[k] = rgb_mad(jump[k], j->weight[k][i], texel[j->texel[k][i]]);
    }
}

static void apply_transpose(const jumps *j, const rsv_rgb *jump, rsv_rgb *texel)
{
    for (size_t t = 0; t < j->texel_count; t++)
        texel[t] = rgb_gray(0);
    for (size_t k = 0; k < j->count; k++)
        for (int i = 0; i < 8; i++) {
            rsv_rgb *own = &texel[j->texel[k][i]];
            *own = rgb_mad(*own, j->weight[k][i], jump[k]);
        }
}

static void add_scaled(rsv_rgb *sum, float factor, const rsv_rgb *v, size_t count)
{
    for (size_t k = 0; k < count; k++)
        sum[k] = rgb_mad(sum[k], factor, v[k]);
}

/// Conjugate gradients for least squares (Hestenes and Stiefel 1952). @return whether more may come of it
static bool draw_together(jumps *j, double *slope)
{
    for (int k = 0; k<STEPS_PER_LOOK && * slope> 0; k++) {
        apply(j, j->step, j->change);
        double curvature = square(j->change, j->count), before = *slope;
        if (!(curvature > 0)) return false;
        float length = (float)(*slope / curvature);
        add_scaled(j->moved, length, j->step, j->texel_count);
        add_scaled(j->jump, -length, j->change, j->count);
        apply_transpose(j, j->jump, j->slope);
        *slope = square(j->slope, j->texel_count);
        for (size_t t = 0; t < j->texel_count; t++)
            j->step[t] = rgb_mad(j->slope[t], (float)(*slope / before), j->step[t]);
    }
    return *slope > 0;
}

static double largest_left(const jumps *j)
{
    float most = 0;
    for (size_t k = 0; k < j->count; k++)
        most = f_max(
            most, f_max(fabsf(j->jump[k].r), f_max(fabsf(j->jump[k].g), fabsf(j->jump[k].b))));
    return (double)most;
}

static void close_jumps(jumps *j, rsv_bake_map *map)
{
    for (size_t t = 0; t < j->texel_count; t++) {
        j->slope[t] = rgb_scale(map->light[j->place[t]], -1 / j->root[t]);
        j->moved[t] = rgb_gray(0);
    }
    apply(j, j->slope, j->jump);
    apply_transpose(j, j->jump, j->slope);
    for (size_t t = 0; t < j->texel_count; t++)
        j->step[t] = j->slope[t];
    double slope = square(j->slope, j->texel_count);
    for (int steps = 0; steps < MOST_STEPS && largest_left(j) > CLOSED; steps += STEPS_PER_LOOK)
        if (!draw_together(j, &slope)) break;
    for (size_t t = 0; t < j->texel_count; t++) {
        rsv_rgb *light = &map->light[j->place[t]];
        *light = lit(rgb_mad(*light, j->root[t], j->moved[t]));
    }
}

/// Makes those that are still open count for more: where not all can be closed, none stays far behind.
static void stress_open(jumps *j, const rsv_bake_map *map)
{
    for (size_t k = 0; k < j->count; k++)
        if (rsv_bake_jump(map, &j->stitch[k]) > CLOSED)
            for (int i = 0; i < 8; i++)
                j->weight[k][i] *= STRESS;
}

static void close_group(jumps j, rsv_bake_map *map)
{
    for (int round = 0; round < STITCH_ROUNDS && largest_jump(map, j.stitch, j.count) > CLOSED;
         round++) {
        close_jumps(&j, map);
        if (round < STRESSED_ROUNDS) stress_open(&j, map);
    }
}

/// Groups of stitches that share no texel.
typedef struct group_job {
    const jumps *jumps;
    const rsv_bake_stitch_groups *groups;
    rsv_bake_map *map;
} group_job;

static void close_groups(void *job, rsv_span span)
{
    const group_job *q = job;
    for (size_t c = span.begin; c < span.end; c++)
        close_group(jumps_of(q->jumps, q->groups, c), q->map);
}

rsv_status rsv_bake_stitch_up(rsv_context *context, const rsv_bake_stitch *stitch, size_t count,
    rsv_bake_map *map, double *largest)
{
    rsv_status status;
    rsv_bake_stitch_groups g = { 0 };
    jumps j = { 0 };
    *largest = largest_jump(map, stitch, count);
    if (*largest <= CLOSED) return RSV_OK;
    RSV_TRY(rsv_bake_stitch_groups_create(context, map, stitch, count, &g));
    for (int pass = 0; pass < TRUE_PASSES; pass++)
        for (size_t k = 0; k < count; k++) {
            show_truly(map, g.stitch[k].point[0], g.stitch[k].solved);
            show_truly(map, g.stitch[k].point[1], g.stitch[k].solved);
        }
    RSV_TRY(create_jumps(context, map, &g, &j));
    rsv_parallel_for(context, g.count, 1, close_groups, &(group_job){ &j, &g, map });
    *largest = largest_jump(map, stitch, count);
cleanup:
    destroy_jumps(context, &j);
    rsv_bake_stitch_groups_destroy(context, &g);
    return status;
}
