#include "resting.h"

#include <string.h>

/// Paths of a block and frame in the mean: fewer at first, so that moving on is not delayed.
#define FIRST_PATHS 0.5f
#define FIRST_FRAMES 8
#define LATER_PATHS 1.0f
/// Minimum fraction for a block, because little may be known of it.
#define LEAST_PATHS 0.25f
/// Degrees of freedom that the variance in a larger square counts for in those within.
#define GIVEN_FREEDOM 4.0f
/// Standard errors by which the signal of squares must exceed noise.
#define CERTAINTY 2.0f
/// Samples of a square that count as few: its correction comes bit by bit, so that pictures do not flicker.
#define FEW_SAMPLES 12.0f
/// Lower limit of displayed light, relative to that of larger squares.
#define LEAST_SHOWN 0.1f

static float luminance(const float *c) { return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]; }

// ---- paths --------------------------------------------------------------------------------------

void rsv_resting_begin(rsv_resting_tile *tile, uint32_t seed)
{
    memset(tile, 0, sizeof *tile);
    tile->rate = FIRST_PATHS;
    for (uint32_t k = 0; k < RSV_RESTING_BLOCKS; k++) {
        tile->noise[k] = 1;
        tile->due[k] = rsv_unit_float(rsv_hash2(seed, k));
    }
}

static float mean_paths(const rsv_resting_tile *tile)
{
    return tile->frames < FIRST_FRAMES ? FIRST_PATHS : LATER_PATHS;
}

/// Paths of a block and frame, in the mean over frames.
static float rate_of(const rsv_resting_tile *tile, uint32_t block)
{
    float wanted = f_max(tile->rate * tile->noise[block], LEAST_PATHS * mean_paths(tile));
    return f_min(wanted, RSV_RESTING_BLOCK_PATHS);
}

uint32_t rsv_resting_turns(rsv_resting_tile *tile, uint32_t block)
{
    tile->due[block] += rate_of(tile, block);
    uint32_t turns = (uint32_t)f_min(tile->due[block], RSV_RESTING_BLOCK_PATHS);
    tile->due[block] -= (float)turns;
    return turns;
}

uint32_t rsv_resting_lane(rsv_resting_tile *tile, uint32_t block, uint32_t seed)
{
    // far from those just before (Bayer's order), and another first one for each block
    static const uint8_t order[16] = { 0, 10, 2, 8, 5, 15, 7, 13, 1, 11, 3, 9, 4, 14, 6, 12 };
    return order[tile->turns[block]++ & 15] ^ (rsv_hash(seed) & 15);
}

/// Samples count by one over how many are taken there, so that sums over squares are those of evenly spread ones.
static void add_difference(
    rsv_resting_tile *tile, uint32_t pixel, float weight, const float difference[3])
{
    float y = luminance(difference);
    if (!isfinite(y)) return;
    for (int c = 0; c < 3; c++)
        tile->difference[pixel][c] += weight * difference[c];
    tile->difference[pixel][3] += weight;
    tile->square[pixel] += weight * y * y;
    tile->weight_square[pixel] += weight * weight;
}

static uint32_t block_of(uint32_t pixel)
{
    return pixel / RSV_RESTING_SIDE / 4 * (RSV_RESTING_SIDE / 4) + pixel % RSV_RESTING_SIDE / 4;
}

void rsv_resting_add(
    rsv_resting_tile *tile, const rsv_resting_paths *paths, const float (*radiance)[4])
{
    for (uint32_t k = 0; k < paths->count; k++) {
        uint32_t pixel = paths->pixel[k];
        const float *path = paths->radiance[k], *frame = radiance[pixel];
        const float difference[3] = { path[0] - frame[0], path[1] - frame[1], path[2] - frame[2] };
        add_difference(tile, pixel, 1 / rate_of(tile, block_of(pixel)), difference);
    }
    for (int k = 0; k < RSV_RESTING_BLOCKS; k++)
        tile->open[k] |= paths->open[k];
}

