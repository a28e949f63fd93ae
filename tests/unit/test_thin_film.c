/// Thin films against light of single wavelengths, summed: by the characteristic matrix of a layer (Abeles 1950), which has
/// no series and no table.
#include "bsdf/bsdf.h"

#include <complex.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/// The eye of 1931 (Wyman, Sloan and Shirley 2013) in sRGB's primaries.
static double bell(double nm, double peak, double below, double above)
{
    return exp(-0.5 * pow((nm - peak) / (nm < peak ? below : above), 2));
}

static void sensitivity(double nm, double rgb[3])
{
    double x = 1.056 * bell(nm, 599.8, 37.9, 31.0) + 0.362 * bell(nm, 442.0, 16.0, 26.7) -
               0.065 * bell(nm, 501.1, 20.4, 26.2);
    double y = 0.821 * bell(nm, 568.8, 46.9, 40.5) + 0.286 * bell(nm, 530.9, 16.3, 31.1);
    double z = 1.217 * bell(nm, 437.0, 11.8, 36.0) + 0.681 * bell(nm, 459.0, 26.0, 13.8);
    rgb[0] = 3.2404542 * x - 1.5371385 * y - 0.4985314 * z;
    rgb[1] = -0.9692660 * x + 1.8760108 * y + 0.0415560 * z;
    rgb[2] = 0.0556434 * x - 0.2040259 * y + 1.0572252 * z;
}

/// Reflectance of one wavelength and polarisation. @param admittance of air, film and base for it
static double reflectance_of(const double admittance[3], double phase)
{
    double complex b = cos(phase) + I * admittance[2] / admittance[1] * sin(phase);
    double complex c = I * admittance[1] * sin(phase) + admittance[2] * cos(phase);
    double complex r = (admittance[0] * b - c) / (admittance[0] * b + c);
    return creal(r * conj(r));
}

static double at_wavelength(double film, double nanometres, double base, double cos_o, double nm)
{
    double sin2 = 1 - cos_o * cos_o, in = sqrt(1 - sin2 / (film * film));
    double below = sqrt(1 - sin2 / (base * base));
    double phase = 2 * (double)RSV_PI * film * nanometres * in / nm;
    const double s[3] = { cos_o, film * in, base * below };
    const double p[3] = { 1 / cos_o, film / in, base / below };
    return 0.5 * (reflectance_of(s, phase) + reflectance_of(p, phase));
}

static void spectral_mean(double film, double nm, double base, double cos_o, double mean[3])
{
    double whole[3] = { 0 }, rgb[3];
    mean[0] = mean[1] = mean[2] = 0;
    for (double wave = 330; wave <= 830; wave += 0.5) {
        sensitivity(wave, rgb);
        double r = at_wavelength(film, nm, base, cos_o, wave);
        for (int c = 0; c < 3; c++) {
            whole[c] += rgb[c];
            mean[c] += rgb[c] * r;
        }
    }
    for (int c = 0; c < 3; c++)
        mean[c] = fmin(fmax(mean[c] / whole[c], 0), 1);
}

static void reflects_as_the_sum_over_wavelengths(void **state)
{
    (void)state;
    static const double films[] = { 1, 1.3, 1.38, 1.8, 2.4 }, bases[] = { 1, 1.33, 1.5, 2.5, 9 };
    static const double thicknesses[] = { 20, 100, 250, 400, 700, 1200, 5000 };
    static const double cosines[] = { 1, 0.8, 0.5, 0.2, 0.05 };
    for (size_t k = 0; k < COUNT(films) * COUNT(bases) * COUNT(thicknesses) * COUNT(cosines); k++) {
        double film = films[k % COUNT(films)], base = bases[k / 5 % COUNT(bases)];
        double cos_o = cosines[k / 25 % 5], nm = thicknesses[k / 125], mean[3];
        spectral_mean(film, nm, base, cos_o, mean);
        const rsv_thin_film thin = { 1, (float)film, (float)(nm / 1000) };
        rsv_rgb r = rsv_film_reflectance(&rsv_bsdf_tables_data, thin, (float)base, (float)cos_o);
        const float found[3] = { r.r, r.g, r.b };
        for (int c = 0; c < 3; c++)
            if (!(fabs((double)found[c] - mean[c]) < 2e-3))
                fail_msg("film %g of %g nm on %g, cos %g, channel %d: %.5f instead of %.5f", film,
                    nm, base, cos_o, c, (double)found[c], mean[c]);
    }
}

static rsv_material film_on(float metallic, float thickness)
{
    rsv_material m = rsv_default_material();
    m.metallic = metallic;
    m.roughness = 0;
    m.base_color = rgb(0.9f, 0.6f, 0.4f);
    m.iridescence = 1;
    m.iridescence_thickness_max = thickness;
    return m;
}

static rsv_rgb mirrored(const rsv_bsdf *bsdf, float cos)
{
    rsv_vec3 wo = v3(sqrtf(1 - cos * cos), 0, cos);
    return rsv_bsdf_evaluate_branches(bsdf, wo, v3(0, 0, 1), true).reflect;
}

static void no_thickness_is_no_film(void **state)
{
    (void)state;
    for (int metal = 0; metal < 2; metal++) {
        rsv_material with = film_on((float)metal, 0), without = with;
        without.iridescence = 0;
        rsv_bsdf a = rsv_bsdf_from_material(&with), b = rsv_bsdf_from_material(&without);
        for (float cos = 0.1f; cos < 1; cos += 0.1f) {
            rsv_rgb x = mirrored(&a, cos), y = mirrored(&b, cos);
            assert_true(x.r == y.r && x.g == y.g && x.b == y.b);
        }
    }
}

/// As thick as a quarter of a wavelength of green, under light from straight above, on glass: by hand.
static void film_of_magnesium_fluoride_takes_the_reflex_away(void **state)
{
    (void)state;
    rsv_material coated = film_on(0, 550 / 4 / 1.38f), bare = coated;
    coated.iridescence_ior = 1.38f;
    bare.iridescence = 0;
    rsv_bsdf a = rsv_bsdf_from_material(&coated), b = rsv_bsdf_from_material(&bare);
    assert_float_equal(mirrored(&b, 1).g, 0.04, 1e-6);
    // ((1 - n^2 / 1.5) / (1 + n^2 / 1.5))^2 = 0.0141 at 550 nm, the least of all; green takes its share of red away
    assert_float_equal(mirrored(&a, 1).g, 0.0141, 4e-4);
    assert_true(mirrored(&a, 1).b > mirrored(&a, 1).g && mirrored(&a, 1).r > mirrored(&a, 1).g);
}

static void share_is_a_blend(void **state)
{
    (void)state;
    rsv_material half = film_on(1, 400), whole = half, none = half;
    half.iridescence = 0.5f;
    none.iridescence = 0;
    rsv_bsdf a = rsv_bsdf_from_material(&whole), b = rsv_bsdf_from_material(&none);
    rsv_bsdf c = rsv_bsdf_from_material(&half);
    for (float cos = 0.1f; cos < 1; cos += 0.1f) {
        rsv_rgb x = mirrored(&a, cos), y = mirrored(&b, cos), z = mirrored(&c, cos);
        assert_float_equal(z.r, 0.5f * (x.r + y.r), 1e-5);
        assert_float_equal(z.b, 0.5f * (x.b + y.b), 1e-5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reflects_as_the_sum_over_wavelengths),
        cmocka_unit_test(no_thickness_is_no_film),
        cmocka_unit_test(film_of_magnesium_fluoride_takes_the_reflex_away),
        cmocka_unit_test(share_is_a_blend),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
