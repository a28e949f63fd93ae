/// Piecewise linear elements: exact on planes, continuous across everything that is smooth, separate
/// across everything that is not.
#include "elements/cluster.h"
#include "elements/contact.h"
#include "elements/elements.h"
#include "elements/follower.h"
#include "elements/spacing.h"
#include "light_fixture.h"
#include "solve/sharpen.h"

/// Corners of a rectangle with two points inside: six triangles of very different sizes.
static const rsv_vec3 plane_corner[] = { { 0, 0, 0 }, { 4, 0, 0 }, { 4, 3, 0 }, { 0, 3, 0 },
    { 0.6f, 0.5f, 0 }, { 3, 2.2f, 0 } };
static const uint32_t plane_index[] = { 0, 1, 4, 1, 5, 4, 1, 2, 5, 2, 3, 5, 3, 4, 5, 3, 0, 4 };
#define PLANE_AREA 12.0

static rsv_elements *create_elements(world *w, float spacing)
{
    world_commit(w);
    rsv_elements *e;
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = spacing }, &e), RSV_OK);
    return e;
}

static rsv_elements *create_plane(world **w, float spacing)
{
    *w = world_begin(1);
    world_triangles(*w, world_lambert(*w, 0.5f, 0), plane_corner, 6, plane_index, 6);
    return create_elements(*w, spacing);
}

/// Splits a random part of the cells, several times.
static rsv_elements *refine_at_random(rsv_elements *e, int times, float share, uint32_t seed)
{
    for (int k = 0; k < times; k++) {
        rsv_random random = rsv_random_from(seed, (uint32_t)k, 0);
        uint8_t *split = calloc(e->cell_count, 1);
        assert_non_null(split);
        for (size_t c = 0; c < e->cell_count; c++)
            split[c] = rsv_random_float(&random) < share;
        rsv_elements *finer;
        assert_int_equal(rsv_elements_refine(e, split, &finer), RSV_OK);
        free(split);
        rsv_elements_destroy(e);
        e = finer;
    }
    return e;
}

static rsv_vec3 place_on_face(const rsv_elements *e, uint32_t face, float u, float v)
{
    return rsv_surface_point_at(e->scene, e->face_triangle[face], u, v, e->face_back[face])
        .position;
}

static rsv_vec3 corner_place(const rsv_elements *e, uint32_t cell, int k)
{
    float u, v;
    rsv_cell_corner(&e->cell[cell], k, &u, &v);
    return place_on_face(e, e->cell[cell].face, u, v);
}

static rsv_vec3 node_place(const rsv_elements *e, uint32_t node)
{
    uint32_t support = e->support[e->support_begin[node]];
    return corner_place(e, support / 4, (int)(support & 3));
}

/// Barycentric coordinates of (u, v) in a cell, computed the slow way.
static void cell_coordinates(const rsv_cell *cell, double u, double v, double b[3])
{
    float cu[3], cv[3];
    for (int k = 0; k < 3; k++)
        rsv_cell_corner(cell, k, &cu[k], &cv[k]);
    double e1u = cu[1] - cu[0], e1v = cv[1] - cv[0], e2u = cu[2] - cu[0], e2v = cv[2] - cv[0];
    double det = e1u * e2v - e1v * e2u, du = u - cu[0], dv = v - cv[0];
    b[1] = (du * e2v - dv * e2u) / det;
    b[2] = (e1u * dv - e1v * du) / det;
    b[0] = 1 - b[1] - b[2];
}

static bool contains(const double b[3], double tolerance)
{
    return fmin(b[0], fmin(b[1], b[2])) >= -tolerance;
}

static void random_place(rsv_random *random, float *u, float *v)
{
    rsv_square_to_triangle(rsv_random_float(random), rsv_random_float(random), u, v);
}

static rsv_rgb linear_field(rsv_vec3 p)
{
    return rgb(1 + 2 * p.x - p.y, p.x, 3 * p.y - 0.5f * p.x);
}

static rsv_rgb *random_field(const rsv_elements *e, uint32_t seed)
{
    rsv_random random = rsv_random_from(seed, 0, 0);
    rsv_rgb *value = calloc(e->node_count, sizeof *value);
    assert_non_null(value);
    for (size_t n = 0; n < e->node_count; n++)
        value[n] = rgb_gray(rsv_random_float(&random));
    rsv_elements_constrain(e, value);
    return value;
}

