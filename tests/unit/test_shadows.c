/// Shadow rays: past alpha-blended surfaces, and off coarse bodies with smooth normals.
#include "resolvent/render.h"

#include "light_fixture.h"
#include "render/pixel_direct.h"
#include "slow_tests.h"
#include "solve/light.h"
#include "sources/punctual_light.h"
#include "surface/lift.h"
#include "trace/passage.h"

enum { SUN, POINT, LAMP, SOURCES };

static void add_source(world *w, int kind)
{
    rsv_punctual_light light = { .name = "light", .direction = v3(0.25f, -0.9f, 0.2f) };
    light.direction = v3_normalize(light.direction);
    light.position = v3(0.1f, 2.5f, -0.2f);
    light.intensity = rgb_gray(kind == SUN ? 3.0f : 20.0f);
    light.kind = kind == SUN ? RSV_PUNCTUAL_DIRECTIONAL : RSV_PUNCTUAL_POINT;
    if (kind != LAMP) {
        assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
        return;
    }
    uint32_t lamp = world_lambert(w, 0, 40);
    world_quad(w, lamp, v3(-0.2f, 2.5f, -0.2f), v3(0.2f, 2.5f, -0.2f), v3(0.2f, 2.5f, 0.2f),
        v3(-0.2f, 2.5f, 0.2f));
}

static void add_floor(world *w, float half)
{
    world_quad(w, world_lambert(w, 0.6f, 0), v3(-half, 0, -half), v3(-half, 0, half),
        v3(half, 0, half), v3(half, 0, -half));
}

/// Whether a texel of the card is part of a leaf: 25 of them.
static bool is_leaf(int x, int y, int side)
{
    double across = fmod(5.0 * (x + 0.5) / side, 1) - 0.5,
           along = fmod(5.0 * (y + 0.5) / side, 1) - 0.5;
    return fabs(across) < 0.25 * cos(M_PI * along / 0.8) && fabs(along) < 0.4;
}

/// A card of leaves one metre above the floor. @param cutoff 0 = blended @param opacity of the leaves
static void add_card(world *w, float cutoff, float opacity)
{
    enum { SIDE = 40 };
    float texel[SIDE * SIDE][4];
    for (int k = 0; k < SIDE * SIDE; k++) {
        const float leaf[4] = { 0.2f, 0.6f, 0.1f, is_leaf(k % SIDE, k / SIDE, SIDE) ? opacity : 0 };
        memcpy(texel[k], leaf, sizeof leaf);
    }
    rsv_texture_desc texture = { .size = sizeof texture,
        .name = "leaves",
        .width = SIDE,
        .height = SIDE,
        .channel_count = 4,
        .values = texel[0],
        .nearest = true };
    uint32_t id;
    assert_int_equal(rsv_scene_add_texture(w->scene, &texture, &id), RSV_OK);
    const rsv_texture_ref ref[2] = { rsv_default_texture_ref(RSV_TEXTURE_BASE_COLOR, id),
        rsv_default_texture_ref(RSV_TEXTURE_OPACITY, id) };
    rsv_material m = lambert_material(1, 0);
    m.double_sided = true;
    m.alpha_cutoff = cutoff;
    m.textures = ref;
    m.texture_count = 2;
    const rsv_vec3 corner[4] = { { -0.8f, 1, -0.8f }, { -0.8f, 1, 0.8f }, { 0.8f, 1, 0.8f },
        { 0.8f, 1, -0.8f } };
    static const float uv[4][2] = { { 0, 0 }, { 0, 1 }, { 1, 1 }, { 1, 0 } };
    world_textured_quad(w, "card", m, corner, uv);
}

/// From above, at an angle.
static void add_camera(world *w, float size)
{
    rsv_vec3 forward = v3_normalize(v3(0, -1, -0.5f)), right = v3(1, 0, 0);
    rsv_camera camera = { .name = "camera",
        .position = v3_mad(v3(0, 0.3f, 0), -6, forward),
        .right = right,
        .forward = forward,
        .up = v3_cross(right, forward),
        .vertical_extent = size };
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
}

