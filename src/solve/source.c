#include "source.h"

#include "../core/parallel.h"
#include "../direct/voxel_direct.h"
#include "../update/kept_light.h"
#include "../update/update.h"
#include "goal.h"
#include "resolvent/measure.h"
#include "solve_constants.h"

rsv_status rsv_source_hidden_cells(const rsv_light *s, uint8_t **hidden)
{
    rsv_goal_aim aim = rsv_goal_aim_of(&s->desc);
    if (!rsv_goal_is_wanted(&aim)) return RSV_OK;
    *hidden = rsv_alloc(s->context, s->elements->cell_count, 1);
    if (!*hidden) return RSV_ERROR_MEMORY;
    return rsv_goal_hidden_cells(s->op, &aim, s->desc.seed, *hidden);
}

/// Options common to both levels.
static rsv_source_level_desc level_desc(const rsv_light *s, const rsv_level_limits *limits)
{
    return (rsv_source_level_desc){ .levels = s->desc.direct_levels,
        .max_cells = limits->max_cells,
        .light_samples = s->desc.light_samples,
        .hidden = limits->hidden,
        .seed = rsv_level_seed(s->desc.seed) };
}

rsv_status rsv_source_create_levels(rsv_light *s, const rsv_level_limits *limits)
{
    bool caustics = s->desc.photon_count > 0 && s->elements->node_count > 0 &&
                    rsv_photons_wanted(&s->scene, s->sources->lights);
    bool sampled = rsv_lights_any_sampled(s->sources->lights) || s->scene.view->light_count > 0;
    rsv_status status = RSV_OK;
    rsv_source_level_desc direct_desc = level_desc(s, limits), caustic_desc = direct_desc;
    direct_desc.direct = true;
    caustic_desc.photon_count = s->desc.photon_count;
    if (s->desc.direct_level && sampled)
        status = rsv_source_level_create(&s->scene, s->sources->lights, s->elements, &direct_desc,
            &s->field.fine, &s->report.rays);
    if (status == RSV_OK && caustics)
        status = rsv_source_level_create(&s->scene, s->sources->lights, s->elements, &caustic_desc,
            &s->field.caustics, &s->report.rays);
    return status;
}

/// Builds a level of direct light again, reusing what is still valid of the previous one.
static rsv_status build_again(rsv_light *s, const rsv_source_level_desc *desc,
    const rsv_level_motion *motion, rsv_source_level *level)
{
    rsv_source_level then = *level;
    const rsv_level_before before = { then.elements, then.direct, then.deviation, then.valid_points,
        motion->shafts, motion->moved };
    const rsv_known_cells answers = rsv_level_before_answers(&before);
    const rsv_update update = { .before = &before };
    rsv_transport_scene scene = s->scene;
    scene.update = &update;
    scene.known_cells = &answers;
    *level = (rsv_source_level){ 0 };
    rsv_status status = rsv_source_level_create(
        &scene, s->sources->lights, s->elements, desc, level, &s->report.rays);
    rsv_source_level_destroy(s->context, &then);
    return status;
}

static rsv_status follow_level(rsv_light *s, const rsv_source_level_desc *desc,
    const rsv_level_motion *motion, rsv_source_level *level)
{
    if (!level->elements) return RSV_OK;
    return rsv_source_level_follow(&s->scene, s->elements, desc, motion, level, &s->report.rays);
}

/// Whether the light has a level that can follow motions.
static bool has_level(const rsv_source_level *level)
{
    return level->elements && level->valid_points && (!level->direct || level->deviation);
}

bool rsv_source_has_grown(const rsv_light *s)
{
    const rsv_source_level *fine = &s->field.fine;
    return has_level(fine) &&
           (float)fine->elements->cell_count > MOST_GROWTH * (float)fine->built_cells;
}

static rsv_status follow_caustics(
    rsv_light *s, const rsv_level_limits *limits, const rsv_level_motion *motion)
{
    rsv_source_level_desc desc = level_desc(s, limits);
    desc.photon_count = s->desc.photon_count;
    return motion ? follow_level(s, &desc, motion, &s->field.caustics) : RSV_OK;
}

rsv_status rsv_source_divide_again(rsv_light *s, const rsv_level_limits *limits,
    const rsv_level_motion *motion, const rsv_level_motion *caustics)
{
    rsv_source_level_desc direct = level_desc(s, limits);
    rsv_status status = RSV_OK;
    direct.direct = true;
    if (has_level(&s->field.fine)) RSV_TRY(build_again(s, &direct, motion, &s->field.fine));
    if (has_level(&s->field.caustics)) RSV_TRY(follow_caustics(s, limits, caustics));
cleanup:
    return status;
}

rsv_status rsv_source_follow_levels(rsv_light *s, const rsv_level_limits *limits,
    const rsv_level_motion *motion, const rsv_level_motion *caustics)
{
    rsv_status status;
    rsv_source_level_desc direct = level_desc(s, limits);
    rsv_light_fields *f = &s->field;
    bool known = motion && (!f->fine.elements || has_level(&f->fine)) &&
                 (!f->caustics.elements || has_level(&f->caustics));
    if (!known) {
        rsv_source_level_destroy(s->context, &f->fine);
        rsv_source_level_destroy(s->context, &f->caustics);
        return rsv_source_create_levels(s, limits);
    }
    direct.direct = true;
    RSV_TRY(follow_level(s, &direct, motion, &f->fine));
    RSV_TRY(follow_caustics(s, limits, caustics));
cleanup:
    return status;
}