static void check_linear(const rsv_elements *e)
{
    rsv_rgb *value = calloc(e->node_count, sizeof *value);
    assert_non_null(value);
    for (uint32_t n = 0; n < e->node_count; n++)
        if (e->node_hanging[n] == RSV_NONE) value[n] = linear_field(node_place(e, n));
    rsv_elements_constrain(e, value);
    rsv_random random = rsv_random_from(1, 2, 3);
    for (uint32_t k = 0; k < 2000; k++) {
        uint32_t face = k % (uint32_t)e->face_count;
        float u, v;
        random_place(&random, &u, &v);
        rsv_rgb found = rsv_elements_interpolate(e, value, face, u, v);
        rsv_rgb truth = linear_field(place_on_face(e, face, u, v));
        assert_close(found.r, truth.r, 1e-5);
        assert_close(found.g, truth.g, 1e-5);
        assert_close(found.b, truth.b, 1e-5);
    }
    free(value);
}

static void interpolation_reproduces_linear_functions(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_plane(&w, 0.5f);
    check_linear(e);
    e = refine_at_random(e, 4, 0.2f, 5);
    assert_true(e->hanging_count > 0);
    check_linear(e);
    rsv_elements_destroy(e);
    world_end(w);
}

static void locate_finds_what_a_slow_search_finds(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.7f), 5, 0.25f, 7);
    rsv_random random = rsv_random_from(4, 5, 6);
    for (uint32_t n = 0; n < 3000; n++) {
        uint32_t face = n % (uint32_t)e->face_count;
        float u, v, weight[3];
        random_place(&random, &u, &v);
        if (n % 4 == 0) u = floorf(u * 16) / 16; // on lines of the grid
        if (n % 8 == 0) v = floorf(v * 16) / 16;
        uint32_t found = rsv_elements_locate(e, face, u, v, weight);
        bool among = false;
        for (uint32_t c = 0; c < e->cell_count; c++) {
            double b[3];
            if (e->cell[c].face != face) continue;
            cell_coordinates(&e->cell[c], u, v, b);
            if (contains(b, -1e-4)) assert_int_equal(c, found); // strictly inside: no other can be
            if (c != found) continue;
            assert_true(contains(b, 1e-4));
            for (int k = 0; k < 3; k++)
                assert_close(weight[k], b[k], 1e-4);
            among = true;
        }
        assert_true(among);
    }
    rsv_elements_destroy(e);
    world_end(w);
}

/// Places outside the triangle, as rounding makes them, still give weights between 0 and 1.
static void locate_survives_rounding_at_the_borders(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.7f), 3, 0.3f, 9);
    const float place[][2] = { { -1e-6f, 0.5f }, { 0.5f, -1e-6f }, { 0.5f, 0.5000005f }, { 1, 0 },
        { 0, 1 }, { 1.0000001f, 0 }, { 0, 1.0000001f }, { 1, 1e-7f } };
    for (uint32_t face = 0; face < e->face_count; face++) {
        for (size_t k = 0; k < sizeof place / sizeof *place; k++) {
            float weight[3];
            uint32_t cell = rsv_elements_locate(e, face, place[k][0], place[k][1], weight);
            assert_int_equal(e->cell[cell].face, face);
            assert_close(weight[0] + weight[1] + weight[2], 1, 1e-6);
            for (int n = 0; n < 3; n++)
                assert_true(weight[n] >= 0 && weight[n] <= 1);
        }
    }
    rsv_elements_destroy(e);
    world_end(w);
}

/// Value of the field in one cell at a place of the plane z = 0, if it contains the place.
static bool value_in_cell(
    const rsv_elements *e, const rsv_rgb *value, uint32_t cell, rsv_vec3 p, double *result)
{
    rsv_vec3 a = corner_place(e, cell, 0), b = corner_place(e, cell, 1),
             c = corner_place(e, cell, 2);
    double det = (double)(b.x - a.x) * (c.y - a.y) - (double)(b.y - a.y) * (c.x - a.x);
    double w[3];
    w[1] = ((double)(p.x - a.x) * (c.y - a.y) - (double)(p.y - a.y) * (c.x - a.x)) / det;
    w[2] = ((double)(b.x - a.x) * (p.y - a.y) - (double)(b.y - a.y) * (p.x - a.x)) / det;
    w[0] = 1 - w[1] - w[2];
    if (!contains(w, 1e-4)) return false;
    *result = 0;
    for (int k = 0; k < 3; k++)
        *result += w[k] * value[e->cell_node[cell][k]].g;
    return true;
}

static void the_field_is_continuous_across_all_edges(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.9f), 4, 0.2f, 11);
    assert_true(e->hanging_count > 20);
    rsv_rgb *value = random_field(e, 3);
    size_t shared = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        for (int k = 0; k < 3; k++) {
            float t = 0.37f;
            rsv_vec3 a = corner_place(e, c, k), b = corner_place(e, c, (k + 1) % 3);
            rsv_vec3 p = v3_mad(v3_scale(a, 1 - t), t, b);
            double mine = (1 - t) * (double)value[e->cell_node[c][k]].g +
                          t * (double)value[e->cell_node[c][(k + 1) % 3]].g;
            for (uint32_t other = 0; other < e->cell_count; other++) {
                double theirs;
                if (other == c || !value_in_cell(e, value, other, p, &theirs)) continue;
                assert_close(theirs, mine, 1e-3); // 1e-4 of a cell times a jump of at most 2
                shared++;
            }
        }
    }
    assert_true(shared > 2 * e->cell_count);
    free(value);
    rsv_elements_destroy(e);
    world_end(w);
}

