#include "../sources/partition.h"
#include "../trace/packet.h"
#include "row_tracer_internal.h"
#include "row_track.h"

#include <string.h>

#define LANES RSV_SUPPORT_POINTS

/// So rows of coated surfaces sum to no more than 1 either.
static rsv_rgb scale_of_entry(const rsv_row_tracer *tracer, const rsv_row_receiver *r)
{
    const rsv_directions *d = &tracer->directions;
    const float *cos = d->z + rsv_directions_of(d, tracer->seed, r->index);
    const float rays = (float)d->count, least = 1e-6f;
    rsv_rgb sum = rgb_gray(0);
    if (!rsv_surface_entry_tints(&r->entry, tracer->scene->bsdf)) return rgb_gray(1);
    for (uint32_t k = 0; k < d->count; k++)
        sum = rgb_add(sum, rsv_surface_entry_at(&r->entry, tracer->scene->bsdf, cos[k]));
    return rgb(rays / f_max(sum.r, least), rays / f_max(sum.g, least), rays / f_max(sum.b, least));
}

/// Where the rays of a node leave. @param sample out
static void place_points(const rsv_row_tracer *tracer, const rsv_receiver_draw *draw,
    rsv_support_point sample[LANES], rsv_receiver_points *points)
{
    rsv_receiver_points_choose(tracer->elements, *draw, sample);
    rsv_receiver_points_set_up(tracer->elements, tracer->scene->tracer, *draw, sample, points);
}

void rsv_row_place_points(const rsv_row_tracer *tracer, uint32_t node, rsv_receiver_points *points)
{
    rsv_support_point sample[LANES];
    const rsv_receiver_draw draw = { node, rsv_elements_draw_of(tracer->elements, node),
        tracer->seed, tracer->valid_points[node] };
    place_points(tracer, &draw, sample, points);
}

void rsv_row_receive_as(const rsv_row_tracer *tracer, uint32_t node, uint32_t index, uint16_t valid,
    rsv_row_receiver *r)
{
    const rsv_elements *e = tracer->elements;
    rsv_receiver_points *p = &r->points;
    rsv_support_point sample[LANES];
    const rsv_receiver_draw draw = { node, index, tracer->seed, valid };
    place_points(tracer, &draw, sample, p);
    r->index = index;
    r->valid = valid;
    r->in_air = false;
    r->entry = rsv_elements_entry(e, node, sample, LANES, UINT32_MAX);
    r->entry_scale = scale_of_entry(tracer, r);
    // one of the points speaks for the medium of all
    r->medium =
        rsv_medium_above(&tracer->scene->media, v3(p->origin_x[0], p->origin_y[0], p->origin_z[0]),
            v3(p->geometric_x[0], p->geometric_y[0], p->geometric_z[0]));
    r->tints = rsv_surface_entry_tints(&r->entry, tracer->scene->bsdf) ||
               rsv_medium_absorbs(&r->medium, tracer->scene->bsdf);
}

void rsv_row_receive(const rsv_row_tracer *tracer, uint32_t node, rsv_row_receiver *r)
{
    uint32_t index = rsv_elements_draw_of(tracer->elements, node);
    rsv_row_receive_as(tracer, node, index, tracer->valid_points[node], r);
}

/// Light of gathered sources counts however it arrives; that of the others is the business of
/// next-event estimation and light shooting.
static bool counts_by_gathering(const void *user, uint32_t triangle, uint32_t turns)
{
    return rsv_gathering_counts(user, triangle, turns, true);
}

static bool is_one(rsv_rgb w) { return fabsf(w.r - 1) + fabsf(w.g - 1) + fabsf(w.b - 1) < 1e-4f; }

static void add_tinted(rsv_row_scratch *s, uint32_t ray, uint32_t node, rsv_rgb weight)
{
    if (s->track) s->track->tinted_ray[s->tinted_count] = (uint16_t)ray;
    s->tinted_column[s->tinted_count] = node;
    s->tinted_weight[s->tinted_count++] = weight;
}

void rsv_row_record_node(
    rsv_row_scratch *s, uint32_t ray, uint32_t node, rsv_rgb weight, rsv_rgb entered)
{
    rsv_rgb w = weight;
    uint32_t copies = s->whole ? s->copies[ray] : 1;
    if (!s->whole) w = rgb_mul(w, entered);
    if (copies == 0) return;
    if (!is_one(w)) {
        add_tinted(s, ray, node, rgb_scale(w, (float)copies));
        return;
    }
    s->column[ray] = node;
    for (uint32_t k = 1; k < copies; k++)
        add_tinted(s, ray, node, rgb_gray(1));
}

