/// Lambert's formula against cubature and closed forms; sampling against density and against
/// Lambert's formula; groups, selection and punctual lights.
#include "sources/lights.h"
#include "sources/punctual_light.h"

#include "core/core.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

typedef struct triangle {
    rsv_vec3 corner[3];
} triangle;

static float uniform(rsv_random *random, float low, float high)
{
    return low + (high - low) * rsv_random_float(random);
}

static rsv_vec3 random_point(rsv_random *random, float extent)
{
    float x = uniform(random, -extent, extent), y = uniform(random, -extent, extent);
    return v3(x, y, uniform(random, -extent, extent));
}

static rsv_vec3 random_direction(rsv_random *random)
{
    float x = rsv_random_float(random);
    return v3_normalize(rsv_square_to_sphere(x, rsv_random_float(random)));
}

static triangle random_triangle(rsv_random *random, float extent)
{
    triangle t;
    for (int i = 0; i < 3; i++)
        t.corner[i] = random_point(random, extent);
    return t;
}

static rsv_vec3 triangle_normal(const triangle *t)
{
    return v3_normalize(
        v3_cross(v3_sub(t->corner[1], t->corner[0]), v3_sub(t->corner[2], t->corner[0])));
}

static rsv_vec3 triangle_centre(const triangle *t)
{
    return v3_barycentric(t->corner[0], t->corner[1], t->corner[2], 1.0f / 3, 1.0f / 3);
}

static double triangle_area(const triangle *t)
{
    return 0.5 * v3_length(v3_cross(
                     v3_sub(t->corner[1], t->corner[0]), v3_sub(t->corner[2], t->corner[0])));
}

/// Cell `index` of the triangle cut into steps^2 equal ones.
static triangle triangle_cell(const triangle *t, int steps, int index)
{
    int row = (int)sqrt(index), column = index - row * row, up = column % 2 == 0, k = column / 2;
    // row r holds 2 r + 1 cells; corners in units of 1 / steps along the two edges from corner 0
    int first[2] = { row - k, k };
    int corners[3][2] = { { first[0], first[1] }, { first[0] + 1, first[1] },
        { first[0], first[1] + 1 } };
    if (!up) {
        corners[0][0] = first[0] - 1, corners[0][1] = first[1] + 1;
        corners[1][0] = first[0], corners[1][1] = first[1];
        corners[2][0] = first[0], corners[2][1] = first[1] + 1;
    }
    triangle cell;
    for (int i = 0; i < 3; i++)
        cell.corner[i] = v3_barycentric(t->corner[0], t->corner[1], t->corner[2],
            (float)corners[i][0] / (float)steps, (float)corners[i][1] / (float)steps);
    return cell;
}

/// cos cos' / d^2 summed over the centroids of steps^2 cells.
static double cubature(const triangle *t, rsv_vec3 p, rsv_vec3 n, int steps)
{
    rsv_vec3 normal = triangle_normal(t);
    double sum = 0;
    for (int i = 0; i < steps * steps; i++) {
        triangle cell = triangle_cell(t, steps, i);
        rsv_vec3 centre = triangle_centre(&cell);
        rsv_vec3 d = v3_sub(centre, p);
        double squared = v3_dot(d, d);
        sum += fmax(v3_dot(n, d), 0) * fabs(v3_dot(normal, d)) / (squared * squared);
    }
    return sum * triangle_area(t) / (steps * steps);
}

static void polygon_irradiance_agrees_with_cubature(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(1, 2, 3);
    for (int i = 0; i < 200; i++) {
        triangle t = random_triangle(&random, 1);
        rsv_vec3 normal = triangle_normal(&t);
        rsv_vec3 p = random_point(&random, 2), n = random_direction(&random);
        if (fabsf(v3_dot(normal, v3_sub(p, t.corner[0]))) < 0.2f) continue;
        double expected = cubature(&t, p, n, 128);
        // midpoint rule with a kink at the horizon: error about (size / steps / height)^2
        assert_float_equal(
            rsv_polygon_irradiance(t.corner, 3, p, n), expected, 1e-3 * expected + 2e-5);
    }
}

