#include "frame_tile.h"

#include "final_path.h"

#include <string.h>

rsv_status rsv_tile_worker_create(const rsv_tiling *tiling, uint32_t path_depth, rsv_tile_worker *w)
{
    for (int stage = 0; stage < RSV_STAGES; stage++)
        memset(w->packet[stage].mask, 0xff, sizeof w->packet[stage].mask);
    rsv_status status = rsv_specular_queue_create(
        tiling->table, tiling->kernels, tiling->media, tiling->clearances, &w->queue);
    rsv_glossy_rays_create(tiling->kernels, tiling->table, &w->rays);
    w->queue.light.max_events = path_depth;
    w->queue.light.radiance = w->radiance;
    return status;
}

void rsv_tile_worker_destroy(rsv_tile_worker *w) { rsv_specular_queue_destroy(&w->queue); }

/// A tile in the hands of a worker.
typedef struct tile {
    const rsv_tiling *tiling;
    rsv_eye_picture *eye;
    rsv_tile_worker *worker;
    float (*sum)[4];                     ///< [RSV_TILE_PIXELS]
    uint32_t column, row, width, height; ///< pixels inside the picture
    uint32_t blocks_across, block_count;
    const rsv_beam *beam; ///< NULL = packets go through the ray tracer
} tile;

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static tile tile_at(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t index, rsv_tile_worker *worker)
{
    tile t = { .tiling = tiling,
        .eye = eye,
        .worker = worker,
        .sum = eye->sum + (size_t)index * RSV_TILE_PIXELS,
        .column = index % tiling->across * RSV_TILE,
        .row = index / tiling->across * RSV_TILE };
    t.width = smaller(tiling->width - t.column, RSV_TILE);
    t.height = smaller(tiling->height - t.row, RSV_TILE);
    t.blocks_across = (t.width + RSV_BLOCK - 1) / RSV_BLOCK;
    t.block_count = t.blocks_across * ((t.height + RSV_BLOCK - 1) / RSV_BLOCK);
    return t;
}

/// Names the sample of a pixel. @param pixel within the tile
static uint32_t path_of(const tile *t, uint32_t pixel)
{
    uint32_t row = t->row + pixel / RSV_TILE, column = t->column + pixel % RSV_TILE;
    return rsv_hash2(rsv_pixel_seed(t->tiling->seed, row, column), t->eye->samples);
}

/// Pixel within the tile that a lane of a block belongs to.
static uint32_t pixel_of(uint32_t column, uint32_t row, uint32_t lane)
{
    return (row + lane / RSV_BLOCK) * RSV_TILE + column + lane % RSV_BLOCK;
}

/// Starts the specular paths of a block's pixels that are not in the table.
static void begin_paths(const tile *t, uint32_t column, uint32_t row, uint32_t stage)
{
    rsv_tile_worker *w = t->worker;
    const rsv_ray_packet *p = &w->packet[stage];
    rsv_specular_lanes *c = &w->paths;
    uint32_t lanes = 0;
    float ior = rsv_medium_ior(&t->eye->medium, t->tiling->solution->bsdf);
    for (uint32_t k = 0; k < RSV_LANES; k++) {
        uint32_t x = column + k % RSV_BLOCK, y = row + k / RSV_BLOCK;
        bool begins = w->begins[stage] >> k & 1 && x < t->width && y < t->height;
        rsv_set_lane_color(c->weight, k, rgb_gray(1));
        c->start_ior[k] = ior;
        c->width[k] = 0;
        c->events[k] = 0;
        c->medium[k] = t->eye->medium_number;
        c->settled[k] = 0;
        if (!begins) continue;
        lanes |= 1u << k;
        c->pixel[k] = pixel_of(column, row, k);
        c->trail[k] = path_of(t, c->pixel[k]);
        memset(w->radiance[c->pixel[k]], 0, sizeof *w->radiance);
        w->carried[c->pixel[k]] = 0;
    }
    const rsv_arrival arrival = { p, &w->places[stage], w->left[stage], c };
    rsv_specular_queue_arrive(&w->queue, &arrival, lanes);
}

