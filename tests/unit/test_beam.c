/// Beams against the ray tracer: whole pictures, and cases that could slip through.
#include "copies_fixture.h"
#include "frame/packet_kernels.h"
#include "trace/packet.h"
#include "trace/tracer_update.h"

#include "frame_fixture.h"
#include "resolvent/relight.h"

/// Tiles and pixels of a picture: the last tiles are cut off, and a row and a column lie in the middle.
enum { across = 10, down = 6, columns = across * RSV_TILE - 7, rows = down * RSV_TILE - 11 };

/// A picture in the making.
typedef struct picture {
    const rsv_packet_kernels *kernels;
    rsv_frame_aim aim;
    rsv_beam_lens lens;
    rsv_beams beams;
    const rsv_tracer *tracer;
} picture;

/// How the rays of beams compare with those of the ray tracer.
typedef struct comparison {
    size_t rays;
    size_t other; ///< met another triangle
    size_t apart; ///< at another distance, or the one met nothing
    double most;  ///< difference of weights
} comparison;

static picture picture_of(
    const rsv_tracer *tracer, const rsv_camera *camera, rsv_instructions instructions)
{
    picture p = { .kernels = rsv_packet_kernels_for(&instructions), .tracer = tracer };
    p.aim = (rsv_frame_aim){ rsv_lens_of(camera, columns, rows), columns, rows, 0.3f, 0.6f, 0,
        { 0, 0 } };
    p.lens = rsv_beam_lens_of(&p.aim.lens);
    assert_int_equal(rsv_beams_create(tracer, &p.beams), RSV_OK);
    assert_true(p.beams.hold);
    return p;
}

static bool gather(const picture *p, uint32_t column, uint32_t row, rsv_beam *beam)
{
    float right = f_min((float)(column + RSV_TILE), (float)p->aim.width) - 1,
          bottom = f_min((float)(row + RSV_TILE), (float)p->aim.height) - 1;
    float low[2] = { (float)column + p->aim.place_x, (float)row + p->aim.place_y },
          high[2] = { right + p->aim.place_x, bottom + p->aim.place_y };
    memset(beam, 0, sizeof *beam);
    return p->lens.usable && p->kernels->gather(&p->beams, &p->lens, low, high, beam);
}

static void aim(const picture *p, uint32_t column, uint32_t row, rsv_ray_packet *packet)
{
    memset(packet, 0, sizeof *packet);
    memset(packet->mask, 0xff, sizeof packet->mask);
    p->kernels->aim(&p->aim, column, row, packet);
}

static void compare_lane(const rsv_ray_packet *a, const rsv_ray_packet *b, int k, comparison *c)
{
    if (b->t_max[k] == -1) { // outside the picture
        assert_true(a->t_max[k] == -1 && a->triangle[k] == RSV_NONE);
        return;
    }
    c->rays++;
    bool alike_far = a->t_max[k] == b->t_max[k] || // both infinite, say
                     fabsf(a->t_max[k] - b->t_max[k]) <= 4e-6f * b->t_max[k];
    c->apart += !alike_far;
    c->other += a->triangle[k] != b->triangle[k];
    if (a->triangle[k] != b->triangle[k] || a->triangle[k] == RSV_NONE) return;
    double u = fabs((double)a->u[k] - b->u[k]), v = fabs((double)a->v[k] - b->v[k]);
    c->most = fmax(c->most, fmax(u, v));
    assert_int_equal(rsv_packet_meets_back(a, (uint32_t)k), rsv_packet_meets_back(b, (uint32_t)k));
}

static void compare_tile(const picture *p, uint32_t column, uint32_t row, comparison *c)
{
    rsv_beam beam;
    if (!gather(p, column, row, &beam)) return;
    for (uint32_t block = 0; block < 64; block++) {
        rsv_ray_packet met, traced;
        uint32_t x = column + block % 8 * RSV_BLOCK, y = row + block / 8 * RSV_BLOCK;
        aim(p, x, y, &met);
        aim(p, x, y, &traced);
        p->kernels->meet(&beam, &met);
        rsv_tracer_closest_packet(p->tracer, &traced, true);
        for (int k = 0; k < RSV_PACKET_WIDTH; k++)
            compare_lane(&met, &traced, k, c);
    }
}

static comparison compare(const rsv_tracer *tracer, const rsv_camera *camera)
{
    comparison c = { 0 };
    picture p = picture_of(tracer, camera, RSV_INSTRUCTIONS_BEST);
    for (uint32_t tile = 0; tile < across * down; tile++)
        compare_tile(&p, tile % across * RSV_TILE, tile / across * RSV_TILE, &c);
    return c;
}

