#include "solve_desc.h"
#include "../core/descriptor.h"

#include "operator.h"

void rsv_solve_desc_init(rsv_solve_desc *desc, size_t size, rsv_quality quality)
{
    static const rsv_solve_desc presets[] = {
        [RSV_QUALITY_DRAFT] = { .element_target = 3000,
            .rays_per_element = 256,
            .refinements = 0,
            .light_samples = 16,
            .photon_count = 300000,
            .direct_levels = 2 },
        [RSV_QUALITY_MEDIUM] = { .element_target = 7000,
            .rays_per_element = 1024,
            .refinements = 3,
            .light_samples = 16,
            .photon_count = 1500000,
            .direct_levels = 3 },
        [RSV_QUALITY_HIGH] = { .element_target = 24000,
            .rays_per_element = 1024,
            .refinements = 3,
            .light_samples = 32,
            .photon_count = 6000000,
            .direct_levels = 4 },
    };
    rsv_solve_desc defaults = presets[quality];
    defaults.size = sizeof defaults;
    defaults.direct_level = true;
    defaults.max_orders = 4096;
    defaults.tolerance = 1e-4f;
    defaults.goal_camera = RSV_NONE;
    defaults.seed = 1;
    rsv_desc_fill(desc, size, &defaults);
}

static bool is_power_of_two(uint32_t value) { return value && (value & (value - 1)) == 0; }

rsv_status rsv_check_solve_desc(const rsv_solve_desc *desc)
{
    if (desc->element_target == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: element_target must be positive");
    if (!is_power_of_two(desc->rays_per_element) || desc->rays_per_element < RSV_FEWEST_RAYS ||
        desc->rays_per_element > RSV_MOST_RAYS)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: rays_per_element is %u; it must be a power of two from 64 to 4096",
            desc->rays_per_element);
    if (!is_power_of_two(desc->light_samples) || desc->light_samples < 16 ||
        desc->light_samples > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: light_samples is %u; it must be a power of two from 16 to 65536",
            desc->light_samples);
    if (!(desc->contact_share >= 0 && desc->contact_share <= 1))
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: contact_share is %g; it must be from 0 to 1",
            (double)desc->contact_share);
    if (desc->max_orders == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: max_orders must be positive");
    if (!(desc->tolerance > 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: tolerance must be positive");
    return RSV_OK;
}
