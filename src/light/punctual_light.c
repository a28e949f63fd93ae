/// Punctual lights after KHR_lights_punctual.
#include "light.h"

/// Share of a spot's intensity at the cosine of the angle to its axis: the extension's recommended
/// falloff, the square of a ramp in the cosine between the cones; a step where they coincide.
static double spot_falloff(const rsv_light *light, double cos_angle)
{
    double cos_inner = cos(light->inner_cone_angle), cos_outer = cos(light->outer_cone_angle);
    if (cos_angle < cos_outer) return 0;
    double ramp = cos_inner > cos_outer ? (cos_angle - cos_outer) / (cos_inner - cos_outer) : 1;
    double falloff = ramp < 1 ? ramp * ramp : 1;
    return light->exponent != 0 ? falloff * pow(fmax(cos_angle, 0), light->exponent) : falloff;
}

bool rsv_punctual_light(const rsv_light *light, rsv_vec3 point, rsv_vec3 *direction,
    float *distance, rsv_rgb *irradiance)
{
    if (rgb_is_black(light->intensity)) return false;
    if (light->kind == RSV_LIGHT_DIRECTIONAL) {
        *direction = v3_neg(light->direction);
        *distance = INFINITY;
        *irradiance = light->intensity;
        return true;
    }
    rsv_vec3 towards = v3_sub(light->position, point);
    *distance = v3_length(towards);
    if (!(*distance > 0)) return false;
    *direction = v3_scale(towards, 1 / *distance);
    double scale = 1 / ((double)*distance * *distance);
    if (light->kind == RSV_LIGHT_SPOT)
        scale *= spot_falloff(light, -v3_dot(*direction, light->direction));
    *irradiance = rgb_scale(light->intensity, (float)scale);
    return scale > 0;
}
