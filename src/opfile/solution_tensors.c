/// G, K, sources and solution.
#include "../operator/transport_lists.h"
#include "../solve/goal.h"
#include "../solve/solve_desc.h"
#include "exchange.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])

// clang-format off
#define DESC_FIELD(kind, field)                                                                    \
    { #field, kind, offsetof(rsv_solve_desc, field), sizeof((rsv_solve_desc *)0)->field }
#define REPORT_FIELD(kind, field)                                                                  \
    { #field, kind, offsetof(rsv_solve_report, field), sizeof((rsv_solve_report *)0)->field }
// clang-format on

static const rsv_field desc_fields[] = {
    DESC_FIELD(RSV_FIELD_U32, element_target),
    DESC_FIELD(RSV_FIELD_U32, rays_per_element),
    DESC_FIELD(RSV_FIELD_U32, refinements),
    DESC_FIELD(RSV_FIELD_U32, light_samples),
    DESC_FIELD(RSV_FIELD_U32, photon_count),
    DESC_FIELD(RSV_FIELD_U32, direct_levels),
    DESC_FIELD(RSV_FIELD_BOOL, direct_level),
    DESC_FIELD(RSV_FIELD_U32, solver),
    DESC_FIELD(RSV_FIELD_U32, max_orders),
    DESC_FIELD(RSV_FIELD_FLOAT, tolerance),
    DESC_FIELD(RSV_FIELD_U32, seed),
    DESC_FIELD(RSV_FIELD_U32, goal_camera),
    DESC_FIELD(RSV_FIELD_U64, max_elements),
    DESC_FIELD(RSV_FIELD_U64, max_bytes),
};

static const rsv_field report_fields[] = {
    REPORT_FIELD(RSV_FIELD_U32, stop_reason),
    REPORT_FIELD(RSV_FIELD_U64, elements),
    REPORT_FIELD(RSV_FIELD_U64, direct_elements),
    REPORT_FIELD(RSV_FIELD_U64, rows),
    REPORT_FIELD(RSV_FIELD_U32, rays_per_row),
    REPORT_FIELD(RSV_FIELD_U64, entries),
    REPORT_FIELD(RSV_FIELD_U64, rays),
    REPORT_FIELD(RSV_FIELD_U32, iterations),
    REPORT_FIELD(RSV_FIELD_U32, solver),
    REPORT_FIELD(RSV_FIELD_TEXT, solver_reason),
    REPORT_FIELD(RSV_FIELD_DOUBLE, norm_inf),
    REPORT_FIELD(RSV_FIELD_DOUBLE, spectral_radius),
    REPORT_FIELD(RSV_FIELD_U32, neumann_terms),
    REPORT_FIELD(RSV_FIELD_DOUBLE, residual_inf),
    REPORT_FIELD(RSV_FIELD_DOUBLE, truncation_bound),
    REPORT_FIELD(RSV_FIELD_DOUBLE, mean_irradiance),
};

_Static_assert(sizeof(rsv_solver) == 4 && sizeof(rsv_stop_reason) == 4, "enumerations are U32");

/// Operator and light of a file: owned while reading, borrowed while writing.
typedef struct parts {
    rsv_elements *elements;
    rsv_transport *transport;
    rsv_subsurface *subsurface;
    uint16_t *valid_points;
    rsv_rgb *albedo;
    rsv_light_fields field;
    rsv_solve_desc desc;
    rsv_probe *goal_points;
    rsv_solve_report report;
} parts;

// ---- reading and writing -------------------------------------------------------------------------

rsv_status rsv_exchange_rgb(
    rsv_tensor_file *file, const char *name, rsv_rgb **field, size_t count, float least)
{
    rsv_status status = rsv_tensor_exchange_optional(file, name, RSV_TENSOR_F32, 3, field, &count);
    if (status == RSV_OK && file->reading && *field)
        status = rsv_check_numbers(file, name, &(*field)->r, 3 * count, least);
    return status;
}

rsv_status rsv_exchange_needed(const rsv_tensor_file *file, const char *name, const void *array)
{
    return array ? RSV_OK : rsv_tensor_fail(file, name, "is missing");
}

/// Compressed rows: starts, columns or bins below `bound`, and weights where there are any.
typedef struct row_tensors {
    const char *name;
    rsv_tensor_type type; ///< U32 columns or U16 bins
    size_t rows, bound;
    const rsv_transport *divided; ///< whose rows other processes have some of; NULL = all are here
} row_tensors;

static rsv_status exchange_rows(
    rsv_tensor_file *file, const row_tensors *t, size_t **begin, void *column, rsv_rgb **weight)
{
    rsv_tensor_type type = t->type;
    size_t rows = t->rows, bound = t->bound;
    const rsv_transport *divided = t->divided;
    char start_name[64], column_name[64], weight_name[64];
    size_t starts = rows + 1, entries = file->reading ? RSV_ANY_COUNT : (*begin)[rows];
    size_t *whole = NULL;
    snprintf(start_name, sizeof start_name, "%srow_start", t->name);
    snprintf(column_name, sizeof column_name, "%s%s", t->name,
        type == RSV_TENSOR_U16 ? "bin" : "column");
    snprintf(weight_name, sizeof weight_name, "%sweight", t->name);
    rsv_status status;
    if (divided) {
        RSV_TRY(rsv_transport_whole_begin(divided, *begin, &whole));
        entries = whole[rows];
        RSV_TRY(rsv_tensor_give(file, start_name, RSV_TENSOR_U64, 1, starts, whole));
    } else {
        RSV_TRY(rsv_tensor_exchange(file, start_name, RSV_TENSOR_U64, 1, begin, &starts));
    }
    RSV_TRY(rsv_tensor_exchange(file, column_name, type, 1, column, &entries));
    if (divided) rsv_tensor_divide(file, rows, *begin, whole);
    if (weight)
        RSV_TRY(rsv_tensor_exchange(file, weight_name, RSV_TENSOR_F32, 3, weight, &entries));
    if (weight && divided) rsv_tensor_divide(file, rows, *begin, whole);
    if (!file->reading) return RSV_OK;
    if (weight)
        RSV_TRY(rsv_check_numbers(file, weight_name, &(*weight)->r, 3 * entries, -INFINITY));
    RSV_TRY(rsv_check_rows(file, start_name, *begin, rows, entries));
    if (type == RSV_TENSOR_U32)
        RSV_TRY(rsv_check_indices(file, column_name, *(uint32_t **)column, entries, bound));
    for (size_t k = 0; type == RSV_TENSOR_U16 && k < entries; k++)
        if ((*(uint16_t **)column)[k] >= bound)
            RSV_TRY(rsv_tensor_fail(
                file, column_name, "refers to bin %u of %zu", (*(uint16_t **)column)[k], bound));
cleanup:
    return status;
}

/// Emission that rows gathered; written at its present strength. @param scale factor of the stored strength
static rsv_status exchange_gathered(rsv_tensor_file *file, rsv_transport *t, rsv_rgb scale)
{
    rsv_status status;
    bool kept = scale.r == 1 && scale.g == 1 && scale.b == 1;
    if (file->reading || kept) {
        status = rsv_exchange_rgb(file, "gathered", &t->gathered, t->row_count, 0);
        return status == RSV_OK ? rsv_exchange_needed(file, "gathered", t->gathered) : status;
    }
    rsv_rgb *scaled = rsv_alloc(file->context, t->row_count, sizeof *scaled);
    for (size_t n = 0; scaled && n < t->row_count; n++)
        scaled[n] = rgb_mul(t->gathered[n], scale);
    return rsv_tensor_give(file, "gathered", RSV_TENSOR_F32, 3, t->row_count, scaled);
}

static rsv_status exchange_transport(
    rsv_tensor_file *file, rsv_transport *t, rsv_rgb gathered_scale)
{
    rsv_status status;
    size_t rows = t->row_count;
    rsv_transport_list list[RSV_TRANSPORT_LISTS];
    if (!rsv_transport_list_rows(t, list))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "%s: rows that are not kept as they were traced have no form in files", file->path);
    for (size_t k = 0; k < RSV_TRANSPORT_LISTS; k++) {
        const rsv_transport_list *l = &list[k];
        rsv_tensor_type type = l->bin ? RSV_TENSOR_U16 : RSV_TENSOR_U32;
        void *items = l->bin ? (void *)l->bin : (void *)l->column;
        const row_tensors tensors = { l->name, type, rows, l->bound, t->division ? t : NULL };
        rsv_tensor_prefix(file, NULL);
        RSV_TRY(exchange_rows(file, &tensors, l->begin, items, l->weight));
        if (k != 1) continue;
        rsv_tensor_prefix(file, "transport.");
        RSV_TRY(rsv_tensor_exchange(file, "scale", RSV_TENSOR_F32, 1, &t->scale, &rows));
        if (file->reading) RSV_TRY(rsv_check_numbers(file, "scale", t->scale, rows, 0));
        RSV_TRY(exchange_gathered(file, t, gathered_scale));
    }
    if (file->reading) rsv_transport_filled(t);
cleanup:
    return status;
}

/// E0, its gathered part, E and its orders on the coarse elements.
static rsv_status exchange_system(rsv_tensor_file *file, parts *p)
{
    rsv_status status;
    size_t nodes = p->elements->node_count, valid = nodes;
    char name[32];
    rsv_tensor_prefix(file, NULL);
    RSV_TRY(rsv_exchange_rgb(file, "albedo", &p->albedo, nodes, 0));
    RSV_TRY(rsv_exchange_rgb(file, "source", &p->field.source, nodes, 0));
    RSV_TRY(rsv_exchange_rgb(file, "source.gathered", &p->field.gathered, nodes, 0));
    RSV_TRY(rsv_exchange_rgb(file, "irradiance", &p->field.irradiance, nodes, 0));
    RSV_TRY(rsv_exchange_rgb(file, "shown.indirect", &p->field.indirect, nodes, -INFINITY));
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        snprintf(name, sizeof name, "shown.order%u", k);
        if (!file->reading && k >= p->field.order_count) break;
        RSV_TRY(rsv_exchange_rgb(file, name, &p->field.order[k], nodes, -INFINITY));
        if (file->reading && p->field.order[k]) p->field.order_count = k + 1;
        if (!p->field.order[k]) break;
    }
    RSV_TRY(rsv_tensor_exchange(
        file, RSV_COARSE_PREFIX "valid_points", RSV_TENSOR_U16, 1, &p->valid_points, &valid));
    RSV_TRY(rsv_tensor_exchange_optional(
        file, RSV_COARSE_PREFIX "draw", RSV_TENSOR_U32, 1, &p->elements->node_draw, &valid));
    RSV_TRY(rsv_exchange_needed(file, "albedo", p->albedo));
    RSV_TRY(rsv_exchange_needed(file, "source", p->field.source));
    RSV_TRY(rsv_exchange_needed(file, "source.gathered", p->field.gathered));
    RSV_TRY(rsv_exchange_needed(file, "irradiance", p->field.irradiance));
    RSV_TRY(rsv_exchange_needed(file, "shown.indirect", p->field.indirect));
    RSV_TRY(rsv_exchange_needed(file, "shown.order0", p->field.order[0]));
cleanup:
    return status;
}

