/// Relighting: solving again for another E0, from where the last solve stopped.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../scene/punctual.h"
#include "../solve/sharpen.h"
#include "relight_responses.h"

#include <math.h>
#include <string.h>

/// Largest invisible change by the last order, relative to the largest E0.
#define CONVERGED 1e-3

static double largest(const rsv_rgb *field, size_t count)
{
    float most = 0;
    for (size_t n = 0; n < count; n++)
        most = f_max(most, rgb_max(field[n]));
    return (double)most;
}

static void add_source(void *data, rsv_span span)
{
    const rsv_relighter *r = data;
    const rsv_rgb *source = r->s->source;
    for (size_t n = span.begin; n < span.end; n++)
        r->next[n] = rgb_add(source[n], r->next[n]);
}

/// A step of the iteration, and its largest change of any channel.
typedef struct step_job {
    const rsv_relighter *relighter;
    _Atomic double change;
} step_job;

static void take_next(void *data, rsv_span span)
{
    step_job *job = data;
    const rsv_rgb *next = job->relighter->next;
    rsv_rgb *irradiance = job->relighter->field->irradiance;
    float change = 0;
    for (size_t n = span.begin; n < span.end; n++) {
        rsv_rgb step = rgb_sub(next[n], irradiance[n]);
        change = f_max(change, f_max(fabsf(step.r), f_max(fabsf(step.g), fabsf(step.b))));
        irradiance[n] = next[n];
    }
    rsv_atomic_max(&job->change, (double)change);
}

/// E = E0 + G K E once, from the E of the last time.
static void apply_once(rsv_relighter *r, double size)
{
    const rsv_linear_map *map = &r->map->linear;
    size_t nodes = rsv_relighter_nodes(r);
    step_job step = { .relighter = r };
    map->table->apply(map->data, 3, &r->field->irradiance->r, &r->next->r);
    rsv_parallel_for(r->context, nodes, 0, add_source, r);
    rsv_elements_constrain(r->s->elements, r->next);
    rsv_parallel_for(r->context, nodes, 0, take_next, &step);
    r->residual = size > 0 ? step.change / size : 0;
}

static void take_indirect(void *data, rsv_span span)
{
    const rsv_light_fields *f = data;
    for (size_t n = span.begin; n < span.end; n++)
        f->indirect[n] = rgb_positive(rgb_sub(f->irradiance[n], f->source[n]));
}

/// The light for lookups by cameras: everything but E0, sharpened.
static void show(rsv_relighter *r)
{
    rsv_light_fields *f = r->field;
    rsv_parallel_for(r->context, rsv_relighter_nodes(r), 0, take_indirect, f);
    rsv_sharpen(r->s->elements, f->indirect, r->next, r->scratch);
}

