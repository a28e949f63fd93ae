/// Relighting: scene and E0 scaled light by light, then solved again on the same operator.
#include "resolvent/relight.h"

#include "../scene/scene_internal.h"
#include "solution.h"

#include <stdio.h>
#include <string.h>

#define LARGEST_SCALE 1e6f

typedef struct relighting {
    rsv_solution *s;
    rsv_scene *scene;
    const rsv_light_basis *basis;
    rsv_rgb *scale;   ///< [source_count]
    rsv_rgb gathered; ///< of the lamps that gather rays find
    bool turned;      ///< the surroundings: what was sampled of them is of no use
} relighting;

// ---- what is asked for ----------------------------------------------------------------------------

static rsv_status fail_unknown_light(const relighting *r, const char *name)
{
    char known[512] = "";
    for (size_t k = 0; k < r->basis->source_count; k++) {
        size_t used = strlen(known);
        snprintf(
            known + used, sizeof known - used, "%s'%s'", k ? ", " : "", r->basis->source[k].name);
    }
    return rsv_fail(RSV_ERROR_ARGUMENT, "relight: there is no light '%s'; there are: %s", name,
        *known ? known : "none");
}

static bool is_scale(float value) { return value >= 0 && value <= LARGEST_SCALE; }

static rsv_status find_scales(relighting *r, const rsv_relight_desc *desc)
{
    const rsv_light_basis *b = r->basis;
    for (size_t k = 0; k < b->source_count; k++)
        r->scale[k] = rgb_gray(1);
    for (size_t i = 0; i < desc->light_count; i++) {
        const rsv_light_scale *light = &desc->light[i];
        bool known = false,
             gray = light->scale.r == light->scale.g && light->scale.g == light->scale.b;
        if (!is_scale(light->scale.r) || !is_scale(light->scale.g) || !is_scale(light->scale.b))
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "relight: the factors of light '%s' must be from 0 to %g", light->name,
                LARGEST_SCALE);
        for (size_t k = 0; k < b->source_count; k++) {
            if (strcmp(b->source[k].name, light->name) != 0) continue;
            if (b->source[k].kind == RSV_SOURCE_SURROUNDINGS && !gray)
                return rsv_fail(RSV_ERROR_UNSUPPORTED,
                    "relight: the environment takes one factor for all colours");
            r->scale[k] = light->scale;
            known = true;
        }
        if (!known) return fail_unknown_light(r, light->name);
    }
    return RSV_OK;
}

/// Emission that rows gathered is one sum: its sources share a factor.
static rsv_status find_gathered_scale(relighting *r)
{
    const char *first = NULL;
    r->gathered = rgb_gray(1);
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_source *source = &r->basis->source[k];
        if (source->kind != RSV_SOURCE_MATERIAL || !rsv_is_gathered(r->s->lights, source->index))
            continue;
        rsv_rgb own = r->scale[k], other = r->gathered;
        if (first && (own.r != other.r || own.g != other.g || own.b != other.b))
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "relight: lamps '%s' and '%s' fill much of the view and are stored together; scale "
                "both alike or solve anew",
                first, source->name);
        first = source->name;
        r->gathered = own;
    }
    return RSV_OK;
}

static rsv_status find_material(const rsv_scene *scene, const char *name, uint32_t *material)
{
    char known[512] = "";
    for (*material = 0; *material < scene->material_count; ++*material) {
        size_t used = strlen(known);
        if (strcmp(scene->material[*material].name, name) == 0) return RSV_OK;
        snprintf(known + used, sizeof known - used, "%s'%s'", *material ? ", " : "",
            scene->material[*material].name);
    }
    return rsv_fail(
        RSV_ERROR_ARGUMENT, "relight: there is no material '%s'; there are: %s", name, known);
}

static bool is_share(float value) { return value >= 0 && value <= 1; }