static rsv_status exchange_level(
    rsv_tensor_file *file, const char *prefix, rsv_source_level *level, size_t coarse_nodes)
{
    rsv_status status;
    if (!level->elements) return RSV_OK;
    size_t nodes = level->elements->node_count;
    rsv_tensor_prefix(file, prefix);
    RSV_TRY(rsv_exchange_rgb(
        file, "irradiance", level->caustic ? &level->caustic : &level->direct, nodes, 0));
    RSV_TRY(rsv_exchange_rgb(file, "coarse", &level->coarse_caustic, coarse_nodes, 0));
cleanup:
    return status;
}

static rsv_status exchange_diffused(rsv_tensor_file *file, parts *p)
{
    rsv_status status;
    rsv_diffused_level *d = &p->field.diffused;
    char name[32];
    if (!d->elements) return RSV_OK;
    size_t nodes = d->elements->node_count;
    rsv_tensor_prefix(file, RSV_DIFFUSED_PREFIX);
    RSV_TRY(rsv_exchange_rgb(file, "entered", &d->entered, nodes, 0));
    RSV_TRY(rsv_exchange_rgb(file, "indirect", &d->indirect, nodes, -INFINITY));
    RSV_TRY(rsv_exchange_needed(file, "entered", d->entered));
    RSV_TRY(rsv_exchange_needed(file, "indirect", d->indirect));
    for (uint32_t k = 0; k < p->field.order_count; k++) {
        snprintf(name, sizeof name, "order%u", k);
        RSV_TRY(rsv_exchange_rgb(file, name, &d->order[k], nodes, -INFINITY));
        RSV_TRY(rsv_exchange_needed(file, name, d->order[k]));
    }
cleanup:
    return status;
}

