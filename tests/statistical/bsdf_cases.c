#include "bsdf_cases.h"

static rsv_material white(void)
{
    rsv_material material = { .base_color = { 1, 1, 1 },
        .ior = 1.5f,
        .specular = 1,
        .specular_color = { 1, 1, 1 },
        .attenuation_color = { 1, 1, 1 },
        .attenuation_distance = INFINITY,
        .diffuse_transmission_color = { 1, 1, 1 },
        .iridescence_ior = 1.3f,
        .opacity = 1 };
    return material;
}

static rsv_material blend(float metallic, float transmission, float thickness, float ior)
{
    rsv_material material = white();
    material.metallic = metallic;
    material.transmission = transmission;
    material.thickness = thickness;
    material.ior = ior;
    return material;
}

static rsv_material filmed(rsv_material material, float ior, float nanometres)
{
    material.iridescence = 1;
    material.iridescence_ior = ior;
    material.iridescence_thickness_max = nanometres;
    return material;
}

static rsv_material brushed(rsv_material material, float strength)
{
    material.anisotropy = strength;
    return material;
}

const bsdf_case *bsdf_cases(void)
{
    static bsdf_case cases[24];
    size_t count = 0;
    cases[count++] = (bsdf_case){ "metal", blend(1, 0, 0, 1.5f), false };
    cases[count++] = (bsdf_case){ "coat", blend(0, 0, 0, 1.5f), false };
    cases[count++] = (bsdf_case){ "coat of high index", blend(0, 0, 0, 2.4f), false };
    cases[count++] = (bsdf_case){ "glass", blend(0, 1, 1, 1.5f), true };
    cases[count++] = (bsdf_case){ "water", blend(0, 1, 1, 1.33f), true };
    cases[count++] = (bsdf_case){ "sheet", blend(0, 1, 0, 1.5f), true };
    cases[count++] = (bsdf_case){ "blend", blend(0.3f, 0.5f, 0, 1.5f), false };
    rsv_material layered = blend(0, 0, 0, 1.5f);
    layered.clearcoat = 1;
    layered.clearcoat_roughness = 0.3f;
    cases[count++] = (bsdf_case){ "clear coat", layered, false };
    layered = blend(0, 0, 0, 1.5f);
    layered.sheen_color = rgb(1, 0.6f, 0.2f);
    layered.sheen_roughness = 0.4f;
    layered.specular = 0;
    cases[count++] = (bsdf_case){ "sheen", layered, false };
    layered = blend(0, 0, 0, 1.5f);
    layered.diffuse_transmission = 0.6f;
    layered.double_sided = true;
    cases[count++] = (bsdf_case){ "leaf", layered, true };
    layered = blend(1, 0, 0, 1.5f);
    layered.clearcoat = 1;
    layered.clearcoat_roughness = 0.3f;
    cases[count++] = (bsdf_case){ "metal under clear coat", layered, false };
    layered.sheen_color = rgb(0.3f, 1, 1);
    layered.sheen_roughness = 0.7f;
    layered.transmission = 0.5f;
    layered.metallic = 0.5f;
    layered.double_sided = true;
    cases[count++] = (bsdf_case){ "blend under both layers", layered, true };
    cases[count++] = (bsdf_case){ "coat under film", filmed(blend(0, 0, 0, 1.5f), 2, 350), false };
    cases[count++] =
        (bsdf_case){ "glass under film", filmed(blend(0, 1, 1, 1.5f), 1.8f, 300), true };
    cases[count++] = (bsdf_case){ "soap", filmed(blend(0, 1, 0, 1), 1.33f, 500), true };
    cases[count++] =
        (bsdf_case){ "blend under film", filmed(blend(0.3f, 0.5f, 0, 1.5f), 1.3f, 400), false };
    cases[count++] = (bsdf_case){ "brushed metal", brushed(blend(1, 0, 0, 1.5f), 0.6f), false };
    cases[count++] = (bsdf_case){ "metal brushed well", brushed(blend(1, 0, 0, 1.5f), 1), false };
    cases[count++] =
        (bsdf_case){ "brushed blend", brushed(blend(0.4f, 0.5f, 0, 1.5f), 0.3f), false };
    layered = brushed(blend(1, 0, 0, 1.5f), 0.8f);
    layered.clearcoat = 1;
    layered.clearcoat_roughness = 0.3f;
    cases[count++] = (bsdf_case){ "brushed metal under clear coat", layered, false };
    cases[count] = (bsdf_case){ .name = NULL };
    return cases;
}

