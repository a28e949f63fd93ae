#include "relight_responses.h"

#include <math.h>
#include <string.h>

/// Computes the light's contributions to E0, if it has none.
static rsv_status find_basis(rsv_relighter *r)
{
    if (!r->s->basis) {
        rsv_light_basis *found = NULL;
        rsv_status status = rsv_light_basis_create(r->light, &found);
        if (status != RSV_OK) return status;
        rsv_light_set_basis(r->light, found);
    }
    r->basis = rsv_light_edit_basis(r->light);
    return rsv_light_basis_check(r->light, r->basis);
}

/// Room for `to` in place of `from` elements.
static rsv_status widen(rsv_context *context, void *array, size_t from, size_t to, size_t size)
{
    void **held = array, *wider = rsv_alloc(context, to, size);
    if (!wider) return RSV_ERROR_MEMORY;
    if (*held && from) memcpy(wider, *held, from * size);
    rsv_free(context, *held);
    *held = wider;
    return RSV_OK;
}

rsv_status rsv_relighter_make_room(rsv_relighter *r, size_t sources)
{
    rsv_light_basis *b = r->basis;
    rsv_light_settings *settings[] = { &r->home, &r->now, &r->wanted };
    rsv_status status = RSV_OK;
    if (sources <= r->capacity) return RSV_OK;
    size_t count = b->source_count, to = sources + sources / 2;
    size_t from = r->capacity ? count : 0; // only the basis has sources at first
    RSV_TRY(widen(r->context, &b->source, count, to, sizeof *b->source));
    RSV_TRY(widen(r->context, &b->part, count, to, sizeof *b->part));
    RSV_TRY(widen(r->context, &b->scale, count, to, sizeof *b->scale));
    RSV_TRY(widen(r->context, &b->strength, count, to, sizeof *b->strength));
    RSV_TRY(widen(r->context, &b->gathered, count, to, sizeof *b->gathered));
    RSV_TRY(widen(r->context, &b->stale, count, to, sizeof *b->stale));
    struct {
        void *array;
        size_t size;
    } list[] = { { &r->place, sizeof *r->place }, { &r->stale, sizeof *r->stale },
        { &r->moved, sizeof *r->moved }, { &r->away, sizeof *r->away },
        { &r->home_part, sizeof *r->home_part }, { &r->began_part, sizeof *r->began_part },
        { &r->summed, sizeof *r->summed }, { &r->factor, sizeof *r->factor },
        { &r->listed, 2 * sizeof *r->listed } };
    for (size_t k = 0; k < sizeof list / sizeof *list; k++)
        RSV_TRY(widen(r->context, list[k].array, from, to, list[k].size));
    for (int k = 0; k < 3; k++) {
        RSV_TRY(widen(r->context, &settings[k]->scale, from, to, sizeof(rsv_rgb)));
        RSV_TRY(widen(r->context, &settings[k]->offset, from, to, sizeof(rsv_vec3)));
        RSV_TRY(widen(r->context, &settings[k]->aim, from, to, sizeof(rsv_vec3)));
    }
    r->capacity = to;
cleanup:
    return status;
}

/// The part of a source that is the only one, and was never scaled, is all there is.
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
    const rsv_light_basis *b = r->basis;
    r->environment_scale = rgb_gray(1);
    for (size_t k = 0; k < b->source_count; k++) {
        r->home.scale[k] = r->now.scale[k] = b->scale[k];
        r->stale[k] = b->stale[k];
        if (b->source[k].kind == RSV_SOURCE_SURROUNDINGS) r->environment_scale = b->scale[k];
    }
    for (size_t m = 0; m < r->scene->material_count; m++)
        r->home.base_color[m] = r->now.base_color[m] = r->scene->material[m].base_color;
    r->home.rotation = r->now.rotation = r->scene->environment.rotation;
    if (rsv_light_basis_is_known(b)) return;
    r->settled = false;
    r->residual = INFINITY;
}

/// The sources at the strengths that they have by themselves, found as rows found them.
static rsv_status find_sources(rsv_relighter *r)
{
    const rsv_light_basis *b = r->basis;
    rsv_status status;
    RSV_TRY(rsv_relighter_set_strengths(r, NULL));
    RSV_TRY(rsv_relighter_find_lights(r));
    RSV_TRY(rsv_lights_gather_sources(r->sources->lights, b->source, b->gathered, b->source_count));
    RSV_TRY(rsv_relighter_set_strengths(r, r->now.scale));
cleanup:
    if (status != RSV_OK) (void)rsv_relighter_set_strengths(r, r->now.scale);
    rsv_world_find_bsdfs(rsv_light_world(r->light));
    return status;
}

static rsv_status allocate(rsv_relighter *r)
{
    size_t materials = r->scene->material_count;
    rsv_light_settings *settings[] = { &r->home, &r->now, &r->wanted };
    for (int k = 0; k < 3; k++)
        if (rsv_light_settings_allocate(r->context, 0, materials, settings[k]) != RSV_OK)
            return RSV_ERROR_MEMORY;
    rsv_status status = rsv_relighter_make_room(r, r->basis->source_count);
    if (status != RSV_OK) return status;
    r->moves = rsv_alloc(r->context, materials, sizeof *r->moves);
    r->next = rsv_alloc(r->context, rsv_relighter_nodes(r), sizeof *r->next);
    r->scratch = rsv_alloc(r->context, rsv_relighter_nodes(r), sizeof *r->scratch);
    return r->moves && r->next && r->scratch ? RSV_OK : RSV_ERROR_MEMORY;
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
    RSV_TRY(rsv_light_require_parts(rsv_light_get_view(light)));
    RSV_TRY(begin(light, &r));
    RSV_TRY(find_basis(r));
    RSV_TRY(fill_single_part(r));
    RSV_TRY(allocate(r));
    note_settings(r);
    RSV_TRY(rsv_light_places_find(r->scene, r->basis->source, r->basis->source_count, r->place));
    RSV_TRY(find_sources(r));
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
    if (r->basis && r->sources && sources)
        memcpy(r->basis->stale, r->stale, sources * sizeof *r->stale);
    if (r->behind) rsv_light_set_basis(r->light, NULL);
    for (size_t k = 0; r->home_part && k < sources; k++)
        rsv_light_part_free(context, &r->home_part[k]);
    for (size_t k = 0; r->began_part && k < sources; k++)
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
    rsv_free(context, (void *)r->summed);
    rsv_free(context, r->factor);
    rsv_free(context, (void *)r->listed);
    rsv_free(context, r->stale);
    rsv_free(context, r->moved);
    rsv_free(context, r->away);
    rsv_free(context, r->home_part);
    rsv_free(context, r->began_part);
    rsv_free(context, r->next);
    rsv_free(context, r->scratch);
    rsv_free(context, r->valid);
    rsv_relight_responses_destroy(r->responses);
    rsv_free(context, r);
}
