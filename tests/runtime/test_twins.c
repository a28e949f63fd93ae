/// The runtime's arithmetic: SIMD against its scalar twin bit by bit, and against answers known in closed form. Without
/// a test framework, so that it also runs cross-compiled.
#include "resolvent_rt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

rsv_rt_status scalar_relight(const rsv_rt_basis *basis, const float *scale, uint32_t scale_count,
    uint32_t first, uint32_t count, float *out);
void scalar_solver_begin(
    rsv_rt_solver *solver, const rsv_rt_operator *transport, float *irradiance, float *exitance);
uint64_t scalar_solver_update(rsv_rt_solver *solver, const float *direct, uint64_t operations);

enum { ELEMENTS = 203, ROW = 37, TINTED = 5, LIGHTS = 5, RECEIVERS = 1001, HANGING = 3 };

static int failures;

static void check(int condition, const char *what)
{
    if (!condition) printf("FAILED: %s\n", what);
    failures += !condition;
}

static int is_near(double a, double b, double tolerance)
{
    return a - b <= tolerance && b - a <= tolerance;
}

static uint32_t state = 1;

static uint32_t random_below(uint32_t bound)
{
    state = state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)state * bound >> 32);
}

static float random_unit(void) { return (float)random_below(1u << 24) / (float)(1u << 24); }

static float *random_floats(size_t count)
{
    float *value = malloc(count * sizeof *value);
    for (size_t k = 0; value && k < count; k++)
        value[k] = random_unit();
    return value;
}

// ---- basis ----------------------------------------------------------------------------------------

static void both_twins_relight_alike(void)
{
    static float out[2][RECEIVERS * 3];
    float scale[3 * LIGHTS];
    float *value = random_floats((size_t)LIGHTS * RECEIVERS * 3);
    const rsv_rt_basis basis = { LIGHTS, RECEIVERS, 1, value };
    for (int k = 0; k < 3 * LIGHTS; k++)
        scale[k] = 10 * random_unit();
    check(rsv_rt_relight(&basis, scale, LIGHTS, 0, RECEIVERS, out[0]) == RSV_RT_OK, "relight");
    for (uint32_t first = 0; first < RECEIVERS; first += 77) { // other ranges, the same bits
        uint32_t count = RECEIVERS - first < 77 ? RECEIVERS - first : 77;
        check(scalar_relight(&basis, scale, LIGHTS, first, count, out[1]) == RSV_RT_OK, "twin");
    }
    check(memcmp(out[0], out[1], sizeof out[0]) == 0, "the twins relight differently");
    for (size_t k = 0; k < RECEIVERS * 3; k++) {
        double sum = 0;
        for (size_t l = 0; l < LIGHTS; l++)
            sum += (double)value[l * RECEIVERS * 3 + k] * scale[3 * l + k % 3];
        check(is_near(out[0][k], sum, 1e-5 * sum), "relight is not the sum of its lights");
    }
    check(rsv_rt_relight(&basis, scale, LIGHTS - 1, 0, 1, out[0]) == RSV_RT_LIGHT_COUNT, "lights");
    check(rsv_rt_relight(&basis, scale, LIGHTS, 1, RECEIVERS, out[0]) == RSV_RT_RANGE, "range");
    free(value);
}

/// For any turn, the two neighbouring angles share the light; whole turns change nothing.
static void a_turning_sky_goes_from_angle_to_angle(void)
{
    const float color[3] = { 1, 2, 0.5f }, turn[] = { 0, 0.25f, 0.3125f, -0.0625f, 3.25f, 1e30f };
    const int before[] = { 0, 1, 1, 3, 1, 0 };
    const double share[] = { 0, 0, 0.25, 0.75, 0, 0 };
    float scale[12];
    for (size_t t = 0; t < sizeof turn / sizeof turn[0]; t++) {
        int after = (before[t] + 1) % 4;
        rsv_rt_turn(turn[t], color, 4, scale);
        for (int k = 0; k < 12; k++) {
            double expected = k / 3 == before[t] ? 1 - share[t] : k / 3 == after ? share[t] : 0;
            check(is_near(scale[k], expected * (double)color[k % 3], 1e-6), "a turn of the sky");
        }
    }
}

