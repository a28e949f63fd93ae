#include "tracked_rows.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "../update/moved_elements.h"
#include "operator_constants.h"
#include "row_touch.h"
#include "row_tracer_internal.h"
#include "tracked_row.h"
#include "transport_rows.h"

#define LANES RSV_SUPPORT_POINTS
#define MOST_RAYS (LANES * RSV_MOST_ROW_PACKETS)

typedef struct tracked_rows {
    rsv_transport transport; ///< first, so that either is the other
    rsv_row_tracer tracer;
    rsv_row_cones cones;
    rsv_trail_frame frame;
    uint32_t rays;  ///< of a row
    uint32_t *slot; ///< [row_count] index of the row in the following arrays; RSV_NONE = it hangs
    size_t slot_count;
    uint32_t *column;     ///< [slot_count * rays] ends of weight 1, the first `count` of each
    uint16_t *reach;      ///< [slot_count * rays]
    uint8_t *kind;        ///< [slot_count * rays] with RSV_ROW_RAY_ENDS
    uint32_t *count;      ///< [slot_count]
    uint8_t *lost;        ///< [slot_count] 1 = there are columns RSV_NONE, of ends that are no more
    rsv_row_place *place; ///< [slot_count]
    rsv_row_tail **tail;  ///< [slot_count]
    size_t entries;       ///< of all rows
    size_t live_rows;     ///< neither hanging nor buried
    rsv_row_scratch *scratch; ///< [threads]
} tracked_rows;

static const rsv_transport_table tracked_rows_table;

static tracked_rows *rows_of(const rsv_transport *transport)
{
    RSV_ASSERT(transport->table == &tracked_rows_table);
    return (tracked_rows *)(uintptr_t)transport;
}

bool rsv_rows_are_tracked(const rsv_transport *transport)
{
    return transport->table == &tracked_rows_table;
}

// ---- one row --------------------------------------------------------------------------------------

/// The rays of a row to trace again, and their tracer.
typedef struct patch {
    tracked_rows *t;
    uint32_t node;
    size_t slot, first; ///< first ray of the row in arrays of rays
    size_t set;         ///< of directions, in packets
    rsv_row_scratch *scratch;
    uint64_t touched[MOST_RAYS / 64];
} patch;

static bool is_touched(const patch *p)
{
    for (uint32_t k = 0; k < (p->t->rays + 63) / 64; k++)
        if (p->touched[k]) return true;
    return false;
}

static void touch_packet(
    patch *p, const rsv_receiver_points *points, const rsv_scene_change *change, uint32_t first)
{
    rsv_ray_packet packet;
    float at[LANES];
    const uint16_t *reach = p->t->reach + p->first + first;
    const rsv_directions *d = &p->t->tracer.directions;
    size_t from = p->set * LANES + first;
    rsv_receiver_points_aim(points, d->x + from, d->y + from, d->z + from, &packet);
    rsv_scene_change_meets(change, &packet, at);
    for (uint32_t k = 0; k < LANES; k++) {
        bool meets = packet.t_max[k] > 0 && at[k] < INFINITY &&
                     at[k] * (1 - 1e-4f) <= rsv_reach_metres(reach[k]);
        p->touched[(first + k) / 64] |= (uint64_t)meets << ((first + k) % 64);
    }
}

/// Marks rays whose ends are no more.
static void touch_lost(patch *p)
{
    const tracked_rows *t = p->t;
    const uint32_t *column = t->column + p->first;
    const rsv_row_tail *tail = t->tail[p->slot];
    const rsv_row_tail_view v = rsv_row_tail_view_of(tail);
    for (uint32_t ray = 0; ray < t->rays; ray++) {
        if (!(t->kind[p->first + ray] & RSV_ROW_RAY_ENDS)) continue;
        bool lost = *column++ == RSV_NONE;
        p->touched[ray / 64] |= (uint64_t)lost << (ray % 64);
    }
    for (uint32_t k = 0; tail && k < tail->tinted_count; k++)
        if (v.tinted_column[k] == RSV_NONE)
            p->touched[v.tinted_ray[k] / 64] |= (uint64_t)1 << (v.tinted_ray[k] % 64);
}

