/// Light in fog, path traced, compared with exact answers: absorption, scattering once, often, and in equilibrium.
///
/// Numbers for slabs come from doubling and adding with 24 Gauss points per hemisphere (error 1e-7; for the slab of
/// optical thickness 10: 1e-4), those for half spaces from Chandrasekhar's equation for H, iterated over 64 Gauss
/// points.
#include "unit/fog_fixture.h"
#include "unit/slow_tests.h"

static void read_probe(
    const world *w, rsv_vec3 at, rsv_vec3 normal, uint32_t samples, estimate out[3])
{
    const rsv_probe probe = { at, normal };
    rsv_probe_reading reading;
    assert_int_equal(rsv_probe_reference(w->scene, &probe, 1, samples, 7, &reading), RSV_OK);
    for (int k = 0; k < 3; k++)
        out[k] = (estimate){ (double)channel(reading.irradiance, k),
            (double)channel(reading.standard_error, k) };
}

/// Mean radiance of a picture; its pixels are independent. @param layer 0 = all orders, 2 = light scattered once
static void see(const world *w, rsv_camera camera, uint32_t side, uint32_t samples, uint32_t layer,
    estimate out[3])
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = RSV_RENDER_REFERENCE;
    desc.width = desc.height = side;
    desc.samples = samples;
    desc.viewpoint = &camera;
    desc.layers = layer > 0;
    assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
    const rsv_rgb *pixel = rsv_image_pixels(image, layer);
    for (int k = 0; k < 3; k++) {
        double sum = 0, squares = 0, n = (double)side * side;
        for (size_t i = 0; i < (size_t)side * side; i++) {
            double value = (double)channel(pixel[i], k);
            sum += value;
            squares += value * value;
        }
        out[k] = (estimate){ sum / n, sqrt(fmax(squares / n - sum / n * (sum / n), 0) / (n - 1)) };
    }
    rsv_image_destroy(image);
}

// ---- absorption ---------------------------------------------------------------------------------

/// Beer and Lambert, to a thousandth: straight and aslant through a slab, and where fog thins upwards. Without
/// scattering there is no noise.
static void absorbing_slabs_follow_beer(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0, 1), v3(-99, 0, 99), v3(99, 0, 99), v3(99, 0, -99), v3(-99, 0, -99));
    fill(w, slab(rgb(0.1f, 1, 5), rgb_gray(0), 0.5f, 2));
    for (int aslant = 0; aslant < 2; aslant++) {
        estimate seen[3];
        see(w, needle(v3(aslant ? 6 : 0, 6, 0.01f), v3(0, 0, 0)), 2, 4, 0, seen);
        for (int k = 0; k < 3; k++) {
            double depth = (k == 0 ? 0.1 : k == 1 ? 1 : 5) * 1.5 * (aslant ? sqrt(2) : 1);
            assert_close(seen[k].mean, exp(-depth), 1e-3 * exp(-depth));
        }
    }
    rsv_fog thinning = everywhere(rgb(0.1f, 0.5f, 2), rgb_gray(0));
    thinning.scale_height = 0.7f;
    thinning.base_height = 1;
    assert_int_equal(rsv_scene_set_fog(w->scene, &thinning), RSV_OK);
    estimate seen[3];
    see(w, needle(v3(3, 3, 0.01f), v3(0, 0, 0)), 2, 4, 0, seen);
    double column = sqrt(2) * (1 + 0.7 * (1 - exp(-2 / 0.7)));
    for (int k = 0; k < 3; k++) {
        double passed = exp(-(k == 0 ? 0.1 : k == 1 ? 0.5 : 2) * column);
        assert_close(seen[k].mean, passed, 1e-3 * passed);
    }
    world_end(w);
}