static rsv_light *solve(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    desc.element_target = 600;
    if (rsv_light_create(w->scene, &desc, &solution) != RSV_OK) fail_msg("%s", rsv_last_error());
    return solution;
}

static rsv_image *picture(const rsv_light *s, rsv_render_mode mode, uint32_t samples)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = mode;
    desc.width = desc.height = 48;
    desc.samples = samples;
    desc.noise = 0;
    rsv_status status =
        mode == RSV_RENDER_REFERENCE
            ? rsv_render_reference(rsv_light_get_view(s)->scene.scene, &desc, &image, NULL)
            : rsv_render(s, &desc, &image);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

/// As `resolvent compare` has it.
static double relative_mse(const rsv_image *truth, const rsv_image *image)
{
    size_t count = (size_t)rsv_image_width(truth) * rsv_image_height(truth);
    const rsv_rgb *a = rsv_image_const_pixels(truth, 0), *b = rsv_image_const_pixels(image, 0);
    double mean = 0, sum = 0;
    for (size_t k = 0; k < count; k++)
        mean += (double)a[k].g / (double)count;
    for (size_t k = 0; k < count; k++) {
        double error = (double)b[k].g - (double)a[k].g;
        sum += error * error / ((double)a[k].g * (double)a[k].g + 0.01 * mean * mean);
    }
    return sum / (double)count;
}

// ---- alpha-blended surfaces -----------------------------------------------------------------------

static world *card_world(int source, float cutoff, float opacity)
{
    world *w = world_begin(2);
    add_floor(w, 2);
    if (opacity > 0) add_card(w, cutoff, opacity);
    add_source(w, source);
    add_camera(w, 1.6f);
    world_commit(w);
    return w;
}

static void rays_pass_what_is_left_uncovered(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_material veil = lambert_material(0.5f, 0), wall = lambert_material(0.5f, 0);
    veil.opacity = 0.25f;
    uint32_t veils = world_material(w, veil), walls = world_material(w, wall);
    for (int k = 0; k < 4; k++) // the last of them opaque, and smaller
        world_quad(w, k == 3 ? walls : veils, v3(k == 3, -1, (float)k), v3(2, -1, (float)k),
            v3(2, 1, (float)k), v3(k == 3, 1, (float)k));
    world_commit(w);
    rsv_ray_packet packet = { 0 };
    const float expected[5] = { 0.421875f, 0, 0.5625f, 0.5625f, 1 };
    const rsv_ray ray[5] = { { v3(0.3f, 0.2f, -1), v3(0, 0, 1), INFINITY },
        { v3(1.3f, 0.2f, -1), v3(0, 0, 1), INFINITY }, { v3(1.3f, 0.2f, 1.5f), v3(0, 0, -2), 4 },
        { v3(1.3f, 0.2f, -1), v3(0, 0, 2), 1.2f }, { v3(-1, 0.2f, -1), v3(0, 0, 1), INFINITY } };
    float passed[RSV_PACKET_WIDTH];
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        const rsv_ray *r = &ray[k % 5];
        packet.origin_x[k] = r->origin.x, packet.origin_y[k] = r->origin.y;
        packet.origin_z[k] = r->origin.z;
        packet.direction_z[k] = r->direction.z;
        packet.t_max[k] = k < 10 ? r->t_max : -1;
        packet.mask[k] = UINT32_MAX;
    }
    rsv_tracer_passed_packet(w->tracer, &packet, false, passed);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        float alone = rsv_tracer_passed(w->tracer, &ray[k % 5]);
        assert_float_equal(alone, expected[k % 5], 1e-6);
        assert_true(passed[k] == (k < 10 ? alone : 0));
        assert_int_equal(packet.t_max[k] > 0, passed[k] > 0);
    }
    world_end(w);
}

