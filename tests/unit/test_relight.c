/// Relighting against fresh solutions of the changed scene.
#include "resolvent/relight.h"

#include "direct/preview_kernels.h"
#include "light_fixture.h"
#include "light_view.h"
#include "scene/scene.h"
#include "slow_tests.h"
#include "sources/lights_internal.h"

static rsv_scene *own_scene(world *w) { return w->scene; }

/// A box with a lamp and two punctual lights in it.
static world *lit_box(const float scale[3])
{
    world *w = world_builtin(2, "cornell-spheres");
    rsv_scene *scene = own_scene(w);
    for (size_t m = 0; m < scene->material_count; m++)
        scene->material[m].emission = rgb_scale(scene->material[m].emission, scale[0]);
    rsv_punctual_light light = { .name = "bulb",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.1f, 0.4f, 0.05f },
        .intensity = { 0.2f * scale[1], 0.1f * scale[1], 0.1f * scale[1] } };
    scene->committed = false; // for what is added to a built-in scene
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
    light.name = "torch";
    light.kind = RSV_PUNCTUAL_SPOT;
    light.direction = v3(0, -1, 0.1f);
    light.outer_cone_angle = 0.8f;
    light.intensity = rgb(0.1f * scale[2], 0.2f * scale[2], 0.3f * scale[2]);
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
    scene->committed = true;
    scene->view.light = scene->light;
    scene->view.light_count = scene->light_count;
    return w;
}

/// Without pilots, so that elements do not depend on the light, and without photons, because their directions do.
static rsv_light *solve(const world *w, bool direct_level)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 300;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.photon_count = 0;
    desc.direct_level = direct_level;
    desc.tolerance = 1e-6f;
    rsv_light *s;
    if (rsv_light_create(w->scene, &desc, &s) != RSV_OK) fail_msg("%s", rsv_last_error());
    return s;
}

static double largest_difference(const rsv_rgb *a, const rsv_rgb *b, size_t count)
{
    double difference = 0, size = 0;
    for (size_t n = 0; n < count; n++) {
        difference = fmax(difference, fabs((double)a[n].r - b[n].r));
        difference = fmax(difference, fabs((double)a[n].g - b[n].g));
        difference = fmax(difference, fabs((double)a[n].b - b[n].b));
        size = fmax(size, rgb_max(b[n]));
    }
    return difference / size;
}

static void relight(rsv_light *s, const rsv_relight_desc *desc)
{
    if (rsv_light_relight(s, desc) != RSV_OK) fail_msg("%s", rsv_last_error());
}

static void scaled_lights_are_those_of_a_fresh_solve(void **state)
{
    (void)state;
    const rsv_light_scale scales[] = { { "light", { 0.5f, 0.5f, 0.5f } }, { "bulb", { 3, 3, 3 } },
        { "torch", { 0, 0, 0 } } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = scales, .light_count = 3 };
    world *w = lit_box((float[]){ 1, 1, 1 }), *other = lit_box((float[]){ 0.5f, 3, 0 });
    rsv_light *relit = solve(w, false), *fresh = solve(other, false);
    relight(relit, &desc);
    size_t nodes = inside(fresh)->elements->node_count;
    assert_int_equal(inside(relit)->elements->node_count, nodes);
    assert_true(largest_difference(inside(relit)->source, inside(fresh)->source, nodes) < 1e-4);
    assert_true(
        largest_difference(inside(relit)->irradiance, inside(fresh)->irradiance, nodes) < 1e-4);
    rsv_light_destroy(relit);
    rsv_light_destroy(fresh);
    world_end(w);
    world_end(other);
}

static void scaling_nothing_changes_nothing(void **state)
{
    (void)state;
    const rsv_relight_desc desc = { .size = sizeof desc };
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *before = solve(w, true), *after = solve(w, true);
    relight(after, &desc);
    size_t nodes = inside(before)->elements->node_count,
           fine = inside(before)->fine.elements->node_count;
    assert_true(
        largest_difference(inside(after)->irradiance, inside(before)->irradiance, nodes) < 1e-6);
    assert_true(
        largest_difference(inside(after)->fine.direct, inside(before)->fine.direct, fine) < 1e-6);
    rsv_light_destroy(before);
    rsv_light_destroy(after);
    world_end(w);
}

static void changed_albedos_are_those_of_a_fresh_solve(void **state)
{
    (void)state;
    const rsv_albedo_change change = { "red", { 0.1f, 0.2f, 0.7f } };
    const rsv_relight_desc desc = { .size = sizeof desc, .albedo = &change, .albedo_count = 1 };
    world *w = lit_box((float[]){ 1, 1, 1 }), *other = lit_box((float[]){ 1, 1, 1 });
    for (size_t m = 0; m < own_scene(other)->material_count; m++)
        if (strcmp(own_scene(other)->material[m].name, "red") == 0)
            own_scene(other)->material[m].base_color = change.base_color;
    rsv_light *relit = solve(w, false), *fresh = solve(other, false);
    relight(relit, &desc);
    size_t nodes = inside(fresh)->elements->node_count;
    assert_true(
        largest_difference(inside(relit)->irradiance, inside(fresh)->irradiance, nodes) < 1e-4);
    rsv_light_destroy(relit);
    rsv_light_destroy(fresh);
    world_end(w);
    world_end(other);
}

/// A lamp above a plate with a texture, and a coat with another.
static world *room_with_pattern(rsv_rgb base_color)
{
    static const rsv_texture_role role[] = { RSV_TEXTURE_BASE_COLOR, RSV_TEXTURE_CLEARCOAT };
    const rsv_vec3 corner[4] = { v3(0.2f, 0.1f, 0.2f), v3(0.2f, 0.1f, 1.8f), v3(1.8f, 0.1f, 1.8f),
        v3(1.8f, 0.1f, 0.2f) };
    world *w = world_begin(2);
    rsv_material pattern = lambert_material(0, 0);
    pattern.name = "pattern";
    pattern.base_color = base_color;
    pattern.clearcoat = 1;
    pattern.clearcoat_roughness = 1;
    world_pattern(w, pattern, corner, role, 2);
    world_room(w, world_lambert(w, 0.7f, 0), v3(0, 0, 0), v3(2, 2, 2));
    world_box(w, world_lambert(w, 0, 1), v3(0.8f, 1.9f, 0.8f), v3(1.2f, 1.95f, 1.2f));
    world_commit(w);
    return w;
}