static rsv_status check_albedo(const rsv_scene *scene, const rsv_albedo_change *change)
{
    uint32_t m;
    rsv_rgb c = change->base_color;
    rsv_status status = find_material(scene, change->material, &m);
    if (status != RSV_OK) return status;
    const rsv_material *material = &scene->material[m];
    if (!is_share(c.r) || !is_share(c.g) || !is_share(c.b))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "relight: the colour of material '%s' must be in 0 .. 1", change->material);
    bool plain = material->metallic == 0 && material->transmission == 0 && material->opacity == 1 &&
                 material->diffuse_transmission == 0 && !scene->material_varies[m] &&
                 !rsv_material_scatters_below(material);
    return plain
               ? RSV_OK
               : rsv_fail(RSV_ERROR_UNSUPPORTED,
                     "relight: the colour of material '%s' is part of the operator (metal, glass, "
                     "texture, ...); solve anew",
                     change->material);
}

static rsv_status check_turn(const rsv_scene *scene, const rsv_relight_desc *desc)
{
    if (!desc->turn) return RSV_OK;
    if (!scene->environment.pixels)
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: there are no surroundings to turn");
    return isfinite(desc->rotation)
               ? RSV_OK
               : rsv_fail(RSV_ERROR_ARGUMENT, "relight: the rotation must be finite");
}

// ---- the scene ------------------------------------------------------------------------------------

static rsv_status scale_surroundings(rsv_scene *scene, float scale)
{
    if (scale == 1) return RSV_OK;
    if (scale == 0) return rsv_scene_set_environment(scene, NULL);
    rsv_rgb *pixel = (rsv_rgb *)scene->environment.pixels;
    for (size_t k = 0; k < (size_t)scene->environment.width * scene->environment.height; k++)
        pixel[k] = rgb_scale(pixel[k], scale);
    return RSV_OK;
}

static rsv_status change_scene(relighting *r, const rsv_relight_desc *desc)
{
    rsv_status status = RSV_OK;
    if (desc->turn) r->scene->environment.rotation = desc->rotation;
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_source *source = &r->basis->source[k];
        rsv_rgb *strength =
            source->kind == RSV_SOURCE_MATERIAL ? &r->scene->material[source->index].emission
            : source->kind == RSV_SOURCE_LIGHT  ? &r->scene->light[source->index].intensity
                                                : NULL;
        if (strength)
            *strength = rgb_mul(*strength, r->scale[k]);
        else
            RSV_TRY(scale_surroundings(r->scene, r->scale[k].r));
    }
    for (size_t i = 0; i < desc->albedo_count; i++) {
        uint32_t m;
        RSV_TRY(find_material(r->scene, desc->albedo[i].material, &m));
        r->scene->material[m].base_color = desc->albedo[i].base_color;
    }
cleanup:
    return status;
}

// ---- E0 -------------------------------------------------------------------------------------------

static rsv_rgb part_scale(const relighting *r, size_t source)
{
    bool surroundings = r->basis->source[source].kind == RSV_SOURCE_SURROUNDINGS;
    return r->turned && surroundings ? rgb_gray(0) : r->scale[source];
}

/// A field of the new E0: the parts times their factors.
static void combine(const relighting *r, size_t field, rsv_rgb *sum)
{
    const rsv_light_basis *b = r->basis;
    size_t length = rsv_light_field_length(r->s, field);
    if (b->source_count == 1) {
        for (size_t n = 0; n < length; n++)
            sum[n] = rgb_mul(part_scale(r, 0), sum[n]);
        return;
    }
    for (size_t n = 0; n < length; n++) {
        sum[n] = rgb_gray(0);
        for (size_t k = 0; k < b->source_count; k++)
            sum[n] = rgb_add(
                sum[n], rgb_mul(part_scale(r, k), (*rsv_light_part_field(&b->part[k], field))[n]));
    }
}

/// Replaces everything of E0 but for what rows gathered; the coarse whole comes first, as it is found by difference.
static rsv_status scale_sources(relighting *r)
{
    rsv_solution *s = r->s;
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++) {
        size_t length = rsv_light_field_length(s, field);
        if (!length) continue;
        rsv_rgb *sum = rsv_alloc(s->context, length, sizeof *sum);
        if (!sum) return RSV_ERROR_MEMORY;
        rsv_light_total(s, field, sum);
        combine(r, field, sum);
        memcpy(rsv_light_field(s, field), sum, length * sizeof *sum);
        rsv_free(s->context, sum);
    }
    return RSV_OK;
}

