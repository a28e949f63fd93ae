#include "source_level_internal.h"

#include "../core/parallel.h"
#include "../elements/burial.h"
#include "../elements/contact.h"
#include "../elements/curvature.h"
#include "../elements/elements.h"
#include "../elements/open_corners.h"
#include "../update/kept_light.h"
#include "../update/update.h"
#include "direct_constants.h"

#include <string.h>

/// Nodes of a level, and the known values of the level that it refines.
typedef struct node_job {
    rsv_level_builder *b;
    const rsv_earlier_level *earlier;
    uint8_t *skip; ///< [node_count] out, of skip_broken()
} node_job;

/// Reuses values of nodes whose surroundings did not change.
static void carry_over(void *data, rsv_span span)
{
    const node_job *job = data;
    rsv_level_builder *b = job->b;
    const rsv_earlier_level *earlier = job->earlier;
    const rsv_elements *e = b->elements;
    for (size_t n = span.begin; n < span.end; n++) {
        uint32_t twin = rsv_elements_find_twin(e, (uint32_t)n, earlier->elements);
        if (twin == RSV_NONE || earlier->elements->node_hanging[twin] != RSV_NONE ||
            e->node_hanging[n] != RSV_NONE)
            continue;
        b->known[n] = 1;
        b->valid_points[n] = earlier->valid_points[twin];
        if (!b->direct) continue;
        b->lit[n] = 1;
        b->direct[n] = earlier->direct[twin];
        b->deviation[n] = earlier->deviation[twin];
        if (!b->first_look) continue;
        b->first_look[n] = earlier->first_look[twin];
        e->node_draw[n] = rsv_elements_draw_of(earlier->elements, twin);
    }
}

rsv_rgb *rsv_level_create_first_look(const rsv_elements *e)
{
    rsv_rgb *look = rsv_reserve(e->context, e->node_count, sizeof *look);
    for (size_t n = 0; look && n < e->node_count; n++)
        look[n] = rgb_gray(-1);
    return look;
}

/// Nodes that stay are to look at the same points as before.
static rsv_status allocate_looks(rsv_level_builder *b)
{
    rsv_elements *e = b->elements;
    b->first_look = rsv_level_create_first_look(e);
    if (!e->node_draw) e->node_draw = rsv_reserve(e->context, e->node_count, sizeof *e->node_draw);
    if (!b->first_look || !e->node_draw) return RSV_ERROR_MEMORY;
    for (uint32_t n = 0; n < e->node_count; n++)
        e->node_draw[n] = n;
    return RSV_OK;
}

