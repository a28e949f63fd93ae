#include "relight_responses.h"

#include "../solve/sharpen.h"
#include "solve_fields.h"

/// Of the residual: far below what anybody sees.
#define TOLERANCE 1e-5
#define FIELDS_AT_ONCE 4 ///< they share every pass over G

static bool is_gathered(const rsv_relighter *r, size_t source)
{
    const rsv_source *s = &r->basis->source[source];
    return s->kind == RSV_SOURCE_MATERIAL && rsv_is_gathered(r->sources->lights, s->index);
}

/// @return number of responses
static size_t group_sources(const rsv_relighter *r, size_t *of_source)
{
    size_t count = 0, gathered = SIZE_MAX;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        bool joins = is_gathered(r, k);
        of_source[k] = joins && gathered != SIZE_MAX ? gathered : count++;
        if (joins) gathered = of_source[k];
    }
    return count;
}

/// E0 of one response, 0 at hanging nodes. @param sky [node_count] what rows gathered of the surroundings
static void add_source(const rsv_relighter *r, size_t k, const rsv_rgb *sky, rsv_rgb *field)
{
    const rsv_light_part *part = &r->basis->part[k];
    bool surrounds = r->basis->source[k].kind == RSV_SOURCE_SURROUNDINGS;
    for (size_t n = 0; n < rsv_relighter_nodes(r); n++) {
        field[n] = rgb_add(field[n], part->direct[n]);
        if (part->coarse_caustic) field[n] = rgb_add(field[n], part->coarse_caustic[n]);
        if (surrounds) field[n] = rgb_add(field[n], sky[n]);
    }
}

static void add_gathered(const rsv_relighter *r, rsv_rgb *field)
{
    for (size_t n = 0; n < rsv_relighter_nodes(r); n++)
        field[n] = rgb_add(field[n], rgb_mul(r->s->transport->gathered[n], r->gathered_scale));
}

/// E0 of responses `first` to `first + count`, side by side for the solver.
static void collect_sources(const rsv_relighter *r, const rsv_relight_responses *own, size_t first,
    size_t count, const rsv_rgb *sky, rsv_rgb *field, rsv_rgb *source)
{
    size_t nodes = rsv_relighter_nodes(r);
    for (size_t f = 0; f < count; f++) {
        bool gathers = false;
        for (size_t n = 0; n < nodes; n++)
            field[n] = rgb_gray(0);
        for (size_t k = 0; k < r->basis->source_count; k++) {
            if (own->of_source[k] != first + f) continue;
            add_source(r, k, sky, field);
            gathers = gathers || is_gathered(r, k);
        }
        if (gathers) add_gathered(r, field);
        for (size_t n = 0; n < nodes; n++)
            source[n * count + f] = field[n];
    }
}

/// Keeps what was solved for, whole and as it is shown.
static void keep(rsv_relighter *r, rsv_relight_responses *own, size_t first, size_t count,
    const rsv_rgb *source, const rsv_rgb *solved, rsv_rgb *field)
{
    const rsv_elements *e = r->s->elements;
    for (size_t f = 0; f < count; f++) {
        for (size_t n = 0; n < e->node_count; n++)
            field[n] = solved[n * count + f];
        rsv_elements_constrain(e, field);
        for (size_t n = 0; n < e->node_count; n++)
            own->irradiance[n * own->count + first + f] = field[n];
        for (size_t n = 0; n < e->node_count; n++) {
            rsv_rgb rest = rgb_sub(solved[n * count + f], source[n * count + f]);
            field[n] = rgb_positive(rest);
        }
        rsv_elements_constrain(e, field);
        rsv_sharpen(e, field, r->next, r->scratch);
        for (size_t n = 0; n < e->node_count; n++)
            own->shown[n * own->count + first + f] = field[n];
    }
}

