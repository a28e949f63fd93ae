#include "error_target.h"

rsv_status cli_solve_to_target(const rsv_scene *scene, const rsv_solve_desc *desc,
    const cli_error_target *target, rsv_light **solution, rsv_certificate *certificate)
{
    if (target->share == 0) return rsv_light_create(scene, desc, solution);
    rsv_error_target goal = rsv_default_error_target((double)target->share);
    rsv_error_stop stop;
    if (desc->max_elements) goal.max_elements = desc->max_elements;
    if (target->max_seconds > 0) goal.max_seconds = (double)target->max_seconds;
    return rsv_solve_to_error(scene, desc, &goal, solution, certificate, &stop);
}