/// The texture stays, and so does what of it each element has. @param before of the texture; may be 0
static void check_textured_color(rsv_rgb before)
{
    const rsv_albedo_change change = { "pattern", { 0.9f, 0.2f, 0.5f } };
    const rsv_relight_desc desc = { .size = sizeof desc, .albedo = &change, .albedo_count = 1 };
    world *w = room_with_pattern(before), *other = room_with_pattern(change.base_color);
    rsv_light *relit = solve(w, false), *fresh = solve(other, false);
    relight(relit, &desc);
    size_t nodes = inside(fresh)->elements->node_count;
    assert_int_equal(inside(relit)->elements->node_count, nodes);
    assert_memory_equal(inside(relit)->exitance_albedo, inside(fresh)->exitance_albedo,
        nodes * sizeof *inside(fresh)->exitance_albedo);
    assert_true(
        largest_difference(inside(relit)->irradiance, inside(fresh)->irradiance, nodes) < 1e-4);
    rsv_light_destroy(relit);
    rsv_light_destroy(fresh);
    world_end(w);
    world_end(other);
}

static void textures_stay_under_changed_colors(void **state)
{
    (void)state;
    check_textured_color(rgb(0.5f, 0.8f, 0.5f));
    check_textured_color(rgb(0.5f, 0, 0.1f));
}

static void check_refused(
    rsv_light *s, const rsv_relight_desc *desc, const char *what, const char *listed)
{
    assert_int_not_equal(rsv_light_relight(s, desc), RSV_OK);
    assert_non_null(strstr(rsv_last_error(), what));
    assert_non_null(strstr(rsv_last_error(), listed));
}

static void unknown_names_are_answered_by_the_known_ones(void **state)
{
    (void)state;
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, false);
    const rsv_light_scale moon = { "moon", { 1, 1, 1 } }, dark = { "bulb", { -1, 1, 1 } };
    const rsv_albedo_change gold = { "gold", { 1, 1, 1 } }, glass = { "glass", { 1, 1, 1 } },
                            bright = { "red", { 2, 1, 1 } };
    check_refused(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .light = &moon, .light_count = 1 },
        "'moon'", "'bulb', 'torch'");
    check_refused(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .light = &dark, .light_count = 1 },
        "'bulb'", "from 0");
    check_refused(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .albedo = &gold, .albedo_count = 1 },
        "'gold'", "'red'");
    check_refused(s,
        &(rsv_relight_desc){
            .size = sizeof(rsv_relight_desc), .albedo = &glass, .albedo_count = 1 },
        "'glass'", "again");
    check_refused(s,
        &(rsv_relight_desc){
            .size = sizeof(rsv_relight_desc), .albedo = &bright, .albedo_count = 1 },
        "'red'", "0 .. 1");
    rsv_light_destroy(s);
    world_end(w);
}

// ---- lights that move ------------------------------------------------------------------------------

/// A yard with low walls under a black-bodied lamp. All surfaces lie below the lamp, so that no light goes from one
/// to another through the places where it may hang: G does not depend on those.
static world *yard_on(int threads, bool globe, rsv_vec3 offset)
{
    world *w = world_begin(threads);
    uint32_t gray = world_lambert(w, 0.6f, 0), red = world_lambert(w, 0.5f, 0);
    rsv_material lamp = lambert_material(0, 9);
    lamp.name = "lamp";
    uint32_t light = world_material(w, lamp);
    world_quad(w, gray, v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2), v3(-2, 0, -2));
    world_quad(w, red, v3(-2, 0, -2), v3(2, 0, -2), v3(2, 1, -2), v3(-2, 1, -2));
    world_box(w, gray, v3(0.2f, 0, -1), v3(1, 0.8f, -0.2f));
    float x = offset.x, y = 2 + offset.y, z = offset.z;
    if (globe)
        world_sphere(w, light, v3(x, y, z), 0.3f, 2);
    else
        world_quad(w, light, v3(x - 0.3f, y, z - 0.3f), v3(x + 0.3f, y, z - 0.3f),
            v3(x + 0.3f, y, z + 0.3f), v3(x - 0.3f, y, z + 0.3f));
    rsv_punctual_light bulb = { .name = "bulb",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3_add(v3(-1, 1.5f, 1), offset),
        .intensity = { 1, 2, 3 } };
    assert_int_equal(rsv_scene_add_light(w->scene, &bulb), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static world *yard(rsv_vec3 offset) { return yard_on(2, false, offset); }

/// B = K E, the visible part of a solution. The black body of the lamp has rows of its own, from where it began.
static rsv_rgb *exitance(const rsv_light *s)
{
    rsv_rgb *b = malloc(inside(s)->elements->node_count * sizeof *b);
    for (size_t n = 0; n < inside(s)->elements->node_count; n++)
        b[n] = rgb_mul(inside(s)->exitance_albedo[n], inside(s)->irradiance[n]);
    return b;
}

static void check_moved(bool direct_level)
{
    const rsv_vec3 offset = { -0.7f, 0.4f, 0.5f };
    const rsv_light_move moves[] = { { "lamp", offset }, { "bulb", offset } };
    const rsv_relight_desc desc = { .size = sizeof desc, .move = moves, .move_count = 2 };
    world *w = yard(v3(0, 0, 0)), *other = yard(offset);
    rsv_light *relit = solve(w, direct_level), *fresh = solve(other, direct_level);
    relight(relit, &desc);
    size_t nodes = inside(fresh)->elements->node_count;
    assert_int_equal(inside(relit)->elements->node_count, nodes);
    assert_true(largest_difference(inside(relit)->source, inside(fresh)->source, nodes) < 1e-4);
    rsv_rgb *seen = exitance(relit), *wanted = exitance(fresh);
    assert_true(largest_difference(seen, wanted, nodes) < 1e-4);
    free(seen);
    free(wanted);
    rsv_light_destroy(relit);
    rsv_light_destroy(fresh);
    world_end(w);
    world_end(other);
}

static void moved_lights_are_those_of_a_fresh_solve(void **state)
{
    (void)state;
    check_moved(false);
    check_moved(true);
}

static const rsv_light_part *part_named(const rsv_light *s, const char *name)
{
    const rsv_light_basis *b = inside(s)->basis;
    for (size_t k = 0; b && k < b->source_count; k++)
        if (strcmp(b->source[k].name, name) == 0) return &b->part[k];
    return NULL;
}

#define PLACES 100 ///< along each edge of a square of the floor

/// A glass ball above a floor, under a spot that stands at `x`, and a bulb that stays.
static rsv_light *ball_below_spot(float x, world **w)
{
    rsv_material glass = rsv_default_material();
    glass.roughness = 0;
    glass.transmission = glass.thickness = 1;
    *w = world_begin(2);
    uint32_t grey = world_lambert(*w, 0.5f, 0), ball = world_material(*w, glass);
    world_quad(*w, grey, v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2), v3(-2, 0, -2));
    world_sphere(*w, ball, v3(0, 0.6f, 0), 0.3f, 3);
    const rsv_punctual_light light[] = { { .name = "spot",
                                             .kind = RSV_PUNCTUAL_SPOT,
                                             .position = { x, 2.4f, 0 },
                                             .direction = { 0, -1, 0 },
                                             .outer_cone_angle = 1,
                                             .intensity = { 20, 20, 20 } },
        { .name = "bulb",
            .kind = RSV_PUNCTUAL_POINT,
            .position = { -1.5f, 2, 1.5f },
            .intensity = { 2, 2, 2 } } };
    for (int k = 0; k < 2; k++)
        assert_int_equal(rsv_scene_add_light((*w)->scene, &light[k]), RSV_OK);
    world_commit(*w);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 300;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.photon_count = 400000;
    rsv_light *s;
    assert_int_equal(rsv_light_create((*w)->scene, &desc, &s), RSV_OK);
    return s;
}

