#include "open_corners.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "elements_constants.h"
#include "known_cells.h"

#define SEED 0x5bd1e995u ///< of the few directions that are tried, the same everywhere

/// Corners, as bits, that something close to them keeps apart from the middle of the cell.
static uint32_t find_far_corners(
    const rsv_transport_scene *scene, const rsv_vec3 place[3], rsv_vec3 middle, uint64_t *rays)
{
    uint32_t far = 0;
    *rays += 3;
    for (int k = 0; k < 3; k++)
        far |= (uint32_t)(rsv_clear_part(scene, place[k], middle) < FAR_CORNER) << k;
    return far;
}

/// Where a cell is looked at from, and which of these places count.
typedef struct outlooks {
    rsv_vec3 place[3], middle;
    uint32_t open; ///< corners, as bits
    bool middle_open,
        beyond; ///< beyond: the cell reaches through a wall, to where it has no corner
} outlooks;

/// @param blocked by side of the cell: whether something stands between its ends
static uint8_t openness_of(const rsv_transport_scene *scene, const outlooks *at, bool cut,
    const bool blocked[3], uint64_t *rays)
{
    bool through = at->beyond;
    for (int k = 0; k < 3; k++)
        through = through || (blocked[k] && (at->open >> k & 1) && (at->open >> (k + 1) % 3 & 1));
    uint32_t near = at->open;
    // where a wall parts open corners, each side has its own up to the wall (cut_cells.h)
    if (cut && !through && at->open) near &= ~find_far_corners(scene, at->place, at->middle, rays);
    if (!near && !at->middle_open) near = at->open;
    return (uint8_t)(near | (cut ? RSV_CELL_CUT : 0) | (through ? RSV_CELL_CUT_THROUGH : 0) |
                     (!near && at->middle_open ? RSV_CELL_OPEN_INSIDE : 0));
}

/// @param blocked out, by side of the cell @return whether any is
static bool find_blocked_sides(
    const rsv_transport_scene *scene, const rsv_vec3 place[3], bool blocked[3], uint64_t *rays)
{
    *rays += 3;
    for (int k = 0; k < 3; k++)
        blocked[k] = rsv_is_blocked(scene, place[k], place[(k + 1) % 3]);
    return blocked[0] || blocked[1] || blocked[2];
}

/// Whether a place right above the cell lies inside something.
static bool is_inside(const rsv_transport_scene *scene, const rsv_cell_shape *shape, rsv_vec3 place,
    bool cut, uint64_t *rays)
{
    return rsv_is_buried(scene, place, shape->normal, SEED, rays) ||
           (cut && rsv_is_mostly_buried(scene, place, shape->normal, SEED, rays));
}

/// Whether the way from a corner in the open to one inside a wall passes through another wall first, and is in the open
/// between them: at the corner of a house.
static bool is_open_between(const rsv_transport_scene *scene, const rsv_cell_shape *shape,
    rsv_vec3 open, rsv_vec3 inside, uint64_t *rays)
{
    float there = rsv_clear_part(scene, open, inside), back = rsv_clear_part(scene, inside, open),
          between = 1 - there - back;
    *rays += 2;
    if (between < SLIVER) return false;
    rsv_vec3 place = v3_mad(inside, back + 0.1f * between, v3_sub(open, inside));
    return !is_inside(scene, shape, place, true, rays);
}

static bool reaches_beyond(const rsv_transport_scene *scene, const rsv_cell_shape *shape,
    const outlooks *at, const bool blocked[3], uint64_t *rays)
{
    bool beyond = false;
    for (int k = 0; k < 3; k++) {
        int open = at->open >> k & 1 ? k : (k + 1) % 3, inside = open == k ? (k + 1) % 3 : k;
        if (!blocked[k] || !(at->open >> open & 1) || at->open >> inside & 1) continue;
        beyond = beyond || is_open_between(scene, shape, at->place[open], at->place[inside], rays);
    }
    return beyond;
}

/// Whether a place in a gap sees some of the gap: nothing touches it, and the gap is not inside something.
static bool is_free_in_gap(const rsv_transport_scene *scene, const rsv_cell_shape *shape,
    rsv_vec3 place, rsv_vec3 above, uint64_t *rays)
{
    ++*rays;
    return !rsv_is_touched(scene->tracer, shape, place) &&
           !is_inside(scene, shape, above, true, rays);
}

/// A cell in a gap, seen from within. @return 0 if it cannot be
static uint8_t judge_sheltered(
    const rsv_transport_scene *scene, const rsv_cell_shape *shape, uint64_t *rays)
{
    outlooks at = { .middle = rsv_cell_within_gap(shape, shape->centre) };
    bool blocked[3] = { false };
    for (int k = 0; k < 3; k++) {
        rsv_vec3 corner = rsv_cell_inset(shape, shape->corner[k]);
        at.place[k] = rsv_cell_within_gap(shape, corner);
        at.open |= (uint32_t)is_free_in_gap(scene, shape, corner, at.place[k], rays) << k;
    }
    bool cut = find_blocked_sides(scene, at.place, blocked, rays) || at.open != RSV_CORNERS_OPEN;
    at.middle_open = cut && is_free_in_gap(scene, shape, shape->centre, at.middle, rays);
    if (!at.open && !at.middle_open) return 0;
    return openness_of(scene, &at, cut, blocked, rays) | RSV_CELL_SHELTERED;
}

