#include "cut_cells.h"

#include "../core/parallel.h"
#include "elements_constants.h"
#include "open_corners.h"

#include <string.h>

/// What is known of a cell while its line is found. Corners are above the cell, and moved towards its centre.
typedef struct cut_search {
    const rsv_transport_scene *scene;
    rsv_vec3 place[3];
    uint32_t open; ///< corners, as bits
    uint64_t rays;
} cut_search;

static bool is_apart(cut_search *s, int a, int b)
{
    s->rays++;
    return rsv_is_blocked(s->scene, s->place[a], s->place[b]);
}

/// Whether two corners see each other on a way around, by the point that mirrors the third one.
static bool meet_outside(cut_search *s, int a, int b, int third)
{
    rsv_vec3 around = v3_sub(v3_add(s->place[a], s->place[b]), s->place[third]);
    s->rays += 2;
    return !rsv_is_blocked(s->scene, s->place[a], around) &&
           !rsv_is_blocked(s->scene, around, s->place[b]);
}

/// The corner that a wall keeps apart from both others, where these are on one side; -1 = there is none.
static int find_lone_corner(cut_search *s)
{
    bool apart[3]; // [k]: the corners other than k from each other
    int walls = 0, lone = -1, found = 0;
    for (int k = 0; k < 3; k++)
        walls += apart[k] = is_apart(s, (k + 1) % 3, (k + 2) % 3);
    for (int k = 0; k < 3; k++) {
        bool together =
            walls == 2 ? !apart[k] : walls == 3 && meet_outside(s, (k + 1) % 3, (k + 2) % 3, k);
        if (together) lone = k;
        found += together;
    }
    return found == 1 ? lone : -1;
}

/// Barycentric weights of the middle of the wall on the way between two corners.
static void find_crossing(cut_search *s, int from, int to, double at[3])
{
    s->rays += 2;
    double begin = (double)rsv_clear_part(s->scene, s->place[from], s->place[to]),
           end = 1 - (double)rsv_clear_part(s->scene, s->place[to], s->place[from]),
           t = fmin(fmax(0.5 * (begin + end), 0), 1);
    for (int k = 0; k < 3; k++)
        at[k] = (double)INSET / 3;
    at[from] += (1 - (double)INSET) * (1 - t);
    at[to] += (1 - (double)INSET) * t;
}

/// The linear function of barycentric weights that is 0 at two places. @return whether it parts the corner from those
/// that are not 0
static bool find_line(const double p[3], const double q[3], int corner, float side[3])
{
    double line[3], largest = 0;
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        line[k] = p[a] * q[b] - p[b] * q[a];
        largest = fmax(largest, fabs(line[k]));
    }
    bool parts = largest > 0;
    for (int k = 0; k < 3 && parts; k++)
        side[k] = (float)(line[k] / (line[corner] < 0 ? -largest : largest));
    for (int k = 0; k < 3 && parts; k++)
        parts = k == corner ? side[k] > 0 : side[k] <= 0;
    return parts;
}

/// @return false: no line parts the cell's open corners
static bool find_cut(cut_search *s, float side[3])
{
    double p[3], q[3] = { 0 };
    if (s->open == RSV_CORNERS_OPEN) {
        int lone = find_lone_corner(s);
        if (lone < 0) return false;
        find_crossing(s, lone, (lone + 1) % 3, p);
        find_crossing(s, lone, (lone + 2) % 3, q);
        return find_line(p, q, lone, side);
    }
    // the third one is inside the wall
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        if (s->open != (RSV_CORNERS_OPEN & ~(1u << k)) || !is_apart(s, a, b)) continue;
        find_crossing(s, a, b, p);
        q[k] = 1;
        return find_line(p, q, a, side);
    }
    return false;
}

typedef struct cut_job {
    const rsv_transport_scene *scene;
    const rsv_elements *e;
    float (*side)[3]; ///< [cell_count] out; the first NAN = no cut
    _Atomic uint64_t rays;
    atomic_size_t count;
} cut_job;

