#include "clearance.h"

#include "../core/parallel.h"
#include "../trace/near.h"
#include "../trace/tracer_update.h"
#include "specular_media.h"

#include <string.h>

/// Reach over the longest edge, and triangles within it at most: large ones have nothing to gain.
#define REACH 4
#define MOST_AROUND 1024

/// Margin for rounding.
#define MARGIN 0.01f

/// A triangle and its surroundings.
typedef struct survey {
    const rsv_scene_view *view;
    rsv_vec3 corner[3], middle, normal;
    float radius, reach;
    float slack; ///< metres by which rays start above the plane
    float cosine[2];
    uint32_t found;
} survey;

typedef struct neighbour {
    rsv_vec3 corner[3], normal;
    float apart; ///< metres from all points of the triangle, at least
} neighbour;

static float distance(rsv_vec3 a, rsv_vec3 b) { return v3_length(v3_sub(a, b)); }

/// Unit normal; the zero vector if the triangle has no area.
static rsv_vec3 place_corners(const rsv_scene_view *view, uint32_t triangle, rsv_vec3 corner[3])
{
    for (int k = 0; k < 3; k++)
        corner[k] = view->position[view->triangle[triangle][k]];
    return v3_normalize(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])));
}

/// Height of the lowest or highest corner above a plane.
static float least_height(const rsv_vec3 corner[3], rsv_vec3 place, rsv_vec3 normal)
{
    float a = v3_dot(v3_sub(corner[0], place), normal),
          b = v3_dot(v3_sub(corner[1], place), normal);
    return f_min(f_min(a, b), v3_dot(v3_sub(corner[2], place), normal));
}

static float most_height(const rsv_vec3 corner[3], rsv_vec3 place, rsv_vec3 normal)
{
    return -least_height(corner, place, v3_neg(normal));
}

/// Cosine to `normal` of directions in which points of the triangle may see the neighbour, at most.
static float cosine_towards(const survey *s, const neighbour *n, rsv_vec3 normal)
{
    float height = most_height(n->corner, s->corner[0], normal);
    if (height <= s->slack) return 0;
    // all of the triangle is in front of the neighbour's plane: its points only see what is behind that
    float along = v3_dot(n->normal, normal);
    rsv_vec3 facing = along < 0 ? v3_neg(n->normal) : n->normal;
    if (fabsf(along) >= 0.5f && least_height(s->corner, n->corner[0], facing) >= -0.5f * s->slack)
        return sqrtf(f_max(1 - along * along, 0));
    return n->apart > height ? height / n->apart : 1;
}

static void look_at(void *user, uint32_t triangle, float *radius)
{
    survey *s = user;
    neighbour n;
    if (++s->found > MOST_AROUND) *radius = 0;
    if (s->found > MOST_AROUND) return;
    n.normal = place_corners(s->view, triangle, n.corner);
    if (v3_dot(n.normal, n.normal) == 0) return; // no ray meets it
    float u, v, apart = rsv_triangle_distance(s->view, triangle, s->middle, &u, &v);
    n.apart = apart - s->radius - 0x1p-20f * rsv_extent_of(s->view, triangle);
    if (n.apart > s->reach) return;
    s->cosine[0] = f_max(s->cosine[0], cosine_towards(s, &n, s->normal));
    s->cosine[1] = f_max(s->cosine[1], cosine_towards(s, &n, v3_neg(s->normal)));
}

static rsv_clearance survey_around(const rsv_clearances *c, uint32_t triangle)
{
    const rsv_clearance unknown = { 0, { 1, 1 } };
    survey s = { .view = rsv_scene_get_view(rsv_tracer_scene(c->tracer)) };
    s.normal = place_corners(s.view, triangle, s.corner);
    s.middle = v3_scale(v3_add(v3_add(s.corner[0], s.corner[1]), s.corner[2]), 1.0f / 3);
    for (int k = 0; k < 3; k++)
        s.radius = f_max(s.radius, distance(s.middle, s.corner[k]));
    float edge = f_max(distance(s.corner[0], s.corner[1]),
        f_max(distance(s.corner[1], s.corner[2]), distance(s.corner[2], s.corner[0])));
    s.reach = REACH * edge;
    s.slack = 0x1p-20f * rsv_extent_of(s.view, triangle);
    rsv_tracer_visit_near(c->tracer, s.middle, s.reach + s.radius, look_at, &s);
    if (s.found > MOST_AROUND || s.slack > 1e-3f * edge) return unknown;
    return (
        rsv_clearance){ (1 - MARGIN) * s.reach, { s.cosine[0] + MARGIN, s.cosine[1] + MARGIN } };
}

/// The range of triangles that have a smooth material.
static void find_range(const rsv_specular_media *media, rsv_clearances *c)
{
    const rsv_scene_view *view = media->scene->view;
    uint32_t last = 0;
    for (uint32_t k = 0; k < view->triangle_count; k++) {
        if (!media->material[view->triangle_material[k]].smooth) continue;
        if (c->count == 0) c->first = k;
        c->count = 1;
        last = k;
    }
    if (c->count) c->count = last - c->first + 1;
}

typedef struct survey_job {
    const rsv_specular_media *media;
    rsv_clearances *clearances;
} survey_job;

static void survey_triangles(void *user, rsv_span span)
{
    const survey_job *job = user;
    const rsv_clearances *c = job->clearances;
    const uint32_t *material = job->media->scene->view->triangle_material;
    for (uint32_t k = (uint32_t)span.begin; k < span.end; k++)
        if (job->media->material[material[c->first + k]].smooth)
            c->of[k] = survey_around(c, c->first + k);
}

rsv_status rsv_clearances_create(
    rsv_context *context, const rsv_specular_media *media, bool wanted, rsv_clearances *c)
{
    *c = (rsv_clearances){ .context = context, .tracer = media->scene->tracer, .holds = true };
    if (wanted) find_range(media, c);
    c->of = rsv_alloc(context, (size_t)c->count + 1, sizeof *c->of);
    if (!c->of) return RSV_ERROR_MEMORY;
    rsv_clearances_refresh(c, c->tracer);
    survey_job job = { media, c };
    if (c->holds) rsv_parallel_for(context, c->count, 64, survey_triangles, &job);
    return RSV_OK;
}

void rsv_clearances_destroy(rsv_clearances *c)
{
    if (c->context) rsv_free(c->context, c->of);
}

void rsv_clearances_refresh(rsv_clearances *c, const rsv_tracer *tracer)
{
    bool same = tracer == c->tracer && !rsv_tracer_is_apart(tracer);
    c->tracer = tracer;
    if (!c->holds || same) return;
    memset(c->of, 0, (size_t)c->count * sizeof *c->of);
    c->holds = false;
}
