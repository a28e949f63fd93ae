/// OBJ, PLY, FBX, COLLADA and STL files are read as intended, or rejected with one line of error.
#include "resolvent/io.h"
#include "scene/smooth_normals.h"
#include "unit/scene_fixture.h"

#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/rsv-assimp-XXXXXX";

static int enter_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state)
{
    (void)state;
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return chdir("/") == 0 ? system(command) : -1;
}

static void write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static rsv_scene *load(fixture *f, const char *name)
{
    rsv_scene *scene = NULL;
    rsv_status status = rsv_scene_load(f->context, name, &scene);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return scene;
}

static void assert_refused(fixture *f, const char *name, const char *reason)
{
    rsv_scene *scene = NULL;
    if (rsv_scene_load(f->context, name, &scene) == RSV_OK) fail_msg("%s was accepted", name);
    assert_null(scene);
    assert_mentions(rsv_last_error(), name);
    assert_mentions(rsv_last_error(), reason);
    assert_null(strchr(rsv_last_error(), '\n'));
}

static const rsv_material *material_of(const rsv_scene_view *view, const char *name)
{
    for (size_t i = 0; i < view->material_count; i++)
        if (strcmp(view->material[i].name, name) == 0) return &view->material[i];
    fail_msg("there is no material '%s'", name);
    return NULL;
}

#define assert_near(a, b) assert_float_equal(a, b, 1e-5f)

// ---- materials of .mtl ----------------------------------------------------------------------------

#define QUAD "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"

static void mtl_phong_becomes_lambert_plastic_mirror_and_glass(void **state)
{
    write_file("m.mtl",
        "newmtl chalk\nKd .5 .4 .3\nKs 0 0 0\nKe 1 2 3\nillum 2\n"
        "newmtl plastic\nKd .5 .4 .3\nKs .5 .25 .25\nNs 30\nNi 1.4\nillum 2\n"
        "newmtl mirror\nKd 0 0 0\nKs .9 .8 .7\nNs 1000\nillum 5\n"
        "newmtl glass\nKd 0 0 0\nKs .3 .3 .3\nTf .1 .1 .05\nNs 200\nNi 1.6\nillum 7\n"
        "newmtl veil\nKd 1 1 1\nKs 0 0 0\nd .25\nillum 2\n");
    write_file("m.obj", "mtllib m.mtl\nusemtl chalk\n" QUAD "usemtl plastic\nf 1 2 3\n"
                        "usemtl mirror\nf 1 2 3\nusemtl glass\nf 1 2 3\nusemtl veil\nf 1 2 3\n");
    rsv_scene *scene = load(*state, "m.obj");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    const rsv_material *chalk = material_of(view, "chalk"), *plastic = material_of(view, "plastic"),
                       *mirror = material_of(view, "mirror"), *glass = material_of(view, "glass"),
                       *veil = material_of(view, "veil");
    assert_near(chalk->base_color.g, 0.4f);
    assert_near(chalk->emission.b, 3);
    assert_near(chalk->specular, 0);
    assert_false(chalk->double_sided);
    assert_near(plastic->specular, 0.5f);
    assert_near(plastic->specular_color.g, 0.5f);
    assert_near(plastic->ior, 1.4f);
    assert_near(plastic->roughness, 0.5f); // (2 / 32)^(1/4)
    assert_true(plastic->double_sided);
    assert_near(mirror->metallic, 1);
    assert_near(mirror->roughness, 0);
    assert_near(mirror->base_color.r, 0.9f);
    assert_near(glass->transmission, 1);
    assert_near(glass->roughness, 0);
    assert_near(glass->ior, 1.6f);
    assert_near(glass->base_color.r, 1);
    assert_near(glass->base_color.b, 0.5f);
    assert_true(glass->thickness > 0);
    assert_near(veil->opacity, 0.25f);
    rsv_scene_destroy(scene);
}