/// Rays within rounding of an edge may go either way.
static void check_alike(const rsv_tracer *tracer, const rsv_camera *camera, comparison *sum)
{
    comparison c = compare(tracer, camera);
    if (c.other > 20 || c.apart > 4 || c.most > 1e-3)
        fail_msg("%zu rays: %zu other triangles, %zu apart, weights differ by %g", c.rays, c.other,
            c.apart, c.most);
    sum->rays += c.rays;
    sum->other += c.other;
    sum->apart += c.apart;
}

/// Rolled by a tenth of a turn, and looking to a side.
static rsv_camera turned(rsv_camera c, float side)
{
    float cosine = cosf(0.63f), sine = sinf(0.63f);
    rsv_vec3 forward = v3_normalize(v3_mad(c.forward, side, c.right));
    rsv_vec3 right = v3_normalize(v3_cross(forward, c.up)), up = v3_cross(right, forward);
    c.forward = forward;
    c.right = v3_mad(v3_scale(right, cosine), sine, up);
    c.up = v3_mad(v3_scale(up, cosine), -sine, right);
    return c;
}

/// From the camera's position and from others: outside, rotated, as if in a mirror, wide, and close to the surface.
static void check_views(world *w, double least_share)
{
    comparison sum = { 0 };
    if (!w->tracer) assert_int_equal(rsv_tracer_create(w->scene, &w->tracer), RSV_OK);
    rsv_camera own = rsv_scene_get_view(w->scene)->camera[0], c = own;
    check_alike(w->tracer, &own, &sum);
    if ((double)sum.rays < least_share * columns * rows) fail_msg("%zu rays alone", sum.rays);
    c.position = v3_mad(own.position, -7.3f, own.forward);
    check_alike(w->tracer, &c, &sum);
    c = turned(own, 0.9f);
    check_alike(w->tracer, &c, &sum);
    c.right = v3_neg(c.right);
    check_alike(w->tracer, &c, &sum);
    c.vertical_fov = 2.8f;
    check_alike(w->tracer, &c, &sum);
    rsv_ray ray = { own.position, v3_normalize(v3_mad(own.forward, 0.4f, own.right)), INFINITY };
    rsv_hit hit;
    if (rsv_tracer_closest(w->tracer, &ray, &hit)) {
        c = turned(own, 0.7f);
        c.position = v3_mad(ray.origin, hit.t - 1e-3f, ray.direction);
        check_alike(w->tracer, &c, &sum);
    }
    assert_true(sum.other < sum.rays / 5000 && sum.apart < sum.rays / 20000);
    world_end(w);
}

static void beams_meet_what_the_tracer_meets(void **state)
{
    (void)state;
    check_views(world_builtin(2, "cornell-blocks"), 1);
    check_views(world_builtin(2, "cornell-spheres"), 0.7);
    check_views(world_builtin(2, "gallery:1"), 0.8);
    check_views(world_builtin(2, "two-rooms"), 0.9);
    check_views(create_copied_room(NULL, MIXED), 0.9);
    check_views(create_copied_room(NULL, INSIDE), 0.9);
}

static void all_instructions_meet_the_same_bytes(void **state)
{
    (void)state;
    world *w = world_builtin(2, "gallery:1");
    assert_int_equal(rsv_tracer_create(w->scene, &w->tracer), RSV_OK);
    const rsv_camera *camera = rsv_scene_get_view(w->scene)->camera;
    uint64_t first = 0;
    for (int k = RSV_INSTRUCTIONS_PORTABLE; rsv_instructions_name((rsv_instructions)k); k++) {
        if (!rsv_has_instructions((rsv_instructions)k)) continue;
        picture p = picture_of(w->tracer, camera, (rsv_instructions)k);
        uint64_t hash = HASH_START;
        for (uint32_t tile = 0; tile < across * down; tile++) {
            rsv_beam beam;
            rsv_ray_packet packet;
            uint32_t column = tile % across * RSV_TILE, row = tile / across * RSV_TILE;
            bool had = gather(&p, column, row, &beam);
            hash = hash_bytes(hash, &had, sizeof had);
            for (uint32_t block = 0; had && block < 64; block++) {
                aim(&p, column + block % 8 * RSV_BLOCK, row + block / 8 * RSV_BLOCK, &packet);
                p.kernels->meet(&beam, &packet);
                hash = hash_bytes(hash, &packet, sizeof packet);
            }
        }
        if (k == RSV_INSTRUCTIONS_PORTABLE) first = hash;
        assert_true(hash == first);
    }
    world_end(w);
}

