/// Mean of e^2 = r^2 + 2 r s + s^2: r at the sampled points, s as other sets than the point's own predict it.
#include "error_field.h"

#define SETS RSV_SAMPLE_SETS

/// Weighted sums over the valid samples of each set, and means over all surfaces.
typedef struct set_sums {
    double weight[SETS];
    double residual[SETS];        ///< of r r', both estimates
    double crossed[SETS][SETS];   ///< of 2 r s: r of the first set, s of the second
    double reflected[SETS][SETS]; ///< area-weighted mean of s s'
} set_sums;

static double luminance(rsv_rgb color) { return (double)rgb_luminance(color); }

static void add_samples(const rsv_light_view *s, const rsv_residual_sample *sample, size_t count,
    const rsv_error_field *field, set_sums *sums)
{
    for (size_t k = 0; k < count; k++) {
        if (!sample[k].valid) continue;
        size_t own = k % SETS;
        double weight = sample[k].weight;
        double a = luminance(sample[k].at.residual[0]), b = luminance(sample[k].at.residual[1]);
        sums->weight[own] += weight;
        sums->residual[own] += weight * a * b;
        for (size_t set = 0; set < SETS; set++)
            if (set != own)
                sums->crossed[own][set] +=
                    weight * (a + b) *
                    luminance(rsv_error_field_at(s, field->reflected[set], &sample[k].point));
    }
}

/// Sums over nodes that are not buried, as samples do.
static void add_nodes(const rsv_light_view *solution, const rsv_error_field *field, set_sums *sums)
{
    const rsv_elements *e = solution->elements;
    double area = 0;
    for (size_t n = 0; n < rsv_elements_surface_nodes(e); n++) {
        if (e->node_hanging[n] == RSV_NONE && !solution->valid_points[n]) continue;
        double s[SETS], own = (double)e->node_area[n];
        for (size_t set = 0; set < SETS; set++)
            s[set] = luminance(field->reflected[set][n]);
        for (size_t a = 0; a < SETS; a++)
            for (size_t b = 0; b < SETS; b++)
                sums->reflected[a][b] += own * s[a] * s[b];
        area += own;
    }
    for (size_t a = 0; a < SETS; a++)
        for (size_t b = 0; b < SETS; b++)
            sums->reflected[a][b] = area > 0 ? sums->reflected[a][b] / area : 0;
}

/// The estimate without one set. @param left_out SETS = none
static double estimate(const set_sums *sums, size_t left_out)
{
    double weight = 0, residual = 0, crossed = 0, partners = 0, reflected = 0, pairs = 0;
    for (size_t a = 0; a < SETS; a++) {
        if (a == left_out) continue;
        weight += sums->weight[a];
        residual += sums->residual[a];
        for (size_t b = 0; b < SETS; b++) {
            if (b == a || b == left_out) continue;
            crossed += sums->crossed[a][b];
            partners += sums->weight[a];
            reflected += sums->reflected[a][b];
            pairs++;
        }
    }
    return weight > 0 ? residual / weight + crossed / partners + reflected / pairs : 0;
}

/// Mean square of the noise in the mean of all predictions of s: from how they differ.
static double reflected_noise(const set_sums *sums)
{
    double own = 0, all = 0;
    for (size_t a = 0; a < SETS; a++) {
        own += sums->reflected[a][a];
        for (size_t b = 0; b < SETS; b++)
            all += sums->reflected[a][b];
    }
    return fmax(own - all / SETS, 0) / (SETS * (SETS - 1));
}

rsv_moments rsv_mean_squared_error(const rsv_light_view *s, const rsv_residual_sample *sample,
    size_t count, const rsv_error_field *field)
{
    set_sums sums = { 0 };
    double pseudo[SETS];
    add_samples(s, sample, count, field, &sums);
    add_nodes(s, field, &sums);
    double all = estimate(&sums, SETS);
    // Tukey's pseudo-values: their spread is that of the estimate, however its parts depend on each other
    for (size_t set = 0; set < SETS; set++)
        pseudo[set] = SETS * all - (SETS - 1) * estimate(&sums, set);
    // where that noise outweighs s, products of sets may all but cancel and spread no more: a chi-squared does not
    double noise = reflected_noise(&sums);
    return rsv_moments_with(rsv_moments_of(pseudo, SETS), SETS, 2 * noise * noise);
}
