/// The wide hierarchy: boxes contain everything below them, and rays hit the same triangles as with the tracer.
#include "bvh/bvh_trace.h"
#include "light_fixture.h"
#include "surface/surface.h"

static rsv_vec3 random_in_box(rsv_random *random, rsv_vec3 low, rsv_vec3 high)
{
    float x = rsv_random_float(random), y = rsv_random_float(random), z = rsv_random_float(random);
    return v3(
        low.x + x * (high.x - low.x), low.y + y * (high.y - low.y), low.z + z * (high.z - low.z));
}

static rsv_vec3 random_direction(rsv_random *random)
{
    float x = rsv_random_float(random);
    return rsv_square_to_sphere(x, rsv_random_float(random));
}

/// Loose triangles of any orientation in a cube.
typedef struct soup {
    world *world; ///< for its context alone
    rsv_vec3 *position;
    uint32_t (*triangle)[3];
    uint32_t count;
    rsv_bvh bvh;
} soup;

static soup soup_of(uint32_t count, int threads)
{
    soup s = { .world = world_begin(threads), .count = count };
    s.position = calloc(3 * (size_t)count + 1, sizeof *s.position);
    s.triangle = calloc((size_t)count + 1, sizeof *s.triangle);
    assert_true(s.position && s.triangle);
    for (uint32_t k = 0; k < 3 * count; k++)
        s.triangle[k / 3][k % 3] = k;
    return s;
}

static void soup_build(soup *s)
{
    assert_int_equal(rsv_bvh_build(s->world->context, s->position,
                         (const uint32_t(*)[3])s->triangle, s->count, &s->bvh),
        RSV_OK);
}

static void soup_end(soup *s)
{
    rsv_bvh_destroy(&s->bvh);
    free(s->position);
    free(s->triangle);
    world_end(s->world);
}

static soup random_soup(uint32_t count, float size, int threads, uint32_t seed)
{
    soup s = soup_of(count, threads);
    rsv_random random = rsv_random_from(seed, count, 1);
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 at = random_in_box(&random, v3(-1, -1, -1), v3(1, 1, 1));
        float extent = size * powf(rsv_random_float(&random), 3);
        for (uint32_t c = 0; c < 3; c++)
            s.position[3 * k + c] = random_in_box(&random, v3_sub(at, v3(extent, extent, extent)),
                v3_add(at, v3(extent, extent, extent)));
    }
    soup_build(&s);
    return s;
}

// ---- structure ----------------------------------------------------------------------------------

typedef struct stored_box {
    double low[3], high[3];
} stored_box;

static uint32_t byte_of(const uint32_t word[2], int k) { return word[k / 4] >> 8 * (k % 4) & 255; }

static stored_box box_of_child(const rsv_bvh_node *node, int k)
{
    stored_box box;
    for (int axis = 0; axis < 3; axis++) {
        double step = ldexp(1, (int)(node->exponents >> 8 * axis & 255) - 127);
        box.low[axis] = node->origin[axis] + step * byte_of(node->low[axis], k);
        box.high[axis] = node->origin[axis] + step * byte_of(node->high[axis], k);
    }
    return box;
}

static void check_inside(rsv_vec3 p, const stored_box *box)
{
    const float place[3] = { p.x, p.y, p.z };
    for (int axis = 0; axis < 3; axis++)
        assert_true(place[axis] >= box->low[axis] && place[axis] <= box->high[axis]);
}

/// What a walk through all nodes has found.
typedef struct walk {
    const rsv_bvh_view *bvh;
    uint32_t *met; ///< [triangle_count] times
    uint32_t nodes;

} walk;

/// @param box [depth] of the node and all above it
static void check_node(walk *w, uint32_t index, stored_box *box, int depth)
{
    const rsv_bvh_node *node = &w->bvh->node[index];
    uint32_t inner = 0;
    assert_true(depth <= RSV_BVH_DEPTH);
    w->nodes++;
    for (int k = 0; k < 8; k++) {
        uint32_t meta = byte_of(node->meta, k);
        assert_int_equal(node->exponents >> (24 + k) & 1, (meta & 31) >= 24);
        if (meta == 0) continue;
        box[depth] = box_of_child(node, k);
        if ((meta & 31) >= 24) {
            assert_int_equal(meta, 32 | (24 + k));
            check_node(w, node->first_child + inner++, box, depth + 1);
            continue;
        }
        for (uint32_t n = 0; n < 3; n++) {
            if (!(meta >> (5 + n) & 1)) continue;
            const rsv_bvh_triangle *t = &w->bvh->triangle[node->first_triangle + (meta & 31) + n];
            w->met[t->index]++;
            for (int level = 0; level <= depth; level++) {
                check_inside(t->a, &box[level]);
                check_inside(t->b, &box[level]);
                check_inside(t->c, &box[level]);
            }
        }
    }
}