/// Projected solid angle of the rectangle [0, a] x [0, b] at height 1 from below its corner.
static double corner_rectangle(double a, double b)
{
    double p = sqrt(1 + a * a), q = sqrt(1 + b * b);
    return 0.5 * (a / p * atan(b / p) + b / q * atan(a / q));
}

static void polygon_irradiance_of_rectangles_is_exact(void **state)
{
    (void)state;
    const float sides[] = { 1e-3f, 0.03f, 0.5f, 1, 7, 200, 1e4f };
    for (size_t i = 0; i < 7; i++)
        for (size_t j = 0; j < 7; j++) {
            float a = sides[i], b = sides[j];
            const rsv_vec3 quad[4] = { v3(0, 0, 1), v3(0, b, 1), v3(a, b, 1), v3(a, 0, 1) };
            double expected = corner_rectangle(a, b);
            double got = rsv_polygon_irradiance(quad, 4, v3(0, 0, 0), v3(0, 0, 1));
            assert_float_equal(got / expected, 1, 5e-7);
            double two = rsv_polygon_irradiance(quad, 3, v3(0, 0, 0), v3(0, 0, 1));
            const rsv_vec3 rest[3] = { quad[0], quad[2], quad[3] };
            two += rsv_polygon_irradiance(rest, 3, v3(0, 0, 0), v3(0, 0, 1));
            assert_float_equal(two / expected, 1, 1e-6);
        }
}

static void polygon_irradiance_is_clipped_at_the_horizon(void **state)
{
    (void)state;
    // upright rectangle that reaches equally far below the receiver's plane: half of it counts
    const rsv_vec3 whole[4] = { v3(1, -2, -3), v3(1, 2, -3), v3(1, 2, 3), v3(1, -2, 3) };
    const rsv_vec3 upper[4] = { v3(1, -2, 0), v3(1, 2, 0), v3(1, 2, 3), v3(1, -2, 3) };
    rsv_vec3 p = v3(0, 0.5f, 0), n = v3(0, 0, 1);
    float expected = rsv_polygon_irradiance(upper, 4, p, n);
    assert_true(expected > 0.1f);
    assert_float_equal(rsv_polygon_irradiance(whole, 4, p, n), expected, 1e-6);
    const rsv_vec3 below[3] = { v3(1, -2, -3), v3(1, 2, -3), v3(1, 2, -1) };
    assert_true(rsv_polygon_irradiance(below, 3, p, n) == 0);
}

/// Solid angles from 1e-4 down to 1e-10 sr, where the point formula is right to second order.
static void polygon_irradiance_keeps_its_digits_far_away(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(4, 5, 6);
    for (int i = 0; i < 500; i++) {
        float size = powf(10, uniform(&random, -5, -3));
        triangle t = random_triangle(&random, size);
        rsv_vec3 n = random_direction(&random);
        rsv_vec3 normal = triangle_normal(&t);
        rsv_vec3 p = v3_scale(random_direction(&random), -1);
        if (v3_dot(n, p) > -0.1f || fabsf(v3_dot(normal, p)) < 0.1f) continue;
        double expected = 0;
        for (int cell = 0; cell < 16; cell++) {
            triangle part = triangle_cell(&t, 4, cell);
            rsv_vec3 centre = triangle_centre(&part);
            double d[3] = { (double)centre.x - p.x, (double)centre.y - p.y,
                (double)centre.z - p.z };
            double squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            double cosines = (n.x * d[0] + n.y * d[1] + n.z * d[2]) *
                             fabs(normal.x * d[0] + normal.y * d[1] + normal.z * d[2]);
            expected += cosines / (squared * squared) * triangle_area(&t) / 16;
        }
        double got = rsv_polygon_irradiance(t.corner, 3, p, n);
        assert_float_equal(got / expected, 1, 1e-5);
    }
}

