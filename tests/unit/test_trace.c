/// Rays: packets against single rays, offsets at all scales, the nearest surface point.
#include "elements/elements.h"
#include "light_fixture.h"
#include "scene/scene.h"
#include "trace/tracer_update.h"

static rsv_vec3 random_in_cube(rsv_random *random, float half)
{
    float x = rsv_random_float(random), y = rsv_random_float(random), z = rsv_random_float(random);
    return v3(half * (2 * x - 1), half * (2 * y - 1), half * (2 * z - 1));
}

static rsv_vec3 random_direction(rsv_random *random)
{
    float x = rsv_random_float(random);
    return rsv_square_to_sphere(x, rsv_random_float(random));
}

/// A room full of loose triangles around `centre`.
static world *triangle_soup(rsv_vec3 centre, float size, uint32_t count)
{
    world *w = world_begin(1);
    rsv_random random = rsv_random_from(count, 1, 2);
    rsv_vec3 *position = calloc(3 * count, sizeof *position);
    assert_non_null(position);
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 at = v3_add(centre, random_in_cube(&random, size));
        for (uint32_t c = 0; c < 3; c++)
            position[3 * k + c] = v3_add(at, random_in_cube(&random, 0.3f * size));
    }
    world_triangles(w, world_lambert(w, 0.5f, 0), position, 3 * count, NULL, count);
    free(position);
    world_commit(w);
    return w;
}

static void set_lane(rsv_ray_packet *packet, int k, const rsv_ray *ray)
{
    packet->origin_x[k] = ray->origin.x;
    packet->origin_y[k] = ray->origin.y;
    packet->origin_z[k] = ray->origin.z;
    packet->direction_x[k] = ray->direction.x;
    packet->direction_y[k] = ray->direction.y;
    packet->direction_z[k] = ray->direction.z;
    packet->t_max[k] = ray->t_max;
    packet->mask[k] = UINT32_MAX;
}

/// Sixteen random rays, some short, some long; every fifth lane is not in use.
static void fill_packet(rsv_random *random, rsv_ray ray[16], rsv_ray_packet *packet)
{
    memset(packet, 0, sizeof *packet);
    for (int k = 0; k < 16; k++) {
        ray[k].origin = random_in_cube(random, 1.5f);
        ray[k].direction = random_direction(random);
        ray[k].t_max = k % 5 == 4 ? -1 : k % 3 ? INFINITY : 0.7f;
        set_lane(packet, k, &ray[k]);
    }
}

static void check_closest(
    const world *w, const rsv_ray ray[16], const rsv_ray_packet *packet, int *hits)
{
    for (int k = 0; k < 16; k++) {
        rsv_hit hit;
        if (ray[k].t_max < 0) continue;
        bool found = rsv_tracer_closest(w->tracer, &ray[k], &hit);
        assert_int_equal(found, hit.triangle != RSV_NONE);
        assert_int_equal(packet->triangle[k], hit.triangle);
        if (!found) continue;
        assert_true(hit.t > 0 && hit.t < ray[k].t_max);
        assert_close(packet->t_max[k], hit.t, 1e-5 * hit.t + 1e-6);
        assert_close(packet->u[k], hit.u, 1e-4);
        assert_close(packet->v[k], hit.v, 1e-4);
        ++*hits;
    }
}

static void check_closest_packets(bool coherent)
{
    world *w = triangle_soup(v3(0, 0, 0), 1, 400);
    rsv_random random = rsv_random_from(1, 1, 1);
    int hits = 0;
    for (int n = 0; n < 300; n++) {
        rsv_ray ray[16];
        rsv_ray_packet packet;
        fill_packet(&random, ray, &packet);
        rsv_tracer_closest_packet(w->tracer, &packet, coherent);
        check_closest(w, ray, &packet, &hits);
    }
    assert_true(hits > 500 && hits < 300 * 13); // the test saw hits and misses
    world_end(w);
}

static void closest_packets_equal_single_rays(void **state)
{
    (void)state;
    check_closest_packets(false);
    check_closest_packets(true);
}

static void occlusion_packets_equal_single_rays(void **state)
{
    (void)state;
    world *w = triangle_soup(v3(0, 0, 0), 1, 400);
    rsv_random random = rsv_random_from(2, 1, 1);
    int blocked = 0;
    for (int n = 0; n < 600; n++) {
        rsv_ray ray[16];
        rsv_ray_packet packet;
        fill_packet(&random, ray, &packet);
        rsv_tracer_occluded_packet(w->tracer, &packet, n & 1);
        for (int k = 0; k < 16; k++) {
            rsv_hit hit;
            if (ray[k].t_max < 0) continue;
            bool occluded = rsv_tracer_occluded(w->tracer, &ray[k]);
            assert_int_equal(occluded, rsv_tracer_closest(w->tracer, &ray[k], &hit));
            assert_int_equal(packet.t_max[k] == -INFINITY, occluded);
            blocked += occluded;
        }
    }
    assert_true(blocked > 1000);
    world_end(w);
}