/// Goal points of the solution: positions and normals.
static rsv_status exchange_goal_points(rsv_tensor_file *file, parts *p)
{
    _Static_assert(sizeof(rsv_probe) == 6 * sizeof(float), "a probe is six numbers");
    size_t count = file->reading ? RSV_ANY_COUNT : p->desc.goal_point_count;
    rsv_status status;
    rsv_tensor_prefix(file, NULL);
    RSV_TRY(rsv_tensor_exchange_optional(
        file, "goal_points", RSV_TENSOR_F32, 6, &p->goal_points, &count));
    if (!file->reading || !p->goal_points) return RSV_OK;
    p->desc.goal_points = p->goal_points;
    p->desc.goal_point_count = count;
    if (rsv_check_probes(p->goal_points, count) != RSV_OK)
        RSV_TRY(rsv_tensor_fail(file, "goal_points", "contains an invalid receiver"));
cleanup:
    return status;
}

// ---- writing --------------------------------------------------------------------------------------

static rsv_status write_subsurface(rsv_tensor_file *file, const rsv_subsurface *subsurface)
{
    if (!subsurface) return RSV_OK;
    rsv_subsurface p = *subsurface;
    rsv_tensor_prefix(file, "subsurface.");
    const row_tensors tensors = { "", RSV_TENSOR_U32, p.row_count, 0, NULL };
    return exchange_rows(file, &tensors, &p.row_begin, &p.column, &p.weight);
}

