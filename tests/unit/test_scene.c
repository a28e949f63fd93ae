/// Flattening: winding, normals, bad triangles and bad values; the chosen camera; the built-in scenes.
#include "scene_fixture.h"
#include "slow_tests.h"

static const rsv_vec3 unit_triangle[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };

/// A scene with one material.
static rsv_scene *new_scene(fixture *f)
{
    rsv_scene *scene = NULL;
    rsv_material material = rsv_default_material();
    material.name = "plain";
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    assert_int_equal(rsv_scene_add_material(scene, &material, NULL), RSV_OK);
    return scene;
}

static rsv_mesh_desc triangle_mesh(const rsv_vec3 *normals)
{
    return (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
        .name = "triangle",
        .positions = unit_triangle,
        .normals = normals,
        .vertex_count = 3,
        .triangle_count = 1 };
}

/// Commits one mesh under a transform.
static const rsv_scene_view *commit_mesh(
    rsv_scene *scene, const rsv_mesh_desc *mesh, const float *transform)
{
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(scene, mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, transform, "node"), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return rsv_scene_get_view(scene);
}

static void assert_vector(rsv_vec3 v, float x, float y, float z)
{
    assert_float_equal(v.x, x, 1e-6f);
    assert_float_equal(v.y, y, 1e-6f);
    assert_float_equal(v.z, z, 1e-6f);
}

static void mirroring_keeps_the_authored_front(void **state)
{
    rsv_scene *scene = new_scene(*state);
    const rsv_vec3 normals[3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } };
    const float mirror_x[16] = { -2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1 };
    rsv_mesh_desc mesh = triangle_mesh(normals);
    const rsv_scene_view *view = commit_mesh(scene, &mesh, mirror_x);
    assert_vector(geometric_normal(view, 0), 0, 0, 1);
    assert_vector(view->normal[0], 0, 0, 1);
    assert_vector(view->bounds_min, 3, 6, 7);
    assert_vector(view->bounds_max, 5, 7, 7);
    rsv_scene_destroy(scene);
}

static void normals_follow_the_inverse_transpose(void **state)
{
    rsv_scene *scene = new_scene(*state);
    const rsv_vec3 slope[3] = { { 0, 0, 0 }, { 1, 0, -1 }, { 0, 1, 0 } };
    const rsv_vec3 normals[3] = { { 1, 0, 1 }, { 1, 0, 1 }, { 1, 0, 1 } };
    const float stretch_x[16] = { 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    rsv_mesh_desc mesh = triangle_mesh(normals);
    mesh.positions = slope;
    const rsv_scene_view *view = commit_mesh(scene, &mesh, stretch_x);
    rsv_vec3 geometric = geometric_normal(view, 0);
    assert_vector(view->normal[view->triangle[0][0]], geometric.x, geometric.y, geometric.z);
    rsv_scene_destroy(scene);
}

static void tiny_transforms_keep_normals(void **state)
{
    rsv_scene *scene = new_scene(*state);
    const rsv_vec3 normals[3] = { { 0, 0, 1e-30f }, { 0, 0, 1e30f }, { 0, 0, 2 } };
    const float shrink[16] = { 1e-12f, 0, 0, 0, 0, 1e-12f, 0, 0, 0, 0, 1e-12f, 0, 0, 0, 0, 1 };
    rsv_mesh_desc mesh = triangle_mesh(normals);
    const rsv_scene_view *view = commit_mesh(scene, &mesh, shrink);
    assert_int_equal(view->triangle_count, 1);
    for (int i = 0; i < 3; i++)
        assert_vector(view->normal[i], 0, 0, 1);
    rsv_scene_destroy(scene);
}

static void missing_normals_make_flat_triangles(void **state)
{
    rsv_scene *scene = new_scene(*state);
    const rsv_vec3 folded[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0.5f }, { 0, 1, 0 } };
    const uint32_t indices[6] = { 0, 1, 2, 0, 2, 3 };
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "fold",
        .positions = folded,
        .vertex_count = 4,
        .indices = indices,
        .triangle_count = 2,
        .material = 0 };
    const rsv_scene_view *view = commit_mesh(scene, &mesh, NULL);
    assert_int_equal(view->vertex_count, 6);
    for (size_t t = 0; t < 2; t++)
        for (int k = 0; k < 3; k++)
            assert_float_equal(
                v3_dot(view->normal[view->triangle[t][k]], geometric_normal(view, t)), 1, 1e-6f);
    rsv_scene_destroy(scene);
}

