/// Lobes over polygons in closed form beside numerical integration of the BSDF over the same lamps.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include "bsdf_cases.h"
#include "highlight/highlight.h"
#include "sources/spherical_triangle.h"

#define SAMPLES 4096

static const rsv_vec3 up = { 0, 0, 1 };

/// A lamp seen from the origin: a convex polygon.
typedef struct lamp {
    rsv_vec3 corner[RSV_HIGHLIGHT_CORNERS];
    uint32_t count;
} lamp;

/// @param half sides, tangents of angles
static lamp quad(rsv_vec3 direction, float half_x, float half_y)
{
    rsv_vec3 t, b;
    v3_frame(direction, &t, &b);
    rsv_vec3 x = v3_scale(t, half_x), y = v3_scale(b, half_y);
    return (lamp){ { v3_sub(v3_sub(direction, x), y), v3_sub(v3_add(direction, x), y),
                       v3_add(v3_add(direction, x), y), v3_add(v3_sub(direction, x), y) },
        4 };
}

static bool is_seen(const lamp *l, rsv_vec3 direction)
{
    int left = 0, right = 0;
    rsv_vec3 middle = v3(0, 0, 0);
    for (uint32_t i = 0; i < l->count; i++) {
        float side = v3_dot(v3_cross(l->corner[i], l->corner[(i + 1) % l->count]), direction);
        left += side > 0, right += side < 0;
        middle = v3_add(middle, l->corner[i]);
    }
    return (left == 0 || right == 0) && v3_dot(middle, direction) > 0;
}

/// Weight of a sample by the power heuristic.
static float power(double own, double other)
{
    return (float)(own * own / (own * own + other * other) / SAMPLES);
}

/// Directions uniform over the lamp and drawn from the BSDF, by the power heuristic.
static rsv_rgb integrate(const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, const lamp *l)
{
    rsv_spherical_triangle part[RSV_HIGHLIGHT_CORNERS];
    rsv_rgb sum = rgb_gray(0);
    double all = 0;
    float chance = rsv_bsdf_specular_chance(bsdf, wo, up, front);
    for (uint32_t i = 0; i + 2 < l->count; i++) {
        rsv_double3 corner[3] = { d3_from(l->corner[0]), d3_from(l->corner[i + 1]),
            d3_from(l->corner[i + 2]) };
        part[i] = rsv_spherical_triangle_from(corner);
        all += part[i].solid_angle;
    }
    for (uint32_t k = 0; k < SAMPLES; k++) {
        float x, y, u, v;
        rsv_sobol_2d(k, 1, &x, &y);
        double place = x * all;
        uint32_t i = 0;
        while (i + 3 < l->count && place >= part[i].solid_angle)
            place -= part[i++].solid_angle;
        rsv_vec3 wi = d3_to_float(
            rsv_spherical_triangle_sample(&part[i], fmin(place / part[i].solid_angle, 1), y));
        rsv_bsdf_value value = rsv_bsdf_evaluate(bsdf, wi, wo, up, front, RSV_LOBES_ROUGH);
        if (value.pdf_solid_angle > 0)
            sum = rgb_mad(
                sum, (float)all * power(1 / all, value.pdf_solid_angle / chance), value.response);
        rsv_sobol_2d(k, 2, &u, &v);
        rsv_bsdf_event event =
            rsv_bsdf_draw_specular(bsdf, wo, up, front, rsv_unit_float(rsv_hash2(k, 3)), u, v);
        if (event.lobe == RSV_LOBE_DIFFUSE || !(event.pdf_solid_angle > 0)) continue;
        if (!is_seen(l, event.direction)) continue;
        value = rsv_bsdf_evaluate(bsdf, event.direction, wo, up, front, RSV_LOBES_ROUGH);
        sum = rgb_mad(sum, power(value.pdf_solid_angle / chance, 1 / all), event.weight);
    }
    return sum;
}

static rsv_vec3 view(float cosine) { return v3(-sqrtf(1 - cosine * cosine), 0, cosine); }

