#include "source_state.h"

#include "../core/sampling.h"

#include <string.h>

/// Pixels of the surroundings that are looked at.
#define MOST_PIXELS 4096

static uint32_t add_floats(uint32_t state, const float *value, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        uint32_t bits;
        memcpy(&bits, &value[k], sizeof bits);
        state = rsv_hash2(state, bits);
    }
    return state;
}

static uint32_t add_punctual(uint32_t state, const rsv_punctual_light *l)
{
    state = add_floats(state, &l->position.x, 3);
    state = add_floats(state, &l->direction.x, 3);
    state = add_floats(state, &l->intensity.r, 3);
    const float shape[3] = { l->inner_cone_angle, l->outer_cone_angle, l->exponent };
    return rsv_hash2(add_floats(state, shape, 3), (uint32_t)l->kind);
}

/// All pixels change where their strength does.
static uint32_t add_surroundings(uint32_t state, const rsv_sky *sky)
{
    size_t count = (size_t)sky->width * sky->height, step = count / MOST_PIXELS + 1;
    state = add_floats(state, &sky->turn, 1);
    for (size_t k = 0; k < count; k += step)
        state = add_floats(state, &sky->pixel[k].r, 3);
    return state;
}

uint32_t rsv_source_state(const rsv_light_view *s)
{
    const rsv_scene_view *scene = s->scene.view;
    uint32_t state = rsv_hash2((uint32_t)scene->light_count, 1);
    for (size_t k = 0; k < scene->light_count; k++)
        state = add_punctual(state, &scene->light[k]);
    return s->lights->environment ? add_surroundings(state, &s->lights->environment->whole) : state;
}