static void missing_and_endless_libraries_are_named(void **state)
{
    fixture *f = *state;
    assert_int_equal(mkfifo("pipe.mtl", 0600), 0);
    write_file("a.obj", "mtllib nowhere.mtl\nusemtl x\n" QUAD);
    write_file("b.obj", "mtllib pipe.mtl\nusemtl x\n" QUAD);
    rsv_scene_destroy(load(f, "a.obj"));
    assert_mentions(f->log, "nowhere.mtl");
    assert_int_equal(count_mentions(f->log, "cannot be read"), 1);
    rsv_scene_destroy(load(f, "b.obj"));
    assert_mentions(f->log, "pipe.mtl");
}

static void materials_that_do_not_exist_are_named_once(void **state)
{
    fixture *f = *state;
    write_file("some.mtl", "newmtl \"known to all\" # here\nKd 1 0 0\n");
    write_file("some.obj", "mtllib some.mtl\nusemtl lost\n" QUAD "usemtl known to all\nf 1 2 3\n"
                           "USEMTL lost\nf 1 2 3\nusemtl gone\nf 1 2 3\nusemtl lost\nf 1 2 3\n");
    rsv_scene_destroy(load(f, "some.obj"));
    assert_mentions(f->log, "none of its libraries defines: 'lost', 'gone'; they are grey");
    assert_int_equal(count_mentions(f->log, "none of its libraries"), 1);
    f->log[0] = 0;
    write_file("bare.obj", "usemtl lost\n" QUAD);
    rsv_scene_destroy(load(f, "bare.obj"));
    assert_int_equal(count_mentions(f->log, "'lost'"), 1);
}

static void textures_are_warned_of(void **state)
{
    fixture *f = *state;
    write_file("t.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n");
    write_file("t.obj", "mtllib t.mtl\nusemtl skin\n" QUAD);
    rsv_scene_destroy(load(f, "t.obj"));
    assert_mentions(f->log, "'skin'");
}

/// One warning for each kind of feature, which names it.
static void what_is_not_used_is_named_once(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *name, *text, *warning;
    } odd[] = {
        { "curve.obj", "vp 0 0\ncstype bezier\n" QUAD "lod 1\nlod 2\n",
            "'vp' (line 1), 'cstype' (line 2), 'lod' (line 8)" },
        { "paint.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nf 1 2 3\n",
            "colours of its 3 vertices" },
        { "wires.obj", QUAD "l 1 2 3\np 1\n", "not used: 3 lines and points" },
        { "odd.obj", "mtllib odd.mtl\nusemtl x\n" QUAD, "'sharpness' (line 3)" },
        { "hair.obj", "mtllib hair.mtl\nusemtl x\n" QUAD, "'aniso' (line 4)" },
        { "scan.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty float quality\nelement face 1\n"
            "property list uchar int vertex_indices\nproperty int flags\nelement edge 1\n"
            "property int a\nproperty int b\nend_header\n0 0 0 9 1\n1 0 0 9 1\n0 1 0 9 1\n"
            "3 0 1 2 7\n0 1\n",
            "not used: red, quality, flags, edge" },
    };
    write_file("odd.mtl", "newmtl x\nKd 1 1 1\nsharpness 60\nsharpness 50\n");
    write_file("hair.mtl", "newmtl x\nKd 1 1 1\nPr 0.5\naniso 0.7\n");
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        f->log[0] = 0;
        write_file(odd[i].name, odd[i].text);
        rsv_scene_destroy(load(f, odd[i].name));
        assert_mentions(f->log, odd[i].warning);
        assert_int_equal(count_mentions(f->log, "not used"), 1);
    }
    f->log[0] = 0;
    write_file("plain.mtl", "newmtl x\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nNs 10\nd 1\nillum 2\n");
    write_file("plain.obj", "mtllib plain.mtl\no a\ng b\ns 1\nusemtl x\n" QUAD);
    rsv_scene_destroy(load(f, "plain.obj"));
    assert_null(strstr(f->log, "not used"));
}