static void polygon_irradiance_is_finite_in_degenerate_positions(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(7, 8, 9);
    for (int i = 0; i < 2000; i++) {
        triangle t = random_triangle(&random, 3);
        if (i % 4 == 0)
            t.corner[2] = v3_barycentric(t.corner[0], t.corner[1], t.corner[1], 0.5f, 0);
        rsv_vec3 points[] = { t.corner[0], t.corner[2],
            v3_barycentric(t.corner[0], t.corner[1], t.corner[2], 0.5f, 0),
            v3_barycentric(t.corner[0], t.corner[1], t.corner[2], 0.3f, 0.2f),
            v3_barycentric(t.corner[0], t.corner[1], t.corner[2], 2, -0.5f) };
        for (size_t k = 0; k < 5; k++) {
            float own = rsv_polygon_irradiance(t.corner, 3, points[k], triangle_normal(&t));
            float other = rsv_polygon_irradiance(t.corner, 3, points[k], random_direction(&random));
            assert_true(own == 0 && other == 0); // all of them in the plane, up to rounding
        }
    }
    // a hair above a large emitter: it fills the hemisphere
    const rsv_vec3 quad[4] = { v3(0, 0, 0), v3(1, 0, 0), v3(1, 1, 0), v3(0, 1, 0) };
    assert_float_equal(
        rsv_polygon_irradiance(quad, 4, v3(0.5f, 0.5f, 1e-5f), v3(0, 0, -1)), RSV_PI, 1e-6);
}

/// A scene of triangles; object and material of each as given.
static rsv_scene *make_scene(rsv_context *context, const triangle *triangles, size_t count,
    const rsv_rgb *radiance, bool double_sided)
{
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(context, &scene), RSV_OK);
    for (size_t i = 0; i < count; i++) {
        rsv_material material = rsv_default_material();
        material.emission = radiance[i];
        material.double_sided = double_sided;
        uint32_t material_id, mesh_id;
        assert_int_equal(rsv_scene_add_material(scene, &material, &material_id), RSV_OK);
        rsv_mesh_desc mesh = { .size = sizeof mesh,
            .positions = triangles[i].corner,
            .vertex_count = 3,
            .triangle_count = 1,
            .material = material_id };
        assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &mesh_id), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, mesh_id, NULL, NULL), RSV_OK);
    }
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

/// Lights of a scene, with the objects that they borrow.
typedef struct fixture {
    rsv_context *context;
    rsv_scene *scene;
    rsv_bsdf *bsdf;
    rsv_lights *lights;
} fixture;

static void close_fixture(fixture *f)
{
    rsv_lights_destroy(f->lights);
    rsv_free(f->context, f->bsdf);
    rsv_scene_destroy(f->scene);
    rsv_context_destroy(f->context);
}

/// Makes the lights of f->scene.
static void make_lights(fixture *f)
{
    const rsv_scene_view *view = rsv_scene_get_view(f->scene);
    f->bsdf = rsv_alloc(f->context, view->material_count, sizeof *f->bsdf);
    for (size_t i = 0; i < view->material_count; i++)
        f->bsdf[i] = rsv_bsdf_from_material(&view->material[i]);
    assert_int_equal(rsv_lights_create(f->scene, f->bsdf, &f->lights), RSV_OK);
}

/// The emitting triangles beside a large black one that sees little of them: nothing is gathered.
static fixture open_fixture(
    const triangle *triangles, size_t count, rsv_rgb radiance, bool double_sided)
{
    fixture f = { 0 };
    assert_int_equal(rsv_context_create(NULL, &f.context), RSV_OK);
    triangle *all = rsv_alloc(f.context, count + 1, sizeof *all);
    rsv_rgb *radiances = rsv_alloc(f.context, count + 1, sizeof *radiances);
    for (size_t i = 0; i < count; i++) {
        all[i] = triangles[i];
        radiances[i] = rgb_scale(radiance, (float)(1 + i % 3));
    }
    all[count] = (triangle){ { v3(0, -1e4f, 0), v3(1e4f, -1e4f, 0), v3(0, -1e4f, 1e4f) } };
    f.scene = make_scene(f.context, all, count + 1, radiances, double_sided);
    make_lights(&f);
    rsv_free(f.context, all);
    rsv_free(f.context, radiances);
    return f;
}