/// The same card, blended and cut out, gives the same picture and the same stored light. (An earlier version used
/// photons for the light that passes: relative errors of 0.45, 0.35 and 0.0006.)
static void blended_cards_shade_like_cut_out_ones(void **state)
{
    (void)state;
    for (int source = 0; source < SOURCES; source++) {
        world *blended = card_world(source, 0, 1), *cut = card_world(source, 0.5f, 1);
        rsv_light *a = solve(blended), *b = solve(cut);
        rsv_image *image = picture(a, RSV_RENDER_FINAL, 16),
                  *same = picture(b, RSV_RENDER_FINAL, 16);
        double error = relative_mse(same, image);
        if (error > 1e-3) fail_msg("source %d, final: relative MSE %g", source, error);
        rsv_image_destroy(image);
        rsv_image_destroy(same);
        image = picture(a, RSV_RENDER_OPERATOR, 4), same = picture(b, RSV_RENDER_OPERATOR, 4);
        error = relative_mse(same, image);
        if (error > 2e-3) fail_msg("source %d, operator: relative MSE %g", source, error);
        rsv_image_destroy(image);
        rsv_image_destroy(same);
        assert_null(rsv_light_get_view(a)->caustics.caustic); // nothing is left to photons
        rsv_light_destroy(a);
        rsv_light_destroy(b);
        world_end(blended);
        world_end(cut);
    }
}

/// Light that is not straight passes, too: what a mirror sends through a curtain is a caustic.
static void curtains_dim_all_that_passes(void **state)
{
    (void)state;
    double mean[2];
    for (int k = 0; k < 2; k++) {
        world *w = world_begin(2);
        rsv_material curtain = lambert_material(0, 0);
        curtain.opacity = k ? 0.25f : 0;
        curtain.double_sided = true;
        add_floor(w, 1);
        world_quad(w, world_material(w, curtain), v3(-4, 0.2f, -4), v3(-4, 0.2f, 4), v3(4, 0.2f, 4),
            v3(4, 0.2f, -4));
        world_quad(w, world_material(w, mirror_material(1)), v3(-1, 2, -1), v3(1, 2, -1),
            v3(1, 2, 1), v3(-1, 2, 1));
        rsv_punctual_light up = {
            .kind = RSV_PUNCTUAL_POINT, .position = v3(0, 1, 0), .intensity = rgb_gray(9)
        };
        assert_int_equal(rsv_scene_add_light(w->scene, &up), RSV_OK);
        world_commit(w);
        rsv_light *s = solve(w);
        rsv_probe probe = { v3(0.11f, 0, 0.07f), v3(0, 1, 0) };
        rsv_probe_reading reading;
        assert_int_equal(rsv_probe_irradiance(s,
                             &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_LOOKUP, 256, 1 },
                             &probe, 1, &reading),
            RSV_OK);
        mean[k] = reading.irradiance.g;
        rsv_light_destroy(s);
        world_end(w);
    }
    assert_close(mean[1], 0.75 * mean[0], 0.02 * mean[0]);
}

/// Surfaces that lamps are aimed at through a veil and those that lobes meet through it are weighed as if it were not there.
static void veils_before_rough_metal_keep_its_light(void **state)
{
    (void)state;
    double mean[2];
    for (int k = 0; k < 2; k++) {
        world *w = world_begin(2);
        rsv_material metal = mirror_material(0.8f), veil = lambert_material(0, 0);
        metal.roughness = 0.4f;
        veil.opacity = 0.5f;
        veil.double_sided = true;
        world_quad(
            w, world_material(w, metal), v3(-2, 0, -2), v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2));
        if (k)
            world_quad(
                w, world_material(w, veil), v3(-2, 2, -2), v3(2, 2, -2), v3(2, 2, 2), v3(-2, 2, 2));
        add_source(w, LAMP);
        rsv_camera camera = { .position = v3(0, 1, 1.5f),
            .forward = v3(0, -0.70710678f, -0.70710678f),
            .right = v3(1, 0, 0),
            .up = v3(0, 0.70710678f, -0.70710678f),
            .vertical_fov = 0.8f };
        assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
        world_commit(w);
        rsv_light *s = solve(w);
        rsv_image *image = picture(s, RSV_RENDER_FINAL, 16);
        mean[k] = 0;
        for (size_t i = 0; i < 48 * 48; i++)
            mean[k] += (double)rsv_image_const_pixels(image, 0)[i].g;
        rsv_image_destroy(image);
        rsv_light_destroy(s);
        world_end(w);
    }
    assert_true(mean[0] > 0);
    assert_close(mean[1], 0.5 * mean[0], 0.02 * mean[0]);
}

