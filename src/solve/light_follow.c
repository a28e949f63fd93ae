/// Lights of scenes in which surfaces move: only the parts that a motion affects are computed again.
///
/// 1. Boxes around the old and new places of everything that moved (rsv_scene_change). 2. Coarse elements: near boxes,
/// buried points are found again (update/moved_elements.h). Where something newly cuts cells, and
///    wherever contacts have changed once everything rests, elements are divided again (light_divide.c). Unchanged ones keep
///    their rays and light.
/// 3. Rows: rays that touch boxes are traced again (operator/tracked_rows.h). 4. Direct light: nodes are sampled again
/// if a line from them to a source meets a box (update/light_shafts.h). The fine level is
///    split further there (direct/source_follow.c) and, once splits accumulate, built again (update/level_before.h).
///    Photons that meet a box are shot again (direct/photon_log.h).
/// 5. E = E0 + G K E is solved, starting from the previous E.
#include "../core/device.h"
#include "../core/parallel.h"
#include "../core/team.h"
#include "../elements/open_corners.h"
#include "../scene/variant.h"
#include "../update/motion_boxes.h"
#include "../update/moved_elements.h"
#include "../update/update.h"
#include "light_motion.h"
#include "resolvent/update.h"
#include "solve_constants.h"
#include "source.h"

#include <string.h>

typedef rsv_light_motion motion;

// ---- motion --------------------------------------------------------------------------------------

static bool moves_emitter(const motion *m)
{
    const rsv_transport_scene *scene = &m->s->world->scene;
    for (uint32_t t = 0; t < scene->view->triangle_count; t++)
        if (m->difference.moved[t] && scene->bsdf[scene->view->triangle_material[t]].emissive)
            return true;
    return false;
}

/// Brings the light's scene, its hierarchy and its sources to where all is now.
static rsv_status move_world(motion *m, const rsv_scene *version)
{
    rsv_light *s = m->s;
    rsv_status status;
    const uint8_t *moved = m->difference.moved;
    rsv_motion_boxes boxes;
    RSV_TRY(rsv_motion_boxes_begin(
        s->context, s->world->scene.view, moved, m->difference.moved_count, &boxes));
    RSV_TRY(rsv_world_vary_triangles(s->world, moved));
    rsv_scene_take_places(s->world->variant, version);
    RSV_TRY(m->hurries ? rsv_world_follow_places_in_haste(s->world)
                       : rsv_world_follow_places(s->world));
    s->scene = s->world->scene;
    rsv_motion_boxes_end(&boxes, s->world->scene.view, moved);
    rsv_motion_boxes_enclose(&boxes, &m->change);
    rsv_scene_change_add_margins(&m->change);
    m->shafts = (rsv_light_shafts){ .change = &m->change,
        .all_light_changed =
            m->begins || m->difference.lights_moved || moves_emitter(m) || s->scene.media.bodies };
    if (m->difference.lights_moved || moves_emitter(m)) {
        RSV_TRY(rsv_light_find_sources(s, s->sources->lights));
        rsv_lights_warn_if_dark(s->sources->lights);
    }
    rsv_light_shafts_find_sources(&m->shafts, s->sources->lights);
cleanup:
    rsv_motion_boxes_free(&boxes);
    return status;
}

// ---- the operator ---------------------------------------------------------------------------------

static rsv_transport_desc describe_rows(const rsv_light *s)
{
    return (rsv_transport_desc){ .scene = &s->world->scene,
        .lights = s->sources->lights,
        .elements = s->following->elements,
        .valid_points = s->following->valid_points,
        .rays = s->report.rays_per_row,
        .seed = s->desc.seed };
}

/// Rows of the light's own.
static rsv_status trace_rows(motion *m)
{
    rsv_following *f = m->s->following;
    const rsv_transport_desc desc = describe_rows(m->s);
    rsv_status status = rsv_tracked_rows_create(&desc, &f->rows);
    if (status == RSV_OK)
        m->rows = (rsv_rows_patched){ .rays = f->rows->rays, .traced = f->rows->rays };
    return status;
}

