#include "light_response.h"

#include "solve_fields.h"

#include <string.h>

/// Of the residual: far below what is visible, also of a faint light that is made strong. Measured: modern_hall, where a
/// lamp has a thousandth of the light: with 1e-4, half of its texels are off by 8 % and more.
#define TOLERANCE 1e-6

typedef struct builder {
    const rsv_light *whole;
    const rsv_light_view *s; ///< of that
    const rsv_light_basis *basis;
    rsv_light_responses *r;
    size_t *group;            ///< [source_count] which response a source belongs to
    size_t gathered;          ///< the response of lamps that rows gathered
    size_t surroundings;      ///< that of the surroundings; SIZE_MAX = none
    rsv_rgb *source, *solved; ///< [node_count x responses]
} builder;

// ---- grouping -------------------------------------------------------------------------------------

static bool same(const char *a, const char *b) { return strcmp(a, b) == 0; }

/// A light's own name, unless others have the same name and its node distinguishes it.
static const char *name_of(const rsv_light_basis *basis, const rsv_source *source)
{
    bool shared = false;
    for (size_t k = 0; source->node && k < basis->source_count; k++) {
        const rsv_source *other = &basis->source[k];
        if (same(other->name, source->node)) return source->name; // which means that one
        shared = shared || (other != source && same(other->name, source->name));
    }
    return shared ? source->node : source->name;
}

static size_t find_response(const rsv_light_responses *r, const char *name, const char *definition)
{
    size_t k = 0;
    while (k < r->count && !(same(r->name[k], name) && same(r->definition[k], definition)))
        k++;
    return k;
}

static void group_sources(builder *b)
{
    b->gathered = b->surroundings = SIZE_MAX;
    for (size_t k = 0; k < b->basis->source_count; k++) {
        const rsv_source *source = &b->basis->source[k];
        const char *name = name_of(b->basis, source);
        bool gathered =
            source->kind == RSV_SOURCE_MATERIAL && rsv_is_gathered(b->s->lights, source->index);
        size_t own = find_response(b->r, name, source->name);
        if (gathered && b->gathered != SIZE_MAX) own = b->gathered;
        bool fresh = own == b->r->count;
        if (fresh) {
            b->r->definition[own] = source->name;
            b->r->scale[own] = b->basis->scale[k];
            b->r->name[b->r->count++] = name;
        }
        if (gathered) b->gathered = own;
        if (source->kind == RSV_SOURCE_SURROUNDINGS) b->surroundings = own;
        b->r->sky_last = fresh && source->kind == RSV_SOURCE_SURROUNDINGS;
        b->group[k] = own;
    }
}

// ---- direct light ---------------------------------------------------------------------------------

static void add_field(rsv_rgb *sum, rsv_rgb scale, const rsv_rgb *value, size_t count)
{
    for (size_t n = 0; sum && value && n < count; n++)
        sum[n] = rgb_add(sum[n], rgb_mul(scale, value[n]));
}

/// A light for each response, without any light yet.
static rsv_status begin_lights(const builder *b)
{
    rsv_status status = RSV_OK;
    rsv_source *own = rsv_alloc(b->s->context, b->basis->source_count, sizeof *own);
    if (!own) return RSV_ERROR_MEMORY;
    for (size_t r = 0; r < b->r->count; r++) {
        rsv_light_sources *sources = NULL;
        size_t count = 0;
        for (size_t k = 0; k < b->basis->source_count; k++)
            if (b->group[k] == r) own[count++] = b->basis->source[k];
        RSV_TRY(rsv_light_sources_select(rsv_light_get_sources(b->whole), own, count, &sources));
        status = rsv_light_begin_like(b->whole, sources, &b->r->light[r]);
        rsv_light_sources_release(sources);
        RSV_TRY(status);
        b->r->view[r] = rsv_light_get_view(b->r->light[r]);
    }
cleanup:
    rsv_free(b->s->context, own);
    return status;
}

