#include "solution.h"

#include "../operator/bend.h"
#include "../operator/burial.h"
#include "../operator/cluster.h"
#include "../operator/contact.h"
#include "../operator/elements_internal.h"
#include "budget.h"
#include "goal.h"

#include <string.h>

/// Pilot solutions with few rays show where coarse cells are too large for the indirect light.
#define PILOT_RAYS 128
#define FEWEST_RAYS 64
#define PILOT_ORDERS 3
/// Where meshes are finer than the wanted spacing, nodes follow leaders within this part of it; pilots halve that where
/// light changes quickly.
#define CLUSTER_RADIUS 1.0f
#define CLUSTER_RADIUS_WITHOUT_PILOTS 0.5f
#define PILOT_BEND 0.2f
#define LARGEST_BEND 2.0f
/// Pilots may bring the number of nodes to this many times what was asked for. A split adds about so many.
#define MOST_NODES 8
#define NODES_PER_SPLIT 2
/// Where budgets are exceeded, elements grow by this factor at most at a time, as long as that leaves fewer than this
/// part of them.
#define LARGEST_STEP 4.0f
#define LEAST_PROGRESS 0.95
/// Part of the mean indirect light below which nobody sees a relative error.
#define PILOT_DARK 0.02f
/// Elements are split for a goal until they are at most this much larger than wanted.
#define GOAL_TOLERANCE 1.4f
/// From this factor on, elements are not worth splitting where light bends.
#define GOAL_IDLE 1.5f
/// Places on each element where textured albedo is looked up.
#define ALBEDO_POINTS 16

rsv_solve_desc rsv_default_solve_desc(rsv_quality quality)
{
    static const rsv_solve_desc presets[] = {
        [RSV_QUALITY_DRAFT] = { .element_target = 3000,
            .rays_per_element = 256,
            .refinements = 0,
            .light_samples = 16,
            .photon_count = 300000,
            .direct_levels = 2 },
        [RSV_QUALITY_MEDIUM] = { .element_target = 7000,
            .rays_per_element = 1024,
            .refinements = 3,
            .light_samples = 16,
            .photon_count = 1500000,
            .direct_levels = 3 },
        [RSV_QUALITY_HIGH] = { .element_target = 24000,
            .rays_per_element = 1024,
            .refinements = 3,
            .light_samples = 32,
            .photon_count = 6000000,
            .direct_levels = 4 },
    };
    rsv_solve_desc desc = presets[quality];
    desc.direct_level = true;
    desc.max_orders = 4096;
    desc.tolerance = 1e-4f;
    desc.goal_camera = RSV_NONE;
    desc.seed = 1;
    return desc;
}

static bool is_power_of_two(uint32_t value) { return value && (value & (value - 1)) == 0; }

