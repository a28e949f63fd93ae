#include "fog_lights.h"

#include "../core/core.h"
#include "local_lights.h"

/// Of choices made evenly: the strongest light may be hidden.
#define EVEN_SHARE 0.1f

static const rsv_vec3 everywhere = { 0, 0, 0 };

// ---- by power -----------------------------------------------------------------------------------

static double power_of(const rsv_fog_lights *l, uint32_t entry)
{
    const rsv_punctual_light *light = rsv_fog_light_punctual(l, entry);
    if (light) return rsv_punctual_flux(l->lights->scene, light);
    return rsv_emitter_power(&l->lights->emitter[l->lights->sampled[entry]]);
}

static rsv_status fill_table(rsv_fog_lights *l)
{
    double sum = 0, *power = rsv_alloc(l->context, l->count, sizeof *power);
    if (!power) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < l->count; k++)
        sum += power[k] = power_of(l, k);
    for (uint32_t k = 0; k < l->count; k++)
        l->probability[k] = sum > 0 ? (float)(power[k] / sum) : 1 / (float)l->count;
    rsv_status status = rsv_alias_table_fill(l->context, power, l->count, l->table);
    rsv_free(l->context, power);
    return status;
}

rsv_status rsv_fog_lights_create(rsv_context *context, const rsv_lights *lights, rsv_fog_lights *l)
{
    *l = (rsv_fog_lights){ .context = context, .lights = lights };
    l->emitters = (uint32_t)lights->sampled_count;
    l->count = l->emitters + (uint32_t)(lights->punctual_count - lights->distant_count);
    l->table = rsv_alloc(context, l->count, sizeof *l->table);
    l->probability = rsv_alloc(context, l->count, sizeof *l->probability);
    l->entry = rsv_alloc(context, lights->emitter_count, sizeof *l->entry);
    if (!l->table || !l->probability || !l->entry) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < lights->emitter_count; k++)
        l->entry[k] = RSV_NONE;
    for (uint32_t k = 0; k < l->emitters; k++)
        l->entry[lights->sampled[k]] = k;
    return l->count ? fill_table(l) : RSV_OK;
}

void rsv_fog_lights_destroy(rsv_fog_lights *l)
{
    if (!l->context) return;
    rsv_free(l->context, l->table);
    rsv_free(l->context, l->probability);
    rsv_free(l->context, l->entry);
}

const rsv_punctual_light *rsv_fog_light_punctual(const rsv_fog_lights *l, uint32_t entry)
{
    const rsv_lights *lights = l->lights;
    if (entry < l->emitters) return NULL;
    return &lights->scene->light[lights->punctual[lights->distant_count + entry - l->emitters]];
}

// ---- at a point ---------------------------------------------------------------------------------

/// Estimate of the fluence from an emitter: its radiance times its solid angle as seen from far away, at most a
/// hemisphere. Above 0 wherever it contributes.
static float guess_emitter(const rsv_emitter *emitter, rsv_vec3 point)
{
    if (!rsv_emitter_faces(emitter, point)) return 0;
    rsv_vec3 corners = v3_add(v3_add(emitter->corner[0], emitter->corner[1]), emitter->corner[2]);
    float distance = v3_length(v3_sub(v3_scale(corners, 1.0f / 3), point));
    float height = fabsf(v3_dot(emitter->normal, v3_sub(point, emitter->corner[0])));
    float solid_angle = emitter->area * height / f_max(distance * distance * distance, 1e-30f);
    return rgb_luminance(emitter->radiance) / (1 / f_max(solid_angle, 1e-20f) + 0.5f / RSV_PI);
}

static float guess_punctual(
    const rsv_scene_view *scene, const rsv_punctual_light *light, rsv_vec3 point)
{
    rsv_punctual_sample sample;
    rsv_vec3 towards = v3_sub(light->position, point);
    // all of a light that has a size may shine here, though its middle does not
    if (rsv_punctual_is_extended(light))
        return rgb_luminance(light->intensity) / f_max(v3_dot(towards, towards), 1e-4f);
    if (!rsv_punctual_arriving(scene, light, rsv_punctual_place_by(light, 0, 0), point, &sample))
        return 0;
    return f_min(rgb_luminance(sample.irradiance), 1e30f);
}

static float guess_tree(const rsv_light_tree *tree, rsv_vec3 point)
{
    return tree ? rsv_light_importance(&tree->node[0].bounds, point, everywhere) : 0;
}

/// Probabilities in proportion to the estimates, with a part divided equally among all that contribute.
static void normalize(rsv_fog_choice *choice)
{
    float sum = 0;
    uint32_t lit = 0;
    for (uint32_t k = 0; k < choice->count; k++) {
        sum += choice->probability[k];
        lit += choice->probability[k] > 0;
    }
    for (uint32_t k = 0; k < choice->count; k++) {
        if (!(choice->probability[k] > 0)) continue;
        float share = f_min(choice->probability[k] / sum, 1);
        choice->probability[k] = (1 - EVEN_SHARE) * share + EVEN_SHARE / (float)lit;
    }
}

