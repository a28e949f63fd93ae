/// Punctual lights seen from places by way of mirrors, panes, prisms and balls.
#include "connect/connect.h"
#include "light_fixture.h"

static void add_light(world *w, rsv_punctual_light light)
{
    light.intensity = rgb_gray(1);
    assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
}

static rsv_connections *connect_world(world *w)
{
    rsv_connections *c;
    world_commit(w);
    assert_int_equal(rsv_connections_create(&w->transport, w->lights, &c), RSV_OK);
    assert_non_null(c);
    return c;
}

/// Unpolarised transmittance into an index `eta` times as high.
static double transmitted(double cos_i, double cos_t, double eta)
{
    double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    double p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 1 - 0.5 * (s * s + p * p);
}

/// Passes a face whose normal lies `tilt` from the beam's axis, in the plane of the angles. @param share of irradiance that is left
static double pass_face(double angle, double tilt, double eta, double *share)
{
    double in = angle - tilt, out = asin(sin(in) / eta);
    *share *= transmitted(cos(in), cos(out), eta) * cos(in) / cos(out);
    return tilt + out;
}

#define TILT (20 * M_PI / 180) ///< of the prism's second face

/// Between x = -3 and 3: a vertical face at z = 0, and one that leans away behind it.
static void build_prism(world *w)
{
    float deep = 0.2f, far = 0.2f + 2 * (float)tan(TILT);
    const rsv_vec3 p[8] = { { -3, 0, 0 }, { 3, 0, 0 }, { 3, 2, 0 }, { -3, 2, 0 }, { -3, 0, -deep },
        { 3, 0, -deep }, { 3, 2, -far }, { -3, 2, -far } };
    static const uint32_t index[36] = { 0, 1, 2, 0, 2, 3, 5, 4, 7, 5, 7, 6, 0, 4, 5, 0, 5, 1, 3, 2,
        6, 3, 6, 7, 0, 3, 7, 0, 7, 4, 1, 5, 6, 1, 6, 2 };
    world_triangles(w, world_material(w, glass_material()), p, 8, index, 12);
}

/// The connection that arrives along a direction; without light if there is none.
static rsv_connection connection_along(const rsv_connections *c, rsv_vec3 point, rsv_vec3 along)
{
    rsv_connection found[RSV_MOST_CONNECTIONS];
    size_t count = rsv_connect(c, point, found);
    for (size_t k = 0; k < count; k++)
        if (v3_dot(found[k].towards, along) < -1 + 1e-5f) return found[k];
    return (rsv_connection){ along, rgb_gray(0), false };
}

static void prisms_turn_beams(void **state)
{
    (void)state;
    double share = 1, angle = 10 * M_PI / 180;
    world *w = world_begin(2);
    build_prism(w);
    rsv_vec3 sent = v3(0, (float)sin(angle), -(float)cos(angle));
    add_light(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL, .direction = sent });
    rsv_connections *c = connect_world(w);
    angle = pass_face(angle, 0, 1.5, &share);
    angle = pass_face(angle, -TILT, 1 / 1.5, &share);
    rsv_vec3 left = v3(0, (float)sin(angle), -(float)cos(angle));
    rsv_vec3 exit = v3(0.3f, 1, -0.2f - (float)tan(TILT));
    rsv_connection found = connection_along(c, v3_mad(exit, 0.5f, left), left);
    assert_close((double)found.irradiance.g, share, 1e-5);
    // outside the beam, no light arrives along it
    found = connection_along(c, v3(0.3f, 6, -1), left);
    assert_true(found.irradiance.g == 0);
    rsv_connections_destroy(c);
    world_end(w);
}

/// A mirror below a window sends the sun to the ceiling, between the images of its edges alone.
static void shelves_light_ceilings(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t mirror = world_material(w, mirror_material(1));
    world_quad(w, mirror, v3(-2, 2, -1), v3(-2, 2, 0), v3(2, 2, 0), v3(2, 2, -1));
    rsv_vec3 sent = v3_normalize(v3(0, -1, -1));
    add_light(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL, .direction = sent });
    rsv_connections *c = connect_world(w);
    const rsv_vec3 down = v3(0, -1, 0);
    assert_close(
        (double)rsv_connected_irradiance(c, v3(0, 2.7f, -1.2f), down, false).g, sqrt(0.5), 1e-6);
    assert_true(rsv_connected_irradiance(c, v3(0, 2.7f, -1.2f), v3(0, 1, 0), false).g == 0);
    assert_true(rsv_connected_irradiance(c, v3(0, 2.7f, -0.69f), down, false).g == 0);
    assert_true(rsv_connected_irradiance(c, v3(0, 2.7f, -1.71f), down, false).g == 0);
    // on the diagonal of its two triangles, the light counts once
    assert_close(
        (double)rsv_connected_irradiance(c, v3(0, 2.5f, -1), down, false).g, sqrt(0.5), 1e-6);
    rsv_connections_destroy(c);
    world_end(w);
}

