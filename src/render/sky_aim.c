#include "sky_aim.h"

#include "../core/octahedral.h"

/// A lobe's half vectors are spread by so much more over a square, about.
#define SQUARE_ALPHA 0.05f
/// Smallest cosine of a visible square: its centre may be below the horizon.
#define LEAST_COSINE 0.02f

/// A microsurface about a normal, its reflectance given by Schlick's approximation.
typedef struct rough_lobe {
    float alpha2, normal_reflectance;
    rsv_vec3 normal;
    float cos_o;
} rough_lobe;

static rough_lobe lobe_of(float alpha, float reflectance, rsv_vec3 normal, rsv_vec3 wo)
{
    return (rough_lobe){ alpha * alpha + SQUARE_ALPHA * SQUARE_ALPHA, reflectance, normal,
        v3_dot(normal, wo) };
}

/// @param lobe [3] @return their number
static int find_lobes(const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, rough_lobe *lobe)
{
    int count = 0;
    float off = (bsdf->ior - 1) / (bsdf->ior + 1);
    float metal = bsdf->metallic * rgb_luminance(bsdf->base_color);
    float interface = (1 - bsdf->metallic) * rgb_luminance(bsdf->specular_tint) * off * off;
    if (bsdf->alpha > 0) lobe[count++] = lobe_of(bsdf->alpha, metal + interface, n, wo);
    if (bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0)
        lobe[count++] = lobe_of(
            bsdf->clearcoat_alpha, 0.04f * bsdf->clearcoat, rsv_bsdf_coat_normal(bsdf, wo, n), wo);
    rsv_rgb wide = rsv_bsdf_wide_layers_most(bsdf);
    if (rgb_max(wide) > 0) lobe[count++] = lobe_of(1, rgb_luminance(wide), n, wo);
    return count;
}

/// F D G1(wi): the response without the factors that depend only on wo.
static float reflect(const rough_lobe *lobe, rsv_vec3 wi, float cos_oi)
{
    float cos_i = f_max(v3_dot(wi, lobe->normal), LEAST_COSINE);
    float chord2 = f_max(2 + 2 * cos_oi, 1e-6f), sum = lobe->cos_o + cos_i; // of wo + wi
    float cos2_n = f_min(sum * sum, chord2) / chord2; // of wi's height as it was raised
    float spread = 1 + (lobe->alpha2 - 1) * cos2_n;
    float cos_h = 0.5f * sqrtf(chord2), x = 1 - cos_h, x2 = x * x;
    float fresnel = lobe->normal_reflectance + (1 - lobe->normal_reflectance) * x2 * x2 * x;
    float seen = cos_i / (cos_i + sqrtf(lobe->alpha2 + (1 - lobe->alpha2) * cos_i * cos_i));
    return fresnel * lobe->alpha2 * seen / (spread * spread);
}

void rsv_sky_aim_at(const rsv_sky_visibility *visibility, const rsv_visible_sky *visible,
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 normal, rsv_sky_aim *aim)
{
    rough_lobe lobe[3];
    int lobes = find_lobes(bsdf, wo, normal, lobe);
    float sum = 0;
    aim->square = visibility->square;
    aim->count = 0;
    for (uint32_t k = 0; visible && k < visible->count; k++) {
        const rsv_sky_square *square = &aim->square[visible->square[k]];
        float weight = 0;
        for (int l = 0; l < lobes; l++)
            weight += reflect(&lobe[l], square->direction, v3_dot(square->direction, wo));
        weight *= square->luminance;
        if (!(weight > 0)) continue;
        aim->choice[aim->count] = visible->square[k];
        aim->chance[aim->count++] = weight;
        sum += weight;
    }
    for (uint32_t k = 0; k < aim->count; k++)
        aim->chance[k] /= sum;
}

rsv_vec3 rsv_sky_aim_sample(const rsv_sky_aim *aim, const float u[3])
{
    uint32_t k = 0;
    float rest = u[0] - aim->chance[0];
    while (rest >= 0 && k + 1 < aim->count)
        rest -= aim->chance[++k];
    const rsv_sky_square *square = &aim->square[aim->choice[k]];
    return rsv_octahedral_to_direction(
        square->x + (2 * u[1] - 1) * square->half, square->y + (2 * u[2] - 1) * square->half);
}

float rsv_sky_aim_pdf(const rsv_sky_aim *aim, rsv_vec3 direction)
{
    float x, y, density = 0;
    if (aim->count == 0) return 0;
    rsv_octahedral_from_direction(direction, &x, &y);
    for (uint32_t k = 0; k < aim->count; k++) {
        const rsv_sky_square *square = &aim->square[aim->choice[k]];
        if (fabsf(x - square->x) <= square->half && fabsf(y - square->y) <= square->half)
            density += aim->chance[k] / (4 * square->half * square->half);
    }
    // the octahedron's faces, seen from its centre: dw = 4 (|x| + |y| + |z|)^3 dx dy
    float norm = fabsf(direction.x) + fabsf(direction.y) + fabsf(direction.z);
    return density / (4 * norm * norm * norm);
}
