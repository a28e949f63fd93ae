/// Relighting: E0 as a sum over its sources, each part times its factor or sampled again where its source stands
/// elsewhere, and then solved on the same operator.
#include "resolvent/relight.h"

#include "../scene/scene_internal.h"
#include "../trace/tracer_update.h"
#include "light_places.h"
#include "light_settings.h"
#include "sharpen.h"
#include "solution.h"
#include "transport_map.h"

#include <math.h>
#include <string.h>

/// Largest change of the last order, relative to the largest E0, that nobody sees.
#define CONVERGED 1e-3
/// Photons of a source on the move, as a share of all.
#define ROUGH_PHOTON_SHARE 16
/// A glance, and more rays in penumbrae alone.
#define ROUGH_SAMPLES 4

struct rsv_relighter {
    rsv_context *context;
    rsv_solution *s;
    rsv_scene *scene;
    rsv_light_basis *basis; ///< parts of E0 at the strengths that the sources began with
    rsv_lights *lights;     ///< at those strengths, where they stand now
    uint16_t *valid;        ///< receiver points of the direct level
    rsv_rgb *gathered;      ///< [node_count] emission that rows found, at those strengths
    rsv_rgb *environment;   ///< pixels at those strengths; NULL = no surroundings
    rsv_rgb *strength;      ///< [source_count]
    rsv_light_place *place; ///< [source_count]
    rsv_light_settings home, now, wanted;
    bool *stale; ///< [source_count] to be sampled in full before the light has settled
    rsv_transport_map *map;
    rsv_rgb *next, *scratch; ///< [node_count]
    double residual;
    bool settled;
};

static size_t node_count(const rsv_relighter *r) { return r->s->elements->node_count; }

static rsv_light_settings_home home_of(const rsv_relighter *r)
{
    return (rsv_light_settings_home){ r->scene, r->lights, r->basis->source, r->basis->source_count,
        &r->home };
}

// ---- how things began -----------------------------------------------------------------------------

/// Takes over the solution's basis: once anything is scaled, its parts are no longer those of the solution.
static rsv_status take_basis(rsv_relighter *r)
{
    rsv_solution *s = r->s;
    if (!s->basis) {
        rsv_status status = rsv_light_basis_create(s, &s->basis);
        if (status != RSV_OK) return status;
    }
    r->basis = s->basis;
    s->basis = NULL;
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
    rsv_source *source = rsv_alloc(r->context, RSV_MAX_LIGHT_PARTS, sizeof *source);
    rsv_light_part *part = rsv_alloc(r->context, RSV_MAX_LIGHT_PARTS, sizeof *part);
    if (!source || !part) {
        rsv_free(r->context, source);
        rsv_free(r->context, part);
        return RSV_ERROR_MEMORY;
    }
    memcpy(source, b->source, b->source_count * sizeof *source);
    memcpy(part, b->part, b->source_count * sizeof *part);
    rsv_free(r->context, b->source);
    rsv_free(r->context, b->part);
    b->source = source;
    b->part = part;
    return RSV_OK;
}

/// The part of a source that is the only one is all there is.
static rsv_status fill_single_part(rsv_relighter *r)
{
    for (size_t field = 0; field < RSV_LIGHT_FIELDS && r->basis->source_count == 1; field++) {
        size_t length = rsv_light_field_length(r->s, field);
        rsv_rgb **part = rsv_light_part_field(&r->basis->part[0], field);
        if (!length || *part) continue;
        *part = rsv_alloc(r->context, length, sizeof **part);
        if (!*part) return RSV_ERROR_MEMORY;
        rsv_light_total(r->s, field, *part);
    }
    return RSV_OK;
}

static rsv_rgb *strength_of(rsv_scene *scene, const rsv_source *source)
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

static size_t environment_length(const rsv_scene *scene)
{
    return (size_t)scene->environment.width * scene->environment.height;
}

