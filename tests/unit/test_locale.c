/// The library in a program whose locale writes 1,5: files still use decimal points.
#include "core/number_text.h"
#include "file_fixture.h"
#include "light_fixture.h"
#include "resolvent/bake.h"
#include "resolvent/image.h"
#include "resolvent/io.h"
#include "resolvent/opfile.h"
#include "resolvent/solve.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>

#define COMMAS "de_DE.UTF-8"

/// Compiles a locale with commas, as machines that test rarely have one, and chooses it.
static int choose_commas(void **state)
{
    static folder f;
    char command[512];
    f = new_folder();
    *state = &f;
    snprintf(command, sizeof command, "localedef -i de_DE -f UTF-8 '%s' >/dev/null 2>&1",
        path_in(&f, COMMAS));
    setenv("LOCPATH", f.path, 1);
    int warned = system(command);
    (void)warned; // it warns of what is no harm here
    if (!setlocale(LC_ALL, COMMAS))
        print_message(
            "skipped: no locale with commas can be made; the package locales would help\n");
    return 0;
}

static int forget_commas(void **state)
{
    const folder *f = *state;
    setlocale(LC_ALL, "C");
    remove_folder(f->path);
    return 0;
}

static void skip_without_commas(void)
{
    if (strcmp(localeconv()->decimal_point, ",") != 0) skip();
}

static void numbers_have_points(void **state)
{
    (void)state;
    char text[RSV_NUMBER_BYTES], *end;
    skip_without_commas();
    rsv_number_text(text, 17, -0.1);
    assert_string_equal(text, "-0.10000000000000001");
    assert_true(rsv_number_value("0.25,5", &end) == 0.25);
    assert_string_equal(end, ",5");
    snprintf(text, sizeof text, "%.1f", 0.5);
    assert_string_equal(text, "0,5"); // the program's own choice stands
}

/// Everything of a room that has numbers in it, by the locale that is chosen now.
static void write_all(const folder *f)
{
    static const char sky[] =
        "#?RADIANCE\nEXPOSURE=1.5\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81";
    char room[300], file[300];
    world *w = world_builtin(1, "cornell-blocks");
    snprintf(room, sizeof room, "%s", path_in(f, "room.glb"));
    assert_int_equal(rsv_scene_save(w->scene, room), RSV_OK);
    rsv_scene_destroy(w->scene);
    assert_int_equal(rsv_scene_load(w->context, room, &w->scene), RSV_OK);
    snprintf(file, sizeof file, "%s", path_in(f, "sky.hdr"));
    write_bytes(file, sky, sizeof sky - 1);
    rsv_image *image;
    assert_int_equal(rsv_image_read(w->context, file, &image), RSV_OK);
    float brightness = rsv_image_pixels(image, 0)[0].r;
    assert_float_equal(brightness, 1 / 1.5, 0.01);
    const rsv_rgb pixel[2] = { { brightness, 1, 1 }, { 1, 1, brightness } };
    const rsv_environment environment = { "sky", pixel, 2, 1, 1, 0.5f };
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    rsv_image_destroy(image);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 60;
    desc.rays_per_element = 64;
    rsv_light *solution, *again;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    snprintf(file, sizeof file, "%s", path_in(f, "solved.safetensors"));
    assert_int_equal(rsv_light_save(solution, "room", file), RSV_OK);
    rsv_scene *loaded;
    assert_int_equal(rsv_light_load(w->context, file, &loaded, &again), RSV_OK);
    rsv_light_destroy(again);
    rsv_scene_destroy(loaded);
    rsv_bake_desc bake = rsv_default_bake_desc();
    rsv_bake_report report;
    bake.basis = true;
    bake.turns = 2;
    assert_int_equal(rsv_bake_vertices(solution, path_in(f, "baked.glb"), &bake, &report), RSV_OK);
    rsv_light_destroy(solution);
    world_end(w);
}

static void files_are_the_same(void **state)
{
    (void)state;
    static const char *const name[] = { "room.glb", "solved.safetensors", "baked.glb",
        "baked.light.safetensors" };
    skip_without_commas();
    folder f[2] = { new_folder(), new_folder() };
    write_all(&f[0]);
    setlocale(LC_ALL, "C");
    write_all(&f[1]);
    setlocale(LC_ALL, COMMAS);
    for (size_t n = 0; n < sizeof name / sizeof *name; n++) {
        uint8_t *content[2];
        size_t bytes[2];
        for (int k = 0; k < 2; k++)
            content[k] = read_bytes(path_in(&f[k], name[n]), &bytes[k]);
        assert_int_equal(bytes[0], bytes[1]);
        assert_memory_equal(content[0], content[1], bytes[0]);
        free(content[0]);
        free(content[1]);
    }
    for (int k = 0; k < 2; k++)
        remove_folder(f[k].path);
}

static const char collada[] =
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
    "version=\"1.4.1\"><library_cameras><camera id=\"c\" "
    "name=\"c\"><optics><technique_common><perspective>"
    "<xfov>49.5</xfov><aspect_ratio>1.75</aspect_ratio><znear>0.1</znear><zfar>100</zfar>"
    "</perspective></technique_common></optics></camera></library_cameras><library_geometries>"
    "<geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 1 0"
    "</float_array><technique_common><accessor source=\"#pa\" count=\"3\" stride=\"3\">"
    "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
    "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>"
    "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p>"
    "</triangles></mesh></geometry></library_geometries><library_visual_scenes>"
    "<visual_scene id=\"s\"><node id=\"m\" name=\"m\"><instance_geometry url=\"#g\"/></node><node "
    "id=\"n\" name=\"n\">"
    "<instance_camera url=\"#c\"/></node></visual_scene></library_visual_scenes>"
    "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";

static void assimp_reads_points(void **state)
{
    (void)state;
    skip_without_commas();
    folder f = new_folder();
    world *w = world_begin(1);
    const char *path = path_in(&f, "a.dae");
    write_bytes(path, collada, sizeof collada - 1);
    rsv_scene *scene;
    assert_int_equal(rsv_scene_load(w->context, path, &scene), RSV_OK);
    const rsv_camera *camera = rsv_scene_get_view(scene)->camera;
    double horizontal = 49.5 * acos(-1) / 180;
    assert_float_equal(camera->vertical_fov, 2 * atan(tan(horizontal / 2) / 1.75), 1e-4);
    rsv_scene_destroy(scene);
    world_end(w);
    remove_folder(f.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_have_points),
        cmocka_unit_test(files_are_the_same),
        cmocka_unit_test(assimp_reads_points),
    };
    return cmocka_run_group_tests(tests, choose_commas, forget_commas);
}
