/// E0 as a sum over its sources, each part times its factor or sampled again where its source stands elsewhere.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../scene/variant.h"
#include "relight_responses.h"

#include <math.h>
#include <string.h>

/// Photons of a source on the move, as a share of all.
#define ROUGH_PHOTON_SHARE 16
/// A preview, with more rays only in penumbrae.
#define ROUGH_SAMPLES 4

static rsv_light_settings_home home_of(const rsv_relighter *r)
{
    return (rsv_light_settings_home){ r->scene, r->sources->lights, r->basis->source,
        r->basis->source_count, &r->home };
}

size_t rsv_surroundings_length(const rsv_scene *scene)
{
    return (size_t)scene->environment.width * scene->environment.height;
}

// ---- the scene ------------------------------------------------------------------------------------

static bool same_color(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/// Keeps the pixels of surroundings before they are scaled for the first time.
static rsv_status keep_environment(rsv_relighter *r)
{
    size_t count = rsv_surroundings_length(r->scene);
    rsv_rgb **kept = &r->basis->environment;
    if (*kept) return RSV_OK;
    *kept = rsv_alloc(r->context, count, sizeof **kept);
    if (!*kept) return RSV_ERROR_MEMORY;
    memcpy(*kept, r->scene->environment.pixels, count * sizeof **kept);
    return RSV_OK;
}

static rsv_status scale_environment(rsv_relighter *r, rsv_rgb factor)
{
    rsv_status status = RSV_OK;
    if (same_color(factor, r->environment_scale)) return RSV_OK;
    RSV_TRY(keep_environment(r));
    RSV_TRY(rsv_scene_vary_environment(r->scene));
    rsv_rgb *pixel = (rsv_rgb *)(uintptr_t)r->scene->environment.pixels;
    for (size_t p = 0; p < rsv_surroundings_length(r->scene); p++)
        pixel[p] = rgb_mul(r->basis->environment[p], factor);
    r->environment_scale = factor;
cleanup:
    return status;
}

static void set_strength(rsv_scene *scene, const rsv_source *source, rsv_rgb strength)
{
    if (source->kind == RSV_SOURCE_MATERIAL)
        scene->material[source->index].emission = strength;
    else
        scene->light[source->index].intensity = strength;
}

rsv_status rsv_relighter_set_strengths(rsv_relighter *r, const rsv_rgb *scale)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < r->basis->source_count && status == RSV_OK; k++) {
        const rsv_source *source = &r->basis->source[k];
        rsv_rgb factor = scale ? scale[k] : rgb_gray(1);
        if (source->kind == RSV_SOURCE_SURROUNDINGS)
            status = scale_environment(r, factor);
        else
            set_strength(r->scene, source, rgb_mul(r->basis->strength[k], factor));
    }
    return status;
}

static bool same_place(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool is_moved(const rsv_relighter *r, size_t k)
{
    return !same_place(r->wanted.offset[k], r->now.offset[k]) ||
           !same_place(r->wanted.aim[k], r->now.aim[k]);
}

/// Whether triangles are to stand elsewhere.
static bool any_body_moves(const rsv_relighter *r)
{
    bool any = false;
    for (size_t k = 0; k < r->basis->source_count; k++)
        any = any || (is_moved(r, k) && r->place[k].vertex_count > 0);
    return any;
}

/// Whether a source will not be at its original position.
static bool will_be_away(const rsv_relighter *r, size_t k)
{
    return !same_place(r->wanted.offset[k], r->home.offset[k]) ||
           !same_place(r->wanted.aim[k], r->home.aim[k]) ||
           (r->basis->source[k].kind == RSV_SOURCE_SURROUNDINGS &&
               r->wanted.rotation != r->home.rotation);
}

/// Stores a source's contribution at its original position, or restores it. @return whether it was restored
static bool leave_or_return(rsv_relighter *r, size_t k)
{
    rsv_light_part *part = &r->basis->part[k];
    bool away = will_be_away(r, k);
    if (away == r->away[k] || (away && r->stale[k])) return false;
    rsv_light_part_free(r->context, away ? &r->home_part[k] : part);
    *(away ? &r->home_part[k] : part) = *(away ? part : &r->home_part[k]);
    *(away ? part : &r->home_part[k]) = (rsv_light_part){ 0 };
    r->away[k] = away;
    return !away;
}

/// Marks sources that are to stand elsewhere, and puts them there. @param returned out: whether any stands where it
/// began again, where its part is known @return whether there are others
static bool move_sources(rsv_relighter *r, bool *returned)
{
    bool any = false;
    *returned = false;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_source *source = &r->basis->source[k];
        bool turned =
            source->kind == RSV_SOURCE_SURROUNDINGS && r->wanted.rotation != r->now.rotation;
        bool moved = is_moved(r, k), known = leave_or_return(r, k);
        if (moved)
            rsv_light_place_move(
                r->scene, source, &r->place[k], r->wanted.offset[k], r->wanted.aim[k]);
        r->moved[k] = (moved || turned) && !known;
        r->stale[k] = !known && (r->stale[k] || r->moved[k]);
        any = any || r->moved[k];
        *returned = *returned || known;
    }
    r->scene->environment.rotation = r->wanted.rotation;
    return any;
}