static void note_settings(rsv_relighter *r)
{
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_rgb *strength = strength_of(r->scene, &r->basis->source[k]);
        r->strength[k] = strength ? *strength : rgb_gray(1);
        r->home.scale[k] = r->now.scale[k] = rgb_gray(1);
    }
    for (size_t m = 0; m < r->scene->material_count; m++)
        r->home.base_color[m] = r->now.base_color[m] = r->scene->material[m].base_color;
    r->home.rotation = r->now.rotation = r->scene->environment.rotation;
    memcpy(r->gathered, r->s->transport->gathered, node_count(r) * sizeof *r->gathered);
    if (r->environment)
        memcpy(r->environment, r->scene->environment.pixels,
            environment_length(r->scene) * sizeof *r->environment);
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
    r->stale = rsv_alloc(r->context, sources, sizeof *r->stale);
    r->gathered = rsv_alloc(r->context, node_count(r), sizeof *r->gathered);
    r->next = rsv_alloc(r->context, node_count(r), sizeof *r->next);
    r->scratch = rsv_alloc(r->context, node_count(r), sizeof *r->scratch);
    bool surrounded = r->scene->environment.pixels != NULL;
    if (surrounded)
        r->environment =
            rsv_alloc(r->context, environment_length(r->scene), sizeof *r->environment);
    return r->strength && r->place && r->stale && r->gathered && r->next && r->scratch &&
                   (r->environment || !surrounded)
               ? RSV_OK
               : RSV_ERROR_MEMORY;
}