static void guess_emitters(const rsv_fog_lights *l, rsv_vec3 point, rsv_fog_choice *choice)
{
    const rsv_lights *lights = l->lights;
    uint32_t weighed = (uint32_t)lights->weighed_count;
    choice->lights = l;
    choice->point = point;
    for (uint32_t k = 0; k < weighed; k++)
        choice->probability[k] = guess_emitter(&lights->emitter[lights->sampled[k]], point);
    choice->probability[weighed] = guess_tree(lights->emitter_tree, point);
    choice->count = weighed + 1;
}

void rsv_fog_emitters_at(const rsv_fog_lights *l, rsv_vec3 point, rsv_fog_choice *choice)
{
    guess_emitters(l, point, choice);
    normalize(choice);
}

void rsv_fog_lights_at(const rsv_fog_lights *l, rsv_vec3 point, rsv_fog_choice *choice)
{
    const rsv_lights *lights = l->lights;
    guess_emitters(l, point, choice);
    if (lights->punctual_tree)
        choice->probability[choice->count++] = guess_tree(lights->punctual_tree, point);
    for (uint32_t k = l->emitters; !lights->punctual_tree && k < l->count; k++)
        choice->probability[choice->count++] =
            guess_punctual(lights->scene, rsv_fog_light_punctual(l, k), point);
    normalize(choice);
}

/// A light of a tree whose first entry is `first`.
static uint32_t draw_of_tree(
    const rsv_light_tree *tree, rsv_vec3 point, uint32_t first, float u, float *probability)
{
    uint32_t light;
    float drawn = rsv_light_tree_sample(tree, point, everywhere, f_min(u, 0x1.fffffep-1f), &light);
    *probability *= drawn;
    return drawn > 0 ? first + light : RSV_NONE;
}

uint32_t rsv_fog_choice_draw(const rsv_fog_choice *choice, float u, float *probability)
{
    const rsv_lights *lights = choice->lights->lights;
    uint32_t weighed = (uint32_t)lights->weighed_count, k = RSV_NONE;
    float left = u;
    for (uint32_t i = 0; i < choice->count && left >= 0; i++) {
        if (!(choice->probability[i] > 0)) continue;
        k = i;
        left -= choice->probability[i];
    }
    if (k == RSV_NONE) return RSV_NONE;
    *probability = choice->probability[k];
    if (k < weighed) return k;
    float place = f_max(left / *probability + 1, 0); // within the choice
    if (k == weighed)
        return draw_of_tree(lights->emitter_tree, choice->point, weighed, place, probability);
    if (!lights->punctual_tree) return choice->lights->emitters + k - weighed - 1;
    return draw_of_tree(
        lights->punctual_tree, choice->point, choice->lights->emitters, place, probability);
}

float rsv_fog_choice_probability(const rsv_fog_choice *choice, uint32_t entry)
{
    const rsv_lights *lights = choice->lights->lights;
    uint32_t weighed = (uint32_t)lights->weighed_count, emitters = choice->lights->emitters;
    if (entry < weighed) return choice->probability[entry];
    if (entry < emitters)
        return choice->probability[weighed] * rsv_light_tree_probability(lights->emitter_tree,
                                                  choice->point, everywhere, entry - weighed);
    if (!lights->punctual_tree) return choice->probability[weighed + 1 + entry - emitters];
    return choice->probability[weighed + 1] * rsv_light_tree_probability(lights->punctual_tree,
                                                  choice->point, everywhere, entry - emitters);
}

bool rsv_fog_sample_emitter(
    const rsv_fog_choice *choice, uint32_t entry, float u1, float u2, rsv_light_sample *sample)
{
    const rsv_lights *lights = choice->lights->lights;
    const rsv_local_lights local = { .lights = lights, .point = choice->point };
    if (!rsv_sample_emitter(&local, entry, 1, u1, u2, sample) || !(sample->pdf_solid_angle > 0))
        return false;
    if (lights->emitter[sample->emitter].varies)
        sample->radiance =
            rsv_emitter_radiance(lights, sample->emitter, sample->back, sample->u, sample->v);
    return isfinite(sample->pdf_solid_angle);
}

float rsv_fog_emitter_pdf(
    const rsv_fog_choice *choice, uint32_t emitter, rsv_vec3 direction, float distance)
{
    uint32_t entry = choice->lights->entry[emitter];
    rsv_triangle_view view;
    if (entry == RSV_NONE ||
        !rsv_view_emitter(&choice->lights->lights->emitter[emitter], choice->point, &view))
        return 0;
    return rsv_fog_choice_probability(choice, entry) *
           (float)rsv_triangle_pdf(&view, direction, distance);
}