/// @param entered weight of the light as it enters the receiver
static void record_end(const rsv_row_tracer *tracer, rsv_row_scratch *s, uint32_t ray,
    const rsv_specular_path *path, rsv_rgb entered, float random)
{
    uint32_t face = tracer->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return;
    float weight[3];
    uint32_t cell = rsv_elements_locate(tracer->elements, face, path->u, path->v, weight);
    uint32_t node = rsv_elements_pick_node(tracer->elements, cell, weight, random);
    rsv_row_record_node(s, ray, node, path->weight, entered);
}

void rsv_row_keep_end(rsv_row_scratch *s, uint32_t ray, uint32_t node, uint8_t seen)
{
    uint32_t copies = s->whole ? s->copies[ray] : 1;
    s->kind[ray] = seen & (uint8_t)~RSV_ROW_RAY_ENDS;
    if (copies == 0) return;
    s->column[ray] = node;
    for (uint32_t k = 1; k < copies; k++)
        add_tinted(s, ray, node, rgb_gray(1));
}

rsv_rgb rsv_row_entering(const rsv_row_tracer *tracer, const rsv_row_receiver *r, float cos)
{
    if (r->in_air) return rgb_gray(1);
    rsv_rgb entry = rsv_surface_entry_at(&r->entry, tracer->scene->bsdf, cos);
    return rgb_mul(entry, r->entry_scale);
}

rsv_specular_path rsv_row_begin_path(const rsv_row_tracer *tracer, const rsv_row_receiver *r,
    const rsv_ray_packet *packet, uint32_t k)
{
    rsv_vec3 direction = v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]);
    return rsv_specular_begin(tracer->scene, &r->medium, direction, rsv_packet_hit(packet, k));
}

/// Whether rays that end there may also find light of a source; which sources they look for, any edit may change.
static bool emits(const rsv_row_tracer *tracer, uint32_t triangle)
{
    return tracer->scene->bsdf[tracer->scene->view->triangle_material[triangle]].emissive;
}

/// Notes which ray an escape is of, that was added last.
static void track_escape(rsv_row_scratch *s, uint32_t ray, uint32_t plain_before)
{
    if (!s->track) return;
    if (s->escapes.count > plain_before)
        s->track->bin_ray[plain_before] = (uint16_t)ray;
    else
        s->track->tinted_bin_ray[s->escapes.tinted_count - 1] = (uint16_t)ray;
}

static void add_escape(
    rsv_row_scratch *s, uint32_t ray, rsv_vec3 direction, rsv_rgb weight, uint32_t turns)
{
    uint32_t before = s->escapes.count;
    rsv_escape_row_add(&s->escapes, direction, weight, turns);
    track_escape(s, ray, before);
}

static void add_emission(rsv_row_scratch *s, uint32_t ray, rsv_rgb light)
{
    s->emission = rgb_add(s->emission, light);
    if (!s->track || rgb_is_black(light)) return;
    s->track->light_ray[s->track->light_count] = (uint16_t)ray;
    s->track->light[s->track->light_count++] = light;
}

/// A ray whose specular path is followed.
typedef struct tracked_ray {
    rsv_row_track *track;
    uint32_t ray;
    const rsv_scene_view *scene;
} tracked_ray;

static void track_path(void *user, const rsv_specular_path *path, bool left_scene, rsv_vec3 from)
{
    const tracked_ray *t = user;
    rsv_row_track_visit(t->track, t->ray, t->scene, path, left_scene, from);
}

rsv_emission_wanted rsv_row_emission_wanted(const rsv_row_tracer *tracer)
{
    return (rsv_emission_wanted){ counts_by_gathering, tracer->lights };
}

void rsv_row_record_gather(const rsv_row_tracer *tracer, rsv_row_scratch *s, uint32_t ray,
    const rsv_gather *gather, rsv_rgb entered, float random)
{
    const rsv_specular_path *path = &gather->path;
    add_emission(s, ray, rgb_mul(gather->emission, entered));
    s->rays += path->rays;
    if (gather->end == RSV_SPECULAR_DIFFUSE) {
        record_end(tracer, s, ray, path, entered, random);
        if (path->rays == 0 && !emits(tracer, path->triangle)) s->kind[ray] = RSV_TARGET_ENTERED;
    } else if (gather->end == RSV_SPECULAR_SCATTERED) {
        rsv_row_land(tracer, s, ray, gather, entered);
    } else if (gather->end == RSV_SPECULAR_ESCAPED) {
        add_escape(s, ray, path->direction, rgb_mul(path->weight, entered), path->turns);
    }
}

