/// Light in fog as solved on voxels, in pictures of both modes and at probes, against exact answers and the path tracer.
///
/// Columns between mirrors stand for slabs without end to the sides. Numbers for slabs are those of test_fog_reference.c.
#include "resolvent/certify.h"
#include "unit/fog_fixture.h"
#include "unit/slow_tests.h"

static rsv_light *solve_with(const world *w, size_t elements, uint32_t rays)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = elements;
    desc.rays_per_element = rays;
    assert_int_equal(rsv_light_create(w->scene, &desc, &light), RSV_OK);
    return light;
}

static rsv_fog box_of_fog(rsv_rgb extinction, rsv_rgb albedo, rsv_vec3 low, rsv_vec3 high)
{
    rsv_fog fog = rsv_default_fog();
    fog.extinction = extinction;
    fog.albedo = albedo;
    fog.bounds_min = low;
    fog.bounds_max = high;
    return fog;
}

/// Mirrors around a column of a square metre.
static void add_mirrors(world *w, float low, float high)
{
    const float a = 0.5f;
    uint32_t mirror = world_material(w, mirror_material(1));
    world_quad(w, mirror, v3(-a, low, -a), v3(-a, high, -a), v3(-a, high, a), v3(-a, low, a));
    world_quad(w, mirror, v3(a, low, a), v3(a, high, a), v3(a, high, -a), v3(a, low, -a));
    world_quad(w, mirror, v3(-a, low, -a), v3(a, low, -a), v3(a, high, -a), v3(-a, high, -a));
    world_quad(w, mirror, v3(-a, low, a), v3(-a, high, a), v3(a, high, a), v3(a, low, a));
}

static void add_sun(world *w)
{
    add_lamp(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL,
                    .direction = v3(0, -1, 0),
                    .intensity = rgb_gray(1) });
}

static void read_probe(
    const rsv_light *light, rsv_vec3 at, rsv_vec3 normal, uint32_t samples, estimate out[3])
{
    const rsv_probe probe = { at, normal };
    rsv_probe_reading reading;
    rsv_probe_desc desc = rsv_default_probe_desc();
    desc.samples = samples;
    assert_int_equal(rsv_probe_irradiance(light, &desc, &probe, 1, &reading), RSV_OK);
    for (int k = 0; k < 3; k++)
        out[k] = (estimate){ (double)channel(reading.irradiance, k),
            (double)channel(reading.standard_error, k) };
}

enum { PICTURE_SIDE = 8, PIXELS = PICTURE_SIDE * PICTURE_SIDE };

/// Mean radiance of a layer of a picture of PICTURE_SIDE x PICTURE_SIDE pixels, which are independent.
static void average_picture(
    const rsv_light *light, const rsv_render_desc *desc, uint32_t layer, estimate out[3])
{
    rsv_image *image;
    assert_int_equal(rsv_render(light, desc, &image), RSV_OK);
    const rsv_rgb *pixel = rsv_image_pixels(image, layer);
    for (int k = 0; k < 3; k++) {
        double sum = 0, squares = 0;
        for (int i = 0; i < PIXELS; i++) {
            double value = (double)channel(pixel[i], k);
            sum += value;
            squares += value * value;
        }
        double mean = sum / PIXELS, spread = fmax(squares / PIXELS - mean * mean, 0);
        out[k] = (estimate){ mean, sqrt(spread / (PIXELS - 1)) };
    }
    rsv_image_destroy(image);
}

static rsv_render_desc picture_of(const rsv_camera *camera, rsv_render_mode mode, uint32_t samples)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.width = desc.height = PICTURE_SIDE;
    desc.samples = samples;
    desc.viewpoint = camera;
    return desc;
}

/// @param layer 0 = all orders, 2 = light scattered once
static void see(const rsv_light *light, rsv_camera camera, rsv_render_mode mode, uint32_t samples,
    uint32_t layer, estimate out[3])
{
    rsv_render_desc desc = picture_of(&camera, mode, samples);
    desc.layers = layer > 0;
    average_picture(light, &desc, layer, out);
}

