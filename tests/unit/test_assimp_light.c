/// Lights and cameras of FBX and COLLADA have the intended strengths and fields of view, in any unit.
#include "io/fbx_scan.h"
#include "resolvent/io.h"
#include "unit/file_fixture.h"

static folder files;

static int enter(void **state)
{
    files = new_folder();
    return fixture_setup(state);
}

static int leave(void **state)
{
    remove_folder(files.path);
    return fixture_teardown(state);
}

static rsv_scene *load(fixture *f, const char *name)
{
    rsv_scene *scene = NULL;
    f->log[0] = '\0';
    if (rsv_scene_load(f->context, path_in(&files, name), &scene) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    return scene;
}

#define assert_about(a, b) assert_float_equal((a) / (b), 1, 1e-4)

/// Irradiance on the floor right below the first light, ignoring occluders.
static float below(const rsv_scene_view *view)
{
    const rsv_punctual_light *light = &view->light[0];
    if (light->kind == RSV_PUNCTUAL_DIRECTIONAL) return light->intensity.r;
    return light->intensity.r / (light->position.y * light->position.y);
}

static const double metres[] = { 1, 0.01, 0.001, 0.0254 };

// ---- COLLADA --------------------------------------------------------------------------------------

#define FLOOR                                                                                      \
    "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"pa\" "        \
    "count=\"9\">0 0 0 0 0 9 9 0 0</float_array><technique_common><accessor source=\"#pa\" "       \
    "count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "                \
    "type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"    \
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles "        \
    "count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles>"  \
    "</mesh></geometry></library_geometries>"

/// @param library cameras or lights @param nodes that use them
static void write_collada(const char *tool, double metre, const char *library, const char *nodes)
{
    FILE *file = fopen(path_in(&files, "a.dae"), "w");
    assert_non_null(file);
    fprintf(file,
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
        "version=\"1.4.1\"><asset><contributor><authoring_tool>%s</authoring_tool></contributor>"
        "<unit name=\"u\" meter=\"%.9g\"/><up_axis>Y_UP</up_axis></asset>%s" FLOOR
        "<library_visual_scenes><visual_scene id=\"s\"><node id=\"n\"><instance_geometry "
        "url=\"#g\"/></node>%s</visual_scene></library_visual_scenes><scene>"
        "<instance_visual_scene url=\"#s\"/></scene></COLLADA>",
        tool, metre, library, nodes);
    fclose(file);
}

/// The importer reads an invalid number as one metre, and an invalid axis as y.
static void collada_units_that_are_no_numbers_are_named(void **state)
{
    fixture *f = *state;
    static const char *const meter[] = { "one", "", "0.01", "1" };
    for (int k = 0; k < 4; k++) {
        write_collada("any", 1, "", "");
        size_t bytes;
        char *text = (char *)read_bytes(path_in(&files, "a.dae"), &bytes);
        text[bytes] = '\0';
        char *at = strstr(text, "meter=\"");
        FILE *file = fopen(path_in(&files, "b.dae"), "w");
        assert_non_null(file);
        if (k == 1) *strstr(text, "Y_UP") = 'W';
        fprintf(file, "%.*smeter=\"%s%s", (int)(at - text), text, meter[k], at + 8);
        fclose(file);
        free(text);
        f->log[0] = 0;
        rsv_scene_destroy(load(f, "b.dae"));
        assert_int_equal(count_mentions(f->log, "is not a number of metres; 1 is used"), k < 2);
        assert_int_equal(count_mentions(f->log, "its <up_axis> is not"), k == 1);
    }
}

static rsv_scene *load_collada_light(
    fixture *f, const char *tool, double metre, const char *kind, const char *more)
{
    char library[1024], nodes[256];
    snprintf(library, sizeof library,
        "<library_lights><light id=\"lamp\"><technique_common><%s>%s</%s></technique_common>"
        "</light></library_lights>",
        kind, more, kind);
    snprintf(nodes, sizeof nodes,
        "<node id=\"l\"><translate>1 %.9g 1</translate><rotate>1 0 0 -90</rotate>"
        "<instance_light url=\"#lamp\"/></node>",
        2 / metre);
    write_collada(tool, metre, library, nodes);
    return load(f, "a.dae");
}

static void collada_lights_are_as_bright_in_any_unit(void **state)
{
    for (size_t k = 0; k < sizeof metres / sizeof *metres; k++) {
        static const char *const kinds[] = { "point", "spot" };
        for (int n = 0; n < 2; n++) {
            char more[256];
            snprintf(more, sizeof more,
                "<color>5 5 5</color><constant_attenuation>0</constant_attenuation>"
                "<quadratic_attenuation>%.9g</quadratic_attenuation>",
                0.5 * metres[k] * metres[k]);
            rsv_scene *scene = load_collada_light(*state, "any", metres[k], kinds[n], more);
            assert_about(below(rsv_scene_get_view(scene)), 2.5f);
            assert_null(strstr(((fixture *)*state)->log, "square of the distance"));
            rsv_scene_destroy(scene);
        }
        rsv_scene *scene =
            load_collada_light(*state, "any", metres[k], "directional", "<color>2.5 1 1</color>");
        assert_about(below(rsv_scene_get_view(scene)), 2.5f);
        rsv_scene_destroy(scene);
    }
}

/// A strength in units of the file: the same number of them per square unit.
static void collada_strengths_are_in_units_of_the_file(void **state)
{
    for (size_t k = 0; k < sizeof metres / sizeof *metres; k++) {
        char more[256];
        double strength = 10 / (metres[k] * metres[k]);
        snprintf(more, sizeof more,
            "<color>%.9g %.9g %.9g</color><constant_attenuation>0</constant_attenuation>"
            "<quadratic_attenuation>1</quadratic_attenuation>",
            strength, strength, strength);
        rsv_scene *scene = load_collada_light(*state, "any", metres[k], "point", more);
        assert_about(below(rsv_scene_get_view(scene)), 2.5f);
        rsv_scene_destroy(scene);
    }
}

static void watts_of_blender_are_spread_over_the_sphere(void **state)
{
    static const struct {
        const char *tool;
        float expected;
    } blender[] = { { "Blender 2.82.7 commit date:2020-03-12", 2.5f }, { "Blender 4.2.1", 2.5f },
        { "Blender 2.79.0 commit date:2018-03-22", 28274.33f } };
    static const char more[] =
        "<color>125.66371 125.66371 125.66371</color><constant_attenuation>1</constant_attenuation>"
        "<linear_attenuation>0</linear_attenuation>"
        "<quadratic_attenuation>0.00111109</quadratic_attenuation>";
    for (size_t k = 0; k < sizeof blender / sizeof *blender; k++) {
        rsv_scene *scene = load_collada_light(*state, blender[k].tool, 1, "point", more);
        assert_float_equal(below(rsv_scene_get_view(scene)) / blender[k].expected, 1, 1e-3);
        rsv_scene_destroy(scene);
    }
}

static void collada_spots_end_where_they_say(void **state)
{
    rsv_scene *scene = load_collada_light(*state, "any", 1, "spot",
        "<color>1 1 1</color><quadratic_attenuation>1</quadratic_attenuation>"
        "<falloff_angle>60</falloff_angle><falloff_exponent>2</falloff_exponent>");
    const rsv_punctual_light *light = &rsv_scene_get_view(scene)->light[0];
    assert_int_equal(light->kind, RSV_PUNCTUAL_SPOT);
    assert_about(light->outer_cone_angle, 0.52359878f);
    assert_about(light->inner_cone_angle, 0.52359878f);
    assert_about(light->exponent, 2);
    assert_about(light->direction.y, -1);
    rsv_scene_destroy(scene);
}

static void every_light_of_a_node_shines_and_ambient_ones_are_named(void **state)
{
    fixture *f = *state;
    write_collada("any", 1,
        "<library_lights><light id=\"a\"><technique_common><point><color>1 1 1</color></point>"
        "</technique_common></light><light id=\"b\"><technique_common><ambient><color>1 1 1"
        "</color></ambient></technique_common></light></library_lights>",
        "<node id=\"one\"><instance_light url=\"#a\"/><instance_light url=\"#a\"/></node>"
        "<node id=\"two\"><instance_light url=\"#a\"/></node><node id=\"three\"><instance_light "
        "url=\"#b\"/></node>");
    rsv_scene *scene = load(f, "a.dae");
    assert_int_equal(rsv_scene_get_view(scene)->light_count, 3);
    assert_mentions(f->log, "light 'three': ambient");
    rsv_scene_destroy(scene);
}

static void collada_cameras_see_what_they_say(void **state)
{
    static const struct {
        const char *projection, *node;
        double vertical_fov, vertical_extent, aspect;
        const char *warning;
    } lens[] = {
        { "<perspective><xfov>90</xfov></perspective>", "id=\"c\"", 90, 0, 1, NULL },
        { "<perspective><yfov>40</yfov></perspective>", "id=\"c\"", 40, 0, 1, NULL },
        { "<perspective><yfov>40</yfov></perspective>", "", 40, 0, 1, NULL },
        { "<perspective><yfov>40</yfov></perspective>", "sid=\"x\"", 40, 0, 1, NULL },
        { "<perspective><xfov>90</xfov><aspect_ratio>2</aspect_ratio></perspective>", "id=\"c\"",
            53.130102, 0, 2, NULL },
        { "<perspective><yfov sid=\"f\">40</yfov><aspect_ratio>1.5</aspect_ratio></perspective>",
            "id=\"a &amp; b\"", 40, 0, 1.5, NULL },
        { "<perspective><xfov>90</xfov><yfov>53.130102</yfov></perspective>", "id=\"c\"", 53.130102,
            0, 2, NULL },
        { "<orthographic><xmag>300</xmag><ymag>200</ymag></orthographic>", "id=\"c\"", 0, 2, 1.5,
            NULL },
        { "<orthographic><ymag>200</ymag></orthographic>", "id=\"c\"", 0, 2, 1, NULL },
        { "<perspective><znear>1</znear></perspective>", "", 45, 0, 1, "45 degrees" },
    };
    for (size_t k = 0; k < sizeof lens / sizeof *lens; k++) {
        fixture *f = *state;
        char library[512], nodes[256];
        snprintf(library, sizeof library,
            "<library_cameras><camera id=\"lens\"><optics><technique_common>%s</technique_common>"
            "</optics></camera></library_cameras>",
            lens[k].projection);
        snprintf(nodes, sizeof nodes,
            "<node %s><translate>0 100 0</translate><instance_camera url=\"#lens\"/></node>",
            lens[k].node);
        write_collada("any", 0.01, library, nodes);
        rsv_scene *scene = load(f, "a.dae");
        const rsv_camera *camera = &rsv_scene_get_view(scene)->camera[0];
        assert_float_equal(camera->vertical_fov * 57.29577951, lens[k].vertical_fov, 1e-3);
        assert_float_equal(camera->vertical_extent, lens[k].vertical_extent, 1e-5);
        assert_float_equal(camera->aspect, lens[k].aspect, 1e-5);
        if (lens[k].warning)
            assert_mentions(f->log, lens[k].warning);
        else
            assert_null(strstr(f->log, "degrees is used"));
        rsv_scene_destroy(scene);
    }
}

/// Blender gives parts of the longer side, `render` takes widths and heights.
static void shifts_of_films_are_named(void **state)
{
    static const struct {
        const char *aspect, *wanted;
    } cases[] = { { "2", "--shift-x 0.1 --shift-y -0.4 " },
        { "0.5", "--shift-x 0.2 --shift-y -0.2 " } };
    fixture *f = *state;
    for (size_t k = 0; k < 2; k++) {
        char library[768];
        snprintf(library, sizeof library,
            "<library_cameras><camera id=\"lens\"><optics><technique_common><perspective><xfov>40"
            "</xfov><aspect_ratio>%s</aspect_ratio></perspective></technique_common></optics><extra>"
            "<technique profile=\"blender\"><shiftx sid=\"shiftx\">0.1</shiftx><shifty>-0.2"
            "</shifty></technique></extra></camera></library_cameras>",
            cases[k].aspect);
        write_collada("any", 1, library, "<node><instance_camera url=\"#lens\"/></node>");
        rsv_scene_destroy(load(f, "a.dae"));
        assert_mentions(f->log, cases[k].wanted);
    }
}

static void fbx_tells_of_shifted_films(void **state)
{
    (void)state;
    static const char binary[] =
        "S\x0b\0\0\0FilmOffsetXS\x06\0\0\0NumberS\0\0\0\0S\x01\0\0\0AD\0\0\0\0\0\0\xe0?";
    static const char still[] =
        "S\x0b\0\0\0FilmOffsetYS\x06\0\0\0NumberS\0\0\0\0S\x01\0\0\0AD\0\0\0\0\0\0\0\0";
    static const char text[] = "P: \"FilmOffsetX\", \"Number\", \"\", \"A\",0.1\n";
    static const char text_still[] = "P: \"FilmOffsetX\", \"Number\", \"\", \"A\",0\n";
    assert_true(rsv_fbx_shifts_film(binary, sizeof binary - 1));
    assert_true(rsv_fbx_shifts_film(text, sizeof text - 1));
    assert_false(rsv_fbx_shifts_film(still, sizeof still - 1));
    assert_false(rsv_fbx_shifts_film(text_still, sizeof text_still - 1));
    for (size_t size = 0; size < sizeof binary - 1; size++) {
        char *cut = malloc(size + 1);
        memcpy(cut, binary, size);
        cut[size] = '\0';
        assert_false(rsv_fbx_shifts_film(cut, size));
        free(cut);
    }
}

/// Its exporter writes metals as <lambert> with a reflectivity.
static void metals_of_blender_in_collada_are_metals(void **state)
{
    static const char library[] =
        "<library_materials><material id=\"m\" name=\"paint\"><instance_effect url=\"#e\"/>"
        "</material></library_materials><library_effects><effect id=\"e\"><profile_COMMON>"
        "<technique sid=\"common\"><lambert><diffuse><color>0.9 0.7 0.3 1</color></diffuse>"
        "<reflectivity><float sid=\"specular\">0.75</float></reflectivity></lambert></technique>"
        "</profile_COMMON></effect></library_effects>";
    static const char *const tools[] = { "Blender 3.4.1", "any" };
    fixture *f = *state;
    for (int k = 0; k < 2; k++) {
        write_collada(tools[k], 1, library, "");
        rsv_scene *scene = load(f, "a.dae");
        const rsv_material *m = &rsv_scene_get_view(scene)->material[0];
        assert_string_equal(m->name, "paint");
        assert_float_equal(m->metallic, k ? 0 : 0.75, 1e-6);
        assert_float_equal(m->base_color.r, 0.9, 1e-6);
        assert_mentions(f->log, k ? "reflectivity" : "the roughness of the metal");
        rsv_scene_destroy(scene);
    }
}

/// The count of an array is the number of its elements, even if the file states another.
static void collada_arrays_hold_what_stands_in_them(void **state)
{
    fixture *f = *state;
    static const char *const said[] = { "count=\"9\"", "count=\"15\"", "count=\"4000000000\"",
        "count=\"-3\"", "count='twelve'", "count=\"\"", "", "count=\"12\"", "count = ' 12'" };
    for (size_t k = 0; k < sizeof said / sizeof *said; k++) {
        char library[2048];
        snprintf(library, sizeof library,
            "<library_geometries><geometry id=\"q\"><mesh><source id=\"qp\"><float_array "
            "id=\"recount\" %s>0 0 9 1 0 9 1 0 8 0 0 8</float_array><technique_common><accessor "
            "source=\"#recount\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param "
            "name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
            "</technique_common></source><vertices id=\"qv\"><input semantic=\"POSITION\" "
            "source=\"#qp\"/></vertices><triangles count=\"2\"><input semantic=\"VERTEX\" "
            "source=\"#qv\" offset=\"0\"/><p>0 1 2 0 2 3</p></triangles></mesh></geometry>"
            "</library_geometries>",
            said[k]);
        write_collada("any", 1, library, "<node id=\"b\"><instance_geometry url=\"#q\"/></node>");
        f->log[0] = 0;
        rsv_scene *scene = load(f, "a.dae");
        assert_float_equal(rsv_scene_get_view(scene)->bounds_max.z, 9, 1e-5);
        assert_int_equal(count_mentions(f->log, "and holds 12 values"), k < 7);
        rsv_scene_destroy(scene);
    }
}

/// Axes need not have length 1; about an axis of length 0 nothing turns.
static void collada_rotations_keep_sizes(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *rotation;
        double x, z;
        int warnings;
    } turn[] = { { "0 1 0 90", 0, -3, 0 }, { "0 7 0 90", 0, -3, 0 }, { "0 1e-9 0 90", 0, -3, 0 },
        { "0 -1e200 0 90", 0, 3, 0 }, { "0 0 0 90", 3, 0, 1 } };
    for (size_t k = 0; k < sizeof turn / sizeof *turn; k++) {
        char nodes[512];
        snprintf(nodes, sizeof nodes,
            "<node id=\"a\"><rotate sid=\"r\">%s</rotate><node id=\"b\"><translate>3 0 "
            "0</translate>"
            "<instance_light url=\"#lamp\"/></node></node>",
            turn[k].rotation);
        write_collada("any", 1,
            "<library_lights><light id=\"lamp\"><technique_common><point><color>1 1 1</color>"
            "</point></technique_common></light></library_lights>",
            nodes);
        f->log[0] = 0;
        rsv_scene *scene = load(f, "a.dae");
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        assert_float_equal(view->light[0].position.x, turn[k].x, 1e-5);
        assert_float_equal(view->light[0].position.z, turn[k].z, 1e-5);
        assert_int_equal(count_mentions(f->log, "about an axis of length 0"), turn[k].warnings);
        rsv_scene_destroy(scene);
    }
}

