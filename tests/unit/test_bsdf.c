#include "bsdf/bsdf.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const rsv_vec3 up = { 0, 0, 1 };

static rsv_vec3 direction_at(float cos, float phi)
{
    float sin = sqrtf(fmaxf(1 - cos * cos, 0));
    return v3(sin * cosf(phi), sin * sinf(phi), cos);
}

static rsv_bsdf make_bsdf(const rsv_material *material) { return rsv_bsdf_from_material(material); }

static rsv_material smooth_material(rsv_rgb base_color)
{
    rsv_material material = { .base_color = base_color,
        .ior = 1.5f,
        .specular = 1,
        .specular_color = { 1, 1, 1 },
        .attenuation_color = { 1, 1, 1 },
        .attenuation_distance = INFINITY };
    return material;
}

static rsv_material glass_material(void)
{
    rsv_material material = smooth_material(rgb_gray(1));
    material.transmission = 1;
    material.thickness = 1;
    return material;
}

static float dielectric_at(float degrees, float eta)
{
    float cos_t;
    return rsv_fresnel_dielectric(cosf(degrees * RSV_PI / 180), eta, &cos_t);
}

static float conductor_at(float degrees, float eta, float k)
{
    return rsv_fresnel_conductor(cosf(degrees * RSV_PI / 180), eta, k);
}

// Values below: validation cases f.fresnel.*, f.fresnel_average.*, f.conductor.*
static void dielectric_reflectance_matches_reference_values(void **state)
{
    (void)state;
    assert_float_equal(dielectric_at(0, 1.5f), 0.04, 1e-6);
    assert_float_equal(dielectric_at(45, 1.5f), 0.0502399110122, 1e-6);
    assert_float_equal(dielectric_at(75, 1.5f), 0.25306056299, 2e-6);
    assert_float_equal(dielectric_at(85, 1.5f), 0.612799645265, 4e-6);
    assert_float_equal(dielectric_at(80, 1.33f), 0.346916096262, 4e-6);
    assert_float_equal(dielectric_at(30, 1 / 1.5f), 0.0551901672954, 1e-6);
    assert_float_equal(dielectric_at(41, 1 / 1.5f), 0.379751265962, 2e-5);
    assert_float_equal(dielectric_at(45, 1 / 1.5f), 1, 0);
}

static void refracted_cosine_obeys_snell(void **state)
{
    (void)state;
    float cos_t;
    rsv_fresnel_dielectric(cosf(RSV_PI / 6), 1.5f, &cos_t);
    assert_float_equal(sqrtf(1 - cos_t * cos_t), 0.5f / 1.5f, 1e-6);
    rsv_fresnel_dielectric(0.1f, 1 / 1.5f, &cos_t);
    assert_float_equal(cos_t, 0, 0);
}

static void conductor_reflectance_matches_reference_values(void **state)
{
    (void)state;
    assert_float_equal(conductor_at(0, 0.2f, 3.9f), 0.951951951952, 1e-6);
    assert_float_equal(conductor_at(60, 0.2f, 3.9f), 0.945882381801, 1e-6);
    assert_float_equal(conductor_at(80, 0.2f, 3.9f), 0.948407448365, 1e-6);
    assert_float_equal(conductor_at(45, 1.5f, 7.5f), 0.899438292438, 1e-6);
    assert_float_equal(conductor_at(88, 2.9f, 3.2f), 0.820874554728, 4e-6);
}

static void conductor_without_absorption_is_a_dielectric(void **state)
{
    (void)state;
    for (float degrees = 0; degrees < 90; degrees += 10)
        assert_float_equal(conductor_at(degrees, 1.5f, 0), dielectric_at(degrees, 1.5f), 2e-6);
}

static void mean_reflectance_matches_reference_values(void **state)
{
    (void)state;
    assert_true(fabs(rsv_fresnel_dielectric_mean(1.5) - 0.0917779593424) < 1e-12);
    assert_true(fabs(rsv_fresnel_dielectric_mean(1.33) - 0.0659308492994) < 1e-12);
    assert_true(fabs(rsv_fresnel_dielectric_mean(1.1) - 0.0251573573529) < 1e-11);
}