/// Gives materials their colours. @param changed [material_count] those that get others @return whether there are any
static bool put_colors(rsv_relighter *r, const rsv_light_settings *settings, bool *changed)
{
    bool any = false;
    for (uint32_t m = 0; m < r->scene->material_count; m++) {
        changed[m] = !same_color(r->scene->material[m].base_color, settings->base_color[m]);
        r->scene->material[m].base_color = settings->base_color[m];
        any = any || changed[m];
    }
    return any;
}

/// Gives materials their colours, and so K at its elements; as they were where light would never die out in them.
static rsv_status set_colors(rsv_relighter *r)
{
    bool *changed = rsv_alloc(r->context, r->scene->material_count, sizeof *changed);
    rsv_status status = changed ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK && put_colors(r, &r->wanted, changed)) {
        status = rsv_light_recolor(r->light, changed);
        if (status != RSV_OK) put_colors(r, &r->now, changed);
        if (status != RSV_OK) rsv_world_find_bsdfs(rsv_light_world(r->light));
        if (status == RSV_OK) status = rsv_relighter_map(r);
    }
    rsv_free(r->context, changed);
    return status;
}

// ---- E0 -------------------------------------------------------------------------------------------

rsv_status rsv_relighter_find_lights(rsv_relighter *r)
{
    rsv_light_sources *found = NULL;
    rsv_world *world = rsv_light_world(r->light);
    rsv_world_find_bsdfs(world);
    rsv_status status =
        rsv_light_sources_create(world, r->sources ? r->sources->lights : r->s->lights, &found);
    if (status != RSV_OK) return status;
    rsv_light_sources_release(r->sources);
    r->sources = found;
    return RSV_OK;
}

/// Takes over where sources stand, at the strengths that they have by themselves.
static rsv_status follow_lights(rsv_relighter *r, rsv_relighter_change_kind kind)
{
    rsv_status status = rsv_relighter_set_strengths(r, NULL);
    if (status != RSV_OK) return status;
    return kind == RSV_RELIGHTER_PLACES ? rsv_lights_follow(r->sources->lights)
                                        : rsv_relighter_find_lights(r);
}

rsv_status rsv_relighter_sample(rsv_relighter *r, const bool *which, rsv_relighter_change_kind kind,
    const rsv_light_effort *effort)
{
    rsv_status status = RSV_OK;
    RSV_TRY(follow_lights(r, kind));
    for (size_t k = 0; k < r->basis->source_count; k++)
        if (which[k])
            RSV_TRY(rsv_light_part_estimate(r->light, r->sources->lights, &r->basis->source[k],
                effort, &r->basis->part[k], &r->rays));
cleanup:
    return status;
}

typedef struct combine_job {
    const rsv_relighter *relighter;
    rsv_rgb *sum;
} combine_job;