/// A glowing sphere full of fog: its wall receives 2 pi L int exp(-2 R sigma mu) mu dmu, its centre pi L exp(-R sigma).
/// A point light in its middle lights the wall by I exp(-R sigma) / R^2.
static void absorbing_spheres_follow_beer(void **state)
{
    (void)state;
    const float radius = 1.5f, sigma = 0.8f;
    const double t = 2 * (double)radius * (double)sigma;
    for (int lamp = 0; lamp < 2; lamp++) {
        world *w = world_begin(2);
        rsv_material wall = lambert_material(0, lamp ? 0 : 1);
        wall.double_sided = true;
        world_sphere(w, world_material(w, wall), v3(0, 0, 0), radius, 6);
        if (lamp) add_lamp(w, (rsv_punctual_light){ .intensity = rgb_gray(3) });
        fill(w, everywhere(rgb_gray(sigma), rgb_gray(0)));
        estimate read[3];
        rsv_vec3 out = v3_normalize(v3(1, 2, 3));
        read_probe(w, v3_scale(out, 0.9995f * radius), v3_neg(out), 16384, read);
        double at_wall = 2 * M_PI * (1 - (1 + t) * exp(-t)) / (t * t);
        const double inside = 0.9995 * (double)radius; // where the probe lies
        if (lamp) at_wall = 3 * exp(-inside * (double)sigma) / (inside * inside);
        check("wall of an absorbing sphere", read[1], at_wall);
        assert_close(read[1].mean, at_wall, 1.5e-3 * at_wall + STANDARD_ERRORS * read[1].error);
        if (!lamp) {
            read_probe(w, v3(0, 0, 0), v3(0, 1, 0), 4096, read);
            assert_close(read[1].mean, M_PI * exp(-t / 2), 1.5e-3 * M_PI * exp(-t / 2));
        }
        world_end(w);
    }
}

// ---- scattering once ----------------------------------------------------------------------------

/// A light next to the line of sight: a point light, a spot light aimed at the line, and a small panel.
static void lamps_beside_a_line_light_it_once(void **state)
{
    (void)state;
    const rsv_rgb sigma = { 0.05f, 0.4f, 2 };
    const float albedo = 0.8f, g = 0.4f, h = 0.5f, foot = 2;
    for (int kind = 0; kind < 3; kind++) {
        world *w = world_begin(2);
        // the end of the line
        world_quad(
            w, world_lambert(w, 0, 0), v3(-1, -1, -5), v3(1, -1, -5), v3(1, 1, -5), v3(-1, 1, -5));
        const float radius = 5e-3f;
        if (kind == 2)
            world_quad(w, world_lambert(w, 0, 1), v3(-radius, h, -foot - radius),
                v3(radius, h, -foot - radius), v3(radius, h, -foot + radius),
                v3(-radius, h, -foot + radius));
        else
            add_lamp(w, (rsv_punctual_light){ .kind = kind ? RSV_PUNCTUAL_SPOT : RSV_PUNCTUAL_POINT,
                            .position = v3(0, h, -foot),
                            .direction = v3(0, -1, 0),
                            .intensity = rgb_gray(2),
                            .inner_cone_angle = 0.6f,
                            .outer_cone_angle = 0.6f });
        rsv_fog fog = everywhere(sigma, rgb_gray(albedo));
        fog.anisotropy = g;
        fill(w, fog);
        estimate seen[3];
        see(w, needle(v3(0, 0, 0), v3(0, 0, -1)), 16, 64, 2, seen);
        for (int k = 0; k < 3; k++) {
            double s = (double)channel(sigma, k), expected = 0;
            if (kind < 2)
                expected = 2 * once_along_line(s, (double)g, (double)h, (double)foot, 5,
                                   kind ? cos((double)0.6f) : 0);
            else { // intensity L A cos
                enum { STEPS = 20000 };
                double low = atan2(-(double)foot, (double)h), high = atan2(3, (double)h);
                for (int i = 0; i < STEPS; i++) {
                    double angle = low + (high - low) * (i + 0.5) / STEPS;
                    double r = (double)h / cos(angle),
                           along = (double)foot + (double)h * tan(angle);
                    expected += s * 4 * (double)(radius * radius) * cos(angle) *
                                exp(-s * (along + r)) *
                                henyey_greenstein((double)g, ((double)foot - along) / r) /
                                (double)h * (high - low) / STEPS;
                }
            }
            check(kind == 0   ? "point"
                  : kind == 1 ? "spot"
                              : "panel",
                seen[k], (double)albedo * expected);
        }
        world_end(w);
    }
}