static void the_reference_sees_past_blended_cards(void **state)
{
    (void)state;
    for (int source = 0; source < SOURCES; source++) {
        world *w = card_world(source, 0, 0.7f);
        rsv_light *s = solve(w);
        rsv_image *image = picture(s, RSV_RENDER_FINAL, 36);
        rsv_image *truth = picture(s, RSV_RENDER_REFERENCE, 144);
        double error = relative_mse(truth, image);
        if (error > 2e-3) fail_msg("source %d: relative MSE %g", source, error);
        rsv_image_destroy(image);
        rsv_image_destroy(truth);
        rsv_light_destroy(s);
        world_end(w);
    }
}

/// What leaves an element of a card comes from its leaves alone. Black texels, cut out, used to count among the places where
/// the albedo is looked up: fine elements reflected a third too little.
static void elements_are_as_bright_as_what_is_left_of_them(void **state)
{
    (void)state;
    world *w = card_world(POINT, 0.5f, 1);
    rsv_light *s = solve(w);
    const rsv_light_view *light = rsv_light_get_view(s);
    size_t leaves = 0;
    for (size_t n = 0; n < light->elements->node_count; n++) {
        uint32_t triangle = light->elements->face_triangle[light->elements->node_face[n]];
        rsv_rgb albedo = light->exitance_albedo[n];
        if (light->scene.view->position[light->scene.view->triangle[triangle][0]].y != 1) continue;
        if (rgb_is_black(albedo)) continue; // nothing is left of it
        assert_close(albedo.g, 0.6, 1e-3);
        assert_close(albedo.r, 0.2, 1e-3);
        leaves++;
    }
    assert_true(leaves > 50);
    rsv_light_destroy(s);
    world_end(w);
}

// ---- coarse bodies with smooth normals --------------------------------------------------------------

enum { AROUND = 16, ALONG = 8, FACETS = 2 * AROUND * (ALONG - 1) };

/// A sphere of radius 1, of 16 x 8 facets.
static void add_coarse_sphere(world *w, uint32_t material, rsv_vec3 centre, bool smooth)
{
    rsv_vec3 position[(AROUND + 1) * (ALONG + 1)], normal[(AROUND + 1) * (ALONG + 1)];
    uint32_t index[FACETS][3], count = 0, id;
    for (uint32_t k = 0; k < (AROUND + 1) * (ALONG + 1); k++) {
        double theta = M_PI * (k / (AROUND + 1)) / ALONG;
        double phi = 2 * M_PI * (k % (AROUND + 1) % AROUND) / AROUND;
        normal[k] =
            v3((float)(sin(theta) * cos(phi)), (float)cos(theta), (float)(sin(theta) * sin(phi)));
        position[k] = v3_add(centre, normal[k]);
    }
    for (uint32_t k = 0; k < AROUND * ALONG; k++) {
        uint32_t a = k / AROUND * (AROUND + 1) + k % AROUND, b = a + AROUND + 1;
        const uint32_t upper[3] = { a, a + 1, b + 1 }, lower[3] = { a, b + 1, b };
        if (k >= AROUND) memcpy(index[count++], upper, sizeof upper);
        if (k < AROUND * (ALONG - 1)) memcpy(index[count++], lower, sizeof lower);
    }
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "sphere",
        .positions = position,
        .normals = smooth ? normal : NULL,
        .vertex_count = (AROUND + 1) * (ALONG + 1),
        .indices = index[0],
        .triangle_count = count,
        .material = material };
    assert_int_equal(count, FACETS);
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, id, NULL, NULL), RSV_OK);
}

