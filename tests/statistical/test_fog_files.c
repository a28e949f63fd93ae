/// Light in fog, kept in operator files and relit: as it was, and with all of its energy.
#include "resolvent/bake.h"
#include "resolvent/frame.h"
#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "unit/file_fixture.h"
#include "unit/fog_fixture.h"

/// A closed black room with a mirrored box, two point lights and lossless fog. All of their power, 0.4 pi W each, ends
/// in the walls.
static world *begin_room(void)
{
    world *w = world_begin(2);
    const char *const name[2] = { "left", "right" };
    world_room(w, world_lambert(w, 0, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_box(
        w, world_material(w, mirror_material(1)), v3(-0.4f, -0.8f, -0.5f), v3(0.3f, -0.2f, 0.3f));
    for (int k = 0; k < 2; k++)
        add_lamp(w, (rsv_punctual_light){ .name = name[k],
                        .position = v3(k ? 0.6f : -0.6f, 0.3f, -0.1f),
                        .intensity = rgb_gray(0.1f) });
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1.5f);
    fill(w, fog);
    return w;
}

static rsv_light *solve_with(const world *w, size_t elements, uint32_t rays)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = elements;
    desc.rays_per_element = rays;
    desc.photon_count = 50000;
    assert_int_equal(rsv_light_create(w->scene, &desc, &light), RSV_OK);
    return light;
}

static uint64_t hash_picture(const rsv_light *light)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_camera camera = rsv_camera_look_at("eye", v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 1, 1);
    rsv_image *image;
    desc.width = desc.height = 16;
    desc.samples = 4;
    desc.viewpoint = &camera;
    assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    uint64_t hash = hash_bytes(HASH_START, rsv_image_pixels(image, 0), 256 * sizeof(rsv_rgb));
    rsv_image_destroy(image);
    return hash;
}

/// A solution in fog comes back from its file as it went in.
static void files_keep_fog(void **state)
{
    (void)state;
    world *w = begin_room();
    rsv_light *light = solve_with(w, 300, 64), *read;
    rsv_scene *scene;
    folder f = new_folder();
    const char *path = path_in(&f, "fog.safetensors");
    assert_int_equal(rsv_light_save(light, "fog", path), RSV_OK);
    assert_int_equal(rsv_light_load(w->context, path, &scene, &read), RSV_OK);
    const rsv_fog *fog = rsv_scene_get_view(scene)->fog;
    assert_non_null(fog);
    assert_memory_equal(fog, rsv_scene_get_view(w->scene)->fog, sizeof *fog);
    size_t count = rsv_operator_element_count(rsv_light_operator(light));
    assert_int_equal(rsv_operator_element_count(rsv_light_operator(read)), count);
    assert_memory_equal(rsv_light_irradiance_field(read), rsv_light_irradiance_field(light),
        count * sizeof(rsv_rgb));
    assert_true(hash_picture(read) == hash_picture(light));
    remove_folder(f.path);
    rsv_light_destroy(read);
    rsv_scene_destroy(scene);
    rsv_light_destroy(light);
    world_end(w);
}

static void relight(rsv_light *light, const rsv_relight_desc *desc, double expected)
{
    assert_int_equal(rsv_light_relight(light, desc), RSV_OK);
    double power = power_at_walls(light);
    print_message("relit: %g W of %g\n", power, expected);
    assert_close(power, expected, 2 * TOLERANCE * expected);
}

/// Lights in fog change strength and position; the walls still absorb all of their power.
static void fog_is_relit(void **state)
{
    (void)state;
    world *w = begin_room();
    rsv_light *light = solve_with(w, 800, 128);
    const double each = 0.4 * M_PI;
    const rsv_light_scale scale[2] = { { "left", rgb_gray(3) }, { "right", rgb_gray(0.5f) } };
    const rsv_light_move move = { "right", v3(-0.3f, 0.2f, 0.4f) };
    const rsv_relight_desc stronger = { .size = sizeof stronger, .light = scale, .light_count = 2 };
    const rsv_relight_desc elsewhere = { .size = sizeof elsewhere, .move = &move, .move_count = 1 };
    assert_close(power_at_walls(light), 2 * each, 2 * TOLERANCE * 2 * each);
    relight(light, &stronger, 3.5 * each);
    relight(light, &elsewhere, 3.5 * each);
    rsv_light_destroy(light);
    world_end(w);
}

