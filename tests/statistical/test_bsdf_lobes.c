/// Laws that every BSDF must obey at any roughness and angle: energy, densities, reciprocity.
#include "bsdf_cases.h"
#include "unit/slow_tests.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

static const rsv_vec3 up = { 0, 0, 1 };
static const float roughnesses[] = { 0, 0.05f, 0.15f, 0.35f, 0.6f, 0.85f, 1 };
static const float cosines[] = { 0.02f, 0.06f, 0.15f, 0.4f, 0.7f, 1 };

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static rsv_vec3 direction_at(float cos, float phi)
{
    float sin = sqrtf(fmaxf(1 - cos * cos, 0));
    return v3(sin * cosf(phi), sin * sinf(phi), cos);
}

typedef void (*check)(const bsdf_case *c, const rsv_bsdf *bsdf, float cos_o, bool front);

static bool all; ///< else a fifth of the roughnesses and angles

/// Every case, roughness, side and angle.
static void for_all(check check_one)
{
    size_t number = 0;
    for (const bsdf_case *c = bsdf_cases(); c->name; c++, number++)
        for (size_t r = 0; r < COUNT(roughnesses); r++)
            for (size_t k = 0; k < COUNT(cosines); k++)
                for (int back = 0; back <= c->both_sides; back++) {
                    rsv_bsdf bsdf = bsdf_of(c, roughnesses[r]);
                    // narrower brushes are lines to the charts below
                    if (bsdf.brushed && roughnesses[r] < 0.15f) continue;
                    if (!all && (r + k + number) % 5) continue;
                    check_one(c, &bsdf, cosines[k], !back);
                }
}

static int failures;

static void report(bool good, const char *what, const bsdf_case *c, const rsv_bsdf *bsdf,
    float cos_o, bool front, double value)
{
    if (good) return;
    failures++;
    print_message("%s: %s, roughness %.2f, cos %.2f, %s: %.5f\n", what, c->name,
        (double)sqrtf(bsdf->alpha), (double)cos_o, front ? "front" : "back", value);
}

static void check_furnace(const bsdf_case *c, const rsv_bsdf *bsdf, float cos_o, bool front)
{
    rsv_vec3 wo = direction_at(cos_o, 0.4f);
    rsv_bsdf_branches ideal = rsv_bsdf_evaluate_branches(bsdf, wo, up, front);
    bsdf_integral integral = bsdf_integrate_all(bsdf, wo, front, 384, bsdf->brushed ? 768 : 128);
    double energy = integral.response[1] + (double)(ideal.reflect.g + ideal.transmit.g);
    report(energy > 0.995 && energy < 1.002, "energy", c, bsdf, cos_o, front, energy);
    if (bsdf->film.share > 0 && bsdf->alpha == 0)
        return; // chances are of the channel that is reflected most
    double whole = integral.density + (double)(ideal.reflect.g + ideal.transmit.g);
    report(fabs(whole - 1) < 0.005, "density", c, bsdf, cos_o, front, whole);
}

static void white_surfaces_are_lossless_and_densities_whole(void **state)
{
    (void)state;
    failures = 0;
    for_all(check_furnace);
    assert_int_equal(failures, 0);
}

enum { BINS_U = 12, BINS_V = 8, BINS = 2 * BINS_U * BINS_V, DRAWS = 20000 };

static int bin_of(const bsdf_chart chart[2], rsv_vec3 wi)
{
    int below = wi.z < 0;
    float u, v;
    bsdf_chart_locate(&chart[below], wi, &u, &v);
    int i = (int)(u * BINS_U), j = (int)(v * BINS_V);
    return (below * BINS_U + (i < BINS_U ? i : BINS_U - 1)) * BINS_V +
           (j < BINS_V ? j : BINS_V - 1);
}

