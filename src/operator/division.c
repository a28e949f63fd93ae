#include "division.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "../elements/voxels.h"

#include <stdlib.h>
#include <string.h>

#define BITS 20 ///< of each coordinate

typedef struct place {
    uint64_t key;
    uint32_t node;
} place;

/// Index along Hilbert's curve of a point of a grid of 2^BITS cells a side: the transpose of the index by exchanges and
/// inversions, then Gray decoded (Skilling 2004, "Programming the Hilbert curve").
static uint64_t hilbert_index(uint32_t x[3])
{
    for (uint32_t bit = 1u << (BITS - 1); bit > 1; bit >>= 1) {
        uint32_t below = bit - 1;
        for (int k = 0; k < 3; k++) {
            uint32_t swap = (x[0] ^ x[k]) & below;
            if (x[k] & bit)
                x[0] ^= below;
            else
                x[0] ^= swap, x[k] ^= swap;
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    uint32_t parity = 0;
    for (uint32_t bit = 1u << (BITS - 1); bit > 1; bit >>= 1)
        if (x[2] & bit) parity ^= bit - 1;
    uint64_t index = 0;
    for (int bit = BITS - 1; bit >= 0; bit--)
        for (int k = 0; k < 3; k++)
            index = index << 1 | ((x[k] ^ parity) >> bit & 1);
    return index;
}

static rsv_vec3 node_position(const rsv_elements *e, uint32_t node)
{
    size_t surface_nodes = rsv_elements_surface_nodes(e);
    if (node >= surface_nodes) return rsv_voxel_centre(e->voxels, node - (uint32_t)surface_nodes);
    uint32_t face;
    float u, v;
    rsv_elements_place_node(e, node, &face, &u, &v);
    return rsv_surface_point_at(e->scene, e->face_triangle[face], u, v, e->face_back[face])
        .position;
}

static uint32_t grid_step(float x, float low, float extent)
{
    float share = extent > 0 ? f_min(f_max((x - low) / extent, 0), 1) : 0;
    return (uint32_t)(share * (float)((1u << BITS) - 1));
}

/// Nodes at one place keep their order.
static int compare_places(const void *left, const void *right)
{
    const place *a = left, *b = right;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->node > b->node) - (a->node < b->node);
}

typedef struct curve {
    const rsv_elements *elements;
    place *places; ///< [node_count]
} curve;

static void place_nodes(void *job, rsv_span span)
{
    const curve *c = job;
    const rsv_elements *e = c->elements;
    rsv_vec3 low = e->scene->bounds_min, high = e->scene->bounds_max;
    float extent = f_max(f_max(high.x - low.x, high.y - low.y), high.z - low.z);
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        rsv_vec3 p = node_position(e, n);
        uint32_t step[3] = { grid_step(p.x, low.x, extent), grid_step(p.y, low.y, extent),
            grid_step(p.z, low.z, extent) };
        c->places[n] = (place){ hilbert_index(step), n };
    }
}

static void walk_curve(const rsv_elements *e, place *places)
{
    curve c = { e, places };
    rsv_parallel_for(e->context, e->node_count, 0, place_nodes, &c);
    qsort(places, e->node_count, sizeof *places, compare_places);
}

rsv_status rsv_division_create(const rsv_elements *e, rsv_division **division)
{
    rsv_context *context = e->context;
    rsv_status status = RSV_OK;
    place *places = rsv_alloc(context, e->node_count, sizeof *places);
    rsv_division *d = rsv_alloc(context, 1, sizeof *d);
    if (!places || !d) {
        rsv_free(context, d);
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    *division = d;
    d->context = context;
    d->node_count = e->node_count;
    d->order = rsv_alloc(context, e->node_count, sizeof *d->order);
    d->cost = rsv_alloc(context, e->node_count, sizeof *d->cost);
    if (!d->order || !d->cost) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    walk_curve(e, places);
    for (size_t k = 0; k < e->node_count; k++)
        d->order[k] = places[k].node;
cleanup:
    rsv_free(context, places);
    return status;
}

void rsv_division_destroy(rsv_division *d)
{
    if (!d) return;
    rsv_free(d->context, d->order);
    rsv_free(d->context, d->begin);
    rsv_free(d->context, d->row_begin);
    rsv_free(d->context, d->cost);
    rsv_free(d->context, d);
}

static void count_rows(rsv_division *d)
{
    size_t rows = 0;
    for (uint32_t part = 0; part < d->part_count; part++) {
        d->row_begin[part] = rows;
        for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
            rows += d->cost[d->order[k]] > 0;
    }
    d->row_begin[d->part_count] = rows;
}

rsv_status rsv_division_cut(rsv_division *d, uint32_t part, uint32_t part_count)
{
    rsv_free(d->context, d->begin);
    rsv_free(d->context, d->row_begin);
    d->begin = rsv_alloc(d->context, (size_t)part_count + 1, sizeof *d->begin);
    d->row_begin = rsv_alloc(d->context, (size_t)part_count + 1, sizeof *d->row_begin);
    if (!d->begin || !d->row_begin) return RSV_ERROR_MEMORY;
    d->part = part;
    d->part_count = part_count;
    double total = 0, sum = 0;
    for (size_t n = 0; n < d->node_count; n++)
        total += (double)d->cost[n];
    uint32_t cut = 1;
    for (size_t k = 0; k < d->node_count; k++) {
        // a row belongs to the part in which the middle of its cost lies
        double half = 0.5 * (double)d->cost[d->order[k]];
        for (; cut < part_count && sum + half > total * cut / part_count; cut++)
            d->begin[cut] = k;
        sum += 2 * half;
    }
    for (; cut <= part_count; cut++)
        d->begin[cut] = d->node_count;
    count_rows(d);
    return RSV_OK;
}

size_t rsv_division_step(size_t count)
{
    size_t step = (size_t)(0.618033988749895 * (double)count) + 1; // the golden section
    for (;; step++) {
        size_t a = step, b = count; // Euclid: no common divisor
        while (b != 0) {
            size_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a <= 1 || count == 0) return step;
    }
}

/// Colours, which are most of what is shared, at once; all else by the library.
static void copy_item(char *to, const char *from, size_t bytes)
{
    if (bytes == sizeof(rsv_rgb))
        memcpy(to, from, sizeof(rsv_rgb));
    else
        memcpy(to, from, bytes);
}

/// Moves the items of a part's rows next to each other; or back from there.
static void move_part(
    const rsv_division *d, uint32_t part, char *items, char *packed, size_t bytes, bool unpack)
{
    size_t at = d->row_begin[part];
    for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++) {
        if (d->cost[d->order[k]] <= 0) continue;
        char *here = items + d->order[k] * bytes, *there = packed + at++ * bytes;
        copy_item(unpack ? here : there, unpack ? there : here, bytes);
    }
}

void rsv_division_share(const rsv_division *d, void *field, size_t item_bytes)
{
    rsv_team *team = d ? rsv_team_of(d->context) : NULL;
    if (!team) return;
    char *packed = rsv_reserve(d->context, d->node_count, item_bytes);
    if (rsv_team_meet(d->context, packed ? RSV_OK : RSV_ERROR_MEMORY) == RSV_OK && packed) {
        move_part(d, d->part, field, packed, item_bytes, false);
        team->table->share(team, packed, item_bytes, d->row_begin); // all have just met
        for (uint32_t part = 0; part < d->part_count; part++)
            if (part != d->part) move_part(d, part, field, packed, item_bytes, true);
    }
    rsv_free(d->context, packed);
}