/// Finds the rays of a row that touch boxes. @return whether there are any
static bool find_touched(patch *p, const rsv_scene_change *change)
{
    tracked_rows *t = p->t;
    rsv_receiver_points points;
    uint64_t packet[RSV_MOST_ROW_PACKETS / 64];
    uint32_t index = rsv_elements_draw_of(t->tracer.elements, p->node);
    p->set = rsv_directions_of(&t->tracer.directions, t->tracer.seed, index) / LANES;
    memset(p->touched, 0, sizeof p->touched);
    if (t->lost[p->slot]) touch_lost(p);
    rsv_row_tail_touch(t->tail[p->slot], &t->frame, change, p->touched);
    if (!rsv_row_cones_meet(&t->cones, p->set, &t->place[p->slot], change, packet))
        return is_touched(p);
    rsv_row_place_points(&t->tracer, p->node, &points);
    for (uint32_t k = 0; k < t->cones.packets; k++)
        if (rsv_ray_is_marked(packet, k)) touch_packet(p, &points, change, k * LANES);
    return is_touched(p);
}

/// Reuses the results of rays that are not affected. @return how many there are
static uint32_t keep_others(const patch *p)
{
    const tracked_rows *t = p->t;
    rsv_row_scratch *s = p->scratch;
    const uint32_t *column = t->column + p->first;
    uint32_t touched = 0;
    for (uint32_t ray = 0; ray < t->rays; ray++) {
        uint8_t kind = t->kind[p->first + ray];
        uint32_t end = kind & RSV_ROW_RAY_ENDS ? *column++ : RSV_NONE;
        s->kind[ray] = kind & (uint8_t)~RSV_ROW_RAY_ENDS;
        s->track->reach[ray] = t->reach[p->first + ray];
        bool again = rsv_ray_is_marked(p->touched, ray);
        s->column[ray] = again ? RSV_NONE : end;
        touched += again;
    }
    rsv_row_tail_keep(t->tail[p->slot], p->touched, s);
    return touched;
}

/// Traces the touched rays of a packet. @param seen [LANES] kinds of all of them
static void trace_touched(
    const patch *p, const rsv_row_receiver *r, uint32_t first, rsv_ray_packet *packet)
{
    rsv_row_scratch *s = p->scratch;
    uint8_t seen[LANES];
    const float *z = rsv_row_aim(&p->t->tracer, r, first, packet);
    memcpy(seen, s->kind + first, LANES);
    for (uint32_t k = 0; k < LANES; k++) {
        packet->triangle[k] = RSV_NONE;
        if (!rsv_ray_is_marked(p->touched, first + k)) packet->t_max[k] = -1;
    }
    rsv_tracer_closest_packet(p->t->tracer.scene->tracer, packet, false);
    for (uint32_t k = 0; k < LANES; k++)
        if (rsv_ray_is_marked(p->touched, first + k))
            s->track->reach[first + k] = rsv_reach_of(packet->t_max[k]);
    rsv_row_process_hits(&p->t->tracer, s, first, r, z, packet);
    for (uint32_t k = 0; k < LANES; k++)
        if (!rsv_ray_is_marked(p->touched, first + k)) s->kind[first + k] = seen[k];
}

static void trace_again(const patch *p, const rsv_row_receiver *r)
{
    rsv_ray_packet packet = rsv_row_begin(&p->t->tracer, r, p->scratch);
    uint32_t touched = keep_others(p);
    p->scratch->rays += touched;
    for (uint32_t first = 0; first < p->t->rays; first += LANES)
        if (p->touched[first / 64] >> (first % 64) & 0xffff) trace_touched(p, r, first, &packet);
}

static rsv_status store_row(const patch *p)
{
    tracked_rows *t = p->t;
    const rsv_row_scratch *s = p->scratch;
    uint32_t *column = t->column + p->first, count = 0;
    for (uint32_t ray = 0; ray < t->rays; ray++) {
        bool ends = s->column[ray] != RSV_NONE;
        if (ends) column[count++] = s->column[ray];
        t->kind[p->first + ray] = (uint8_t)(s->kind[ray] | (ends ? RSV_ROW_RAY_ENDS : 0));
        t->reach[p->first + ray] = s->track->reach[ray];
    }
    t->count[p->slot] = count;
    t->lost[p->slot] = 0;
    float scale = t->transport.scale[p->node] = 1 / (float)t->rays;
    t->transport.gathered[p->node] = rgb_scale(s->emission, RSV_PI * scale);
    return rsv_row_tail_store(t->transport.context, s, &t->tail[p->slot]);
}