/// Elements with unknown names are reported once, wherever they are, without their content.
static void collada_names_elements_that_nobody_knows(void **state)
{
    fixture *f = *state;
    write_collada("any", 1,
        "<library_acme><acme_inner/></library_acme><library_materials><material "
        "id=\"m\"><acme_look>1"
        "</acme_look></material></library_materials><library_effects><effect id=\"e\"><profile_CG>"
        "<technique sid=\"a\"><pass/></technique></profile_CG></effect></library_effects>"
        "<library_geometries><geometry id=\"more\"><acme_shape/><mesh/><extra><more/></extra>"
        "</geometry></library_geometries>",
        "<node id=\"a\"><acme_thing/><acme_thing><acme_part/></acme_thing></node>");
    rsv_scene_destroy(load(f, "a.dae"));
    assert_mentions(f->log, "not used: element 'library_acme', element 'acme_look', profile_CG, "
                            "element 'acme_shape', element 'acme_thing'\n");
}

/// References that lead nowhere, and kinds of objects that are not read, are reported once each.
static void collada_names_what_is_not_there_or_not_used(void **state)
{
    fixture *f = *state;
    write_collada("any", 1,
        "<library_physics_scenes><physics_scene id=\"w\"/></library_physics_scenes>"
        "<library_geometries><geometry id=\"curve\"><spline/></geometry><geometry id=\"more\">"
        "<spline/></geometry></library_geometries>",
        "<node id=\"a\"><instance_geometry url=\"#nowhere\"/><instance_light url=\"#nowhere\"/>"
        "<instance_camera url=\"#lens\"/><instance_geometry url=\"#curve\"/><extra><technique "
        "profile=\"OTHER\"><x/></technique></extra></node>");
    rsv_scene_destroy(load(f, "a.dae"));
    assert_mentions(
        f->log, "not used: library_physics_scenes, spline, technique of profile 'OTHER'");
    assert_int_equal(count_mentions(f->log, "'nowhere', which it does not contain"), 1);
    assert_int_equal(count_mentions(f->log, "'lens', which it does not contain"), 1);
    assert_int_equal(count_mentions(f->log, "does not contain"), 2);
}