/// Messages say what is wrong, where, and what to do, without Assimp's wording.
static void importers_do_not_speak_for_themselves(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *name, *text, *reason;
    } broken[] = {
        { "far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "line 4: a face refers to vertex 9" },
        { "back.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf -9 -2 -1\n", "line 5" },
        { "word.obj", "v 0 0 0\nv one 0 0\nv 0 1 0\nf 1 2 3\n", "line 2: a vertex needs three" },
        { "loose.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangle" },
        { "other.dae", "<?xml version=\"1.0\"?><svg></svg>", "holds no scene" },
        { "text.dae", "this is no XML\nthis is no XML\n", "not well-formed XML" },
        { "text.fbx", "this is no FBX\nthis is no FBX\n", "near line 1" },
        { "old.fbx",
            "; FBX 6.1.0 project file\nFBXHeaderExtension: {\n FBXHeaderVersion: 1003\n "
            "FBXVersion: "
            "6100\n}\nObjects: {\n}\n",
            "older than FBX 2011" },
    };
    static const char *const theirs[] = { "OBJ:", "FBX-", "Collada", "TOK_", "Validation", "aiMesh",
        "aiScene", "std::", "Assimp", "Unable", "Invalid" };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        write_file(broken[i].name, broken[i].text);
        assert_refused(f, broken[i].name, broken[i].reason);
        for (size_t k = 0; k < sizeof theirs / sizeof *theirs; k++)
            assert_null(strstr(rsv_last_error(), theirs[k]));
    }
}

/// However a text editor leaves it.
static void line_ends_blanks_and_marks_do_not_matter(void **state)
{
    fixture *f = *state;
    static const char *const texts[] = {
        "mtllib my lib.mtl\r\nv 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nusemtl x y\r\nf 1 2 3\r\n",
        "mtllib my lib.mtl\rv 0 0 0\rv 1 0 0\rv 1 1 0\rusemtl x y\rf 1 2 3",
        "\xef\xbb\xbfv 0 0 0\nmtllib my lib.mtl  \n\tv 1 0 0\n  v 1 1 0\nusemtl x y \t\nf 1 2 3",
        "mtllib my lib.mtl\nv 0 0 0 # a\nv 1 0 \\\n0\nv 1 1 0\nusemtl x y\nf 1 \\\n2 3\n",
        "mtllib my lib.mtl\nlod 1 \\\n2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl x y\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nmtllib my lib.mtl\nusemtl x y\nf -3 -2 -1\n",
    };
    write_file("my lib.mtl", "\xef\xbb\xbfnewmtl x y\r\n\tKd .25 .5 .75 \r\n");
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        f->log[0] = 0;
        write_file("ends.obj", texts[i]);
        rsv_scene *scene = load(f, "ends.obj");
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        assert_int_equal(view->triangle_count, 1);
        assert_near(view->bounds_max.y, 1);
        assert_near(material_of(view, "x y")->base_color.g, 0.5f);
        assert_null(strstr(f->log, "cannot be read"));
        rsv_scene_destroy(scene);
    }
}

/// What programs write in more than one way means the same.
static void spellings_of_mtl_and_obj_are_understood(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *library, *object;
        float red, green, opacity;
    } spelt[] = {
        { "newmtl m\nKd 0.5\n", "usemtl m\n", .5f, .5f, 1 },
        { "NewMtl m\nkd .5 .25 .125\n", "UseMtl m\n", .5f, .25f, 1 },
        { "newmtl m # the paint\nKd .5 .25 .125 # as measured\n", "usemtl m # here\n", .5f, .25f,
            1 },
        { "newmtl \"m\"\nKd 0.5 0.25 0.125\nd -halo 0.75\n", "usemtl \"m\"\n", .5f, .25f, .75f },
        { "newmtl m\nKd 0.5 0.25 0.125\nTr 0.25\n", "usemtl m\n", .5f, .25f, .75f },
        { "newmtl m\nKd 0.5 0.25 0.125\nKs spectral a.rfl\n", "usemtl m\n", .5f, .25f, 1 },
    };
    static const char *const libraries[] = { "mtllib spelt.mtl\n", "mtllib \"spelt.mtl\"\n",
        "mtllib .\\spelt.mtl\n", "mtllib plain.mtl spelt.mtl\n", "MTLLIB spelt.mtl\n" };
    write_file("plain.mtl", "newmtl x\nKd 1 1 1\n");
    for (size_t i = 0; i < sizeof spelt / sizeof *spelt; i++) {
        for (size_t k = 0; k < sizeof libraries / sizeof *libraries; k++) {
            char text[512];
            snprintf(text, sizeof text, "%sV .0 0 0\nv 2 0 0\nv 2 .3e1 0\nv 0 3 0\n%sF 1 2 3 4\n",
                libraries[k], spelt[i].object);
            f->log[0] = 0;
            write_file("spelt.mtl", spelt[i].library);
            write_file("spelt.obj", text);
            rsv_scene *scene = load(f, "spelt.obj");
            const rsv_material *m = material_of(rsv_scene_get_view(scene), "m");
            assert_near(m->base_color.r, spelt[i].red);
            assert_near(m->base_color.g, spelt[i].green);
            assert_near(m->opacity, spelt[i].opacity);
            assert_near(rsv_scene_get_view(scene)->bounds_max.y, 3);
            assert_null(strstr(f->log, "cannot be read"));
            rsv_scene_destroy(scene);
        }
    }
}

