/// Levels of direct light and caustics whose surfaces move. Elements stay: light is sampled again at nodes that a
/// motion may have hidden from a source, or shown to it, and cells are split further where new shadows end.
#include "../core/parallel.h"
#include "../update/moved_elements.h"
#include "direct_constants.h"
#include "source_level_internal.h"

#include <string.h>

typedef struct level_follower {
    rsv_level_builder b;
    const rsv_level_motion *motion;
    uint8_t *changed;        ///< [cell_count] 1 = light may be another there
    uint8_t *coarse_changed; ///< [coarse cell_count]
    uint8_t *anew;           ///< [node_count] RSV_MOVE_... of the node; 1 = it is not sampled again
} level_follower;

/// Takes ownership of elements, which must have no other owner, and their fields.
static rsv_status take_level(level_follower *f, rsv_source_level *level)
{
    rsv_status status = RSV_OK;
    rsv_elements *shared = level->elements, *own = NULL;
    if (shared->references > 1) {
        RSV_TRY(rsv_elements_copy(shared, shared->scene, shared->bsdf, &own));
        rsv_elements_destroy(shared);
        level->elements = own;
    }
    f->b.elements = level->elements;
    f->b.direct = level->direct;
    f->b.deviation = level->deviation;
    f->b.valid_points = level->valid_points;
    f->b.first_look = level->first_look;
    rsv_free(f->b.coarse->context, level->caustic);
    rsv_free(f->b.coarse->context, level->coarse_caustic);
    *level = (rsv_source_level){ .built_cells = level->built_cells };
cleanup:
    return status;
}

static rsv_status move_elements(level_follower *f)
{
    rsv_elements *e = f->b.elements;
    rsv_scene_change change = *f->motion->shafts->change;
    const rsv_elements_motion motion = { f->motion->moved, &change,
        { RSV_LEVEL_POINTS, f->b.desc->seed }, NULL };
    f->anew = rsv_alloc(e->context, e->node_count, 1);
    if (!f->anew) return RSV_ERROR_MEMORY;
    return rsv_elements_follow(f->b.scene, e, &motion, f->b.valid_points, f->anew);
}

/// Whether the coarse elements say that it may have changed, unless these are finer than the cell.
static bool may_be_changed(const level_follower *f, const rsv_cell *cell)
{
    const rsv_elements *coarse = f->b.coarse;
    uint32_t around = rsv_elements_find_around(coarse, cell);
    return f->coarse_changed[around] || coarse->cell[around].level > cell->level;
}

static bool is_changed(const level_follower *f, uint32_t c, uint8_t moved)
{
    const rsv_elements *e = f->b.elements;
    if (moved != RSV_MOVE_NONE) return moved == RSV_MOVE_TURN;
    return may_be_changed(f, &e->cell[c]) && rsv_light_shafts_meet(f->motion->shafts, e, c);
}

static void judge_cells(void *data, rsv_span span)
{
    const level_follower *f = data;
    const rsv_elements *e = f->b.elements;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++)
        f->changed[c] = is_changed(f, c, f->motion->moved[e->face_triangle[e->cell[c].face]]);
}

/// Cells where light may be another: looked for in coarse cells where it may be.
static rsv_status find_changed(level_follower *f)
{
    const rsv_elements *e = f->b.elements;
    rsv_status status;
    f->changed = rsv_alloc(e->context, e->cell_count, 1);
    RSV_TRY(f->changed ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_light_shafts_find_changed(f->motion->shafts, f->b.coarse, &f->coarse_changed));
    rsv_parallel_for(e->context, e->cell_count, 256, judge_cells, f);
cleanup:
    rsv_free(e->context, f->coarse_changed);
    return status;
}

/// Whether shadow rays from any corner of a cell around a node met different things.
static bool is_beside_shadow(const level_follower *f, uint32_t node)
{
    const rsv_elements *e = f->b.elements;
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        const uint32_t *corner = e->cell_node[e->support[s] / 4];
        for (int k = 0; k < 3; k++)
            if (corner[k] != node && f->b.deviation[corner[k]] > 0) return true;
    }
    return false;
}

/// Light before it was sampled again.
typedef struct light_before {
    rsv_rgb *direct;
    float *deviation;
} light_before;

static void free_before(const level_follower *f, light_before *before)
{
    rsv_free(f->b.coarse->context, before->direct);
    rsv_free(f->b.coarse->context, before->deviation);
}

