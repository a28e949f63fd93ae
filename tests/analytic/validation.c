/// Runs those cases of tests/validation/cases.json that this version supports, and compares.
///
///     test_validation [--reference | --lookup] [CASE_ID_PREFIX]...
///
/// A reading passes if it is within 0.5 % (behind lenses 1 %) of the expected value and within 3 of its own standard
/// errors (pictures in mode operator report none), plus the errors of single precision and, on curved
/// surfaces, of the tessellation. Readings include the noise of their probes but not that of the solution
/// behind them, and a reading may be an outlier. One that fails is therefore repeated with several solutions from other
/// random numbers. Their mean then has to pass, with the error that follows from their spread.
#include "case_file.h"
#include "case_probe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RELATIVE_TOLERANCE 5e-3
/// Tolerance that cases.json recommends for light focused by a lens.
#define CAUSTIC_TOLERANCE 1e-2
/// Two readings in 400 of a right solution lie beyond this many standard errors: Student's t for the 31 degrees of
/// freedom of one reading, and for the 4 of several opinions.
static const double standard_errors[2] = { 3, 5.5 };
/// The errors of single precision: positions and sums are float, and probes are lifted off their surface. Paths that
/// rarely survive Russian roulette may be missing from the sample, and then from its standard error too.
#define ROUNDING 1e-4
/// Facets of 64-gons and of 48 x 96 spheres that have the true area: normals are off by up to 0.033
/// rad, of which the square counts, and distances by 5e-4 of the radius; albedos repeat it.
/// Skies are pictures of 0.35 degrees per pixel, which blurs edges and the core of a disc.
#define TESSELLATION 2e-3
/// Of the largest value of the case, where nothing is expected.
#define ZERO_TOLERANCE 1e-4

static const char *const families[] = { "a.", "b.furnace_box", "b.furnace_object", "b.box_mean",
    "b.sphere_", "c.two_plates", "c.concentric", "c.cube.", "d.", "e.", "f.caustic", "f.interface",
    "f.mirror_", "i.cube_reciprocity", "j.cie5p2", "j.cie5p3", "j.cie5p4", "j.cie5p6", "j.cie5p7",
    "j.cie5p8", "j.cie5p9", "j.cie5p11" };

typedef struct score {
    int passed, failed, cases, skipped_cases, skipped_quantities;
    double largest_relative_error;
} score;