/// Mean and standard error of luminance * cos / pdf.
static double estimate(
    const rsv_local_lights *local, int samples, rsv_random *random, double *error)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < samples; i++) {
        rsv_light_sample s;
        float u = rsv_random_float(random), u1 = rsv_random_float(random);
        if (!rsv_local_lights_sample(local, u, u1, rsv_random_float(random), &s)) continue;
        assert_float_equal(v3_length(s.direction), 1, 1e-5);
        assert_true(
            s.pdf_solid_angle == rsv_local_lights_pdf(local, s.emitter, s.direction, s.distance));
        double value =
            rgb_luminance(s.radiance) * v3_dot(s.direction, local->normal) / s.pdf_solid_angle;
        sum += value;
        squares += value * value;
    }
    double mean = sum / samples;
    *error = sqrt(fmax(squares / samples - mean * mean, 0) / samples);
    return mean;
}

/// Receivers of all kinds: far, close to the surface, tilted so that the horizon cuts the triangle.
static void sampling_integrates_to_the_polygon_irradiance(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(10, 11, 12);
    for (int i = 0; i < 300; i++) {
        triangle t = random_triangle(&random, 1);
        if (triangle_area(&t) < 0.05) continue;
        fixture f = open_fixture(&t, 1, rgb_gray(2), false);
        float height = powf(10, uniform(&random, -4, 1.5f));
        float u, v;
        rsv_square_to_triangle(rsv_random_float(&random), rsv_random_float(&random), &u, &v);
        rsv_vec3 foot = v3_barycentric(t.corner[0], t.corner[1], t.corner[2], u, v);
        rsv_vec3 p = v3_mad(foot, height, triangle_normal(&t));
        rsv_local_lights local;
        rsv_lights_at(f.lights, p, random_direction(&random), &local);
        double expected = 2 * rsv_polygon_irradiance(t.corner, 3, p, local.normal), error;
        assert_float_equal(rgb_luminance(local.unshadowed), expected, 1e-5 * expected);
        double mean = estimate(&local, 4000, &random, &error);
        rsv_vec3 towards = v3_normalize(v3_sub(triangle_centre(&t), p));
        // if almost nothing is above the horizon, the samples show no variance
        if (expected > 0.02 * rsv_polygon_irradiance(t.corner, 3, p, towards))
            assert_float_equal(mean, expected, 4.5 * error + 1e-5 * expected);
        close_fixture(&f);
    }
}

/// Girard's excess: independent of the arc tangent formula under test.
static double solid_angle(const triangle *t, rsv_vec3 p)
{
    double angle_sum = 0;
    for (int i = 0; i < 3; i++) {
        rsv_vec3 a = v3_sub(t->corner[i], p), b = v3_sub(t->corner[(i + 1) % 3], p),
                 c = v3_sub(t->corner[(i + 2) % 3], p);
        rsv_vec3 ab = v3_normalize(v3_cross(a, b)), ac = v3_normalize(v3_cross(a, c));
        angle_sum += acos(fmax(-1, fmin(1, v3_dot(ab, ac))));
    }
    return angle_sum - 3.14159265358979;
}

/// Index of the cell (see triangle_cell) that a sample lies in.
static int cell_of(const triangle *t, int steps, rsv_vec3 p, const rsv_light_sample *s)
{
    rsv_vec3 normal = triangle_normal(t), point = v3_mad(p, s->distance, s->direction);
    rsv_vec3 offset = v3_sub(point, t->corner[0]);
    rsv_vec3 edge1 = v3_sub(t->corner[1], t->corner[0]), edge2 = v3_sub(t->corner[2], t->corner[0]);
    double scale = steps / (2 * triangle_area(t));
    double u = scale * v3_dot(normal, v3_cross(offset, edge2));
    double v = scale * v3_dot(normal, v3_cross(edge1, offset));
    int row = (int)fmin(fmax(u + v, 0), steps - 1), k = (int)fmin(fmax(v, 0), row);
    bool between = u < row - k;
    return row * row + 2 * k + (between ? 1 : 0);
}

