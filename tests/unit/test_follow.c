/// Light that follows moving objects: patched rows compared with new ones, motions there and back, moments compared
/// with new solves, and unsupported motions.
#include "light_fixture.h"

#include "direct/photon_log.h"
#include "light_view.h"
#include "operator/tracked_rows.h"
#include "resolvent/render.h"
#include "resolvent/update.h"
#include "scene/moved.h"
#include "slow_tests.h"

#include <math.h>
#include <stdlib.h>

/// A built-in scene, and what moves in it.
typedef struct stage {
    rsv_context *context;
    rsv_scene *scene;
    uint32_t object;
} stage;

static stage open_stage_with(const char *name, const char *object, uint32_t threads)
{
    stage s = { .context = NULL };
    rsv_context_desc desc = rsv_default_context_desc();
    desc.thread_count = threads;
    assert_int_equal(rsv_context_create(&desc, &s.context), RSV_OK);
    assert_int_equal(rsv_scene_builtin(s.context, name, &s.scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(s.scene);
    while (s.object < view->object_count && strcmp(view->object_name[s.object], object) != 0)
        s.object++;
    if (s.object == view->object_count) fail_msg("%s has no '%s'", name, object);
    return s;
}

static stage open_stage(const char *name, const char *object)
{
    return open_stage_with(name, object, 2);
}

static void close_stage(stage *s)
{
    rsv_scene_destroy(s->scene);
    rsv_context_destroy(s->context);
}

/// The object shifted, and turned about an upright axis through a point. @param turn radians
static rsv_motion motion_of(const stage *s, rsv_vec3 shift, float turn, float x, float z)
{
    float c = cosf(turn), n = sinf(turn);
    return (rsv_motion){ .object = s->object,
        .matrix = { c, 0, -n, 0, 0, 1, 0, 0, n, 0, c, 0, x - c * x - n * z + shift.x, shift.y,
            z + n * x - c * z + shift.z, 1 } };
}

static rsv_scene *moved(const stage *s, rsv_motion motion)
{
    rsv_scene *scene = NULL;
    if (rsv_scene_move(s->scene, &motion, 1, &scene) != RSV_OK) fail_msg("%s", rsv_last_error());
    return scene;
}

static rsv_solve_desc small_desc(void)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = UNLESS_SANITIZED(1200, 400);
    desc.rays_per_element = UNLESS_SANITIZED(128, 64);
    desc.photon_count = desc.photon_count ? 20000 : 0;
    desc.direct_levels = 1;
    return desc;
}

static rsv_light *solve(const rsv_scene *scene, const rsv_solve_desc *desc)
{
    rsv_light *light = NULL;
    if (rsv_light_create(scene, desc, &light) != RSV_OK) fail_msg("%s", rsv_last_error());
    return light;
}

static rsv_update_report follow(rsv_light *light, const stage *s, rsv_motion motion)
{
    rsv_update_report report = { 0 };
    rsv_scene *scene = moved(s, motion);
    if (rsv_light_follow(light, scene, &report) != RSV_OK) fail_msg("%s", rsv_last_error());
    rsv_scene_destroy(scene);
    return report;
}

// ---- scenes ---------------------------------------------------------------------------------------

static void objects_are_moved_and_nothing_else(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_scene *scene = moved(&s, motion_of(&s, v3(0.1f, 0.02f, 0), RSV_PI / 2, 0, 0));
    const rsv_scene_view *a = rsv_scene_get_view(s.scene), *b = rsv_scene_get_view(scene);
    assert_int_equal(a->triangle_count, b->triangle_count);
    for (size_t t = 0; t < a->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            uint32_t v = a->triangle[t][k];
            rsv_vec3 p = a->position[v], q = b->position[v], n = a->normal[v], m = b->normal[v];
            bool moves = a->triangle_object[t] == s.object;
            rsv_vec3 at = moves ? v3(p.z + 0.1f, p.y + 0.02f, -p.x) : p;
            rsv_vec3 up = moves ? v3(n.z, n.y, -n.x) : n;
            assert_true(v3_length(v3_sub(q, at)) < 1e-6f);
            assert_true(v3_length(v3_sub(m, up)) < 1e-6f);
        }
    rsv_scene_destroy(scene);
    close_stage(&s);
}

static void refuse_motion(const stage *s, rsv_motion motion, const char *words)
{
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_scene_move(s->scene, &motion, 1, &scene), RSV_ERROR_ARGUMENT);
    assert_null(scene);
    if (!strstr(rsv_last_error(), words)) fail_msg("%s", rsv_last_error());
}

