#include "spacing.h"

#include "../core/sampling.h"
#include "../trace/near.h"
#include "elements_constants.h"
#include "elements_internal.h"

/// Slivers count by a quarter of their length, or their cells would be far too many across; the thinnest by their area.
int rsv_spacing_level(const rsv_scene_view *scene, uint32_t triangle, float metres)
{
    const uint32_t *corner = scene->triangle[triangle];
    float longest = 0;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 edge = v3_sub(scene->position[corner[k]], scene->position[corner[(k + 1) % 3]]);
        longest = f_max(longest, v3_length(edge));
    }
    float wide = 1.4f * sqrtf(2 * rsv_triangle_area(scene, triangle));
    float size = f_max(wide, f_min(0.25f * longest, SLIVER_FACTOR * wide));
    int level = (int)ceilf(log2f(f_max(size / (1.4f * metres), 1e-6f)) - 0.5f);
    return level < 0 ? 0 : level > FINEST_GRID ? FINEST_GRID : level;
}

/// A cell within a ball, and the plane that it lies in.
typedef struct patch {
    rsv_vec3 centre, normal;
    float radius;
} patch;

static patch patch_of(
    const rsv_scene_view *scene, uint32_t triangle, bool back, const rsv_cell *cell)
{
    patch p = { 0 };
    rsv_vec3 corner[3];
    for (int k = 0; k < 3; k++) {
        float u, v;
        rsv_cell_corner(cell, k, &u, &v);
        rsv_surface_point point = rsv_surface_point_at(scene, triangle, u, v, back);
        corner[k] = point.position;
        p.centre = v3_mad(p.centre, 1.0f / 3, point.position);
        p.normal = point.geometric;
    }
    for (int k = 0; k < 3; k++)
        p.radius = f_max(p.radius, v3_length(v3_sub(corner[k], p.centre)));
    return p;
}

static bool is_mere_lamp(const rsv_transport_scene *scene, uint32_t triangle)
{
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[triangle]];
    return bsdf->lambert && rgb_is_black(bsdf->base_color);
}

/// Searches for geometry that rises above a patch.
typedef struct obstacle_search {
    const rsv_transport_scene *scene;
    const patch *patch;
    float rise;
    bool found;
} obstacle_search;

static void look_at(void *user, uint32_t triangle, float *radius)
{
    obstacle_search *search = user;
    const rsv_scene_view *scene = search->scene->view;
    const patch *p = search->patch;
    float highest = -INFINITY, u, v;
    if (search->found) return;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 corner = scene->position[scene->triangle[triangle][k]];
        highest = f_max(highest, v3_dot(p->normal, v3_sub(corner, p->centre)));
    }
    if (highest <= search->rise || is_mere_lamp(search->scene, triangle) ||
        rsv_triangle_distance(scene, triangle, p->centre, &u, &v) >= *radius)
        return;
    search->found = true;
    *radius = 0;
}

/// Whether surfaces fill more than a share of the hemisphere that a patch faces, weighted by the cosine.
static bool faces_more(const rsv_transport_scene *scene, const patch *p, float extent, float share)
{
    rsv_vec3 origin = rsv_offset_origin(p->centre, p->normal, extent);
    float left = share * LOOKS;
    for (uint32_t k = 0; k < LOOKS && left >= 0; k++) {
        float x, y;
        rsv_hit hit;
        rsv_sobol_2d(k, 0, &x, &y);
        rsv_vec3 d = v3_turned_to(p->normal, rsv_square_to_cosine_hemisphere(x, y));
        left -= rsv_tracer_closest(scene->tracer, &(rsv_ray){ origin, d, INFINITY }, &hit) &&
                !is_mere_lamp(scene, hit.triangle);
    }
    return left < 0;
}

static bool rises_within(
    const rsv_transport_scene *scene, const patch *p, float extent, float radius)
{
    obstacle_search search = { scene, p, RISE * extent, false };
    rsv_tracer_visit_near(scene->tracer, p->centre, radius, look_at, &search);
    return search.found;
}

/// Whether a cell lies so far in the open, or faces so little, that it may be larger than usual.
/// @param usual level > cell->level
static bool is_open(
    const rsv_spacing *spacing, uint32_t triangle, bool back, const rsv_cell *cell, int usual)
{
    const rsv_transport_scene *scene = spacing->scene;
    int growth = usual - cell->level;
    if (!scene || growth > MOST_GROWTH || is_mere_lamp(scene, triangle)) return false;
    patch p = patch_of(scene->view, triangle, back, cell);
    float extent = rsv_triangle_extent(scene->view, triangle);
    float around = ALONE * p.radius;
    float far = p.radius + spacing->reach * sqrtf(ldexpf(0.5f, growth));
    if (around >= far) return !rises_within(scene, &p, extent, far);
    if (rises_within(scene, &p, extent, around)) return false; // as most cells that have neighbours
    return !rises_within(scene, &p, extent, far) ||
           !faces_more(scene, &p, extent, ldexpf(MOST_FACED, -2 * growth));
}

