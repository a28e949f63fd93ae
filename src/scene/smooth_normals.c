#include "smooth_normals.h"

#include "../core/vec.h"

#include <stdlib.h>

/// One end of an edge seen from a vertex: the corner it belongs to and the vertex it leads to.
typedef struct spoke {
    uint32_t other, slot;
} spoke;

/// A corner around a vertex, with the group of corners that share its normal.
typedef struct member {
    uint32_t group, source, corner;
} member;

typedef struct smoother {
    rsv_context *context;
    const rsv_vec3 *position;
    const uint32_t *index;
    size_t vertex_count, triangle_count;
    float crease_cosine;
    uint32_t *weld;      ///< [vertex_count] first vertex of that position
    rsv_vec3 *face;      ///< [triangle_count] unit normal; zero = degenerate
    size_t *begin;       ///< [vertex_count + 1] into corner, by welded vertex
    uint32_t *corner;    ///< [3 * triangle_count]
    spoke *spokes;       ///< [2 * largest number of corners around a vertex]
    member *members;     ///< [the same / 2]
    uint32_t *group;     ///< [the same / 2] union-find forest
    rsv_smooth_mesh out; ///< out.index is filled corner by corner
} smoother;

static int compare_floats(float a, float b) { return (a > b) - (a < b); }

/// A vertex and where it is: the C library of web pages has no qsort_r.
typedef struct placed_vertex {
    rsv_vec3 position;
    uint32_t index;
} placed_vertex;

static int compare_positions(const void *a, const void *b)
{
    const placed_vertex *v = a, *w = b;
    const rsv_vec3 *p = &v->position, *q = &w->position;
    int order = compare_floats(p->x, q->x);
    if (!order) order = compare_floats(p->y, q->y);
    if (!order) order = compare_floats(p->z, q->z);
    return order ? order : (v->index > w->index) - (v->index < w->index);
}

static bool same_position(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static rsv_status weld(smoother *s)
{
    placed_vertex *sorted = rsv_alloc(s->context, s->vertex_count, sizeof *sorted);
    if (!sorted) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < s->vertex_count; i++)
        sorted[i] = (placed_vertex){ s->position[i], (uint32_t)i };
    qsort(sorted, s->vertex_count, sizeof *sorted, compare_positions);
    for (size_t i = 0; i < s->vertex_count; i++) {
        bool repeated = i > 0 && same_position(sorted[i].position, sorted[i - 1].position);
        s->weld[sorted[i].index] = repeated ? s->weld[sorted[i - 1].index] : sorted[i].index;
    }
    rsv_free(s->context, sorted);
    return RSV_OK;
}

static uint32_t welded(const smoother *s, size_t corner) { return s->weld[s->index[corner]]; }