static rsv_status check_desc(const rsv_solve_desc *desc)
{
    if (desc->element_target == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: element_target must be positive");
    if (!is_power_of_two(desc->rays_per_element) || desc->rays_per_element < FEWEST_RAYS ||
        desc->rays_per_element > 4096)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: rays_per_element is %u; it must be a power of two from 64 to 4096",
            desc->rays_per_element);
    if (!is_power_of_two(desc->light_samples) || desc->light_samples < 16 ||
        desc->light_samples > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: light_samples is %u; it must be a power of two from 16 to 65536",
            desc->light_samples);
    if (desc->max_orders == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: max_orders must be positive");
    if (!(desc->tolerance > 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: tolerance must be positive");
    return RSV_OK;
}

static rsv_status create_bsdfs(rsv_solution *s)
{
    const rsv_scene_view *view = s->scene.view;
    s->bsdf = rsv_alloc(s->context, view->material_count, sizeof *s->bsdf);
    if (!s->bsdf) return RSV_ERROR_MEMORY;
    for (size_t m = 0; m < view->material_count; m++)
        s->bsdf[m] = rsv_surface_common_bsdf(view, (uint32_t)m);
    s->scene.bsdf = s->bsdf;
    return RSV_OK;
}

/// Edge of the cells that put about `target` nodes on everything that scatters diffusely.
static float spacing_for(const rsv_solution *s, uint32_t target)
{
    const rsv_scene_view *view = s->scene.view;
    double area = 0;
    for (size_t t = 0; t < view->triangle_count; t++)
        if (s->bsdf[view->triangle_material[t]].diffuse > 0)
            area += rsv_triangle_area(view, (uint32_t)t);
    return area > 0 ? (float)sqrt(area / target) : 1;
}

/// Mean over the hat function of a node: irradiance is smooth there, textures are not. Weighted by the share of
/// light that is scattered diffusely, which gather rays take care of.
static rsv_rgb mean_albedo(const rsv_solution *s, uint32_t node)
{
    const rsv_elements *e = s->elements;
    rsv_support_point sample[ALBEDO_POINTS];
    if (e->support_begin[node] == e->support_begin[node + 1]) return rgb_gray(0); // bridged
    rsv_elements_sample_support(e, node, ALBEDO_POINTS, s->desc.seed, sample);
    float width = sqrtf(3 * e->node_area[node] / ALBEDO_POINTS), weights = 0;
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < ALBEDO_POINTS; k++) {
        rsv_bsdf storage;
        uint32_t triangle = e->face_triangle[e->cell[sample[k].support / 4].face];
        const rsv_bsdf *bsdf = rsv_surface_bsdf(
            s->scene.view, s->bsdf, triangle, sample[k].u, sample[k].v, width, &storage);
        float weight = bsdf->diffuse * bsdf->opacity;
        sum = rgb_mad(sum, weight, bsdf->exitance_albedo);
        weights += weight;
    }
    return weights > 0 ? rgb_scale(sum, 1 / weights) : sum;
}

static rsv_status create_albedos(rsv_solution *s)
{
    const rsv_elements *e = s->elements;
    s->exitance_albedo = rsv_alloc(s->context, e->node_count, sizeof *s->exitance_albedo);
    s->source = rsv_alloc(s->context, e->node_count, sizeof *s->source);
    s->gathered = rsv_alloc(s->context, e->node_count, sizeof *s->gathered);
    if (!s->exitance_albedo || !s->source || !s->gathered) return RSV_ERROR_MEMORY;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(s->context))
    for (size_t n = 0; n < e->node_count; n++) {
        uint32_t triangle = e->face_triangle[e->node_face[n]];
        uint32_t material = s->scene.view->triangle_material[triangle];
        s->exitance_albedo[n] = s->scene.view->material_varies[material]
                                    ? mean_albedo(s, (uint32_t)n)
                                    : s->bsdf[material].exitance_albedo;
    }
    return RSV_OK;
}

/// Everything that belongs to one set of coarse elements: G, K, E0 and the solution.
static void destroy_system(rsv_solution *s)
{
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        rsv_free(s->context, s->order[k]);
        s->order[k] = NULL;
    }
    rsv_free(s->context, s->irradiance);
    rsv_free(s->context, s->indirect);
    rsv_free(s->context, s->source);
    rsv_free(s->context, s->gathered);
    rsv_free(s->context, s->exitance_albedo);
    rsv_transport_destroy(s->transport);
    s->irradiance = s->indirect = s->source = s->gathered = s->exitance_albedo = NULL;
    s->transport = NULL;
}

/// Caustics have elements of their own: they are the same whether direct light is left to the renderer or not.
static rsv_status create_fine_levels(rsv_solution *s)
{
    bool caustics = s->desc.photon_count > 0 && s->elements->node_count > 0 &&
                    rsv_photons_wanted(&s->scene, s->lights);
    bool sampled = rsv_lights_any_sampled(s->lights) || s->scene.view->light_count > 0;
    rsv_source_level_desc desc = { .levels = s->desc.direct_levels,
        .max_cells = rsv_budget_cells(s),
        .light_samples = s->desc.light_samples,
        .seed = rsv_level_seed(s) };
    rsv_status status = RSV_OK;
    uint8_t *hidden = NULL;
    if (s->desc.goal_camera != RSV_NONE) {
        hidden = rsv_alloc(s->context, s->elements->cell_count, 1);
        RSV_TRY(hidden ? RSV_OK : RSV_ERROR_MEMORY);
        RSV_TRY(rsv_goal_hidden_cells(s, s->desc.goal_camera, hidden));
    }
    desc.hidden = hidden;
    rsv_source_level_desc direct_desc = desc, caustic_desc = desc;
    direct_desc.direct = true;
    caustic_desc.photon_count = s->desc.photon_count;
    if (s->desc.direct_level && sampled)
        status = rsv_source_level_create(
            &s->scene, s->lights, s->elements, &direct_desc, &s->fine, &s->report.rays);
    if (status == RSV_OK && caustics)
        status = rsv_source_level_create(
            &s->scene, s->lights, s->elements, &caustic_desc, &s->caustics, &s->report.rays);
cleanup:
    rsv_free(s->context, hidden);
    return status;
}