// ---- what could slip through --------------------------------------------------------------------

static world *commit(world *w)
{
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    assert_int_equal(rsv_tracer_create(w->scene, &w->tracer), RSV_OK);
    return w;
}

static const rsv_vec3 eye = { 0.2f, 0.3f, 4 };

static rsv_camera looking_at_the_origin(void)
{
    return rsv_camera_look_at("front", eye, v3(0, 0, 0), 0.9f, (float)across / (float)down);
}

static void add_triangle(world *w, uint32_t material, const rsv_vec3 corner[3])
{
    static const uint32_t index[3] = { 0, 1, 2 };
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "triangle",
        .positions = corner,
        .vertex_count = 3,
        .indices = index,
        .triangle_count = 1,
        .material = material };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, id, NULL, NULL), RSV_OK);
}

/// Specks of a hundredth of a pixel, each hit by the ray at a tile's corner.
static void a_speck_at_the_corner_of_a_tile_is_met(void **state)
{
    (void)state;
    const uint32_t place[4][2] = { { 96, 64 }, { 127, 64 }, { 96, 95 }, { 127, 95 } };
    world *w = world_begin(1);
    rsv_camera camera = looking_at_the_origin();
    rsv_lens lens = rsv_lens_of(&camera, columns, rows);
    uint32_t gray = world_lambert(w, 0.5f, 0);
    world_quad(w, gray, v3(-9, -9, -1), v3(9, -9, -1), v3(9, 9, -1), v3(-9, 9, -1));
    for (int k = 0; k < 4; k++) {
        rsv_ray ray = rsv_lens_ray(&lens, (float)place[k][0] + 0.3f, (float)place[k][1] + 0.6f);
        rsv_vec3 at = v3_mad(ray.origin, 3, ray.direction);
        const rsv_vec3 corner[3] = { v3_mad(at, 1e-4f, camera.right), v3_mad(at, 1e-4f, camera.up),
            v3_mad(v3_mad(at, -1e-4f, camera.right), -1e-4f, camera.up) };
        add_triangle(w, gray, corner);
    }
    commit(w);
    picture p = picture_of(w->tracer, &camera, RSV_INSTRUCTIONS_BEST);
    rsv_beam beam;
    assert_true(gather(&p, 96, 64, &beam));
    for (int k = 0; k < 4; k++) {
        rsv_ray_packet packet;
        uint32_t x = place[k][0] / 4 * 4, y = place[k][1] / 4 * 4;
        aim(&p, x, y, &packet);
        p.kernels->meet(&beam, &packet);
        assert_int_equal(packet.triangle[(place[k][1] - y) * 4 + place[k][0] - x], 2 + k);
    }
    world_end(w);
}

/// A wall that is in the scene twice, with two materials.
static void of_two_walls_in_one_place_the_tracers_is_met(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_camera camera = looking_at_the_origin();
    uint32_t material[2] = { world_lambert(w, 0.5f, 0), world_lambert(w, 0.1f, 0) };
    for (int k = 0; k < 2; k++)
        world_quad(w, material[k], v3(-9, -9, -1), v3(9, -9, -1), v3(9, 9, -1), v3(-9, 9, -1));
    commit(w);
    comparison c = compare(w->tracer, &camera);
    assert_true(c.rays > 1000);
    if (c.other > 20) fail_msg("of %zu rays %zu meet the other wall", c.rays, c.other);
    world_end(w);
}

/// A triangle two metres long and a hundredth of a millimetre wide, and rays past its short edge along its length.
static void slivers_end_where_they_end(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_camera camera = looking_at_the_origin();
    rsv_lens lens = rsv_lens_of(&camera, columns, rows);
    uint32_t gray = world_lambert(w, 0.5f, 0);
    world_quad(w, gray, v3(-9, -9, -1), v3(9, -9, -1), v3(9, 9, -1), v3(-9, 9, -1));
    rsv_ray middle = rsv_lens_ray(&lens, 112, 80);
    rsv_vec3 foot = v3_mad(middle.origin, 4, middle.direction), along = v3(0.6f, 0.8f, 0);
    const rsv_vec3 corner[3] = { foot, v3_mad(foot, 2, along),
        v3_add(foot, v3(-0.8e-5f, 0.6e-5f, 0)) };
    add_triangle(w, gray, corner);
    commit(w);
    picture p = picture_of(w->tracer, &camera, RSV_INSTRUCTIONS_BEST);
    rsv_beam beam;
    assert_true(gather(&p, 96, 64, &beam));
    bool gathered = false;
    for (uint32_t k = 0; k < beam.count; k++)
        gathered = gathered || beam.of[k].triangle == 2;
    assert_true(gathered);
    rsv_ray_packet packet;
    aim(&p, 112, 80, &packet);
    rsv_vec3 edge = v3_scale(v3_add(foot, corner[2]), 0.5f);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_vec3 past = v3_mad(edge, -0.002f * (float)(k + 1), along);
        rsv_vec3 towards = v3_normalize(v3_sub(past, middle.origin));
        rsv_packet_set_ray(&packet, k, (rsv_ray){ middle.origin, towards, INFINITY });
    }
    p.kernels->meet(&beam, &packet);
    for (int k = 0; k < RSV_PACKET_WIDTH; k++)
        assert_int_not_equal(packet.triangle[k], 2);
    world_end(w);
}

