/// Next-event estimation: the sources as one receiver sees them. For device code too.
#ifndef RSV_LOCAL_LIGHTS_H
#define RSV_LOCAL_LIGHTS_H

#include "lights.h"
#include "spherical_triangle.h"

/// Below this solid angle a triangle is sampled by area: the density then varies little over it,
/// and the spherical triangle would have few digits left.
#define RSV_SOLID_ANGLE_SAMPLING_MIN 1e-4

/// A triangle as seen from a point: input of both sampling and density.
typedef struct rsv_triangle_view {
    rsv_double3 corner[3];   ///< relative to the point
    rsv_double3 area_vector; ///< front normal times area
    rsv_spherical_triangle spherical;
    bool by_area;
} rsv_triangle_view;

/// Half the cross product of the edges in double: the float normal of the emitter tilts its plane
/// by more than a grazing point is above it.
RSV_INLINE rsv_double3 rsv_emitter_area_vector(const rsv_emitter *emitter)
{
    return d3_scale(d3_cross(d3_between(emitter->corner[0], emitter->corner[1]),
                        d3_between(emitter->corner[0], emitter->corner[2])),
        0.5);
}

/// Whether `point` is above a side that emits, by more than the rounding of its coordinates.
RSV_INLINE bool rsv_emitter_faces(const rsv_emitter *emitter, rsv_vec3 point)
{
    rsv_double3 area_vector = rsv_emitter_area_vector(emitter);
    double height = d3_dot(area_vector, d3_between(emitter->corner[0], point));
    if (emitter->double_sided) height = fabs(height);
    return height > rsv_rounding_height(emitter->corner, 3, point) * d3_length(area_vector);
}

RSV_INLINE bool rsv_view_emitter(
    const rsv_emitter *emitter, rsv_vec3 point, rsv_triangle_view *view)
{
    if (!rsv_emitter_faces(emitter, point)) return false;
    view->area_vector = rsv_emitter_area_vector(emitter);
    for (int i = 0; i < 3; i++)
        view->corner[i] = d3_between(point, emitter->corner[i]);
    view->spherical = rsv_spherical_triangle_from(view->corner);
    view->by_area = view->spherical.solid_angle < RSV_SOLID_ANGLE_SAMPLING_MIN;
    return true;
}

/// The same without its solid angle: places are drawn by area.
RSV_INLINE bool rsv_view_far_emitter(
    const rsv_emitter *emitter, rsv_vec3 point, rsv_triangle_view *view)
{
    if (!rsv_emitter_faces(emitter, point)) return false;
    view->area_vector = rsv_emitter_area_vector(emitter);
    for (int i = 0; i < 3; i++)
        view->corner[i] = d3_between(point, emitter->corner[i]);
    view->by_area = true;
    return true;
}

RSV_INLINE float rsv_projected_solid_angle(
    const rsv_emitter *emitter, rsv_vec3 point, rsv_vec3 normal)
{
    if (!rsv_emitter_faces(emitter, point)) return 0;
    return rsv_polygon_irradiance(emitter->corner, 3, point, normal);
}

/// The sky keeps a chance where its table says it cannot be seen: the table interpolates.
#define RSV_LEAST_SKY_SHARE 1e-4f

RSV_INLINE uint32_t rsv_sun_count(const rsv_lights *lights)
{
    return lights->environment ? lights->environment->sun_count : 0;
}

/// Suns and sky come after the emitters.
RSV_INLINE uint32_t rsv_entry_count(const rsv_local_lights *local)
{
    return local->count + rsv_sun_count(local->lights) + 1;
}

/// Unshadowed irradiance of all suns and of the sky; selection in proportion to it.
RSV_INLINE float rsv_weigh_environment(rsv_local_lights *local)
{
    const rsv_environment_light *environment = local->lights->environment;
    float *probability = local->probability + local->count, sum = 0;
    for (uint32_t k = 0; k < rsv_sun_count(local->lights); k++) {
        const rsv_sun *sun = &environment->sun[k];
        float projected = sun->solid_angle * f_max(v3_dot(sun->direction, local->normal), 0);
        local->unshadowed = rgb_mad(local->unshadowed, projected, sun->radiance);
        sum += *probability++ = projected * rgb_luminance(sun->radiance);
    }
    *probability = 0;
    if (!environment || !(environment->sampler.flux > 0)) return sum;
    rsv_rgb open = rsv_sky_irradiance_at(&environment->open, local->normal);
    local->unshadowed = rgb_add(local->unshadowed, open);
    *probability =
        f_max(rgb_luminance(open), RSV_LEAST_SKY_SHARE * (float)environment->sampler.flux);
    return sum + *probability;
}