/// E0 on the coarse elements: next-event estimates, gathered emission and caustics.
static rsv_status create_source(rsv_solution *s)
{
    rsv_status status = rsv_direct_irradiance(&s->scene, s->lights, s->elements, RSV_SUPPORT_POINTS,
        RSV_COARSE_LIGHT_FACTOR * s->desc.light_samples, s->desc.seed, s->valid_points, NULL,
        s->source, NULL, &s->report.rays);
    if (status != RSV_OK) return status;
    rsv_transport_environment(s->transport, s->bin_radiance, s->gathered);
    for (size_t n = 0; n < s->elements->node_count; n++) {
        s->gathered[n] = rgb_add(s->gathered[n], s->transport->gathered[n]);
        s->source[n] = rgb_add(s->source[n], s->gathered[n]);
        if (s->caustics.coarse_caustic)
            s->source[n] = rgb_add(s->source[n], s->caustics.coarse_caustic[n]);
    }
    rsv_elements_constrain(s->elements, s->gathered);
    rsv_elements_constrain(s->elements, s->source);
    return RSV_OK;
}

/// Elements ready to receive: walls kept apart, fine meshes clustered, buried points known, buried corners
/// bridged.
static rsv_status prepare_elements(rsv_solution *s)
{
    rsv_status status = rsv_elements_separate(s->tracer, s->elements, &s->report.rays);
    if (status == RSV_OK)
        status = rsv_elements_cluster(s->elements,
            s->elements->spacing *
                (s->desc.refinements ? CLUSTER_RADIUS : CLUSTER_RADIUS_WITHOUT_PILOTS));
    if (status != RSV_OK) return status;
    rsv_free(s->context, s->valid_points);
    s->valid_points = rsv_alloc(s->context, s->elements->node_count, sizeof *s->valid_points);
    if (!s->valid_points) return RSV_ERROR_MEMORY;
    status = rsv_find_buried(
        &s->scene, s->elements, RSV_SUPPORT_POINTS, s->desc.seed, s->valid_points, &s->report.rays);
    return status == RSV_OK ? rsv_elements_bridge_buried(s->elements, s->valid_points) : status;
}

static rsv_status assemble(rsv_solution *s, uint32_t rays)
{
    rsv_status status = rsv_transport_create(
        &s->scene, s->lights, s->elements, s->valid_points, rays, s->desc.seed, &s->transport);
    if (status == RSV_OK) s->report.rays += s->transport->rays;
    return status;
}

/// Where nothing reflects diffusely, irradiance is of no consequence: what cameras and probes see comes straight
/// from the sources.
static bool reflects_diffusely(const rsv_solution *s)
{
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        if (s->bsdf[m].diffuse > 0 && !rgb_is_black(s->bsdf[m].exitance_albedo)) return true;
    return false;
}

static void mark_pair(void *user, uint32_t cell, uint32_t other)
{
    uint8_t *split = user;
    split[cell] = split[other] = 1;
}

static rsv_status split_marked(rsv_solution *s, const uint8_t *split)
{
    rsv_elements *finer = NULL;
    rsv_status status = rsv_elements_refine(s->elements, split, &finer);
    if (status != RSV_OK) return status;
    rsv_elements_destroy(s->elements);
    s->elements = finer;
    return prepare_elements(s);
}