/// Some responses at once. @param field [node_count] scratch @param solved_all is cleared where the solver fails
static rsv_status solve(rsv_relighter *r, rsv_relight_responses *own, size_t first, size_t count,
    const rsv_rgb *sky, rsv_rgb *field, bool *solved_all)
{
    rsv_status status;
    bool reached;
    size_t nodes = rsv_relighter_nodes(r);
    rsv_rgb *source = rsv_alloc(r->context, nodes, count * sizeof *source);
    rsv_rgb *solved = rsv_alloc(r->context, nodes, count * sizeof *solved);
    RSV_TRY(source && solved ? RSV_OK : RSV_ERROR_MEMORY);
    collect_sources(r, own, first, count, sky, field, source);
    RSV_TRY(rsv_solve_fields(r->s, count, TOLERANCE, source, solved, &reached));
    *solved_all = *solved_all && reached;
    keep(r, own, first, count, source, solved, field);
cleanup:
    rsv_free(r->context, source);
    rsv_free(r->context, solved);
    return status;
}

rsv_status rsv_relight_responses_create(rsv_relighter *r, rsv_relight_responses **responses)
{
    rsv_status status = RSV_OK;
    size_t nodes = rsv_relighter_nodes(r);
    *responses = NULL;
    rsv_rgb *field = rsv_alloc(r->context, nodes, sizeof *field);
    rsv_rgb *sky = rsv_alloc(r->context, nodes, sizeof *sky);
    rsv_relight_responses *own = rsv_alloc(r->context, 1, sizeof *own);
    RSV_TRY(field && sky && own ? RSV_OK : RSV_ERROR_MEMORY);
    own->context = r->context;
    own->of_source = rsv_alloc(r->context, RSV_MAX_LIGHT_PARTS, sizeof *own->of_source);
    RSV_TRY(own->of_source ? RSV_OK : RSV_ERROR_MEMORY);
    own->count = group_sources(r, own->of_source);
    if (!own->count || own->count * nodes * 2 * sizeof(rsv_rgb) > RSV_MAX_RESPONSE_BYTES)
        goto cleanup;
    own->irradiance = rsv_alloc(r->context, nodes, own->count * sizeof(rsv_rgb));
    own->shown = rsv_alloc(r->context, nodes, own->count * sizeof(rsv_rgb));
    RSV_TRY(own->irradiance && own->shown ? RSV_OK : RSV_ERROR_MEMORY);
    rsv_relighter_see_sky(r, sky);
    bool solved = true;
    for (size_t first = 0; first < own->count && solved; first += FIELDS_AT_ONCE) {
        size_t left = own->count - first, count = left < FIELDS_AT_ONCE ? left : FIELDS_AT_ONCE;
        RSV_TRY(solve(r, own, first, count, sky, field, &solved));
    }
    if (!solved) goto cleanup;
    *responses = own;
    own = NULL;
cleanup:
    rsv_relight_responses_destroy(own);
    rsv_free(r->context, field);
    rsv_free(r->context, sky);
    return status;
}

void rsv_relight_responses_destroy(rsv_relight_responses *own)
{
    if (!own) return;
    rsv_free(own->context, own->of_source);
    rsv_free(own->context, own->irradiance);
    rsv_free(own->context, own->shown);
    rsv_free(own->context, own);
}

void rsv_relight_responses_forget(rsv_relighter *r)
{
    rsv_relight_responses_destroy(r->responses);
    r->responses = NULL;
}

void rsv_relight_responses_combine(const rsv_relight_responses *own, const rsv_relighter *r)
{
    rsv_rgb scale[RSV_MAX_LIGHT_PARTS];
    for (size_t k = 0; k < r->basis->source_count; k++)
        scale[own->of_source[k]] = r->now.scale[k];
#pragma omp parallel for schedule(static) num_threads(rsv_threads(r->context))
    for (size_t n = 0; n < rsv_relighter_nodes(r); n++) {
        const rsv_rgb *irradiance = own->irradiance + n * own->count;
        const rsv_rgb *shown = own->shown + n * own->count;
        rsv_rgb whole = rgb_gray(0), rest = rgb_gray(0);
        for (size_t k = 0; k < own->count; k++) {
            whole = rgb_add(whole, rgb_mul(scale[k], irradiance[k]));
            rest = rgb_add(rest, rgb_mul(scale[k], shown[k]));
        }
        r->field->irradiance[n] = whole;
        r->field->indirect[n] = rest;
    }
}