// ---- squares of squares -------------------------------------------------------------------------

typedef rsv_resting_node node;

/// Nodes in rows.
typedef struct grid {
    node *node;
    int width, height;
} grid;

static node *at(const grid *g, int x, int y) { return &g->node[y * g->width + x]; }

static void add_node(const node *part, node *sum)
{
    for (int c = 0; c < 4; c++)
        sum->difference[c] += part->difference[c];
    sum->square += part->square;
    sum->weight_square += part->weight_square;
    sum->shown += part->shown;
    sum->pixels += part->pixels;
}

/// The sums of two by two; those at the border may have fewer parts.
static grid unite(const grid *parts, node *to)
{
    grid g = { to, (parts->width + 1) / 2, (parts->height + 1) / 2 };
    memset(to, 0, (size_t)g.width * (size_t)g.height * sizeof *to);
    for (int y = 0; y < parts->height; y++)
        for (int x = 0; x < parts->width; x++)
            add_node(at(parts, x, y), at(&g, x / 2, y / 2));
    return g;
}

static float mean_shown(const node *n) { return n->shown / f_max(n->pixels, 1); }

static float mean_difference(const node *n, int channel)
{
    return n->difference[channel] / n->difference[3];
}

/// Samples of equal weight that would say as much.
static float samples_of(const node *n)
{
    float weight = n->difference[3];
    return weight > 0 ? weight * weight / n->weight_square : 0;
}

/// Sum of squared deviations of samples from the mean of their square.
static float scatter_of(const node *n)
{
    float weight = n->difference[3];
    if (!(weight > 0)) return 0;
    float mean = luminance(n->difference) / weight;
    return samples_of(n) * f_max(n->square / weight - mean * mean, 0);
}

/// How much of a correction a square takes that is darker or brighter than the larger one: as much more or less, unless
/// hardly anything was shown.
static float taken(const node *n, const rsv_resting_given *g)
{
    float known = fabsf(luminance(g->correction)) + 1e-30f;
    return f_min((mean_shown(n) + known) / (g->shown + known), 2);
}

/// Factor by which the parts of a square together take as much as it was given.
static float evened(const grid *smaller, int x, int y, const rsv_resting_given *g)
{
    float pixels = 0, sum = 0;
    for (int k = 0; k < 4; k++) {
        int column = 2 * x + k % 2, row = 2 * y + k / 2;
        if (column >= smaller->width || row >= smaller->height) continue;
        const node *n = at(smaller, column, row);
        pixels += n->pixels;
        sum += n->pixels * taken(n, g);
    }
    return sum > 0 ? pixels / sum : 1;
}

/// Corrections of parts before their own samples count: in proportion to their light.
static void inherit(
    const grid *larger, const rsv_resting_given *from, const grid *smaller, rsv_resting_given *to)
{
    for (int y = 0; y < smaller->height; y++)
        for (int x = 0; x < smaller->width; x++) {
            const rsv_resting_given *g = &from[y / 2 * larger->width + x / 2];
            rsv_resting_given *own = &to[y * smaller->width + x];
            float scale = taken(at(smaller, x, y), g) * evened(smaller, x / 2, y / 2, g);
            *own = *g;
            for (int c = 0; c < 3; c++)
                own->correction[c] *= scale;
            own->shown = f_max(mean_shown(at(smaller, x, y)), LEAST_SHOWN * g->shown) + 1e-30f;
        }
}

/// Sums over up to 4x4 squares, relative to the light of each.
typedef struct pool {
    float samples, squares; ///< numbers of both; squares that have samples
    float between; ///< squares of the difference between their means and their inherited correction, by samples
    float scatter; ///< of samples around these means
} pool;