/// Faces of old versions, flat faces in a file without normals, and text that is not OBJ.
static void oddities_of_obj_are_read_or_named(void **state)
{
    fixture *f = *state;
    write_file("old.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nfo 1 2 3\nf 1 1 2\n");
    f->log[0] = 0;
    rsv_scene *scene = load(f, "old.obj");
    assert_int_equal(rsv_scene_get_view(scene)->triangle_count, 1);
    assert_mentions(f->log, "1 degenerate");
    assert_null(strstr(f->log, "normals"));
    rsv_scene_destroy(scene);
    static const char wide[] = "\xff\xfev\0 \0"
                               "0\0\n";
    FILE *file = fopen("wide.obj", "wb");
    assert_non_null(file);
    fwrite(wide, 1, sizeof wide, file);
    fclose(file);
    assert_refused(f, "wide.obj", "is UTF-16");
}

// ---- units and axes -------------------------------------------------------------------------------

static void polygons_without_units_follow_the_description(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = NULL;
    rsv_load_desc desc = rsv_default_load_desc();
    desc.metres_per_unit = 0.001f;
    desc.up = RSV_AXIS_Z;
    write_file("u.obj", "v 0 0 0\nv 1000 0 0\nv 0 2000 0\nv 0 0 3000\nf 1 2 3\nf 1 3 4\n");
    assert_int_equal(rsv_scene_load_with(f->context, "u.obj", &desc, &scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_near(view->bounds_max.x, 1);
    assert_near(view->bounds_max.y, 3);
    assert_near(view->bounds_min.z, -2);
    rsv_scene_destroy(scene);
    desc.metres_per_unit = 0;
    assert_int_equal(rsv_scene_load_with(f->context, "u.obj", &desc, &scene), RSV_ERROR_ARGUMENT);
}

static const char collada[] =
    "<?xml version=\"1.0\"?>\n"
    "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n"
    "<asset><unit name=\"centimeter\" meter=\"0.01\"/><up_axis>Z_UP</up_axis></asset>\n"
    "<library_cameras><camera id=\"lens\" name=\"lens\"><optics><technique_common><perspective>\n"
    "<xfov>90</xfov><aspect_ratio>2</aspect_ratio><znear>1</znear><zfar>10</zfar>\n"
    "</perspective></technique_common></optics></camera></library_cameras>\n"
    "<library_lights><light id=\"lamp\" name=\"lamp\"><technique_common><point>\n"
    "<color>8 4 2</color><quadratic_attenuation>2</quadratic_attenuation>\n"
    "</point></technique_common></light></library_lights>\n"
    "<library_geometries><geometry id=\"g\" name=\"g\"><mesh>\n"
    "<source id=\"p\"><float_array id=\"pa\" count=\"9\">0 0 0 100 0 0 0 0 200</float_array>\n"
    "<technique_common><accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" "
    "type=\"float\"/>"
    "<param name=\"Y\" type=\"float\"/><param name=\"Z\" "
    "type=\"float\"/></accessor></technique_common>"
    "</source>\n"
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\n"
    "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 "
    "2</p></triangles>\n"
    "</mesh></geometry></library_geometries>\n"
    "<library_visual_scenes><visual_scene id=\"s\">\n"
    "<node id=\"n\" name=\"n\"><translate>0 0 50</translate><instance_geometry "
    "url=\"#g\"/></node>\n"
    "<node id=\"c\" name=\"c\"><translate>0 -300 0</translate><rotate>1 0 0 90</rotate>"
    "<instance_camera url=\"#lens\"/></node>\n"
    "<node id=\"l\" name=\"l\"><translate>0 0 400</translate><instance_light "
    "url=\"#lamp\"/></node>\n"
    "</visual_scene></library_visual_scenes>\n"
    "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>\n";

static void collada_units_axes_cameras_and_lights_are_kept(void **state)
{
    write_file("c.dae", collada);
    rsv_scene *scene = load(*state, "c.dae");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_near(view->bounds_max.x, 1);
    assert_near(view->bounds_min.y, 0.5f);
    assert_near(view->bounds_max.y, 2.5f);
    assert_int_equal(view->camera_count, 1);
    const rsv_camera *camera = &view->camera[0];
    assert_near(camera->position.z, 3);
    assert_near(camera->forward.z, -1);
    assert_near(camera->up.y, 1);
    assert_near(camera->aspect, 2);
    assert_near(camera->vertical_fov, 2 * atanf(0.5f));
    assert_int_equal(view->light_count, 1);
    assert_near(view->light[0].position.y, 4);
    assert_float_equal(view->light[0].intensity.r, 4e-4, 1e-8); // W/sr: 8 / 2 cm2
    rsv_scene_destroy(scene);
}

static const char fbx[] =
    "; FBX 7.3.0 project file\n"
    "FBXHeaderExtension: {\n FBXHeaderVersion: 1003\n FBXVersion: 7300\n}\n"
    "GlobalSettings: {\n Version: 1000\n Properties70: {\n"
    "  P: \"UpAxis\", \"int\", \"Integer\", \"\",2\n  P: \"UpAxisSign\", \"int\", \"Integer\", "
    "\"\",1\n"
    "  P: \"FrontAxis\", \"int\", \"Integer\", \"\",1\n  P: \"FrontAxisSign\", \"int\", "
    "\"Integer\", \"\",-1\n"
    "  P: \"CoordAxis\", \"int\", \"Integer\", \"\",0\n  P: \"CoordAxisSign\", \"int\", "
    "\"Integer\", \"\",1\n"
    "  P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",2.5\n }\n}\n"
    "Objects: {\n"
    " Geometry: 1, \"Geometry::shard\", \"Mesh\" {\n"
    "  Vertices: *9 {\n   a: 0,0,0,40,0,0,0,0,80\n  }\n"
    "  PolygonVertexIndex: *3 {\n   a: 0,1,-3\n  }\n  GeometryVersion: 124\n"
    "  LayerElementMaterial: 0 {\n   Version: 101\n   Name: \"\"\n"
    "   MappingInformationType: \"AllSame\"\n   ReferenceInformationType: \"IndexToDirect\"\n"
    "   Materials: *1 {\n    a: 0\n   }\n  }\n"
    "  Layer: 0 {\n   Version: 100\n   LayerElement: {\n    Type: \"LayerElementMaterial\"\n"
    "    TypedIndex: 0\n   }\n  }\n }\n"
    " Model: 2, \"Model::shard\", \"Mesh\" {\n  Version: 232\n  Properties70: {\n"
    "   P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",0,40,0\n  }\n }\n"
    " Material: 3, \"Material::clay\", \"\" {\n  Version: 102\n  ShadingModel: \"lambert\"\n"
    "  Properties70: {\n   P: \"DiffuseColor\", \"Color\", \"\", \"A\",0.5,0.25,0.125\n  }\n }\n"
    "}\n"
    "Connections: {\n C: \"OO\",2,0\n C: \"OO\",1,2\n C: \"OO\",3,2\n}\n";

