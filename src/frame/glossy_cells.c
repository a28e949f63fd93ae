#include "glossy_cells.h"

#include "../core/core.h"

#include <string.h>

/// Samples that count while the camera moves, and at rest.
#define MOST_MOVING 48
#define MOST_RESTING 4096
/// Frames that poor cells wait for their turn at most.
#define MOST_POOR_TURN 4
/// Cells for each ray that poor ones may send in a frame.
#define POOR_CELLS_PER_RAY 16

enum { PLANES = 2 * 8 + 5 * 5 };

/// Hands out planes one after the other.
static float *next_plane(rsv_glossy_cells *c, size_t size, uint32_t *index)
{
    return c->memory + size * (*index)++;
}

static void place_geometry(rsv_glossy_cells *c, size_t size, uint32_t *k, rsv_glossy_geometry *g)
{
    float **plane[8] = { &g->x, &g->y, &g->z, &g->depth, &g->nx, &g->ny, &g->nz, &g->alpha };
    for (int n = 0; n < 8; n++)
        *plane[n] = next_plane(c, size, k);
}

static void place_light(rsv_glossy_cells *c, size_t size, uint32_t *k, rsv_glossy_light *l)
{
    float **plane[5] = { &l->r, &l->g, &l->b, &l->count, &l->reach };
    for (int n = 0; n < 5; n++)
        *plane[n] = next_plane(c, size, k);
}

/// @param width, height of the picture @return cells of a plane
static size_t lay_out(rsv_glossy_cells *c, uint32_t width, uint32_t height)
{
    c->width = (width + 1) / 2;
    c->height = (height + 1) / 2;
    c->stride = (c->width + 15) / 16 * 16 + 32; // tiles reach beyond the picture
    c->first = (size_t)RSV_GLOSSY_MARGIN * c->stride + 16;
    return (size_t)c->stride * ((c->height + 15) / 16 * 16 + 2 * RSV_GLOSSY_MARGIN);
}

rsv_status rsv_glossy_cells_create(
    rsv_context *context, uint32_t width, uint32_t height, rsv_glossy_cells *c)
{
    uint32_t k = 0;
    *c = (rsv_glossy_cells){ .context = context, .poor_turn = MOST_POOR_TURN };
    size_t size = lay_out(c, width, height);
    c->floats = size * PLANES;
    c->memory = rsv_alloc(context, c->floats, sizeof *c->memory);
    if (!c->memory) return RSV_ERROR_MEMORY;
    place_geometry(c, size, &k, &c->now);
    place_geometry(c, size, &k, &c->before);
    place_light(c, size, &k, &c->fresh);
    place_light(c, size, &k, &c->even);
    place_light(c, size, &k, &c->kept);
    place_light(c, size, &k, &c->kept_before);
    place_light(c, size, &k, &c->shown);
    return RSV_OK;
}

void rsv_glossy_cells_resize(rsv_glossy_cells *c, uint32_t width, uint32_t height)
{
    lay_out(c, width, height);
    memset(c->memory, 0, c->floats * sizeof *c->memory);
}

void rsv_glossy_cells_destroy(rsv_glossy_cells *c)
{
    if (c->context) rsv_free(c->context, c->memory);
    *c = (rsv_glossy_cells){ 0 };
}

void rsv_glossy_cells_begin(rsv_glossy_cells *c, const rsv_lens *lens, bool rests)
{
    rsv_glossy_geometry geometry = c->before;
    rsv_glossy_light kept = c->kept_before;
    c->before = c->now;
    c->now = geometry;
    c->kept_before = c->kept;
    c->kept = kept;
    c->lens_before = c->lens;
    c->lens = *lens;
    c->most = rests ? MOST_RESTING : MOST_MOVING;
    c->frame++;
}

void rsv_glossy_cells_pace(rsv_glossy_cells *c, uint64_t poor)
{
    uint64_t rays = (uint64_t)c->width * c->height / POOR_CELLS_PER_RAY + 1;
    c->poor_turn = 1;
    while (c->poor_turn < MOST_POOR_TURN && poor / c->poor_turn > rays)
        c->poor_turn *= 2;
}

void rsv_glossy_cells_forget(rsv_glossy_cells *c, float change)
{
    c->keep *= f_max(1 - 16 * change, 0);
    if (change > 0) c->poor_turn = MOST_POOR_TURN; // many cells may be
}
