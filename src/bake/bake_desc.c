#include "bake_desc.h"
#include "../core/descriptor.h"

#include "../core/core.h"

void rsv_bake_desc_init(rsv_bake_desc *desc, size_t size)
{
    const rsv_bake_desc defaults = { .size = sizeof defaults,
        .tolerance = 0.02f,
        .error = 0.01f,
        .padding = 2,
        .keep_uv = true,
        .turns = 1,
        .probe_samples = 64 };
    rsv_desc_fill(desc, size, &defaults);
}

rsv_status rsv_bake_check_desc(const rsv_bake_desc *desc)
{
    if (!(desc->tolerance >= 0.002f && desc->tolerance <= 1))
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the tolerance must be from 0.002 to 1");
    if (!(desc->error >= 0.001f && desc->error <= 0.5f))
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the error must be from 0.001 to 0.5");
    if (desc->judged > 65536)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "bake: the number of values to measure must be from 0 to 65536");
    if (!(desc->light_scale >= 0 && desc->light_scale <= 1e12f))
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the light scale must be from 0 to 1e12");
    if (!(desc->density >= 0 && desc->density <= 1e6f))
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: texels per metre must be from 0 to 1e6");
    if (desc->map_size && (desc->map_size < 16 || desc->map_size > 8192))
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the map's size must be from 16 to 8192 texels");
    if (desc->padding < 1 || desc->padding > 16)
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the padding must be from 1 to 16 texels");
    if (!(desc->probe_spacing >= 0 && desc->probe_spacing <= 1e6f))
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the probes' spacing must be from 0 to 1e6 m");
    if (desc->probe_samples < 32 || desc->probe_samples > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: a probe's samples must be from 32 to 65536");
    if (desc->turns < 1 || desc->turns > 64)
        return rsv_fail(RSV_ERROR_ARGUMENT, "bake: the number of environment angles must be from "
                                            "1 to 64");
    return RSV_OK;
}
