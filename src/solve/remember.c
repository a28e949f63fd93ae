#include "remember.h"

#include "../core/key.h"
#include "../core/team.h"
#include "goal.h"

/// Of all that decides how a scene is solved, beside the scene.
static uint64_t settings_of(const rsv_solution *s)
{
    const rsv_solve_desc *d = &s->desc;
    const uint64_t word[] = { d->element_target, s->wanted_rays, d->refinements, d->light_samples,
        d->photon_count, d->direct_levels, d->direct_level, d->max_elements, d->max_bytes,
        d->seed };
    return rsv_key_add_bytes(1, word, sizeof word);
}

/// A goal decides by what a camera sees, of which nothing is kept.
static bool has_goal(const rsv_solution *s)
{
    rsv_goal_aim aim = rsv_goal_aim_of(s);
    return rsv_goal_is_wanted(&aim);
}

/// Whether all processes opened the same: another one in any of them would make other elements there.
static bool all_opened(rsv_context *context, const rsv_past *past)
{
    uint64_t checksum = past ? rsv_past_identity(past) : 0, first = checksum;
    rsv_team_copy(context, 0, &first, sizeof first);
    return rsv_team_total(context, first != checksum) == 0;
}

rsv_status rsv_solution_recall(rsv_solution *s, rsv_past **past)
{
    rsv_status status = RSV_OK;
    *past = NULL;
    if (!s->desc.checkpoint || has_goal(s)) return RSV_OK;
    if (s->desc.earlier)
        status = rsv_past_open(&s->scene, s->lights, s->desc.earlier, settings_of(s), past);
    status = rsv_team_meet(s->context, status);
    if (status == RSV_OK && !all_opened(s->context, *past)) {
        rsv_past_close(*past);
        *past = NULL;
    }
    s->scene.past = *past;
    return status;
}

static void write_down(const rsv_solution *s)
{
    size_t nodes = s->elements->node_count;
    rsv_rgb *direct = rsv_alloc(s->context, nodes, sizeof *direct);
    if (!direct) {
        rsv_log(s->context, RSV_LOG_WARNING,
            "checkpoint: no memory to keep what this solution knew; after an edit of the scene "
            "everything will be solved anew");
        return;
    }
    rsv_light_total(s, 0, direct);
    rsv_spacing wanted = s->spacing; // budgets coarsen that anew each time
    wanted.metres = s->wanted_metres;
    const rsv_past_fields level[RSV_PAST_LEVELS] = {
        [RSV_PAST_COARSE] = { .elements = s->elements,
            .direct = direct,
            .source = s->source,
            .indirect = s->indirect,
            .valid_points = s->valid_points },
        [RSV_PAST_FINE] = { .elements = s->fine.elements,
            .direct = s->fine.direct,
            .deviation = s->fine.deviation,
            .valid_points = s->fine.valid_points },
    };
    rsv_past_write(&s->scene, s->lights, s->desc.checkpoint, settings_of(s), &wanted, level);
    rsv_free(s->context, direct);
}

static void let_go(rsv_context *context, rsv_source_level *level)
{
    rsv_free(context, level->deviation);
    rsv_free(context, level->valid_points);
    level->deviation = NULL;
    level->valid_points = NULL;
}

void rsv_solution_remember(rsv_solution *s)
{
    if (s->desc.checkpoint && !has_goal(s) && rsv_team_place_of(s->context).rank == 0)
        write_down(s);
    let_go(s->context, &s->fine);
    let_go(s->context, &s->caustics);
}