static void packets_report_the_front_normal(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_quad(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(2, 0, 0), v3(2, 2, 0), v3(0, 2, 0));
    world_commit(w);
    for (int side = -1; side <= 1; side += 2) {
        rsv_ray_packet packet = { 0 };
        const rsv_ray ray = { v3(1, 0.5f, (float)side), v3(0, 0, (float)-side), INFINITY };
        for (int k = 0; k < 16; k++)
            set_lane(&packet, k, &ray);
        rsv_tracer_closest_packet(w->tracer, &packet, true);
        assert_true(packet.normal_z[7] > 0);
        assert_close(packet.normal_x[7], 0, 1e-6);
        assert_close(packet.t_max[7], 1, 1e-6);
    }
    world_end(w);
}

static void distance_counts_in_lengths_of_the_direction(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-1, -1, 0), v3(1, -1, 0), v3(1, 1, 0), v3(-1, 1, 0));
    world_commit(w);
    rsv_hit hit;
    const rsv_ray reaches = { v3(0.1f, 0.2f, 3), v3(0, 0, -2), 1.51f };
    const rsv_ray falls_short = { v3(0.1f, 0.2f, 3), v3(0, 0, -2), 1.49f };
    assert_true(rsv_tracer_closest(w->tracer, &reaches, &hit));
    assert_close(hit.t, 1.5, 1e-6);
    assert_false(rsv_tracer_closest(w->tracer, &falls_short, &hit));
    assert_false(rsv_tracer_occluded(w->tracer, &falls_short));
    world_end(w);
}

/// Rays that leave every triangle of a soup must not hit it again, from any point, in any direction.
static void check_offsets(float coordinate, float size)
{
    world *w = triangle_soup(v3(coordinate, -0.7f * coordinate, 0.4f * coordinate), size, 40);
    const rsv_scene_view *view = w->transport.view;
    rsv_random random = rsv_random_from(3, 3, 3);
    for (uint32_t n = 0; n < 20000; n++) {
        uint32_t triangle = n % (uint32_t)view->triangle_count;
        float u, v, x = rsv_random_float(&random), y = rsv_random_float(&random);
        rsv_square_to_triangle(x, y, &u, &v);
        rsv_surface_point point = rsv_surface_point_at(view, triangle, u, v, n & 1);
        rsv_vec3 direction = random_direction(&random);
        if (v3_dot(direction, point.geometric) < 0) direction = v3_neg(direction);
        rsv_vec3 origin =
            rsv_offset_origin(point.position, point.geometric, rsv_triangle_extent(view, triangle));
        rsv_ray ray = { origin, direction, INFINITY };
        rsv_hit hit;
        if (rsv_tracer_closest(w->tracer, &ray, &hit)) assert_int_not_equal(hit.triangle, triangle);
        float moved = v3_length(v3_sub(origin, point.position));
        assert_true(moved <= 1e-4f * (fabsf(coordinate) + 2 * size)); // not visibly off the surface
    }
    world_end(w);
}

static void rays_that_leave_a_surface_do_not_hit_it_again(void **state)
{
    (void)state;
    check_offsets(1e-3f, 1e-3f);
    check_offsets(0, 1);
    check_offsets(1, 1);
    check_offsets(1e4f, 100);
    check_offsets(1e4f, 1e4f);
}

/// The same from where a ray arrived, which is less exact than a point drawn on the surface.
static void reflected_rays_do_not_hit_the_surface_again(void **state)
{
    (void)state;
    const float coordinate[] = { 1e-3f, 1, 1e4f };
    for (int k = 0; k < 3; k++) {
        rsv_vec3 centre = v3(coordinate[k], coordinate[k], -coordinate[k]);
        world *w = triangle_soup(centre, coordinate[k], 40);
        rsv_random random = rsv_random_from(4, 4, 4);
        for (uint32_t n = 0; n < 20000; n++) {
            rsv_ray ray = { v3_add(centre, random_in_cube(&random, 3 * coordinate[k])),
                random_direction(&random), INFINITY };
            rsv_hit hit, again;
            if (!rsv_tracer_closest(w->tracer, &ray, &hit)) continue;
            rsv_surface_point point =
                rsv_surface_point_at(w->transport.view, hit.triangle, hit.u, hit.v, false);
            float cos = v3_dot(point.geometric, ray.direction);
            rsv_vec3 side = cos > 0 ? v3_neg(point.geometric) : point.geometric;
            rsv_vec3 mirrored = v3_mad(ray.direction, -2 * cos, point.geometric);
            rsv_ray next = { rsv_offset_origin(point.position, side, point.extent), mirrored,
                INFINITY };
            if (rsv_tracer_closest(w->tracer, &next, &again))
                assert_int_not_equal(again.triangle, hit.triangle);
        }
        world_end(w);
    }
}