/// Rows that refining the marked cells adds, about.
static double rows_for(const rsv_elements *e, const uint8_t *marked, bool *any)
{
    double rows = 0;
    *any = false;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (!marked[c]) continue;
        *any = true;
        rows += rsv_cell_follows(e, c) ? (double)rsv_cell_new_leaders(e, c) : NODES_PER_SPLIT;
    }
    return rows;
}

/// Where a mesh is finer than its clusters, these shrink rather than its triangles.
static void shrink_clusters(rsv_elements *e, uint8_t *marked)
{
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (!marked[c] || !rsv_cell_follows(e, c)) continue;
        e->face_halvings[e->cell[c].face]++;
        marked[c] = 0;
    }
}

/// Leaves cells alone whose light hardly matters to the goal.
static void unmark_idle(const rsv_goal *goal, const rsv_elements *e, uint8_t *split)
{
    for (uint32_t c = 0; goal->elements && c < e->cell_count; c++)
        if (split[c] && rsv_goal_size_at(goal, e, c) > GOAL_IDLE) split[c] = 0;
}

/// Marks the cells over which indirect light bends, the strongest bends alone where all of them would take more nodes
/// than there should be. @param any out: false if none are marked
static rsv_status mark_bends(
    const rsv_solution *s, const rsv_goal *goal, const float *deviation, uint8_t *split, bool *any)
{
    const rsv_elements *e = s->elements;
    float dark = PILOT_DARK * (float)rsv_elements_mean_luminance(e, s->indirect);
    size_t rows = rsv_solution_rows(s), most = (size_t)MOST_NODES * s->desc.element_target;
    if (most > rsv_budget_rows(s)) most = rsv_budget_rows(s);
    *any = false;
    for (float bend = PILOT_BEND; bend < LARGEST_BEND; bend *= 1.5f) {
        memset(split, 0, e->cell_count);
        rsv_status status = rsv_find_bends(
            e, s->indirect, deviation, bend, dark, RSV_BENDS_AND_BORDERS, mark_pair, split);
        rsv_find_cluster_bends(e, s->indirect, deviation, bend, dark, mark_pair, split);
        unmark_idle(goal, e, split);
        bool marked;
        *any = (double)rows + rows_for(e, split, &marked) <= (double)most && marked;
        if (status != RSV_OK || !marked || *any) return status;
    }
    return RSV_OK;
}

/// Splits coarse cells over which the first few orders of a pilot solution bend.
/// @param refined out: false if there are none
static rsv_status refine_by_pilot(rsv_solution *s, const rsv_goal *goal, bool *refined)
{
    rsv_status status = RSV_OK;
    uint8_t *split = rsv_alloc(s->context, s->elements->cell_count, 1);
    size_t nodes = s->elements->node_count;
    float *deviation = rsv_alloc(s->context, nodes, sizeof *deviation);
    rsv_rgb *exitance = rsv_alloc(s->context, nodes, sizeof *exitance);
    if (!split || !deviation || !exitance) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(create_albedos(s));
    RSV_TRY(assemble(s, PILOT_RAYS));
    RSV_TRY(create_source(s));
    RSV_TRY(rsv_solve_orders(s, PILOT_ORDERS));
    for (size_t n = 0; n < nodes; n++)
        exitance[n] = rgb_mul(s->exitance_albedo[n], rgb_add(s->source[n], s->indirect[n]));
    rsv_transport_deviation(s->transport, exitance, s->bin_radiance, deviation);
    rsv_mark_buried(s->elements, s->valid_points, deviation);
    RSV_TRY(mark_bends(s, goal, deviation, split, refined));
    destroy_system(s);
    if (!*refined) goto cleanup;
    shrink_clusters(s->elements, split);
    RSV_TRY(split_marked(s, split));
cleanup:
    rsv_free(s->context, split);
    rsv_free(s->context, deviation);
    rsv_free(s->context, exitance);
    return status;
}

/// Splits cells that are too large for what they matter; one round halves them.
static rsv_status split_for_goal(rsv_solution *s, const rsv_goal *goal)
{
    const rsv_elements *e = s->elements;
    uint8_t *split = rsv_alloc(s->context, e->cell_count, 1);
    if (!split) return RSV_ERROR_MEMORY;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        float size = sqrtf(2 * rsv_cell_area(e, c));
        split[c] = e->cell[c].level < RSV_MAX_LEVEL &&
                   size > GOAL_TOLERANCE * e->spacing * rsv_goal_size_at(goal, e, c);
    }
    rsv_status status = split_marked(s, split);
    rsv_free(s->context, split);
    return status;
}

