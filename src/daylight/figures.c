#include "figures.h"

#include <string.h>

#define GROUPS RSV_DAYLIGHT_GROUPS
#define AUTONOMY 300.0 ///< lux
#define SUN 1000.0     ///< lux
#define MOST_SUN_HOURS 250.0

static const rsv_figure_facts sensor_facts[RSV_SENSOR_FIGURES] = {
    [RSV_SENSOR_MEAN] = { "mean", "lux", "mean illuminance, all hours" },
    [RSV_SENSOR_OCCUPIED_MEAN] = { "occupied_mean", "lux", "mean illuminance, occupied hours" },
    [RSV_SENSOR_DA] = { "da", "1", "daylight autonomy, 300 lux" },
    [RSV_SENSOR_CDA] = { "cda", "1", "continuous daylight autonomy, 300 lux" },
    [RSV_SENSOR_UDI_BELOW] = { "udi_below", "1", "useful daylight, below 100 lux" },
    [RSV_SENSOR_UDI_SUPPLEMENTARY] = { "udi_supplementary", "1",
        "useful daylight, 100 to 300 lux" },
    [RSV_SENSOR_UDI_AUTONOMOUS] = { "udi_autonomous", "1", "useful daylight, 300 to 3000 lux" },
    [RSV_SENSOR_UDI_EXCEEDED] = { "udi_exceeded", "1", "useful daylight, above 3000 lux" },
    [RSV_SENSOR_SUN_HOURS] = { "sun_hours", "h", "hours with 1000 lux of direct sun" },
    [RSV_SENSOR_DAYLIGHT_FACTOR] = { "daylight_factor", "1", "daylight factor" },
    [RSV_SENSOR_MEDIAN] = { "median", "lux", "exceeded in half of the daylight hours" },
};

static const rsv_figure_facts space_facts[RSV_SPACE_FIGURES] = {
    [RSV_SPACE_MEAN] = { "mean", "lux", "mean illuminance, all hours" },
    [RSV_SPACE_SDA] = { "sda_300_50", "1", "sDA 300/50 %" },
    [RSV_SPACE_ASE] = { "ase_1000_250", "1", "ASE 1000, 250 h" },
    [RSV_SPACE_DA] = { "da", "1", "mean daylight autonomy, 300 lux" },
    [RSV_SPACE_CDA] = { "cda", "1", "mean continuous daylight autonomy" },
    [RSV_SPACE_UDI_AUTONOMOUS] = { "udi_autonomous", "1", "mean useful daylight, 300 to 3000 lux" },
    [RSV_SPACE_DAYLIGHT_FACTOR] = { "daylight_factor", "1", "mean daylight factor" },
    [RSV_SPACE_MEDIAN_DAYLIGHT_FACTOR] = { "median_daylight_factor", "1",
        "median daylight factor" },
    [RSV_SPACE_TARGET] = { "target", "lux", "EN 17037 target, half of the space" },
    [RSV_SPACE_MINIMUM] = { "minimum", "lux", "EN 17037 minimum target, 95 % of the space" },
};

rsv_figure_facts rsv_sensor_figure_facts(rsv_sensor_figure figure)
{
    return figure < RSV_SENSOR_FIGURES ? sensor_facts[figure] : (rsv_figure_facts){ 0 };
}

rsv_figure_facts rsv_space_figure_facts(rsv_space_figure figure)
{
    return figure < RSV_SPACE_FIGURES ? space_facts[figure] : (rsv_figure_facts){ 0 };
}

int rsv_daylight_class(double target, double minimum)
{
    return target >= 750 && minimum >= 500   ? 3
           : target >= 500 && minimum >= 300 ? 2
           : target >= 300 && minimum >= 100 ? 1
                                             : 0;
}

int rsv_daylight_class_rooflit(double minimum)
{
    return minimum >= 750 ? 3 : minimum >= 500 ? 2 : minimum >= 300 ? 1 : 0;
}

float rsv_variant_reading(
    const float reading[RSV_DAYLIGHT_COLUMNS], int variant, double stored_error)
{
    float sum = 0;
    for (int g = 0; g < GROUPS; g++)
        sum += reading[g];
    if (variant < GROUPS) return (sum - reading[variant]) / (GROUPS - 1);
    float shift = variant == RSV_VARIANT_SHIFTED ? (float)stored_error * reading[GROUPS] : 0;
    return sum / GROUPS + shift;
}

