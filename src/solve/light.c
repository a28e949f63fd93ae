#include "light_internal.h"

#include "../scene/scene.h"
#include "source.h"

#include <string.h>

// ---- making one -----------------------------------------------------------------------------------

static rsv_status copy_goal_points(rsv_light *s)
{
    size_t count = s->desc.goal_point_count;
    const rsv_probe *points = s->desc.goal_points;
    s->desc.goal_points = NULL;
    if (count == 0) return RSV_OK;
    s->goal_points = rsv_alloc(s->context, count, sizeof *points);
    if (!s->goal_points) return RSV_ERROR_MEMORY;
    memcpy(s->goal_points, points, count * sizeof *points);
    s->desc.goal_points = s->goal_points;
    return RSV_OK;
}

/// A light without fields.
static rsv_status create(rsv_operator *op, rsv_world *world, rsv_light_sources *sources,
    const rsv_solve_desc *desc, rsv_light **light)
{
    rsv_light *s = *light = rsv_alloc(world->context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    s->context = world->context;
    s->op = rsv_operator_retain(op);
    s->elements = rsv_operator_get_view(op)->elements;
    s->world = rsv_world_retain(world);
    s->scene = world->scene;
    s->sources = rsv_light_sources_retain(sources);
    s->desc = *desc;
    s->gathered_scale = rgb_gray(1);
    return copy_goal_points(s);
}

static rsv_status allocate(rsv_light *s, rsv_rgb **field, size_t count)
{
    *field = rsv_alloc(s->context, count, sizeof **field);
    return *field ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status rsv_light_begin(rsv_operator *op, rsv_light_sources *sources,
    const rsv_transport_scene *scene, const rsv_solve_desc *desc, rsv_light **light)
{
    rsv_status status;
    rsv_light *s = NULL;
    RSV_TRY(create(op, rsv_operator_get_view(op)->world, sources, desc, &s));
    s->scene = *scene;
    RSV_TRY(allocate(s, &s->field.source, s->elements->node_count));
    RSV_TRY(allocate(s, &s->field.gathered, s->elements->node_count));
    rsv_light_publish(s);
    *light = s;
    s = NULL;
cleanup:
    rsv_light_destroy(s);
    return status;
}

/// The elements of a level, and zeros on them.
static rsv_status begin_level_like(
    rsv_light *s, const rsv_source_level *like, rsv_source_level *level)
{
    rsv_status status = RSV_OK;
    if (!like->elements) return RSV_OK;
    level->elements = rsv_elements_retain(like->elements);
    size_t nodes = level->elements->node_count;
    if (like->direct) RSV_TRY(allocate(s, &level->direct, nodes));
    if (like->caustic) RSV_TRY(allocate(s, &level->caustic, nodes));
    if (like->coarse_caustic) RSV_TRY(allocate(s, &level->coarse_caustic, s->elements->node_count));
cleanup:
    return status;
}

rsv_status rsv_light_begin_like(
    const rsv_light *like, rsv_light_sources *sources, rsv_light **light)
{
    rsv_status status;
    rsv_light *s = NULL;
    RSV_TRY(create(like->op, like->world, sources, &like->desc, &s));
    s->gathered_scale = like->gathered_scale;
    size_t nodes = s->elements->node_count;
    RSV_TRY(allocate(s, &s->field.source, nodes));
    RSV_TRY(allocate(s, &s->field.gathered, nodes));
    RSV_TRY(allocate(s, &s->field.irradiance, nodes));
    RSV_TRY(allocate(s, &s->field.indirect, nodes));
    RSV_TRY(begin_level_like(s, &like->field.fine, &s->field.fine));
    RSV_TRY(begin_level_like(s, &like->field.caustics, &s->field.caustics));
    rsv_light_publish(s);
    *light = s;
    s = NULL;
cleanup:
    rsv_light_destroy(s);
    return status;
}

void rsv_light_fields_free(rsv_context *context, rsv_light_fields *f)
{
    rsv_diffused_level_destroy(context, &f->diffused);
    rsv_source_level_destroy(context, &f->fine);
    rsv_source_level_destroy(context, &f->caustics);
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++)
        rsv_free(context, f->order[k]);
    rsv_free(context, f->irradiance);
    rsv_free(context, f->indirect);
    rsv_free(context, f->source);
    rsv_free(context, f->gathered);
    *f = (rsv_light_fields){ 0 };
}

rsv_status rsv_light_restore(rsv_operator *op, rsv_light_sources *sources,
    const rsv_solve_desc *desc, const rsv_light_fields *fields, const rsv_solve_report *report,
    rsv_light **light)
{
    rsv_light *s = NULL;
    rsv_light_fields given = *fields;
    rsv_status status = create(op, rsv_operator_get_view(op)->world, sources, desc, &s);
    if (s)
        s->field = given;
    else
        rsv_light_fields_free(sources->context, &given);
    RSV_TRY(status);
    s->report = *report;
    RSV_TRY(rsv_diffused_level_name_materials(s));
    rsv_light_publish(s);
    *light = s;
    s = NULL;
cleanup:
    rsv_light_destroy(s);
    return status;
}

static void copy_field(const rsv_rgb *from, size_t count, rsv_rgb *to)
{
    if (from && to && count) memcpy(to, from, count * sizeof *from);
}

static rsv_status copy_orders(const rsv_light *from, rsv_light *to)
{
    rsv_status status = RSV_OK;
    size_t nodes = from->elements->node_count;
    to->field.order_count = from->field.order_count;
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        if (!from->field.order[k]) continue;
        RSV_TRY(allocate(to, &to->field.order[k], nodes));
        copy_field(from->field.order[k], nodes, to->field.order[k]);
    }
cleanup:
    return status;
}

