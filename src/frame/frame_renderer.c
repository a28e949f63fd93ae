#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../core/stratified.h"
#include "../trace/camera_ray.h"
#include "frame_device.h"
#include "resolvent/measure.h"

#include <string.h>

#define PATTERN 0x7f4a7c15u ///< of samples whose number is known

/// Places within pixels that frames of a moving camera take in turn.
#define HISTORY_PLACES 16

/// Camera rays per triangle that make a hierarchy for beams, and clearances, worthwhile.
#define BEAM_RAYS 64
#define CLEARANCE_RAYS 256

struct rsv_frame_renderer {
    rsv_context *context;
    const rsv_light_view *solution;
    rsv_frame_desc desc;
    rsv_light_table table;
    rsv_glossy_materials materials;
    const rsv_mover *mover; ///< NULL = none
    rsv_fog_shine shine;    ///< of fog; no solution = the air is clear
    rsv_specular_media media;
    rsv_clearances clearances;
    rsv_beams beams;
    rsv_tiling tiling;
    rsv_eye_picture eye[RSV_MAX_EYES];
    rsv_tile_worker *worker; ///< [thread_count]
    int thread_count;
    rsv_frame_device *device; ///< NULL = none
    bool on_device;           ///< the last frame is there
};

void rsv_frame_desc_init(rsv_frame_desc *desc, size_t size)
{
    const rsv_frame_desc defaults = { .size = sizeof defaults,
        .width = 1280,
        .height = 720,
        .eyes = 1,
        .path_depth = 8,
        .seed = 1,
        .gloss = RSV_GLOSS_REUSED };
    rsv_desc_fill(desc, size, &defaults);
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
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "frames: this CPU does not have %s",
            rsv_instructions_name(desc->instructions) ? rsv_instructions_name(desc->instructions)
                                                      : "such instructions");
    return RSV_OK;
}

static rsv_status create_eyes(rsv_frame_renderer *r)
{
    size_t pixels = (size_t)r->desc.width * r->desc.height;
    size_t sums = (size_t)r->tiling.tile_count * RSV_TILE_PIXELS;
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        r->eye[k].sum = rsv_alloc(r->context, sums, sizeof *r->eye[k].sum);
        r->eye[k].pixel = rsv_alloc(r->context, pixels, sizeof *r->eye[k].pixel);
        if (!r->eye[k].sum || !r->eye[k].pixel) return RSV_ERROR_MEMORY;
    }
    return RSV_OK;
}

/// Fog before each eye, where there is any.
static rsv_status create_fog(rsv_frame_renderer *r)
{
    const rsv_fog *fog = r->solution->scene.view->fog;
    rsv_status status = RSV_OK;
    if (!fog) return RSV_OK;
    if (fog->anisotropy != 0)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "fog: frames show fog that scatters evenly, with G = 0, not %g; leave out G",
            (double)fog->anisotropy);
    RSV_TRY(rsv_fog_shine_create(r->solution, &r->shine));
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        RSV_TRY(rsv_fog_front_create(r->context, r->desc.width, r->desc.height, &r->eye[k].fog));
    r->tiling.shine = &r->shine;
cleanup:
    return status;
}

static bool reuses_gloss(const rsv_frame_renderer *r) { return r->table.glossy != NULL; }

