/// A moving object compared with scenes that contain it: its light, its shadow, its mirror images, and walls that light
/// must not pass.
#include "resolvent/frame.h"
#include "resolvent/mover.h"
#include "resolvent/render.h"

#include "light_fixture.h"

enum { width = 64, height = 48, pixel_count = width * height, samples = 4 };

static const rsv_vec3 place = { 0.4f, 0.9f, 0.3f };

/// A room with a lamp under its ceiling.
static world *room_world(int threads)
{
    world *w = world_begin(threads);
    world_room(w, world_lambert(w, 0.5f, 0), v3(-2, 0, -2), v3(2, 3, 2));
    world_quad(w, world_lambert(w, 0, 20), v3(-0.4f, 2.9f, -0.4f), v3(0.4f, 2.9f, -0.4f),
        v3(0.4f, 2.9f, 0.4f), v3(-0.4f, 2.9f, 0.4f));
    rsv_camera camera =
        rsv_camera_look_at("corner", v3(1.8f, 1.8f, 1.8f), v3(-0.6f, 0.8f, -0.4f), 1.1f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    return w;
}

/// The same with a mirror on its wall and a block of glass.
static world *clear_world(int threads)
{
    world *w = room_world(threads);
    world_quad(w, world_material(w, mirror_material(0.9f)), v3(-1.9f, 0.3f, 1.5f),
        v3(-1.9f, 0.3f, -1.5f), v3(-1.9f, 2.5f, -1.5f), v3(-1.9f, 2.5f, 1.5f));
    world_box(w, world_material(w, glass_material()), v3(0.7f, 0.2f, 0.6f), v3(1, 1.4f, 1.2f));
    return w;
}

static void add_ball(world *w, rsv_vec3 centre)
{
    world_sphere(w, world_lambert(w, 0.7f, 0), centre, 0.4f, 3);
}

static void commit(world *w) { assert_int_equal(rsv_scene_commit(w->scene), RSV_OK); }

static world *ball_alone(void)
{
    world *w = world_begin(1);
    add_ball(w, v3(0, 0, 0));
    commit(w);
    return w;
}

static rsv_light *solve(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 800;
    desc.rays_per_element = 128;
    desc.photon_count = 20000;
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

static rsv_mover *begin_mover(const rsv_light *solution, const world *body, rsv_vec3 offset)
{
    rsv_mover *mover;
    if (rsv_mover_create(solution, body->scene, NULL, &mover) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    assert_int_equal(rsv_mover_place(mover, offset, 30), RSV_OK);
    return mover;
}

// ---- its light ----------------------------------------------------------------------------------

enum { reading_count = 48 };

/// Some of its vertices as virtual receivers.
static size_t list_vertices(const rsv_mover *mover, const world *body, rsv_probe *probe)
{
    const rsv_scene_view *view = rsv_scene_get_view(body->scene);
    size_t step = view->vertex_count / reading_count;
    for (size_t k = 0; k < reading_count; k++) {
        rsv_vec3 at = rsv_mover_point(mover, view->position[k * step]);
        probe[k] = (rsv_probe){ at, v3_sub(at, place) };
    }
    return step;
}

/// RMS of what the object shows less some readings, and its mean, relative to their mean.
static void compare_light(const rsv_mover *mover, size_t step, const rsv_probe_reading *reading,
    double *rms, double *bias)
{
    double squares = 0, exact = 0, shown = 0;
    for (size_t k = 0; k < reading_count; k++) {
        double a = (double)rsv_mover_irradiance(mover)[k * step].g;
        double b = (double)reading[k].irradiance.g;
        squares += (a - b) * (a - b) / reading_count;
        shown += a / reading_count;
        exact += b / reading_count;
    }
    *rms = sqrt(squares) / exact;
    *bias = shown / exact - 1;
}

/// Readings of the scene alone do not include what the object does to its own light, such as its shadow on the floor
/// below it. Readings of a scene that contains the object do; their noise is about 0.02.
static void light_on_it_is_that_of_the_scene(void **state)
{
    (void)state;
    world *w = room_world(2), *with = room_world(2), *body = ball_alone();
    commit(w);
    add_ball(with, place);
    commit(with);
    rsv_light *solution = solve(w);
    rsv_mover *mover = begin_mover(solution, body, place);
    rsv_probe probe[reading_count];
    rsv_probe_reading reading[reading_count];
    double rms, bias;
    size_t step = list_vertices(mover, body, probe);
    assert_int_equal(rsv_probe_irradiance(solution,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 1024, 1 },
                         probe, reading_count, reading),
        RSV_OK);
    compare_light(mover, step, reading, &rms, &bias);
    print_message("beside the scene: RMS %.4f, mean %+.4f\n", rms, bias);
    assert_true(rms < 0.015 && fabs(bias) < 0.005);
    assert_int_equal(
        rsv_probe_reference(with->scene, probe, reading_count, 1024, 1, reading), RSV_OK);
    compare_light(mover, step, reading, &rms, &bias);
    print_message("beside one that holds it: RMS %.4f, mean %+.4f\n", rms, bias);
    assert_true(rms < 0.1 && fabs(bias) < 0.05);
    rsv_mover_destroy(mover);
    rsv_light_destroy(solution);
    world_end(body);
    world_end(with);
    world_end(w);
}

/// Two closed rooms, a lamp in one, a wall a millimetre thick between them; probes are 25 cm apart.
static void nothing_leaks_through_a_thin_wall(void **state)
{
    (void)state;
    world *w = world_begin(2), *body = ball_alone();
    uint32_t white = world_lambert(w, 0.7f, 0);
    world_room(w, white, v3(-2, 0, -1), v3(-0.0005f, 2, 1));
    world_room(w, white, v3(0.0005f, 0, -1), v3(2, 2, 1));
    world_quad(w, world_lambert(w, 0, 20), v3(-1.2f, 1.9f, -0.2f), v3(-0.8f, 1.9f, -0.2f),
        v3(-0.8f, 1.9f, 0.2f), v3(-1.2f, 1.9f, 0.2f));
    commit(w);
    rsv_light *solution = solve(w);
    size_t count = rsv_scene_get_view(body->scene)->vertex_count;
    double bright = 0, dark = 0;
    rsv_mover *mover = begin_mover(solution, body, v3(-0.401f, 0.8f, 0));
    for (size_t v = 0; v < count; v++)
        bright += (double)rsv_mover_irradiance(mover)[v].g;
    assert_int_equal(rsv_mover_place(mover, v3(0.401f, 0.8f, 0), 0), RSV_OK);
    for (size_t v = 0; v < count; v++)
        dark += (double)rsv_mover_irradiance(mover)[v].g;
    assert_true(bright > 0);
    assert_true(dark <= 1e-6 * bright);
    rsv_mover_destroy(mover);
    rsv_light_destroy(solution);
    world_end(body);
    world_end(w);
}

// ---- its images and its shadow ------------------------------------------------------------------

static void render(const rsv_light *solution, const rsv_mover *mover, rsv_rgb *picture)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = width;
    desc.height = height;
    desc.gloss = RSV_GLOSS_PATHS;
    rsv_frame_renderer *renderer;
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_OK);
    rsv_frame_renderer_put(renderer, mover);
    const rsv_camera *camera = rsv_scene_get_view(rsv_light_scene(solution))->camera;
    rsv_frame_view view = { .camera = { camera[0], camera[0] } };
    for (int k = 0; k < samples; k++)
        assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
    rsv_frame_radiance(renderer, 0, picture);
    rsv_frame_renderer_destroy(renderer);
}

