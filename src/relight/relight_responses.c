#include "relight_responses.h"

#include "../core/parallel.h"
#include "../solve/sharpen.h"
#include "solve_fields.h"

/// Of the residual: far below what is visible.
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

/// E0 of one response, 0 at hanging nodes. @param sky [node_count] light of the environment that rows gathered
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
        field[n] =
            rgb_add(field[n], rgb_mul(r->s->transport->gathered[n], r->basis->gathered_scale));
}

/// Responses `first` to `first + count`, solved for together.
typedef struct batch {
    rsv_relighter *r;
    rsv_relight_responses *own;
    size_t first, count;
    const rsv_rgb *sky;       ///< [node_count] light of the environment that rows gathered
    rsv_rgb *field;           ///< [node_count] scratch
    rsv_rgb *source, *solved; ///< [node_count x count]
} batch;

/// E0 of each, side by side for the solver.
static void collect_sources(const batch *b)
{
    const rsv_relighter *r = b->r;
    size_t nodes = rsv_relighter_nodes(r);
    for (size_t f = 0; f < b->count; f++) {
        bool gathers = false;
        for (size_t n = 0; n < nodes; n++)
            b->field[n] = rgb_gray(0);
        for (size_t k = 0; k < r->basis->source_count; k++) {
            if (b->own->of_source[k] != b->first + f) continue;
            add_source(r, k, b->sky, b->field);
            gathers = gathers || is_gathered(r, k);
        }
        if (gathers) add_gathered(r, b->field);
        for (size_t n = 0; n < nodes; n++)
            b->source[n * b->count + f] = b->field[n];
    }
}

/// Stores the solutions, complete and as displayed.
static void keep(const batch *b)
{
    const rsv_elements *e = b->r->s->elements;
    rsv_rgb *field = b->field;
    for (size_t f = 0; f < b->count; f++) {
        size_t at = b->first + f, all = b->own->count;
        for (size_t n = 0; n < e->node_count; n++)
            field[n] = b->solved[n * b->count + f];
        rsv_elements_constrain(e, field);
        for (size_t n = 0; n < e->node_count; n++)
            b->own->irradiance[n * all + at] = field[n];
        for (size_t n = 0; n < e->node_count; n++) {
            rsv_rgb rest = rgb_sub(b->solved[n * b->count + f], b->source[n * b->count + f]);
            field[n] = rgb_positive(rest);
        }
        rsv_elements_constrain(e, field);
        rsv_sharpen(e, field, b->r->next, b->r->scratch);
        for (size_t n = 0; n < e->node_count; n++)
            b->own->shown[n * all + at] = field[n];
    }
}

/// @param solved_all is cleared where the solver fails
static rsv_status solve(batch *b, bool *solved_all)
{
    rsv_status status;
    bool reached;
    rsv_context *context = b->r->context;
    size_t nodes = rsv_relighter_nodes(b->r);
    b->source = rsv_alloc(context, nodes, b->count * sizeof *b->source);
    b->solved = rsv_alloc(context, nodes, b->count * sizeof *b->solved);
    RSV_TRY(b->source && b->solved ? RSV_OK : RSV_ERROR_MEMORY);
    collect_sources(b);
    RSV_TRY(rsv_solve_fields(b->r->s, b->count, TOLERANCE, b->source, b->solved, &reached));
    *solved_all = *solved_all && reached;
    keep(b);
cleanup:
    rsv_free(context, b->source);
    rsv_free(context, b->solved);
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
    own->of_source = rsv_alloc(r->context, r->basis->source_count, sizeof *own->of_source);
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
        RSV_TRY(solve(&(batch){ r, own, first, count, sky, field, NULL, NULL }, &solved));
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

typedef struct combine_job {
    const rsv_relight_responses *responses;
    const rsv_relighter *relighter;
} combine_job;

static void weigh_responses(void *data, rsv_span span)
{
    const combine_job *job = data;
    const rsv_relight_responses *own = job->responses;
    const rsv_relighter *r = job->relighter;
    const rsv_rgb *scale = r->factor;
    for (size_t n = span.begin; n < span.end; n++) {
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

void rsv_relight_responses_combine(const rsv_relight_responses *own, const rsv_relighter *r)
{
    for (size_t k = 0; k < r->basis->source_count; k++)
        r->factor[own->of_source[k]] = r->now.scale[k];
    combine_job job = { own, r };
    rsv_parallel_for(r->context, rsv_relighter_nodes(r), 0, weigh_responses, &job);
}