static void no_edge_is_halved_more_than_once(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.9f), 5, 0.1f, 13);
    size_t halved = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        for (int k = 0; k < 3; k++) {
            rsv_vec3 a = corner_place(e, c, k), b = corner_place(e, c, (k + 1) % 3);
            rsv_vec3 edge = v3_sub(b, a);
            float length = v3_length(edge);
            size_t between = 0;
            for (uint32_t n = 0; n < e->node_count; n++) {
                rsv_vec3 d = v3_sub(node_place(e, n), a);
                float along = v3_dot(d, edge) / (length * length);
                float off = v3_length(v3_mad(d, -along, edge));
                if (along < 0.01f || along > 0.99f || off > 1e-3f * length) continue;
                between++;
                assert_close(along, 0.5, 1e-3);
                assert_true(e->node_hanging[n] != RSV_NONE);
            }
            assert_true(between <= 1);
            halved += between;
        }
    }
    assert_true(halved > 0);
    rsv_elements_destroy(e);
    world_end(w);
}

static void node_areas_sum_to_the_surface(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_plane(&w, 0.5f);
    for (int round = 0; round < 3; round++) {
        double sum = 0;
        for (size_t n = 0; n < e->node_count; n++) {
            bool hangs = e->node_hanging[n] != RSV_NONE;
            assert_true(hangs ? e->node_area[n] == 0 : e->node_area[n] > 0);
            sum += e->node_area[n];
        }
        assert_close(sum, PLANE_AREA, 1e-4);
        e = refine_at_random(e, 2, 0.2f, 17 + (uint32_t)round);
    }
    rsv_elements_destroy(e);
    world_end(w);
}

static void parents_come_before_the_nodes_that_hang_on_them(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.9f), 6, 0.15f, 19);
    size_t chained = 0;
    for (uint32_t h = 0; h < e->hanging_count; h++) {
        assert_int_equal(e->node_hanging[e->hanging[h].node], h);
        for (int p = 0; p < 2; p++) {
            uint32_t parent = e->node_hanging[e->hanging[h].parent[p]];
            assert_true(parent == RSV_NONE || parent < h);
            chained += parent != RSV_NONE;
        }
    }
    assert_true(chained > 0); // the order matters in this test
    rsv_elements_destroy(e);
    world_end(w);
}

/// Number of nodes that cells of both faces use.
static size_t count_shared_nodes(const rsv_elements *e, uint32_t face_a, uint32_t face_b)
{
    uint8_t *used = calloc(e->node_count, 1);
    assert_non_null(used);
    for (size_t c = 0; c < e->cell_count; c++)
        for (int k = 0; k < 3; k++) {
            if (e->cell[c].face == face_a) used[e->cell_node[c][k]] |= 1;
            if (e->cell[c].face == face_b) used[e->cell_node[c][k]] |= 2;
        }
    size_t shared = 0;
    for (size_t n = 0; n < e->node_count; n++)
        shared += used[n] == 3;
    free(used);
    return shared;
}

/// Two unit squares that share an edge, the second one folded up by `angle`; nodes shared along it.
static size_t shared_across_fold(float angle, bool one_material)
{
    world *w = world_begin(1);
    uint32_t a = world_lambert(w, 0.5f, 0), b = one_material ? a : world_lambert(w, 0.5f, 0);
    float x = 1 + cosf(angle), z = sinf(angle);
    world_quad(w, a, v3(0, 0, 0), v3(1, 0, 0), v3(1, 1, 0), v3(0, 1, 0));
    world_quad(w, b, v3(1, 0, 0), v3(x, 0, z), v3(x, 1, z), v3(1, 1, 0));
    rsv_elements *e = create_elements(w, 0.25f);
    size_t shared = 0;
    for (uint32_t first = 0; first < 2; first++)
        for (uint32_t second = 2; second < 4; second++) {
            size_t count = count_shared_nodes(e, first, second);
            shared = count > shared ? count : shared;
        }
    rsv_elements_destroy(e);
    world_end(w);
    return shared;
}

static void smooth_edges_share_their_nodes(void **state)
{
    (void)state;
    assert_int_equal(shared_across_fold(0, true), 5);
    assert_int_equal(shared_across_fold(0.2f, true), 5);
}