static void panes_dim_lamps(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material glass = glass_material();
    glass.thickness = 0;
    uint32_t pane = world_material(w, glass);
    world_quad(w, pane, v3(-9, 2, -9), v3(-9, 2, 9), v3(9, 2, 9), v3(9, 2, -9));
    add_light(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_POINT, .position = { 0, 3, 0 } });
    rsv_connections *c = connect_world(w);
    double inner = sqrt(1 - 0.5 / 2.25), expected = transmitted(sqrt(0.5), inner, 1.5) / 18;
    rsv_rgb got = rsv_connected_irradiance(c, v3(3, 0, 0), v3_normalize(v3(-1, 1, 0)), false);
    assert_close((double)got.g, expected, 1e-5 * expected);
    rsv_connections_destroy(c);
    world_end(w);
}

/// Irradiance behind a unit ball in a beam along z, at r from the axis; light that passes without a reflection inside.
static double behind_ball(double r, double z, double ior)
{
    double low = 0, high = 0.7; // height of the ray; the image is upside down
    for (int k = 0; k < 60; k++) {
        double h = (low + high) / 2, turn = 2 * (asin(h) - asin(h / ior));
        double at =
            sin(2 * asin(h / ior) - asin(h)) - (z - cos(2 * asin(h / ior) - asin(h))) * tan(turn);
        *(at > -r ? &low : &high) = h;
    }
    double r_of[2], step = 1e-5;
    for (int k = 0; k < 2; k++) {
        double h = low + k * step, turn = 2 * (asin(h) - asin(h / ior)),
               p = 2 * asin(h / ior) - asin(h);
        r_of[k] = fabs(sin(p) - (z - cos(p)) * tan(turn));
    }
    double passed = transmitted(cos(asin(low)), cos(asin(low / ior)), ior);
    return passed * passed * low * step / (r * (r_of[1] - r_of[0]));
}

/// A glass ball gathers a beam. @param expected W/m2 of the strongest connection, at r from the axis
static void balls_gather_beams(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material glass = glass_material();
    glass.ior = 1.33f;
    world_sphere(w, world_material(w, glass), v3(0, 0, 0), 1, 5);
    add_light(
        w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_DIRECTIONAL, .direction = v3(0, 0, 1) });
    rsv_connections *c = connect_world(w);
    for (int k = 0; k < 32; k++) {
        float r = 0.1f + 0.015f * (float)k, turn = 2.4f * (float)k;
        rsv_vec3 point = v3(r * cosf(turn), r * sinf(turn), 4);
        rsv_connection found[RSV_MOST_CONNECTIONS];
        size_t count = rsv_connect(c, point, found);
        float most = 0;
        for (size_t j = 0; j < count; j++)
            most = f_max(most, -found[j].towards.z * found[j].irradiance.g);
        double expected = behind_ball((double)r, 4, 1.33);
        assert_close((double)most, expected, 0.01 * expected);
    }
    rsv_connections_destroy(c);
    world_end(w);
}

static void nothing_smooth_has_no_connections(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_connections *c;
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-1, 0, -1), v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1));
    add_light(w, (rsv_punctual_light){ .kind = RSV_PUNCTUAL_POINT, .position = { 0, 3, 0 } });
    world_commit(w);
    assert_int_equal(rsv_connections_create(&w->transport, w->lights, &c), RSV_OK);
    assert_null(c);
    assert_true(rgb_is_black(rsv_connected_irradiance(NULL, v3(0, 1, 0), v3(0, 1, 0), false)));
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prisms_turn_beams),
        cmocka_unit_test(shelves_light_ceilings),
        cmocka_unit_test(panes_dim_lamps),
        cmocka_unit_test(balls_gather_beams),
        cmocka_unit_test(nothing_smooth_has_no_connections),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