static void mean_reflectance_is_continuous_towards_no_interface(void **state)
{
    (void)state;
    assert_true(rsv_fresnel_dielectric_mean(1) == 0);
    double below = rsv_fresnel_dielectric_mean(1 + 0.9999e-4);
    double above = rsv_fresnel_dielectric_mean(1 + 1.0001e-4);
    assert_true(fabs(above - below) < 1e-7);
}

/// int f(wi, wo) cos_i dwi by the midpoint rule in (cos^2, phi).
static rsv_rgb directional_albedo(const rsv_bsdf *bsdf, rsv_vec3 wo)
{
    enum { STEPS = 4000 };
    rsv_rgb sum = { 0, 0, 0 };
    for (int i = 0; i < STEPS; i++) {
        rsv_vec3 wi = direction_at(sqrtf(((float)i + 0.5f) / STEPS), 1.0f);
        sum = rgb_mad(sum, RSV_PI / STEPS, rsv_bsdf_eval(bsdf, wi, wo, up, true));
    }
    return sum;
}

static void white_coated_surface_loses_nothing_at_any_angle(void **state)
{
    (void)state;
    rsv_material material = smooth_material(rgb_gray(1));
    material.specular_color = rgb(1, 0.5f, 0.2f);
    rsv_bsdf bsdf = make_bsdf(&material);
    assert_true(bsdf.coated && !bsdf.lambert);
    for (float cos = 0.02f; cos <= 1; cos += 0.07f) {
        rsv_vec3 wo = direction_at(cos, 0.3f);
        rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(&bsdf, wo, up, true);
        rsv_rgb total = rgb_add(directional_albedo(&bsdf, wo), branches.reflect);
        assert_float_equal(total.r, 1, 1e-3);
        assert_float_equal(total.g, 1, 1e-3);
        assert_float_equal(total.b, 1, 1e-3);
    }
}

static void diffuse_lobe_is_reciprocal(void **state)
{
    (void)state;
    rsv_material material = smooth_material(rgb(0.8f, 0.4f, 0.1f));
    rsv_bsdf bsdf = make_bsdf(&material);
    rsv_vec3 a = direction_at(0.15f, 0.2f), b = direction_at(0.8f, 2.0f);
    rsv_rgb forward = rsv_bsdf_eval(&bsdf, a, b, up, true),
            backward = rsv_bsdf_eval(&bsdf, b, a, up, true);
    assert_float_equal(forward.r, backward.r, 1e-7);
    assert_float_equal(forward.b, backward.b, 1e-7);
    assert_true(rgb_is_black(rsv_bsdf_eval(&bsdf, v3_neg(a), b, up, true)));
}

/// Eight materials that mix the lobes in different ways.
static rsv_bsdf mixed_bsdf(int index)
{
    rsv_material material = smooth_material(rgb(0.9f, 0.5f, 0.2f));
    material.specular = index & 1 ? 1.0f : 0.3f;
    material.metallic = index & 2 ? 0.4f : 0;
    material.transmission = index & 4 ? 0.6f : 0;
    material.thickness = index == 7 ? 0.1f : 0;
    return make_bsdf(&material);
}

static void branches_never_create_energy(void **state)
{
    (void)state;
    for (int i = 0; i < 16; i++) {
        rsv_bsdf bsdf = mixed_bsdf(i / 2);
        for (float cos = 0; cos <= 1; cos += 0.05f) {
            rsv_bsdf_branches branches =
                rsv_bsdf_evaluate_branches(&bsdf, direction_at(cos, 0), up, i % 2 == 0);
            rsv_rgb diffuse = rgb_mul(branches.diffuse, bsdf.base_color);
            rsv_rgb sum = rgb_add(rgb_add(branches.reflect, branches.transmit), diffuse);
            assert_true(rgb_max(sum) <= 1 + 1e-6f);
        }
    }
}