static bool prepare(const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, rsv_highlight_lobes *lobes)
{
    rsv_highlight_point point = { v3(0, 0, 0), up, up, wo, bsdf, front };
    return rsv_highlight_prepare(&point, lobes);
}

static rsv_bsdf case_of(const char *name, float roughness)
{
    const bsdf_case *c = bsdf_cases();
    while (strcmp(c->name, name) != 0)
        c++;
    return bsdf_of(c, roughness);
}

/// Mean relative error where there is more than a fiftieth of the light of even surroundings.
static double mean_error(const rsv_bsdf *bsdf, float cosine, double *worst)
{
    const float offset[] = { 0, -0.15f, 0.15f, -0.5f, -1 }, size[] = { 0.02f, 0.1f, 0.4f, 1.2f };
    double sum = 0;
    int count = 0;
    rsv_highlight_lobes lobes;
    rsv_vec3 wo = view(cosine);
    assert_true(prepare(bsdf, wo, true, &lobes));
    double albedo = (double)rgb_luminance(rsv_highlight_albedo(&lobes));
    *worst = 0;
    for (int k = 0; k < 40; k++) {
        float theta = acosf(cosine) + offset[k % 5], s = size[k / 5 % 4], phi = k < 20 ? 0 : 0.3f;
        lamp l =
            quad(v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta)), s, 0.7f * s);
        double exact = (double)rgb_luminance(integrate(bsdf, wo, true, &l));
        double closed = (double)rgb_luminance(rsv_highlight_polygon(&lobes, l.corner, l.count));
        assert_true(isfinite(closed) && closed >= 0);
        if (exact < 0.02 * albedo) continue;
        double error = fabs(closed / exact - 1);
        sum += error;
        *worst = fmax(*worst, error);
        count++;
    }
    return count ? sum / count : 0;
}

/// What the fit leaves; views from 84 degrees see worse.
static void lamps_are_reflected_as_the_bsdf_says(void **state)
{
    (void)state;
    const char *name[] = { "metal", "coat", "metal under clear coat" };
    const float roughness[] = { 0.05f, 0.1f, 0.2f, 0.3f, 0.5f, 0.7f, 1 };
    const float cosine[] = { 1, 0.7f, 0.3f, 0.1f };
    const double mean[] = { 0.02, 0.025, 0.06, 0.11 }, most[] = { 0.03, 0.07, 0.16, 0.32 };
    for (int n = 0; n < 3; n++) {
        for (int r = 0; r < 7; r++) {
            printf("    %-24s roughness %.2f:", name[n], (double)roughness[r]);
            rsv_bsdf bsdf = case_of(name[n], roughness[r]);
            for (int c = 0; c < 4; c++) {
                double worst, error = mean_error(&bsdf, cosine[c], &worst);
                printf("  %.3f (%.3f)", error, worst);
                assert_true(error < mean[c] && worst < most[c]);
            }
            printf("\n");
        }
    }
}

/// The upper hemisphere as four triangles with their base on the horizon, or so low that they are clipped.
static rsv_rgb over_hemisphere(const rsv_highlight_lobes *lobes, float low)
{
    rsv_rgb sum = rgb_gray(0);
    const rsv_vec3 ring[4] = { v3(1, 0, low), v3(0, 1, low), v3(-1, 0, low), v3(0, -1, low) };
    for (int k = 0; k < 4; k++) {
        rsv_vec3 corner[3] = { ring[k], ring[(k + 1) % 4], up };
        sum = rgb_add(sum, rsv_highlight_polygon(lobes, corner, 3));
    }
    return sum;
}