/// Albedos for an operator of the elements as they are. NULL = no memory
static rsv_rgb *take_albedo(motion *m)
{
    const rsv_light *s = m->s;
    size_t nodes = s->following->elements->node_count;
    rsv_rgb *albedo = m->albedo;
    m->albedo = NULL;
    if (albedo) return albedo;
    albedo = rsv_alloc(s->context, nodes, sizeof *albedo);
    if (albedo && nodes)
        memcpy(albedo, rsv_operator_get_view(s->op)->albedo, nodes * sizeof *albedo);
    return albedo;
}

/// A new operator of the rows in hand.
static rsv_status take_operator(motion *m)
{
    rsv_light *s = m->s;
    rsv_following *f = s->following;
    rsv_operator *op = NULL;
    rsv_rgb *albedo = take_albedo(m);
    const rsv_operator_view parts = { .context = s->context,
        .world = s->world,
        .elements = f->elements,
        .valid_points = f->valid_points,
        .transport = f->rows,
        .albedo = albedo };
    rsv_status status = rsv_operator_restore(&parts, &op);
    if (status == RSV_OK && !albedo) status = RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = rsv_operator_scatter(op);
    if (status != RSV_OK) {
        rsv_operator_release(op);
        return status;
    }
    rsv_operator_release(s->op);
    s->op = op;
    s->elements = f->elements;
    return RSV_OK;
}

static rsv_status copy_valid_points(motion *m)
{
    rsv_light *s = m->s;
    size_t nodes = s->elements->node_count;
    uint16_t *own = s->following->valid_points = rsv_alloc(s->context, nodes, sizeof *own);
    if (!own) return RSV_ERROR_MEMORY;
    if (nodes) memcpy(own, s->view.valid_points, nodes * sizeof *own);
    return RSV_OK;
}

/// An operator of divided elements, whose rows remain to be patched.
static rsv_status divide_operator(motion *m, bool from_first)
{
    rsv_light *s = m->s;
    rsv_following *f = s->following;
    rsv_divided_elements d;
    rsv_status status;
    RSV_TRY(rsv_light_divide(m, from_first, &d));
    if (m->begins) goto cleanup; // rows are traced as a whole
    const rsv_transport_desc desc = describe_rows(s);
    const rsv_rows_division rows = { d.node_before, d.node_now };
    RSV_TRY(rsv_tracked_rows_divide(f->rows, &desc, &rows, &f->rows));
    RSV_TRY(take_operator(m));
cleanup:
    rsv_divided_elements_free(s->context, &d);
    return status;
}

static rsv_status trace_operator(motion *m)
{
    rsv_status status = trace_rows(m);
    return status == RSV_OK ? take_operator(m) : status;
}

static rsv_status patch_rows(motion *m)
{
    const rsv_light_turn *turn = &m->coarse;
    const rsv_rows_motion rows = { m->s->sources->lights, &turn->change, m->anew, turn->count,
        turn->turn };
    return rsv_tracked_rows_patch(m->s->following->rows, &rows, &m->rows);
}