/// In fog, paths are followed one by one, because the queue supports only clear air.
static void follow_in_fog(const tile *t, uint32_t column, uint32_t row, uint32_t stage)
{
    rsv_tile_worker *w = t->worker;
    rsv_specular_light *light = &w->queue.light;
    const rsv_ray_packet *p = &w->packet[stage];
    for (uint32_t k = 0; k < RSV_LANES; k++) {
        uint32_t x = column + k % RSV_BLOCK, y = row + k / RSV_BLOCK;
        light->pixel = pixel_of(column, row, k);
        w->depth[light->pixel] = p->triangle[k] == RSV_NONE ? INFINITY : p->t_max[k];
        if (!(w->begins[stage] >> k & 1) || x >= t->width || y >= t->height) continue;
        memset(w->radiance[light->pixel], 0, sizeof *w->radiance);
        rsv_vec3 direction = v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]);
        if (p->triangle[k] == RSV_NONE) {
            rsv_add_sky(light, direction, rgb_gray(1));
            continue;
        }
        rsv_specular_path path =
            rsv_specular_begin(light->scene, &t->eye->medium, direction, rsv_packet_hit(p, k));
        rsv_specular_set_spread(&path, t->eye->spread, p->t_max[k]);
        light->trail = path_of(t, light->pixel);
        path.length = 0; // the fog up to there is added last
        rsv_add_whole_path(light, &path);
    }
}

/// Adds the fog in front of the pixels.
static void add_fog(const tile *t)
{
    rsv_tile_worker *w = t->worker;
    const rsv_frame_aim *aim = &t->eye->aim;
    if (!t->tiling->shine || t->eye->medium.depth) return;
    for (uint32_t y = 0; y < t->height; y++)
        for (uint32_t x = 0; x < t->width; x++) {
            const float place[2] = { (float)(t->column + x) + aim->place_x,
                (float)(t->row + y) + aim->place_y };
            uint32_t pixel = y * RSV_TILE + x;
            rsv_fog_front_add(
                &t->eye->fog, t->tiling->shine, place, w->depth[pixel], w->radiance[pixel]);
        }
}

/// Draws the object in front of a block, and its shadow.
static void show_mover(const tile *t, uint32_t column, uint32_t row, uint32_t stage)
{
    rsv_tile_worker *w = t->worker;
    const rsv_ray_packet *p = &w->packet[stage];
    uint32_t met = rsv_mover_meet(t->tiling->mover, p, &w->body);
    for (uint32_t lane = 0; lane < RSV_PACKET_WIDTH; lane++) {
        uint32_t pixel = pixel_of(column, row, lane);
        float *radiance = w->radiance[pixel];
        rsv_rgb shown = rgb(radiance[0], radiance[1], radiance[2]);
        if (met >> lane & 1) w->gloss.depth[pixel] = 0;
        if (met >> lane & 1) w->depth[pixel] = w->body.t_max[lane];
        if (met >> lane & 1)
            shown = rgb_mul(rsv_mover_shown(t->tiling->mover, &w->body, lane),
                rsv_medium_transmittance(
                    &t->eye->medium, t->tiling->solution->bsdf, w->body.t_max[lane]));
        else if (!(w->begins[stage] >> lane & 1) && p->triangle[lane] != RSV_NONE &&
                 rsv_mover_may_shade(t->tiling->mover, rsv_packet_point(p, lane)))
            shown = rsv_shade_stored(
                t->tiling->table, t->tiling->mover, p, lane, path_of(t, pixel), shown);
        radiance[0] = shown.r, radiance[1] = shown.g, radiance[2] = shown.b;
    }
    w->begins[stage] &= ~met;
}

/// Finds the triangles that all rays of the tile may hit, unless there are too many.
static void gather_beam(tile *t)
{
    const rsv_tiling *tiling = t->tiling;
    const rsv_frame_aim *aim = &t->eye->aim;
    if (!tiling->beams->hold || !t->eye->beam_lens.usable) return;
    float low[2] = { (float)t->column + aim->place_x, (float)t->row + aim->place_y };
    float high[2] = { low[0] + (float)(t->width - 1) + aim->scatter,
        low[1] + (float)(t->height - 1) + aim->scatter };
    rsv_beam *beam = &t->worker->beam;
    if (tiling->kernels->gather(tiling->beams, &t->eye->beam_lens, low, high, beam)) t->beam = beam;
}