static parts parts_of(const rsv_light_view *s)
{
    const rsv_operator_view *op = rsv_operator_get_view(s->op);
    parts p = { .elements = op->elements,
        .valid_points = (uint16_t *)(uintptr_t)op->valid_points,
        .albedo = (rsv_rgb *)(uintptr_t)op->albedo,
        .desc = s->desc,
        .goal_points = (rsv_probe *)(uintptr_t)s->desc.goal_points,
        .report = s->report };
    p.field = (rsv_light_fields){ .gathered = (rsv_rgb *)(uintptr_t)s->gathered,
        .source = (rsv_rgb *)(uintptr_t)s->source,
        .irradiance = (rsv_rgb *)(uintptr_t)s->irradiance,
        .order_count = s->order_count,
        .indirect = (rsv_rgb *)(uintptr_t)s->indirect,
        .fine = s->fine,
        .caustics = s->caustics,
        .diffused = s->diffused };
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++)
        p.field.order[k] = (rsv_rgb *)(uintptr_t)s->order[k];
    return p;
}

static rsv_status write_levels(rsv_tensor_file *file, const rsv_scene_view *scene, parts *p)
{
    rsv_status status;
    rsv_light_fields *f = &p->field;
    size_t coarse = p->elements->node_count;
    RSV_TRY(rsv_write_elements(file, RSV_DIRECT_PREFIX, scene, f->fine.elements));
    RSV_TRY(exchange_level(file, RSV_DIRECT_PREFIX, &f->fine, coarse));
    RSV_TRY(rsv_write_elements(file, RSV_CAUSTIC_PREFIX, scene, f->caustics.elements));
    RSV_TRY(exchange_level(file, RSV_CAUSTIC_PREFIX, &f->caustics, coarse));
    RSV_TRY(rsv_write_elements(file, RSV_DIFFUSED_PREFIX, scene, f->diffused.elements));
    RSV_TRY(exchange_diffused(file, p));
cleanup:
    return status;
}