/// Ray after ray along edges and through corners of a wall.
static void no_ray_falls_between_triangles(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t gray = world_lambert(w, 0.5f, 0);
    for (int k = 0; k < 16; k++) {
        float x = -4 + 2 * (float)(k % 4), y = -4 + 2 * (float)(k / 4);
        world_quad(w, gray, v3(x, y, 0), v3(x + 2, y, 0), v3(x + 2, y + 2, 0), v3(x, y + 2, 0));
    }
    commit(w);
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0, 3), v3(0, 0, 0), 0.9f, 1);
    picture p = picture_of(w->tracer, &camera, RSV_INSTRUCTIONS_BEST);
    p.aim.place_x = p.aim.place_y = 0.5f; // the middle row and column run along edges
    size_t rays = 0;
    for (uint32_t tile = 0; tile < across * down; tile++) {
        rsv_beam beam;
        uint32_t column = tile % across * RSV_TILE, row = tile / across * RSV_TILE;
        assert_true(gather(&p, column, row, &beam));
        for (uint32_t block = 0; block < 64; block++) {
            rsv_ray_packet packet;
            aim(&p, column + block % 8 * RSV_BLOCK, row + block / 8 * RSV_BLOCK, &packet);
            p.kernels->meet(&beam, &packet);
            for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
                assert_true(packet.t_max[k] == -1 || packet.triangle[k] < 32);
                rays += packet.triangle[k] != RSV_NONE;
            }
        }
    }
    assert_int_equal(rays, p.aim.width * p.aim.height);
    world_end(w);
}

static void a_wall_hides_what_is_behind_it(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t gray = world_lambert(w, 0.5f, 0);
    const rsv_vec3 wall[3] = { { -20, -20, 1 }, { 20, -20, 1 }, { 0, 40, 1 } };
    world_sphere(w, gray, v3(0, 0, 0), 0.9f, 4);
    add_triangle(w, gray, wall);
    commit(w);
    rsv_camera camera = looking_at_the_origin();
    picture p = picture_of(w->tracer, &camera, RSV_INSTRUCTIONS_BEST);
    rsv_beam beam;
    assert_true(gather(&p, 5 * RSV_TILE, 3 * RSV_TILE, &beam));
    assert_int_equal(beam.count, 1);
    p.aim.lens.camera.position = v3(0, 0, -4); // from the other side the sphere is too much
    p.aim.lens.camera.forward = v3(0, 0, 1);
    p.lens = rsv_beam_lens_of(&p.aim.lens);
    assert_false(gather(&p, 5 * RSV_TILE, 3 * RSV_TILE, &beam));
    world_end(w);
}

// ---- what is left to the ray tracer -------------------------------------------------------------

static void cut_out_surfaces_are_left_to_the_tracer(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_material leaf = lambert_material(0.5f, 0);
    leaf.alpha_cutoff = 0.5f;
    const rsv_vec3 corner[4] = { { 0, -1, 1 }, { 1, -1, 1 }, { 1, 1, 1 }, { 0, 1, 1 } };
    const rsv_texture_role role = RSV_TEXTURE_BASE_COLOR;
    world_pattern(w, leaf, corner, &role, 1);
    uint32_t gray = world_lambert(w, 0.5f, 0);
    world_quad(w, gray, v3(-9, -9, 0), v3(9, -9, 0), v3(9, 9, 0), v3(-9, 9, 0));
    commit(w);
    rsv_camera camera = looking_at_the_origin();
    picture p = picture_of(w->tracer, &camera, RSV_INSTRUCTIONS_BEST);
    rsv_beam beam;
    assert_true(gather(&p, 0, 0, &beam));
    assert_false(gather(&p, 6 * RSV_TILE, 2 * RSV_TILE, &beam));
    world_end(w);
}