static void fbx_units_and_axes_become_metres_and_y_up(void **state)
{
    write_file("x.fbx", fbx);
    rsv_scene *scene = load(*state, "x.fbx");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_near(view->bounds_max.x, 1); // 40 units of 2.5 cm
    assert_near(view->bounds_max.y, 2);
    assert_near(view->bounds_min.z, -1);
    assert_near(material_of(view, "clay")->base_color.g, 0.25f);
    rsv_scene_destroy(scene);
}

static void bones_morph_targets_colours_and_animations_are_named(void **state)
{
    fixture *f = *state;
    char text[8192];
    const char *at = strstr(collada, "<library_visual_scenes>");
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - collada), collada,
        "<library_animations><animation id=\"a\"><source id=\"t\"><float_array id=\"ta\" "
        "count=\"2\">"
        "0 1</float_array><technique_common><accessor source=\"#ta\" count=\"2\" "
        "stride=\"1\"><param "
        "name=\"TIME\" type=\"float\"/></accessor></technique_common></source><source id=\"o\">"
        "<float_array id=\"oa\" count=\"2\">0 1</float_array><technique_common><accessor "
        "source=\"#oa\" count=\"2\" stride=\"1\"><param name=\"X\" type=\"float\"/></accessor>"
        "</technique_common></source><sampler id=\"m\"><input semantic=\"INPUT\" source=\"#t\"/>"
        "<input semantic=\"OUTPUT\" source=\"#o\"/></sampler><channel source=\"#m\" "
        "target=\"n/translate.X\"/></animation></library_animations>",
        at);
    // a node can only be animated through what has a name
    char *translate = strstr(text, "<translate>0 0 50");
    memmove(translate + strlen("<translate sid=\"translate\">0 0 50"),
        translate + strlen("<translate>0 0 50"),
        strlen(translate + strlen("<translate>0 0 50")) + 1);
    memcpy(translate, "<translate sid=\"translate\">0 0 50",
        strlen("<translate sid=\"translate\">0 0 50"));
    write_file("moving.dae", text);
    rsv_scene_destroy(load(f, "moving.dae"));
    assert_mentions(f->log, "not used: 1 animation");
    f->log[0] = 0;
    snprintf(text, sizeof text, "%s; AnimationCurve\n", fbx);
    write_file("moving.fbx", text);
    rsv_scene_destroy(load(f, "moving.fbx"));
    assert_mentions(f->log, "not used: 1 animation");
}