static void sampled_weight_is_value_over_density(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        rsv_bsdf bsdf = mixed_bsdf(i);
        rsv_vec3 wo = direction_at(0.6f, 1.0f);
        rsv_bsdf_sample s =
            rsv_bsdf_sample_direction(&bsdf, wo, up, true, (const float[3]){ 0.9999f, 0.3f, 0.8f });
        if (s.lobe != RSV_LOBE_DIFFUSE) continue;
        float pdf = rsv_bsdf_pdf(&bsdf, s.direction, wo, up, true);
        assert_float_equal(s.pdf_solid_angle, pdf, 1e-5 * pdf);
        rsv_rgb value = rsv_bsdf_eval(&bsdf, s.direction, wo, up, true);
        assert_float_equal(s.weight.r, value.r * s.direction.z / pdf, 1e-4 * s.weight.r);
        assert_float_equal(s.weight.b, value.b * s.direction.z / pdf, 1e-4 * s.weight.b);
    }
}

static void mean_sampled_weight_is_the_albedo(void **state)
{
    (void)state;
    enum { SAMPLES = 1 << 14 };
    rsv_vec3 wo = direction_at(0.4f, 1.0f);
    for (int i = 0; i < 8; i++) {
        rsv_bsdf bsdf = mixed_bsdf(i);
        rsv_random random = rsv_random_from((uint32_t)i, 7, 1);
        double sum = 0;
        for (uint32_t k = 0; k < SAMPLES; k++) {
            float u1, u2;
            rsv_sobol_2d(k, (uint32_t)i, &u1, &u2);
            sum += (double)rsv_bsdf_sample_direction(
                &bsdf, wo, up, true, (const float[3]){ rsv_random_float(&random), u1, u2 })
                       .weight.g;
        }
        rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(&bsdf, wo, up, true);
        double albedo = (double)(branches.reflect.g + branches.transmit.g +
                                 branches.diffuse.g * bsdf.base_color.g);
        assert_true(fabs(sum / SAMPLES - albedo) < 0.01);
    }
}

enum { COS_BINS = 10, PHI_BINS = 12, DRAWS = 200000 };

static int bin_of(rsv_vec3 w)
{
    int i = (int)(w.z * COS_BINS), j = (int)((atan2f(w.y, w.x) / (2 * RSV_PI) + 0.5f) * PHI_BINS);
    return (i < COS_BINS ? i : COS_BINS - 1) * PHI_BINS + (j < PHI_BINS ? j : PHI_BINS - 1);
}

/// Probability that one draw falls into a cosine ring of bins, by the midpoint rule.
static double ring_probability(const rsv_bsdf *bsdf, rsv_vec3 wo, int ring)
{
    enum { STEPS = 16 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        float cos = ((float)ring + ((float)i + 0.5f) / STEPS) / COS_BINS;
        sum += (double)rsv_bsdf_pdf(bsdf, direction_at(cos, 0.5f), wo, up, true);
    }
    return sum / STEPS * 2 * (double)RSV_PI / COS_BINS;
}

static void check_chi_square(const rsv_bsdf *bsdf, rsv_vec3 wo, uint32_t seed)
{
    int counts[COS_BINS * PHI_BINS] = { 0 }, diffuse_draws = 0;
    rsv_random random = rsv_random_from(seed, 3, 5);
    for (int k = 0; k < DRAWS; k++) {
        float u_lobe = rsv_random_float(&random), u1 = rsv_random_float(&random);
        float u2 = rsv_random_float(&random);
        rsv_bsdf_sample s =
            rsv_bsdf_sample_direction(bsdf, wo, up, true, (const float[3]){ u_lobe, u1, u2 });
        if (s.lobe != RSV_LOBE_DIFFUSE) continue;
        counts[bin_of(s.direction)]++;
        diffuse_draws++;
    }
    double chi_square = 0, share = 0;
    for (int ring = 0; ring < COS_BINS; ring++) {
        double probability = ring_probability(bsdf, wo, ring);
        double expected = probability * DRAWS / PHI_BINS;
        share += probability;
        for (int j = 0; j < PHI_BINS; j++) {
            double difference = counts[ring * PHI_BINS + j] - expected;
            chi_square += difference * difference / expected;
        }
    }
    // 120 bins: mean 120, standard deviation 15.5; beyond 5 of those is no accident
    assert_true(chi_square < 120 + 5 * 15.5);
    double deviation = sqrt(share * (1 - share) / DRAWS);
    assert_true(fabs((double)diffuse_draws / DRAWS - share) < 5 * deviation + 1e-6);
}