static void creases_split_nodes(void **state)
{
    (void)state;
    assert_int_equal(shared_across_fold(0.6f, true), 0);
    assert_int_equal(shared_across_fold(RSV_PI / 2, true), 0);
}

static void material_borders_split_nodes(void **state)
{
    (void)state;
    assert_int_equal(shared_across_fold(0, false), 0);
}

static void sides_of_double_sided_surfaces_have_nodes_of_their_own(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_material material = lambert_material(0.5f, 0);
    material.double_sided = true;
    world_quad(w, world_material(w, material), v3(0, 0, 0), v3(1, 0, 0), v3(1, 1, 0), v3(0, 1, 0));
    rsv_elements *e = create_elements(w, 0.25f);
    assert_int_equal(e->face_count, 4);
    for (uint32_t triangle = 0; triangle < 2; triangle++)
        for (uint32_t other = 0; other < 2; other++)
            assert_int_equal(
                count_shared_nodes(e, e->face_of[0][triangle], e->face_of[1][other]), 0);
    assert_true(count_shared_nodes(e, e->face_of[1][0], e->face_of[1][1]) > 2);
    rsv_elements_destroy(e);
    world_end(w);
}

static bool belongs_to(const rsv_elements *e, uint32_t node, uint32_t support)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (e->support[s] == support) return true;
    return false;
}

enum { POINTS = 16, REPEATS = 256, MAX_CELLS = 64 };

/// Sums over independent samples of one node's support.
typedef struct hat_moments {
    double first, second;    ///< of the hat function's value
    double cells[MAX_CELLS]; ///< points per cell of the support
} hat_moments;

static void collect_moments(const rsv_elements *e, uint32_t node, hat_moments *m)
{
    for (uint32_t seed = 0; seed < REPEATS; seed++) {
        rsv_support_point point[POINTS];
        rsv_elements_sample_support(e, node, POINTS, seed, point);
        for (int k = 0; k < POINTS; k++) {
            double b[3];
            assert_true(belongs_to(e, node, point[k].support));
            cell_coordinates(&e->cell[point[k].support / 4], point[k].u, point[k].v, b);
            assert_true(contains(b, 1e-4));
            double hat = b[point[k].support & 3];
            m->first += hat;
            m->second += hat * hat;
            for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
                m->cells[s - e->support_begin[node]] += e->support[s] == point[k].support;
        }
    }
}

/// Under a density proportional to the hat function b itself, the mean of b is 1/2 and that of b^2 is
/// 3/10; each cell gets its share of the area.
static void support_samples_follow_the_hat_function(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.9f), 3, 0.2f, 23);
    const double total = POINTS * REPEATS;
    for (uint32_t node = 0; node < e->node_count; node += 7) {
        if (e->node_hanging[node] != RSV_NONE) continue;
        uint32_t begin = e->support_begin[node], count = e->support_begin[node + 1] - begin;
        hat_moments m = { 0 };
        double area = 0, chi_square = 0;
        assert_true(count <= MAX_CELLS);
        collect_moments(e, node, &m);
        // standard deviations 0.22 and 0.23, five standard errors even without stratification
        assert_close(m.first / total, 0.5, 5 * 0.23 / sqrt(total));
        assert_close(m.second / total, 0.3, 5 * 0.23 / sqrt(total));
        for (uint32_t s = 0; s < count; s++) {
            const rsv_cell *cell = &e->cell[e->support[begin + s] / 4];
            area += ldexp(e->face_area[cell->face], -2 * cell->level);
        }
        for (uint32_t s = 0; s < count; s++) {
            const rsv_cell *cell = &e->cell[e->support[begin + s] / 4];
            double expected = total * ldexp(e->face_area[cell->face], -2 * cell->level) / area;
            chi_square += (m.cells[s] - expected) * (m.cells[s] - expected) / expected;
        }
        // five standard deviations above the mean of chi-square with count - 1 degrees of freedom
        assert_true(chi_square <= count + 5 * sqrt(2.0 * count));
    }
    rsv_elements_destroy(e);
    world_end(w);
}

/// Whether two nodes have cells of the same area around them, which on a plane are the same if their places are.
static bool same_surroundings(
    const rsv_elements *a, uint32_t node, const rsv_elements *b, uint32_t other)
{
    const rsv_elements *of[2] = { a, b };
    uint32_t index[2] = { node, other };
    double area[2] = { 0 };
    for (int i = 0; i < 2; i++)
        for (uint32_t s = of[i]->support_begin[index[i]]; s < of[i]->support_begin[index[i] + 1];
             s++)
            area[i] += (double)rsv_cell_area(of[i], of[i]->support[s] / 4);
    rsv_vec3 step = v3_sub(node_place(a, node), node_place(b, other));
    return v3_length(step) < 1e-4f && fabs(area[0] - area[1]) < 1e-5 * area[0];
}

