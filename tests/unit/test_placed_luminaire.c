/// Measured luminaires in scenes: flux, near fields, mirrors, files.
#include "file_fixture.h"
#include "luminaire_fixture.h"

#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "resolvent/render.h"
#include "slow_tests.h"
#include "sources/polygon_irradiance.h"
#include "sources/punctual_light.h"

#define PEAK 1000.0 ///< cd of the lamps whose intensity is a cosine

static void ok(rsv_status status)
{
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
}

static void assert_close(double value, double expected, double tolerance, const char *what)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s is %.7g, expected %.7g within %.2g", what, value, expected, tolerance);
}

static double lux_of(rsv_rgb irradiance)
{
    return RSV_LUMEN_PER_WATT * (double)rgb_luminance(irradiance);
}

// ---- scenes -----------------------------------------------------------------------------------------

static uint32_t add_material(rsv_scene *scene, float albedo, bool mirror)
{
    uint32_t id;
    rsv_material m = rsv_default_material();
    m.base_color = rgb_gray(albedo);
    m.specular = 0;
    m.roughness = 0;
    m.metallic = mirror ? 1 : 0;
    ok(rsv_scene_add_material(scene, &m, &id));
    return id;
}

static void add_quad(rsv_scene *scene, uint32_t material, const float corner[4][3])
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    uint32_t id;
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "quad",
        .positions = (const rsv_vec3 *)corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = material };
    ok(rsv_scene_add_mesh(scene, &mesh, &id));
    ok(rsv_scene_add_instance(scene, id, identity, NULL));
}

/// Far below everything, and black.
static void add_tile(rsv_scene *scene)
{
    static const float corner[4][3] = { { -1, -50, -1 }, { -1, -50, 1 }, { 1, -50, 1 },
        { 1, -50, -1 } };
    add_quad(scene, add_material(scene, 0, false), corner);
}

static char *print_cosine(const char *opening)
{
    char *text = NULL;
    size_t length = 0;
    FILE *s = open_memstream(&text, &length);
    assert_non_null(s);
    fprintf(s, "IESNA:LM-63-2002\n[LUMINAIRE] cosine\nTILT=NONE\n1 -1 1 181 1 1 2 %s\n1 1 10\n",
        opening);
    for (int k = 0; k <= 180; k++)
        fprintf(s, "%g\n", 0.5 * k);
    fprintf(s, "0\n");
    for (int k = 0; k <= 180; k++)
        fprintf(s, "%.6f\n", PEAK * cos(0.5 * k * DEGREES));
    assert_int_equal(fclose(s), 0);
    return text;
}

/// @param text of a file; freed
static rsv_punctual_light add_luminaire(rsv_scene *scene, char *text)
{
    uint32_t id;
    rsv_luminaire luminaire;
    rsv_context *context = rsv_scene_get_context(scene);
    ok(rsv_luminaire_parse(context, "lamp", text, strlen(text), &luminaire));
    ok(rsv_scene_add_luminaire(scene, &luminaire, &id));
    rsv_punctual_light light = rsv_luminaire_light(&luminaire, id);
    light.name = "lamp";
    rsv_luminaire_free(context, &luminaire);
    free(text);
    return light;
}

static rsv_scene *new_scene(rsv_context *context)
{
    rsv_scene *scene;
    ok(rsv_scene_create(context, &scene));
    return scene;
}

static rsv_light *solve(rsv_scene *scene)
{
    rsv_light *light;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    ok(rsv_light_create(scene, &desc, &light));
    return light;
}

// ---- flux -------------------------------------------------------------------------------------------

/// Directions spread evenly over the sphere.
static rsv_vec3 spread(int k, int count)
{
    double up = 2 * (k + 0.5) / count - 1, turn = 2 * M_PI * fmod(k * 0.6180339887498949, 1);
    double across = sqrt(1 - up * up);
    return v3((float)(across * cos(turn)), (float)up, (float)(across * sin(turn)));
}

