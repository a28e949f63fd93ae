/// Rows of a scene that was edited: rays whose ends still hold are not traced.
#include "../elements/burial.h"
#include "row_tracer_internal.h"

#define LANES RSV_SUPPORT_POINTS
#define ALL_LANES ((1u << LANES) - 1)
#define ROUNDING 1e-5f ///< of distances along rays

/// The reused ones of sixteen rays.
typedef struct kept_rays {
    uint32_t column[LANES]; ///< RSV_NONE = none
    uint16_t ends;          ///< bit by bit: rays that end where they did
    uint16_t skies;         ///< rays that leave the scene as they did
    uint16_t blacks;        ///< rays that meet black backs as they did
} kept_rays;

/// As far as a ray can have got that ended in a cell of that box.
static float farthest_end(const rsv_vec3 box[2], const rsv_ray_packet *p, int k)
{
    float x = p->origin_x[k], y = p->origin_y[k], z = p->origin_z[k];
    rsv_vec3 d = v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]);
    float reach = f_max(d.x * (box[0].x - x), d.x * (box[1].x - x)) +
                  f_max(d.y * (box[0].y - y), d.y * (box[1].y - y)) +
                  f_max(d.z * (box[0].z - z), d.z * (box[1].z - z));
    return reach * (1 + ROUNDING);
}

/// Rays that hit black backs: removed objects may have hidden some of these.
static uint16_t keep_blacks(
    const rsv_kept_row *row, const uint8_t *seen, const rsv_ray_packet *packet)
{
    uint16_t blacks = 0;
    float at[LANES];
    for (int k = 0; k < LANES && row->change->has_gone; k++)
        blacks |= (uint16_t)((seen[k] == RSV_TARGET_BLACK && packet->t_max[k] > 0) << k);
    if (!blacks) return 0;
    rsv_scene_change_meets(row->change, packet, at);
    for (int k = 0; k < LANES; k++)
        if (at[k] < INFINITY) blacks &= (uint16_t) ~(1u << k);
    return blacks;
}

/// Whether a ray ended at its first surface. Paths in coated surfaces are the same as long as the coat is, which is
/// known where the change is.
static bool ends_at_once(const rsv_kept_row *row, uint8_t seen)
{
    uint8_t kind = seen & (uint8_t)~RSV_ROW_RAY_ENDS;
    return kind == RSV_TARGET_LAMBERT || (kind == RSV_TARGET_ENTERED && row->change->has_gone);
}

/// @param seen [LANES] of the packet @param column of these rays, moved on to those of the next
static kept_rays keep_rays(const rsv_kept_row *row, const uint8_t *seen, const uint32_t **column,
    const rsv_ray_packet *packet)
{
    kept_rays kept = { .blacks = keep_blacks(row, seen, packet) };
    float at[LANES];
    rsv_scene_change_meets(row->added, packet, at);
    for (int k = 0; k < LANES; k++) {
        uint32_t then = seen[k] & RSV_ROW_RAY_ENDS ? *(*column)++ : RSV_NONE;
        bool known = then != RSV_NONE && packet->t_max[k] > 0 && ends_at_once(row, seen[k]);
        uint32_t now = kept.column[k] = known ? row->end_now[then] : RSV_NONE;
        bool ends = now != RSV_NONE &&
                    (at[k] == INFINITY || at[k] > farthest_end(row->end_box[now], packet, k));
        bool leaves = packet->t_max[k] > 0 && seen[k] == RSV_TARGET_SKY && at[k] == INFINITY;
        kept.ends |= (uint16_t)(ends << k);
        kept.skies |= (uint16_t)(leaves << k);
    }
    return kept;
}

/// Traces the other rays of a packet. @return how many
static uint32_t trace_others(
    const rsv_row_tracer *tracer, const kept_rays *kept, rsv_ray_packet *packet)
{
    uint16_t known = kept->ends | kept->skies | kept->blacks;
    uint32_t traced = 0;
    if (kept->ends == ALL_LANES) return 0;
    for (int k = 0; k < LANES; k++) {
        if (known >> k & 1) packet->t_max[k] = -1;
        packet->triangle[k] = RSV_NONE;
        traced += packet->t_max[k] > 0;
    }
    if (traced) rsv_tracer_closest_packet(tracer->scene->tracer, packet, false);
    for (int k = 0; k < LANES; k++) {
        if (!(known >> k & 1)) continue;
        packet->triangle[k] = RSV_NONE;
        packet->t_max[k] = kept->skies >> k & 1 ? INFINITY : -1;
    }
    return traced;
}

/// Whether the points that counted then count still, and no others.
static bool points_hold(const rsv_row_tracer *tracer, uint32_t node, const rsv_kept_row *row)
{
    const uint16_t all = (1u << RSV_SUPPORT_POINTS) - 1;
    if (row->valid == all && tracer->valid_points[node] == all) return true;
    if (row->index == rsv_elements_draw_of(tracer->elements, node))
        return row->valid == tracer->valid_points[node];
    uint64_t rays = 0; // not counted, because a run without reuse does not trace them
    return row->valid == rsv_judge_points(tracer->scene, tracer->elements, node, row->index,
                             (rsv_support_draw){ RSV_SUPPORT_POINTS, tracer->seed }, &rays);
}

void rsv_row_retrace(
    const rsv_row_tracer *tracer, uint32_t node, const rsv_kept_row *row, rsv_row_scratch *s)
{
    rsv_row_receiver r;
    rsv_row_receive_as(tracer, node, row->index, row->valid, &r);
    uint32_t rays = tracer->directions.count;
    uint64_t kept_before = s->kept;
    const uint32_t *column = row->column;
    rsv_ray_packet packet = rsv_row_begin(tracer, &r, s);
    bool weighs = r.tints && (!s->whole || rsv_medium_absorbs(&r.medium, tracer->scene->bsdf));
    if (weighs || !points_hold(tracer, node, row)) {
        rsv_row_trace(tracer, node, s);
        return;
    }
    for (uint32_t first = 0; first < rays; first += LANES) {
        const float *z = rsv_row_aim(tracer, &r, first, &packet);
        kept_rays kept = keep_rays(row, row->kind + first, &column, &packet);
        s->kept += LANES - trace_others(tracer, &kept, &packet);
        if (kept.ends != ALL_LANES) rsv_row_process_hits(tracer, s, first, &r, z, &packet);
        for (uint32_t k = 0; k < LANES; k++)
            if (kept.ends >> k & 1)
                rsv_row_keep_end(s, first + k, kept.column[k], row->kind[first + k]);
    }
    s->rays += rays;
    s->kept_rows += s->kept - kept_before == rays;
}
