/// A room with a lamp and a ball of each rough kind: the operator's picture against the reference's.
#include "resolvent/frame.h"
#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "unit/light_fixture.h"
#include "unit/slow_tests.h"

/// Of the mean over the picture.
#define TOLERANCE 5e-3
/// The reference's own standard error, at most; a large lamp keeps it small.
#define NOISE (TOLERANCE / 3)

static rsv_material ball_material(float metallic, float transmission, float roughness)
{
    rsv_material material = rsv_default_material();
    material.base_color = rgb(0.9f, 0.8f, 0.6f);
    material.metallic = metallic;
    material.transmission = transmission;
    material.thickness = transmission;
    material.roughness = roughness;
    return material;
}

/// Red to the left, green to the right, a lamp under the ceiling.
static world *room_with_ball(rsv_material ball)
{
    world *w = world_begin(2);
    rsv_material wall = rsv_default_material();
    wall.specular = 0;
    wall.base_color = rgb(0.7f, 0.6f, 0.5f);
    world_room(w, world_material(w, wall), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_material lamp = wall;
    lamp.base_color = rgb_gray(0);
    lamp.emission = rgb_gray(3);
    world_quad(w, world_material(w, lamp), v3(-0.7f, 0.99f, -0.7f), v3(0.7f, 0.99f, -0.7f),
        v3(0.7f, 0.99f, 0.7f), v3(-0.7f, 0.99f, 0.7f));
    world_sphere(w, world_material(w, ball), v3(0, -0.4f, -0.1f), 0.55f, 4);
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 0, 0.98f), v3(0, -0.2f, -1), 1.4f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

static double mean_luminance(const rsv_image *image)
{
    const rsv_rgb *pixels = rsv_image_const_pixels(image, 0);
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)rgb_luminance(pixels[i]);
    return sum / (double)count;
}

/// @param samples the reference's camera rays per pixel, and ours
static void check_means(world *w, const uint32_t samples[2])
{
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    rsv_image *reference, *found;
    double error;
    assert_int_equal(rsv_light_create(w->scene, &solve, &solution), RSV_OK);
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = 32;
    desc.samples = samples[0];
    assert_int_equal(rsv_render_reference(w->scene, &desc, &reference, &error), RSV_OK);
    desc.samples = samples[1];
    desc.mode = RSV_RENDER_OPERATOR;
    assert_int_equal(rsv_render(solution, &desc, &found), RSV_OK);
    double expected = mean_luminance(reference);
    print_message(
        "mean %.5f, reference %.5f +- %.2f %%\n", mean_luminance(found), expected, 100 * error);
    assert_true(error < NOISE);
    assert_float_equal(mean_luminance(found), expected, TOLERANCE * expected);
    rsv_image_destroy(reference);
    rsv_image_destroy(found);
    rsv_light_destroy(solution);
    world_end(w);
}

static void check_ball(rsv_material ball)
{
    check_means(room_with_ball(ball), (uint32_t[2]){ 192, 64 });
}

static void rough_metal_agrees_with_the_reference(void **state)
{
    (void)state;
    check_ball(ball_material(1, 0, 0.4f));
}

static void rough_glass_agrees_with_the_reference(void **state)
{
    (void)state;
    check_ball(ball_material(0, 1, 0.4f));
}

static void layers_agree_with_the_reference(void **state)
{
    (void)state;
    rsv_material ball = ball_material(0.3f, 0, 0.5f);
    ball.clearcoat = 1;
    ball.clearcoat_roughness = 0.15f;
    ball.sheen_color = rgb(0.3f, 0.5f, 0.7f);
    ball.sheen_roughness = 0.5f;
    check_ball(ball);
}

static void leaves_agree_with_the_reference(void **state)
{
    (void)state;
    rsv_material ball = ball_material(0, 0, 0.6f);
    ball.diffuse_transmission = 0.5f;
    ball.double_sided = true;
    check_ball(ball);
}

/// A square of frosted glass across the z axis, shaded as if it were tilted by 27 degrees.
static void add_tilted_sheet(world *w, uint32_t material, float z)
{
    const rsv_vec3 corner[4] = { v3(-1, -1, z), v3(1, -1, z), v3(1, 1, z), v3(-1, 1, z) };
    const rsv_vec3 tilted = v3_normalize(v3(0.5f, 0, 1));
    const rsv_vec3 normal[4] = { tilted, tilted, tilted, tilted };
    const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "sheet",
        .positions = corner,
        .normals = normal,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = material };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, id, NULL, NULL), RSV_OK);
}