rsv_bsdf bsdf_of(const bsdf_case *c, float roughness)
{
    rsv_material material = c->material;
    material.roughness = roughness;
    rsv_bsdf bsdf = rsv_bsdf_from_material(&material);
    bsdf.brush = v3(cosf(1), sinf(1), 0);
    return bsdf;
}

void bsdf_charts(const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, bsdf_chart chart[2])
{
    float cos_t, eta = bsdf->solid && !front ? 1 / bsdf->ior : bsdf->ior;
    rsv_fresnel_dielectric(wo.z, eta, &cos_t);
    for (int below = 0; below < 2; below++) {
        bsdf_chart *c = &chart[below];
        c->wo = wo;
        c->side = below ? -1 : 1;
        c->half_vectors = !below || !bsdf->solid;
        c->scale = bsdf->alpha > 0 ? bsdf->alpha : 1;
        c->axis = c->half_vectors ? v3(0, 0, 1) : v3(-wo.x / eta, -wo.y / eta, -cos_t);
        c->axis = v3_normalize(c->axis);
        v3_frame(c->axis, &c->tangent, &c->bitangent);
        c->stretch = 1;
        if (bsdf->brushed && c->half_vectors) {
            c->stretch = sqrtf(bsdf->brush_along / bsdf->brush_across);
            c->scale = sqrtf(bsdf->brush_along * bsdf->brush_across);
            rsv_brush_frame(bsdf, c->axis, &c->tangent, &c->bitangent);
            continue;
        }
        rsv_vec3 across = v3_mad(wo, -v3_dot(wo, c->axis), c->axis);
        if (v3_dot(across, across) < 1e-6f) continue; // along the axis: any frame will do
        c->tangent = v3_normalize(across);
        c->bitangent = v3_cross(c->axis, c->tangent);
    }
}

/// Radius 0 .. infinity of u = 0 .. 1: grows like the scale at first, then reaches out.
static double radius_at(const bsdf_chart *c, double u)
{
    return ((double)c->scale + u * u * u) * u / (1 - u);
}
static double radius_slope(const bsdf_chart *c, double u)
{
    return 3 * u * u * u / (1 - u) + ((double)c->scale + u * u * u) / ((1 - u) * (1 - u));
}
/// Newton's method on u^4 + (scale + radius) u = radius, from above, where it is convex.
static double radius_inverse(const bsdf_chart *c, double radius)
{
    double slope = (double)c->scale + radius, u = radius / slope, step = 1;
    while (step > 1e-8) {
        step = (u * u * u * u + slope * u - radius) / (4 * u * u * u + slope);
        u -= step;
    }
    return u;
}

static rsv_vec3 turned(const bsdf_chart *c, double cosine, double sine, double phi)
{
    rsv_vec3 w = v3_scale(c->axis, (float)cosine);
    w = v3_mad(w, (float)(sine * cos(phi)), c->tangent);
    return v3_normalize(v3_mad(w, (float)(sine * sin(phi)), c->bitangent));
}