/// The sun through air that thins upwards: seen from the ground, light that was scattered once, in closed form.
static void the_sun_lights_an_atmosphere_once(void **state)
{
    (void)state;
    const float sun_cos = 0.8f, view_cos = 0.5f, g = 0.7f;
    world *w = world_begin(2);
    add_speck(w);
    add_lamp(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL,
                    .direction = v3(-sqrtf(1 - sun_cos * sun_cos), -sun_cos, 0),
                    .intensity = rgb_gray(2) });
    rsv_fog fog = everywhere(rgb(1e-5f, 1e-4f, 5e-4f), rgb(1, 0.9f, 0.5f));
    fog.scale_height = 2000;
    fog.anisotropy = g;
    fill(w, fog);
    rsv_vec3 view = v3(sqrtf(1 - view_cos * view_cos), view_cos, 0);
    estimate seen[3];
    see(w, needle(v3(0, 0, 0), view), 32, 64, 2, seen);
    double cos_turn = (double)v3_dot(view, v3(sqrtf(1 - sun_cos * sun_cos), sun_cos, 0));
    for (int k = 0; k < 3; k++) {
        double tau = 2000 * (double)channel(fog.extinction, k), s = (double)sun_cos,
               v = (double)view_cos;
        double expected = 2 * (double)channel(fog.albedo, k) *
                          henyey_greenstein((double)g, cos_turn) * s / (s - v) *
                          (exp(-tau / s) - exp(-tau / v));
        check("sun in an atmosphere", seen[k], expected);
    }
    world_end(w);
}

// ---- scattering often -----------------------------------------------------------------------------

/// Albedo and transmission of slabs with isotropic scattering, lit by a beam; one slab for each channel, of optical
/// thickness and albedo (0.5, 1), (1, 0.8), (2, 0.95).
static void slabs_reflect_and_transmit_as_chandrasekhar_says(void **state)
{
    (void)state;
    static const double exact[2][2][3] = { // [cosine 1, 0.5][reflected, transmitted][slab]
        { { 0.2025058, 0.2108463, 0.4287211 }, { 0.7974939, 0.5413993, 0.4093064 } },
        { { 0.3343814, 0.3127017, 0.5536619 }, { 0.6656181, 0.3504240, 0.2693881 } }
    };
    for (int aslant = 0; aslant < 2; aslant++) {
        world *w = world_begin(2);
        float cos = aslant ? 0.5f : 1, sin = sqrtf(1 - cos * cos);
        add_speck(w);
        add_lamp(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL,
                        .direction = v3(sin, -cos, 0),
                        .intensity = rgb_gray(1 / cos) });
        fill(w, slab(rgb(0.5f, 1, 2), rgb(1, 0.8f, 0.95f), 0, 1));
        for (int below = 0; below < 2; below++) {
            estimate read[3];
            read_probe(
                w, v3(0, below ? -0.1f : 1.1f, 0), v3(0, below ? 1.0f : -1.0f, 0), 1 << 18, read);
            for (int k = 0; k < 3; k++)
                check(below ? "transmitted" : "reflected", read[k], exact[aslant][below][k]);
        }
        world_end(w);
    }
}

/// The radiance of a half space under a beam: omega / 4 pi mu0 / (mu + mu0) H(mu) H(mu0), for omega = 0.99, 0.9, 0.5.
static void half_spaces_shine_by_chandrasekhars_h(void **state)
{
    (void)state;
    static const double h_of_1[3] = { 2.472793, 1.850099, 1.251260 };
    static const double h_of_half[3] = { 1.848601, 1.556034, 1.187735 };
    static const double omega[3] = { (double)0.99f, (double)0.9f, 0.5 };
    world *w = world_begin(2);
    add_speck(w);
    add_lamp(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL,
                    .direction = v3(0, -1, 0),
                    .intensity = rgb_gray(1) });
    fill(w, slab(rgb_gray(1), rgb(0.99f, 0.9f, 0.5f), -INFINITY, 0));
    estimate seen[3];
    see(w, needle(v3(0, 1, 0), v3(0, -1, 0)), 64, 128, 0, seen);
    for (int k = 0; k < 3; k++)
        check("half space, straight", seen[k], omega[k] / (8 * M_PI) * h_of_1[k] * h_of_1[k]);
    see(w, needle(v3(-sqrtf(0.75f), 0.5f, 0), v3(0, 0, 0)), 64, 128, 0, seen);
    for (int k = 0; k < 3; k++)
        check("half space, aslant", seen[k], omega[k] / (6 * M_PI) * h_of_1[k] * h_of_half[k]);
    world_end(w);
}

