/// Surfaces with one light in a file show that of the side from which they are normally seen.
#include "bake/bake_side.h"
#include "light_fixture.h"
#include "light_view.h"
#include "slow_tests.h"

#define PAINT 0.5f

/// A world, solved, as one part of a file.
typedef struct baked {
    world *w;
    rsv_light *solution;
    rsv_bake_part part;
    uint32_t triangle[64];
} baked;

static uint32_t sheet_paint(world *w)
{
    rsv_material sheet = lambert_material(PAINT, 0);
    sheet.double_sided = true;
    return world_material(w, sheet);
}

static void lamp(world *w, float radiance)
{
    world_quad(w, world_lambert(w, 0, radiance), v3(-0.3f, 2.4f, -0.3f), v3(0.3f, 2.4f, -0.3f),
        v3(0.3f, 2.4f, 0.3f), v3(-0.3f, 2.4f, 0.3f));
}

static void surround(world *w, float radiance)
{
    const rsv_rgb pixel[2] = { { radiance, radiance, radiance }, { radiance, radiance, radiance } };
    const rsv_environment sky = { "sky", pixel, 2, 1, 1, 0 };
    assert_int_equal(rsv_scene_set_environment(w->scene, &sky), RSV_OK);
}

static void bake(baked *b)
{
    world_commit(b->w);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 700;
    desc.rays_per_element = 64;
    assert_int_equal(rsv_light_create(b->w->scene, &desc, &b->solution), RSV_OK);
    size_t count = inside(b->solution)->scene.view->triangle_count;
    assert_true(count <= 64);
    for (uint32_t t = 0; t < count; t++)
        b->triangle[t] = t;
    b->part = (rsv_bake_part){ .triangle = b->triangle, .triangle_count = count };
    assert_int_equal(rsv_bake_choose_sides(inside(b->solution), &b->part), RSV_OK);
}

static void discard(baked *b)
{
    rsv_free(inside(b->solution)->context, b->part.back);
    rsv_light_destroy(b->solution);
    world_end(b->w);
}

static float light_on(const baked *b, uint32_t t, bool back)
{
    return rsv_light_irradiance(b->solution, t, 1.0f / 3, 1.0f / 3, back, RSV_NONE).g;
}

static void assert_shown(const baked *b, uint32_t first, uint32_t end, bool back)
{
    for (uint32_t t = first; t < end; t++)
        assert_int_equal(b->part.back[t], back);
}

/// A cushion without a bottom, a hand above the floor: its front is inside.
static void add_cushion(world *w, uint32_t paint)
{
    const rsv_vec3 p[8] = { { -0.3f, 0.1f, -0.3f }, { 0.3f, 0.1f, -0.3f }, { 0.3f, 0.1f, 0.3f },
        { -0.3f, 0.1f, 0.3f }, { -0.3f, 0.3f, -0.3f }, { 0.3f, 0.3f, -0.3f }, { 0.3f, 0.3f, 0.3f },
        { -0.3f, 0.3f, 0.3f } };
    static const uint32_t side[10][3] = { { 0, 1, 5 }, { 0, 5, 4 }, { 1, 2, 6 }, { 1, 6, 5 },
        { 2, 3, 7 }, { 2, 7, 6 }, { 3, 0, 4 }, { 3, 4, 7 }, { 4, 5, 6 }, { 4, 6, 7 } };
    world_triangles(w, paint, p, 8, side[0], 10);
}

/// @param radiance of the lamp in the room; that of the sky outside is 1
static void bake_furnished_room(baked *b, float radiance)
{
    world *w = b->w = world_begin(2);
    uint32_t paint = sheet_paint(w);
    world_room(w, paint, v3(-1.5f, 0, -1.5f), v3(1.5f, 2.5f, 1.5f));
    add_cushion(w, paint);
    // a skirting board a centimetre off the wall, its front to the wall
    world_quad(
        w, paint, v3(-1, 0, -1.49f), v3(-1, 0.1f, -1.49f), v3(1, 0.1f, -1.49f), v3(1, 0, -1.49f));
    lamp(w, radiance);
    surround(w, 1);
    bake(b);
}

/// The first triangles: 12 of the room, 10 of the cushion, 2 of the skirting board.
static void rooms_in_the_sun_show_their_inside_and_cushions_their_outside(void **state)
{
    (void)state;
    for (int bright = 0; bright < 2; bright++) {
        baked b = { 0 };
        bake_furnished_room(&b, bright ? 8 : 1.2f);
        float inside = light_on(&b, 0, false) / light_on(&b, 0, true);
        float within = light_on(&b, 20, false) / light_on(&b, 20, true);
        print_message(
            "room %.3f, cushion %.3f of the light without\n", (double)inside, (double)within);
        assert_true(inside < (bright ? 0.5f : 0.05f)); // darker by far than the sunny side
        assert_true(within > 0.05f);                   // not dark by itself
        assert_shown(&b, 0, 12, false);
        assert_shown(&b, 12, 24, true);
        discard(&b);
    }
}

/// The same box with its fronts inside, and outside: nobody looks at it from the void.
static void rooms_turned_to_the_void_show_their_inside(void **state)
{
    (void)state;
    for (int turned = 0; turned < 2; turned++) {
        baked b = { .w = world_begin(2) };
        uint32_t paint = sheet_paint(b.w);
        const rsv_vec3 low = v3(-1.5f, 0, -1.5f), high = v3(1.5f, 2.5f, 1.5f);
        (turned ? world_box : world_room)(b.w, paint, low, high);
        lamp(b.w, 1);
        bake(&b);
        assert_shown(&b, 0, 12, turned);
        discard(&b);
    }
}

/// A sheet 3 cm above a table, its front down, so that it shows its back; from its edge hangs another that one sees, its back
/// to a board 2 cm away.
static void what_hangs_from_a_hidden_sheet_is_seen(void **state)
{
    (void)state;
    baked b = { .w = world_begin(2) };
    uint32_t paint = sheet_paint(b.w), wood = world_lambert(b.w, PAINT, 0);
    const rsv_vec3 near = v3(-1, 1.23f, -1), far = v3(-1, 1.23f, 1);
    world_quad(b.w, paint, near, v3(1, 1.23f, -1), v3(1, 1.23f, 1), far);
    world_quad(b.w, paint, near, far, v3(-1, 0.93f, 1), v3(-1, 0.93f, -1));
    world_quad(
        b.w, wood, v3(-0.98f, 1.2f, 1), v3(1, 1.2f, 1), v3(1, 1.2f, -1), v3(-0.98f, 1.2f, -1));
    world_quad(b.w, wood, v3(-1.02f, 0.8f, -1), v3(-1.02f, 1.23f, -1), v3(-1.02f, 1.23f, 1),
        v3(-1.02f, 0.8f, 1));
    world_room(b.w, wood, v3(-1.5f, 0, -1.5f), v3(1.5f, 2.5f, 1.5f));
    lamp(b.w, 1);
    world_quad(b.w, world_lambert(b.w, 0, 1), v3(1.45f, 0.2f, -0.5f), v3(1.45f, 0.2f, 0.5f),
        v3(1.45f, 1, 0.5f), v3(1.45f, 1, -0.5f));
    bake(&b);
    assert_shown(&b, 0, 2, true);
    assert_shown(&b, 2, 4, false);
    discard(&b);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(rooms_turned_to_the_void_show_their_inside),
        cmocka_unit_test(what_hangs_from_a_hidden_sheet_is_seen),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(rooms_in_the_sun_show_their_inside_and_cushions_their_outside),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