static void motions_that_make_no_sense_are_refused(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_motion m = motion_of(&s, v3(0, 0, 0), 0, 0, 0);
    rsv_motion other = m, mirror = m, flat = m, nan = m, far = m;
    other.object = 999;
    mirror.matrix[0] = -1;
    flat.matrix[5] = 0;
    nan.matrix[13] = NAN;
    far.matrix[12] = 1e20f;
    refuse_motion(&s, other, "object 999");
    refuse_motion(&s, mirror, "mirrored");
    refuse_motion(&s, flat, "scaled to zero");
    refuse_motion(&s, nan, "not finite");
    refuse_motion(&s, far, "farther than");
    close_stage(&s);
}

// ---- pictures ---------------------------------------------------------------------------------------

static double mean_of_picture(const rsv_light *light, uint32_t gather_rays)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    double sum = 0;
    desc.width = desc.height = 24;
    desc.samples = 64;
    desc.gather_rays = gather_rays;
    if (rsv_render(light, &desc, &image) != RSV_OK) fail_msg("%s", rsv_last_error());
    for (uint32_t k = 0; k < desc.width * desc.height; k++)
        sum += (double)rgb_luminance(rsv_image_const_pixels(image, 0)[k]);
    rsv_image_destroy(image);
    return sum / (desc.width * desc.height);
}

/// Light that has followed an object has no separate orders: layers are not supported, and gather rays include all
/// orders.
static void pictures_miss_no_bounce(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_solve_desc desc = small_desc();
    rsv_light *light = solve(s.scene, &desc);
    follow(light, &s, motion_of(&s, v3(0.1f, 0, 0), 0, 0, 0));
    assert_int_equal(rsv_light_order_count(light), 0);
    double looked_up = mean_of_picture(light, 0);
    assert_close(mean_of_picture(light, 1), looked_up, 0.03 * looked_up);
    rsv_render_desc layers = rsv_default_render_desc();
    rsv_image *image = NULL;
    layers.layers = true;
    assert_int_equal(rsv_render(light, &layers, &image), RSV_ERROR_UNSUPPORTED);
    assert_null(image);
    assert_non_null(strstr(rsv_last_error(), "layers"));
    rsv_light_destroy(light);
    close_stage(&s);
}

// ---- readings -------------------------------------------------------------------------------------

#define PROBE_SIDE 24

/// Probes just above what stands below a grid of places in the air.
typedef struct probe_grid {
    rsv_probe probe[PROBE_SIDE * PROBE_SIDE];
    size_t count;
} probe_grid;

/// Place k of a grid in the air. @param part of the scene along x, from its lower end
static rsv_vec3 place_in_air(const rsv_light *light, float part, int k)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_light_scene(light));
    rsv_vec3 low = view->bounds_min, size = v3_sub(view->bounds_max, low);
    float x = ((float)(k % PROBE_SIDE) + 0.5f) / PROBE_SIDE,
          z = ((float)(k / PROBE_SIDE) + 0.5f) / PROBE_SIDE;
    return v3_add(low, v3(part * x * size.x, 0.7f * size.y, z * size.z));
}

/// Whether a hit from above is one from inside a body.
static bool is_below_its_face(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    const rsv_vec3 *at = view->position;
    rsv_vec3 normal;
    return rsv_triangle_normal(at[corner[0]], at[corner[1]], at[corner[2]], &normal) &&
           normal.y < 0;
}

/// Places inside a body have none. @param without the object that they must not be on; RSV_NONE = they may be anywhere
static probe_grid probes_below(const rsv_light *light, float part, uint32_t without)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_light_scene(light));
    probe_grid grid = { .count = 0 };
    for (int k = 0; k < PROBE_SIDE * PROBE_SIDE; k++) {
        rsv_vec3 at = place_in_air(light, part, k);
        const rsv_ray ray = { .origin = at, .direction = { 0, -1, 0 }, .t_max = INFINITY };
        rsv_hit hit;
        if (!rsv_tracer_closest(inside(light)->tracer, &ray, &hit)) continue;
        if (view->triangle_object[hit.triangle] == without) continue;
        if (is_below_its_face(view, hit.triangle)) continue;
        grid.probe[grid.count++] = (rsv_probe){ v3(at.x, at.y - hit.t + 1e-4f, at.z), { 0, 1, 0 } };
    }
    assert_true(grid.count > PROBE_SIDE * PROBE_SIDE / 2);
    return grid;
}

static double mean_read(const rsv_light *light, const probe_grid *grid, rsv_probe_desc desc)
{
    rsv_probe_reading reading[PROBE_SIDE * PROBE_SIDE];
    double sum = 0;
    desc.size = sizeof desc;
    assert_int_equal(rsv_probe_irradiance(light, &desc, grid->probe, grid->count, reading), RSV_OK);
    for (size_t k = 0; k < grid->count; k++)
        sum += (double)rgb_luminance(reading[k].irradiance);
    return sum / (double)grid->count;
}