static void count_draws(const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, const bsdf_chart chart[2],
    int counts[BINS], int *ideal)
{
    rsv_random random = rsv_random_from(rsv_number_bits(wo.z), rsv_number_bits(bsdf->alpha), front);
    *ideal = 0;
    for (int k = 0; k < DRAWS; k++) {
        float u = rsv_random_float(&random), x = rsv_random_float(&random);
        rsv_bsdf_sample sample = rsv_bsdf_sample_direction(
            bsdf, wo, up, front, (const float[3]){ u, x, rsv_random_float(&random) });
        if (sample.pdf_solid_angle > 0)
            counts[bin_of(chart, sample.direction)]++;
        else
            ++*ideal;
    }
}

/// Standard deviations by which a chi-square of `bins` bins exceeds its mean (Wilson and Hilferty 1931).
static double excess(double chi_square, int bins)
{
    double spread = 2.0 / (9 * bins);
    return (cbrt(chi_square / bins) - (1 - spread)) / sqrt(spread);
}

/// At grazing angles, densities come from tables with an error of 0.5 %. Samples follow the microsurface exactly, so
/// the test would notice that error.
#define GRAZING 0.05f

/// Bins with few expected draws are merged.
static void check_draws(const bsdf_case *c, const rsv_bsdf *bsdf, float cos_o, bool front)
{
    if (cos_o < GRAZING) return;
    rsv_vec3 wo = direction_at(cos_o, 0.4f);
    bsdf_chart chart[2];
    bsdf_charts(bsdf, wo, front, chart);
    int counts[BINS] = { 0 }, ideal, bins = 0;
    count_draws(bsdf, wo, front, chart, counts, &ideal);
    double chi_square = 0, expected = 0, found = 0, density[BINS];
    for (int bin = 0; bin < BINS; bin++) {
        int i = bin / BINS_V % BINS_U, j = bin % BINS_V, mirrored = bin - j + BINS_V - 1 - j;
        bsdf_patch patch = { (float)i / BINS_U, (float)(i + 1) / BINS_U, (float)j / BINS_V,
            (float)(j + 1) / BINS_V, bsdf->brushed ? 24 : 8, bsdf->brushed ? 96 : 6 };
        const bsdf_chart *side = &chart[bin / (BINS_U * BINS_V)];
        density[bin] = mirrored < bin && !bsdf->brushed
                           ? density[mirrored]
                           : bsdf_integrate(bsdf, wo, front, side, patch).density;
        expected += DRAWS * density[bin];
        found += counts[bin];
        if (expected < 20) continue;
        chi_square += (found - expected) * (found - expected) / expected;
        bins++;
        expected = found = 0;
    }
    if (bins == 0) return;
    // 3.72 standard deviations: p = 1e-4
    double deviations = excess(chi_square, bins);
    report(deviations < 3.72, "chi-square", c, bsdf, cos_o, front, deviations);
}

static void draws_follow_their_density(void **state)
{
    (void)state;
    failures = 0;
    for_all(check_draws);
    assert_int_equal(failures, 0);
}

/// f(wi, wo) / ior(wi)^2 is symmetric where radiance is basic.
static void check_reciprocity(const bsdf_case *c, const rsv_bsdf *bsdf, float cos_o, bool front)
{
    rsv_vec3 wo = direction_at(cos_o, 0.4f);
    for (int k = 0; k < 40; k++) {
        float x, y;
        rsv_sobol_2d((uint32_t)k, 7, &x, &y);
        rsv_vec3 wi = rsv_square_to_sphere(x, y);
        bool through = wi.z < 0, other_front = front != through;
        float ior_o = bsdf->solid && !front ? bsdf->ior : 1;
        float ior_i = bsdf->solid && !other_front ? bsdf->ior : 1;
        rsv_vec3 other_up = through ? v3_neg(up) : up;
        double there = (double)rsv_bsdf_eval(bsdf, wi, wo, up, front).g;
        double back = (double)rsv_bsdf_eval(bsdf, wo, wi, other_up, other_front).g;
        there /= (double)(ior_i * ior_i);
        back /= (double)(ior_o * ior_o);
        bool good = fabs(there - back) <= 2e-3 * fmax(there, back) + 1e-6;
        report(good, "reciprocity", c, bsdf, cos_o, front, there / back);
    }
}