/// What a field of a level has at places of the floor, which is the first quad. @param value [PLACES * PLACES] out
static void look_at_floor(const rsv_elements *e, const rsv_rgb *field, double *value)
{
    for (int k = 0; k < PLACES * PLACES; k++) {
        float x = 0.35f + 0.3f * ((float)(k % PLACES) + 0.5f) / PLACES; // share of the way along x
        float z = 0.35f + 0.3f * ((float)(k / PLACES) + 0.5f) / PLACES; // and against z
        uint32_t face = 0;
        while (e->face_triangle[face] != (z > x))
            face++;
        float u = z > x ? x : x - z, v = z > x ? z - x : z;
        value[k] = (double)rsv_elements_interpolate(e, field, face, u, v).g;
    }
}

/// What the photons of a spot find on the floor after it was moved has the detail of a fresh solve, and the light that
/// stays is no other.
static void moved_caustics_are_as_sharp_as_fresh_ones(void **state)
{
    (void)state;
    enum { COUNT = PLACES * PLACES };
    static double relit[COUNT], fresh[COUNT], before[COUNT], after[COUNT];
    const rsv_light_move move = { "spot", { -0.9f, 0, 0 } }, none = { "spot", { 0, 0, 0 } };
    world *w, *other;
    rsv_light *s = ball_below_spot(0.6f, &w), *wanted = ball_below_spot(-0.3f, &other);
    relight(
        s, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &none, .move_count = 1 });
    look_at_floor(inside(s)->fine.elements, part_named(s, "bulb")->fine, before);
    relight(
        s, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &move, .move_count = 1 });
    look_at_floor(inside(s)->fine.elements, part_named(s, "bulb")->fine, after);
    look_at_floor(inside(s)->caustics.elements, inside(s)->caustics.caustic, relit);
    look_at_floor(inside(wanted)->caustics.elements, inside(wanted)->caustics.caustic, fresh);
    double square = 0, size = 0, peak[2] = { 0 };
    for (int k = 0; k < COUNT; k++) {
        assert_float_equal(after[k], before[k], 1e-5 * before[k]);
        square += pow(relit[k] - fresh[k], 2);
        size += pow(fresh[k], 2);
        peak[0] = fmax(peak[0], relit[k]);
        peak[1] = fmax(peak[1], fresh[k]);
    }
    assert_true(sqrt(square / size) < 0.05);
    assert_float_equal(peak[0], peak[1], 0.05 * peak[1]);
    rsv_light_destroy(s);
    rsv_light_destroy(wanted);
    world_end(w);
    world_end(other);
}

static rsv_punctual_light spark(void)
{
    return (rsv_punctual_light){ .name = "spark",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.5f, 1.2f, 1.1f },
        .intensity = { 3, 1, 1 } };
}

static void begin_relighting(rsv_light *s, rsv_relighter **r)
{
    if (rsv_relighter_create(s, r) != RSV_OK) fail_msg("%s", rsv_last_error());
}

static void change(rsv_relighter *r, const rsv_relight_desc *desc)
{
    if (rsv_relighter_change(r, desc) != RSV_OK) fail_msg("%s", rsv_last_error());
}