/// A glowing floor under a thick slab without absorption: the light that leaves the top darkens towards the limb as
/// H(mu).
static void thick_slabs_darken_by_milnes_law(void **state)
{
    (void)state;
    static const float cosine[3] = { 1, 0.5f, 0.2f };
    static const double exact[3] = { 0.14691, 0.10169, 0.073273 }; // 1, 0.6922, 0.4988 of the first
    world *w = world_begin(2);
    world_quad(w, world_lambert(w, 0, 1), v3(-400, 0, 400), v3(400, 0, 400), v3(400, 0, -400),
        v3(-400, 0, -400));
    fill(w, slab(rgb_gray(1), rgb_gray(1), 0, 10));
    for (int k = 0; k < 3; k++) {
        estimate seen[3];
        float sin = sqrtf(1 - cosine[k] * cosine[k]);
        see(w, needle(v3(-sin, 10 + cosine[k], 0), v3(0, 10, 0)), 64, 128, 0, seen);
        check("Milne's slab", seen[1], exact[k]);
    }
    world_end(w);
}

// ---- equilibrium and balance ------------------------------------------------------------------------

/// In a closed room whose walls all have radiance 1, fog changes nothing: it scatters as much into each direction as
/// out of it, and where it absorbs it emits as much at the same temperature.
static void fog_is_invisible_in_a_furnace(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0.5f), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_fog fog = everywhere(rgb(0.2f, 1, 3), rgb(1, 0.7f, 0));
    fog.anisotropy = 0.6f;
    fog.emission = rgb(0, 0.3f, 3);
    fill(w, fog);
    for (int thins = 0; thins < 2; thins++) {
        estimate seen[3];
        if (thins) fog.scale_height = 0.5f;
        assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
        see(w, rsv_camera_look_at("eye", v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 1, 1), 64, 32, 0, seen);
        for (int k = 0; k < 3; k++)
            check(thins ? "furnace, thinner above" : "furnace", seen[k], 1);
    }
    world_end(w);
}

/// It is also invisible under a uniform sky.
static void lossless_fog_is_invisible_under_an_even_sky(void **state)
{
    (void)state;
    world *w = world_begin(2);
    add_speck(w);
    rsv_fog fog = slab(rgb(0.5f, 1, 2), rgb_gray(1), -1, 1);
    fog.anisotropy = -0.5f;
    fog.bounds_min.x = -2;
    fog.bounds_max.x = 2;
    fill(w, fog);
    assert_int_equal(rsv_scene_set_builtin_environment(w->scene, "white", 1, 0), RSV_OK);
    estimate seen[3];
    see(w, rsv_camera_look_at("eye", v3(0.5f, 0.2f, 4), v3(0, 0, 0), 1, 1), 64, 32, 0, seen);
    for (int k = 0; k < 3; k++)
        check("under an even sky", seen[k], 1);
    world_end(w);
}

/// The mean irradiance of a room's walls, by independent rounds over stratified places.
static estimate wall_mean(const world *w, uint32_t rounds)
{
    enum { SIDE = 12, COUNT = 6 * SIDE * SIDE, SAMPLES = 32 };
    rsv_probe *probe = calloc(COUNT, sizeof *probe);
    rsv_probe_reading *reading = calloc(COUNT, sizeof *reading);
    double sum = 0, squares = 0;
    for (uint32_t round = 0; round < rounds; round++) {
        rsv_random random = rsv_random_from(round, 1, 2);
        double mean = 0;
        for (int k = 0; k < COUNT; k++)
            probe[k] = wall_place(k, SIDE, &random);
        assert_int_equal(
            rsv_probe_reference(w->scene, probe, COUNT, SAMPLES, 100 + round, reading), RSV_OK);
        for (int k = 0; k < COUNT; k++)
            mean += (double)reading[k].irradiance.g / COUNT;
        sum += mean;
        squares += mean * mean;
    }
    free(probe);
    free(reading);
    double n = rounds, mean = sum / n;
    return (estimate){ mean, sqrt(fmax(squares / n - mean * mean, 0) / (n - 1)) };
}

static void add_lamps(world *w, int count)
{
    // weak, because close to a point light the variance of light that is scattered more than once is infinite
    for (int k = 0; k < count; k++) {
        float x = 1.2f * (((float)(k % 5) + 0.5f) / 5 - 0.5f), y = 0.1f * (float)(k % 7) - 0.3f,
              z = 1.2f * (((float)(k / 5 % 5) + 0.5f) / 5 - 0.5f);
        add_lamp(w, (rsv_punctual_light){
                        .position = v3(x, y, z), .intensity = rgb_gray(0.1f / (float)count) });
    }
}