static void scattering_is_reciprocal(void **state)
{
    (void)state;
    failures = 0;
    for_all(check_reciprocity);
    assert_int_equal(failures, 0);
}

/// The integrals above rely on this: scattering is symmetric about the plane of wo and the normal.
static void check_symmetry(const bsdf_case *c, const rsv_bsdf *bsdf, float cos_o, bool front)
{
    if (bsdf->brushed) return;
    rsv_vec3 wo = direction_at(cos_o, 0.4f), across = v3(-sinf(0.4f), cosf(0.4f), 0);
    for (int k = 0; k < 40; k++) {
        float x, y;
        rsv_sobol_2d((uint32_t)k, 7, &x, &y);
        rsv_vec3 wi = rsv_square_to_sphere(x, y);
        rsv_vec3 mirrored = v3_mad(wi, -2 * v3_dot(wi, across), across);
        rsv_bsdf_value here = rsv_bsdf_evaluate(bsdf, wi, wo, up, front, RSV_LOBES_ALL);
        rsv_bsdf_value there = rsv_bsdf_evaluate(bsdf, mirrored, wo, up, front, RSV_LOBES_ALL);
        double response = (double)here.response.g, pdf = (double)here.pdf_solid_angle;
        bool good = fabs((double)there.response.g - response) <= 1e-3 * response + 1e-6 &&
                    fabs((double)there.pdf_solid_angle - pdf) <= 1e-3 * pdf + 1e-6;
        report(good, "symmetry", c, bsdf, cos_o, front, (double)there.response.g / response);
    }
}

static void scattering_is_symmetric(void **state)
{
    (void)state;
    failures = 0;
    for_all(check_symmetry);
    assert_int_equal(failures, 0);
}

/// White and clear surfaces keep the weight of a path at 1, whatever happens to it. (Coloured sheen does so in the
/// channel that it reflects most.) Diffuse light that leaves a coated sheet has the factor T(wi) / T_mean of the coat,
/// and rough lobes under layers have a(wi) / s(wo): these are 1 only in the mean.
static void check_weights(const bsdf_case *c, const rsv_bsdf *bsdf, float cos_o, bool front)
{
    if (bsdf->passed > 0 || bsdf->film.share > 0) return; // a film has colours
    rsv_random random = rsv_random_from(1, 2, 3);
    for (int k = 0; k < 200; k++) {
        float u = rsv_random_float(&random), x = rsv_random_float(&random);
        rsv_bsdf_event event = rsv_bsdf_draw_event(bsdf, direction_at(cos_o, 0.4f), up, front,
            (const float[3]){ u, x, rsv_random_float(&random) });
        bool balanced = bsdf->layered && bsdf->alpha > 0 && event.lobe != RSV_LOBE_DIFFUSE;
        float largest = rgb_max(bsdf->sheen) > bsdf->sheen.r ? event.weight.g : event.weight.r;
        bool good = balanced ? largest > 0 && largest < 3 : fabsf(largest - 1) < 1e-4f;
        report(
            good && event.lobe != RSV_LOBE_NONE, "weight", c, bsdf, cos_o, front, (double)largest);
    }
}

static void events_of_white_surfaces_weigh_one(void **state)
{
    (void)state;
    failures = 0;
    for_all(check_weights);
    assert_int_equal(failures, 0);
}

static rsv_material layered_base(float metallic, float transmission, float thickness)
{
    rsv_material material = bsdf_cases()[0].material;
    material.metallic = metallic;
    material.transmission = transmission;
    material.thickness = thickness;
    return material;
}