static void kinds_are_told_by_content_where_names_say_nothing(void **state)
{
    fixture *f = *state;
    write_file("shard.bin", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\n"
                            "property list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    rsv_scene *scene = load(f, "shard.bin");
    assert_int_equal(rsv_scene_get_view(scene)->triangle_count, 1);
    rsv_scene_destroy(scene);
    write_file("notes.txt", "nothing to see\n");
    assert_refused(f, "notes.txt", ".obj");
}

// ---- normals --------------------------------------------------------------------------------------

static void stl_facets_are_shaded_smooth_across_flat_edges(void **state)
{
    write_file("s.stl",
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
        "vertex 0 1 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\n"
        "vertex 1 0 0\nvertex 1 1 0.2\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n");
    rsv_scene *scene = load(*state, "s.stl");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->triangle_count, 2);
    rsv_vec3 a = view->normal[view->triangle[0][1]], b = view->normal[view->triangle[1][0]];
    assert_near(v3_length(v3_sub(a, b)), 0);
    assert_true(v3_length(v3_sub(a, v3(0, 0, 1))) > 0.05f);
    rsv_scene_destroy(scene);
}

static const rsv_vec3 cube[8] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 0, 1 },
    { 1, 0, 1 }, { 1, 1, 1 }, { 0, 1, 1 } };
static const uint32_t cube_index[36] = { 0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2,
    6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7 };

