/// Environments: lookup, sampling, irradiance, division, suns, in the operator and in mode reference.
#include "light_fixture.h"
#include "slow_tests.h"

#include "core/octahedral.h"
#include "light_view.h"
#include "resolvent/render.h"
#include "sources/environment.h"
#include "specular/escapes.h"

static rsv_environment picture(const rsv_rgb *pixels, uint32_t width, uint32_t height)
{
    return (rsv_environment){
        .name = "sky", .pixels = pixels, .width = width, .height = height, .intensity = 1
    };
}

/// A picture of `radiance(direction)` at the centres of its pixels.
static rsv_rgb *paint(uint32_t width, uint32_t height, rsv_rgb (*radiance)(rsv_vec3))
{
    rsv_rgb *pixels = malloc((size_t)width * height * sizeof *pixels);
    rsv_sky sky = { NULL, width, height, 0 };
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            pixels[(size_t)y * width + x] = radiance(rsv_sky_pixel_direction(&sky, x, y));
    return pixels;
}

static rsv_rgb smooth_sky(rsv_vec3 d)
{
    return rgb(1 + 0.5f * d.x, 1 + 0.3f * d.y * d.z, 1.5f - d.z);
}

/// Dim, with a window of 0.1 sr at a contrast of 60.
static rsv_rgb contrasty_sky(rsv_vec3 d)
{
    bool window = fabsf(d.y - 0.5f) < 0.15f && d.x > 0 && fabsf(d.z) < 0.2f;
    return window ? rgb(30, 25, 20) : rgb(0.5f, 0.5f, 0.6f);
}

/// Bright patches all around; half of them are behind any surface.
static rsv_rgb patchy_sky(rsv_vec3 d)
{
    bool patch = sinf(9 * d.x) * sinf(9 * d.y + 1) * sinf(9 * d.z + 2) > 0.4f;
    return rgb_gray(patch ? 20 : 0.1f);
}

/// Dim, with a sun of 1 degree's radius.
static rsv_rgb sunny_sky(rsv_vec3 d)
{
    rsv_vec3 sun = v3_normalize(v3(0.8f, 0.3f, -0.2f));
    rsv_rgb sky = rgb(0.4f + 0.2f * d.y, 0.6f, 1);
    return v3_dot(d, sun) > cosf(RSV_PI / 180) ? rgb(9000, 8000, 6000) : sky;
}

static void directions_look_up_the_documented_pixels(void **state)
{
    (void)state;
    rsv_rgb pixels[8 * 4];
    for (int i = 0; i < 32; i++)
        pixels[i] = rgb_gray((float)i);
    rsv_sky sky = { pixels, 8, 4, 0 };
    uint32_t x, y;
    // -z at u = 1/4, +x in the middle, +z at u = 3/4: borders of columns, so a little beyond
    rsv_sky_pixel_at(&sky, v3_normalize(v3(0.01f, 0.01f, -1)), &x, &y);
    assert_true(x == 2 && y == 1);
    rsv_sky_pixel_at(&sky, v3_normalize(v3(1, -0.01f, 0.01f)), &x, &y);
    assert_true(x == 4 && y == 2);
    rsv_sky_pixel_at(&sky, v3_normalize(v3(-0.01f, 0.01f, 1)), &x, &y);
    assert_true(x == 6 && y == 1);
    rsv_sky_pixel_at(&sky, v3_normalize(v3(0.1f, 1, 0.01f)), &x, &y);
    assert_int_equal(y, 0);
    for (uint32_t i = 0; i < 32; i++) {
        rsv_vec3 centre = rsv_sky_pixel_direction(&sky, i % 8, i / 8);
        assert_float_equal(rsv_sky_radiance(&sky, centre).r, i, 1e-4);
    }
}