/// Light that receivers all around a luminaire get from it, compared with the integral of its file.
static void check_flux(rsv_context *context, char *text)
{
    enum { directions = 100000, probes = 3000 };
    rsv_scene *scene = new_scene(context);
    rsv_punctual_light light = add_luminaire(scene, text);
    light.position = v3(1, 2, 3);
    light.direction = v3_normalize(v3(0.3f, -1, 0.2f));
    light.side = v3_normalize(v3_cross(light.direction, v3(0.1f, 0.2f, 1)));
    light.opening = v3(0, 0, 0);
    add_tile(scene);
    ok(rsv_scene_add_light(scene, &light));
    ok(rsv_scene_commit(scene));
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    double sum = 0, flux = rsv_punctual_lumens(view, &view->light[0]);
    for (int k = 0; k < directions; k++) {
        rsv_punctual_sample s;
        rsv_vec3 at = v3_add(light.position, spread(k, directions));
        if (rsv_punctual_arriving(view, &view->light[0], light.position, at, &s))
            sum += lux_of(s.irradiance);
    }
    assert_close(4 * M_PI * sum / directions, flux, 0.002 * flux, "flux");
    rsv_probe probe[probes];
    rsv_probe_reading *reading = calloc(probes, sizeof *reading);
    assert_non_null(reading);
    for (int k = 0; k < probes; k++) {
        rsv_vec3 out = spread(k, probes);
        probe[k] = (rsv_probe){ v3_mad(light.position, 2, out), v3_neg(out) };
    }
    ok(rsv_probe_reference(scene, probe, probes, 32, 0, reading));
    sum = 0;
    for (int k = 0; k < probes; k++)
        sum += lux_of(reading[k].irradiance);
    assert_close(4 * 4 * M_PI * sum / probes, flux, 0.004 * flux, "flux by probes");
    free(reading);
    rsv_scene_destroy(scene);
}

static void flux_on_a_sphere_is_that_of_the_file(void **state)
{
    file_fixture *f = *state;
    for (int version = 1; version < 3; version++)
        for (int symmetry = 0; symmetry < 4; symmetry++)
            check_flux(f->context, write_ies(version, symmetry, 3));
    for (int symmetry = 0; symmetry < 4; symmetry++)
        check_flux(f->context, write_eulumdat(symmetry, 3));
}

// ---- illuminance ------------------------------------------------------------------------------------

static const rsv_probe near_probes[] = { { { 0, 2.5f, 0 }, { 0, 1, 0 } },
    { { 0.4f, 2.6f, -0.3f }, { 0, 0.8f, 0.6f } }, { { 2, 1, 1 }, { 0, 1, 0 } },
    { { 1, 2.8f, 0 }, { -1, 0, 0 } } };
#define NEAR_PROBES (sizeof near_probes / sizeof *near_probes)

/// Lux of a flat opening 1.2 x 0.6 m at y = 3 whose intensity is a cosine: it is equally bright all over and from everywhere.
static double lux_of_panel(const rsv_probe *probe)
{
    const rsv_vec3 corner[4] = { { -.6f, 3, -.3f }, { .6f, 3, -.3f }, { .6f, 3, .3f },
        { -.6f, 3, .3f } };
    double radiance = PEAK / (1.2 * 0.6);
    return radiance *
           fabs((double)rsv_polygon_irradiance(corner, 4, probe->position, probe->normal));
}

static double lux_of_point(const rsv_probe *probe)
{
    double x = 0 - (double)probe->position.x, y = 3 - (double)probe->position.y,
           z = 0 - (double)probe->position.z, square = x * x + y * y + z * z;
    double cosine =
        x * (double)probe->normal.x + y * (double)probe->normal.y + z * (double)probe->normal.z;
    return PEAK * y * fmax(cosine, 0) / (square * square);
}

static void check_readings(const rsv_probe_reading *reading, bool panel, const char *what)
{
    for (size_t k = 0; k < NEAR_PROBES; k++) {
        double expected = (panel ? lux_of_panel : lux_of_point)(&near_probes[k]);
        double error = lux_of(reading[k].standard_error);
        assert_close(
            lux_of(reading[k].irradiance), expected, fmax(0.005 * expected, 4 * error), what);
        assert_close(error, 0, 0.02 * expected, what);
    }
}

static void openings_light_like_surfaces_and_points_by_the_law(void **state)
{
    fixture *f = *state;
    for (int panel = 0; panel < 2; panel++) {
        rsv_probe_reading reading[NEAR_PROBES];
        rsv_probe_desc desc = rsv_default_probe_desc();
        rsv_scene *scene = new_scene(f->context);
        rsv_punctual_light light =
            add_luminaire(scene, print_cosine(panel ? "0.6 1.2 0" : "0 0 0"));
        light.position = v3(0, 3, 0);
        add_tile(scene);
        ok(rsv_scene_add_light(scene, &light));
        ok(rsv_scene_commit(scene));
        ok(rsv_probe_reference(scene, near_probes, NEAR_PROBES, 65536, 0, reading));
        check_readings(reading, panel, "reference");
        rsv_light *solved = solve(scene);
        ok(rsv_probe_irradiance(solved, &desc, near_probes, NEAR_PROBES, reading));
        check_readings(reading, panel, "operator");
        rsv_light_destroy(solved);
        rsv_scene_destroy(scene);
    }
}

