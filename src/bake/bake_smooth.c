#include "bake_smooth.h"

#include "../core/parallel.h"
#include "../core/sampling.h"
#include "../core/vec.h"
#include "../elements/elements.h"
#include "bake_constants.h"

#include <stdlib.h>
#include <string.h>

/// Places for the nodes around one, most of them empty.
#define TABLE (4 * MOST_AROUND)

/// Nodes around one, the nearest by cells between them first.
typedef struct surrounding {
    uint32_t node[MOST_AROUND];
    uint32_t ring[MOST_AROUND];  ///< cells between
    float place[MOST_AROUND][2]; ///< on the tangent plane, metres
    uint32_t count;
    uint32_t table[TABLE]; ///< those nodes and 1 at places by their hashes; 0 = nothing
} surrounding;

typedef struct smoother {
    const rsv_elements *elements;
    const rsv_rgb *value; ///< [node_count]
    float *
        departure; ///< [node_count] from the plane of those around; luminance, of noise of deviation 1 as large as that
    float *deviation; ///< [node_count] of noise
    rsv_rgb *smooth;  ///< [node_count] out
} smoother;

/// A plane's value at the middle of a surrounding, as a sum over its nodes.
typedef struct plane_fit {
    float weight[MOST_AROUND];
    float variance; ///< of the sum, that of one node being 1
} plane_fit;

// ---- neighbours -----------------------------------------------------------------------------------

/// Adds a node to a surrounding's table. @return false = it was there
static bool note_node(surrounding *s, uint32_t node)
{
    uint32_t at = rsv_hash2(node, 0) % TABLE;
    while (s->table[at] != 0 && s->table[at] != node + 1)
        at = (at + 1) % TABLE;
    bool fresh = s->table[at] == 0;
    s->table[at] = node + 1;
    return fresh;
}

/// Of a surface, and by itself.
static bool is_free(const rsv_elements *e, uint32_t node)
{
    return e->node_hanging[node] == RSV_NONE && e->node_face[node] != RSV_NONE;
}

static void add_neighbours(const rsv_elements *e, uint32_t of, surrounding *s)
{
    uint32_t node = s->node[of];
    for (uint32_t c = e->support_begin[node]; c < e->support_begin[node + 1]; c++)
        for (int k = 0; k < 3; k++) {
            uint32_t other = e->cell_node[e->support[c] / 4][k];
            if (s->count == MOST_AROUND || !note_node(s, other)) continue;
            s->ring[s->count] = s->ring[of] + 1;
            s->node[s->count++] = other;
        }
}

static void find_surrounding(const rsv_elements *e, uint32_t node, surrounding *s)
{
    s->count = 1;
    s->node[0] = node;
    s->ring[0] = 0;
    memset(s->table, 0, sizeof s->table);
    note_node(s, node);
    for (uint32_t k = 0; k < s->count && s->ring[k] < FIT_RINGS; k++)
        add_neighbours(e, k, s);
    rsv_surface_point middle = rsv_elements_node_point(e->scene, e, node);
    rsv_vec3 x, y;
    v3_frame(middle.geometric, &x, &y);
    for (uint32_t k = 0; k < s->count; k++) {
        rsv_vec3 way =
            v3_sub(rsv_elements_node_point(e->scene, e, s->node[k]).position, middle.position);
        s->place[k][0] = v3_dot(way, x);
        s->place[k][1] = v3_dot(way, y);
    }
}

// ---- planes ---------------------------------------------------------------------------------------

/// Solves the symmetric A c = (1, 0, 0). @param a xx, in the order 00 01 02 11 12 22 @return whether it could be
static bool solve(const double a[6], double c[3])
{
    double m0 = a[3] * a[5] - a[4] * a[4], m1 = a[2] * a[4] - a[1] * a[5],
           m2 = a[1] * a[4] - a[2] * a[3];
    double det = a[0] * m0 + a[1] * m1 + a[2] * m2;
    if (!(det > 1e-9 * a[0] * a[3] * a[5])) return false;
    c[0] = m0 / det, c[1] = m1 / det, c[2] = m2 / det;
    return true;
}

/// A plane through the nodes of the first rings. @param skip the node in the middle
static bool fit(
    const rsv_elements *e, const surrounding *s, uint32_t rings, bool skip, plane_fit *f)
{
    double a[6] = { 0 }, c[3];
    float w[MOST_AROUND];
    for (uint32_t k = 0; k < s->count; k++) {
        bool counts = s->ring[k] <= rings && is_free(e, s->node[k]) && !(skip && k == 0);
        w[k] = counts ? 1 - (float)s->ring[k] / (float)(rings + 1) : 0;
        double x = (double)s->place[k][0], y = (double)s->place[k][1], weight = (double)w[k];
        a[0] += weight, a[1] += weight * x, a[2] += weight * y;
        a[3] += weight * x * x, a[4] += weight * x * y, a[5] += weight * y * y;
    }
    if (!solve(a, c)) return false;
    f->variance = 0;
    for (uint32_t k = 0; k < s->count; k++) {
        f->weight[k] =
            w[k] * (float)(c[0] + c[1] * (double)s->place[k][0] + c[2] * (double)s->place[k][1]);
        f->variance += f->weight[k] * f->weight[k];
    }
    return true;
}

