#include "point_density.h"

#include "../elements/elements.h"

#define SHARE_BY_AREA 0.5

/// A cell is known by the middles of the four it could be split into.
#define CHILDREN 4

/// The areas times the indicators, each before its turn in the sums.
static void weigh_cells(rsv_point_density *d, rsv_cell_indicator indicator, const void *user)
{
    const rsv_elements *e = d->elements;
#pragma omp parallel for schedule(dynamic, 1024) num_threads(rsv_threads(e->context))
    for (size_t c = 0; c < e->cell_count; c++) {
        double value = indicator(user, (uint32_t)c);
        d->below[c + 1] = isfinite(value) ? value * (double)rsv_cell_area(e, (uint32_t)c) : 0;
    }
}

static void add_up_chances(rsv_point_density *d, double even_share)
{
    const rsv_elements *e = d->elements;
    double total = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        total += d->below[c + 1];
        d->area += (double)rsv_cell_area(e, c);
    }
    double even = total > 0 ? even_share : 1, rest = total > 0 ? (1 - even) / total : 0;
    for (uint32_t c = 0; c < e->cell_count; c++)
        d->below[c + 1] =
            d->below[c] + even * (double)rsv_cell_area(e, c) / d->area + rest * d->below[c + 1];
}

rsv_status rsv_point_density_create(const rsv_elements *e, double even_share,
    rsv_cell_indicator indicator, const void *user, rsv_point_density *density)
{
    *density = (rsv_point_density){ .elements = e };
    density->below = rsv_alloc(e->context, e->cell_count + 1, sizeof *density->below);
    if (!density->below) return RSV_ERROR_MEMORY;
    weigh_cells(density, indicator, user);
    add_up_chances(density, even_share);
    return RSV_OK;
}

void rsv_point_density_destroy(rsv_point_density *density)
{
    if (density->elements) rsv_free(density->elements->context, density->below);
    *density = (rsv_point_density){ 0 };
}

/// The point of a cell with barycentric coordinates s, t in it.
static rsv_face_point point_in(const rsv_cell *cell, float s, float t)
{
    float u[3] = { 0 }, v[3] = { 0 };
    for (int corner = 0; corner < 3; corner++)
        rsv_cell_corner(cell, corner, &u[corner], &v[corner]);
    return (rsv_face_point){ cell->face, (1 - s - t) * u[0] + s * u[1] + t * u[2],
        (1 - s - t) * v[0] + s * v[1] + t * v[2] };
}

rsv_face_point rsv_point_density_draw(
    const rsv_point_density *d, uint32_t index, uint32_t count, uint32_t seed, double *weight)
{
    const rsv_elements *e = d->elements;
    rsv_random random = rsv_random_from(seed, index, 0x9d2cu);
    double strip = ((double)index + (double)rsv_random_float(&random)) / count;
    uint32_t cell =
        (uint32_t)rsv_interval_at(d->below + 1, e->cell_count, strip * d->below[e->cell_count]);
    float x = rsv_random_float(&random), s, t;
    rsv_square_to_triangle(x, rsv_random_float(&random), &s, &t);
    double chance = d->below[cell + 1] - d->below[cell];
    *weight = chance > 0 ? (double)rsv_cell_area(e, cell) / (d->area * chance) : 0;
    return point_in(&e->cell[cell], s, t);
}

/// What lookups return there; of direct light that the renderer finds itself what coarse elements know.
static double stored_luminance(const rsv_light_view *s, rsv_face_point p)
{
    return (double)rgb_luminance(rgb_add(rsv_solution_direct(s, p.face, p.u, p.v, false),
        rsv_elements_interpolate(s->elements, s->indirect, p.face, p.u, p.v)));
}

typedef struct lit_cells {
    const rsv_light_view *solution;
    const rsv_elements *elements;
} lit_cells;

static double squared_light(const void *user, uint32_t cell)
{
    static const float middle[CHILDREN][2] = { { 1.0f / 6, 1.0f / 6 }, { 2.0f / 3, 1.0f / 6 },
        { 1.0f / 6, 2.0f / 3 }, { 1.0f / 3, 1.0f / 3 } };
    const lit_cells *lit = user;
    double sum = 0;
    for (int k = 0; k < CHILDREN; k++) {
        double light = stored_luminance(
            lit->solution, point_in(&lit->elements->cell[cell], middle[k][0], middle[k][1]));
        sum += light * light;
    }
    return sum / CHILDREN;
}

static const rsv_elements *finest_elements(const rsv_light_view *s)
{
    const rsv_elements *finest = s->elements;
    const rsv_elements *level[] = { s->fine.elements, s->caustics.elements };
    for (int k = 0; k < 2; k++)
        if (level[k] && level[k]->cell_count > finest->cell_count) finest = level[k];
    return finest;
}

rsv_status rsv_point_density_of_light(const rsv_light_view *s, rsv_point_density *density)
{
    const lit_cells lit = { s, finest_elements(s) };
    return rsv_point_density_create(lit.elements, SHARE_BY_AREA, squared_light, &lit, density);
}