// ---- operator -------------------------------------------------------------------------------------

typedef struct random_operator {
    rsv_rt_operator transport;
    uint64_t row_start[ELEMENTS + 1], tinted_row_start[ELEMENTS + 1];
    uint32_t column[ELEMENTS * ROW], tinted_column[ELEMENTS * TINTED];
    float tinted_weight[ELEMENTS * TINTED * 3], scale[ELEMENTS], albedo[ELEMENTS * 3];
    uint32_t hanging_node[HANGING], hanging_parent[HANGING * 4];
    float hanging_weight[HANGING * 4];
} random_operator;

/// Rows that sum to 1, some of them with tinted entries of weight 1. The last elements are hanging.
static void fill(random_operator *o, float albedo)
{
    for (uint32_t row = 0; row <= ELEMENTS; row++) {
        o->row_start[row] = (uint64_t)row * ROW;
        o->tinted_row_start[row] = (uint64_t)row * TINTED;
    }
    for (uint32_t k = 0; k < ELEMENTS * ROW; k++)
        o->column[k] = random_below(ELEMENTS);
    for (uint32_t k = 0; k < ELEMENTS * TINTED; k++)
        o->tinted_column[k] = random_below(ELEMENTS);
    for (uint32_t k = 0; k < ELEMENTS * TINTED * 3; k++)
        o->tinted_weight[k] = 1;
    for (uint32_t n = 0; n < ELEMENTS; n++) {
        o->scale[n] = n < ELEMENTS - HANGING ? 1.0f / (ROW + TINTED) : 0;
        o->albedo[3 * n] = o->albedo[3 * n + 1] = o->albedo[3 * n + 2] = albedo;
    }
    for (uint32_t k = 0; k < HANGING; k++) {
        o->hanging_node[k] = ELEMENTS - HANGING + k;
        for (uint32_t p = 0; p < 4; p++) {
            o->hanging_parent[4 * k + p] = p + k;
            o->hanging_weight[4 * k + p] = 0.25f;
        }
    }
    o->transport = (rsv_rt_operator){ ELEMENTS, o->row_start, o->column, o->scale,
        o->tinted_row_start, o->tinted_column, o->tinted_weight, o->albedo, HANGING,
        o->hanging_node, o->hanging_parent, o->hanging_weight };
}

static rsv_rt_status check_operator(const random_operator *o, uint64_t entries)
{
    uint8_t scratch[ELEMENTS];
    return rsv_rt_operator_check(&o->transport, entries, ELEMENTS * TINTED, scratch);
}

static int tick(void *user) { return --*(int *)user > 0; }

/// A closed furnace: with rows of sum 1, E = E0 / (1 - albedo) everywhere.
static void furnace_fills_up_within_budgets(void)
{
    static random_operator o;
    static float irradiance[2][ELEMENTS * 3], exitance[2][ELEMENTS * 4], direct[ELEMENTS * 3];
    rsv_rt_solver simd, scalar;
    uint64_t used = 0;
    int ticks = 1000000;
    fill(&o, 0.75f);
    for (int k = 0; k < ELEMENTS * 3; k++)
        direct[k] = 1;
    check(check_operator(&o, ELEMENTS * ROW) == RSV_RT_OK, "a sound operator is refused");
    rsv_rt_solver_begin(&simd, &o.transport, irradiance[0], exitance[0]);
    scalar_solver_begin(&scalar, &o.transport, irradiance[1], exitance[1]);
    for (int frame = 0; frame < 500; frame++) {
        uint64_t now = rsv_rt_solver_update(&simd, direct, 999);
        check(now >= 999 && now < 999 + ROW + TINTED + 1 + 4 * HANGING, "beyond the budget");
        used += now;
    }
    scalar_solver_update(&scalar, direct, used);
    check(memcmp(irradiance[0], irradiance[1], sizeof irradiance[0]) == 0,
        "the twins solve differently");
    check(rsv_rt_solver_update_while(&simd, direct, 1e-5f, 500, tick, &ticks) == 1, "no rest");
    for (int k = 0; k < ELEMENTS * 3; k++)
        check(is_near(irradiance[0][k], 4, 4e-4), "a furnace of albedo 3/4 shows E = 4 E0");
    ticks = 3;
    direct[0] = 2;
    check(rsv_rt_solver_update_while(&simd, direct, 0, 10, tick, &ticks) == 0, "no budget kept");
}

