/// E0 as a sum over its sources, each part times its factor or sampled again where its source stands elsewhere.
#include "../solve/source.h"
#include "../trace/tracer_update.h"
#include "relight_responses.h"

#include <math.h>
#include <string.h>

/// Photons of a source on the move, as a share of all.
#define ROUGH_PHOTON_SHARE 16
/// A glance, and more rays in penumbrae alone.
#define ROUGH_SAMPLES 4

static rsv_light_settings_home home_of(const rsv_relighter *r)
{
    return (rsv_light_settings_home){ r->scene, r->lights, r->basis->source, r->basis->source_count,
        &r->home };
}

rsv_rgb *rsv_source_strength(rsv_scene *scene, const rsv_source *source)
{
    switch (source->kind) {
    case RSV_SOURCE_MATERIAL:
        return &scene->material[source->index].emission;
    case RSV_SOURCE_LIGHT:
        return &scene->light[source->index].intensity;
    default:
        return NULL;
    }
}

size_t rsv_surroundings_length(const rsv_scene *scene)
{
    return (size_t)scene->environment.width * scene->environment.height;
}

// ---- the scene ------------------------------------------------------------------------------------

static bool same_color(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/// @param scale [source_count] NULL = the strengths that the sources began with
static void set_strengths(rsv_relighter *r, const rsv_rgb *scale)
{
    for (size_t k = 0; k < r->basis->source_count; k++) {
        rsv_rgb factor = scale ? scale[k] : rgb_gray(1);
        rsv_rgb *strength = rsv_source_strength(r->scene, &r->basis->source[k]);
        if (strength) {
            *strength = rgb_mul(r->strength[k], factor);
            continue;
        }
        rsv_rgb *pixel = (rsv_rgb *)r->scene->environment.pixels;
        if (same_color(factor, r->environment_scale)) continue;
        r->environment_scale = factor;
        for (size_t p = 0; p < rsv_surroundings_length(r->scene); p++)
            pixel[p] = rgb_mul(r->environment[p], factor);
    }
}

static bool same_place(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// Marks sources that are to stand elsewhere, and puts them there. @param body out: whether triangles moved
static bool move_sources(rsv_relighter *r, bool *body)
{
    bool any = false;
    *body = false;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_source *source = &r->basis->source[k];
        bool turned =
            source->kind == RSV_SOURCE_SURROUNDINGS && r->wanted.rotation != r->now.rotation;
        bool moved = !same_place(r->wanted.offset[k], r->now.offset[k]);
        if (moved) rsv_light_place_move(r->scene, source, &r->place[k], r->wanted.offset[k]);
        *body = *body || (moved && r->place[k].vertex_count > 0);
        r->moved[k] = moved || turned;
        r->stale[k] = r->stale[k] || r->moved[k];
        any = any || r->moved[k];
    }
    r->scene->environment.rotation = r->wanted.rotation;
    return any;
}

/// Gives a material another colour, and so K at its elements.
static void set_color(rsv_relighter *r, uint32_t material, rsv_rgb color)
{
    rsv_solution *s = r->s;
    r->scene->material[material].base_color = color;
    rsv_rgb albedo = rsv_surface_common_bsdf(s->scene.view, material).base_color;
    for (size_t n = 0; n < rsv_relighter_nodes(r); n++) {
        uint32_t triangle = s->elements->face_triangle[s->elements->node_face[n]];
        if (s->scene.view->triangle_material[triangle] == material) s->exitance_albedo[n] = albedo;
    }
}

static void set_colors(rsv_relighter *r)
{
    for (uint32_t m = 0; m < r->scene->material_count; m++)
        if (!same_color(r->now.base_color[m], r->wanted.base_color[m]))
            set_color(r, m, r->wanted.base_color[m]);
}

// ---- E0 -------------------------------------------------------------------------------------------

rsv_status rsv_relighter_find_lights(rsv_relighter *r)
{
    rsv_solution *s = r->s;
    rsv_lights *found = NULL;
    rsv_status status;
    rsv_solution_find_bsdfs(s);
    RSV_TRY(rsv_lights_create(r->scene, s->bsdf, &found));
    RSV_TRY(rsv_lights_gather_like(found, r->lights ? r->lights : s->lights));
    if (found->environment) RSV_TRY(rsv_environment_light_divide(found->environment));
    rsv_lights_destroy(r->lights);
    r->lights = found;
    found = NULL;
cleanup:
    rsv_lights_destroy(found);
    return status;
}

rsv_status rsv_relighter_sample(rsv_relighter *r, const bool *which, rsv_relighter_change_kind kind,
    const rsv_light_effort *effort)
{
    rsv_status status = RSV_OK;
    set_strengths(r, NULL);
    if (kind == RSV_RELIGHTER_PLACES)
        RSV_TRY(rsv_lights_follow(r->lights));
    else
        RSV_TRY(rsv_relighter_find_lights(r));
    for (size_t k = 0; k < r->basis->source_count; k++)
        if (which[k])
            RSV_TRY(rsv_light_part_estimate(
                r->s, r->lights, &r->basis->source[k], effort, &r->basis->part[k], &r->rays));
cleanup:
    return status;
}

/// A field of the new E0: the parts times their factors.
static void combine(const rsv_relighter *r, size_t field)
{
    const rsv_light_basis *b = r->basis;
    size_t length = rsv_light_field_length(r->s, field);
    rsv_rgb *sum = rsv_light_field(r->s, field);
    const rsv_rgb *part[RSV_MAX_LIGHT_PARTS];
    for (size_t k = 0; k < b->source_count; k++)
        part[k] = *rsv_light_part_field(&b->part[k], field);
#pragma omp parallel for schedule(static) num_threads(rsv_threads(r->context))
    for (size_t n = 0; n < length; n++) {
        rsv_rgb total = rgb_gray(0);
        for (size_t k = 0; k < b->source_count; k++)
            total = rgb_add(total, rgb_mul(r->now.scale[k], part[k][n]));
        sum[n] = total;
    }
}

/// What rows gathered, from the emission and the bins as they are now; and all of E0 on the coarse elements.
static void gather_sources(rsv_relighter *r, rsv_rgb scale)
{
    rsv_solution *s = r->s;
    size_t nodes = rsv_relighter_nodes(r);
#pragma omp parallel for schedule(static) num_threads(rsv_threads(r->context))
    for (size_t n = 0; n < nodes; n++)
        s->transport->gathered[n] = rgb_mul(r->gathered[n], scale);
    rsv_source_add_gathered(s);
}

rsv_status rsv_relighter_update_sources(rsv_relighter *r, rsv_relighter_change_kind kind)
{
    rsv_status status;
    rsv_rgb gathered;
    rsv_light_settings_home home = home_of(r);
    rsv_rgb environment_scale = r->environment_scale;
    bool followed = false;
    set_strengths(r, r->now.scale);
    if (kind == RSV_RELIGHTER_PLACES)
        RSV_TRY(rsv_lights_follow(r->s->lights));
    else if (kind == RSV_RELIGHTER_STRENGTHS && same_color(environment_scale, r->environment_scale))
        RSV_TRY(rsv_solution_follow_strengths(r->s, &followed));
    if (kind != RSV_RELIGHTER_PLACES && !followed) RSV_TRY(rsv_solution_refresh(r->s, r->lights));
    RSV_TRY(rsv_gathered_scale(&home, &r->now, &gathered));
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        combine(r, field);
    gather_sources(r, gathered);
cleanup:
    return status;
}

rsv_status rsv_relighter_see_sky(rsv_relighter *r, rsv_rgb *sky)
{
    memset(sky, 0, rsv_relighter_nodes(r) * sizeof *sky);
    if (!r->environment) return RSV_OK;
    set_strengths(r, NULL);
    rsv_status status = rsv_solution_refresh(r->s, r->lights);
    if (status == RSV_OK) rsv_transport_environment(r->s->transport, r->s->bin_radiance, sky);
    set_strengths(r, r->now.scale);
    return status == RSV_OK ? rsv_solution_refresh(r->s, r->lights) : status;
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
    const rsv_solution *s = r->s;
    rsv_status status = RSV_OK;
    if (!r->coarse)
        RSV_TRY(rsv_receiver_blocks_create(&s->scene, s->elements, RSV_SUPPORT_POINTS, s->desc.seed,
            s->valid_points, r->moves, &r->coarse));
    if (!r->fine && s->fine.elements)
        RSV_TRY(rsv_receiver_blocks_create(&s->scene, s->fine.elements, RSV_LEVEL_POINTS,
            rsv_level_seed(s), r->valid, r->moves, &r->fine));
cleanup:
    return status;
}

static rsv_status check_added(const rsv_relighter *r, const rsv_light *light)
{
    const rsv_light_basis *b = r->basis;
    for (size_t k = 0; k < b->source_count; k++)
        if (light->name && strcmp(b->source[k].name, light->name) == 0)
            return rsv_fail(
                RSV_ERROR_ARGUMENT, "relight: there is a light '%s' already", light->name);
    if (b->source_count == RSV_MAX_LIGHT_PARTS)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "relight: at most %d lights are kept apart",
            RSV_MAX_LIGHT_PARTS);
    return RSV_OK;
}