static rsv_status move_operator(motion *m)
{
    rsv_light *s = m->s;
    rsv_following *f = s->following;
    uint8_t contacts = 0;
    const rsv_elements_motion elements = { m->moved, &m->change,
        { RSV_SUPPORT_POINTS, s->desc.seed }, &contacts };
    rsv_status status;
    bool whole = m->begins || !rsv_tracked_rows_can_follow(f->rows, &m->change);
    m->anew = rsv_alloc(s->context, f->elements->node_count, 1);
    RSV_TRY(m->anew ? RSV_OK : RSV_ERROR_MEMORY);
    if (m->begins) RSV_TRY(copy_valid_points(m));
    rsv_scene_change_add_all(&f->unsettled, &m->change);
    RSV_TRY(
        rsv_elements_follow(&s->world->scene, f->elements, &elements, f->valid_points, m->anew));
    if (m->settles && (contacts || f->split))
        RSV_TRY(divide_operator(m, true));
    else if (m->begins ? contacts != 0 : (contacts & RSV_CELL_CUT_THROUGH) && f->waiting == 0)
        RSV_TRY(divide_operator(m, false));
    else if (contacts) // what stands upon cells without parting them can wait until it rests
        f->split = true;
    rsv_light_publish(s);
    rsv_light_take_turns_of_elements(m);
    if (whole && !m->begins) RSV_TRY(copy_valid_points(m)); // the operator keeps its own
    RSV_TRY(whole ? trace_operator(m) : patch_rows(m));
    rsv_light_publish(s);
cleanup:
    return status;
}

// ---- E0 -------------------------------------------------------------------------------------------

typedef struct known_job {
    const motion *motion;
    const uint8_t *changed; ///< from rsv_light_shafts_find_changed
    uint8_t *known;
} known_job;

static bool has_turn(const rsv_light_turn *turn, uint32_t number)
{
    return turn->count == 0 || number % turn->count == turn->turn;
}

static void mark_known(void *data, rsv_span span)
{
    const known_job *job = data;
    const motion *m = job->motion;
    const rsv_elements *e = m->s->elements;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->known[n] = m->anew[n] == RSV_MOVE_WAITS ||
                        (!m->anew[n] && (!has_turn(&m->coarse, n) ||
                                            (!rsv_node_light_is_changed(e, n, job->changed) &&
                                                !rsv_node_is_beside(e, n, &m->coarse.change))));
}

/// Nodes whose direct light has not changed. @param known [node_count] zeros in
static rsv_status find_known(motion *m, uint8_t *known)
{
    const rsv_elements *e = m->s->elements;
    uint8_t *changed = NULL;
    rsv_light_shafts shafts = m->shafts;
    shafts.change = &m->coarse.change;
    rsv_status status = rsv_light_shafts_find_changed(&shafts, e, &changed);
    known_job job = { m, changed, known };
    if (status == RSV_OK) rsv_parallel_for(e->context, e->node_count, 256, mark_known, &job);
    rsv_free(e->context, changed);
    return status;
}