/// Chi-square of 64 cells against the share of each in the measure sampled: solid angle, or area
/// where the triangle looks small.
static void check_cells(const triangle *t, rsv_vec3 p, bool by_area, uint32_t seed)
{
    enum { STEPS = 8, CELLS = STEPS * STEPS, SAMPLES = 40000 };
    fixture f = open_fixture(t, 1, rgb_gray(1), true);
    rsv_local_lights local;
    rsv_lights_at(f.lights, p, v3_normalize(v3_sub(triangle_centre(t), p)), &local);
    rsv_random random = rsv_random_from(seed, 20, 21);
    double count[CELLS] = { 0 }, chi_square = 0;
    int drawn = 0;
    for (int i = 0; i < SAMPLES; i++) {
        rsv_light_sample s;
        float u1 = rsv_random_float(&random), u2 = rsv_random_float(&random);
        if (!rsv_local_lights_sample(&local, 0.5f, u1, u2, &s)) continue;
        count[cell_of(t, STEPS, p, &s)]++;
        drawn++;
    }
    assert_true(drawn > SAMPLES / 2);
    for (int i = 0; i < CELLS; i++) {
        triangle cell = triangle_cell(t, STEPS, i);
        double share = by_area ? 1.0 / CELLS : solid_angle(&cell, p) / solid_angle(t, p);
        chi_square += (count[i] - drawn * share) * (count[i] - drawn * share) / (drawn * share);
    }
    assert_true(chi_square < 115); // 63 degrees of freedom: exceeded with probability 7e-5
    close_fixture(&f);
}

static void samples_fill_the_triangle_evenly(void **state)
{
    (void)state;
    const triangle t = { { v3(0, 0, 0), v3(2, 0.3f, 0), v3(0.5f, 1.5f, 0.4f) } };
    check_cells(&t, v3(0.5f, 0.5f, 3), false, 1);
    check_cells(&t, v3(-1, 1, 1), false, 2);
    check_cells(&t, v3(1.5f, 0.6f, -0.7f), false, 3);
    check_cells(&t, v3(30, -80, 200), true, 4);
}

static void selection_follows_unshadowed_irradiance(void **state)
{
    (void)state;
    const triangle triangles[3] = {
        { { v3(0, 2, 0), v3(1, 2, 0), v3(0, 2, 1) } }, // looks down
        { { v3(0, 2, 0), v3(0, 2, 1), v3(1, 2, 0) } }, // looks up: dark from below
        { { v3(2, 3, 1), v3(3, 3, 1), v3(2, 3, 2) } },
    };
    fixture f = open_fixture(triangles, 3, rgb(1, 2, 3), false);
    rsv_local_lights local;
    rsv_lights_at(f.lights, v3(0, 0, 0), v3(0, 1, 0), &local);
    assert_true(local.tree_share == 0);
    assert_int_equal(local.count, 3);
    double first = rsv_polygon_irradiance(triangles[0].corner, 3, local.point, local.normal);
    double third = 3 * rsv_polygon_irradiance(triangles[2].corner, 3, local.point, local.normal);
    assert_float_equal(local.probability[0], first / (first + third), 1e-6);
    assert_true(local.probability[1] == 0);
    assert_float_equal(local.unshadowed.g, 2 * (first + third), 1e-6);
    rsv_light_sample sample;
    rsv_lights_at(f.lights, v3(0, 5, 0), v3(0, 1, 0), &local);
    assert_false(rsv_local_lights_sample(&local, 0.3f, 0.3f, 0.3f, &sample));
    close_fixture(&f);
}