/// Changes of every kind, and back again: the remaining difference is that of the last change alone, and in the end
/// there is none.
static void only_the_last_change_counts(void **state)
{
    (void)state;
    const rsv_light_move move = { "lamp", { 0.5f, 0.1f, 0 } };
    const rsv_light_scale off = { "lamp", { 0, 0, 0 } }, blue = { "bulb", { 0, 1, 3 } };
    const rsv_albedo_change dark = { "lambert", { 0.1f, 0.1f, 0.1f } };
    const rsv_relight_desc first = { .size = sizeof first,
        .light = &off,
        .light_count = 1,
        .move = &move,
        .move_count = 1,
        .albedo = &dark,
        .albedo_count = 1 };
    const rsv_relight_desc second = {
        .size = sizeof second, .light = &blue, .light_count = 1, .move = &move, .move_count = 1
    };
    const rsv_relight_desc third = { .size = sizeof third };
    world *w = yard(v3(0, 0, 0)), *other = yard(v3(0, 0, 0));
    rsv_light *s = solve(w, true), *once = solve(other, true);
    size_t nodes = inside(s)->elements->node_count;
    rsv_rgb *began = malloc(nodes * sizeof *began);
    memcpy(began, inside(s)->irradiance, nodes * sizeof *began);
    rsv_relighter *r;
    begin_relighting(s, &r);
    assert_true(rsv_relighter_is_settled(r));
    change(r, &first);
    assert_int_equal(rsv_relighter_step(r, 0, NULL), RSV_OK);
    change(r, &second);
    assert_false(rsv_relighter_is_settled(r));
    assert_int_equal(rsv_relighter_refine(r), RSV_OK);
    relight(once, &second);
    size_t fine = inside(s)->fine.elements->node_count;
    assert_int_equal(inside(once)->fine.elements->node_count, fine);
    assert_memory_equal(inside(s)->irradiance, inside(once)->irradiance, nodes * sizeof *began);
    assert_memory_equal(inside(s)->fine.direct, inside(once)->fine.direct, fine * sizeof *began);
    change(r, &third);
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    assert_memory_equal(inside(s)->irradiance, began, nodes * sizeof *began);
    rsv_relighter_destroy(r);
    free(began);
    rsv_light_destroy(s);
    rsv_light_destroy(once);
    world_end(w);
    world_end(other);
}

// ---- lights on the move ----------------------------------------------------------------------------

/// Direct light of the yard with lamp and bulb elsewhere, as long as they move. @param rest out: once they rest
static rsv_rgb *preview_at_yard(int threads, bool globe, size_t *count, rsv_rgb **rest)
{
    const rsv_vec3 offset = { -0.7f, 0.4f, 0.5f };
    const rsv_light_move moves[] = { { "lamp", offset }, { "bulb", offset } };
    world *w = yard_on(threads, globe, v3(0, 0, 0));
    rsv_light *s = solve(w, true);
    rsv_relighter *r;
    begin_relighting(s, &r);
    change(
        r, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = moves, .move_count = 2 });
    size_t bytes = (*count = inside(s)->fine.elements->node_count) * sizeof **rest;
    rsv_rgb *preview = memcpy(malloc(bytes), inside(s)->fine.direct, bytes);
    assert_true(rsv_relighter_rays(r) > 0);
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    *rest = memcpy(malloc(bytes), inside(s)->fine.direct, bytes);
    rsv_relighter_destroy(r);
    rsv_light_destroy(s);
    world_end(w);
    return preview;
}

/// @param rms, bias of what is seen on the move, relative @return share of nodes where nothing is off
static double compare_at_yard(bool globe, double *rms, double *bias)
{
    size_t count, same = 0;
    rsv_rgb *rest, *preview = preview_at_yard(2, globe, &count, &rest);
    double square = 0, size = 0, sum = 0;
    for (size_t n = 0; n < count; n++) {
        double seen = rgb_luminance(preview[n]), wanted = rgb_luminance(rest[n]);
        square += (seen - wanted) * (seen - wanted);
        size += wanted * wanted;
        sum += seen - wanted;
        same += fabs(seen - wanted) <= 1e-4 * wanted;
    }
    *rms = sqrt(square / size);
    *bias = sum / sqrt(size * (double)count);
    free(preview), free(rest);
    return (double)same / (double)count;
}

/// Sixteen places stand for the lamp: a penumbra is off by a few hundredths, most of the yard by nothing. A globe of
/// many triangles is known by these places alone.
static void lights_on_the_move_are_near_those_at_rest(void **state)
{
    (void)state;
    double rms, bias;
    double same = compare_at_yard(false, &rms, &bias);
    assert_true(same > 0.5 && rms < 0.05 && fabs(bias) < 0.01);
    same = compare_at_yard(true, &rms, &bias);
    assert_true(rms < 0.1 && fabs(bias) < 0.03);
}

static void lights_on_the_move_are_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    size_t count;
    rsv_rgb *rest, *one = preview_at_yard(1, false, &count, &rest);
    free(rest);
    for (int threads = 2; threads <= 3; threads++) {
        rsv_rgb *more = preview_at_yard(threads, false, &count, &rest);
        assert_memory_equal(one, more, count * sizeof *one);
        free(more), free(rest);
    }
    free(one);
}

static rsv_vec3 random_place(rsv_random *random, float size)
{
    float x = rsv_random_float(random), y = rsv_random_float(random);
    return v3(size * (x - 0.5f), size * (y - 0.5f), size * (rsv_random_float(random) - 0.5f));
}

static rsv_preview_polygon random_polygon(rsv_random *random, rsv_vec3 corner[3])
{
    rsv_preview_polygon p = { .double_sided = rsv_random_float(random) < 0.5f };
    for (int i = 0; i < 3; i++) {
        corner[i] = random_place(random, 2);
        p.x[i] = corner[i].x, p.y[i] = corner[i].y, p.z[i] = corner[i].z;
    }
    rsv_vec3 n = v3_normalize(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])));
    p.normal_x = n.x, p.normal_y = n.y, p.normal_z = n.z;
    return p;
}

static rsv_receiver_block random_block(rsv_random *random)
{
    rsv_receiver_block b = { .valid = 0xffff };
    for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_vec3 at = random_place(random, 4), n = v3_normalize(random_place(random, 1));
        b.x[k] = at.x, b.y[k] = at.y, b.z[k] = at.z;
        b.normal_x[k] = n.x, b.normal_y[k] = n.y, b.normal_z[k] = n.z;
    }
    return b;
}

/// Right beside an edge, which spans half a turn but for rounding, no receiver gets more than from a sky of such lamps.
static void receivers_at_an_edge_get_no_more_than_there_is(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(11, 0, 0);
    const rsv_preview_polygon p = { .x = { 0, 1, 0 }, .y = { 0, 0, 1 }, .normal_z = 1 };
    for (int round = 0; round < 2000; round++) {
        rsv_receiver_block b = random_block(&random);
        for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
            rsv_vec3 aside = v3_scale(random_place(&random, 2), exp2f(-(float)(round % 20)));
            b.x[k] = 0.1f + 0.8f * rsv_random_float(&random);
            b.y[k] = aside.y, b.z[k] = fabsf(aside.z);
        }
        _Alignas(64) float value[RSV_PACKET_WIDTH];
        rsv_preview_kernels_best()->irradiance(&b, &p, value);
        for (int k = 0; k < RSV_PACKET_WIDTH; k++)
            assert_true(value[k] >= 0 && value[k] <= 1.01f * RSV_PI);
    }
}