rsv_status rsv_relighter_step(rsv_relighter *r, double milliseconds, rsv_relight_progress *progress)
{
    double end = rsv_seconds() + 1e-3 * milliseconds;
    double size = largest(r->s->source, rsv_relighter_nodes(r));
    uint32_t orders = 0;
    if (!(milliseconds >= 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: a step needs a time of 0 ms or more");
    while (!r->settled && r->residual > CONVERGED && (orders == 0 || rsv_seconds() < end)) {
        apply_once(r, size);
        orders++;
    }
    if (orders) show(r);
    if (progress)
        *progress = (rsv_relight_progress){ orders, r->settled ? 0 : r->residual,
            r->settled || r->residual <= CONVERGED };
    return RSV_OK;
}

rsv_status rsv_relighter_settle(rsv_relighter *r)
{
    rsv_status status = RSV_OK;
    if (r->settled) return RSV_OK;
    rsv_light_effort effort = rsv_full_light_effort(r->light, r->valid);
    if (rsv_relighter_any_stale(r)) {
        RSV_TRY(rsv_relighter_sample(r, r->stale, RSV_RELIGHTER_ANYTHING, &effort));
        RSV_TRY(rsv_relighter_update_sources(r, RSV_RELIGHTER_ANYTHING));
        rsv_relight_responses_forget(r);
        memset(r->stale, 0, r->basis->source_count * sizeof *r->stale);
    }
    RSV_TRY(rsv_light_solve_again(r->light));
    r->settled = true;
cleanup:
    return status;
}

/// All parts there are, of those that are away also the one at home. @param part [2 source_count] @return how many
static size_t list_parts(rsv_relighter *r, rsv_light_part **part)
{
    size_t count = 0;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        part[count++] = &r->basis->part[k];
        part[count++] = &r->home_part[k];
    }
    return count;
}

static size_t level_cells(const rsv_relighter *r)
{
    const rsv_elements *fine = r->s->fine.elements, *caustics = r->s->caustics.elements;
    return (fine ? fine->cell_count : 0) + (caustics ? caustics->cell_count : 0);
}

/// Creates levels for the present positions of sources, without refinements for earlier positions.
static rsv_status refine_levels(rsv_relighter *r)
{
    rsv_status status;
    rsv_light_part **part = r->listed;
    if (r->refined && r->began) {
        RSV_TRY(rsv_light_take_levels(r->light, r->began));
        rsv_relighter_return_levels(r);
    }
    size_t cells = level_cells(r);
    RSV_TRY(rsv_relighter_keep_levels(r));
    rsv_relighter_forget_levels(r);
    r->refined = true;
    RSV_TRY(rsv_light_refine_levels(r->light, part, list_parts(r, part)));
    r->replacements += level_cells(r) > cells;
    RSV_TRY(rsv_find_fine_valid(r->light, &r->valid));
cleanup:
    return status;
}

rsv_status rsv_relighter_refine(rsv_relighter *r)
{
    rsv_status status = RSV_OK;
    if (rsv_relighter_any_stale(r)) RSV_TRY(refine_levels(r));
    RSV_TRY(rsv_relighter_settle(r));
cleanup:
    return status;
}

uint32_t rsv_relighter_replacements(const rsv_relighter *r) { return r->replacements; }

uint64_t rsv_relighter_rays(const rsv_relighter *r) { return r->rays; }

bool rsv_relighter_is_settled(const rsv_relighter *r) { return r->settled; }

// ---- sources -------------------------------------------------------------------------------------

size_t rsv_relighter_source_count(const rsv_relighter *r) { return r->basis->source_count; }

rsv_relight_source rsv_relighter_source(const rsv_relighter *r, size_t k)
{
    const rsv_source *source = &r->basis->source[k];
    bool distant = source->kind == RSV_SOURCE_SURROUNDINGS ||
                   (source->kind == RSV_SOURCE_LIGHT &&
                       rsv_punctual_is_distant(&r->scene->light[source->index]));
    const rsv_lights *lights = r->sources->lights;
    bool stored = source->kind == RSV_SOURCE_MATERIAL &&
                  (rsv_is_gathered(lights, source->index) ||
                      rsv_emission_share(lights, source->index) > RSV_MOVABLE_SHARE);
    return (rsv_relight_source){ .name = source->name,
        .strength = r->basis->strength[k],
        .scale = r->now.scale[k],
        .position = v3_add(r->place[k].centre, r->now.offset[k]),
        .movable = !distant && !stored,
        .node = source->node,
        .kind = (rsv_light_kind)source->kind,
        .index = source->index };
}

_Static_assert((int)RSV_LIGHT_MATERIAL == RSV_SOURCE_MATERIAL &&
                   (int)RSV_LIGHT_PUNCTUAL == RSV_SOURCE_LIGHT &&
                   (int)RSV_LIGHT_SURROUNDINGS == RSV_SOURCE_SURROUNDINGS,
    "kinds of sources are public under other names");

uint32_t rsv_light_find_source(const rsv_light *s, rsv_light_kind kind, uint32_t index)
{
    const rsv_light_view *view = rsv_light_get_view(s);
    const rsv_light_basis *basis = view->basis;
    rsv_source *listed = NULL;
    size_t count = 0;
    uint32_t found = RSV_NONE;
    if (!basis && rsv_list_sources(view->lights, &listed, &count) != RSV_OK) return RSV_NONE;
    const rsv_source *source = basis ? basis->source : listed;
    if (basis) count = basis->source_count;
    for (size_t k = 0; k < count && found == RSV_NONE; k++)
        if ((int)source[k].kind == (int)kind && source[k].index == index) found = (uint32_t)k;
    rsv_free(view->context, listed);
    return found;
}

void rsv_relight_desc_init(rsv_relight_desc *desc, size_t size)
{
    const rsv_relight_desc defaults = { .size = sizeof defaults };
    rsv_desc_fill(desc, size, &defaults);
}

rsv_status rsv_light_relight(rsv_light *s, const rsv_relight_desc *desc)
{
    rsv_relighter *r = NULL;
    rsv_status status = rsv_relighter_create(s, &r);
    if (status == RSV_OK) r->once = true;
    if (status == RSV_OK) status = rsv_relighter_change(r, desc);
    if (status == RSV_OK) status = rsv_relighter_refine(r);
    rsv_relighter_destroy(r);
    return status;
}
