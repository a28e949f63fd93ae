#include "baked_values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Light below this share of the mean is dark: relative errors there are invisible.
#define DARK 0.05
/// Share of that below which no light comes to a place.
#define BURIED 0.01
/// An error that is seen.
#define OFF 0.05
#define NOISE_DEVIATIONS 3
/// Median of the absolute value of a normal variable of deviation 1.
#define MEDIAN_OF_NORMAL 0.6745
#define WINDOW_PART 8 ///< fewer paths
#define SIDE CLI_WINDOW_SIDE

static uint32_t hash(uint32_t a, uint32_t b)
{
    uint64_t x = ((uint64_t)a << 32 | b) * 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 29) * 0xbf58476d1ce4e5b9u;
    return (uint32_t)(x >> 32);
}

static double luminance(rsv_rgb c)
{
    return 0.2126 * (double)c.r + 0.7152 * (double)c.g + 0.0722 * (double)c.b;
}

// ---- during the bake ------------------------------------------------------------------------------

static bool is_drawn(uint32_t a, uint32_t b, double chance)
{
    return (double)hash(a, b) < chance * 4294967296.0;
}

static bool is_in_window(const cli_baked_values *v, const uint32_t at[2], const uint32_t size[2])
{
    double windows = ceil(size[0] / (double)SIDE) * ceil(size[1] / (double)SIDE);
    return size[1] > 1 && is_drawn(at[0] / SIDE, 0x10000 + at[1] / SIDE, v->window_count / windows);
}

static bool wants(void *user, const uint32_t at[2], const uint32_t size[2])
{
    const cli_baked_values *v = user;
    return is_drawn(at[0], at[1], v->random_count / ((double)size[0] * size[1])) ||
           is_in_window(v, at, size);
}

static bool grow(void **array, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity) return true;
    size_t wanted = count > 2 * *capacity ? count : 2 * *capacity;
    void *grown = realloc(*array, wanted * size);
    if (!grown) return false;
    *array = grown;
    *capacity = wanted;
    return true;
}

static void take(void *user, const rsv_bake_value *value)
{
    cli_baked_values *v = user;
    size_t places = v->place_count + value->place_count;
    if (value->translucent || value->place_count == 0) return;
    if (!grow((void **)&v->value, &v->capacity, v->count + 1, sizeof *v->value) ||
        !grow((void **)&v->place, &v->place_capacity, places, sizeof *v->place)) {
        v->exhausted = true;
        return;
    }
    memcpy(v->place + v->place_count, value->place, value->place_count * sizeof *v->place);
    v->value[v->count++] = (cli_baked_value){ .at = { value->at[0], value->at[1] },
        .light = value->irradiance,
        .first = v->place_count,
        .place_count = value->place_count };
    v->place_count = places;
}

rsv_bake_visitor cli_baked_values_visitor(cli_baked_values *v)
{
    return (rsv_bake_visitor){ v, wants, take };
}

void cli_baked_values_free(cli_baked_values *v)
{
    free(v->value);
    free(v->place);
}

// ---- path tracing ---------------------------------------------------------------------------------

/// Windows are where more than a few values lie side by side: the others are at random.
static void find_windows(cli_baked_values *v)
{
    for (size_t k = 0; k < v->count; k++) {
        uint32_t side = 0;
        for (size_t n = k > SIDE ? k - SIDE : 0; n < v->count && n < k + SIDE; n++)
            side += v->value[n].at[1] == v->value[k].at[1] &&
                    v->value[n].at[0] / SIDE == v->value[k].at[0] / SIDE;
        v->value[k].in_window = side > 2;
    }
}

/// Path traces the values of windows or the others.
static rsv_status trace(const rsv_scene *scene, cli_baked_values *v, bool windows, uint32_t paths)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_surface_place *place = malloc((v->place_count + 1) * sizeof *place);
    rsv_probe_reading *reading = calloc(v->place_count + 1, sizeof *reading);
    size_t count = 0, places_of_one = 1;
    for (size_t k = 0; place && k < v->count; k++) {
        if (v->value[k].in_window != windows) continue;
        memcpy(
            place + count, v->place + v->value[k].first, v->value[k].place_count * sizeof *place);
        count += v->value[k].place_count;
        if (v->value[k].place_count > places_of_one) places_of_one = v->value[k].place_count;
    }
    uint32_t of_one = paths / (uint32_t)places_of_one;
    if (place && reading)
        status = count == 0 ? RSV_OK
                            : rsv_surface_reference(
                                  scene, place, count, of_one ? of_one : 1, 0x51ed27, reading);
    count = 0;
    for (size_t k = 0; status == RSV_OK && k < v->count; k++) {
        cli_baked_value *value = &v->value[k];
        if (value->in_window != windows) continue;
        double sum = 0, squares = 0, n = value->place_count;
        for (uint32_t p = 0; p < value->place_count; p++, count++) {
            double deviation = luminance(reading[count].standard_error);
            sum += luminance(reading[count].irradiance);
            squares += deviation * deviation;
        }
        value->reference = sum / n;
        value->deviation = sqrt(squares) / n;
    }
    free(place);
    free(reading);
    return status;
}