static void add_to_pool(const node *n, const rsv_resting_given *g, pool *p)
{
    float count = samples_of(n), relative = 1 / (g->shown * g->shown);
    if (count == 0) return;
    float beyond = luminance(n->difference) / n->difference[3] - luminance(g->correction);
    p->samples += count;
    p->squares += 1;
    p->between += count * beyond * beyond * relative;
    p->scatter += scatter_of(n) * relative;
}

/// A fraction of what a square's own samples say beyond its inherited correction: less if they are few, because these
/// may be far off. @param signal, variance of squares and of samples, relative
static void correct(const node *n, float signal, float variance, rsv_resting_given *g)
{
    float count = samples_of(n);
    g->variance = variance;
    if (count == 0 || !(signal > 0)) return;
    float few = f_max(count - 1, 0) / (count + FEW_SAMPLES);
    float share = few * signal / (signal + variance / count);
    for (int c = 0; c < 3; c++)
        g->correction[c] += share * (mean_difference(n, c) - g->correction[c]);
}

/// 4x4 squares at a time. @param given of each, in and out
static void correct_pool(const grid *g, int left, int top, rsv_resting_given *given)
{
    int right = left + 4 < g->width ? left + 4 : g->width;
    int bottom = top + 4 < g->height ? top + 4 : g->height;
    pool p = { 0 };
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++)
            add_to_pool(at(g, x, y), &given[y * g->width + x], &p);
    float known = given[top * g->width + left].variance;
    float freedom = p.samples - p.squares + GIVEN_FREEDOM;
    float variance = (p.scatter + GIVEN_FREEDOM * known) / freedom;
    float doubt = 1 + CERTAINTY * sqrtf(2 / f_max(p.squares, 1) + 2 / freedom);
    float signal = p.samples > 0 ? (p.between - doubt * p.squares * variance) / p.samples : 0;
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++)
            correct(at(g, x, y), signal, variance, &given[y * g->width + x]);
}

/// From squares to those that they consist of. @param from [larger] @param to [smaller] out
static void hand_down(
    const grid *larger, const rsv_resting_given *from, const grid *smaller, rsv_resting_given *to)
{
    inherit(larger, from, smaller, to);
    for (int y = 0; y < smaller->height; y += 4)
        for (int x = 0; x < smaller->width; x += 4)
            correct_pool(smaller, x, y, to);
    for (int y = 0; y < smaller->height; y++)
        for (int x = 0; x < smaller->width; x++)
            to[y * smaller->width + x].shown = mean_shown(at(smaller, x, y));
}

// ---- one tile -----------------------------------------------------------------------------------

enum { LEVELS = 6, NODES = 1365 }; ///< 32^2 + 16^2 + ... + 1

static bool is_open(const rsv_resting_tile *tile, int pixel)
{
    int x = pixel % RSV_RESTING_SIDE, y = pixel / RSV_RESTING_SIDE;
    return tile->open[y / 4 * (RSV_RESTING_SIDE / 4) + x / 4] >> (y % 4 * 4 + x % 4) & 1;
}

static void set_pixels(const rsv_resting_tile *tile, const float (*shown)[4], node *to)
{
    for (int k = 0; k < RSV_RESTING_PIXELS; k++) {
        bool open = is_open(tile, k);
        memcpy(to[k].difference, tile->difference[k], sizeof to[k].difference);
        to[k].square = tile->square[k];
        to[k].weight_square = tile->weight_square[k];
        to[k].shown = open ? f_max(luminance(shown[k]), 0) : 0;
        to[k].pixels = open;
    }
}

/// Room to work in.
typedef struct pyramid {
    node node[NODES];
    grid level[LEVELS];
    rsv_resting_given given[2][RSV_RESTING_PIXELS];
} pyramid;

static void build(const rsv_resting_tile *tile, const float (*shown)[4], pyramid *p)
{
    p->level[0] = (grid){ p->node, RSV_RESTING_SIDE, RSV_RESTING_SIDE };
    set_pixels(tile, shown, p->node);
    for (int k = 1; k < LEVELS; k++) {
        const grid *parts = &p->level[k - 1];
        p->level[k] = unite(parts, parts->node + parts->width * parts->width);
    }
    p->given[(LEVELS - 1) & 1][0] = tile->given;
    for (int k = LEVELS - 2; k >= 0; k--)
        hand_down(&p->level[k + 1], p->given[(k + 1) & 1], &p->level[k], p->given[k & 1]);
}