static rsv_rgb mean_of(const rsv_rgb *pixel, size_t count)
{
    rsv_rgb sum = rgb_gray(0);
    for (size_t k = 0; k < count; k++)
        sum = rgb_mad(sum, 1 / (float)count, pixel[k]);
    return sum;
}

/// The mean of frames, all layers or one.
static rsv_rgb see_frames(const rsv_light *light, const rsv_camera *camera, uint32_t layer)
{
    enum { WIDTH = 80, HEIGHT = 60, COUNT = 8 };
    rsv_frame_desc desc = rsv_default_frame_desc();
    rsv_frame_view view = { .camera = { *camera, *camera } };
    rsv_frame_renderer *renderer;
    static rsv_rgb pixel[WIDTH * HEIGHT];
    desc.width = WIDTH;
    desc.height = HEIGHT;
    desc.frames = COUNT;
    assert_int_equal(rsv_frame_renderer_create(light, &desc, &renderer), RSV_OK);
    rsv_frame_renderer_show(renderer, layer);
    for (int k = 0; k < COUNT; k++)
        assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
    rsv_frame_radiance(renderer, 0, pixel);
    rsv_frame_renderer_destroy(renderer);
    return mean_of(pixel, sizeof pixel / sizeof *pixel);
}

/// Without emission, because a lamp that covers few pixels is too noisy.
static rsv_rgb see_operator(const rsv_light *light, const rsv_camera *camera)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = RSV_RENDER_OPERATOR;
    desc.width = 80;
    desc.height = 60;
    desc.samples = 4;
    desc.viewpoint = camera;
    desc.layers = true;
    assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    rsv_rgb mean = rgb_sub(
        mean_of(rsv_image_pixels(image, 0), 80 * 60), mean_of(rsv_image_pixels(image, 1), 80 * 60));
    rsv_image_destroy(image);
    return mean;
}

/// Frames interpolate fog between columns and slices: their means are those of mode operator, through mirrors too.
static void frames_show_fog(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-spheres");
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb(1, 1.5f, 0.5f);
    fog.albedo = rgb_gray(0.9f);
    fill(w, fog);
    rsv_light *light = solve_with(w, 500, 64);
    const rsv_camera *camera = &rsv_scene_get_view(w->scene)->camera[0];
    rsv_rgb exact = see_operator(light, camera), sum = rgb_gray(0);
    rsv_rgb all = rgb_sub(see_frames(light, camera, UINT32_MAX), see_frames(light, camera, 0));
    for (uint32_t layer = 1; layer <= rsv_light_order_count(light); layer++)
        sum = rgb_add(sum, see_frames(light, camera, layer));
    for (int c = 0; c < 3; c++) {
        print_message("frames %g, layers %g, mode operator %g\n", (double)channel(all, c),
            (double)channel(sum, c), (double)channel(exact, c));
        assert_close(channel(all, c), channel(exact, c), TOLERANCE * (double)channel(exact, c));
        assert_close(channel(sum, c), channel(all, c), TOLERANCE * (double)channel(all, c));
    }
    rsv_light_destroy(light);
    world_end(w);
}

/// In a furnace, fog is invisible.
static void frames_of_a_furnace_are_even(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0.5f), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1);
    fill(w, fog);
    rsv_light *light = solve_with(w, 300, 128);
    rsv_camera eye = rsv_camera_look_at("eye", v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 1, 1);
    rsv_rgb seen = see_frames(light, &eye, UINT32_MAX);
    for (int c = 0; c < 3; c++)
        assert_close(channel(seen, c), 1, 1e-3);
    rsv_light_destroy(light);
    world_end(w);
}

static rsv_bake_desc brief_bake(const rsv_bake_visitor *visitor)
{
    rsv_bake_desc desc = rsv_default_bake_desc();
    desc.visitor = visitor;
    return desc;
}

