#include "diffused_level.h"

#include "../elements/burial.h"
#include "../elements/contact.h"
#include "../elements/elements.h"
#include "../elements/follower.h"
#include "../elements/open_corners.h"
#include "light_internal.h"
#include "solve_constants.h"

#include <string.h>

static const rsv_material *face_material(const rsv_elements *e, uint32_t face)
{
    return &e->scene->material[e->scene->triangle_material[e->face_triangle[face]]];
}

bool rsv_is_translucent(const rsv_light_view *s, uint32_t face)
{
    if (!s->diffused.elements) return false;
    return s->diffused.material[s->scene.view->triangle_material[s->elements->face_triangle[face]]];
}

rsv_status rsv_diffused_level_name_materials(rsv_light *s)
{
    size_t count = s->scene.view->material_count;
    s->field.diffused.material = rsv_alloc(s->context, count, 1);
    if (!s->field.diffused.material) return RSV_ERROR_MEMORY;
    for (size_t m = 0; m < count; m++)
        s->field.diffused.material[m] = rsv_material_scatters_below(&s->scene.view->material[m]);
    return RSV_OK;
}

static bool any_translucent(const rsv_light *s)
{
    size_t count = s->scene.view->material_count;
    return count && memchr(s->field.diffused.material, 1, count);
}

static float cell_size(const rsv_elements *e, uint32_t cell)
{
    return sqrtf(2 * rsv_cell_area(e, cell));
}

static float wanted_size(const rsv_material *m)
{
    rsv_scatter_profile profile = rsv_scatter_profile_of(m);
    return rsv_scatter_profile_narrowest(&profile) / CELLS_PER_PROFILE;
}

static float finest_wanted(const rsv_light *s)
{
    const rsv_scene_view *view = s->scene.view;
    float finest = INFINITY;
    for (size_t m = 0; m < view->material_count; m++)
        if (s->field.diffused.material[m]) finest = f_min(finest, wanted_size(&view->material[m]));
    return finest;
}

/// Size of cells at which the translucent surfaces use up the budget.
static float affordable_size(const rsv_light *s)
{
    const rsv_elements *e = s->elements;
    double area = 0;
    for (uint32_t face = 0; face < e->face_count; face++)
        if (rsv_material_scatters_below(face_material(e, face))) area += (double)e->face_area[face];
    return (float)sqrt(area / (DIFFUSED_CELLS * (double)s->desc.element_target));
}

/// Marks cells of translucent faces that are larger than they should be; counts them.
static size_t mark_large(const rsv_elements *e, float affordable, uint8_t *split)
{
    size_t marked = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        const rsv_material *m = face_material(e, e->cell[c].face);
        split[c] = 0;
        if (!rsv_material_scatters_below(m) || e->cell[c].level >= RSV_MAX_LEVEL) continue;
        // a split halves the size: it is worth it if the cell is more than sqrt(2) too large
        split[c] = cell_size(e, c) > 1.4142f * f_max(wanted_size(m), affordable);
        marked += split[c];
    }
    return marked;
}

/// The coarse elements, split on translucent faces.
static rsv_status create_elements(rsv_light *s)
{
    rsv_status status;
    float affordable = affordable_size(s);
    rsv_elements *e = NULL, *finer = NULL;
    uint8_t *split = rsv_alloc(s->context, s->elements->cell_count, 1);
    if (!split) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_elements_refine(s->elements, split, &e)); // a copy
    for (;;) {
        rsv_free(s->context, split);
        split = rsv_alloc(s->context, e->cell_count, 1);
        if (!split) RSV_TRY(RSV_ERROR_MEMORY);
        if (mark_large(e, affordable, split) == 0) break;
        RSV_TRY(rsv_elements_refine(e, split, &finer));
        rsv_elements_destroy(e);
        e = finer;
        finer = NULL;
    }
    RSV_TRY(rsv_elements_find_open_corners(&s->scene, s->elements, e, &s->report.rays));
    RSV_TRY(rsv_elements_separate(&s->scene, NULL, e, &s->report.rays));
    RSV_TRY(rsv_elements_cluster(e, CLUSTER_SHARE * f_max(finest_wanted(s), affordable)));
    s->field.diffused.elements = e;
    e = NULL;