/// Looks along parallel rays, so that no single voxel counts for much.
static rsv_camera beam(rsv_vec3 from, rsv_vec3 towards)
{
    rsv_camera camera = needle(from, towards);
    camera.vertical_extent = 0.2f;
    return camera;
}

static const rsv_render_mode both_modes[2] = { RSV_RENDER_FINAL, RSV_RENDER_OPERATOR };

static const char *name_of(rsv_render_mode mode)
{
    return mode == RSV_RENDER_FINAL ? "final" : "operator";
}

// ---- absorption ---------------------------------------------------------------------------------

/// To a thousandth, without noise.
static void absorbing_slabs_follow_beer(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0, 1), v3(-99, 0, 99), v3(99, 0, 99), v3(99, 0, -99), v3(-99, 0, -99));
    fill(w, box_of_fog(rgb(0.1f, 1, 5), rgb_gray(0), v3(-20, 0.5f, -20), v3(20, 2, 20)));
    rsv_light *light = solve_with(w, 500, 64);
    for (int mode = 0; mode < 2; mode++)
        for (int aslant = 0; aslant < 2; aslant++) {
            estimate seen[3];
            see(light, needle(v3(aslant ? 6 : 0, 6, 0.01f), v3(0, 0, 0)), both_modes[mode], 1, 0,
                seen);
            for (int k = 0; k < 3; k++) {
                double depth = (k == 0 ? 0.1 : k == 1 ? 1 : 5) * 1.5 * (aslant ? sqrt(2) : 1);
                assert_close(seen[k].mean, exp(-depth), 1e-3 * exp(-depth));
            }
        }
    rsv_light_destroy(light);
    world_end(w);
}

/// A glowing sphere full of fog, and one with a point light: as in test_fog_reference.c, at a probe and where light is stored.
static void absorbing_spheres_follow_beer(void **state)
{
    (void)state;
    const float radius = 1.5f, sigma = 0.8f;
    const double t = 2 * (double)radius * (double)sigma, inside = 0.9995 * (double)radius;
    for (int lamp = 0; lamp < 2; lamp++) {
        world *w = world_begin(2);
        rsv_material wall = lambert_material(0, lamp ? 0 : 1);
        wall.double_sided = true;
        world_sphere(w, world_material(w, wall), v3(0, 0, 0), radius, 5);
        if (lamp) add_lamp(w, (rsv_punctual_light){ .intensity = rgb_gray(3) });
        fill(w, box_of_fog(rgb_gray(sigma), rgb_gray(0), v3(-2, -2, -2), v3(2, 2, 2)));
        rsv_light *light = solve_with(w, 500, 64);
        estimate read[3];
        rsv_vec3 out = v3_normalize(v3(1, 2, 3));
        read_probe(light, v3_scale(out, 0.9995f * radius), v3_neg(out), 16384, read);
        double at_wall = 2 * M_PI * (1 - (1 + t) * exp(-t)) / (t * t);
        if (lamp) at_wall = 3 * exp(-inside * (double)sigma) / (inside * inside);
        check("wall of an absorbing sphere", read[1], at_wall);
        rsv_light_destroy(light);
        world_end(w);
    }
}

// ---- scattering ---------------------------------------------------------------------------------

