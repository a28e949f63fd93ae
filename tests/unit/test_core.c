#include "core/core.h"
#include "core/sampling.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- context, errors, memory ----

/// An allocator that can be told to fail, and what the callbacks saw.
typedef struct witness {
    bool out_of_memory;
    int live_allocations;
    char message[256];
    double fraction;
    bool cancel;
} witness;

static void *witness_allocate(void *user, size_t bytes)
{
    witness *seen = user;
    if (seen->out_of_memory) return NULL;
    seen->live_allocations++;
    void *memory = aligned_alloc(64, bytes);
    if (memory) memset(memory, 0xa5, bytes);
    return memory;
}

static void witness_release(void *user, void *memory)
{
    ((witness *)user)->live_allocations--;
    free(memory);
}

static void witness_log(void *user, rsv_log_level level, const char *message)
{
    (void)level;
    strncpy(((witness *)user)->message, message, sizeof((witness *)user)->message - 1);
}

static bool witness_progress(void *user, const char *phase, double fraction)
{
    (void)phase;
    ((witness *)user)->fraction = fraction;
    return !((witness *)user)->cancel;
}

static rsv_context *create_context(witness *seen)
{
    rsv_context_desc desc = { .size = sizeof desc,
        .thread_count = 3,
        .log = witness_log,
        .progress = witness_progress,
        .allocate = witness_allocate,
        .release = witness_release,
        .user = seen };
    rsv_context *context = NULL;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_OK);
    return context;
}

static void context_refuses_what_it_cannot_honour(void **state)
{
    (void)state;
    rsv_context *context = NULL;
    witness seen = { .out_of_memory = true };
    rsv_context_desc desc = rsv_default_context_desc();
    desc.allocate = witness_allocate;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_ERROR_ARGUMENT);
    desc.release = witness_release;
    desc.user = &seen;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_ERROR_MEMORY);
    desc = rsv_default_context_desc();
    desc.thread_count = -1;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_ERROR_ARGUMENT);
    assert_non_null(strstr(rsv_last_error(), "-1"));
    assert_null(context);
    rsv_context_destroy(NULL);
}

static void default_context_uses_every_processor(void **state)
{
    (void)state;
    rsv_context *context;
    assert_int_equal(rsv_context_create(NULL, &context), RSV_OK);
    assert_true(rsv_threads(context) >= 1);
    rsv_log(context, RSV_LOG_WARNING, "nobody listens");
    rsv_context_destroy(context);
    assert_true(strlen(rsv_version()) >= 5);
}

static void messages_are_one_line(void **state)
{
    (void)state;
    witness seen = { 0 };
    rsv_context *context = create_context(&seen);
    assert_int_equal(rsv_fail(RSV_ERROR_IO, "node '%s'", "a\nb\tc"), RSV_ERROR_IO);
    assert_string_equal(rsv_last_error(), "node 'a b c'");
    rsv_log(context, RSV_LOG_INFO, "%d\r\n", 7);
    assert_string_equal(seen.message, "7  ");
    rsv_context_destroy(context);
}

static void every_thread_has_its_own_error(void **state)
{
    (void)state;
    int wrong = 0;
#pragma omp parallel for num_threads(4) schedule(static, 1) reduction(+ : wrong)
    for (int i = 0; i < 4; i++) {
        char expected[32];
        snprintf(expected, sizeof expected, "error %d", i);
        rsv_fail(RSV_ERROR_IO, "%s", expected);
        wrong += strcmp(rsv_last_error(), expected) != 0;
    }
    assert_int_equal(wrong, 0);
}

static void allocations_are_zeroed_and_aligned(void **state)
{
    (void)state;
    witness seen = { 0 };
    rsv_context *context = create_context(&seen);
    for (size_t count = 0; count < 200; count += 7) {
        uint32_t *array = rsv_alloc(context, count, sizeof *array);
        assert_non_null(array);
        assert_int_equal((uintptr_t)array % 64, 0);
        for (size_t i = 0; i < count; i++)
            assert_int_equal(array[i], 0);
        rsv_free(context, array);
    }
    rsv_free(context, NULL);
    rsv_context_destroy(context);
    assert_int_equal(seen.live_allocations, 0);
}

static void sizes_that_overflow_are_out_of_memory(void **state)
{
    (void)state;
    witness seen = { 0 };
    rsv_context *context = create_context(&seen);
    assert_null(rsv_alloc(context, SIZE_MAX / 2, 3));
    assert_non_null(strstr(rsv_last_error(), "cannot be addressed"));
    assert_null(rsv_alloc(context, SIZE_MAX, 1));
    assert_null(rsv_alloc(context, SIZE_MAX / 8, 8));
    seen.out_of_memory = true;
    assert_null(rsv_alloc(context, 1, 1));
    assert_null(rsv_copy_string(context, "text"));
    rsv_context_destroy(context);
    assert_int_equal(seen.live_allocations, 0);
}