static rsv_status copy_level(rsv_light *s, const rsv_source_level *from, rsv_source_level *to)
{
    rsv_status status = RSV_OK;
    if (to->elements != from->elements) {
        rsv_source_level_destroy(s->context, to);
        RSV_TRY(begin_level_like(s, from, to));
    }
    if (!from->elements) return RSV_OK;
    copy_field(from->direct, from->elements->node_count, to->direct);
    copy_field(from->caustic, from->elements->node_count, to->caustic);
    copy_field(from->coarse_caustic, s->elements->node_count, to->coarse_caustic);
cleanup:
    return status;
}

void rsv_light_drop_orders(rsv_light *s)
{
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        rsv_free(s->context, s->field.order[k]);
        s->field.order[k] = NULL;
    }
    s->field.order_count = 0;
}

rsv_status rsv_light_take_levels(rsv_light *s, const rsv_light *from)
{
    rsv_status status;
    RSV_TRY(copy_level(s, &from->field.fine, &s->field.fine));
    RSV_TRY(copy_level(s, &from->field.caustics, &s->field.caustics));
cleanup:
    rsv_light_publish(s);
    return status;
}

rsv_status rsv_light_assign(rsv_light *s, const rsv_light *from)
{
    rsv_status status;
    size_t nodes = from->elements->node_count;
    rsv_operator *before = s->op;
    s->op = rsv_operator_retain(from->op);
    rsv_operator_release(before);
    copy_field(from->field.source, nodes, s->field.source);
    copy_field(from->field.gathered, nodes, s->field.gathered);
    copy_field(from->field.irradiance, nodes, s->field.irradiance);
    copy_field(from->field.indirect, nodes, s->field.indirect);
    rsv_light_drop_orders(s);
    RSV_TRY(copy_orders(from, s));
    RSV_TRY(rsv_light_take_levels(s, from));
    rsv_diffused_level_destroy(s->context, &s->field.diffused);
    RSV_TRY(rsv_diffused_level_copy(
        s->context, &from->field.diffused, s->scene.view->material_count, &s->field.diffused));
    s->gathered_scale = from->gathered_scale;
    s->pocket_area = from->pocket_area;
    s->report = from->report;
cleanup:
    rsv_light_publish(s);
    return status;
}

rsv_status rsv_light_copy(const rsv_light *from, rsv_light **copy)
{
    rsv_status status;
    rsv_light *s = NULL;
    RSV_TRY(rsv_light_begin_like(from, from->sources, &s));
    RSV_TRY(rsv_light_assign(s, from));
    // a world that may change must not be shared
    if (from->world->variant) RSV_TRY(rsv_light_part_world(s));
    if (from->basis && rsv_light_basis_is_scaled(from->basis)) {
        RSV_TRY(rsv_light_basis_copy(from->basis, s, &s->basis));
        rsv_light_publish(s);
    }
    *copy = s;
    s = NULL;
cleanup:
    rsv_light_destroy(s);
    return status;
}

void rsv_light_destroy(rsv_light *s)
{
    if (!s) return;
    rsv_context *context = s->context;
    rsv_light_basis_destroy(s->basis);
    rsv_following_destroy(context, s->following);
    rsv_light_fields_free(context, &s->field);
    rsv_free(context, s->goal_points);
    if (s->sources) rsv_light_sources_release(s->sources);
    rsv_world_release(s->world);
    rsv_operator_release(s->op);
    rsv_free(context, s);
}