static void unusable_normals_become_geometric(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f);
    const rsv_vec3 normals[3] = { { 0, 0, -1 }, { NAN, 0, 0 }, { 0, 0.6f, 0.8f } };
    rsv_mesh_desc mesh = triangle_mesh(normals);
    const rsv_scene_view *view = commit_mesh(scene, &mesh, NULL);
    assert_vector(view->normal[view->triangle[0][0]], 0, 0, 1);
    assert_vector(view->normal[view->triangle[0][1]], 0, 0, 1);
    assert_vector(view->normal[view->triangle[0][2]], 0, 0.6f, 0.8f);
    assert_mentions(f->log, "mesh 'triangle': 1 of 3 normals");
    rsv_scene_destroy(scene);
}

static void degenerate_triangles_get_one_warning(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f);
    const rsv_vec3 positions[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 2, 0, 0 } };
    const uint32_t indices[9] = { 0, 1, 3, 0, 1, 2, 1, 1, 2 };
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "slivers",
        .positions = positions,
        .vertex_count = 4,
        .indices = indices,
        .triangle_count = 3,
        .material = 0 };
    const rsv_scene_view *view = commit_mesh(scene, &mesh, NULL);
    assert_int_equal(view->triangle_count, 1);
    assert_mentions(f->log, "mesh 'slivers': 2 degenerate");
    assert_int_equal(count_mentions(f->log, "degenerate"), 1);
    rsv_scene_destroy(scene);
}

static void singular_transforms_are_skipped_by_name(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f);
    const float flat[16] = { 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    rsv_mesh_desc mesh = triangle_mesh(NULL);
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, 0, flat, "pressed"), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_ERROR_SCENE);
    assert_mentions(f->log, "node 'pressed'");
    assert_null(strstr(f->log, "degenerate"));
    assert_int_equal(rsv_scene_commit(scene), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(scene);
}

/// A plane stays a plane, however it is turned; a body would become two faces in one place, and is skipped.
static void a_scale_of_zero_across_a_flat_mesh_shows_it(void **state)
{
    fixture *f = *state;
    const float pressed[3][16] = {
        { 4, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 1, 2, 3, 1 },
        { 0, 0, 4, 0, 0, -2, 0, 0, 0, 0, 0, 0, 1, 2, 3, 1 },
        { 4, 0, 0, 0, 0, 2, 0, 0, 4, 2, 0, 0, 1, 2, 3, 1 }, // its z falls into its plane
    };
    const rsv_vec3 normals[3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } };
    const rsv_vec3 expected[3] = { { 0, 0, 1 }, { 1, 0, 0 }, { 0, 0, 1 } };
    for (int k = 0; k < 3; k++) {
        rsv_scene *scene = new_scene(f);
        rsv_mesh_desc mesh = triangle_mesh(normals);
        const rsv_scene_view *view = commit_mesh(scene, &mesh, pressed[k]);
        assert_int_equal(view->triangle_count, 1);
        rsv_vec3 n = expected[k];
        assert_vector(geometric_normal(view, 0), n.x, n.y, n.z);
        assert_vector(view->normal[0], n.x, n.y, n.z);
        rsv_scene_destroy(scene);
    }
    assert_null(strstr(f->log, "singular"));
}

static void a_scale_of_zero_across_a_body_skips_it(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f);
    const rsv_vec3 corner[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    const uint32_t index[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
    const float flat[16] = { 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "body",
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 4 };
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, 0, flat, "pressed"), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_ERROR_SCENE);
    assert_mentions(f->log, "node 'pressed': its transform is singular");
    rsv_scene_destroy(scene);
}

static void bad_meshes_are_refused(void **state)
{
    rsv_scene *scene = new_scene(*state);
    const rsv_vec3 infinite[3] = { { 0, 0, 0 }, { 1, INFINITY, 0 }, { 0, 1, 0 } };
    const uint32_t past_end[3] = { 0, 1, 3 };
    rsv_mesh_desc mesh = triangle_mesh(NULL);
    mesh.positions = infinite;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "mesh 'triangle': position of vertex 1");
    mesh = triangle_mesh(NULL);
    mesh.indices = past_end;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "vertex 3");
    mesh = triangle_mesh(NULL);
    mesh.triangle_count = 2;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_ERROR_FORMAT);
    mesh.triangle_count = SIZE_MAX / 2;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_ERROR_UNSUPPORTED);
    mesh = triangle_mesh(NULL);
    mesh.material = 1;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_scene_add_instance(scene, 0, NULL, "node"), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(scene);
}