/// A floor next to a mirror wall, lit by the lamp and its mirror image.
static void light_is_reflected_by_mirrors(void **state)
{
    fixture *f = *state;
    static const float floor[4][3] = { { 0, 0, -2 }, { 0, 0, 2 }, { 3, 0, 2 }, { 3, 0, -2 } };
    static const float wall[4][3] = { { 0, 0, -2 }, { 0, 3, -2 }, { 0, 3, 2 }, { 0, 0, 2 } };
    rsv_scene *scene = new_scene(f->context);
    rsv_punctual_light light = add_luminaire(scene, print_cosine("0 0 0"));
    light.position = v3(1, 2, 0);
    add_quad(scene, add_material(scene, 0.5f, false), floor);
    add_quad(scene, add_material(scene, 1, true), wall);
    ok(rsv_scene_add_light(scene, &light));
    ok(rsv_scene_commit(scene));
    rsv_light *solved = solve(scene);
    rsv_probe_desc desc = rsv_default_probe_desc();
    desc.mode = RSV_PROBE_LOOKUP;
    const rsv_probe probes[3] = { { { 0.7f, 0, 0.1f }, { 0, 1, 0 } },
        { { 1, 0, -0.5f }, { 0, 1, 0 } }, { { 1.6f, 0, 0.4f }, { 0, 1, 0 } } };
    rsv_probe_reading reading[3];
    ok(rsv_probe_irradiance(solved, &desc, probes, 3, reading));
    for (int k = 0; k < 3; k++) {
        double expected = 0;
        for (int image = -1; image <= 1; image += 2) {
            double x = image - (double)probes[k].position.x, z = (double)probes[k].position.z;
            double square = x * x + 4 + z * z;
            expected += PEAK * 4 / (square * square);
        }
        assert_close(lux_of(reading[k].irradiance), expected, 0.02 * expected, "floor");
    }
    rsv_light_destroy(solved);
    rsv_scene_destroy(scene);
}

// ---- other strengths and directions -----------------------------------------------------------------

static const float floor_corner[4][3] = { { -2, 0, -2 }, { -2, 0, 2 }, { 2, 0, 2 }, { 2, 0, -2 } };

/// Lux on the floor from a lamp whose intensity is a cosine.
static double lux_on_floor(rsv_vec3 lamp, rsv_vec3 direction, const rsv_probe *probe)
{
    rsv_vec3 way = v3_sub(probe->position, lamp);
    double square = (double)v3_dot(way, way);
    return PEAK * fmax((double)v3_dot(way, direction), 0) * (double)lamp.y / (square * square);
}

static void check_floor(
    const rsv_light *solved, rsv_vec3 lamp, rsv_vec3 direction, double scale, double tolerance)
{
    const rsv_probe probes[3] = { { { 0.3f, 0, 0.2f }, { 0, 1, 0 } },
        { { -1, 0, -0.5f }, { 0, 1, 0 } }, { { 1.6f, 0, 1.2f }, { 0, 1, 0 } } };
    rsv_probe_reading reading[3];
    rsv_probe_desc desc = rsv_default_probe_desc();
    desc.mode = RSV_PROBE_LOOKUP;
    ok(rsv_probe_irradiance(solved, &desc, probes, 3, reading));
    for (int k = 0; k < 3; k++) {
        double expected = scale * lux_on_floor(lamp, direction, &probes[k]);
        assert_close(lux_of(reading[k].irradiance), expected, tolerance * expected + 0.5, "floor");
    }
}

static void relighting_dims_and_aims(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f->context);
    rsv_punctual_light light = add_luminaire(scene, print_cosine("0 0 0"));
    light.position = v3(0.2f, 2, -0.1f);
    add_quad(scene, add_material(scene, 0.5f, false), floor_corner);
    ok(rsv_scene_add_light(scene, &light));
    ok(rsv_scene_commit(scene));
    rsv_light *solved = solve(scene);
    check_floor(solved, light.position, v3(0, -1, 0), 1, 0.01);
    rsv_relighter *relighter;
    ok(rsv_relighter_create(solved, &relighter));
    const rsv_light_scale half = { "lamp", { 0.5f, 0.5f, 0.5f } };
    const rsv_light_aim aim = { "lamp", { 1, -2, 0.5f } }, none = { "lamp", { 0, 0, 0 } };
    ok(rsv_relighter_change(relighter, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc),
                                           .light = &half,
                                           .light_count = 1,
                                           .aim = &aim,
                                           .aim_count = 1 }));
    ok(rsv_relighter_refine(relighter));
    check_floor(solved, light.position, v3_normalize(aim.direction), 0.5, 0.01);
    const rsv_scene_view *view = rsv_scene_get_view(rsv_light_scene(solved));
    assert_float_equal(v3_dot(view->light[0].side, view->light[0].direction), 0, 1e-6);
    assert_int_equal(
        rsv_relighter_change(relighter,
            &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .aim = &none, .aim_count = 1 }),
        RSV_ERROR_ARGUMENT);
    ok(rsv_relighter_change(relighter, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc) }));
    ok(rsv_relighter_refine(relighter));
    check_floor(solved, light.position, v3(0, -1, 0), 1, 0.01);
    rsv_relighter_destroy(relighter);
    rsv_light_destroy(solved);
    rsv_scene_destroy(scene);
}

