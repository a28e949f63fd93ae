#include "../trace/camera_ray.h"
#include "chain_queue.h"
#include "packet_kernels.h"

#include <string.h>

#define TILE_PIXELS (RSV_TILE * RSV_TILE)
/// Blocks in hand at a time: being traced, located and looked up.
#define STAGES 3

/// What one thread works with.
typedef struct worker {
    _Alignas(64) float radiance[TILE_PIXELS][4];
    rsv_ray_packet packet[STAGES]; ///< of the last blocks
    rsv_packet_places places[STAGES];
    uint32_t left[STAGES]; ///< lanes of theirs that are to be followed
    rsv_chain_queue queue;
    double camera_seconds, chain_seconds, display_seconds; ///< of the frame
} worker;

/// One eye's picture.
typedef struct eye_picture {
    float (*sum)[4];     ///< [height * width] radiance of all samples
    uint8_t (*pixel)[4]; ///< [height * width]
    uint32_t samples;    ///< in the sums
    rsv_camera camera;   ///< that they are of
    // of the frame in the making
    rsv_frame_aim aim;
    rsv_frame_tone tone;
    rsv_medium medium; ///< the camera's
    float spread;
} eye_picture;

struct rsv_frame_renderer {
    rsv_context *context;
    const rsv_solution *solution;
    rsv_frame_desc desc;
    const rsv_packet_kernels *kernels;
    rsv_light_table table;
    eye_picture eye[RSV_MAX_EYES];
    worker *worker; ///< [thread_count]
    int thread_count;
    uint32_t tiles_across, tile_count; ///< of one eye
};

rsv_frame_desc rsv_default_frame_desc(void)
{
    return (rsv_frame_desc){ .width = 1280, .height = 720, .eyes = 1, .chain_depth = 8, .seed = 1 };
}

// ---- creation -----------------------------------------------------------------------------------

static rsv_status check_desc(const rsv_frame_desc *desc)
{
    if (desc->width == 0 || desc->height == 0 || desc->width > 16384 || desc->height > 16384)
        return rsv_fail(RSV_ERROR_ARGUMENT, "frames: size %ux%u is not in 1x1 .. 16384x16384",
            desc->width, desc->height);
    if (desc->eyes == 0 || desc->eyes > RSV_MAX_EYES)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "frames: %u eyes are not in 1 .. %d", desc->eyes, RSV_MAX_EYES);
    if (!rsv_has_instructions(desc->instructions))
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "frames: this processor does not have %s",
            rsv_instructions_name(desc->instructions) ? rsv_instructions_name(desc->instructions)
                                                      : "such instructions");
    return RSV_OK;
}

static rsv_status create_eyes(rsv_frame_renderer *r)
{
    size_t pixels = (size_t)r->desc.width * r->desc.height;
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        r->eye[k].sum = rsv_alloc(r->context, pixels, sizeof *r->eye[k].sum);
        r->eye[k].pixel = rsv_alloc(r->context, pixels, sizeof *r->eye[k].pixel);
        if (!r->eye[k].sum || !r->eye[k].pixel) return RSV_ERROR_MEMORY;
    }
    return RSV_OK;
}

static rsv_status create_workers(rsv_frame_renderer *r)
{
    r->thread_count = rsv_threads(r->context);
    r->worker = rsv_alloc(r->context, (size_t)r->thread_count, sizeof *r->worker);
    if (!r->worker) return RSV_ERROR_MEMORY;
    rsv_status status = RSV_OK;
    for (int k = 0; k < r->thread_count && status == RSV_OK; k++) {
        worker *w = &r->worker[k];
        for (int stage = 0; stage < STAGES; stage++)
            memset(w->packet[stage].mask, 0xff, sizeof w->packet[stage].mask);
        status = rsv_chain_queue_create(&r->table, &w->queue);
        w->queue.max_events = r->desc.chain_depth;
        w->queue.radiance = w->radiance;
    }
    return status;
}

