/// Certificates of random rooms beside path-traced truth, at every quality.
#include "resolvent/certify.h"
#include "resolvent/solve.h"
#include "unit/random_scene.h"
#include "unit/scene_fixture.h"
#include "unit/slow_tests.h"

#include <math.h>
#include <stdlib.h>

#define PATHS 256
/// Estimates may be wrong by this factor, beyond what truth itself is uncertain by.
#define FACTOR 1.25

/// What a sweep has found.
typedef struct tally {
    uint32_t rooms, cases;
    uint32_t close;   ///< cases whose estimate is within FACTOR of the truth
    uint32_t covered; ///< cases whose interval and that of the truth meet
    uint32_t bounded; ///< cases whose bound is finite, and not below the truth
    uint32_t falling; ///< rooms whose estimate falls with quality
} tally;

/// Truth and certificate of one room at one quality.
typedef struct verdict {
    rsv_certificate certificate;
    double error, interval[2];
} verdict;

static verdict judge(const rsv_scene *scene, rsv_quality quality, uint32_t points)
{
    rsv_solve_desc desc = rsv_default_solve_desc(quality);
    rsv_certify_desc brief = rsv_brief_certify_desc();
    verdict v;
    rsv_light *light;
    rsv_truth *truth;
    brief.seed = 7;
    assert_int_equal(rsv_light_create(scene, &desc, &light), RSV_OK);
    assert_int_equal(rsv_certify(light, &brief, &v.certificate), RSV_OK);
    assert_int_equal(rsv_truth_create(light, points, PATHS, 5, &truth), RSV_OK);
    assert_int_equal(rsv_truth_error(truth, light, &v.error, v.interval), RSV_OK);
    rsv_truth_destroy(truth);
    rsv_light_destroy(light);
    return v;
}

/// Whether the estimate is within FACTOR of what the truth may be.
static bool is_close(const verdict *v)
{
    double estimate = v->certificate.error_estimate_rms;
    return estimate * FACTOR >= v->interval[0] && estimate <= FACTOR * v->interval[1];
}

static void count(tally *t, const verdict *v)
{
    const rsv_certificate *c = &v->certificate;
    t->cases++;
    t->close += is_close(v);
    t->covered +=
        c->error_estimate_ci95[0] <= v->interval[1] && v->interval[0] <= c->error_estimate_ci95[1];
    t->bounded += isfinite(c->error_bound_rms) && v->interval[0] <= c->error_bound_rms;
}

static void say(uint32_t seed, int quality, const verdict *v)
{
    const rsv_certificate *c = &v->certificate;
    double percent = 100 / fmax(c->irradiance_rms, 1e-30);
    print_message("room %u, quality %d: true error %.2f (%.2f .. %.2f) %%, estimate %.2f (%.2f .. "
                  "%.2f), bound %.1f, amplified %.1f, %u points%s\n",
        seed, quality, percent * v->error, percent * v->interval[0], percent * v->interval[1],
        percent * c->error_estimate_rms, percent * c->error_estimate_ci95[0],
        percent * c->error_estimate_ci95[1], percent * c->error_bound_rms, c->amplification,
        c->samples, is_close(v) ? "" : " FAR");
}

static void check_room(fixture *f, uint32_t seed, int qualities, uint32_t points, tally *t)
{
    rsv_scene *scene;
    double before = INFINITY;
    bool falls = true;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    assert_int_equal(random_room(scene, seed), RSV_OK);
    for (int quality = 0; quality < qualities; quality++) {
        verdict v = judge(scene, (rsv_quality)quality, points);
        say(seed, quality, &v);
        count(t, &v);
        falls = falls && v.certificate.error_estimate_ci95[0] <= before;
        before = v.certificate.error_estimate_ci95[1];
    }
    rsv_scene_destroy(scene);
    t->rooms++;
    t->falling += falls;
}

static tally check_rooms(
    fixture *f, uint32_t first, uint32_t number, int qualities, uint32_t points)
{
    tally t = { 0 };
    for (uint32_t k = 0; k < number; k++)
        check_room(f, first + k, qualities, points, &t);
    print_message("%u cases: %u close, %u covered, %u bounded; %u of %u rooms fall\n", t.cases,
        t.close, t.covered, t.bounded, t.falling, t.rooms);
    return t;
}

static void certificates_of_rooms_are_true(void **state)
{
    tally t = check_rooms(*state, 3, 2, 1, 256);
    assert_int_equal(t.covered, t.cases);
    assert_int_equal(t.bounded, t.cases);
}

static void certificates_of_many_rooms_are_true(void **state)
{
    tally t = check_rooms(*state, 0, 30, 3, 400);
    assert_true(6 * t.close >= 5 * t.cases);
    assert_true(20 * t.covered >= 19 * t.cases);
    assert_int_equal(t.bounded, t.cases);
    assert_int_equal(t.falling, t.rooms);
}

/// `rooms FIRST COUNT QUALITIES POINTS`: only these, whatever is wrong with them.
static int look_at_rooms(char **argv)
{
    void *state = NULL;
    fixture_setup(&state);
    check_rooms(state, (uint32_t)atoi(argv[0]), (uint32_t)atoi(argv[1]), atoi(argv[2]),
        (uint32_t)atoi(argv[3]));
    return fixture_teardown(&state);
}

#define ROOM_TEST(test) cmocka_unit_test_setup_teardown(test, fixture_setup, fixture_teardown)

int main(int argc, char **argv)
{
    if (argc == 6 && strcmp(argv[1], "rooms") == 0) return look_at_rooms(argv + 2);
    const struct CMUnitTest quick[] = { ROOM_TEST(certificates_of_rooms_are_true) };
    const struct CMUnitTest longest[] = { ROOM_TEST(certificates_of_many_rooms_are_true) };
    return argc > 1 && strcmp(argv[1], "long") == 0 ? cmocka_run_group_tests(longest, NULL, NULL)
                                                    : cmocka_run_group_tests(quick, NULL, NULL);
}