static void trace_block(const tile *t, uint32_t block)
{
    const rsv_tiling *tiling = t->tiling;
    rsv_ray_packet *packet = &t->worker->packet[block % RSV_STAGES];
    uint32_t column = block % t->blocks_across * RSV_BLOCK,
             row = block / t->blocks_across * RSV_BLOCK;
    tiling->kernels->aim(&t->eye->aim, t->column + column, t->row + row, packet);
    if (t->beam)
        tiling->kernels->meet(t->beam, packet);
    else
        rsv_tracer_closest_packet(tiling->solution->tracer, packet, true);
}

/// Of the lanes that are not in the table, those that see the sky through clear air.
static uint32_t lanes_of_sky(const tile *t, uint32_t stage)
{
    const rsv_tile_worker *w = t->worker;
    bool clear = t->eye->medium.depth == 0 && !t->tiling->shine;
    uint32_t sky = 0;
    if (!clear || !w->queue.light.sky.pixel || !rsv_shows_emission(t->tiling->table)) return 0;
    for (uint32_t k = 0; k < RSV_LANES; k++)
        sky |= (uint32_t)(w->packet[stage].triangle[k] == RSV_NONE) << k;
    return sky & w->left[stage];
}

static void locate_block(const tile *t, uint32_t block)
{
    rsv_tile_worker *w = t->worker;
    uint32_t stage = block % RSV_STAGES;
    w->left[stage] =
        t->tiling->kernels->locate(t->tiling->table, &w->packet[stage], &w->places[stage]);
    rsv_prefetch_triangles(t->tiling->solution->scene.view, &w->packet[stage], w->left[stage]);
    // seen from within a body, all is dimmed on the way
    bool dimmed = t->eye->medium.depth > 0;
    w->glossy[stage] =
        dimmed ? 0 : rsv_glossy_lanes(t->tiling->table, &w->packet[stage], w->left[stage]);
    w->sky[stage] = lanes_of_sky(t, stage);
    w->begins[stage] = dimmed ? 0xffff : w->left[stage] & ~w->glossy[stage] & ~w->sky[stage];
}

/// Widths of pixels where a packet's rays ended, metres. @param width [RSV_LANES] out
static void find_widths(const tile *t, const rsv_ray_packet *p, float *width)
{
    for (int k = 0; k < RSV_LANES; k++)
        width[k] = t->eye->spread * p->t_max[k];
}

static void descend_block(const tile *t, uint32_t block)
{
    rsv_tile_worker *w = t->worker;
    uint32_t stage = block % RSV_STAGES;
    t->tiling->kernels->descend(t->tiling->table, &w->places[stage]);
    rsv_prefetch_corners(t->tiling->solution->scene.view, &w->packet[stage], w->left[stage]);
    if (!w->glossy[stage]) return;
    float width[RSV_LANES];
    find_widths(t, &w->packet[stage], width);
    t->tiling->kernels->find_ahead(
        &t->tiling->shading, &w->packet[stage], width, w->glossy[stage], &w->ahead[stage]);
}

/// Shows a lane's pixel once more, by a path that is followed to all its ends.
static void follow_whole(const tile *t, uint32_t pixel, uint32_t stage, uint32_t lane)
{
    rsv_tile_worker *w = t->worker;
    rsv_specular_light *light = &w->queue.light;
    const rsv_ray_packet *p = &w->packet[stage];
    rsv_specular_path path = rsv_specular_begin(light->scene, &t->eye->medium,
        v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]),
        rsv_packet_hit(p, lane));
    path.back = rsv_packet_meets_back(p, lane);
    rsv_specular_set_spread(&path, t->eye->spread, p->t_max[lane]);
    rsv_resting_paths *whole = w->whole;
    whole->pixel[whole->count] = (uint16_t)pixel;
    memset(whole->radiance[whole->count], 0, sizeof whole->radiance[0]);
    light->radiance = whole->radiance;
    light->pixel = whole->count++;
    light->trail = path_of(t, pixel);
    if (t->tiling->final)
        rsv_add_final_path(light, &path);
    else
        rsv_add_whole_path(light, &path);
    light->radiance = w->radiance;
}