/// A wall leaves a node half its cells; splits around another one leave it cells of the same area together.
static void cells_that_add_up_to_the_same_area_are_not_the_same(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t paint = world_lambert(w, 0.5f, 0);
    world_quad(w, paint, v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1));
    rsv_material sheet = lambert_material(0.5f, 0);
    sheet.double_sided = true;
    world_quad(w, world_material(w, sheet), v3(0, 0, -1), v3(0, 0, 1), v3(0, 1, 1), v3(0, 1, -1));
    rsv_elements *e = create_elements(w, 0.25f), *finer;
    uint64_t rays = 0;
    assert_int_equal(rsv_elements_separate(&w->transport, NULL, e, &rays), RSV_OK);
    size_t same_area = 0;
    for (uint32_t seed = 0; seed < 20; seed++) {
        uint8_t *split = calloc(e->cell_count, 1);
        assert_non_null(split);
        for (uint32_t c = 0; c < e->cell_count; c++)
            split[c] = rsv_hash2(seed, c) % 3 > 0;
        assert_int_equal(rsv_elements_refine(e, split, &finer), RSV_OK);
        for (uint32_t n = 0; n < finer->node_count; n++) {
            uint32_t twin = rsv_elements_find_twin(finer, n, e);
            uint32_t cells = finer->support_begin[n + 1] - finer->support_begin[n];
            if (twin != RSV_NONE)
                assert_int_equal(cells, e->support_begin[twin + 1] - e->support_begin[twin]);
            for (uint32_t m = 0; m < e->node_count; m++)
                same_area += twin == RSV_NONE && same_surroundings(finer, n, e, m);
        }
        free(split);
        rsv_elements_destroy(finer);
    }
    assert_true(same_area > 0);
    rsv_elements_destroy(e);
    world_end(w);
}

static void twins_are_nodes_whose_cells_a_split_left_alone(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_plane(&w, 0.5f), *finer;
    e = refine_at_random(e, 1, 0.3f, 8);
    uint8_t *split = calloc(e->cell_count, 1);
    assert_non_null(split);
    split[7] = 1;
    assert_int_equal(rsv_elements_refine(e, split, &finer), RSV_OK);
    size_t twins = 0;
    for (uint32_t n = 0; n < finer->node_count; n++) {
        uint32_t expected = RSV_NONE;
        for (uint32_t m = 0; m < e->node_count; m++)
            if (same_surroundings(finer, n, e, m)) expected = m;
        assert_int_equal(rsv_elements_find_twin(finer, n, e), expected);
        twins += expected != RSV_NONE;
    }
    assert_true(twins > 0 && twins < e->node_count);
    free(split);
    rsv_elements_destroy(finer);
    rsv_elements_destroy(e);
    world_end(w);
}

static void points_of_one_cell_come_one_after_the_other(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.9f), 2, 0.2f, 29);
    for (uint32_t node = 0; node < e->node_count; node++) {
        rsv_support_point point[POINTS];
        rsv_elements_sample_support(e, node, POINTS, 1, point);
        for (int k = 1; k < POINTS; k++)
            for (int j = 0; j < k - 1; j++)
                if (point[j].support == point[k].support)
                    assert_int_equal(point[k - 1].support, point[k].support);
    }
    rsv_elements_destroy(e);
    world_end(w);
}

static void averages_match_sampled_means(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = refine_at_random(create_plane(&w, 0.9f), 3, 0.2f, 31);
    rsv_rgb *value = random_field(e, 5), *average = calloc(e->node_count, sizeof *average);
    assert_non_null(average);
    rsv_elements_average(e, value, average);
    for (uint32_t node = 0; node < e->node_count; node += 11) {
        if (e->node_hanging[node] != RSV_NONE) continue;
        double sum = 0;
        for (uint32_t seed = 0; seed < REPEATS; seed++) {
            rsv_support_point point[POINTS];
            rsv_elements_sample_support(e, node, POINTS, seed, point);
            for (int k = 0; k < POINTS; k++)
                sum += rsv_elements_interpolate(
                    e, value, e->cell[point[k].support / 4].face, point[k].u, point[k].v)
                           .g;
        }
        // values in [0, 1] vary by less than 0.3 within a cell
        assert_close(average[node].g, sum / (POINTS * REPEATS), 5 * 0.3 / sqrt(POINTS * REPEATS));
    }
    free(value);
    free(average);
    rsv_elements_destroy(e);
    world_end(w);
}