rsv_status rsv_frame_renderer_create(
    const rsv_solution *solution, const rsv_frame_desc *desc, rsv_frame_renderer **renderer)
{
    rsv_frame_desc settings = desc ? *desc : rsv_default_frame_desc();
    rsv_status status = check_desc(&settings);
    if (status != RSV_OK) return status;
    rsv_frame_renderer *r = rsv_alloc(solution->context, 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    r->context = solution->context;
    r->solution = solution;
    r->kernels = rsv_packet_kernels_for(&settings.instructions);
    r->desc = settings;
    r->tiles_across = (settings.width + RSV_TILE - 1) / RSV_TILE;
    r->tile_count = r->tiles_across * ((settings.height + RSV_TILE - 1) / RSV_TILE);
    RSV_TRY(create_eyes(r));
    RSV_TRY(rsv_light_table_create(solution, &r->table));
    RSV_TRY(create_workers(r));
    *renderer = r;
    return RSV_OK;
cleanup:
    rsv_frame_renderer_destroy(r);
    return status;
}

void rsv_frame_renderer_destroy(rsv_frame_renderer *r)
{
    if (!r) return;
    for (int k = 0; r->worker && k < r->thread_count; k++)
        rsv_chain_queue_destroy(&r->worker[k].queue);
    rsv_free(r->context, r->worker);
    for (uint32_t k = 0; k < RSV_MAX_EYES; k++) {
        rsv_free(r->context, r->eye[k].sum);
        rsv_free(r->context, r->eye[k].pixel);
    }
    rsv_light_table_destroy(&r->table);
    rsv_free(r->context, r);
}

// ---- one tile -----------------------------------------------------------------------------------

/// A tile of one eye's picture.
typedef struct tile {
    eye_picture *eye;
    uint32_t column, row, width, height; ///< pixels inside the picture
    uint32_t blocks_across;
} tile;

static tile tile_at(rsv_frame_renderer *r, uint32_t index)
{
    uint32_t within = index % r->tile_count;
    tile t = { .eye = &r->eye[index / r->tile_count],
        .column = within % r->tiles_across * RSV_TILE,
        .row = within / r->tiles_across * RSV_TILE };
    t.width = r->desc.width - t.column < RSV_TILE ? r->desc.width - t.column : RSV_TILE;
    t.height = r->desc.height - t.row < RSV_TILE ? r->desc.height - t.row : RSV_TILE;
    t.blocks_across = (t.width + RSV_BLOCK - 1) / RSV_BLOCK;
    return t;
}

/// Starts the chain of a pixel that is not in the table.
/// @param pixel within the tile
static void begin_chain(const rsv_frame_renderer *r, const tile *t, worker *w,
    const rsv_ray_packet *p, uint32_t lane, uint32_t pixel)
{
    rsv_vec3 direction = v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]);
    memset(w->radiance[pixel], 0, sizeof w->radiance[pixel]);
    if (p->triangle[lane] == RSV_NONE) {
        rsv_chain_queue_add_sky(&w->queue, direction, rgb_gray(1), pixel);
        return;
    }
    rsv_chain chain = rsv_chain_begin(&r->solution->scene, &t->eye->medium, direction,
        p->triangle[lane], p->u[lane], p->v[lane], p->t_max[lane]);
    rsv_chain_set_spread(&chain, t->eye->spread, p->t_max[lane]);
    uint32_t row = t->row + pixel / RSV_TILE, column = t->column + pixel % RSV_TILE;
    uint32_t path = rsv_hash2(rsv_pixel_seed(r->desc.seed, row, column), t->eye->samples);
    rsv_chain_queue_add(&w->queue, &chain, path, pixel);
}

/// Starts those of a block.
static void begin_chains(const rsv_frame_renderer *r, const tile *t, worker *w, uint32_t column,
    uint32_t row, uint32_t stage)
{
    for (uint32_t left = w->left[stage]; left; left &= left - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(left);
        uint32_t x = column + lane % RSV_BLOCK, y = row + lane / RSV_BLOCK;
        if (x < t->width && y < t->height)
            begin_chain(r, t, w, &w->packet[stage], lane, y * RSV_TILE + x);
    }
}

static void trace_block(const rsv_frame_renderer *r, const tile *t, worker *w, uint32_t block)
{
    rsv_ray_packet *packet = &w->packet[block % STAGES];
    uint32_t column = block % t->blocks_across * RSV_BLOCK,
             row = block / t->blocks_across * RSV_BLOCK;
    r->kernels->aim(&t->eye->aim, t->column + column, t->row + row, packet);
    rsv_tracer_closest_packet(r->solution->tracer, packet, true);
    r->kernels->approach(&r->table, packet);
}

static void locate_block(const rsv_frame_renderer *r, const tile *t, worker *w, uint32_t block)
{
    uint32_t stage = block % STAGES;
    w->left[stage] = r->kernels->locate(&r->table, &w->packet[stage], &w->places[stage]);
    if (t->eye->medium.depth) w->left[stage] = 0xffff; // seen from within a body: dimmed on the way
}