/// Mean weight of drawn directions: the share of light from wo's side that is scattered at all.
static double drawn_energy_along(const rsv_bsdf *bsdf, rsv_vec3 wo, double *standard_error)
{
    enum { COUNT_DRAWN = 8192 };
    rsv_random random = rsv_random_from(1, 2, 3);
    double sum = 0, squares = 0;
    for (uint32_t k = 0; k < COUNT_DRAWN; k++) {
        float u1, u2, u = rsv_random_float(&random);
        rsv_sobol_2d(k, 1, &u1, &u2);
        rsv_bsdf_sample sample =
            rsv_bsdf_sample_direction(bsdf, wo, up, true, (const float[3]){ u, u1, u2 });
        double weight = sample.lobe == RSV_LOBE_NONE ? 0 : (double)sample.weight.g;
        sum += weight;
        squares += weight * weight;
    }
    double mean = sum / COUNT_DRAWN;
    *standard_error = sqrt(fmax(squares / COUNT_DRAWN - mean * mean, 0) / COUNT_DRAWN);
    return mean;
}

static double drawn_energy(const rsv_bsdf *bsdf, float cos_o, double *standard_error)
{
    return drawn_energy_along(bsdf, direction_at(cos_o, 0), standard_error);
}

static double whole_energy(const rsv_bsdf *bsdf, float cos_o)
{
    rsv_vec3 wo = direction_at(cos_o, 0.4f);
    rsv_bsdf_branches ideal = rsv_bsdf_evaluate_branches(bsdf, wo, up, true);
    return bsdf_integrate_all(bsdf, wo, true, 192, 64).response[1] +
           (double)(ideal.reflect.g + ideal.transmit.g);
}

static rsv_material under_layers(rsv_material material, int layers, float roughness)
{
    material.roughness = roughness;
    material.clearcoat = layers & 1 ? 1 : 0;
    material.clearcoat_roughness = 0.3f;
    material.sheen_color = rgb_gray(layers & 2 ? 1 : 0);
    material.sheen_roughness = 0.7f;
    return material;
}

/// Coat and sheen over every base that a file can combine them with: all light that leaves the base upwards gets out in
/// the end.
static void layers_are_lossless_over_any_base(void **state)
{
    (void)state;
    const rsv_material bases[] = { layered_base(0, 0, 0), layered_base(1, 0, 0),
        layered_base(0, 1, 1), layered_base(0, 1, 0), layered_base(0.5f, 0.5f, 0) };
    for (size_t b = 0; b < COUNT(bases); b++)
        for (int layers = 1; layers < 4; layers++)
            for (size_t r = 0; r < COUNT(roughnesses); r += 2)
                for (size_t k = 0; k < COUNT(cosines); k++) {
                    rsv_material material = under_layers(bases[b], layers, roughnesses[r]);
                    rsv_bsdf bsdf = rsv_bsdf_from_material(&material);
                    double energy = whole_energy(&bsdf, cosines[k]), error;
                    double drawn = drawn_energy(&bsdf, cosines[k], &error);
                    if (!(energy > 0.995 && energy < 1.002) ||
                        !(fabs(drawn - energy) < 5 * error + 0.002))
                        fail_msg("base %zu, layers %d, roughness %.2f, cos %.2f: %.5f, drawn %.5f",
                            b, layers, (double)roughnesses[r], (double)cosines[k], energy, drawn);
                }
}

// ---- clear coats with normals of their own -------------------------------------------------------------

enum { SLICES = 192, TURNS = 192, BINS_Z = 4, BINS_TURN = 8, COAT_BINS = BINS_Z * BINS_TURN };

/// What a surface scatters upwards, and how it is drawn.
typedef struct upward {
    double response, density, bin[COAT_BINS];
} upward;

static int coat_bin(rsv_vec3 wi)
{
    int z = (int)(wi.z * BINS_Z);
    double turn = atan2((double)wi.y, (double)wi.x) / (2 * (double)RSV_PI) + 0.5;
    int t = (int)(turn * BINS_TURN);
    return (z < BINS_Z ? z : BINS_Z - 1) * BINS_TURN + (t < BINS_TURN ? t : BINS_TURN - 1);
}

