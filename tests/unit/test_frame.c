/// Frames against the pictures of rsv_render, across instructions, threads and eyes.
#include "core/srgb.h"
#include "frame_fixture.h"
#include "resolvent/measure.h"
#include "resolvent/relight.h"
#include "slow_tests.h"

static rsv_light *solve(const world *w) { return solve_for_frames(w, 600, 20000); }

static rsv_frame_renderer *begin_frames(const rsv_light *solution, const rsv_frame_desc *desc)
{
    rsv_frame_renderer *renderer;
    rsv_status status = rsv_frame_renderer_create(solution, desc, &renderer);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return renderer;
}

static void render_frames(rsv_frame_renderer *renderer, const rsv_frame_view *view, int count)
{
    for (int k = 0; k < count; k++)
        assert_int_equal(rsv_frame_render(renderer, view, NULL), RSV_OK);
}

static size_t count_different_pixels(const rsv_frame_renderer *renderer, const rsv_rgb *picture)
{
    static rsv_rgb shown[pixel_count];
    return count_different(renderer, 0, picture, shown);
}

// ---- the same picture ---------------------------------------------------------------------------

static void check_frames(world *w, uint32_t samples, size_t allowed)
{
    rsv_light *solution = solve(w);
    rsv_image *picture = render_picture(solution, NULL, samples, false);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    render_frames(renderer, &view, (int)samples);
    size_t different = count_different_pixels(renderer, rsv_image_const_pixels(picture, 0));
    if (different > allowed) fail_msg("%zu pixels differ", different);
    rsv_image_destroy(picture);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

static void frames_add_up_to_the_picture(void **state)
{
    (void)state;
    check_frames(world_builtin(2, "cornell-blocks"), 1, 0);
    check_frames(world_builtin(2, "cornell-blocks"), 5, 0);
}

/// Packets and single rays round differently. Behind a few curved surfaces that can end a specular path beyond an edge.
static void chains_add_up_to_the_picture(void **state)
{
    (void)state;
    check_frames(world_builtin(2, "cornell-spheres"), 2, pixel_count / 200);
}

/// A plate before a sky of few, very different pixels.
static world *plate_before_sky(rsv_vec3 seen)
{
    enum { columns = 7, rows = 5 };
    static rsv_rgb pixel[rows * columns];
    world *w = world_begin(2);
    for (uint32_t k = 0; k < rows * columns; k++)
        pixel[k] = rgb(rsv_unit_float(rsv_hash2(k, 1)), rsv_unit_float(rsv_hash2(k, 2)),
            rsv_unit_float(rsv_hash2(k, 3)));
    const rsv_environment environment = {
        .pixels = pixel, .width = columns, .height = rows, .intensity = 1, .rotation = 77
    };
    world_quad(w, world_lambert(w, 0.5f, 0), v3(-0.2f, -0.1f, 0.9f), v3(0.1f, -0.1f, 0.9f),
        v3(0.1f, 0.2f, 0.9f), v3(-0.2f, 0.2f, 0.9f));
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 0, 0), seen, 1.8f, (float)width / height);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void the_sky_is_that_of_the_picture(void **state)
{
    (void)state;
    const rsv_vec3 seen[] = { { 0, 0, 1 }, { 0.1f, 1, 0 }, { -1, -1, 0.2f }, { -1, 0, 0 } };
    for (int k = 0; k < UNLESS_SANITIZED(4, 1); k++)
        check_frames(plate_before_sky(seen[k]), 1, 0);
}

/// Mirror, rough metal, coat, a back side, a sky, and a camera inside glass.
static world *mixed_world(bool inside)
{
    world *w = world_begin(2);
    rsv_material metal = mirror_material(0.8f), coated = lambert_material(0.6f, 0);
    metal.roughness = 0.4f;
    coated.specular = 1;
    coated.roughness = 0;
    rsv_material dim_glass = glass_material();
    dim_glass.attenuation_color = rgb(0.9f, 0.5f, 0.7f);
    dim_glass.attenuation_distance = 1;
    world_quad(
        w, world_lambert(w, 0.7f, 0), v3(-3, -1, 3), v3(3, -1, 3), v3(3, -1, -3), v3(-3, -1, -3));
    world_quad(w, world_lambert(w, 0, 5), v3(-1, 2, -1), v3(1, 2, -1), v3(1, 2, 1), v3(-1, 2, 1));
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(2, -1, 0), v3(2, 1, 0), v3(1, 1, -1), v3(1, -1, -1));
    world_box(w, world_material(w, mirror_material(0.9f)), v3(-2, -1, -2), v3(-1, 1, -1));
    world_sphere(w, world_material(w, metal), v3(-0.9f, -0.5f, 0.5f), 0.4f, 3);
    world_sphere(w, world_material(w, coated), v3(0.9f, -0.5f, 0.6f), 0.4f, 3);
    if (inside) world_sphere(w, world_material(w, dim_glass), v3(0, 0.5f, 5), 1.5f, 3);
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.5f, 5), v3(0, 0, 0), 0.9f, 1);
    rsv_rgb sky[2] = { { 0.5f, 0.6f, 0.9f }, { 0.2f, 0.2f, 0.1f } };
    rsv_environment environment = { .pixels = sky, .width = 1, .height = 2, .intensity = 1 };
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void surfaces_of_all_kinds_add_up_to_the_picture(void **state)
{
    (void)state;
    check_frames(mixed_world(false), 3, pixel_count / 200);
    check_frames(mixed_world(true), 1, pixel_count / 200);
}

