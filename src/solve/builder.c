#include "builder.h"
#include "../core/descriptor.h"

#include "../core/team.h"
#include "../elements/voxels.h"
#include "../scene/scene.h"
#include "budget.h"
#include "budget_fill.h"
#include "coarse_elements.h"
#include "goal.h"
#include "pilot.h"
#include "solve_constants.h"
#include "solve_desc.h"
#include "solve_update.h"
#include "source.h"

#include <string.h>

// ---- elements and rows ----------------------------------------------------------------------------

/// Whether budgets are kept with elements that see each other: cells much larger than the surfaces under them may have
/// no valid point at all.
static bool is_within_budget(const rsv_builder *b)
{
    size_t rows = rsv_builder_rows(b);
    bool limited = b->desc.max_elements || b->desc.max_bytes;
    return rows <= rsv_budget_rows(b) &&
           (rows > 0 || !limited || !rsv_reflects_diffusely(&b->scene));
}

static rsv_status create_grids(rsv_builder *b)
{
    rsv_elements_destroy(b->elements);
    b->elements = NULL;
    return rsv_coarse_elements_create(b, rsv_pilot_has_goal(b) ? RSV_GOAL_LEARNED : 1);
}

/// Twice the size of the scene: beyond it, elements do not get fewer, and less and less of them sees anything.
static float coarsest_spacing(const rsv_builder *b)
{
    const rsv_scene_view *view = b->scene.view;
    return 2 * v3_length(v3_sub(view->bounds_max, view->bounds_min));
}

/// A spacing, and its result.
typedef struct trial {
    float metres;
    size_t elements;
    bool usable; ///< some of them see anything
} trial;

static rsv_status try_spacing(rsv_builder *b, float metres, trial *t)
{
    size_t budget = b->desc.max_elements;
    b->spacing.metres = metres;
    if (budget) b->desc.max_elements = 1; // none to spare for splits where surfaces meet
    rsv_status status = create_grids(b);
    b->desc.max_elements = budget;
    if (status != RSV_OK) return status;
    *t = (trial){ metres, rsv_budget_elements(b),
        rsv_builder_rows(b) > 0 || !rsv_reflects_diffusely(&b->scene) };
    return RSV_OK;
}

/// The part of the budgets that the elements in hand use.
static double used_budget(const rsv_builder *b)
{
    double most = (double)b->desc.max_elements;
    double of_elements = most > 0 ? (double)rsv_budget_elements(b) / most : 0;
    return fmax(of_elements, (double)rsv_builder_rows(b) / ((double)rsv_budget_rows(b) + 1));
}

/// Narrows down which spacing just fits. @param best in and out @param exceeding metres, less than the best one's
static rsv_status use_budget(rsv_builder *b, float exceeding, trial *best)
{
    rsv_status status = RSV_OK;
    double used = 0;
    for (int k = 0; k < BISECTIONS && used < BUDGET_USED; k++) {
        trial t;
        RSV_TRY(try_spacing(b, sqrtf(best->metres * exceeding), &t));
        if (t.usable && is_within_budget(b) && t.elements >= best->elements)
            *best = t, used = used_budget(b);
        else
            exceeding = t.metres;
    }
cleanup:
    return status;
}

/// The last resort: spacings from the coarsest down, always the same ones, so that the smallest number of elements
/// stated by a refusal can be reached. Takes the finest of those that fit, otherwise the one with the fewest elements.
static rsv_status create_fewest(rsv_builder *b)
{
    rsv_status status = RSV_OK;
    size_t budget = b->desc.max_elements;
    trial best = { 0, SIZE_MAX, false };
    float exceeding = 0;
    for (int k = 0; k < SPACINGS_TRIED; k++) {
        trial t;
        RSV_TRY(try_spacing(b, coarsest_spacing(b) * exp2f(-(float)k), &t));
        bool fits = budget && t.elements <= budget && t.elements >= best.elements;
        if (t.usable && (t.elements <= best.elements || fits))
            best = t, exceeding = 0;
        else if (exceeding == 0)
            exceeding = t.metres;
    }
    if (best.metres > 0 && best.elements <= budget && exceeding > 0)
        RSV_TRY(use_budget(b, exceeding, &best));
    if (best.metres > 0) RSV_TRY(try_spacing(b, best.metres, &best));
    while (rsv_builder_rows(b) > rsv_budget_rows(b) && rsv_budget_halve_rays(b)) {}
    if (!is_within_budget(b)) RSV_TRY(rsv_budget_refuse(b, rsv_budget_elements(b)));
cleanup:
    return status;
}