/// Mean irradiance below places in the air, on the floor and what stands on it, as it is stored: with the errors of
/// elements, which lights have that were divided at different moments.
static double mean_without(const rsv_light *light, float part, uint32_t without)
{
    probe_grid grid = probes_below(light, part, without);
    return mean_read(light, &grid, (rsv_probe_desc){ .mode = RSV_PROBE_LOOKUP, .samples = 16 });
}

static double mean_below(const rsv_light *light, float part)
{
    return mean_without(light, part, RSV_NONE);
}

/// The same, gathered once through the light: nearly without the errors of the elements at these places.
static double mean_gathered(const rsv_light *light, float part, uint32_t rays)
{
    probe_grid grid = probes_below(light, part, RSV_NONE);
    return mean_read(light, &grid, (rsv_probe_desc){ .mode = RSV_PROBE_OPERATOR, .samples = rays });
}

/// RMS difference of the direct light of two lights on faces that stay, over its RMS.
static double difference_of_direct(const rsv_light *a, const rsv_light *b, uint32_t object)
{
    enum { SIDE = 48 };
    const uint32_t *owner = rsv_scene_get_view(rsv_light_scene(a))->triangle_object;
    const rsv_source_level *x = &inside(a)->fine, *y = &inside(b)->fine;
    double apart = 0, all = 0;
    for (uint32_t k = 0; k < x->elements->face_count * SIDE * SIDE; k++) {
        float u = ((float)(k % SIDE) + 0.5f) / SIDE, v = ((float)(k / SIDE % SIDE) + 0.5f) / SIDE;
        uint32_t face = k / (SIDE * SIDE);
        if (u + v > 1 || owner[x->elements->face_triangle[face]] == object) continue;
        double p = (double)rgb_luminance(
                   rsv_elements_interpolate(x->elements, x->direct, face, u, v)),
               q = (double)rgb_luminance(
                   rsv_elements_interpolate(y->elements, y->direct, face, u, v));
        apart += (p - q) * (p - q);
        all += p * p;
    }
    return sqrt(apart / all);
}

// ---- rows -----------------------------------------------------------------------------------------