static rsv_status find_direct(motion *m)
{
    rsv_light *s = m->s;
    size_t nodes = s->elements->node_count;
    rsv_status status;
    uint8_t *known = rsv_alloc(s->context, nodes, 1);
    RSV_TRY(known ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(find_known(m, known));
    memcpy(s->field.source, s->following->direct, nodes * sizeof *s->field.source);
    RSV_TRY(rsv_source_estimate(s, known));
    memcpy(s->following->direct, s->field.source, nodes * sizeof *s->field.source);
    for (size_t n = 0; n < nodes; n++) {
        bool lit = s->elements->node_hanging[n] == RSV_NONE && s->view.valid_points[n];
        m->lit += lit;
        m->kept_lit += lit && known[n];
    }
cleanup:
    rsv_free(s->context, known);
    return status;
}

/// Builds the level of direct light again if anything has moved since the last time; its splits are then those of a
/// solve.
static rsv_status divide_again(
    motion *m, const rsv_level_limits *limits, const rsv_level_motion *caustics)
{
    rsv_light *s = m->s;
    rsv_light_shafts shafts = m->shafts;
    shafts.change = &s->following->undivided;
    const rsv_level_motion moved = {
        .moved = m->moved, .shafts = &shafts, .lights = s->sources->lights
    };
    rsv_status status = rsv_source_divide_again(s, limits, &moved, caustics);
    s->following->undivided.count = 0;
    return status;
}

/// Direct light and caustics on their own elements.
static rsv_status find_levels(motion *m)
{
    rsv_light *s = m->s;
    rsv_status status;
    uint8_t *hidden = NULL;
    rsv_scene_change *undivided = &s->following->undivided;
    rsv_light_shafts near = m->shafts, shafts;
    const rsv_level_motion moved = { .moved = m->moved,
        .shafts = &near,
        .lights = s->sources->lights,
        .whole = m->whole,
        .hasty = s->following->waiting > 0,
        .turns = m->level.count,
        .turn = m->level.turn };
    rsv_level_motion caustics;
    near.change = &m->level.change;
    bool turn = rsv_light_begin_caustics(m, &shafts, &caustics);
    rsv_scene_change_add_all(undivided, &m->change);
    RSV_TRY(rsv_source_hidden_cells(s, &hidden));
    const rsv_level_limits limits = { SIZE_MAX, hidden };
    if (!m->begins && (m->divides || rsv_source_has_grown(s)))
        RSV_TRY(divide_again(m, &limits, turn ? &caustics : NULL));
    else
        RSV_TRY(rsv_source_follow_levels(
            s, &limits, m->begins ? NULL : &moved, turn ? &caustics : NULL));
    if (m->begins) undivided->count = 0;
    rsv_light_end_caustics(m);
cleanup:
    rsv_free(s->context, hidden);
    return status;
}

static rsv_status solve_again(motion *m)
{
    rsv_light *s = m->s;
    rsv_status status;
    s->gathered_scale = rgb_gray(1);
    rsv_source_add_gathered(s);
    RSV_TRY(rsv_solve_on(s, s->following->waiting ? ORDERS_IN_HASTE : s->desc.max_orders));
    if (rsv_operator_get_view(s->op)->subsurface) RSV_TRY(rsv_light_diffuse(s));
cleanup:
    return status;
}

static rsv_status move_light(motion *m)
{
    rsv_status status;
    RSV_TRY(find_direct(m));
    if (m->settles) goto cleanup; // the level is built again
    RSV_TRY(find_levels(m));
    RSV_TRY(solve_again(m));
cleanup:
    return status;
}

// ---- all of it ------------------------------------------------------------------------------------

static void fill_report(const motion *m, double seconds, rsv_update_report *report)
{
    const rsv_light *s = m->s;
    size_t rows = rsv_count_rows(s->elements, s->view.valid_points);
    *report = (rsv_update_report){ .rows = rows,
        .kept_elements = rows,
        .kept_rows = m->rows.kept_rows,
        .row_rays = m->rows.rays,
        .kept_row_rays = m->rows.rays > m->rows.traced ? m->rows.rays - m->rows.traced : 0,
        .lit_elements = m->lit,
        .kept_lit_elements = m->kept_lit + s->field.fine.kept,
        .waiting_triangles = s->following->waiting,
        .seconds = seconds };
    const rsv_elements *fine = s->field.fine.elements;
    for (size_t n = 0; fine && s->field.fine.valid_points && n < fine->node_count; n++)
        report->lit_elements +=
            fine->node_hanging[n] == RSV_NONE && s->field.fine.valid_points[n] != 0;
}

/// RSV_ERROR_UNSUPPORTED where a light cannot follow.
static rsv_status check(const rsv_light *s)
{
    if (rsv_team_place_of(s->context).size > 1)
        return rsv_fail(
            RSV_ERROR_UNSUPPORTED, "light can follow moving objects only in a single process");
    if (rsv_context_device(s->context))
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "light can follow moving objects only on the CPU");
    if (!s->field.irradiance || !s->field.indirect)
        return rsv_fail(RSV_ERROR_ARGUMENT, "light: solve it before it follows moving objects");
    return RSV_OK;
}