/// Adds what next-event estimates and photons find of the surroundings as they stand now.
static rsv_status sample_surroundings(relighting *r)
{
    rsv_solution *s = r->s;
    rsv_status status;
    rsv_source *source = NULL;
    rsv_light_part part = { 0 };
    size_t count, k = 0;
    RSV_TRY(rsv_list_sources(s->lights, &source, &count));
    while (k < count && source[k].kind != RSV_SOURCE_SURROUNDINGS)
        k++;
    if (k == count) goto cleanup; // switched off
    RSV_TRY(rsv_light_part_estimate(s, &source[k], &part));
    for (size_t field = 0; field < RSV_LIGHT_FIELDS; field++) {
        rsv_rgb *whole = rsv_light_field(s, field), *found = *rsv_light_part_field(&part, field);
        for (size_t n = 0; n < rsv_light_field_length(s, field); n++)
            whole[n] = rgb_add(whole[n], found[n]);
    }
cleanup:
    rsv_light_part_free(s->context, &part);
    rsv_free(s->context, source);
    return status;
}

/// What rows gathered, from the emission and the bins as they are now; and all of E0 on the coarse elements.
static void gather_sources(relighting *r)
{
    rsv_solution *s = r->s;
    rsv_transport_environment(s->transport, s->bin_radiance, s->gathered);
    for (size_t n = 0; n < s->elements->node_count; n++) {
        rsv_rgb *emitted = &s->transport->gathered[n];
        *emitted = rgb_mul(*emitted, r->gathered);
        s->gathered[n] = rgb_add(s->gathered[n], *emitted);
        s->source[n] = rgb_add(s->source[n], s->gathered[n]);
        if (s->caustics.coarse_caustic)
            s->source[n] = rgb_add(s->source[n], s->caustics.coarse_caustic[n]);
    }
    rsv_elements_constrain(s->elements, s->gathered);
    rsv_elements_constrain(s->elements, s->source);
}

/// K's colours at the elements of changed materials.
static void change_albedos(relighting *r, const rsv_relight_desc *desc)
{
    rsv_solution *s = r->s;
    for (size_t i = 0; i < desc->albedo_count; i++)
        for (size_t n = 0; n < s->elements->node_count; n++) {
            uint32_t triangle = s->elements->face_triangle[s->elements->node_face[n]];
            uint32_t m = s->scene.view->triangle_material[triangle];
            if (strcmp(s->scene.view->material[m].name, desc->albedo[i].material) == 0)
                s->exitance_albedo[n] = s->bsdf[m].exitance_albedo;
        }
}

rsv_status rsv_solution_relight(rsv_solution *s, rsv_scene *scene, const rsv_relight_desc *desc)
{
    rsv_status status = RSV_OK;
    relighting r = { .s = s, .scene = scene };
    if (rsv_solution_scene(s) != scene)
        return rsv_fail(RSV_ERROR_ARGUMENT, "relight: the scene is not the solution's");
    if (!s->basis) RSV_TRY(rsv_light_basis_create(s, &s->basis));
    r.basis = s->basis;
    if (r.basis->source_count > RSV_MAX_LIGHT_PARTS)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "relight: the scene has %zu lights; at most %d are kept apart", r.basis->source_count,
            RSV_MAX_LIGHT_PARTS);
    r.scale = rsv_alloc(s->context, r.basis->source_count, sizeof *r.scale);
    if (!r.scale) return RSV_ERROR_MEMORY;
    RSV_TRY(find_scales(&r, desc));
    RSV_TRY(find_gathered_scale(&r));
    for (size_t i = 0; i < desc->albedo_count; i++)
        RSV_TRY(check_albedo(scene, &desc->albedo[i]));
    RSV_TRY(check_turn(scene, desc));
    r.turned = desc->turn;
    RSV_TRY(scale_sources(&r));
    RSV_TRY(change_scene(&r, desc));
    RSV_TRY(rsv_solution_refresh(s));
    if (r.turned) RSV_TRY(sample_surroundings(&r));
    gather_sources(&r);
    change_albedos(&r, desc);
    RSV_TRY(rsv_solution_solve_again(s));
    // scaled once, its parts are no longer those of the solution
    rsv_light_basis_destroy(s->basis);
    s->basis = NULL;
cleanup:
    rsv_free(s->context, r.scale);
    return status;
}