static int compare_nodes(const void *left, const void *right)
{
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

/// Whether two rows have the same ends, in any order, and the same light in those with colours.
static void check_row(const rsv_transport *p, const rsv_transport *q, size_t row)
{
    rsv_transport_row a = rsv_transport_row_at(p, row), b = rsv_transport_row_at(q, row);
    uint32_t x[4096], y[4096];
    double sum_a = 0, sum_b = 0;
    assert_int_equal(a.count, b.count);
    assert_int_equal(a.tinted_count, b.tinted_count);
    assert_true(p->scale[row] == q->scale[row]);
    if (a.count) memcpy(x, a.column, a.count * sizeof *x);
    if (b.count) memcpy(y, b.column, b.count * sizeof *y);
    qsort(x, a.count, sizeof *x, compare_nodes);
    qsort(y, b.count, sizeof *y, compare_nodes);
    assert_true(a.count == 0 || memcmp(x, y, a.count * sizeof *x) == 0);
    for (size_t k = 0; k < a.tinted_count; k++) {
        sum_a += (double)rgb_luminance(a.tinted_weight[k]) * (a.tinted_column[k] + 1);
        sum_b += (double)rgb_luminance(b.tinted_weight[k]) * (b.tinted_column[k] + 1);
    }
    assert_true(fabs(sum_a - sum_b) <= 1e-5 * fabs(sum_a));
}

/// Rows of two lights of the same scene.
static void check_rows(const rsv_light *a, const rsv_light *b)
{
    const rsv_transport *p = inside(a)->transport, *q = inside(b)->transport;
    assert_int_equal(p->row_count, q->row_count);
    assert_true(rsv_rows_are_tracked(p) && rsv_rows_are_tracked(q));
    for (size_t row = 0; row < p->row_count; row++) {
        assert_int_equal(inside(a)->valid_points[row], inside(b)->valid_points[row]);
        check_row(p, q, row);
    }
    assert_int_equal(rsv_transport_entries(p), rsv_transport_entries(q));
}

/// Follows a few motions, and one straight to the end: rows that are patched repeatedly equal rows traced from scratch.
static void check_way(
    const char *scene, const char *object, rsv_vec3 shift, rsv_vec3 axis, float turn)
{
    enum { STEPS = 3 };
    stage s = open_stage(scene, object);
    const rsv_solve_desc desc = small_desc();
    rsv_light *by_steps = solve(s.scene, &desc), *at_once = solve(s.scene, &desc);
    uint64_t kept = 0;
    for (int k = 0; k <= STEPS; k++) {
        float part = (float)k / STEPS;
        kept =
            follow(by_steps, &s, motion_of(&s, v3_scale(shift, part), part * turn, axis.x, axis.z))
                .kept_row_rays;
    }
    follow(by_steps, &s, motion_of(&s, shift, turn, axis.x, axis.z)); // at rest: divided as at once
    follow(at_once, &s, motion_of(&s, shift, turn, axis.x, axis.z));
    assert_true(kept > 0);
    check_rows(by_steps, at_once);
    double a = rsv_light_report(by_steps)->mean_irradiance,
           b = rsv_light_report(at_once)->mean_irradiance;
    if (fabs(a - b) > 2e-3 * b)
        fail_msg("%s: mean irradiance %g by steps, %g at once", scene, a, b);
    rsv_light_destroy(by_steps);
    rsv_light_destroy(at_once);
    close_stage(&s);
}

static void patched_rows_are_those_traced_anew(void **state)
{
    (void)state;
    check_way("cornell-blocks", "short block", v3(-0.08f, 0, 0.02f), v3(-0.18f, 0, -0.17f), 0.4f);
    check_way("two-rooms", "door", v3(0, 0, 0), v3(0, 0, -0.43f), 0.7f);
}

static void patched_rows_past_glass_are_those_traced_anew(void **state)
{
    (void)state;
    check_way("cornell-spheres", "front sphere", v3(0.03f, 0.02f, -0.02f), v3(0, 0, 0), 0);
}

static void what_comes_back_is_what_it_was(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    const rsv_solve_desc desc = small_desc();
    rsv_light *stays = solve(s.scene, &desc), *leaves = solve(s.scene, &desc);
    const rsv_motion none = motion_of(&s, v3(0, 0, 0), 0, 0, 0);
    follow(stays, &s, none);
    follow(leaves, &s, none);
    for (int k = 1; k <= UNLESS_SANITIZED(20, 4); k++)
        follow(leaves, &s,
            motion_of(
                &s, v3(-0.005f * (float)k, 0, 0.003f * (float)(k % 7)), 0.1f * (float)k, 0, 0));
    follow(leaves, &s, none);
    follow(leaves, &s, none); // at rest, shadows are divided as they were
    check_rows(stays, leaves);
    double a = rsv_light_report(stays)->mean_irradiance,
           b = rsv_light_report(leaves)->mean_irradiance;
    if (fabs(a - b) > 1e-4 * a) fail_msg("mean irradiance %.8g became %.8g", a, b);
    for (size_t n = 0; n < inside(stays)->elements->node_count; n++) {
        float then = rgb_luminance(inside(stays)->irradiance[n]),
              now = rgb_luminance(inside(leaves)->irradiance[n]);
        if (fabsf(then - now) > 1e-3f * (float)a) fail_msg("node %zu: %g became %g", n, then, now);
    }
    rsv_light_destroy(stays);
    rsv_light_destroy(leaves);
    close_stage(&s);
}

static rsv_motion on_the_way(const stage *s, float part)
{
    return motion_of(s, v3(-0.1f * part, 0, 0.04f * part), 0.4f * part, 0, 0);
}

/// Follows with a limit to the triangles whose own light is computed again. @return how many of ten wait
static size_t follow_in_part(rsv_light *light, const stage *s, float part)
{
    rsv_update_report report = { 0 };
    rsv_scene *there = moved(s, on_the_way(s, part));
    assert_int_equal(rsv_light_follow_part(light, there, 2, &report), RSV_OK);
    rsv_scene_destroy(there);
    return report.waiting_triangles;
}

static rsv_solve_desc smaller_desc(void)
{
    rsv_solve_desc desc = small_desc();
    desc.element_target = 400;
    desc.rays_per_element = 64;
    return desc;
}

enum { STEPS_IN_PART = 5 };

/// The light of a block on its way, in part.
static rsv_light *move_in_part(const stage *s)
{
    const rsv_solve_desc desc = smaller_desc();
    rsv_light *light = solve(s->scene, &desc);
    follow(light, s, on_the_way(s, 0));
    for (int k = 1; k <= STEPS_IN_PART; k++)
        assert_int_equal(follow_in_part(light, s, (float)k / STEPS_IN_PART), 8);
    return light;
}

/// How far two lights may be apart.
typedef struct tolerances {
    double stored, gathered; ///< of means
    double direct;    ///< of direct light, point by point, which is noisy at the edges of shadows
    uint32_t without; ///< object whose own light does not count in the stored mean
} tolerances;

static void check_alike(
    const stage *s, const rsv_light *whole, const rsv_light *part, tolerances tolerance)
{
    double apart = difference_of_direct(whole, part, s->object);
    double stored =
        mean_without(part, 1, tolerance.without) / mean_without(whole, 1, tolerance.without) - 1;
    double gathered = mean_gathered(part, 1, 64) / mean_gathered(whole, 1, 64) - 1;
    if (fabs(stored) > tolerance.stored) fail_msg("stored light is off by %g", stored);
    if (fabs(gathered) > tolerance.gathered) fail_msg("gathered light is off by %g", gathered);
    if (apart > tolerance.direct) fail_msg("direct light: RMS difference %g", apart);
}

/// Rows of a moving object whose light is computed in turns are those of one that had no limit, once it rests. On the
/// way, the object takes the light along that it had, but shadows and all light elsewhere are nearly up to date.
static void what_waits_is_computed_in_its_turn(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    const rsv_solve_desc desc = smaller_desc();
    rsv_light *whole = solve(s.scene, &desc), *part = move_in_part(&s);
    follow(whole, &s, on_the_way(&s, 0));
    follow(whole, &s, on_the_way(&s, 1));
    check_alike(&s, whole, part, (tolerances){ 0.005, 0.005, 0.03, s.object });
    for (size_t waiting = 8; waiting > 0;) {
        size_t now = follow_in_part(part, &s, 1);
        assert_int_equal(now, waiting - 2);
        waiting = now;
    }
    check_alike(&s, whole, part, (tolerances){ 1e-3, 1e-5, 0.03, RSV_NONE });
    follow(whole, &s, on_the_way(&s, 1));
    follow(part, &s, on_the_way(&s, 1)); // at rest: divided alike
    check_rows(whole, part);
    check_alike(&s, whole, part, (tolerances){ 1e-3, 1e-5, 5e-3, RSV_NONE });
    rsv_light_destroy(whole);
    rsv_light_destroy(part);
    close_stage(&s);
}

/// Brought to rest at once, while triangles wait, the rows are those of one that had no limit, too; and the light on
/// the way is the same for any number of threads.
static void what_waits_comes_to_rest_at_once(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block"),
          t = open_stage_with("cornell-blocks", "short block", 1);
    const rsv_solve_desc desc = smaller_desc();
    rsv_light *whole = solve(s.scene, &desc), *part = move_in_part(&s), *other = move_in_part(&t);
    size_t bytes = inside(part)->elements->node_count * sizeof *inside(part)->irradiance;
    assert_memory_equal(inside(part)->irradiance, inside(other)->irradiance, bytes);
    follow(whole, &s, on_the_way(&s, 0));
    follow(whole, &s, on_the_way(&s, 1));
    follow(whole, &s, on_the_way(&s, 1));
    follow(part, &s, on_the_way(&s, 1));
    check_rows(whole, part);
    check_alike(&s, whole, part, (tolerances){ 1e-3, 1e-5, 5e-3, RSV_NONE });
    rsv_light_destroy(whole);
    rsv_light_destroy(part);
    rsv_light_destroy(other);
    close_stage(&s);
    close_stage(&t);
}

static void rays_take_eight_bytes_at_most(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_solve_desc desc = small_desc();
    desc.rays_per_element = 256;
    rsv_light *light = solve(s.scene, &desc);
    uint64_t rays = follow(light, &s, motion_of(&s, v3(-0.01f, 0, 0), 0, 0, 0)).row_rays;
    const rsv_transport *rows = inside(light)->transport;
    double bytes = (double)rows->table->bytes(rows) / (double)rays;
    if (bytes > 8) fail_msg("%.2f bytes a ray", bytes);
    rsv_light_destroy(light);
    close_stage(&s);
}

// ---- photons --------------------------------------------------------------------------------------

static void enclose(const rsv_light *light, uint32_t object, rsv_scene_change *change)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_light_scene(light));
    rsv_vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_scale(low, -1);
    for (size_t t = 0; t < view->triangle_count; t++)
        for (int k = 0; k < 3 && view->triangle_object[t] == object; k++) {
            low = v3_min(low, view->position[view->triangle[t][k]]);
            high = v3_max(high, view->position[view->triangle[t][k]]);
        }
    const rsv_vec3 margin = v3(1e-3f, 1e-3f, 1e-3f);
    rsv_scene_change_add(change, v3_sub(low, margin), v3_add(high, margin), false);
}