static upward scattered_upwards(const rsv_bsdf *bsdf, rsv_vec3 wo)
{
    upward sum = { 0 };
    double area = 2 * (double)RSV_PI / (SLICES * TURNS);
    for (int k = 0; k < SLICES * TURNS; k++) {
        float z = ((float)(k / TURNS) + 0.5f) / SLICES;
        rsv_vec3 wi = direction_at(z, 2 * RSV_PI * ((float)(k % TURNS) + 0.5f) / TURNS - RSV_PI);
        rsv_bsdf_value value = rsv_bsdf_evaluate(bsdf, wi, wo, up, true, RSV_LOBES_ALL);
        sum.response += area * (double)value.response.g;
        sum.density += area * (double)value.pdf_solid_angle;
        sum.bin[coat_bin(wi)] += area * (double)value.pdf_solid_angle;
    }
    return sum;
}

/// Light that a coat alone, met along its own normal, sends where `below` says.
static double sent_below(float roughness, rsv_vec3 normal, rsv_vec3 wo)
{
    rsv_material material = under_layers(layered_base(0, 0, 0), 1, 1);
    material.base_color = rgb_gray(0);
    material.specular = 0;
    material.clearcoat_roughness = roughness;
    rsv_bsdf coat = rsv_bsdf_from_material(&material);
    double sum = 0, area = 4 * (double)RSV_PI / (SLICES * TURNS);
    for (int k = 0; k < SLICES * TURNS; k++) {
        float z = 2 * ((float)(k / TURNS) + 0.5f) / SLICES - 1;
        rsv_vec3 wi = direction_at(z, 2 * RSV_PI * ((float)(k % TURNS) + 0.5f) / TURNS);
        if (z < 0)
            sum +=
                area *
                (double)rsv_bsdf_evaluate(&coat, wi, wo, normal, true, RSV_LOBES_ROUGH).response.g;
    }
    return sum;
}

static void check_coat_draws(const rsv_bsdf *bsdf, rsv_vec3 wo, const upward *expected)
{
    int counts[COAT_BINS] = { 0 }, bins = 0;
    rsv_random random = rsv_random_from(4, 5, 6);
    for (int k = 0; k < DRAWS; k++) {
        float u = rsv_random_float(&random), x = rsv_random_float(&random);
        rsv_bsdf_sample sample = rsv_bsdf_sample_direction(
            bsdf, wo, up, true, (const float[3]){ u, x, rsv_random_float(&random) });
        if (sample.lobe != RSV_LOBE_NONE) counts[coat_bin(sample.direction)]++;
    }
    double chi_square = 0;
    for (int k = 0; k < COAT_BINS; k++) {
        double mean = DRAWS * expected->bin[k];
        if (mean < 20) continue;
        chi_square += (counts[k] - mean) * (counts[k] - mean) / mean;
        bins++;
    }
    assert_true(excess(chi_square, bins) < 3.72); // p = 1e-4
}

static void check_tilted_coat(rsv_material material, float tilt, float cos_o)
{
    rsv_texture_ref map = rsv_default_texture_ref(RSV_TEXTURE_CLEARCOAT_NORMAL, 0);
    rsv_vec3 wo = direction_at(cos_o, 0.4f), normal = direction_at(cosf(tilt), 1);
    material.textures = &map;
    material.texture_count = 1;
    rsv_bsdf bsdf = rsv_bsdf_from_material(&material);
    assert_true(bsdf.tilted);
    bsdf.coat_normal = normal;
    upward found = scattered_upwards(&bsdf, wo);
    normal = rsv_bsdf_coat_normal(&bsdf, wo, up);
    double lost = sent_below(material.clearcoat_roughness, normal, wo), error;
    double drawn = drawn_energy_along(&bsdf, wo, &error);
    if (fabs(found.response + lost - 1) > 0.005 || fabs(found.density + lost - 1) > 0.005 ||
        fabs(drawn - found.response) > 5 * error + 0.002)
        fail_msg("roughness %.2f, tilt %.2f, cos %.2f: %.5f, density %.5f, drawn %.5f, lost %.5f",
            (double)material.clearcoat_roughness, (double)tilt, (double)cos_o, found.response,
            found.density, drawn, lost);
    check_coat_draws(&bsdf, wo, &found);
}