static size_t next_corner(size_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
static size_t previous_corner(size_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

static void find_face_normals(smoother *s)
{
    for (size_t t = 0; t < s->triangle_count; t++) {
        const uint32_t *c = &s->index[3 * t];
        rsv_vec3 a = s->position[c[0]], e = v3_sub(s->position[c[1]], a),
                 f = v3_sub(s->position[c[2]], a);
        // scaled first: products of tiny or huge edges leave the range of float
        float scale = f_max(v3_max_abs(e), v3_max_abs(f));
        if (scale > 0 && isfinite(scale))
            s->face[t] = v3_normalize(v3_cross(v3_scale(e, 1 / scale), v3_scale(f, 1 / scale)));
    }
}

/// Lists the corners around each welded vertex; returns how many the busiest one has.
static size_t list_corners(smoother *s)
{
    size_t corner_count = 3 * s->triangle_count, largest = 0;
    for (size_t c = 0; c < corner_count; c++)
        s->begin[welded(s, c) + 1]++;
    for (size_t v = 0; v < s->vertex_count; v++) {
        if (s->begin[v + 1] > largest) largest = s->begin[v + 1];
        s->begin[v + 1] += s->begin[v];
    }
    // filled from the back, which leaves `begin` one step ahead of itself
    for (size_t c = corner_count; c-- > 0;)
        s->corner[--s->begin[welded(s, c) + 1]] = (uint32_t)c;
    for (size_t v = 0; v < s->vertex_count; v++)
        s->begin[v] = s->begin[v + 1];
    s->begin[s->vertex_count] = corner_count;
    return largest;
}

static int compare_spokes(const void *a, const void *b)
{
    const spoke *p = a, *q = b;
    if (p->other != q->other) return p->other < q->other ? -1 : 1;
    return (p->slot > q->slot) - (p->slot < q->slot);
}

static int compare_members(const void *a, const void *b)
{
    const member *p = a, *q = b;
    if (p->group != q->group) return p->group < q->group ? -1 : 1;
    if (p->source != q->source) return p->source < q->source ? -1 : 1;
    return (p->corner > q->corner) - (p->corner < q->corner);
}

static uint32_t find_root(uint32_t *group, uint32_t i)
{
    while (group[i] != i)
        i = group[i] = group[group[i]];
    return i;
}

/// Joins the corners around a vertex across its smooth edges.
static void group_corners(smoother *s, const uint32_t *corner, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        s->group[i] = (uint32_t)i;
        s->spokes[2 * i] = (spoke){ welded(s, next_corner(corner[i])), (uint32_t)i };
        s->spokes[2 * i + 1] = (spoke){ welded(s, previous_corner(corner[i])), (uint32_t)i };
    }
    qsort(s->spokes, 2 * count, sizeof *s->spokes, compare_spokes);
    for (size_t i = 1; i < 2 * count; i++) {
        spoke a = s->spokes[i - 1], b = s->spokes[i];
        if (a.other != b.other) continue;
        rsv_vec3 p = s->face[corner[a.slot] / 3], q = s->face[corner[b.slot] / 3];
        if (v3_dot(p, q) < s->crease_cosine) continue;
        uint32_t x = find_root(s->group, a.slot), y = find_root(s->group, b.slot);
        s->group[x > y ? x : y] = x < y ? x : y;
    }
}

/// The face's normal times the angle at this corner.
static rsv_vec3 weighted_normal(const smoother *s, uint32_t corner)
{
    rsv_vec3 at = s->position[s->index[corner]];
    rsv_vec3 e = v3_normalize(v3_sub(s->position[s->index[next_corner(corner)]], at));
    rsv_vec3 f = v3_normalize(v3_sub(s->position[s->index[previous_corner(corner)]], at));
    // accurate at all angles, unlike the arc cosine
    float angle = atan2f(v3_length(v3_cross(e, f)), v3_dot(e, f));
    return v3_scale(s->face[corner / 3], angle);
}

/// Gives the corners around one vertex their output vertices.
static void emit_vertex(smoother *s, const uint32_t *corner, size_t count)
{
    for (size_t i = 0; i < count; i++)
        s->members[i] =
            (member){ find_root(s->group, (uint32_t)i), s->index[corner[i]], corner[i] };
    qsort(s->members, count, sizeof *s->members, compare_members);
    for (size_t first = 0, end; first < count; first = end) {
        rsv_vec3 sum = v3(0, 0, 0);
        for (end = first; end < count && s->members[end].group == s->members[first].group; end++)
            sum = v3_add(sum, weighted_normal(s, s->members[end].corner));
        for (size_t i = first; i < end; i++) {
            const member *m = &s->members[i];
            if (i == first || m->source != m[-1].source) {
                s->out.normal[s->out.vertex_count] = v3_normalize(sum);
                s->out.source[s->out.vertex_count++] = m->source;
            }
            s->out.index[m->corner] = (uint32_t)(s->out.vertex_count - 1);
        }
    }
}

static rsv_status allocate(smoother *s)
{
    size_t corner_count = 3 * s->triangle_count;
    s->weld = rsv_alloc(s->context, s->vertex_count, sizeof *s->weld);
    s->face = rsv_alloc(s->context, s->triangle_count, sizeof *s->face);
    s->begin = rsv_alloc(s->context, s->vertex_count + 1, sizeof *s->begin);
    s->corner = rsv_alloc(s->context, corner_count, sizeof *s->corner);
    s->out.normal = rsv_alloc(s->context, corner_count, sizeof *s->out.normal);
    s->out.source = rsv_alloc(s->context, corner_count, sizeof *s->out.source);
    s->out.index = rsv_alloc(s->context, corner_count, sizeof *s->out.index);
    bool complete = s->weld && s->face && s->begin && s->corner && s->out.normal && s->out.source &&
                    s->out.index;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_status allocate_star(smoother *s, size_t corners)
{
    s->spokes = rsv_alloc(s->context, 2 * corners, sizeof *s->spokes);
    s->members = rsv_alloc(s->context, corners, sizeof *s->members);
    s->group = rsv_alloc(s->context, corners, sizeof *s->group);
    return s->spokes && s->members && s->group ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_smooth_mesh_release(rsv_context *context, rsv_smooth_mesh *smooth)
{
    rsv_free(context, smooth->normal);
    rsv_free(context, smooth->source);
    rsv_free(context, smooth->index);
    *smooth = (rsv_smooth_mesh){ 0 };
}

rsv_status rsv_smooth_normals(
    rsv_context *context, const rsv_mesh_desc *mesh, float crease_angle, rsv_smooth_mesh *smooth)
{
    rsv_status status;
    smoother s = { .context = context,
        .position = mesh->positions,
        .index = mesh->indices,
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count,
        .crease_cosine = crease_angle >= RSV_PI ? -2 : cosf(crease_angle) };
    RSV_TRY(allocate(&s));
    RSV_TRY(weld(&s));
    find_face_normals(&s);
    RSV_TRY(allocate_star(&s, list_corners(&s)));
    for (size_t v = 0; v < s.vertex_count; v++) {
        const uint32_t *corner = &s.corner[s.begin[v]];
        size_t count = s.begin[v + 1] - s.begin[v];
        group_corners(&s, corner, count);
        emit_vertex(&s, corner, count);
    }
cleanup:
    rsv_free(context, s.weld);
    rsv_free(context, s.face);
    rsv_free(context, s.begin);
    rsv_free(context, s.corner);
    rsv_free(context, s.spokes);
    rsv_free(context, s.members);
    rsv_free(context, s.group);
    if (status != RSV_OK) rsv_smooth_mesh_release(context, &s.out);
    *smooth = s.out;
    return status;
}