static void empty_row(const patch *p)
{
    tracked_rows *t = p->t;
    t->count[p->slot] = 0;
    t->lost[p->slot] = 0;
    t->transport.scale[p->node] = 0;
    t->transport.gathered[p->node] = rgb_gray(0);
    rsv_free(t->transport.context, t->tail[p->slot]);
    t->tail[p->slot] = NULL;
}

/// Whether a row stays as it is although its receiver points have moved: its turn comes later.
static bool can_wait(const patch *p, const rsv_rows_motion *motion)
{
    const tracked_rows *t = p->t;
    return motion && motion->anew[p->node] == RSV_MOVE_WAITS && t->transport.scale[p->node] > 0 &&
           !t->lost[p->slot];
}

/// Whether a row of a place that stays is patched in another call.
static bool has_no_turn(const patch *p, const rsv_rows_motion *motion)
{
    return motion->turns > 0 && p->node % motion->turns != motion->turn && !p->t->lost[p->slot];
}

/// @param motion NULL = all rows are new
static rsv_status find_row(patch *p, const rsv_rows_motion *motion)
{
    tracked_rows *t = p->t;
    rsv_row_receiver r;
    if (!t->tracer.valid_points[p->node]) {
        empty_row(p);
        return RSV_OK;
    }
    bool whole = !motion || motion->anew[p->node] || t->transport.scale[p->node] == 0;
    if (whole && can_wait(p, motion)) {
        p->scratch->kept_rows++;
        return RSV_OK;
    }
    if (whole) {
        rsv_row_receive(&t->tracer, p->node, &r);
        t->place[p->slot] = rsv_row_place_of(&r.points);
        rsv_row_trace_from(&t->tracer, &r, p->scratch);
        return store_row(p);
    }
    if (has_no_turn(p, motion) || !find_touched(p, motion->change)) {
        p->scratch->kept_rows++;
        return RSV_OK;
    }
    rsv_row_receive(&t->tracer, p->node, &r);
    trace_again(p, &r);
    return store_row(p);
}

// ---- all rows -------------------------------------------------------------------------------------

typedef struct rows_job {
    tracked_rows *rows;
    const rsv_rows_motion *motion; ///< NULL = all rows are new
    _Atomic rsv_status result;
} rows_job;

static void find_span(void *data, rsv_span span)
{
    rows_job *job = data;
    tracked_rows *t = job->rows;
    rsv_context *context = t->transport.context;
    for (uint32_t node = (uint32_t)span.begin; node < span.end; node++) {
        if (t->slot[node] == RSV_NONE || rsv_cancelled(context)) continue;
        patch p;
        p.t = t;
        p.node = node;
        p.slot = t->slot[node];
        p.first = p.slot * t->rays;
        p.scratch = &t->scratch[span.worker];
        rsv_keep_failure(&job->result, find_row(&p, job->motion));
    }
    if (span.worker == 0)
        rsv_progress(context, "assemble", (double)span.end / (double)t->transport.row_count);
}

static rsv_status find_rows(tracked_rows *t, const rsv_rows_motion *motion)
{
    rsv_context *context = t->transport.context;
    rows_job job = { .rows = t, .motion = motion };
    rsv_parallel_for(context, t->transport.row_count, 64, find_span, &job);
    if (job.result == RSV_ERROR_MEMORY)
        return rsv_fail(RSV_ERROR_MEMORY, "out of memory assembling the operator");
    return rsv_cancelled(context) ? rsv_progress(context, "assemble", 1) : job.result;
}

/// Lists where the rays of all rows left the scene.
static rsv_status list_escapes(tracked_rows *t)
{
    rsv_context *context = t->transport.context;
    size_t rows = t->transport.row_count;
    rsv_escapes *e = &t->transport.escapes;
    rsv_escape_list list = { 0 };
    rsv_status status;
    if (e->begin && !t->tracer.scene->view->environment) return RSV_OK;
    rsv_escapes_destroy(context, e);
    RSV_TRY(rsv_escapes_create(context, rows, e));
    for (size_t row = 0; row < rows && t->tracer.scene->view->environment; row++) {
        const rsv_row_tail *tail = t->slot[row] == RSV_NONE ? NULL : t->tail[t->slot[row]];
        rsv_row_tail_view v = rsv_row_tail_view_of(tail);
        const rsv_escape_row escapes = { v.bin, v.tinted_bin, v.bin_weight,
            tail ? tail->bin_count : 0, tail ? tail->tinted_bin_count : 0 };
        RSV_TRY(rsv_escapes_store(context, e, row, &escapes, &list));
    }
    RSV_TRY(rsv_escapes_append(context, e, &list));
    rsv_escapes_finish(e, rows);
cleanup:
    rsv_escape_list_destroy(context, &list);
    return status;
}

