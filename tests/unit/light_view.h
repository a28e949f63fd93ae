/// The contents of a light, for tests that look inside.
#ifndef RSV_TEST_LIGHT_VIEW_H
#define RSV_TEST_LIGHT_VIEW_H

#include "solve/light.h"

static inline const rsv_light_view *inside(const rsv_light *light)
{
    return rsv_light_get_view(light);
}

#endif