void rsv_light_publish(rsv_light *s)
{
    const rsv_operator_view *op = rsv_operator_get_view(s->op);
    const rsv_light_fields *f = &s->field;
    s->scene.fog_lights = s->scene.view->fog ? &s->sources->fog_lights : NULL;
    s->view = (rsv_light_view){ .light = s,
        .context = s->context,
        .op = s->op,
        .scene = s->scene,
        .tracer = s->scene.tracer,
        .bsdf = s->scene.bsdf,
        .lights = s->sources->lights,
        .fog_lights = s->scene.fog_lights,
        .desc = s->desc,
        .elements = op->elements,
        .valid_points = op->valid_points,
        .transport = op->transport,
        .exitance_albedo = op->albedo,
        .subsurface = op->subsurface,
        .bin_radiance = s->sources->bin_radiance,
        .gathered = f->gathered,
        .source = f->source,
        .irradiance = f->irradiance,
        .order_count = f->order_count,
        .indirect = f->indirect,
        .fine = f->fine,
        .caustics = f->caustics,
        .diffused = f->diffused,
        .gathered_scale = s->gathered_scale,
        .pocket_area = s->pocket_area,
        .basis = s->basis,
        .report = s->report };
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++)
        s->view.order[k] = f->order[k];
}

// ---- looking up -----------------------------------------------------------------------------------

const rsv_light_view *rsv_light_get_view(const rsv_light *s) { return &s->view; }

rsv_operator *rsv_light_operator(const rsv_light *s) { return s->op; }

const rsv_rgb *rsv_light_source_field(const rsv_light *s) { return s->field.source; }

const rsv_rgb *rsv_light_irradiance_field(const rsv_light *s) { return s->field.irradiance; }

const rsv_solve_report *rsv_light_report(const rsv_light *s) { return &s->report; }

const rsv_scene *rsv_light_scene(const rsv_light *s) { return s->scene.scene; }

uint32_t rsv_light_order_count(const rsv_light *s) { return s->field.order_count; }

rsv_status rsv_light_refuse_fog(const rsv_light_view *s, const char *what)
{
    return rsv_scene_refuse_fog(s->scene.scene, what);
}

bool rsv_light_has_parts(const rsv_light_view *s)
{
    const rsv_fog *fog = s->scene.view->fog;
    return !fog || (fog->anisotropy == 0 && rgb_is_black(fog->emission));
}

rsv_status rsv_light_require_parts(const rsv_light_view *s)
{
    if (rsv_light_has_parts(s)) return RSV_OK;
    bool uneven = s->scene.view->fog->anisotropy != 0;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "relight: in fog that %s, rows store the light of all sources together; %s",
        uneven ? "scatters unevenly" : "emits light",
        uneven ? "use G = 0 (--fog EXTINCTION,ALBEDO)" : "leave out its emission");
}

rsv_rgb rsv_light_view_direct(
    const rsv_light_view *s, uint32_t face, float u, float v, bool skip_sampled)
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

bool rsv_has_unseen_caustics(const rsv_light_view *s)
{
    return s->caustics.caustic && s->lights->punctual_count > 0;
}

rsv_rgb rsv_light_view_scattered(
    const rsv_light_view *s, uint32_t node, uint32_t order, bool skip_sampled)
{
    rsv_rgb e = rgb_gray(0);
    if (order == 0 && !skip_sampled)
        e = s->source[node];
    else if (order == 0)
        e = s->caustics.coarse_caustic
                ? rgb_add(s->gathered[node], s->caustics.coarse_caustic[node])
                : s->gathered[node];
    else if (order == RSV_NONE)
        e = s->indirect[node];
    else if (order < s->order_count)
        e = s->order[order][node];
    return rgb_scale(rgb_mul(e, s->exitance_albedo[node]), 1 / RSV_PI);
}

rsv_rgb rsv_light_view_irradiance(
    const rsv_light_view *s, uint32_t triangle, float u, float v, bool back_side, uint32_t order)
{
    uint32_t face = s->elements->face_of[back_side][triangle];
    if (face == RSV_NONE) return rgb_gray(0);
    if (order == 0) return rsv_light_view_direct(s, face, u, v, false);
    if (order != RSV_NONE)
        return order < s->order_count
                   ? rsv_elements_interpolate(s->elements, s->order[order], face, u, v)
                   : rgb_gray(0);
    return rgb_add(rsv_light_view_direct(s, face, u, v, false),
        rsv_elements_interpolate(s->elements, s->indirect, face, u, v));
}

rsv_rgb rsv_light_irradiance(
    const rsv_light *s, uint32_t triangle, float u, float v, bool back_side, uint32_t order)
{
    return rsv_light_view_irradiance(&s->view, triangle, u, v, back_side, order);
}