/// Estimate of the irradiance from an emitter of radiance 1, as if seen from far away. Much faster than the exact
/// value.
RSV_INLINE float rsv_guessed_solid_angle(
    const rsv_emitter *emitter, rsv_vec3 point, rsv_vec3 normal)
{
    float height = v3_dot(emitter->normal, v3_sub(point, emitter->corner[0])), above = 0,
          square = 0; // of the distance; sums over the corners
    if (emitter->double_sided) height = fabsf(height);
    for (int i = 0; i < 3; i++) {
        rsv_vec3 way = v3_sub(emitter->corner[i], point);
        above += f_max(v3_dot(way, normal), 0);
        square += v3_dot(way, way);
    }
    if (!(height > 0) || !(above > 0)) return 0;
    // never more than a hemisphere gives, however near
    float ratio = square / (3 * above) * (square / (emitter->area * height));
    return RSV_PI / (1 + f_max(RSV_PI * ratio, 0));
}

RSV_INLINE float rsv_weigh_emitters(rsv_local_lights *local, bool guess)
{
    const rsv_lights *lights = local->lights;
    local->count = (uint32_t)lights->weighed_count;
    float sum = 0;
    for (uint32_t i = 0; i < local->count; i++) {
        const rsv_emitter *emitter = &lights->emitter[lights->sampled[i]];
        float projected = guess ? rsv_guessed_solid_angle(emitter, local->point, local->normal)
                                : rsv_projected_solid_angle(emitter, local->point, local->normal);
        local->unshadowed = rgb_mad(local->unshadowed, projected, emitter->radiance);
        local->probability[i] = projected * rgb_luminance(emitter->radiance);
        sum += local->probability[i];
    }
    return sum;
}

/// Of lamps and of the sky, and of lamps in the tree and others, at every receiver: the stronger of the two may be
/// hidden from all of a room.
#define RSV_LEAST_SHARE 0.25f

/// Of the first of two.
RSV_INLINE float rsv_weight_share(float first, float second)
{
    if (!(first > 0)) return 0;
    if (!(second > 0)) return 1;
    return f_min(f_max(first / (first + second), RSV_LEAST_SHARE), 1 - RSV_LEAST_SHARE);
}

/// As rsv_lights_at or, as a guess, rsv_lights_about.
RSV_INLINE void rsv_weigh_lights(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, bool guess, rsv_local_lights *local)
{
    local->lights = lights;
    local->point = point;
    local->normal = normal;
    local->count = 0;
    local->unshadowed = rgb_gray(0);
    local->tree_estimate = 0;
    if (lights->emitter_tree)
        local->tree_estimate =
            rsv_light_importance(&lights->emitter_tree->node[0].bounds, point, normal);
    float tree = local->tree_estimate, emitters = rsv_weigh_emitters(local, guess),
          sky = rsv_weigh_environment(local);
    float lamps_share = rsv_weight_share(tree + emitters, sky),
          among = rsv_weight_share(tree, emitters);
    local->tree_share = lamps_share * among;
    for (uint32_t i = 0; i < local->count && emitters > 0; i++)
        local->probability[i] *= lamps_share * (1 - among) / emitters;
    for (uint32_t i = local->count; i < rsv_entry_count(local) && sky > 0; i++)
        local->probability[i] *= (1 - lamps_share) / sky;
}

/// RSV_NONE if no entry has a probability. The last entry with one also gets the rounding error of the sum.
RSV_INLINE uint32_t rsv_select_by_irradiance(const rsv_local_lights *local, float u)
{
    uint32_t selected = RSV_NONE;
    for (uint32_t i = 0; i < rsv_entry_count(local) && u >= 0; i++) {
        if (!(local->probability[i] > 0)) continue;
        selected = i;
        u -= local->probability[i];
    }
    return selected;
}

/// Density per solid angle on a triangle that is already chosen.
RSV_INLINE double rsv_triangle_pdf(
    const rsv_triangle_view *view, rsv_vec3 direction, float distance)
{
    if (!view->by_area) return 1 / view->spherical.solid_angle;
    double projected_area = fabs(d3_dot(view->area_vector, d3_from(direction)));
    return projected_area > 0 ? (double)distance * distance / projected_area : 0;
}

/// The vector from the receiver to a random point of the triangle.
RSV_INLINE rsv_double3 rsv_sample_triangle(const rsv_triangle_view *view, float u1, float u2)
{
    if (!view->by_area) {
        rsv_double3 direction = rsv_spherical_triangle_sample(&view->spherical, u1, u2);
        double distance =
            d3_dot(view->area_vector, view->corner[0]) / d3_dot(view->area_vector, direction);
        return d3_scale(direction, distance);
    }
    float u, v;
    rsv_square_to_triangle(u1, u2, &u, &v);
    rsv_double3 point = d3_scale(view->corner[0], 1.0 - u - v);
    return d3_mad(d3_mad(point, u, view->corner[1]), v, view->corner[2]);
}