static void growing_keeps_the_content(void **state)
{
    (void)state;
    witness seen = { 0 };
    rsv_context *context = create_context(&seen);
    int *array = NULL;
    size_t capacity = 0;
    for (int i = 0; i < 1000; i++) {
        assert_int_equal(
            rsv_grow(context, (void **)&array, &capacity, (size_t)i + 1, sizeof *array), RSV_OK);
        array[i] = i;
    }
    for (int i = 0; i < 1000; i++)
        assert_int_equal(array[i], i);
    seen.out_of_memory = true;
    assert_int_equal(rsv_grow(context, (void **)&array, &capacity, capacity + 1, sizeof *array),
        RSV_ERROR_MEMORY);
    assert_int_equal(array[999], 999);
    rsv_free(context, array);
    rsv_context_destroy(context);
    assert_int_equal(seen.live_allocations, 0);
}

static void strings_are_copied(void **state)
{
    (void)state;
    witness seen = { 0 };
    rsv_context *context = create_context(&seen);
    char *name = rsv_copy_string(context, "floor"), *none = rsv_copy_string(context, NULL);
    assert_string_equal(name, "floor");
    assert_string_equal(none, "");
    rsv_free(context, name);
    rsv_free(context, none);
    rsv_context_destroy(context);
}

static void progress_and_cancel_stop_the_work(void **state)
{
    (void)state;
    witness seen = { 0 };
    rsv_context *context = create_context(&seen);
    assert_int_equal(rsv_threads(context), 3);
    assert_int_equal(rsv_progress(context, "assemble", 0.25), RSV_OK);
    assert_true(seen.fraction == 0.25 && !rsv_cancelled(context));
    seen.cancel = true;
    assert_int_equal(rsv_progress(context, "assemble", 0.5), RSV_ERROR_CANCELLED);
    assert_non_null(strstr(rsv_last_error(), "assemble"));
    assert_true(rsv_cancelled(context));
    rsv_context_destroy(context);

    context = create_context(&seen);
    seen.cancel = false;
    rsv_context_cancel(context);
    assert_int_equal(rsv_progress(context, "render", 0), RSV_ERROR_CANCELLED);
    rsv_context_destroy(context);
}

// ---- random and quasi-random numbers ----

/// Whether each box of width 2^-k and height 2^-(m - k) holds one of the first 2^m points.
static bool is_stratified(uint32_t seed, int m, int k)
{
    uint32_t count = 1u << m;
    bool *filled = calloc(count, sizeof *filled);
    bool stratified = true;
    for (uint32_t i = 0; i < count; i++) {
        float x, y;
        rsv_sobol_2d(i, seed, &x, &y);
        uint32_t column = (uint32_t)ldexpf(x, k), row = (uint32_t)ldexpf(y, m - k);
        uint32_t box = row << k | column;
        stratified = stratified && x < 1 && y < 1 && !filled[box];
        filled[box] = true;
    }
    free(filled);
    return stratified;
}

static void every_power_of_two_of_sobol_points_is_stratified(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 20; seed++)
        for (int m = 0; m <= 12; m++)
            for (int k = 0; k <= m; k++)
                assert_true(is_stratified(seed * 0x9e3779b9u, m, k));
}

static void sobol_seeds_are_independent(void **state)
{
    (void)state;
    // the sample mean over seeds of one point's product x y' must be E[x] E[y'] = 1/4
    double sum = 0;
    const int seeds = 20000;
    for (int seed = 0; seed < seeds; seed++) {
        float x, y, other_x, other_y;
        rsv_sobol_2d(5, (uint32_t)seed, &x, &y);
        rsv_sobol_2d(5, (uint32_t)seed + 1, &other_x, &other_y);
        sum += x * other_x;
    }
    // variance of a product of two uniforms: 1/9 - 1/16 = 0.0486
    assert_float_equal(sum / seeds, 0.25, 5 * sqrt(0.0486 / seeds));
}

static void generator_is_uniform_and_reproducible(void **state)
{
    (void)state;
    rsv_random a = rsv_random_from(1, 2, 3), b = rsv_random_from(1, 2, 3);
    int counts[64] = { 0 };
    const int draws = 64 * 4096;
    for (int i = 0; i < draws; i++) {
        float u = rsv_random_float(&a);
        assert_true(u >= 0 && u < 1 && u == rsv_random_float(&b));
        counts[(int)(64 * u)]++;
    }
    double chi_squared = 0;
    for (int i = 0; i < 64; i++)
        chi_squared += (counts[i] - 4096.0) * (counts[i] - 4096.0) / 4096;
    assert_in_range((int)chi_squared, 30, 114); // 63 degrees of freedom: 1e-4 on either side
    rsv_random other = rsv_random_from(1, 2, 4);
    assert_int_not_equal(rsv_random_bits(&other), rsv_random_bits(&a));
}

static void unit_floats_stay_below_one(void **state)
{
    (void)state;
    assert_true(rsv_unit_float(0) == 0);
    assert_true(rsv_unit_float(UINT32_MAX) < 1);
    assert_int_equal(rsv_reverse_bits(1), 0x80000000u);
    assert_int_equal(rsv_reverse_bits(0x12345678u), 0x1e6a2c48u);
}

