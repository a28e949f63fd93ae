/// Light does not leak through walls, and is not lost where objects touch, hang close together or intersect.
#include "elements/burial.h"
#include "elements/contact.h"
#include "elements/cut_cells.h"
#include "elements/open_corners.h"
#include "elements/spacing.h"
#include "light_fixture.h"
#include "light_view.h"
#include "resolvent/render.h"
#include "solve/world.h"

// ---- leaks --------------------------------------------------------------------------------------

/// A room split by a wall across x = `at`, light in the right part alone.
typedef struct split_room {
    float at, thickness, sunk; ///< metres; sunk: how far the wall reaches through floor and walls
} split_room;

static world *create_split_room(split_room room)
{
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    const float low = -room.sunk, high = 1 + room.sunk, z = 1 + room.sunk,
                half = room.thickness / 2;
    world_room(w, paint, v3(-1, 0, -1), v3(1, 1, 1));
    if (room.thickness > 0) {
        world_box(w, paint, v3(room.at - half, low, -z), v3(room.at + half, high, z));
    } else {
        rsv_material sheet = lambert_material(0.7f, 0);
        sheet.double_sided = true;
        world_quad(w, world_material(w, sheet), v3(room.at, low, -z), v3(room.at, low, z),
            v3(room.at, high, z), v3(room.at, high, -z));
    }
    world_quad(w, world_lambert(w, 0, 10), v3(0.4f, 0.99f, -0.3f), v3(0.8f, 0.99f, -0.3f),
        v3(0.8f, 0.99f, 0.3f), v3(0.4f, 0.99f, 0.3f));
    world_commit(w);
    return w;
}

static rsv_light *solve_with(const world *w, uint32_t elements, uint32_t rays, uint32_t seed)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = elements;
    desc.rays_per_element = rays;
    desc.photon_count = 1000;
    desc.seed = seed;
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

static rsv_light *solve_small(const world *w, uint32_t seed)
{
    return solve_with(w, 700, 64, seed);
}

static float look_up(
    const world *w, const rsv_light *s, rsv_vec3 p, rsv_vec3 normal, uint32_t order)
{
    rsv_hit hit;
    assert_true(rsv_tracer_nearest(w->tracer, p, normal, &hit));
    return rsv_light_irradiance(s, hit.triangle, hit.u, hit.v, false, order).g;
}

/// Light on the dark side of the wall, divided by the light on the bright side at the same distance.
static float leak_at(const world *w, const rsv_light *s, split_room room, rsv_vec3 place,
    rsv_vec3 normal, float distance, uint32_t order)
{
    float away = room.thickness / 2 + distance;
    rsv_vec3 dark = place, bright = place;
    dark.x = room.at - away;
    bright.x = room.at + away;
    float lit = look_up(w, s, bright, normal, order), unlit = look_up(w, s, dark, normal, order);
    return unlit > 0 ? unlit / lit
                     : 0; // places that the lamp does not reach are dark on both sides
}

/// The worst leak along the wall on floor and rear wall, within a centimetre.
static float worst_leak(const world *w, const rsv_light *s, split_room room, uint32_t order)
{
    const float distance[] = { 0.001f, 0.004f, 0.007f, 0.01f };
    float worst = 0;
    for (int d = 0; d < 4; d++)
        for (int k = 0; k < 40; k++) {
            float t = ((float)k + 0.5f) / 40;
            float on_floor =
                leak_at(w, s, room, v3(0, 0, 2 * t - 1), v3(0, 1, 0), distance[d], order);
            float on_rear = leak_at(w, s, room, v3(0, t, -1), v3(0, 0, 1), distance[d], order);
            worst = f_max(worst, f_max(on_floor, on_rear));
        }
    return worst;
}

/// Direct light is stored on fine cells, indirect light on coarse ones, each with its own limit; a negative limit skips
/// one.
static void check_leaks(split_room room, uint32_t seed, float direct_limit, float indirect_limit)
{
    world *w = create_split_room(room);
    rsv_light *s = solve_small(w, seed);
    float direct = direct_limit >= 0 ? worst_leak(w, s, room, 0) : -1;
    float indirect = worst_leak(w, s, room, 1);
    rsv_light_destroy(s);
    world_end(w);
    if (direct > direct_limit || indirect > indirect_limit)
        fail_msg("wall at %g, %g thick, sunk %g, seed %u: leak %.4f direct, %.4f indirect", room.at,
            room.thickness, room.sunk, seed, direct, indirect);
}