/// Lambert's formula in single precision, polygons that cross the horizon included.
static void sixteen_receivers_see_what_one_does(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(7, 0, 0);
    for (int round = 0; round < 500; round++) {
        rsv_vec3 corner[3];
        rsv_preview_polygon p = random_polygon(&random, corner);
        rsv_receiver_block b = random_block(&random);
        _Alignas(64) float value[RSV_PACKET_WIDTH], narrow[RSV_PACKET_WIDTH];
        rsv_preview_kernels_best()->irradiance(&b, &p, value);
        rsv_preview_kernels_portable.irradiance(&b, &p, narrow);
        assert_memory_equal(value, narrow, sizeof value);
        for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
            rsv_vec3 at = v3(b.x[k], b.y[k], b.z[k]);
            rsv_vec3 n = v3(b.normal_x[k], b.normal_y[k], b.normal_z[k]);
            float height = v3_dot(v3(p.normal_x, p.normal_y, p.normal_z), v3_sub(at, corner[0]));
            bool faces = height > 0 || p.double_sided;
            double exact = faces ? rsv_polygon_irradiance(corner, 3, at, n) : 0;
            // close to the plane edges span nearly half a turn, where 1 / height times the rounding is left
            if (fabsf(height) > 1e-3f)
                assert_true(fabs(value[k] - exact) < 2e-6 * (1 + 1 / fabs((double)height)));
        }
    }
}

/// A light that is added later, then moved and scaled, equals one that was there from the start.
static void added_lights_are_those_of_a_fresh_solve(void **state)
{
    (void)state;
    const rsv_light_scale twice = { "spark", { 2, 2, 2 } };
    const rsv_light_move lift = { "spark", { 0, 0.3f, 0 } };
    const rsv_relight_desc desc = {
        .size = sizeof desc, .light = &twice, .light_count = 1, .move = &lift, .move_count = 1
    };
    rsv_punctual_light light = spark(), there = spark();
    there.intensity = rgb_scale(light.intensity, 2);
    there.position.y += 0.3f;
    world *w = yard(v3(0, 0, 0)), *other = yard(v3(0, 0, 0));
    assert_int_equal(rsv_scene_append_light(own_scene(other), &there), RSV_OK);
    rsv_light *s = solve(w, true), *fresh = solve(other, true);
    rsv_relighter *r;
    begin_relighting(s, &r);
    size_t sources = rsv_relighter_source_count(r);
    assert_int_equal(rsv_relighter_add_light(r, &light), RSV_OK);
    assert_int_equal(rsv_relighter_source_count(r), sources + 1);
    assert_string_equal(rsv_relighter_source(r, sources).name, "spark");
    assert_int_equal(rsv_relighter_add_light(r, &light), RSV_ERROR_ARGUMENT);
    change(r, &desc);
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    size_t nodes = inside(fresh)->elements->node_count;
    rsv_rgb *seen = exitance(s), *wanted = exitance(fresh);
    assert_true(largest_difference(inside(s)->source, inside(fresh)->source, nodes) < 1e-4);
    assert_true(largest_difference(seen, wanted, nodes) < 1e-4);
    free(seen);
    free(wanted);
    rsv_relighter_destroy(r);
    rsv_light_destroy(s);
    rsv_light_destroy(fresh);
    world_end(w);
    world_end(other);
}

/// Steps converge to the solution, except for orders of light too faint to be seen. No step allocates memory.
static void steps_lead_to_the_solution(void **state)
{
    (void)state;
    const rsv_light_scale scales[] = { { "light", { 0.1f, 2, 2 } }, { "bulb", { 9, 9, 9 } } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = scales, .light_count = 2 };
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, true);
    size_t nodes = inside(s)->elements->node_count;
    rsv_rgb *stepped = malloc(nodes * sizeof *stepped);
    rsv_relighter *r;
    rsv_relight_progress progress;
    begin_relighting(s, &r);
    change(r, &desc);
    long alive = w->alive;
    w->until_failure = 0;
    for (int k = 0; k < 100; k++) {
        assert_int_equal(rsv_relighter_step(r, 0, &progress), RSV_OK);
        if (progress.converged) break;
        assert_int_equal(progress.orders, 1);
    }
    w->until_failure = -1;
    assert_int_equal(w->alive, alive);
    assert_true(progress.converged);
    memcpy(stepped, inside(s)->irradiance, nodes * sizeof *stepped);
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    // the last change was 1e-3 at most; those that follow fall by the norm of G K, here 0.73
    assert_true(largest_difference(stepped, inside(s)->irradiance, nodes) < 1e-3 / (1 - 0.73));
    rsv_relighter_destroy(r);
    free(stepped);
    rsv_light_destroy(s);
    world_end(w);
}

/// Changes strengths of a prepared relighter and compares the immediate result with the result at rest.
static void check_at_once(rsv_relighter *r, rsv_light *s, const rsv_relight_desc *desc)
{
    size_t nodes = inside(s)->elements->node_count;
    rsv_rgb *once = malloc(nodes * sizeof *once), *shown = malloc(nodes * sizeof *shown);
    rsv_relight_progress progress;
    change(r, desc);
    assert_int_equal(rsv_relighter_step(r, 0, &progress), RSV_OK);
    assert_true(progress.converged && progress.orders == 0);
    memcpy(once, inside(s)->irradiance, nodes * sizeof *once);
    memcpy(shown, inside(s)->indirect, nodes * sizeof *shown);
    assert_false(rsv_relighter_is_settled(r));
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    assert_true(largest_difference(once, inside(s)->irradiance, nodes) < 1e-4);
    // each source is sharpened separately, which differs from sharpening their sum at discontinuities
    double rms = 0, size = 0;
    for (size_t n = 0; n < nodes; n++) {
        rms += pow((double)shown[n].g - inside(s)->indirect[n].g, 2);
        size += pow((double)inside(s)->indirect[n].g, 2);
    }
    assert_true(sqrt(rms / size) < 2e-2);
    free(once);
    free(shown);
}