static void look_up_block(const rsv_frame_renderer *r, const tile *t, worker *w, uint32_t block)
{
    uint32_t stage = block % STAGES;
    uint32_t column = block % t->blocks_across * RSV_BLOCK,
             row = block / t->blocks_across * RSV_BLOCK;
    r->kernels->look_up(&r->table, &w->places[stage], w->radiance + row * RSV_TILE + column);
    if (w->left[stage]) begin_chains(r, t, w, column, row, stage);
}

/// Every block one step behind the one after it.
static void render_blocks(const rsv_frame_renderer *r, const tile *t, worker *w)
{
    uint32_t blocks = t->blocks_across * ((t->height + RSV_BLOCK - 1) / RSV_BLOCK);
    for (uint32_t block = 0; block < blocks + STAGES - 1; block++) {
        if (block < blocks) trace_block(r, t, w, block);
        if (block >= 1 && block - 1 < blocks) locate_block(r, t, w, block - 1);
        if (block >= 2) look_up_block(r, t, w, block - 2);
    }
}

static void display_tile(const rsv_frame_renderer *r, const tile *t, worker *w)
{
    for (uint32_t y = 0; y < t->height; y++) {
        size_t first = (size_t)(t->row + y) * r->desc.width + t->column;
        r->kernels->display(&t->eye->tone, t->width, w->radiance + y * RSV_TILE,
            t->eye->sum + first, t->eye->pixel + first);
    }
}

static void render_tile(rsv_frame_renderer *r, uint32_t index, worker *w)
{
    tile t = tile_at(r, index);
    double start = rsv_seconds();
    render_blocks(r, &t, w);
    double traced = rsv_seconds();
    rsv_chain_queue_run(&w->queue);
    double followed = rsv_seconds();
    display_tile(r, &t, w);
    w->camera_seconds += traced - start;
    w->chain_seconds += followed - traced;
    w->display_seconds += rsv_seconds() - followed;
}

// ---- one frame ----------------------------------------------------------------------------------

static bool same_vector(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_view(const rsv_camera *a, const rsv_camera *b)
{
    return same_vector(a->position, b->position) && same_vector(a->right, b->right) &&
           same_vector(a->up, b->up) && same_vector(a->forward, b->forward) &&
           a->vertical_fov == b->vertical_fov && a->vertical_extent == b->vertical_extent;
}

static void set_aim(const rsv_frame_renderer *r, eye_picture *e)
{
    e->aim = (rsv_frame_aim){ .lens = rsv_lens_of(&e->camera, r->desc.width, r->desc.height),
        .width = r->desc.width,
        .height = r->desc.height };
    rsv_shared_place(e->samples, &e->aim.place_x, &e->aim.place_y);
    e->spread = rsv_camera_spread(&e->camera, r->desc.height) / sqrtf((float)(e->samples + 1));
}

static void begin_eye(
    const rsv_frame_renderer *r, eye_picture *e, const rsv_frame_view *view, uint32_t k)
{
    if (e->samples == 0 || !same_view(&view->camera[k], &e->camera)) {
        e->samples = 0;
        e->camera = view->camera[k];
        e->medium =
            rsv_medium_above(&r->solution->scene.media, e->camera.position, e->camera.forward);
    }
    set_aim(r, e);
    e->tone = (rsv_frame_tone){ .scale = exp2f(view->exposure) / (float)(e->samples + 1),
        .soft = view->soft,
        .first = e->samples == 0 };
}

static void begin_workers(rsv_frame_renderer *r)
{
    for (int k = 0; k < r->thread_count; k++) {
        worker *w = &r->worker[k];
        w->camera_seconds = w->chain_seconds = w->display_seconds = 0;
        w->queue.rays = 0;
    }
}

static void sum_stats(const rsv_frame_renderer *r, double seconds, rsv_frame_stats *stats)
{
    *stats = (rsv_frame_stats){ .total_ms = 1e3 * seconds, .samples = r->eye[0].samples };
    for (int k = 0; k < r->thread_count; k++) {
        const worker *w = &r->worker[k];
        stats->camera_ms += 1e3 * w->camera_seconds / r->thread_count;
        stats->chain_ms += 1e3 * w->chain_seconds / r->thread_count;
        stats->display_ms += 1e3 * w->display_seconds / r->thread_count;
        stats->chain_rays += w->queue.rays;
    }
}

static bool is_finite(rsv_vec3 a) { return isfinite(a.x + a.y + a.z); }

static rsv_status check_view(const rsv_frame_renderer *r, const rsv_frame_view *view)
{
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        const rsv_camera *c = &view->camera[k];
        if (!is_finite(c->position) || !is_finite(c->right) || !is_finite(c->up) ||
            !is_finite(c->forward) || !isfinite(c->vertical_fov + c->vertical_extent))
            return rsv_fail(RSV_ERROR_ARGUMENT, "frames: camera %u is not finite", k);
    }
    if (!(fabsf(view->exposure) <= 64))
        return rsv_fail(RSV_ERROR_ARGUMENT, "frames: an exposure of %g stops is not in -64 .. 64",
            (double)view->exposure);
    return RSV_OK;
}