// ---- warps ----

#define BINS 8
#define WARP_POINTS 65536

/// Maps a point of the unit square through a warp and back to coordinates in [0, 1] x [0, 1] in
/// which its density should be constant.
typedef void (*warp_test)(float x, float y, double *u, double *v);

/// Stratified points fill each of the equal-area bins with its share of 1024, but for those near a
/// border: about 4 sqrt(1024) = 128 of them, each on either side by chance, so 11 / 2 is one
/// standard deviation.
static void check_uniform(warp_test warp)
{
    int counts[BINS][BINS] = { { 0 } };
    for (uint32_t i = 0; i < WARP_POINTS; i++) {
        float x, y;
        double u, v;
        rsv_sobol_2d(i, 17, &x, &y);
        warp(x, y, &u, &v);
        assert_true(u > -1e-5 && u < 1 + 1e-5 && v > -1e-5 && v < 1 + 1e-5);
        int column = (int)(BINS * u), row = (int)(BINS * v);
        counts[row > 7 ? 7 : row][column > 7 ? 7 : column]++;
    }
    for (int i = 0; i < BINS * BINS; i++)
        assert_in_range(counts[i / BINS][i % BINS], 1024 - 32, 1024 + 32);
}

static double turn(double x, double y) { return atan2(y, x) / (2 * 3.14159265358979) + 0.5; }

static void warp_to_disk(float x, float y, double *u, double *v)
{
    float dx, dy;
    rsv_square_to_disk(x, y, &dx, &dy);
    *u = dx * dx + dy * dy; // area within a radius
    *v = turn(dx, dy);
}

static void warp_to_cosine_hemisphere(float x, float y, double *u, double *v)
{
    rsv_vec3 direction = rsv_square_to_cosine_hemisphere(x, y);
    assert_float_equal(v3_length(direction), 1, 1e-5);
    assert_true(direction.z > 0);
    *u = direction.z * direction.z; // probability of lying below: integral of 2 z dz
    *v = turn(direction.x, direction.y);
}

static void warp_to_sphere(float x, float y, double *u, double *v)
{
    rsv_vec3 direction = rsv_square_to_sphere(x, y);
    assert_float_equal(v3_length(direction), 1, 1e-5);
    *u = 0.5 * (direction.z + 1); // Archimedes
    *v = turn(direction.x, direction.y);
}

static void warp_to_triangle(float x, float y, double *u, double *v)
{
    float b, c;
    rsv_square_to_triangle(x, y, &b, &c);
    assert_true(b >= 0 && c >= 0 && b + c <= 1);
    double near = b + c; // the part of the triangle nearer to corner 0 has area (b + c)^2
    *u = near * near;
    *v = near > 0 ? c / near : 0;
}

static void warps_are_uniform(void **state)
{
    (void)state;
    check_uniform(warp_to_disk);
    check_uniform(warp_to_cosine_hemisphere);
    check_uniform(warp_to_sphere);
    check_uniform(warp_to_triangle);
}

static void disk_warp_reaches_centre_and_rim(void **state)
{
    (void)state;
    float dx, dy;
    rsv_square_to_disk(0.5f, 0.5f, &dx, &dy);
    assert_true(dx == 0 && dy == 0);
    for (int i = 0; i <= 16; i++) {
        rsv_square_to_disk(0, (float)i / 16, &dx, &dy);
        assert_float_equal(dx * dx + dy * dy, 1, 1e-6);
    }
}

static void frames_are_orthonormal_and_right_handed(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 4096; i++) {
        float x, y;
        rsv_sobol_2d(i, 3, &x, &y);
        rsv_vec3 n = i == 0 ? v3(0, 0, -1) : rsv_square_to_sphere(x, y), t, b;
        v3_frame(n, &t, &b);
        assert_float_equal(v3_dot(t, b), 0, 1e-6);
        assert_float_equal(v3_length(t), 1, 1e-6);
        assert_float_equal(v3_length(b), 1, 1e-6);
        assert_float_equal(v3_dot(v3_cross(t, b), n), 1, 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(context_refuses_what_it_cannot_honour),
        cmocka_unit_test(default_context_uses_every_processor),
        cmocka_unit_test(messages_are_one_line),
        cmocka_unit_test(every_thread_has_its_own_error),
        cmocka_unit_test(allocations_are_zeroed_and_aligned),
        cmocka_unit_test(sizes_that_overflow_are_out_of_memory),
        cmocka_unit_test(growing_keeps_the_content),
        cmocka_unit_test(strings_are_copied),
        cmocka_unit_test(progress_and_cancel_stop_the_work),
        cmocka_unit_test(every_power_of_two_of_sobol_points_is_stratified),
        cmocka_unit_test(sobol_seeds_are_independent),
        cmocka_unit_test(generator_is_uniform_and_reproducible),
        cmocka_unit_test(unit_floats_stay_below_one),
        cmocka_unit_test(warps_are_uniform),
        cmocka_unit_test(disk_warp_reaches_centre_and_rim),
        cmocka_unit_test(frames_are_orthonormal_and_right_handed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