/// Mode final samples light that is scattered once, without using voxels.
static void lamps_beside_a_line_light_it_once(void **state)
{
    (void)state;
    const rsv_rgb sigma = { 0.05f, 0.4f, 2 };
    const float h = 0.5f, foot = 2;
    for (int spot = 0; spot < 2; spot++) {
        // in heterogeneous fog, orders after the first are not separated, so they must be faint
        const float g = spot ? 0 : 0.4f, albedo = spot ? 0.8f : 1e-3f;
        world *w = world_begin(2);
        // what ends the line
        world_quad(
            w, world_lambert(w, 0, 0), v3(-1, -1, -5), v3(1, -1, -5), v3(1, 1, -5), v3(-1, 1, -5));
        add_lamp(w, (rsv_punctual_light){ .kind = spot ? RSV_PUNCTUAL_SPOT : RSV_PUNCTUAL_POINT,
                        .position = v3(0, h, -foot),
                        .direction = v3(0, -1, 0),
                        .intensity = rgb_gray(2),
                        .inner_cone_angle = 0.6f,
                        .outer_cone_angle = 0.6f });
        rsv_fog fog = box_of_fog(sigma, rgb_gray(albedo), v3(-6, -6, -6), v3(6, 6, 6));
        fog.anisotropy = g;
        fill(w, fog);
        rsv_light *light = solve_with(w, 200, 64);
        estimate seen[3];
        see(light, needle(v3(0, 0, 0), v3(0, 0, -1)), RSV_RENDER_FINAL, 256, 2, seen);
        for (int k = 0; k < 3; k++)
            check(spot ? "spot" : "point", seen[k],
                (double)albedo * 2 *
                    once_along_line((double)channel(sigma, k), (double)g, (double)h, (double)foot,
                        5, spot ? cos((double)0.6f) : 0));
        rsv_light_destroy(light);
        world_end(w);
    }
}

/// What slabs under a vertical beam reflect and let through, one slab for each channel, of optical thickness and albedo
/// (0.5, 1), (1, 0.8), (2, 0.95).
static void slabs_reflect_and_transmit_as_chandrasekhar_says(void **state)
{
    (void)state;
    static const double exact[2][3] = { { 0.2025058, 0.2108463, 0.4287211 },
        { 0.7974939, 0.5413993, 0.4093064 } };
    world *w = world_begin(2);
    add_mirrors(w, -0.2f, 1.2f);
    add_sun(w);
    fill(w,
        box_of_fog(rgb(0.5f, 1, 2), rgb(1, 0.8f, 0.95f), v3(-0.5f, 0, -0.5f), v3(0.5f, 1, 0.5f)));
    rsv_light *light = solve_with(w, 6000, 256);
    for (int below = 0; below < 2; below++) {
        estimate read[3];
        read_probe(
            light, v3(0, below ? -0.1f : 1.1f, 0), v3(0, below ? 1.0f : -1.0f, 0), 1 << 18, read);
        for (int k = 0; k < 3; k++)
            check(below ? "transmitted" : "reflected", read[k], exact[below][k]);
    }
    rsv_light_destroy(light);
    world_end(w);
}

/// A mirror sends a beam back into a slab: as a slab twice as thick, what this reflects and transmits leaves on one side. The
/// beam itself, exp(-thickness), comes to no probe by way of a mirror.
static void mirrors_send_the_sun_into_fog(void **state)
{
    (void)state;
    static const double exact[3] = { 0.2025058 + 0.7974939 - 0.6065307,
        0.2108463 + 0.5413993 - 0.3678794, 0.4287211 + 0.4093064 - 0.1353353 };
    world *w = world_begin(2);
    estimate read[3];
    add_mirrors(w, 0, 0.7f);
    world_quad(w, world_material(w, mirror_material(1)), v3(-0.5f, 0, 0.5f), v3(0.5f, 0, 0.5f),
        v3(0.5f, 0, -0.5f), v3(-0.5f, 0, -0.5f));
    add_sun(w);
    fill(w, box_of_fog(
                rgb(0.5f, 1, 2), rgb(1, 0.8f, 0.95f), v3(-0.5f, 0, -0.5f), v3(0.5f, 0.5f, 0.5f)));
    rsv_light *light = solve_with(w, 2000, 128);
    read_probe(light, v3(0, 0.6f, 0), v3(0, -1, 0), 1 << 16, read);
    for (int k = 0; k < 3; k++)
        check("reflected above a mirror", read[k], exact[k]);
    rsv_light_destroy(light);
    world_end(w);
}

