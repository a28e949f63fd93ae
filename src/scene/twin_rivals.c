/// Faces that share the inner part of a triangle with it.
#include "../core/parallel.h"
#include "scene.h"
#include "twins_owner.h"

#include <string.h>

/// Tolerances are this many times as wide as those of hits, so that triangles close to a limit are included.
#define WIDER 2.0

/// Triangles that are slimmer are searched for at each hit: too much of their coordinates is rounding.
#define LEAST_NORMAL 1e-3f

/// Faces that one triangle looks at: more are a heap, or the tip of a fan.
#define MOST_LOOKS 256

/// Places of a triangle that hits may be at well inside it: a smaller triangle.
typedef struct inner_part {
    uint32_t triangle;
    rsv_vec3 corner[3], normal;
    rsv_twin_node box;
    rsv_twin_margin margin; ///< of the triangle
} inner_part;

static inner_part inner_part_of(const rsv_scene_view *view, uint32_t triangle)
{
    const float far = 1 - 2 * RSV_TWIN_INSET;
    const rsv_twins *twins = view->twins;
    rsv_twin_plane plane = rsv_twin_plane_of(view, triangle);
    inner_part a = { .triangle = triangle, .normal = plane.normal };
    a.corner[0] = rsv_twin_point(&plane, RSV_TWIN_INSET, RSV_TWIN_INSET);
    a.corner[1] = rsv_twin_point(&plane, far, RSV_TWIN_INSET);
    a.corner[2] = rsv_twin_point(&plane, RSV_TWIN_INSET, far);
    a.box.low = v3_min(v3_min(a.corner[0], a.corner[1]), a.corner[2]);
    a.box.high = v3_max(v3_max(a.corner[0], a.corner[1]), a.corner[2]);
    a.margin = rsv_twin_margin_of(&plane, twins->rounding, twins->reach);
    return a;
}

/// A dot product in double: a small face may be seen from far corners of a large one.
static double dot(rsv_vec3 a, rsv_vec3 b)
{
    return (double)a.x * b.x + (double)a.y * b.y + (double)a.z * b.z;
}

/// Whether all three are on one side of the band between -width and width.
static bool are_beyond(const double x[3], double width)
{
    return (x[0] > width && x[1] > width && x[2] > width) ||
           (x[0] < -width && x[1] < -width && x[2] < -width);
}

/// Whether all three are below.
static bool are_below(const double x[3], double least)
{
    return x[0] < least && x[1] < least && x[2] < least;
}

/// Whether no hit in the inner part can be on a face. The conditions of rsv_twin_covers are linear in the position, so
/// they fail everywhere if they fail at all corners for the same reason.
static bool is_clear_of(const rsv_scene_view *view, const inner_part *a, uint32_t face)
{
    const rsv_twins *twins = view->twins;
    rsv_twin_plane p = rsv_twin_plane_of(view, face);
    rsv_twin_margin margin = rsv_twin_margin_of(&p, twins->rounding, twins->reach);
    margin = rsv_twin_margin_between(margin, a->margin);
    float length = v3_length(p.normal);
    double square = dot(p.normal, p.normal);
    double fall = WIDER * (double)margin.rounding * p.scale / length;
    double height[3], u[3], v[3], w[3];
    if (!(length > LEAST_NORMAL)) return false;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 to = v3_scale(v3_sub(a->corner[k], p.corner), p.scale);
        height[k] = dot(p.normal, to) / length;
        u[k] = dot(v3_cross(p.edge2, p.normal), to) / square;
        v[k] = dot(v3_cross(p.normal, p.edge1), to) / square;
        w[k] = 1 - u[k] - v[k];
    }
    return are_beyond(height, WIDER * (double)margin.reach * p.scale) ||
           are_below(u, -fall * v3_length(p.edge2)) || are_below(v, -fall * v3_length(p.edge1)) ||
           are_below(w, -fall * v3_length(v3_sub(p.edge2, p.edge1)));
}

/// @param rival [RSV_TWIN_RIVALS] out @return how many; of too many, the first is RSV_NONE
static uint32_t find_rivals(const rsv_scene_view *view, uint32_t triangle, uint32_t *rival)
{
    const rsv_twins *twins = view->twins;
    float reach = (float)WIDER * (twins->reach + twins->rounding);
    inner_part a = inner_part_of(view, triangle);
    uint32_t count = 0, looks = 0;
    bool lists = v3_length(a.normal) > LEAST_NORMAL;
    for (uint32_t n = 0; lists && n < twins->node_count;) {
        const rsv_twin_node *node = &twins->node[n];
        bool near = rsv_twin_boxes_meet(node, &a.box, reach);
        uint32_t end = near && node->next == n + 1 ? node[1].first : node->first;
        for (uint32_t k = node->first; lists && k < end; k++) {
            uint32_t face = twins->face[k];
            bool meets = face != triangle && !is_clear_of(view, &a, face);
            lists = ++looks <= MOST_LOOKS && !(meets && count == RSV_TWIN_RIVALS);
            if (meets && lists) rival[count++] = face;
        }
        n = near ? n + 1 : node->next;
    }
    if (lists) return count;
    rival[0] = RSV_NONE;
    return 1;
}

typedef struct rival_job {
    const rsv_scene_view *view;
    uint32_t *first; ///< [triangle_count + 1] counts, then their sums
    uint32_t *rival; ///< NULL = they are counted
} rival_job;

static void list_all(void *data, rsv_span span)
{
    const rival_job *job = data;
    for (uint32_t t = (uint32_t)span.begin; t < span.end; t++) {
        uint32_t found[RSV_TWIN_RIVALS] = { 0 };
        uint32_t count = job->view->twins->flags[t] ? find_rivals(job->view, t, found) : 0;
        if (job->rival)
            memcpy(job->rival + job->first[t], found, count * sizeof *found);
        else
            job->first[t + 1] = count;
    }
}

rsv_status rsv_twins_find_rivals(rsv_scene *scene)
{
    rsv_context *context = scene->context;
    rsv_twins_owner *owner = scene->twins;
    size_t count = scene->triangle_count;
    owner->first_rival = rsv_alloc(context, count + 1, sizeof *owner->first_rival);
    if (!owner->first_rival) return RSV_ERROR_MEMORY;
    rival_job job = { &scene->view, owner->first_rival, NULL };
    rsv_parallel_for(context, count, 256, list_all, &job);
    for (size_t t = 0; t < count; t++)
        job.first[t + 1] += job.first[t];
    owner->rival = job.rival = rsv_alloc(context, (size_t)job.first[count] + 1, sizeof *job.rival);
    if (!job.rival) return RSV_ERROR_MEMORY;
    rsv_parallel_for(context, count, 256, list_all, &job);
    owner->twins.first_rival = owner->first_rival;
    owner->twins.rival = owner->rival;
    return RSV_OK;
}