/// Lamps off and on again, and all that after lights have moved and walls changed colour.
static void prepared_strengths_are_right_at_once(void **state)
{
    (void)state;
    const rsv_light_scale dim[] = { { "lamp", { 0, 0, 0 } }, { "bulb", { 9, 9, 1 } } };
    const rsv_light_scale lit[] = { { "lamp", { 2, 1, 3 } }, { "bulb", { 0, 0, 0 } } };
    const rsv_light_move move = { "lamp", { 0.5f, 0.1f, 0 } };
    const rsv_albedo_change dark = { "lambert", { 0.1f, 0.5f, 0.1f } };
    rsv_relight_desc later = {
        .size = sizeof later, .move = &move, .move_count = 1, .albedo = &dark, .albedo_count = 1
    };
    world *w = yard(v3(0, 0, 0));
    rsv_light *s = solve(w, true);
    size_t nodes = inside(s)->elements->node_count;
    rsv_rgb *began = malloc(nodes * sizeof *began);
    memcpy(began, inside(s)->irradiance, nodes * sizeof *began);
    rsv_relighter *r;
    begin_relighting(s, &r);
    assert_int_equal(rsv_relighter_prepare(r), RSV_OK);
    assert_memory_equal(inside(s)->irradiance, began, nodes * sizeof *began);
    assert_true(rsv_relighter_is_settled(r));
    check_at_once(r, s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .light = dim, .light_count = 2 });
    check_at_once(r, s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .light = lit, .light_count = 2 });
    change(r, &later);
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    later.light = dim;
    later.light_count = 2;
    check_at_once(r, s, &later);
    rsv_relighter_destroy(r);
    free(began);
    rsv_light_destroy(s);
    world_end(w);
}

static void what_cannot_move_is_refused(void **state)
{
    (void)state;
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, false);
    const rsv_light_move moon = { "moon", { 0, 1, 0 } }, far = { "bulb", { NAN, 0, 0 } };
    check_refused(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &moon, .move_count = 1 },
        "'moon'", "'bulb', 'torch'");
    check_refused(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &far, .move_count = 1 },
        "'bulb'", "moved by");
    rsv_light_destroy(s);
    world_end(w);
}

// ---- lights side by side --------------------------------------------------------------------------

/// Largest difference of two lights, E and what lookups read, of one operator.
static double difference_of(const rsv_light *a, const rsv_light *b)
{
    size_t nodes = inside(a)->elements->node_count;
    return fmax(largest_difference(inside(a)->irradiance, inside(b)->irradiance, nodes),
        largest_difference(inside(a)->source, inside(b)->source, nodes));
}

static void lights_of_one_operator_leave_each_other_alone(void **state)
{
    (void)state;
    const rsv_light_scale dim = { "light", { 0.25f, 0.25f, 0.25f } },
                          off = { "light", { 0, 0, 0 } };
    const rsv_albedo_change paint = { "red", { 0.1f, 0.2f, 0.7f } };
    const rsv_light_move move = { "bulb", { 0.1f, 0, 0 } };
    const rsv_relight_desc first = { .size = sizeof first,
        .light = &dim,
        .light_count = 1,
        .albedo = &paint,
        .albedo_count = 1 },
                           second = { .size = sizeof second,
                               .light = &off,
                               .light_count = 1,
                               .move = &move,
                               .move_count = 1 };
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *home = solve(w, true), *a, *b, *alone = solve(w, true);
    assert_int_equal(rsv_light_copy(home, &a), RSV_OK);
    assert_int_equal(rsv_light_copy(home, &b), RSV_OK);
    assert_ptr_equal(inside(a)->transport, inside(b)->transport);
    relight(a, &first);
    relight(b, &second);
    relight(alone, &first);
    assert_true(difference_of(a, alone) == 0);
    assert_true(difference_of(home, a) > 0.1 && difference_of(a, b) > 0.1);
    relight(b,
        &(rsv_relight_desc){
            .size = sizeof(rsv_relight_desc) }); // as it was when this began: still off and moved
    rsv_light_destroy(home);
    assert_true(difference_of(a, alone) == 0);
    rsv_light_destroy(alone);
    rsv_light_destroy(a);
    assert_true(inside(b)->irradiance[0].r >= 0);
    rsv_light_destroy(b);
    world_end(w);
}

/// Copies of a light whose lamp stands elsewhere have that place, and change it for themselves.
static void copies_of_a_moved_light_move_on_alone(void **state)
{
    (void)state;
    const rsv_light_move there = { "light", { 0.05f, -0.1f, 0 } },
                         on = { "light", { 0, -0.1f, 0.05f } };
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, true), *copy;
    relight(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &there, .move_count = 1 });
    assert_int_equal(rsv_light_copy(s, &copy), RSV_OK);
    assert_true(difference_of(s, copy) == 0);
    rsv_vec3 *before = malloc(inside(s)->scene.view->vertex_count * sizeof *before);
    memcpy(before, inside(s)->scene.view->position,
        inside(s)->scene.view->vertex_count * sizeof *before);
    relight(copy,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &on, .move_count = 1 });
    assert_memory_equal(before, inside(s)->scene.view->position,
        inside(s)->scene.view->vertex_count * sizeof *before);
    assert_true(difference_of(s, copy) > 0.001);
    free(before);
    rsv_light_destroy(s);
    assert_non_null(rsv_light_scene(copy));
    rsv_light_destroy(copy);
    world_end(w);
}

