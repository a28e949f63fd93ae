/// Solving a scene again after an edit, with results of the previous solve.
#include "history_fixture.h"
#include "slow_tests.h"
#include "update/material_keys.h"

#include <math.h>

enum { SEEDS = 4, EDITS = 2 };

/// Logarithm of a solution's mean distance to others. @param from [SEEDS], itself left out
static double distance(const rsv_light *s, rsv_light *const from[SEEDS])
{
    double sum = 0;
    int count = 0;
    for (int k = 0; k < SEEDS; k++) {
        if (from[k] == s) continue;
        sum += difference(from[k], s);
        count++;
    }
    return log(sum / count);
}

/// Solutions of a room after an edit, from what is kept, and as a whole with other random numbers: how far each of both
/// is from those as a whole.
static void measure(const room *now, folder rows[SEEDS], const folder earlier[SEEDS],
    double again_distance[SEEDS], double whole_distance[SEEDS])
{
    world *w = build(now, 2);
    rsv_light *again[SEEDS], *whole[SEEDS];
    for (uint32_t k = 0; k < SEEDS; k++) {
        rows[k] = new_folder();
        again[k] = solve_as(w, rows[k].path, earlier[k].path, 1 + k);
        whole[k] = solve_as(w, NULL, NULL, 1 + SEEDS + k);
        assert_true(inside(again[k])->report.kept_row_rays > inside(again[k])->report.row_rays / 2);
    }
    for (int k = 0; k < SEEDS; k++) {
        again_distance[k] = distance(again[k], whole);
        whole_distance[k] = distance(whole[k], whole);
    }
    for (int k = 0; k < SEEDS; k++) {
        rsv_light_destroy(again[k]);
        rsv_light_destroy(whole[k]);
    }
    world_end(w);
}

static double mean_of(const double x[SEEDS])
{
    double sum = 0;
    for (int k = 0; k < SEEDS; k++)
        sum += x[k];
    return sum / SEEDS;
}

static double squares_of(const double x[SEEDS])
{
    double mean = mean_of(x), sum = 0;
    for (int k = 0; k < SEEDS; k++)
        sum += (x[k] - mean) * (x[k] - mean);
    return sum;
}

/// Student's t of the distances from what is kept against those as a whole, each edit against its own. Distances vary by a
/// third from seed to seed, as much of the error is that of the whole level of light: one alone says little.
static void an_edit_gives_what_a_whole_solution_gives(void **state)
{
    (void)state;
    folder f[1 + EDITS][SEEDS];
    room now[1 + EDITS] = { plain, plain, plain };
    now[1].box_at = 0.8f;
    now[2].albedo = 0.1f; // what was solved again serves as well, and moves back
    for (uint32_t k = 0; k < SEEDS; k++) {
        f[0][k] = new_folder();
        leave_as(&plain, f[0][k].path, NULL, 1 + k);
    }
    double again[SEEDS], whole[SEEDS], farther = 0, squares = 0;
    for (int edit = 1; edit <= EDITS; edit++) {
        measure(&now[edit], f[edit], f[edit - 1], again, whole);
        farther += (mean_of(again) - mean_of(whole)) / EDITS;
        squares += squares_of(again) + squares_of(whole);
    }
    double variance = squares / (2 * EDITS * (SEEDS - 1)); // 12 degrees of freedom
    double t = farther / sqrt(variance * 2 / (EDITS * SEEDS));
    assert_true(t < 3.93); // once in a thousand if they are as good
    for (int edit = 0; edit <= EDITS; edit++)
        for (int k = 0; k < SEEDS; k++)
            remove_folder(f[edit][k].path);
}

static void albedos_need_no_rays_of_rows(void **state)
{
    (void)state;
    room dark = plain;
    dark.albedo = 0.1f;
    edited_room r = edit(&plain, &dark);
    assert_true(inside(r.s)->report.kept_row_rays > 0);
    assert_int_equal(inside(r.s)->report.kept_row_rays, inside(r.s)->report.row_rays);
    end_edit(&r);
}

