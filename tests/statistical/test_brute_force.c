/// Light by way of coats, sheets and mirrors: the path tracer and mode final compared with paths that do no next-event
/// estimation and hit their lamp only by chance.
#include "core/sampling.h"
#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "trace/camera_ray.h"
#include "unit/light_fixture.h"
#include "unit/slow_tests.h"

#define SIDE 16 ///< pixels
#define BLOCKS 2
#define ORDERS 2 ///< emission, direct
#define MOST_EVENTS 64

// ---- the judge ----------------------------------------------------------------------------------

/// The current vertex of a path.
typedef struct arrival {
    rsv_bsdf storage;
    const rsv_bsdf *bsdf;
    rsv_surface_point point; ///< on the side that the path came to
    rsv_vec3 normal;         ///< of the lobes
    bool front;
} arrival;

static bool arrive(const world *w, const rsv_ray *ray, arrival *a)
{
    rsv_hit hit;
    const rsv_scene_view *view = w->transport.view;
    if (!rsv_tracer_closest(w->tracer, ray, &hit)) return false;
    a->point = rsv_surface_point_seen(view, hit.triangle, hit.u, hit.v, false, 0);
    a->front = v3_dot(a->point.geometric, ray->direction) < 0;
    if (!a->front) a->point = rsv_surface_point_seen(view, hit.triangle, hit.u, hit.v, true, 0);
    a->bsdf = rsv_surface_bsdf(view, w->bsdf,
        (rsv_footprint){ hit.triangle, hit.u, hit.v, 0, RSV_CHANNEL_ALL }, &a->storage);
    rsv_vec3 wo = v3_neg(ray->direction);
    a->normal = rsv_bsdf_specular_normal(a->point.normal, a->point.geometric, wo);
    return true;
}

/// Sends the path on. @return false if it ends
static bool leave(const arrival *a, bool transmitted, rsv_vec3 direction, rsv_ray *ray)
{
    rsv_vec3 side = transmitted ? v3_neg(a->point.geometric) : a->point.geometric;
    ray->origin = rsv_offset_origin(a->point.position, side, a->point.extent);
    ray->direction = direction;
    return v3_dot(side, direction) > 0;
}

/// Adds the light that a path finds, by its diffuse events; it samples only the BSDFs.
static void follow(const world *w, rsv_ray ray, uint32_t orders, rsv_random *random, double *found)
{
    rsv_rgb throughput = rgb_gray(1);
    arrival a;
    for (uint32_t order = 0, events = 0; events < MOST_EVENTS && arrive(w, &ray, &a); events++) {
        if (rsv_random_float(random) >= a.bsdf->opacity) {
            if (!leave(&a, true, ray.direction, &ray)) return;
            continue;
        }
        if (a.front || a.bsdf->double_sided)
            found[order] += (double)rgb_luminance(rgb_mul(throughput, a.bsdf->emission));
        float u[3];
        for (int k = 0; k < 3; k++)
            u[k] = rsv_random_float(random);
        rsv_bsdf_sample s =
            rsv_bsdf_sample_direction(a.bsdf, v3_neg(ray.direction), a.normal, a.front, u);
        order += s.lobe == RSV_LOBE_DIFFUSE;
        if (s.lobe == RSV_LOBE_NONE || order == orders) return;
        throughput = rgb_mul(throughput, s.weight);
        if (!leave(&a, s.lobe == RSV_LOBE_TRANSMIT, s.direction, &ray)) return;
    }
}

/// Sums over one block of pixels.
typedef struct block_sum {
    double sum, squares, count;
} block_sum;

static void add_to(block_sum *b, double value)
{
    b->sum += value;
    b->squares += value * value;
    b->count += 1;
}

static double mean_of(const block_sum *b) { return b->sum / b->count; }

static double error_of(const block_sum *b)
{
    double mean = mean_of(b);
    return sqrt(fmax(b->squares / b->count - mean * mean, 0) / b->count);
}

