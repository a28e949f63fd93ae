#include "solve_fields.h"

#include "../solve/transport_map.h"
#include "../solver/linear_solver.h"

rsv_status rsv_solve_fields(const rsv_light_view *s, size_t fields, double relative,
    rsv_rgb *source, rsv_rgb *solved, bool *reached)
{
    rsv_status status;
    rsv_transport_map *map = NULL;
    rsv_linear_report report;
    rsv_linear_desc desc = rsv_default_linear_desc(s->report.solver);
    desc.relative = relative;
    RSV_TRY(rsv_operator_map(s->op, fields, &map));
    RSV_TRY(rsv_transport_map_prepare(map, desc.solver));
    rsv_transport_map_mask(map, fields, source);
    RSV_TRY(rsv_linear_solve(&map->linear, 3 * fields, &source->r, &desc, &solved->r, &report));
    if (reached) *reached = report.stop_reason <= RSV_STOP_NO_LIGHT;
cleanup:
    rsv_transport_map_destroy(map);
    return status;
}