/// Glass inside glass around the camera and in front of it, more bodies than the list of media holds, one-sided
/// mirrors.
static world *nested_world(void)
{
    world *w = world_begin(2);
    rsv_material one_sided = mirror_material(0.9f);
    one_sided.double_sided = false;
    world_room(w, world_lambert(w, 0.6f, 0), v3(-3, -2, -3), v3(3, 3, 3));
    world_quad(w, world_lambert(w, 0, 5), v3(-1, 2, -1), v3(1, 2, -1), v3(1, 2, 1), v3(-1, 2, 1));
    world_quad(w, world_material(w, one_sided), v3(-2, -1, 0), v3(-2, 1, 0), v3(-1, 1, -2),
        v3(-1, -1, -2));
    for (int k = 0; k < 70; k++) {
        rsv_material glass = glass_material();
        glass.ior = 1.05f + 0.01f * (float)k;
        if (k % 3 == 0) glass.attenuation_color = rgb(0.5f, 0.9f, 0.8f);
        if (k % 3 == 0) glass.attenuation_distance = 0.5f;
        rsv_vec3 place = v3(-0.9f + 0.3f * (float)(k % 7), -1 + 0.25f * (float)(k / 7), 0);
        world_sphere(w, world_material(w, glass), place, k % 2 ? 0.2f : 0.12f, 2);
    }
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.2f, 2.5f), v3(0, 0.2f, 0), 0.8f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void bodies_within_bodies_add_up_to_the_picture(void **state)
{
    (void)state;
    check_frames(nested_world(), 1, pixel_count / 200);
}

static void layers_are_shown(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_image *picture = render_picture(solution, NULL, 1, true);
    rsv_image *whole = render_picture(solution, NULL, 1, false);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    for (uint32_t layer = 0; layer < 4; layer++) {
        rsv_frame_renderer_show(renderer, layer);
        render_frames(renderer, &view, 1);
        assert_int_equal(
            count_different_pixels(renderer, rsv_image_const_pixels(picture, 1 + layer)), 0);
    }
    rsv_frame_renderer_show(renderer, RSV_NONE);
    render_frames(renderer, &view, 1);
    assert_int_equal(count_different_pixels(renderer, rsv_image_const_pixels(whole, 0)), 0);
    rsv_image_destroy(whole);
    rsv_image_destroy(picture);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

// ---- however it is computed ---------------------------------------------------------------------

static uint64_t hash_of_frames(
    const rsv_light *solution, const rsv_frame_desc *desc, const rsv_frame_view *view, uint32_t eye)
{
    static rsv_rgb radiance[pixel_count];
    rsv_frame_renderer *renderer = begin_frames(solution, desc);
    render_frames(renderer, view, 3);
    rsv_frame_radiance(renderer, eye, radiance);
    uint64_t hash = hash_bytes(HASH_START, radiance, sizeof radiance);
    hash = hash_bytes(hash, rsv_frame_pixels(renderer, eye), 4 * pixel_count);
    rsv_frame_renderer_destroy(renderer);
    return hash;
}

static void all_instructions_give_the_same_bytes(void **state)
{
    (void)state;
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    uint64_t best = hash_of_frames(solution, &desc, &view, 0);
    for (desc.instructions = RSV_INSTRUCTIONS_PORTABLE; rsv_instructions_name(desc.instructions);
         desc.instructions++) {
        rsv_frame_renderer *renderer;
        rsv_status status = rsv_frame_renderer_create(solution, &desc, &renderer);
        if (status == RSV_ERROR_UNSUPPORTED) {
            print_message("skipped: no %s here\n", rsv_instructions_name(desc.instructions));
            continue;
        }
        assert_int_equal(status, RSV_OK);
        rsv_frame_renderer_destroy(renderer);
        assert_true(hash_of_frames(solution, &desc, &view, 0) == best);
    }
    rsv_light_destroy(solution);
    world_end(w);
}

static uint64_t hash_with_threads(int threads)
{
    world *w = world_builtin(threads, "cornell-spheres");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    uint64_t hash = hash_of_frames(solution, &desc, &view, 0);
    rsv_light_destroy(solution);
    world_end(w);
    return hash;
}

static void any_number_of_threads_gives_the_same_bytes(void **state)
{
    (void)state;
    assert_true(hash_with_threads(1) == hash_with_threads(3));
}

static void each_eye_has_a_picture_of_its_own(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w), single = view;
    for (uint32_t eye = 0; eye < 2; eye++)
        view.camera[eye] = rsv_camera_eye(&view.camera[eye], eye, 0.063f);
    for (uint32_t eye = 0; eye < 2; eye++) {
        desc.eyes = 2;
        uint64_t both = hash_of_frames(solution, &desc, &view, eye);
        desc.eyes = 1;
        single.camera[0] = view.camera[eye];
        assert_true(hash_of_frames(solution, &desc, &single, 0) == both);
    }
    rsv_light_destroy(solution);
    world_end(w);
}