/// At rest, some pixels of a block take whole paths, if the table does not have all of their light.
static void rest_block(const tile *t, uint32_t column, uint32_t row, uint32_t stage)
{
    rsv_tile_worker *w = t->worker;
    uint32_t block = row / RSV_BLOCK * (RSV_TILE / RSV_BLOCK) + column / RSV_BLOCK;
    uint32_t seed = rsv_pixel_seed(t->tiling->seed, t->row + row, t->column + column);
    bool all = t->tiling->final || t->eye->medium.depth > 0;
    uint32_t open = all ? 0xffff : w->left[stage];
    for (int k = 0; k < RSV_PACKET_WIDTH; k++)
        if (w->packet[stage].triangle[k] == RSV_NONE) open &= ~(1u << k);
    w->whole->open[block] = (uint16_t)open;
    for (uint32_t left = rsv_resting_turns(w->resting, block); left > 0; left--) {
        uint32_t lane = rsv_resting_lane(w->resting, block, seed);
        uint32_t x = column + lane % RSV_BLOCK, y = row + lane / RSV_BLOCK;
        if ((open >> lane & 1) && x < t->width && y < t->height)
            follow_whole(t, y * RSV_TILE + x, stage, lane);
    }
}

/// Records the distances of a block's hits.
static void note_depths(const rsv_ray_packet *p, float *depth)
{
    for (int k = 0; k < RSV_PACKET_WIDTH; k++)
        depth[k / RSV_BLOCK * RSV_TILE + k % RSV_BLOCK] = f_min(p->t_max[k], RSV_HISTORY_FAR);
}

static bool has_history(const tile *t) { return t->eye->history.context != NULL; }

/// Whether rsv_tile_recall is to show the tile: until then, its samples lie where their sum will.
static bool waits_for_history(const tile *t) { return has_history(t) && t->eye->history.moves; }

static void look_up_block(const tile *t, uint32_t block)
{
    rsv_tile_worker *w = t->worker;
    uint32_t stage = block % RSV_STAGES;
    uint32_t column = block % t->blocks_across * RSV_BLOCK,
             row = block / t->blocks_across * RSV_BLOCK;
    uint32_t first = row * RSV_TILE + column;
    t->tiling->kernels->look_up(t->tiling->table, &w->places[stage], w->radiance + first);
    if (w->glossy[stage]) {
        float width[RSV_LANES];
        find_widths(t, &w->packet[stage], width);
        w->begins[stage] |= t->tiling->kernels->shade_glossy(&t->tiling->shading, &w->packet[stage],
            width, w->glossy[stage], w->radiance + first,
            (rsv_glossy_block){ &w->gloss, first, &w->ahead[stage] });
    }
    if (w->sky[stage])
        t->tiling->kernels->show_sky(
            &w->queue.light.sky, &w->packet[stage], w->sky[stage], w->radiance + first);
    if (has_history(t)) note_depths(&w->packet[stage], w->depth + first);
    if (t->tiling->mover) show_mover(t, column, row, stage);
    if (t->tiling->shine)
        follow_in_fog(t, column, row, stage);
    else if (w->begins[stage])
        begin_paths(t, column, row, stage);
    if (w->whole) rest_block(t, column, row, stage);
}

/// Every block one step behind the one after it.
static void render_blocks(const tile *t)
{
    for (uint32_t block = 0; block < t->block_count + RSV_STAGES - 1; block++) {
        if (block < t->block_count) {
            trace_block(t, block);
            t->tiling->kernels->approach(t->tiling->table, &t->worker->packet[block % RSV_STAGES]);
        }
        if (block >= 1 && block - 1 < t->block_count) locate_block(t, block - 1);
        if (block >= 2 && block - 2 < t->block_count) descend_block(t, block - 2);
        if (block >= 3) look_up_block(t, block - 3);
    }
}

/// First of a row's pixels in the picture.
static uint8_t (*shown_row(const tile *t, uint32_t row))[4]
{
    return t->eye->pixel + (size_t)(t->row + row) * t->tiling->width + t->column;
}