/// White metal, and glass from outside without refraction: the albedo is the integral of the BSDF.
static void even_light_gives_the_albedo(void **state)
{
    (void)state;
    const float roughness[] = { 0.1f, 0.3f, 0.5f, 0.7f, 1 }, cosine[] = { 1, 0.7f, 0.3f, 0.1f };
    double worst = 0, most = 0;
    for (int r = 0; r < 5; r++) {
        for (int c = 0; c < 4; c++) {
            rsv_highlight_lobes lobes;
            rsv_bsdf white = case_of("metal", roughness[r]);
            assert_true(prepare(&white, view(cosine[c]), true, &lobes));
            double albedo = (double)rsv_highlight_albedo(&lobes).g;
            worst = fmax(worst, fabs(albedo - 1));
            most = fmax(most, fabs((double)over_hemisphere(&lobes, -0.3f).g - 1));
        }
    }
    printf("    white furnace: albedo within %.4f, hemisphere of four lamps within %.4f\n", worst,
        most);
    assert_true(worst < 0.005);
    assert_true(most < 0.15);
}

static void albedos_are_those_of_the_bsdf(void **state)
{
    (void)state;
    const float roughness[] = { 0.1f, 0.3f, 0.6f, 1 }, cosine[] = { 0.95f, 0.5f, 0.15f };
    for (const bsdf_case *c = bsdf_cases(); c->name; c++) {
        double worst = 0;
        for (int k = 0; k < 12; k++) {
            rsv_bsdf bsdf = bsdf_of(c, roughness[k / 3]);
            rsv_highlight_lobes lobes;
            rsv_vec3 wo = view(cosine[k % 3]);
            if (!prepare(&bsdf, wo, true, &lobes)) continue;
            rsv_rgb sum = rgb_gray(0);
            for (uint32_t i = 0; i < 16 * SAMPLES; i++) {
                float x, y;
                rsv_sobol_2d(i, 4, &x, &y);
                rsv_bsdf_event e = rsv_bsdf_draw_specular(
                    &bsdf, wo, up, true, rsv_unit_float(rsv_hash2(i, 5)), x, y);
                bool refracted = lobes.refracts && e.direction.z < 0;
                if (e.lobe != RSV_LOBE_DIFFUSE && e.pdf_solid_angle > 0 && !refracted)
                    sum = rgb_mad(sum, 1.0f / (16 * SAMPLES), e.weight);
            }
            rsv_rgb known = rsv_highlight_albedo(&lobes);
            worst = fmax(worst, fabs((double)(known.r - sum.r)));
            worst = fmax(worst, fabs((double)(known.b - sum.b)));
        }
        printf("    %-24s albedo within %.4f\n", c->name, worst);
        assert_true(worst < (strstr(c->name, "under both") ? 0.03 : 0.01));
    }
}

static void small_and_distant_lamps_are_exact(void **state)
{
    (void)state;
    for (const bsdf_case *c = bsdf_cases(); c->name; c++) {
        for (int k = 0; k < 24; k++) {
            rsv_bsdf bsdf = bsdf_of(c, 0.1f + 0.9f * (float)(k % 4) / 3);
            rsv_highlight_lobes lobes;
            rsv_vec3 wo = view(0.2f + 0.15f * (float)(k % 6));
            if (!prepare(&bsdf, wo, k < 12, &lobes)) continue;
            float x, y;
            rsv_sobol_2d((uint32_t)k, 6, &x, &y);
            rsv_vec3 wi = rsv_square_to_sphere(x, y);
            // within 3 degrees of the horizon the BSDF is not even over these lamps
            if ((lobes.refracts && wi.z < 0) || fabsf(wi.z) < 0.05f) continue;
            // corners are rounded to 6e-5 of its sides
            lamp l = quad(wi, 1e-3f, 1e-3f);
            rsv_rgb closed = rsv_highlight_polygon(&lobes, l.corner, 4);
            rsv_rgb exact = rsv_bsdf_evaluate(&bsdf, wi, wo, up, k < 12, RSV_LOBES_ROUGH).response;
            assert_true(fabsf(closed.g - 4e-6f * exact.g) <= 1e-3f * 4e-6f * exact.g + 1e-12f);
        }
    }
}