rsv_status rsv_write_solution(
    rsv_tensor_file *file, const rsv_light_view *s, rsv_rgb gathered_scale)
{
    rsv_status status;
    parts p = parts_of(s);
    rsv_transport *rows = (rsv_transport *)(uintptr_t)s->transport;
    const rsv_scene_view *scene = s->scene.view;
    RSV_TRY(rsv_write_fields(file, "solve", desc_fields, COUNT_OF(desc_fields), &p.desc));
    RSV_TRY(rsv_write_fields(file, "report", report_fields, COUNT_OF(report_fields), &p.report));
    RSV_TRY(exchange_goal_points(file, &p));
    RSV_TRY(rsv_write_elements(file, RSV_COARSE_PREFIX, scene, p.elements));
    RSV_TRY(rsv_write_voxels(file, p.elements));
    RSV_TRY(exchange_transport(file, rows, gathered_scale));
    RSV_TRY(write_subsurface(file, s->subsurface));
    RSV_TRY(exchange_system(file, &p));
    RSV_TRY(write_levels(file, scene, &p));
cleanup:
    return status;
}

// ---- reading --------------------------------------------------------------------------------------

static rsv_status read_transport(rsv_tensor_file *file, rsv_context *context, parts *p)
{
    rsv_status status = rsv_transport_create_empty(context, p->elements->node_count, &p->transport);
    return status != RSV_OK ? status : exchange_transport(file, p->transport, rgb_gray(1));
}

static rsv_status read_subsurface(rsv_tensor_file *file, rsv_context *context, parts *p)
{
    rsv_status status;
    rsv_subsurface rows = { .row_count = p->elements->node_count };
    rsv_tensor_prefix(file, "subsurface.");
    if (!rsv_tensor_find(file, "row_start")) return RSV_OK;
    const row_tensors tensors = { "", RSV_TENSOR_U32, rows.row_count, SIZE_MAX, NULL };
    status = exchange_rows(file, &tensors, &rows.row_begin, &rows.column, &rows.weight);
    if (status == RSV_OK) return rsv_subsurface_restore(p->elements, &rows, &p->subsurface);
    rsv_free(context, rows.row_begin);
    rsv_free(context, rows.column);
    rsv_free(context, rows.weight);
    return status;
}

static rsv_status read_caustics(rsv_tensor_file *file, const rsv_world *world, parts *p)
{
    rsv_status status;
    rsv_source_level *level = &p->field.caustics;
    RSV_TRY(rsv_read_elements(file, RSV_CAUSTIC_PREFIX, world, p->elements, &level->elements));
    RSV_TRY(exchange_level(file, RSV_CAUSTIC_PREFIX, level, p->elements->node_count));
    // both levels keep their field under the same name
    level->caustic = level->direct;
    level->direct = NULL;
    if (level->elements) RSV_TRY(rsv_exchange_needed(file, "irradiance", level->caustic));
    if (level->elements) RSV_TRY(rsv_exchange_needed(file, "coarse", level->coarse_caustic));
cleanup:
    return status;
}

static rsv_status check_report(const rsv_tensor_file *file, const parts *p)
{
    const rsv_solve_report *r = &p->report;
    bool sound = r->stop_reason <= RSV_STOP_BREAKDOWN && rsv_solver_name(r->solver) &&
                 rsv_solver_name(p->desc.solver);
    return sound ? RSV_OK
                 : rsv_fail(RSV_ERROR_FORMAT,
                       "%s: note 'report' or 'solve' names no known solver "
                       "or reason to stop; solve the scene again",
                       file->path);
}

