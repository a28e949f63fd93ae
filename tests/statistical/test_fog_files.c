/// Light in fog, kept in operator files and relit: as it was, and with all of its energy.
#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "unit/file_fixture.h"
#include "unit/fog_fixture.h"

/// A closed black room with a mirrored box, two point lights and lossless fog. All of their power, 0.4 pi W each, ends in the
/// walls.
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

static rsv_light *solve_room(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = 1500;
    desc.rays_per_element = 256;
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
    rsv_light *light = solve_room(w), *read;
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

/// Lights in fog change their strength and place; none of their power is lost.
static void fog_is_relit(void **state)
{
    (void)state;
    world *w = begin_room();
    rsv_light *light = solve_room(w);
    const double each = 0.4 * M_PI;
    const rsv_light_scale scale[2] = { { "left", rgb_gray(3) }, { "right", rgb_gray(0.5f) } };
    const rsv_light_move move = { "right", v3(-0.3f, 0.2f, 0.4f) };
    const rsv_relight_desc stronger = { .light = scale, .light_count = 2 };
    const rsv_relight_desc elsewhere = { .move = &move, .move_count = 1 };
    assert_close(power_at_walls(light), 2 * each, 2 * TOLERANCE * 2 * each);
    relight(light, &stronger, 3.5 * each);
    relight(light, &elsewhere, 3.5 * each);
    rsv_light_destroy(light);
    world_end(w);
}

/// Of fog that scatters unevenly, rows hold light of all lights in one.
static void uneven_fog_is_not_relit(void **state)
{
    (void)state;
    world *w = begin_room();
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1);
    fog.anisotropy = 0.5f;
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    rsv_light *light = solve_room(w);
    const rsv_light_scale scale = { "left", rgb_gray(3) };
    const rsv_relight_desc desc = { .light = &scale, .light_count = 1 };
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
        cmocka_unit_test(uneven_fog_is_not_relit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