static int compare_numbers(const void *left, const void *right)
{
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

static void no_two_nodes_draw_the_same_points(void **state)
{
    (void)state;
    edited_room r = edit(&plain, &moved);
    const rsv_elements *e = inside(r.s)->elements;
    uint32_t *draw = calloc(e->node_count, sizeof *draw), count = 0, recalled = 0;
    assert_non_null(draw);
    assert_non_null(e->node_draw);
    for (uint32_t n = 0; n < e->node_count; n++) {
        recalled += e->node_draw[n] != n;
        if (inside(r.s)->valid_points[n]) draw[count++] = e->node_draw[n];
    }
    assert_true(recalled > 0);
    qsort(draw, count, sizeof *draw, compare_numbers);
    for (uint32_t k = 1; k < count; k++)
        assert_int_not_equal(draw[k - 1], draw[k]);
    free(draw);
    end_edit(&r);
}

static void threads_make_no_difference(void **state)
{
    (void)state;
    folder before = new_folder();
    leave(&plain, before.path, NULL);
    rsv_light *s[2];
    world *w[2];
    for (int k = 0; k < 2; k++) {
        folder after = new_folder();
        w[k] = build(&moved, k + 1);
        s[k] = solve(w[k], after.path, before.path);
        remove_folder(after.path);
    }
    assert_int_equal(
        inside(s[0])->fine.elements->node_count, inside(s[1])->fine.elements->node_count);
    assert_memory_equal(inside(s[0])->irradiance, inside(s[1])->irradiance,
        inside(s[0])->elements->node_count * sizeof *inside(s[0])->irradiance);
    assert_memory_equal(inside(s[0])->fine.direct, inside(s[1])->fine.direct,
        inside(s[0])->fine.elements->node_count * sizeof *inside(s[0])->fine.direct);
    for (int k = 0; k < 2; k++) {
        rsv_light_destroy(s[k]);
        world_end(w[k]);
    }
    remove_folder(before.path);
}

/// Of the first triangle, and of the normal map there.
static uint64_t key_of_first(const world *w)
{
    rsv_material_key *keys, *maps;
    const rsv_scene_view *scene = w->transport.view;
    assert_int_equal(rsv_material_keys_create(w->context, &w->transport, &keys), RSV_OK);
    assert_int_equal(rsv_normal_map_keys_create(w->context, scene, &maps), RSV_OK);
    uint64_t map = maps[scene->triangle_material[0]].key;
    uint64_t key = rsv_surface_key(scene, keys, 0) + (map ? rsv_key_add_uvs(map, scene, 0) : 0);
    rsv_free(w->context, keys);
    rsv_free(w->context, maps);
    return key;
}

static uint64_t key_of_coat(rsv_rgb specular_color, rsv_rgb sheen_color, float roughness)
{
    world *w = world_begin(1);
    rsv_material coat = lambert_material(0.5f, 0);
    coat.specular = 1;
    coat.specular_color = specular_color;
    coat.sheen_color = sheen_color;
    coat.roughness = roughness;
    world_room(w, world_material(w, coat), v3(0, 0, 0), v3(1, 1, 1));
    world_commit(w);
    uint64_t key = key_of_first(w);
    world_end(w);
    return key;
}

static void another_coat_is_another_surface(void **state)
{
    (void)state;
    const rsv_rgb black = rgb_gray(0), white = rgb_gray(1), red = rgb(1, 0.5f, 0.5f);
    uint64_t key = key_of_coat(white, black, 0.5f);
    assert_int_equal(key_of_coat(white, black, 0.5f), key);
    assert_int_not_equal(key_of_coat(red, black, 0.5f), key);
    assert_int_not_equal(key_of_coat(white, red, 0.5f), key);
    assert_int_not_equal(key_of_coat(white, black, 0.25f), key);
}

/// Of a plate whose coat is a texture of 1 on one side and 0 on the other.
static uint64_t key_of_half(rsv_texture_role role, bool other_side, float shift)
{
    const float left = other_side ? 0 : 1, right = 1 - left;
    const float texel[2][4] = { { left, left, left, left }, { right, right, right, right } };
    static const float uv[4][2] = { { 0, 0 }, { 0, 1 }, { 1, 1 }, { 1, 0 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_vec3 corner[4] = { v3(0, 0, 0), v3(0, 0, 1), v3(1, 0, 1), v3(1, 0, 0) };
    float shifted[4][2];
    for (int k = 0; k < 4; k++)
        shifted[k][0] = uv[k][0] + shift, shifted[k][1] = uv[k][1];
    const rsv_texture_desc desc = { .size = sizeof desc,
        .name = "half",
        .width = 2,
        .height = 1,
        .channel_count = 4,
        .values = texel[0] };
    world *w = world_begin(1);
    rsv_texture_ref ref = rsv_default_texture_ref(role, 0);
    rsv_material coat = lambert_material(0.5f, 0);
    coat.clearcoat = 1;
    coat.textures = &ref;
    coat.texture_count = 1;
    assert_int_equal(rsv_scene_add_texture(w->scene, &desc, &ref.texture), RSV_OK);
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = world_material(w, coat),
        .uvs = { (const float(*)[2])shifted, NULL } };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, id, NULL, NULL), RSV_OK);
    world_commit(w);
    uint64_t key = key_of_first(w);
    world_end(w);
    return key;
}