cleanup:
    rsv_free(s->context, split);
    rsv_elements_destroy(e);
    return status;
}

static bool is_translucent_node(const rsv_elements *e, uint32_t node)
{
    return rsv_material_scatters_below(face_material(e, e->node_face[node]));
}

/// The value of a coarse or fine field at a node of the level.
static rsv_rgb field_at(
    const rsv_elements *level, uint32_t node, const rsv_elements *elements, const rsv_rgb *field)
{
    uint32_t face;
    float u, v;
    rsv_elements_place_node(level, node, &face, &u, &v);
    return rsv_elements_interpolate(elements, field, face, u, v);
}

/// Direct light at the level's own nodes; gathered light and photons come from where they are stored.
static rsv_status create_entered(rsv_light *s)
{
    const rsv_elements *e = s->field.diffused.elements;
    rsv_status status;
    uint64_t *rays = &s->report.rays;
    uint16_t *valid = rsv_alloc(s->context, e->node_count, sizeof *valid);
    uint8_t *known = rsv_alloc(s->context, e->node_count, 1);
    rsv_rgb *entered = s->field.diffused.entered =
        rsv_alloc(s->context, e->node_count, sizeof *entered);
    const rsv_direct_job job = { .scene = &s->scene,
        .elements = e,
        .setting = { s->sources->lights, s->scene.bsdf, DIFFUSED_POINTS,
            s->desc.seed ^ 0x3c6ef372u },
        .samples = 4 * s->desc.light_samples,
        .valid_points = valid };
    rsv_direct_light light = { .irradiance = entered };
    if (!valid || !known || !entered) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(rsv_find_buried(
        &s->scene, e, (rsv_support_draw){ DIFFUSED_POINTS, s->desc.seed }, NULL, valid, rays));
    RSV_TRY(rsv_elements_bridge_buried(s->field.diffused.elements, valid));
    for (uint32_t n = 0; n < e->node_count; n++)
        known[n] = !is_translucent_node(e, n);
    RSV_TRY(rsv_direct_irradiance(&job, known, &light));
    *rays += light.rays;
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (!valid[n] || known[n]) continue;
        entered[n] = rgb_add(entered[n], field_at(e, n, s->elements, s->field.gathered));
        if (s->field.caustics.caustic)
            entered[n] = rgb_add(
                entered[n], field_at(e, n, s->field.caustics.elements, s->field.caustics.caustic));
    }
    rsv_elements_constrain(e, entered);
cleanup:
    rsv_free(s->context, valid);
    rsv_free(s->context, known);
    return status;
}

/// order n = P of the solved irradiance of that order.
static rsv_status diffuse_order(
    rsv_light *s, rsv_subsurface *p, uint32_t order, rsv_rgb *irradiance)
{
    const rsv_elements *e = s->field.diffused.elements;
    rsv_rgb *diffused = s->field.diffused.order[order] =
        rsv_alloc(s->context, e->node_count, sizeof *diffused);
    if (!diffused) return RSV_ERROR_MEMORY;
    for (uint32_t n = 0; order > 0 && n < e->node_count; n++)
        if (is_translucent_node(e, n))
            irradiance[n] = field_at(e, n, s->elements, s->field.order[order]);
    rsv_subsurface_apply(p, e, order > 0 ? irradiance : s->field.diffused.entered, diffused);
    for (uint32_t n = 0; order > 0 && n < e->node_count; n++)
        s->field.diffused.indirect[n] = rgb_add(s->field.diffused.indirect[n], diffused[n]);
    return RSV_OK;
}

