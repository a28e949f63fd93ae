/// Textures: the pyramid, lookups, materials at a point, cut-outs, coverage, textured emitters.
#include "core/sampling.h"
#include "core/srgb.h"
#include "resolvent/render.h"
#include "resolvent/trace.h"
#include "scene/material_at.h"
#include "scene/scene.h"
#include "scene_fixture.h"
#include "slow_tests.h"
#include "sources/lights.h"

static uint32_t add_codes(rsv_scene *scene, uint32_t width, uint32_t height, uint32_t channels,
    const uint8_t *codes, bool srgb, bool nearest)
{
    uint32_t id;
    rsv_texture_desc desc = { .size = sizeof desc,
        .name = "codes",
        .width = width,
        .height = height,
        .channel_count = channels,
        .codes = codes,
        .srgb = srgb,
        .nearest = nearest };
    assert_int_equal(rsv_scene_add_texture(scene, &desc, &id), RSV_OK);
    return id;
}

/// A square of `size` metres around `centre`, facing +z, or -z if `size` is negative; uv (0, 0) on top left.
static void add_square(rsv_scene *scene, uint32_t material, float size, rsv_vec3 centre)
{
    float h = 0.5f * size, top = fabsf(h);
    rsv_vec3 position[4] = { { -h, top, 0 }, { -h, -top, 0 }, { h, -top, 0 }, { h, top, 0 } };
    static const float uv[4][2] = { { 0, 0 }, { 0, 1 }, { 1, 1 }, { 1, 0 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    for (int k = 0; k < 4; k++)
        position[k] = v3_add(position[k], centre);
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "square",
        .positions = position,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = material,
        .uvs = { uv, NULL } };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, NULL, NULL), RSV_OK);
}

static uint32_t add_textured(rsv_scene *scene, rsv_material m, rsv_texture_role role, uint32_t id)
{
    rsv_texture_ref ref = rsv_default_texture_ref(role, id);
    uint32_t material;
    m.textures = &ref;
    m.texture_count = 1;
    assert_int_equal(rsv_scene_add_material(scene, &m, &material), RSV_OK);
    return material;
}

static rsv_material lambert(float albedo)
{
    rsv_material m = rsv_default_material();
    m.specular = 0;
    m.base_color = rgb_gray(albedo);
    return m;
}

/// A green leaf on white paper that is cut away, half of the area: all levels of the pyramid are green.
static void what_is_cut_away_lends_no_colour(void **state)
{
    fixture *f = *state;
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    uint8_t codes[8][8][4];
    for (int k = 0; k < 64; k++) {
        bool leaf = (k / 8 * 5 + k % 8 * 3) % 8 < 4;
        memcpy(codes[k / 8][k % 8], leaf ? "\0\x80\0\xff" : "\xff\xff\xff\0", 4);
    }
    rsv_material m = lambert(1);
    m.alpha_cutoff = 0.5f;
    uint32_t id = add_codes(scene, 8, 8, 4, &codes[0][0][0], false, false);
    const rsv_texture_ref refs[2] = { rsv_default_texture_ref(RSV_TEXTURE_BASE_COLOR, id),
        rsv_default_texture_ref(RSV_TEXTURE_OPACITY, id) };
    m.textures = refs;
    m.texture_count = 2;
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
    const rsv_texture *texture = &scene->texture[id];
    rsv_texel mean = rsv_texture_mean(texture);
    assert_float_equal(mean.r, 0, 1e-4);
    assert_float_equal(mean.g, 128 / 255.0, 1e-4);
    assert_float_equal(mean.a, 0.5, 1e-4);
    for (int k = 0; k < 300; k++) { // nor does it between texels, and between levels
        float u = rsv_unit_float(rsv_hash((uint32_t)k)),
              v = rsv_unit_float(rsv_hash2((uint32_t)k, 1));
        rsv_texel at = rsv_texture_lookup(texture, u, v, (float)(k % 30) / 10);
        if (at.a > 1e-3f) assert_float_equal(at.r, 0, 1e-4);
        if (at.a > 1e-3f) assert_float_equal(at.g, 128 / 255.0, 1e-3);
    }

    m.texture_count = 1; // somebody shows the paper too
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
    assert_float_equal(rsv_texture_mean(texture).r, 0.5, 1e-4);
    rsv_scene_destroy(scene);
}