static void collada_opacity_and_shading_are_as_specified(void **state)
{
    static const struct {
        const char *technique;
        float opacity, specular, red;
    } paint[] = {
        { "<lambert><diffuse><color>.5 .4 .6 1</color></diffuse></lambert>", 1, 0, .5f },
        { "<constant><emission><color>1 1 1 1</color></emission></constant>", 1, 0, 0 },
        { "<lambert><diffuse><color>.5 .4 .6 1</color></diffuse><transparent "
          "opaque=\"A_ONE\"><color>"
          "1 1 1 .5</color></transparent><transparency><float>1</float></transparency></lambert>",
            .5f, 0, .5f },
        { "<lambert><diffuse><color>.5 .4 .6 1</color></diffuse><transparent opaque=\"RGB_ZERO\">"
          "<color>.25 .25 .25 1</color></transparent><transparency><float>1</float></transparency>"
          "</lambert>",
            .75f, 0, .5f },
        { "<phong><diffuse><color>.5 .4 .6 1</color></diffuse><specular><color>.5 .5 .5 1</color>"
          "</specular></phong>",
            1, .5f, .5f },
    };
    for (size_t k = 0; k < sizeof paint / sizeof *paint; k++) {
        char library[1024];
        snprintf(library, sizeof library,
            "<library_materials><material id=\"m\" name=\"paint\"><instance_effect url=\"#e\"/>"
            "</material></library_materials><library_effects><effect id=\"e\"><profile_COMMON>"
            "<technique sid=\"c\">%s</technique></profile_COMMON></effect></library_effects>",
            paint[k].technique);
        write_collada("any", 1, library, "");
        rsv_scene *scene = load(*state, "a.dae");
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        const rsv_material *m = &view->material[0];
        assert_string_equal(m->name, "paint");
        if (fabsf(m->opacity - paint[k].opacity) > 1e-4f)
            fail_msg("%zu: opacity %g", k, (double)m->opacity);
        assert_float_equal(m->specular, paint[k].specular, 1e-4);
        assert_float_equal(m->base_color.r, paint[k].red, 1e-4);
        rsv_scene_destroy(scene);
    }
}

