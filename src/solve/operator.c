#include "operator.h"

#include "../core/parallel.h"
#include "../core/references.h"
#include "../scene/material_at.h"
#include "solve_constants.h"

#include <string.h>

struct rsv_operator {
    rsv_operator_view view;
    uint32_t references; ///< holders
    rsv_operator *base;  ///< whose rows these are; NULL = its own
    uint16_t *valid_points;
    rsv_rgb *albedo;
};

// ---- K --------------------------------------------------------------------------------------------

bool rsv_reflects_diffusely(const rsv_transport_scene *scene)
{
    for (size_t m = 0; m < scene->view->material_count; m++)
        if (scene->bsdf[m].diffuse > 0 && !rgb_is_black(scene->bsdf[m].base_color)) return true;
    return false;
}

/// Mean over the hat function of a node: irradiance is smooth there, textures are not. Weighted by the fraction of
/// light that is scattered diffusely, which gather rays account for, as they do for cut-outs.
static rsv_rgb mean_albedo(
    const rsv_transport_scene *scene, const rsv_elements *e, uint32_t seed, uint32_t node)
{
    rsv_support_point sample[ALBEDO_POINTS];
    if (e->support_begin[node] == e->support_begin[node + 1]) return rgb_gray(0); // bridged
    rsv_elements_sample_support(e, node, ALBEDO_POINTS, seed, sample);
    float width = sqrtf(3 * e->node_area[node] / ALBEDO_POINTS);
    rsv_rgb sum = rgb_gray(0), weights = rgb_gray(0);
    for (uint32_t k = 0; k < ALBEDO_POINTS; k++) {
        rsv_bsdf storage;
        uint32_t triangle = e->face_triangle[e->cell[sample[k].support / 4].face];
        const rsv_bsdf *bsdf = rsv_surface_entry_bsdf(scene->view, scene->bsdf,
            (rsv_footprint){ triangle, sample[k].u, sample[k].v, width, RSV_CHANNEL_ALL },
            &storage);
        rsv_rgb scale = bsdf->entry_scale, left = rgb(1 / scale.r, 1 / scale.g, 1 / scale.b);
        float share = bsdf->diffuse * bsdf->opacity *
                      rsv_left_of_cut_out(scene->view, triangle, sample[k].u, sample[k].v, width);
        rsv_rgb weight = rgb_scale(left, share);
        sum = rgb_add(sum, rgb_mul(weight, bsdf->base_color));
        weights = rgb_add(weights, weight);
    }
    const float none = 1e-9f;
    return rgb(sum.r / f_max(weights.r, none), sum.g / f_max(weights.g, none),
        sum.b / f_max(weights.b, none));
}

rsv_rgb rsv_element_albedo(
    const rsv_transport_scene *scene, const rsv_elements *e, uint32_t seed, uint32_t node)
{
    if (node >= rsv_elements_surface_nodes(e)) return scene->view->fog->albedo;
    uint32_t material = scene->view->triangle_material[e->face_triangle[e->node_face[node]]];
    return scene->view->material_varies[material] ? mean_albedo(scene, e, seed, node)
                                                  : scene->bsdf[material].base_color;
}

typedef struct albedo_job {
    const rsv_transport_scene *scene;
    const rsv_elements *elements;
    uint32_t seed;
    rsv_rgb *albedo;
} albedo_job;

static void find_albedos(void *data, rsv_span span)
{
    const albedo_job *job = data;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->albedo[n] = rsv_element_albedo(job->scene, job->elements, job->seed, n);
}

rsv_status rsv_element_albedos(
    const rsv_transport_scene *scene, const rsv_elements *e, uint32_t seed, rsv_rgb **albedo)
{
    rsv_rgb *a = *albedo = rsv_alloc(e->context, e->node_count, sizeof *a);
    if (!a) return RSV_ERROR_MEMORY;
    albedo_job job = { scene, e, seed, a };
    rsv_parallel_for(e->context, e->node_count, 256, find_albedos, &job);
    return RSV_OK;
}

// ---- making one -----------------------------------------------------------------------------------

static rsv_status begin(rsv_world *world, rsv_elements *elements, rsv_operator **result)
{
    rsv_operator *op = *result = rsv_alloc(world->context, 1, sizeof *op);
    if (!op) return RSV_ERROR_MEMORY;
    op->references = 1;
    op->view.context = world->context;
    op->view.world = rsv_world_retain(world);
    op->view.elements = rsv_elements_retain(elements);
    return RSV_OK;
}

static rsv_status copy_valid_points(rsv_operator *op, const uint16_t *valid_points)
{
    size_t nodes = op->view.elements->node_count;
    op->valid_points = rsv_alloc(op->view.context, nodes, sizeof *valid_points);
    if (!op->valid_points) return RSV_ERROR_MEMORY;
    if (nodes) memcpy(op->valid_points, valid_points, nodes * sizeof *valid_points);
    op->view.valid_points = op->valid_points;
    return RSV_OK;
}