/// Nine lamps of all sizes around receivers that some of them cut: the mean is that of exact choices, and so are the
/// densities; far away the guess is the irradiance.
static void guesses_choose_lamps_without_bias(void **state)
{
    (void)state;
    enum { COUNT = 9, RECEIVERS = 40 };
    rsv_random random = rsv_random_from(13, 14, 15);
    triangle t[COUNT];
    for (int i = 0; i < COUNT; i++)
        t[i] = random_triangle(&random, powf(10, uniform(&random, -1, 1)));
    fixture f = open_fixture(t, COUNT, rgb(1, 2, 3), false);
    for (int i = 0; i < RECEIVERS; i++) {
        rsv_vec3 p = random_point(&random, 3), n = random_direction(&random);
        rsv_local_lights exact, guess;
        rsv_light_sample s;
        double error;
        rsv_lights_at(f.lights, p, n, &exact);
        rsv_lights_about(f.lights, p, n, &guess);
        double expected = rgb_luminance(exact.unshadowed);
        double mean = estimate(&guess, 20000, &random, &error);
        assert_float_equal(mean, expected, 4.5 * error + 1e-4 * expected);
        if (!rsv_local_lights_sample(&guess, 0.4f, 0.3f, 0.6f, &s)) continue;
        float pdf = rsv_local_lights_pdf(&guess, s.emitter, s.direction, s.distance);
        assert_float_equal(pdf, s.pdf_solid_angle, 1e-3 * pdf);
        rsv_vec3 far = v3_scale(p, 100), down = v3_normalize(v3_neg(p));
        rsv_lights_at(f.lights, far, down, &exact);
        rsv_lights_about(f.lights, far, down, &guess);
        for (uint32_t k = 0; k < COUNT; k++)
            assert_float_equal(guess.probability[k], exact.probability[k], 0.1);
    }
    close_fixture(&f);
}

/// Turned so that its front is seen from the origin.
static triangle facing_the_origin(triangle t)
{
    rsv_vec3 second = t.corner[1];
    if (v3_dot(triangle_normal(&t), t.corner[0]) < 0) return t;
    t.corner[1] = t.corner[2];
    t.corner[2] = second;
    return t;
}

/// A hundred emitters above the origin: every `stride`-th is large, and faces it.
static void check_many_emitters(int stride, bool any_weighed, uint32_t seed)
{
    enum { COUNT = 100 };
    triangle triangles[COUNT];
    rsv_random random = rsv_random_from(seed, 14, 15);
    for (int i = 0; i < COUNT; i++) {
        rsv_vec3 shift = v3_add(random_point(&random, 2), v3(0, 4, 0));
        triangles[i] = random_triangle(&random, i % stride == 0 ? 2.5f : 0.1f);
        for (int k = 0; k < 3; k++)
            triangles[i].corner[k] = v3_add(triangles[i].corner[k], shift);
        if (i % stride == 0) triangles[i] = facing_the_origin(triangles[i]);
    }
    fixture f = open_fixture(triangles, COUNT, rgb_gray(1), false);
    rsv_local_lights local;
    rsv_lights_at(f.lights, v3(0, 0, 0), v3(0, 1, 0), &local);
    assert_true(any_weighed ? local.tree_share < 1 : local.tree_share == 1);
    assert_true(any_weighed == (local.count > 0));
    double expected = 0, error;
    for (int i = 0; i < COUNT; i++)
        if (v3_dot(triangle_normal(&triangles[i]), triangles[i].corner[0]) < 0)
            expected += (1 + i % 3) *
                        rsv_polygon_irradiance(triangles[i].corner, 3, local.point, local.normal);
    assert_true(rgb_luminance(local.unshadowed) < (1 - 1e-4) * expected);
    double mean = estimate(&local, 200000, &random, &error);
    assert_float_equal(mean, expected, 4.5 * error);
    assert_true(error < 0.02 * expected);
    close_fixture(&f);
}

