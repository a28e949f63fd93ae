#include "twin_body.h"

#include "../core/sampling.h"
#include "tree_ray.h"

#include <stdlib.h>

/// Lines through a face at most. One does, unless it runs along edges.
#define LINES 5
/// Triangles that a line crosses at most: more are a heap.
#define MOST_CROSSED 512
/// How far lines depart from the normal: no line of one face runs along the edges of others.
#define TILT 0.4f

bool rsv_twin_is_body(const rsv_scene_view *scene, uint32_t material)
{
    const rsv_material *m = &scene->material[material];
    return m->transmission > 0 && m->thickness > 0;
}

static int compare_distances(const void *left, const void *right)
{
    float a = *(const float *)left, b = *(const float *)right;
    return (a > b) - (a < b);
}

/// Places ahead, or behind, that lie apart by more than the gap. @param t [count] ascending
static uint32_t count_crossed(const float *t, uint32_t count, float sign, float gap)
{
    uint32_t crossed = 0;
    float last = 0;
    for (uint32_t k = 0; k < count; k++) {
        float at = sign * t[sign > 0 ? k : count - 1 - k];
        if (!(at > last + gap)) continue;
        last = at;
        crossed++;
    }
    return crossed;
}

static rsv_ray line_through(const rsv_scene_view *scene, uint32_t triangle, uint32_t k)
{
    float x[4];
    for (uint32_t d = 0; d < 4; d++)
        x[d] = rsv_unit_float(rsv_hash2(LINES * d + k, triangle));
    if (x[0] + x[1] > 1) x[0] = 1 - x[0], x[1] = 1 - x[1];
    rsv_twin_plane plane = rsv_twin_plane_of(scene, triangle);
    rsv_vec3 away = v3_scale(rsv_square_to_sphere(x[2], x[3]), TILT);
    return (rsv_ray){ rsv_twin_point(&plane, x[0], x[1]),
        v3_normalize(v3_add(v3_normalize(plane.normal), away)), INFINITY };
}

/// @return 1 = the front is inside, -1 = the back is, 0 = the surface is not closed
static int find_inside(rsv_tree_ray *r, float gap, uint32_t triangle)
{
    float t[MOST_CROSSED];
    for (uint32_t k = 0; k < LINES; k++) {
        r->ray = line_through(r->view, triangle, k);
        uint32_t count = rsv_tree_ray_all(r, t, MOST_CROSSED);
        qsort(t, count, sizeof *t, compare_distances);
        uint32_t ahead = count_crossed(t, count, 1, gap), behind = count_crossed(t, count, -1, gap);
        if ((ahead + behind) % 2) return ahead % 2 ? 1 : -1;
    }
    return 0;
}

bool rsv_twin_is_inside_out(
    const rsv_scene_view *scene, const rsv_twin_tree *tree, float gap, uint32_t triangle)
{
    rsv_tree_ray r = { .view = scene, .tree = tree, .slack = gap };
    r.kind_of = scene->triangle_object;
    r.kind = r.kind_of[triangle];
    int inside = find_inside(&r, gap, triangle);
    if (inside) return inside > 0;
    r.kind_of = scene->triangle_material;
    r.kind = r.kind_of[triangle];
    return find_inside(&r, gap, triangle) > 0;
}