static double distance(const rsv_rgb *a, const rsv_rgb *b)
{
    double sum = 0;
    for (size_t k = 0; k < pixel_count; k++)
        sum += ((double)a[k].g - (double)b[k].g) * ((double)a[k].g - (double)b[k].g);
    return sqrt(sum / pixel_count);
}

static void pictures_are_those_of_a_scene_that_holds_it(void **state)
{
    (void)state;
    static rsv_rgb empty[pixel_count], moved[pixel_count], held[pixel_count];
    world *w = clear_world(2), *with = clear_world(2), *body = ball_alone();
    commit(w);
    add_ball(with, place);
    commit(with);
    rsv_light *solution = solve(w), *fresh = solve(with);
    rsv_mover *mover = begin_mover(solution, body, place);
    render(solution, NULL, empty);
    render(solution, mover, moved);
    render(fresh, NULL, held);
    print_message(
        "off by %.4f with it, by %.4f without\n", distance(moved, held), distance(empty, held));
    assert_true(distance(moved, held) < 0.2 * distance(empty, held));
    rsv_mover_destroy(mover);
    rsv_light_destroy(fresh);
    rsv_light_destroy(solution);
    world_end(body);
    world_end(with);
    world_end(w);
}

static void render_with_threads(int threads, rsv_rgb *picture)
{
    world *w = clear_world(threads), *body = ball_alone();
    commit(w);
    rsv_light *solution = solve(w);
    rsv_mover *mover = begin_mover(solution, body, place);
    render(solution, mover, picture);
    rsv_mover_destroy(mover);
    rsv_light_destroy(solution);
    world_end(body);
    world_end(w);
}