static void add_corrections(const pyramid *p, float (*shown)[4])
{
    for (int k = 0; k < RSV_RESTING_PIXELS; k++)
        for (int c = 0; c < 3 && p->node[k].pixels > 0; c++)
            shown[k][c] += p->given[0][k].correction[c];
}

void rsv_resting_correct(const rsv_resting_tile *tile, float (*shown)[4])
{
    pyramid p;
    build(tile, (const float(*)[4])shown, &p);
    add_corrections(&p, shown);
}

/// Of blocks of 4x4 pixels.
static void find_noise(const pyramid *p, rsv_resting_noise noise)
{
    for (int k = 0; k < RSV_RESTING_BLOCKS; k++) {
        int across = RSV_RESTING_SIDE / 4,
            first = k / across * 4 * RSV_RESTING_SIDE + k % across * 4;
        float variance = 0;
        for (int n = 0; n < 16; n++)
            variance += p->given[0][first + n / 4 * RSV_RESTING_SIDE + n % 4].variance;
        noise[k] = p->level[2].node[k].pixels * (1.0f / 64) * sqrtf(variance);
    }
}

void rsv_resting_update(rsv_resting_tile *tile, float (*shown)[4])
{
    pyramid p;
    build(tile, (const float(*)[4])shown, &p);
    add_corrections(&p, shown);
    tile->sum = *p.level[LEVELS - 1].node;
    find_noise(&p, tile->noise);
}

// ---- all tiles ----------------------------------------------------------------------------------

enum { MOST_LEVELS = 17 };

/// The mean of the whole picture is right: with so many samples, it has hardly any error.
static rsv_resting_given given_by_all(const node *all)
{
    rsv_resting_given g = { .shown = mean_shown(all) };
    float shown = g.shown + 1e-30f;
    g.variance = scatter_of(all) / (f_max(samples_of(all) - 1, 1) * shown * shown);
    for (int c = 0; c < 3 && samples_of(all) > 0; c++)
        g.correction[c] = mean_difference(all, c);
    return g;
}

/// Paths of the next frame, where noise is.
static void share_paths(rsv_resting_tile *tile, size_t count)
{
    double noise = 0;
    float blocks = 0;
    for (size_t k = 0; k < count; k++) {
        blocks += tile[k].sum.pixels * (1.0f / 16);
        for (int b = 0; b < RSV_RESTING_BLOCKS; b++)
            noise += (double)tile[k].noise[b];
    }
    for (size_t k = 0; k < count; k++)
        tile[k].rate = noise > 0 ? mean_paths(&tile[k]) * blocks / (float)noise : 0;
}

void rsv_resting_share(
    rsv_resting_tile *tile, uint32_t across, uint32_t down, node *nodes, rsv_resting_given *given)
{
    grid level[MOST_LEVELS] = { { nodes, (int)across, (int)down } };
    size_t count = (size_t)across * down;
    int top = 0;
    for (size_t k = 0; k < count; k++)
        nodes[k] = tile[k].sum;
    for (; level[top].width * level[top].height > 1; top++)
        level[top + 1] = unite(&level[top], level[top].node + level[top].width * level[top].height);
    rsv_resting_given *from = given, *to = given + count + 1;
    from[0] = given_by_all(level[top].node);
    for (int k = top - 1; k >= 0; k--) {
        hand_down(&level[k + 1], from, &level[k], to);
        rsv_resting_given *last = from;
        from = to;
        to = last;
    }
    for (size_t k = 0; k < count; k++) {
        tile[k].given = from[k];
        tile[k].frames++;
    }
    share_paths(tile, count);
}