/// Deposits photons on the elements of a light, in the scene of another. @return rays
static uint64_t land(rsv_photon_log *log, const rsv_light *on, const rsv_light *in,
    const rsv_scene_change *change, rsv_photon_map *map)
{
    uint64_t rays = 0;
    const rsv_elements *elements = inside(on)->elements;
    const rsv_photon_targets targets = { &elements, map, 1 };
    rsv_status status = rsv_photon_log_deposit(
        log, &inside(in)->scene, inside(in)->lights, change, &targets, &rays);
    assert_int_equal(status, RSV_OK);
    return rays;
}

/// Photons whose paths a motion does not meet land where they would land if all were shot again.
static void photons_that_meet_nothing_are_kept(void **state)
{
    (void)state;
    enum { PHOTONS = 20000 };
    stage s = open_stage("cornell-spheres", "front sphere");
    rsv_solve_desc desc = smaller_desc();
    desc.photon_count = 1000;
    rsv_scene *there = moved(&s, motion_of(&s, v3(0.05f, 0.03f, -0.05f), 0, 0, 0));
    rsv_light *light[2] = { solve(s.scene, &desc), solve(there, &desc) };
    rsv_scene_change change = { .count = 0 }, all = { .count = 0 };
    rsv_photon_map map[3];
    rsv_photon_log *log = NULL;
    uint64_t rays = 0;
    for (int k = 0; k < 2; k++)
        enclose(light[k], s.object, &change);
    rsv_scene_change_add(&all, v3(-99, -99, -99), v3(99, 99, 99), false);
    assert_int_equal(rsv_photon_log_create(&inside(light[0])->scene, inside(light[0])->lights,
                         PHOTONS, 1, &log, &rays),
        RSV_OK);
    rays = land(log, light[0], light[0], &change, &map[0]);
    uint64_t some = land(log, light[0], light[1], &change, &map[1]),
             whole = land(log, light[0], light[1], &all, &map[2]);
    if (!(some < whole / 2)) fail_msg("%zu rays, %zu in all", (size_t)some, (size_t)whole);
    size_t bytes = inside(light[0])->elements->node_count * sizeof *map->flux;
    assert_memory_equal(map[1].flux, map[2].flux, bytes);
    assert_memory_not_equal(map[0].flux, map[1].flux, bytes);
    for (int k = 0; k < 3; k++)
        rsv_photon_map_destroy(&map[k]);
    rsv_photon_log_destroy(log);
    rsv_light_destroy(light[0]);
    rsv_light_destroy(light[1]);
    rsv_scene_destroy(there);
    close_stage(&s);
}