/// The lights of the scene as it stands, divided between rays that gather and rays that aim as the operator has it.
static rsv_status find_lights(rsv_relighter *r)
{
    rsv_solution *s = r->s;
    rsv_lights *found = NULL;
    rsv_status status;
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        s->bsdf[m] = rsv_surface_common_bsdf(s->scene.view, (uint32_t)m);
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

rsv_status rsv_relighter_create(rsv_solution *s, rsv_scene *scene, rsv_relighter **relighter)
{
    rsv_status status;
    if (rsv_solution_scene(s) != scene)
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: the scene is not the solution's");
    rsv_relighter *r = rsv_alloc(s->context, 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    *r = (rsv_relighter){ .context = s->context, .s = s, .scene = scene, .settled = true };
    RSV_TRY(take_basis(r));
    RSV_TRY(make_room(r));
    RSV_TRY(fill_single_part(r));
    RSV_TRY(allocate(r));
    note_settings(r);
    RSV_TRY(rsv_light_places_find(scene, r->basis->source, r->basis->source_count, r->place));
    RSV_TRY(find_lights(r));
    RSV_TRY(rsv_find_fine_valid(s, &r->valid));
    RSV_TRY(rsv_transport_map_create(
        s->elements, s->transport, s->subsurface, s->exitance_albedo, 1, &r->map));
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
    rsv_transport_map_destroy(r->map);
    rsv_light_places_free(context, r->place, sources);
    rsv_light_settings_free(context, &r->home);
    rsv_light_settings_free(context, &r->now);
    rsv_light_settings_free(context, &r->wanted);
    rsv_lights_destroy(r->lights);
    rsv_free(context, r->place);
    rsv_free(context, r->strength);
    rsv_free(context, r->stale);
    rsv_free(context, r->gathered);
    rsv_free(context, r->environment);
    rsv_free(context, r->next);
    rsv_free(context, r->scratch);
    rsv_free(context, r->valid);
    rsv_light_basis_destroy(r->basis);
    rsv_free(context, r);
}

// ---- the scene ------------------------------------------------------------------------------------

/// @param scale [source_count] NULL = the strengths that the sources began with
static void set_strengths(rsv_relighter *r, const rsv_rgb *scale)
{
    for (size_t k = 0; k < r->basis->source_count; k++) {
        rsv_rgb factor = scale ? scale[k] : rgb_gray(1);
        rsv_rgb *strength = strength_of(r->scene, &r->basis->source[k]);
        if (strength) {
            *strength = rgb_mul(r->strength[k], factor);
            continue;
        }
        rsv_rgb *pixel = (rsv_rgb *)r->scene->environment.pixels;
        for (size_t p = 0; p < environment_length(r->scene); p++)
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
        r->stale[k] = r->stale[k] || moved || turned;
        any = any || moved || turned;
    }
    r->scene->environment.rotation = r->wanted.rotation;
    return any;
}

/// Gives a material another colour, and so K at its elements.
static void set_color(rsv_relighter *r, uint32_t material, rsv_rgb color)
{
    rsv_solution *s = r->s;
    r->scene->material[material].base_color = color;
    rsv_rgb albedo = rsv_surface_common_bsdf(s->scene.view, material).exitance_albedo;
    for (size_t n = 0; n < node_count(r); n++) {
        uint32_t triangle = s->elements->face_triangle[s->elements->node_face[n]];
        if (s->scene.view->triangle_material[triangle] == material) s->exitance_albedo[n] = albedo;
    }
}

static bool same_color(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

static void set_colors(rsv_relighter *r)
{
    for (uint32_t m = 0; m < r->scene->material_count; m++)
        if (!same_color(r->now.base_color[m], r->wanted.base_color[m]))
            set_color(r, m, r->wanted.base_color[m]);
}

// ---- E0 -------------------------------------------------------------------------------------------

/// Samples the sources that are marked, at the strengths that they began with.
static rsv_status sample_stale(rsv_relighter *r, const rsv_light_effort *effort)
{
    rsv_status status = RSV_OK;
    set_strengths(r, NULL);
    RSV_TRY(find_lights(r));
    for (size_t k = 0; k < r->basis->source_count; k++)
        if (r->stale[k])
            RSV_TRY(rsv_light_part_estimate(
                r->s, r->lights, &r->basis->source[k], effort, &r->basis->part[k]));
cleanup:
    return status;
}

/// A field of the new E0: the parts times their factors.
static void combine(const rsv_relighter *r, size_t field)
{
    const rsv_light_basis *b = r->basis;
    size_t length = rsv_light_field_length(r->s, field);
    rsv_rgb *sum = rsv_light_field(r->s, field);
    for (size_t n = 0; n < length; n++) {
        rsv_rgb total = rgb_gray(0);
        for (size_t k = 0; k < b->source_count; k++)
            total = rgb_add(
                total, rgb_mul(r->now.scale[k], (*rsv_light_part_field(&b->part[k], field))[n]));
        sum[n] = total;
    }
}

/// What rows gathered, from the emission and the bins as they are now; and all of E0 on the coarse elements.
static void gather_sources(rsv_relighter *r, rsv_rgb scale)
{
    rsv_solution *s = r->s;
    rsv_transport_environment(s->transport, s->bin_radiance, s->gathered);
    for (size_t n = 0; n < node_count(r); n++) {
        s->transport->gathered[n] = rgb_mul(r->gathered[n], scale);
        s->gathered[n] = rgb_add(s->gathered[n], s->transport->gathered[n]);
        s->source[n] = rgb_add(s->source[n], s->gathered[n]);
        if (s->caustics.coarse_caustic)
            s->source[n] = rgb_add(s->source[n], s->caustics.coarse_caustic[n]);
    }
    rsv_elements_constrain(s->elements, s->gathered);
    rsv_elements_constrain(s->elements, s->source);
}

/// Brings scene, lights and E0 to the present settings, after parts have changed.
static rsv_status update_sources(rsv_relighter *r)
{
    rsv_status status;
    rsv_rgb gathered;
    rsv_light_settings_home home = home_of(r);
    set_strengths(r, r->now.scale);
    RSV_TRY(rsv_solution_refresh(r->s, r->lights));
    RSV_TRY(rsv_gathered_scale(&home, &r->now, &gathered));
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++)
        combine(r, field);
    gather_sources(r, gathered);
cleanup:
    return status;
}

/// Few rays, for a light that will soon be elsewhere.
static rsv_light_effort rough_effort(const rsv_relighter *r)
{
    return (rsv_light_effort){ .coarse_samples = ROUGH_SAMPLES,
        .fine_samples = ROUGH_SAMPLES,
        .photons = r->s->desc.photon_count / ROUGH_PHOTON_SHARE,
        .valid = r->valid };
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
    r->stale[k] = true;
    b->source_count++;
    r->settled = false;
    r->residual = INFINITY;
    status = sample_stale(r, &rough);
    return status == RSV_OK ? update_sources(r) : status;
}

rsv_status rsv_relighter_change(rsv_relighter *r, const rsv_relight_desc *desc)
{
    rsv_light_settings_home home = home_of(r);
    rsv_status status = rsv_light_settings_read(&home, desc, &r->wanted);
    if (status != RSV_OK) return status;
    rsv_light_effort rough = rough_effort(r);
    bool body, moved = move_sources(r, &body);
    set_colors(r);
    rsv_light_settings before = r->now;
    r->now = r->wanted;
    r->wanted = before;
    r->settled = false;
    r->residual = INFINITY;
    if (body) {
        rsv_scene_update_bounds(r->scene);
        RSV_TRY(rsv_tracer_update(r->s->tracer));
    }
    if (moved) RSV_TRY(sample_stale(r, &rough));
    RSV_TRY(update_sources(r));
cleanup:
    return status;
}

// ---- E --------------------------------------------------------------------------------------------

static double largest(const rsv_rgb *field, size_t count)
{
    float most = 0;
    for (size_t n = 0; n < count; n++)
        most = f_max(most, rgb_max(field[n]));
    return (double)most;
}

/// E = E0 + G K E once, from the E of the last time.
static void apply_once(rsv_relighter *r, double size)
{
    rsv_solution *s = r->s;
    const rsv_linear_map *map = &r->map->linear;
    float change = 0;
    map->table->apply(map->data, 3, &s->irradiance->r, &r->next->r);
    for (size_t n = 0; n < node_count(r); n++)
        r->next[n] = rgb_add(s->source[n], r->next[n]);
    rsv_elements_constrain(s->elements, r->next);
    for (size_t n = 0; n < node_count(r); n++) {
        rsv_rgb step = rgb_sub(r->next[n], s->irradiance[n]);
        change = f_max(change, f_max(fabsf(step.r), f_max(fabsf(step.g), fabsf(step.b))));
    }
    memcpy(s->irradiance, r->next, node_count(r) * sizeof *r->next);
    r->residual = size > 0 ? (double)change / size : 0;
}

/// What cameras look up: all but E0, sharpened.
static void show(rsv_relighter *r)
{
    rsv_solution *s = r->s;
    for (size_t n = 0; n < node_count(r); n++) {
        rsv_rgb rest = rgb_sub(s->irradiance[n], s->source[n]);
        s->indirect[n] = rgb(f_max(rest.r, 0), f_max(rest.g, 0), f_max(rest.b, 0));
    }
    rsv_sharpen(s->elements, s->indirect, r->next, r->scratch);
}

rsv_status rsv_relighter_step(rsv_relighter *r, double milliseconds, rsv_relight_progress *progress)
{
    double end = rsv_seconds() + 1e-3 * milliseconds;
    double size = largest(r->s->source, node_count(r));
    uint32_t orders = 0;
    if (!(milliseconds >= 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: a step needs a time of 0 ms or more");
    while (!r->settled && r->residual > CONVERGED && (orders == 0 || rsv_seconds() < end)) {
        apply_once(r, size);
        orders++;
    }
    if (orders) show(r);
    if (progress)
        *progress = (rsv_relight_progress){ orders, r->settled ? 0 : r->residual,
            r->settled || r->residual <= CONVERGED };
    return RSV_OK;
}

rsv_status rsv_relighter_settle(rsv_relighter *r)
{
    rsv_status status = RSV_OK;
    bool any = false;
    if (r->settled) return RSV_OK;
    rsv_light_effort effort = rsv_full_light_effort(r->s, r->valid);
    for (size_t k = 0; k < r->basis->source_count; k++)
        any = any || r->stale[k];
    if (any) {
        RSV_TRY(sample_stale(r, &effort));
        RSV_TRY(update_sources(r));
        memset(r->stale, 0, r->basis->source_count * sizeof *r->stale);
    }
    RSV_TRY(rsv_solution_solve_again(r->s));
    r->settled = true;
cleanup:
    return status;
}

bool rsv_relighter_is_settled(const rsv_relighter *r) { return r->settled; }

// ---- what there is ----------------------------------------------------------------------------------

size_t rsv_relighter_source_count(const rsv_relighter *r) { return r->basis->source_count; }

rsv_relight_source rsv_relighter_source(const rsv_relighter *r, size_t k)
{
    const rsv_source *source = &r->basis->source[k];
    bool distant = source->kind == RSV_SOURCE_SURROUNDINGS ||
                   (source->kind == RSV_SOURCE_LIGHT &&
                       r->scene->light[source->index].kind == RSV_LIGHT_DIRECTIONAL);
    bool stored = source->kind == RSV_SOURCE_MATERIAL && rsv_is_gathered(r->lights, source->index);
    return (rsv_relight_source){ .name = source->name,
        .strength = r->strength[k],
        .scale = r->now.scale[k],
        .position = v3_add(r->place[k].centre, r->now.offset[k]),
        .movable = !distant && !stored };
}

rsv_status rsv_solution_relight(rsv_solution *s, rsv_scene *scene, const rsv_relight_desc *desc)
{
    rsv_relighter *r = NULL;
    rsv_status status = rsv_relighter_create(s, scene, &r);
    if (status == RSV_OK) status = rsv_relighter_change(r, desc);
    if (status == RSV_OK) status = rsv_relighter_settle(r);
    rsv_relighter_destroy(r);
    return status;
}