/// Whose axis turns towards the direction of movement, by the angle.
static void collada_skews_move_along_one_direction(void **state)
{
    static const struct {
        const char *skew;
        rsv_vec3 moved; // of the corners (0, 0, 9) and (9, 0, 0)
        rsv_vec3 other;
    } cases[] = {
        { "45 0 0 1 1 0 0", { 9, 0, 9 }, { 9, 0, 0 } },
        { "-45 0 0 2 0 3 0", { 0, -9, 9 }, { 9, 0, 0 } },
        { "26.565051177 1 0 0 0 0 1", { 0, 0, 9 }, { 9, 0, 4.5f } },
        { "45 1 0 1 0 0 1", { 0, 0, 9 }, { 9, 0, 0 } }, // no angle is left: not a skew
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char nodes[256];
        snprintf(nodes, sizeof nodes,
            "<node id=\"s\"><skew sid=\"skew\"> %s </skew><instance_geometry url=\"#g\"/></node>",
            cases[k].skew);
        write_collada("any", 1, "", nodes);
        rsv_scene *scene = load(*state, "a.dae");
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        const rsv_vec3 *p = view->position;
        const uint32_t *corner = view->triangle[1];
        if (v3_length(v3_sub(p[corner[1]], cases[k].moved)) > 1e-5f ||
            v3_length(v3_sub(p[corner[2]], cases[k].other)) > 1e-5f)
            fail_msg("%s: (%g %g %g), (%g %g %g)", cases[k].skew, (double)p[corner[1]].x,
                (double)p[corner[1]].y, (double)p[corner[1]].z, (double)p[corner[2]].x,
                (double)p[corner[2]].y, (double)p[corner[2]].z);
        rsv_scene_destroy(scene);
    }
}