/// Prefetches memory that display will write: rows of a picture are far apart.
static void approach_pixels(const tile *t)
{
    for (uint32_t y = 0; y < t->height; y++) {
        const uint8_t *row = shown_row(t, y)[0];
        __builtin_prefetch(row, 1);
        __builtin_prefetch(row + 4 * t->width - 1, 1);
    }
}

static void begin_gloss(rsv_glossy_tile *g)
{
    memset(g->depth, 0, sizeof g->depth);
    g->count = 0;
}

/// A row of a tile as it was shown.
static float (*history_row(const rsv_frame_history *h, uint32_t column, uint32_t row))[4]
{
    return h->shown + rsv_history_place(h, column, row);
}

/// Mean of the samples of a tile, corrected by whole paths.
static void find_mean(const rsv_eye_picture *eye, uint32_t index, float (*radiance)[4])
{
    const float(*sum)[4] = (const float(*)[4])eye->sum + (size_t)index * RSV_TILE_PIXELS;
    float scale = 1 / (float)(eye->samples > eye->dropped ? eye->samples - eye->dropped : 1);
    for (uint32_t k = 0; k < RSV_TILE_PIXELS; k++)
        for (int c = 0; c < 4; c++)
            radiance[k][c] = sum[k][c] * scale;
    if (eye->resting && eye->samples > 1) rsv_resting_correct(&eye->resting[index], radiance);
}

void rsv_tile_shown(
    const rsv_tiling *tiling, const rsv_eye_picture *eye, uint32_t index, float (*radiance)[4])
{
    const rsv_frame_history *h = &eye->history;
    uint32_t column = index % tiling->across * RSV_TILE, row = index / tiling->across * RSV_TILE;
    if (!h->context) {
        find_mean(eye, index, radiance);
        return;
    }
    for (uint32_t y = 0; y < smaller(h->height - row, RSV_TILE); y++)
        memcpy(
            radiance + y * RSV_TILE, history_row(h, column, row + y), RSV_TILE * sizeof *radiance);
}

static void add_to_sum(const tile *t)
{
    for (uint32_t k = 0; k < RSV_TILE_PIXELS; k++)
        for (int c = 0; c < 4; c++)
            t->sum[k][c] += t->worker->radiance[k][c];
}

/// A row at rest takes the place of the history bit by bit. @param radiance [RSV_TILE] in and out
static void leave_history(const tile *t, uint32_t line, float (*radiance)[4])
{
    const float(*old)[4] =
        (const float(*)[4])history_row(&t->eye->history, t->column, t->row + line);
    uint32_t samples = t->eye->samples + 1;
    for (uint32_t k = 0; k < t->width; k++) {
        float share = rsv_history_share_at_rest(old[k][3], samples);
        for (int c = 0; c < 3 && share < 1; c++)
            radiance[k][c] = old[k][c] + share * (radiance[k][c] - old[k][c]);
        radiance[k][3] = samples < RSV_HISTORY_SETTLED ? old[k][3] : RSV_HISTORY_FRAMES;
    }
}

/// Displays a tile at rest, corrected by whole paths so far.
static void display_resting(const tile *t, uint32_t index)
{
    rsv_tile_worker *w = t->worker;
    _Alignas(64) float ignored[RSV_TILE][4];
    rsv_frame_tone tone = t->eye->tone;
    rsv_resting_add(&t->eye->resting[index], &t->eye->whole[index], (const float(*)[4])w->radiance);
    add_to_sum(t);
    for (uint32_t k = 0; k < RSV_TILE_PIXELS; k++)
        for (int c = 0; c < 4; c++)
            w->radiance[k][c] = t->sum[k][c] / (float)rsv_eye_samples(t->eye);
    rsv_resting_update(&t->eye->resting[index], w->radiance);
    tone.scale *= (float)rsv_eye_samples(t->eye);
    tone.first = true;
    for (uint32_t y = 0; y < t->height; y++) {
        float(*radiance)[4] = w->radiance + y * RSV_TILE;
        if (has_history(t)) leave_history(t, y, radiance);
        t->tiling->kernels->display(&tone, radiance,
            has_history(t) ? history_row(&t->eye->history, t->column, t->row + y) : ignored,
            t->width, shown_row(t, y));
    }
}

