#include "rough_aim.h"

#include "../trace/passage.h"

void rsv_rough_aim(
    const rsv_rough_surface *s, const rsv_sky_visibility *visibility, rsv_sky_aim *aim)
{
    aim->count = 0;
    if (visibility)
        rsv_sky_aim_at(visibility, rsv_sky_visibility_at(visibility, s->path, &s->point), s->bsdf,
            s->wo, s->normal, aim);
}

rsv_rgb rsv_rough_aimed_light(
    const rsv_rough_surface *s, const rsv_lights *lights, const rsv_sky_aim *aim, const float u[3])
{
    if (aim->count == 0) return rgb_gray(0);
    rsv_vec3 direction = rsv_sky_aim_sample(aim, u);
    rsv_bsdf_value value = rsv_rough_respond(s, direction);
    float pdf = rsv_sky_aim_pdf(aim, direction);
    if (value.pdf_solid_angle == 0 || !(pdf > 0)) return rgb_gray(0);
    rsv_ray ray = { rsv_rough_leaving_point(s, direction), direction, INFINITY };
    float passed = rsv_tracer_passed(s->scene->tracer, &ray);
    if (!(passed > 0)) return rgb_gray(0);
    rsv_rgb arriving = rgb_mul(rsv_rough_throughput(s, direction, INFINITY),
        rsv_sky_radiance(&lights->environment->gathered, direction));
    float weight = passed * rsv_power_heuristic(pdf, value.pdf_solid_angle);
    return rgb_scale(rgb_mul(value.response, arriving), weight / pdf);
}