static void damaged_operators_are_refused(void)
{
    static random_operator o;
    const uint64_t entries = ELEMENTS * ROW;
    float zero = 0;
    fill(&o, 0.5f);
    check(check_operator(&o, entries - 1) == RSV_RT_ROWS, "entries");
    o.row_start[7] = entries + 1;
    check(check_operator(&o, entries) == RSV_RT_ROWS, "rows");
    fill(&o, 0.5f);
    o.column[11] = ELEMENTS;
    check(check_operator(&o, entries) == RSV_RT_INDEX, "columns");
    fill(&o, 0.5f);
    o.hanging_parent[2] = ELEMENTS;
    check(check_operator(&o, entries) == RSV_RT_INDEX, "parents");
    fill(&o, 0.5f);
    o.albedo[4] = 0 / zero;
    check(check_operator(&o, entries) == RSV_RT_NUMBER, "numbers");
    fill(&o, 2);
    check(check_operator(&o, entries) == RSV_RT_ENERGY, "albedo 2");
    fill(&o, -0.5f);
    check(check_operator(&o, entries) == RSV_RT_ENERGY, "albedo below 0");
    fill(&o, 1.07f); // white under gloss, whose rows find less than all light
    check(check_operator(&o, entries) == RSV_RT_OK, "albedo of what entered");
}

/// A hanging element may only depend on elements before it.
static void parents_come_first(void)
{
    static random_operator o;
    const uint64_t entries = ELEMENTS * ROW;
    uint32_t first = ELEMENTS - HANGING;
    fill(&o, 0.5f);
    o.hanging_parent[4 * 2] = first;
    check(check_operator(&o, entries) == RSV_RT_OK, "a parent that hangs, but earlier");
    o.hanging_parent[4 * 0] = first + 2;
    check(check_operator(&o, entries) == RSV_RT_ORDER, "parents of each other");
    o.hanging_weight[4 * 0] = 0;
    check(check_operator(&o, entries) == RSV_RT_OK, "a parent that counts for nothing");
    fill(&o, 0.5f);
    o.hanging_parent[1] = first;
    check(check_operator(&o, entries) == RSV_RT_ORDER, "a parent of itself");
    fill(&o, 0.5f);
    o.hanging_node[1] = first;
    check(check_operator(&o, entries) == RSV_RT_ORDER, "an element that hangs twice");
}

/// If the engine passes NaN or infinity for one update, that counts as no light, and the solver does not report that it
/// has converged.
static void what_is_not_finite_does_not_stay(void)
{
    static random_operator o;
    static float irradiance[2][ELEMENTS * 3], exitance[2][ELEMENTS * 4], direct[ELEMENTS * 3];
    const float zero = 0, wrong[] = { 0 / zero, 1 / zero, -1 / zero, 3e38f };
    rsv_rt_solver simd, scalar;
    fill(&o, 0.5f);
    for (size_t k = 0; k < ELEMENTS * 3; k++) {
        direct[k] = 1;
        irradiance[0][k] = irradiance[1][k] = wrong[k % 2];
    }
    rsv_rt_solver_begin(&simd, &o.transport, irradiance[0], exitance[0]);
    scalar_solver_begin(&scalar, &o.transport, irradiance[1], exitance[1]);
    for (size_t w = 0; w < sizeof wrong / sizeof wrong[0]; w++) {
        rsv_rt_solver_update(&simd, direct, 1000000);
        scalar_solver_update(&scalar, direct, 1000000);
        check(simd.change <= 1e-6f, "no rest before");
        for (size_t k = w; k < ELEMENTS * 3; k += 1 + w * w)
            direct[k] = wrong[w];
        rsv_rt_solver_update(&simd, direct, 20000);
        scalar_solver_update(&scalar, direct, 20000);
        check(simd.change > 1e30f, "what is not finite passes for rest");
        for (size_t k = 0; k < ELEMENTS * 3; k++)
            direct[k] = 1;
        rsv_rt_solver_update(&simd, direct, 1000000);
        scalar_solver_update(&scalar, direct, 1000000);
        check(memcmp(irradiance[0], irradiance[1], sizeof irradiance[0]) == 0,
            "the twins mend differently");
        for (int k = 0; k < ELEMENTS * 3; k++)
            check(is_near(irradiance[0][k], 2, 1e-4), "what was not finite stays");
    }
}