static void a_thin_wall_on_the_grid_keeps_light_out(void **state)
{
    (void)state;
    check_leaks((split_room){ 0, 0, 0.02f }, 0, 0.01f, 0.01f);
    check_leaks((split_room){ 0, 0, 0 }, 0, 0.01f, 0.01f);
}

static void a_thick_wall_keeps_light_out(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 3; seed++) {
        check_leaks((split_room){ 0, 0.05f, 0.02f }, seed, 0.01f, 0.01f);
        check_leaks((split_room){ 0.1234f, 0.05f, 0.02f }, seed, 0.01f, 0.01f);
    }
}

static void a_thick_wall_that_just_touches_keeps_light_out(void **state)
{
    (void)state;
    check_leaks((split_room){ 0, 0.05f, 0 }, 0, 0.01f, 0.01f);
    check_leaks((split_room){ -0.0777f, 0.05f, 0 }, 0, 0.01f, 0.01f);
}

/// Nodes that splits at contacts add to boards that run through each other, 8 one way and 8 the other.
static size_t nodes_at_contacts(size_t most_nodes)
{
    world *w = world_begin(1);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    for (int k = 0; k < 8; k++) {
        float x = 0.25f * (float)k;
        world_box(w, paint, v3(x, -0.1f, 0), v3(x + 0.1f, 2, 0.1f));
        world_box(w, paint, v3(-0.1f, x, 0.05f), v3(2, x + 0.1f, 0.15f));
    }
    world_commit(w);
    rsv_elements *e;
    uint64_t rays = 0;
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = 0.2f }, &e), RSV_OK);
    size_t before = e->node_count;
    assert_int_equal(
        rsv_elements_refine_contacts(&w->transport, most_nodes, NULL, &e, &rays), RSV_OK);
    size_t added = e->node_count - before;
    rsv_elements_destroy(e);
    world_end(w);
    return added;
}

static void contacts_take_no_more_nodes_than_allowed(void **state)
{
    (void)state;
    size_t wanted = nodes_at_contacts(1 << 20);
    for (size_t most = wanted / 2; most > wanted / 64; most /= 2) {
        size_t added = nodes_at_contacts(most);
        if (added == 0 || added > most)
            fail_msg("%zu nodes were added, %zu allowed, %zu wanted", added, most, wanted);
    }
    assert_int_equal(nodes_at_contacts(0), 0);
}

static float size_of(const rsv_elements *e, uint32_t cell)
{
    return rsv_cell_shape_of(e, cell).size;
}

/// Size of the largest cells that a box cuts, and of those whose corners are on different sides of a thin wall.
static void sizes_at_contacts(const rsv_growth *growth, float *cut, float *through)
{
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    world_room(w, paint, v3(-2, 0, -2), v3(2, 2, 2));
    world_box(w, paint, v3(-0.53f, 0, -0.57f), v3(0.57f, 0.8f, 0.53f)); // cuts
    world_box(w, paint, v3(-2, 0, 1.131f), v3(2, 2, 1.151f));           // keeps corners apart
    world_commit(w);
    rsv_elements *e;
    uint64_t rays = 0;
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = 0.5f }, &e), RSV_OK);
    assert_int_equal(
        rsv_elements_refine_contacts(&w->transport, 1 << 20, growth, &e, &rays), RSV_OK);
    *cut = *through = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        bool walled = e->cell_openness[c] & RSV_CELL_CUT_THROUGH;
        if (walled) *through = f_max(*through, size_of(e, c));
        if (!walled && (e->cell_openness[c] & RSV_CELL_CUT)) *cut = f_max(*cut, size_of(e, c));
    }
    rsv_elements_destroy(e);
    world_end(w);
}

static float constant_growth(const void *growth, const rsv_elements *e, uint32_t cell)
{
    (void)e, (void)cell;
    return *(const float *)growth;
}

/// If a goal allows larger cells, cells under an object grow by the square of that factor, but not where light from the
/// far side of a wall would leak through.
static void contacts_matter_as_much_as_the_goal_says(void **state)
{
    (void)state;
    const float usual = 1, root = sqrtf(2);
    const rsv_growth none = { constant_growth, &usual }, larger = { constant_growth, &root };
    float cut[3], through[3];
    sizes_at_contacts(NULL, &cut[0], &through[0]);
    sizes_at_contacts(&none, &cut[1], &through[1]);
    sizes_at_contacts(&larger, &cut[2], &through[2]);
    assert_true(cut[0] > 0 && through[0] > 0);
    assert_close(cut[1], cut[0], 1e-6);
    assert_close(cut[2], 2 * cut[1], 1e-6);
    assert_close(through[2], through[1], 1e-6);
}