static void a_transform_beyond_float_is_refused(void **state)
{
    rsv_scene *scene = new_scene(*state);
    const float huge[16] = { 3e38f, 0, 0, 0, 0, 3e38f, 0, 0, 0, 0, 3e38f, 0, 3e38f, 0, 0, 1 };
    rsv_mesh_desc mesh = triangle_mesh(NULL);
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, 0, huge, "far"), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "node 'far'");
    rsv_scene_destroy(scene);
}

static void an_empty_scene_is_refused(void **state)
{
    rsv_scene *scene = new_scene(*state);
    assert_int_equal(rsv_scene_commit(scene), RSV_ERROR_SCENE);
    rsv_scene_destroy(scene);
}

static void a_committed_scene_is_closed(void **state)
{
    rsv_scene *scene = new_scene(*state);
    rsv_mesh_desc mesh = triangle_mesh(NULL);
    commit_mesh(scene, &mesh, NULL);
    assert_int_equal(rsv_scene_commit(scene), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, NULL), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(scene);
}

static void values_out_of_range_are_clamped_by_name(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f);
    rsv_material material = rsv_default_material();
    material.name = "odd";
    material.base_color = rgb(1, 1.5f, -1);
    material.roughness = NAN;
    material.ior = 0.5f;
    material.attenuation_distance = 0;
    assert_int_equal(rsv_scene_add_material(scene, &material, NULL), RSV_OK);
    rsv_mesh_desc mesh = triangle_mesh(NULL);
    mesh.material = 1;
    const rsv_material *stored = &commit_mesh(scene, &mesh, NULL)->material[1];
    assert_float_equal(stored->base_color.r, 1, 0);
    assert_float_equal(stored->base_color.g, 1, 0);
    assert_float_equal(stored->base_color.b, 0, 0);
    assert_float_equal(stored->roughness, 1, 0);
    assert_float_equal(stored->ior, 1, 0);
    assert_true(stored->attenuation_distance > 0);
    assert_int_equal(count_mentions(f->log, "material 'odd'"), 4);
    rsv_scene_destroy(scene);
}

static void bad_lights_and_cameras_are_refused(void **state)
{
    rsv_scene *scene = new_scene(*state);
    rsv_punctual_light light = {
        .name = "lamp", .kind = RSV_PUNCTUAL_SPOT, .direction = { 0, -1, 0 }
    };
    light.inner_cone_angle = 1;
    light.outer_cone_angle = 0.5f;
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_ERROR_FORMAT);
    light.outer_cone_angle = 1;
    light.intensity.g = -1;
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "light 'lamp'");
    rsv_camera camera = rsv_camera_look_at("flat", v3(0, 0, 1), v3(0, 0, 0), 0, 1);
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_ERROR_FORMAT);
    camera.vertical_extent = 1;
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    rsv_scene_destroy(scene);
}

static void the_framing_camera_shows_everything(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f);
    const rsv_vec3 wide[3] = { { 100, 3, -7 }, { 160, 4, -9 }, { 120, 40, -8 } };
    rsv_mesh_desc mesh = triangle_mesh(NULL);
    mesh.positions = wide;
    const rsv_scene_view *view = commit_mesh(scene, &mesh, NULL);
    assert_int_equal(rsv_scene_find_camera(scene, "framing"), 0);
    assert_int_equal(rsv_scene_find_camera(scene, "other"), RSV_NONE);
    assert_mentions(f->log, "'framing' is chosen");
    const rsv_camera *camera = &view->camera[0];
    for (size_t i = 0; i < view->vertex_count; i++) {
        rsv_vec3 d = v3_sub(view->position[i], camera->position);
        float depth = v3_dot(d, camera->forward), limit = depth * tanf(camera->vertical_fov / 2);
        assert_true(depth > 0);
        assert_true(fabsf(v3_dot(d, camera->right)) <= limit);
        assert_true(fabsf(v3_dot(d, camera->up)) <= limit);
    }
    assert_true(camera->position.z > view->bounds_max.z && camera->forward.y < 0);
    rsv_scene_destroy(scene);
}