static void turning_moves_the_sky_counter_clockwise_from_above(void **state)
{
    (void)state;
    rsv_rgb *pixels = paint(64, 32, smooth_sky);
    rsv_environment still = picture(pixels, 64, 32), turned = still;
    turned.rotation = 90; // what was at +x is now at -z
    rsv_sky a = rsv_sky_from_environment(&still), b = rsv_sky_from_environment(&turned);
    rsv_random random = rsv_random_from(1, 2, 3);
    for (int k = 0; k < 100; k++) {
        float x = rsv_random_float(&random);
        rsv_vec3 d = rsv_square_to_sphere(x, rsv_random_float(&random));
        rsv_rgb before = rsv_sky_radiance(&a, d), after = rsv_sky_radiance(&b, v3(d.z, d.y, -d.x));
        assert_float_equal(before.r, after.r, 1e-4);
        assert_float_equal(before.b, after.b, 1e-4);
    }
    free(pixels);
}

static void the_sampler_draws_what_its_density_says(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_rgb *pixels = paint(96, 48, contrasty_sky);
    rsv_sky sky = { pixels, 96, 48, 0.1f };
    rsv_sky_sampler sampler;
    assert_int_equal(rsv_sky_sampler_create(w->context, &sky, &sampler), RSV_OK);
    enum { SIDE = 8, SAMPLES = 1 << 18 };
    double count[SIDE * SIDE] = { 0 }, expected[SIDE * SIDE] = { 0 }, flux = 0, integral = 0;
    for (uint32_t k = 0; k < SAMPLES; k++) {
        float x, y;
        rsv_sobol_2d(k, 77, &x, &y);
        rsv_vec3 d;
        float pdf = rsv_sky_sample(&sampler, x, y, &d);
        assert_float_equal(rsv_sky_pdf(&sampler, d) / pdf, 1, 0.7); // a neighbour's at a border
        count[rsv_octahedral_bin(d, SIDE)] += 1;
        flux += rgb_luminance(rsv_sky_radiance(&sky, d)) / pdf / SAMPLES;
        d = rsv_square_to_sphere(x, y);
        pdf = rsv_sky_pdf(&sampler, d);
        expected[rsv_octahedral_bin(d, SIDE)] += 4 * M_PI * pdf;
        integral += 4 * M_PI * pdf / SAMPLES;
    }
    assert_float_equal(integral, 1, 2e-3);
    assert_float_equal(flux, sampler.flux, 1e-3 * flux);
    assert_float_equal(flux, rgb_luminance(rsv_sky_flux(&sky)), 2e-3 * flux);
    for (int bin = 0; bin < SIDE * SIDE; bin++) // stratified: far below the noise of counting
        assert_float_equal(count[bin], expected[bin], 4 * sqrt(expected[bin]) + 5);
    rsv_sky_sampler_destroy(w->context, &sampler);
    free(pixels);
    world_end(w);
}

static void the_irradiance_table_is_the_integral(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_rgb *pixels = paint(128, 64, smooth_sky);
    rsv_sky sky = { pixels, 128, 64, 0 };
    rsv_sky_irradiance table;
    assert_int_equal(rsv_sky_irradiance_create(w->context, &sky, &table), RSV_OK);
    rsv_random random = rsv_random_from(4, 5, 6);
    for (int k = 0; k < 50; k++) {
        float x = rsv_random_float(&random);
        rsv_vec3 n = rsv_square_to_sphere(x, rsv_random_float(&random));
        rsv_rgb e = rsv_sky_irradiance_at(&table, n);
        // of 1 + a d.x: pi + 2 pi / 3 a n.x; of d.y d.z: pi / 4 n.y n.z
        assert_float_equal(e.r, RSV_PI * (1 + n.x / 3), 3e-3);
        assert_float_equal(e.g, RSV_PI * (1 + 0.3f / 4 * n.y * n.z), 3e-3);
        assert_float_equal(e.b, RSV_PI * (1.5f - 2 * n.z / 3), 4e-3);
    }
    rsv_sky_irradiance_destroy(w->context, &table);
    free(pixels);
    world_end(w);
}