/// Red light beside green light of the same luminance.
static void sharpening_keeps_away_from_edges_of_colour(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_plane(&w, 0.2f);
    rsv_rgb *value = calloc(e->node_count, sizeof *value);
    rsv_rgb *once = calloc(e->node_count, sizeof *once),
            *twice = calloc(e->node_count, sizeof *once);
    const rsv_rgb red = { 1, 0.1f, 0.1f }, green = { 0.1f, 0.3675f, 0.1f };
    assert_true(value && once && twice);
    for (uint32_t n = 0; n < e->node_count; n++) {
        uint32_t face;
        float u, v;
        rsv_elements_place_node(e, n, &face, &u, &v);
        rsv_vec3 at = place_on_face(e, face, u, v);
        value[n] = rgb_scale(at.x < 2 ? red : green, 1 + 0.1f * at.y);
    }
    rsv_sharpen(e, value, once, twice);
    for (size_t n = 0; n < e->node_count; n++) {
        assert_true(value[n].r > 0.099f && value[n].r < 1.31f);
        assert_true(value[n].g > 0.099f && value[n].g < 0.48f);
    }
    free(value);
    free(once);
    free(twice);
    rsv_elements_destroy(e);
    world_end(w);
}

static void nodes_are_drawn_by_their_weights(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_plane(&w, 0.9f);
    const float weight[3] = { 0.2f, 0.5f, 0.3f };
    int drawn[3] = { 0 };
    for (int n = 0; n < 1000; n++) {
        uint32_t node = rsv_elements_pick_node(e, 3, weight, ((float)n + 0.5f) / 1000);
        for (int k = 0; k < 3; k++)
            drawn[k] += e->cell_node[3][k] == node;
    }
    for (int k = 0; k < 3; k++)
        assert_close(drawn[k] / 1000.0, weight[k], 2e-3);
    rsv_elements_destroy(e);
    world_end(w);
}

#define MESH_SIDE 40 // squares along a square of 4 m, two triangles each

/// A plane meshed far more finely than its spacing of 1 m.
static rsv_elements *create_fine_plane(world **w)
{
    static rsv_vec3 corner[(MESH_SIDE + 1) * (MESH_SIDE + 1)];
    static uint32_t index[6 * MESH_SIDE * MESH_SIDE];
    uint32_t row = MESH_SIDE + 1, *next = index;
    for (uint32_t k = 0; k < row * row; k++)
        corner[k] = v3(4.0f * (float)(k % row) / MESH_SIDE, 4.0f * (float)(k / row) / MESH_SIDE, 0);
    for (uint32_t j = 0; j < MESH_SIDE; j++)
        for (uint32_t i = 0; i < MESH_SIDE; i++) {
            uint32_t a = j * row + i, b = a + row;
            const uint32_t square[6] = { a, a + 1, b + 1, a, b + 1, b };
            memcpy(next, square, sizeof square);
            next += 6;
        }
    *w = world_begin(1);
    world_triangles(
        *w, world_lambert(*w, 0.5f, 0), corner, row * row, index, 2 * MESH_SIDE * MESH_SIDE);
    return create_elements(*w, 1);
}

static size_t count_leaders(const rsv_elements *e) { return e->node_count - e->hanging_count; }

static void nodes_of_fine_meshes_follow_near_leaders(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_fine_plane(&w);
    assert_int_equal(rsv_elements_cluster(e, 0.5f), RSV_OK);
    // discs of 0.5 m cover 16 m2: 21 at the least; discs of 0.25 m, which do not overlap, fill no more than 0.9069 of
    // 4.5 m squared: 93 at the most
    assert_in_range(count_leaders(e), 21, 93);
    double area = 0;
    for (size_t n = 0; n < e->node_count; n++)
        area += e->node_area[n];
    assert_close(area, 16, 1e-4);
    for (size_t h = 0; h < e->follower_count; h++) {
        const rsv_hanging *f = &e->hanging[h];
        float sum = 0, nearest = INFINITY;
        for (int p = 0; p < RSV_PARENTS; p++) {
            assert_int_equal(e->node_hanging[f->parent[p]], RSV_NONE);
            sum += f->weight[p];
            rsv_vec3 apart = v3_sub(node_place(e, f->node), node_place(e, f->parent[p]));
            if (f->weight[p] > 0) nearest = f_min(nearest, v3_length(apart));
        }
        assert_close(sum, 1, 1e-5);
        assert_true(nearest <= 0.5f);
    }
    rsv_elements_destroy(e);
    world_end(w);
}

static void mark_cell(void *user, uint32_t cell, uint32_t other, float curvature)
{
    (void)curvature;
    (void)other;
    ((uint8_t *)user)[cell] = 1;
}

/// Integral of x^2 over the elements, from points of their supports.
static double sampled_integral(const rsv_elements *e)
{
    double sum = 0;
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (e->node_hanging[n] != RSV_NONE) continue;
        rsv_support_point point[256];
        rsv_elements_sample_support(e, n, 256, 1, point);
        for (int k = 0; k < 256; k++) {
            float x =
                place_on_face(e, e->cell[point[k].support / 4].face, point[k].u, point[k].v).x;
            sum += (double)e->node_area[n] / 256 * (double)(x * x);
        }
    }
    return sum;
}