static void look_at_is_right_handed_even_straight_down(void **state)
{
    (void)state;
    const rsv_vec3 targets[3] = { { 1, 2, 3 }, { 0, -5, 0 }, { 0, 5, 0 } };
    for (int i = 0; i < 3; i++) {
        rsv_camera c = rsv_camera_look_at("c", v3(0, 0, 0), targets[i], 1, 1);
        rsv_vec3 back = v3_cross(c.right, c.up);
        assert_vector(back, -c.forward.x, -c.forward.y, -c.forward.z);
        assert_float_equal(v3_dot(c.forward, v3_normalize(targets[i])), 1, 1e-6f);
        assert_float_equal(v3_dot(c.right, c.up), 0, 1e-6f);
    }
}

static rsv_scene *builtin(fixture *f, const char *name)
{
    rsv_scene *scene = NULL;
    if (rsv_scene_builtin(f->context, name, &scene) != RSV_OK) fail_msg("%s", rsv_last_error());
    return scene;
}

static void builtin_scenes_are_sound(void **state)
{
    fixture *f = *state;
    for (const char *const *name = rsv_scene_builtin_names(); *name; name++) {
        rsv_scene *scene = builtin(f, *name);
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        for (size_t t = 0; t < view->triangle_count; t++)
            for (int k = 0; k < 3; k++) {
                rsv_vec3 normal = view->normal[view->triangle[t][k]];
                assert_float_equal(v3_length(normal), 1, 1e-5f);
                assert_true(v3_dot(normal, geometric_normal(view, t)) > 0);
            }
        assert_true(rsv_scene_find_camera(scene, "framing") == RSV_NONE);
        rsv_scene_destroy(scene);
        // its light is the environment, which the caller chooses
        if (strcmp(*name, "character") == 0) f->log[0] = 0;
    }
    assert_string_equal(f->log, ""); // nothing to warn about
    rsv_scene *none = NULL;
    assert_int_equal(rsv_scene_builtin(f->context, "bathroom", &none), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "cornell-blocks");
}

/// Horizontal picture coordinate of a point: negative = left of the middle.
static float picture_x(const rsv_camera *camera, rsv_vec3 p)
{
    return v3_dot(v3_sub(p, camera->position), camera->right);
}

static void the_cornell_box_is_the_published_one(void **state)
{
    rsv_scene *scene = builtin(*state, "cornell-blocks");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->triangle_count, 2 * 6 + 2 * 10);
    assert_float_equal(view->camera[0].vertical_fov, 39.3077f * RSV_PI / 180, 1e-5f);
    assert_float_equal(view->bounds_max.y, 0.5488f, 1e-6f);
    const rsv_vec3 inside = v3(-0.278f, 0.3f, -0.28f);
    float light_area = 0;
    for (size_t t = 0; t < view->triangle_count; t++) {
        const char *object = object_of(view, t);
        const rsv_material *material = &view->material[view->triangle_material[t]];
        rsv_vec3 normal = geometric_normal(view, t), middle = centroid(view, t);
        if (!strstr(object, "block"))
            assert_true(v3_dot(normal, v3_sub(inside, middle)) > 0); // seen from inside
        if (!strcmp(material->name, "red"))
            assert_true(picture_x(&view->camera[0], middle) < -0.2f);
        if (!strcmp(material->name, "green"))
            assert_true(picture_x(&view->camera[0], middle) > 0.2f);
        if (!strcmp(object, "tall block")) assert_true(picture_x(&view->camera[0], middle) < 0.1f);
        if (!strcmp(object, "light")) {
            assert_float_equal(normal.y, -1, 1e-6f);
            assert_true(middle.y < 0.5488f && middle.y > 0.548f);
            assert_true(rgb_is_black(material->base_color) && material->emission.r == 17);
            const uint32_t *c = view->triangle[t];
            light_area +=
                0.5f * v3_length(v3_cross(v3_sub(view->position[c[1]], view->position[c[0]]),
                           v3_sub(view->position[c[2]], view->position[c[0]])));
        }
    }
    assert_float_equal(light_area, 0.130f * 0.105f, 1e-7f);
    rsv_scene_destroy(scene);
}