static void weigh_parts(void *data, rsv_span span)
{
    const combine_job *job = data;
    const rsv_relighter *r = job->relighter;
    size_t count = r->basis->source_count;
    const rsv_rgb *scale = r->now.scale, *const *part = r->summed;
    for (size_t n = span.begin; n < span.end; n++) {
        rsv_rgb total = rgb_gray(0);
        for (size_t k = 0; k < count; k++)
            total = rgb_add(total, rgb_mul(scale[k], part[k][n]));
        job->sum[n] = total;
    }
}

/// A field of the new E0: the parts times their factors.
static void combine(const rsv_relighter *r, size_t field)
{
    const rsv_light_basis *b = r->basis;
    size_t length = rsv_light_field_length(r->light, field);
    combine_job job = { r, rsv_light_field(r->light, field) };
    for (size_t k = 0; k < b->source_count; k++)
        r->summed[k] = *rsv_light_part_field(&b->part[k], field);
    rsv_parallel_for(r->context, length, 0, weigh_parts, &job);
}

rsv_status rsv_relighter_update_sources(rsv_relighter *r, rsv_relighter_change_kind kind)
{
    rsv_status status;
    rsv_rgb gathered;
    rsv_light_settings_home home = home_of(r);
    rsv_rgb environment_scale = r->environment_scale;
    bool followed = false;
    RSV_TRY(rsv_relighter_set_strengths(r, r->now.scale));
    if (kind == RSV_RELIGHTER_PLACES)
        RSV_TRY(rsv_light_follow_places(r->light));
    else if (kind == RSV_RELIGHTER_STRENGTHS && same_color(environment_scale, r->environment_scale))
        RSV_TRY(rsv_light_follow_strengths(r->light, &followed));
    if (kind != RSV_RELIGHTER_PLACES && !followed) {
        RSV_TRY(rsv_light_find_sources(r->light, r->sources->lights));
        rsv_lights_warn_if_dark(rsv_light_get_view(r->light)->lights);
    }
    RSV_TRY(rsv_gathered_scale(&home, &r->now, &gathered));
    memcpy(r->basis->scale, r->now.scale, r->basis->source_count * sizeof *r->now.scale);
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        combine(r, field);
    rsv_light_gather(r->light, rgb_mul(r->basis->gathered_scale, gathered));
cleanup:
    return status;
}

void rsv_relighter_see_sky(const rsv_relighter *r, rsv_rgb *sky)
{
    memset(sky, 0, rsv_relighter_nodes(r) * sizeof *sky);
    if (r->scene->environment.pixels)
        rsv_transport_environment(r->s->transport, r->sources->bin_radiance, sky);
}

// ---- changes --------------------------------------------------------------------------------------

/// Few rays, for a light that will soon be elsewhere.
static rsv_light_effort rough_effort(const rsv_relighter *r)
{
    return (rsv_light_effort){ .coarse_samples = ROUGH_SAMPLES,
        .fine_samples = ROUGH_SAMPLES,
        .photons = r->s->desc.photon_count / ROUGH_PHOTON_SHARE,
        .valid = r->valid,
        .coarse = r->coarse,
        .fine = r->fine };
}

/// Receivers are kept from the first move on.
static rsv_status keep_receivers(rsv_relighter *r)
{
    const rsv_light_view *s = r->s;
    rsv_status status = RSV_OK;
    if (!r->coarse)
        RSV_TRY(rsv_receiver_blocks_create(&s->scene, s->elements,
            (rsv_support_draw){ RSV_SUPPORT_POINTS, s->desc.seed }, s->valid_points, r->moves,
            &r->coarse));
    if (!r->fine && s->fine.elements)
        RSV_TRY(rsv_receiver_blocks_create(&s->scene, s->fine.elements,
            (rsv_support_draw){ RSV_LEVEL_POINTS, rsv_level_seed(s->desc.seed) }, r->valid,
            r->moves, &r->fine));
cleanup:
    return status;
}

static rsv_status check_added(const rsv_relighter *r, const rsv_punctual_light *light)
{
    const rsv_light_basis *b = r->basis;
    for (size_t k = 0; k < b->source_count; k++)
        if (light->name && strcmp(b->source[k].name, light->name) == 0)
            return rsv_fail(RSV_ERROR_ARGUMENT, "relight: light '%s' already exists", light->name);
    return RSV_OK;
}

