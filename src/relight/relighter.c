#include "relight_responses.h"

#include <math.h>
#include <string.h>

/// Has the light know its parts of E0, at the strengths that its sources have now.
static rsv_status find_basis(rsv_relighter *r)
{
    if (!r->s->basis) {
        rsv_light_basis *found = NULL;
        rsv_status status = rsv_light_basis_create(r->light, &found);
        if (status != RSV_OK) return status;
        rsv_light_set_basis(r->light, found);
    }
    r->basis = rsv_light_edit_basis(r->light);
    rsv_light_basis_apply_scales(r->light, r->basis);
    return r->basis->source_count <= RSV_MAX_LIGHT_PARTS
               ? RSV_OK
               : rsv_fail(RSV_ERROR_UNSUPPORTED,
                     "relight: the scene has %zu lights; at most %d are kept apart",
                     r->basis->source_count, RSV_MAX_LIGHT_PARTS);
}

/// Makes room in a basis for all sources that there may ever be.
static rsv_status make_room(rsv_relighter *r)
{
    rsv_light_basis *b = r->basis;
    size_t count = b->source_count;
    rsv_light_basis more = { .source =
                                 rsv_alloc(r->context, RSV_MAX_LIGHT_PARTS, sizeof *b->source),
        .part = rsv_alloc(r->context, RSV_MAX_LIGHT_PARTS, sizeof *b->part),
        .scale = rsv_alloc(r->context, RSV_MAX_LIGHT_PARTS, sizeof *b->scale) };
    bool made = more.source && more.part && more.scale;
    if (made && count) {
        memcpy(more.source, b->source, count * sizeof *b->source);
        memcpy(more.part, b->part, count * sizeof *b->part);
        memcpy(more.scale, b->scale, count * sizeof *b->scale);
    }
    rsv_free(r->context, made ? b->source : more.source);
    rsv_free(r->context, made ? b->part : more.part);
    rsv_free(r->context, made ? b->scale : more.scale);
    if (!made) return RSV_ERROR_MEMORY;
    b->source = more.source;
    b->part = more.part;
    b->scale = more.scale;
    return RSV_OK;
}

/// The part of a source that is the only one is all there is.
static rsv_status fill_single_part(rsv_relighter *r)
{
    for (size_t field = 0; field < RSV_LIGHT_FIELDS && r->basis->source_count == 1; field++) {
        size_t length = rsv_light_field_length(r->light, field);
        rsv_rgb **part = rsv_light_part_field(&r->basis->part[0], field);
        if (!length || *part) continue;
        *part = rsv_alloc(r->context, length, sizeof **part);
        if (!*part) return RSV_ERROR_MEMORY;
        rsv_light_total(r->light, field, *part);
    }
    return RSV_OK;
}

static void note_movable(rsv_relighter *r)
{
    for (size_t k = 0; k < r->basis->source_count; k++)
        if (r->basis->source[k].kind == RSV_SOURCE_MATERIAL)
            r->moves[r->basis->source[k].index] = rsv_relighter_source(r, k).movable;
}

static void note_settings(rsv_relighter *r)
{
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_rgb *strength = rsv_source_strength(r->scene, &r->basis->source[k]);
        r->strength[k] = strength ? *strength : rgb_gray(1);
        r->home.scale[k] = r->now.scale[k] = rgb_gray(1);
    }
    for (size_t m = 0; m < r->scene->material_count; m++)
        r->home.base_color[m] = r->now.base_color[m] = r->scene->material[m].base_color;
    r->home.rotation = r->now.rotation = r->scene->environment.rotation;
    r->environment_scale = rgb_gray(1);
    r->gathered_scale = r->s->gathered_scale;
    if (r->environment)
        memcpy(r->environment, r->scene->environment.pixels,
            rsv_surroundings_length(r->scene) * sizeof *r->environment);
}