/// Learns on coarse elements what matters to the goal, and refines them accordingly.
static rsv_status refine_for_goal(rsv_solution *s, rsv_goal *goal)
{
    rsv_status status;
    RSV_TRY(create_albedos(s));
    RSV_TRY(assemble(s, PILOT_RAYS));
    RSV_TRY(rsv_goal_create(s, s->desc.goal_camera, goal));
    destroy_system(s);
    for (float size = RSV_GOAL_COARSEST; size > 1; size /= 2)
        RSV_TRY(split_for_goal(s, goal));
cleanup:
    return status;
}

/// @param spacing metres, wanted
static rsv_status create_elements_of(rsv_solution *s, float spacing)
{
    rsv_status status;
    rsv_goal goal = { 0 };
    bool has_goal = s->desc.goal_camera != RSV_NONE && reflects_diffusely(s);
    RSV_TRY(rsv_elements_create(
        s->scene.scene, s->bsdf, has_goal ? RSV_GOAL_COARSEST * spacing : spacing, &s->elements));
    s->elements->spacing = spacing;
    RSV_TRY(rsv_elements_refine_contacts(&s->scene, &s->elements, &s->report.rays));
    RSV_TRY(prepare_elements(s));
    bool refined = reflects_diffusely(s) && rsv_solution_rows(s) <= rsv_budget_rows(s);
    if (has_goal && refined) RSV_TRY(refine_for_goal(s, &goal));
    for (uint32_t pilot = 0; refined && pilot < s->desc.refinements; pilot++)
        RSV_TRY(refine_by_pilot(s, &goal, &refined));
cleanup:
    rsv_goal_destroy(&goal);
    return status;
}

/// Creates elements, larger ones as long as there are more than budgets allow.
static rsv_status create_elements(rsv_solution *s)
{
    rsv_status status;
    float wanted = spacing_for(s, s->desc.element_target), spacing = wanted;
    size_t before = SIZE_MAX;
    RSV_TRY(rsv_budget_open(s));
    for (;;) {
        RSV_TRY(create_elements_of(s, spacing));
        while (rsv_solution_rows(s) > rsv_budget_rows(s) && rsv_budget_halve_rays(s)) {}
        size_t rows = rsv_solution_rows(s), most = rsv_budget_rows(s);
        if (rows <= most) break;
        if ((double)rows > LEAST_PROGRESS * (double)before) RSV_TRY(rsv_budget_refuse(s, rows));
        before = rows;
        spacing *= f_min(sqrtf(1.2f * (float)rows / ((float)most + 1)), LARGEST_STEP);
        rsv_elements_destroy(s->elements);
        s->elements = NULL;
    }
    rsv_budget_report(s, wanted);
cleanup:
    return status;
}

/// Errors of the operator are amplified by about 1 / (1 - spectral radius): beyond this the reader must know.
#define WORRYING_RADIUS 0.98

static void warn_if_unbounded(const rsv_solution *s)
{
    const rsv_solve_report *report = &s->report;
    if (s->pocket_area > 0)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: %.3g m2 of surfaces that absorb nothing enclose pockets which hardly any light "
            "enters, and are left dark there; lower their albedo below 1",
            s->pocket_area);
    if (report->stop_reason == RSV_STOP_MAX_ORDERS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: stopped after %u orders of light with a residual of %.3g W/m2",
            report->iterations, report->residual_inf);
    else if (report->stop_reason > RSV_STOP_NO_LIGHT)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: solver %s gave up after %u applications with a residual of %.3g W/m2; leave "
            "the choice to 'auto'",
            rsv_solver_name(report->solver), report->iterations, report->residual_inf);
    else if (report->stop_reason == RSV_STOP_CONVERGED && report->norm_inf > WORRYING_RADIUS &&
             report->spectral_radius > WORRYING_RADIUS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: the scene absorbs almost nothing (spectral radius %.4f): small errors of the "
            "operator weigh heavily; use a higher quality or lower the albedos",
            report->spectral_radius);
}