// ---- light ----------------------------------------------------------------------------------------

/// Random positions of an object: means of light that follows compared with those of new solves.
/// @return mean difference, relative to the light: stored and gathered
static void find_differences(
    const char *scene, const char *object, rsv_vec3 reach, int count, double difference[2])
{
    stage s = open_stage(scene, object);
    const rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light = solve(s.scene, &desc);
    rsv_random random = rsv_random_from(5, 6, 7);
    difference[0] = difference[1] = 0;
    for (int k = 0; k < count; k++) {
        rsv_vec3 shift = v3(reach.x * rsv_random_float(&random),
            reach.y * rsv_random_float(&random), reach.z * rsv_random_float(&random));
        rsv_motion motion = motion_of(&s, shift, 0, 0, 0);
        rsv_scene *there = moved(&s, motion);
        follow(light, &s, motion);
        rsv_light *fresh = solve(there, &desc);
        double apart[2] = { mean_below(light, 1) / mean_below(fresh, 1) - 1,
            mean_gathered(light, 1, 64) / mean_gathered(fresh, 1, 64) - 1 };
        for (int j = 0; j < 2; j++) {
            if (fabs(apart[j]) > 0.01) fail_msg("%s, place %d: off by %g", scene, k, apart[j]);
            difference[j] += apart[j] / count;
        }
        rsv_light_destroy(fresh);
        rsv_scene_destroy(there);
    }
    rsv_light_destroy(light);
    close_stage(&s);
}

static void check_difference(const char *scene, const char *object, rsv_vec3 reach, int count)
{
    double difference[2];
    find_differences(scene, object, reach, count, difference);
    for (int k = 0; k < 2; k++)
        if (fabs(difference[k]) > 0.002)
            fail_msg("%s: %s off by %.3f %%", scene, k ? "gathered light is" : "stored light is",
                100 * difference[k]);
}

static void light_is_that_of_solves(void **state)
{
    (void)state;
    check_difference("cornell-blocks", "short block", v3(-0.1f, 0, 0.1f), UNLESS_SANITIZED(4, 1));
}

/// 20 random movements.
static void light_of_twenty_places_is_that_of_solves(void **state)
{
    (void)state;
    check_difference("cornell-blocks", "short block", v3(-0.1f, 0.2f, 0.1f), 20);
}

static void lamps_that_move_take_their_light_along(void **state)
{
    (void)state;
    check_difference("cornell-blocks", "light", v3(0.1f, -0.1f, 0.05f), UNLESS_SANITIZED(3, 1));
}

/// The door of two-rooms. @param angle radians from where it is shut
static rsv_scene *open_door(const stage *s, float angle)
{
    const float shut = 0.22f; // from where the file has it
    return moved(s, motion_of(s, v3(0, 0, 0), shut - angle, 0, -0.43f));
}