static void count_entries(tracked_rows *t)
{
    t->entries = t->live_rows = 0;
    for (size_t k = 0; k < t->slot_count; k++)
        t->entries += t->count[k] + (t->tail[k] ? t->tail[k]->tinted_count : 0);
    for (size_t row = 0; row < t->transport.row_count; row++)
        t->live_rows += t->transport.scale[row] > 0;
}

bool rsv_tracked_rows_can_follow(const rsv_transport *transport, const rsv_scene_change *change)
{
    const rsv_trail_frame *f = &rows_of(transport)->frame;
    for (uint32_t k = 0; k < change->count; k++) {
        rsv_vec3 low = change->low[k], high = change->high[k];
        if (low.x < f->low.x || low.y < f->low.y || low.z < f->low.z || high.x > f->high.x ||
            high.y > f->high.y || high.z > f->high.z)
            return false;
    }
    return true;
}

rsv_status rsv_tracked_rows_patch(
    rsv_transport *transport, const rsv_rows_motion *motion, rsv_rows_patched *patched)
{
    tracked_rows *t = rows_of(transport);
    int threads = rsv_threads(transport->context);
    rsv_status status;
    t->tracer.lights = motion->lights;
    for (int thread = 0; thread < threads; thread++)
        t->scratch[thread].rays = t->scratch[thread].kept_rows = 0;
    RSV_TRY(find_rows(t, motion));
    RSV_TRY(list_escapes(t));
    count_entries(t);
    *patched = (rsv_rows_patched){ .rays = (uint64_t)t->live_rows * t->rays };
    for (int thread = 0; thread < threads; thread++) {
        patched->traced += t->scratch[thread].rays;
        patched->kept_rows += t->scratch[thread].kept_rows;
    }
cleanup:
    return status;
}

// ---- creating them --------------------------------------------------------------------------------

/// The scene's box with a margin for moving objects.
static rsv_trail_frame frame_around(const rsv_scene_view *view)
{
    rsv_vec3 low = view->bounds_min, high = view->bounds_max;
    rsv_vec3 size = v3_sub(high, low);
    float least = 0.1f * v3_length(size);
    rsv_vec3 more = v3(f_max(TRAIL_ROOM * size.x, least), f_max(TRAIL_ROOM * size.y, least),
        f_max(TRAIL_ROOM * size.z, least));
    return (rsv_trail_frame){ v3_sub(low, more), v3_add(high, more) };
}

static rsv_status create_scratch(tracked_rows *t)
{
    rsv_context *context = t->transport.context;
    int threads = rsv_threads(context);
    rsv_status status;
    t->scratch = rsv_alloc(context, (size_t)threads, sizeof *t->scratch);
    RSV_TRY(t->scratch ? RSV_OK : RSV_ERROR_MEMORY);
    for (int thread = 0; thread < threads; thread++) {
        RSV_TRY(rsv_row_scratch_create(context, t->rays, &t->scratch[thread]));
        RSV_TRY(rsv_row_track_create(context, t->rays, &t->scratch[thread].track));
        t->scratch[thread].track->frame = t->frame;
    }
cleanup:
    return status;
}

static rsv_status create_arrays(tracked_rows *t, const rsv_elements *e)
{
    rsv_context *context = e->context;
    size_t rows = e->node_count;
    t->slot = rsv_alloc(context, rows, sizeof *t->slot);
    t->transport.scale = rsv_alloc(context, rows, sizeof *t->transport.scale);
    t->transport.gathered = rsv_alloc(context, rows, sizeof *t->transport.gathered);
    if (!t->slot || !t->transport.scale || !t->transport.gathered) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < rows; n++)
        t->slot[n] = e->node_hanging[n] == RSV_NONE ? (uint32_t)t->slot_count++ : RSV_NONE;
    size_t all = t->slot_count * t->rays;
    t->column = rsv_reserve(context, all, sizeof *t->column);
    t->reach = rsv_reserve(context, all, sizeof *t->reach);
    t->kind = rsv_reserve(context, all, sizeof *t->kind);
    t->count = rsv_alloc(context, t->slot_count, sizeof *t->count);
    t->place = rsv_alloc(context, t->slot_count, sizeof *t->place);
    t->tail = rsv_alloc(context, t->slot_count, sizeof *t->tail);
    t->lost = rsv_alloc(context, t->slot_count, sizeof *t->lost);
    bool complete = t->lost && t->column && t->reach && t->kind && t->count && t->place && t->tail;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Rows of which none is there yet. @param frame NULL = one around the scene