static void unusual_cameras_have_no_beams(void **state)
{
    (void)state;
    rsv_camera camera = looking_at_the_origin();
    rsv_lens lens = rsv_lens_of(&camera, 64, 64);
    assert_true(rsv_beam_lens_of(&lens).usable);
    lens.camera.up = lens.camera.right;
    assert_false(rsv_beam_lens_of(&lens).usable);
    camera.vertical_fov = 0;
    camera.vertical_extent = 1;
    lens = rsv_lens_of(&camera, 64, 64);
    assert_false(rsv_beam_lens_of(&lens).usable);
}

/// A room with a lamp.
static world *lamp_at(rsv_vec3 place)
{
    world *w = world_begin(2);
    rsv_material lamp = lambert_material(0, 9);
    lamp.name = "lamp";
    uint32_t gray = world_lambert(w, 0.6f, 0), light = world_material(w, lamp);
    world_room(w, gray, v3(-3, -3, 0), v3(3, 3, 6));
    world_sphere(w, light, place, 0.3f, 1);
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0, 5), v3(0, 0, 0), 0.9f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void frames_see_a_lamp_where_it_was_moved(void **state)
{
    (void)state;
    static rsv_rgb shown[pixel_count], wanted[pixel_count];
    const rsv_light_move move = { "lamp", { 0.8f, 0.3f, 0.1f } };
    const rsv_relight_desc change = { .size = sizeof change, .move = &move, .move_count = 1 };
    world *w = lamp_at(v3(0, 0, 1)), *other = lamp_at(v3(0.8f, 0.3f, 1.1f));
    rsv_light *solution = solve_for_frames(w, 300, 1000),
              *fresh = solve_for_frames(other, 300, 1000);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    rsv_frame_renderer *moved, *still;
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &moved), RSV_OK);
    assert_int_equal(rsv_frame_renderer_create(fresh, &desc, &still), RSV_OK);
    assert_int_equal(rsv_frame_render(moved, &view, NULL), RSV_OK);
    assert_int_equal(rsv_light_relight(solution, &change), RSV_OK);
    rsv_frame_renderer_refresh(moved);
    assert_int_equal(rsv_frame_render(moved, &view, NULL), RSV_OK);
    assert_int_equal(rsv_frame_render(still, &view, NULL), RSV_OK);
    rsv_frame_radiance(moved, 0, shown);
    rsv_frame_radiance(still, 0, wanted);
    for (size_t k = 0; k < pixel_count; k++)
        assert_int_equal(shown[k].r > 5, wanted[k].r > 5);
    rsv_frame_renderer_destroy(moved);
    rsv_frame_renderer_destroy(still);
    rsv_light_destroy(solution);
    rsv_light_destroy(fresh);
    world_end(w);
    world_end(other);
}

static void beams_hold_until_triangles_are_set_apart(void **state)
{
    (void)state;
    const bool moves[2] = { false, true };
    rsv_beams beams;
    world *w = lamp_at(v3(0.5f, 0.4f, 1));
    assert_int_equal(rsv_tracer_create(w->scene, &w->tracer), RSV_OK);
    assert_int_equal(rsv_beams_create(w->tracer, &beams), RSV_OK);
    rsv_beams_refresh(&beams, w->tracer);
    assert_true(beams.hold);
    assert_int_equal(rsv_tracer_set_apart(w->tracer, moves), RSV_OK);
    rsv_beams_refresh(&beams, w->tracer);
    assert_false(beams.hold);
    assert_int_equal(rsv_beams_create(w->tracer, &beams), RSV_OK);
    assert_false(beams.hold);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beams_meet_what_the_tracer_meets),
        cmocka_unit_test(all_instructions_meet_the_same_bytes),
        cmocka_unit_test(a_speck_at_the_corner_of_a_tile_is_met),
        cmocka_unit_test(of_two_walls_in_one_place_the_tracers_is_met),
        cmocka_unit_test(slivers_end_where_they_end),
        cmocka_unit_test(no_ray_falls_between_triangles),
        cmocka_unit_test(a_wall_hides_what_is_behind_it),
        cmocka_unit_test(cut_out_surfaces_are_left_to_the_tracer),
        cmocka_unit_test(unusual_cameras_have_no_beams),
        cmocka_unit_test(frames_see_a_lamp_where_it_was_moved),
        cmocka_unit_test(beams_hold_until_triangles_are_set_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
