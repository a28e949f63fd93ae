/// Polygonised fields are closed and lie on their surface; built-in scenes place bodies where they should be.
#include "builtin/body.h"
#include "unit/scene_fixture.h"
#include "unit/slow_tests.h"

#include "core/index_map.h"

#define RADIUS 0.7f

static float sphere(rsv_vec3 p) { return v3_dot(p, p) - RADIUS * RADIUS; }

/// Every edge belongs to two triangles, which run along it in opposite directions.
static bool is_closed(rsv_context *context, const uint32_t *index, size_t triangle_count)
{
    rsv_index_map edges;
    assert_int_equal(rsv_index_map_create(context, 3 * triangle_count, &edges), RSV_OK);
    bool closed = true;
    for (size_t i = 0; i < 3 * triangle_count; i++) {
        uint64_t from = index[i], to = index[i / 3 * 3 + (i + 1) % 3];
        closed &= rsv_index_map_insert(&edges, from << 32 | to, (uint32_t)i) == i;
    }
    for (size_t i = 0; i < 3 * triangle_count; i++) {
        uint64_t from = index[i], to = index[i / 3 * 3 + (i + 1) % 3];
        closed &= rsv_index_map_find(&edges, to << 32 | from) != UINT32_MAX;
    }
    rsv_index_map_destroy(&edges);
    return closed;
}

static void an_isosurface_is_closed_and_where_the_field_vanishes(void **state)
{
    fixture *f = *state;
    rsv_isosurface s;
    assert_int_equal(
        rsv_isosurface_create(f->context, sphere, v3(-1, -1, -1), v3(1, 1, 1), 30, &s), RSV_OK);
    assert_true(is_closed(f->context, s.index, s.triangle_count));
    double area = 0;
    for (size_t i = 0; i < s.vertex_count; i++) {
        assert_float_equal(v3_length(s.position[i]), RADIUS, 1e-5f);
        assert_float_equal(v3_dot(s.normal[i], s.position[i]), RADIUS, 1e-4f);
    }
    for (size_t t = 0; t < s.triangle_count; t++) {
        rsv_vec3 a = s.position[s.index[3 * t]], b = s.position[s.index[3 * t + 1]],
                 c = s.position[s.index[3 * t + 2]];
        rsv_vec3 normal = v3_cross(v3_sub(b, a), v3_sub(c, a));
        assert_true(v3_dot(normal, a) > 0);
        area += 0.5 * (double)v3_length(normal);
    }
    // chords of length h cut off a share of about (h / r)^2 / 8
    assert_true(fabs(area / (4 * 3.14159265 * RADIUS * RADIUS) - 1) < 2e-3);
    rsv_isosurface_release(f->context, &s);
}

static void stand_ins_are_closed_and_of_the_wanted_size(void **state)
{
    fixture *f = *state;
    const rsv_sculpture sculpture[] = { rsv_sculpture_knot(), rsv_sculpture_bust() };
    for (int i = 0; i < 2; i++) {
        rsv_isosurface s;
        assert_int_equal(rsv_isosurface_of_size(f->context, sculpture[i].field, sculpture[i].low,
                             sculpture[i].high, 9000, &s),
            RSV_OK);
        assert_true(is_closed(f->context, s.index, s.triangle_count));
        assert_true(s.triangle_count > 8000 && s.triangle_count < 10000);
        rsv_isosurface_release(f->context, &s);
    }
}

static const rsv_vec3 corner[4] = { { 10, 10, 10 }, { 14, 10, 10 }, { 10, 18, 10 },
    { 10, 10, 12 } };
static const uint32_t outwards[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };

/// A tetrahedron, its triangles turned inwards if so wanted.
static rsv_scene *tetrahedron(fixture *f, bool inwards)
{
    rsv_scene *scene;
    uint32_t index[12], id;
    const rsv_material material = rsv_default_material();
    for (int i = 0; i < 12; i++)
        index[i] = outwards[inwards ? i / 3 * 3 + 2 - i % 3 : i];
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    scene->is_part = true;
    assert_int_equal(rsv_scene_add_material(scene, &material, &id), RSV_OK);
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 4,
        .material = id };
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, NULL, NULL), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