/// A leader (a node that receives light for others) at the rim of a chair's seat must not pass the light of the rim on
/// to the whole seat.
static void leaders_receive_for_all_that_follow_them(void **state)
{
    (void)state;
    const float radius[] = { 0.5f, 20 }; // of many leaders, of one in the corner
    for (int k = 0; k < 2; k++) {
        world *w;
        rsv_elements *e = create_fine_plane(&w);
        assert_int_equal(rsv_elements_cluster(e, radius[k]), RSV_OK);
        assert_close(sampled_integral(e), 4 * 64.0 / 3, k ? 5 : 1);
        rsv_elements_destroy(e);
        world_end(w);
    }
}

static void clusters_shrink_where_leaders_disagree(void **state)
{
    (void)state;
    world *w;
    rsv_elements *e = create_fine_plane(&w), *finer;
    assert_int_equal(rsv_elements_cluster(e, 0.5f), RSV_OK);
    size_t leaders = count_leaders(e);
    rsv_rgb *value = calloc(e->node_count, sizeof *value);
    float *deviation = calloc(e->node_count, sizeof *deviation);
    uint8_t *marked = calloc(e->cell_count, 1), *none = calloc(e->cell_count, 1);
    for (uint32_t n = 0; n < e->node_count; n++) // a step at x = 1
        value[n] = rgb_gray(node_place(e, n).x < 1 ? 1 : 2);
    rsv_elements_constrain(e, value);
    rsv_find_cluster_curvature(
        e, &(rsv_curvature_field){ value, deviation, 0.2f, 0, NULL }, mark_cell, marked);
    double expected = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (!marked[c]) continue;
        rsv_vec3 place = corner_place(e, c, 0);
        assert_true(fabsf(place.x - 1) < 1.3f);
        expected += (double)rsv_cell_new_leaders(e, c);
        e->face_halvings[e->cell[c].face]++;
    }
    assert_int_equal(rsv_elements_refine(e, none, &finer), RSV_OK);
    assert_int_equal(rsv_elements_cluster(finer, 0.5f), RSV_OK);
    double added = (double)(count_leaders(finer) - leaders);
    assert_true(added > 0.3 * expected && added < 2 * expected);
    free(value);
    free(deviation);
    free(marked);
    free(none);
    rsv_elements_destroy(e);
    rsv_elements_destroy(finer);
    world_end(w);
}

#define TARGET 2000

static void spacing_is_even_in_closed_rooms(void **state)
{
    (void)state;
    const rsv_vec3 high[] = { { 1, 1, 1 }, { 8, 2, 3 }, { 10, 5, 10 } };
    for (int k = 0; k < 3; k++) {
        world *w = world_begin(1);
        uint32_t white = world_lambert(w, 0.7f, 0);
        world_room(w, white, v3(0, 0, 0), high[k]);
        world_commit(w);
        float x = high[k].x, y = high[k].y, z = high[k].z;
        rsv_spacing spacing = rsv_spacing_for(&w->transport, TARGET);
        assert_close(spacing.metres, sqrt(2 * (double)(x * y + y * z + z * x) / TARGET), 1e-4);
        rsv_elements *e;
        assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &e), RSV_OK);
        for (uint32_t c = 0; c < e->cell_count; c++)
            assert_false(rsv_spacing_lets_grow(&spacing, e, c));
        rsv_elements_destroy(e);
        world_end(w);
    }
}

/// A house of 6 m without a floor of its own, on a plain of 200 m.
static world *create_house(float plain)
{
    world *w = world_begin(1);
    uint32_t white = world_lambert(w, 0.7f, 0);
    world_quad(w, white, v3(-plain, 0, plain), v3(plain, 0, plain), v3(plain, 0, -plain),
        v3(-plain, 0, -plain));
    world_box(w, white, v3(-3, -0.1f, -3), v3(-2.8f, 3, 3));
    world_box(w, white, v3(2.8f, -0.1f, -3), v3(3, 3, 3));
    world_box(w, white, v3(-3, -0.1f, -3), v3(3, 3, -2.8f));
    world_box(w, white, v3(-3, 3, -3), v3(3, 3.2f, 3));
    return w;
}