// ---- judging --------------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double percentile(const double *sorted, size_t count, double share)
{
    return count ? sorted[(size_t)(share * (double)(count - 1) + 0.5)] : NAN;
}

static bool is_buried(const cli_baked_value *value, double dark)
{
    return value->reference < BURIED * dark;
}

static rsv_status judge_random(const cli_baked_values *v, double dark, cli_bake_judgement *j)
{
    double *error = malloc((v->count + 1) * sizeof *error),
           *noise = malloc((v->count + 1) * sizeof *noise), baked = 0, traced = 0;
    size_t count = 0;
    for (size_t k = 0; error && noise && k < v->count; k++) {
        const cli_baked_value *value = &v->value[k];
        if (value->in_window) continue;
        if (is_buried(value, dark)) {
            j->buried++;
            continue;
        }
        double least = fmax(value->reference, dark);
        baked += luminance(value->light);
        traced += value->reference;
        error[count] = fabs(luminance(value->light) - value->reference) / least;
        noise[count++] = MEDIAN_OF_NORMAL * value->deviation / least;
    }
    rsv_status status = error && noise ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) {
        qsort(error, count, sizeof *error, compare);
        qsort(noise, count, sizeof *noise, compare);
        j->values = count;
        j->median = percentile(error, count, 0.5);
        j->ninety = percentile(error, count, 0.9);
        j->ninety_nine = percentile(error, count, 0.99);
        j->noise = percentile(noise, count, 0.5);
        j->mean_ratio = baked / traced;
    }
    free(error);
    free(noise);
    return status;
}

/// A window of texels; the others count as none.
typedef struct window {
    double light[SIDE][SIDE], reference[SIDE][SIDE], variance[SIDE][SIDE];
    bool known[SIDE][SIDE], off[SIDE][SIDE];
} window;

/// Whether a texel's neighbourhood is off by more than noise explains.
static bool is_off(const window *w, int x, int y, double dark)
{
    double light = 0, reference = 0, variance = 0, count = 0;
    for (int b = y - 1; b <= y + 1; b++)
        for (int a = x - 1; a <= x + 1; a++) {
            if (a < 0 || b < 0 || a >= SIDE || b >= SIDE || !w->known[b][a]) continue;
            light += w->light[b][a];
            reference += w->reference[b][a];
            variance += w->variance[b][a];
            count++;
        }
    double least = fmax(reference, dark * count);
    return w->known[y][x] &&
           fabs(light - reference) > OFF * least + NOISE_DEVIATIONS * sqrt(variance);
}

/// Texels of a connected part, which it clears.
static size_t clear_part(window *w, int x, int y)
{
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE || !w->off[y][x]) return 0;
    w->off[y][x] = false;
    return 1 + clear_part(w, x - 1, y) + clear_part(w, x + 1, y) + clear_part(w, x, y - 1) +
           clear_part(w, x, y + 1);
}

static size_t largest_part(window *w, double dark)
{
    size_t largest = 0;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            w->off[y][x] = is_off(w, x, y, dark);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            size_t part = clear_part(w, x, y);
            if (part > largest) largest = part;
        }
    return largest;
}

static void judge_windows(const cli_baked_values *v, double dark, cli_bake_judgement *j)
{
    for (size_t k = 0; k < v->count; k++) {
        const cli_baked_value *first = &v->value[k];
        window w = { .known = { { false } } };
        bool begins = first->in_window;
        for (size_t n = 0; n < v->count && begins; n++) {
            const cli_baked_value *value = &v->value[n];
            if (!value->in_window || is_buried(value, dark) ||
                value->at[0] / SIDE != first->at[0] / SIDE ||
                value->at[1] / SIDE != first->at[1] / SIDE)
                continue;
            begins = n >= k; // once for each window
            uint32_t x = value->at[0] % SIDE, y = value->at[1] % SIDE;
            w.light[y][x] = luminance(value->light);
            w.reference[y][x] = value->reference;
            w.variance[y][x] = value->deviation * value->deviation;
            w.known[y][x] = true;
        }
        size_t part = begins ? largest_part(&w, dark) : 0;
        if (part > j->blotch) j->blotch = part;
    }
}

rsv_status cli_judge_baked_values(
    const rsv_scene *scene, cli_baked_values *v, uint32_t paths, cli_bake_judgement *j)
{
    *j = (cli_bake_judgement){ 0 };
    find_windows(v);
    rsv_status status = v->exhausted ? RSV_ERROR_MEMORY : trace(scene, v, false, paths);
    if (status == RSV_OK) status = trace(scene, v, true, paths / WINDOW_PART);
    double mean = 0;
    for (size_t k = 0; k < v->count; k++)
        mean += v->value[k].reference / (double)v->count;
    if (status == RSV_OK) status = judge_random(v, DARK * mean, j);
    if (status == RSV_OK) judge_windows(v, DARK * mean, j);
    return status;
}
