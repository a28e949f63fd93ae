#include "solve_fields.h"

#include "../solve/transport_map.h"
#include "../solver/linear_solver.h"

static rsv_status solve_all(const rsv_light_view *s, size_t fields, double relative,
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

/// Whether all channels of all fields are alike, and stay so.
static bool are_gray(const rsv_light_view *s, size_t fields, const rsv_rgb *source)
{
    size_t count = s->elements->node_count * fields;
    for (size_t k = 0; k < count; k++)
        if (source[k].r != source[k].g || source[k].g != source[k].b) return false;
    return rsv_operator_is_gray(s->op);
}

/// Three fields share one, each in a channel of its own.
static void share_fields(size_t nodes, size_t fields, const rsv_rgb *field, rsv_rgb *shared)
{
    size_t thirds = (fields + 2) / 3;
    for (size_t n = 0; n < nodes; n++)
        for (size_t f = 0; f < fields; f++)
            (&shared[n * thirds + f / 3].r)[f % 3] = field[n * fields + f].r;
}

static void part_fields(size_t nodes, size_t fields, const rsv_rgb *shared, rsv_rgb *field)
{
    size_t thirds = (fields + 2) / 3;
    for (size_t n = 0; n < nodes; n++)
        for (size_t f = 0; f < fields; f++)
            field[n * fields + f] = rgb_gray((&shared[n * thirds + f / 3].r)[f % 3]);
}

rsv_status rsv_solve_fields(const rsv_light_view *s, size_t fields, double relative,
    rsv_rgb *source, rsv_rgb *solved, bool *reached)
{
    if (fields < 2 || !are_gray(s, fields, source))
        return solve_all(s, fields, relative, source, solved, reached);
    rsv_status status;
    size_t nodes = s->elements->node_count, thirds = (fields + 2) / 3;
    rsv_rgb *from = rsv_alloc(s->context, nodes * thirds, sizeof *from);
    rsv_rgb *to = rsv_alloc(s->context, nodes * thirds, sizeof *to);
    RSV_TRY(from && to ? RSV_OK : RSV_ERROR_MEMORY);
    share_fields(nodes, fields, source, from);
    share_fields(nodes, fields, solved, to);
    RSV_TRY(solve_all(s, thirds, relative, from, to, reached));
    part_fields(nodes, fields, from, source); // without what is masked
    part_fields(nodes, fields, to, solved);
cleanup:
    rsv_free(s->context, from);
    rsv_free(s->context, to);
    return status;
}