static uint8_t judge_cell(
    const rsv_transport_scene *scene, const rsv_cell_shape *shape, uint64_t *rays)
{
    outlooks at = { .middle = rsv_cell_above_gaps(shape, shape->centre) };
    bool covered[3] = { false }, blocked[3] = { false };
    *rays += 3;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 corner = rsv_cell_inset(shape, shape->corner[k]);
        at.place[k] = rsv_cell_above_gaps(shape, corner);
        covered[k] = rsv_is_covered(scene, shape, corner);
    }
    bool any = covered[0] || covered[1] || covered[2], all = covered[0] && covered[1] && covered[2];
    bool cut = find_blocked_sides(scene, at.place, blocked, rays) || any != all;
    // an object may stand in the middle of a large cell, away from its corners
    bool uncertain = cut || all || shape->size > RSV_GROWTH_TOLERANCE * shape->spacing,
         middle_covered = uncertain && rsv_is_covered(scene, shape, shape->centre);
    cut = cut || (middle_covered && !all);
    uint8_t sheltered = all && middle_covered ? judge_sheltered(scene, shape, rays) : 0;
    if (sheltered) return sheltered;
    for (int k = 0; k < 3; k++)
        at.open |= (uint32_t) !(covered[k] || is_inside(scene, shape, at.place[k], cut, rays)) << k;
    cut = cut || (all && !middle_covered);
    at.beyond = cut && reaches_beyond(scene, shape, &at, blocked, rays);
    at.middle_open = cut && !middle_covered && !is_inside(scene, shape, at.middle, true, rays);
    return openness_of(scene, &at, cut, blocked, rays);
}

uint8_t rsv_cell_judge_again(
    const rsv_transport_scene *scene, const rsv_elements *e, uint32_t cell, uint64_t *rays)
{
    rsv_cell_shape shape = rsv_cell_shape_of(e, cell);
    return judge_cell(scene, &shape, rays);
}

uint8_t rsv_cell_openness(const rsv_transport_scene *scene, const rsv_elements *e, uint32_t cell,
    const rsv_cell_shape *shape, uint64_t *rays)
{
    return e->cell_openness ? e->cell_openness[cell] : judge_cell(scene, shape, rays);
}

typedef struct cell_search {
    const rsv_transport_scene *scene;
    const rsv_elements *earlier; ///< NULL = none
    rsv_elements *e;
    rsv_team_place place;
    _Atomic uint64_t rays;
} cell_search;

/// Openness of the cell in `earlier` or another known source. False = it must be computed.
static bool recall_cell(const cell_search *s, uint32_t c)
{
    uint8_t *openness = &s->e->cell_openness[c];
    const rsv_known_cells *known = s->scene->known_cells;
    uint32_t same = RSV_NONE;
    if (s->earlier && s->earlier->cell_openness)
        same = rsv_elements_find_same_cell(s->earlier, &s->e->cell[c]);
    if (same == RSV_NONE) return known && known->openness(known->user, s->e, c, openness);
    *openness = s->earlier->cell_openness[same];
    return true;
}

static void judge_cells(void *user, rsv_span span)
{
    cell_search *s = user;
    uint64_t rays = 0;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t c = (uint32_t)k;
        if (!rsv_team_owns(s->place, c, RSV_TEAM_BLOCK) || rsv_cancelled(s->e->context)) continue;
        if (recall_cell(s, c)) continue;
        rsv_cell_shape shape = rsv_cell_shape_of(s->e, c);
        s->e->cell_openness[c] = judge_cell(s->scene, &shape, &rays);
    }
    atomic_fetch_add(&s->rays, rays);
}

rsv_status rsv_elements_find_open_corners(
    const rsv_transport_scene *scene, const rsv_elements *earlier, rsv_elements *e, uint64_t *rays)
{
    if (e->cell_openness) return RSV_OK;
    e->cell_openness = rsv_alloc(e->context, e->cell_count, sizeof *e->cell_openness);
    if (!e->cell_openness) return RSV_ERROR_MEMORY;
    cell_search search = { scene, earlier, e, rsv_team_place_of(e->context), 0 };
    rsv_parallel_for(e->context, e->cell_count, 256, judge_cells, &search);
    rsv_team_merge(
        e->context, e->cell_openness, sizeof *e->cell_openness, e->cell_count, RSV_TEAM_BLOCK);
    *rays += rsv_team_total(e->context, search.rays);
    return rsv_progress(e->context, "assemble", 0);
}

rsv_vec3 rsv_cell_above(uint8_t openness, const rsv_cell_shape *shape, rsv_vec3 place)
{
    return openness & RSV_CELL_SHELTERED ? rsv_cell_within_gap(shape, place)
                                         : rsv_cell_above_gaps(shape, place);
}

bool rsv_cell_outlook(
    uint8_t openness, const rsv_cell_shape *shape, uint32_t corner, rsv_vec3 *place)
{
    uint32_t open = openness & RSV_CORNERS_OPEN;
    if (openness & RSV_CELL_OPEN_INSIDE) *place = rsv_cell_above(openness, shape, shape->centre);
    if (!open) return openness & RSV_CELL_OPEN_INSIDE;
    uint32_t from = open >> corner & 1 ? corner : (uint32_t)__builtin_ctz(open);
    *place = rsv_cell_above(openness, shape, rsv_cell_inset(shape, shape->corner[from]));
    return true;
}

bool rsv_cell_sees(const rsv_transport_scene *scene, uint8_t openness, const rsv_cell_shape *shape,
    rsv_vec3 outlook, rsv_vec3 place)
{
    bool covered = openness & RSV_CELL_SHELTERED ? rsv_is_touched(scene->tracer, shape, place)
                                                 : rsv_is_covered(scene, shape, place);
    return !covered && !rsv_is_blocked(scene, outlook, rsv_cell_above(openness, shape, place));
}