/// White bases in white surroundings stay white, except for the light that the coat itself sends below the surface.
static void tilted_coats_lose_only_what_they_send_below(void **state)
{
    (void)state;
    static const float from[] = { 0.15f, 0.4f, 0.7f, 1 };
    for (int metal = 0; metal < 2; metal++)
        for (int rough = 1; rough < 3; rough++)
            for (size_t k = 0; k < COUNT(from); k++) {
                rsv_material material =
                    under_layers(layered_base((float)metal, 0, 0), rough == 1 ? 1 : 3, 0.6f);
                material.clearcoat_roughness = 0.35f * (float)rough;
                check_tilted_coat(material, 0.25f, from[k]);
                check_tilted_coat(material, 0.6f, from[k]);
            }
}

// Values below: validation cases g.ggx.*
static void single_scattering_matches_reference_values(void **state)
{
    (void)state;
    static const struct {
        float alpha, cos;
        double albedo;
    } values[] = { { 0.1f, 1, 0.988304056521 }, { 0.1f, 0.7f, 0.981418595773 },
        { 0.1f, 0.4f, 0.95690513711 }, { 0.1f, 0.1f, 0.883455001867 }, { 0.5f, 1, 0.68784851511 },
        { 0.5f, 0.8f, 0.682045682101 }, { 0.5f, 0.5f, 0.698250696928 },
        { 0.5f, 0.2f, 0.789929186565 }, { 0.5f, 0.05f, 0.912547797965 }, { 1, 1, 0.30685281944 },
        { 1, 0.8f, 0.351255827027 }, { 1, 0.5f, 0.450693855666 }, { 1, 0.2f, 0.641648106154 },
        { 1, 0.05f, 0.847773878114 }, { 0.05f, 1, 0.997295868489 }, { 0.05f, 0.5f, 0.992715568676 },
        { 0.05f, 0.1f, 0.911346937308 }, { 0.2f, 1, 0.947657778991 },
        { 0.2f, 0.6f, 0.910874288799 }, { 0.2f, 0.2f, 0.858399442274 } };
    for (size_t i = 0; i < COUNT(values); i++) {
        float missing = rsv_table_albedo(rsv_bsdf_tables_data.conductor_missing,
            rsv_table_alpha(values[i].alpha), rsv_table_cos(values[i].cos));
        assert_float_equal(1 - missing, values[i].albedo, 1e-3);
    }
}

static void mean_single_scattering_matches_reference_values(void **state)
{
    (void)state;
    const float *mean = rsv_bsdf_tables_data.conductor_missing_mean;
    assert_float_equal(1 - rsv_table_line(mean, rsv_table_alpha(0.1f)), 0.972045756819, 1e-3);
    assert_float_equal(1 - rsv_table_line(mean, rsv_table_alpha(0.5f)), 0.700240469157, 1e-3);
    assert_float_equal(1 - rsv_table_line(mean, rsv_table_alpha(1)), 0.40913709265, 1e-3);
}

int main(int argc, char **argv)
{
    all = asks_for_more(argc, argv);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_surfaces_are_lossless_and_densities_whole),
        cmocka_unit_test(draws_follow_their_density),
        cmocka_unit_test(scattering_is_reciprocal),
        cmocka_unit_test(scattering_is_symmetric),
        cmocka_unit_test(events_of_white_surfaces_weigh_one),
        cmocka_unit_test(layers_are_lossless_over_any_base),
        cmocka_unit_test(tilted_coats_lose_only_what_they_send_below),
        cmocka_unit_test(single_scattering_matches_reference_values),
        cmocka_unit_test(mean_single_scattering_matches_reference_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