/// In a closed room with fog without absorption, the black walls absorb all light of the lamps. The lamps are points
/// and panels, few and many. A white body, a pane with holes and a glass ball are in the room.
static void fog_loses_no_light(void **state)
{
    (void)state;
    for (int many = 0; many < 2; many++) {
        world *w = world_begin(2);
        world_room(w, world_lambert(w, 0, 0), v3(-1, -1, -1), v3(1, 1, 1));
        rsv_material panel = lambert_material(1, 2);
        int panels = many ? 90 : 2;
        float half = many ? 0.01f : 0.1f, apart = many ? 0.13f : 0.5f;
        for (int k = 0; k < panels; k++) {
            float x = apart * (float)(k % 10) - 0.6f, z = apart * (float)(k / 10) - 0.6f;
            world_quad(w, world_material(w, panel), v3(x - half, 0.6f, z - half),
                v3(x + half, 0.6f, z - half), v3(x + half, 0.6f, z + half),
                v3(x - half, 0.6f, z + half));
            world_quad(w, world_lambert(w, 1, 0), v3(x - half, 0.6f, z + half),
                v3(x + half, 0.6f, z + half), v3(x + half, 0.6f, z - half),
                v3(x - half, 0.6f, z - half));
        }
        add_lamps(w, many ? 40 : 1);
        world_box(w, world_lambert(w, 1, 0), v3(-0.7f, -0.9f, -0.2f), v3(-0.3f, -0.4f, 0.2f));
        rsv_fog fog = everywhere(rgb_gray(1.5f), rgb_gray(1));
        fog.anisotropy = 0.5f;
        fill(w, fog);
        double power = 0.4 * M_PI + panels * 2 * M_PI * 4 * (double)(half * half);
        check(many ? "many lamps in fog" : "few lamps in fog", wall_mean(w, 16), power / 24);
        world_end(w);
    }
}

/// Solid bodies displace fog. Paths reach a lamp made of glowing walls through glass and holes.
static void bodies_and_holes_in_fog_lose_no_light(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_sphere(w, world_lambert(w, 1, 1), v3(0.3f, 0.2f, 0), 0.3f, 3);
    world_sphere(w, world_material(w, glass_material()), v3(-0.4f, -0.3f, 0.2f), 0.35f, 4);
    rsv_material veil = lambert_material(1, 0);
    veil.opacity = 0.4f;
    veil.double_sided = true;
    world_quad(w, world_material(w, veil), v3(-0.9f, 0.7f, 0.9f), v3(0.9f, 0.7f, 0.9f),
        v3(0.9f, 0.7f, -0.9f), v3(-0.9f, 0.7f, -0.9f));
    fill(w, everywhere(rgb_gray(1), rgb_gray(1)));
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    double lamp = 0;
    for (size_t t = 0; t < view->triangle_count; t++)
        if (view->material[view->triangle_material[t]].emission.g > 0)
            lamp += (double)rsv_triangle_area(view, (uint32_t)t);
    check("glass and veils in fog", wall_mean(w, 16), M_PI * lamp / 24);
    world_end(w);
}

/// Solid angle of the rectangle between an axis and (x, y) at distance 1.
static double solid_angle_of(double x, double y) { return atan(x * y / sqrt(1 + x * x + y * y)); }

/// Scattered fluence where one face of a cube around the eye looks: radiance times solid angle.
static rsv_rgb face_fluence(const world *w, rsv_vec3 from, rsv_vec3 towards, uint32_t seed)
{
    enum { SIDE = 16 };
    rsv_camera camera = rsv_camera_look_at("face", from, v3_add(from, towards), RSV_PI / 2, 1);
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = RSV_RENDER_REFERENCE;
    desc.width = desc.height = SIDE;
    desc.samples = 192;
    desc.seed = seed;
    desc.viewpoint = &camera;
    assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
    const rsv_rgb *pixel = rsv_image_pixels(image, 0);
    rsv_rgb sum = rgb_gray(0);
    for (int i = 0; i < SIDE * SIDE; i++) {
        double x = 2.0 * (i % SIDE) / SIDE - 1, y = 2.0 * (i / SIDE) / SIDE - 1, d = 2.0 / SIDE;
        double solid_angle = solid_angle_of(x + d, y + d) - solid_angle_of(x, y + d) -
                             solid_angle_of(x + d, y) + solid_angle_of(x, y);
        sum = rgb_mad(sum, (float)solid_angle, pixel[i]);
    }
    rsv_image_destroy(image);
    return sum;
}

