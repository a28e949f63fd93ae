#include "benchmarks.h"
#include "stats.h"

#include "resolvent/frame.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/// Seeds of the reference, unlike any that the measured pictures use.
enum { judge_seed = 1000 };

typedef struct recipe {
    const char *name;
    const char *curve; ///< pictures of one curve are joined in the plot; NULL = not drawn
    rsv_render_mode mode;
    rsv_quality quality; ///< of the solution
    uint32_t samples;
} recipe;

static const recipe recipes[] = {
    { "final, draft", "final", RSV_RENDER_FINAL, RSV_QUALITY_DRAFT, 9 },
    { "final, medium", "final", RSV_RENDER_FINAL, RSV_QUALITY_MEDIUM, 9 },
    { "final, high", "final", RSV_RENDER_FINAL, RSV_QUALITY_HIGH, 9 },
    { "final, medium, 64 spp", NULL, RSV_RENDER_FINAL, RSV_QUALITY_MEDIUM, 64 },
    { "operator, medium, 64 spp", NULL, RSV_RENDER_OPERATOR, RSV_QUALITY_MEDIUM, 64 },
    { "reference, 1 spp", "reference", RSV_RENDER_REFERENCE, 0, 1 },
    { "reference, 4 spp", "reference", RSV_RENDER_REFERENCE, 0, 4 },
    { "reference, 16 spp", "reference", RSV_RENDER_REFERENCE, 0, 16 },
    { "reference, 64 spp", "reference", RSV_RENDER_REFERENCE, 0, 64 },
};
enum { recipe_count = sizeof recipes / sizeof recipes[0] };

/// The reference for the pictures, and its own error.
typedef struct judge {
    rsv_image *half[2], *mean; ///< two independent pictures, and their mean
    double median_error, relative_mse;
} judge;

/// Results of one recipe.
typedef struct outcome {
    double seconds, cpu_seconds;
    rsv_image_difference difference;
    double median_error, relative_mse; ///< without the reference's share
} outcome;

static rsv_status solve_and_render(const cli_bench_task *bench, const rsv_scene *scene,
    const recipe *r, uint32_t seed, rsv_image **image)
{
    rsv_render_desc picture = rsv_default_render_desc();
    picture.mode = r->mode;
    picture.width = picture.height = bench->size;
    picture.samples = r->samples;
    picture.seed = seed;
    if (r->mode == RSV_RENDER_REFERENCE) return rsv_render_reference(scene, &picture, image, NULL);
    rsv_solve_desc desc = cli_bench_solve_desc(bench, r->quality);
    desc.direct_level = r->mode == RSV_RENDER_OPERATOR;
    rsv_light *solution = NULL;
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    bool is_frames = r->mode == RSV_RENDER_OPERATOR;
    if (status == RSV_OK)
        status = is_frames ? rsv_render_operator(solution, &picture, RSV_GLOSS_PATHS, image)
                           : rsv_render(solution, &picture, image);
    rsv_light_destroy(solution);
    return status;
}