/// Both textures have the same mean. Those of base colours count nowhere: albedos are found anew.
static void another_texture_of_a_coat_is_another_surface(void **state)
{
    (void)state;
    uint64_t key = key_of_half(RSV_TEXTURE_CLEARCOAT, false, 0);
    assert_int_equal(key_of_half(RSV_TEXTURE_CLEARCOAT, false, 0), key);
    assert_int_not_equal(key_of_half(RSV_TEXTURE_CLEARCOAT, true, 0), key);
    assert_int_not_equal(key_of_half(RSV_TEXTURE_CLEARCOAT, false, 0.25f), key);
    key = key_of_half(RSV_TEXTURE_NORMAL, false, 0);
    assert_int_not_equal(key_of_half(RSV_TEXTURE_NORMAL, true, 0), key);
    assert_int_not_equal(key_of_half(RSV_TEXTURE_NORMAL, false, 0.25f), key);
    key = key_of_half(RSV_TEXTURE_BASE_COLOR, false, 0);
    assert_int_equal(key_of_half(RSV_TEXTURE_BASE_COLOR, true, 0), key);
    assert_int_equal(key_of_half(RSV_TEXTURE_BASE_COLOR, false, 0.25f), key);
}

static bool segment_meets(rsv_vec3 from, rsv_vec3 to, rsv_vec3 low, rsv_vec3 high)
{
    for (int step = 0; step <= 200; step++) { // slow and obvious
        rsv_vec3 p = v3_mad(from, (float)step / 200, v3_sub(to, from));
        if (p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z &&
            p.z <= high.z)
            return true;
    }
    return false;
}

/// Lines from a cell to the lamp against all boxes of the change.
static bool any_line_meets(const rsv_scene_change *change, const rsv_elements *e, uint32_t c)
{
    rsv_random random = rsv_random_from(1, c, 0);
    for (int line = 0; line < 24; line++) {
        float u[3], v[3], a = rsv_random_float(&random), b = rsv_random_float(&random);
        for (int k = 0; k < 3; k++)
            rsv_cell_corner(&e->cell[c], k, &u[k], &v[k]);
        if (a + b > 1) a = 1 - a, b = 1 - b;
        uint32_t face = e->cell[c].face;
        rsv_vec3 from = rsv_surface_point_at(e->scene, e->face_triangle[face],
            u[0] + a * (u[1] - u[0]) + b * (u[2] - u[0]),
            v[0] + a * (v[1] - v[0]) + b * (v[2] - v[0]), e->face_back[face])
                            .position;
        rsv_vec3 to =
            v3(1 + 0.3f * rsv_random_float(&random), 1.9f, 0.8f + 0.4f * rsv_random_float(&random));
        for (uint32_t k = 0; k < change->count; k++)
            if (segment_meets(from, to, change->low[k], change->high[k])) return true;
    }
    return false;
}

static void light_is_the_same_only_where_no_line_to_a_lamp_meets_the_change(void **state)
{
    (void)state;
    edited_room r = edit(&plain, &moved);
    const rsv_elements *e = inside(r.s)->elements;
    size_t bytes;
    rsv_history_header *h = read_past(r.before.path, &bytes);
    opened o = open_history(&inside(r.s)->scene, inside(r.s)->lights, r.before.path, h->settings);
    const rsv_history *past = o.history;
    assert_non_null(past);
    free(h);
    size_t same = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (rsv_history_is_light_changed(past, e, c)) continue;
        same++;
        assert_false(any_line_meets(rsv_history_change(past), e, c));
    }
    assert_true(same > e->cell_count / 3);
    close_history(&o);
    end_edit(&r);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(albedos_need_no_rays_of_rows),
        cmocka_unit_test(no_two_nodes_draw_the_same_points),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(light_is_the_same_only_where_no_line_to_a_lamp_meets_the_change),
        cmocka_unit_test(another_coat_is_another_surface),
        cmocka_unit_test(another_texture_of_a_coat_is_another_surface),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(an_edit_gives_what_a_whole_solution_gives),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