/// What hides behind a picture's canvas is looked at from the middle of a cell whose corners all lie on its frame.
static void large_cells_are_looked_at_in_their_middle(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    world_room(w, paint, v3(0, 0, 0), v3(3, 3, 3));
    world_box(w, paint, v3(0.3f, 0.001f, 0.3f), v3(2.5f, 0.005f, 2.5f));
    world_commit(w);
    rsv_elements *e;
    uint64_t rays = 0;
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = 3 }, &e), RSV_OK);
    e->spacing = 0.5f;
    assert_int_equal(rsv_elements_find_open_corners(&w->transport, NULL, e, &rays), RSV_OK);
    size_t cut = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        rsv_cell_shape shape = rsv_cell_shape_of(e, c);
        bool floor = shape.normal.y > 0.9f && shape.centre.y == 0;
        if (floor && (e->cell_openness[c] & RSV_CELL_CUT)) cut++;
    }
    assert_int_equal(cut, 2); // both halves of the floor
    rsv_elements_destroy(e);
    world_end(w);
}

static void add_lamp(world *w)
{
    world_quad(w, world_lambert(w, 0, 10), v3(-0.3f, 0.99f, -0.3f), v3(0.3f, 0.99f, -0.3f),
        v3(0.3f, 0.99f, 0.3f), v3(-0.3f, 0.99f, 0.3f));
}

/// Stored irradiance at these points, divided by gathered irradiance: minimum, maximum and mean.
typedef struct shares {
    float least, largest, mean;
} shares;

static shares stored_shares(
    const world *w, const rsv_light *s, const rsv_probe *probe, size_t places)
{
    rsv_probe_reading *reading = malloc(places * sizeof *reading);
    assert_int_equal(rsv_probe_irradiance(s,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 1024, 1 },
                         probe, places, reading),
        RSV_OK);
    shares found = { INFINITY, 0, 0 };
    for (size_t k = 0; k < places; k++) {
        float stored = look_up(w, s, probe[k].position, probe[k].normal, RSV_NONE);
        float share = stored / reading[k].irradiance.g;
        found.least = f_min(found.least, share);
        found.largest = f_max(found.largest, share);
        found.mean += share / (float)places;
    }
    free(reading);
    return found;
}

#define OUT 1.2f // the far side of a built room's walls

/// A room whose walls, floor and ceiling are intersecting boxes, as in architectural models: corners of their cells lie
/// inside the next box.
static world *create_built_room(void)
{
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    const float low = -0.02f, high = 1.02f, end = 1.02f;
    world_box(w, paint, v3(-OUT, -0.2f, -OUT), v3(OUT, 0, OUT));
    world_box(w, paint, v3(-OUT, 1, -OUT), v3(OUT, 1.2f, OUT));
    world_box(w, paint, v3(-OUT, low, -OUT), v3(OUT, high, -1));
    world_box(w, paint, v3(-OUT, low, 1), v3(OUT, high, OUT));
    world_box(w, paint, v3(-OUT, low, -end), v3(-1, high, end));
    world_box(w, paint, v3(1, low, -end), v3(OUT, high, end));
    add_lamp(w);
    world_commit(w);
    return w;
}

/// How far a point lies in the room's walls; negative in the room.
static float depth_in_walls(rsv_vec3 p)
{
    return f_max(f_max(fabsf(p.x) - 1, fabsf(p.z) - 1), fabsf(p.y - 0.5f) - 0.5f);
}

static void corners_within_walls_are_not_open(void **state)
{
    (void)state;
    world *w = create_built_room();
    rsv_elements *e;
    uint64_t rays = 0;
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = 0.13f }, &e), RSV_OK);
    assert_int_equal(rsv_elements_refine_contacts(&w->transport, 10000, NULL, &e, &rays), RSV_OK);
    size_t cut = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        rsv_cell_shape shape = rsv_cell_shape_of(e, c);
        if (!(e->cell_openness[c] & RSV_CELL_CUT) || depth_in_walls(shape.corner[0]) > OUT - 1.01f)
            continue;
        cut++;
        for (int k = 0; k < 3; k++) {
            float depth = depth_in_walls(rsv_cell_inset(&shape, shape.corner[k]));
            bool open = e->cell_openness[c] >> k & 1;
            if (depth > 1e-4f && depth < OUT - 1.01f && open)
                fail_msg("corner at (%g, %g, %g) is open", shape.corner[k].x, shape.corner[k].y,
                    shape.corner[k].z);
        }
    }
    assert_true(cut > 100);
    rsv_elements_destroy(e);
    world_end(w);
}