/// Tells gather rays and shadow rays what each of them finds of the surroundings.
static rsv_status divide_environment(rsv_solution *s)
{
    rsv_environment_light *environment = s->lights->environment;
    s->bin_radiance = rsv_alloc(s->context, RSV_ESCAPE_BINS, sizeof *s->bin_radiance);
    if (!s->bin_radiance) return RSV_ERROR_MEMORY;
    rsv_status status = environment ? rsv_environment_light_divide(environment) : RSV_OK;
    return status == RSV_OK ? rsv_escape_radiance(s->context, environment, s->bin_radiance)
                            : status;
}

static size_t count_nodes(const rsv_elements *elements)
{
    return elements ? elements->node_count : 0;
}

static rsv_status prepare(rsv_solution *s)
{
    rsv_status status;
    double start = rsv_seconds();
    RSV_TRY(create_bsdfs(s));
    RSV_TRY(rsv_tracer_create(s->scene.scene, &s->tracer));
    s->scene.tracer = s->tracer;
    s->scene.media = rsv_media_of(s->scene.view, s->tracer, s->bsdf);
    s->report.time_bvh = rsv_seconds() - start;
    RSV_TRY(rsv_lights_create(s->scene.scene, s->bsdf, &s->lights));
    RSV_TRY(divide_environment(s));
cleanup:
    return status;
}

rsv_status rsv_solution_prepare(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_solution **solution)
{
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_status status = check_desc(desc);
    if (status != RSV_OK) return status;
    rsv_solution *s = rsv_alloc(context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    s->context = context;
    s->desc = *desc;
    s->wanted_rays = desc->rays_per_element;
    s->scene = (rsv_transport_scene){ .scene = scene, .view = rsv_scene_get_view(scene) };
    status = prepare(s);
    if (status == RSV_OK)
        *solution = s;
    else
        rsv_solution_destroy(s);
    return status;
}

rsv_status rsv_solution_refresh(rsv_solution *s)
{
    rsv_status status;
    rsv_lights *before = s->lights;
    s->lights = NULL;
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        s->bsdf[m] = rsv_surface_common_bsdf(s->scene.view, (uint32_t)m);
    RSV_TRY(rsv_lights_create(s->scene.scene, s->bsdf, &s->lights));
    RSV_TRY(rsv_lights_gather_like(s->lights, before));
    rsv_free(s->context, s->bin_radiance);
    RSV_TRY(divide_environment(s));
cleanup:
    rsv_lights_destroy(before);
    return status;
}

rsv_status rsv_solution_solve_again(rsv_solution *s)
{
    rsv_status status;
    double start = rsv_seconds();
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        rsv_free(s->context, s->order[k]);
        s->order[k] = NULL;
    }
    rsv_free(s->context, s->irradiance);
    rsv_free(s->context, s->indirect);
    s->irradiance = s->indirect = NULL;
    RSV_TRY(rsv_solve_orders(s, s->desc.max_orders));
    rsv_diffused_level_destroy(s->context, &s->diffused);
    RSV_TRY(rsv_diffused_level_create(s));
    s->report.time_solve = rsv_seconds() - start;
    warn_if_unbounded(s);
cleanup:
    return status;
}

static rsv_status build(rsv_solution *s)
{
    rsv_status status;
    double start = rsv_seconds();
    RSV_TRY(create_elements(s));
    RSV_TRY(create_albedos(s));
    RSV_TRY(assemble(s, reflects_diffusely(s) ? s->desc.rays_per_element : FEWEST_RAYS));
    RSV_TRY(rsv_subsurface_create(s->elements, &s->subsurface));
    RSV_TRY(create_fine_levels(s));
    RSV_TRY(create_source(s));
    double assembled = rsv_seconds();
    s->report.time_assemble = assembled - start;

    s->report.elements = s->elements->node_count;
    s->report.rows = rsv_solution_rows(s);
    s->report.direct_elements = count_nodes(s->fine.elements) + count_nodes(s->caustics.elements);
    s->report.entries = rsv_transport_entries(s->transport) + rsv_subsurface_entries(s->subsurface);
    RSV_TRY(rsv_solve_orders(s, s->desc.max_orders));
    RSV_TRY(rsv_diffused_level_create(s));
    s->report.time_solve = rsv_seconds() - assembled;
    s->report.bytes = rsv_solution_bytes(s);
    warn_if_unbounded(s);
cleanup:
    return status;
}