/// Divides gathered light: of lamps and, for the rest, of the environment.
static void divide_gathered(const builder *b)
{
    const rsv_light_view *s = b->s;
    for (size_t n = 0; n < s->elements->node_count; n++) {
        rsv_rgb lamps = rgb_gray(0);
        if (b->gathered != SIZE_MAX) {
            lamps = rgb_mul(s->transport->gathered[n], s->gathered_scale);
            rsv_light_edit(b->r->light[b->gathered])->gathered[n] = lamps;
        }
        if (b->surroundings != SIZE_MAX) {
            rsv_rgb *own = &rsv_light_edit(b->r->light[b->surroundings])->gathered[n];
            *own = rgb_add(*own, rgb_sub(s->gathered[n], lamps));
        }
    }
    for (size_t k = 0; k < b->r->count; k++)
        rsv_elements_constrain(s->elements, rsv_light_edit(b->r->light[k])->gathered);
}

static void divide_direct(const builder *b)
{
    const rsv_light_view *s = b->s;
    size_t nodes = s->elements->node_count;
    for (size_t k = 0; k < b->basis->source_count; k++) {
        const rsv_light_part *part = &b->basis->part[k];
        const rsv_light_fields *light = rsv_light_edit(b->r->light[b->group[k]]);
        rsv_rgb scale = b->basis->scale[k];
        add_field(light->source, scale, part->direct, nodes);
        add_field(light->source, scale, part->coarse_caustic, nodes);
        if (s->fine.direct)
            add_field(light->fine.direct, scale, part->fine, s->fine.elements->node_count);
        if (s->caustics.caustic)
            add_field(
                light->caustics.caustic, scale, part->caustic, s->caustics.elements->node_count);
    }
    divide_gathered(b);
    for (size_t k = 0; k < b->r->count; k++) {
        const rsv_light_fields *light = rsv_light_edit(b->r->light[k]);
        add_field(light->source, rgb_gray(1), light->gathered, nodes);
    }
}

// ---- bounces --------------------------------------------------------------------------------------

/// All responses at once: they share every pass over G.
static rsv_status solve(builder *b)
{
    const rsv_light_view *s = b->s;
    size_t nodes = s->elements->node_count, count = b->r->count;
    b->source = rsv_alloc(s->context, nodes, count * sizeof *b->source);
    b->solved = rsv_alloc(s->context, nodes, count * sizeof *b->solved);
    if (!b->source || !b->solved) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < nodes; n++)
        for (size_t k = 0; k < count; k++)
            b->source[n * count + k] = b->r->view[k]->source[n];
    return rsv_solve_fields(s, count, TOLERANCE, b->source, b->solved, NULL);
}

static float share(float part, float sum, size_t count)
{
    return sum > 0 ? part / sum : 1 / (float)count;
}

/// Divides displayed indirect light in proportion to the solved light of each response.
static void divide_indirect(const builder *b)
{
    const rsv_light_view *s = b->s;
    size_t count = b->r->count;
    for (size_t n = 0; n < s->elements->node_count; n++) {
        const rsv_rgb *source = b->source + n * count, whole = s->indirect[n];
        rsv_rgb *part = b->solved + n * count, sum = rgb_gray(0);
        for (size_t k = 0; k < count; k++) {
            rsv_rgb rest = rgb_sub(part[k], source[k]);
            part[k] = rgb_positive(rest);
            sum = rgb_add(sum, part[k]);
        }
        for (size_t k = 0; k < count; k++)
            rsv_light_edit(b->r->light[k])->indirect[n] =
                rgb_mul(whole, rgb(share(part[k].r, sum.r, count), share(part[k].g, sum.g, count),
                                   share(part[k].b, sum.b, count)));
    }
    for (size_t k = 0; k < count; k++)
        rsv_elements_constrain(s->elements, rsv_light_edit(b->r->light[k])->indirect);
}

/// Light of translucent surfaces for each response.
static rsv_status diffuse(const builder *b)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < b->r->count && b->s->diffused.elements; k++)
        RSV_TRY(rsv_light_diffuse(b->r->light[k]));