static rsv_status read_notes(rsv_tensor_file *file, parts *p)
{
    rsv_status status;
    p->desc = rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    RSV_TRY(rsv_read_fields(file, "solve", desc_fields, COUNT_OF(desc_fields), &p->desc));
    if (p->desc.solver == RSV_SOLVER_PETSC)
        p->desc.solver = RSV_SOLVER_AUTO; // not everywhere at hand
    RSV_TRY(rsv_check_solve_desc(&p->desc));
    RSV_TRY(rsv_read_fields(file, "report", report_fields, COUNT_OF(report_fields), &p->report));
    RSV_TRY(check_report(file, p));
    RSV_TRY(exchange_goal_points(file, p));
cleanup:
    return status;
}

static rsv_status read_parts(rsv_tensor_file *file, const rsv_world *world, parts *p)
{
    rsv_status status;
    rsv_light_fields *f = &p->field;
    RSV_TRY(read_notes(file, p));
    RSV_TRY(rsv_read_elements(file, RSV_COARSE_PREFIX, world, NULL, &p->elements));
    RSV_TRY(rsv_read_voxels(file, p->elements));
    RSV_TRY(read_transport(file, world->context, p));
    RSV_TRY(read_subsurface(file, world->context, p));
    RSV_TRY(exchange_system(file, p));
    RSV_TRY(rsv_read_elements(file, RSV_DIRECT_PREFIX, world, p->elements, &f->fine.elements));
    RSV_TRY(exchange_level(file, RSV_DIRECT_PREFIX, &f->fine, p->elements->node_count));
    if (f->fine.elements) RSV_TRY(rsv_exchange_needed(file, "irradiance", f->fine.direct));
    RSV_TRY(read_caustics(file, world, p));
    RSV_TRY(
        rsv_read_elements(file, RSV_DIFFUSED_PREFIX, world, p->elements, &f->diffused.elements));
    RSV_TRY(exchange_diffused(file, p));
cleanup:
    return status;
}

/// Frees parts that were not passed on.
static void free_parts(rsv_context *context, parts *p)
{
    rsv_elements_destroy(p->elements);
    rsv_transport_destroy(p->transport);
    rsv_subsurface_destroy(p->subsurface);
    rsv_free(context, p->valid_points);
    rsv_free(context, p->albedo);
    rsv_light_fields_free(context, &p->field);
    rsv_free(context, p->goal_points);
}

/// Creates an operator from its parts.
static rsv_status restore_operator(rsv_world *world, parts *p, rsv_operator **op)
{
    const rsv_operator_view view = { .context = world->context,
        .world = world,
        .elements = p->elements,
        .valid_points = p->valid_points,
        .transport = p->transport,
        .albedo = p->albedo,
        .subsurface = p->subsurface };
    p->valid_points = NULL;
    p->transport = NULL;
    p->albedo = NULL;
    p->subsurface = NULL;
    return rsv_operator_restore(&view, op);
}

rsv_status rsv_read_solution(rsv_tensor_file *file, rsv_world *world, rsv_light **light)
{
    rsv_status status;
    parts p = { 0 };
    rsv_operator *op = NULL;
    rsv_light_sources *sources = NULL;
    RSV_TRY(read_parts(file, world, &p));
    RSV_TRY(rsv_light_sources_create(world, NULL, &sources));
    RSV_TRY(restore_operator(world, &p, &op));
    p.report.time_bvh = world->build_seconds;
    rsv_light_fields field = p.field;
    p.field = (rsv_light_fields){ 0 };
    RSV_TRY(rsv_light_restore(op, sources, &p.desc, &field, &p.report, light));
cleanup:
    free_parts(world->context, &p);
    rsv_light_sources_release(sources);
    rsv_operator_release(op);
    return status;
}
