#include "solve_update.h"

#include "../core/key.h"
#include "../core/team.h"
#include "goal.h"

/// Key of everything besides the scene that determines how it is solved.
static uint64_t settings_of(const rsv_builder *b)
{
    const rsv_solve_desc *d = &b->desc;
    const uint64_t word[] = { d->element_target, b->wanted_rays, d->refinements, d->light_samples,
        d->photon_count, d->direct_levels, d->direct_level, d->max_elements, d->max_bytes,
        d->reserved_bytes, d->seed };
    uint64_t key = rsv_key_add_bytes(1, word, sizeof word);
    if (d->row_rays > 0) key = rsv_key_add_bytes(key, &d->row_rays, sizeof d->row_rays);
    return d->contact_share > 0 ? rsv_key_add_bytes(key, &d->contact_share, sizeof(float)) : key;
}

/// A goal depends on what a camera sees, which is not stored.
static bool has_goal(const rsv_builder *b)
{
    rsv_goal_aim aim = rsv_goal_aim_of(&b->desc);
    return rsv_goal_is_wanted(&aim);
}

/// Whether all processes opened the same: another one in any of them would make other elements there.
static bool all_opened(rsv_context *context, const rsv_history *history)
{
    uint64_t checksum = history ? rsv_history_identity(history) : 0, first = checksum;
    rsv_team_copy(context, 0, &first, sizeof first);
    return rsv_team_total(context, first != checksum) == 0;
}

rsv_status rsv_builder_open_history(rsv_builder *b, rsv_history **history)
{
    rsv_status status = RSV_OK;
    *history = NULL;
    if (!b->update.store || has_goal(b)) return RSV_OK;
    if (b->update.earlier)
        status = rsv_history_open(
            &b->scene, b->sources->lights, b->update.earlier, settings_of(b), history);
    status = rsv_team_meet(b->context, status);
    if (status == RSV_OK && !all_opened(b->context, *history)) {
        rsv_history_close(*history);
        *history = NULL;
    }
    b->update.history = *history;
    b->scene.known_cells = *history ? rsv_history_known_cells(*history) : NULL;
    return status;
}

void rsv_builder_forget_history(rsv_builder *b)
{
    b->update.history = NULL;
    b->scene.known_cells = NULL;
}

static void write_down(const rsv_builder *b, const rsv_light *light)
{
    size_t nodes = b->elements->node_count;
    rsv_rgb *direct = rsv_alloc(b->context, nodes, sizeof *direct);
    if (!direct) {
        rsv_log(b->context, RSV_LOG_WARNING,
            "%s: no memory to keep the results of this solution; after an edit of the scene "
            "everything will be "
            "solved again",
            b->update.store->kind);
        return;
    }
    rsv_light_total(light, 0, direct);
    rsv_spacing wanted = b->spacing; // budgets make it coarser again each time
    wanted.metres = b->wanted_metres;
    const rsv_history_fields level[RSV_HISTORY_LEVELS] = {
        [RSV_HISTORY_COARSE] = { .elements = b->elements,
            .direct = direct,
            .source = light->field.source,
            .indirect = light->field.indirect,
            .valid_points = b->valid_points },
        [RSV_HISTORY_FINE] = { .elements = light->field.fine.elements,
            .direct = light->field.fine.direct,
            .deviation = light->field.fine.deviation,
            .valid_points = light->field.fine.valid_points },
    };
    rsv_history_write(
        &b->scene, b->sources->lights, b->update.store, settings_of(b), &wanted, level);
    rsv_free(b->context, direct);
}

static void let_go(rsv_context *context, rsv_source_level *level)
{
    rsv_free(context, level->deviation);
    rsv_free(context, level->valid_points);
    level->deviation = NULL;
    level->valid_points = NULL;
}

void rsv_builder_keep_history(const rsv_builder *b, rsv_light *light)
{
    const rsv_store *store = b->update.store;
    bool writes = store && (!store->shared || rsv_team_place_of(b->context).rank == 0);
    if (writes && !has_goal(b)) write_down(b, light);
    let_go(b->context, &light->field.fine);
    let_go(b->context, &light->field.caustics);
}