static rsv_status allocate(rsv_relighter *r)
{
    size_t sources = RSV_MAX_LIGHT_PARTS, materials = r->scene->material_count;
    rsv_light_settings *settings[] = { &r->home, &r->now, &r->wanted };
    for (int k = 0; k < 3; k++)
        if (rsv_light_settings_allocate(r->context, sources, materials, settings[k]) != RSV_OK)
            return RSV_ERROR_MEMORY;
    r->strength = rsv_alloc(r->context, sources, sizeof *r->strength);
    r->place = rsv_alloc(r->context, sources, sizeof *r->place);
    r->moves = rsv_alloc(r->context, materials, sizeof *r->moves);
    r->stale = rsv_alloc(r->context, sources, sizeof *r->stale);
    r->moved = rsv_alloc(r->context, sources, sizeof *r->moved);
    r->away = rsv_alloc(r->context, sources, sizeof *r->away);
    r->home_part = rsv_alloc(r->context, sources, sizeof *r->home_part);
    r->began_part = rsv_alloc(r->context, sources, sizeof *r->began_part);
    r->next = rsv_alloc(r->context, rsv_relighter_nodes(r), sizeof *r->next);
    r->scratch = rsv_alloc(r->context, rsv_relighter_nodes(r), sizeof *r->scratch);
    bool surrounded = r->scene->environment.pixels != NULL;
    if (surrounded)
        r->environment =
            rsv_alloc(r->context, rsv_surroundings_length(r->scene), sizeof *r->environment);
    return r->strength && r->place && r->moves && r->stale && r->moved && r->away && r->home_part &&
                   r->began_part && r->next && r->scratch && (r->environment || !surrounded)
               ? RSV_OK
               : RSV_ERROR_MEMORY;
}

rsv_status rsv_relighter_map(rsv_relighter *r)
{
    rsv_transport_map_destroy(r->map);
    r->map = NULL;
    return rsv_operator_map(r->s->op, 1, &r->map);
}

static rsv_status begin(rsv_light *light, rsv_relighter **relighter)
{
    rsv_status status = rsv_light_vary_world(light);
    if (status != RSV_OK) return status;
    const rsv_light_view *view = rsv_light_get_view(light);
    rsv_relighter *r = *relighter = rsv_alloc(view->context, 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    *r = (rsv_relighter){ .context = view->context,
        .light = light,
        .s = view,
        .field = rsv_light_edit(light),
        .scene = rsv_light_world(light)->variant,
        .settled = true };
    return RSV_OK;
}

rsv_status rsv_relighter_create(rsv_light *light, rsv_relighter **relighter)
{
    rsv_status status;
    rsv_relighter *r = NULL;
    RSV_TRY(rsv_light_refuse_fog(rsv_light_get_view(light), "relighting"));
    RSV_TRY(begin(light, &r));
    RSV_TRY(find_basis(r));
    RSV_TRY(make_room(r));
    RSV_TRY(fill_single_part(r));
    RSV_TRY(allocate(r));
    note_settings(r);
    RSV_TRY(rsv_light_places_find(r->scene, r->basis->source, r->basis->source_count, r->place));
    RSV_TRY(rsv_relighter_find_lights(r));
    note_movable(r);
    RSV_TRY(rsv_find_fine_valid(light, &r->valid));
    RSV_TRY(rsv_relighter_map(r));
    *relighter = r;
    return RSV_OK;
cleanup:
    rsv_relighter_destroy(r);
    return status;
}

void rsv_relighter_destroy(rsv_relighter *r)
{
    if (!r) return;
    rsv_context *context = r->context;
    size_t sources = r->basis ? r->basis->source_count : 0;
    // parts that few rays found are no better than none
    if (r->basis && r->stale && (r->behind || rsv_relighter_any_stale(r)))
        rsv_light_set_basis(r->light, NULL);
    for (size_t k = 0; r->home_part && k < RSV_MAX_LIGHT_PARTS; k++)
        rsv_light_part_free(context, &r->home_part[k]);
    for (size_t k = 0; r->began_part && k < RSV_MAX_LIGHT_PARTS; k++)
        rsv_light_part_free(context, &r->began_part[k]);
    rsv_light_destroy(r->began);
    rsv_transport_map_destroy(r->map);
    rsv_free(context, r->moves);
    rsv_receiver_blocks_destroy(r->coarse);
    rsv_receiver_blocks_destroy(r->fine);
    rsv_light_places_free(context, r->place, sources);
    rsv_light_settings_free(context, &r->home);
    rsv_light_settings_free(context, &r->now);
    rsv_light_settings_free(context, &r->wanted);
    rsv_light_sources_release(r->sources);
    rsv_free(context, r->place);
    rsv_free(context, r->strength);
    rsv_free(context, r->stale);
    rsv_free(context, r->moved);
    rsv_free(context, r->away);
    rsv_free(context, r->home_part);
    rsv_free(context, r->began_part);
    rsv_free(context, r->environment);
    rsv_free(context, r->next);
    rsv_free(context, r->scratch);
    rsv_free(context, r->valid);
    rsv_relight_responses_destroy(r->responses);
    rsv_free(context, r);
}
