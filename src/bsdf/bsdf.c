#include "bsdf.h"

static rsv_rgb one_minus(rsv_rgb a) { return rgb(1 - a.r, 1 - a.g, 1 - a.b); }

static float rgb_mean(rsv_rgb a) { return (a.r + a.g + a.b) / 3; }

static rsv_rgb metal_reflectance(rsv_rgb base_color, float cos)
{
    float x = 1 - cos, x5 = x * x * (x * x) * x;
    return rgb_mad(base_color, x5, one_minus(base_color));
}

static rsv_vec3 mirror_direction(rsv_vec3 wo, rsv_vec3 n)
{
    return v3_normalize(v3_sub(v3_scale(n, 2 * v3_dot(n, wo)), wo));
}

rsv_vec3 rsv_bsdf_specular_normal(rsv_vec3 shading, rsv_vec3 geometric, rsv_vec3 wo)
{
    bool above = v3_dot(shading, wo) > 0 && v3_dot(geometric, mirror_direction(wo, shading)) > 0;
    return above ? shading : geometric;
}

/// Snell's law; `eta` is the far side's ior over that of wo's side.
static rsv_vec3 refracted_direction(rsv_vec3 wo, rsv_vec3 n, float eta, float cos_o, float cos_t)
{
    return v3_normalize(v3_mad(v3_scale(wo, -1 / eta), cos_o / eta - cos_t, n));
}

/// Whether light scatters diffusely on this side: inside a body and behind one-sided surfaces not.
static bool diffuses(const rsv_bsdf *bsdf, bool front)
{
    return bsdf->diffuse > 0 && (front || (bsdf->double_sided && !bsdf->solid));
}

rsv_rgb rsv_bsdf_entry(const rsv_bsdf *bsdf, float cos)
{
    if (!bsdf->coated) return rgb_gray(1);
    float cos_t;
    float fresnel = rsv_fresnel_dielectric(f_min(f_max(cos, 0), 1), bsdf->ior, &cos_t);
    return one_minus(rgb_scale(bsdf->specular_tint, fresnel));
}

rsv_bsdf_branches rsv_bsdf_evaluate_branches(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    rsv_bsdf_branches branches = { .transmit_direction = v3_neg(wo) };
    if (!front && !bsdf->double_sided && bsdf->transmission == 0) return branches;
    if (bsdf->lambert) {
        branches.diffuse = rgb_gray(1);
        branches.reflect_direction = n;
        return branches;
    }

    float cos_o = f_min(f_max(v3_dot(n, wo), 0), 1), cos_t;
    float eta = bsdf->solid && !front ? 1 / bsdf->ior : bsdf->ior;
    float fresnel = rsv_fresnel_dielectric(cos_o, eta, &cos_t);
    // a weakened or tinted interface still reflects totally: nothing else can become of that light
    rsv_rgb reflected =
        fresnel >= 1 && bsdf->solid ? rgb_gray(1) : rgb_scale(bsdf->specular_tint, fresnel);
    rsv_rgb passed = one_minus(reflected);
    float dielectric = 1 - bsdf->metallic;

    branches.reflect_direction = mirror_direction(wo, n);
    branches.reflect = rgb_mad(rgb_scale(reflected, dielectric), bsdf->metallic,
        metal_reflectance(bsdf->base_color, cos_o));
    branches.transmit =
        rgb_scale(rgb_mul(passed, bsdf->base_color), dielectric * bsdf->transmission);
    if (bsdf->solid) branches.transmit_direction = refracted_direction(wo, n, eta, cos_o, cos_t);
    if (diffuses(bsdf, front)) branches.diffuse = rgb_scale(passed, bsdf->diffuse);
    return branches;
}

/// Chances of the three lobes, proportional to the light they carry; false if they carry none.
static bool lobe_probabilities(const rsv_bsdf *bsdf, const rsv_bsdf_branches *branches,
    float *reflect, float *transmit, float *diffuse)
{
    float r = rgb_mean(branches->reflect), t = rgb_mean(branches->transmit);
    float d = rgb_mean(rgb_mul(branches->diffuse, bsdf->base_color)), sum = r + t + d;
    if (!(sum > 0)) return false;
    *reflect = r / sum;
    *transmit = t / sum;
    *diffuse = d / sum;
    return true;
}

static rsv_bsdf_sample delta_sample(rsv_lobe lobe, rsv_vec3 direction, rsv_rgb branch, float chance)
{
    return (rsv_bsdf_sample){ lobe, direction, rgb_scale(branch, 1 / chance), 0 };
}

rsv_bsdf_sample rsv_bsdf_sample_direction(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, float u_lobe, float u1, float u2)
{
    rsv_bsdf_sample none = { RSV_LOBE_NONE, n, rgb_gray(0), 0 };
    rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(bsdf, wo, n, front);
    float reflect, transmit, diffuse;
    if (!lobe_probabilities(bsdf, &branches, &reflect, &transmit, &diffuse)) return none;
    if (u_lobe < reflect)
        return delta_sample(
            RSV_LOBE_REFLECT, branches.reflect_direction, branches.reflect, reflect);
    if (u_lobe < reflect + transmit)
        return delta_sample(
            RSV_LOBE_TRANSMIT, branches.transmit_direction, branches.transmit, transmit);
    if (diffuse == 0) return none; // rounding left u_lobe above the sum of the others

    rsv_vec3 local = rsv_square_to_cosine_hemisphere(u1, u2), tangent, bitangent;
    v3_frame(n, &tangent, &bitangent);
    rsv_vec3 direction = v3_mad(v3_mad(v3_scale(n, local.z), local.x, tangent), local.y, bitangent);
    rsv_rgb exitance = rgb_mul(bsdf->exitance_albedo, rsv_bsdf_entry(bsdf, local.z));
    rsv_rgb weight = rgb_scale(rgb_mul(branches.diffuse, exitance), 1 / diffuse);
    return (rsv_bsdf_sample){ RSV_LOBE_DIFFUSE, v3_normalize(direction), weight,
        diffuse * local.z / RSV_PI };
}

rsv_rgb rsv_bsdf_eval(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_i = v3_dot(n, wi);
    if (cos_i <= 0) return rgb_gray(0);
    rsv_rgb value = rgb_scale(bsdf->exitance_albedo, bsdf->diffuse / RSV_PI);
    if (!bsdf->coated) return value;
    rsv_rgb entering = rsv_bsdf_entry(bsdf, cos_i), leaving = rsv_bsdf_entry(bsdf, v3_dot(n, wo));
    return rgb_mul(value, rgb_mul(entering, leaving));
}

float rsv_bsdf_pdf(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_i = v3_dot(n, wi), reflect, transmit, diffuse;
    rsv_bsdf_branches branches = rsv_bsdf_evaluate_branches(bsdf, wo, n, true);
    if (cos_i <= 0 || !lobe_probabilities(bsdf, &branches, &reflect, &transmit, &diffuse)) return 0;
    return diffuse * cos_i / RSV_PI;
}
