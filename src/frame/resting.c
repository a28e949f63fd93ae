#include "resting.h"

#include <string.h>

/// Frames in which every other block takes a path: fewer, so that moving on is not delayed.
#define FIRST_FRAMES 64
/// Standard error that a correction may have, as a share of what is shown. Half as much comes through at most.
#define ALLOWED_ERROR 0.01f
/// What is shown counts as at least this share of what larger squares show.
#define LEAST_SHOWN 0.1f

static float luminance(const float *c) { return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]; }

int rsv_resting_lane(uint32_t samples, uint32_t block)
{
    if (samples <= FIRST_FRAMES && (samples + block) % 2) return -1;
    return (int)(rsv_hash2(block, samples) & 15);
}

static void add_difference(rsv_resting_tile *tile, uint32_t pixel, const float difference[3])
{
    float y = luminance(difference);
    if (!isfinite(y)) return;
    for (int c = 0; c < 3; c++)
        tile->difference[pixel][c] += difference[c];
    tile->difference[pixel][3] += 1;
    tile->square[pixel] += y * y;
}

void rsv_resting_add(
    rsv_resting_tile *tile, const rsv_resting_paths *paths, const float (*radiance)[4])
{
    for (uint32_t k = 0; k < paths->count; k++) {
        const float *path = paths->radiance[k], *frame = radiance[paths->pixel[k]];
        const float difference[3] = { path[0] - frame[0], path[1] - frame[1], path[2] - frame[2] };
        add_difference(tile, paths->pixel[k], difference);
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

/// Of one sample, around the mean of all; few samples say little of their mean.
static float variance_of(const node *n)
{
    float count = n->difference[3];
    if (count == 0) return 0;
    float mean = luminance(n->difference) / count;
    return f_max(n->square / count - (1 - 4 / (count + 4)) * mean * mean, 0);
}

/// How much of a correction a square takes that is darker or brighter than the larger one: as much more or less, unless
/// hardly anything was shown.
static float taken(const node *n, const rsv_resting_given *g)
{
    float known = fabsf(luminance(g->correction)) + 1e-30f;
    return f_min((mean_shown(n) + known) / (g->shown + known), 2);
}

/// What a square makes of what it is given, times `scale`: a share of what its own samples say beyond that.
/// The variance is that of a larger square: its own would be least where bright paths happen to be missing.
static void correct(const node *n, float scale, rsv_resting_given *g)
{
    float count = n->difference[3], shown = mean_shown(n);
    float allowed = ALLOWED_ERROR * f_max(shown, LEAST_SHOWN * g->shown), a2 = allowed * allowed;
    float share = count > 0 ? a2 / (a2 + g->variance / count + 1e-30f) : 0;
    for (int c = 0; c < 3; c++) {
        g->correction[c] *= scale;
        if (count > 0) g->correction[c] += share * (n->difference[c] / count - g->correction[c]);
    }
    g->shown = shown;
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

/// From squares to those that they consist of. @param from [larger] @param to [smaller] out
static void hand_down(
    const grid *larger, const rsv_resting_given *from, const grid *smaller, rsv_resting_given *to)
{
    for (int y = 0; y < smaller->height; y++)
        for (int x = 0; x < smaller->width; x++) {
            rsv_resting_given *own = &to[y * smaller->width + x];
            *own = from[y / 2 * larger->width + x / 2];
            float scale = taken(at(smaller, x, y), own) * evened(smaller, x / 2, y / 2, own);
            correct(at(smaller, x, y), scale, own);
            own->variance = variance_of(at(larger, x / 2, y / 2));
        }
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
        to[k].shown = open ? f_max(luminance(shown[k]), 0) : 0;
        to[k].pixels = open;
    }
}

void rsv_resting_correct(const rsv_resting_tile *tile, float (*shown)[4], node *sum)
{
    node nodes[NODES];
    rsv_resting_given given[2][RSV_RESTING_PIXELS];
    grid level[LEVELS] = { { nodes, RSV_RESTING_SIDE, RSV_RESTING_SIDE } };
    set_pixels(tile, (const float(*)[4])shown, nodes);
    for (int k = 1; k < LEVELS; k++)
        level[k] =
            unite(&level[k - 1], level[k - 1].node + level[k - 1].width * level[k - 1].width);
    if (sum) *sum = *level[LEVELS - 1].node;
    given[(LEVELS - 1) & 1][0] = tile->given;
    for (int k = LEVELS - 2; k >= 0; k--)
        hand_down(&level[k + 1], given[(k + 1) & 1], &level[k], given[k & 1]);
    for (int k = 0; k < RSV_RESTING_PIXELS; k++)
        for (int c = 0; c < 3 && nodes[k].pixels > 0; c++)
            shown[k][c] += given[0][k].correction[c];
}

// ---- all tiles ----------------------------------------------------------------------------------

enum { MOST_LEVELS = 17 };

/// The whole picture is right in the mean: so many samples have hardly any error.
static rsv_resting_given given_by_all(const node *all)
{
    rsv_resting_given g = { .variance = variance_of(all), .shown = mean_shown(all) };
    float count = all->difference[3];
    for (int c = 0; c < 3 && count > 0; c++)
        g.correction[c] = all->difference[c] / count;
    return g;
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
    for (size_t k = 0; k < count; k++)
        tile[k].given = from[k];
}