/// The fluence of fog in a furnace, 4 pi, in a texture of shared exponents.
static void fluence_is_baked(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0.5f), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1);
    fog.bounds_min = v3(-1, -1, -1);
    fog.bounds_max = v3(1, 1, 1);
    fill(w, fog);
    rsv_light *light = solve_with(w, 300, 64);
    rsv_bake_desc desc = brief_bake(NULL);
    rsv_bake_report report;
    folder f = new_folder();
    size_t bytes;
    assert_int_equal(rsv_bake(light, "fog", path_in(&f, "a.json"), &desc, &report), RSV_OK);
    uint8_t *file = read_bytes(path_in(&f, "a.fog.ktx2"), &bytes);
    uint32_t size[3],
        texels = report.probe_count[0] * report.probe_count[1] * report.probe_count[2];
    memcpy(size, file + 20, sizeof size); // pixelWidth, pixelHeight, pixelDepth
    assert_memory_equal(size, report.probe_count, sizeof size);
    for (uint32_t k = 0; k < texels; k++) {
        uint32_t code;
        memcpy(&code, file + bytes - 4 * (texels - k), 4);
        double value = ldexp(code & 511, (int)(code >> 27) - 24);
        assert_close(value, 4 * M_PI, 0.01 * 4 * M_PI);
    }
    free(file);
    remove_folder(f.path);
    rsv_light_destroy(light);
    world_end(w);
}

static bool wants_all(void *user, const uint32_t at[2], const uint32_t size[2])
{
    (void)user, (void)at, (void)size;
    return true;
}

/// Irradiance by a lamp at a place on the floor, through fog of extinction 2/m.
static double absorbed_at(const rsv_scene_view *view, const rsv_surface_place *p)
{
    const uint32_t *corner = view->triangle[p->triangle];
    rsv_vec3 at = v3_barycentric(view->position[corner[0]], view->position[corner[1]],
        view->position[corner[2]], p->u, p->v);
    double d = (double)v3_length(v3_sub(v3(0.1f, 1, 0), at));
    return exp(-2 * d) / (d * d * d);
}

static void take_absorbed(void *user, const rsv_bake_value *value)
{
    double expected = 0;
    for (uint32_t k = 0; k < value->place_count; k++)
        expected += absorbed_at(user, &value->place[k]) / value->place_count;
    assert_close(value->irradiance.g, expected, 0.02 * expected);
}

/// A lamp over a floor in fog that absorbs.
static void vertices_know_what_fog_takes(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1));
    add_lamp(w, (rsv_punctual_light){ .position = v3(0.1f, 1, 0), .intensity = rgb_gray(1) });
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(2);
    fog.albedo = rgb_gray(0);
    fill(w, fog);
    rsv_light *light = solve_with(w, 300, 64);
    const rsv_bake_visitor visitor = { (void *)(uintptr_t)rsv_scene_get_view(w->scene), wants_all,
        take_absorbed };
    rsv_bake_desc desc = brief_bake(&visitor);
    folder f = new_folder();
    assert_int_equal(rsv_bake_vertices(light, path_in(&f, "a.glb"), &desc, NULL), RSV_OK);
    remove_folder(f.path);
    rsv_light_destroy(light);
    world_end(w);
}

/// If the fog scatters anisotropically, rows hold the sum of all lights.
static void uneven_fog_is_not_relit(void **state)
{
    (void)state;
    world *w = begin_room();
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1);
    fog.anisotropy = 0.5f;
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    rsv_light *light = solve_with(w, 200, 64);
    const rsv_light_scale scale = { "left", rgb_gray(3) };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = &scale, .light_count = 1 };
    assert_int_equal(rsv_light_relight(light, &desc), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "unevenly"));
    rsv_light_destroy(light);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_keep_fog),
        cmocka_unit_test(fog_is_relit),
        cmocka_unit_test(fluence_is_baked),
        cmocka_unit_test(vertices_know_what_fog_takes),
        cmocka_unit_test(frames_show_fog),
        cmocka_unit_test(frames_of_a_furnace_are_even),
        cmocka_unit_test(uneven_fog_is_not_relit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