static void samples_follow_their_density(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        rsv_bsdf bsdf = mixed_bsdf(i);
        check_chi_square(&bsdf, direction_at(0.5f, 0.4f), (uint32_t)i);
    }
}

static void glass_is_lossless_from_both_sides_and_reversible(void **state)
{
    (void)state;
    rsv_material material = glass_material();
    rsv_bsdf bsdf = make_bsdf(&material);
    rsv_vec3 wo = direction_at(0.6f, 0.7f);
    rsv_bsdf_branches outside = rsv_bsdf_evaluate_branches(&bsdf, wo, up, true);
    assert_float_equal(outside.reflect.g + outside.transmit.g, 1, 1e-6);
    assert_true(rgb_is_black(outside.diffuse));
    assert_true(outside.transmit_direction.z < 0);
    rsv_bsdf_branches inside =
        rsv_bsdf_evaluate_branches(&bsdf, outside.transmit_direction, v3_neg(up), false);
    assert_float_equal(inside.reflect.g, outside.reflect.g, 1e-6);
    assert_float_equal(v3_length(v3_sub(inside.transmit_direction, wo)), 0, 1e-5);
}

static void total_reflection_ignores_the_specular_scale(void **state)
{
    (void)state;
    rsv_material material = glass_material();
    material.specular = 0.2f;
    rsv_bsdf bsdf = make_bsdf(&material);
    rsv_bsdf_branches branches =
        rsv_bsdf_evaluate_branches(&bsdf, direction_at(0.3f, 0), up, false);
    assert_float_equal(branches.reflect.r, 1, 0);
    assert_float_equal(branches.transmit.r, 0, 0);
}

static void index_matched_body_is_invisible(void **state)
{
    (void)state;
    rsv_material material = glass_material();
    material.ior = 1;
    rsv_bsdf bsdf = make_bsdf(&material);
    rsv_vec3 wo = direction_at(0.01f, 0);
    rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(&bsdf, wo, up, false);
    assert_true(rgb_is_black(branches.reflect));
    assert_float_equal(v3_length(v3_add(branches.transmit_direction, wo)), 0, 1e-5);
}

static void thin_sheet_transmits_straight_through_both_ways(void **state)
{
    (void)state;
    rsv_material material = glass_material();
    material.thickness = 0;
    rsv_bsdf bsdf = make_bsdf(&material);
    rsv_vec3 wo = direction_at(0.6f, 0.7f);
    for (int front = 0; front < 2; front++) {
        rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(&bsdf, wo, up, front);
        assert_float_equal(v3_length(v3_add(branches.transmit_direction, wo)), 0, 0);
        assert_float_equal(branches.reflect.g + branches.transmit.g, 1, 1e-6);
    }
}

static void backs_of_single_sided_surfaces_are_black(void **state)
{
    (void)state;
    rsv_material material = smooth_material(rgb_gray(0.5f));
    rsv_bsdf single = make_bsdf(&material);
    material.double_sided = true;
    rsv_bsdf both = make_bsdf(&material);
    rsv_vec3 wo = direction_at(0.6f, 0.7f);
    rsv_bsdf_branches back = rsv_bsdf_evaluate_branches(&single, wo, up, false);
    assert_true(
        rgb_is_black(back.reflect) && rgb_is_black(back.diffuse) && rgb_is_black(back.transmit));
    assert_int_equal(
        rsv_bsdf_sample_direction(&single, wo, up, false, (const float[3]){ 0.5f, 0.5f, 0.5f })
            .lobe,
        RSV_LOBE_NONE);
    assert_false(rgb_is_black(rsv_bsdf_evaluate_branches(&both, wo, up, false).diffuse));
}

