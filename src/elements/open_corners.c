#include "open_corners.h"

#include "../core/team.h"
#include "past.h"

#define SEED 0x5bd1e995u ///< of the few directions that are tried, the same everywhere

/// A corner closer than that to what keeps it apart from the rest of its cell, as a part of the way there, does not count
/// as open. Up to about there, light that ends at once, but in the wrong place, is less wrong than light that fades all over
/// the cell.
#define FAR_CORNER 0.29f

/// How well the corners of a cell see each other: [from][to] as rsv_clear_part.
typedef struct sights {
    float part[3][3];
} sights;

static bool is_apart(const sights *s, int a, int b) { return s->part[a][b] < 1; }

static sights look_around(const rsv_transport_scene *scene, const rsv_vec3 place[3], uint64_t *rays)
{
    sights s;
    *rays += 3;
    for (int a = 0, b = 1; a < 3; a++, b = (a + 1) % 3) {
        s.part[a][b] = rsv_clear_part(scene, place[a], place[b]);
        s.part[b][a] = is_apart(&s, a, b) ? rsv_clear_part(scene, place[b], place[a]) : 1;
    }
    return s;
}

/// Open corners that are kept apart from the others by something close to them: those of the smaller side, if there are two
/// sides. @param open bits
static uint32_t find_far_corners(uint32_t open, const sights *s)
{
    for (int a = 0; a < 3; a++) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        bool with_b = open >> b & 1, with_c = open >> c & 1;
        if (!(open >> a & 1) || !(with_b || with_c)) continue;
        if ((with_b && !is_apart(s, a, b)) || (with_c && !is_apart(s, a, c))) continue;
        if (with_b && with_c && is_apart(s, b, c)) return 0;
        // `a` is on one side alone
        bool near =
            (!with_b || s->part[a][b] < FAR_CORNER) && (!with_c || s->part[a][c] < FAR_CORNER);
        bool others_near =
            (!with_b || s->part[b][a] < FAR_CORNER) && (!with_c || s->part[c][a] < FAR_CORNER);
        if (near == others_near) return 0;
        return near ? 1u << a : open & ~(1u << a);
    }
    return 0;
}

static uint8_t openness_of(uint32_t open, bool cut, const sights *s)
{
    bool through = false;
    for (int k = 0; k < 3; k++)
        through = through ||
                  (is_apart(s, k, (k + 1) % 3) && (open >> k & 1) && (open >> (k + 1) % 3 & 1));
    open &= ~find_far_corners(open, s);
    return (uint8_t)(open | (cut ? RSV_CELL_CUT : 0) | (through ? RSV_CELL_CUT_THROUGH : 0));
}

static bool is_any_apart(const sights *s)
{
    return is_apart(s, 0, 1) || is_apart(s, 1, 2) || is_apart(s, 2, 0);
}

/// A cell in a gap, seen from within: its corners are open that nothing touches, unless the gap is inside something.
/// @return 0 if none is
static uint8_t judge_sheltered(
    const rsv_transport_scene *scene, const rsv_cell_shape *shape, uint64_t *rays)
{
    rsv_vec3 place[3];
    uint32_t open = 0;
    *rays += 3;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 corner = rsv_cell_inset(shape, shape->corner[k]);
        place[k] = rsv_cell_crouch(shape, corner);
        bool shut = rsv_is_touched(scene->tracer, shape, corner) ||
                    rsv_is_buried(scene, place[k], shape->normal, SEED, rays) ||
                    rsv_is_mostly_buried(scene, place[k], shape->normal, SEED, rays);
        open |= (uint32_t)!shut << k;
    }
    if (!open) return 0;
    sights s = look_around(scene, place, rays);
    bool cut = is_any_apart(&s) || open != RSV_CORNERS_OPEN;
    return openness_of(open, cut, &s) | RSV_CELL_SHELTERED;
}