void rsv_row_follow_path(const rsv_row_tracer *tracer, rsv_row_scratch *s, uint32_t ray,
    const rsv_row_receiver *r, float cos_receiver, rsv_specular_path path)
{
    rsv_random random = rsv_random_from(tracer->seed ^ 0x51ed270bu, r->index, ray);
    const rsv_emission_wanted wanted = rsv_row_emission_wanted(tracer);
    tracked_ray tracked = { s->track, ray, tracer->scene->view };
    const rsv_specular_witness witness = { s->track ? track_path : NULL, &tracked };
    rsv_gather gather = rsv_specular_gather_seen(tracer->scene, path, &random, &wanted, &witness);
    // not ahead of roulette, which could raise the sum of the row
    rsv_rgb entered = rsv_row_entering(tracer, r, cos_receiver);
    rsv_row_record_gather(tracer, s, ray, &gather, entered, rsv_random_float(&random));
}

/// Where sixteen rays ended on the grids of their faces, in arithmetic without branches.
typedef struct grid_places {
    _Alignas(64) float side[LANES], u[LANES], v[LANES];
    _Alignas(64) int32_t index[LANES], corner[LANES];
} grid_places;

static void place_on_grids(grid_places *g, uint32_t stream)
{
    for (int k = 0; k < LANES; k++) {
        float x = g->u[k] * g->side[k], y = g->v[k] * g->side[k];
        int32_t side = (int32_t)g->side[k], j = (int32_t)y, i = (int32_t)x;
        j = j > side - 1 ? side - 1 : j;
        i = i > side - 1 - j ? side - 1 - j : i;
        float fx = x - (float)i, fy = y - (float)j;
        int32_t flipped = (fx + fy > 1) & (i + j < side - 1);
        float b0 = flipped ? fx + fy - 1 : 1 - fx - fy, b1 = flipped ? 1 - fx : fx;
        float random = rsv_unit_float(rsv_hash(stream + (uint32_t)k));
        g->index[k] = rsv_triangle_grid_index(side, i, j, flipped);
        g->corner[k] = (random >= b0) + (random >= b0 + b1);
    }
}

static rsv_ray_target hit_target(const rsv_row_tracer *tracer, const rsv_ray_packet *packet, int k)
{
    uint32_t triangle = packet->triangle[k];
    if (triangle == RSV_NONE)
        return (rsv_ray_target){ .kind = packet->t_max[k] > 0 ? RSV_TARGET_SKY : RSV_TARGET_BLACK };
    bool back = packet->normal_x[k] * packet->direction_x[k] +
                    packet->normal_y[k] * packet->direction_y[k] +
                    packet->normal_z[k] * packet->direction_z[k] >
                0;
    return tracer->target[2 * (size_t)triangle + back];
}

static void record_sky(const rsv_row_tracer *tracer, rsv_row_scratch *s, const rsv_row_receiver *r,
    float cos_receiver, const rsv_ray_packet *packet, uint32_t ray)
{
    uint32_t k = ray % LANES;
    rsv_vec3 direction = v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]);
    add_escape(s, ray, direction, rsv_row_entering(tracer, r, cos_receiver), 0);
}