static void creases_split_vertices_and_angles_weigh_normals(void **state)
{
    fixture *f = *state;
    rsv_smooth_mesh smooth;
    assert_int_equal(rsv_smooth_normals(f->context,
                         &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                             .positions = cube,
                             .vertex_count = 8,
                             .indices = cube_index,
                             .triangle_count = 12 },
                         1, &smooth),
        RSV_OK);
    assert_int_equal(smooth.vertex_count, 24);
    for (size_t i = 0; i < 24; i++)
        assert_near(v3_max_abs(smooth.normal[i]), 1);
    rsv_smooth_mesh_release(f->context, &smooth);
    // all smooth: three right angles meet at each corner, however the faces are cut
    assert_int_equal(rsv_smooth_normals(f->context,
                         &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                             .positions = cube,
                             .vertex_count = 8,
                             .indices = cube_index,
                             .triangle_count = 12 },
                         2, &smooth),
        RSV_OK);
    assert_int_equal(smooth.vertex_count, 8);
    for (size_t i = 0; i < 8; i++)
        assert_near(v3_max_abs(smooth.normal[i]), 0.57735027f);
    rsv_smooth_mesh_release(f->context, &smooth);
}

static void a_vertex_of_many_triangles_takes_no_quadratic_time(void **state)
{
    fixture *f = *state;
    enum { blades = 200000 };
    rsv_smooth_mesh smooth;
    rsv_vec3 *position = calloc(blades + 1, sizeof *position);
    uint32_t *index = calloc(3 * (size_t)blades, sizeof *index);
    for (uint32_t i = 0; i < blades; i++) {
        double angle = 6.283185307179586 * i / blades;
        position[i + 1] = v3((float)cos(angle), (float)sin(angle), 0);
        index[3 * i + 1] = i + 1;
        index[3 * i + 2] = (i + 1) % blades + 1;
    }
    assert_int_equal(rsv_smooth_normals(f->context,
                         &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                             .positions = position,
                             .vertex_count = blades + 1,
                             .indices = index,
                             .triangle_count = blades },
                         1, &smooth),
        RSV_OK);
    assert_int_equal(smooth.vertex_count, blades + 1);
    rsv_smooth_mesh_release(f->context, &smooth);
    free(position);
    free(index);
}

// ---- bad input ------------------------------------------------------------------------------------