rsv_figure rsv_figure_of(const double *variant, size_t step)
{
    double mean = 0, squares = 0, all = variant[RSV_VARIANT_ALL * step];
    for (size_t g = 0; g < GROUPS; g++)
        mean += variant[g * step] / GROUPS;
    for (size_t g = 0; g < GROUPS; g++)
        squares += (variant[g * step] - mean) * (variant[g * step] - mean);
    if (squares < 1e-20 * (1 + mean * mean)) squares = 0; // rounding
    double shift = variant[RSV_VARIANT_SHIFTED * step] - all;
    return (rsv_figure){ all, sqrt(squares * (GROUPS - 1) / GROUPS + shift * shift) };
}

/// The value of that rank, counted from 0 for the largest (Hoare's selection). Reorders the values.
static float select_largest(float *value, size_t count, size_t rank)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        float pivot = value[low + (high - low) / 2];
        size_t i = low, j = high;
        for (;;) {
            while (value[i] > pivot)
                i++;
            while (value[j] < pivot)
                j--;
            if (i >= j) break;
            float swap = value[i];
            value[i++] = value[j];
            value[j--] = swap;
        }
        if (rank <= j)
            high = j;
        else
            low = j + 1;
    }
    return value[rank];
}

/// The value that a fraction `share` of the values reach.
static double reached_by(float *value, size_t count, double share)
{
    if (count == 0) return 0;
    size_t rank = (size_t)ceil(share * (double)count - 1e-9);
    return (double)select_largest(value, count, rank > 0 ? rank - 1 : 0);
}

/// Adds an hour to the sums of a variant.
static void add_hour(const rsv_lit_hour *hour, double lux, double straight, double *sum)
{
    double h = hour->hours;
    sum[RSV_SENSOR_MEAN] += h * lux;
    if (!hour->occupied) return;
    sum[RSV_SENSOR_OCCUPIED_MEAN] += h * lux;
    sum[RSV_SENSOR_DA] += lux >= AUTONOMY ? h : 0;
    sum[RSV_SENSOR_CDA] += h * fmin(lux / AUTONOMY, 1);
    sum[RSV_SENSOR_UDI_SUPPLEMENTARY] += lux >= 100 && lux < AUTONOMY ? h : 0;
    sum[RSV_SENSOR_UDI_AUTONOMOUS] += lux >= AUTONOMY && lux <= 3000 ? h : 0;
    sum[RSV_SENSOR_UDI_EXCEEDED] += lux > 3000 ? h : 0;
    sum[RSV_SENSOR_SUN_HOURS] += straight >= SUN ? h : 0;
}

/// From sums over hours to means and shares.
static void finish_sums(const rsv_year *year, double *sum)
{
    double hours = fmax(year->hours, 1e-9), occupied = fmax(year->occupied_hours, 1e-9);
    sum[RSV_SENSOR_MEAN] /= hours;
    for (int k = RSV_SENSOR_OCCUPIED_MEAN; k <= RSV_SENSOR_UDI_EXCEEDED; k++)
        sum[k] /= occupied;
    sum[RSV_SENSOR_UDI_BELOW] = 1 - sum[RSV_SENSOR_UDI_SUPPLEMENTARY] -
                                sum[RSV_SENSOR_UDI_AUTONOMOUS] - sum[RSV_SENSOR_UDI_EXCEEDED];
    if (year->occupied_hours <= 0) sum[RSV_SENSOR_UDI_BELOW] = 0;
}

static void read_variant(
    const rsv_year *year, const rsv_sensor_readings *r, int variant, double *figure)
{
    size_t daylight = 0;
    memset(figure, 0, RSV_SENSOR_FIGURES * sizeof *figure);
    for (size_t k = 0; k < year->lit_count; k++) {
        const rsv_lit_hour *hour = &year->lit[k];
        float lux = rsv_variant_reading(r->reading[k], variant, r->stored_error);
        add_hour(hour, (double)lux, (double)r->sun[k], figure);
        if (hour->daylight) r->value[daylight++] = lux;
    }
    for (; daylight < year->daylight_count; daylight++)
        r->value[daylight] = 0;
    finish_sums(year, figure);
    figure[RSV_SENSOR_MEDIAN] = reached_by(r->value, year->daylight_count, 0.5);
}