static rsv_status create_gloss(rsv_frame_renderer *r)
{
    size_t tiles = r->tiling.tile_count;
    for (uint32_t k = 0; k < r->desc.eyes && reuses_gloss(r); k++) {
        rsv_eye_picture *e = &r->eye[k];
        e->base = rsv_reserve(r->context, tiles * RSV_TILE_PIXELS, sizeof *e->base);
        e->lobes = rsv_reserve(r->context, tiles, sizeof *e->lobes);
        e->glossy = rsv_alloc(r->context, tiles, sizeof *e->glossy);
        if (!e->base || !e->lobes || !e->glossy) return RSV_ERROR_MEMORY;
        rsv_status status =
            rsv_glossy_cells_create(r->context, r->desc.width, r->desc.height, &e->cells);
        if (status == RSV_OK)
            status =
                rsv_frame_history_create(r->context, r->desc.width, r->desc.height, &e->history);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

/// Whether frames at rest become better than those before.
static bool improves_at_rest(const rsv_frame_renderer *r)
{
    bool final = r->desc.rest == RSV_REST_FINAL && !rsv_context_device(r->context);
    return (final || reuses_gloss(r)) && !r->tiling.shine;
}

static rsv_status create_rest(rsv_frame_renderer *r)
{
    size_t tiles = r->tiling.tile_count;
    for (uint32_t k = 0; k < r->desc.eyes && improves_at_rest(r); k++) {
        rsv_eye_picture *e = &r->eye[k];
        e->whole = rsv_reserve(r->context, tiles, sizeof *e->whole);
        e->resting = rsv_reserve(r->context, tiles, sizeof *e->resting);
        e->squares = rsv_reserve(r->context, 2 * tiles + 64, sizeof *e->squares);
        e->given = rsv_reserve(r->context, 2 * tiles + 64, sizeof *e->given);
        if (!e->whole || !e->resting || !e->squares || !e->given) return RSV_ERROR_MEMORY;
    }
    return RSV_OK;
}

static rsv_status create_workers(rsv_frame_renderer *r)
{
    r->thread_count = rsv_threads(r->context);
    r->worker = rsv_alloc(r->context, (size_t)r->thread_count, sizeof *r->worker);
    if (!r->worker) return RSV_ERROR_MEMORY;
    rsv_status status = RSV_OK;
    for (int k = 0; k < r->thread_count && status == RSV_OK; k++)
        status = rsv_tile_worker_create(&r->tiling, r->desc.path_depth, &r->worker[k]);
    return status;
}

static void set_size(rsv_frame_renderer *r, uint32_t width, uint32_t height)
{
    rsv_tiling *t = &r->tiling;
    t->width = width;
    t->height = height;
    t->across = (width + RSV_TILE - 1) / RSV_TILE;
    t->tile_count = t->across * ((height + RSV_TILE - 1) / RSV_TILE);
}

static void set_tiling(rsv_frame_renderer *r)
{
    r->tiling = (rsv_tiling){ .solution = r->solution,
        .table = &r->table,
        .media = &r->media,
        .clearances = &r->clearances,
        .beams = &r->beams,
        .kernels = rsv_packet_kernels_for(&r->desc.instructions),
        .seed = r->desc.seed };
    set_size(r, r->desc.width, r->desc.height);
}

/// Devices shade every pixel by its own path, with a table that does not mark glossy surfaces.
static rsv_status create_table(rsv_frame_renderer *r)
{
    const rsv_light_view *s = r->solution;
    bool reuses = r->desc.gloss == RSV_GLOSS_REUSED && !rsv_context_device(r->context) &&
                  rsv_any_glossy(&s->scene) && !r->tiling.shine;
    if (!reuses) return rsv_light_table_create(s, NULL, &r->table);
    rsv_status status =
        rsv_glossy_materials_create(r->context, &s->scene, s->diffused.material, &r->materials);
    return status == RSV_OK ? rsv_light_table_create(s, &r->materials, &r->table) : status;
}

/// Camera rays per triangle.
static double rays_expected(const rsv_frame_renderer *r)
{
    double pixels = (double)r->desc.width * r->desc.height * r->desc.eyes;
    double triangles = (double)r->solution->scene.view->triangle_count;
    return r->desc.frames > 0 ? r->desc.frames * pixels / fmax(triangles, 1) : INFINITY;
}

/// Creates data that makes rays faster, if there are enough of them.
static rsv_status create_shortcuts(rsv_frame_renderer *r)
{
    double rays = rays_expected(r);
    const rsv_tracer *tracer = r->solution->scene.tracer;
    rsv_status status =
        rsv_clearances_create(r->context, &r->media, rays >= CLEARANCE_RAYS, &r->clearances);
    r->beams = (rsv_beams){ .tracer = tracer };
    return status == RSV_OK && rays >= BEAM_RAYS ? rsv_beams_create(tracer, &r->beams) : status;
}

rsv_status rsv_frame_renderer_create(
    const rsv_light *light, const rsv_frame_desc *desc, rsv_frame_renderer **renderer)
{
    const rsv_light_view *solution = rsv_light_get_view(light);
    rsv_frame_desc settings = rsv_default_frame_desc();
    rsv_status status = RSV_READ_DESC(rsv_frame_desc, &settings, desc);
    if (status == RSV_OK) status = check_desc(&settings);
    if (status != RSV_OK) return status;
    rsv_frame_renderer *r = rsv_alloc(solution->context, 1, sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    r->context = solution->context;
    r->solution = solution;
    r->desc = settings;
    set_tiling(r);
    RSV_TRY(create_eyes(r));
    RSV_TRY(create_fog(r));
    RSV_TRY(create_table(r));
    RSV_TRY(create_gloss(r));
    RSV_TRY(create_rest(r));
    RSV_TRY(rsv_specular_media_create(r->context, &solution->scene, &r->media));
    RSV_TRY(create_shortcuts(r));
    RSV_TRY(create_workers(r));
    if (!r->tiling.shine) RSV_TRY(rsv_frame_device_create(&r->table, &r->desc, &r->device));
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
        rsv_tile_worker_destroy(&r->worker[k]);
    rsv_free(r->context, r->worker);
    for (uint32_t k = 0; k < RSV_MAX_EYES; k++) {
        rsv_free(r->context, r->eye[k].sum);
        rsv_free(r->context, r->eye[k].pixel);
        rsv_free(r->context, r->eye[k].base);
        rsv_free(r->context, r->eye[k].lobes);
        rsv_free(r->context, r->eye[k].glossy);
        rsv_free(r->context, r->eye[k].whole);
        rsv_free(r->context, r->eye[k].resting);
        rsv_free(r->context, r->eye[k].squares);
        rsv_free(r->context, r->eye[k].given);
        rsv_glossy_cells_destroy(&r->eye[k].cells);
        rsv_frame_history_destroy(&r->eye[k].history);
        rsv_fog_front_destroy(r->context, &r->eye[k].fog);
    }
    rsv_fog_shine_destroy(&r->shine);
    rsv_frame_device_destroy(r->device);
    rsv_clearances_destroy(&r->clearances);
    rsv_specular_media_destroy(&r->media);
    rsv_light_table_destroy(&r->table);
    rsv_glossy_materials_destroy(&r->materials);
    rsv_free(r->context, r);
}

// ---- one frame ----------------------------------------------------------------------------------

static bool same_vector(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_view(const rsv_camera *a, const rsv_camera *b)
{
    return same_vector(a->position, b->position) && same_vector(a->right, b->right) &&
           same_vector(a->up, b->up) && same_vector(a->forward, b->forward) &&
           a->vertical_fov == b->vertical_fov && a->vertical_extent == b->vertical_extent;
}

/// If the number of samples is known, they are spread better, each in its own stratum. Reused gloss and devices use one
/// position for all pixels.
static void place_sample(const rsv_frame_renderer *r, uint32_t sample, rsv_frame_aim *aim)
{
    uint32_t count = r->desc.frames;
    rsv_shared_place(sample, &aim->place_x, &aim->place_y);
    if (count < 2 || sample >= count) return;
    rsv_stratified_2d(sample, count, PATTERN, &aim->place_x, &aim->place_y);
    if (reuses_gloss(r) || r->device) return;
    aim->scatter = 1 / (float)count;
    aim->place_x = floorf(aim->place_x * (float)count) * aim->scatter;
    aim->place_y = floorf(aim->place_y * (float)count) * aim->scatter;
    aim->phase[0] = rsv_hash2(sample, PATTERN);
    aim->phase[1] = rsv_hash2(sample, ~PATTERN);
}

static void set_aim(const rsv_frame_renderer *r, rsv_eye_picture *e)
{
    e->aim = (rsv_frame_aim){ .lens = rsv_lens_of(&e->camera, r->tiling.width, r->tiling.height),
        .width = r->tiling.width,
        .height = r->tiling.height };
    e->beam_lens = rsv_beam_lens_of(&e->aim.lens);
    bool follows = e->samples == 0 && e->history.keep > 0;
    place_sample(r, follows ? e->history.frame % HISTORY_PLACES : e->samples, &e->aim);
    e->spread = rsv_camera_spread(&e->camera, r->tiling.height) / sqrtf((float)(e->samples + 1));
}

/// The first frame shows guesses of what rough surfaces reflect where it has traced no rays, and no paths correct them: it
/// does not count in the mean at rest. (Where the number of frames is known, each has a stratum of its own to sample.)
static void drop_first(const rsv_frame_renderer *r, rsv_eye_picture *e)
{
    if (!reuses_gloss(r) || r->device || r->desc.frames > 1) return;
    memset(e->sum, 0, (size_t)r->tiling.tile_count * RSV_TILE_PIXELS * sizeof *e->sum);
    e->dropped = 1;
}

static void begin_eye(
    rsv_frame_renderer *r, rsv_eye_picture *e, const rsv_frame_view *view, uint32_t k)
{
    if (e->samples == 0 || !same_view(&view->camera[k], &e->camera)) {
        e->samples = 0;
        e->camera = view->camera[k];
        e->medium =
            rsv_medium_above(&r->solution->scene.media, e->camera.position, e->camera.forward);
    }
    e->medium_number = rsv_specular_media_of_eye(&r->media, k, &e->medium);
    if (e->samples == 0) e->dropped = 0;
    if (e->samples == 1) drop_first(r, e);
    set_aim(r, e);
    e->tone = (rsv_frame_tone){ .scale = exp2f(view->exposure) / (float)rsv_eye_samples(e),
        .soft = view->soft,
        .first = e->samples == 0 };
}

static void begin_eyes(rsv_frame_renderer *r, const rsv_frame_view *view)
{
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        begin_eye(r, &r->eye[k], view, k);
}

/// Not if only camera rays are traced: the history goes from one displayed frame to the next.
static void begin_cells(rsv_frame_renderer *r)
{
    for (uint32_t k = 0; k < r->desc.eyes && reuses_gloss(r); k++) {
        rsv_eye_picture *e = &r->eye[k];
        rsv_glossy_cells_begin(&e->cells, &e->aim.lens, e->samples > 0);
        rsv_frame_history_begin(
            &e->history, &e->aim.lens, e->samples, e->aim.place_x, e->aim.place_y);
    }
}

typedef struct fog_job {
    const rsv_fog_shine *shine;
    const rsv_eye_picture *eye;
} fog_job;

static void fill_fog_rows(void *user, rsv_span span)
{
    const fog_job *job = user;
    for (size_t row = span.begin; row < span.end; row++)
        rsv_fog_front_fill(&job->eye->fog, job->shine, &job->eye->aim.lens, (uint32_t)row);
}

/// Fog before the eyes.
static void begin_fog(rsv_frame_renderer *r)
{
    if (!r->tiling.shine) return;
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        rsv_eye_picture *e = &r->eye[k];
        fog_job job = { &r->shine, e };
        rsv_fog_front_begin(&e->fog, &r->shine, &e->camera, r->tiling.width, r->tiling.height);
        rsv_parallel_for(r->context, e->fog.down, 1, fill_fog_rows, &job);
    }
}

static void start_over(rsv_frame_renderer *r)
{
    for (uint32_t k = 0; k < RSV_MAX_EYES; k++)
        r->eye[k].samples = 0;
}

static void begin_workers(rsv_frame_renderer *r)
{
    for (int k = 0; k < r->thread_count; k++) {
        rsv_tile_worker *w = &r->worker[k];
        w->camera_seconds = w->path_seconds = w->gloss_seconds = w->display_seconds = 0;
        w->queue.rays = w->rays.rays = w->rays.poor = 0;
    }
}

static void sum_stats(const rsv_frame_renderer *r, double seconds, rsv_frame_stats *stats)
{
    *stats = (rsv_frame_stats){ .total_ms = 1e3 * seconds, .samples = r->eye[0].samples };
    for (int k = 0; k < r->thread_count; k++) {
        const rsv_tile_worker *w = &r->worker[k];
        stats->camera_ms += 1e3 * w->camera_seconds / r->thread_count;
        stats->path_ms += 1e3 * w->path_seconds / r->thread_count;
        stats->display_ms += 1e3 * w->display_seconds / r->thread_count;
        stats->gloss_ms += 1e3 * w->gloss_seconds / r->thread_count;
        stats->path_rays += w->queue.rays;
        stats->gloss_rays += w->rays.rays;
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

typedef void (*tile_work)(const rsv_tiling *, rsv_eye_picture *, uint32_t, rsv_tile_worker *);

typedef struct tile_job {
    rsv_frame_renderer *renderer;
    tile_work work;
} tile_job;

static void work_on_tiles(void *user, rsv_span span)
{
    const tile_job *job = user;
    rsv_frame_renderer *r = job->renderer;
    for (uint32_t k = (uint32_t)span.begin; k < span.end; k++)
        job->work(&r->tiling, &r->eye[k / r->tiling.tile_count], k % r->tiling.tile_count,
            &r->worker[span.worker]);
}

static void for_tiles(rsv_frame_renderer *r, tile_work work)
{
    tile_job job = { r, work };
    rsv_parallel_for(
        r->context, (size_t)r->tiling.tile_count * r->desc.eyes, 1, work_on_tiles, &job);
}

typedef void (*cell_work)(const rsv_glossy_cells *, uint32_t, uint32_t);

typedef struct cell_job {
    rsv_frame_renderer *renderer;
    cell_work work;
} cell_job;

static void work_on_cell_rows(void *user, rsv_span span)
{
    const cell_job *job = user;
    rsv_frame_renderer *r = job->renderer;
    uint32_t height = r->eye[0].cells.height;
    double start = rsv_seconds();
    for (uint32_t k = (uint32_t)span.begin; k < span.end; k++) {
        const rsv_glossy_cells *c = &r->eye[k / height].cells;
        for (uint32_t column = 0; column < c->width; column += RSV_LANES)
            job->work(c, column, k % height);
    }
    r->worker[span.worker].gloss_seconds += rsv_seconds() - start;
}

static void for_cells(rsv_frame_renderer *r, cell_work work)
{
    cell_job job = { r, work };
    size_t rows = (size_t)r->eye[0].cells.height * r->desc.eyes;
    rsv_parallel_for(r->context, rows, 8, work_on_cell_rows, &job);
}

static bool any_glossy(const rsv_frame_renderer *r)
{
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        if (memchr(r->eye[k].glossy, 1, r->tiling.tile_count)) return true;
    return false;
}

/// Lights the rough lobes of all tiles, and shows these.
static void finish_gloss(rsv_frame_renderer *r)
{
    if (!reuses_gloss(r)) return;
    if (any_glossy(r)) {
        for_cells(r, r->tiling.kernels->blend_cells);
        for_cells(r, r->tiling.kernels->smooth_cells);
        for_tiles(r, rsv_tile_finish);
    }
    uint64_t poor = 0;
    for (int k = 0; k < r->thread_count; k++)
        poor += r->worker[k].rays.poor;
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        r->eye[k].cells.keep = 1;
        rsv_glossy_cells_pace(&r->eye[k].cells, poor / r->desc.eyes);
    }
}

/// Displays frames of a moving camera, combined with the history.
static void finish_history(rsv_frame_renderer *r)
{
    if (!reuses_gloss(r)) return;
    if (r->eye[0].history.moves) for_tiles(r, rsv_tile_recall);
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        r->eye[k].history.keep = 1;
}

/// Shares data among tiles at rest.
static void share_rest(rsv_frame_renderer *r)
{
    uint32_t across = r->tiling.across, down = r->tiling.tile_count / across;
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        rsv_eye_picture *e = &r->eye[k];
        if (e->resting && e->samples > 0)
            rsv_resting_share(e->resting, across, down, e->squares, e->given);
    }
}

/// Sums do not move between device and processor: they start over where they change places.
static rsv_status render_eyes(rsv_frame_renderer *r, const rsv_frame_view *view)
{
    bool was_on_device = r->on_device;
    rsv_status status = RSV_OK;
    r->on_device = false;
    if (!r->tiling.mover)
        status =
            rsv_frame_device_render(r->device, r->eye, &r->worker[0].queue.rays, &r->on_device);
    if (status != RSV_OK || r->on_device) return status;
    if (was_on_device) {
        start_over(r);
        begin_eyes(r, view);
    }
    begin_cells(r);
    begin_fog(r);
    for_tiles(r, rsv_tile_render);
    finish_gloss(r);
    finish_history(r);
    share_rest(r);
    return RSV_OK;
}

rsv_status rsv_frame_render(
    rsv_frame_renderer *r, const rsv_frame_view *view, rsv_frame_stats *stats)
{
    rsv_status status = check_view(r, view);
    if (status != RSV_OK) return status;
    double start = rsv_seconds();
    rsv_clearances_refresh(&r->clearances, r->solution->tracer);
    rsv_beams_refresh(&r->beams, r->solution->tracer);
    begin_eyes(r, view);
    begin_workers(r);
    r->tiling.shading = (rsv_glossy_shading){ .view = r->solution->scene.view,
        .materials = r->materials.material,
        .shows_emission = rsv_shows_emission(&r->table) };
    r->tiling.final = r->desc.rest == RSV_REST_FINAL && r->table.layer == RSV_NONE;
    rsv_highlights_of(r->solution->lights, &r->tiling.highlights);
    if (!rsv_shows_emission(&r->table)) r->tiling.highlights.count = 0;
    r->tiling.mover = r->table.layer == RSV_NONE ? r->mover : NULL;
    status = render_eyes(r, view);
    if (status != RSV_OK) return status;
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        r->eye[k].samples++;
    if (stats) sum_stats(r, rsv_seconds() - start, stats);
    return RSV_OK;
}

double rsv_frame_trace_only(rsv_frame_renderer *r, const rsv_frame_view *view)
{
    double start = rsv_seconds();
    begin_eyes(r, view);
    for_tiles(r, rsv_tile_trace_only);
    return rsv_seconds() - start;
}

/// Discards a part of the results of earlier frames, after a change of light.
static void forget(rsv_frame_renderer *r, float change)
{
    for (uint32_t k = 0; k < r->desc.eyes; k++) {
        rsv_glossy_cells_forget(&r->eye[k].cells, change);
        rsv_frame_history_forget(&r->eye[k].history, change);
    }
}

rsv_status rsv_frame_renderer_resize(rsv_frame_renderer *r, uint32_t width, uint32_t height)
{
    if (width == r->tiling.width && height == r->tiling.height) return RSV_OK;
    if (width == 0 || height == 0 || width > r->desc.width || height > r->desc.height)
        return rsv_fail(RSV_ERROR_ARGUMENT, "frames: size %ux%u is not in 1x1 .. %ux%u", width,
            height, r->desc.width, r->desc.height);
    if (r->device)
        return rsv_fail(
            RSV_ERROR_UNSUPPORTED, "frames: those of a device stay as large as they are");
    set_size(r, width, height);
    for (uint32_t k = 0; k < r->desc.eyes && reuses_gloss(r); k++) {
        rsv_glossy_cells_resize(&r->eye[k].cells, width, height);
        rsv_frame_history_resize(&r->eye[k].history, width, height);
    }
    start_over(r);
    return RSV_OK;
}

void rsv_frame_renderer_show(rsv_frame_renderer *r, uint32_t layer)
{
    if (layer == r->table.layer) return;
    forget(r, 1);
    rsv_light_table_bake(&r->table, layer);
    if (r->tiling.shine) rsv_fog_shine_refresh(&r->shine, layer);
    rsv_frame_device_refresh(r->device);
    start_over(r);
}

void rsv_frame_renderer_put(rsv_frame_renderer *r, const rsv_mover *mover)
{
    r->mover = mover;
    for (uint32_t k = 0; k < r->desc.eyes; k++)
        rsv_frame_history_forget(&r->eye[k].history, 1);
    start_over(r);
}

void rsv_frame_renderer_refresh(rsv_frame_renderer *r)
{
    rsv_specular_media_refresh(&r->media);
    for (int k = 0; k < r->thread_count; k++)
        rsv_specular_light_refresh(&r->worker[k].queue.light);
    if (r->table.glossy) rsv_glossy_materials_refresh(&r->materials);
    forget(r, rsv_light_table_bake(&r->table, r->table.layer));
    if (r->tiling.shine) rsv_fog_shine_refresh(&r->shine, r->table.layer);
    rsv_frame_device_refresh(r->device);
    start_over(r);
}

const uint8_t (*rsv_frame_pixels(const rsv_frame_renderer *r, uint32_t eye))[4]
{
    if (r->on_device) rsv_frame_device_pixels(r->device, eye, r->eye[eye].pixel);
    return (const uint8_t(*)[4])r->eye[eye].pixel;
}

static rsv_rgb positive_rgb(const float c[4])
{
    return rgb(f_max(c[0], 0), f_max(c[1], 0), f_max(c[2], 0));
}

/// From the sums of a device, which lie row by row.
static void copy_device_means(const rsv_frame_renderer *r, uint32_t eye, rsv_rgb *radiance)
{
    const rsv_eye_picture *e = &r->eye[eye];
    float scale = 1 / (float)(e->samples ? e->samples : 1);
    rsv_frame_device_sums(r->device, eye, e->sum);
    for (size_t k = 0; k < (size_t)r->desc.width * r->desc.height; k++)
        radiance[k] = rgb_scale(positive_rgb(e->sum[k]), scale);
}

static void copy_tile(
    const rsv_frame_renderer *r, uint32_t tile, const float (*from)[4], rsv_rgb *to)
{
    uint32_t left = tile % r->tiling.across * RSV_TILE, top = tile / r->tiling.across * RSV_TILE;
    for (uint32_t y = 0; y < RSV_TILE && top + y < r->tiling.height; y++)
        for (uint32_t x = 0; x < RSV_TILE && left + x < r->tiling.width; x++)
            to[(size_t)(top + y) * r->tiling.width + left + x] =
                positive_rgb(from[y * RSV_TILE + x]);
}

void rsv_frame_radiance(const rsv_frame_renderer *r, uint32_t eye, rsv_rgb *radiance)
{
    float shown[RSV_TILE_PIXELS][4];
    if (r->on_device) {
        copy_device_means(r, eye, radiance);
        return;
    }
    for (uint32_t tile = 0; tile < r->tiling.tile_count; tile++) {
        rsv_tile_shown(&r->tiling, &r->eye[eye], tile, shown);
        copy_tile(r, tile, (const float(*)[4])shown, radiance);
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