/// A bulb behind two such sheets: photons that pass through one of them must still find the true surface of the other.
static void tilted_normals_bend_shot_light_as_they_bend_paths(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material frosted = ball_material(0, 1, 0.6f);
    frosted.thickness = 0;
    frosted.double_sided = true;
    uint32_t material = world_material(w, frosted);
    add_tilted_sheet(w, material, 0);
    add_tilted_sheet(w, material, -0.5f);
    const rsv_punctual_light bulb = {
        .kind = RSV_PUNCTUAL_POINT, .position = v3(0.2f, 0.1f, -1.2f), .intensity = rgb_gray(10)
    };
    assert_int_equal(rsv_scene_add_light(w->scene, &bulb), RSV_OK);
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 0, 2), v3(0, 0, -1), 0.9f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    check_means(w, (uint32_t[2]){ 1600, 512 });
}

/// A metal ball between a small lamp and a ceiling under a matt coat: light that only few rays of the coat would find.
static world *room_with_glint(void)
{
    world *w = world_begin(2);
    rsv_material wall = rsv_default_material();
    wall.roughness = 1;
    wall.base_color = rgb_gray(0.1f);
    world_room(w, world_material(w, wall), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_material lamp = wall;
    lamp.specular = 0;
    lamp.base_color = rgb_gray(0);
    lamp.emission = rgb_gray(300);
    world_quad(w, world_material(w, lamp), v3(-0.05f, 0.99f, -0.05f), v3(0.05f, 0.99f, -0.05f),
        v3(0.05f, 0.99f, 0.05f), v3(-0.05f, 0.99f, 0.05f));
    world_sphere(
        w, world_material(w, ball_material(1, 0, 0.18f)), v3(0.3f, -0.8f, -0.1f), 0.15f, 4);
    rsv_camera camera =
        rsv_camera_look_at("eye", v3(0, -0.9f, 0.98f), v3(-0.5f, 1, -0.8f), 0.4f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

/// The layer of light that specular events alone bring: luminance [SIDE * SIDE].
/// @param gathered all of it is met by chance: nothing is shot where samples have shared places
#define SIDE 32
static void render_glints(
    const rsv_light *solution, rsv_render_mode mode, bool gathered, uint32_t samples, double *glint)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = mode;
    desc.width = desc.height = SIDE;
    desc.samples = samples;
    desc.shared_pattern = gathered;
    desc.layers = true;
    desc.seed = samples;
    assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
    const rsv_rgb *pixels = rsv_image_const_pixels(image, 1);
    for (size_t i = 0; i < SIDE * SIDE; i++)
        glint[i] = (double)rgb_luminance(pixels[i]);
    rsv_image_destroy(image);
}

static double mean_of(const double *value)
{
    double sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++)
        sum += value[i];
    return sum / (SIDE * SIDE);
}

static void matt_coats_show_glints_without_specks(void **state)
{
    (void)state;
    world *w = room_with_glint();
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &solve, &solution), RSV_OK);
    double shot[SIDE * SIDE], finely[SIDE * SIDE], gathered[SIDE * SIDE];
    render_glints(solution, RSV_RENDER_OPERATOR, false, 4, shot);
    render_glints(solution, RSV_RENDER_FINAL, false, 511, finely);
    render_glints(solution, RSV_RENDER_OPERATOR, true, 512, gathered);
    double mean = mean_of(gathered), squares = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++)
        squares += (shot[i] - finely[i]) * (shot[i] - finely[i]);
    double rms = sqrt(squares) / SIDE;
    print_message("mean %g, gathered %g; specks of %g\n", mean_of(shot), mean, rms);
    assert_float_equal(mean_of(shot), mean, 0.01 * mean);
    assert_true(rms < 0.05 * mean);
    rsv_light_destroy(solution);
    world_end(w);
}

// ---- a clear coat with normals of its own --------------------------------------------------------------

/// A black floor under a polished coat that may have waves: all that is seen of it is what the coat reflects of walls and lamp.
static world *room_with_coat(bool waves)
{
    static const rsv_texture_role role[] = { RSV_TEXTURE_CLEARCOAT_NORMAL };
    world *w = world_begin(2);
    rsv_material wall = rsv_default_material();
    wall.specular = 0;
    wall.base_color = rgb(0.7f, 0.5f, 0.3f);
    world_room(w, world_material(w, wall), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_material lamp = wall;
    lamp.base_color = rgb_gray(0);
    lamp.emission = rgb_gray(3);
    world_quad(w, world_material(w, lamp), v3(-0.7f, 0.99f, -0.7f), v3(0.7f, 0.99f, -0.7f),
        v3(0.7f, 0.99f, 0.7f), v3(-0.7f, 0.99f, 0.7f));
    rsv_material floor = wall;
    floor.base_color = rgb_gray(0);
    floor.clearcoat = 1;
    floor.clearcoat_roughness = 0.1f;
    const rsv_vec3 corner[4] = { v3(-1, -0.9f, -1), v3(-1, -0.9f, 1), v3(1, -0.9f, 1),
        v3(1, -0.9f, -1) };
    world_pattern(w, floor, corner, role, waves ? 1 : 0);
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, -0.4f, 0.9f), v3(0, -0.9f, -0.1f), 0.4f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

enum { BLOCKS = 8, BLOCK = SIDE / BLOCKS };

/// Mean luminance, and that of blocks of pixels [BLOCKS * BLOCKS].
typedef struct blocks {
    double mean, block[BLOCKS * BLOCKS];
} blocks;

static blocks blocks_of(const rsv_rgb *pixels)
{
    blocks b = { 0 };
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        double luminance = (double)rgb_luminance(pixels[i]);
        b.mean += luminance / (SIDE * SIDE);
        b.block[i / SIDE / BLOCK * BLOCKS + i % SIDE / BLOCK] += luminance / (BLOCK * BLOCK);
    }
    return b;
}