/// E = E0 + G K E by the operator's own functions; it outlives its lights as long as somebody holds it.
static void the_operator_solves_for_its_light(void **state)
{
    (void)state;
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, true);
    rsv_operator *op = rsv_operator_retain(rsv_light_operator(s));
    size_t count = rsv_operator_element_count(op);
    rsv_rgb *residual = calloc(count, sizeof *residual), *source = calloc(count, sizeof *source);
    rsv_rgb *field = calloc(count, sizeof *field), *image = calloc(count, sizeof *image);
    double norm;
    memcpy(source, rsv_light_source_field(s), count * sizeof *source);
    memcpy(field, rsv_light_irradiance_field(s), count * sizeof *field);
    double most = rsv_light_report(s)->residual_inf;
    rsv_light_destroy(s);
    assert_int_equal(rsv_operator_norm(op, &norm), RSV_OK);
    assert_true(norm > 0.3 && norm < 1);
    assert_int_equal(rsv_operator_apply(op, field, image), RSV_OK);
    assert_int_equal(rsv_operator_residual(op, source, field, residual), RSV_OK);
    const rsv_operator_view *view = rsv_operator_get_view(op);
    for (size_t n = 0; n < count; n++) {
        if (view->elements->node_hanging[n] != RSV_NONE || view->transport->scale[n] == 0) continue;
        assert_true(fabs((double)residual[n].g) <= most * 1.01);
        assert_close(source[n].g + image[n].g, field[n].g, most + 1e-5 * field[n].g);
    }
    free(residual), free(source), free(field), free(image);
    rsv_operator_release(op);
    world_end(w);
}

/// <y, G K x> = <(G K)* y, x>
static void the_transposed_operator_is_the_adjoint(void **state)
{
    (void)state;
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, false);
    rsv_operator *op = rsv_light_operator(s);
    size_t count = rsv_operator_element_count(op);
    rsv_rgb *x = calloc(count, sizeof *x), *y = calloc(count, sizeof *y);
    rsv_rgb *ax = calloc(count, sizeof *ax), *ay = calloc(count, sizeof *ay);
    for (uint32_t n = 0; n < count; n++) {
        bool row = inside(s)->elements->node_hanging[n] == RSV_NONE;
        x[n] = row ? rgb_gray(rsv_unit_float(rsv_hash2(1, n))) : rgb_gray(0);
        y[n] = row ? rgb_gray(rsv_unit_float(rsv_hash2(2, n))) : rgb_gray(0);
    }
    assert_int_equal(rsv_operator_apply(op, x, ax), RSV_OK);
    assert_int_equal(rsv_operator_apply_transpose(op, y, ay), RSV_OK);
    double left = 0, right = 0;
    for (size_t n = 0; n < count; n++) {
        left += (double)y[n].r * (double)ax[n].r;
        right += (double)ay[n].r * (double)x[n].r;
    }
    assert_close(left, right, 1e-4 * right);
    free(x), free(y), free(ax), free(ay);
    rsv_light_destroy(s);
    world_end(w);
}

// ---- there and back -------------------------------------------------------------------------------

static rsv_rgb *copy_of(const rsv_rgb *field, size_t count)
{
    rsv_rgb *copy = malloc((count + 1) * sizeof *copy);
    memcpy(copy, field, count * sizeof *copy);
    return copy;
}

static void moving_one_light_leaves_the_parts_of_others_alone(void **state)
{
    (void)state;
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, true);
    size_t nodes = inside(s)->elements->node_count;
    const rsv_light_move nudge = { "bulb", { 1e-6f, 0, 0 } };
    relight(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &nudge, .move_count = 1 });
    assert_non_null(part_named(s, "light"));
    rsv_rgb *lamp = copy_of(part_named(s, "light")->direct, nodes);
    rsv_rgb *torch = copy_of(part_named(s, "torch")->direct, nodes);
    for (int k = 0; k < 4; k++) {
        relight(s, &(rsv_relight_desc){
                       .size = sizeof(rsv_relight_desc), .move = &nudge, .move_count = 1 });
        const rsv_light_part *light = part_named(s, "light"), *other = part_named(s, "torch");
        assert_true(light && other);
        if (!light || !other) return;
        assert_memory_equal(lamp, light->direct, nodes * sizeof *lamp);
        assert_memory_equal(torch, other->direct, nodes * sizeof *torch);
    }
    free(lamp), free(torch);
    rsv_light_destroy(s);
    world_end(w);
}

/// After any moves, scalings and colour changes, going back to the start restores the light byte for byte, and at once.
static void going_back_ends_where_it_began(void **state)
{
    (void)state;
    world *w = lit_box((float[]){ 1, 1, 1 });
    rsv_light *s = solve(w, true);
    size_t nodes = inside(s)->elements->node_count, fine = inside(s)->fine.elements->node_count;
    rsv_rgb *light = copy_of(inside(s)->irradiance, nodes);
    rsv_rgb *first = copy_of(inside(s)->source, nodes);
    rsv_rgb *direct = copy_of(inside(s)->fine.direct, fine);
    const rsv_light_move move = { "bulb", { 0.1f, -0.05f, 0 } };
    const rsv_light_scale dim = { "light", { 0, 0.5f, 1 } };
    const rsv_albedo_change paint = { "red", { 0.1f, 0.2f, 0.7f } };
    const rsv_relight_desc there = { .size = sizeof there,
        .move = &move,
        .move_count = 1,
        .light = &dim,
        .light_count = 1,
        .albedo = &paint,
        .albedo_count = 1 };
    rsv_relighter *r;
    begin_relighting(s, &r);
    for (int k = 0; k < 3; k++) {
        change(r, &there);
        if (k > 0) assert_int_equal(rsv_relighter_refine(r), RSV_OK);
        assert_int_equal(rsv_relighter_replacements(r), k == 0 ? 0 : 2 * k - 1);
        assert_true(largest_difference(first, inside(s)->source, nodes) > 0.01);
        change(r, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc) });
        assert_int_equal(rsv_relighter_settle(r), RSV_OK);
        assert_int_equal(inside(s)->fine.elements->node_count, fine);
        assert_memory_equal(light, inside(s)->irradiance, nodes * sizeof *light);
        assert_memory_equal(direct, inside(s)->fine.direct, fine * sizeof *direct);
    }
    free(light), free(direct), free(first);
    rsv_relighter_destroy(r);
    rsv_light_destroy(s);
    world_end(w);
}

/// A closed box of one diffuse material around a bulb.
static rsv_light *closed_box(world **w)
{
    *w = world_begin(2);
    uint32_t white = world_lambert(*w, 0.5f, 0);
    world_room(*w, white, v3(0, 0, 0), v3(1, 1, 1));
    rsv_punctual_light bulb = { .name = "bulb",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.5f, 0.5f, 0.5f },
        .intensity = { 1, 1, 1 } };
    assert_int_equal(rsv_scene_add_light((*w)->scene, &bulb), RSV_OK);
    world_commit(*w);
    return solve(*w, false);
}