/// Uses the rest of budgets. @param exceeding spacing with too many elements, metres
static rsv_status fill_budget(rsv_builder *b, float exceeding, float wanted)
{
    rsv_status status = rsv_budget_fill(b, wanted);
    if (status != RSV_OK || used_budget(b) > BUDGET_MISSED || exceeding >= b->spacing.metres ||
        rsv_pilot_has_goal(b))
        return status;
    trial best = { b->spacing.metres, rsv_budget_elements(b), true };
    RSV_TRY(use_budget(b, exceeding, &best));
    RSV_TRY(try_spacing(b, best.metres, &best));
    RSV_TRY(rsv_budget_fill(b, wanted));
cleanup:
    return status;
}

/// How many times too many elements or rows there are.
static float excess(const rsv_builder *b)
{
    size_t nodes = rsv_budget_elements(b), most = b->desc.max_elements;
    if (most && nodes > most) return (float)nodes / ((float)most + 1);
    return (float)rsv_builder_rows(b) / ((float)rsv_budget_rows(b) + 1);
}

/// Gives few rows more rays than requested.
static void raise_rays(rsv_builder *b)
{
    uint32_t most = MOST_RAISED * b->wanted_rays;
    uint64_t rows = rsv_builder_rows(b);
    if (b->desc.max_bytes || most > RSV_MOST_RAYS) return;
    while (
        2 * b->desc.rays_per_element <= most && rows * b->desc.rays_per_element < b->desc.row_rays)
        b->desc.rays_per_element *= 2;
}

/// Creates elements, larger ones as long as there are more than budgets allow.
static rsv_status create_elements(rsv_builder *b)
{
    rsv_status status;
    b->spacing = rsv_spacing_for(&b->scene, b->desc.element_target);
    if (b->update.history) b->spacing = rsv_history_spacing(b->update.history, b->spacing);
    float wanted = b->wanted_metres = b->spacing.metres, coarsest = coarsest_spacing(b);
    size_t before = SIZE_MAX;
    bool stalled = false;
    float exceeding = 0;
    RSV_TRY(rsv_budget_open(b));
    for (;;) {
        RSV_TRY(create_grids(b));
        if (!stalled) RSV_TRY(rsv_pilot_refine(b));
        while (rsv_builder_rows(b) > rsv_budget_rows(b) && rsv_budget_halve_rays(b)) {}
        if (is_within_budget(b)) break;
        rsv_builder_forget_history(b); // its grids and splits would stay as they were
        exceeding = b->spacing.metres;
        size_t rows = rsv_builder_rows(b);
        if (rows == 0 || b->spacing.metres >= f_max(coarsest, wanted)) {
            RSV_TRY(create_fewest(b));
            break;
        }
        stalled = stalled || (double)rows > LEAST_PROGRESS * (double)before;
        before = rows;
        float step = sqrtf(1.2f * excess(b));
        b->spacing.metres *= stalled ? LARGEST_STEP : f_min(step, LARGEST_STEP);
        b->spacing.metres = f_min(b->spacing.metres, f_max(coarsest, wanted));
    }
    if (exceeding > 0) RSV_TRY(fill_budget(b, exceeding, wanted));
    rsv_budget_report(b, wanted);
    raise_rays(b);
cleanup:
    return status;
}

rsv_status rsv_builder_trace(
    rsv_builder *b, const uint16_t *valid_points, uint32_t rays, rsv_operator **op)
{
    const rsv_operator_desc desc = { .world = b->world,
        .elements = b->elements,
        .rows = { .scene = &b->scene,
            .lights = b->sources->lights,
            .elements = b->elements,
            .valid_points = valid_points ? valid_points : b->valid_points,
            .rays = rays,
            .seed = b->desc.seed } };
    rsv_status status = rsv_operator_trace(&desc, op);
    if (status != RSV_OK) return status;
    const rsv_transport *rows = rsv_operator_get_view(*op)->transport;
    b->report.rays += rows->rays;
    b->report.row_rays += rows->rays;
    b->report.kept_row_rays += rows->kept_rays;
    b->report.spared_seconds += rows->spared_seconds;
    b->kept.kept_rows = rows->kept_rows;
    return RSV_OK;
}

// ---- light ----------------------------------------------------------------------------------------

/// Direct light and caustics on finer elements, where they are requested and visible.
static rsv_status create_levels(const rsv_builder *b, rsv_light *light)
{
    rsv_status status;
    uint8_t *hidden = NULL;
    RSV_TRY(rsv_source_hidden_cells(light, &hidden));
    rsv_level_limits limits = { rsv_budget_cells(b), hidden };
    RSV_TRY(rsv_source_create_levels(light, &limits));
cleanup:
    rsv_free(b->context, hidden);
    return status;
}