rsv_status rsv_solution_create(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_solution **solution)
{
    rsv_solve_desc settings = desc ? *desc : rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    size_t cameras = rsv_scene_get_view(scene)->camera_count;
    if (settings.goal_camera != RSV_NONE && settings.goal_camera >= cameras)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: goal_camera is %u; the scene has %zu cameras",
            settings.goal_camera, cameras);
    rsv_solution *s = NULL;
    rsv_status status = rsv_solution_prepare(scene, &settings, &s);
    if (status != RSV_OK) return status;
    status = build(s);
    if (status != RSV_OK) {
        rsv_solution_destroy(s);
        return status;
    }
    *solution = s;
    return RSV_OK;
}

void rsv_solution_destroy(rsv_solution *s)
{
    if (!s) return;
    rsv_context *context = s->context;
    rsv_light_basis_destroy(s->basis);
    rsv_diffused_level_destroy(context, &s->diffused);
    rsv_source_level_destroy(context, &s->fine);
    rsv_source_level_destroy(context, &s->caustics);
    rsv_subsurface_destroy(s->subsurface);
    destroy_system(s);
    rsv_free(context, s->valid_points);
    rsv_free(context, s->bin_radiance);
    rsv_elements_destroy(s->elements);
    rsv_lights_destroy(s->lights);
    rsv_tracer_destroy(s->tracer);
    rsv_free(context, s->bsdf);
    rsv_free(context, s);
}

const rsv_solve_report *rsv_solution_report(const rsv_solution *solution)
{
    return &solution->report;
}

const rsv_scene *rsv_solution_scene(const rsv_solution *solution) { return solution->scene.scene; }

uint32_t rsv_solution_order_count(const rsv_solution *solution) { return solution->order_count; }

rsv_rgb rsv_solution_direct(
    const rsv_solution *s, uint32_t face, float u, float v, bool skip_sampled)
{
    rsv_rgb sum = rsv_elements_interpolate(s->elements, s->gathered, face, u, v);
    if (s->caustics.caustic)
        sum = rgb_add(
            sum, rsv_elements_interpolate(s->caustics.elements, s->caustics.caustic, face, u, v));
    if (skip_sampled) return sum;
    if (s->fine.direct)
        return rgb_add(sum, rsv_elements_interpolate(s->fine.elements, s->fine.direct, face, u, v));
    return rsv_elements_interpolate(s->elements, s->source, face, u, v);
}

rsv_rgb rsv_solution_irradiance(
    const rsv_solution *s, uint32_t triangle, float u, float v, bool back_side, uint32_t order)
{
    uint32_t face = s->elements->face_of[back_side][triangle];
    if (face == RSV_NONE) return rgb_gray(0);
    if (order == 0) return rsv_solution_direct(s, face, u, v, false);
    if (order != RSV_NONE)
        return order < s->order_count
                   ? rsv_elements_interpolate(s->elements, s->order[order], face, u, v)
                   : rgb_gray(0);
    return rgb_add(rsv_solution_direct(s, face, u, v, false),
        rsv_elements_interpolate(s->elements, s->indirect, face, u, v));
}

rsv_status rsv_measure_assembly(const rsv_solution *s, rsv_assembly_cost *cost)
{
    rsv_transport *again = NULL;
    uint32_t rays = s->desc.rays_per_element;
    double start = rsv_seconds();
    rsv_status status = rsv_transport_create(
        &s->scene, s->lights, s->elements, s->valid_points, rays, s->desc.seed, &again);
    if (status != RSV_OK) return status;
    cost->assembly_seconds = rsv_seconds() - start;
    rsv_transport_destroy(again);
    return rsv_transport_trace_only(&s->scene, s->elements, s->valid_points, rays, s->desc.seed,
        &cost->rays, &cost->tracing_seconds, &cost->single_seconds);
}