void rsv_row_process_hits(const rsv_row_tracer *tracer, rsv_row_scratch *s, uint32_t first_ray,
    const rsv_row_receiver *r, const float *cos_receiver, const rsv_ray_packet *packet)
{
    const rsv_elements *e = tracer->elements;
    grid_places g;
    rsv_ray_target target[LANES];
    if (tracer->scene->view->fog) {
        rsv_row_process_in_fog(tracer, s, first_ray, r, cos_receiver, packet);
        return;
    }
    for (int k = 0; k < LANES; k++) {
        target[k] = hit_target(tracer, packet, k);
        g.side[k] = target[k].side;
        bool used = target[k].kind == RSV_TARGET_LAMBERT; // other lanes may hold anything
        g.u[k] = used ? packet->u[k] : 0;
        g.v[k] = used ? packet->v[k] : 0;
    }
    uint32_t stream = rsv_hash2(tracer->seed, r->index) + first_ray;
    place_on_grids(&g, stream);
    for (int k = 0; k < LANES; k++) {
        uint32_t ray = first_ray + (uint32_t)k;
        s->kind[ray] = target[k].kind;
        if (target[k].kind == RSV_TARGET_BLACK) continue;
        if (target[k].kind == RSV_TARGET_SKY) {
            record_sky(tracer, s, r, cos_receiver[k], packet, ray);
            continue;
        }
        if (target[k].kind == RSV_TARGET_SPECULAR || r->tints) {
            s->kind[ray] = RSV_TARGET_SPECULAR;
            rsv_row_follow_path(tracer, s, ray, r, cos_receiver[k],
                rsv_row_begin_path(tracer, r, packet, (uint32_t)k));
            continue;
        }
        uint32_t slot = e->slot[e->face_slot[target[k].face] + (uint32_t)g.index[k]];
        if (slot & RSV_SLOT_SPLIT || rsv_cell_sides(e, slot)) {
            float weight[3], random = rsv_unit_float(rsv_hash(stream + (uint32_t)k));
            uint32_t cell =
                rsv_elements_locate(e, target[k].face, packet->u[k], packet->v[k], weight);
            s->column[ray] = rsv_elements_pick_node(e, cell, weight, random);
        } else {
            s->column[ray] = e->cell_node[slot][g.corner[k]];
        }
    }
}

/// Shares a row's ends out to its rays, as a colourless coat lets them in: each counts not at all, once, or more often,
/// by turns, all together as often as there are rays. So rows stay lists of whole rays, half the size of weighed ones.
static void share_out(const rsv_row_tracer *tracer, const rsv_row_receiver *r, rsv_row_scratch *s)
{
    const rsv_directions *d = &tracer->directions;
    const float *cos = d->z + rsv_directions_of(d, tracer->seed, r->index);
    double sum = (double)rsv_unit_float(rsv_hash3(tracer->seed, r->index, 0x6c0au));
    uint32_t left = d->count;
    s->whole = !r->in_air && rsv_surface_entry_tints(&r->entry, tracer->scene->bsdf);
    for (uint32_t k = 0; k < d->count && s->whole; k++) {
        rsv_rgb w = rsv_row_entering(tracer, r, cos[k]);
        double before = floor(sum);
        sum += (double)w.g;
        uint32_t copies = (uint32_t)(floor(sum) - before);
        if (copies > left) copies = left;
        left -= copies;
        s->copies[k] = (uint8_t)copies;
        s->whole = fabsf(w.r - w.g) + fabsf(w.b - w.g) < 1e-4f && copies <= UINT8_MAX;
    }
}

static void clear_scratch(rsv_row_scratch *s)
{
    s->tinted_count = 0;
    s->escapes.count = s->escapes.tinted_count = 0;
    s->emission = s->flights = rgb_gray(0);
    if (s->track) rsv_row_track_clear(s->track);
}

rsv_ray_packet rsv_row_begin(
    const rsv_row_tracer *tracer, const rsv_row_receiver *r, rsv_row_scratch *s)
{
    s->index = r->index;
    s->valid = r->valid;
    memset(s->column, 0xff, tracer->directions.count * sizeof *s->column);
    clear_scratch(s);
    share_out(tracer, r, s);
    rsv_ray_packet packet = { 0 };
    memset(packet.mask, 0xff, sizeof packet.mask);
    return packet;
}

const float *rsv_row_aim(
    const rsv_row_tracer *tracer, const rsv_row_receiver *r, uint32_t first, rsv_ray_packet *packet)
{
    const rsv_directions *d = &tracer->directions;
    size_t at = rsv_directions_of(d, tracer->seed, r->index) + first;
    rsv_receiver_points_aim(&r->points, d->x + at, d->y + at, d->z + at, packet);
    return d->z + at;
}

void rsv_row_trace_from(const rsv_row_tracer *tracer, const rsv_row_receiver *r, rsv_row_scratch *s)
{
    uint32_t rays = tracer->directions.count;
    rsv_ray_packet packet = rsv_row_begin(tracer, r, s);
    for (uint32_t first = 0; first < rays; first += LANES) {
        const float *z = rsv_row_aim(tracer, r, first, &packet);
        rsv_tracer_closest_packet(tracer->scene->tracer, &packet, false);
        for (uint32_t k = 0; k < LANES && s->track; k++)
            s->track->reach[first + k] = rsv_reach_of(packet.t_max[k]);
        rsv_row_process_hits(tracer, s, first, r, z, &packet);
    }
    rsv_row_balance_flights(tracer, s);
    s->rays += rays;
}