rsv_status rsv_operator_trace(const rsv_operator_desc *d, rsv_operator **result)
{
    rsv_status status;
    rsv_operator *op = NULL;
    RSV_TRY(begin(d->world, d->elements, &op));
    RSV_TRY(copy_valid_points(op, d->rows.valid_points));
    RSV_TRY(rsv_element_albedos(d->rows.scene, d->elements, d->rows.seed, &op->albedo));
    op->view.albedo = op->albedo;
    RSV_TRY(rsv_transport_create(&d->rows, &op->view.transport));
    *result = op;
    op = NULL;
cleanup:
    rsv_operator_release(op);
    return status;
}

rsv_status rsv_operator_restore(const rsv_operator_view *parts, rsv_operator **result)
{
    rsv_operator *op = NULL;
    rsv_status status = begin(parts->world, parts->elements, &op);
    if (status != RSV_OK) {
        rsv_free(parts->context, (void *)(uintptr_t)parts->valid_points);
        rsv_free(parts->context, (void *)(uintptr_t)parts->albedo);
        rsv_transport_destroy(parts->transport);
        rsv_subsurface_destroy(parts->subsurface);
        return status;
    }
    op->view = *parts;
    op->valid_points = (uint16_t *)(uintptr_t)parts->valid_points;
    op->albedo = (rsv_rgb *)(uintptr_t)parts->albedo;
    *result = op;
    return RSV_OK;
}

rsv_status rsv_operator_recolor(
    rsv_operator *base, rsv_world *world, const rsv_rgb *albedo, rsv_operator **result)
{
    rsv_operator *op = rsv_alloc(base->view.context, 1, sizeof *op);
    size_t nodes = base->view.elements->node_count;
    if (!op) return RSV_ERROR_MEMORY;
    op->references = 1;
    op->base = rsv_operator_retain(base->base ? base->base : base);
    op->view = base->view;
    op->view.world = rsv_world_retain(world);
    op->view.albedo = op->albedo = rsv_alloc(op->view.context, nodes, sizeof *op->albedo);
    if (!op->albedo) {
        rsv_operator_release(op);
        return RSV_ERROR_MEMORY;
    }
    if (nodes) memcpy(op->albedo, albedo, nodes * sizeof *albedo);
    *result = op;
    return RSV_OK;
}

rsv_status rsv_operator_scatter(rsv_operator *op)
{
    return rsv_subsurface_create(op->view.elements, &op->view.subsurface);
}

// ---- using one ------------------------------------------------------------------------------------

const rsv_operator_view *rsv_operator_get_view(const rsv_operator *op) { return &op->view; }

rsv_status rsv_operator_map(const rsv_operator *op, size_t fields, rsv_transport_map **map)
{
    const rsv_operator_view *v = &op->view;
    return rsv_transport_map_create(
        v->elements, v->transport, v->subsurface, v->albedo, fields, map);
}

size_t rsv_count_rows(const rsv_elements *elements, const uint16_t *valid_points)
{
    size_t rows = 0;
    for (size_t n = 0; n < elements->node_count; n++)
        rows += valid_points[n] != 0;
    return rows;
}

rsv_operator *rsv_operator_retain(rsv_operator *op)
{
    rsv_references_add(&op->references);
    return op;
}

static void release_rows(rsv_operator *op)
{
    rsv_subsurface_destroy(op->view.subsurface);
    rsv_transport_destroy(op->view.transport);
    rsv_free(op->view.context, op->valid_points);
    rsv_elements_destroy(op->view.elements);
}

void rsv_operator_release(rsv_operator *op)
{
    if (!op || !rsv_references_drop(&op->references)) return;
    rsv_context *context = op->view.context;
    rsv_operator *base = op->base;
    rsv_free(context, op->albedo);
    if (!base) release_rows(op);
    rsv_world_release(op->view.world);
    rsv_free(context, op);
    rsv_operator_release(base);
}

static bool is_gray(rsv_rgb c) { return c.r == c.g && c.g == c.b; }

bool rsv_operator_is_gray(const rsv_operator *op)
{
    const rsv_operator_view *v = rsv_operator_get_view(op);
    if (v->subsurface || v->transport->division) return false;
    for (size_t n = 0; n < v->elements->node_count; n++) {
        rsv_transport_row row = rsv_transport_row_at(v->transport, n);
        if (!is_gray(v->albedo[n])) return false;
        for (size_t k = 0; k < row.tinted_count; k++)
            if (!is_gray(row.tinted_weight[k])) return false;
    }
    return true;
}