// ---- FBX ------------------------------------------------------------------------------------------

/// A lamp 2 m above the floor that shines downwards. @param properties of the light
static rsv_scene *load_fbx_light(
    fixture *f, const char *creator, double metre, const char *properties)
{
    FILE *file = fopen(path_in(&files, "a.fbx"), "w");
    assert_non_null(file);
    fprintf(file,
        "; FBX 7.3.0 project file\n"
        "FBXHeaderExtension: {\n FBXHeaderVersion: 1003\n FBXVersion: 7300\n Creator: \"%s\"\n}\n"
        "GlobalSettings: {\n Version: 1000\n Properties70: {\n"
        "  P: \"UpAxis\", \"int\", \"Integer\", \"\",1\n"
        "  P: \"UpAxisSign\", \"int\", \"Integer\", \"\",1\n"
        "  P: \"FrontAxis\", \"int\", \"Integer\", \"\",2\n"
        "  P: \"FrontAxisSign\", \"int\", \"Integer\", \"\",1\n"
        "  P: \"CoordAxis\", \"int\", \"Integer\", \"\",0\n"
        "  P: \"CoordAxisSign\", \"int\", \"Integer\", \"\",1\n"
        "  P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",%.9g\n }\n}\n"
        "Objects: {\n Geometry: 1, \"Geometry::floor\", \"Mesh\" {\n"
        "  Vertices: *9 {\n   a: 0,0,0,0,0,9,9,0,0\n  }\n"
        "  PolygonVertexIndex: *3 {\n   a: 0,1,-3\n  }\n  GeometryVersion: 124\n }\n"
        " NodeAttribute: 10, \"NodeAttribute::lamp\", \"Light\" {\n  TypeFlags: \"Light\"\n"
        "  GeometryVersion: 124\n  Properties70: {\n%s  }\n }\n"
        " Model: 2, \"Model::floor\", \"Mesh\" {\n  Version: 232\n }\n"
        " Model: 11, \"Model::lamp\", \"Light\" {\n  Version: 232\n  Properties70: {\n"
        "   P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",0,%.9g,0\n"
        "   P: \"Lcl Scaling\", \"Lcl Scaling\", \"\", \"A\",100,100,100\n  }\n }\n"
        "}\nConnections: {\n C: \"OO\",2,0\n C: \"OO\",1,2\n C: \"OO\",11,0\n C: \"OO\",10,11\n}\n",
        creator, 100 * metre, properties, 2 / metre);
    fclose(file);
    return load(f, "a.fbx");
}