cleanup:
    return status;
}

// ---- the whole ------------------------------------------------------------------------------------

static rsv_status create_groups(builder *b)
{
    size_t sources = b->basis->source_count;
    rsv_status status = rsv_light_basis_check(b->whole, b->basis);
    if (status != RSV_OK) return status;
    b->group = rsv_alloc(b->s->context, sources, sizeof *b->group);
    b->r->name = rsv_alloc(b->s->context, sources, sizeof *b->r->name);
    b->r->definition = rsv_alloc(b->s->context, sources, sizeof *b->r->definition);
    b->r->scale = rsv_alloc(b->s->context, sources, sizeof *b->r->scale);
    b->r->light = rsv_alloc(b->s->context, sources, sizeof *b->r->light);
    b->r->view = rsv_alloc(b->s->context, sources, sizeof *b->r->view);
    bool named = b->group && b->r->name && b->r->definition && b->r->scale;
    if (!named || !b->r->light || !b->r->view) return RSV_ERROR_MEMORY;
    group_sources(b);
    return RSV_OK;
}

static rsv_status divide(builder *b)
{
    rsv_status status;
    RSV_TRY(begin_lights(b));
    divide_direct(b);
    RSV_TRY(solve(b));
    divide_indirect(b);
    RSV_TRY(diffuse(b));
cleanup:
    return status;
}

rsv_status rsv_light_responses_count(const rsv_light *whole, size_t *count)
{
    rsv_status status;
    const rsv_light_view *s = rsv_light_get_view(whole);
    rsv_light_basis *sources = NULL;
    builder b = { .whole = whole, .s = s, .r = rsv_alloc(s->context, 1, sizeof *b.r) };
    RSV_TRY(b.r ? RSV_OK : RSV_ERROR_MEMORY);
    b.r->context = s->context;
    RSV_TRY(rsv_light_basis_create_empty(whole, &sources));
    b.basis = sources;
    RSV_TRY(create_groups(&b));
    *count = b.r->count;
cleanup:
    rsv_free(s->context, b.group);
    rsv_light_responses_destroy(b.r);
    rsv_light_basis_destroy(sources);
    return status;
}

rsv_status rsv_light_responses_create(const rsv_light *whole, rsv_light_responses **responses)
{
    rsv_status status;
    const rsv_light_view *s = rsv_light_get_view(whole);
    rsv_light_basis *own = NULL;
    builder b = { .whole = whole,
        .s = s,
        .basis = rsv_light_basis_is_known(s->basis) ? s->basis : NULL,
        .r = rsv_alloc(s->context, 1, sizeof *b.r) };
    RSV_TRY(b.r ? RSV_OK : RSV_ERROR_MEMORY);
    b.r->context = s->context;
    if (!b.basis) RSV_TRY(rsv_light_basis_create(whole, &own));
    if (!b.basis) b.basis = own;
    RSV_TRY(create_groups(&b));
    if (b.basis->source_count > 1) RSV_TRY(rsv_light_require_parts(s));
    if (b.basis->source_count == 1)
        b.r->view[0] = s; // a single source is the total
    else
        RSV_TRY(divide(&b));
    *responses = b.r;
    b.r = NULL;
cleanup:
    rsv_light_responses_destroy(b.r);
    rsv_light_basis_destroy(own);
    rsv_free(s->context, b.group);
    rsv_free(s->context, b.source);
    rsv_free(s->context, b.solved);
    return status;
}

void rsv_light_responses_destroy(rsv_light_responses *r)
{
    if (!r) return;
    for (size_t k = 0; r->light && k < r->count; k++)
        rsv_light_destroy(r->light[k]);
    rsv_free(r->context, r->light);
    rsv_free(r->context, r->view);
    rsv_free(r->context, r->name);
    rsv_free(r->context, r->definition);
    rsv_free(r->context, r->scale);
    rsv_free(r->context, r);
}