static uint32_t block_at(uint32_t x, uint32_t y)
{
    return y / (SIDE / BLOCKS) * BLOCKS + x / (SIDE / BLOCKS);
}

static void judge(const world *w, uint32_t orders, uint32_t samples, block_sum *block)
{
    const rsv_camera *camera = &w->transport.view->camera[0];
    const uint32_t order = orders - 1;
    for (uint32_t k = 0; k < SIDE * SIDE; k++) {
        rsv_random random = rsv_random_from(k, order, 0x6a75u);
        for (uint32_t n = 0; n < samples; n++) {
            double found[ORDERS] = { 0 };
            float x = (float)(k % SIDE) + rsv_random_float(&random);
            float y = (float)(k / SIDE) + rsv_random_float(&random);
            follow(w, rsv_camera_ray(camera, SIDE, SIDE, x, y), orders, &random, found);
            add_to(&block[block_at(k % SIDE, k / SIDE)], found[order]);
        }
    }
}

// ---- the judged ---------------------------------------------------------------------------------

/// Number of pictures of one mode, which differ only by chance.
#define PICTURES 8

static void look(const world *w, const rsv_light *solution, uint32_t samples,
    block_sum block[ORDERS][BLOCKS * BLOCKS])
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = solution ? RSV_RENDER_FINAL : RSV_RENDER_REFERENCE;
    desc.width = desc.height = SIDE;
    desc.samples = samples;
    desc.layers = true;
    for (desc.seed = 0; desc.seed < PICTURES; desc.seed++) {
        rsv_image *image;
        double sum[ORDERS][BLOCKS * BLOCKS] = { { 0 } };
        rsv_status status = solution ? rsv_render(solution, &desc, &image)
                                     : rsv_render_reference(w->scene, &desc, &image, NULL);
        assert_int_equal(status, RSV_OK);
        for (uint32_t order = 0; order < ORDERS; order++)
            for (uint32_t k = 0; k < SIDE * SIDE; k++)
                sum[order][block_at(k % SIDE, k / SIDE)] +=
                    (double)rgb_luminance(rsv_image_const_pixels(image, 1 + order)[k]);
        for (uint32_t order = 0; order < ORDERS; order++)
            for (uint32_t b = 0; b < BLOCKS * BLOCKS; b++)
                add_to(&block[order][b], sum[order][b] * (BLOCKS * BLOCKS) / (double)(SIDE * SIDE));
        rsv_image_destroy(image);
    }
}

/// @param tolerated relative difference in addition to noise
static uint32_t compare(const char *what, uint32_t order, const block_sum *found,
    const block_sum *expected, double tolerated)
{
    static const char *const layer[ORDERS] = { "emission", "direct" };
    uint32_t wrong = 0;
    for (uint32_t b = 0; b < BLOCKS * BLOCKS; b++) {
        double is = mean_of(&found[b]), should = mean_of(&expected[b]);
        double error = hypot(error_of(&found[b]), error_of(&expected[b]));
        bool right = fabs(is - should) <= tolerated * should + 4 * error;
        print_message("%s, %s, block %u: %.5f +- %.5f, by chance %.5f +- %.5f%s\n", what,
            layer[order], b, is, error_of(&found[b]), should, error_of(&expected[b]),
            right ? "" : " WRONG");
        wrong += !right;
    }
    return wrong;
}

static uint32_t check_scene(world *w, const char *what)
{
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    static const uint32_t samples[ORDERS] = { 4096, 512 };
    block_sum expected[ORDERS][BLOCKS * BLOCKS] = { { { 0 } } };
    block_sum reference[ORDERS][BLOCKS * BLOCKS] = { { { 0 } } };
    block_sum final[ORDERS][BLOCKS * BLOCKS] = { { { 0 } } };
    uint32_t wrong = 0;
    print_message("%s\n", what);
    world_commit(w);
    assert_int_equal(rsv_light_create(w->scene, &solve, &solution), RSV_OK);
    look(w, NULL, 128, reference);
    look(w, solution, 64, final);
    for (uint32_t order = 0; order < ORDERS; order++) {
        judge(w, order + 1, samples[order], expected[order]);
        wrong += compare("reference", order, reference[order], expected[order], 0.002);
        wrong += compare("final", order, final[order], expected[order], order ? 0.01 : 0.002);
    }
    rsv_light_destroy(solution);
    world_end(w);
    return wrong;
}

