/// Photons that leave (photon_origin.h).
#ifndef RSV_PHOTON_ORIGIN_BODY_H
#define RSV_PHOTON_ORIGIN_BODY_H

#include "../sources/punctual_light.h"
#include "photon_origin.h"

RSV_INLINE rsv_photon_emission rsv_emit_from_group(
    const rsv_photon_origins *o, uint32_t group, float x, float y, rsv_random *random)
{
    const rsv_emitter_group *g = &o->lights->group[group];
    uint32_t index = g->first + rsv_alias_table_draw(o->emitter_table + g->first, g->count,
                                    rsv_random_float(random));
    const rsv_emitter *e = &o->lights->emitter[index];
    float u, v, y_on_triangle = rsv_random_float(random), x_on_triangle = rsv_random_float(random);
    rsv_square_to_triangle(x_on_triangle, y_on_triangle, &u, &v);
    bool back = e->double_sided && (rsv_random_bits(random) & 1u);
    rsv_vec3 normal = back ? v3_neg(e->normal) : e->normal;
    rsv_vec3 point = v3_barycentric(e->corner[0], e->corner[1], e->corner[2], u, v);
    rsv_photon_emission out;
    out.medium = NULL;
    out.origin = rsv_moved_off(point, normal, rsv_extent_of(o->scene->view, e->triangle));
    out.direction = v3_turned_to(normal, rsv_square_to_cosine_hemisphere(x, y));
    double probability = rsv_emitter_power(e) / g->power;
    out.flux = rgb_scale(rsv_emitter_radiance(o->lights, index, back, u, v),
        (float)(M_PI * e->area * (e->double_sided ? 2 : 1) / probability));
    return out;
}

/// Parallel light that fills the scene's bounding sphere.
RSV_INLINE rsv_photon_emission rsv_emit_from_afar(
    const rsv_photon_origins *o, rsv_vec3 travels, rsv_rgb irradiance, float x, float y)
{
    float dx, dy;
    rsv_square_to_disk(x, y, &dx, &dy);
    rsv_vec3 offset = v3_turned_to(travels, v3(dx * o->radius, dy * o->radius, -2 * o->radius));
    rsv_photon_emission out;
    out.origin = v3_add(o->centre, offset);
    out.direction = travels;
    out.flux = rgb_scale(irradiance, RSV_PI * o->radius * o->radius);
    out.medium = NULL;
    return out;
}

RSV_INLINE rsv_photon_emission rsv_emit_from_sun(
    const rsv_photon_origins *o, uint32_t index, float x, float y, rsv_random *random)
{
    const rsv_sun *sun = &o->lights->environment->sun[index];
    float u = rsv_random_float(random);
    rsv_vec3 towards = rsv_sun_sample(sun, u, rsv_random_float(random));
    return rsv_emit_from_afar(o, v3_neg(towards), rgb_scale(sun->radiance, sun->solid_angle), x, y);
}

RSV_INLINE rsv_photon_emission rsv_emit_from_light(
    const rsv_photon_origins *o, uint32_t light_index, float x, float y, rsv_random *random)
{
    const rsv_punctual_light *light = &o->scene->view->light[light_index];
    rsv_photon_emission out;
    rsv_vec3 place = light->position;
    if (light->kind == RSV_PUNCTUAL_LUMINAIRE) {
        float u[3] = { 0.5f, 0.5f, 0.5f };
        for (int k = 0; k < 3 && rsv_punctual_is_extended(light); k++)
            u[k] = rsv_random_float(random);
        place = rsv_punctual_place(light, u);
    }
    out.origin = place;
    out.flux = rgb_gray(0);
    out.medium = NULL;
    if (rsv_punctual_is_distant(light))
        return rsv_emit_from_afar(o, light->direction, light->intensity, x, y);
    float solid_angle = 4 * RSV_PI;
    if (!rsv_punctual_has_cone(light)) {
        out.direction = rsv_square_to_sphere(x, y);
    } else {
        float cos_outer = cosf(light->outer_cone_angle);
        float cos = 1 - x * (1 - cos_outer), sin = sqrtf(f_max(0, 1 - cos * cos));
        float phi = 2 * RSV_PI * y;
        out.direction = v3_turned_to(light->direction, v3(sin * cosf(phi), sin * sinf(phi), cos));
        solid_angle = 2 * RSV_PI * (1 - cos_outer);
    }
    rsv_punctual_sample metre_away;
    if (rsv_punctual_arriving(
            o->scene->view, light, place, v3_add(place, out.direction), &metre_away))
        out.flux = rgb_scale(metre_away.irradiance, solid_angle);
    return out;
}

RSV_SHARED rsv_photon_emission rsv_photon_emit(const rsv_photon_origins *o, uint32_t first,
    uint32_t count, float x, float y, rsv_random *random)
{
    uint32_t drawn = 0;
    if (count > 1)
        drawn = rsv_alias_table_draw(o->origin_table + first, count, rsv_random_float(random));
    const rsv_photon_origin *origin = &o->origin[first + drawn];
    rsv_photon_emission out =
        origin->kind == RSV_ORIGIN_GROUP ? rsv_emit_from_group(o, origin->index, x, y, random)
        : origin->kind == RSV_ORIGIN_SUN ? rsv_emit_from_sun(o, origin->index, x, y, random)
                                         : rsv_emit_from_light(o, origin->index, x, y, random);
    out.medium = &origin->medium;
    out.flux = rgb_scale(out.flux, 1 / origin->probability);
    return out;
}

#endif
