/// Certificates of random rooms compared with path-traced truth, at every quality.
#include "resolvent/certify.h"
#include "resolvent/solve.h"
#include "unit/random_scene.h"
#include "unit/scene_fixture.h"
#include "unit/slow_tests.h"

#include <math.h>
#include <stdlib.h>

#define PATHS 256
/// Largest factor between an estimate and the truth, beyond the truth's own uncertainty.
#define FACTOR 1.25

/// Results of a sweep.
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

/// How hard to look.
typedef struct effort {
    int qualities;   ///< that many of them, draft first
    uint32_t points; ///< of the truth
    uint32_t seed;   ///< of solutions, certificates and truth
    rsv_certify_desc certify;
} effort;

static verdict judge(const rsv_scene *scene, rsv_quality quality, const effort *by)
{
    rsv_solve_desc desc = rsv_default_solve_desc(quality);
    rsv_certify_desc certify = by->certify;
    verdict v;
    rsv_light *light;
    rsv_truth *truth;
    desc.seed = by->seed;
    certify.seed = by->seed + 7;
    assert_int_equal(rsv_light_create(scene, &desc, &light), RSV_OK);
    assert_int_equal(rsv_certify(light, &certify, &v.certificate), RSV_OK);
    assert_int_equal(rsv_truth_create(light, by->points, PATHS, by->seed + 5, &truth), RSV_OK);
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

static void say(const char *name, int quality, const verdict *v)
{
    const rsv_certificate *c = &v->certificate;
    double percent = 100 / fmax(c->irradiance_rms, 1e-30);
    print_message("%s, quality %d: true error %.2f (%.2f .. %.2f) %%, estimate %.2f (%.2f .. "
                  "%.2f), bound %.1f, amplified %.1f, %u points%s\n",
        name, quality, percent * v->error, percent * v->interval[0], percent * v->interval[1],
        percent * c->error_estimate_rms, percent * c->error_estimate_ci95[0],
        percent * c->error_estimate_ci95[1], percent * c->error_bound_rms, c->amplification,
        c->samples, is_close(v) ? "" : " FAR");
}

/// @param scene taken over
static void check_scene(rsv_scene *scene, const char *name, const effort *by, tally *t)
{
    double before = INFINITY;
    bool falls = true;
    for (int quality = 0; quality < by->qualities; quality++) {
        verdict v = judge(scene, (rsv_quality)quality, by);
        say(name, quality, &v);
        count(t, &v);
        falls = falls && v.certificate.error_estimate_ci95[0] <= before;
        before = v.certificate.error_estimate_ci95[1];
    }
    rsv_scene_destroy(scene);
    t->rooms++;
    t->falling += falls;
}

static void check_room(fixture *f, uint32_t seed, const effort *by, tally *t)
{
    rsv_scene *scene;
    char name[32];
    snprintf(name, sizeof name, "room %u", seed);
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    assert_int_equal(random_room(scene, seed), RSV_OK);
    check_scene(scene, name, by, t);
}

static tally check_rooms(fixture *f, uint32_t first, uint32_t number, const effort *by)
{
    tally t = { 0 };
    for (uint32_t k = 0; k < number; k++)
        check_room(f, first + k, by, &t);
    print_message("%u cases: %u close, %u covered, %u bounded; %u of %u rooms fall\n", t.cases,
        t.close, t.covered, t.bounded, t.falling, t.rooms);
    return t;
}

static void certificates_of_rooms_are_true(void **state)
{
    const effort by = { 1, 256, 0, rsv_brief_certify_desc() };
    tally t = check_rooms(*state, 3, 1, &by);
    assert_int_equal(t.covered, t.cases);
    assert_int_equal(t.bounded, t.cases);
}

static void certificates_of_many_rooms_are_true(void **state)
{
    const effort by = { 3, 400, 0, rsv_brief_certify_desc() };
    tally t = check_rooms(*state, 0, 30, &by);
    assert_true(6 * t.close >= 5 * t.cases);
    assert_true(20 * t.covered >= 19 * t.cases);
    assert_int_equal(t.bounded, t.cases);
    assert_int_equal(t.falling, t.rooms);
}

/// Points in contact, under frames and behind them, are judged alike at every quality.
static void certificates_of_a_gallery_fall_with_quality(void **state)
{
    fixture *f = *state;
    tally t = { 0 };
    for (uint32_t seed = 0; seed < 3; seed++) {
        effort by = { 0, 400, seed, rsv_default_certify_desc() };
        rsv_scene *scene;
        verdict v[2];
        assert_int_equal(rsv_scene_builtin(f->context, "gallery:1", &scene), RSV_OK);
        for (int quality = 0; quality < 2; quality++) {
            v[quality] = judge(scene, (rsv_quality)quality, &by);
            say("gallery:1", quality, &v[quality]);
            count(&t, &v[quality]);
        }
        assert_true(v[1].certificate.error_estimate_rms < v[0].certificate.error_estimate_rms);
        rsv_scene_destroy(scene);
    }
    assert_int_equal(t.covered, t.cases);
    assert_int_equal(t.bounded, t.cases);
}

/// `rooms FIRST COUNT QUALITIES POINTS SAMPLES` or `scene NAME SEEDS QUALITIES POINTS SAMPLES`: runs only these, and
/// continues after failures.
static int look_at(char **argv)
{
    void *state = NULL;
    effort by = { atoi(argv[3]), (uint32_t)atoi(argv[4]), 0, rsv_default_certify_desc() };
    by.certify.samples = (uint32_t)atoi(argv[5]);
    fixture_setup(&state);
    fixture *f = state;
    if (strcmp(argv[0], "rooms") == 0)
        check_rooms(f, (uint32_t)atoi(argv[1]), (uint32_t)atoi(argv[2]), &by);
    for (; strcmp(argv[0], "scene") == 0 && (int)by.seed < atoi(argv[2]); by.seed++) {
        rsv_scene *scene;
        tally t = { 0 };
        assert_int_equal(rsv_scene_builtin(f->context, argv[1], &scene), RSV_OK);
        check_scene(scene, argv[1], &by, &t);
    }
    return fixture_teardown(&state);
}

#define ROOM_TEST(test) cmocka_unit_test_setup_teardown(test, fixture_setup, fixture_teardown)

int main(int argc, char **argv)
{
    if (argc == 7) return look_at(argv + 1);
    const struct CMUnitTest quick[] = { ROOM_TEST(certificates_of_rooms_are_true) };
    const struct CMUnitTest longest[] = { ROOM_TEST(certificates_of_a_gallery_fall_with_quality),
        ROOM_TEST(certificates_of_many_rooms_are_true) };
    return argc > 1 && strcmp(argv[1], "long") == 0 ? cmocka_run_group_tests(longest, NULL, NULL)
                                                    : cmocka_run_group_tests(quick, NULL, NULL);
}