static void check_structure(const rsv_bvh_view *bvh)
{
    stored_box box[RSV_BVH_DEPTH + 1];
    walk w = { .bvh = bvh, .met = calloc(bvh->triangle_count, sizeof *w.met) };
    assert_non_null(w.met);
    check_node(&w, 0, box, 0);
    assert_int_equal(w.nodes, bvh->node_count);
    for (uint32_t k = 0; k < bvh->triangle_count; k++)
        assert_int_equal(w.met[k], 1);
    free(w.met);
}

static void boxes_hold_the_triangles_below_them(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 40; n++) {
        soup s = random_soup(1 + n * n % 500, n % 3 ? 0.1f : 1, 1, n);
        check_structure(&s.bvh.view);
        soup_end(&s);
    }
}

/// Sizes and places that the heuristic peels apart one by one.
static void no_path_is_longer_than_the_stack(void **state)
{
    (void)state;
    soup s = soup_of(3000, 1);
    for (uint32_t k = 0; k < s.count; k++) {
        float at = ldexpf(1, (int)(k % 250) - 125) * (1 + (float)(k / 250) * 1e-3f);
        s.position[3 * k] = v3(at, -at, at);
        s.position[3 * k + 1] = v3(1.01f * at, -at, at);
        s.position[3 * k + 2] = v3(at, -at, 1.01f * at);
    }
    soup_build(&s);
    check_structure(&s.bvh.view);
    soup_end(&s);
}

static void triangles_in_one_place_are_all_kept(void **state)
{
    (void)state;
    soup s = soup_of(200, 1);
    for (uint32_t k = 0; k < 3 * s.count; k++)
        s.position[k] = v3((float)(k % 3 == 1), (float)(k % 3 == 2), 0.5f);
    soup_build(&s);
    check_structure(&s.bvh.view);
    rsv_hit hit;
    const rsv_ray ray = { v3(0.2f, 0.3f, 2), v3(0, 0, -1), INFINITY };
    assert_true(rsv_bvh_closest(&s.bvh.view, &ray, &hit));
    assert_true(hit.t == 1.5f && fabsf(hit.u - 0.2f) < 1e-6f && fabsf(hit.v - 0.3f) < 1e-6f);
    soup_end(&s);
}

static void same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    soup one = random_soup(20000, 0.05f, 1, 3), three = random_soup(20000, 0.05f, 3, 3);
    const rsv_bvh_view *a = &one.bvh.view, *b = &three.bvh.view;
    assert_int_equal(a->node_count, b->node_count);
    assert_memory_equal(a->node, b->node, a->node_count * sizeof *a->node);
    assert_memory_equal(a->triangle, b->triangle, a->triangle_count * sizeof *a->triangle);
    assert_true(a->node_count < a->triangle_count / 3); // nodes are well filled
    soup_end(&one);
    soup_end(&three);
}

static void a_failed_allocation_leaves_nothing(void **state)
{
    (void)state;
    for (long k = 0;; k++) {
        soup s = random_soup(50, 0.1f, 1, 1);
        rsv_bvh again;
        s.world->until_failure = k;
        rsv_status status = rsv_bvh_build(
            s.world->context, s.position, (const uint32_t(*)[3])s.triangle, s.count, &again);
        s.world->until_failure = -1;
        if (status == RSV_OK) rsv_bvh_destroy(&again);
        soup_end(&s);
        if (status == RSV_OK) return;
        assert_int_equal(status, RSV_ERROR_MEMORY);
    }
}

// ---- rays ---------------------------------------------------------------------------------------

static void nothing_and_one_triangle(void **state)
{
    (void)state;
    rsv_hit hit;
    const rsv_ray ray = { v3(0.25f, 0.25f, 1), v3(0, 0, -2), 0.51f };
    soup none = soup_of(0, 1), one = soup_of(1, 1);
    soup_build(&none);
    assert_false(rsv_bvh_closest(&none.bvh.view, &ray, &hit));
    assert_int_equal(hit.triangle, RSV_NONE);
    assert_false(rsv_bvh_occluded(&none.bvh.view, &ray));
    one.position[1] = v3(1, 0, 0);
    one.position[2] = v3(0, 1, 0);
    soup_build(&one);
    assert_true(rsv_bvh_closest(&one.bvh.view, &ray, &hit));
    assert_true(hit.triangle == 0 && hit.t == 0.5f && hit.u == 0.25f && hit.v == 0.25f);
    const rsv_ray falls_short = { ray.origin, ray.direction, 0.49f },
                  unused = { ray.origin, ray.direction, -1 };
    assert_false(rsv_bvh_occluded(&one.bvh.view, &falls_short));
    assert_false(rsv_bvh_occluded(&one.bvh.view, &unused));
    const rsv_ray in_plane = { v3(-1, 0.25f, 0), v3(1, 0, 0), INFINITY };
    assert_false(rsv_bvh_occluded(&one.bvh.view, &in_plane));
    soup_end(&none);
    soup_end(&one);
}