/// Finds the contribution of every source, if requested. If that is not possible, steps are used.
static rsv_status find_responses(rsv_relighter *r)
{
    if (r->responses || !r->prepared || rsv_relighter_any_stale(r)) return RSV_OK;
    rsv_status status = rsv_relight_responses_create(r, &r->responses);
    r->prepared = r->responses != NULL;
    return status;
}

/// Irradiance at the strengths as they are now.
static rsv_status follow_strengths(rsv_relighter *r)
{
    rsv_status status;
    RSV_TRY(find_responses(r));
    RSV_TRY(rsv_relighter_update_sources(r, RSV_RELIGHTER_STRENGTHS));
    if (!r->responses) return RSV_OK;
    rsv_relight_responses_combine(r->responses, r);
    r->residual = 0;
cleanup:
    return status;
}

rsv_status rsv_relighter_prepare(rsv_relighter *r)
{
    r->prepared = true;
    rsv_status status = keep_receivers(r);
    return status == RSV_OK ? find_responses(r) : status;
}

rsv_status rsv_relighter_add_light(rsv_relighter *r, const rsv_punctual_light *light)
{
    rsv_light_basis *b = r->basis;
    size_t k = b->source_count;
    rsv_light_effort rough = rough_effort(r);
    rsv_status status = check_added(r, light);
    if (status == RSV_OK) status = rsv_relighter_make_room(r, k + 1);
    if (status == RSV_OK) status = rsv_scene_append_light(r->scene, light);
    if (status != RSV_OK) return status;
    uint32_t index = (uint32_t)r->scene->light_count - 1;
    const rsv_punctual_light *added = &r->scene->light[index];
    b->source[k] = (rsv_source){ RSV_SOURCE_LIGHT, index, added->name, NULL };
    b->scale[k] = rgb_gray(1);
    b->strength[k] = added->intensity;
    b->gathered[k] = false;
    rsv_light_destroy(r->began); // without that light
    r->began = NULL;
    r->grown = true;
    rsv_light_place_note(added, &r->place[k]);
    r->home.scale[k] = r->now.scale[k] = rgb_gray(1);
    memset(r->moved, 0, k * sizeof *r->moved);
    r->stale[k] = r->moved[k] = true;
    b->source_count++;
    r->settled = false;
    r->residual = INFINITY;
    rsv_relight_responses_forget(r);
    status = rsv_relighter_sample(r, r->moved, RSV_RELIGHTER_ANYTHING, &rough);
    return status == RSV_OK ? rsv_relighter_update_sources(r, RSV_RELIGHTER_ANYTHING) : status;
}

/// Kind of change between two settings.
static rsv_relighter_change_kind kind_of_change(
    const rsv_relighter *r, const rsv_light_settings *from, const rsv_light_settings *to)
{
    bool strengths = true, places = true, others = from->rotation == to->rotation;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        strengths = strengths && same_color(from->scale[k], to->scale[k]);
        places = places && same_place(from->offset[k], to->offset[k]) &&
                 same_place(from->aim[k], to->aim[k]);
    }
    for (size_t m = 0; m < r->scene->material_count; m++)
        others = others && same_color(from->base_color[m], to->base_color[m]);
    if (others && strengths) return RSV_RELIGHTER_PLACES;
    return others && places ? RSV_RELIGHTER_STRENGTHS : RSV_RELIGHTER_ANYTHING;
}

/// Stores the original light, so that it can be restored.
static rsv_status keep_beginning(rsv_relighter *r)
{
    rsv_status status;
    if (r->began || r->once || r->grown || r->refined) return RSV_OK;
    RSV_TRY(rsv_light_begin_like(r->light, rsv_light_get_sources(r->light), &r->began));
    RSV_TRY(rsv_light_assign(r->began, r->light));
cleanup:
    return status;
}

