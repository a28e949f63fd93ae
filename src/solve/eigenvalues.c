#include "../core/team.h"
#include "light_internal.h"

rsv_status rsv_leading_eigenvalues(const rsv_light *s, size_t *count, double *value)
{
    rsv_status status;
    rsv_transport_map *map = NULL;
    char message[RSV_MESSAGE_BYTES];
    RSV_TRY(rsv_operator_map(s->op, 1, &map));
    RSV_TRY(rsv_transport_map_prepare(map, RSV_SOLVER_PETSC));
    status = rsv_context_team(s->context)
                 ->table->krylov->eigenvalues(map->krylov, count, value, message);
    if (status != RSV_OK) status = rsv_fail(status, "eigenvalues: %s", message);
cleanup:
    rsv_transport_map_destroy(map);
    return status;
}