static void degenerate_triangles_give_finite_answers(void **state)
{
    (void)state;
    soup s = random_soup(300, 0.3f, 1, 9);
    for (uint32_t k = 0; k < s.count; k++) {
        rsv_vec3 *p = &s.position[3 * k];
        if (k % 3 == 0) p[2] = p[1] = p[0];
        if (k % 3 == 1) p[2] = p[0];
        if (k % 3 == 2) p[2] = v3_mad(p[0], 0.37f, v3_sub(p[1], p[0]));
    }
    rsv_bvh_destroy(&s.bvh);
    soup_build(&s);
    check_structure(&s.bvh.view);
    rsv_random random = rsv_random_from(6, 6, 6);
    for (int n = 0; n < 20000; n++) {
        rsv_vec3 to = s.position[(uint32_t)(rsv_random_float(&random) * 3 * (float)s.count)];
        rsv_ray ray = { random_in_box(&random, v3(-2, -2, -2), v3(2, 2, 2)), { 0, 0, 0 },
            INFINITY };
        ray.direction = v3_sub(to, ray.origin);
        rsv_hit hit;
        if (!rsv_bvh_closest(&s.bvh.view, &ray, &hit)) continue;
        assert_true(hit.t > 0 && isfinite(hit.t));
        assert_true(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1.00001f);
    }
    soup_end(&s);
}

/// Hits of both kinds of tracing, and how often they differ.
typedef struct duel {
    const rsv_tracer *tracer;
    const rsv_bvh_view *bvh;
    float
        rounding; ///< of distances: a few last places of the scene's coordinates, at grazing angles more
    uint32_t hits, differ;
} duel;

/// Two surfaces at one distance may change places.
static void compare_ray(duel *d, const rsv_ray *ray)
{
    rsv_hit a, b;
    bool found = rsv_tracer_closest(d->tracer, ray, &a), met = rsv_bvh_closest(d->bvh, ray, &b);
    d->hits += found;
    assert_int_equal(met, b.triangle != RSV_NONE);
    assert_int_equal(rsv_bvh_occluded(d->bvh, ray), met);
    if (found != met) {
        d->differ++;
    } else if (met && fabsf(a.t - b.t) > 1e-5f * b.t + d->rounding) {
        d->differ++;
    } else if (met && a.triangle == b.triangle) {
        assert_close(a.u, b.u, 1e-3);
        assert_close(a.v, b.v, 1e-3);
    }
}

/// Rays from within a box. Closes the world. @param least share of rays that must meet something
static void check_rays(world *w, rsv_vec3 low, rsv_vec3 high, uint32_t rays, float least)
{
    rsv_bvh bvh;
    duel d = { .bvh = &bvh.view };
    assert_int_equal(rsv_tracer_create(w->scene, &w->tracer), RSV_OK);
    assert_int_equal(rsv_bvh_build_scene(w->scene, &bvh), RSV_OK);
    d.tracer = w->tracer;
    d.rounding = 4e-6f * rsv_scene_extent(rsv_scene_get_view(w->scene));
    rsv_random random = rsv_random_from(7, 7, rays);
    for (uint32_t n = 0; n < rays; n++) {
        rsv_ray ray = { random_in_box(&random, low, high), random_direction(&random),
            n % 4 ? INFINITY : 0.3f };
        if (n % 8 == 1)
            ray.direction = v3((float)(n % 3 == 0), (float)(n % 3 == 1), -(float)(n % 3 == 2));
        if (n % 8 == 2) ray.direction.x = 0;
        if (n % 8 == 3) ray.direction = v3_scale(ray.direction, 100 * rsv_random_float(&random));
        compare_ray(&d, &ray);
    }
    assert_true((float)d.hits > least * (float)rays);
    assert_int_equal(d.differ, 0);
    rsv_bvh_destroy(&bvh);
    world_end(w);
}

static void check_scene(const char *name, uint32_t rays)
{
    world *w = world_builtin(2, name);
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    check_rays(w, view->bounds_min, view->bounds_max, rays, 1.0f / 3);
}

static void rays_meet_what_the_tracer_meets(void **state)
{
    (void)state;
    check_scene("cornell-blocks", 20000);
    check_scene("cornell-spheres", 20000);
    check_scene("two-rooms", 20000);
    check_scene("gallery:3", 20000);
    check_scene("terraces:1e4", 20000);
}