static void pyramid_keeps_the_mean_of_odd_sizes(void **state)
{
    fixture *f = *state;
    enum { W = 37, H = 11 };
    float values[W * H][3];
    double mean[3] = { 0 };
    for (int k = 0; k < W * H * 3; k++) {
        values[k / 3][k % 3] = (float)(rsv_unit_float(rsv_hash((uint32_t)k)) * (k % 7));
        mean[k % 3] += values[k / 3][k % 3] / (double)(W * H);
    }
    rsv_texture_desc desc = {
        .size = sizeof desc, .width = W, .height = H, .channel_count = 3, .values = values[0]
    };
    rsv_texture texture;
    assert_int_equal(rsv_texture_create(f->context, &desc, &texture), RSV_OK);
    assert_int_equal(texture.level_count, 6); // 37 18 9 4 2 1
    rsv_texel whole = rsv_texture_mean(&texture);
    assert_float_equal(whole.r, mean[0], 1e-5);
    assert_float_equal(whole.g, mean[1], 1e-5);
    assert_float_equal(whole.b, mean[2], 1e-5);
    assert_true(whole.a == 1);
    rsv_texture_release(f->context, &texture);
}

static void codes_are_averaged_in_linear_light(void **state)
{
    fixture *f = *state;
    static const uint8_t codes[2][4] = { { 0, 0, 0, 0 }, { 255, 188, 64, 128 } };
    rsv_texture_desc desc = { .size = sizeof desc,
        .width = 2,
        .height = 1,
        .channel_count = 4,
        .codes = codes[0],
        .srgb = true,
        .wrap_u = RSV_WRAP_CLAMP };
    rsv_texture texture;
    assert_int_equal(rsv_texture_create(f->context, &desc, &texture), RSV_OK);
    rsv_texel mean = rsv_texture_mean(&texture), last = rsv_texture_lookup(&texture, 1, 0.5f, 0);
    // texels are kept to 16 bits
    assert_float_equal(mean.r, 0.5, 1.0 / 65535);
    assert_float_equal(mean.g, 0.5 * rsv_srgb_decode(188 / 255.0), 1.0 / 65535);
    assert_float_equal(last.b, rsv_srgb_decode(64 / 255.0), 1.0 / 65535);
    assert_float_equal(last.a, 128 / 255.0, 1.0 / 65535); // coverage is no colour
    rsv_texture_release(f->context, &texture);
}

static float looked_up(rsv_context *context, rsv_wrap wrap, float u)
{
    static const uint8_t codes[4] = { 0, 51, 102, 255 };
    rsv_texture_desc desc = { .size = sizeof desc,
        .width = 4,
        .height = 1,
        .channel_count = 1,
        .codes = codes,
        .wrap_u = wrap,
        .nearest = true };
    rsv_texture texture;
    assert_int_equal(rsv_texture_create(context, &desc, &texture), RSV_OK);
    float value = rsv_texture_lookup(&texture, u, 0.5f, 0).r;
    rsv_texture_release(context, &texture);
    return value;
}

static void coordinates_repeat_mirror_or_stop(void **state)
{
    fixture *f = *state;
    const struct {
        rsv_wrap wrap;
        float u, value;
    } expected[] = {
        { RSV_WRAP_REPEAT, 0.3f, 0.2f },
        { RSV_WRAP_REPEAT, 1.3f, 0.2f },
        { RSV_WRAP_REPEAT, -0.1f, 1 },
        { RSV_WRAP_MIRROR, 1.1f, 1 },
        { RSV_WRAP_MIRROR, -0.3f, 0.2f },
        { RSV_WRAP_MIRROR, 2.3f, 0.2f },
        { RSV_WRAP_CLAMP, 7, 1 },
        { RSV_WRAP_CLAMP, -7, 0 },
        { RSV_WRAP_REPEAT, NAN, 0 },
        { RSV_WRAP_CLAMP, INFINITY, 0 },
    };
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
        assert_float_equal(
            looked_up(f->context, expected[k].wrap, expected[k].u), expected[k].value, 1e-4);
}

