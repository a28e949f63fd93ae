/// The refinement indicator: finds kinks, leaves planes alone, and sees slopes at borders when asked to.
#include "elements/curvature.h"
#include "elements/elements.h"
#include "elements/spacing.h"
#include "light_fixture.h"

#define SIDE 4.0f

typedef struct flat_square {
    world *w;
    rsv_elements *elements;
    rsv_rgb *value;
    uint8_t *marked; ///< [cell_count]
} flat_square;

static float node_x(const rsv_elements *e, uint32_t node)
{
    uint32_t support = e->support[e->support_begin[node]];
    const rsv_cell *cell = &e->cell[support / 4];
    float u, v;
    rsv_cell_corner(cell, (int)(support % 4), &u, &v);
    uint32_t face = cell->face;
    return rsv_surface_point_at(e->scene, e->face_triangle[face], u, v, e->face_back[face])
        .position.x;
}

/// A square in which x runs from 0 to SIDE, with values field(x).
static flat_square create_square(float (*field)(float x))
{
    static const rsv_vec3 corner[] = { { 0, 0, 0 }, { SIDE, 0, 0 }, { SIDE, SIDE, 0 },
        { 0, SIDE, 0 } };
    static const uint32_t index[] = { 0, 1, 2, 0, 2, 3 };
    flat_square s = { .w = world_begin(1) };
    world_triangles(s.w, world_lambert(s.w, 0.5f, 0), corner, 4, index, 2);
    world_commit(s.w);
    assert_int_equal(
        rsv_elements_create(s.w->scene, s.w->bsdf, &(rsv_spacing){ .metres = 0.5f }, &s.elements),
        RSV_OK);
    s.value = calloc(s.elements->node_count, sizeof *s.value);
    s.marked = calloc(s.elements->cell_count, 1);
    assert_non_null(s.value);
    assert_non_null(s.marked);
    for (uint32_t n = 0; n < s.elements->node_count; n++)
        s.value[n] = rgb_gray(field(node_x(s.elements, n)));
    return s;
}

static void destroy_square(flat_square *s)
{
    free(s->value);
    free(s->marked);
    rsv_elements_destroy(s->elements);
    world_end(s->w);
}

static void mark(void *user, uint32_t cell, uint32_t other, float curvature)
{
    (void)curvature;
    uint8_t *marked = user;
    marked[cell] = marked[other] = 1;
}

/// Marks cells and returns the range of x that they cover; false if there are none.
static bool find(
    flat_square *s, const float *deviation, rsv_curved_edges places, float *low, float *high)
{
    memset(s->marked, 0, s->elements->cell_count);
    const rsv_curvature_field field = { s->value, deviation, 0.2f, 0.01f, NULL };
    assert_int_equal(rsv_find_curved_edges(s->elements, &field, places, mark, s->marked), RSV_OK);
    *low = SIDE, *high = 0;
    bool any = false;
    for (size_t c = 0; c < s->elements->cell_count; c++)
        for (int k = 0; s->marked[c] && k < 3; k++) {
            float x = node_x(s->elements, s->elements->cell_node[c][k]);
            *low = fminf(*low, x), *high = fmaxf(*high, x);
            any = true;
        }
    return any;
}

static float ramp(float x) { return 1 + x; }
static float shadow_edge(float x) { return x < SIDE / 2 ? 1 : 0.2f; }
static float corner_power(float x) { return sqrtf(x); }

static void planes_have_no_curvature(void **state)
{
    (void)state;
    flat_square s = create_square(ramp);
    float low, high;
    assert_false(find(&s, NULL, RSV_CURVED_EDGES, &low, &high));
    destroy_square(&s);
}

static void shadow_edges_curve_where_they_are(void **state)
{
    (void)state;
    flat_square s = create_square(shadow_edge);
    float low, high;
    assert_true(find(&s, NULL, RSV_CURVED_EDGES, &low, &high));
    assert_true(low >= SIDE / 2 - 1.1f && high <= SIDE / 2 + 1.1f);
    assert_true(low < SIDE / 2 && high >= SIDE / 2);
    destroy_square(&s);
}

static void noise_is_no_curvature(void **state)
{
    (void)state;
    flat_square s = create_square(shadow_edge);
    float *deviation = calloc(s.elements->node_count, sizeof *deviation), low, high;
    assert_non_null(deviation);
    for (size_t n = 0; n < s.elements->node_count; n++)
        deviation[n] = 0.5f;
    assert_false(find(&s, deviation, RSV_CURVED_EDGES_AND_BORDERS, &low, &high));
    free(deviation);
    destroy_square(&s);
}

/// x^(1/2): steepest in the last cell before the border, where no inner edge can tell.
static void falls_towards_a_border_are_found(void **state)
{
    (void)state;
    flat_square s = create_square(corner_power);
    float low, high;
    assert_true(find(&s, NULL, RSV_CURVED_EDGES_AND_BORDERS, &low, &high));
    assert_true(low == 0 && high <= SIDE / 2);
    destroy_square(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_have_no_curvature),
        cmocka_unit_test(shadow_edges_curve_where_they_are),
        cmocka_unit_test(noise_is_no_curvature),
        cmocka_unit_test(falls_towards_a_border_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