static void malformed_files_are_refused_in_one_line(void **state)
{
    fixture *f = *state;
    const struct {
        const char *name, *text, *reason;
    } broken[] = {
        { "empty.obj", "", "read" },
        { "empty.ply", "", "header" },
        { "empty.fbx", "", "read" },
        { "empty.dae", "", "read" },
        { "empty.stl", "", "read" },
        { "far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "index" },
        { "nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite" },
        { "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "" },
        { "words.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "line 3" },
        { "type.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n",
            "line 4" },
        { "binary.ply", "ply\nformat ascii 1.0\nelement \x01 1\nend_header\n", "not text" },
        { "open.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n", "end_header" },
        { "huge.ply",
            "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
            "property double x\nproperty double y\nproperty double z\nend_header\n",
            "announces" },
        { "index.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
            "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 77\n",
            "" },
        { "half.dae", "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><library_", "" },
        { "half.fbx", "; FBX 7.3.0 project file\nObjects: { Geometry: 1, ", "" },
    };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        write_file(broken[i].name, broken[i].text);
        assert_refused(f, broken[i].name, broken[i].reason);
    }
    assert_refused(f, "absent.obj", "No such file");
    assert_refused(f, "/tmp", "folder");
    assert_refused(f, "/dev/null", "regular file");
}

/// Every file, truncated anywhere or with single bytes changed, is read or refused, and does no harm.
static void cut_and_altered_files_do_no_harm(void **state)
{
    fixture *f = *state;
    const struct {
        const char *name, *text;
    } sound[] = { { "cut.dae", collada }, { "cut.fbx", fbx },
        { "cut.obj", "mtllib m.mtl\no a\nvn 0 0 1\nvt 0 0\nusemtl glass\ns 1\n" QUAD
                     "f 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1 4/1/1\n" },
        { "cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                     "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                     "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" } };
    uint32_t random = 1;
    for (size_t i = 0; i < sizeof sound / sizeof *sound; i++) {
        size_t length = strlen(sound[i].text);
        for (int round = 0; round < 30; round++) {
            char *text = strdup(sound[i].text);
            random = random * 1664525u + 1013904223u;
            size_t at = random % length;
            if (round % 2)
                text[at] = (char)('-' + (random >> 24) % 80);
            else
                text[at] = 0;
            write_file(sound[i].name, text);
            free(text);
            rsv_scene *scene = NULL;
            f->log[0] = 0;
            if (rsv_scene_load(f->context, sound[i].name, &scene) != RSV_OK)
                assert_null(strchr(rsv_last_error(), '\n'));
            rsv_scene_destroy(scene);
        }
    }
}

static void running_out_of_memory_is_said(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = NULL;
    write_file("q.obj", QUAD);
    for (size_t left = 0; !scene; left++) {
        f->allocations_left = left;
        rsv_status status = rsv_scene_load(f->context, "q.obj", &scene);
        f->allocations_left = SIZE_MAX;
        if (status != RSV_OK) assert_int_equal(status, RSV_ERROR_MEMORY);
        assert_true(left < 1000);
    }
    rsv_scene_destroy(scene);
}

// ---- files of others ------------------------------------------------------------------------------

static const char *assets(void)
{
    const char *path = getenv("RSV_ASSETS");
    if (path && access(path, R_OK) == 0) return path;
    print_message("skipped: RSV_ASSETS names no folder of test assets\n");
    skip();
    return NULL;
}

static void published_files_are_read(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *file;
        size_t triangles;
    } sound[] = { { "cornell/mcguire/CornellBox-Original.obj", 36 },
        { "cornell/mcguire/CornellBox-Sphere.obj", 2188 },
        { "cornell/mcguire/CornellBox-Water.obj", 7088 }, { "head/lee_perry_smith.obj", 17672 },
        { "dragon/dragon_128k.ply", 7282 } };
    const char *root = assets();
    for (size_t i = 0; i < sizeof sound / sizeof *sound; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", root, sound[i].file);
        rsv_scene *scene = load(f, path);
        assert_int_equal(rsv_scene_get_view(scene)->triangle_count, sound[i].triangles);
        rsv_scene_destroy(scene);
    }
}

static void files_broken_on_purpose_are_refused(void **state)
{
    fixture *f = *state;
    static const char *const broken[] = { "crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df.ply",
        "empty.obj", "empty.ply", "malformed.obj" };
    const char *root = assets();
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/broken/text/%s", root, broken[i]);
        assert_refused(f, path, "");
    }
}

int main(void)
{
#define CASE(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)
    const struct CMUnitTest tests[] = {
        CASE(mtl_phong_becomes_lambert_plastic_mirror_and_glass),
        CASE(missing_and_endless_libraries_are_named),
        CASE(materials_that_do_not_exist_are_named_once),
        CASE(textures_are_warned_of),
        CASE(what_is_not_used_is_named_once),
        CASE(line_ends_blanks_and_marks_do_not_matter),
        CASE(oddities_of_obj_are_read_or_named),
        CASE(spellings_of_mtl_and_obj_are_understood),
        CASE(bones_morph_targets_colours_and_animations_are_named),
        CASE(importers_do_not_speak_for_themselves),
        CASE(polygons_without_units_follow_the_description),
        CASE(collada_units_axes_cameras_and_lights_are_kept),
        CASE(fbx_units_and_axes_become_metres_and_y_up),
        CASE(kinds_are_told_by_content_where_names_say_nothing),
        CASE(stl_facets_are_shaded_smooth_across_flat_edges),
        CASE(creases_split_vertices_and_angles_weigh_normals),
        CASE(a_vertex_of_many_triangles_takes_no_quadratic_time),
        CASE(malformed_files_are_refused_in_one_line),
        CASE(cut_and_altered_files_do_no_harm),
        CASE(running_out_of_memory_is_said),
        CASE(published_files_are_read),
        CASE(files_broken_on_purpose_are_refused),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