static void fbx_lights_are_as_bright_in_any_unit(void **state)
{
    fixture *f = *state;
    enum { NONE, START, NO_START };
    static const struct {
        const char *creator;
        int type; // 0 point, 1 sun, 2 spot, 3 area
        double intensity;
        int decay;
        double start;
        float expected;
    } lamp[] = {
        { "any", 0, 1000, START, 1.4142135623731, 2.5f },
        { "any", 2, 1000, START, 1.4142135623731, 2.5f },
        { "any", 3, 1000, START, 1.4142135623731, 2.5f },
        { "any", 1, 250, START, 1, 2.5f },
        { "any", 0, 1000, NONE, 0, 2.5f },
        { "any", 2, 1000, NONE, 0, 2.5f },
        // what Blender writes: watts, and a decay that starts at 25 m
        { "Blender (stable FBX IO) - 2.82 - 4.14.14", 0, 12566.371, START, 25, 2.5f },
        { "Blender (stable FBX IO) - 3.6.2 - 5.3.0", 2, 12566.371, START, 25, 2.5f },
        { "Blender (stable FBX IO) - 4.2.1 - 5.12.5", 3, 3141.5927, START, 25, 2.5f },
        { "Blender (stable FBX IO) - 4.2.1 - 5.12.5", 1, 250, START, 25, 2.5f },
    };
    for (size_t k = 0; k < sizeof lamp / sizeof *lamp; k++) {
        for (size_t n = 0; n < sizeof metres / sizeof *metres; n++) {
            char properties[1024], decay[256] = "";
            if (lamp[k].decay == START)
                snprintf(decay, sizeof decay,
                    "   P: \"DecayType\", \"enum\", \"\", \"\",2\n"
                    "   P: \"DecayStart\", \"double\", \"Number\", \"\",%.9g\n",
                    lamp[k].start / metres[n]);
            snprintf(properties, sizeof properties,
                "   P: \"LightType\", \"enum\", \"\", \"\",%d\n"
                "   P: \"Color\", \"Color\", \"\", \"A\",1,1,1\n"
                "   P: \"Intensity\", \"Number\", \"\", \"A\",%.9g\n"
                "   P: \"InnerAngle\", \"Number\", \"\", \"A\",30\n"
                "   P: \"OuterAngle\", \"Number\", \"\", \"A\",60\n%s",
                lamp[k].type, lamp[k].intensity, decay);
            rsv_scene *scene = load_fbx_light(f, lamp[k].creator, metres[n], properties);
            const rsv_scene_view *view = rsv_scene_get_view(scene);
            assert_int_equal(view->light_count, 1);
            assert_about(below(view), lamp[k].expected);
            if (lamp[k].type == 2) assert_about(view->light[0].outer_cone_angle, 0.52359878f);
            if (lamp[k].type == 3) assert_mentions(f->log, "area or volume light");
            rsv_scene_destroy(scene);
        }
    }
}