/// Compares light that follows with a new solve. Stored light of a solve has errors of its own where light is steep, in
/// the doorway: it is 2 % too bright there at this quality, beside paths; what is gathered through it is not.
/// @param most relative difference of stored light
static void check_door(
    const rsv_light *light, const rsv_light *fresh, const char *when, double most)
{
    double stored = mean_below(light, 0.5f) / mean_below(fresh, 0.5f) - 1,
           gathered = mean_gathered(light, 0.5f, 256) / mean_gathered(fresh, 0.5f, 256) - 1;
    if (fabs(stored) > most) fail_msg("%s: stored light is off by %g", when, stored);
    if (fabs(gathered) > 0.005) fail_msg("%s: gathered light is off by %g", when, gathered);
}

/// A door that opens, nearly shut at first: light floods the dark room.
static void doors_let_light_in(void **state)
{
    (void)state;
    enum { MOMENTS = 6 };
    static const float angle[MOMENTS] = { 0.05f, 0.12f, 0.25f, 0.45f, 0.7f, 0.9f };
    stage s = open_stage("two-rooms", "door");
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.rays_per_element = 1024;
    desc.light_samples *= 4;
    rsv_scene *shut = open_door(&s, 0.02f);
    rsv_light *light = solve(shut, &desc);
    double before = mean_below(light, 0.5f);
    for (int k = 0; k < MOMENTS; k++) {
        rsv_scene *there = open_door(&s, angle[k]);
        assert_int_equal(rsv_light_follow(light, there, NULL), RSV_OK);
        rsv_light *fresh = solve(there, &desc);
        check_door(light, fresh, "moving", 0.05);
        assert_int_equal(rsv_light_follow(light, there, NULL), RSV_OK);
        check_door(light, fresh, "at rest", 0.03);
        rsv_light_destroy(fresh);
        rsv_scene_destroy(there);
    }
    assert_true(mean_below(light, 0.5f) > before);
    rsv_light_destroy(light);
    rsv_scene_destroy(shut);
    close_stage(&s);
}

/// A tolerance below the rounding of stored light is raised, as in a solve, and does not cost orders without end.
static void orders_end_at_rounding(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_solve_desc desc = small_desc();
    desc.element_target = 300;
    desc.direct_level = false;
    desc.tolerance = 1e-8f;
    rsv_light *light = solve(s.scene, &desc);
    uint32_t most = rsv_light_report(light)->iterations;
    for (int k = 1; k <= 3; k++) {
        follow(light, &s, motion_of(&s, v3(-0.02f * (float)k, 0, 0), 0, 0, 0));
        const rsv_solve_report *report = rsv_light_report(light);
        assert_int_equal(report->stop_reason, RSV_STOP_CONVERGED);
        if (report->iterations > most) fail_msg("%u, not %u", report->iterations, most);
    }
    rsv_light_destroy(light);
    close_stage(&s);
}

// ---- what cannot be followed ----------------------------------------------------------------------

static void other_scenes_are_refused(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_scene *other = NULL;
    const rsv_solve_desc desc = small_desc();
    rsv_light *light = solve(s.scene, &desc);
    double before = rsv_light_report(light)->mean_irradiance;
    assert_int_equal(rsv_scene_builtin(s.context, "cornell-spheres", &other), RSV_OK);
    assert_int_equal(rsv_light_follow(light, other, NULL), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "solve the scene again"));
    assert_true(rsv_light_report(light)->mean_irradiance == before);
    assert_int_equal(rsv_light_follow(light, s.scene, NULL), RSV_OK); // it goes on
    rsv_scene_destroy(other);
    rsv_light_destroy(light);
    close_stage(&s);
}

/// A sheet of two triangles folded along their common edge, whose normals all stay upright, above a floor and below a lamp.
/// @param fold radians; beyond a quarter turn the second triangle looks down, away from its normals
static rsv_scene *fold_sheet(rsv_context *context, float fold, bool deforms)
{
    const rsv_vec3 sheet[4] = { { 0, 1, -1 }, { 0, 1, 1 }, { -1, 1, 0 },
        { cosf(fold), 1 + sinf(fold), 0 } };
    const rsv_vec3 floor[4] = { { -3, 0, -3 }, { -3, 0, 3 }, { 3, 0, 3 }, { 3, 0, -3 } };
    const rsv_vec3 up[4] = { { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 } };
    const uint32_t folded[6] = { 0, 2, 1, 0, 1, 3 }, flat[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_mesh_desc mesh[2] = { { .size = sizeof *mesh,
                                        .positions = floor,
                                        .vertex_count = 4,
                                        .indices = flat,
                                        .triangle_count = 2 },
        { .size = sizeof *mesh,
            .positions = sheet,
            .normals = up,
            .vertex_count = 4,
            .indices = folded,
            .triangle_count = 2,
            .deforms = deforms } };
    rsv_material paint = rsv_default_material();
    const rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 1, 4, 1 },
        .intensity = { 9, 9, 9 } };
    rsv_scene *scene = NULL;
    paint.double_sided = true;
    assert_int_equal(rsv_scene_create(context, &scene), RSV_OK);
    assert_int_equal(rsv_scene_add_material(scene, &paint, NULL), RSV_OK);
    assert_int_equal(rsv_scene_add_light(scene, &lamp), RSV_OK);
    for (uint32_t k = 0; k < 2; k++) {
        assert_int_equal(rsv_scene_add_mesh(scene, &mesh[k], NULL), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, k, NULL, NULL), RSV_OK);
    }
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