static void material_at_a_point_multiplies_its_texels(void **state)
{
    fixture *f = *state;
    static const uint8_t codes[] = { 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255 };
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    uint32_t texture = add_codes(scene, 2, 2, 3, codes, false, true);
    add_square(
        scene, add_textured(scene, lambert(0.8f), RSV_TEXTURE_BASE_COLOR, texture), 2, v3(0, 0, 0));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    // triangle 0: corners top left, bottom left, bottom right
    rsv_rgb top_left = rsv_material_at(view, 0, 0.1f, 0.05f, 0).base_color;
    rsv_rgb bottom_right = rsv_material_at(view, 0, 0.05f, 0.9f, 0).base_color;
    rsv_rgb all = rsv_material_at(view, 0, 0.3f, 0.3f, INFINITY).base_color;
    assert_float_equal(top_left.r, 0.8f, 1e-6);
    assert_float_equal(top_left.g, 0, 1e-6);
    assert_float_equal(bottom_right.g, 0.8f, 1e-6);
    assert_float_equal(all.r, 0.4f, 1e-4);
    assert_float_equal(all.b, 0.4f, 1e-4);
    rsv_scene_destroy(scene);
}

static void normal_map_leans_as_the_picture_shows(void **state)
{
    fixture *f = *state;
    static const uint8_t codes[] = { 255, 128, 128, 128, 255, 128 }; // right; up
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    uint32_t texture = add_codes(scene, 2, 1, 3, codes, false, true);
    add_square(
        scene, add_textured(scene, lambert(0.8f), RSV_TEXTURE_NORMAL, texture), 2, v3(0, 0, 0));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_vec3 left = rsv_mapped_normal(view, 0, 0.1f, 0.05f, 0, v3(0, 0, 1));
    rsv_vec3 right = rsv_mapped_normal(view, 0, 0.05f, 0.9f, 0, v3(0, 0, 1));
    assert_true(left.x > 0.99f);
    assert_true(right.y > 0.99f);
    rsv_scene_destroy(scene);
}

/// Two triangles that meet at an angle, with one smooth normal and different directions of u on each.
static void normal_map_is_continuous_across_smooth_edges(void **state)
{
    fixture *f = *state;
    static const uint8_t codes[3] = { 200, 90, 200 };
    static const rsv_vec3 position[4] = { { -1, 0, -1 }, { 0, -1, 0 }, { 0, 1, 0 }, { 1, 0, -1 } };
    static const rsv_vec3 normal[4] = { { -1, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 }, { 1, 0, 1 } };
    static const float uv[4][2] = { { 0, 0.4f }, { 0.5f, 1 }, { 0.6f, 0 }, { 1, 0.8f } };
    static const uint32_t index[6] = { 0, 1, 2, 2, 1, 3 };
    rsv_scene *scene;
    uint32_t id;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    uint32_t texture = add_codes(scene, 1, 1, 3, codes, false, false);
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "fold",
        .positions = position,
        .normals = normal,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = add_textured(scene, lambert(0.5f), RSV_TEXTURE_NORMAL, texture),
        .uvs = { uv, NULL } };
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, NULL, NULL), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_vec3 one = rsv_mapped_normal(view, 0, 0.7f, 0.3f, 0, v3(0, 0, 1));
    rsv_vec3 other = rsv_mapped_normal(view, 1, 0.7f, 0, 0, v3(0, 0, 1));
    assert_float_equal(v3_dot(one, other), 1, 1e-6);
    assert_true(one.x > 0.3f);
    rsv_scene_destroy(scene);
}