/// The radiance of half spaces under a beam: omega / 4 pi mu0 / (mu + mu0) H(mu) H(mu0), for omega = 0.9 and 0.5.
static void half_spaces_shine_by_chandrasekhars_h(void **state)
{
    (void)state;
    static const double h_of_1[3] = { 1.850099, 1.850099, 1.251260 };
    static const double h_of_half[3] = { 1.556034, 1.556034, 1.187735 };
    static const double omega[3] = { (double)0.9f, (double)0.9f, 0.5 };
    world *w = world_begin(2);
    add_mirrors(w, -10, 2);
    add_sun(w);
    fill(w,
        box_of_fog(rgb_gray(1), rgb(0.9f, 0.9f, 0.5f), v3(-0.5f, -10, -0.5f), v3(0.5f, 0, 0.5f)));
    rsv_light *light = solve_with(w, 20000, 256);
    for (int mode = 0; mode < 2; mode++) {
        estimate seen[3];
        see(light, beam(v3(0, 1, 0), v3(0, -1, 0)), both_modes[mode], 64, 0, seen);
        for (int k = 1; k < 3; k++)
            check(
                name_of(both_modes[mode]), seen[k], omega[k] / (8 * M_PI) * h_of_1[k] * h_of_1[k]);
        see(light, beam(v3(-0.25f * sqrtf(0.75f), 0.125f, 0), v3(0, 0, 0)), both_modes[mode], 64, 0,
            seen);
        for (int k = 1; k < 3; k++)
            check(name_of(both_modes[mode]), seen[k],
                omega[k] / (6 * M_PI) * h_of_1[k] * h_of_half[k]);
    }
    rsv_light_destroy(light);
    world_end(w);
}

// ---- equilibrium and balance --------------------------------------------------------------------

static void look_into_furnace(const world *w)
{
    rsv_light *light = solve_with(w, 1000, 256);
    assert_true(rsv_light_report(light)->norm_inf <= 1 + 1e-6);
    rsv_camera eye = rsv_camera_look_at("eye", v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 1, 1);
    for (int mode = 0; mode < 2; mode++) {
        estimate seen[3];
        see(light, eye, both_modes[mode], 16, 0, seen);
        for (int k = 0; k < 3; k++)
            check(name_of(both_modes[mode]), seen[k], 1);
    }
    estimate read[3];
    rsv_render_desc gathered = picture_of(&eye, RSV_RENDER_FINAL, 256);
    gathered.gather_rays = 1;
    average_picture(light, &gathered, 0, read);
    for (int k = 0; k < 3; k++)
        check("gathered", read[k], 1);
    read_probe(light, v3(0.2f, 0.1f, 0), v3(0, 1, 0), 4096, read);
    for (int k = 0; k < 3; k++)
        check("probe in a furnace", read[k], M_PI);
    rsv_light_destroy(light);
}

