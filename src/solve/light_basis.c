#include "light_basis.h"

#include "../direct/direct_preview.h"
#include "../direct/voxel_direct.h"
#include "../elements/burial.h"
#include "light_internal.h"
#include "solve_constants.h"

#include <string.h>

enum { DIRECT, COARSE_CAUSTIC, FINE, CAUSTIC };

rsv_rgb **rsv_light_part_field(rsv_light_part *part, size_t field)
{
    rsv_rgb **const fields[RSV_LIGHT_FIELDS] = { &part->direct, &part->coarse_caustic, &part->fine,
        &part->caustic };
    return fields[field];
}

size_t rsv_light_field_length(const rsv_light *s, size_t field)
{
    switch (field) {
    case DIRECT:
        return s->elements->node_count;
    case COARSE_CAUSTIC:
        return s->field.caustics.elements ? s->elements->node_count : 0;
    case FINE:
        return s->field.fine.elements ? s->field.fine.elements->node_count : 0;
    default:
        return s->field.caustics.elements ? s->field.caustics.elements->node_count : 0;
    }
}

rsv_rgb *rsv_light_field(const rsv_light *s, size_t field)
{
    rsv_rgb *const fields[RSV_LIGHT_FIELDS] = { s->field.source, s->field.caustics.coarse_caustic,
        s->field.fine.direct, s->field.caustics.caustic };
    return fields[field];
}

static float positive(float value) { return f_max(value, 0); }

void rsv_light_total(const rsv_light *s, size_t field, rsv_rgb *total)
{
    size_t length = rsv_light_field_length(s, field);
    if (length) memcpy(total, rsv_light_field(s, field), length * sizeof *total);
    for (size_t n = 0; field == DIRECT && n < length; n++) {
        rsv_rgb rest = rgb_sub(total[n], s->field.gathered[n]);
        if (s->field.caustics.coarse_caustic)
            rest = rgb_sub(rest, s->field.caustics.coarse_caustic[n]);
        total[n] = rgb(positive(rest.r), positive(rest.g), positive(rest.b));
    }
}

const rsv_rgb *rsv_source_strength(const rsv_scene_view *scene, const rsv_source *source)
{
    switch (source->kind) {
    case RSV_SOURCE_MATERIAL:
        return &scene->material[source->index].emission;
    case RSV_SOURCE_LIGHT:
        return &scene->light[source->index].intensity;
    default:
        return NULL;
    }
}