/// A square whose left half is cut out.
static rsv_scene *half_square(fixture *f)
{
    static const uint8_t codes[] = { 255, 255, 255, 0, 255, 255, 255, 255 };
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_material m = lambert(0.5f);
    m.alpha_cutoff = 0.5f;
    uint32_t texture = add_codes(scene, 2, 1, 4, codes, true, true);
    add_square(scene, add_textured(scene, m, RSV_TEXTURE_OPACITY, texture), 2, v3(0, 0, 0));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

static void rays_pass_where_a_surface_is_cut_out(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = half_square(f);
    rsv_tracer *tracer;
    assert_int_equal(rsv_tracer_create(scene, &tracer), RSV_OK);
    rsv_ray_packet closest = { 0 };
    for (int k = 0; k < 16; k++) {
        rsv_ray ray = { v3(-0.9f + 0.12f * (float)k, 0.3f, 1), v3(0, 0, -1), 10 };
        bool covered = ray.origin.x > 0;
        rsv_hit hit;
        assert_int_equal(rsv_tracer_closest(tracer, &ray, &hit), covered);
        assert_int_equal(rsv_tracer_occluded(tracer, &ray), covered);
        closest.origin_x[k] = ray.origin.x;
        closest.origin_y[k] = ray.origin.y;
        closest.origin_z[k] = 1;
        closest.direction_z[k] = -1;
        closest.t_max[k] = 10;
        closest.mask[k] = UINT32_MAX;
    }
    rsv_ray_packet occluded = closest;
    rsv_tracer_closest_packet(tracer, &closest, true);
    rsv_tracer_occluded_packet(tracer, &occluded, true);
    for (int k = 0; k < 16; k++) {
        assert_int_equal(closest.triangle[k] != RSV_NONE, closest.origin_x[k] > 0);
        assert_int_equal(occluded.t_max[k]<0, closest.origin_x[k]> 0);
    }
    rsv_tracer_destroy(tracer);
    rsv_scene_destroy(scene);
}

static void unusable_textures_are_refused(void **state)
{
    fixture *f = *state;
    static const uint8_t code[4] = { 0 };
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_texture_desc desc = { .size = sizeof desc,
        .name = "huge",
        .width = 100000,
        .height = 1,
        .channel_count = 1,
        .codes = code };
    assert_int_equal(rsv_scene_add_texture(scene, &desc, NULL), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "texture 'huge': 100000 x 1");
    desc.width = 0;
    assert_int_equal(rsv_scene_add_texture(scene, &desc, NULL), RSV_ERROR_FORMAT);
    desc.width = 1;
    desc.codes = NULL;
    assert_int_equal(rsv_scene_add_texture(scene, &desc, NULL), RSV_ERROR_ARGUMENT);
    float values[3] = { NAN, INFINITY, 1 };
    desc = (rsv_texture_desc){ .size = sizeof(rsv_texture_desc),
        .name = "holes",
        .width = 1,
        .height = 1,
        .channel_count = 3,
        .values = values };
    assert_int_equal(rsv_scene_add_texture(scene, &desc, NULL), RSV_OK);
    assert_mentions(f->log, "texture 'holes': 2 values are not finite");

    rsv_material m = lambert(0.5f);
    rsv_texture_ref ref = rsv_default_texture_ref(RSV_TEXTURE_BASE_COLOR, 7);
    m.name = "wall";
    m.textures = &ref;
    m.texture_count = 1;
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "material 'wall': texture 7 does not exist");
    ref.texture = 0;
    ref.uv_set = 2;
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_ERROR_ARGUMENT);
    ref.uv_set = 0;
    ref.transform[1][2] = NAN;
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_ERROR_FORMAT);
    rsv_scene_destroy(scene);
}

// ---- light --------------------------------------------------------------------------------------

static rsv_rgb read_irradiance(const rsv_scene *scene, rsv_probe_mode mode, rsv_vec3 at, rsv_vec3 n)
{
    rsv_probe probe = { at, n };
    rsv_probe_reading reading;
    if (mode == RSV_PROBE_REFERENCE) {
        assert_int_equal(rsv_probe_reference(scene, &probe, 1, 1 << 16, 1, &reading), RSV_OK);
        return reading.irradiance;
    }
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(scene, &desc, &solution), RSV_OK);
    assert_int_equal(
        rsv_probe_irradiance(solution,
            &(rsv_probe_desc){ sizeof(rsv_probe_desc), mode, 1 << 16, 1 }, &probe, 1, &reading),
        RSV_OK);
    rsv_light_destroy(solution);
    return reading.irradiance;
}