static rsv_status create_empty(
    const rsv_transport_desc *d, const rsv_trail_frame *frame, tracked_rows **rows)
{
    rsv_context *context = d->elements->context;
    rsv_status status;
    if (rsv_team_place_of(context).size > 1 || d->rays > MOST_RAYS)
        return rsv_fail(
            RSV_ERROR_UNSUPPORTED, "light can follow moving objects only in a single process");
    tracked_rows *t = rsv_alloc(context, 1, sizeof *t);
    RSV_TRY(t ? RSV_OK : RSV_ERROR_MEMORY);
    t->transport.table = &tracked_rows_table;
    t->transport.context = context;
    t->transport.row_count = d->elements->node_count;
    t->rays = d->rays;
    t->frame = frame ? *frame : frame_around(d->scene->view);
    t->tracer =
        (rsv_row_tracer){ d->scene, d->lights, d->elements, d->valid_points, .seed = d->seed };
    RSV_TRY(rsv_row_tracer_begin(&t->tracer, d->rays));
    RSV_TRY(rsv_row_cones_create(context, &t->tracer.directions, &t->cones));
    RSV_TRY(create_arrays(t, d->elements));
    RSV_TRY(create_scratch(t));
    *rows = t;
    t = NULL;
cleanup:
    if (t) rsv_transport_destroy(&t->transport);
    return status;
}

rsv_status rsv_tracked_rows_create(const rsv_transport_desc *d, rsv_transport **transport)
{
    tracked_rows *t = NULL;
    rsv_status status;
    RSV_TRY(create_empty(d, NULL, &t));
    RSV_TRY(find_rows(t, NULL));
    RSV_TRY(list_escapes(t));
    count_entries(t);
    for (int thread = 0; thread < rsv_threads(d->elements->context); thread++)
        t->transport.rays += t->scratch[thread].rays;
    *transport = &t->transport;
    t = NULL;
cleanup:
    if (t) rsv_transport_destroy(&t->transport);
    return status;
}

/// Reuses a row whose receiver has not changed. @param node its present index
static void take_row(tracked_rows *t, tracked_rows *then, uint32_t node, const rsv_rows_division *d)
{
    uint32_t before = d->row_before[node], slot = t->slot[node], other = then->slot[before];
    size_t to = (size_t)slot * t->rays, from = (size_t)other * t->rays;
    memcpy(t->kind + to, then->kind + from, t->rays * sizeof *t->kind);
    memcpy(t->reach + to, then->reach + from, t->rays * sizeof *t->reach);
    t->transport.scale[node] = then->transport.scale[before];
    t->transport.gathered[node] = then->transport.gathered[before];
    t->place[slot] = then->place[other];
    t->count[slot] = then->count[other];
    for (uint32_t k = 0; k < t->count[slot]; k++) {
        t->column[to + k] = d->column_now[then->column[from + k]];
        t->lost[slot] |= t->column[to + k] == RSV_NONE;
    }
    t->tail[slot] = then->tail[other];
    then->tail[other] = NULL;
    rsv_row_tail_view v = rsv_row_tail_view_of(t->tail[slot]);
    for (uint32_t k = 0; t->tail[slot] && k < t->tail[slot]->tinted_count; k++) {
        v.tinted_column[k] = d->column_now[v.tinted_column[k]];
        t->lost[slot] |= v.tinted_column[k] == RSV_NONE;
    }
}

typedef struct divide_job {
    tracked_rows *rows, *then;
    const rsv_rows_division *division;
} divide_job;