rsv_vec3 bsdf_chart_direction(const bsdf_chart *c, float u, float v, double *jacobian)
{
    double r = radius_at(c, u), phi = 2 * (double)RSV_PI * (double)v, q = 1 + r * r;
    double per_square = 2 * (double)RSV_PI * r * radius_slope(c, u);
    rsv_vec3 w;
    if (c->half_vectors) { // r is the slope of the half vector
        double stretch = (double)c->stretch, x = r * cos(phi) * stretch, y = r * sin(phi) / stretch;
        q = 1 + x * x + y * y;
        rsv_vec3 h = turned(c, 1 / sqrt(q), sqrt(x * x + y * y) / sqrt(q), atan2(y, x));
        double cos_h = (double)v3_dot(h, c->wo);
        w = v3_sub(v3_scale(h, (float)(2 * cos_h)), c->wo);
        *jacobian = per_square / (q * sqrt(q)) * 4 * fabs(cos_h);
        if (c->side < 0) w.z = -w.z;
        if (cos_h <= 0) *jacobian = 0;
    } else { // r is the tangent of half the distance
        w = turned(c, (1 - r * r) / q, 2 * r / q, phi);
        *jacobian = per_square * 4 / (q * q);
    }
    if (w.z * c->side <= 0) *jacobian = 0;
    return v3_normalize(w);
}

void bsdf_chart_locate(const bsdf_chart *c, rsv_vec3 w, float *u, float *v)
{
    rsv_vec3 p = w;
    if (c->half_vectors) p = v3_normalize(v3_add(c->wo, v3(w.x, w.y, fabsf(w.z))));
    double x = (double)v3_dot(p, c->tangent), y = (double)v3_dot(p, c->bitangent);
    x /= (double)c->stretch, y *= (double)c->stretch;
    double z = (double)v3_dot(p, c->axis), across = sqrt(x * x + y * y);
    *u = (float)radius_inverse(c, across / fmax(c->half_vectors ? z : 1 + z, 1e-9));
    double turn = atan2(y, x) / (2 * (double)RSV_PI);
    *v = (float)(turn < 0 ? turn + 1 : turn);
}

bsdf_integral bsdf_integrate(
    const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, const bsdf_chart *chart, bsdf_patch p)
{
    const rsv_vec3 up = { 0, 0, 1 };
    bsdf_integral sum = { 0 };
    double area = (double)(p.u1 - p.u0) * (double)(p.v1 - p.v0) / (p.steps_u * p.steps_v);
    for (int i = 0; i < p.steps_u * p.steps_v; i++) {
        float x = ((float)(i % p.steps_u) + 0.5f) / (float)p.steps_u;
        float y = ((float)(i / p.steps_u) + 0.5f) / (float)p.steps_v;
        double jacobian;
        rsv_vec3 wi = bsdf_chart_direction(
            chart, p.u0 + x * (p.u1 - p.u0), p.v0 + y * (p.v1 - p.v0), &jacobian);
        if (jacobian == 0) continue;
        rsv_bsdf_value value = rsv_bsdf_evaluate(bsdf, wi, wo, up, front, RSV_LOBES_ALL);
        sum.response[0] += area * jacobian * (double)value.response.r;
        sum.response[1] += area * jacobian * (double)value.response.g;
        sum.response[2] += area * jacobian * (double)value.response.b;
        sum.density += area * jacobian * (double)value.pdf_solid_angle;
    }
    return sum;
}

bsdf_integral bsdf_integrate_all(
    const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, int steps_u, int steps_v)
{
    // the plane of wo mirrors all but brushed surfaces
    bsdf_patch half = { 0, 1, 0, 0.5f, steps_u, steps_v / 2 };
    int halves = bsdf->brushed ? 1 : 2;
    if (bsdf->brushed) half.v1 = 1, half.steps_v = steps_v;
    bsdf_chart chart[2];
    bsdf_charts(bsdf, wo, front, chart);
    bsdf_integral sum = bsdf_integrate(bsdf, wo, front, &chart[0], half);
    bsdf_integral below = bsdf_integrate(bsdf, wo, front, &chart[1], half);
    for (int i = 0; i < 3; i++)
        sum.response[i] = halves * (sum.response[i] + below.response[i]);
    sum.density = halves * (sum.density + below.density);
    return sum;
}