/// Scattered fluence at (0, 0, r). As all is symmetric about the z axis, four sides of the cube count as one.
static void fluence_beside_the_axis(const world *w, float r, estimate found[3])
{
    enum { ROUNDS = 10 };
    double sum[3] = { 0 }, squares[3] = { 0 };
    for (uint32_t round = 0; round < ROUNDS; round++) {
        rsv_rgb front = face_fluence(w, v3(0, 0, r), v3(0, 0, -1), 3 * round);
        rsv_rgb back = face_fluence(w, v3(0, 0, r), v3(0, 0, 1), 3 * round + 1);
        rsv_rgb side = face_fluence(w, v3(0, 0, r), v3(1, 0, 0), 3 * round + 2);
        rsv_rgb all = rgb_mad(rgb_add(front, back), 4, side);
        for (int k = 0; k < 3; k++) {
            sum[k] += (double)channel(all, k);
            squares[k] += (double)channel(all, k) * (double)channel(all, k);
        }
    }
    for (int k = 0; k < 3; k++) {
        double mean = sum[k] / ROUNDS;
        found[k] =
            (estimate){ mean, sqrt(fmax(squares[k] / ROUNDS - mean * mean, 0) / (ROUNDS - 1)) };
    }
}

/// Fluence at distance r from an isotropic point source of one watt in infinite fog of extinction 1 (Case and Zweifel
/// 1967): a discrete mode, the solution of the diffusion equation, and a continuum.
static double exact_fluence(double omega, double r)
{
    double low = 0, high = 1 - 1e-15;
    for (int k = 0; k < 200; k++) { // kappa of omega atanh(kappa) / kappa = 1
        double middle = (low + high) / 2;
        if (omega * atanh(middle) / middle < 1)
            low = middle;
        else
            high = middle;
    }
    double kappa = (low + high) / 2, k2 = kappa * kappa;
    double mode = exp(-kappa * r) / (2 * M_PI * r) * k2 * (1 - k2) / (omega * (omega - 1 + k2));
    enum { STEPS = 400000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) { // eta = 1 / t
        double t = (i + 0.5) / STEPS, eta = 1 / t, l = atanh(t) * t, im = M_PI / 2 * t;
        double a = 1 - omega * l, b = omega * im; // Im of M / (1 - omega M), M = l + i im
        sum += eta * (im * a + l * b) / (a * a + b * b) * exp(-eta * r) / (t * t) / STEPS;
    }
    return mode + sum / (2 * M_PI * M_PI * r);
}

static void endless_fog_has_the_exact_fluence(void **state)
{
    (void)state;
    static const double omega[3] = { (double)0.9f, 0.5, (double)0.2f };
    world *w = world_begin(2);
    add_speck(w);
    add_lamp(w, (rsv_punctual_light){ .intensity = rgb_gray((float)(1 / (4 * M_PI))) });
    fill(w, everywhere(rgb_gray(1), rgb((float)omega[0], (float)omega[1], (float)omega[2])));
    for (int far = 0; far < 2; far++) {
        float r = far ? 2 : 0.5f;
        estimate found[3];
        fluence_beside_the_axis(w, r, found);
        for (int k = 0; k < 3; k++) {
            found[k].mean += exp(-(double)r) / (4 * M_PI * (double)r * (double)r); // not scattered
            check("fluence", found[k], exact_fluence(omega[k], (double)r));
        }
    }
    world_end(w);
}

static rsv_image *take(world *w, const rsv_render_desc *desc)
{
    rsv_image *image;
    assert_int_equal(rsv_render_reference(w->scene, desc, &image, NULL), RSV_OK);
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
        cmocka_unit_test(the_sun_lights_an_atmosphere_once),
        cmocka_unit_test(slabs_reflect_and_transmit_as_chandrasekhar_says),
        cmocka_unit_test(fog_is_invisible_in_a_furnace),
        cmocka_unit_test(lossless_fog_is_invisible_under_an_even_sky),
        cmocka_unit_test(bodies_and_holes_in_fog_lose_no_light),
        cmocka_unit_test(fog_does_not_depend_on_threads),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(fog_loses_no_light),
        cmocka_unit_test(half_spaces_shine_by_chandrasekhars_h),
        cmocka_unit_test(thick_slabs_darken_by_milnes_law),
        cmocka_unit_test(endless_fog_has_the_exact_fluence),
    };
    return RUN_HALF(argc, argv, quick, longest);
}