/// An office has hundreds: one after the other is made to shine alone.
static void any_number_of_lights_is_relit(void **state)
{
    enum { lamps = 80 };
    fixture *f = *state;
    static char name[lamps][24];
    rsv_scene *scene = new_scene(f->context);
    rsv_punctual_light light = add_luminaire(scene, print_cosine("0 0 0"));
    add_quad(scene, add_material(scene, 0.5f, false), floor_corner);
    for (int k = 0; k < lamps; k++) {
        snprintf(name[k], sizeof name[k], "lamp %d", k);
        light.name = name[k];
        light.position = v3(-1.9f + 0.025f * (float)k, 2, 0.3f * (float)(k % 7) - 1);
        ok(rsv_scene_add_light(scene, &light));
    }
    ok(rsv_scene_commit(scene));
    rsv_light *solved = solve(scene);
    rsv_light_scale scale[lamps];
    for (int alone = 3; alone < lamps; alone += 30) {
        rsv_relighter *relighter;
        ok(rsv_relighter_create(solved, &relighter));
        for (int k = 0; k < lamps; k++)
            scale[k] = (rsv_light_scale){ name[k], rgb_gray(k == alone ? 1 : 0) };
        ok(rsv_relighter_change(relighter,
            &(rsv_relight_desc){
                .size = sizeof(rsv_relight_desc), .light = scale, .light_count = lamps }));
        ok(rsv_relighter_settle(relighter));
        rsv_vec3 lamp = v3(-1.9f + 0.025f * (float)alone, 2, 0.3f * (float)(alone % 7) - 1);
        check_floor(
            solved, lamp, v3(0, -1, 0), 1, 0.04); // noise of the whole, whose lights are drawn
        ok(rsv_relighter_change(
            relighter, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc) }));
        ok(rsv_relighter_settle(relighter));
        rsv_relighter_destroy(relighter);
    }
    rsv_light_destroy(solved);
    rsv_scene_destroy(scene);
}

// ---- names and files --------------------------------------------------------------------------------

static rsv_scene *room_with(rsv_context *context, const char *opening)
{
    static const float floor[4][3] = { { -2, 0, -2 }, { -2, 0, 2 }, { 2, 0, 2 }, { 2, 0, -2 } };
    rsv_scene *scene = new_scene(context);
    rsv_punctual_light light = add_luminaire(scene, print_cosine(opening));
    light.position = v3(0.5f, 2, 0);
    light.direction = v3_normalize(v3(0.2f, -1, 0.1f));
    light.side = v3_normalize(v3_cross(light.direction, v3(0, 0.3f, 1)));
    light.intensity = rgb_mul(light.intensity, rgb(1, 0.5f, 0.25f));
    add_quad(scene, add_material(scene, 0.5f, false), floor);
    ok(rsv_scene_add_light(scene, &light));
    ok(rsv_scene_commit(scene));
    return scene;
}

static void assert_same_light(const rsv_scene *a, const rsv_scene *b, float tolerance)
{
    const rsv_scene_view *left = rsv_scene_get_view(a), *right = rsv_scene_get_view(b);
    assert_int_equal(right->light_count, 1);
    assert_int_equal(right->luminaire_count, 1);
    const rsv_punctual_light *x = left->light, *y = right->light;
    assert_int_equal(y->kind, RSV_PUNCTUAL_LUMINAIRE);
    const float *was[] = { &x->position.x, &x->direction.x, &x->side.x, &x->opening.x,
        &x->intensity.r };
    const float *is[] = { &y->position.x, &y->direction.x, &y->side.x, &y->opening.x,
        &y->intensity.r };
    for (int k = 0; k < 5; k++)
        for (int i = 0; i < 3; i++)
            assert_float_equal(is[k][i], was[k][i], tolerance);
    assert_float_equal(rsv_punctual_lumens(right, y), rsv_punctual_lumens(left, x),
        fmax(1, 1e7 * (double)tolerance) * 1e-4);
}