static void glass_spheres_are_closed_fine_and_apart(void **state)
{
    rsv_scene *scene = builtin(*state, "cornell-spheres");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    const char *const names[2] = { "front sphere", "back sphere" };
    for (int i = 0; i < 2; i++) {
        size_t count = 0;
        double volume = 0;
        rsv_vec3 low = v3(1, 1, 1), high = v3(-1, -1, -1);
        for (size_t t = 0; t < view->triangle_count; t++) {
            if (strcmp(object_of(view, t), names[i])) continue;
            const uint32_t *c = view->triangle[t];
            const rsv_vec3 *p = view->position;
            count++;
            volume += v3_dot(p[c[0]], v3_cross(p[c[1]], p[c[2]])) / 6.0;
            for (int k = 0; k < 3; k++) {
                low = v3_min(low, p[c[k]]);
                high = v3_max(high, p[c[k]]);
            }
        }
        assert_true(count >= 20000);
        assert_true(low.y > 0 && low.y < 0.001f); // a hair above the floor
        // outward: the signed volume is that of a ball of radius 0.1, less what chords cut off
        assert_float_equal(volume, 4.0 / 3 * RSV_PI * 1e-3, 1e-5);
        assert_float_equal(high.x - low.x, 0.2f, 1e-3f);
    }
    rsv_scene_destroy(scene);
}

static void the_furnace_faces_inwards(void **state)
{
    rsv_scene *scene = builtin(*state, "furnace");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->triangle_count, 12);
    for (size_t t = 0; t < 12; t++)
        assert_true(
            v3_dot(geometric_normal(view, t), v3_sub(v3(0.5f, 0.5f, 0.5f), centroid(view, t))) > 0);
    assert_float_equal(view->material[0].emission.r, 1 / RSV_PI, 1e-7f);
    rsv_scene_destroy(scene);
}

static void the_two_rooms_share_floor_and_ceiling(void **state)
{
    rsv_scene *scene = builtin(*state, "two-rooms");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    size_t floor = 0, ceiling = 0, lamp_in_left_room = 0;
    for (size_t t = 0; t < view->triangle_count; t++) {
        floor += !strcmp(object_of(view, t), "floor");
        ceiling += !strcmp(object_of(view, t), "ceiling");
        lamp_in_left_room += !strcmp(object_of(view, t), "lamp") && centroid(view, t).x < 0;
        const rsv_material *m = &view->material[view->triangle_material[t]];
        assert_true(m->metallic == 0 && m->roughness == 1 && m->specular == 0);
    }
    assert_int_equal(floor, 2);
    assert_int_equal(ceiling, 2);
    assert_int_equal(lamp_in_left_room, 0);
    assert_true(view->camera[0].position.x < 0);
    rsv_scene_destroy(scene);
}

static void the_foggy_rooms_have_fog_and_a_lamp_behind_the_door(void **state)
{
    rsv_scene *scene = builtin(*state, "fog-rooms");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_true(view->fog && view->fog->extinction.g > 0 && view->fog->albedo.g < 1);
    assert_int_equal(view->light_count, 1);
    assert_true(view->light[0].position.x > 0 && view->camera[0].position.x < 0);
    rsv_scene_destroy(scene);
}

/// Six times the volume that an object encloses: positive where it faces outwards.
static double volume_of(const rsv_scene_view *view, const char *object)
{
    double volume = 0;
    for (size_t t = 0; t < view->triangle_count; t++) {
        const uint32_t *k = view->triangle[t];
        if (strcmp(object_of(view, t), object) != 0) continue;
        rsv_vec3 a = view->position[k[0]], b = view->position[k[1]], c = view->position[k[2]];
        volume += (double)v3_dot(a, v3_cross(b, c));
    }
    return volume;
}

static void the_milk_fills_its_glass(void **state)
{
    rsv_scene *scene = builtin(*state, "milk");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    double milk = volume_of(view, "milk") / 6, glass = volume_of(view, "tumbler") / 6;
    double expected = M_PI * 0.0332 * 0.0332 * (0.1 - 0.0078);
    assert_float_equal(milk, expected, 2e-3 * expected);
    expected = M_PI * (0.036 * 0.036 * 0.13 - 0.033 * 0.033 * 0.122);
    assert_float_equal(glass, expected, 2e-3 * expected);
    rsv_scene_destroy(scene);
}

static double area_of(const rsv_scene_view *view)
{
    double area = 0;
    for (size_t t = 0; t < view->triangle_count; t++) {
        const uint32_t *k = view->triangle[t];
        rsv_vec3 a = view->position[k[0]], b = view->position[k[1]], c = view->position[k[2]];
        area += 0.5 * (double)v3_length(v3_cross(v3_sub(b, a), v3_sub(c, a)));
    }
    return area;
}

