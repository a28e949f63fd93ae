#include "system.h"

#include "../elements/elements_internal.h"

/// Places on each element where textured albedo is looked up.
#define ALBEDO_POINTS 16

bool rsv_reflects_diffusely(const rsv_solution *s)
{
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        if (s->bsdf[m].diffuse > 0 && !rgb_is_black(s->bsdf[m].base_color)) return true;
    return false;
}

/// Mean over the hat function of a node: irradiance is smooth there, textures are not. Weighted by the share of
/// light that leaves diffusely, which gather rays take care of.
static rsv_rgb mean_albedo(const rsv_solution *s, uint32_t node)
{
    const rsv_elements *e = s->elements;
    rsv_support_point sample[ALBEDO_POINTS];
    if (e->support_begin[node] == e->support_begin[node + 1]) return rgb_gray(0); // bridged
    rsv_elements_sample_support(e, node, ALBEDO_POINTS, s->desc.seed, sample);
    float width = sqrtf(3 * e->node_area[node] / ALBEDO_POINTS);
    rsv_rgb sum = rgb_gray(0), weights = rgb_gray(0);
    for (uint32_t k = 0; k < ALBEDO_POINTS; k++) {
        rsv_bsdf storage;
        uint32_t triangle = e->face_triangle[e->cell[sample[k].support / 4].face];
        const rsv_bsdf *bsdf = rsv_surface_entry_bsdf(
            s->scene.view, s->bsdf, triangle, sample[k].u, sample[k].v, width, &storage);
        rsv_rgb scale = bsdf->entry_scale, left = rgb(1 / scale.r, 1 / scale.g, 1 / scale.b);
        rsv_rgb weight = rgb_scale(left, bsdf->diffuse * bsdf->opacity);
        sum = rgb_add(sum, rgb_mul(weight, bsdf->base_color));
        weights = rgb_add(weights, weight);
    }
    const float none = 1e-9f;
    return rgb(sum.r / f_max(weights.r, none), sum.g / f_max(weights.g, none),
        sum.b / f_max(weights.b, none));
}

rsv_status rsv_system_create_fields(rsv_solution *s)
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
                                    : s->bsdf[material].base_color;
    }
    return RSV_OK;
}

rsv_status rsv_system_assemble(rsv_solution *s, uint32_t rays)
{
    rsv_status status = rsv_transport_create(
        &s->scene, s->lights, s->elements, s->valid_points, rays, s->desc.seed, &s->transport);
    if (status != RSV_OK) return status;
    s->report.rays += s->transport->rays;
    s->report.row_rays += s->transport->rays;
    s->report.kept_row_rays += s->transport->kept_rays;
    s->report.spared_seconds += s->transport->spared_seconds;
    return status;
}

void rsv_system_destroy(rsv_solution *s)
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