/// Distance to a triangle by looking at a dense grid of its points.
static float slow_distance(const rsv_scene_view *view, uint32_t triangle, rsv_vec3 p)
{
    const int steps = 60;
    float nearest = INFINITY;
    for (int i = 0; i <= steps; i++)
        for (int j = 0; i + j <= steps; j++) {
            rsv_vec3 q =
                rsv_surface_point_at(view, triangle, (float)i / steps, (float)j / steps, false)
                    .position;
            nearest = f_min(nearest, v3_length(v3_sub(q, p)));
        }
    return nearest;
}

static void nearest_finds_what_a_slow_search_finds(void **state)
{
    (void)state;
    world *w = triangle_soup(v3(0, 0, 0), 1, 12);
    const rsv_scene_view *view = w->transport.view;
    rsv_random random = rsv_random_from(5, 5, 5);
    for (int n = 0; n < 60; n++) {
        rsv_vec3 p = random_in_cube(&random, 2), normal = random_direction(&random);
        float expected = INFINITY;
        for (uint32_t t = 0; t < view->triangle_count; t++) {
            rsv_surface_point point = rsv_surface_point_at(view, t, 0.3f, 0.3f, false);
            if (v3_dot(point.geometric, normal) > 0)
                expected = f_min(expected, slow_distance(view, t, p));
        }
        rsv_hit hit;
        assert_true(rsv_tracer_nearest(w->tracer, p, normal, &hit));
        rsv_surface_point found = rsv_surface_point_at(view, hit.triangle, hit.u, hit.v, false);
        assert_true(v3_dot(found.geometric, normal) > 0);
        assert_close(v3_length(v3_sub(found.position, p)), hit.t, 1e-5);
        // edges are shorter than 1.1, so the grid's points lie 0.02 apart
        assert_true(hit.t <= expected + 1e-5f && hit.t >= expected - 0.02f);
    }
    world_end(w);
}

static void nearest_prefers_the_side_that_the_normal_points_to(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t paint = world_lambert(w, 0.5f, 0);
    world_quad(w, paint, v3(-1, -1, 0), v3(1, -1, 0), v3(1, 1, 0), v3(-1, 1, 0)); // faces +z
    world_quad(w, paint, v3(-1, -1, 1), v3(-1, 1, 1), v3(1, 1, 1), v3(1, -1, 1)); // faces -z
    world_commit(w);
    rsv_hit hit;
    const rsv_vec3 near_floor = v3(0.3f, 0.1f, 0.1f);
    assert_true(rsv_tracer_nearest(w->tracer, near_floor, v3(0, 0, 1), &hit));
    assert_true(hit.triangle < 2);
    assert_close(hit.t, 0.1, 1e-6);
    assert_true(rsv_tracer_nearest(w->tracer, near_floor, v3(0, 0, -1), &hit));
    assert_true(hit.triangle >= 2);
    assert_close(hit.t, 0.9, 1e-6);
    // nothing is seen from the side: any surface will do
    assert_true(rsv_tracer_nearest(w->tracer, near_floor, v3(1, 0, 0), &hit));
    assert_true(hit.triangle < 2);
    world_end(w);
}

// ---- geometry that moves ---------------------------------------------------------------------------

/// Two soups, the second one somewhere.
static world *two_soups(rsv_vec3 offset)
{
    enum { count = 200 };
    rsv_random random = rsv_random_from(9, 1, 1);
    world *w = world_begin(2);
    for (int soup = 0; soup < 2; soup++) {
        rsv_vec3 position[3 * count];
        for (int k = 0; k < 3 * count; k++)
            position[k] = k % 3 ? v3_mad(position[k - k % 3], 0.3f, random_in_cube(&random, 1))
                                : random_in_cube(&random, 1);
        for (int k = 0; k < 3 * count && soup; k++)
            position[k] = v3_add(position[k], offset);
        world_triangles(w, world_lambert(w, 0.5f, 0), position, 3 * count, NULL, count);
    }
    world_commit(w);
    return w;
}