/// A box that reaches through the floor of a room.
static world *create_sunk_box(bool two_sided)
{
    world *w = world_begin(2);
    rsv_material paint = lambert_material(0.7f, 0);
    paint.double_sided = two_sided;
    uint32_t painted = world_material(w, paint);
    world_room(w, painted, v3(-1, 0, -1), v3(1, 1, 1));
    world_box(w, painted, v3(-0.31f, -0.2f, -0.32f), v3(0.33f, 0.4f, 0.34f));
    world_commit(w);
    return w;
}

/// Openness of all cells. @param rays out
static rsv_elements *judge_openness(
    const world *w, const rsv_transport_scene *scene, uint64_t *rays)
{
    rsv_elements *e;
    *rays = 0;
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = 0.13f }, &e), RSV_OK);
    assert_int_equal(rsv_elements_find_open_corners(scene, NULL, e, rays), RSV_OK);
    return e;
}

static void no_ray_looks_for_insides_where_there_are_none(void **state)
{
    (void)state;
    for (int sides = 1; sides <= 2; sides++) {
        world *w = create_sunk_box(sides == 2);
        rsv_world *solved;
        uint64_t rays, fewer;
        assert_int_equal(rsv_world_create(w->scene, &solved), RSV_OK);
        rsv_elements *looked = judge_openness(w, &w->transport, &rays);
        rsv_elements *known = judge_openness(w, &solved->scene, &fewer);
        assert_int_equal(solved->scene.no_insides, sides == 2);
        assert_memory_equal(looked->cell_openness, known->cell_openness, looked->cell_count);
        assert_int_equal(fewer < rays, sides == 2);
        rsv_elements_destroy(looked);
        rsv_elements_destroy(known);
        rsv_world_release(solved);
        world_end(w);
    }
}

static void where_walls_run_on_into_each_other_there_are_no_spots(void **state)
{
    (void)state;
    world *w = create_built_room();
    rsv_light *s = solve_small(w, 0);
    enum { PLACES = 120 };
    rsv_probe probe[PLACES];
    for (int k = 0; k < PLACES; k++) { // below the ceiling and beside a corner, a centimetre away
        float t = ((float)(k / 3) + 0.5f) / (PLACES / 3), x = 1.96f * t - 0.98f;
        const rsv_probe place[3] = { { v3(x, 0.99f, -1), v3(0, 0, 1) },
            { v3(-1, 0.99f, x), v3(1, 0, 0) }, { v3(-1, t, -0.99f), v3(1, 0, 0) } };
        probe[k] = place[k % 3];
    }
    shares found = stored_shares(w, s, probe, PLACES);
    rsv_light_destroy(s);
    world_end(w);
    if (found.least < 0.95f || found.largest > 1.07f || fabsf(found.mean - 1) > 0.03f)
        fail_msg("%g to %g of the light, %g on average", found.least, found.largest, found.mean);
}

/// Visibility was tested for exactly those points from which the rays of rows start.
static void rows_start_from_the_points_that_were_judged(void **state)
{
    (void)state;
    world *w = create_built_room();
    rsv_light *s;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 700;
    desc.rays_per_element = 64;
    desc.refinements = 2;
    assert_int_equal(rsv_light_create(w->scene, &desc, &s), RSV_OK);
    const rsv_elements *e = inside(s)->elements;
    uint64_t rays = 0;
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (e->node_hanging[n] != RSV_NONE) continue;
        uint16_t judged = rsv_judge_points(&inside(s)->scene, e, n, n,
            (rsv_support_draw){ RSV_SUPPORT_POINTS, inside(s)->desc.seed }, &rays);
        if (inside(s)->valid_points[n] != judged)
            fail_msg("node %u of %zu: %04x of the points count, %04x were to", n, e->node_count,
                judged, inside(s)->valid_points[n]);
    }
    rsv_light_destroy(s);
    world_end(w);
}