static void many_emitters_are_selected_by_a_tree(void **state)
{
    (void)state;
    check_many_emitters(1, false, 13);
}

static void of_many_emitters_the_strong_few_are_weighed_and_the_others_in_a_tree(void **state)
{
    (void)state;
    check_many_emitters(9, true, 16);
    check_many_emitters(40, true, 17);
}

static void emitters_are_grouped_and_black_ones_left_out(void **state)
{
    (void)state;
    fixture f = { 0 };
    assert_int_equal(rsv_context_create(NULL, &f.context), RSV_OK);
    const triangle triangles[3] = {
        { { v3(0, 0, 0), v3(1, 0, 0), v3(0, 1, 0) } },
        { { v3(0, 0, 1), v3(1, 0, 1), v3(0, 1, 1) } },
        { { v3(0, 0, 3), v3(0.5f, 0, 3), v3(0, 2, 3) } },
    };
    const rsv_rgb radiance[3] = { rgb(1, 1, 1), rgb_gray(0), rgb(0, 3, 0) };
    f.scene = make_scene(f.context, triangles, 3, radiance, false);
    make_lights(&f);
    assert_int_equal(f.lights->emitter_count, 2);
    assert_int_equal(f.lights->group_count, 2);
    assert_int_equal(f.lights->sampled_count, 2);
    assert_int_equal(f.lights->triangle_emitter[1], RSV_NONE);
    assert_int_equal(f.lights->triangle_emitter[2], 1);
    assert_float_equal(f.lights->group[0].power, 0.5 * RSV_PI, 1e-5);
    close_fixture(&f);
}

/// Two triangles that face the centre of the unit cube from side `side` (axis, then far or near).
static void cube_side(int side, triangle *two)
{
    int axis = side / 2;
    bool far = side % 2;
    rsv_vec3 corner[4];
    for (int i = 0; i < 4; i++) {
        float along[3], u = i == 1 || i == 2, v = i >= 2;
        along[axis] = far;
        along[(axis + 1) % 3] = far ? v : u;
        along[(axis + 2) % 3] = far ? u : v;
        corner[i] = v3(along[0], along[1], along[2]);
    }
    two[0] = (triangle){ { corner[0], corner[1], corner[2] } };
    two[1] = (triangle){ { corner[0], corner[2], corner[3] } };
}

/// The walls of a furnace are gathered although each is small; a lamp in it is not, unless it
/// shines no brighter than they do.
static void emitters_that_surround_are_gathered(void **state)
{
    (void)state;
    triangle triangles[13] = {
        [12] = { { v3(0.5f, 0.5f, 0.5f), v3(0.6f, 0.5f, 0.5f), v3(0.5f, 0.6f, 0.5f) } }
    };
    rsv_rgb radiance[13];
    for (int i = 0; i < 6; i++)
        cube_side(i, &triangles[2 * i]);
    for (int i = 0; i < 13; i++)
        radiance[i] = rgb_gray(1);
    for (int lamp = 1; lamp <= 100; lamp += 99) {
        fixture f = { 0 };
        radiance[12] = rgb_gray((float)lamp);
        assert_int_equal(rsv_context_create(NULL, &f.context), RSV_OK);
        f.scene = make_scene(f.context, triangles, 13, radiance, false);
        make_lights(&f);
        for (int i = 0; i < 12; i++)
            assert_true(f.lights->group[i].gathered);
        assert_true(f.lights->group[12].gathered == (lamp == 1));
        rsv_local_lights local;
        rsv_lights_at(f.lights, v3(0.5f, 0.5f, 0.7f), v3(0, 0, -1), &local);
        assert_true(rsv_local_lights_pdf(&local, 0, v3(0, 0, -1), 0.7f) == 0);
        assert_true((rsv_local_lights_pdf(&local, 12, v3(0, 0, -1), 0.2f) > 0) == (lamp > 1));
        close_fixture(&f);
    }
}