static void a_given_body_stands_on_the_floor_and_faces_outwards(void **state)
{
    fixture *f = *state;
    for (int inwards = 0; inwards < 2; inwards++) {
        rsv_scene *body = tetrahedron(f, inwards), *scene = NULL;
        rsv_builtin_desc desc = rsv_default_builtin_desc();
        desc.body = body;
        assert_int_equal(
            rsv_scene_builtin_with(f->context, "cornell-glass", &desc, &scene), RSV_OK);
        rsv_scene_destroy(body);
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        rsv_vec3 low = v3(9, 9, 9), high = v3(-9, -9, -9), middle = v3(0, 0, 0);
        size_t first = view->triangle_count - 4;
        for (size_t t = first; t < view->triangle_count; t++) {
            assert_string_equal(object_of(view, t), "glass");
            middle = v3_mad(middle, 0.25f, centroid(view, t));
            for (int k = 0; k < 3; k++) {
                low = v3_min(low, view->position[view->triangle[t][k]]);
                high = v3_max(high, view->position[view->triangle[t][k]]);
            }
        }
        assert_float_equal(low.y, 1e-4f, 1e-6f);
        assert_float_equal(high.y - low.y, 0.36f, 1e-5f); // the tightest side of the box given
        assert_float_equal(high.x - low.x, 0.18f, 1e-5f);
        assert_float_equal((high.x + low.x) / 2, -0.276f, 1e-5f);
        for (size_t t = first; t < view->triangle_count; t++) {
            rsv_vec3 away = v3_sub(centroid(view, t), middle);
            assert_true(v3_dot(geometric_normal(view, t), away) > 0);
        }
        rsv_scene_destroy(scene);
    }
}

static void wrong_wishes_are_refused(void **state)
{
    fixture *f = *state;
    rsv_scene *body = tetrahedron(f, false), *scene = NULL;
    rsv_builtin_desc desc = { .size = sizeof desc, .body = body, .body_triangles = 1000 };
    assert_int_equal(
        rsv_scene_builtin_with(f->context, "furnace", &desc, &scene), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "takes no mesh");
    desc.body_triangles = 5;
    assert_int_equal(
        rsv_scene_builtin_with(f->context, "character", &desc, &scene), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(body);
}

static void exhaust(fixture *f, size_t stride)
{
    rsv_scene *scene = NULL;
    rsv_builtin_desc desc = { .size = sizeof desc, .body_triangles = 200 };
    for (size_t allowed = 0; !scene; allowed += stride) {
        f->allocations_left = allowed;
        rsv_status status = rsv_scene_builtin_with(f->context, "cornell-marble", &desc, &scene);
        if (status != RSV_OK) assert_int_equal(status, RSV_ERROR_MEMORY);
    }
    f->allocations_left = SIZE_MAX;
    rsv_scene_destroy(scene);
}

static void exhaustion_is_an_error_and_leaks_nothing(void **state) { exhaust(*state, 3); }

/// What the sanitizers see of it.
static void memory_may_run_out_here_and_there(void **state) { exhaust(*state, 31); }

int main(int argc, char **argv)
{
#define CASE(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)
    const struct CMUnitTest quick[] = {
        CASE(an_isosurface_is_closed_and_where_the_field_vanishes),
        CASE(stand_ins_are_closed_and_of_the_wanted_size),
        CASE(a_given_body_stands_on_the_floor_and_faces_outwards),
        CASE(wrong_wishes_are_refused),
        CASE(memory_may_run_out_here_and_there),
    };
    const struct CMUnitTest slow[] = {
        CASE(exhaustion_is_an_error_and_leaks_nothing),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