rsv_status rsv_light_basis_allocate(rsv_context *context, size_t count, rsv_light_basis **basis)
{
    rsv_light_basis *b = *basis = rsv_alloc(context, 1, sizeof *b);
    if (!b) return RSV_ERROR_MEMORY;
    b->context = context;
    b->source_count = count;
    b->gathered_scale = rgb_gray(1);
    b->source = rsv_alloc(context, count, sizeof *b->source);
    b->part = rsv_alloc(context, count, sizeof *b->part);
    b->scale = rsv_alloc(context, count, sizeof *b->scale);
    b->strength = rsv_alloc(context, count, sizeof *b->strength);
    b->gathered = rsv_alloc(context, count, sizeof *b->gathered);
    b->stale = rsv_alloc(context, count, sizeof *b->stale);
    bool complete = b->source && b->part && b->scale && b->strength && b->gathered && b->stale;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Records the present strength of a source.
static void note_source(const rsv_light *s, const rsv_source *source, rsv_light_basis *b, size_t k)
{
    const rsv_rgb *strength = rsv_source_strength(s->scene.view, source);
    b->source[k] = *source;
    b->scale[k] = rgb_gray(1);
    b->strength[k] = strength ? *strength : rgb_gray(1);
    b->gathered[k] =
        source->kind == RSV_SOURCE_MATERIAL && rsv_is_gathered(s->sources->lights, source->index);
}

rsv_status rsv_light_basis_create_empty(const rsv_light *s, rsv_light_basis **basis)
{
    rsv_status status;
    rsv_source *source = NULL;
    rsv_light_basis *b = NULL;
    size_t count = 0;
    RSV_TRY(rsv_list_sources(s->sources->lights, &source, &count));
    RSV_TRY(rsv_light_basis_allocate(s->context, count, &b));
    for (size_t k = 0; k < count; k++)
        note_source(s, &source[k], b, k);
    b->gathered_scale = s->gathered_scale;
    *basis = b;
    b = NULL;
cleanup:
    rsv_light_basis_destroy(b);
    rsv_free(s->context, source);
    return status;
}

void rsv_light_part_free(rsv_context *context, rsv_light_part *part)
{
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        rsv_free(context, *rsv_light_part_field(part, field));
}

void rsv_light_basis_destroy(rsv_light_basis *b)
{
    if (!b) return;
    for (size_t k = 0; b->part && k < b->source_count; k++)
        rsv_light_part_free(b->context, &b->part[k]);
    rsv_free(b->context, b->part);
    rsv_free(b->context, b->scale);
    rsv_free(b->context, b->strength);
    rsv_free(b->context, b->gathered);
    rsv_free(b->context, b->stale);
    rsv_free(b->context, b->environment);
    rsv_free(b->context, b->source);
    rsv_free(b->context, b);
}

bool rsv_light_basis_is_scaled(const rsv_light_basis *b)
{
    bool any = false;
    for (size_t k = 0; k < b->source_count; k++)
        any = any || b->scale[k].r != 1 || b->scale[k].g != 1 || b->scale[k].b != 1;
    return any;
}

bool rsv_light_basis_is_known(const rsv_light_basis *b)
{
    bool any = false;
    for (size_t k = 0; b && k < b->source_count; k++)
        any = any || b->stale[k];
    return b && !any;
}

void rsv_light_basis_name_sources(rsv_light_basis *b, const rsv_scene_view *scene)
{
    for (size_t k = 0; k < b->source_count; k++) {
        rsv_source *source = &b->source[k];
        if (source->kind == RSV_SOURCE_MATERIAL)
            source->name = scene->material[source->index].name;
        else if (source->kind == RSV_SOURCE_LIGHT)
            source->name = scene->light[source->index].name;
        else
            source->name = "environment";
        source->node = source->kind == RSV_SOURCE_LIGHT ? scene->light_node[source->index] : NULL;
    }
}

/// @param copy out, freed by the caller; NULL if there is nothing to copy
static rsv_status copy_field(
    rsv_context *context, const rsv_rgb *from, size_t length, rsv_rgb **copy)
{
    if (!from || !length) return RSV_OK;
    *copy = rsv_alloc(context, length, sizeof **copy);
    if (!*copy) return RSV_ERROR_MEMORY;
    memcpy(*copy, from, length * sizeof **copy);
    return RSV_OK;
}

static rsv_status copy_part(const rsv_light *s, rsv_light_part *from, rsv_light_part *to)
{
    rsv_status status = RSV_OK;
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        RSV_TRY(copy_field(s->context, *rsv_light_part_field(from, field),
            rsv_light_field_length(s, field), rsv_light_part_field(to, field)));
cleanup:
    return status;
}

rsv_status rsv_light_basis_copy(
    const rsv_light_basis *from, const rsv_light *s, rsv_light_basis **copy)
{
    rsv_status status;
    rsv_light_basis *b = NULL;
    size_t count = from->source_count;
    const rsv_environment *sky = s->scene.view->environment;
    RSV_TRY(rsv_light_basis_allocate(s->context, count, &b));
    b->gathered_scale = from->gathered_scale;
    for (size_t k = 0; k < count; k++) {
        b->source[k] = from->source[k];
        b->scale[k] = from->scale[k];
        b->strength[k] = from->strength[k];
        b->gathered[k] = from->gathered[k];
        b->stale[k] = from->stale[k];
        RSV_TRY(copy_part(s, &from->part[k], &b->part[k]));
    }
    if (sky)
        RSV_TRY(copy_field(
            s->context, from->environment, (size_t)sky->width * sky->height, &b->environment));
    rsv_light_basis_name_sources(b, s->scene.view);
    *copy = b;
    b = NULL;
cleanup:
    rsv_light_basis_destroy(b);
    return status;
}

static size_t bytes_of_parts(const rsv_light *s, const rsv_light_basis *b)
{
    size_t values = 0;
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        values += rsv_light_field_length(s, field);
    return b->source_count * values * sizeof(rsv_rgb);
}

bool rsv_light_keeps_parts(const rsv_light *s, const rsv_light_basis *b)
{
    return b->source_count > 1 && rsv_light_has_parts(&s->view) &&
           bytes_of_parts(s, b) <= RSV_MAX_PART_BYTES;
}

rsv_status rsv_light_basis_check(const rsv_light *s, const rsv_light_basis *b)
{
    size_t bytes = bytes_of_parts(s, b);
    if (bytes <= RSV_MAX_PART_BYTES) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "relight: storing its %zu lights separately takes %.1f GiB, more than the %.0f GiB "
        "available; "
        "solve with fewer elements (--quality draft, --max-elements), or join lights",
        b->source_count, (double)bytes / 1073741824, (double)RSV_MAX_PART_BYTES / 1073741824);
}