static void display(const tile *t, uint32_t index)
{
    if (t->eye->resting && t->eye->samples > 0) {
        display_resting(t, index);
        return;
    }
    for (uint32_t y = 0; y < t->height; y++)
        t->tiling->kernels->display(&t->eye->tone, t->worker->radiance + y * RSV_TILE,
            t->sum + y * RSV_TILE, t->width, shown_row(t, y));
}

/// Whole paths begin with the second frame at rest. None are sent where an object moves.
static void begin_whole(const tile *t, uint32_t index)
{
    rsv_eye_picture *eye = t->eye;
    t->worker->whole = NULL;
    if (!eye->resting || eye->samples == 0) return;
    t->worker->resting = &eye->resting[index];
    if (eye->samples == 1) rsv_resting_begin(t->worker->resting, rsv_hash2(t->tiling->seed, index));
    memset(&eye->whole[index], 0, sizeof eye->whole[index]);
    if (!t->tiling->mover) t->worker->whole = &eye->whole[index];
}

/// Leaves the light and distances of the pixels to rsv_tile_recall.
static void leave_samples(const tile *t)
{
    const rsv_frame_history *h = &t->eye->history;
    memcpy(t->sum, t->worker->radiance, sizeof t->worker->radiance);
    for (uint32_t y = 0; y < t->height; y++)
        memcpy(h->depth + rsv_history_place(h, t->column, t->row + y),
            t->worker->depth + y * RSV_TILE, RSV_TILE * sizeof *h->depth);
}

static rsv_glossy_task task_of(const tile *t)
{
    return (rsv_glossy_task){ &t->eye->cells, &t->eye->aim, &t->tiling->highlights, t->eye->spread,
        t->tiling->seed, t->eye->samples == 0 };
}

/// Adds the highlights of punctual lights that cells do not have.
static void show_highlights(const tile *t)
{
    rsv_tile_worker *w = t->worker;
    const rsv_glossy_task task = task_of(t);
    if (t->eye->lobes)
        rsv_show_highlights(&w->rays, &task, &w->gloss, t->column, t->row, w->radiance);
}

/// Leaves the lobes of a tile to be lit, with the other light. @return whether there are any
static bool leave_gloss(const tile *t, uint32_t index)
{
    rsv_tile_worker *w = t->worker;
    rsv_eye_picture *eye = t->eye;
    const rsv_glossy_task task = task_of(t);
    rsv_glossy_rays_of_tile(&w->rays, &task, &w->gloss, t->column, t->row);
    eye->glossy[index] = w->gloss.count > 0;
    if (!eye->glossy[index]) return false;
    t->tiling->kernels->pack_pixels(&w->gloss, &eye->lobes[index]);
    if (!waits_for_history(t))
        memcpy(eye->base + (size_t)index * RSV_TILE_PIXELS, w->radiance, sizeof w->radiance);
    return true;
}

void rsv_tile_render(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t index, rsv_tile_worker *w)
{
    tile t = tile_at(tiling, eye, index, w);
    double start = rsv_seconds();
    approach_pixels(&t);
    gather_beam(&t);
    w->queue.light.mover = tiling->mover;
    w->queue.light.shine = tiling->shine;
    w->queue.light.gloss = tiling->table->glossy ? &w->gloss : NULL;
    w->queue.light.eye = eye->camera.position;
    w->queue.light.forward = eye->camera.forward;
    w->queue.light.parallel = eye->camera.vertical_fov == 0;
    w->queue.shading = &tiling->shading;
    bool recalled = waits_for_history(&t);
    w->queue.light.depth = recalled ? w->depth : NULL;
    w->queue.light.carried = w->carried;
    if (w->queue.light.gloss) begin_gloss(&w->gloss);
    w->queue.spread = eye->spread;
    begin_whole(&t, index);
    render_blocks(&t);
    double traced = rsv_seconds();
    rsv_specular_queue_run(&w->queue);
    add_fog(&t);
    double followed = rsv_seconds();
    show_highlights(&t);
    if (recalled) leave_samples(&t);
    bool waits = eye->lobes && leave_gloss(&t, index);
    double left = rsv_seconds();
    if (!waits && !recalled) display(&t, index);
    w->camera_seconds += traced - start;
    w->path_seconds += followed - traced;
    w->gloss_seconds += left - followed;
    w->display_seconds += rsv_seconds() - left;
}