static rsv_status follow(motion *m, const rsv_scene *version, size_t most)
{
    rsv_light *s = m->s;
    rsv_status status;
    m->hurries = rsv_light_hurries(m, most);
    RSV_TRY(rsv_light_vary_world(s));
    rsv_light_set_basis(s, NULL);
    RSV_TRY(move_world(m, version));
    if (m->begins) RSV_TRY(rsv_following_create(m->s, &m->s->following));
    RSV_TRY(rsv_light_take_turns(m, most));
    RSV_TRY(move_operator(m));
    RSV_TRY(move_light(m));
cleanup:
    return status;
}

/// Removes splits of coarse elements that earlier motions left, and updates what depends on them.
static rsv_status settle_operator(motion *m)
{
    rsv_light *s = m->s;
    rsv_status status;
    rsv_light_take_turns_of_elements(m);
    RSV_TRY(divide_operator(m, true));
    RSV_TRY(patch_rows(m));
    rsv_light_publish(s);
    RSV_TRY(find_direct(m));
cleanup:
    return status;
}

/// If nobody waited, nothing was done in this call yet.
static rsv_status begin_settling(motion *m)
{
    const rsv_light *s = m->s;
    rsv_status status;
    m->shafts =
        (rsv_light_shafts){ .change = &m->change, .all_light_changed = s->scene.media.bodies };
    rsv_light_shafts_find_sources(&m->shafts, s->sources->lights);
    RSV_TRY(rsv_light_take_turns(m, 0)); // nobody waits
    if (s->following->split) RSV_TRY(settle_operator(m));
cleanup:
    return status;
}

/// Divides elements of direct light as a solve would, once all is at rest. @param followed light of those that waited
static rsv_status settle(motion *m, bool followed)
{
    rsv_light *s = m->s;
    uint8_t *hidden = NULL;
    rsv_status status;
    rsv_light_shafts shafts;
    rsv_level_motion caustics;
    if (!followed) RSV_TRY(begin_settling(m));
    rsv_scene_change_add_all(&s->following->undivided, &m->change);
    RSV_TRY(rsv_source_hidden_cells(s, &hidden));
    const rsv_level_limits limits = { SIZE_MAX, hidden };
    rsv_light_begin_caustics(m, &shafts, &caustics);
    RSV_TRY(divide_again(m, &limits, &caustics));
    rsv_light_end_caustics(m);
    if (m->divides || followed) RSV_TRY(solve_again(m));
cleanup:
    rsv_free(s->context, hidden);
    return status;
}

/// Whether anything has to be divided again now that all is at rest.
static bool is_unsettled(const rsv_following *f) { return f->undivided.count > 0 || f->split; }

rsv_status rsv_light_follow(rsv_light *s, const rsv_scene *version, rsv_update_report *report)
{
    return rsv_light_follow_part(s, version, 0, report);
}

rsv_status rsv_light_follow_part(
    rsv_light *s, const rsv_scene *version, size_t most, rsv_update_report *report)
{
    motion m = { .s = s, .begins = !s->following };
    double start = rsv_seconds();
    rsv_status status;
    RSV_TRY(rsv_scene_require_committed(version));
    RSV_TRY(rsv_scene_refuse_fog(version, "a light that follows what moves"));
    RSV_TRY(rsv_scene_refuse_fog(s->scene.scene, "a light that follows what moves"));
    RSV_TRY(check(s));
    RSV_TRY(rsv_scene_find_moved(s->world->scene.scene, version, &m.difference));
    bool rests = m.difference.moved_count == 0 && !m.difference.lights_moved && !m.begins;
    bool waits = rests && s->following->waiting > 0;
    m.settles = rests && (most == 0 || !waits) && (waits || is_unsettled(s->following));
    if (!rests || waits) RSV_TRY(follow(&m, version, most));
    if (m.settles) RSV_TRY(settle(&m, waits));
    rsv_light_publish(s);
    if (report) fill_report(&m, rsv_seconds() - start, report);
cleanup:
    rsv_free(s->context, m.difference.moved);
    rsv_free(s->context, m.moved);
    rsv_free(s->context, m.anew);
    rsv_free(s->context, m.albedo);
    return status;
}
