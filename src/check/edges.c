/// Edges of an object's triangles, by the places of their ends: vertices that lie in the same place count as one.
#include "check_internal.h"

#include "../core/vec.h"

#include <stdlib.h>
#include <string.h>

/// Edges within this fraction of the object's size of each other were probably meant to be one.
#define SEAM 1e-4f
/// Neighbours along x that an edge is compared with at most: a heap of edges takes no quadratic time.
enum { MOST_COMPARED = 64 };

/// An edge from the smaller place to the larger one.
typedef struct edge {
    rsv_vec3 a, b;
    bool turned; ///< its triangle uses the opposite direction
} edge;

static int compare_edges(const void *p, const void *q)
{
    const edge *e = p, *f = q;
    int order = compare_places(e->a, f->a);
    if (!order) order = compare_places(e->b, f->b);
    return order ? order : (int)e->turned - (int)f->turned;
}

/// The edges of triangles, sorted. @param edges [3 * (end - first)] out
static void list_edges(const rsv_scene_view *view, size_t first, size_t end, edge *edges)
{
    edge *to = edges;
    for (size_t k = 3 * first; k < 3 * end; k++) {
        const uint32_t *corner = view->triangle[k / 3];
        rsv_vec3 from = view->position[corner[k % 3]], next = view->position[corner[(k + 1) % 3]];
        bool turned = compare_places(from, next) > 0;
        *to++ = (edge){ turned ? next : from, turned ? from : next, turned };
    }
    qsort(edges, 3 * (end - first), sizeof *edges, compare_edges);
}

static bool is_same_edge(const edge *e, const edge *f)
{
    return compare_places(e->a, f->a) == 0 && compare_places(e->b, f->b) == 0;
}

/// The sorted edges of an object, and their faults.
typedef struct object_edges {
    edge *border; ///< [border_count] those of a single triangle
    size_t border_count, inner, flipped;
    rsv_vec3 low, high;
} object_edges;

/// @param edges [count] of the object; the border moves to their beginning
static object_edges sort_out(edge *edges, size_t count)
{
    object_edges o = { .border = edges, .low = edges[0].a, .high = edges[0].a };
    for (size_t k = 0; k < count;) {
        size_t next = k + 1;
        while (next < count && is_same_edge(&edges[k], &edges[next]))
            next++;
        o.low = v3_min(o.low, v3_min(edges[k].a, edges[k].b));
        o.high = v3_max(o.high, v3_max(edges[k].a, edges[k].b));
        if (next - k == 2) {
            o.inner++;
            o.flipped += edges[k].turned == edges[k + 1].turned;
        }
        if (next - k == 1) o.border[o.border_count++] = edges[k];
        k = next;
    }
    return o;
}

static float distance(rsv_vec3 p, rsv_vec3 q) { return v3_max_abs(v3_sub(p, q)); }

/// Border edges that touch another edge without sharing it. Edges are sorted by the x of their start.
/// @param widest out: largest distance between such edges, metres
static size_t count_seams(const object_edges *o, float *widest)
{
    float reach = SEAM * v3_max_abs(v3_sub(o->high, o->low));
    size_t seams = 0;
    *widest = 0;
    for (size_t k = 0; k < o->border_count; k++) {
        const edge *e = &o->border[k];
        size_t last = k + MOST_COMPARED < o->border_count ? k + MOST_COMPARED : o->border_count;
        for (size_t i = k + 1; i < last && o->border[i].a.x - e->a.x <= reach; i++) {
            const edge *f = &o->border[i];
            float straight = f_max(distance(e->a, f->a), distance(e->b, f->b));
            float across = f_max(distance(e->a, f->b), distance(e->b, f->a));
            float apart = f_min(straight, across);
            if (apart > reach || distance(e->a, e->b) <= 2 * reach) continue;
            *widest = f_max(*widest, apart);
            seams++;
            break;
        }
    }
    return seams;
}

static rsv_status tell(rsv_checker *c, const object_edges *o, uint32_t object)
{
    rsv_status status = RSV_OK;
    float widest;
    const char *name = c->view->object_name[object];
    const rsv_finding flipped = { .mistake = RSV_MISTAKE_FLIPPED_FACES, .count = o->flipped };
    if (o->flipped)
        RSV_TRY(rsv_check_tell(c, &flipped, name,
            "object '%.100s': at %zu of its %zu inner edges, the two faces have opposite "
            "orientation; "
            "recalculate its normals",
            name, o->flipped, o->inner));
    size_t seams = count_seams(o, &widest);
    const rsv_finding open = {
        .mistake = RSV_MISTAKE_OPEN_SEAMS, .count = seams, .amount = (double)widest
    };
    if (seams)
        RSV_TRY(rsv_check_tell(c, &open, name,
            "object '%.100s': %zu edges are at most %.2g m from others without sharing vertices; "
            "merge vertices by distance",
            name, seams, (double)widest));
cleanup:
    return status;
}

/// The end of the object's triangles that begin with `first`: those of an object follow each other.
static size_t end_of_object(const rsv_scene_view *view, size_t first)
{
    size_t end = first + 1;
    while (end < view->triangle_count && view->triangle_object[end] == view->triangle_object[first])
        end++;
    return end;
}

static size_t most_triangles(const rsv_scene_view *view)
{
    size_t most = 0;
    for (size_t first = 0, end; first < view->triangle_count; first = end) {
        end = end_of_object(view, first);
        most = end - first > most ? end - first : most;
    }
    return most;
}

/// One object after the other: the largest one decides how much memory that takes.
rsv_status rsv_check_edges(rsv_checker *c)
{
    rsv_status status = RSV_OK;
    edge *edges = rsv_alloc(c->context, 3 * most_triangles(c->view), sizeof *edges);
    if (!edges) return RSV_ERROR_MEMORY;
    for (size_t first = 0, end; first < c->view->triangle_count; first = end) {
        end = end_of_object(c->view, first);
        list_edges(c->view, first, end, edges);
        const object_edges o = sort_out(edges, 3 * (end - first));
        RSV_TRY(tell(c, &o, c->view->triangle_object[first]));
    }
cleanup:
    rsv_free(c->context, edges);
    return status;
}
