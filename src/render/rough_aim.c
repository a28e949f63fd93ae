#include "rough_aim.h"

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
    const rsv_light_sample sample = { .direction = direction,
        .distance = INFINITY,
        .radiance = rsv_sky_radiance(&lights->environment->gathered, direction),
        .pdf_solid_angle = pdf,
        .emitter = RSV_NONE,
        .from_sky = true };
    rsv_rough_side side;
    rsv_next_event event;
    rsv_rough_set_side(s, v3_dot(s->normal, direction) < 0, &side);
    rsv_next_event_clear(&event);
    rsv_next_event_at_place(
        &side.receiver, &side.entrance, lights, &sample, rsv_rough_weighed(&value, pdf), &event);
    return rgb_scale(event.light, rsv_next_event_passed(s->scene->tracer, &event));
}