static void check_both_modes(
    const rsv_scene *scene, rsv_vec3 at, rsv_vec3 n, double expected, double tolerance)
{
    double reference = read_irradiance(scene, RSV_PROBE_REFERENCE, at, n).g;
    double solved = read_irradiance(scene, RSV_PROBE_OPERATOR, at, n).g;
    assert_float_equal(reference, expected, tolerance * expected);
    assert_float_equal(solved, expected, tolerance * expected);
}

/// Form factor of a square of side 2 at distance 1, seen from its axis by a parallel receiver.
static double square_form_factor(void)
{
    double x = 1 / sqrt(2.0);
    return 4 / (2 * M_PI) * 2 * x * atan(x);
}

static void emitters_shine_as_bright_as_their_texels(void **state)
{
    fixture *f = *state;
    // bright in the upper left and lower right quarter: half of the light, from anywhere on the axis
    static const uint8_t codes[] = { 255, 0, 0, 255 };
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_material m = lambert(0);
    m.emission = rgb_gray(8);
    uint32_t texture = add_codes(scene, 2, 2, 1, codes, false, true);
    add_square(scene, add_textured(scene, m, RSV_TEXTURE_EMISSION, texture), 2, v3(0, 0, 0));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    double expected = 8 * M_PI * square_form_factor() / 2;
    check_both_modes(scene, v3(0, 0, 1), v3(0, 0, -1), expected, 0.01);
    rsv_scene_destroy(scene);
}

/// One texel of 256 shines: chosen by area, one sample in 256 would find it, and their relative standard deviation
/// would be 16.
static void textured_emitters_are_sampled_by_brightness(void **state)
{
    enum { SIDE = 16, SAMPLES = 4096 };
    fixture *f = *state;
    uint8_t codes[SIDE * SIDE] = { 0 };
    codes[5 * SIDE + 9] = 255;
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_material m = lambert(0);
    m.emission = rgb_gray(100);
    uint32_t texture = add_codes(scene, SIDE, SIDE, 1, codes, false, true);
    add_square(scene, add_textured(scene, m, RSV_TEXTURE_EMISSION, texture), 2, v3(0, 0, 0));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    // the texel's form factor times pi, place by place
    double expected = 0;
    for (int k = 0; k < 64 * 64; k++) {
        double x = 2 * (9 + (k % 64 + 0.5) / 64) / SIDE - 1,
               y = 2 * (5 + (k / 64 + 0.5) / 64) / SIDE - 1;
        double square = 1 + x * x + y * y;
        expected += 100 * (2.0 / SIDE) * (2.0 / SIDE) / (square * square) / (64 * 64);
    }
    double by_area = 16 / sqrt(SAMPLES) * expected;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    rsv_probe probe = { v3(0, 0, 1), v3(0, 0, -1) };
    rsv_probe_reading traced, solved;
    assert_int_equal(rsv_probe_reference(scene, &probe, 1, SAMPLES, 1, &traced), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &desc, &solution), RSV_OK);
    // one sample in four casts a shadow ray there
    assert_int_equal(
        rsv_probe_irradiance(solution,
            &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 8 * SAMPLES, 1 }, &probe,
            1, &solved),
        RSV_OK);
    assert_float_equal(
        traced.irradiance.g, expected, 4 * traced.standard_error.g + 1e-5 * expected);
    assert_float_equal(
        solved.irradiance.g, expected, 4 * solved.standard_error.g + 1e-5 * expected);
    assert_true(traced.standard_error.g < 0.25 * by_area);
    assert_true(solved.standard_error.g < 0.25 * by_area);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
}

/// Irradiance below the middle of a lamp of 2 x 2 m, from a solution at draft quality.
static double below_lamp(rsv_scene *scene, rsv_probe_reading *reading)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    rsv_probe probe = { v3(0.2f, 0.1f, 2), v3(0, 0, -1) };
    desc.element_target = 50;
    assert_int_equal(rsv_light_create(scene, &desc, &solution), RSV_OK);
    assert_int_equal(rsv_probe_irradiance(solution,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 4096, 1 },
                         &probe, 1, reading),
        RSV_OK);
    rsv_light_destroy(solution);
    return reading->irradiance.g;
}