static void find_cuts(void *user, rsv_span span)
{
    cut_job *job = user;
    const rsv_elements *e = job->e;
    uint64_t rays = 0;
    for (size_t c = span.begin; c < span.end; c++) {
        uint8_t openness = e->cell_openness[c];
        job->side[c][0] = NAN;
        if (!(openness & RSV_CELL_CUT_THROUGH)) continue;
        cut_search s = { .scene = job->scene, .open = openness & RSV_CORNERS_OPEN };
        rsv_cell_shape shape = rsv_cell_shape_of(e, (uint32_t)c);
        for (int k = 0; k < 3; k++)
            s.place[k] = rsv_cell_above(openness, &shape, rsv_cell_inset(&shape, shape.corner[k]));
        float side[3];
        if (find_cut(&s, side)) {
            memcpy(job->side[c], side, sizeof side);
            atomic_fetch_add(&job->count, 1);
        }
        rays += s.rays;
    }
    atomic_fetch_add(&job->rays, rays);
}

/// Keeps the lines that were found. @param side [cell_count]
static rsv_status keep_cuts(rsv_elements *e, float (*side)[3], size_t count)
{
    rsv_free(e->context, e->cell_cut);
    rsv_free(e->context, e->cut_side);
    e->cell_cut = NULL;
    e->cut_side = NULL;
    e->cut_count = 0;
    if (count == 0) return RSV_OK;
    e->cell_cut = rsv_reserve(e->context, e->cell_count, sizeof *e->cell_cut);
    e->cut_side = rsv_reserve(e->context, count, sizeof *e->cut_side);
    if (!e->cell_cut || !e->cut_side) return RSV_ERROR_MEMORY;
    for (size_t c = 0; c < e->cell_count; c++) {
        bool cut = !isnan(side[c][0]);
        e->cell_cut[c] = cut ? (uint32_t)e->cut_count : RSV_NONE;
        if (cut) memcpy(e->cut_side[e->cut_count++], side[c], sizeof side[c]);
    }
    return RSV_OK;
}

rsv_status rsv_elements_find_cuts(const rsv_transport_scene *scene, rsv_elements *e, uint64_t *rays)
{
    cut_job job = { scene, e, rsv_reserve(e->context, e->cell_count, sizeof *job.side), 0, 0 };
    if (!job.side) return RSV_ERROR_MEMORY;
    rsv_parallel_for(e->context, e->cell_count, 256, find_cuts, &job);
    rsv_status status = keep_cuts(e, job.side, job.count);
    *rays += job.rays;
    rsv_free(e->context, job.side);
    return status;
}

/// Share of the way from one corner to another at which the line is.
static float crossing_of(const float side[3], int from, int to)
{
    return side[from] / (side[from] - side[to]);
}

void rsv_cell_shares(const rsv_elements *e, uint32_t cell, float share[3])
{
    const float *side = rsv_cell_sides(e, cell);
    int lone = 0;
    if (!side) {
        share[0] = share[1] = share[2] = 1.0f / 3;
        return;
    }
    while (lone < 2 && !(side[lone] > 0 && side[(lone + 1) % 3] <= 0 && side[(lone + 2) % 3] <= 0))
        lone++;
    int a = (lone + 1) % 3, b = (lone + 2) % 3;
    float to_a = crossing_of(side, lone, a), to_b = crossing_of(side, lone, b);
    share[lone] = to_a * to_b;
    // weights of the others change linearly along the rays from the lone corner: Simpson's rule over these
    float middle = 2 / (1 / to_a + 1 / to_b), rest = 1 - share[lone],
          ends[2] = { 1 - to_a * to_a, 1 - to_b * to_b };
    float towards_a = (ends[0] + 2 * (1 - middle * middle)) / 6,
          towards_b = (ends[1] + 2 * (1 - middle * middle)) / 6, sum = towards_a + towards_b;
    share[a] = side[a] == 0 ? 0 : side[b] == 0 ? rest : sum > 0 ? rest * towards_a / sum : rest / 2;
    share[b] = rest - share[a];
}