/// The part of a wall that a picture hides must not darken the visible part.
static void the_wall_around_a_picture_is_not_darkened(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    world_room(w, paint, v3(-1, 0, -1), v3(1, 1, 1));
    world_box(w, paint, v3(-0.23f, 0.31f, -0.995f), v3(0.27f, 0.69f, -0.97f));
    add_lamp(w);
    world_commit(w);
    rsv_light *s = solve_small(w, 0);
    enum { PLACES = 96 };
    rsv_probe probe[PLACES];
    for (int k = 0; k < PLACES; k++) { // three centimetres away
        float t = ((float)(k / 4) + 0.5f) / (PLACES / 4);
        float x = -0.23f + 0.5f * t, y = 0.31f + 0.38f * t;
        const rsv_vec3 place[4] = { v3(-0.26f, y, -1), v3(0.3f, y, -1), v3(x, 0.28f, -1),
            v3(x, 0.72f, -1) };
        probe[k] = (rsv_probe){ place[k % 4], v3(0, 0, 1) };
    }
    shares found = stored_shares(w, s, probe, PLACES);
    rsv_light_destroy(s);
    world_end(w);
    if (found.least < 0.78f || fabsf(found.mean - 1) > 0.06f)
        fail_msg("%g of the light at least, %g on average", found.least, found.mean);
}

/// Nodes under a box are black, but must not darken the floor around it.
static void the_floor_beside_a_box_is_not_darkened(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    world_room(w, paint, v3(-1, 0, -1), v3(1, 1, 1));
    world_box(w, paint, v3(-0.23f, 0, -0.31f), v3(0.27f, 0.3f, 0.19f));
    add_lamp(w);
    world_commit(w);
    rsv_light *s = solve_small(w, 0);
    enum { PLACES = 48 };
    rsv_probe probe[PLACES];
    for (int k = 0; k < PLACES; k++) { // around the box, a centimetre away
        float t = ((float)(k / 4) + 0.5f) / (PLACES / 4);
        float x = -0.23f + 0.5f * t, z = -0.31f + 0.5f * t;
        const rsv_vec3 place[4] = { v3(-0.24f, 0, z), v3(0.28f, 0, z), v3(x, 0, -0.32f),
            v3(x, 0, 0.2f) };
        probe[k] = (rsv_probe){ place[k % 4], v3(0, 1, 0) };
    }
    float least = stored_shares(w, s, probe, PLACES).least;
    if (least < 0.5f) fail_msg("%g of the light is stored", least);
    rsv_light_destroy(s);
    world_end(w);
}

/// A panel just below the ceiling that lights it: nodes at its border must not pass that light on.
static void a_lamp_close_to_the_ceiling_keeps_its_light_there(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.7f, 0), v3(-1, 0, -1), v3(1, 1, 1));
    world_quad(w, world_lambert(w, 0, 10), v3(-0.3f, 0.98f, -0.3f), v3(-0.3f, 0.98f, 0.3f),
        v3(0.3f, 0.98f, 0.3f), v3(0.3f, 0.98f, -0.3f));
    world_commit(w);
    rsv_light *s = solve_small(w, 0);
    enum { PLACES = 64 };
    rsv_probe probe[PLACES];
    rsv_probe_reading exact[PLACES];
    for (int k = 0; k < PLACES; k++) {
        float x = ((float)(k % 8) - 3.5f) / 4, z = ((float)(k / 8) - 3.5f) / 4;
        probe[k] = (rsv_probe){ v3(x, 0, z), v3(0, 1, 0) };
    }
    assert_int_equal(rsv_probe_irradiance(s,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_REFERENCE, 4096, 1 },
                         probe, PLACES, exact),
        RSV_OK);
    float stored = 0, traced = 0;
    for (int k = 0; k < PLACES; k++) {
        stored += look_up(w, s, probe[k].position, probe[k].normal, RSV_NONE);
        traced += exact[k].irradiance.g;
    }
    rsv_light_destroy(s);
    world_end(w);
    if (fabsf(stored / traced - 1) > 0.15f)
        fail_msg("the floor has %.3f of the light that paths bring there", stored / traced);
}

static rsv_vec3 beneath(int k)
{
    float along = 0.5f * ((float)(k / 4) + 0.5f) / 24, in = 0.005f + 0.015f * (float)(k / 4 % 6);
    float x = -0.23f + along, z = -0.31f + along;
    const rsv_vec3 place[4] = { v3(-0.23f + in, 0, z), v3(0.27f - in, 0, z), v3(x, 0, -0.31f + in),
        v3(x, 0, 0.19f - in) };
    return place[k % 4];
}

