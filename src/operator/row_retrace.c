/// Rows of a scene that was edited: rays whose ends still hold are not traced.
#include "../elements/burial.h"
#include "row_tracer_internal.h"

#define LANES RSV_SUPPORT_POINTS
#define ALL_LANES ((1u << LANES) - 1)

/// What stays of sixteen rays.
typedef struct kept_rays {
    uint32_t column[LANES]; ///< RSV_NONE = none
    uint16_t ends;          ///< bit by bit: rays that end where they did
    uint16_t skies;         ///< rays that leave the scene as they did
    uint16_t blacks;        ///< rays that meet black backs as they did
} kept_rays;

/// @param seen [LANES] of the packet @param column of these rays, moved on to those of the next
static kept_rays keep_rays(const rsv_kept_row *row, const uint8_t *seen, const uint32_t **column,
    const rsv_ray_packet *packet)
{
    kept_rays kept = { .ends = 0 };
    uint16_t meets = rsv_scene_change_meets(row->change, packet);
    for (int k = 0; k < LANES; k++) {
        uint32_t then = seen[k] & RSV_ROW_RAY_ENDS ? *(*column)++ : RSV_NONE;
        bool lambert = (seen[k] & ~RSV_ROW_RAY_ENDS) == RSV_TARGET_LAMBERT;
        kept.column[k] = lambert && then != RSV_NONE ? row->end_now[then] : RSV_NONE;
        bool passes = packet->t_max[k] > 0 && !(meets >> k & 1);
        kept.ends |= (uint16_t)((passes && kept.column[k] != RSV_NONE) << k);
        kept.skies |= (uint16_t)((passes && seen[k] == RSV_TARGET_SKY) << k);
        bool black = row->change->has_gone && seen[k] == RSV_TARGET_BLACK;
        kept.blacks |= (uint16_t)((passes && black) << k);
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
    uint64_t rays = 0; // not counted, as a run that knows of nothing does without them
    return row->valid == rsv_judge_points(tracer->scene, tracer->elements, node, row->index,
                             (rsv_support_draw){ RSV_SUPPORT_POINTS, tracer->seed }, &rays);
}

void rsv_row_retrace(
    const rsv_row_tracer *tracer, uint32_t node, const rsv_kept_row *row, rsv_row_scratch *s)
{
    rsv_row_receiver r;
    rsv_row_receive_as(tracer, node, row->index, row->valid, &r);
    // what passes through coats and media is nothing but specular paths
    if (r.tints || !points_hold(tracer, node, row)) {
        rsv_row_trace(tracer, node, s);
        return;
    }
    uint32_t rays = tracer->directions.count;
    uint64_t kept_before = s->kept;
    const uint32_t *column = row->column;
    rsv_ray_packet packet = rsv_row_begin(tracer, &r, s);
    for (uint32_t first = 0; first < rays; first += LANES) {
        const float *z = rsv_row_aim(tracer, &r, first, &packet);
        kept_rays kept = keep_rays(row, row->kind + first, &column, &packet);
        s->kept += LANES - trace_others(tracer, &kept, &packet);
        if (kept.ends != ALL_LANES) rsv_row_process_hits(tracer, s, first, &r, z, &packet);
        for (uint32_t k = 0; k < LANES; k++) {
            if (!(kept.ends >> k & 1)) continue;
            s->column[first + k] = kept.column[k];
            s->kind[first + k] = RSV_TARGET_LAMBERT;
        }
    }
    s->rays += rays;
    s->kept_rows += s->kept - kept_before == rays;
}