static void receivers_mix_three_elements(void)
{
    const uint32_t element[] = { 0, 1, 2, 2, 2, 1 };
    const float weight[] = { 0.5f, 0.25f, 0.25f, 1, 0, 0 }, field[] = { 4, 0, 0, 0, 8, 0, 0, 0, 2 };
    const rsv_rt_receivers receivers = { 2, element, weight };
    float out[6] = { 0 };
    check(rsv_rt_receivers_check(&receivers, 3) == RSV_RT_OK, "receivers");
    check(rsv_rt_receivers_check(&receivers, 2) == RSV_RT_INDEX, "receivers beyond the elements");
    check(rsv_rt_receive(&receivers, field, 0, 2, out) == RSV_RT_OK, "receive");
    check(out[0] == 2 && out[1] == 2 && out[2] == 0.5f && out[5] == 2, "means of three");
    check(rsv_rt_receive(&receivers, field, 2, 1, out) == RSV_RT_RANGE, "range of receivers");
}

// ---- probes ---------------------------------------------------------------------------------------

/// Constant radiance 1 gives pi; radiance max(0, cos) about z gives 2 pi / 3 on top.
static void probes_give_irradiance(void)
{
    float probe[8][RSV_RT_SH_COUNT][3] = { 0 }, sh[RSV_RT_SH_COUNT * 3], irradiance[3];
    uint8_t valid[8] = { 1, 1, 1, 1, 1, 1, 1, 0 };
    const float up[3] = { 0, 0, 1 }, corner[3] = { 9, 9, 9 }, middle[3] = { 1, 1, 1 };
    rsv_rt_probe_grid grid = { { 2, 2, 2 }, { 0, 0, 0 }, { 2, 2, 2 }, valid };
    for (int p = 0; p < 8; p++)
        probe[p][0][0] = 3.5449077f; // 1 / 0.2820948: radiance 1
    check(rsv_rt_probe_at(&grid, &probe[0][0][0], middle, sh) == RSV_RT_OK, "probe");
    rsv_rt_sh_irradiance(sh, up, irradiance);
    check(is_near(irradiance[0], 3.14159265, 1e-5), "constant radiance 1 is irradiance pi");
    check(irradiance[1] == 0, "no green light");
    check(rsv_rt_probe_at(&grid, &probe[0][0][0], corner, sh) == RSV_RT_NO_PROBE, "no probe");
    check(sh[0] == 0, "a probe inside a wall counts for nothing");
    memset(probe, 0, sizeof probe);
    for (int p = 0; p < 8; p++) { // projections of max(0, cos): orders 0, 1 and 2
        probe[p][0][0] = 0.88622693f;
        probe[p][2][0] = 1.02332671f;
        probe[p][6][0] = 0.49541592f;
    }
    rsv_rt_probe_at(&grid, &probe[0][0][0], middle, sh);
    rsv_rt_sh_irradiance(sh, up, irradiance);
    check(is_near(irradiance[0], 2.0943951, 0.02), "a cosine lobe is irradiance 2 pi / 3");
    grid.size[1] = 0;
    check(rsv_rt_probe_at(&grid, &probe[0][0][0], middle, sh) == RSV_RT_GRID, "an empty grid");
}

int main(void)
{
    both_twins_relight_alike();
    a_turning_sky_goes_from_angle_to_angle();
    furnace_fills_up_within_budgets();
    damaged_operators_are_refused();
    parents_come_first();
    what_is_not_finite_does_not_stay();
    receivers_mix_three_elements();
    probes_give_irradiance();
    if (!failures) printf("all passed\n");
    return failures != 0;
}