static rsv_rgb value_of(const smoother *q, const surrounding *s, const plane_fit *f)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < s->count; k++)
        if (f->weight[k] != 0) sum = rgb_mad(sum, f->weight[k], q->value[s->node[k]]);
    return sum;
}

// ---- noise ----------------------------------------------------------------------------------------

static void find_departure(smoother *q, uint32_t node)
{
    surrounding s;
    plane_fit f;
    q->departure[node] = -1; // unknown
    if (!is_free(q->elements, node)) return;
    find_surrounding(q->elements, node, &s);
    if (!fit(q->elements, &s, 1, true, &f) || f.variance > 1) return;
    float off = rgb_luminance(rgb_sub(q->value[node], value_of(q, &s, &f)));
    q->departure[node] = fabsf(off) / sqrtf(1 + f.variance);
}

static int compare(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// By the median of departures around, which an edge of light that runs by does not raise.
static void find_deviation(smoother *q, uint32_t node)
{
    surrounding s;
    float known[MOST_AROUND];
    size_t count = 0;
    q->deviation[node] = 0;
    if (!is_free(q->elements, node)) return;
    find_surrounding(q->elements, node, &s);
    for (uint32_t k = 0; k < s.count; k++)
        if (q->departure[s.node[k]] >= 0) known[count++] = q->departure[s.node[k]];
    if (count < LEAST_DEPARTURES) return;
    qsort(known, count, sizeof *known, compare);
    q->deviation[node] = DEVIATION_BY_MEDIAN * known[count / 2];
}

// ---- smoothing ------------------------------------------------------------------------------------

static rsv_rgb smooth_node(const smoother *q, uint32_t node)
{
    surrounding s;
    plane_fit f;
    rsv_rgb best = q->value[node];
    float own = rgb_luminance(best), deviation = CONFIDENCE * q->deviation[node];
    float low = own - deviation, high = own + deviation;
    if (!(deviation > 0)) return best;
    find_surrounding(q->elements, node, &s);
    for (uint32_t rings = 1; rings <= FIT_RINGS; rings++) {
        if (!fit(q->elements, &s, rings, false, &f)) continue;
        rsv_rgb value = value_of(q, &s, &f);
        float half = deviation * sqrtf(f.variance), luminance = rgb_luminance(value);
        low = f_max(low, luminance - half);
        high = f_min(high, luminance + half);
        if (low > high) break;
        best = rgb_positive(value);
    }
    return best;
}

static void find_departures(void *job, rsv_span span)
{
    for (size_t n = span.begin; n < span.end; n++)
        find_departure(job, (uint32_t)n);
}

static void find_deviations(void *job, rsv_span span)
{
    for (size_t n = span.begin; n < span.end; n++)
        find_deviation(job, (uint32_t)n);
}

static void smooth_nodes(void *job, rsv_span span)
{
    const smoother *q = job;
    for (size_t n = span.begin; n < span.end; n++) {
        bool free = is_free(q->elements, (uint32_t)n);
        q->smooth[n] = free ? smooth_node(q, (uint32_t)n) : q->value[n];
    }
}

static rsv_status run(smoother *q, rsv_context *context)
{
    size_t nodes = q->elements->node_count;
    rsv_parallel_for(context, nodes, 256, find_departures, q);
    rsv_parallel_for(context, nodes, 256, find_deviations, q);
    rsv_parallel_for(context, nodes, 256, smooth_nodes, q);
    rsv_elements_constrain(q->elements, q->smooth);
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

rsv_status rsv_bake_smooth_create(const rsv_light_view *s, rsv_bake_smooth *smooth)
{
    rsv_context *context = s->context;
    rsv_status status = RSV_ERROR_MEMORY;
    size_t nodes = s->elements->node_count;
    *smooth = (rsv_bake_smooth){ .context = context, .view = *s };
    rsv_rgb *sum = rsv_alloc(context, nodes, sizeof *sum);
    smoother q = { .elements = s->elements, .value = sum };
    q.departure = rsv_alloc(context, nodes, sizeof *q.departure);
    q.deviation = rsv_alloc(context, nodes, sizeof *q.deviation);
    smooth->indirect = rsv_alloc(context, nodes, sizeof *smooth->indirect);
    smooth->gathered = rsv_alloc(context, nodes, sizeof *smooth->gathered); // zeros
    q.smooth = smooth->indirect;
    if (sum && q.departure && q.deviation && smooth->indirect && smooth->gathered) {
        for (size_t n = 0; n < nodes; n++)
            sum[n] = rgb_add(s->indirect[n], s->gathered[n]);
        status = run(&q, context);
        smooth->view.indirect = smooth->indirect;
        smooth->view.gathered = smooth->gathered;
    }
    rsv_free(context, sum);
    rsv_free(context, q.departure);
    rsv_free(context, q.deviation);
    return status;
}

void rsv_bake_smooth_destroy(rsv_bake_smooth *smooth)
{
    if (!smooth->context) return;
    rsv_free(smooth->context, smooth->indirect);
    rsv_free(smooth->context, smooth->gathered);
    *smooth = (rsv_bake_smooth){ .context = NULL };
}