static void walls_that_absorb_nothing_are_refused_and_change_nothing(void **state)
{
    (void)state;
    world *w;
    rsv_light *s = closed_box(&w);
    const char *name = rsv_scene_get_view(w->scene)->material[0].name;
    const rsv_albedo_change white = { name, { 1, 1, 1 } }, grey = { name, { 0.25f, 0.25f, 0.25f } };
    size_t nodes = inside(s)->elements->node_count;
    rsv_rgb *light = copy_of(inside(s)->irradiance, nodes);
    rsv_relighter *r;
    begin_relighting(s, &r);
    assert_int_equal(rsv_relighter_change(r, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc),
                                                 .albedo = &white,
                                                 .albedo_count = 1 }),
        RSV_ERROR_SCENE);
    assert_int_equal(rsv_relighter_step(r, 10, NULL), RSV_OK);
    assert_memory_equal(light, inside(s)->irradiance, nodes * sizeof *light);
    change(r, &(rsv_relight_desc){
                  .size = sizeof(rsv_relight_desc), .albedo = &grey, .albedo_count = 1 });
    assert_int_equal(rsv_relighter_settle(r), RSV_OK);
    assert_true(inside(s)->irradiance[0].g < light[0].g);
    free(light);
    rsv_relighter_destroy(r);
    rsv_light_destroy(s);
    world_end(w);
}

/// A lamp that was moved into the plane of a ceiling is seen before it, from there and wherever else it goes.
static void a_lamp_that_was_moved_into_a_ceiling_is_seen(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(4, 3, 5));
    uint32_t lamp = world_lambert(w, 0, 5);
    world_quad(w, lamp, v3(1.8f, 2.63f, 2.1f), v3(2.2f, 2.63f, 2.1f), v3(2.2f, 2.63f, 2.5f),
        v3(1.8f, 2.63f, 2.5f));
    world_commit(w);
    rsv_light *s = solve(w, false);
    const char *name = rsv_scene_get_view(w->scene)->material[lamp].name;
    const rsv_vec3 step[] = { { 0, 0.37f, 0 }, { 0.9f, 0, 1 }, { 0, -0.5f, 0 } };
    rsv_vec3 offset = v3(0, 0, 0);
    for (int k = 0; k < 3; k++) {
        const rsv_light_move move = { name, step[k] };
        offset = v3_add(offset, step[k]);
        relight(s, &(rsv_relight_desc){
                       .size = sizeof(rsv_relight_desc), .move = &move, .move_count = 1 });
        for (int place = 0; place < 16; place++) {
            rsv_vec3 at = v3(1.82f + 0.024f * (float)place, 2.63f, 2.12f + 0.024f * (float)place);
            rsv_vec3 eye = v3(1.3f, 0.4f, 2.2f);
            rsv_ray ray = { eye, v3_sub(v3_add(at, offset), eye), INFINITY };
            rsv_hit hit;
            assert_true(rsv_tracer_closest(inside(s)->scene.tracer, &ray, &hit));
            assert_int_equal(inside(s)->scene.view->triangle_material[hit.triangle], lamp);
        }
    }
    rsv_light_destroy(s);
    world_end(w);
}

/// A lamp as large as a wall blocks light in the rows, so it cannot be moved.
static void a_lamp_as_large_as_a_wall_cannot_be_moved(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t wall = world_lambert(w, 0.5f, 0), lamp = world_lambert(w, 0.5f, 1);
    world_room(w, wall, v3(0, 0, 0), v3(1, 1, 1));
    world_quad(w, lamp, v3(0.3f, 0.98f, 0.3f), v3(0.7f, 0.98f, 0.3f), v3(0.7f, 0.98f, 0.7f),
        v3(0.3f, 0.98f, 0.7f));
    world_commit(w);
    rsv_light *s = solve(w, false);
    const char *name = rsv_scene_get_view(w->scene)->material[lamp].name;
    const rsv_light_move move = { name, { 0, -0.1f, 0 } };
    check_refused(s,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .move = &move, .move_count = 1 },
        name, "solve the scene again");
    rsv_light_destroy(s);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(moving_one_light_leaves_the_parts_of_others_alone),
        cmocka_unit_test(walls_that_absorb_nothing_are_refused_and_change_nothing),
        cmocka_unit_test(a_lamp_as_large_as_a_wall_cannot_be_moved),
        cmocka_unit_test(a_lamp_that_was_moved_into_a_ceiling_is_seen),
        cmocka_unit_test(the_operator_solves_for_its_light),
        cmocka_unit_test(the_transposed_operator_is_the_adjoint),
        cmocka_unit_test(scaled_lights_are_those_of_a_fresh_solve),
        cmocka_unit_test(scaling_nothing_changes_nothing),
        cmocka_unit_test(changed_albedos_are_those_of_a_fresh_solve),
        cmocka_unit_test(textures_stay_under_changed_colors),
        cmocka_unit_test(unknown_names_are_answered_by_the_known_ones),
        cmocka_unit_test(moved_lights_are_those_of_a_fresh_solve),
        cmocka_unit_test(only_the_last_change_counts),
        cmocka_unit_test(lights_on_the_move_are_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(receivers_at_an_edge_get_no_more_than_there_is),
        cmocka_unit_test(sixteen_receivers_see_what_one_does),
        cmocka_unit_test(added_lights_are_those_of_a_fresh_solve),
        cmocka_unit_test(steps_lead_to_the_solution),
        cmocka_unit_test(prepared_strengths_are_right_at_once),
        cmocka_unit_test(what_cannot_move_is_refused),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(lights_of_one_operator_leave_each_other_alone),
        cmocka_unit_test(going_back_ends_where_it_began),
        cmocka_unit_test(copies_of_a_moved_light_move_on_alone),
        cmocka_unit_test(lights_on_the_move_are_near_those_at_rest),
        cmocka_unit_test(moved_caustics_are_as_sharp_as_fresh_ones),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