/// A lamp of which only a few texels shine. @return its irradiance, divided by the exact value
static double lamp_of_texels(fixture *f, uint32_t side, uint32_t stars, rsv_probe_reading *reading)
{
    rsv_scene *scene;
    uint8_t *codes = calloc((size_t)side * side, 1);
    assert_non_null(codes);
    for (uint32_t k = 0; k < stars; k++)
        codes[rsv_hash2(k, 17) % (side * side)] = 255;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_material m = lambert(0);
    m.emission = rgb_gray(1000);
    uint32_t texture = add_codes(scene, side, side, 1, codes, false, true);
    add_square(scene, add_textured(scene, m, RSV_TEXTURE_EMISSION, texture), 2, v3(0, 0, 0));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    double value = below_lamp(scene, reading), expected = 0;
    for (uint32_t k = 0; k < side * side; k++) {
        double x = 2 * (k % side + 0.5) / side - 1 - 0.2, y = 1 - 2 * (k / side + 0.5) / side - 0.1;
        double square = 4 + x * x + y * y;
        if (codes[k]) expected += 1000 * (2.0 / side) * (2.0 / side) * 4 / (square * square);
    }
    free(codes);
    rsv_scene_destroy(scene);
    return value / expected;
}

/// One texel of 65,536 used to be missed, or found twice as bright; so were many.
static void few_bright_texels_are_found(void **state)
{
    fixture *f = *state;
    rsv_probe_reading reading;
    assert_float_equal(lamp_of_texels(f, 256, 1, &reading), 1, 0.001);
    assert_float_equal(lamp_of_texels(f, 512, 3, &reading), 1, 0.005);
    assert_float_equal(lamp_of_texels(f, 2048, 1, &reading), 1, 0.002);
    assert_float_equal(lamp_of_texels(f, 256, 100, &reading), 1, 0.05);
    assert_true(reading.standard_error.g < 0.05 * reading.irradiance.g);
}

/// Patches beside a bright texel must not be taken for bright: the texel would count for more than it gives. Dark cells
/// around it are not weighed, which took four times as long as a lamp of the texel's size.
static void a_bright_texel_is_a_lamp_of_its_size(void **state)
{
    enum { SIDE = 256 };
    fixture *f = *state;
    for (uint32_t k = 0; k < 24; k++) {
        uint8_t *codes = calloc(SIDE * SIDE, 1);
        assert_non_null(codes);
        codes[rsv_hash2(k, 5) % (SIDE * SIDE)] = 255;
        rsv_scene *scene;
        assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
        rsv_material m = lambert(0);
        m.emission = rgb_gray(1000);
        uint32_t texture = add_codes(scene, SIDE, SIDE, 1, codes, false, true);
        add_square(scene, add_textured(scene, m, RSV_TEXTURE_EMISSION, texture), 2, v3(0, 0, 0));
        assert_int_equal(rsv_scene_commit(scene), RSV_OK);
        rsv_bsdf bsdf = rsv_bsdf_from_material(&rsv_scene_get_view(scene)->material[0]);
        rsv_lights *lights;
        assert_int_equal(rsv_lights_create(scene, &bsdf, &lights), RSV_OK);
        const double right = M_PI * 1000 * 2.0 / SIDE * 2.0 / SIDE;
        assert_float_equal(lights->group[0].power, right, 2e-3 * right);
        assert_in_range(lights->weighed_count, 2, 4);
        rsv_lights_destroy(lights);
        rsv_scene_destroy(scene);
        free(codes);
    }
}

static void blended_surfaces_let_their_share_pass(void **state)
{
    fixture *f = *state;
    static const uint8_t codes[] = { 0, 51 }; // opacity 0.2
    rsv_scene *scene;
    uint32_t lamp_id;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_material lamp = lambert(0), veil = lambert(0);
    lamp.emission = rgb_gray(3);
    veil.double_sided = true;
    assert_int_equal(rsv_scene_add_material(scene, &lamp, &lamp_id), RSV_OK);
    add_square(scene, lamp_id, 2, v3(0, 0, 0));
    uint32_t texture = add_codes(scene, 1, 1, 2, codes, true, false);
    add_square(scene, add_textured(scene, veil, RSV_TEXTURE_OPACITY, texture), 8, v3(0, 0, 0.5f));
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    double expected = 0.8 * 3 * M_PI * square_form_factor();
    check_both_modes(scene, v3(0, 0, 1), v3(0, 0, -1), expected, 0.01);
    rsv_scene_destroy(scene);
}

