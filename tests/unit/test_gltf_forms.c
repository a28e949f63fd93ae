/// Other forms of glTF meshes: morph targets, skins, instances; and hidden meshes.
#include "gltf_fixture.h"

#include "scene/material_at.h"

#define SQUARE "\"attributes\":{\"POSITION\":0},\"indices\":1"

static rsv_scene *load_sketch(fixture *f, const folder *place, const sketch *s, const char *rest)
{
    return load(f, write_sketch(place, s, rest));
}

// ---- morph targets --------------------------------------------------------------------------------

/// A square with three targets: x + 1, y + 2, z + 4 at two of its corners.
static sketch morphed_square(void)
{
    sketch s = square_sketch();
    for (int k = 0; k < 3; k++) {
        float change[12] = { 0 };
        for (int v = k == 2 ? 2 : 0; v < 4; v++)
            change[3 * v + k] = (float)(1 << k);
        add_vectors(&s, change, 4, 3);
    }
    return s;
}

#define TARGETS ",\"targets\":[{\"POSITION\":2},{\"POSITION\":3},{\"POSITION\":4}]"

static void morph_targets_are_added_by_their_default_weights(void **state)
{
    static const struct {
        const char *mesh, *node;
        rsv_vec3 low, high;
    } cases[] = {
        { "", "", { 0, 0, 0 }, { 1, 1, 0 } },
        { ",\"weights\":[1,0,0]", "", { 1, 0, 0 }, { 2, 1, 0 } },
        { ",\"weights\":[0.5,0.25,0]", "", { 0.5f, 0.5f, 0 }, { 1.5f, 1.5f, 0 } },
        { ",\"weights\":[0.5,0.25,-0.5]", "", { 0.5f, 0.5f, -2 }, { 1.5f, 1.5f, 0 } },
        { ",\"weights\":[1,1,1]", ",\"weights\":[0,0,0]", { 0, 0, 0 }, { 1, 1, 0 } },
        { ",\"weights\":[1,1,1]", ",\"weights\":[0,0,1]", { 0, 0, 0 }, { 1, 1, 4 } },
        { "", ",\"weights\":[0,2]", { 0, 4, 0 }, { 1, 5, 0 } }, // those missing are 0
        { ",\"weights\":[0,0,0,7,7]", "", { 0, 0, 0 }, { 1, 1, 0 } },
    };
    folder place = new_folder();
    const sketch s = morphed_square();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[2048];
        snprintf(rest, sizeof rest,
            "\"meshes\":[{\"primitives\":[{" SQUARE TARGETS "}]%s}],\"nodes\":[{\"mesh\":0%s}]",
            cases[k].mesh, cases[k].node);
        rsv_scene *scene = load_sketch(*state, &place, &s, rest);
        assert_bounds(scene, cases[k].low, cases[k].high);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

/// Two nodes show one mesh, each by its own weights.
static void nodes_morph_their_mesh_each_for_itself(void **state)
{
    folder place = new_folder();
    const sketch s = morphed_square();
    rsv_scene *scene = load_sketch(*state, &place, &s,
        "\"meshes\":[{\"primitives\":[{" SQUARE TARGETS "}],\"weights\":[0,0,0]}],"
        "\"nodes\":[{\"mesh\":0,\"weights\":[4,0,0]},{\"mesh\":0},{\"mesh\":0,\"translation\":[0,7,"
        "0],"
        "\"weights\":[0,1,0]}]");
    assert_bounds(scene, v3(0, 0, 0), v3(5, 10, 0));
    assert_int_equal(rsv_scene_get_view(scene)->object_count, 3);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// A target without a buffer view, of which sparse elements alone differ from 0, in normalised bytes.
static void sparse_and_normalized_targets_are_read(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    const uint16_t replaced[2] = { 1, 2 };
    const int8_t change[6] = { 127, 0, 0, 127, 0, 64 };
    int indices = add_accessor(&s, replaced, sizeof replaced, 5123, 2, "SCALAR", "");
    int values = add_accessor(&s, change, sizeof change, 5120, 2, "VEC3", "");
    char more[512];
    snprintf(more, sizeof more,
        ",{\"componentType\":5120,\"normalized\":true,\"count\":4,\"type\":\"VEC3\",\"sparse\":{"
        "\"count\":2,\"indices\":{\"bufferView\":%d,\"componentType\":5123},\"values\":{"
        "\"bufferView\":%d}}}",
        indices, values);
    append_text(s.accessors, sizeof s.accessors, more);
    rsv_scene *scene = load_sketch(*state, &place, &s,
        "\"meshes\":[{\"primitives\":[{" SQUARE
        ",\"targets\":[{\"POSITION\":4}]}],\"weights\":[2]}],\"nodes\":[{\"mesh\":0}]");
    assert_bounds(scene, v3(0, 0, 0), v3(3, 1, 128.0f / 127));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// The normal turns with the square, which the targets tilt by 45 degrees.
static void normals_and_tangents_morph(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    const float normal[12] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    const float tangent[16] = { 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1 };
    const float lift[12] = { 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0 };
    const float tilt[12] = { -1, 0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0 };
    const float along[12] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    add_vectors(&s, normal, 4, 3);
    add_vectors(&s, tangent, 4, 4);
    add_vectors(&s, lift, 4, 3);
    add_vectors(&s, tilt, 4, 3);
    add_vectors(&s, along, 4, 3);
    rsv_scene *scene = load_sketch(*state, &place, &s,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":2,\"TANGENT\":3},"
        "\"indices\":1,\"targets\":[{\"POSITION\":4,\"NORMAL\":5,\"TANGENT\":6}]}],"
        "\"weights\":[1]}],\"nodes\":[{\"mesh\":0}]");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    const float half = sqrtf(0.5f);
    for (size_t n = 0; n < view->vertex_count; n++) {
        assert_true(v3_length(v3_sub(view->normal[n], v3(-half, 0, half))) < 1e-6f);
        assert_float_equal(view->tangent[n][0], half, 1e-6f);
        assert_float_equal(view->tangent[n][2], half, 1e-6f);
        assert_float_equal(view->tangent[n][3], 1, 0);
    }
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void targets_that_do_not_fit_are_refused(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    const float three[9] = { 0 };
    add_vectors(&s, three, 3, 3);
    assert_refused(*state,
        write_sketch(&place, &s,
            "\"meshes\":[{\"name\":\"m\",\"primitives\":[{" SQUARE
            ",\"targets\":[{\"POSITION\":2}]}],\"weights\":[1]}],\"nodes\":[{\"mesh\":0}]"),
        RSV_ERROR_FORMAT, "mesh 'm': accessor 2 holds 3 positions for 4 positions");
    assert_refused(*state,
        write_sketch(&place, &s,
            "\"meshes\":[{\"name\":\"m\",\"primitives\":[{" SQUARE
            ",\"targets\":[{\"POSITION\":9}]}],\"weights\":[1]}],\"nodes\":[{\"mesh\":0}]"),
        RSV_ERROR_FORMAT, "mesh 'm': accessor 9 does not exist");
    remove_folder(place.path);
}

// ---- skins ----------------------------------------------------------------------------------------

/// Joints (accessor 2) and weights (3): all vertices follow joint 0.
static sketch bound_square(void)
{
    sketch s = square_sketch();
    const uint8_t joints[16] = { 0 };
    const float weights[16] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
    add_accessor(&s, joints, sizeof joints, 5121, 4, "VEC4", "");
    add_vectors(&s, weights, 4, 4);
    return s;
}

#define BOUND_MESH                                                                                 \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2,\"WEIGHTS_0\":3}" \
    ","                                                                                            \
    "\"indices\":1}]}],"

/// The node of the mesh stands at (5, 0, 0): that does not count.
static void skinned_meshes_are_where_their_joints_are(void **state)
{
    folder place = new_folder();
    const sketch s = bound_square();
    rsv_scene *scene = load_sketch(*state, &place, &s,
        BOUND_MESH "\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":"
                   "[5,0,0]},{\"translation\":[0,0,2],\"scale\":[3,3,3]}]");
    assert_bounds(scene, v3(0, 0, 2), v3(3, 3, 2));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Joints in the bind pose leave a mesh where it was modelled, wherever node and joints are.
static void inverse_bind_matrices_undo_the_joints(void **state)
{
    folder place = new_folder();
    sketch s = bound_square();
    const float inverse[16] = { 0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0, -2, 0, 0, 1 };
    add_accessor(&s, inverse, sizeof inverse, 5126, 1, "MAT4", "");
    rsv_scene *scene = load_sketch(*state, &place, &s,
        BOUND_MESH "\"skins\":[{\"joints\":[2],\"inverseBindMatrices\":4}],\"nodes\":[{\"mesh\":0,"
                   "\"skin\":0,\"scale\":[9,9,9]},{\"translation\":[1,0,0],\"children\":[2]},"
                   "{\"translation\":[3,0,0],\"scale\":[2,2,2]}]");
    assert_bounds(scene, v3(0, 0, 0), v3(1, 1, 0));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Eight influences in two sets, of shorts, with weights that do not add up to 1: shares count.
static void several_sets_of_influences_are_blended_by_their_shares(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    const uint16_t first[16] = { 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0 };
    const uint16_t second[16] = { 2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0 };
    const uint8_t weights[16] = { 50, 50, 0, 0, 50, 50, 0, 0, 50, 50, 0, 0, 50, 50, 0, 0 };
    const uint16_t more[16] = { 25700, 0, 0, 0, 25700, 0, 0, 0, 25700, 0, 0, 0, 25700, 0, 0, 0 };
    add_accessor(&s, first, sizeof first, 5123, 4, "VEC4", "");
    add_accessor(&s, weights, sizeof weights, 5121, 4, "VEC4", ",\"normalized\":true");
    add_accessor(&s, second, sizeof second, 5123, 4, "VEC4", "");
    add_accessor(&s, more, sizeof more, 5123, 4, "VEC4", ",\"normalized\":true");
    // shares 1/4, 1/4 and 1/2 of joints at x = 0, 4 and 10
    rsv_scene *scene = load_sketch(*state, &place, &s,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2,\"WEIGHTS_0\":"
        "3,\"JOINTS_1\":4,\"WEIGHTS_1\":5},\"indices\":1}]}],\"skins\":[{\"joints\":[1,2,3]}],"
        "\"nodes\":[{\"mesh\":0,\"skin\":0},{},{\"translation\":[4,0,0]},{\"translation\":[10,0,0]}"
        "]");
    assert_bounds(scene, v3(6, 0, 0), v3(7, 1, 0));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void vertices_without_weights_follow_their_first_joint(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    fixture *f = *state;
    const uint8_t joints[16] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
    const float weights[16] = { 0, 0, 0, 0, -1, 0, 0, 0, NAN, 0, 0, 0, INFINITY };
    add_accessor(&s, joints, sizeof joints, 5121, 4, "VEC4", "");
    add_vectors(&s, weights, 4, 4);
    rsv_scene *scene = load_sketch(*state, &place, &s,
        BOUND_MESH "\"skins\":[{\"joints\":[1,2]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{},"
                   "{\"translation\":[4,0,0]}]");
    assert_bounds(scene, v3(4, 0, 0), v3(5, 1, 0));
    assert_mentions(f->log, "3 of 4 vertices have weights that are negative or not finite");
    assert_mentions(f->log, "4 of 4 vertices have no weight above 0");
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// First the targets, then the joints; one mesh, with and without skin.
static void morphed_meshes_are_skinned(void **state)
{
    folder place = new_folder();
    sketch s = bound_square();
    const float change[12] = { 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0 };
    add_vectors(&s, change, 4, 3);
    rsv_scene *scene = load_sketch(*state, &place, &s,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2,\"WEIGHTS_0\":"
        "3},\"indices\":1,\"targets\":[{\"POSITION\":4}]}],\"weights\":[1]}],"
        "\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{\"translation\":[10,0,0],"
        "\"scale\":[2,1,1]},{\"mesh\":0}]");
    assert_bounds(scene, v3(0, 0, 0), v3(14, 1, 0));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// A joint that mirrors: what was in front stays in front, and normals lie on that side.
static void mirroring_joints_keep_the_front(void **state)
{
    folder place = new_folder();
    sketch s = bound_square();
    const float normal[12] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    add_vectors(&s, normal, 4, 3);
    rsv_scene *scene = load_sketch(*state, &place, &s,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2,\"WEIGHTS_0\":"
        "3,\"NORMAL\":4},\"indices\":1}]}],\"skins\":[{\"joints\":[1]}],"
        "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"scale\":[-3,1,1]}]");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_bounds(scene, v3(-3, 0, 0), v3(0, 1, 0));
    for (size_t t = 0; t < view->triangle_count; t++) {
        assert_true(geometric_normal(view, t).z > 0.99f);
        assert_true(view->normal[view->triangle[t][0]].z > 0.99f);
    }
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Joints that no scene shows are where their nodes are.
static void joints_may_lie_outside_the_scene(void **state)
{
    folder place = new_folder();
    const sketch s = bound_square();
    rsv_scene *scene = load_sketch(*state, &place, &s,
        BOUND_MESH
        "\"skins\":[{\"joints\":[2]}],\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":"
        "0,\"skin\":0},{\"translation\":[1,0,0],\"children\":[2]},{\"translation\":[0,2,0]"
        "}]");
    assert_bounds(scene, v3(1, 2, 0), v3(2, 3, 0));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void broken_skins_are_refused(void **state)
{
    static const struct {
        const char *skin, *message;
    } cases[] = {
        { "\"skins\":[{\"name\":\"s\",\"joints\":[]}],", "skin 's': it has no joints" },
        { "\"skins\":[{\"name\":\"s\",\"joints\":[7]}],", "its joint 0 is node 7" },
        { "\"skins\":[{\"name\":\"s\",\"joints\":[1],\"inverseBindMatrices\":0}],",
            "skin 's': accessor 0 must hold MAT4" },
        { "\"skins\":[{\"name\":\"s\",\"joints\":[1],\"inverseBindMatrices\":4}],",
            "skin 's': accessor 4: the matrix of joint 0 is not finite" },
        { "", "node 'n': skin 0 does not exist" },
    };
    folder place = new_folder();
    sketch s = bound_square();
    const float inverse[16] = { 1, 0, 0, 0, 0, NAN };
    add_accessor(&s, inverse, sizeof inverse, 5126, 1, "MAT4", "");
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[1024];
        snprintf(rest, sizeof rest,
            BOUND_MESH "%s\"nodes\":[{\"name\":\"n\",\"mesh\":0,\"skin\":0},{}]", cases[k].skin);
        assert_refused(*state, write_sketch(&place, &s, rest), RSV_ERROR_FORMAT, cases[k].message);
    }
    remove_folder(place.path);
}

// ---- instances ------------------------------------------------------------------------------------

static sketch crates(void)
{
    sketch s = square_sketch();
    float place[27], scale[27];
    int8_t turn[36] = { 0 };
    for (int k = 0; k < 9; k++) {
        place[3 * k] = (float)(3 * (k % 3)), place[3 * k + 1] = (float)(3 * (k / 3));
        place[3 * k + 2] = 0;
        scale[3 * k] = scale[3 * k + 1] = scale[3 * k + 2] = 2;
        turn[4 * k + 3] = 127;
    }
    add_vectors(&s, place, 9, 3);
    add_accessor(&s, turn, sizeof turn, 5120, 9, "VEC4", ",\"normalized\":true");
    add_vectors(&s, scale, 9, 3);
    return s;
}

static void instances_are_placed_by_their_attributes(void **state)
{
    static const char *const listed[] = { "extensionsUsed", "extensionsRequired" };
    fixture *f = *state;
    folder place = new_folder();
    const sketch s = crates();
    for (int k = 0; k < 2; k++) {
        char rest[1024];
        snprintf(rest, sizeof rest,
            "\"%s\":[\"EXT_mesh_gpu_instancing\"],\"meshes\":[{\"primitives\":[{" SQUARE
            "}]}],\"nodes\":[{\"name\":\"crates\",\"mesh\":0,\"translation\":[0,0,5],"
            "\"extensions\":"
            "{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2,\"ROTATION\":3,"
            "\"SCALE\":4}}}}]",
            listed[k]);
        rsv_scene *scene = load_sketch(f, &place, &s, rest);
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        assert_int_equal(view->object_count, 9);
        assert_int_equal(view->triangle_count, 18);
        assert_string_equal(view->object_name[8], "crates, instance 8");
        assert_bounds(scene, v3(0, 0, 5), v3(8, 8, 5));
        rsv_scene_destroy(scene);
    }
    assert_null(strstr(f->log, "warning"));
    remove_folder(place.path);
}

/// Translations alone; quarter turns in normalised shorts.
static void instances_need_not_say_everything(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    const int16_t turn[8] = { 0, 0, 0, 32767, 0, 0, 23170, 23170 };
    const float shift[6] = { 0, 0, 0, 4, 0, 0 };
    add_accessor(&s, turn, sizeof turn, 5122, 2, "VEC4", ",\"normalized\":true");
    add_vectors(&s, shift, 2, 3);
    const char *const attribute[] = { "\"ROTATION\":2", "\"TRANSLATION\":3" };
    const rsv_vec3 low[] = { { -1, 0, 0 }, { 0, 0, 0 } }, high[] = { { 1, 1, 0 }, { 5, 1, 0 } };
    for (int k = 0; k < 2; k++) {
        char rest[512];
        snprintf(rest, sizeof rest,
            "\"meshes\":[{\"primitives\":[{" SQUARE "}]}],\"nodes\":[{\"mesh\":0,\"extensions\":{"
            "\"EXT_mesh_gpu_instancing\":{\"attributes\":{%s}}}}]",
            attribute[k]);
        rsv_scene *scene = load_sketch(*state, &place, &s, rest);
        assert_bounds(scene, low[k], high[k]);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void absurd_instances_are_refused(void **state)
{
    static const struct {
        const char *accessor, *attributes, *message;
        rsv_status status;
    } cases[] = {
        { "", "\"TRANSLATION\":0,\"SCALE\":2", "4 elements as TRANSLATION, but 9 as SCALE",
            RSV_ERROR_FORMAT },
        { "", "\"TRANSLATION\":77", "node 'n': accessor 77 does not exist", RSV_ERROR_FORMAT },
        { "", "\"ROTATION\":2", "node 'n': accessor 2 must hold VEC4", RSV_ERROR_FORMAT },
        { ",{\"componentType\":5126,\"count\":4000000000,\"type\":\"VEC3\"}", "\"TRANSLATION\":5",
            "too large a count", RSV_ERROR_FORMAT },
        { ",{\"bufferView\":0,\"componentType\":5126,\"count\":4000000000,\"type\":\"VEC3\"}",
            "\"TRANSLATION\":5", "reaches past the end of its buffer view", RSV_ERROR_FORMAT },
        { ",{\"componentType\":5126,\"count\":2,\"type\":\"VEC4\"}", "\"ROTATION\":5",
            "the rotation of its instance 0 is zero", RSV_ERROR_FORMAT },
    };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        sketch s = crates();
        char rest[1024];
        append_text(s.accessors, sizeof s.accessors, cases[k].accessor);
        snprintf(rest, sizeof rest,
            "\"meshes\":[{\"primitives\":[{" SQUARE "}]}],\"nodes\":[{\"name\":\"n\",\"mesh\":0,"
            "\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{%s}}}}]",
            cases[k].attributes);
        assert_refused(*state, write_sketch(&place, &s, rest), cases[k].status, cases[k].message);
    }
    remove_folder(place.path);
}

/// 16 million instances of a mesh of a million triangles, from a file of a few hundred bytes.
static void instances_that_no_memory_holds_are_refused(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    append_text(s.accessors, sizeof s.accessors,
        ",{\"componentType\":5126,\"count\":16000000,\"type\":\"VEC3\"},"
        "{\"componentType\":5126,\"count\":16000000,\"type\":\"VEC3\"}");
    const char *path = write_sketch(&place, &s,
        "\"meshes\":[{\"name\":\"m\",\"primitives\":[{\"attributes\":{\"POSITION\":3}}]}],"
        "\"nodes\":"
        "[{\"name\":\"n\",\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
        "\"TRANSLATION\":2}}}}]");
    assert_refused(
        *state, path, RSV_ERROR_UNSUPPORTED, "node 'n': 16000000 instances of mesh 'm' need");
    remove_folder(place.path);
}

// ---- visibility and lights ------------------------------------------------------------------------

#define LAMPS                                                                                      \
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"bright\",\"type\":"          \
    "\"point\","                                                                                   \
    "\"intensity\":1000},{\"name\":\"dim\",\"type\":\"point\",\"intensity\":10},{\"name\":"        \
    "\"odd\","                                                                                     \
    "\"type\":\"ambient\"}]}},"
#define LIGHT(index) "\"KHR_lights_punctual\":{\"light\":" #index "}"

static void hidden_nodes_neither_show_nor_shine(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    const sketch s = square_sketch();
    rsv_scene *scene = load_sketch(f, &place, &s,
        LAMPS
        "\"extensionsRequired\":[\"KHR_node_visibility\"],\"meshes\":[{\"primitives\":[{" SQUARE
        "}]}],\"nodes\":[{\"extensions\":{" LIGHT(
            0) ",\"KHR_node_visibility\":{\"visible\":"
               "false}},\"mesh\":0,\"translation\":[9,0,0],\"children\":[1]},{\"mesh\":0,"
               "\"extensions\":{" LIGHT(0) "}},{\"extensions\":{" LIGHT(
                   1) ",\"KHR_node_visibility\":{\"visible\":true}},\"mesh\":0,\"children\":[3]},{"
                      "\"extensions\":{\"KHR_node_visibility\":{}}}]");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->light_count, 1);
    assert_string_equal(view->light[0].name, "dim");
    assert_bounds(scene, v3(0, 0, 0), v3(1, 1, 0));
    assert_mentions(f->log, "1 nodes (first: 'node 0') are hidden");
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void lights_of_an_unknown_type_are_left_out_by_name(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    const sketch s = square_sketch();
    rsv_scene *scene = load_sketch(f, &place, &s,
        LAMPS "\"meshes\":[{\"primitives\":[{" SQUARE
              "}]}],\"nodes\":[{\"mesh\":0},{\"extensions\":{" LIGHT(2) "}}]");
    assert_int_equal(rsv_scene_get_view(scene)->light_count, 0);
    assert_mentions(f->log, "warning: light 'odd': its type 'ambient' is not in the format");
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Three nodes, one light and one camera: the names of the nodes distinguish them.
static void lights_and_cameras_know_their_nodes(void **state)
{
    folder place = new_folder();
    const sketch s = square_sketch();
    rsv_scene *scene = load_sketch(*state, &place, &s,
        LAMPS
        "\"cameras\":[{\"name\":\"lens\",\"type\":\"perspective\",\"perspective\":{\"yfov\":1,"
        "\"znear\":1}}],\"meshes\":[{\"primitives\":[{" SQUARE
        "}]}],\"nodes\":[{\"mesh\":0},{\"name\":\"left\",\"extensions\":{" LIGHT(
            0) "},\"camera\":0},{\"name\":\"right\",\"extensions\":{" LIGHT(0) "},\"camera\":0}]");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->light_count, 2);
    assert_string_equal(view->light[1].name, "bright");
    assert_string_equal(view->light_node[0], "left");
    assert_string_equal(view->light_node[1], "right");
    assert_string_equal(view->camera_node[1], "right");
    assert_int_equal(rsv_scene_find_camera(scene, "lens"), 0);
    assert_int_equal(rsv_scene_find_camera(scene, "left"), 0);
    assert_int_equal(rsv_scene_find_camera(scene, "right"), 1);
    assert_int_equal(rsv_scene_find_camera(scene, "middle"), RSV_NONE);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

// ---- opacity --------------------------------------------------------------------------------------

/// How many of a square's points are cut out. @param alpha of its vertices
static size_t count_holes(
    fixture *f, const folder *place, float alpha, const char *factor, const char *cutoff)
{
    sketch s = square_sketch();
    float color[16];
    char rest[1024];
    for (int k = 0; k < 16; k++)
        color[k] = k % 4 == 3 ? alpha : 1;
    add_vectors(&s, color, 4, 4);
    snprintf(rest, sizeof rest,
        "\"materials\":[{\"alphaMode\":\"MASK\",\"alphaCutoff\":%s,\"pbrMetallicRoughness\":{"
        "\"baseColorFactor\":[1,1,1,%s]}}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0,\"COLOR_0\":2},\"indices\":1,\"material\":0}]}],\"nodes\":[{\"mesh\":0}]",
        cutoff, factor);
    rsv_scene *scene = load(f, write_sketch(place, &s, rest));
    size_t holes = 0;
    for (int k = 0; k < 10000; k++) {
        float u = 0.0099f * (float)(k % 100), v = 0.0099f * (float)(k / 100) * (1 - u);
        holes += rsv_is_cut_out(rsv_scene_get_view(scene), (uint32_t)k % 2, u, v);
    }
    rsv_scene_destroy(scene);
    return holes;
}

static void opacity_equal_to_the_cutoff_is_opaque(void **state)
{
    static const struct {
        float alpha;
        const char *factor, *cutoff;
    } equal[] = { { 0.5f, "0.5", "0.25" }, { 0.3f, "0.7", "0.21" }, { 0.1f, "1", "0.1" },
        { 0.9f, "0.9", "0.81" }, { 1, "0.3", "0.3" }, { 1.0f / 3, "0.6", "0.2" } };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof equal / sizeof *equal; k++)
        assert_int_equal(
            count_holes(*state, &place, equal[k].alpha, equal[k].factor, equal[k].cutoff), 0);
    assert_int_equal(count_holes(*state, &place, 0.4999f, "0.5", "0.25"), 10000);
    remove_folder(place.path);
}

/// Where opacity is above the cutoff, the surface is opaque, also without a texture or vertex colours.
static void what_a_cutoff_leaves_lets_nothing_through(void **state)
{
    folder place = new_folder();
    static const struct {
        const char *factor, *cutoff;
        size_t holes;
    } mask[] = { { "0.7", "0.5", 0 }, { "0.7", "0.7", 0 }, { "0.3", "0.5", 10000 } };
    for (size_t k = 0; k < sizeof mask / sizeof *mask; k++) {
        assert_int_equal(
            count_holes(*state, &place, 1, mask[k].factor, mask[k].cutoff), mask[k].holes);
        rsv_scene *scene = load(*state, path_in(&place, "shape.gltf"));
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        if (!mask[k].holes) assert_float_equal(view->material[0].opacity, 1, 0);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

#define FORM_TEST(function)                                                                        \
    cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

// ---- variants ---------------------------------------------------------------------------------------

/// Red by default, green where it is moss, and as it is where it is sand, of which it says nothing.
static const char *write_variants(const folder *place)
{
    const sketch s = square_sketch();
    return write_sketch(place, &s,
        "\"materials\":[{\"name\":\"red\"},{\"name\":\"green\"}],\"meshes\":[{\"primitives\":["
        "{" SQUARE
        ",\"material\":0,\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[{\"material\":1,"
        "\"variants\":[0]},{\"material\":7,\"variants\":[2]}]}}}]}],\"nodes\":[{\"mesh\":0}],"
        "\"extensionsUsed\":[\"KHR_materials_variants\"],\"extensions\":{\"KHR_materials_"
        "variants\":{"
        "\"variants\":[{\"name\":\"moss\"},{\"name\":\"sand\"},{\"name\":\"broken\"}]}}");
}

static void variants_show_their_materials(void **state)
{
    static const struct {
        const char *variant, *material, *problem;
    } cases[] = {
        { NULL, "red", NULL },
        { "moss", "green", NULL },
        { "sand", "red", NULL },
        { "broken", NULL, "material 7 does not exist" },
        { "stone", NULL, "no variant 'stone'; there are 'moss', 'sand', 'broken'" },
    };
    fixture *f = *state;
    folder place = new_folder();
    const char *path = write_variants(&place);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        rsv_load_desc desc = rsv_default_load_desc();
        rsv_scene *scene = NULL;
        desc.variant = cases[k].variant;
        f->log[0] = '\0';
        rsv_status status = rsv_scene_load_with(f->context, path, &desc, &scene);
        if (cases[k].problem) {
            assert_int_not_equal(status, RSV_OK);
            assert_mentions(rsv_last_error(), cases[k].problem);
            continue;
        }
        assert_int_equal(status, RSV_OK);
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        assert_string_equal(view->material[view->triangle_material[0]].name, cases[k].material);
        assert_null(strstr(f->log, "warning"));
        if (!cases[k].variant) assert_mentions(f->log, "'moss', 'sand'");
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void files_without_variants_have_none(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    const sketch s = square_sketch();
    rsv_load_desc desc = rsv_default_load_desc();
    rsv_scene *scene = NULL;
    desc.variant = "moss";
    const char *path = write_sketch(
        &place, &s, "\"meshes\":[{\"primitives\":[{" SQUARE "}]}],\"nodes\":[{\"mesh\":0}]");
    assert_int_equal(rsv_scene_load_with(f->context, path, &desc, &scene), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "no variant 'moss', nor any other");
    path = path_in(&place, "plain.stl");
    write_bytes(path, "solid x\nendsolid x\n", 19);
    assert_int_equal(rsv_scene_load_with(f->context, path, &desc, &scene), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "only glTF has variants");
    remove_folder(place.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FORM_TEST(morph_targets_are_added_by_their_default_weights),
        FORM_TEST(nodes_morph_their_mesh_each_for_itself),
        FORM_TEST(sparse_and_normalized_targets_are_read),
        FORM_TEST(normals_and_tangents_morph),
        FORM_TEST(targets_that_do_not_fit_are_refused),
        FORM_TEST(skinned_meshes_are_where_their_joints_are),
        FORM_TEST(inverse_bind_matrices_undo_the_joints),
        FORM_TEST(several_sets_of_influences_are_blended_by_their_shares),
        FORM_TEST(vertices_without_weights_follow_their_first_joint),
        FORM_TEST(morphed_meshes_are_skinned),
        FORM_TEST(mirroring_joints_keep_the_front),
        FORM_TEST(joints_may_lie_outside_the_scene),
        FORM_TEST(broken_skins_are_refused),
        FORM_TEST(instances_are_placed_by_their_attributes),
        FORM_TEST(instances_need_not_say_everything),
        FORM_TEST(absurd_instances_are_refused),
        FORM_TEST(instances_that_no_memory_holds_are_refused),
        FORM_TEST(hidden_nodes_neither_show_nor_shine),
        FORM_TEST(lights_of_an_unknown_type_are_left_out_by_name),
        FORM_TEST(lights_and_cameras_know_their_nodes),
        FORM_TEST(opacity_equal_to_the_cutoff_is_opaque),
        FORM_TEST(variants_show_their_materials),
        FORM_TEST(files_without_variants_have_none),
        FORM_TEST(what_a_cutoff_leaves_lets_nothing_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