static void partly_transmitting_body_diffuses_outside_only(void **state)
{
    (void)state;
    rsv_material material = glass_material();
    material.transmission = 0.5f;
    rsv_bsdf bsdf = make_bsdf(&material);
    rsv_vec3 wo = direction_at(0.9f, 0);
    assert_false(rgb_is_black(rsv_bsdf_evaluate_branches(&bsdf, wo, up, true).diffuse));
    assert_true(rgb_is_black(rsv_bsdf_evaluate_branches(&bsdf, wo, up, false).diffuse));
}

static void absorption_follows_beer_and_lambert(void **state)
{
    (void)state;
    rsv_material material = glass_material();
    material.attenuation_color = rgb(0.5f, 1, 0);
    material.attenuation_distance = 0.25f;
    rsv_bsdf bsdf = make_bsdf(&material);
    assert_float_equal(expf(-bsdf.absorption.r * 0.25f), 0.5f, 1e-6);
    assert_float_equal(bsdf.absorption.g, 0, 0);
    assert_true(bsdf.absorption.b > 1e6f && isfinite(bsdf.absorption.b));
}

static void mirror_directions_stay_above_the_surface(void **state)
{
    (void)state;
    rsv_vec3 shading = v3_normalize(v3(0.3f, 0, 1)), steep = direction_at(0.9f, 0);
    rsv_vec3 grazing = direction_at(0.05f, RSV_PI);
    assert_float_equal(rsv_bsdf_specular_normal(shading, up, steep).x, shading.x, 0);
    assert_float_equal(rsv_bsdf_specular_normal(shading, up, grazing).x, up.x, 0);
}

static void unlit_material_is_black_to_light_transport(void **state)
{
    (void)state;
    rsv_material material = smooth_material(rgb(0.2f, 0.4f, 0.6f));
    material.unlit = true;
    material.emission = rgb_gray(5);
    rsv_bsdf bsdf = make_bsdf(&material);
    assert_true(bsdf.unlit && !bsdf.emissive && rgb_is_black(bsdf.base_color));
    assert_float_equal(bsdf.emission.b, 0.6f, 0);
}

/// Weight that the specular lobes carry: drawn alone, and among the others.
static void mean_specular_weights(const rsv_bsdf *bsdf, rsv_vec3 wo, double *alone, double *among)
{
    const int count = 1 << 15;
    *alone = *among = 0;
    for (int k = 0; k < count; k++) {
        float x, y, u = ((float)k + 0.5f) / (float)count;
        rsv_sobol_2d((uint32_t)k, 7, &x, &y);
        *alone += rsv_bsdf_draw_specular(bsdf, wo, up, true, (const float[3]){ u, x, y }).weight.r /
                  count;
        rsv_bsdf_event event = rsv_bsdf_draw_event(bsdf, wo, up, true, (const float[3]){ u, x, y });
        if (event.lobe == RSV_LOBE_REFLECT) *among += event.weight.r / count;
    }
}

/// Sampled on their own, the specular lobes have the same albedo as among the others: that of the coat, and all that
/// black glass reflects.
static void specular_lobes_drawn_alone_carry_their_share(void **state)
{
    (void)state;
    for (int r = 1; r <= 4; r++)
        for (int c = 1; c <= 5; c++) {
            double alone, among;
            rsv_vec3 wo = direction_at(0.19f * (float)c, 1);
            rsv_material material = smooth_material(rgb_gray(0.5f));
            material.opacity = 1;
            material.roughness = 0.25f * (float)r;
            rsv_bsdf bsdf = make_bsdf(&material);
            mean_specular_weights(&bsdf, wo, &alone, &among);
            // the albedo tables are coarse in ior: 7e-4 of the light
            assert_float_equal(alone, among, 1e-3);
            material.transmission = 1;
            material.base_color = rgb_gray(0);
            bsdf = make_bsdf(&material);
            mean_specular_weights(&bsdf, wo, &alone, &among);
            // samples among the others are drawn by rejection: 1e-3 with 2^15 of them
            assert_float_equal(alone, among, 4e-3);
        }
}