/// One of the places of a facet.
static rsv_specular_path place_of(const world *w, uint32_t facet, uint32_t k)
{
    float x, y, u, v;
    const rsv_scene_view *view = w->transport.view;
    rsv_sobol_2d(k, facet, &x, &y);
    rsv_square_to_triangle(x, y, &u, &v);
    rsv_vec3 normal = rsv_surface_point_at(view, facet, u, v, false).geometric;
    return rsv_specular_begin(&w->transport, NULL, v3_neg(normal), (rsv_hit){ facet, 1, u, v });
}

/// What sources send to a surface that stands alone.
static double unshadowed_at(const world *w, const rsv_surface_point *p)
{
    rsv_local_lights local;
    rsv_punctual_sample light;
    rsv_lights_at(w->lights, p->position, p->normal, &local);
    if (w->transport.view->light_count == 0) return local.unshadowed.g;
    if (!rsv_punctual_at(w->lights, p->position, p->normal, 0, 0, &light)) return 0;
    return light.irradiance.g * f_max(v3_dot(p->normal, light.direction), 0);
}

/// Lambert's law holds by the smooth normals, up to the terminator. Facets that turn away from the light used to be dark
/// before that: off by the sine of 11 degrees.
static void shadows_end_where_smooth_surfaces_turn_away(void **state)
{
    enum { PLACES = 8, TRIES = 16 };
    (void)state;
    for (int source = 0; source < SOURCES; source++) {
        world *w = world_begin(1);
        add_coarse_sphere(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), true);
        add_source(w, source);
        world_commit(w);
        rsv_light *s = solve(w);
        double worst = 0, most = 0;
        for (uint32_t facet = 0; facet < FACETS; facet++) {
            double expected = 0, found = 0;
            for (uint32_t k = 0; k < PLACES; k++) {
                rsv_specular_path path = place_of(w, facet, k);
                rsv_surface_point p =
                    rsv_surface_point_at(w->transport.view, path.triangle, path.u, path.v, false);
                expected += unshadowed_at(w, &p) / PLACES;
                for (uint32_t n = 0; n < TRIES; n++) {
                    rsv_random random = rsv_random_from(facet, k, n);
                    found +=
                        (double)rsv_sampled_irradiance(rsv_light_get_view(s), &path, &random).g /
                        (PLACES * TRIES);
                }
            }
            most = fmax(most, expected);
            worst = fmax(worst, fabs(found - expected));
        }
        if (worst > (source == LAMP ? 0.02 : 0.005) * most)
            fail_msg("source %d: off by %g of %g", source, worst, most);
        rsv_light_destroy(s);
        world_end(w);
    }
}

/// Elements receive by the same law: nothing is missing near the terminator.
static void elements_of_coarse_bodies_miss_no_light(void **state)
{
    (void)state;
    for (int source = 0; source < SOURCES; source++) {
        world *w = world_begin(2);
        add_coarse_sphere(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), true);
        add_source(w, source);
        world_commit(w);
        rsv_light *s = solve(w);
        double found = 0, expected = 0;
        float faint = source == SUN ? 0.6f : 0.5f;
        for (uint32_t facet = 0; facet < FACETS; facet++)
            for (uint32_t k = 0; k < 4; k++) {
                rsv_specular_path c = place_of(w, facet, k);
                rsv_surface_point p =
                    rsv_surface_point_at(w->transport.view, c.triangle, c.u, c.v, false);
                double own = unshadowed_at(w, &p);
                if (own > faint) continue;
                expected += own;
                found += (double)rsv_light_irradiance(s, facet, c.u, c.v, false, RSV_NONE).g;
            }
        if (fabs(found - expected) > 0.05 * expected)
            fail_msg("source %d: %g of %g", source, found, expected);
        rsv_light_destroy(s);
        world_end(w);
    }
}