static void any_number_of_threads_gives_the_same_picture(void **state)
{
    (void)state;
    static rsv_rgb one[pixel_count], three[pixel_count];
    render_with_threads(1, one);
    render_with_threads(3, three);
    assert_memory_equal(one, three, sizeof one);
}

static void failing_allocations_leave_nothing_behind(void **state)
{
    (void)state;
    world *w = clear_world(1), *body = ball_alone();
    commit(w);
    rsv_light *solution = solve(w);
    rsv_mover *mover = NULL;
    for (long k = 0; !mover; k++) {
        w->until_failure = k;
        rsv_status status = rsv_mover_create(solution, body->scene, NULL, &mover);
        w->until_failure = -1;
        assert_true(status == RSV_OK || status == RSV_ERROR_MEMORY);
    }
    rsv_mover_destroy(mover);
    rsv_light_destroy(solution);
    world_end(body);
    world_end(w);
}

static void unusable_wishes_are_refused(void **state)
{
    (void)state;
    world *w = clear_world(1), *body = ball_alone();
    commit(w);
    rsv_light *solution = solve(w);
    rsv_mover *mover = NULL;
    rsv_mover_desc desc = rsv_default_mover_desc();
    desc.light_samples = 0;
    assert_int_equal(rsv_mover_create(solution, body->scene, &desc, &mover), RSV_ERROR_ARGUMENT);
    desc = rsv_default_mover_desc();
    desc.probe_spacing = 1e-6f;
    assert_int_equal(rsv_mover_create(solution, body->scene, &desc, &mover), RSV_ERROR_ARGUMENT);
    mover = begin_mover(solution, body, place);
    assert_int_equal(rsv_mover_place(mover, v3(NAN, 0, 0), 0), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_mover_place(mover, v3(0, 0, 0), INFINITY), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_mover_place(mover, v3(1e5f, 0, 0), 0), RSV_OK);
    rsv_mover_destroy(mover);
    rsv_light_destroy(solution);
    world_end(body);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_on_it_is_that_of_the_scene),
        cmocka_unit_test(nothing_leaks_through_a_thin_wall),
        cmocka_unit_test(pictures_are_those_of_a_scene_that_holds_it),
        cmocka_unit_test(any_number_of_threads_gives_the_same_picture),
        cmocka_unit_test(failing_allocations_leave_nothing_behind),
        cmocka_unit_test(unusable_wishes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