/// Strength in units of the file, with a decay from the light itself, as Maya writes it.
static void fbx_decay_may_start_at_the_light(void **state)
{
    for (size_t n = 0; n < sizeof metres / sizeof *metres; n++) {
        char properties[512];
        snprintf(properties, sizeof properties,
            "   P: \"Intensity\", \"Number\", \"\", \"A\",%.9g\n"
            "   P: \"DecayType\", \"enum\", \"\", \"\",2\n"
            "   P: \"DecayStart\", \"Number\", \"\", \"A\",0\n",
            1000 / (metres[n] * metres[n]));
        rsv_scene *scene = load_fbx_light(*state, "FBX SDK/FBX Plugins", metres[n], properties);
        assert_about(below(rsv_scene_get_view(scene)), 2.5f);
        rsv_scene_destroy(scene);
    }
}

/// A lamp that is not shown does not shine.
static void fbx_hides_what_is_not_to_be_shown(void **state)
{
    fixture *f = *state;
    for (int shown = 0; shown < 3; shown++) { // 1: but for its Visibility
        char scaling[192];
        rsv_scene *scene =
            load_fbx_light(f, "any", 1, "   P: \"Intensity\", \"Number\", \"\", \"A\",100\n");
        rsv_scene_destroy(scene);
        size_t bytes;
        char *text = (char *)read_bytes(path_in(&files, "a.fbx"), &bytes);
        snprintf(scaling, sizeof scaling, "   P: \"Show\", \"bool\", \"\", \"\",%d\n%s", shown > 0,
            shown == 1 ? "   P: \"Visibility\", \"Visibility\", \"\", \"A\",0\n" : "");
        text[bytes] = '\0';
        char *at = strstr(text, "   P: \"Lcl Scaling\"");
        assert_non_null(at);
        FILE *file = fopen(path_in(&files, "a.fbx"), "w");
        fprintf(file, "%.*s%s%s", (int)(at - text), text, scaling, at);
        fclose(file);
        free(text);
        scene = load(f, "a.fbx");
        assert_int_equal(rsv_scene_get_view(scene)->light_count, shown == 2);
        if (shown < 2)
            assert_mentions(f->log, "1 node is (first: 'lamp') hidden by Show or Visibility");
        memset(f->log, 0, sizeof f->log);
        rsv_scene_destroy(scene);
    }
}

/// Binary files state it by lengths, which do not change.
static void fbx_tells_of_visibility_in_binary_files(void **state)
{
    (void)state;
    static const char start[] = "S\x0a\0\0\0VisibilityS\x0a\0\0\0VisibilityS\0\0\0\0S\x01\0\0\0AD";
    static const char wanted[] =
        "S\x0a\0\0\0VisibilityS\x06\0\0\0doubleS\x04\0\0\0    S\x01\0\0\0AD";
    FILE *file = fopen(path_in(&files, "b.fbx"), "w+b");
    assert_non_null(file);
    fwrite(start, 1, sizeof start - 1, file);
    fwrite(start, 1, 30, file); // cut off
    rewind(file);
    size_t size;
    char *cleaned = rsv_fbx_clean(file, &size);
    fclose(file);
    assert_non_null(cleaned);
    assert_int_equal(size, sizeof start - 1 + 30);
    assert_memory_equal(cleaned, wanted, sizeof wanted - 1);
    assert_memory_equal(cleaned + sizeof start - 1, start, 30);
    free(cleaned);
}

/// The importer makes up one degree where a camera says nothing.
static void fbx_cameras_without_a_field_of_view_see_something(void **state)
{
    fixture *f = *state;
    for (int given = 0; given < 2; given++) {
        rsv_scene_destroy(load_fbx_light(f, "any", 1, ""));
        size_t bytes;
        char *text = (char *)read_bytes(path_in(&files, "a.fbx"), &bytes);
        text[bytes] = '\0';
        char *connections = strstr(text, "}\nConnections: {\n");
        assert_non_null(connections);
        FILE *file = fopen(path_in(&files, "b.fbx"), "w");
        fprintf(file,
            "%.*s NodeAttribute: 20, \"NodeAttribute::cam\", \"Camera\" {\n  TypeFlags: "
            "\"Camera\"\n"
            "  Properties70: {\n%s  }\n }\n Model: 21, \"Model::cam\", \"Camera\" {\n  Version: "
            "232\n }\n"
            "}\nConnections: {\n C: \"OO\",21,0\n C: \"OO\",20,21\n%s",
            (int)(connections - text), text,
            given ? "   P: \"FieldOfView\", \"FieldOfView\", \"\", \"A\",60\n" : "",
            connections + strlen("}\nConnections: {\n"));
        fclose(file);
        free(text);
        rsv_scene *scene = load(f, "b.fbx");
        assert_int_equal(rsv_scene_get_view(scene)->camera_count, 1);
        assert_about(
            rsv_scene_get_view(scene)->camera[0].vertical_fov, (given ? 60 : 45) * 0.0174532925f);
        assert_int_equal(count_mentions(f->log, "45 degrees is used"), given ? 0 : 1);
        rsv_scene_destroy(scene);
    }
}