/// Rays from inside at the edges and corners of a closed body: none escapes.
static void closed_bodies_are_tight(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-spheres");
    rsv_bvh bvh;
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    uint32_t object = 0, tested = 0;
    rsv_vec3 centre = v3(0, 0, 0);
    float corners = 0;
    while (strcmp(view->object_name[object], "front sphere") != 0)
        object++;
    for (size_t t = 0; t < view->triangle_count; t++)
        for (int c = 0; c < 3 && view->triangle_object[t] == object; c++, corners++)
            centre = v3_add(centre, view->position[view->triangle[t][c]]);
    assert_int_equal(rsv_bvh_build_scene(w->scene, &bvh), RSV_OK);
    rsv_random random = rsv_random_from(8, 8, 8);
    for (size_t t = 0; t < view->triangle_count; t++) {
        if (view->triangle_object[t] != object) continue;
        const uint32_t *corner = view->triangle[t];
        for (int n = 0; n < 6; n++) {
            rsv_vec3 a = view->position[corner[n % 3]], b = view->position[corner[(n + 1) % 3]];
            rsv_vec3 at = n < 3 ? a : v3_mad(a, rsv_random_float(&random), v3_sub(b, a));
            rsv_ray ray = { v3_scale(centre, 1 / corners), { 0, 0, 0 }, INFINITY };
            ray.direction = v3_sub(at, ray.origin);
            rsv_hit hit;
            assert_true(rsv_bvh_closest(&bvh.view, &ray, &hit));
            assert_close(hit.t, 1, 1e-4);
            tested++;
        }
    }
    assert_true(tested > 1000);
    rsv_bvh_destroy(&bvh);
    world_end(w);
}

/// As for the tracer: a ray that leaves a triangle from its offset origin does not hit it again.
static void rays_that_leave_a_surface_do_not_hit_it_again(void **state)
{
    (void)state;
    const float scale[] = { 1e-3f, 1, 1e4f };
    for (int k = 0; k < 3; k++) {
        soup s = random_soup(60, 1, 1, 5);
        rsv_vec3 shift = v3(scale[k], -0.7f * scale[k], 0.4f * scale[k]);
        for (uint32_t n = 0; n < 3 * s.count; n++)
            s.position[n] = v3_mad(shift, scale[k], s.position[n]);
        rsv_bvh_destroy(&s.bvh);
        soup_build(&s);
        rsv_random random = rsv_random_from(3, 3, 3);
        for (uint32_t n = 0; n < 20000; n++) {
            const rsv_vec3 *p = &s.position[3 * (n % s.count)];
            float u, v, x = rsv_random_float(&random);
            rsv_square_to_triangle(x, rsv_random_float(&random), &u, &v);
            rsv_vec3 normal = v3_normalize(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])));
            rsv_vec3 direction = random_direction(&random);
            if (v3_dot(direction, normal) < 0) normal = v3_neg(normal);
            float extent = f_max(v3_max_abs(p[0]), f_max(v3_max_abs(p[1]), v3_max_abs(p[2])));
            rsv_vec3 origin =
                rsv_offset_origin(v3_barycentric(p[0], p[1], p[2], u, v), normal, extent);
            const rsv_ray ray = { origin, direction, INFINITY };
            rsv_hit hit;
            if (rsv_bvh_closest(&s.bvh.view, &ray, &hit))
                assert_int_not_equal(hit.triangle, n % s.count);
        }
        soup_end(&s);
    }
}

/// The same holes: some rays pass the lattice, some do not.
static void rays_pass_where_a_surface_is_cut_out(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_lattice(w, v3(-1, 1, 0), v3(-1, -1, 0), v3(1, -1, 0), v3(1, 1, 0));
    world_lattice(w, v3(-1, 1, -1), v3(-1, -1, -1.2f), v3(1, -1, -1), v3(1, 1, -1.1f));
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    check_rays(w, v3(-1, -1, -2), v3(1, 1, 1), 20000, 1.0f / 12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_hold_the_triangles_below_them),
        cmocka_unit_test(no_path_is_longer_than_the_stack),
        cmocka_unit_test(triangles_in_one_place_are_all_kept),
        cmocka_unit_test(same_bytes_for_any_thread_count),
        cmocka_unit_test(a_failed_allocation_leaves_nothing),
        cmocka_unit_test(nothing_and_one_triangle),
        cmocka_unit_test(degenerate_triangles_give_finite_answers),
        cmocka_unit_test(rays_meet_what_the_tracer_meets),
        cmocka_unit_test(closed_bodies_are_tight),
        cmocka_unit_test(rays_that_leave_a_surface_do_not_hit_it_again),
        cmocka_unit_test(rays_pass_where_a_surface_is_cut_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