/// E0 on the elements of an operator and on levels of its own. @param light out, even after an error
static rsv_status find_sources(rsv_builder *b, rsv_operator *op, rsv_light **light)
{
    rsv_status status;
    RSV_TRY(rsv_light_begin(op, b->sources, &b->scene, &b->desc, light));
    RSV_TRY(create_levels(b, *light));
    RSV_TRY(rsv_source_create(*light));
cleanup:
    return status;
}

// ---- the report -----------------------------------------------------------------------------------

static size_t count_nodes(const rsv_elements *elements)
{
    return elements ? elements->node_count : 0;
}

static size_t level_bytes(const rsv_elements *elements)
{
    if (!elements) return 0;
    return rsv_elements_bytes(elements) + elements->node_count * sizeof(rsv_rgb);
}

/// Bytes of elements, with one field each, and of the operator.
static size_t bytes_of(const rsv_light *s)
{
    return level_bytes(s->elements) + s->elements->node_count * sizeof(uint16_t) +
           rsv_transport_bytes(s->view.transport) + rsv_subsurface_bytes(s->view.subsurface) +
           level_bytes(s->field.fine.elements) + level_bytes(s->field.caustics.elements) +
           level_bytes(s->field.diffused.elements);
}

static void report_sizes(const rsv_builder *b, rsv_light *light)
{
    const rsv_operator_view *op = rsv_operator_get_view(light->op);
    rsv_solve_report *report = &light->report;
    report->elements = rsv_budget_elements(b);
    report->rows = rsv_builder_rows(b);
    report->rays_per_row = b->desc.rays_per_element;
    report->direct_elements =
        count_nodes(light->field.fine.elements) + count_nodes(light->field.caustics.elements);
    report->entries = rsv_team_total(b->context, rsv_transport_entries(op->transport)) +
                      rsv_subsurface_entries(op->subsurface);
}

/// Adds the counts from before the light existed.
static void add_report(rsv_solve_report *report, const rsv_solve_report *before)
{
    report->rays += before->rays;
    report->row_rays = before->row_rays;
    report->kept_row_rays = before->kept_row_rays;
    report->spared_seconds = before->spared_seconds;
    report->time_bvh = before->time_bvh;
}

/// Elements of the air, where there is fog. All of their points count.
static rsv_status add_voxels(rsv_builder *b)
{
    rsv_voxels *voxels = NULL;
    if (!rsv_fog_has_volume(b->scene.view->fog)) return RSV_OK;
    rsv_status status =
        rsv_voxels_create(&b->scene, b->desc.element_target, &b->report.rays, &voxels);
    if (status != RSV_OK) return status;
    size_t before = b->elements->node_count, after = before + voxels->count;
    status = rsv_elements_add_voxels(b->elements, voxels);
    uint16_t *valid_points = rsv_alloc(b->context, after, sizeof *valid_points);
    if (!valid_points || status != RSV_OK) {
        rsv_free(b->context, valid_points);
        return RSV_ERROR_MEMORY;
    }
    if (before) memcpy(valid_points, b->valid_points, before * sizeof *valid_points);
    memset(valid_points + before, 0xff, voxels->count * sizeof *valid_points);
    rsv_free(b->context, b->valid_points);
    b->valid_points = valid_points;
    return RSV_OK;
}

// ---- all of it ------------------------------------------------------------------------------------

static rsv_status assemble(rsv_builder *b, rsv_operator **op, rsv_light **light)
{
    rsv_status status;
    double start = rsv_seconds(), path = rsv_team_path(b->context);
    RSV_TRY(create_elements(b));
    RSV_TRY(add_voxels(b));
    bool matters = rsv_reflects_diffusely(&b->scene) || b->elements->voxels;
    uint32_t rays = matters ? b->desc.rays_per_element : RSV_FEWEST_RAYS;
    RSV_TRY(rsv_builder_trace(b, NULL, rays, op));
    RSV_TRY(rsv_operator_scatter(*op));
    RSV_TRY(find_sources(b, *op, light));
    add_report(&(*light)->report, &b->report);
    (*light)->update.kept_elements = b->kept.kept_elements;
    (*light)->update.kept_rows = b->kept.kept_rows;
    (*light)->report.time_assemble = rsv_seconds() - start;
    (*light)->report.critical_assemble = rsv_team_path(b->context) - path;
    report_sizes(b, *light);
cleanup:
    return status;
}

static rsv_status solve(rsv_builder *b, rsv_light *light)
{
    rsv_status status;
    double start = rsv_seconds(), path = rsv_team_path(b->context);
    RSV_TRY(rsv_solve_and_measure(light));
    RSV_TRY(rsv_diffused_level_create(light));
    light->report.time_solve = rsv_seconds() - start;
    light->report.critical_solve = rsv_team_path(b->context) - path;
    rsv_light_publish(light);
    light->report.bytes = bytes_of(light);
    rsv_light_warn_if_unbounded(light);
cleanup:
    return status;
}