// ---- reused light of rough lobes ----------------------------------------------------------------

/// Mean radiance of some frames from a camera that moves to and fro. @param gloss of paths: in four places of each pixel, as
/// frames of reused light take them in turn
static double mean_of_flight(rsv_light *solution, const world *w, rsv_frame_gloss gloss, int frames)
{
    static rsv_rgb radiance[pixel_count];
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    desc.gloss = gloss;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    double sum = 0;
    for (int k = 0; k < frames; k++) {
        view.camera[0].position.x = 1e-3f * (float)(k % 48 + 1);
        render_frames(renderer, &view, gloss == RSV_GLOSS_PATHS ? 4 : 1);
        rsv_frame_radiance(renderer, 0, radiance);
        for (size_t i = 0; i < pixel_count; i++) {
            assert_true(isfinite(radiance[i].r + radiance[i].g + radiance[i].b));
            sum += (double)radiance[i].g / (double)(frames * pixel_count);
        }
    }
    rsv_frame_renderer_destroy(renderer);
    return sum;
}

static void reused_light_has_the_same_mean(void **state)
{
    (void)state;
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    double paths = mean_of_flight(solution, w, RSV_GLOSS_PATHS, 24);
    double reused = mean_of_flight(solution, w, RSV_GLOSS_REUSED, 48);
    assert_close(reused, paths, 0.01 * paths);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Two metal walls that face each other: what one reflects is mostly the other.
static world *facing_metals(void)
{
    world *w = world_begin(2);
    rsv_material metal = rsv_default_material();
    metal.base_color = rgb(0.9f, 0.85f, 0.8f);
    metal.metallic = 1;
    metal.roughness = 0.4f;
    metal.double_sided = true;
    uint32_t walls = world_material(w, metal);
    world_room(w, world_lambert(w, 0.6f, 0), v3(-1, -1, -2), v3(1, 1, 2));
    world_quad(w, world_lambert(w, 0, 5), v3(-0.4f, 0.95f, -0.4f), v3(0.4f, 0.95f, -0.4f),
        v3(0.4f, 0.95f, 0.4f), v3(-0.4f, 0.95f, 0.4f));
    for (float x = -0.5f; x < 1; x += 1)
        world_quad(w, walls, v3(x, -0.9f, -1.5f), v3(x, 0.7f, -1.5f), v3(x, 0.7f, 0.8f),
            v3(x, -0.9f, 0.8f));
    rsv_camera camera =
        rsv_camera_look_at("eye", v3(0, 0, 1.8f), v3(0, -0.2f, 0), 0.9f, (float)width / height);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

/// Metal that rays of rough lobes hit must not count as black, although it stores no light: otherwise, 15 % would be
/// missing.
static void metals_show_each_other(void **state)
{
    (void)state;
    world *w = facing_metals();
    rsv_light *solution = solve(w);
    double paths = mean_of_flight(solution, w, RSV_GLOSS_PATHS, 24);
    double reused = mean_of_flight(solution, w, RSV_GLOSS_REUSED, 384);
    print_message("    reused %.4f, paths %.4f\n", reused, paths);
    assert_close(reused, paths, 0.02 * paths);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Small balls of metal in the sun: their highlights are smaller than a pixel.
static world *balls_in_the_sun(void)
{
    world *w = world_begin(2);
    rsv_material metal = rsv_default_material();
    metal.base_color = rgb(0.9f, 0.9f, 0.9f);
    metal.metallic = 1;
    metal.roughness = 0.3f;
    uint32_t balls = world_material(w, metal);
    world_quad(
        w, world_lambert(w, 0.3f, 0), v3(-3, -1, 3), v3(3, -1, 3), v3(3, -1, -3), v3(-3, -1, -3));
    for (int k = 0; k < 80; k++)
        world_sphere(w, balls,
            v3(-0.9f + 0.2f * (float)(k % 10), -0.8f + 0.2f * (float)(k / 10), 0), 0.06f, 3);
    rsv_punctual_light sun = { .kind = RSV_PUNCTUAL_DIRECTIONAL,
        .direction = v3(-0.6f, -0.64f, -0.48f),
        .intensity = rgb(5, 5, 5) };
    assert_int_equal(rsv_scene_add_light(w->scene, &sun), RSV_OK);
    rsv_camera camera =
        rsv_camera_look_at("eye", v3(0, 0, 3), v3(0, 0, 0), 0.7f, (float)width / height);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

/// Highlights that are smaller than a cell are spread over it. Otherwise they would flicker, and rare ones would be
/// lost. Balls three pixels wide still lose 17 % of their light, instead of 29 %.
static void small_highlights_are_spread_over_cells(void **state)
{
    (void)state;
    world *w = balls_in_the_sun();
    rsv_light *solution = solve(w);
    double paths = mean_of_flight(solution, w, RSV_GLOSS_PATHS, 48);
    double reused = mean_of_flight(solution, w, RSV_GLOSS_REUSED, 48);
    print_message("    reused %.4f, paths %.4f\n", reused, paths);
    assert_true(reused > 0.8 * paths && reused < 1.05 * paths);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Box means of 4x4 pixels: mean square of their difference over the square of their mean. @param ratio of the means, out
static double block_error(const rsv_rgb *a, const rsv_rgb *b, double *ratio)
{
    double sum[2] = { 0, 0 }, squares = 0;
    for (uint32_t y = 0; y + 4 <= height; y += 4)
        for (uint32_t x = 0; x + 4 <= width; x += 4) {
            double mean[2] = { 0, 0 };
            for (uint32_t k = 0; k < 16; k++) {
                mean[0] += (double)a[(y + k / 4) * width + x + k % 4].g / 16;
                mean[1] += (double)b[(y + k / 4) * width + x + k % 4].g / 16;
            }
            sum[0] += mean[0], sum[1] += mean[1];
            squares += (mean[0] - mean[1]) * (mean[0] - mean[1]);
        }
    double blocks = (double)(height / 4) * (width / 4);
    *ratio = sum[0] / sum[1];
    return squares / blocks / (sum[1] / blocks * sum[1] / blocks);
}

/// A plate of metal in the sun, with bumps smaller than a pixel.
static world *bumps_in_the_sun(void)
{
    enum { texels = 64 };
    static float texel[texels * texels][4];
    static const float uv[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_vec3 corner[4] = { v3(-1, -1, 0), v3(1, -1, 0), v3(1, 1, 0), v3(-1, 1, 0) };
    world *w = world_begin(2);
    rsv_material metal = rsv_default_material();
    rsv_texture_ref ref = rsv_default_texture_ref(RSV_TEXTURE_NORMAL, 0);
    for (uint32_t k = 0; k < texels * texels; k++) {
        texel[k][0] = 0.5f + 0.4f * (rsv_unit_float(rsv_hash2(1, k)) - 0.5f);
        texel[k][1] = 0.5f + 0.4f * (rsv_unit_float(rsv_hash2(2, k)) - 0.5f);
        texel[k][2] = texel[k][3] = 1;
    }
    const rsv_texture_desc texture = { .size = sizeof texture,
        .name = "bumps",
        .width = texels,
        .height = texels,
        .channel_count = 4,
        .values = texel[0] };
    assert_int_equal(rsv_scene_add_texture(w->scene, &texture, &ref.texture), RSV_OK);
    metal.base_color = rgb_gray(0.9f);
    metal.metallic = 1;
    metal.roughness = 0.2f;
    metal.textures = &ref;
    metal.texture_count = 1;
    uint32_t mesh;
    const rsv_mesh_desc plate = { .size = sizeof plate,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = world_material(w, metal),
        .uvs = { uv, NULL } };
    assert_int_equal(rsv_scene_add_mesh(w->scene, &plate, &mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, mesh, NULL, NULL), RSV_OK);
    world_quad(w, world_lambert(w, 0.3f, 0), v3(-3, -1.1f, 3), v3(3, -1.1f, 3), v3(3, -1.1f, -3),
        v3(-3, -1.1f, -3));
    rsv_punctual_light sun = { .kind = RSV_PUNCTUAL_DIRECTIONAL,
        .direction = v3(-0.3f, -0.3f, -0.9f),
        .intensity = rgb(5, 5, 5) };
    assert_int_equal(rsv_scene_add_light(w->scene, &sun), RSV_OK);
    rsv_camera camera =
        rsv_camera_look_at("eye", v3(0, 0, 3), v3(0, 0, 0), 0.7f, (float)width / height);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

/// Also what a normal map turns away from its neighbours: one ray of a cell must not show the highlight of one pixel on all
/// of them. At rest, each pixel has its own.
static void highlights_on_bumps_are_those_of_pixels(void **state)
{
    (void)state;
    static rsv_rgb paths[pixel_count], moving[pixel_count];
    world *w = bumps_in_the_sun();
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    rsv_frame_renderer *judge = begin_frames(solution, &desc);
    desc.gloss = RSV_GLOSS_REUSED;
    rsv_frame_renderer *reused = begin_frames(solution, &desc);
    render_frames(judge, &view, 64);
    rsv_frame_radiance(judge, 0, paths);
    render_frames(reused, &view, 1);
    view.camera[0].position.x += 1e-3f;
    render_frames(reused, &view, 1);
    rsv_frame_radiance(reused, 0, moving);
    double ratio, error = block_error(moving, paths, &ratio);
    print_message("    error of blocks %.3g, mean %.4f\n", error, ratio);
    assert_true(error < 0.5);
    view.camera[0].position.x -= 1e-3f;
    render_frames(reused, &view, 24);
    rsv_frame_radiance(reused, 0, moving);
    error = block_error(moving, paths, &ratio);
    print_message("    at rest: error of blocks %.3g, mean %.4f\n", error, ratio);
    assert_true(error < 0.1 && fabs(ratio - 1) < 0.03);
    rsv_frame_renderer_destroy(judge);
    rsv_frame_renderer_destroy(reused);
    rsv_light_destroy(solution);
    world_end(w);
}

/// At rest, reused light becomes that of paths: less far from it after more frames, and with the same mean.
static void reused_light_at_rest_becomes_that_of_paths(void **state)
{
    (void)state;
    static rsv_rgb paths[pixel_count], first[pixel_count], last[pixel_count];
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    rsv_frame_renderer *judge = begin_frames(solution, &desc);
    desc.gloss = RSV_GLOSS_REUSED;
    rsv_frame_renderer *reused = begin_frames(solution, &desc);
    render_frames(judge, &view, 512);
    rsv_frame_radiance(judge, 0, paths);
    render_frames(reused, &view, 8);
    rsv_frame_radiance(reused, 0, first);
    render_frames(reused, &view, 2040);
    rsv_frame_radiance(reused, 0, last);
    double ratio, early = block_error(first, paths, &ratio),
                  late = block_error(last, paths, &ratio);
    print_message("    after 8 frames %.2g, after 2048 %.2g, mean %.4f\n", early, late, ratio);
    assert_true(late < 0.5 * early);
    assert_true(late < 1e-3);
    assert_close(ratio, 1, 0.003);
    rsv_frame_renderer_destroy(judge);
    rsv_frame_renderer_destroy(reused);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Threads, instructions and eyes.
static void reused_light_is_the_same_however_it_is_computed(void **state)
{
    (void)state;
    uint64_t hash[2];
    for (int threads = 1; threads < 3; threads++) {
        world *w = mixed_world(false);
        rsv_light *solution = solve(w);
        rsv_frame_desc desc = frame_desc();
        rsv_frame_view view = view_of(w);
        desc.gloss = RSV_GLOSS_REUSED;
        hash[threads - 1] = hash_of_frames(solution, &desc, &view, 0);
        desc.instructions = RSV_INSTRUCTIONS_PORTABLE;
        assert_true(hash_of_frames(solution, &desc, &view, 0) == hash[threads - 1]);
        desc.eyes = 2;
        view.camera[1] = rsv_camera_eye(&view.camera[0], 1, 0.1f);
        assert_true(hash_of_frames(solution, &desc, &view, 0) == hash[threads - 1]);
        rsv_light_destroy(solution);
        world_end(w);
    }
}

/// Small varnished balls before a sky: cells at their edges come and go from frame to frame.
static world *varnished_world(int threads)
{
    world *w = world_begin(threads);
    rsv_material varnish = lambert_material(0.6f, 0);
    varnish.specular = 1;
    varnish.roughness = 0.32f;
    uint32_t material = world_material(w, varnish);
    world_quad(w, material, v3(-3, -1, 3), v3(3, -1, 3), v3(3, -1, -3), v3(-3, -1, -3));
    world_quad(w, world_lambert(w, 0, 5), v3(-1, 2, -1), v3(1, 2, -1), v3(1, 2, 1), v3(-1, 2, 1));
    for (int k = 0; k < 49; k++)
        world_sphere(w, material,
            v3(-1.2f + 0.4f * (float)(k % 7), -0.8f + 0.35f * (float)(k / 7), 0), 0.12f, 1);
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.3f, 4), v3(0, 0.2f, 0), 0.8f, 1);
    rsv_rgb sky[2] = { { 0.5f, 0.6f, 0.9f }, { 0.2f, 0.2f, 0.1f } };
    rsv_environment environment = { .pixels = sky, .width = 1, .height = 2, .intensity = 1 };
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static uint64_t hash_at_rest(int threads)
{
    enum { wide = 320, high = 192 };
    static rsv_rgb radiance[wide * high];
    world *w = varnished_world(threads);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    desc.gloss = RSV_GLOSS_REUSED;
    desc.width = wide;
    desc.height = high;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    uint64_t hash = HASH_START;
    for (int k = 0; k < 16; k++) {
        render_frames(renderer, &view, 1);
        rsv_frame_radiance(renderer, 0, radiance);
        hash = hash_bytes(hash, radiance, sizeof radiance);
    }
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
    return hash;
}

static void frames_at_rest_do_not_depend_on_threads(void **state)
{
    (void)state;
    assert_true(hash_at_rest(1) == hash_at_rest(3));
}

/// A black floor under a coat shows hardly any light of a lamp that is not reflected to the eye. The first frame does not
/// know that yet.
static void guesses_of_the_first_frame_do_not_count_at_rest(void **state)
{
    (void)state;
    static rsv_rgb radiance[pixel_count];
    world *w = world_begin(2);
    rsv_material coated = lambert_material(0, 0);
    coated.clearcoat = 1;
    coated.clearcoat_roughness = 0.1f;
    world_quad(
        w, world_material(w, coated), v3(-3, -1, 3), v3(3, -1, 3), v3(3, -1, -3), v3(-3, -1, -3));
    world_quad(w, world_lambert(w, 0, 5), v3(-0.3f, 2, -0.3f), v3(0.3f, 2, -0.3f),
        v3(0.3f, 2, 0.3f), v3(-0.3f, 2, 0.3f));
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.3f, 4), v3(0, -1, 0), 0.8f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    desc.gloss = RSV_GLOSS_REUSED;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    double first = 0, rested = 0;
    render_frames(renderer, &view, 1);
    rsv_frame_radiance(renderer, 0, radiance);
    for (int k = 0; k < pixel_count; k++)
        first += (double)rgb_luminance(radiance[k]);
    render_frames(renderer, &view, 15);
    rsv_frame_radiance(renderer, 0, radiance);
    for (int k = 0; k < pixel_count; k++)
        rested += (double)rgb_luminance(radiance[k]);
    assert_true(rested < 0.02 * first);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

/// A light that is switched off leaves no trace, even in the first frame.
static void reused_light_goes_with_its_source(void **state)
{
    (void)state;
    const rsv_light_scale off = { "environment", { 0, 0, 0 } };
    const rsv_relight_desc change = { .size = sizeof change, .light = &off, .light_count = 1 };
    static rsv_rgb after[pixel_count], anew[pixel_count];
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    desc.gloss = RSV_GLOSS_REUSED;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    render_frames(renderer, &view, 20);
    assert_int_equal(rsv_light_relight(solution, &change), RSV_OK);
    rsv_frame_renderer_refresh(renderer);
    rsv_frame_renderer *other = begin_frames(solution, &desc);
    render_frames(renderer, &view, 1);
    render_frames(other, &view, 1);
    rsv_frame_radiance(renderer, 0, after);
    rsv_frame_radiance(other, 0, anew);
    double sum = 0, difference = 0;
    for (size_t k = 0; k < pixel_count; k++) {
        sum += (double)anew[k].g;
        difference += (double)after[k].g - (double)anew[k].g;
    }
    assert_close(difference, 0, 0.02 * sum); // each has noise of its own
    rsv_frame_renderer_destroy(renderer);
    rsv_frame_renderer_destroy(other);
    rsv_light_destroy(solution);
    world_end(w);
}

/// `bench fps` may trace rays of its own between two frames; the next frame must still reuse the previous one. The mean
/// of all channels of a moving frame's light, refreshed before each frame or not.
static uint64_t hash_of_refreshed(
    rsv_light *solution, const world *w, rsv_instructions instructions, bool refreshed)
{
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    desc.gloss = RSV_GLOSS_REUSED;
    desc.instructions = instructions;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    for (int k = 0; k < 12; k++) {
        view.camera[0].position.x = 1e-3f * (float)k;
        if (refreshed) rsv_frame_renderer_refresh(renderer);
        render_frames(renderer, &view, 1);
    }
    uint64_t hash = hash_bytes(HASH_START, rsv_frame_pixels(renderer, 0), 4 * pixel_count);
    rsv_frame_renderer_destroy(renderer);
    return hash;
}

/// Light that has not changed is not dropped, and frames on the way do not depend on the instructions.
static void reused_light_stays_with_its_sources(void **state)
{
    (void)state;
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    uint64_t hash = hash_of_refreshed(solution, w, RSV_INSTRUCTIONS_BEST, false);
    assert_true(hash_of_refreshed(solution, w, RSV_INSTRUCTIONS_BEST, true) == hash);
    assert_true(hash_of_refreshed(solution, w, RSV_INSTRUCTIONS_PORTABLE, false) == hash);
    rsv_light_destroy(solution);
    world_end(w);
}

static void tracing_alone_leaves_reused_light_as_it_was(void **state)
{
    (void)state;
    static rsv_rgb plain[pixel_count], measured[pixel_count];
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    desc.gloss = RSV_GLOSS_REUSED;
    for (int traces = 0; traces < 2; traces++) {
        rsv_frame_view view = view_of(w);
        rsv_frame_renderer *renderer = begin_frames(solution, &desc);
        for (int k = 0; k < 6; k++) {
            view.camera[0].position.x = 1e-3f * (float)(k % 48 + 1);
            render_frames(renderer, &view, 1);
            if (traces) rsv_frame_trace_only(renderer, &view);
        }
        rsv_frame_radiance(renderer, 0, traces ? measured : plain);
        rsv_frame_renderer_destroy(renderer);
    }
    assert_memory_equal(measured, plain, sizeof plain);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Mean square of differences between pixels, over the square of their mean.
static double pixel_error(const rsv_rgb *a, const rsv_rgb *truth)
{
    double squares = 0, sum = 0;
    for (size_t k = 0; k < pixel_count; k++) {
        double difference = (double)a[k].g - (double)truth[k].g;
        squares += difference * difference / pixel_count;
        sum += (double)truth[k].g / pixel_count;
    }
    return squares / (sum * sum);
}

/// What a renderer shows of one view, after frames on the way there or without them.
static void show_after(
    rsv_light *solution, const rsv_frame_view *view, int steps, float step, rsv_rgb *shown)
{
    rsv_frame_desc desc = frame_desc();
    desc.gloss = RSV_GLOSS_REUSED;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view way = *view;
    for (int k = steps; k >= 0; k--) {
        way.camera[0].position.x = view->camera[0].position.x + step * (float)k;
        render_frames(renderer, &way, 1);
    }
    rsv_frame_radiance(renderer, 0, shown);
    rsv_frame_renderer_destroy(renderer);
}

/// Edges of moving frames are means over their pixels, in place and without trails; those after a jump are no worse than
/// first ones.
static void moving_edges_are_smooth(void **state)
{
    (void)state;
    static rsv_rgb truth[pixel_count], shown[pixel_count];
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    rsv_frame_view view = view_of(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *judge = begin_frames(solution, &desc);
    render_frames(judge, &view, 512);
    rsv_frame_radiance(judge, 0, truth);
    show_after(solution, &view, 0, 0, shown);
    double first = pixel_error(shown, truth);
    show_after(solution, &view, 16, 0.003f, shown);
    double moving = pixel_error(shown, truth);
    show_after(solution, &view, 1, 1, shown);
    double jump = pixel_error(shown, truth);
    print_message("    first %.2g, moving %.2g, after a jump %.2g\n", first, moving, jump);
    assert_true(moving < 0.6 * first);
    assert_true(jump < 1.1 * first);
    rsv_frame_renderer_destroy(judge);
    rsv_light_destroy(solution);
    world_end(w);
}

static void reused_light_fits_windows_of_one_pixel(void **state)
{
    (void)state;
    world *w = mixed_world(true); // from inside glass, too
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_view view = view_of(w);
    desc.gloss = RSV_GLOSS_REUSED;
    for (uint32_t size = 1; size < 40; size += 19) {
        rsv_rgb radiance[39 * 39];
        desc.width = desc.height = size;
        rsv_frame_renderer *renderer = begin_frames(solution, &desc);
        render_frames(renderer, &view, 3);
        rsv_frame_radiance(renderer, 0, radiance);
        for (uint32_t k = 0; k < size * size; k++)
            assert_true(isfinite(radiance[k].r + radiance[k].g + radiance[k].b));
        rsv_frame_renderer_destroy(renderer);
    }
    rsv_light_destroy(solution);
    world_end(w);
}

// ---- frame after frame --------------------------------------------------------------------------

static void frames_start_over_when_the_camera_moves(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    rsv_frame_stats stats;
    render_frames(renderer, &view, 2);
    view.camera[0].position.x += 0.01f;
    assert_int_equal(rsv_frame_render(renderer, &view, &stats), RSV_OK);
    assert_int_equal(stats.samples, 1);
    view.exposure = 1; // shown otherwise, the light is the same
    assert_int_equal(rsv_frame_render(renderer, &view, &stats), RSV_OK);
    assert_int_equal(stats.samples, 2);
    rsv_frame_renderer_refresh(renderer);
    assert_int_equal(rsv_frame_render(renderer, &view, &stats), RSV_OK);
    assert_int_equal(stats.samples, 1);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Relit in place, sky, mirrors and all: the picture is that of a new renderer.
static void frames_follow_the_light(void **state)
{
    (void)state;
    const rsv_light_scale dim = { "environment", { 0.3f, 0.3f, 0.3f } };
    const rsv_relight_desc change = { .size = sizeof change, .light = &dim, .light_count = 1 };
    world *w = mixed_world(false);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *before = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    render_frames(before, &view, 1);
    assert_int_equal(rsv_light_relight(solution, &change), RSV_OK);
    rsv_frame_renderer_refresh(before);
    rsv_frame_renderer *after = begin_frames(solution, &desc);
    render_frames(before, &view, 1);
    render_frames(after, &view, 1);
    assert_memory_equal(rsv_frame_pixels(before, 0), rsv_frame_pixels(after, 0), 4 * pixel_count);
    rsv_frame_renderer_destroy(before);
    rsv_frame_renderer_destroy(after);
    rsv_light_destroy(solution);
    world_end(w);
}

static void frames_allocate_nothing(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-spheres");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    w->until_failure = 0; // the next allocation fails
    for (int k = 0; k < 20; k++) {
        view.camera[0].position.x += 1e-3f * (float)(k & 4);
        render_frames(renderer, &view, 1);
    }
    rsv_frame_renderer_show(renderer, 2);
    render_frames(renderer, &view, 1);
    assert_int_equal(w->until_failure, 0);
    w->until_failure = -1;
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

static void failing_allocations_leave_nothing_behind(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer = NULL;
    rsv_status status = RSV_ERROR_MEMORY;
    for (int k = 0; status == RSV_ERROR_MEMORY; k++) {
        w->until_failure = k;
        status = rsv_frame_renderer_create(solution, &desc, &renderer);
    }
    assert_int_equal(status, RSV_OK);
    w->until_failure = -1;
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

static void codes_follow_the_srgb_curve(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    view.exposure = 1.5f;
    static rsv_rgb shown[pixel_count];
    render_frames(renderer, &view, 2);
    rsv_frame_radiance(renderer, 0, shown);
    for (size_t k = 0; k < pixel_count; k++) {
        double linear = fmin((double)shown[k].g * exp2(1.5), 1);
        assert_close(rsv_frame_pixels(renderer, 0)[k][1], 255 * rsv_srgb_encode(linear), 0.505);
        assert_int_equal(rsv_frame_pixels(renderer, 0)[k][3], 255);
    }
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

static void unusable_wishes_are_refused(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_renderer *renderer;
    rsv_frame_desc desc = frame_desc();
    desc.width = 0;
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_ERROR_ARGUMENT);
    desc = frame_desc();
    desc.eyes = 3;
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_ERROR_ARGUMENT);
    desc = frame_desc();
    renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    view.camera[0].position.x = NAN;
    assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_ERROR_ARGUMENT);
    view = view_of(w);
    view.exposure = INFINITY;
    assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_ERROR_ARGUMENT);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

/// Shells of frosted glass within each other, in uniform light.
static world *frosted_shells(void)
{
    static rsv_rgb white = { 1, 1, 1 };
    world *w = world_begin(2);
    rsv_material frosted = rsv_default_material();
    frosted.base_color = rgb_gray(1);
    frosted.roughness = 0.6f;
    frosted.transmission = 1;
    frosted.thickness = 0.1f;
    for (int k = 1; k <= 3; k++)
        world_sphere(w, world_material(w, frosted), v3(0, 0, 0), 0.3f * (float)k, 3);
    world_quad(w, world_lambert(w, 0.5f, 0), v3(-0.01f, 0, 9), v3(0.01f, 0, 9), v3(0.01f, 0.02f, 9),
        v3(-0.01f, 0.02f, 9));
    const rsv_environment environment = {
        .pixels = &white, .width = 1, .height = 1, .intensity = 1
    };
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 0, 3), v3(0, 0, 0), 0.3f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

/// Nothing but the colour of the light is to be seen. Paths of up to 32 events would miss 1 % of it; of 4, 85 %.
static void frosted_glass_loses_no_light(void **state)
{
    (void)state;
    static rsv_rgb shown[pixel_count];
    world *w = frosted_shells();
    rsv_light *solution = solve_for_frames(w, 50, 0);
    rsv_frame_desc desc = frame_desc();
    desc.gloss = RSV_GLOSS_REUSED;
    rsv_frame_renderer *renderer = begin_frames(solution, &desc);
    rsv_frame_view view = view_of(w);
    double sum = 0;
    assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
    rsv_frame_radiance(renderer, 0, shown);
    for (size_t k = 0; k < pixel_count; k++)
        sum += (double)shown[k].g;
    print_message("    mean %.4f\n", sum / pixel_count);
    assert_true(fabs(sum / pixel_count - 1) < 0.001);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(frames_add_up_to_the_picture),
        cmocka_unit_test(the_sky_is_that_of_the_picture),
        cmocka_unit_test(layers_are_shown),
        cmocka_unit_test(frosted_glass_loses_no_light),
        cmocka_unit_test(all_instructions_give_the_same_bytes),
        cmocka_unit_test(each_eye_has_a_picture_of_its_own),
        cmocka_unit_test(frames_start_over_when_the_camera_moves),
        cmocka_unit_test(frames_allocate_nothing),
        cmocka_unit_test(failing_allocations_leave_nothing_behind),
        cmocka_unit_test(codes_follow_the_srgb_curve),
        cmocka_unit_test(unusable_wishes_are_refused),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(chains_add_up_to_the_picture),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
        cmocka_unit_test(surfaces_of_all_kinds_add_up_to_the_picture),
        cmocka_unit_test(bodies_within_bodies_add_up_to_the_picture),
        cmocka_unit_test(frames_follow_the_light),
        cmocka_unit_test(reused_light_has_the_same_mean),
        cmocka_unit_test(metals_show_each_other),
        cmocka_unit_test(small_highlights_are_spread_over_cells),
        cmocka_unit_test(highlights_on_bumps_are_those_of_pixels),
        cmocka_unit_test(reused_light_at_rest_becomes_that_of_paths),
        cmocka_unit_test(reused_light_is_the_same_however_it_is_computed),
        cmocka_unit_test(frames_at_rest_do_not_depend_on_threads),
        cmocka_unit_test(guesses_of_the_first_frame_do_not_count_at_rest),
        cmocka_unit_test(reused_light_goes_with_its_source),
        cmocka_unit_test(reused_light_stays_with_its_sources),
        cmocka_unit_test(tracing_alone_leaves_reused_light_as_it_was),
        cmocka_unit_test(moving_edges_are_smooth),
        cmocka_unit_test(reused_light_fits_windows_of_one_pixel),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