/// An object close to a floor leaves little light on it, but some: that of the gap, which the floor's own cells store.
static void light_in_a_gap_is_that_of_the_gap(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    world_room(w, paint, v3(-1, 0, -1), v3(1, 1, 1));
    world_box(w, paint, v3(-0.23f, 0.02f, -0.31f), v3(0.27f, 0.3f, 0.19f));
    add_lamp(w);
    world_commit(w);
    rsv_light *s = solve_small(w, 0);
    enum { PLACES = 96 };
    rsv_probe probe[PLACES];
    for (int k = 0; k < PLACES; k++) // up to eight centimetres in, along the four sides
        probe[k] = (rsv_probe){ beneath(k), v3(0, 1, 0) };
    shares found = stored_shares(w, s, probe, PLACES);
    rsv_light_destroy(s);
    world_end(w);
    if (found.least < 0.4f || found.largest > 2.5f || fabsf(found.mean - 1) > 0.15f)
        fail_msg("%g to %g of the light, %g on average", found.least, found.largest, found.mean);
}

/// A dark storey above a bright one, a thin floor between them at y = 0.
static world *begin_storeys(void)
{
    world *w = world_begin(2);
    rsv_material sheet = lambert_material(0.7f, 0);
    sheet.double_sided = true;
    world_room(w, world_lambert(w, 0.7f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_quad(w, world_material(w, sheet), v3(-1.02f, 0, 1.02f), v3(1.02f, 0, 1.02f),
        v3(1.02f, 0, -1.02f), v3(-1.02f, 0, -1.02f));
    world_quad(w, world_lambert(w, 0, 10), v3(-0.8f, -0.99f, 0.8f), v3(0.8f, -0.99f, 0.8f),
        v3(0.8f, -0.99f, -0.8f), v3(-0.8f, -0.99f, -0.8f));
    return w;
}

/// The most light on the sides of a body on the floor, over that below the floor, from six millimetres (the least split cells) to two centimetres above it.
static float most_light_at_foot(const world *w, rsv_vec3 low, rsv_vec3 high)
{
    rsv_light *s = solve_small(w, 0);
    float most = 0;
    for (int k = 0; k < 200; k++) {
        float t = ((float)(k % 20) + 0.5f) / 20, y = 0.002f * (float)(k / 20) + 0.006f;
        rsv_vec3 in_front = v3(low.x + t * (high.x - low.x), y, high.z);
        rsv_vec3 beside = v3(high.x, y, low.z + t * (high.z - low.z));
        most = f_max(most, look_up(w, s, in_front, v3(0, 0, 1), RSV_NONE));
        most = f_max(most, look_up(w, s, beside, v3(1, 0, 0), RSV_NONE));
    }
    rsv_hit hit;
    assert_true(rsv_tracer_nearest(w->tracer, v3(high.x + 0.1f, 0, high.z), v3(0, -1, 0), &hit));
    float below = rsv_light_irradiance(s, hit.triangle, hit.u, hit.v, true, RSV_NONE).g;
    assert_true(below > 5);
    rsv_light_destroy(s);
    return most / below;
}

/// An object on a thin floor, which it pierces slightly: its foot receives light from above the floor, and none from
/// below.
static void feet_that_reach_through_a_floor_stay_dark(void **state)
{
    (void)state;
    const rsv_vec3 low = v3(0.1f, -0.0025f, 0.2f), high = v3(0.16f, 0.1f, 0.26f);
    world *w = begin_storeys();
    world_box(w, world_lambert(w, 0.7f, 0), low, high);
    world_commit(w);
    float most = most_light_at_foot(w, low, high);
    world_end(w);
    if (most > 0.01f) fail_msg("%g of the light below the floor", most);
}

/// The base of a body whose normals are smooth around its edges shares nodes with its sides, but not if the floor that it
/// stands on, in the very same plane, is between them.
static void smooth_bodies_on_a_floor_stay_dark(void **state)
{
    (void)state;
    const rsv_vec3 low = v3(0.1f, 0, 0.2f), high = v3(0.3f, 0.2f, 0.4f);
    const uint32_t index[12][3] = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 },
        { 1, 5, 4 }, { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
    rsv_vec3 position[8], normal[8];
    for (int k = 0; k < 8; k++) {
        position[k] = v3(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
        normal[k] = v3_normalize(v3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    }
    world *w = begin_storeys();
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "pot",
        .positions = position,
        .normals = normal,
        .vertex_count = 8,
        .indices = index[0],
        .triangle_count = 12,
        .material = world_lambert(w, 0.7f, 0) };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, id, NULL, NULL), RSV_OK);
    world_commit(w);
    float most = most_light_at_foot(w, low, high);
    world_end(w);
    if (most > 0.01f) fail_msg("%g of the light below the floor", most);
}

/// A small plate in a frame that touches all of its corners, behind bars or not: its light over what is gathered there.
static shares shares_on_plate(bool bars)
{
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    const float edge = 0.06f, in = 0.04f, back = -0.995f, front = -0.98f;
    world_room(w, paint, v3(-1, 0, -1), v3(1, 1, 1));
    world_quad(w, paint, v3(-edge, 0.5f - edge, -0.99f), v3(edge, 0.5f - edge, -0.99f),
        v3(edge, 0.5f + edge, -0.99f), v3(-edge, 0.5f + edge, -0.99f));
    world_box(w, paint, v3(-edge, 0.5f - edge, back), v3(edge, 0.5f - in, front));
    world_box(w, paint, v3(-edge, 0.5f + in, back), v3(edge, 0.5f + edge, front));
    world_box(w, paint, v3(-edge, 0.5f - in, back), v3(-in, 0.5f + in, front));
    world_box(w, paint, v3(in, 0.5f - in, back), v3(edge, 0.5f + in, front));
    for (int k = 0; k < 2 && bars; k++) { // before the middles of the plate's two triangles
        float y = k ? 0.52f : 0.48f;
        world_box(w, paint, v3(-edge, y - 0.004f, -0.982f), v3(edge, y + 0.004f, -0.975f));
    }
    add_lamp(w);
    world_commit(w);
    rsv_light *s = solve_small(w, 0);
    enum { PLACES = 36 };
    rsv_probe probe[PLACES];
    for (int k = 0; k < PLACES; k++) {
        float x = 0.01f * ((float)(k % 6) - 2.5f), y = 0.01f * ((float)(k / 6) - 2.5f);
        probe[k] = (rsv_probe){ v3(x, 0.5f + y, -0.99f), v3(0, 0, 1) };
    }
    shares found = stored_shares(w, s, probe, PLACES);
    rsv_light_destroy(s);
    world_end(w);
    return found;
}

static void a_plate_in_a_frame_is_lit(void **state)
{
    (void)state;
    shares found = shares_on_plate(false);
    if (found.least < 0.8f || found.largest > 1.2f || fabsf(found.mean - 1) > 0.1f)
        fail_msg("%g to %g of the light, %g on average", found.least, found.largest, found.mean);
}

static void a_plate_behind_bars_is_lit(void **state)
{
    (void)state;
    shares found = shares_on_plate(true);
    if (found.least < 0.4f || found.largest > 2.5f || fabsf(found.mean - 1) > 0.15f)
        fail_msg("%g to %g of the light, %g on average", found.least, found.largest, found.mean);
}

// ---- closed rooms in daylight ---------------------------------------------------------------------

/// Half the inner size of a room built of boxes, and its height.
#define HALF_X 2.0f
#define HALF_Z 2.5f
#define CEILING 2.6f

/// A closed room of four walls and a roof that juts out, white sky all around. The walls stand on a slab that is lit
/// outside, or reach through a sheet.
static world *create_closed_room(float thickness, bool on_sheet)
{
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    const float low = on_sheet ? -0.1f : 0, high = CEILING - low, x = HALF_X + thickness,
                z = HALF_Z + thickness;
    world_box(w, paint, v3(-x, low, -HALF_Z), v3(-HALF_X, high, HALF_Z));
    world_box(w, paint, v3(HALF_X, low, -HALF_Z), v3(x, high, HALF_Z));
    world_box(w, paint, v3(-x, low, -z), v3(x, high, -HALF_Z));
    world_box(w, paint, v3(-x, low, HALF_Z), v3(x, high, z));
    world_box(w, paint, v3(-3, CEILING, -3.5f), v3(3, CEILING + 0.2f, 3.5f));
    if (on_sheet)
        world_quad(w, paint, v3(-6, 0, 6), v3(6, 0, 6), v3(6, 0, -6), v3(-6, 0, -6));
    else
        world_box(w, paint, v3(-5, -0.2f, -5.5f), v3(5, 0, 5.5f));
    assert_int_equal(rsv_scene_set_builtin_environment(w->scene, "white", 1, 0), RSV_OK);
    world_commit(w);
    return w;
}

/// The most light within the room: on its floor, its ceiling and a wall, down to two millimetres from where they meet.
static float most_light_inside(const world *w, const rsv_light *s)
{
    const float distance[] = { 0.002f, 0.01f, 0.05f, 0.3f };
    float most = 0;
    for (int d = 0; d < 4; d++)
        for (int k = 0; k < 40; k++) {
            float t = ((float)k + 0.5f) / 40, x = HALF_X - distance[d],
                  z = (2 * t - 1) * (HALF_Z - 0.002f);
            most = f_max(most, look_up(w, s, v3(x, 0, z), v3(0, 1, 0), RSV_NONE));
            most = f_max(most, look_up(w, s, v3(-x, CEILING, z), v3(0, -1, 0), RSV_NONE));
            most = f_max(most, look_up(w, s, v3(HALF_X, distance[d], z), v3(-1, 0, 0), RSV_NONE));
        }
    return most;
}

static void check_closed_room(float thickness, bool on_sheet)
{
    world *w = create_closed_room(thickness, on_sheet);
    rsv_light *s = solve_with(w, 3000, 64, 0);
    float inside_it = most_light_inside(w, s),
          outside = look_up(w, s, v3(3.5f, 0, 0), v3(0, 1, 0), RSV_NONE);
    rsv_light_destroy(s);
    world_end(w);
    if (!(outside > 1 && inside_it < 1e-4f * outside))
        fail_msg("walls of %g m: %g inside, %g outside", thickness, inside_it, outside);
}

static void closed_rooms_in_daylight_are_dark(void **state)
{
    (void)state;
    check_closed_room(0.03f, false);
    check_closed_room(0.03f, true);
    check_closed_room(0.2f, true);
}

// ---- cells that a wall cuts -----------------------------------------------------------------------

/// Shares of a cell are the integrals of its corners' weights, and no weight reaches across the wall.
static void check_cut(const float side[3])
{
    enum { STEPS = 400 };
    uint32_t cut = 0;
    float line[1][3], share[3];
    double sum[3] = { 0 };
    memcpy(line[0], side, sizeof line[0]);
    rsv_elements e = { .cell_cut = &cut, .cut_side = line, .cut_count = 1 };
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            float u = ((float)i + 0.5f) / STEPS, v = ((float)j + 0.5f) / STEPS;
            float weight[3] = { 1 - u - v, u, v };
            float here = side[0] * weight[0] + side[1] * u + side[2] * v;
            if (u + v >= 1) continue;
            rsv_keep_side(side, weight);
            assert_float_equal(weight[0] + weight[1] + weight[2], 1, 1e-5f);
            for (int k = 0; k < 3; k++) {
                assert_true(weight[k] >= 0 && (weight[k] == 0 || side[k] * here >= 0));
                sum[k] += 2 * (double)weight[k] / (STEPS * STEPS);
            }
        }
    rsv_cell_shares(&e, 0, share);
    for (int k = 0; k < 3; k++)
        assert_float_equal(share[k], sum[k], 0.01f);
}