// ---- scenes -------------------------------------------------------------------------------------

/// Under a strong coat.
static rsv_material paint(float roughness)
{
    rsv_material m = rsv_default_material();
    m.base_color = rgb(0.58f, 0.5f, 0.4f);
    m.roughness = roughness;
    m.ior = 2.2f;
    m.double_sided = true;
    return m;
}

/// A room under one material, a lamp in a corner of its ceiling that the camera does not see.
static world *painted_room(rsv_material walls)
{
    world *w = world_begin(2);
    rsv_material lamp = lambert_material(0, 10);
    lamp.double_sided = true;
    world_room(w, world_material(w, walls), v3(-1, -1, -1), v3(1, 1, 1));
    world_quad(w, world_material(w, lamp), v3(-0.9f, 0.9f, -0.9f), v3(0, 0.9f, -0.9f),
        v3(0, 0.9f, 0.3f), v3(-0.9f, 0.9f, 0.3f));
    rsv_camera camera =
        rsv_camera_look_at("eye", v3(-0.6f, -0.2f, 0.9f), v3(0.5f, -0.9f, -1), 1, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    return w;
}

static void check_room(rsv_material walls, const char *what)
{
    assert_int_equal(check_scene(painted_room(walls), what), 0);
}

static void paint_is_as_chance_finds_it(void **state)
{
    (void)state;
    check_room(paint(0.3162f), "paint");
}

static void clear_coats_are_as_chance_finds_them(void **state)
{
    (void)state;
    rsv_material m = paint(0.7f);
    m.clearcoat = 1;
    m.clearcoat_roughness = 0.3f;
    check_room(m, "clear coat");
    m.metallic = 0.5f;
    m.clearcoat_roughness = 0;
    check_room(m, "polish over half metal");
}

static void check_ball(rsv_material ball, const char *what)
{
    world *w = painted_room(paint(0.3162f));
    world_sphere(w, world_material(w, ball), v3(0.2f, -0.5f, -0.3f), 0.4f, 4);
    assert_int_equal(check_scene(w, what), 0);
}

static void balls_are_as_chance_finds_them(void **state)
{
    (void)state;
    rsv_material m = paint(0.3162f);
    m.metallic = 1;
    check_ball(m, "brass ball");
    check_ball(mirror_material(0.9f), "mirror ball");
}

/// Below the lamp.
static void check_sheet(rsv_material sheet, const char *what)
{
    world *w = painted_room(paint(0.3162f));
    sheet.double_sided = true;
    world_quad(w, world_material(w, sheet), v3(-1, 0.6f, -1), v3(0.6f, 0.6f, -1),
        v3(0.6f, 0.6f, 0.6f), v3(-1, 0.6f, 0.6f));
    assert_int_equal(check_scene(w, what), 0);
}

static void panes_are_as_chance_finds_them(void **state)
{
    (void)state;
    rsv_material m = glass_material();
    m.thickness = 0;
    check_sheet(m, "pane");
    m.roughness = 0.4f;
    check_sheet(m, "frosted pane");
}

static void thin_things_are_as_chance_finds_them(void **state)
{
    (void)state;
    rsv_material m = paint(0.4f);
    m.opacity = 0.4f;
    check_sheet(m, "veil");
    m.opacity = 1;
    m.diffuse_transmission = 0.5f;
    check_sheet(m, "leaf");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(paint_is_as_chance_finds_it),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(clear_coats_are_as_chance_finds_them),
        cmocka_unit_test(balls_are_as_chance_finds_them),
        cmocka_unit_test(panes_are_as_chance_finds_them),
        cmocka_unit_test(thin_things_are_as_chance_finds_them),
    };
    return RUN_HALF(argc, argv, quick, longest);
}