rsv_status rsv_source_refine_level(
    rsv_light *s, const rsv_level_limits *limits, bool caustic, rsv_source_level *finer)
{
    const rsv_source_level *level = caustic ? &s->field.caustics : &s->field.fine;
    rsv_source_level_desc desc = level_desc(s, limits);
    desc.start = level->elements;
    desc.direct = !caustic;
    desc.photon_count = caustic ? s->desc.photon_count : 0;
    if (s->desc.max_bytes) desc.max_cells = level->elements->cell_count; // there is no more room
    return rsv_source_level_create(
        &s->scene, s->sources->lights, s->elements, &desc, finer, &s->report.rays);
}

static void complete_nodes(void *job, rsv_span span)
{
    rsv_light *s = job;
    const rsv_rgb *caustic = s->field.caustics.coarse_caustic;
    for (size_t n = span.begin; n < span.end; n++) {
        s->field.source[n] = rgb_add(s->field.source[n], s->field.gathered[n]);
        if (caustic) s->field.source[n] = rgb_add(s->field.source[n], caustic[n]);
    }
}

void rsv_source_complete(rsv_light *s)
{
    rsv_parallel_for(s->context, s->elements->node_count, 0, complete_nodes, s);
    rsv_elements_constrain(s->elements, s->field.gathered);
    rsv_elements_constrain(s->elements, s->field.source);
}

static void add_emission(void *job, rsv_span span)
{
    rsv_light *s = job;
    const rsv_transport *rows = rsv_operator_get_view(s->op)->transport;
    rsv_rgb *gathered = s->field.gathered;
    for (size_t n = span.begin; n < span.end; n++)
        gathered[n] = rgb_add(gathered[n], rgb_mul(rows->gathered[n], s->gathered_scale));
}

void rsv_source_add_gathered(rsv_light *s)
{
    const rsv_transport *rows = rsv_operator_get_view(s->op)->transport;
    rsv_transport_environment(rows, s->sources->bin_radiance, s->field.gathered);
    rsv_parallel_for(s->context, s->elements->node_count, 0, add_emission, s);
    rsv_source_complete(s);
}

/// @param known [node_count] nodes that are left as they are; NULL = none
static rsv_status find_direct(
    const rsv_light *s, const uint8_t *known, rsv_rgb *irradiance, uint64_t *rays)
{
    const rsv_direct_job job = { .scene = &s->scene,
        .elements = s->elements,
        .setting = { s->sources->lights, s->scene.bsdf, RSV_SUPPORT_POINTS, s->desc.seed },
        .samples = RSV_COARSE_LIGHT_FACTOR * s->desc.light_samples,
        .valid_points = s->view.valid_points };
    rsv_direct_light light = { .irradiance = irradiance };
    rsv_status status = rsv_direct_irradiance(&job, known, &light);
    *rays += light.rays;
    if (status != RSV_OK || !s->elements->voxels) return status;
    return rsv_voxel_direct(&job, irradiance, rays);
}

rsv_status rsv_measure_direct(const rsv_light *s, double *seconds, uint64_t *rays)
{
    rsv_rgb *again = rsv_alloc(s->context, s->elements->node_count, sizeof *again);
    if (!again) return RSV_ERROR_MEMORY;
    double start = rsv_seconds();
    *rays = 0;
    rsv_status status = find_direct(s, NULL, again, rays);
    *seconds = rsv_seconds() - start;
    rsv_free(s->context, again);
    return status;
}

rsv_status rsv_source_estimate(rsv_light *s, const uint8_t *known)
{
    return find_direct(s, known, s->field.source, &s->report.rays);
}

/// Elements that receive light: neither hanging nor buried.
static size_t count_lit(const rsv_elements *e, const uint16_t *valid_points)
{
    size_t count = 0;
    for (size_t n = 0; e && valid_points && n < e->node_count; n++)
        count += e->node_hanging[n] == RSV_NONE && valid_points[n];
    return count;
}

/// @param known [node_count] coarse elements whose light was not sampled
static void report_kept(rsv_light *s, const uint8_t *known)
{
    const rsv_source_level *fine = &s->field.fine;
    size_t kept = 0;
    for (size_t n = 0; n < s->elements->node_count; n++)
        kept += known[n] && s->view.valid_points[n];
    s->update.lit_elements = count_lit(s->elements, s->view.valid_points) +
                             count_lit(fine->elements, fine->valid_points);
    s->update.kept_lit_elements = kept + fine->kept;
}

rsv_status rsv_source_create(rsv_light *s)
{
    rsv_status status;
    const rsv_history *history = rsv_history_of(&s->scene);
    uint8_t *known = rsv_alloc(s->context, s->elements->node_count, 1);
    RSV_TRY(known ? RSV_OK : RSV_ERROR_MEMORY);
    if (history) RSV_TRY(rsv_kept_direct(history, s->elements, s->field.source, known));
    report_kept(s, known);
    RSV_TRY(rsv_source_estimate(s, known));
    rsv_source_add_gathered(s);
cleanup:
    rsv_free(s->context, known);
    return status;
}