/// Prepares for going without the further rays of penumbrae.
static rsv_status begin_haste(level_follower *f, light_before *before)
{
    rsv_level_builder *b = &f->b;
    const rsv_elements *e = b->elements;
    *before = (light_before){ NULL, NULL };
    if (!f->motion->hasty) {
        rsv_free(e->context, b->first_look);
        b->first_look = NULL;
        return RSV_OK;
    }
    if (!b->first_look) b->first_look = rsv_level_create_first_look(e);
    before->direct = rsv_reserve(e->context, e->node_count, sizeof *before->direct);
    before->deviation = rsv_reserve(e->context, e->node_count, sizeof *before->deviation);
    if (!b->first_look || !before->direct || !before->deviation) return RSV_ERROR_MEMORY;
    memcpy(before->direct, b->direct, e->node_count * sizeof *before->direct);
    memcpy(before->deviation, b->deviation, e->node_count * sizeof *before->deviation);
    return RSV_OK;
}

static bool same_light(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/// Nodes whose first rays found what they did the last time keep what all of their rays found then.
static void keep_unchanged(level_follower *f, const light_before *before, uint8_t *known)
{
    rsv_level_builder *b = &f->b;
    if (!before->direct || !before->deviation || !b->first_look) return; // there is no haste
    for (size_t n = 0; n < b->elements->node_count; n++) {
        if (known[n]) continue;
        rsv_rgb look = b->direct[n];
        if (!f->anew[n] && same_light(look, b->first_look[n])) {
            b->direct[n] = before->direct[n];
            b->deviation[n] = before->deviation[n];
            known[n] = 1;
        }
        b->first_look[n] = look;
    }
}

/// Whether light is sampled again at a node where it may have changed.
static bool has_turn(const level_follower *f, uint32_t node)
{
    const rsv_level_motion *m = f->motion;
    return m->turns == 0 || f->anew[node] ||
           rsv_elements_draw_of(f->b.elements, node) % m->turns == m->turn;
}

/// Samples light again where it may have changed, with more rays next to shadows.
static rsv_status sample_again(level_follower *f)
{
    rsv_level_builder *b = &f->b;
    const rsv_elements *e = b->elements;
    light_before before;
    uint8_t *known = rsv_alloc(e->context, e->node_count, 1);
    rsv_status status = begin_haste(f, &before);
    RSV_TRY(status);
    RSV_TRY(known ? RSV_OK : RSV_ERROR_MEMORY);
    b->kept_count = 0;
    for (uint32_t n = 0; n < e->node_count; n++) {
        known[n] = f->anew[n] == RSV_MOVE_WAITS || !has_turn(f, n) ||
                   (!f->anew[n] && !rsv_node_light_is_changed(e, n, f->changed));
        b->kept_count += known[n] && e->node_hanging[n] == RSV_NONE && b->valid_points[n];
    }
    RSV_TRY(rsv_level_estimate(b, b->desc->light_samples, known));
    keep_unchanged(f, &before, known);
    for (uint32_t n = 0; n < e->node_count; n++)
        f->anew[n] = known[n] || !is_beside_shadow(f, n);
    RSV_TRY(rsv_level_estimate(b, RSV_PENUMBRA_FACTOR * b->desc->light_samples, f->anew));
cleanup:
    rsv_free(e->context, known);
    free_before(f, &before);
    return status;
}

static rsv_status split_marked(level_follower *f)
{
    rsv_level_builder *b = &f->b;
    rsv_elements *finer = NULL;
    rsv_status status = rsv_elements_refine(b->elements, b->split, &finer);
    if (status != RSV_OK) return status;
    rsv_earlier_level earlier = rsv_level_set_aside(b);
    b->elements = finer;
    RSV_TRY(rsv_level_prepare(b, &earlier));
    RSV_TRY(rsv_level_estimate_fresh(b, &earlier));
cleanup:
    rsv_level_free_earlier(b, &earlier);
    return status;
}

static bool is_few(const level_follower *f, size_t cells)
{
    return (float)cells <= SPLIT_SHARE * (float)f->b.elements->cell_count;
}

/// Cells where light may be another, and those that share a node with one. @param near [cell_count] out
/// @param count out: of the former
static rsv_status find_near(const level_follower *f, uint8_t *near, size_t *count)
{
    const rsv_elements *e = f->b.elements;
    uint8_t *beside = rsv_alloc(e->context, e->node_count, 1);
    if (!beside) return RSV_ERROR_MEMORY;
    *count = 0;
    for (size_t c = 0; c < e->cell_count; c++) {
        *count += f->changed[c];
        for (int k = 0; k < 3 && f->changed[c]; k++)
            beside[e->cell_node[c][k]] = 1;
    }
    for (size_t c = 0; c < e->cell_count; c++) {
        const uint32_t *node = e->cell_node[c];
        near[c] = beside[node[0]] | beside[node[1]] | beside[node[2]];
    }
    rsv_free(e->context, beside);
    return RSV_OK;
}

/// Marks cells where light curves now. @param marked out: number of cells; 0 = too few to split
static rsv_status mark_changed(level_follower *f, size_t *marked)
{
    rsv_level_builder *b = &f->b;
    rsv_context *context = b->coarse->context;
    rsv_status status;
    size_t count = 0;
    uint8_t *near = rsv_alloc(context, b->elements->cell_count, 1);
    rsv_free(context, b->split);
    b->split = rsv_alloc(context, b->elements->cell_count, 1);
    RSV_TRY(near && b->split ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(find_near(f, near, &count));
    *marked = 0;
    if (is_few(f, count)) goto cleanup;
    b->asked = near;
    RSV_TRY(rsv_level_mark_cells(b, 0, marked));
    *marked = 0;
    for (size_t c = 0; c < b->elements->cell_count; c++) {
        b->split[c] &= f->changed[c];
        *marked += b->split[c];
    }
cleanup:
    b->asked = NULL;
    rsv_free(context, near);
    return status;
}

/// Splits cells until few remain in which light curves. These are left until the level is built again.
static rsv_status split_cells(level_follower *f)
{
    rsv_status status = RSV_OK;
    uint32_t rounds = f->motion->hasty ? 1 : f->b.desc->levels;
    for (uint32_t round = 0; round < rounds; round++) {
        size_t marked;
        RSV_TRY(mark_changed(f, &marked));
        if (is_few(f, marked)) break;
        RSV_TRY(split_marked(f));
        rsv_free(f->b.coarse->context, f->changed);
        f->changed = NULL;
        RSV_TRY(find_changed(f));
    }
cleanup:
    return status;
}

static rsv_status follow_direct(level_follower *f)
{
    rsv_status status;
    RSV_TRY(find_changed(f));
    RSV_TRY(sample_again(f));
    if (!f->motion->whole) RSV_TRY(split_cells(f));
cleanup:
    return status;
}

/// Kept photons: those of earlier motions, or new ones.
static rsv_status open_log(level_follower *f)
{
    rsv_level_builder *b = &f->b;
    rsv_photon_log **log = f->motion->photons;
    uint32_t count = b->desc->photon_count, seed = b->desc->seed;
    rsv_status status = RSV_OK;
    if (!rsv_photon_log_fits(*log, b->scene, count, seed)) {
        rsv_photon_log_destroy(*log);
        *log = NULL;
        status = rsv_photon_log_create(b->scene, b->lights, count, seed, log, b->rays);
    }
    b->log = *log;
    b->met = f->motion->shafts->change;
    return status;
}

/// Photons that are all shot, by new guides.
static rsv_status open_shooter(level_follower *f)
{
    rsv_level_builder *b = &f->b;
    rsv_photon_log **log = f->motion->photons;
    if (log) {
        rsv_photon_log_destroy(*log);
        *log = NULL;
    }
    return rsv_photon_shooter_create(
        b->scene, b->lights, b->desc->seed, NULL, &b->shooter, b->rays);
}

static rsv_status follow_caustics(level_follower *f)
{
    rsv_level_builder *b = &f->b;
    bool keeps = f->motion->photons && rsv_photons_can_be_kept(b->scene, f->motion->moved);
    rsv_status status = keeps ? open_log(f) : open_shooter(f);
    return status == RSV_OK ? rsv_level_shoot(b, b->desc->photon_count) : status;
}

rsv_status rsv_source_level_follow(const rsv_transport_scene *scene, const rsv_elements *coarse,
    const rsv_source_level_desc *desc, const rsv_level_motion *motion, rsv_source_level *level,
    uint64_t *rays)
{
    rsv_status status;
    rsv_source_level_desc own = *desc;
    level_follower f = { .motion = motion,
        .b = { scene, motion->lights, coarse, &own, .rays = rays } };
    size_t built_cells = level->built_cells;
    own.start = level->elements; // cells know their depth
    RSV_TRY(take_level(&f, level));
    RSV_TRY(move_elements(&f));
    RSV_TRY(desc->direct ? follow_direct(&f) : RSV_OK);
    RSV_TRY(desc->photon_count ? follow_caustics(&f) : RSV_OK);
    RSV_TRY(rsv_level_hand_over(&f.b, level));
    level->built_cells = built_cells;
cleanup:
    rsv_free(coarse->context, f.changed);
    rsv_free(coarse->context, f.anew);
    rsv_level_end(&f.b);
    return status;
}
