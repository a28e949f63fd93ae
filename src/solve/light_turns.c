/// Which of the surfaces that moved have their light computed again in a call, if that is limited: each in its turn.
#include "../update/moved_elements.h"
#include "light_motion.h"

#include "solve_constants.h"

#include <string.h>

/// Neighbours have numbers close to each other. Their turns are spread out, so that light that is behind shows no
/// borders: about the golden section of the count, and coprime to it.
static size_t stride_of(size_t count)
{
    size_t stride = (size_t)(0.6180339887 * (double)count) | 1;
    for (;; stride += 2) {
        size_t a = count, b = stride;
        while (b > 0) {
            size_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a == 1) return stride;
    }
}

/// Takes up to `most` of the waiting triangles, from where the last call stopped.
static void take_turns(rsv_light_motion *m, size_t count, size_t most)
{
    rsv_following *f = m->s->following;
    size_t stride = stride_of(count), taken = 0;
    for (size_t looked = 0; looked < count && taken < most; looked++) {
        f->next_turn = (f->next_turn + stride) % count;
        uint8_t *moved = &m->moved[f->next_turn];
        if (*moved != RSV_MOVE_WAITS) continue;
        *moved = RSV_MOVE_TURN;
        f->waits[f->next_turn] = 0;
        taken++;
    }
    f->waiting -= taken;
    f->turns += taken;
}

/// Caustics are computed again each time that all have had their turn: photons do not know whom they will meet.
static void take_turn_of_caustics(rsv_light_motion *m, size_t moved)
{
    rsv_following *f = m->s->following;
    m->caustics = f->waiting == 0 || f->turns >= moved;
    if (m->caustics) f->turns = 0;
    rsv_scene_change_add_all(&f->caustics_behind, &m->change);
}

bool rsv_light_hurries(const rsv_light_motion *m, size_t most)
{
    size_t waiting = m->begins ? 0 : m->s->following->waiting;
    return !m->begins && most > 0 && (m->difference.moved_count > most || waiting > most);
}

rsv_status rsv_light_take_turns(rsv_light_motion *m, size_t most)
{
    const rsv_light *s = m->s;
    rsv_following *f = s->following;
    size_t count = s->world->scene.view->triangle_count;
    m->moved = rsv_alloc(s->context, count, 1);
    if (!f->waits) f->waits = rsv_alloc(s->context, count, 1);
    if (!f->caustics_moved) f->caustics_moved = rsv_alloc(s->context, count, 1);
    if (!m->moved || !f->waits || !f->caustics_moved) return RSV_ERROR_MEMORY;
    f->waiting = 0;
    for (size_t t = 0; t < count; t++) {
        f->waits[t] |= m->difference.moved[t];
        f->caustics_moved[t] |= m->difference.moved[t];
        f->waiting += f->waits[t];
        m->moved[t] = f->waits[t] ? RSV_MOVE_WAITS : RSV_MOVE_NONE;
    }
    size_t moved = f->waiting;
    take_turns(m, count, m->begins || most == 0 ? count : most);
    take_turn_of_caustics(m, moved);
    m->whole = f->waiting > 0 && f->calls++ % CALLS_PER_SPLIT != 0;
    return RSV_OK;
}

/// @param behind [turns] @param next the turn of the next call that has turns
static void take_turn(const rsv_light_motion *m, rsv_scene_change *behind, uint32_t turns,
    uint32_t *next, rsv_light_turn *turn)
{
    bool some = m->s->following->waiting > 0 && !m->shafts.all_light_changed;
    *turn = (rsv_light_turn){ .count = some ? turns : 0, .turn = *next };
    for (uint32_t k = 0; k < turns; k++) {
        rsv_scene_change_add_all(&behind[k], &m->change);
        if (some && k != *next) continue;
        rsv_scene_change_add_all(&turn->change, &behind[k]);
        behind[k].count = 0;
    }
    if (some) *next = (*next + 1) % turns;
}

void rsv_light_take_turns_of_elements(rsv_light_motion *m)
{
    rsv_following *f = m->s->following;
    take_turn(m, f->coarse_behind, RSV_COARSE_TURNS, &f->coarse_turn, &m->coarse);
    take_turn(m, f->level_behind, RSV_LEVEL_TURNS, &f->level_turn, &m->level);
}

bool rsv_light_begin_caustics(
    rsv_light_motion *m, rsv_light_shafts *shafts, rsv_level_motion *motion)
{
    rsv_following *f = m->s->following;
    *shafts = m->shafts;
    shafts->change = &f->caustics_behind;
    if (m->shafts.all_light_changed || m->settles) rsv_following_forget_photons(f);
    *motion = (rsv_level_motion){ .moved = f->caustics_moved,
        .shafts = shafts,
        .lights = m->s->sources->lights,
        .photons = m->shafts.all_light_changed || m->settles ? NULL : &f->photons };
    return m->caustics;
}

void rsv_light_end_caustics(rsv_light_motion *m)
{
    rsv_following *f = m->s->following;
    if (!m->caustics) return;
    f->caustics_behind.count = 0;
    memset(f->caustics_moved, 0, m->s->world->scene.view->triangle_count);
}