static void lamps_below_the_horizon_give_nothing(void **state)
{
    (void)state;
    rsv_bsdf bsdf = case_of("metal", 0.5f);
    rsv_highlight_lobes lobes;
    assert_true(prepare(&bsdf, view(0.5f), true, &lobes));
    lamp l = quad(v3_normalize(v3(0.3f, 0.2f, -1)), 0.2f, 0.2f);
    assert_true(rgb_is_black(rsv_highlight_polygon(&lobes, l.corner, 4)));
    lobes.point.horizon = v3_normalize(v3(-1, 0, 1));
    l = quad(v3_normalize(v3(1, 0, 0.3f)), 0.2f, 0.2f);
    assert_true(rgb_is_black(rsv_highlight_polygon(&lobes, l.corner, 4)));
    l = quad(v3_normalize(v3(-0.2f, 0, 1)), 0.2f, 0.2f);
    assert_true(rsv_highlight_polygon(&lobes, l.corner, 4).g > 0);
}

static void discs_are_what_polygons_of_many_corners_are(void **state)
{
    (void)state;
    for (int r = 0; r < 4; r++) {
        rsv_bsdf bsdf = case_of("metal", 0.1f + 0.2f * (float)r);
        rsv_highlight_lobes lobes;
        rsv_vec3 wo = view(0.6f), direction = v3_normalize(v3(0.75f, 0.05f, 0.62f));
        assert_true(prepare(&bsdf, wo, true, &lobes));
        float cosine = cosf(0.05f), solid_angle = 2 * RSV_PI * (1 - cosine);
        rsv_vec3 t, b;
        double sum = 0;
        v3_frame(direction, &t, &b);
        for (uint32_t k = 0; k < 16384; k++) {
            float x, y;
            rsv_sobol_2d(k, 8, &x, &y);
            float z = 1 - x * (1 - cosine), s = sqrtf(1 - z * z);
            rsv_vec3 wi = v3_mad(v3_mad(v3_scale(direction, z), s * cosf(2 * RSV_PI * y), t),
                s * sinf(2 * RSV_PI * y), b);
            sum += (double)rsv_bsdf_evaluate(&bsdf, wi, wo, up, true, RSV_LOBES_ROUGH).response.g;
        }
        double exact = sum / 16384 * (double)solid_angle;
        double closed = (double)rsv_highlight_disc(&lobes, direction, cosine).g;
        printf("    disc of 2.9 degrees, roughness %.1f: error %.4f\n", 0.1 + 0.2 * r,
            closed / exact - 1);
        assert_true(fabs(closed / exact - 1) < 0.03);
    }
}

static void speed(void **state)
{
    (void)state;
    enum { ROUNDS = 20000 };
    const char *name[] = { "metal", "coat", "metal under clear coat" };
    for (int n = 0; n < 3; n++) {
        for (int c = 0; c < 3; c++) {
            rsv_bsdf bsdf = case_of(name[n], 0.3f);
            rsv_highlight_lobes lobes;
            lamp l = quad(v3_normalize(v3(0.4f, 0.1f, 1)), 0.3f, 0.3f);
            rsv_rgb sum = rgb_gray(0);
            clock_t begin = clock();
            for (int k = 0; k < ROUNDS; k++)
                prepare(&bsdf, view(0.9f - 0.3f * (float)c + 1e-6f * (float)k), true, &lobes);
            clock_t middle = clock();
            for (int k = 0; k < ROUNDS; k++) {
                l.corner[0].x += 1e-6f;
                sum = rgb_add(sum, rsv_highlight_polygon(&lobes, l.corner, 4));
            }
            clock_t end = clock();
            double unit = 1e9 / CLOCKS_PER_SEC / ROUNDS;
            printf("    %-24s cosine %.1f: prepared in %4.0f ns, a quad in %4.0f ns (%g)\n",
                name[n], 0.9 - 0.3 * c, (double)(middle - begin) * unit,
                (double)(end - middle) * unit, (double)sum.g / ROUNDS);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_are_reflected_as_the_bsdf_says),
        cmocka_unit_test(even_light_gives_the_albedo),
        cmocka_unit_test(albedos_are_those_of_the_bsdf),
        cmocka_unit_test(small_and_distant_lamps_are_exact),
        cmocka_unit_test(lamps_below_the_horizon_give_nothing),
        cmocka_unit_test(discs_are_what_polygons_of_many_corners_are),
        cmocka_unit_test(speed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