static rsv_status allocate_part(const rsv_light *s, rsv_light_part *part)
{
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++) {
        size_t length = rsv_light_field_length(s, field);
        rsv_rgb **array = rsv_light_part_field(part, field);
        if (length && !*array) *array = rsv_alloc(s->context, length, sizeof **array);
        if (length && !*array) return RSV_ERROR_MEMORY;
    }
    return RSV_OK;
}

static rsv_status shoot_subset(const rsv_light *s, const rsv_lights *subset, uint32_t photons,
    rsv_light_part *part, uint64_t *rays)
{
    rsv_photon_map map[2] = { 0 };
    const rsv_elements *const targets[2] = { s->field.caustics.elements, s->elements };
    rsv_status status = rsv_photons_shoot(&s->scene, subset, photons, rsv_level_seed(s->desc.seed),
        &(rsv_photon_targets){ targets, map, 2 }, rays);
    if (status == RSV_OK) {
        rsv_photon_map_irradiance(&map[0], part->caustic);
        rsv_photon_map_irradiance(&map[1], part->coarse_caustic);
    }
    rsv_photon_map_destroy(&map[0]);
    rsv_photon_map_destroy(&map[1]);
    return status;
}

rsv_light_effort rsv_full_light_effort(const rsv_light *s, const uint16_t *valid)
{
    return (rsv_light_effort){ .coarse_samples = RSV_COARSE_LIGHT_FACTOR * s->desc.light_samples,
        .fine_samples = RSV_PENUMBRA_FACTOR * s->desc.light_samples,
        .photons = s->desc.photon_count,
        .valid = valid };
}

static rsv_direct_job job_of(
    const rsv_light *s, const rsv_lights *subset, bool fine, const rsv_light_effort *effort)
{
    rsv_direct_job job = { .scene = &s->scene,
        .elements = s->elements,
        .setting = { subset, s->scene.bsdf, RSV_SUPPORT_POINTS, s->desc.seed },
        .samples = effort->coarse_samples,
        .valid_points = s->view.valid_points };
    if (!fine) return job;
    job.elements = s->field.fine.elements;
    job.setting.points = RSV_LEVEL_POINTS;
    job.setting.seed = rsv_level_seed(s->desc.seed);
    job.samples = effort->fine_samples;
    job.valid_points = effort->valid;
    job.whole = effort->fine_whole;
    return job;
}

/// The light of surfaces: by a preview where that will do.
static rsv_status estimate_surfaces(const rsv_direct_job *job, const rsv_receiver_blocks *blocks,
    rsv_rgb *irradiance, uint64_t *rays)
{
    const rsv_lights *subset = job->setting.lights;
    const uint8_t *known = NULL;
    if (blocks && rsv_can_preview(subset)) {
        rsv_status status = rsv_direct_preview(blocks, subset, irradiance, rays);
        if (status == RSV_OK && blocks->holds_all)
            rsv_elements_constrain(job->elements, irradiance);
        if (status != RSV_OK || blocks->holds_all) return status;
        known = blocks->held;
    }
    rsv_direct_light light = { .irradiance = irradiance };
    rsv_status status = rsv_direct_irradiance(job, known, &light);
    *rays += light.rays;
    return status;
}

/// The light of one level, that of voxels included.
static rsv_status estimate_level(const rsv_light *s, const rsv_lights *subset, bool fine,
    const rsv_light_effort *effort, rsv_rgb *irradiance, uint64_t *rays)
{
    const rsv_direct_job job = job_of(s, subset, fine, effort);
    rsv_status status =
        estimate_surfaces(&job, fine ? effort->fine : effort->coarse, irradiance, rays);
    if (status != RSV_OK || !job.elements->voxels) return status;
    return rsv_voxel_direct(&job, irradiance, rays);
}

rsv_status rsv_light_part_estimate(const rsv_light *s, const rsv_lights *lights,
    const rsv_source *source, const rsv_light_effort *effort, rsv_light_part *part, uint64_t *rays)
{
    rsv_status status;
    rsv_lights *subset = NULL;
    RSV_TRY(allocate_part(s, part));
    RSV_TRY(rsv_light_subset_create(lights, source, 1, &subset));
    RSV_TRY(estimate_level(s, subset, false, effort, part->direct, rays));
    if (part->fine) RSV_TRY(estimate_level(s, subset, true, effort, part->fine, rays));
    if (part->caustic) RSV_TRY(shoot_subset(s, subset, effort->photons, part, rays));
cleanup:
    rsv_light_subset_destroy(subset);
    return status;
}

