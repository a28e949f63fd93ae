/// Sides of surfaces: backs that a camera sees, and materials shown from both sides though the file has them single-sided.
#include "gltf_fixture.h"

#include "resolvent/render.h"

#include "trace/backs.h"

/// Two walls that a camera at z = 3 sees side by side, each a square metre: the left one, left of x = 0, turns its front to
/// the camera, the right one its back.
/// @param right members of its material
static const char *write_walls(const folder *place, const char *right)
{
    sketch s = { .count = 0 };
    const float corners[2][12] = { { -1, 0, 0, 0, 0, 0, 0, 1, 0, -1, 1, 0 },
        { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 } };
    const uint8_t index[2][6] = { { 0, 1, 2, 0, 2, 3 }, { 0, 2, 1, 0, 3, 2 } };
    char rest[2048];
    for (int k = 0; k < 2; k++) {
        add_vectors(&s, corners[k], 4, 3);
        add_accessor(&s, index[k], 6, 5121, 6, "SCALAR", "");
    }
    snprintf(rest, sizeof rest,
        "\"materials\":[{\"name\":\"left\"},{\"name\":\"right\"%s}],\"meshes\":[{\"primitives\":["
        "{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0},"
        "{\"attributes\":{\"POSITION\":2},\"indices\":3,\"material\":1}]}],"
        "\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":0.5,"
        "\"znear\":0,\"zfar\":9}}],\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0,0.5,3]}"
        "],"
        "\"extensionsUsed\":[\"KHR_materials_transmission\"]",
        right);
    return write_sketch(place, &s, rest);
}

static rsv_scene *load_sides(fixture *f, const char *path, bool two_sided, bool emit_both)
{
    rsv_load_desc desc = rsv_default_load_desc();
    rsv_scene *scene = NULL;
    desc.two_sided = two_sided;
    desc.emit_both = emit_both;
    if (rsv_scene_load_with(f->context, path, &desc, &scene) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    return scene;
}

static void half_a_picture_of_backs_is_counted(void **state)
{
    static const struct {
        const char *right;
        bool two_sided, emit_both;
        double share;
    } cases[] = {
        { "", false, false, 0.5 },
        { "", true, false, 0 },
        { "", false, true, 0.5 },
        { ",\"doubleSided\":true", false, false, 0 },
        { ",\"emissiveFactor\":[1,1,1]", true, false, 0.5 },
        { ",\"emissiveFactor\":[1,1,1]", false, true, 0 },
        { ",\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1}}", false,
            false, 0 },
    };
    fixture *f = *state;
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        rsv_scene *scene = load_sides(
            f, write_walls(&place, cases[k].right), cases[k].two_sided, cases[k].emit_both);
        rsv_tracer *tracer;
        assert_int_equal(rsv_tracer_create(scene, &tracer), RSV_OK);
        const rsv_camera *camera = &rsv_scene_get_view(scene)->camera[0];
        const rsv_seen_backs seen = rsv_look_for_backs(tracer, camera);
        assert_float_equal(seen.share, cases[k].share, 0.01);
        assert_int_equal(seen.material, cases[k].share > 0 ? 1 : RSV_NONE);
        f->log[0] = '\0';
        rsv_warn_of_view(tracer, camera);
        if (cases[k].share > 0)
            assert_mentions(f->log, "'right'");
        else
            assert_string_equal(f->log, "");
        rsv_camera away = *camera; // into the dark around the scene
        away.position = v3(0, 0, 1e3f);
        away.forward = v3(0, 0, 1);
        f->log[0] = '\0';
        rsv_warn_of_view(tracer, &away);
        assert_mentions(f->log, "sees nothing");
        rsv_tracer_destroy(tracer);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static rsv_rgb mean_of(const rsv_image *image, uint32_t first, uint32_t last)
{
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    rsv_rgb sum = { 0, 0, 0 };
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = first; x < last; x++)
            sum = rgb_add(sum, rsv_image_const_pixels(image, 0)[y * width + x]);
    return rgb_scale(sum, 1 / (float)((last - first) * height));
}

/// Both halves of a picture: front and back.
static void take_halves(const rsv_scene *scene, rsv_render_mode mode, double half[2])
{
    rsv_image *image = NULL;
    rsv_light *light = NULL;
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.mode = mode;
    desc.width = 16;
    desc.height = 8;
    desc.samples = mode == RSV_RENDER_REFERENCE ? 256 : 16;
    if (mode == RSV_RENDER_REFERENCE) {
        assert_int_equal(rsv_render_reference(scene, &desc, &image, NULL), RSV_OK);
    } else {
        assert_int_equal(rsv_light_create(scene, &solve, &light), RSV_OK);
        assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    }
    for (uint32_t k = 0; k < 2; k++)
        half[k] = (double)mean_of(image, 8 * k, 8 * k + 8).g;
    rsv_image_destroy(image);
    rsv_light_destroy(light);
}

/// Under a white sky, a wall of one quad has the same brightness from behind as from the front, in every mode.
static void a_wall_of_one_quad_is_lit_from_both_sides(void **state)
{
    static const rsv_render_mode modes[] = { RSV_RENDER_OPERATOR, RSV_RENDER_FINAL,
        RSV_RENDER_REFERENCE };
    folder place = new_folder();
    const char *path = write_walls(&place, "");
    for (int two_sided = 0; two_sided < 2; two_sided++) {
        rsv_scene *scene = load_sides(*state, path, two_sided, false);
        assert_int_equal(rsv_scene_set_builtin_environment(scene, "white", 1, 0), RSV_OK);
        for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
            double half[2];
            take_halves(scene, modes[k], half);
            assert_true(half[0] > 0.5);
            assert_float_equal(half[1], two_sided ? half[0] : 0, two_sided ? 0.03 : 0);
        }
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void lamps_shine_from_behind_where_that_is_wanted(void **state)
{
    folder place = new_folder();
    const char *path = write_walls(&place, ",\"emissiveFactor\":[1,1,1]");
    for (int both = 0; both < 2; both++) {
        rsv_scene *scene = load_sides(*state, path, false, both);
        double half[2];
        take_halves(scene, RSV_RENDER_REFERENCE, half);
        assert_float_equal(half[1], both, 1e-6);
        take_halves(scene, RSV_RENDER_FINAL, half);
        assert_float_equal(half[1], both, 1e-6);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            half_a_picture_of_backs_is_counted, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            a_wall_of_one_quad_is_lit_from_both_sides, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            lamps_shine_from_behind_where_that_is_wanted, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