void rsv_row_trace(const rsv_row_tracer *tracer, uint32_t node, rsv_row_scratch *s)
{
    rsv_row_receiver r;
    if (node >= rsv_elements_surface_nodes(tracer->elements)) {
        rsv_row_trace_voxel(tracer, node, s);
        return;
    }
    rsv_row_receive(tracer, node, &r);
    rsv_row_trace_from(tracer, &r, s);
}

void rsv_row_finish(const rsv_row_tracer *tracer, const rsv_row_receiver *r,
    const rsv_row_ends *ends, rsv_row_scratch *s)
{
    memcpy(s->column, ends->column, tracer->directions.count * sizeof *s->column);
    s->valid = r->valid;
    clear_scratch(s);
    share_out(tracer, r, s);
    rsv_ray_packet packet = { 0 };
    for (size_t n = 0; n < ends->left_count; n++) {
        uint32_t ray = ends->left[n], k = ray % LANES;
        const float *z = rsv_row_aim(tracer, r, ray - k, &packet);
        packet.triangle[k] = ends->hit[n].triangle;
        packet.u[k] = ends->hit[n].u;
        packet.v[k] = ends->hit[n].v;
        packet.t_max[k] = ends->hit[n].t;
        if (packet.triangle[k] == RSV_NONE)
            record_sky(tracer, s, r, z[k], &packet, ray);
        else
            rsv_row_follow_path(tracer, s, ray, r, z[k], rsv_row_begin_path(tracer, r, &packet, k));
    }
    s->rays += tracer->directions.count;
}

rsv_status rsv_row_scratch_create(rsv_context *context, uint32_t rays, rsv_row_scratch *s)
{
    s->column = rsv_alloc(context, rays, sizeof *s->column);
    s->kind = rsv_alloc(context, rays, sizeof *s->kind);
    s->copies = rsv_alloc(context, rays, sizeof *s->copies);
    s->tinted_column = rsv_alloc(context, rays, sizeof *s->tinted_column);
    s->tinted_weight = rsv_alloc(context, rays, sizeof *s->tinted_weight);
    bool complete = s->column && s->kind && s->copies && s->tinted_column && s->tinted_weight;
    return complete ? rsv_escape_row_create(context, rays, &s->escapes) : RSV_ERROR_MEMORY;
}

void rsv_row_scratch_destroy(rsv_context *context, rsv_row_scratch *s)
{
    rsv_free(context, s->column);
    rsv_free(context, s->kind);
    rsv_free(context, s->copies);
    rsv_free(context, s->tinted_column);
    rsv_free(context, s->tinted_weight);
    rsv_escape_row_destroy(context, &s->escapes);
}

static rsv_status create_targets(rsv_row_tracer *tracer)
{
    const rsv_scene_view *view = tracer->scene->view;
    const rsv_elements *e = tracer->elements;
    tracer->target = rsv_alloc(e->context, 2 * view->triangle_count, sizeof *tracer->target);
    if (!tracer->target) return RSV_ERROR_MEMORY;
    for (size_t side = 0; side < 2 * view->triangle_count; side++) {
        const rsv_bsdf *bsdf = &tracer->scene->bsdf[view->triangle_material[side / 2]];
        uint32_t face = e->face_of[side & 1][side / 2];
        bool back = side & 1, opaque_back = back && !bsdf->double_sided &&
                                            bsdf->transmission == 0 && bsdf->opacity == 1;
        bool plain =
            bsdf->lambert && bsdf->opacity == 1 && face != RSV_NONE &&
            (!bsdf->emissive || !counts_by_gathering(tracer->lights, (uint32_t)(side / 2), 0));
        tracer->target[side].kind = opaque_back ? RSV_TARGET_BLACK
                                    : plain     ? RSV_TARGET_LAMBERT
                                                : RSV_TARGET_SPECULAR;
        if (face == RSV_NONE) continue;
        tracer->target[side].face = face;
        tracer->target[side].side = (uint16_t)(1u << e->face_level[face]);
    }
    return RSV_OK;
}

rsv_status rsv_row_tracer_begin(rsv_row_tracer *tracer, uint32_t rays)
{
    rsv_status status =
        rsv_directions_create(tracer->elements->context, rays, tracer->seed, &tracer->directions);
    return status == RSV_OK ? create_targets(tracer) : status;
}

void rsv_row_tracer_end(rsv_row_tracer *tracer)
{
    rsv_free(tracer->elements->context, tracer->target);
    rsv_directions_destroy(&tracer->directions);
}