/// In a closed room whose walls all show radiance 1, fog changes nothing, and no row sums to more than 1.
static void fog_is_invisible_in_a_furnace(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0.5f), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_fog fog = box_of_fog(rgb_gray(1), rgb(1, 0.7f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    fog.emission = rgb(0, 0.3f, 1);
    world_commit(w);
    for (int forward = 0; forward < 2; forward++) {
        if (forward) fog.anisotropy = 0.6f;
        assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
        look_into_furnace(w);
    }
    world_end(w);
}

/// It is also invisible under a uniform sky.
static void lossless_fog_is_invisible_under_an_even_sky(void **state)
{
    (void)state;
    world *w = world_begin(2);
    add_speck(w);
    fill(w, box_of_fog(rgb(0.5f, 1, 2), rgb_gray(1), v3(-2, -1, -3), v3(2, 1, 3)));
    assert_int_equal(rsv_scene_set_builtin_environment(w->scene, "white", 1, 0), RSV_OK);
    rsv_light *light = solve_with(w, 1000, 256);
    rsv_camera eye = rsv_camera_look_at("eye", v3(0.5f, 0.2f, 4), v3(0, 0, 0), 1, 1);
    for (int mode = 0; mode < 2; mode++) {
        estimate seen[3];
        see(light, eye, both_modes[mode], 4, 0, seen);
        for (int k = 0; k < 3; k++)
            check(name_of(both_modes[mode]), seen[k], 1);
    }
    assert_true(rsv_light_report(light)->norm_inf <= 1 + 1e-5);
    rsv_light_destroy(light);
    world_end(w);
}

/// The mean irradiance of a room's walls, by what the solution holds.
static estimate wall_mean(const rsv_light *light)
{
    enum { SIDE = 12, COUNT = 6 * SIDE * SIDE };
    rsv_probe *probe = calloc(COUNT, sizeof *probe);
    rsv_probe_reading *reading = calloc(COUNT, sizeof *reading);
    rsv_random random = rsv_random_from(1, 1, 2);
    rsv_probe_desc desc = rsv_default_probe_desc();
    double mean = 0, variance = 0;
    desc.samples = 512;
    for (int k = 0; k < COUNT; k++)
        probe[k] = wall_place(k, SIDE, &random);
    assert_int_equal(rsv_probe_irradiance(light, &desc, probe, COUNT, reading), RSV_OK);
    for (int k = 0; k < COUNT; k++) {
        mean += (double)reading[k].irradiance.g / COUNT;
        double error = (double)reading[k].standard_error.g / COUNT;
        variance += error * error;
    }
    free(probe);
    free(reading);
    return (estimate){ mean, sqrt(variance) };
}

/// Shines downwards with pi x 0.16 W.
static void add_panel(world *w)
{
    world_quad(w, world_lambert(w, 1, 1), v3(-0.2f, 0.6f, -0.2f), v3(0.2f, 0.6f, -0.2f),
        v3(0.2f, 0.6f, 0.2f), v3(-0.2f, 0.6f, 0.2f));
    world_quad(w, world_lambert(w, 1, 0), v3(-0.2f, 0.6f, 0.2f), v3(0.2f, 0.6f, 0.2f),
        v3(0.2f, 0.6f, -0.2f), v3(-0.2f, 0.6f, -0.2f));
}

/// In a closed room with fog without absorption, the black walls absorb all light of the lamps.
static void fog_loses_no_light(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        world *w = world_begin(2);
        world_room(w, world_lambert(w, 0, 0), v3(-1, -1, -1), v3(1, 1, 1));
        if (kind == 0)
            add_lamp(w, (rsv_punctual_light){
                            .position = v3(0.1f, 0.2f, -0.1f), .intensity = rgb_gray(0.1f) });
        else
            add_panel(w);
        world_box(w, world_lambert(w, 1, 0), v3(-0.7f, -0.9f, -0.2f), v3(-0.3f, -0.4f, 0.2f));
        rsv_fog fog = box_of_fog(rgb_gray(1.5f), rgb_gray(1), v3(-1, -1, -1), v3(1, 1, 1));
        if (kind == 1) fog.anisotropy = 0.5f;
        fill(w, fog);
        rsv_light *light = solve_with(w, 3000, 1024);
        double power = kind == 0 ? 0.4 * M_PI : M_PI * 0.16;
        check(kind ? "panel in fog" : "point in fog", wall_mean(light), power / 24);
        rsv_light_destroy(light);
        world_end(w);
    }
}

/// The same where a mirror sends part of it into the fog, whose phase function is even or not. Probes do not see what mirrors
/// send straight to them, so the walls' own elements are asked.
static void fog_loses_no_light_of_mirrors(void **state)
{
    (void)state;
    for (int forward = 0; forward < 2; forward++) {
        world *w = world_begin(2);
        world_room(w, world_lambert(w, 0, 0), v3(-1, -1, -1), v3(1, 1, 1));
        world_box(w, world_material(w, mirror_material(1)), v3(-0.7f, -0.8f, -0.5f),
            v3(0.1f, -0.1f, 0.3f));
        if (forward)
            add_panel(w);
        else
            add_lamp(w, (rsv_punctual_light){
                            .position = v3(0.1f, 0.3f, -0.1f), .intensity = rgb_gray(0.1f) });
        rsv_fog fog = box_of_fog(rgb_gray(1.5f), rgb_gray(1), v3(-1, -1, -1), v3(1, 1, 1));
        if (forward) fog.anisotropy = 0.5f;
        fill(w, fog);
        rsv_light *light = solve_with(w, 3000, 512);
        double power = power_at_walls(light), expected = forward ? 0.16 * M_PI : 0.4 * M_PI;
        print_message("g %g: %g W of %g\n", (double)fog.anisotropy, power, expected);
        assert_close(power, expected, TOLERANCE * expected);
        rsv_light_destroy(light);
        world_end(w);
    }
}