/// What every source does by itself, where that is wanted; steps will do where it cannot be had.
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

rsv_status rsv_relighter_add_light(rsv_relighter *r, const rsv_light *light)
{
    rsv_light_basis *b = r->basis;
    size_t k = b->source_count;
    rsv_light_effort rough = rough_effort(r);
    rsv_status status = check_added(r, light);
    if (status == RSV_OK) status = rsv_scene_append_light(r->scene, light);
    if (status != RSV_OK) return status;
    uint32_t index = (uint32_t)r->scene->light_count - 1;
    const rsv_light *added = &r->scene->light[index];
    b->source[k] = (rsv_source){ RSV_SOURCE_LIGHT, index, added->name };
    r->strength[k] = added->intensity;
    r->place[k].centre = added->position;
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

/// What changes between two settings.
static rsv_relighter_change_kind kind_of_change(
    const rsv_relighter *r, const rsv_light_settings *from, const rsv_light_settings *to)
{
    bool strengths = true, places = true, others = from->rotation == to->rotation;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        strengths = strengths && same_color(from->scale[k], to->scale[k]);
        places = places && same_place(from->offset[k], to->offset[k]);
    }
    for (size_t m = 0; m < r->scene->material_count; m++)
        others = others && same_color(from->base_color[m], to->base_color[m]);
    if (others && strengths) return RSV_RELIGHTER_PLACES;
    return others && places ? RSV_RELIGHTER_STRENGTHS : RSV_RELIGHTER_ANYTHING;
}