static bool is_as_it_began(const rsv_relighter *r)
{
    bool same = r->now.rotation == r->home.rotation;
    for (size_t k = 0; k < r->basis->source_count; k++)
        same = same && same_color(r->now.scale[k], r->home.scale[k]) &&
               same_place(r->now.offset[k], r->home.offset[k]) &&
               same_place(r->now.aim[k], r->home.aim[k]);
    for (size_t m = 0; m < r->scene->material_count; m++)
        same = same && same_color(r->now.base_color[m], r->home.base_color[m]);
    return same;
}

/// The light as it began, once sources and colours are.
static rsv_status go_back(rsv_relighter *r)
{
    rsv_status status;
    RSV_TRY(rsv_light_assign(r->light, r->began));
    if (r->refined) {
        rsv_relighter_return_levels(r);
        RSV_TRY(rsv_find_fine_valid(r->light, &r->valid));
    }
    RSV_TRY(rsv_relighter_map(r));
    r->settled = true;
    r->residual = 0;
cleanup:
    return status;
}

/// Sources as they stand now, after some were moved. @param moved, returned of move_sources
static rsv_status follow_moves(
    rsv_relighter *r, bool moved, bool returned, rsv_relighter_change_kind kind)
{
    rsv_status status = RSV_OK;
    if (returned && !moved) RSV_TRY(follow_lights(r, kind));
    if (!moved) return RSV_OK;
    RSV_TRY(keep_receivers(r));
    rsv_light_effort rough = rough_effort(r);
    RSV_TRY(rsv_relighter_sample(r, r->moved, kind, &rough));
cleanup:
    return status;
}

/// Makes the requested settings the present ones.
static void take_settings(rsv_relighter *r)
{
    rsv_light_settings before = r->now;
    r->now = r->wanted;
    r->wanted = before;
    r->settled = false;
    r->residual = INFINITY;
}

/// Applies the requested settings to the light, except colours, which have been applied.
static rsv_status follow_settings(rsv_relighter *r)
{
    rsv_status status = RSV_OK;
    rsv_relighter_change_kind kind =
        r->behind ? RSV_RELIGHTER_ANYTHING : kind_of_change(r, &r->now, &r->wanted);
    r->behind = true;
    bool body = any_body_moves(r), returned;
    if (body) RSV_TRY(rsv_light_vary_places(r->light, r->moves));
    bool moved = move_sources(r, &returned);
    take_settings(r);
    if (kind != RSV_RELIGHTER_STRENGTHS) rsv_relight_responses_forget(r);
    if (body) RSV_TRY(rsv_world_follow_places(rsv_light_world(r->light)));
    RSV_TRY(follow_moves(r, moved, returned, kind));
    if (kind == RSV_RELIGHTER_STRENGTHS)
        RSV_TRY(follow_strengths(r));
    else
        RSV_TRY(rsv_relighter_update_sources(r, kind));
    if (r->began && !rsv_relighter_any_stale(r) && is_as_it_began(r)) RSV_TRY(go_back(r));
    r->behind = false;
cleanup:
    return status;
}

rsv_status rsv_relighter_change(rsv_relighter *r, const rsv_relight_desc *desc)
{
    rsv_light_settings_home home = home_of(r);
    rsv_relight_desc settings = rsv_default_relight_desc();
    rsv_status status = RSV_READ_DESC(rsv_relight_desc, &settings, desc);
    if (status == RSV_OK) status = rsv_light_settings_read(&home, &settings, &r->wanted);
    if (status == RSV_OK) status = keep_beginning(r);
    if (status == RSV_OK) status = set_colors(r);
    return status == RSV_OK ? follow_settings(r) : status;
}

rsv_status rsv_relighter_scale(rsv_relighter *r, const rsv_rgb *scale)
{
    size_t sources = r->basis->source_count;
    memcpy(r->wanted.scale, scale, sources * sizeof *scale);
    memcpy(r->wanted.offset, r->now.offset, sources * sizeof *r->now.offset);
    memcpy(r->wanted.base_color, r->now.base_color,
        r->scene->material_count * sizeof *r->now.base_color);
    r->wanted.rotation = r->now.rotation;
    rsv_status status = keep_beginning(r);
    return status == RSV_OK ? follow_settings(r) : status;
}