/// From the scene's name to the picture in memory.
static bool take_picture(
    const cli_bench_task *bench, const recipe *r, uint32_t seed, rsv_image **image)
{
    rsv_scene *scene = cli_open_scene(bench->session, bench->scene, &bench->environment);
    if (!scene) return false;
    rsv_status status = solve_and_render(bench, scene, r, seed, image);
    rsv_scene_destroy(scene);
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

/// Seconds of all processors together.
static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/// Medians over the repetitions; every repetition makes the same picture.
static bool time_picture(
    const cli_bench_task *bench, const recipe *r, rsv_image **image, outcome *out)
{
    bool taken = true;
    double *seconds = calloc(2 * (size_t)bench->repetitions, sizeof *seconds);
    if (!seconds) return false;
    double *cpu = seconds + bench->repetitions;
    for (uint32_t i = 0; i < bench->repetitions && taken; i++) {
        rsv_image_destroy(*image);
        *image = NULL;
        double started = cli_seconds(), cpu_started = cpu_seconds();
        taken = take_picture(bench, r, rsv_default_render_desc().seed, image);
        seconds[i] = cli_seconds() - started;
        cpu[i] = cpu_seconds() - cpu_started;
    }
    out->seconds = cli_median(seconds, bench->repetitions);
    out->cpu_seconds = cli_median(cpu, bench->repetitions);
    free(seconds);
    return taken;
}

/// One of the independent pictures whose mean is the reference.
static bool judge_picture(
    const cli_bench_task *bench, size_t index, size_t count, rsv_image **image)
{
    if (bench->references.count == 0) {
        recipe r = { .name = "",
            .mode = RSV_RENDER_REFERENCE,
            .samples = bench->reference_samples / (uint32_t)count };
        return take_picture(bench, &r, judge_seed + (uint32_t)index, image);
    }
    rsv_context *context = bench->session->context;
    rsv_status status = rsv_image_read(context, bench->references.item[index], image);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

/// sum += weight * image
static void add_pixels(rsv_image *sum, float weight, const rsv_image *image)
{
    rsv_rgb *to = rsv_image_pixels(sum, 0);
    const rsv_rgb *from = rsv_image_const_pixels(image, 0);
    size_t count = (size_t)rsv_image_width(sum) * rsv_image_height(sum);
    for (size_t i = 0; i < count; i++) {
        to[i].r += weight * from[i].r;
        to[i].g += weight * from[i].g;
        to[i].b += weight * from[i].b;
    }
}

/// Adds the pictures alternately to two halves, each scaled to a picture of its own, and to their mean.
static bool gather_halves(const cli_bench_task *bench, size_t count, judge *j)
{
    for (size_t i = 0; i < count; i++) {
        rsv_image *picture = NULL;
        if (!judge_picture(bench, i, count, &picture)) return false;
        bool fits =
            rsv_image_width(picture) == bench->size && rsv_image_height(picture) == bench->size;
        if (fits) {
            add_pixels(j->half[i % 2], 2.0f / (float)count, picture);
            add_pixels(j->mean, 1.0f / (float)count, picture);
        } else {
            cli_error("%s: a reference must have %u x %u pixels", bench->references.item[i],
                bench->size, bench->size);
        }
        rsv_image_destroy(picture);
        if (!fits) return false;
    }
    return true;
}

static rsv_status judge_by(const judge *j, const rsv_image *image, rsv_image_judgement *judgement)
{
    return rsv_image_judge(
        (const rsv_image *const *)j->half, (const uint32_t[2]){ 0, 0 }, image, 0, judgement);
}

/// The reference is the mean of two independent halves; half their difference is its own error.
static bool make_judge(const cli_bench_task *bench, judge *j)
{
    size_t count = bench->references.count ? bench->references.count : 2;
    rsv_image **const image[3] = { &j->half[0], &j->half[1], &j->mean };
    rsv_image_difference apart;
    rsv_image_judgement own;
    rsv_status status = RSV_OK;
    for (int i = 0; i < 3 && status == RSV_OK; i++)
        status = rsv_image_create(bench->session->context, bench->size, bench->size, 1, image[i]);
    if (status == RSV_OK && !gather_halves(bench, count, j)) return false;
    if (status == RSV_OK) status = rsv_image_compare(j->half[0], 0, j->half[1], 0, &apart);
    if (status == RSV_OK) status = judge_by(j, j->mean, &own);
    if (status != RSV_OK) {
        cli_report_failure(bench->session, status);
        return false;
    }
    j->median_error = apart.median_relative_error / 2;
    j->relative_mse = own.reference_mse;
    return true;
}

static void release_judge(judge *j)
{
    rsv_image_destroy(j->half[0]);
    rsv_image_destroy(j->half[1]);
    rsv_image_destroy(j->mean);
}

/// Squares of independent errors add; a difference below a hundredth of what was measured is not significant.
static double square_without(double own, double measured)
{
    return fmax(fmax(measured - own, 0.01 * measured), 1e-12);
}

static bool measure(const cli_bench_task *bench, const judge *j, const recipe *r, outcome *out)
{
    rsv_image *image = NULL;
    rsv_image_judgement judgement = { 0 };
    bool measured = time_picture(bench, r, &image, out);
    if (measured) {
        rsv_status status = rsv_image_compare(j->mean, 0, image, 0, &out->difference);
        if (status == RSV_OK) status = judge_by(j, image, &judgement);
        if (status != RSV_OK) cli_report_failure(bench->session, status);
        measured = status == RSV_OK;
    }
    rsv_image_destroy(image);
    double median = out->difference.median_relative_error;
    out->median_error = sqrt(square_without(j->median_error * j->median_error, median * median));
    // an error below its own standard error is not significant
    out->relative_mse = fmax(judgement.relative_mse, judgement.relative_mse_error);
    return measured;
}

/// Seconds after which the reference mode would have as small a square error, which falls as 1 / time.
static double reference_seconds(const outcome *longest, double square, double square_of_longest)
{
    return longest->seconds * square_of_longest / square;
}

static cJSON *describe(const recipe *r, const outcome *out, const outcome *longest)
{
    cJSON *point = cJSON_CreateObject();
    cJSON_AddStringToObject(point, "name", r->name);
    static const char *const modes[] = { [RSV_RENDER_REFERENCE] = "reference",
        [RSV_RENDER_FINAL] = "final",
        [RSV_RENDER_OPERATOR] = "operator" };
    cJSON_AddStringToObject(point, "mode", modes[r->mode]);
    if (r->curve) cJSON_AddStringToObject(point, "curve", r->curve);
    cJSON_AddNumberToObject(point, "spp", r->samples);
    cJSON_AddNumberToObject(point, "seconds", out->seconds);
    cJSON_AddNumberToObject(point, "cpu_seconds", out->cpu_seconds);
    cJSON_AddNumberToObject(point, "median_relative_error", out->difference.median_relative_error);
    cJSON_AddNumberToObject(point, "error_without_reference", out->median_error);
    cJSON_AddNumberToObject(point, "relative_mse", out->difference.relative_mse);
    cJSON_AddNumberToObject(point, "mean_ratio", out->difference.mean_ratio);
    double as_good = reference_seconds(longest, out->median_error * out->median_error,
        longest->median_error * longest->median_error);
    cJSON_AddNumberToObject(point, "reference_seconds", as_good);
    cJSON_AddNumberToObject(point, "time_factor", as_good / out->seconds);
    double as_clean = reference_seconds(longest, out->relative_mse, longest->relative_mse);
    cJSON_AddNumberToObject(point, "mse_without_reference", out->relative_mse);
    cJSON_AddNumberToObject(point, "mse_time_factor", as_clean / out->seconds);
    return point;
}

static bool is_asked_for(const recipe *r, const cli_bench_task *bench)
{
    return (int)r->quality <= bench->quality;
}

bool cli_bench_quality(const cli_bench_task *bench, cJSON *result)
{
    judge j = { 0 };
    outcome outcomes[recipe_count] = { 0 };
    bool measured = make_judge(bench, &j);
    for (size_t i = 0; i < recipe_count && measured; i++)
        measured =
            !is_asked_for(&recipes[i], bench) || measure(bench, &j, &recipes[i], &outcomes[i]);
    release_judge(&j);
    if (!measured) return false;
    cJSON *reference = cJSON_AddObjectToObject(result, "reference");
    cJSON_AddNumberToObject(reference, "median_relative_error", j.median_error);
    cJSON_AddNumberToObject(reference, "relative_mse", j.relative_mse);
    cJSON *points = cJSON_AddArrayToObject(result, "points");
    for (size_t i = 0; i < recipe_count; i++)
        if (is_asked_for(&recipes[i], bench))
            cJSON_AddItemToArray(
                points, describe(&recipes[i], &outcomes[i], &outcomes[recipe_count - 1]));
    return true;
}

static void print_point(const cJSON *point)
{
    printf("  %-24s %8.3g %8.3g %8.3g %% %8.3g %% %8.3g %10.3g %8.3g %9.4f\n",
        cJSON_GetStringValue(cJSON_GetObjectItem(point, "name")), cli_json_number(point, "seconds"),
        cli_json_number(point, "cpu_seconds"),
        100 * cli_json_number(point, "median_relative_error"),
        100 * cli_json_number(point, "error_without_reference"),
        cli_json_number(point, "time_factor"), cli_json_number(point, "mse_without_reference"),
        cli_json_number(point, "mse_time_factor"), cli_json_number(point, "mean_ratio"));
}

void cli_print_quality(const cJSON *result)
{
    const cJSON *reference = cJSON_GetObjectItem(result, "reference"), *point;
    printf("  the reference's own median error is %.3g %%, its relative MSE %.3g\n",
        100 * cli_json_number(reference, "median_relative_error"),
        cli_json_number(reference, "relative_mse"));
    printf("  %-24s %8s %8s %10s %10s %8s %10s %8s %9s\n", "picture", "time s", "cpu s", "median",
        "corrected", "factor", "rel. MSE", "factor", "mean");
    cJSON_ArrayForEach(point, cJSON_GetObjectItem(result, "points")) print_point(point);
}
