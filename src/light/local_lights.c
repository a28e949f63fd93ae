/// Next-event estimation: the emitters as one receiver sees them.
#include "light_internal.h"

/// Below this solid angle a triangle is sampled by area: the density then varies little over it,
/// and the spherical triangle would have few digits left.
#define SOLID_ANGLE_SAMPLING_MIN 1e-4

/// A triangle as a point sees it: what both sampling and density decide by.
typedef struct triangle_view {
    rsv_double3 corner[3];   ///< relative to the point
    rsv_double3 area_vector; ///< front normal times area
    rsv_spherical_triangle spherical;
    bool by_area;
} triangle_view;

/// Half the cross product of the edges in double: the float normal of the emitter tilts its plane
/// by more than a grazing point is above it.
static rsv_double3 emitter_area_vector(const rsv_emitter *emitter)
{
    return d3_scale(d3_cross(d3_between(emitter->corner[0], emitter->corner[1]),
                        d3_between(emitter->corner[0], emitter->corner[2])),
        0.5);
}

bool rsv_emitter_faces(const rsv_emitter *emitter, rsv_vec3 point)
{
    rsv_double3 area_vector = emitter_area_vector(emitter);
    double height = d3_dot(area_vector, d3_between(emitter->corner[0], point));
    if (emitter->double_sided) height = fabs(height);
    return height > rsv_rounding_height(emitter->corner, 3, point) * d3_length(area_vector);
}

static bool view_emitter(const rsv_emitter *emitter, rsv_vec3 point, triangle_view *view)
{
    if (!rsv_emitter_faces(emitter, point)) return false;
    view->area_vector = emitter_area_vector(emitter);
    for (int i = 0; i < 3; i++)
        view->corner[i] = d3_between(point, emitter->corner[i]);
    view->spherical = rsv_spherical_triangle_from(view->corner);
    view->by_area = view->spherical.solid_angle < SOLID_ANGLE_SAMPLING_MIN;
    return true;
}

static float projected_solid_angle(const rsv_emitter *emitter, rsv_vec3 point, rsv_vec3 normal)
{
    if (!rsv_emitter_faces(emitter, point)) return 0;
    return rsv_polygon_irradiance(emitter->corner, 3, point, normal);
}

void rsv_lights_at(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, rsv_local_lights *local)
{
    local->lights = lights;
    local->point = point;
    local->normal = normal;
    local->count = 0;
    local->unshadowed = rgb_gray(0);
    local->by_power = lights->sampled_count > RSV_LOCAL_LIGHTS;
    if (local->by_power) return;
    local->count = (uint32_t)lights->sampled_count;
    float sum = 0;
    for (uint32_t i = 0; i < local->count; i++) {
        const rsv_emitter *emitter = &lights->emitter[lights->sampled[i]];
        float projected = projected_solid_angle(emitter, point, normal);
        local->unshadowed = rgb_mad(local->unshadowed, projected, emitter->radiance);
        local->probability[i] = projected * rgb_luminance(emitter->radiance);
        sum += local->probability[i];
    }
    for (uint32_t i = 0; i < local->count && sum > 0; i++)
        local->probability[i] /= sum;
}

static double selection_probability(const rsv_local_lights *local, uint32_t entry)
{
    if (!local->by_power) return local->probability[entry];
    const double *cdf = local->lights->power_cdf;
    return entry ? cdf[entry] - cdf[entry - 1] : cdf[0];
}

static uint32_t select_by_power(const rsv_lights *lights, double u)
{
    size_t low = 0, high = lights->sampled_count - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (u < lights->power_cdf[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return (uint32_t)low;
}

/// RSV_NONE if no entry has a probability; the last that has one also takes what rounding left
/// over.
static uint32_t select_by_irradiance(const rsv_local_lights *local, float u)
{
    uint32_t selected = RSV_NONE;
    for (uint32_t i = 0; i < local->count && u >= 0; i++) {
        if (!(local->probability[i] > 0)) continue;
        selected = i;
        u -= local->probability[i];
    }
    return selected;
}

/// Entry of lights->sampled that holds `emitter`, or RSV_NONE: the list ascends.
static uint32_t find_entry(const rsv_lights *lights, uint32_t emitter)
{
    size_t low = 0, high = lights->sampled_count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (lights->sampled[middle] < emitter)
            low = middle + 1;
        else
            high = middle;
    }
    bool found = low < lights->sampled_count && lights->sampled[low] == emitter;
    return found ? (uint32_t)low : RSV_NONE;
}

/// Density per solid angle on a triangle that is already chosen.
static double triangle_pdf(const triangle_view *view, rsv_vec3 direction, float distance)
{
    if (!view->by_area) return 1 / view->spherical.solid_angle;
    double projected_area = fabs(d3_dot(view->area_vector, d3_from(direction)));
    return projected_area > 0 ? (double)distance * distance / projected_area : 0;
}

/// The vector from the receiver to a random point of the triangle.
static rsv_double3 sample_triangle(const triangle_view *view, float u1, float u2)
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

/// Radiance of the emitter's point at `towards` from the receiver.
static rsv_rgb radiance_at(
    const rsv_lights *lights, uint32_t emitter, const triangle_view *view, rsv_double3 towards)
{
    if (!lights->emitter[emitter].varies) return lights->emitter[emitter].radiance;
    rsv_double3 edge1 = d3_sub(view->corner[1], view->corner[0]);
    rsv_double3 edge2 = d3_sub(view->corner[2], view->corner[0]);
    rsv_double3 place = d3_sub(towards, view->corner[0]);
    double area = 2 * d3_dot(view->area_vector, view->area_vector);
    double u = d3_dot(view->area_vector, d3_cross(place, edge2)) / area;
    double v = d3_dot(view->area_vector, d3_cross(edge1, place)) / area;
    return rsv_emitter_radiance(lights, emitter, (float)u, (float)v);
}

bool rsv_local_lights_sample(
    const rsv_local_lights *local, float u_select, float u1, float u2, rsv_light_sample *sample)
{
    const rsv_lights *lights = local->lights;
    uint32_t entry =
        local->by_power ? select_by_power(lights, u_select) : select_by_irradiance(local, u_select);
    if (entry == RSV_NONE) return false;
    sample->emitter = lights->sampled[entry];
    const rsv_emitter *emitter = &lights->emitter[sample->emitter];
    triangle_view view;
    if (!view_emitter(emitter, local->point, &view)) return false;
    rsv_double3 towards = sample_triangle(&view, u1, u2);
    double distance = d3_length(towards);
    sample->distance = (float)distance;
    sample->direction = d3_to_float(d3_scale(towards, 1 / distance));
    sample->mean_radiance = emitter->radiance;
    sample->radiance = radiance_at(lights, sample->emitter, &view, towards);
    if (!(v3_dot(sample->direction, local->normal) > 0)) return false;
    sample->pdf_solid_angle = (float)(selection_probability(local, entry) *
                                      triangle_pdf(&view, sample->direction, sample->distance));
    return sample->pdf_solid_angle > 0 && isfinite(sample->pdf_solid_angle);
}

float rsv_local_lights_pdf(
    const rsv_local_lights *local, uint32_t emitter, rsv_vec3 direction, float distance)
{
    uint32_t entry = find_entry(local->lights, emitter);
    if (entry == RSV_NONE || !(v3_dot(direction, local->normal) > 0)) return 0;
    double probability = selection_probability(local, entry);
    triangle_view view;
    if (!(probability > 0) || !view_emitter(&local->lights->emitter[emitter], local->point, &view))
        return 0;
    return (float)(probability * triangle_pdf(&view, direction, distance));
}