/// Whether a place right above the cell lies inside something.
static bool is_inside(const rsv_transport_scene *scene, const rsv_cell_shape *shape, rsv_vec3 place,
    bool cut, uint64_t *rays)
{
    return rsv_is_buried(scene, place, shape->normal, SEED, rays) ||
           (cut && rsv_is_mostly_buried(scene, place, shape->normal, SEED, rays));
}

static uint8_t judge_cell(
    const rsv_transport_scene *scene, const rsv_cell_shape *shape, uint64_t *rays)
{
    rsv_vec3 place[3], middle = rsv_cell_hover(shape, shape->centre);
    bool covered[3];
    *rays += 3;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 corner = rsv_cell_inset(shape, shape->corner[k]);
        place[k] = rsv_cell_hover(shape, corner);
        covered[k] = rsv_is_covered(scene, shape, corner);
    }
    sights s = look_around(scene, place, rays);
    bool same = covered[0] == covered[1] && covered[1] == covered[2];
    bool cut = is_any_apart(&s) || !same, framed = same && covered[0];
    bool gap = framed && rsv_is_covered(scene, shape, shape->centre);
    uint8_t sheltered = gap ? judge_sheltered(scene, shape, rays) : 0;
    if (sheltered) return sheltered;
    uint32_t open = 0;
    for (int k = 0; k < 3; k++)
        open |= (uint32_t) !(covered[k] || is_inside(scene, shape, place[k], cut, rays)) << k;
    if (framed && !is_inside(scene, shape, middle, true, rays))
        return RSV_CELL_OPEN_INSIDE | RSV_CELL_CUT;
    return openness_of(open, cut, &s);
}

uint8_t rsv_cell_openness(const rsv_transport_scene *scene, const rsv_elements *e, uint32_t cell,
    const rsv_cell_shape *shape, uint64_t *rays)
{
    return e->cell_openness ? e->cell_openness[cell] : judge_cell(scene, shape, rays);
}

rsv_status rsv_elements_find_open_corners(
    const rsv_transport_scene *scene, const rsv_elements *earlier, rsv_elements *e, uint64_t *rays)
{
    if (e->cell_openness) return RSV_OK;
    e->cell_openness = rsv_alloc(e->context, e->cell_count, sizeof *e->cell_openness);
    if (!e->cell_openness) return RSV_ERROR_MEMORY;
    rsv_team_place place = rsv_team_place_of(e->context);
    uint64_t traced = 0;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context)) \
    reduction(+ : traced)
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (!rsv_team_owns(place, c, RSV_TEAM_BLOCK)) continue;
        bool known = earlier && earlier->cell_openness;
        uint32_t same = known ? rsv_elements_find_same_cell(earlier, &e->cell[c]) : RSV_NONE;
        rsv_cell_shape shape;
        if (same != RSV_NONE) {
            e->cell_openness[c] = earlier->cell_openness[same];
            continue;
        }
        if (scene->past && rsv_past_openness(scene->past, e, c, &e->cell_openness[c])) continue;
        shape = rsv_cell_shape_of(e, c);
        e->cell_openness[c] = judge_cell(scene, &shape, &traced);
    }
    rsv_team_merge(
        e->context, e->cell_openness, sizeof *e->cell_openness, e->cell_count, RSV_TEAM_BLOCK);
    *rays += rsv_team_total(e->context, traced);
    return RSV_OK;
}

rsv_vec3 rsv_cell_above(uint8_t openness, const rsv_cell_shape *shape, rsv_vec3 place)
{
    return openness & RSV_CELL_SHELTERED ? rsv_cell_crouch(shape, place)
                                         : rsv_cell_hover(shape, place);
}

bool rsv_cell_outlook(
    uint8_t openness, const rsv_cell_shape *shape, uint32_t corner, rsv_vec3 *place)
{
    uint32_t open = openness & RSV_CORNERS_OPEN;
    if (openness & RSV_CELL_OPEN_INSIDE) *place = rsv_cell_hover(shape, shape->centre);
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