static void files_keep_luminaires(void **state)
{
    file_fixture *f = *state;
    const char *opening[] = { "0 0 0", "0.6 1.2 0", "-0.4 -0.4 0.05" };
    for (int k = 0; k < 3; k++) {
        rsv_scene *scene = room_with(f->context, opening[k]), *again;
        const char *path = path_in(&f->folder, "room.glb");
        ok(rsv_scene_save(scene, path));
        ok(rsv_scene_load(f->context, path, &again));
        assert_same_light(scene, again, 1e-6f);
        rsv_scene_destroy(again);
        rsv_light *solved = solve(scene), *reread;
        path = path_in(&f->folder, "room.safetensors");
        ok(rsv_light_save(solved, "room", path));
        ok(rsv_light_load(f->context, path, &again, &reread));
        assert_same_light(scene, again, 0);
        rsv_light_destroy(reread);
        rsv_scene_destroy(again);
        rsv_light_destroy(solved);
        rsv_scene_destroy(scene);
    }
}

static void lights_and_objects_are_found_by_name(void **state)
{
    fixture *f = *state;
    rsv_luminaire luminaire;
    char *text = print_cosine("0 0 0");
    ok(rsv_luminaire_parse(f->context, "lamp", text, strlen(text), &luminaire));
    free(text);
    rsv_scene *scene = new_scene(f->context);
    rsv_punctual_light lights[] = { { .name = "desk 1", .kind = RSV_PUNCTUAL_POINT },
        { .name = "desk 2", .kind = RSV_PUNCTUAL_SPOT, .direction = { 1, 0, 0 } },
        { .name = "sun", .kind = RSV_PUNCTUAL_DIRECTIONAL, .direction = { 0, -1, 0 } } };
    for (int k = 0; k < 3; k++) {
        lights[k].intensity = rgb_gray(1);
        ok(rsv_scene_add_light(scene, &lights[k]));
    }
    add_tile(scene);
    ok(rsv_scene_place_luminaire(scene, "desk*", &luminaire));
    ok(rsv_scene_place_luminaire(scene, "quad", &luminaire));
    assert_int_equal(rsv_scene_place_luminaire(scene, "lamp", &luminaire), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "lamp");
    ok(rsv_scene_place_luminaire(scene, "sun", &luminaire));
    assert_mentions(f->log, "infinitely far");
    ok(rsv_scene_commit(scene));
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->light_count, 4);
    assert_int_equal(view->light[0].kind, RSV_PUNCTUAL_LUMINAIRE);
    assert_float_equal(view->light[0].direction.y, -1, 0);
    assert_float_equal(view->light[1].direction.x, 1, 0);
    assert_float_equal(v3_dot(view->light[1].side, view->light[1].direction), 0, 1e-6);
    assert_int_equal(view->light[2].kind, RSV_PUNCTUAL_DIRECTIONAL);
    assert_string_equal(view->light[3].name, "quad");
    rsv_luminaire_free(f->context, &luminaire);
    rsv_scene_destroy(scene);
}

static void what_no_scene_can_hold_is_refused(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = new_scene(f->context);
    rsv_punctual_light light = add_luminaire(scene, print_cosine("0 0 0")), wrong;
    wrong = light, wrong.luminaire = 1;
    assert_int_equal(rsv_scene_add_light(scene, &wrong), RSV_ERROR_FORMAT);
    wrong = light, wrong.side = light.direction;
    assert_int_equal(rsv_scene_add_light(scene, &wrong), RSV_ERROR_FORMAT);
    wrong = light, wrong.opening.x = NAN;
    assert_int_equal(rsv_scene_add_light(scene, &wrong), RSV_ERROR_FORMAT);
    float angle[2] = { 90, 0 }, intensity[2] = { 1, 1 };
    rsv_luminaire luminaire = { .vertical_count = 2,
        .horizontal_count = 1,
        .vertical = angle,
        .horizontal = angle,
        .intensity = intensity };
    assert_int_equal(rsv_scene_add_luminaire(scene, &luminaire, NULL), RSV_ERROR_FORMAT);
    rsv_scene_destroy(scene);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test_setup_teardown(
            openings_light_like_surfaces_and_points_by_the_law, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            light_is_reflected_by_mirrors, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(relighting_dims_and_aims, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(files_keep_luminaires, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            lights_and_objects_are_found_by_name, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            what_no_scene_can_hold_is_refused, fixture_setup, fixture_teardown),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test_setup_teardown(
            flux_on_a_sphere_is_that_of_the_file, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            any_number_of_lights_is_relit, fixture_setup, fixture_teardown),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