/// A Phong material stays one, whatever roughness the importer derives from its shininess. Blender's Phong materials
/// represent a Principled BSDF.
static void fbx_of_blender_is_read_as_blender_means_it(void **state)
{
    static const char layer[] = "  LayerElementMaterial: 0 {\n"
                                "   Version: 101\n"
                                "   Name: \"\"\n"
                                "   MappingInformationType: \"AllSame\"\n"
                                "   ReferenceInformationType: \"IndexToDirect\"\n"
                                "   Materials: *1 {\n"
                                "    a: 0\n"
                                "   }\n"
                                "  }\n"
                                "  Layer: 0 {\n"
                                "   Version: 100\n"
                                "   LayerElement:  {\n"
                                "    Type: \"LayerElementMaterial\"\n"
                                "    TypedIndex: 0\n"
                                "   }\n"
                                "  }\n";
    static const char paint[] = " Material: 5, \"Material::paint\", \"\" {\n"
                                "  Version: 102\n"
                                "  ShadingModel: \"phong\"\n"
                                "  MultiLayer: 0\n"
                                "  Properties70: {\n"
                                "   P: \"DiffuseColor\", \"Color\", \"\", \"A\",0.5,0.25,0.125\n"
                                "   P: \"DiffuseFactor\", \"Number\", \"\", \"A\",1\n"
                                "   P: \"SpecularColor\", \"Color\", \"\", \"A\",0.5,0.5,0.5\n"
                                "   P: \"SpecularFactor\", \"Number\", \"\", \"A\",1\n"
                                "   P: \"ShininessExponent\", \"Number\", \"\", \"A\",20\n"
                                "   P: \"ReflectionFactor\", \"Number\", \"\", \"A\",0.5\n"
                                "  }\n"
                                " }\n";
    static const char *const creators[] = { "any", "Blender (stable FBX IO) - 3.4.1 - 4.37.1" };
    fixture *f = *state;
    for (int k = 0; k < 2; k++) {
        size_t bytes;
        rsv_scene_destroy(load_fbx_light(f, creators[k], 1, ""));
        char *text = (char *)read_bytes(path_in(&files, "a.fbx"), &bytes);
        text[bytes] = '\0';
        char *lamp = strstr(text, " }\n NodeAttribute: 10"),
             *end = strstr(text, "}\nConnections: {\n");
        assert_true(lamp && end);
        FILE *file = fopen(path_in(&files, "b.fbx"), "w");
        fprintf(file, "%.*s%s%.*s%s}\nConnections: {\n C: \"OO\",5,2\n%s", (int)(lamp - text), text,
            layer, (int)(end - lamp), lamp, paint, end + strlen("}\nConnections: {\n"));
        fclose(file);
        free(text);
        rsv_scene *scene = load(f, "b.fbx");
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        const rsv_material *m = &view->material[view->triangle_material[0]];
        assert_string_equal(m->name, "paint");
        assert_float_equal(m->roughness, k ? 1 - sqrt(0.2) : pow(2 / 22.0, 0.25), 1e-5);
        assert_float_equal(m->metallic, k ? 0.5 : 0, 1e-6);
        assert_float_equal(m->specular, k ? 1 : 0.5, 1e-6);
        assert_float_equal(m->ior, k ? (1 + sqrt(0.08)) / (1 - sqrt(0.08)) : 1.5, 1e-5);
        rsv_scene_destroy(scene);
    }
}

int main(void)
{
#define CASE(name) cmocka_unit_test_setup_teardown(name, enter, leave)
    const struct CMUnitTest tests[] = {
        CASE(collada_lights_are_as_bright_in_any_unit),
        CASE(collada_strengths_are_in_units_of_the_file),
        CASE(watts_of_blender_are_spread_over_the_sphere),
        CASE(collada_spots_end_where_they_say),
        CASE(every_light_of_a_node_shines_and_ambient_ones_are_named),
        CASE(collada_cameras_see_what_they_say),
        CASE(fbx_of_blender_is_read_as_blender_means_it),
        CASE(shifts_of_films_are_named),
        CASE(fbx_tells_of_shifted_films),
        CASE(metals_of_blender_in_collada_are_metals),
        CASE(collada_names_what_is_not_there_or_not_used),
        CASE(collada_names_elements_that_nobody_knows),
        CASE(collada_arrays_hold_what_stands_in_them),
        CASE(collada_rotations_keep_sizes),
        CASE(collada_opacity_and_shading_are_as_specified),
        CASE(collada_skews_move_along_one_direction),
        CASE(fbx_hides_what_is_not_to_be_shown),
        CASE(collada_units_that_are_no_numbers_are_named),
        CASE(fbx_tells_of_visibility_in_binary_files),
        CASE(fbx_lights_are_as_bright_in_any_unit),
        CASE(fbx_decay_may_start_at_the_light),
        CASE(fbx_cameras_without_a_field_of_view_see_something),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