/// Root mean square of the difference of blocks, relative to the mean.
static double difference(const blocks *a, const blocks *b)
{
    double squares = 0;
    for (int k = 0; k < BLOCKS * BLOCKS; k++)
        squares += (a->block[k] - b->block[k]) * (a->block[k] - b->block[k]);
    return sqrt(squares) / BLOCKS / b->mean;
}

static blocks blocks_of_picture(
    const rsv_light *solution, rsv_render_mode mode, uint32_t samples, double *error)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.width = desc.height = SIDE;
    desc.samples = samples;
    desc.mode = mode;
    if (mode == RSV_RENDER_REFERENCE)
        assert_int_equal(
            rsv_render_reference(rsv_light_scene(solution), &desc, &image, error), RSV_OK);
    else
        assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
    blocks found = blocks_of(rsv_image_const_pixels(image, 0));
    rsv_image_destroy(image);
    return found;
}

static blocks blocks_of_frames(const rsv_light *solution, uint32_t count)
{
    static rsv_rgb radiance[SIDE * SIDE];
    rsv_frame_desc desc = rsv_default_frame_desc();
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_light_scene(solution));
    const rsv_frame_view view = { .camera = { scene->camera[0] } };
    rsv_frame_renderer *renderer;
    desc.width = desc.height = SIDE;
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_OK);
    for (uint32_t k = 0; k < count; k++)
        assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
    rsv_frame_radiance(renderer, 0, radiance);
    rsv_frame_renderer_destroy(renderer);
    return blocks_of(radiance);
}

static void coats_with_normals_of_their_own_look_alike_in_all_modes(void **state)
{
    (void)state;
    world *flat = room_with_coat(false), *w = room_with_coat(true);
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution, *even;
    double error = 0;
    assert_int_equal(rsv_light_create(w->scene, &solve, &solution), RSV_OK);
    assert_int_equal(rsv_light_create(flat->scene, &solve, &even), RSV_OK);
    blocks without = blocks_of_picture(even, RSV_RENDER_FINAL, 64, NULL);
    blocks expected = blocks_of_picture(solution, RSV_RENDER_REFERENCE, 512, &error);
    const blocks found[] = { blocks_of_picture(solution, RSV_RENDER_FINAL, 64, NULL),
        blocks_of_picture(solution, RSV_RENDER_OPERATOR, 64, NULL),
        blocks_of_frames(solution, 64) };
    assert_true(error < TOLERANCE); // of a coat that few paths meet
    for (int k = 0; k < 3; k++) {
        print_message("mean %.5f, reference %.5f +- %.2f %%; blocks differ by %.1f %%\n",
            found[k].mean, expected.mean, 100 * error, 100 * difference(&found[k], &expected));
        // the first frame, an approximation, is one of those that add up
        double tolerance = k == 2 ? 5 * TOLERANCE : 3 * TOLERANCE;
        assert_float_equal(found[k].mean, expected.mean, tolerance * expected.mean);
        assert_true(difference(&found[k], &expected) < 0.08);
    }
    print_message("without waves %.1f %%\n", 100 * difference(&without, &expected));
    assert_true(difference(&without, &expected) > 0.16);
    rsv_light_destroy(even);
    rsv_light_destroy(solution);
    world_end(flat);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(matt_coats_show_glints_without_specks),
        cmocka_unit_test(rough_metal_agrees_with_the_reference),
        cmocka_unit_test(rough_glass_agrees_with_the_reference),
        cmocka_unit_test(layers_agree_with_the_reference),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(leaves_agree_with_the_reference),
        cmocka_unit_test(coats_with_normals_of_their_own_look_alike_in_all_modes),
        cmocka_unit_test(tilted_normals_bend_shot_light_as_they_bend_paths),
    };
    return RUN_HALF(argc, argv, tests, longest);
}