static void take_rows(void *data, rsv_span span)
{
    const divide_job *job = data;
    tracked_rows *t = job->rows, *then = job->then;
    for (uint32_t node = (uint32_t)span.begin; node < span.end; node++) {
        uint32_t other = job->division->row_before[node];
        if (other != RSV_NONE && t->slot[node] != RSV_NONE && then->slot[other] != RSV_NONE &&
            then->transport.scale[other] > 0)
            take_row(t, then, node, job->division);
    }
}

rsv_status rsv_tracked_rows_divide(rsv_transport *before, const rsv_transport_desc *desc,
    const rsv_rows_division *division, rsv_transport **transport)
{
    tracked_rows *then = rows_of(before), *t = NULL;
    rsv_status status = create_empty(desc, &then->frame, &t);
    if (status != RSV_OK) return status;
    divide_job job = { t, then, division };
    rsv_parallel_for(before->context, t->transport.row_count, 64, take_rows, &job);
    t->transport.rays = before->rays;
    *transport = &t->transport;
    return RSV_OK;
}

// ---- the table ------------------------------------------------------------------------------------

static void destroy(rsv_transport *transport)
{
    tracked_rows *t = rows_of(transport);
    rsv_context *context = transport->context;
    for (int thread = 0; t->scratch && thread < rsv_threads(context); thread++) {
        rsv_row_track_destroy(t->scratch[thread].track);
        rsv_row_scratch_destroy(context, &t->scratch[thread]);
    }
    rsv_free(context, t->scratch);
    for (size_t k = 0; t->tail && k < t->slot_count; k++)
        rsv_free(context, t->tail[k]);
    rsv_row_cones_destroy(&t->cones);
    rsv_row_tracer_end(&t->tracer);
    void *arrays[] = { t->slot, t->column, t->reach, t->kind, t->count, t->place, t->tail,
        t->lost };
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        rsv_free(context, arrays[k]);
}

static rsv_transport_row get_row(const rsv_transport *transport, size_t row)
{
    const tracked_rows *t = rows_of(transport);
    uint32_t slot = t->slot[row];
    if (slot == RSV_NONE || t->count[slot] + (t->tail[slot] != NULL) == 0)
        return (rsv_transport_row){ .count = 0 };
    const rsv_row_tail *tail = t->tail[slot];
    rsv_row_tail_view v = rsv_row_tail_view_of(tail);
    return (rsv_transport_row){ t->column + (size_t)slot * t->rays, v.tinted_column,
        v.tinted_weight, t->count[slot], tail ? tail->tinted_count : 0 };
}

static size_t entries(const rsv_transport *transport) { return rows_of(transport)->entries; }

static size_t bytes(const rsv_transport *transport)
{
    const tracked_rows *t = rows_of(transport);
    size_t ray = sizeof *t->column + sizeof *t->reach + sizeof *t->kind;
    size_t slot = sizeof *t->count + sizeof *t->place + sizeof *t->tail;
    size_t sum = t->live_rows * t->rays * ray + t->slot_count * slot +
                 transport->row_count * sizeof *t->slot; // other rows are never touched
    for (size_t k = 0; k < t->slot_count; k++)
        if (t->tail[k]) sum += sizeof **t->tail + t->tail[k]->capacity;
    return sum;
}

static rsv_status complete(rsv_transport *transport)
{
    (void)transport; // they are all here
    return RSV_OK;
}

static void gather_rows(void *job, rsv_span span)
{
    const rsv_row_product p = *(const rsv_row_product *)job;
    for (size_t k = p.begin + span.begin; k < p.begin + span.end; k++) {
        rsv_transport_row row = get_row(p.transport, k);
        for (size_t f = 0; f < p.fields; f++) {
            rsv_rgb sum = rsv_sum_ends(row.column, row.count, p.exitance + f, p.fields);
            for (size_t i = 0; i < row.tinted_count; i++)
                sum = rgb_add(sum,
                    rgb_mul(row.tinted_weight[i], p.exitance[row.tinted_column[i] * p.fields + f]));
            p.irradiance[k * p.fields + f] = rgb_scale(sum, p.transport->scale[k]);
        }
    }
}

static void gather(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance)
{
    rsv_row_product p = { transport, fields, exitance, begin, irradiance };
    rsv_parallel_for(transport->context, end - begin, 64, gather_rows, &p);
}

static const rsv_transport_table tracked_rows_table = { destroy, get_row, gather,
    rsv_residual_by_rows, complete, entries, bytes };