/// A cube of side 2 that faces inwards, each wall with the whole texture.
static void add_cube(rsv_scene *scene, uint32_t material)
{
    static const float uv[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    static const uint32_t index[6] = { 0, 2, 1, 0, 3, 2 };
    for (int wall = 0; wall < 6; wall++) {
        rsv_vec3 position[4];
        for (int k = 0; k < 4; k++) {
            float side = wall % 2 ? 1.0f : -1.0f;
            float c[3] = { side, 2 * uv[k][0] - 1, side * (2 * uv[k][1] - 1) };
            position[k] = v3(c[(3 - wall / 2) % 3], c[(4 - wall / 2) % 3], c[(5 - wall / 2) % 3]);
        }
        rsv_mesh_desc mesh = { .size = sizeof mesh,
            .name = "wall",
            .positions = position,
            .vertex_count = 4,
            .indices = index,
            .triangle_count = 2,
            .material = material,
            .uvs = { uv, NULL } };
        uint32_t id;
        assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, id, NULL, NULL), RSV_OK);
    }
}

/// Walls that emit as much as they absorb: radiance is 1 everywhere, for any texture.
static void textured_furnace_is_uniform(void **state)
{
    fixture *f = *state;
    enum { SIDE = 8 };
    uint8_t albedo[SIDE * SIDE][3], emission[SIDE * SIDE][3];
    for (uint32_t k = 0; k < SIDE * SIDE * 3; k++) {
        albedo[k / 3][k % 3] = (uint8_t)(20 + rsv_hash(k) % 200);
        emission[k / 3][k % 3] = (uint8_t)(255 - albedo[k / 3][k % 3]);
    }
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_texture_ref refs[2] = {
        rsv_default_texture_ref(
            RSV_TEXTURE_BASE_COLOR, add_codes(scene, SIDE, SIDE, 3, albedo[0], false, false)),
        rsv_default_texture_ref(
            RSV_TEXTURE_EMISSION, add_codes(scene, SIDE, SIDE, 3, emission[0], false, false)),
    };
    rsv_material m = lambert(1);
    m.emission = rgb_gray(1);
    m.textures = refs;
    m.texture_count = 2;
    uint32_t material;
    assert_int_equal(rsv_scene_add_material(scene, &m, &material), RSV_OK);
    add_cube(scene, material);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    check_both_modes(scene, v3(0.1f, 0.2f, 0.3f), v3(0, 1, 0), M_PI, 0.003);
    check_both_modes(scene, v3(0.1f, 0.99f, 0.3f), v3(0, 1, 0), M_PI, 0.003);
    rsv_scene_destroy(scene);
}

int main(int argc, char **argv)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)
    const struct CMUnitTest quick[] = {
        TEST(what_is_cut_away_lends_no_colour),
        TEST(pyramid_keeps_the_mean_of_odd_sizes),
        TEST(codes_are_averaged_in_linear_light),
        TEST(coordinates_repeat_mirror_or_stop),
        TEST(material_at_a_point_multiplies_its_texels),
        TEST(normal_map_leans_as_the_picture_shows),
        TEST(normal_map_is_continuous_across_smooth_edges),
        TEST(rays_pass_where_a_surface_is_cut_out),
        TEST(unusable_textures_are_refused),
        TEST(textured_emitters_are_sampled_by_brightness),
        TEST(few_bright_texels_are_found),
        TEST(a_bright_texel_is_a_lamp_of_its_size),
    };
    const struct CMUnitTest slow[] = {
        TEST(emitters_shine_as_bright_as_their_texels),
        TEST(blended_surfaces_let_their_share_pass),
        TEST(textured_furnace_is_uniform),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