/// A wall separates the lit part from the dark part, however large voxels are. Surfaces are black, so all light is in
/// the air.
static void no_light_leaks_through_walls(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material wall = lambert_material(0, 0);
    wall.double_sided = true;
    world_room(w, world_lambert(w, 0, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_quad(w, world_material(w, wall), v3(0.03f, -1, -1), v3(0.03f, 1, -1), v3(0.03f, 1, 1),
        v3(0.03f, -1, 1));
    add_lamp(w, (rsv_punctual_light){ .position = v3(-0.5f, 0, 0), .intensity = rgb_gray(1) });
    fill(w, box_of_fog(rgb_gray(1), rgb_gray(0.9f), v3(-1, -1, -1), v3(1, 1, 1)));
    rsv_light *light = solve_with(w, 500, 64);
    estimate lit[3], dark[3];
    read_probe(light, v3(0, 0, 0), v3(-1, 0, 0), 1024, lit);
    read_probe(light, v3(0.1f, 0, 0), v3(1, 0, 0), 1024, dark);
    print_message("beyond a wall: %g of %g\n", dark[1].mean, lit[1].mean);
    assert_true(lit[1].mean > 0.1);
    assert_true(dark[1].mean == 0);
    rsv_light_destroy(light);
    world_end(w);
}

// ---- against the path tracer ----------------------------------------------------------------------

/// The certificate finds an error on surfaces, and its bound holds.
static void the_certificate_knows_fog(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1);
    fog.albedo = rgb_gray(0.9f);
    fill(w, fog);
    rsv_light *light = solve_with(w, 2000, 256);
    rsv_certify_desc desc = rsv_brief_certify_desc();
    rsv_certificate certificate;
    assert_int_equal(rsv_certify(light, &desc, &certificate), RSV_OK);
    print_message("certificate: residual %.3g, estimate %.3g of %.3g\n", certificate.residual_rms,
        certificate.error_estimate_rms, certificate.irradiance_rms);
    assert_true(certificate.error_estimate_rms < 0.1 * certificate.irradiance_rms);
    assert_true(certificate.error_bound_rms > certificate.amplification * certificate.residual_rms);
    rsv_light_destroy(light);
    world_end(w);
}

static rsv_image *take(world *w, const rsv_render_desc *desc)
{
    rsv_light *light = solve_with(w, 500, 64);
    rsv_image *image;
    assert_int_equal(rsv_render(light, desc, &image), RSV_OK);
    rsv_light_destroy(light);
    return image;
}

static void fog_does_not_depend_on_threads(void **state)
{
    (void)state;
    assert_same_for_threads(take);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(absorbing_slabs_follow_beer),
        cmocka_unit_test(absorbing_spheres_follow_beer),
        cmocka_unit_test(lamps_beside_a_line_light_it_once),
        cmocka_unit_test(fog_is_invisible_in_a_furnace),
        cmocka_unit_test(lossless_fog_is_invisible_under_an_even_sky),
        cmocka_unit_test(mirrors_send_the_sun_into_fog),
        cmocka_unit_test(no_light_leaks_through_walls),
        cmocka_unit_test(the_certificate_knows_fog),
        cmocka_unit_test(fog_does_not_depend_on_threads),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(fog_loses_no_light_of_mirrors),
        cmocka_unit_test(fog_loses_no_light),
        cmocka_unit_test(slabs_reflect_and_transmit_as_chandrasekhar_says),
        cmocka_unit_test(half_spaces_shine_by_chandrasekhars_h),
    };
    return RUN_HALF(argc, argv, quick, longest);
}