static void point_and_directional_lights_follow_their_laws(void **state)
{
    (void)state;
    rsv_punctual_light light = {
        .kind = RSV_PUNCTUAL_POINT, .position = v3(0, 3, 4), .intensity = rgb(50, 25, 0)
    };
    rsv_punctual_sample s;
    assert_true(rsv_punctual_arriving(NULL, &light, light.position, v3(0, 0, 0), &s));
    assert_float_equal(s.distance, 5, 1e-6);
    assert_float_equal(s.direction.z, 0.8, 1e-6);
    assert_float_equal(s.irradiance.r, 2, 1e-6);
    assert_float_equal(s.irradiance.g, 1, 1e-6);
    assert_false(rsv_punctual_arriving(NULL, &light, light.position, light.position, &s));
    light.kind = RSV_PUNCTUAL_DIRECTIONAL;
    light.direction = v3(0, -1, 0);
    assert_true(rsv_punctual_arriving(NULL, &light, light.position, v3(9, 9, 9), &s));
    assert_true(isinf(s.distance) && s.direction.y == 1 && s.irradiance.r == 50);
    light.intensity = rgb_gray(0);
    assert_false(rsv_punctual_arriving(NULL, &light, light.position, v3(9, 9, 9), &s));
}

/// Irradiance at 1 m from a spot that looks down, `angle` off its axis.
static float spot_at(const rsv_punctual_light *light, float angle)
{
    rsv_punctual_sample s;
    rsv_vec3 point = v3(sinf(angle), -cosf(angle), 0);
    return rsv_punctual_arriving(NULL, light, light->position, point, &s) ? s.irradiance.g : 0;
}

static void spots_fall_off_between_their_cones(void **state)
{
    (void)state;
    rsv_punctual_light spot = { .kind = RSV_PUNCTUAL_SPOT,
        .direction = v3(0, -1, 0),
        .intensity = rgb_gray(7),
        .inner_cone_angle = 0.3f,
        .outer_cone_angle = 0.6f };
    assert_float_equal(spot_at(&spot, 0.29f), 7, 1e-5);
    assert_true(spot_at(&spot, 0.61f) == 0);
    double ramp = (cos(0.5) - cos(0.6)) / (cos(0.3) - cos(0.6));
    assert_float_equal(spot_at(&spot, 0.5f), 7 * ramp * ramp, 1e-4);
    spot.smooth_cone = true;
    assert_float_equal(spot_at(&spot, 0.5f), 7 * ramp * ramp * (3 - 2 * ramp), 1e-4);
    spot.smooth_cone = false;
    spot.inner_cone_angle = spot.outer_cone_angle; // hard edge
    spot.exponent = 3;
    assert_float_equal(spot_at(&spot, 0.59f), 7 * pow(cos(0.59), 3), 1e-4);
    assert_true(spot_at(&spot, 0.61f) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polygon_irradiance_agrees_with_cubature),
        cmocka_unit_test(polygon_irradiance_of_rectangles_is_exact),
        cmocka_unit_test(polygon_irradiance_is_clipped_at_the_horizon),
        cmocka_unit_test(polygon_irradiance_keeps_its_digits_far_away),
        cmocka_unit_test(polygon_irradiance_is_finite_in_degenerate_positions),
        cmocka_unit_test(sampling_integrates_to_the_polygon_irradiance),
        cmocka_unit_test(samples_fill_the_triangle_evenly),
        cmocka_unit_test(selection_follows_unshadowed_irradiance),
        cmocka_unit_test(guesses_choose_lamps_without_bias),
        cmocka_unit_test(many_emitters_are_selected_by_a_tree),
        cmocka_unit_test(of_many_emitters_the_strong_few_are_weighed_and_the_others_in_a_tree),
        cmocka_unit_test(emitters_are_grouped_and_black_ones_left_out),
        cmocka_unit_test(emitters_that_surround_are_gathered),
        cmocka_unit_test(point_and_directional_lights_follow_their_laws),
        cmocka_unit_test(spots_fall_off_between_their_cones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