static rsv_status allocate_fields(rsv_level_builder *b, bool looks)
{
    rsv_context *context = b->coarse->context;
    size_t nodes = b->elements->node_count;
    b->valid_points = rsv_alloc(context, nodes, sizeof *b->valid_points);
    b->known = rsv_alloc(context, nodes, sizeof *b->known);
    b->lit = rsv_alloc(context, nodes, sizeof *b->lit);
    if (!b->valid_points || !b->known || !b->lit) return RSV_ERROR_MEMORY;
    if (!b->desc->direct) return RSV_OK;
    if (looks && allocate_looks(b) != RSV_OK) return RSV_ERROR_MEMORY;
    b->direct = rsv_alloc(context, nodes, sizeof *b->direct);
    b->deviation = rsv_alloc(context, nodes, sizeof *b->deviation);
    return b->direct && b->deviation ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Elements ready to receive: walls kept apart, buried corners bridged.
/// @param earlier NULL = nothing is known yet
rsv_status rsv_level_prepare(rsv_level_builder *b, const rsv_earlier_level *earlier)
{
    rsv_elements *e = b->elements;
    rsv_status status;
    RSV_TRY(rsv_elements_find_open_corners(
        b->scene, earlier ? earlier->elements : b->coarse, e, b->rays));
    RSV_TRY(rsv_elements_separate(b->scene, earlier ? earlier->elements : NULL, e, b->rays));
    RSV_TRY(allocate_fields(b, earlier && earlier->first_look));
    node_job job = { b, earlier, NULL };
    if (earlier) rsv_parallel_for(e->context, e->node_count, 0, carry_over, &job);
    const rsv_kept_light_fields fields = { b->direct, b->deviation, b->valid_points,
        RSV_LEVEL_POINTS, b->known, b->lit };
    if (b->kept)
        RSV_TRY(rsv_kept_light_nodes(b->kept, e, &fields, b->complete ? &b->kept_count : NULL));
    RSV_TRY(rsv_find_buried(b->scene, e, (rsv_support_draw){ RSV_LEVEL_POINTS, b->desc->seed },
        b->known, b->valid_points, b->rays));
    RSV_TRY(rsv_elements_bridge_buried(e, b->valid_points));
cleanup:
    return status;
}

/// Estimates direct light at the nodes that `known` does not cover. (How many samples a node gets must not
/// depend on its own samples: stopping early where all of them see the light would be biased.)
rsv_status rsv_level_estimate(rsv_level_builder *b, uint32_t samples, const uint8_t *known)
{
    const rsv_direct_job job = { .scene = b->scene,
        .elements = b->elements,
        .setting = { b->lights, b->scene->bsdf, RSV_LEVEL_POINTS, b->desc->seed },
        .samples = samples,
        .valid_points = b->valid_points };
    rsv_direct_light light = { b->direct, b->deviation, 0 };
    rsv_status status = rsv_direct_irradiance(&job, known, &light);
    *b->rays += light.rays;
    rsv_mark_buried(b->elements, b->valid_points, b->deviation);
    return status;
}

/// Whether the shadow rays from each corner of the cell that a fresh node lies in all met the same: no shadow ends
/// there.
static bool is_unbroken(const rsv_elements *e, uint32_t node, const rsv_earlier_level *earlier)
{
    uint32_t face;
    float u, v, weight[3];
    rsv_elements_place_node(e, node, &face, &u, &v);
    uint32_t cell = rsv_elements_locate(earlier->elements, face, u, v, weight);
    const uint32_t *corner = earlier->elements->cell_node[cell];
    return earlier->deviation[corner[0]] + earlier->deviation[corner[1]] +
               earlier->deviation[corner[2]] ==
           0;
}

/// Of the fresh nodes, those where shadows may end are left for later.
static void skip_broken(void *data, rsv_span span)
{
    const node_job *job = data;
    const rsv_level_builder *b = job->b;
    for (size_t n = span.begin; n < span.end; n++)
        job->skip[n] = b->lit[n] || !is_unbroken(b->elements, (uint32_t)n, job->earlier);
}

/// Estimates direct light at fresh nodes, with more samples where shadows may end.
rsv_status rsv_level_estimate_fresh(rsv_level_builder *b, const rsv_earlier_level *earlier)
{
    const rsv_elements *e = b->elements;
    uint32_t samples = b->desc->light_samples;
    rsv_status status;
    uint8_t *skip = rsv_alloc(e->context, e->node_count, 1);
    if (!skip) return RSV_ERROR_MEMORY;
    node_job job = { b, earlier, skip };
    rsv_parallel_for(e->context, e->node_count, 0, skip_broken, &job);
    RSV_TRY(rsv_level_estimate(b, samples, skip));
    for (size_t n = 0; n < e->node_count; n++)
        skip[n] = b->lit[n] || !skip[n];
    RSV_TRY(rsv_level_estimate(b, RSV_PENUMBRA_FACTOR * samples, skip));
cleanup:
    rsv_free(e->context, skip);
    return status;
}

void rsv_level_free_photons(rsv_level_builder *b)
{
    rsv_photon_map_destroy(&b->map[0]);
    rsv_photon_map_destroy(&b->map[1]);
    rsv_free(b->coarse->context, b->caustic);
    b->caustic = NULL;
}

rsv_status rsv_level_shoot(rsv_level_builder *b, uint32_t count)
{
    rsv_level_free_photons(b);
    b->caustic = rsv_alloc(b->coarse->context, b->elements->node_count, sizeof *b->caustic);
    if (!b->caustic) return RSV_ERROR_MEMORY;
    const rsv_elements *elements[2] = { b->elements, b->coarse };
    const rsv_photon_targets targets = { elements, b->map, 2 };
    rsv_status status =
        b->log ? rsv_photon_log_deposit(b->log, b->scene, b->lights, b->met, &targets, b->rays)
               : rsv_photons_deposit(b->shooter, count, &targets, b->rays);
    if (status == RSV_OK) rsv_photon_map_irradiance(&b->map[0], b->caustic);
    return status;
}

static bool caught_enough(const rsv_level_builder *b, uint32_t cell)
{
    const uint32_t *node = b->elements->cell_node[cell];
    for (int k = 0; k < 3; k++)
        if ((float)b->map[0].hits[node[k]] / 65536.0f >= PHOTONS_TO_SPLIT) return true;
    return false;
}

static void mark_direct(void *user, uint32_t cell, uint32_t other, float bend)
{
    rsv_level_builder *b = user;
    (void)bend;
    b->split[cell] = b->split[other] = 1;
}

static void mark_caustic(void *user, uint32_t cell, uint32_t other, float bend)
{
    rsv_level_builder *b = user;
    (void)bend;
    b->split[cell] |= caught_enough(b, cell);
    b->split[other] |= caught_enough(b, other);
}

static float cell_size(const rsv_elements *e, size_t cell)
{
    return sqrtf(2 * rsv_cell_area(e, (uint32_t)cell));
}

/// Whether a cell has the size that splitting a cell of the coarse spacing at every level leads to: meshes that are
/// finer from the start need no more.
static bool is_finest(const rsv_level_builder *b, size_t cell)
{
    uint32_t levels = b->desc->levels + (b->caustic ? CAUSTIC_LEVELS : 0);
    return cell_size(b->elements, cell) * (float)(4u << levels) <= b->elements->spacing;
}

/// Rounds of splits that bring the largest cells, out in the open, to the size of the others.
static uint32_t rounds_in_the_open(const rsv_elements *e)
{
    float largest = 0;
    for (size_t c = 0; c < e->cell_count; c++)
        largest = f_max(largest, cell_size(e, c));
    return (uint32_t)f_max(ceilf(log2f(f_max(largest / e->spacing, 1e-6f))), 0);
}

/// Whether direct light may split a cell in this round: after the last common one, those still larger than the others.
static bool is_in_turn(const rsv_level_builder *b, size_t cell, uint32_t round)
{
    const rsv_elements *e = b->elements;
    return round < b->desc->levels ||
           cell_size(e, cell) * (float)(1u << b->desc->levels) > OPEN_TOLERANCE * e->spacing;
}

/// Whether a cell lies in one that is not worth splitting, or whose splits are known.
static bool is_left_alone(const rsv_level_builder *b, uint32_t cell)
{
    const uint8_t *hidden = b->desc->hidden;
    const rsv_cell *c = &b->elements->cell[cell];
    if (hidden && hidden[rsv_elements_find_around(b->coarse, c)]) return true;
    return b->kept && !rsv_kept_light_is_changed(b->kept, c);
}

/// Whether a cell of a level that goes on has been split as often as a level that begins would split it.
static bool is_split_enough(const rsv_level_builder *b, size_t cell)
{
    const rsv_cell *c = &b->elements->cell[cell];
    if (!b->desc->start) return false;
    const rsv_cell *around = &b->coarse->cell[rsv_elements_find_around(b->coarse, c)];
    if (c->level <= around->level) return false; // coarse elements were divided since
    uint32_t depth = (uint32_t)c->level - around->level;
    if (b->caustic) return depth >= b->desc->levels + CAUSTIC_LEVELS;
    return !is_in_turn(b, cell, depth - 1);
}

bool rsv_level_may_split(const rsv_level_builder *b, uint32_t cell)
{
    return b->elements->cell[cell].level < RSV_MAX_LEVEL && !is_finest(b, cell) &&
           !is_split_enough(b, cell);
}

/// Marks the cells on both sides of every edge across which light bends; counts them.
rsv_status rsv_level_mark_cells(rsv_level_builder *b, uint32_t round, size_t *marked)
{
    const rsv_elements *e = b->elements;
    rsv_status status = RSV_OK;
    float dark = b->direct ? DARK * (float)rsv_elements_mean_luminance(e, b->direct) : 0;
    if (b->direct) {
        const rsv_curvature_field direct = { b->direct, b->deviation, BEND, dark, b->asked };
        RSV_TRY(rsv_find_curved_edges(e, &direct, RSV_CURVED_EDGES, mark_direct, b));
    }
    if (b->caustic) {
        float faint = f_max(dark, (float)rsv_elements_mean_luminance(e, b->caustic));
        const rsv_curvature_field caustic = { b->caustic, NULL, BEND, faint, b->asked };
        RSV_TRY(rsv_find_curved_edges(e, &caustic, RSV_CURVED_EDGES, mark_caustic, b));
    }
    *marked = 0;
    for (size_t c = 0; c < e->cell_count; c++) {
        if (!rsv_level_may_split(b, (uint32_t)c) || (b->direct && !is_in_turn(b, c, round)) ||
            (b->split[c] && is_left_alone(b, (uint32_t)c)))
            b->split[c] = 0;
        *marked += b->split[c];
    }
cleanup:
    return status;
}

/// Takes the fields from the builder, which starts again.
rsv_earlier_level rsv_level_set_aside(rsv_level_builder *b)
{
    rsv_earlier_level earlier = { b->elements, b->direct, b->deviation, b->valid_points,
        b->first_look };
    rsv_free(b->coarse->context, b->known);
    rsv_free(b->coarse->context, b->lit);
    b->elements = NULL;
    b->direct = NULL;
    b->deviation = NULL;
    b->valid_points = NULL;
    b->first_look = NULL;
    b->known = b->lit = NULL;
    return earlier;
}

void rsv_level_free_earlier(rsv_level_builder *b, rsv_earlier_level *earlier)
{
    rsv_context *context = b->coarse->context;
    rsv_free(context, earlier->direct);
    rsv_free(context, earlier->deviation);
    rsv_free(context, earlier->valid_points);
    rsv_free(context, earlier->first_look);
    rsv_elements_destroy(earlier->elements);
}

/// Replaces the elements by finer ones and updates direct light on them.
static rsv_status split_once(rsv_level_builder *b)
{
    rsv_status status;
    rsv_earlier_level earlier = rsv_level_set_aside(b);
    RSV_TRY(rsv_elements_refine(earlier.elements, b->split, &b->elements));
    RSV_TRY(rsv_level_prepare(b, &earlier));
    if (b->desc->direct) RSV_TRY(rsv_level_estimate_fresh(b, &earlier));
cleanup:
    rsv_level_free_earlier(b, &earlier);
    return status;
}

/// Adds the splits from before the scene was edited, and the light there: those of the rest have been found again.
static rsv_status add_kept(rsv_level_builder *b)
{
    rsv_status status;
    rsv_earlier_level earlier = rsv_level_set_aside(b);
    b->complete = true;
    RSV_TRY(rsv_kept_light_splits(b->kept, b->desc->max_cells, earlier.elements, &b->elements));
    RSV_TRY(rsv_level_prepare(b, &earlier));
    // nodes where both meet; shadows may end there
    RSV_TRY(rsv_level_estimate(b, RSV_PENUMBRA_FACTOR * b->desc->light_samples, b->lit));
cleanup:
    rsv_level_free_earlier(b, &earlier);
    return status;
}

/// Cells at most: in the rounds that only cells in the open need, no more than closed scenes have where light bends
/// everywhere.
static size_t most_cells(const rsv_level_builder *b, uint32_t round)
{
    bool common = round < b->desc->levels || b->desc->photon_count > 0;
    size_t all_split = b->coarse->cell_count << (2 * (b->desc->levels + 1));
    return common || b->desc->max_cells < all_split ? b->desc->max_cells : all_split;
}

static rsv_status refine(rsv_level_builder *b)
{
    rsv_context *context = b->coarse->context;
    rsv_status status = RSV_OK;
    uint32_t rounds = b->desc->levels +
                      (b->desc->photon_count ? CAUSTIC_LEVELS : rounds_in_the_open(b->elements));
    for (uint32_t round = 0; round < rounds; round++) {
        rsv_progress_part(context, "level", round + 1);
        if (b->desc->photon_count) RSV_TRY(rsv_level_shoot(b, b->desc->photon_count / 8));
        rsv_free(context, b->split);
        b->split = rsv_alloc(context, b->elements->cell_count, 1);
        RSV_TRY(b->split ? RSV_OK : RSV_ERROR_MEMORY);
        size_t marked;
        RSV_TRY(rsv_level_mark_cells(b, round, &marked));
        if (marked == 0 || b->elements->cell_count + 3 * marked > most_cells(b, round)) break;
        RSV_TRY(split_once(b));
    }
    rsv_progress_part(context, NULL, 0);
    if (b->desc->photon_count && !b->desc->start)
        RSV_TRY(rsv_level_shoot(b, b->desc->photon_count));
    if (b->desc->start) rsv_level_free_photons(b); // they are of the elements before the last split
cleanup:
    rsv_progress_part(context, NULL, 0);
    return status;
}

/// Whether a cell of the coarse elements may be split before shadows are looked for.
static bool may_begin_finer(const rsv_level_builder *b, size_t cell)
{
    const uint8_t *hidden = b->desc->hidden;
    return cell_size(b->coarse, cell) > 0.25f * b->coarse->spacing && !(hidden && hidden[cell]) &&
           (!b->kept || b->kept->changed[cell]);
}

static bool is_lit(const rsv_level_builder *b, size_t cell)
{
    const uint32_t *node = b->elements->cell_node[cell];
    return !(rgb_is_black(b->direct[node[0]]) && rgb_is_black(b->direct[node[1]]) &&
             rgb_is_black(b->direct[node[2]]));
}

/// The first elements, split once for direct light, except where they will be kept unsplit. For a goal, which needs as
/// few elements as possible, only those that a first pass finds lit are split.
static rsv_status begin(rsv_level_builder *b)
{
    const rsv_elements *coarse = b->coarse;
    const rsv_history *history = rsv_history_of(b->scene);
    const rsv_level_before *before = rsv_level_before_of(b->scene);
    bool looks_first = b->desc->direct && b->desc->hidden;
    rsv_status status;
    if ((history || before) && b->desc->direct && !b->desc->hidden)
        RSV_TRY(rsv_kept_light_create(history, before, coarse, &b->kept));
    b->split = rsv_alloc(coarse->context, coarse->cell_count, 1);
    if (!b->split) return RSV_ERROR_MEMORY;
    for (size_t c = 0; b->desc->direct && !looks_first && c < coarse->cell_count; c++)
        b->split[c] = may_begin_finer(b, c);
    RSV_TRY(rsv_elements_refine(coarse, b->split, &b->elements));
    RSV_TRY(rsv_level_prepare(b, NULL));
    if (b->desc->direct) RSV_TRY(rsv_level_estimate(b, b->desc->light_samples, b->lit));
    if (!looks_first) goto cleanup;
    for (size_t c = 0; c < coarse->cell_count; c++)
        b->split[c] = may_begin_finer(b, c) && is_lit(b, c);
    RSV_TRY(split_once(b));
cleanup:
    return status;
}

/// Elements that a level had.
static rsv_status begin_again(rsv_level_builder *b)
{
    const rsv_elements *start = b->desc->start;
    rsv_status status;
    b->split = rsv_alloc(start->context, start->cell_count, 1);
    if (!b->split) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_elements_refine(start, b->split, &b->elements));
    RSV_TRY(rsv_level_prepare(b, NULL));
    if (b->desc->direct) RSV_TRY(rsv_level_estimate(b, b->desc->light_samples, b->lit));
cleanup:
    return status;
}