/// @param light out, even after an error
static rsv_status build(rsv_builder *b, rsv_light **light)
{
    rsv_status status;
    rsv_history *history = NULL;
    rsv_operator *op = NULL;
    RSV_TRY(rsv_builder_open_history(b, &history));
    RSV_TRY(assemble(b, &op, light));
    RSV_TRY(solve(b, *light));
    rsv_builder_keep_history(b, *light);
cleanup:
    if (*light) {
        (*light)->scene = b->world->scene;
        rsv_light_publish(*light);
    }
    rsv_history_close(history);
    rsv_operator_release(op);
    return status;
}

static rsv_status begin(const rsv_scene *scene, const rsv_solve_desc *desc, rsv_builder *b)
{
    rsv_status status;
    *b = (rsv_builder){ .context = rsv_scene_get_context(scene),
        .desc = *desc,
        .wanted_rays = desc->rays_per_element };
    RSV_TRY(rsv_world_create(scene, &b->world));
    b->report.time_bvh = b->world->build_seconds;
    b->scene = b->world->scene;
    b->scene.update = &b->update;
    RSV_TRY(rsv_light_sources_create(b->world, NULL, &b->sources));
    rsv_lights_warn_if_dark(b->sources->lights);
    if (b->scene.view->fog) b->scene.fog_lights = &b->sources->fog_lights;
cleanup:
    return status;
}

static void end(rsv_builder *b)
{
    rsv_elements_destroy(b->elements);
    rsv_free(b->context, b->valid_points);
    rsv_light_sources_release(b->sources);
    rsv_world_release(b->world);
}

static rsv_status check_goal(const rsv_solve_desc *desc, size_t cameras)
{
    if (desc->goal_camera == RSV_NONE)
        return rsv_check_probes(desc->goal_points, desc->goal_point_count);
    if (desc->goal_point_count > 0)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "solve: goal_camera and goal_points are both given; choose one");
    if (desc->goal_camera >= cameras)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: goal_camera is %u; the scene has %zu cameras",
            desc->goal_camera, cameras);
    return RSV_OK;
}

rsv_status rsv_light_build(const rsv_scene *scene, const rsv_solve_desc *desc, rsv_store *store,
    rsv_store *earlier, rsv_light **solution)
{
    rsv_builder b;
    rsv_light *light = NULL;
    rsv_status status = store ? rsv_scene_refuse_fog(scene, "an update") : RSV_OK;
    if (status != RSV_OK) return status;
    status = begin(scene, desc, &b);
    b.update.store = store;
    b.update.earlier = earlier;
    if (status == RSV_OK) status = build(&b, &light);
    end(&b);
    if (status == RSV_OK)
        *solution = light;
    else
        rsv_light_destroy(light);
    return status;
}

rsv_status rsv_check_settings(const rsv_scene *scene, const rsv_solve_desc *desc)
{
    rsv_status status = rsv_scene_require_committed(scene);
    if (status == RSV_OK) status = check_goal(desc, rsv_scene_get_view(scene)->camera_count);
    if (status == RSV_OK && (desc->checkpoint || desc->earlier))
        status = rsv_scene_refuse_fog(scene, "a checkpoint");
    return status == RSV_OK ? rsv_check_solve_desc(desc) : status;
}

/// Logs reused rays; updates in memory have them in their report.
static void tell_kept_rays(rsv_context *context, const rsv_solve_report *r)
{
    if (r->kept_row_rays > 0)
        rsv_log(context, RSV_LOG_INFO,
            "checkpoint: %.1f %% of the rays of rows kept from before the edit, %.1f %% traced "
            "again: %.1f s saved",
            100 * (double)r->kept_row_rays / (double)r->row_rays,
            100 * (1 - (double)r->kept_row_rays / (double)r->row_rays), fmax(r->spared_seconds, 0));
}

rsv_status rsv_light_create(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_light **solution)
{
    rsv_solve_desc settings = rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_store *store = NULL, *earlier = NULL;
    rsv_status status;
    RSV_TRY(RSV_READ_DESC(rsv_solve_desc, &settings, desc));
    RSV_TRY(rsv_check_settings(scene, &settings));
    if (settings.checkpoint) RSV_TRY(rsv_store_folder(context, settings.checkpoint, &store));
    if (settings.earlier) RSV_TRY(rsv_store_folder(context, settings.earlier, &earlier));
    RSV_TRY(rsv_light_build(scene, &settings, store, earlier, solution));
    tell_kept_rays(context, &(*solution)->report);
cleanup:
    rsv_store_destroy(store);
    rsv_store_destroy(earlier);
    return status;
}
