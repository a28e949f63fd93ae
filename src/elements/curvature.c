#include "curvature.h"

#include "../core/first_map.h"
#include "../core/parallel.h"
#include "elements_constants.h"

double rsv_elements_mean_luminance(const rsv_elements *e, const rsv_rgb *value)
{
    double sum = 0, area = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        sum += (double)rgb_luminance(value[n]) * e->node_area[n];
        area += e->node_area[n];
    }
    return area > 0 ? sum / area : 0;
}

#define NO_CELL UINT32_MAX

static uint64_t edge_key(uint32_t p, uint32_t q)
{
    return p < q ? (uint64_t)p << 32 | q : (uint64_t)q << 32 | p;
}

static uint64_t edge_of_cell(const rsv_elements *e, size_t cell, int k)
{
    return edge_key(e->cell_node[cell][(k + 1) % 3], e->cell_node[cell][(k + 2) % 3]);
}

/// Of more than two cells at an edge the last lies across from the first, and the first from all others. Any thread.
static void pair(_Atomic uint32_t *across, uint32_t first, uint32_t edge)
{
    uint32_t was = atomic_load_explicit(&across[first], memory_order_relaxed);
    atomic_store_explicit(&across[edge], first, memory_order_relaxed);
    while ((was == NO_CELL || was < edge) &&
           !atomic_compare_exchange_weak_explicit(
               &across[first], &was, edge, memory_order_relaxed, memory_order_relaxed)) {}
}

typedef struct partner_search {
    const rsv_elements *e;
    const uint8_t *cells;     ///< [cell_count] 0 = left out; NULL = none is
    _Atomic uint32_t *across; ///< [4 cell_count], out
    uint32_t *slot;           ///< [4 cell_count] of `edges`
    rsv_first_map edges;
} partner_search;

static bool is_left_out(const partner_search *s, size_t edge)
{
    return edge % 4 == 3 || (s->cells && !s->cells[edge / 4]);
}

static void note_edges(void *user, rsv_span span)
{
    partner_search *s = user;
    for (size_t edge = span.begin; edge < span.end; edge++) {
        atomic_init(&s->across[edge], NO_CELL);
        if (is_left_out(s, edge)) continue;
        uint64_t key = edge_of_cell(s->e, edge / 4, (int)(edge % 4));
        s->slot[edge] = rsv_first_map_note(&s->edges, key, (uint32_t)edge);
    }
}

static void pair_edges(void *user, rsv_span span)
{
    const partner_search *s = user;
    for (size_t edge = span.begin; edge < span.end; edge++) {
        if (is_left_out(s, edge)) continue;
        uint32_t first = s->edges.slot[s->slot[edge]].first;
        if (first != edge) pair(s->across, first, (uint32_t)edge);
    }
}

static size_t count_cells(const rsv_elements *e, const uint8_t *cells)
{
    size_t count = 0;
    for (size_t c = 0; cells && c < e->cell_count; c++)
        count += cells[c] != 0;
    return cells ? count : e->cell_count;
}

/// The neighbour across each edge.
/// @param cells [cell_count] 0 = omit; NULL = omit none
/// @param across [4 cell_count] out: by 4 * cell + corner opposite the edge, the same of the neighbour; NO_CELL at
/// borders and next to smaller or larger cells
static rsv_status find_partners(
    const rsv_elements *e, const uint8_t *cells, _Atomic uint32_t *across)
{
    rsv_status status;
    size_t count = 4 * e->cell_count;
    partner_search s = { .e = e, .cells = cells, .across = across };
    s.slot = rsv_reserve(e->context, count, sizeof *s.slot);
    RSV_TRY(s.slot ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_first_map_create(e->context, 3 * count_cells(e, cells), &s.edges));
    rsv_parallel_for(e->context, count, 0, note_edges, &s);
    rsv_parallel_for(e->context, count, 0, pair_edges, &s);
cleanup:
    rsv_first_map_destroy(&s.edges);
    rsv_free(e->context, s.slot);
    return status;
}

/// Luminance at an edge and at the corners opposite to it: where two equal cells make a parallelogram,
/// the sums agree on a plane.
typedef struct edge_values {
    float ends, opposite;
    float noise; ///< standard deviation of the difference between the two
} edge_values;

static edge_values values_at(
    const rsv_elements *e, const rsv_curvature_field *field, uint32_t edge, uint32_t across)
{
    const rsv_rgb *value = field->value;
    const float *deviation = field->deviation;
    const uint32_t *near = e->cell_node[edge / 4], *far = e->cell_node[across / 4];
    uint32_t k = edge % 4, p = near[(k + 1) % 3], q = near[(k + 2) % 3];
    uint32_t a = near[k], b = far[across % 4];
    edge_values v = { rgb_luminance(value[p]) + rgb_luminance(value[q]),
        rgb_luminance(value[a]) + rgb_luminance(value[b]), 0 };
    if (deviation)
        v.noise = sqrtf(deviation[p] * deviation[p] + deviation[q] * deviation[q] +
                        deviation[a] * deviation[a] + deviation[b] * deviation[b]);
    return v;
}

/// The part that noise does not explain, relative to the local level; 0 if there is none.
static float curvature_of(const edge_values *v, float floor)
{
    float level = 0.25f * (v->ends + v->opposite) + floor;
    float departure = fabsf(v->ends - v->opposite) - NOISE * v->noise;
    return departure > 0 && level > 0 ? departure / level : 0;
}

typedef struct curvature_job {
    const rsv_elements *e;
    const rsv_curvature_field *field;
    rsv_curved_edges places;
    _Atomic uint32_t *across; ///< [4 cell_count]
    float *curvature;         ///< [4 cell_count], zeros at first
} curvature_job;

static void measure_edges(void *user, rsv_span span)
{
    const curvature_job *job = user;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t edge = (uint32_t)k, across = job->across[k];
        bool border = across == NO_CELL && job->places == RSV_CURVED_EDGES_AND_BORDERS;
        if (job->field->cells && !job->field->cells[edge / 4]) continue;
        // an inner edge once, from its later side
        if (edge % 4 == 3 || (!border && across > edge)) continue;
        edge_values v = values_at(job->e, job->field, edge, border ? edge : across);
        job->curvature[edge] = curvature_of(&v, job->field->floor);
    }
}

rsv_status rsv_find_curved_edges(const rsv_elements *e, const rsv_curvature_field *field,
    rsv_curved_edges places, rsv_curved_edge_found found, void *user)
{
    rsv_status status;
    size_t count = 4 * e->cell_count;
    _Atomic uint32_t *across = rsv_reserve(e->context, count, sizeof *across);
    float *curvature = rsv_alloc(e->context, count, sizeof *curvature);
    RSV_TRY(across && curvature ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(find_partners(e, field->cells, across));
    curvature_job job = { e, field, places, across, curvature };
    rsv_parallel_for(e->context, count, 0, measure_edges, &job);
    for (uint32_t edge = 0; edge < count; edge++)
        if (curvature[edge] > field->threshold)
            found(user, edge / 4, (across[edge] == NO_CELL ? edge : across[edge]) / 4,
                curvature[edge]);
cleanup:
    rsv_free(e->context, (void *)across);
    rsv_free(e->context, curvature);
    return status;
}