static void plains_around_a_house_take_few_elements(void **state)
{
    (void)state;
    world *w = create_house(100);
    world_commit(w);
    rsv_spacing spacing = rsv_spacing_for(&w->transport, TARGET);
    assert_in_range(spacing.metres * 100, 10, 100); // 4.5 m if the plain took its share
    rsv_elements *e;
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &e), RSV_OK);
    assert_in_range(e->node_count, TARGET / 4, 4 * TARGET);
    for (uint32_t c = 0; c < e->cell_count; c++) {
        rsv_vec3 place = corner_place(e, c, 0);
        float far = f_max(fabsf(place.x), fabsf(place.z));
        float size = sqrtf(2 * rsv_cell_area(e, c)) / spacing.metres;
        if (far < 3) assert_true(size < 1.5f);
        if (far > 90) assert_true(size > 8);
    }
    rsv_elements_destroy(e);
    world_end(w);
}

/// Walls of one metre around a yard of 40 fill no more than a hundredth of what its middle faces.
static void yards_within_low_walls_take_few_elements(void **state)
{
    (void)state;
    const float yard = 20, thick = 0.2f;
    world *w = world_begin(1);
    uint32_t white = world_lambert(w, 0.7f, 0);
    world_quad(w, white, v3(-100, 0, 100), v3(100, 0, 100), v3(100, 0, -100), v3(-100, 0, -100));
    for (int side = -1; side <= 1; side += 2) {
        float near = side * yard, far = side * (yard + thick);
        float low = f_min(near, far), high = f_max(near, far);
        world_box(w, white, v3(low, -0.1f, -yard), v3(high, 1, yard));
        world_box(w, white, v3(-yard, -0.1f, low), v3(yard, 1, high));
    }
    world_commit(w);
    rsv_spacing spacing = rsv_spacing_for(&w->transport, TARGET);
    rsv_elements *e;
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &e), RSV_OK);
    assert_in_range(e->node_count, TARGET / 4, 4 * TARGET);
    for (uint32_t c = 0; c < e->cell_count; c++) {
        rsv_vec3 place = corner_place(e, c, 0);
        float far = f_max(fabsf(place.x), fabsf(place.z));
        float size = sqrtf(2 * rsv_cell_area(e, c)) / spacing.metres;
        if (place.y > 0 && place.y < 1) assert_true(size < 1.5f);
        if (place.y == 0 && far < yard / 4) assert_true(size > 3);
        if (place.y == 0 && fabsf(far - yard) < 0.5f) assert_true(size < 1.5f);
    }
    rsv_elements_destroy(e);
    world_end(w);
}

static void bare_planes_have_elements_of_one_size(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_triangles(w, world_lambert(w, 0.5f, 0), plane_corner, 6, plane_index, 6);
    world_commit(w);
    rsv_spacing even = { .metres = sqrtf((float)PLANE_AREA / TARGET) };
    rsv_spacing spacing = rsv_spacing_for(&w->transport, TARGET);
    rsv_elements *e, *expected;
    assert_float_equal(
        spacing.metres, even.metres, 1e-3 * even.metres); // what direct light starts from
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &e), RSV_OK);
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &even, &expected), RSV_OK);
    assert_int_equal(e->node_count, expected->node_count);
    rsv_elements_destroy(e);
    rsv_elements_destroy(expected);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interpolation_reproduces_linear_functions),
        cmocka_unit_test(locate_finds_what_a_slow_search_finds),
        cmocka_unit_test(locate_survives_rounding_at_the_borders),
        cmocka_unit_test(the_field_is_continuous_across_all_edges),
        cmocka_unit_test(no_edge_is_halved_more_than_once),
        cmocka_unit_test(node_areas_sum_to_the_surface),
        cmocka_unit_test(parents_come_before_the_nodes_that_hang_on_them),
        cmocka_unit_test(smooth_edges_share_their_nodes),
        cmocka_unit_test(creases_split_nodes),
        cmocka_unit_test(material_borders_split_nodes),
        cmocka_unit_test(sides_of_double_sided_surfaces_have_nodes_of_their_own),
        cmocka_unit_test(support_samples_follow_the_hat_function),
        cmocka_unit_test(points_of_one_cell_come_one_after_the_other),
        cmocka_unit_test(cells_that_add_up_to_the_same_area_are_not_the_same),
        cmocka_unit_test(twins_are_nodes_whose_cells_a_split_left_alone),
        cmocka_unit_test(averages_match_sampled_means),
        cmocka_unit_test(sharpening_keeps_away_from_edges_of_colour),
        cmocka_unit_test(nodes_are_drawn_by_their_weights),
        cmocka_unit_test(nodes_of_fine_meshes_follow_near_leaders),
        cmocka_unit_test(leaders_receive_for_all_that_follow_them),
        cmocka_unit_test(spacing_is_even_in_closed_rooms),
        cmocka_unit_test(plains_around_a_house_take_few_elements),
        cmocka_unit_test(yards_within_low_walls_take_few_elements),
        cmocka_unit_test(bare_planes_have_elements_of_one_size),
        cmocka_unit_test(clusters_shrink_where_leaders_disagree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