rsv_status rsv_frame_render(
    rsv_frame_renderer *r, const rsv_frame_view *view, rsv_frame_stats *stats)
{
    rsv_status status = check_view(r, view);
    if (status != RSV_OK) return status;
    double start = rsv_seconds();
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        begin_eye(r, &r->eye[k], view, k);
    begin_workers(r);
    uint32_t tiles = r->tile_count * r->desc.eyes;
#pragma omp parallel for schedule(dynamic, 1) num_threads(r->thread_count)
    for (uint32_t index = 0; index < tiles; index++)
        render_tile(r, index, &r->worker[rsv_thread_index()]);
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        r->eye[k].samples++;
    if (stats) sum_stats(r, rsv_seconds() - start, stats);
    return RSV_OK;
}

double rsv_frame_trace_only(rsv_frame_renderer *r, const rsv_frame_view *view)
{
    double start = rsv_seconds();
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        begin_eye(r, &r->eye[k], view, k);
    uint32_t tiles = r->tile_count * r->desc.eyes;
#pragma omp parallel for schedule(dynamic, 1) num_threads(r->thread_count)
    for (uint32_t index = 0; index < tiles; index++) {
        rsv_ray_packet *packet = r->worker[rsv_thread_index()].packet;
        tile t = tile_at(r, index);
        for (uint32_t row = 0; row < t.height; row += RSV_BLOCK)
            for (uint32_t column = 0; column < t.width; column += RSV_BLOCK) {
                r->kernels->aim(&t.eye->aim, t.column + column, t.row + row, packet);
                rsv_tracer_closest_packet(r->solution->tracer, packet, true);
            }
    }
    return rsv_seconds() - start;
}

static void start_over(rsv_frame_renderer *r)
{
    for (uint32_t k = 0; k < RSV_MAX_EYES; k++)
        r->eye[k].samples = 0;
}

void rsv_frame_renderer_show(rsv_frame_renderer *r, uint32_t layer)
{
    if (layer == r->table.layer) return;
    rsv_light_table_bake(&r->table, layer);
    start_over(r);
}

void rsv_frame_renderer_refresh(rsv_frame_renderer *r)
{
    for (int k = 0; k < r->thread_count; k++)
        rsv_chain_queue_refresh(&r->worker[k].queue);
    rsv_light_table_bake(&r->table, r->table.layer);
    start_over(r);
}

const uint8_t (*rsv_frame_pixels(const rsv_frame_renderer *r, uint32_t eye))[4]
{
    return (const uint8_t(*)[4])r->eye[eye].pixel;
}

void rsv_frame_radiance(const rsv_frame_renderer *r, uint32_t eye, rsv_rgb *radiance)
{
    float scale = 1 / (float)(r->eye[eye].samples ? r->eye[eye].samples : 1);
    size_t pixels = (size_t)r->desc.width * r->desc.height;
    for (size_t k = 0; k < pixels; k++) {
        const float *sum = r->eye[eye].sum[k];
        radiance[k] =
            rgb(f_max(sum[0] * scale, 0), f_max(sum[1] * scale, 0), f_max(sum[2] * scale, 0));
    }
}

rsv_instructions rsv_frame_instructions(const rsv_frame_renderer *r)
{
    return r->desc.instructions;
}

rsv_camera rsv_camera_eye(const rsv_camera *camera, uint32_t eye, float separation)
{
    rsv_camera moved = *camera;
    float side = eye == 0 ? -0.5f : 0.5f;
    moved.position = v3_mad(camera->position, side * separation, camera->right);
    return moved;
}