/// Nothing is lost of light from all around, at any facet.
static void coarse_bodies_gather_all_light(void **state)
{
    (void)state;
    world *w = world_begin(2);
    add_coarse_sphere(w, world_lambert(w, 1, 0), v3(0, 0, 0), true);
    world_room(w, world_lambert(w, 0, 1), v3(-9, -9, -9), v3(9, 9, 9));
    add_camera(w, 1.2f);
    world_commit(w);
    rsv_light *s = solve(w);
    for (uint32_t facet = 0; facet < FACETS; facet++) {
        rsv_specular_path c = place_of(w, facet, 0);
        rsv_rgb e = rsv_light_irradiance(s, c.triangle, c.u, c.v, false, RSV_NONE);
        assert_close(e.g, M_PI, 0.002 * M_PI);
    }
    rsv_image *image = picture(s, RSV_RENDER_REFERENCE, 4);
    for (size_t k = 0; k < 48 * 48; k++)
        assert_close(rsv_image_const_pixels(image, 0)[k].g, 1, 0.03);
    rsv_image_destroy(image);
    rsv_light_destroy(s);
    world_end(w);
}

/// A sphere that protrudes slightly from the floor, with bright light below the floor: none of it gets above.
static void light_does_not_leak_where_bodies_touch(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t white = world_lambert(w, 0.8f, 0);
    add_coarse_sphere(w, white, v3(0, 0.985f, 0), true);
    add_floor(w, 6);
    world_quad(w, white, v3(-6, 2.2f, -6), v3(6, 2.2f, -6), v3(6, 2.2f, 6), v3(-6, 2.2f, 6));
    for (int k = 0; k < 4; k++) { // walls, open below
        float a = k < 2 ? 6.0f : -6.0f, b = k == 1 || k == 2 ? 6.0f : -6.0f;
        world_quad(w, white, v3(a, 0, b), v3(b, 0, -a), v3(b, 2.2f, -a), v3(a, 2.2f, b));
    }
    rsv_punctual_light below = {
        .kind = RSV_PUNCTUAL_POINT, .position = v3(2, -1, 0), .intensity = rgb_gray(99)
    };
    assert_int_equal(rsv_scene_add_light(w->scene, &below), RSV_OK);
    world_commit(w);
    rsv_light *s = solve(w);
    for (uint32_t facet = 0; facet < FACETS; facet++)
        for (uint32_t k = 0; k < 32; k++) {
            rsv_specular_path c = place_of(w, facet, k);
            rsv_surface_point p =
                rsv_surface_point_at(w->transport.view, c.triangle, c.u, c.v, false);
            rsv_random random = rsv_random_from(facet, k, 0);
            if (p.position.y > 1e-4f)
                assert_true(rsv_sampled_irradiance(rsv_light_get_view(s), &c, &random).g == 0);
        }
    rsv_light_destroy(s);
    world_end(w);
}

/// Flat ones are left alone, to the bit.
static void flat_bodies_are_not_lifted(void **state)
{
    (void)state;
    world *w = world_begin(1);
    add_coarse_sphere(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), false);
    world_commit(w);
    const rsv_scene_view *view = w->transport.view;
    for (uint32_t facet = 0; facet < FACETS; facet++) {
        rsv_specular_path c = place_of(w, facet, 3);
        rsv_surface_point p = rsv_surface_point_at(view, facet, c.u, c.v, false), lifted = p;
        rsv_surface_lift(view, w->tracer, facet, c.u, c.v, &lifted);
        assert_memory_equal(&p, &lifted, sizeof p);
    }
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(rays_pass_what_is_left_uncovered),
        cmocka_unit_test(elements_are_as_bright_as_what_is_left_of_them),
        cmocka_unit_test(shadows_end_where_smooth_surfaces_turn_away),
        cmocka_unit_test(elements_of_coarse_bodies_miss_no_light),
        cmocka_unit_test(light_does_not_leak_where_bodies_touch),
        cmocka_unit_test(flat_bodies_are_not_lifted),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(veils_before_rough_metal_keep_its_light),
        cmocka_unit_test(curtains_dim_all_that_passes),
        cmocka_unit_test(blended_cards_shade_like_cut_out_ones),
        cmocka_unit_test(the_reference_sees_past_blended_cards),
        cmocka_unit_test(coarse_bodies_gather_all_light),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