/// Under the traditional overcast sky, by the illuminance outdoors.
static void read_overcast(const rsv_daylight *d, size_t sensor, float reading[RSV_DAYLIGHT_COLUMNS])
{
    const rsv_patch_share *share = d->all + sensor * d->patches.count;
    rsv_sky_shape shape = rsv_cie_sky(RSV_CIE_TRADITIONAL_OVERCAST, v3(0, 1, 0));
    double sum = 0;
    for (int c = 0; c < RSV_DAYLIGHT_COLUMNS; c++)
        reading[c] = d->desc.ground_albedo / RSV_PI * share[0].column[c];
    for (uint32_t p = 1; p < d->patches.count; p++) {
        rsv_vec3 direction = rsv_sky_patch_direction(&d->patches, p);
        sum += rsv_sky_shape_at(&shape, direction) * rsv_sky_patch_solid_angle(&d->patches, p) *
               (double)direction.y;
    }
    for (uint32_t p = 1; p < d->patches.count; p++) {
        double l = rsv_sky_shape_at(&shape, rsv_sky_patch_direction(&d->patches, p)) / sum;
        for (int c = 0; c < RSV_DAYLIGHT_COLUMNS; c++)
            reading[c] += (float)l * share[p].column[c];
    }
}

void rsv_sensor_figures(const rsv_daylight *d, const rsv_year *year, size_t sensor,
    const rsv_sensor_readings *readings, rsv_sensor_variants figures)
{
    float overcast[RSV_DAYLIGHT_COLUMNS];
    read_overcast(d, sensor, overcast);
    for (int v = 0; v < RSV_VARIANTS; v++) {
        read_variant(year, readings, v, figures[v]);
        figures[v][RSV_SENSOR_DAYLIGHT_FACTOR] =
            (double)rsv_variant_reading(overcast, v, readings->stored_error);
    }
}

// ---- all sensors together -------------------------------------------------------------------------

static double mean_of(
    const rsv_sensor_variants *figures, size_t count, int variant, rsv_sensor_figure figure)
{
    double sum = 0;
    for (size_t s = 0; s < count; s++)
        sum += figures[s][variant][figure];
    return sum / (double)count;
}

static double level_of(const rsv_sensor_variants *figures, size_t count, int variant,
    rsv_sensor_figure figure, double share, float *value)
{
    for (size_t s = 0; s < count; s++)
        value[s] = (float)figures[s][variant][figure];
    return reached_by(value, count, share);
}

static void read_space(const rsv_sensor_variants *figures, size_t count, int v, float *value,
    double space[RSV_SPACE_FIGURES])
{
    double autonomous = 0, sunny = 0;
    for (size_t s = 0; s < count; s++) {
        autonomous += figures[s][v][RSV_SENSOR_DA] >= 0.5;
        sunny += figures[s][v][RSV_SENSOR_SUN_HOURS] > MOST_SUN_HOURS;
    }
    space[RSV_SPACE_SDA] = autonomous / (double)count;
    space[RSV_SPACE_ASE] = sunny / (double)count;
    space[RSV_SPACE_MEAN] = mean_of(figures, count, v, RSV_SENSOR_MEAN);
    space[RSV_SPACE_DA] = mean_of(figures, count, v, RSV_SENSOR_DA);
    space[RSV_SPACE_CDA] = mean_of(figures, count, v, RSV_SENSOR_CDA);
    space[RSV_SPACE_UDI_AUTONOMOUS] = mean_of(figures, count, v, RSV_SENSOR_UDI_AUTONOMOUS);
    space[RSV_SPACE_DAYLIGHT_FACTOR] = mean_of(figures, count, v, RSV_SENSOR_DAYLIGHT_FACTOR);
    space[RSV_SPACE_MEDIAN_DAYLIGHT_FACTOR] =
        level_of(figures, count, v, RSV_SENSOR_DAYLIGHT_FACTOR, 0.5, value);
    space[RSV_SPACE_TARGET] = level_of(figures, count, v, RSV_SENSOR_MEDIAN, 0.5, value);
    space[RSV_SPACE_MINIMUM] = level_of(figures, count, v, RSV_SENSOR_MEDIAN, 0.95, value);
}

void rsv_space_figures(
    const rsv_sensor_variants *figures, size_t count, float *value, rsv_figure *space)
{
    double variant[RSV_VARIANTS][RSV_SPACE_FIGURES];
    for (int v = 0; v < RSV_VARIANTS; v++)
        read_space(figures, count, v, value, variant[v]);
    for (int f = 0; f < RSV_SPACE_FIGURES; f++)
        space[f] = rsv_figure_of(&variant[0][f], RSV_SPACE_FIGURES);
}