static bool starts_with(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

static bool is_covered(const char *id)
{
    for (size_t i = 0; i < sizeof families / sizeof families[0]; i++)
        if (starts_with(id, families[i])) return true;
    return false;
}

static bool is_wanted(const char *id, char *const *prefixes, int count)
{
    for (int i = 0; i < count; i++)
        if (starts_with(id, prefixes[i])) return true;
    return count == 0;
}

static const char *text(const cJSON *object, const char *name)
{
    const char *value = cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
    return value ? value : "";
}

static double expected_value(const cJSON *expected)
{
    return cJSON_GetNumberValue(cJSON_GetObjectItem(expected, "value"));
}

static double largest_expected(const cJSON *list)
{
    const cJSON *item;
    double largest = 0;
    cJSON_ArrayForEach(item, list) largest = fmax(largest, fabs(expected_value(item)));
    return largest;
}

static bool is_accurate(
    const cJSON *expected, case_reading reading, double largest, double tolerance)
{
    double value = expected_value(expected), error = fabs(reading.value - value);
    if (value == 0) return error <= ZERO_TOLERANCE * largest;
    const cJSON *uncertainty = cJSON_GetObjectItem(expected, "uncertainty");
    double own = cJSON_GetNumberValue(cJSON_GetObjectItem(uncertainty, "abs"));
    return error <= fmax(tolerance * fabs(value), own);
}

static bool is_within_its_error(
    const cJSON *expected, case_reading reading, bool curved, int attempt)
{
    double value = expected_value(expected);
    double systematic = (curved ? TESSELLATION : ROUNDING) * fabs(value);
    return value == 0 || reading.standard_error == 0 ||
           fabs(reading.value - value) <=
               standard_errors[attempt] * reading.standard_error + systematic;
}

static void report(
    const char *id, const cJSON *expected, case_reading reading, bool pass, score *tally)
{
    double value = expected_value(expected), error = reading.value - value;
    double relative = value != 0 ? error / value : 0;
    printf("%-34s %-28s %13.7g %13.7g %+9.4f%% %+7.2f  %s\n", id, text(expected, "name"), value,
        reading.value, 100 * relative,
        reading.standard_error > 0 ? error / reading.standard_error : 0, pass ? "pass" : "FAIL");
    tally->passed += pass;
    tally->failed += !pass;
    tally->largest_relative_error = fmax(tally->largest_relative_error, fabs(relative));
}

/// Mean of several solutions' readings; no error if the readings have none.
static rsv_status read_again(case_bench *bench, const cJSON *expected, case_reading *reading)
{
    double sum = 0, squares = 0, own = reading->standard_error;
    rsv_status status = RSV_OK;
    for (uint32_t k = 1; k <= CASE_OPINIONS && status == RSV_OK; k++) {
        bool known;
        bench->opinion = k;
        status = case_bench_read(bench, expected, reading, &known);
        sum += reading->value;
        squares += reading->value * reading->value;
    }
    bench->opinion = 0;
    double mean = sum / CASE_OPINIONS, variance = fmax(0, squares / CASE_OPINIONS - mean * mean);
    *reading = (case_reading){ mean, own > 0 ? sqrt(variance / (CASE_OPINIONS - 1)) : 0 };
    return status;
}

static void run_quantity(case_bench *bench, const cJSON *item, const cJSON *expected, score *tally)
{
    bool curved =
        strcmp(text(item, "level"), "scene-curved") == 0 || starts_with(text(item, "id"), "e.") ||
        starts_with(text(item, "id"), "j.cie5p9") || starts_with(text(item, "id"), "j.cie5p11");
    bool known = true, pass = false;
    double largest = largest_expected(cJSON_GetObjectItem(item, "expected"));
    bool caustic = starts_with(text(item, "id"), "f.caustic");
    double tolerance = caustic ? CAUSTIC_TOLERANCE : RELATIVE_TOLERANCE;
    case_reading reading;
    rsv_status status = RSV_OK;
    for (int attempt = 0; attempt < 2 && status == RSV_OK && known && !pass; attempt++) {
        status = attempt == 0 ? case_bench_read(bench, expected, &reading, &known)
                              : read_again(bench, expected, &reading);
        pass = is_accurate(expected, reading, largest, tolerance) &&
               is_within_its_error(expected, reading, curved, attempt);
    }
    if (status != RSV_OK) {
        printf("%-34s %s: %s\n", text(item, "id"), text(expected, "name"), rsv_last_error());
        tally->failed++;
    } else if (known) {
        report(text(item, "id"), expected, reading, pass, tally);
    } else {
        tally->skipped_quantities++;
    }
}

static void run_case(rsv_context *context, rsv_probe_mode mode, const cJSON *item, score *tally)
{
    case_bench bench = {
        .context = context, .mode = mode, .expected = cJSON_GetObjectItem(item, "expected")
    };
    bool is_scene =
        starts_with(text(item, "level"), "scene") || starts_with(text(item, "id"), "e.sh");
    const char *problem = is_scene
                              ? case_scene_read(cJSON_GetObjectItem(item, "scene"), &bench.scene)
                              : "not a scene";
    if (problem) {
        printf("%-34s skipped: %s\n", text(item, "id"), problem);
        tally->skipped_cases++;
        return;
    }
    const cJSON *expected;
    cJSON_ArrayForEach(expected, cJSON_GetObjectItem(item, "expected"))
        case_bench_announce(&bench, expected);
    cJSON_ArrayForEach(expected, cJSON_GetObjectItem(item, "expected"))
        run_quantity(&bench, item, expected, tally);
    tally->cases++;
    case_bench_close(&bench);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    rsv_probe_mode mode = RSV_PROBE_OPERATOR;
    if (argc > 1 && strcmp(argv[1], "--reference") == 0) mode = RSV_PROBE_REFERENCE;
    if (argc > 1 && strcmp(argv[1], "--lookup") == 0) mode = RSV_PROBE_LOOKUP;
    int options = mode != RSV_PROBE_OPERATOR, prefix_count = argc - 1 - options;
    char *const *prefixes = argv + 1 + options;
    cJSON *json = case_file_read();
    rsv_context *context;
    if (rsv_context_create(NULL, &context) != RSV_OK) return EXIT_FAILURE;
    score tally = { 0 };
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItem(json, "cases"))
    {
        if (!is_wanted(text(item, "id"), prefixes, prefix_count)) continue;
        if (is_covered(text(item, "id")))
            run_case(context, mode, item, &tally);
        else
            tally.skipped_cases++;
    }
    printf(
        "%d cases, %d quantities: %d passed, %d failed, largest relative error %.3f%%; skipped %d "
        "cases and %d quantities without a probe\n",
        tally.cases, tally.passed + tally.failed, tally.passed, tally.failed,
        100 * tally.largest_relative_error, tally.skipped_cases, tally.skipped_quantities);
    rsv_context_destroy(context);
    cJSON_Delete(json);
    return tally.failed || tally.cases == 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