void rsv_tile_finish(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t index, rsv_tile_worker *w)
{
    if (!eye->glossy[index]) return;
    tile t = tile_at(tiling, eye, index, w);
    double start = rsv_seconds();
    const rsv_glossy_cells *cells = &eye->cells;
    approach_pixels(&t);
    bool recalled = waits_for_history(&t);
    float(*radiance)[4] = recalled ? t.sum : w->radiance;
    if (!recalled)
        memcpy(radiance, eye->base + (size_t)index * RSV_TILE_PIXELS, sizeof w->radiance);
    for (uint32_t y = 0; y < t.height; y++) {
        size_t cell = cells->first + (size_t)((t.row + y) / 2) * cells->stride + t.column / 2;
        for (uint32_t x = 0; x < t.width; x += RSV_LANES)
            tiling->kernels->light_pixels(cells, &eye->lobes[index], x, y, cell + x / 2, radiance);
    }
    double lit = rsv_seconds();
    if (!recalled) display(&t, index);
    w->gloss_seconds += lit - start;
    w->display_seconds += rsv_seconds() - lit;
}

/// A pixel of the picture, or the nearest one, in the sums of tiles.
static const float *sample_at(const tile *t, int column, int row)
{
    const rsv_tiling *tiling = t->tiling;
    column = column < 0 ? 0 : column;
    row = row < 0 ? 0 : row;
    return t->eye->sum[rsv_tile_place(tiling, smaller((uint32_t)column, tiling->width - 1),
        smaller((uint32_t)row, tiling->height - 1))];
}

static float depth_at(const tile *t, int column, int row)
{
    const rsv_frame_history *h = &t->eye->history;
    column = column < 0 ? 0 : column;
    row = row < 0 ? 0 : row;
    return h->depth[rsv_history_place(
        h, smaller((uint32_t)column, h->width - 1), smaller((uint32_t)row, h->height - 1))];
}

/// Brings together this frame's samples of a tile and around it.
static void fill_window(const tile *t, rsv_history_window *w)
{
    for (int y = 0; y < RSV_TILE + 2; y++) {
        int row = (int)t->row + y - 1, column = (int)t->column - 1;
        bool whole = t->width == RSV_TILE && y >= 1 && y <= (int)t->height;
        if (whole) {
            memcpy(w->now[y][1], t->sum + (y - 1) * RSV_TILE, RSV_TILE * sizeof *w->now[y]);
            memcpy(w->depth[y] + 1,
                &t->eye->history
                     .depth[rsv_history_place(&t->eye->history, t->column, (uint32_t)row)],
                RSV_TILE * sizeof *w->depth[y]);
        }
        for (int x = 0; x < RSV_TILE + 2; x += whole ? RSV_TILE + 1 : 1) {
            memcpy(w->now[y][x], sample_at(t, column + x, row), sizeof w->now[y][x]);
            w->depth[y][x] = depth_at(t, column + x, row);
        }
    }
}

void rsv_tile_recall(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t index, rsv_tile_worker *w)
{
    tile t = tile_at(tiling, eye, index, w);
    double start = rsv_seconds();
    approach_pixels(&t);
    fill_window(&t, &w->window);
    for (uint32_t y = 0; y < t.height; y++) {
        uint32_t row = t.row + y;
        tiling->kernels->recall(&eye->history, &w->window, t.column, row, y, w->radiance);
        tiling->kernels->display(&eye->tone, w->radiance, history_row(&eye->history, t.column, row),
            t.width, shown_row(&t, y));
    }
    w->display_seconds += rsv_seconds() - start;
}

void rsv_tile_trace_only(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t index, rsv_tile_worker *w)
{
    tile t = tile_at(tiling, eye, index, w);
    for (uint32_t block = 0; block < t.block_count; block++)
        trace_block(&t, block);
}