/// Notes the emitter's point at `towards` from the receiver, and on which side that is.
RSV_INLINE void rsv_note_place(
    const rsv_triangle_view *view, rsv_double3 towards, rsv_light_sample *sample)
{
    rsv_double3 edge1 = d3_sub(view->corner[1], view->corner[0]);
    rsv_double3 edge2 = d3_sub(view->corner[2], view->corner[0]);
    rsv_double3 place = d3_sub(towards, view->corner[0]);
    double area = 2 * d3_dot(view->area_vector, view->area_vector);
    sample->u = (float)(d3_dot(view->area_vector, d3_cross(place, edge2)) / area);
    sample->v = (float)(d3_dot(view->area_vector, d3_cross(edge1, place)) / area);
    sample->back = d3_dot(view->area_vector, towards) > 0;
}

/// A place on an emitter as it is seen. @param sample out: all but `emitter` and the density
RSV_INLINE void rsv_sample_view(const rsv_emitter *emitter, const rsv_triangle_view *view, float u1,
    float u2, rsv_light_sample *sample)
{
    rsv_double3 towards = rsv_sample_triangle(view, u1, u2);
    double distance = d3_length(towards);
    sample->from_sky = false;
    sample->distance = (float)distance;
    sample->direction = d3_to_float(d3_scale(towards, 1 / distance));
    sample->radiance = sample->mean_radiance = emitter->radiance;
    if (emitter->varies) rsv_note_place(view, towards, sample);
}

/// @param probability of having selected this one
RSV_INLINE bool rsv_sample_emitter(const rsv_local_lights *local, uint32_t entry, float probability,
    float u1, float u2, rsv_light_sample *sample)
{
    rsv_triangle_view view;
    sample->emitter = local->lights->sampled[entry];
    const rsv_emitter *emitter = &local->lights->emitter[sample->emitter];
    if (!rsv_view_emitter(emitter, local->point, &view)) return false;
    rsv_sample_view(emitter, &view, u1, u2, sample);
    sample->pdf_solid_angle =
        (float)(probability * rsv_triangle_pdf(&view, sample->direction, sample->distance));
    return true;
}

/// The same by area, for an emitter that is small compared with its distance; much faster.
RSV_INLINE bool rsv_sample_far_emitter(const rsv_local_lights *local, uint32_t entry,
    float probability, float u1, float u2, rsv_light_sample *sample)
{
    rsv_triangle_view view;
    sample->emitter = local->lights->sampled[entry];
    const rsv_emitter *emitter = &local->lights->emitter[sample->emitter];
    if (!rsv_view_far_emitter(emitter, local->point, &view)) return false;
    rsv_sample_view(emitter, &view, u1, u2, sample);
    sample->pdf_solid_angle =
        (float)(probability * rsv_triangle_pdf(&view, sample->direction, sample->distance));
    return true;
}

/// A sun, or the sky beyond the last of them.
RSV_INLINE void rsv_sample_environment(
    const rsv_local_lights *local, uint32_t index, float u1, float u2, rsv_light_sample *sample)
{
    const rsv_environment_light *environment = local->lights->environment;
    sample->emitter = RSV_NONE;
    sample->distance = INFINITY;
    sample->from_sky = index >= environment->sun_count;
    if (index < environment->sun_count) {
        const rsv_sun *sun = &environment->sun[index];
        sample->direction = rsv_sun_sample(sun, u1, u2);
        sample->radiance = sun->radiance;
        sample->pdf_solid_angle = 1 / sun->solid_angle;
    } else {
        sample->pdf_solid_angle = rsv_sky_sample(&environment->sampler, u1, u2, &sample->direction);
        sample->radiance = rsv_sky_radiance(&environment->sampled, sample->direction);
    }
    sample->mean_radiance = sample->radiance;
    sample->pdf_solid_angle *= local->probability[local->count + index];
}

/// Emitters of the tree have the first `tree_share` of the numbers.
RSV_INLINE bool rsv_sample_any(
    const rsv_local_lights *local, float u_select, float u1, float u2, rsv_light_sample *sample)
{
    uint32_t entry;
    if (u_select < local->tree_share) {
        float probability = rsv_light_tree_sample(local->lights->emitter_tree, local->point,
            local->normal, u_select / local->tree_share, &entry);
        if (!(probability > 0) || !rsv_sample_emitter(local, local->count + entry,
                                      local->tree_share * probability, u1, u2, sample))
            return false;
        sample->mean_radiance = rgb_gray(0);
        return true;
    }
    entry = rsv_select_by_irradiance(local, u_select - local->tree_share);
    if (entry == RSV_NONE) return false;
    if (entry < local->count)
        return rsv_sample_emitter(local, entry, local->probability[entry], u1, u2, sample);
    rsv_sample_environment(local, entry - local->count, u1, u2, sample);
    return true;
}

/// As rsv_local_lights_sample, but of an emitter that varies its mean radiance and the place.
RSV_INLINE bool rsv_draw_light(
    const rsv_local_lights *local, float u_select, float u1, float u2, rsv_light_sample *sample)
{
    return rsv_sample_any(local, u_select, u1, u2, sample) &&
           v3_dot(sample->direction, local->normal) > 0 && sample->pdf_solid_angle > 0 &&
           isfinite(sample->pdf_solid_angle);
}

#endif