/// How much coarser a cell is than usual, in levels.
static int levels_missing(const rsv_spacing *spacing, const rsv_elements *e, uint32_t cell)
{
    uint32_t triangle = e->face_triangle[e->cell[cell].face];
    return rsv_spacing_level(e->scene, triangle, spacing->metres) - e->cell[cell].level;
}

static bool cell_is_open(
    const rsv_spacing *spacing, const rsv_elements *e, uint32_t cell, int missing)
{
    const rsv_cell *c = &e->cell[cell];
    return is_open(
        spacing, e->face_triangle[c->face], e->face_back[c->face], c, c->level + missing);
}

bool rsv_spacing_lets_grow(const rsv_spacing *spacing, const rsv_elements *e, uint32_t cell)
{
    int missing = levels_missing(spacing, e, cell);
    return missing > 0 && cell_is_open(spacing, e, cell, missing);
}

bool rsv_spacing_is_exceeded(const rsv_spacing *spacing, const rsv_elements *e, uint32_t cell)
{
    int missing = levels_missing(spacing, e, cell);
    return missing > 0 && !cell_is_open(spacing, e, cell, missing);
}

typedef struct divider {
    const rsv_spacing *spacing;
    uint32_t triangle;
    bool back;
    int usual;
    rsv_face_division division;
} divider;

static void divide(divider *d, rsv_cell cell, double area)
{
    if (cell.level >= d->usual || is_open(d->spacing, d->triangle, d->back, &cell, d->usual)) {
        d->division.counts += ldexp(area, 2 * (cell.level - d->usual));
        if (cell.level < d->division.coarsest) d->division.coarsest = cell.level;
        return;
    }
    for (int k = 0; k < 4; k++)
        divide(d, rsv_child_cell(cell, k), area / 4);
}

rsv_face_division rsv_spacing_divide(const rsv_spacing *spacing, uint32_t triangle, bool back)
{
    const rsv_scene_view *scene = spacing->scene->view;
    int usual = rsv_spacing_level(scene, triangle, spacing->metres);
    divider d = { spacing, triangle, back, usual, { usual, 0 } };
    divide(&d, (rsv_cell){ 0 }, rsv_triangle_area(scene, triangle));
    return d.division;
}

/// m2 that count on one side of each triangle, the one that has more around it.
static double area_that_counts(const rsv_transport_scene *scene, const rsv_spacing *spacing)
{
    const rsv_scene_view *view = scene->view;
    double sum = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++) {
        const rsv_bsdf *bsdf = &scene->bsdf[view->triangle_material[t]];
        if (bsdf->diffuse <= 0) continue;
        double counts = rsv_spacing_divide(spacing, t, false).counts;
        if (rsv_side_scatters(bsdf, true) && counts < rsv_triangle_area(view, t))
            counts = fmax(counts, rsv_spacing_divide(spacing, t, true).counts);
        sum += counts;
    }
    return sum;
}

static double diffuse_area(const rsv_transport_scene *scene)
{
    double area = 0;
    for (uint32_t t = 0; t < scene->view->triangle_count; t++)
        if (scene->bsdf[scene->view->triangle_material[t]].diffuse > 0)
            area += rsv_triangle_area(scene->view, t);
    return area;
}

rsv_spacing rsv_spacing_for(const rsv_transport_scene *scene, uint32_t target)
{
    double all = diffuse_area(scene), area = all;
    rsv_spacing spacing = { 1, INFINITY, scene };
    for (int round = 0; round < MAX_ROUNDS && all > 0; round++) {
        spacing.metres = (float)sqrt(area / target);
        spacing.reach = (float)sqrt(area) / REACHES;
        double counts = area_that_counts(scene, &spacing);
        if (counts > (1 - SETTLED) * area) break;
        area = counts;
    }
    // a plain with nothing on it: where all is as open as can be, one size fits all
    if (ldexp(area, 2 * MOST_GROWTH) < (1 + SETTLED) * all)
        return (rsv_spacing){ (float)sqrt(all / target), INFINITY, NULL };
    return spacing;
}