static void suns_leave_the_picture_with_their_energy(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_rgb *pixels = paint(720, 360, sunny_sky);
    rsv_sky sky = { pixels, 720, 360, 0.3f };
    rsv_rgb before = rsv_sky_flux(&sky);
    rsv_sun sun[RSV_MAX_SUNS];
    uint32_t count;
    assert_int_equal(rsv_extract_suns(w->context, &sky, pixels, sun, &count), RSV_OK);
    assert_int_equal(count, 1);
    rsv_rgb after = rsv_sky_flux(&sky);
    assert_float_equal(after.r + sun->radiance.r * sun->solid_angle, before.r, 1e-3 * before.r);
    assert_float_equal(after.b + sun->radiance.b * sun->solid_angle, before.b, 1e-3 * before.b);
    assert_float_equal(after.b, 4 * RSV_PI, 0.02);                    // the sky's blue alone
    assert_float_equal(sun->solid_angle, RSV_PI * 3.0462e-4, 1.5e-4); // two pixels
    // turned by 0.3 turns, which lowers the azimuth
    float phi = atan2f(-0.2f, 0.8f) - 0.6f * RSV_PI, r = sqrtf(0.68f / 0.77f);
    rsv_vec3 expected = v3(r * cosf(phi), 0.3f / sqrtf(0.77f), r * sinf(phi));
    assert_true(v3_dot(sun->direction, expected) > 1 - 1e-5f);
    free(pixels);
    world_end(w);
}

static void windows_are_no_suns(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_rgb *pixels = paint(128, 64, contrasty_sky);
    rsv_sky sky = { pixels, 128, 64, 0 };
    rsv_sun sun[RSV_MAX_SUNS];
    uint32_t count;
    assert_int_equal(rsv_extract_suns(w->context, &sky, pixels, sun, &count), RSV_OK);
    assert_int_equal(count, 0);
    free(pixels);
    world_end(w);
}

static void surround(world *w, rsv_environment environment)
{
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
}

static void the_parts_add_up_to_the_whole(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_rgb *pixels = paint(360, 180, contrasty_sky);
    surround(w, picture(pixels, 360, 180));
    rsv_environment_light *light;
    assert_int_equal(rsv_environment_light_create(w->scene, &light), RSV_OK);
    assert_int_equal(rsv_environment_light_divide(light), RSV_OK);
    assert_true(light->sampler.flux > 0 && light->sun_count == 0);
    rsv_random random = rsv_random_from(7, 8, 9);
    for (int k = 0; k < 1000; k++) {
        float x = rsv_random_float(&random);
        rsv_vec3 d = rsv_square_to_sphere(x, rsv_random_float(&random));
        rsv_rgb parts =
            rgb_add(rsv_sky_radiance(&light->gathered, d), rsv_sky_radiance(&light->sampled, d));
        rsv_rgb whole = rsv_sky_radiance(&light->whole, d);
        assert_float_equal(parts.r, whole.r, 1e-4 * whole.r);
        assert_float_equal(parts.b, whole.b, 1e-4 * whole.b);
    }
    rsv_environment_light_destroy(light);
    free(pixels);
    world_end(w);
}

static void add_quad(world *w, rsv_vec3 corner, rsv_vec3 edge1, rsv_vec3 edge2, float albedo)
{
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(albedo);
    material.specular = 0;
    material.roughness = 1;
    material.double_sided = true;
    uint32_t id, mesh_id;
    assert_int_equal(rsv_scene_add_material(w->scene, &material, &id), RSV_OK);
    const rsv_vec3 far = v3_add(v3_add(corner, edge1), edge2);
    const rsv_vec3 position[6] = { corner, v3_add(corner, edge1), far, corner, far,
        v3_add(corner, edge2) };
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "quad",
        .positions = position,
        .vertex_count = 6,
        .triangle_count = 2,
        .material = id };
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &mesh_id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, mesh_id, NULL, NULL), RSV_OK);
}