/// Caustics of the last photons, on the level and on the coarse elements.
static rsv_status finish_caustics(rsv_level_builder *b, rsv_source_level *level)
{
    rsv_context *context = b->coarse->context;
    level->coarse_caustic =
        rsv_alloc(context, b->coarse->node_count, sizeof *level->coarse_caustic);
    if (!level->coarse_caustic) return RSV_ERROR_MEMORY;
    rsv_photon_map_irradiance(&b->map[1], level->coarse_caustic);
    return rsv_photon_map_shrink(&b->map[0], &b->map[1], level->coarse_caustic, b->caustic);
}

rsv_status rsv_level_hand_over(rsv_level_builder *b, rsv_source_level *level)
{
    rsv_status status = b->caustic ? finish_caustics(b, level) : RSV_OK;
    if (status != RSV_OK) return status;
    level->elements = b->elements;
    level->direct = b->direct;
    level->caustic = b->caustic;
    level->deviation = b->deviation;
    level->valid_points = b->valid_points;
    level->first_look = b->first_look;
    level->kept = b->kept_count;
    level->built_cells = b->elements->cell_count;
    b->elements = NULL;
    b->direct = b->caustic = NULL;
    b->deviation = NULL;
    b->valid_points = NULL;
    b->first_look = NULL;
    return RSV_OK;
}