rsv_status rsv_diffused_level_create(rsv_light *s)
{
    rsv_status status = RSV_OK;
    rsv_subsurface *p = NULL;
    rsv_rgb *irradiance = NULL;
    RSV_TRY(rsv_diffused_level_name_materials(s));
    if (!any_translucent(s)) return RSV_OK;
    RSV_TRY(create_elements(s));
    RSV_TRY(create_entered(s));
    RSV_TRY(rsv_subsurface_create(s->field.diffused.elements, &p));
    size_t nodes = s->field.diffused.elements->node_count;
    irradiance = rsv_alloc(s->context, nodes, sizeof *irradiance);
    s->field.diffused.indirect = rsv_alloc(s->context, nodes, sizeof *s->field.diffused.indirect);
    if (!irradiance || !s->field.diffused.indirect) RSV_TRY(RSV_ERROR_MEMORY);
    for (uint32_t order = 0; order < s->field.order_count; order++)
        RSV_TRY(diffuse_order(s, p, order, irradiance));
cleanup:
    rsv_free(s->context, irradiance);
    rsv_subsurface_destroy(p);
    return status;
}

/// @param to NULL stays NULL where there is nothing to copy
static rsv_status copy_array(
    rsv_context *context, const void *from, size_t count, size_t size, void **to)
{
    if (!from) return RSV_OK;
    *to = rsv_alloc(context, count, size);
    if (!*to) return RSV_ERROR_MEMORY;
    if (count) memcpy(*to, from, count * size);
    return RSV_OK;
}

rsv_status rsv_diffused_level_copy(rsv_context *context, const rsv_diffused_level *level,
    size_t material_count, rsv_diffused_level *copy)
{
    rsv_status status;
    size_t nodes = level->elements ? level->elements->node_count : 0, rgb_bytes = sizeof(rsv_rgb);
    copy->elements = rsv_elements_retain(level->elements);
    RSV_TRY(copy_array(context, level->material, material_count, 1, (void **)&copy->material));
    RSV_TRY(copy_array(context, level->entered, nodes, rgb_bytes, (void **)&copy->entered));
    RSV_TRY(copy_array(context, level->indirect, nodes, rgb_bytes, (void **)&copy->indirect));
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++)
        RSV_TRY(copy_array(context, level->order[k], nodes, rgb_bytes, (void **)&copy->order[k]));
cleanup:
    return status;
}

void rsv_diffused_level_destroy(rsv_context *context, rsv_diffused_level *level)
{
    rsv_elements_destroy(level->elements);
    rsv_free(context, level->material);
    rsv_free(context, level->entered);
    rsv_free(context, level->indirect);
    for (uint32_t order = 0; order < RSV_KEPT_ORDERS; order++)
        rsv_free(context, level->order[order]);
    *level = (rsv_diffused_level){ 0 };
}

rsv_rgb rsv_light_view_diffused(
    const rsv_light_view *s, uint32_t face, float u, float v, uint32_t order)
{
    const rsv_rgb *field = order == RSV_NONE ? s->diffused.indirect : s->diffused.order[order];
    return rsv_elements_interpolate(s->diffused.elements, field, face, u, v);
}

rsv_rgb rsv_diffused_share(const rsv_elements *e, uint32_t cell)
{
    if (!rsv_material_scatters_below(face_material(e, e->cell[cell].face))) return rgb_gray(1);
    rsv_scatter_profile p = rsv_scatter_profile_of(face_material(e, e->cell[cell].face));
    double finest = (double)(RSV_PI / rsv_cell_spacing(e, cell));
    return rgb((float)rsv_diffusion_transfer((double)p.d[0], finest),
        (float)rsv_diffusion_transfer((double)p.d[1], finest),
        (float)rsv_diffusion_transfer((double)p.d[2], finest));
}

rsv_unresolved rsv_light_unresolved(const rsv_light_view *s, uint32_t face, float u, float v)
{
    const rsv_elements *e = s->diffused.elements;
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, face, u, v, weight);
    return (rsv_unresolved){ .known = rsv_elements_interpolate(e, s->diffused.entered, face, u, v),
        .share = rsv_diffused_share(e, cell) };
}

rsv_rgb rsv_light_view_diffused_direct(const rsv_light_view *s, uint32_t face, float u, float v)
{
    rsv_rgb direct = rsv_light_view_diffused(s, face, u, v, 0);
    if (!s->fine.direct) return direct;
    rsv_unresolved detail = rsv_light_unresolved(s, face, u, v);
    rsv_rgb stored = rsv_light_view_direct(s, face, u, v, false);
    return rgb_add(direct, rgb_mul(detail.share, rgb_sub(stored, detail.known)));
}