/// The second soup set apart and moved is one that was there from the start, under the numbers that it had.
static void what_moved_is_hit_where_it_is(void **state)
{
    (void)state;
    const rsv_vec3 offset = { 0.4f, -0.3f, 0.2f };
    const bool moves[] = { false, true };
    world *w = two_soups(v3(0, 0, 0)), *fresh = two_soups(offset);
    memcpy(w->scene->position, fresh->scene->position,
        fresh->scene->vertex_count * sizeof *fresh->scene->position);
    assert_int_equal(rsv_tracer_set_apart(w->tracer, moves), RSV_OK);
    assert_int_equal(rsv_tracer_update(w->tracer), RSV_OK);
    rsv_random random = rsv_random_from(4, 1, 1);
    int hits = 0, apart = 0;
    for (int n = 0; n < 300; n++) {
        rsv_ray ray[16];
        rsv_ray_packet packet;
        fill_packet(&random, ray, &packet);
        rsv_tracer_closest_packet(w->tracer, &packet, n & 1);
        check_closest(fresh, ray, &packet, &hits);
        for (int k = 0; k < 16; k++) {
            rsv_hit hit, wanted;
            if (ray[k].t_max < 0) continue;
            bool met = rsv_tracer_closest(w->tracer, &ray[k], &hit);
            assert_int_equal(met, rsv_tracer_closest(fresh->tracer, &ray[k], &wanted));
            assert_int_equal(rsv_tracer_occluded(w->tracer, &ray[k]), met);
            assert_true(!met || hit.triangle == wanted.triangle);
            apart += met && hit.triangle >= 200;
        }
    }
    assert_true(hits > 500 && apart > 100);
    world_end(w);
    world_end(fresh);
}

/// A lamp of many triangles in a room; none or all of it stays where it is.
static void bodies_set_apart_are_hit_where_they_are(void **state)
{
    (void)state;
    for (int all = 0; all < 2; all++) {
        const bool moves[] = { all, true };
        world *w = world_begin(2);
        uint32_t wall = world_lambert(w, 0.5f, 0), lamp = world_lambert(w, 0.5f, 1);
        world_room(w, wall, v3(-3, -3, 0), v3(3, 3, 6));
        world_sphere(w, lamp, v3(0.5f, 0.4f, 1), 0.3f, 1);
        world_commit(w);
        const rsv_ray at_lamp = { { 0.5f, 0.4f, 5 }, { 0, 0, -1 }, INFINITY },
                      at_wall = { { 0.5f, 0.4f, 5 }, { 0, 1, -1 }, INFINITY };
        rsv_hit hit;
        assert_int_equal(rsv_tracer_set_apart(w->tracer, moves), RSV_OK);
        assert_true(rsv_tracer_closest(w->tracer, &at_lamp, &hit));
        assert_true(hit.triangle >= 12 && fabsf(hit.t - 3.7f) < 0.05f);
        assert_true(rsv_tracer_closest(w->tracer, &at_wall, &hit));
        assert_true(hit.triangle < 12);
        world_end(w);
    }
}

#if defined(RSV_TEST_OWN_TRACER)
static void devices_of_embree_are_refused(void **state)
{
    (void)state;
    rsv_context_desc desc = rsv_default_context_desc();
    rsv_context *context;
    rsv_scene *scene;
    rsv_tracer *tracer = NULL;
    desc.embree_device = &desc;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_OK);
    assert_int_equal(rsv_scene_builtin(context, "furnace", &scene), RSV_OK);
    assert_int_equal(rsv_tracer_create(scene, &tracer), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "leave embree_device NULL"));
    assert_null(tracer);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#if defined(RSV_TEST_OWN_TRACER)
        cmocka_unit_test(devices_of_embree_are_refused),
#endif
        cmocka_unit_test(closest_packets_equal_single_rays),
        cmocka_unit_test(occlusion_packets_equal_single_rays),
        cmocka_unit_test(packets_report_the_front_normal),
        cmocka_unit_test(distance_counts_in_lengths_of_the_direction),
        cmocka_unit_test(rays_that_leave_a_surface_do_not_hit_it_again),
        cmocka_unit_test(reflected_rays_do_not_hit_the_surface_again),
        cmocka_unit_test(nearest_finds_what_a_slow_search_finds),
        cmocka_unit_test(nearest_prefers_the_side_that_the_normal_points_to),
        cmocka_unit_test(what_moved_is_hit_where_it_is),
        cmocka_unit_test(bodies_set_apart_are_hit_where_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