void rsv_level_end(rsv_level_builder *b)
{
    rsv_context *context = b->coarse->context;
    rsv_free(context, b->split);
    rsv_free(context, b->direct);
    rsv_free(context, b->deviation);
    rsv_free(context, b->valid_points);
    rsv_free(context, b->first_look);
    rsv_free(context, b->known);
    rsv_free(context, b->lit);
    rsv_kept_light_destroy(b->kept);
    rsv_level_free_photons(b);
    rsv_photon_shooter_destroy(b->shooter);
    rsv_elements_destroy(b->elements);
}

rsv_status rsv_source_level_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *coarse, const rsv_source_level_desc *desc, rsv_source_level *level,
    uint64_t *rays)
{
    rsv_status status;
    rsv_level_builder b = {
        .scene = scene, .lights = lights, .coarse = coarse, .desc = desc, .rays = rays
    };
    *level = (rsv_source_level){ 0 };
    if (desc->photon_count)
        RSV_TRY(rsv_photon_shooter_create(scene, lights, desc->seed, NULL, &b.shooter, rays));
    RSV_TRY(desc->start ? begin_again(&b) : begin(&b));
    RSV_TRY(refine(&b));
    if (b.kept) RSV_TRY(add_kept(&b));
    RSV_TRY(rsv_level_hand_over(&b, level));
cleanup:
    rsv_level_end(&b);
    return status;
}

void rsv_source_level_destroy(rsv_context *context, rsv_source_level *level)
{
    rsv_elements_destroy(level->elements);
    rsv_free(context, level->direct);
    rsv_free(context, level->caustic);
    rsv_free(context, level->deviation);
    rsv_free(context, level->valid_points);
    rsv_free(context, level->first_look);
    rsv_free(context, level->coarse_caustic);
    *level = (rsv_source_level){ 0 };
}