static rsv_light *solve_with(world *w, uint32_t elements)
{
    rsv_light *solution;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    if (elements) desc.element_target = elements;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

static rsv_light *solve(world *w) { return solve_with(w, 0); }

/// For what has to be exact with any elements.
static rsv_light *solve_coarsely(world *w) { return solve_with(w, 500); }

/// A white floor alone under radiance 1: irradiance pi, everywhere, exactly.
static void a_constant_sky_is_exact(void **state)
{
    (void)state;
    world *w = world_begin(2);
    add_quad(w, v3(-1, 0, -1), v3(0, 0, 2), v3(2, 0, 0), 0.8f);
    rsv_rgb pixel = rgb(1, 2, 0.5f);
    surround(w, picture(&pixel, 1, 1));
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *solution = solve(w);
    for (int k = 0; k < 20; k++) {
        float u = 0.03f + 0.045f * (float)k;
        rsv_rgb e = rsv_light_irradiance(solution, 0, u, 0.5f * (1 - u), false, RSV_NONE);
        assert_float_equal(e.r, RSV_PI, 1e-4);
        assert_float_equal(e.g, 2 * RSV_PI, 2e-4);
        assert_float_equal(e.b, 0.5f * RSV_PI, 1e-4);
    }
    rsv_light_destroy(solution);
    world_end(w);
}

/// A new environment through the stored escapes, compared with an operator built under it.
static void turning_the_sky_takes_no_new_rays(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-spheres");
    rsv_rgb *pixels = paint(128, 64, smooth_sky);
    rsv_environment sky = picture(pixels, 128, 64);
    surround(w, sky);
    rsv_light *still = solve_coarsely(w);
    sky.rotation = 137;
    sky.intensity = 0.5f;
    surround(w, sky);
    rsv_light *turned = solve_coarsely(w);
    assert_int_equal(inside(still)->elements->node_count, inside(turned)->elements->node_count);
    size_t nodes = inside(still)->elements->node_count;
    rsv_rgb *before = malloc(nodes * sizeof *before), *after = malloc(nodes * sizeof *after);
    rsv_transport_environment(inside(still)->transport, inside(turned)->bin_radiance, before);
    rsv_transport_environment(inside(turned)->transport, inside(turned)->bin_radiance, after);
    assert_memory_equal(before, after, nodes * sizeof *before);
    free(before);
    free(after);
    rsv_light_destroy(still);
    rsv_light_destroy(turned);
    free(pixels);
    world_end(w);
}

/// A room without its front, and a wall in the middle, under a sky that is mostly one bright window.
static world *room_under(const rsv_rgb *pixels, uint32_t width, uint32_t height)
{
    world *w = world_begin(2);
    add_quad(w, v3(-1, 0, -1), v3(0, 0, 2), v3(2, 0, 0), 0.7f);   // floor
    add_quad(w, v3(-1, 2, -1), v3(2, 0, 0), v3(0, 0, 2), 0.7f);   // ceiling
    add_quad(w, v3(-1, 0, -1), v3(0, 2, 0), v3(0, 0, 2), 0.5f);   // -x
    add_quad(w, v3(-1, 0, -1), v3(2, 0, 0), v3(0, 2, 0), 0.6f);   // -z
    add_quad(w, v3(-1, 0, 1), v3(0, 2, 0), v3(2, 0, 0), 0.4f);    // +z
    add_quad(w, v3(1, 0, -1), v3(0, 0.6f, 0), v3(0, 0, 2), 0.5f); // +x below the window
    surround(w, picture(pixels, width, height));
    rsv_camera camera = rsv_camera_look_at("eye", v3(0.9f, 1, 0.8f), v3(-1, 0.7f, -0.6f), 1.2f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static double mean_luminance(const rsv_image *image)
{
    const rsv_rgb *pixels = rsv_image_const_pixels(image, 0);
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += rgb_luminance(pixels[i]);
    return sum / (double)count;
}

static void check_room(rsv_rgb (*radiance)(rsv_vec3))
{
    rsv_rgb *pixels = paint(256, 128, radiance);
    world *w = room_under(pixels, 256, 128);
    rsv_light *solution = solve(w);
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = 32;
    desc.samples = 512;
    rsv_image *reference, *looked_up, *final;
    assert_int_equal(rsv_render_reference(w->scene, &desc, &reference, NULL), RSV_OK);
    desc.samples = 16;
    desc.mode = RSV_RENDER_OPERATOR;
    assert_int_equal(rsv_render(solution, &desc, &looked_up), RSV_OK);
    desc.mode = RSV_RENDER_FINAL;
    assert_int_equal(rsv_render(solution, &desc, &final), RSV_OK);
    double expected = mean_luminance(reference);
    assert_float_equal(mean_luminance(looked_up), expected, 0.01 * expected);
    assert_float_equal(mean_luminance(final), expected, 0.01 * expected);
    rsv_image_destroy(reference);
    rsv_image_destroy(looked_up);
    rsv_image_destroy(final);
    rsv_light_destroy(solution);
    free(pixels);
    world_end(w);
}

static void a_room_under_a_contrasty_sky_agrees_with_the_reference(void **state)
{
    (void)state;
    check_room(contrasty_sky);
}

static void a_room_under_a_sun_agrees_with_the_reference(void **state)
{
    (void)state;
    check_room(sunny_sky);
}

/// Two camera rays a pixel, each of whose shadow rays sees a part of the sky: on average what many see.
static void few_rays_find_as_much_sky_as_many(void **state)
{
    (void)state;
    enum { pictures = 48 };
    rsv_rgb *pixels = paint(256, 128, patchy_sky);
    world *w = world_begin(2);
    add_quad(w, v3(-2, 0, 2), v3(4, 0, 0), v3(0, 0, -4), 0.5f);
    add_quad(w, v3(-2, 0, -2), v3(4, 0, 0), v3(0, 3, 0), 0.5f);
    world_box(w, world_lambert(w, 0.5f, 0), v3(-0.5f, 0.1f, -0.5f), v3(0.5f, 1, 0.5f));
    surround(w, picture(pixels, 256, 128));
    rsv_camera camera = rsv_camera_look_at("eye", v3(2, 2, 3), v3(0, 0.3f, 0), 0.7f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *solution = solve(w);
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_FINAL;
    desc.width = desc.height = 24;
    double mean[2] = { 0, 0 };
    for (uint32_t k = 0; k < pictures + 1; k++) {
        rsv_image *image;
        desc.samples = k ? 2 : 1024;
        desc.seed = k;
        assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
        mean[k > 0] += mean_luminance(image) / (k ? pictures : 1);
        rsv_image_destroy(image);
    }
    print_message("two rays: %.4f of what many find\n", mean[1] / mean[0]);
    assert_float_equal(mean[1], mean[0], 4e-3 * mean[0]);
    rsv_light_destroy(solution);
    free(pixels);
    world_end(w);
}

static void one_pixel_is_a_constant_sky(void **state)
{
    (void)state;
    world *w = world_begin(2);
    add_quad(w, v3(-1, 0, 1), v3(2, 0, 0), v3(0, 0, -2), 0.5f);
    rsv_rgb pixel = { 2, 2, 2 };
    surround(w, picture(&pixel, 1, 1));
    world_commit(w);
    rsv_probe probe = { v3(0, 0.1f, 0), v3(0, 1, 0) };
    rsv_probe_reading solved, traced;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    assert_int_equal(rsv_probe_irradiance(solution,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 1024, 1 },
                         &probe, 1, &solved),
        RSV_OK);
    assert_int_equal(rsv_probe_reference(w->scene, &probe, 1, 1024, 1, &traced), RSV_OK);
    assert_float_equal(solved.irradiance.g, 2 * RSV_PI, 1e-3);
    assert_float_equal(traced.irradiance.g, 2 * RSV_PI, 0.02);
    rsv_light_destroy(solution);
    world_end(w);
}

/// A floor of albedo 0.8 shows about 1 under either: pictures need no exposure.
static void surroundings_without_a_file_light_a_floor(void **state)
{
    (void)state;
    for (const char *const *name = rsv_environment_builtin_names(); *name; name++) {
        world *w = world_begin(1);
        add_quad(w, v3(-1, 0, 1), v3(2, 0, 0), v3(0, 0, -2), 0.8f);
        assert_true(rsv_environment_is_builtin(*name));
        assert_int_equal(rsv_scene_set_builtin_environment(w->scene, *name, 1, 0), RSV_OK);
        world_commit(w);
        rsv_probe probe = { v3(0, 0.1f, 0), v3(0, 1, 0) };
        rsv_probe_reading traced;
        assert_int_equal(rsv_probe_reference(w->scene, &probe, 1, 4096, 1, &traced), RSV_OK);
        float shown = 0.8f / RSV_PI * rgb_luminance(traced.irradiance);
        print_message("%s: %.3f\n", *name, (double)shown);
        assert_true(shown > 0.6f && shown < 1.1f);
        assert_int_equal(
            rsv_scene_set_builtin_environment(w->scene, "night", 1, 0), RSV_ERROR_ARGUMENT);
        world_end(w);
    }
}

static void broken_pictures_are_repaired_or_refused(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_rgb pixels[4] = { { NAN, -1, 2 }, { INFINITY, 1, 1 }, { 3, 3, 3 }, { 1e38f, 0, 0 } };
    surround(w, picture(pixels, 2, 2));
    const rsv_environment *kept = rsv_scene_get_view(w->scene)->environment;
    for (int i = 0; i < 12; i++)
        assert_true((&kept->pixels[0].r)[i] >= 0 && (&kept->pixels[0].r)[i] <= 1e12f);
    rsv_environment environment = picture(pixels, 0, 2);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_ERROR_ARGUMENT);
    environment = picture(pixels, 1u << 20, 1u << 20);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_ERROR_UNSUPPORTED);
    environment = picture(pixels, 2, 2);
    environment.intensity = NAN;
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_ERROR_ARGUMENT);
    environment.intensity = 1;
    environment.rotation = INFINITY;
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_ERROR_ARGUMENT);
    assert_ptr_equal(rsv_scene_get_view(w->scene)->environment, kept);
    assert_int_equal(rsv_scene_set_environment(w->scene, NULL), RSV_OK);
    assert_null(rsv_scene_get_view(w->scene)->environment);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(directions_look_up_the_documented_pixels),
        cmocka_unit_test(turning_moves_the_sky_counter_clockwise_from_above),
        cmocka_unit_test(the_sampler_draws_what_its_density_says),
        cmocka_unit_test(the_irradiance_table_is_the_integral),
        cmocka_unit_test(suns_leave_the_picture_with_their_energy),
        cmocka_unit_test(windows_are_no_suns),
        cmocka_unit_test(the_parts_add_up_to_the_whole),
        cmocka_unit_test(a_constant_sky_is_exact),
        cmocka_unit_test(one_pixel_is_a_constant_sky),
        cmocka_unit_test(surroundings_without_a_file_light_a_floor),
        cmocka_unit_test(broken_pictures_are_repaired_or_refused),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(turning_the_sky_takes_no_new_rays),
        cmocka_unit_test(a_room_under_a_contrasty_sky_agrees_with_the_reference),
        cmocka_unit_test(few_rays_find_as_much_sky_as_many),
        cmocka_unit_test(a_room_under_a_sun_agrees_with_the_reference),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