static void terraces_grow_and_keep_their_detail(void **state)
{
    const double sizes[] = { 3e4, 1e5, 3e5 };
    const char *const names[] = { "terraces:30000", "terraces:1e5", "terraces:3e5" };
    for (int i = 0; i < 3; i++) {
        rsv_scene *scene = builtin(*state, names[i]);
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        assert_float_equal(view->triangle_count / sizes[i], 1, 0.08);
        // squares of 25 cm, nothing twice and nothing missing: wells and pyramids close over the streets
        assert_float_equal(area_of(view) / view->triangle_count, 0.03125, 1e-4);
        double plan = 0;
        for (size_t t = 0; t < view->triangle_count; t++)
            plan += 0.03125 * (double)geometric_normal(view, t).y;
        rsv_vec3 size = v3_sub(view->bounds_max, view->bounds_min);
        assert_true(plan <= (double)(size.x * size.z) * 1.0001);
        assert_float_equal(fmod(plan, 100), 0, 0.01); // whole blocks
        rsv_scene_destroy(scene);
    }
}

static void every_room_of_the_gallery_has_its_lights(void **state)
{
    rsv_scene *scene = builtin(*state, "gallery:11");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    size_t panels = 0;
    for (size_t t = 0; t < view->triangle_count; t++)
        panels += !strcmp(object_of(view, t), "panel");
    assert_int_equal(panels, 2 * 11);
    assert_int_equal(view->light_count, 3 * 11);
    assert_float_equal(view->bounds_max.x - view->bounds_min.x, 11 * 6 + 0.44f, 1e-3f);
    rsv_scene_destroy(scene);
}

static void exhaustion_is_an_error_and_leaks_nothing(void **state)
{
    fixture *f = *state;
    const char *const names[] = { "two-rooms", "cornell-spheres", "gallery:1", "terraces:5000",
        "fog-rooms", "milk" };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        size_t alive = f->allocations_alive;
        rsv_scene *scene = NULL;
        rsv_status status = RSV_ERROR_MEMORY;
        for (size_t allowed = 0; status == RSV_ERROR_MEMORY; allowed++) {
            f->allocations_left = allowed;
            status = rsv_scene_builtin(f->context, names[i], &scene);
            if (status == RSV_ERROR_MEMORY) assert_int_equal(f->allocations_alive, alive);
        }
        assert_int_equal(status, RSV_OK);
        f->allocations_left = SIZE_MAX;
        rsv_scene_destroy(scene);
    }
}

#define SCENE_TEST(function)                                                                       \
    cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        SCENE_TEST(mirroring_keeps_the_authored_front),
        SCENE_TEST(normals_follow_the_inverse_transpose),
        SCENE_TEST(tiny_transforms_keep_normals),
        SCENE_TEST(missing_normals_make_flat_triangles),
        SCENE_TEST(unusable_normals_become_geometric),
        SCENE_TEST(degenerate_triangles_get_one_warning),
        SCENE_TEST(singular_transforms_are_skipped_by_name),
        SCENE_TEST(a_scale_of_zero_across_a_flat_mesh_shows_it),
        SCENE_TEST(a_scale_of_zero_across_a_body_skips_it),
        SCENE_TEST(bad_meshes_are_refused),
        SCENE_TEST(a_transform_beyond_float_is_refused),
        SCENE_TEST(an_empty_scene_is_refused),
        SCENE_TEST(a_committed_scene_is_closed),
        SCENE_TEST(values_out_of_range_are_clamped_by_name),
        SCENE_TEST(bad_lights_and_cameras_are_refused),
        SCENE_TEST(the_framing_camera_shows_everything),
        SCENE_TEST(look_at_is_right_handed_even_straight_down),
        SCENE_TEST(the_cornell_box_is_the_published_one),
        SCENE_TEST(glass_spheres_are_closed_fine_and_apart),
        SCENE_TEST(the_furnace_faces_inwards),
        SCENE_TEST(the_two_rooms_share_floor_and_ceiling),
        SCENE_TEST(the_foggy_rooms_have_fog_and_a_lamp_behind_the_door),
        SCENE_TEST(the_milk_fills_its_glass),
        SCENE_TEST(terraces_grow_and_keep_their_detail),
        SCENE_TEST(every_room_of_the_gallery_has_its_lights),
        SCENE_TEST(exhaustion_is_an_error_and_leaks_nothing),
    };
    const struct CMUnitTest slow[] = {
        SCENE_TEST(builtin_scenes_are_sound),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
