#include "point_density.h"

#include "../core/parallel.h"
#include "../elements/elements.h"
#include "../elements/open_corners.h"
#include "../render/stored_noise.h"

#define SHARE_BY_AREA 0.5
/// Fraction of the light that may be wrong where something touches or almost touches a cell.
#define CUT_ERROR 0.3

/// A cell is known by the middles of the four it could be split into.
#define CHILDREN 4

typedef struct weighing {
    const rsv_point_density *density;
    rsv_cell_indicator indicator;
    const void *user; ///< of the indicator
} weighing;

/// The areas times the indicators, each before its turn in the sums.
static void weigh_cells(void *data, rsv_span span)
{
    const weighing *w = data;
    const rsv_elements *e = w->density->elements;
    double *below = w->density->below;
    for (size_t c = span.begin; c < span.end; c++) {
        double value = w->indicator(w->user, (uint32_t)c);
        below[c + 1] = isfinite(value) ? value * (double)rsv_cell_area(e, (uint32_t)c) : 0;
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
    weighing w = { density, indicator, user };
    rsv_parallel_for(e->context, e->cell_count, 1024, weigh_cells, &w);
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

/// The stored value there; for direct light that is left to the renderer, that of the coarse elements.
static double stored_luminance(const rsv_light_view *s, rsv_face_point p)
{
    return (double)rgb_luminance(rgb_add(rsv_light_view_direct(s, p.face, p.u, p.v, false),
        rsv_elements_interpolate(s->elements, s->indirect, p.face, p.u, p.v)));
}

/// Indicators of the finest cells, each of them to have the same share of points.
typedef struct cell_indicators {
    const rsv_light_view *solution;
    const rsv_elements *elements;
    rsv_stored_noise noise;
    float *value[2];  ///< [cell_count]: squares of the light, and of its suspected error
    double weight[2]; ///< that makes their integrals 1
} cell_indicators;

static const float middle[CHILDREN][2] = { { 1.0f / 6, 1.0f / 6 }, { 2.0f / 3, 1.0f / 6 },
    { 1.0f / 6, 2.0f / 3 }, { 1.0f / 3, 1.0f / 3 } };

/// The square of the light, and the variance visible in stored light. Next to contacts, any fraction of the light may
/// be wrong.
static void judge_cell(cell_indicators *i, uint32_t cell)
{
    double light = 0, variance = 0;
    for (int k = 0; k < CHILDREN; k++) {
        rsv_face_point p = point_in(&i->elements->cell[cell], middle[k][0], middle[k][1]);
        double stored = stored_luminance(i->solution, p);
        light += stored * stored / CHILDREN;
        variance += rsv_stored_noise_at(&i->noise, p.face, p.u, p.v, false) / CHILDREN;
    }
    const uint8_t *openness = i->elements->cell_openness;
    if (openness && openness[cell] & RSV_CELL_CUT) variance += CUT_ERROR * CUT_ERROR * light;
    i->value[0][cell] = isfinite(light) ? (float)light : 0;
    i->value[1][cell] = isfinite(variance) ? (float)variance : 0;
}

static void judge_span(void *data, rsv_span span)
{
    for (size_t cell = span.begin; cell < span.end; cell++)
        judge_cell(data, (uint32_t)cell);
}

static void judge_cells(cell_indicators *i)
{
    const rsv_elements *e = i->elements;
    rsv_parallel_for(e->context, e->cell_count, 1024, judge_span, i);
    for (int k = 0; k < 2; k++) {
        double sum = 0;
        for (uint32_t cell = 0; cell < e->cell_count; cell++)
            sum += (double)i->value[k][cell] * (double)rsv_cell_area(e, cell);
        i->weight[k] = sum > 0 ? 1 / sum : 0;
    }
}

static double indicator_of(const void *user, uint32_t cell)
{
    const cell_indicators *i = user;
    return i->weight[0] * (double)i->value[0][cell] + i->weight[1] * (double)i->value[1][cell];
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
    rsv_status status;
    cell_indicators i = { .solution = s, .elements = finest_elements(s) };
    size_t cells = i.elements->cell_count;
    RSV_TRY(rsv_stored_noise_create(s, s->desc.direct_level, &i.noise));
    i.value[0] = rsv_alloc(s->context, cells, sizeof *i.value[0]);
    i.value[1] = rsv_alloc(s->context, cells, sizeof *i.value[1]);
    RSV_TRY(i.value[0] && i.value[1] ? RSV_OK : RSV_ERROR_MEMORY);
    judge_cells(&i);
    status = rsv_point_density_create(i.elements, SHARE_BY_AREA, indicator_of, &i, density);
cleanup:
    rsv_stored_noise_destroy(&i.noise);
    rsv_free(s->context, i.value[0]);
    rsv_free(s->context, i.value[1]);
    return status;
}