rsv_status rsv_find_fine_valid(const rsv_light *s, uint16_t **valid)
{
    uint64_t rays = 0;
    *valid = NULL;
    if (!s->field.fine.elements) return RSV_OK;
    *valid = rsv_alloc(s->context, s->field.fine.elements->node_count, sizeof **valid);
    if (!*valid) return RSV_ERROR_MEMORY;
    return rsv_find_buried(&s->scene, s->field.fine.elements,
        (rsv_support_draw){ RSV_LEVEL_POINTS, rsv_level_seed(s->desc.seed) }, NULL, *valid, &rays);
}

/// value's share of sum; equal shares where nothing was found by anyone.
static float share(float value, float sum, size_t count)
{
    return sum > 0 ? value / sum : 1 / (float)count;
}

/// The elements of a level whose field this is; NULL = of the coarse ones.
static const rsv_elements *level_of(const rsv_light *s, size_t field)
{
    if (field == FINE) return s->field.fine.elements;
    return field == CAUSTIC ? s->field.caustics.elements : NULL;
}

/// @param total out, of a field; freed by the caller
static rsv_status create_total(const rsv_light *s, size_t field, rsv_rgb **total)
{
    *total = rsv_alloc(s->context, rsv_light_field_length(s, field), sizeof **total);
    if (!*total) return RSV_ERROR_MEMORY;
    rsv_light_total(s, field, *total);
    return RSV_OK;
}

/// Divides a field in proportion to the separate estimates of the sources. On levels, every part is as continuous as
/// the total, so that finer elements can represent it exactly.
static rsv_status divide(const rsv_light *s, rsv_light_basis *b, size_t field)
{
    size_t length = rsv_light_field_length(s, field), count = b->source_count;
    rsv_rgb *total;
    rsv_status status = create_total(s, field, &total);
    if (status != RSV_OK) return status;
    for (size_t n = 0; n < length; n++) {
        rsv_rgb sum = rgb_gray(0);
        for (size_t k = 0; k < count; k++)
            sum = rgb_add(sum, (*rsv_light_part_field(&b->part[k], field))[n]);
        for (size_t k = 0; k < count; k++) {
            rsv_rgb *value = *rsv_light_part_field(&b->part[k], field) + n;
            *value =
                rgb_mul(total[n], rgb(share(value->r, sum.r, count), share(value->g, sum.g, count),
                                      share(value->b, sum.b, count)));
        }
    }
    rsv_free(s->context, total);
    const rsv_elements *level = level_of(s, field);
    for (size_t k = 0; level && k < count; k++)
        rsv_elements_constrain(level, *rsv_light_part_field(&b->part[k], field));
    return RSV_OK;
}

/// Estimates all parts. On levels, with no more rays than it takes to say how the light of the whole is divided; coarse
/// elements are few, and each one affects all others.
static rsv_status estimate_parts(const rsv_light *s, rsv_light_basis *b)
{
    rsv_status status;
    uint16_t *valid = NULL;
    uint64_t rays = 0;
    rsv_rgb *fine = NULL;
    RSV_TRY(rsv_find_fine_valid(s, &valid));
    if (s->field.fine.elements) RSV_TRY(create_total(s, FINE, &fine));
    rsv_light_effort effort = rsv_full_light_effort(s, valid);
    effort.fine_whole = fine;
    if (b->source_count > RSV_FULL_PHOTON_SOURCES)
        effort.photons =
            (uint32_t)((uint64_t)effort.photons * RSV_FULL_PHOTON_SOURCES / b->source_count) + 1;
    for (size_t k = 0; k < b->source_count; k++)
        RSV_TRY(rsv_light_part_estimate(
            s, s->sources->lights, &b->source[k], &effort, &b->part[k], &rays));
cleanup:
    rsv_free(s->context, valid);
    rsv_free(s->context, fine);
    return status;
}

rsv_status rsv_light_basis_create(const rsv_light *s, rsv_light_basis **basis)
{
    rsv_status status;
    rsv_light_basis *b = NULL;
    RSV_TRY(rsv_light_basis_create_empty(s, &b));
    bool many = rsv_light_keeps_parts(s, b);
    if (many) RSV_TRY(estimate_parts(s, b));
    for (size_t field = 0; many && field < RSV_LIGHT_FIELDS; field++)
        RSV_TRY(divide(s, b, field));
    *basis = b;
    b = NULL;
cleanup:
    rsv_light_basis_destroy(b);
    return status;
}
