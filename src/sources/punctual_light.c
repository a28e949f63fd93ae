#include "punctual_light.h"

double rsv_punctual_flux(const rsv_scene_view *scene, const rsv_punctual_light *light)
{
    double intensity = (double)rgb_luminance(light->intensity);
    if (rsv_punctual_is_distant(light)) return 0;
    if (light->kind == RSV_PUNCTUAL_LUMINAIRE)
        return intensity * rsv_luminaire_flux(&scene->luminaire[light->luminaire]);
    double cos_outer = rsv_punctual_has_cone(light) ? cos((double)light->outer_cone_angle) : -1;
    return intensity * 2 * M_PI * (1 - cos_outer);
}

#define FALLOFF_STEPS 4096

/// Mean of a spot's falloff over the solid angle of its cone.
static double mean_falloff(const rsv_punctual_light *light)
{
    double sum = 0, cos_outer = cos((double)light->outer_cone_angle);
    for (int k = 0; k < FALLOFF_STEPS; k++)
        sum += rsv_spot_falloff(light, 1 - (1 - cos_outer) * (k + 0.5) / FALLOFF_STEPS);
    return sum / FALLOFF_STEPS;
}

double rsv_punctual_lumens(const rsv_scene_view *scene, const rsv_punctual_light *light)
{
    double flux = RSV_LUMEN_PER_WATT * rsv_punctual_flux(scene, light);
    bool spot = light->kind != RSV_PUNCTUAL_LUMINAIRE && rsv_punctual_has_cone(light);
    return spot ? flux * mean_falloff(light) : flux;
}