rsv_status rsv_relighter_change(rsv_relighter *r, const rsv_relight_desc *desc)
{
    rsv_light_settings_home home = home_of(r);
    rsv_status status = rsv_light_settings_read(&home, desc, &r->wanted);
    if (status != RSV_OK) return status;
    rsv_relighter_change_kind kind =
        r->behind ? RSV_RELIGHTER_ANYTHING : kind_of_change(r, &r->now, &r->wanted);
    r->behind = true;
    bool body, moved = move_sources(r, &body);
    set_colors(r);
    rsv_light_settings before = r->now;
    r->now = r->wanted;
    r->wanted = before;
    r->settled = false;
    r->residual = INFINITY;
    if (kind != RSV_RELIGHTER_STRENGTHS) rsv_relight_responses_forget(r);
    if (body) {
        rsv_scene_update_bounds(r->scene);
        RSV_TRY(rsv_tracer_set_apart(r->s->tracer, r->moves));
        RSV_TRY(rsv_tracer_update(r->s->tracer));
    }
    if (moved) {
        RSV_TRY(keep_receivers(r));
        rsv_light_effort rough = rough_effort(r);
        RSV_TRY(rsv_relighter_sample(r, r->moved, kind, &rough));
    }
    if (kind == RSV_RELIGHTER_STRENGTHS)
        RSV_TRY(follow_strengths(r));
    else
        RSV_TRY(rsv_relighter_update_sources(r, kind));
    r->behind = false;
cleanup:
    return status;
}