/// By Snell's law and Abbe's number of dense flint, V = (n - 1) / (n_blue - n_red).
static void channels_of_a_prism_refract_by_its_abbe_number(void **state)
{
    (void)state;
    const double n = 1.75, abbe = 25,
                 n_of[] = { n - 0.5 * (n - 1) / abbe, n, n + 0.5 * (n - 1) / abbe };
    rsv_material material = smooth_material(rgb_gray(1));
    material.ior = (float)n;
    material.transmission = material.thickness = material.opacity = 1;
    material.roughness = 0;
    material.dispersion = (float)(20 / abbe);
    rsv_bsdf bsdf = make_bsdf(&material);
    assert_true(rsv_bsdf_disperses(&bsdf));
    rsv_rgb sum = rgb_gray(0);
    for (int c = 0; c < 3; c++) {
        rsv_channel channel = (rsv_channel)(RSV_CHANNEL_RED + c);
        rsv_bsdf own = rsv_bsdf_in_channel(&bsdf, channel);
        for (float cos = 0.1f; cos < 1; cos += 0.2f) {
            double sin = sqrt(1 - (double)(cos * cos));
            rsv_bsdf_branches in = rsv_bsdf_evaluate_branches(&own, direction_at(cos, 0), up, true);
            double bent = hypot((double)in.transmit_direction.x, (double)in.transmit_direction.y);
            assert_float_equal(bent, sin / n_of[c], 1e-6);
            // lossless, and back the way it came
            assert_float_equal(in.reflect.g + in.transmit.g, 1, 1e-5);
            rsv_vec3 wo = in.transmit_direction;
            rsv_bsdf_branches out = rsv_bsdf_evaluate_branches(&own, wo, v3_neg(up), false);
            assert_float_equal(
                hypot((double)out.transmit_direction.x, (double)out.transmit_direction.y), sin,
                2e-6);
        }
        sum = rgb_mad(sum, 1.0f / 3, rsv_channel_weight(channel));
    }
    assert_true(sum.r == 1 && sum.g == 1 && sum.b == 1);
    material.roughness = 0.5f; // frosted: colours mix anyway
    bsdf = make_bsdf(&material);
    assert_false(rsv_bsdf_disperses(&bsdf));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dielectric_reflectance_matches_reference_values),
        cmocka_unit_test(refracted_cosine_obeys_snell),
        cmocka_unit_test(conductor_reflectance_matches_reference_values),
        cmocka_unit_test(conductor_without_absorption_is_a_dielectric),
        cmocka_unit_test(mean_reflectance_matches_reference_values),
        cmocka_unit_test(mean_reflectance_is_continuous_towards_no_interface),
        cmocka_unit_test(white_coated_surface_loses_nothing_at_any_angle),
        cmocka_unit_test(diffuse_lobe_is_reciprocal),
        cmocka_unit_test(branches_never_create_energy),
        cmocka_unit_test(sampled_weight_is_value_over_density),
        cmocka_unit_test(mean_sampled_weight_is_the_albedo),
        cmocka_unit_test(samples_follow_their_density),
        cmocka_unit_test(glass_is_lossless_from_both_sides_and_reversible),
        cmocka_unit_test(total_reflection_ignores_the_specular_scale),
        cmocka_unit_test(index_matched_body_is_invisible),
        cmocka_unit_test(thin_sheet_transmits_straight_through_both_ways),
        cmocka_unit_test(backs_of_single_sided_surfaces_are_black),
        cmocka_unit_test(partly_transmitting_body_diffuses_outside_only),
        cmocka_unit_test(absorption_follows_beer_and_lambert),
        cmocka_unit_test(mirror_directions_stay_above_the_surface),
        cmocka_unit_test(channels_of_a_prism_refract_by_its_abbe_number),
        cmocka_unit_test(specular_lobes_drawn_alone_carry_their_share),
        cmocka_unit_test(unlit_material_is_black_to_light_transport),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
