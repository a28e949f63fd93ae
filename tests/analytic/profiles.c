/// The formulas of src/subsurface against family h of tests/validation/cases.json: functions, so to the digits of the
/// file (formulas 1e-9, sums over the profile 1e-6).
#include "case_file.h"

#include "subsurface/dipole.h"
#include "subsurface/normalized_diffusion.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FORMULA 1e-9
#define INTEGRAL 1e-6
#define PI 3.14159265358979323846

static double parameter(const cJSON *item, const char *name)
{
    const cJSON *params = cJSON_GetObjectItem(item, "params");
    return cJSON_GetNumberValue(cJSON_GetObjectItem(cJSON_GetObjectItem(params, name), "value"));
}

/// The number behind "@r=", "@a=" or "@x=".
static double place_in(const char *name)
{
    const char *at = strchr(name, '=');
    return at ? strtod(at + 1, NULL) : 0;
}

typedef double (*radial)(const void *profile, double r);

/// int f(r) weight(r) dr from `start` to where the profile ends; r = start + (end - start) s^3 is dense at the start.
static double integrate(
    radial profile, const void *of, double start, double end, double (*weight)(double, double))
{
    const int steps = 200000;
    double sum = 0;
    for (int k = 0; k < steps; k++) {
        double s = (k + 0.5) / steps, r = start + (end - start) * s * s * s;
        sum += profile(of, r) * weight(r, start) * (end - start) * 3 * s * s / steps;
    }
    return sum;
}
static double ring(double r, double start)
{
    (void)start;
    return 2 * PI * r;
}
/// Part of a ring that lies beyond a straight edge at distance x from the ring's centre.
static double ring_beyond(double r, double x) { return 2 * r * acos(fmin(x / r, 1)); }

// ---- dipole -------------------------------------------------------------------------------------

static double dipole_at(const void *of, double r) { return rsv_dipole_profile(of, r); }

static double dipole_value(const cJSON *item, const char *name, double *tolerance)
{
    double scattering = parameter(item, "sigma_s_prime"), absorption = parameter(item, "sigma_a");
    double eta = parameter(item, "eta"), at = place_in(name);
    rsv_dipole dipole = rsv_dipole_create(scattering, absorption, eta);
    if (strcmp(name, "Rd_total") == 0) return rsv_dipole_reflectance(&dipole);
    if (strcmp(name, "A") == 0) return dipole.boundary;
    if (strcmp(name, "sigma_tr") == 0) return dipole.decay;
    if (strcmp(name, "z_r") == 0) return dipole.real;
    if (strcmp(name, "z_v") == 0) return dipole.image;
    if (strncmp(name, "R@", 2) == 0) return rsv_dipole_profile(&dipole, at);
    *tolerance = INTEGRAL;
    if (strncmp(name, "disk_center", 11) == 0) return integrate(dipole_at, &dipole, 0, at, ring);
    if (strncmp(name, "edge", 4) == 0)
        return integrate(dipole_at, &dipole, at, at + 40 / dipole.decay, ring_beyond);
    return NAN; // with a Fresnel mean that the dipole does not use
}

// ---- normalised diffusion -----------------------------------------------------------------------

static double scale_named(const char *name, double albedo)
{
    if (strstr(name, "searchlight_volume_mfp")) return rsv_searchlight_scale(albedo);
    if (strstr(name, "diffuse_surface")) return rsv_diffuse_surface_scale(albedo);
    return rsv_diffuse_path_scale(albedo);
}

static double diffusion_value(const cJSON *item, const char *name)
{
    double albedo = parameter(item, "A"), scale = scale_named(name, albedo);
    double d = parameter(item, "mfp") / scale, at = place_in(name);
    if (strncmp(name, "s_", 2) == 0) return scale;
    if (strncmp(name, "integral", 8) == 0) return albedo * rsv_diffusion_cdf(d, INFINITY);
    if (strncmp(name, "cdf", 3) == 0) return rsv_diffusion_cdf(d, at);
    return albedo * rsv_diffusion_profile(d, at);
}

// ---- the file -----------------------------------------------------------------------------------

static int check_case(const cJSON *item, int *checked)
{
    const char *id = cJSON_GetStringValue(cJSON_GetObjectItem(item, "id"));
    const cJSON *expected;
    int failed = 0;
    cJSON_ArrayForEach(expected, cJSON_GetObjectItem(item, "expected"))
    {
        const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(expected, "name"));
        double wanted = cJSON_GetNumberValue(cJSON_GetObjectItem(expected, "value"));
        double tolerance = FORMULA;
        double value = strncmp(id, "h.dipole", 8) == 0 ? dipole_value(item, name, &tolerance)
                                                       : diffusion_value(item, name);
        if (isnan(value)) continue;
        bool pass = fabs(value - wanted) <= tolerance * fabs(wanted);
        if (!pass) printf("%s %s: %.12g, expected %.12g\n", id, name, value, wanted);
        failed += !pass;
        ++*checked;
    }
    return failed;
}

int main(void)
{
    cJSON *json = case_file_read();
    int failed = 0, checked = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItem(json, "cases"))
    {
        const char *id = cJSON_GetStringValue(cJSON_GetObjectItem(item, "id"));
        if (strncmp(id, "h.", 2) == 0) failed += check_case(item, &checked);
    }
    cJSON_Delete(json);
    printf("%d values checked, %d failed\n", checked, failed);
    return failed || !checked ? EXIT_FAILURE : EXIT_SUCCESS;
}