/// Deforming meshes are followed to poses in which different normals point away from their triangles.
static void meshes_that_deform_are_followed(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    rsv_solve_desc desc = small_desc();
    for (int deforms = 0; deforms < 2; deforms++) {
        rsv_scene *open = fold_sheet(s.context, 0.3f, deforms),
                  *shut = fold_sheet(s.context, 2.5f, deforms);
        rsv_light *light = solve(open, &desc), *anew = solve(shut, &desc);
        rsv_status status = rsv_light_follow(light, shut, NULL);
        assert_int_equal(status, deforms ? RSV_OK : RSV_ERROR_UNSUPPORTED);
        double then = mean_below(anew, 0.1f), now = mean_below(light, 0.1f);
        if (deforms && !(fabs(now - then) < 0.02 * then))
            fail_msg("%g where a solve finds %g", now, then);
        rsv_light_destroy(light);
        rsv_light_destroy(anew);
        rsv_scene_destroy(open);
        rsv_scene_destroy(shut);
    }
    close_stage(&s);
}

/// Whether a light would follow a motion, as far as the scene is concerned.
static rsv_status compare_moved(const stage *s, rsv_motion motion)
{
    rsv_scene_difference difference;
    rsv_scene *there = moved(s, motion);
    rsv_status status = rsv_scene_find_moved(s->scene, there, &difference);
    rsv_free(s->context, difference.moved);
    rsv_scene_destroy(there);
    return status;
}

/// Translucent bodies may move and turn, but have the shape that light diffuses in.
static void translucent_bodies_keep_their_shape(void **state)
{
    (void)state;
    stage s = open_stage("cornell-marble", "marble");
    rsv_motion taller = motion_of(&s, v3(0, 0, 0), 0, 0, 0);
    taller.matrix[5] = 1.01f;
    assert_int_equal(compare_moved(&s, motion_of(&s, v3(0.02f, 0.01f, 0), 0.5f, 0, 0)), RSV_OK);
    assert_int_equal(compare_moved(&s, taller), RSV_ERROR_UNSUPPORTED);
    if (!strstr(rsv_last_error(), "changes its shape")) fail_msg("%s", rsv_last_error());
    close_stage(&s);
}

/// Through walls, and out of the scene.
static void objects_may_go_through_walls(void **state)
{
    (void)state;
    stage s = open_stage("cornell-blocks", "short block");
    const rsv_solve_desc desc = small_desc();
    rsv_light *light = solve(s.scene, &desc);
    const rsv_vec3 shift[] = { { -0.3f, 0, 0 }, { 0, -0.1f, 0 }, { 3, 3, 3 }, { 0, 0, 0 } };
    for (size_t k = 0; k < sizeof shift / sizeof *shift; k++) {
        follow(light, &s, motion_of(&s, shift[k], 0, 0, 0));
        for (size_t n = 0; n < inside(light)->elements->node_count; n++) {
            rsv_rgb e = inside(light)->irradiance[n];
            assert_true(isfinite(e.r) && isfinite(e.g) && isfinite(e.b) && e.r >= 0);
        }
    }
    rsv_light_destroy(light);
    close_stage(&s);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(objects_are_moved_and_nothing_else),
        cmocka_unit_test(motions_that_make_no_sense_are_refused),
        cmocka_unit_test(what_comes_back_is_what_it_was),
        cmocka_unit_test(what_waits_is_computed_in_its_turn),
        cmocka_unit_test(what_waits_comes_to_rest_at_once),
        cmocka_unit_test(rays_take_eight_bytes_at_most),
        cmocka_unit_test(photons_that_meet_nothing_are_kept),
        cmocka_unit_test(orders_end_at_rounding),
        cmocka_unit_test(other_scenes_are_refused),
        cmocka_unit_test(meshes_that_deform_are_followed),
        cmocka_unit_test(translucent_bodies_keep_their_shape),
        cmocka_unit_test(objects_may_go_through_walls),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(pictures_miss_no_bounce),
        cmocka_unit_test(patched_rows_are_those_traced_anew),
        cmocka_unit_test(patched_rows_past_glass_are_those_traced_anew),
        cmocka_unit_test(light_is_that_of_solves),
        cmocka_unit_test(lamps_that_move_take_their_light_along),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(light_of_twenty_places_is_that_of_solves),
        cmocka_unit_test(doors_let_light_in),
    };
    return RUN_THIRD(argc, argv, quick, slow, longest);
}