static void shares_of_cut_cells_are_integrals_of_weights(void **state)
{
    (void)state;
    check_cut((float[3]){ 1, -1, -1 });
    check_cut((float[3]){ -0.2f, 1, -0.7f });
    check_cut((float[3]){ 0.5f, 0.4f, -1 });
    check_cut((float[3]){ 0, 1, -0.3f });
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_rooms_in_daylight_are_dark),
        cmocka_unit_test(shares_of_cut_cells_are_integrals_of_weights),
        cmocka_unit_test(a_thin_wall_on_the_grid_keeps_light_out),
        cmocka_unit_test(a_thick_wall_keeps_light_out),
        cmocka_unit_test(a_thick_wall_that_just_touches_keeps_light_out),
        cmocka_unit_test(contacts_take_no_more_nodes_than_allowed),
        cmocka_unit_test(contacts_matter_as_much_as_the_goal_says),
        cmocka_unit_test(large_cells_are_looked_at_in_their_middle),
        cmocka_unit_test(the_floor_beside_a_box_is_not_darkened),
        cmocka_unit_test(a_lamp_close_to_the_ceiling_keeps_its_light_there),
        cmocka_unit_test(corners_within_walls_are_not_open),
        cmocka_unit_test(no_ray_looks_for_insides_where_there_are_none),
        cmocka_unit_test(where_walls_run_on_into_each_other_there_are_no_spots),
        cmocka_unit_test(rows_start_from_the_points_that_were_judged),
        cmocka_unit_test(the_wall_around_a_picture_is_not_darkened),
        cmocka_unit_test(light_in_a_gap_is_that_of_the_gap),
        cmocka_unit_test(feet_that_reach_through_a_floor_stay_dark),
        cmocka_unit_test(smooth_bodies_on_a_floor_stay_dark),
        cmocka_unit_test(a_plate_in_a_frame_is_lit),
        cmocka_unit_test(a_plate_behind_bars_is_lit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
