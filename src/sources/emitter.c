/// Emissive triangles and, where textures make their brightness vary, the cells of a subdivision of them.
#include "emitter_body.h"
#include "lights_internal.h"

#include "../core/core.h"
#include "../scene/twins.h"

/// Places on a textured emitter from which its mean radiance is estimated.
#define RADIANCE_POINTS 64
/// Relative variance where only wider patches see any light: it may lie outside, and then the mean is wrong.
#define BARELY_SEEN 400

bool rsv_emitter_sides_differ(const rsv_scene_view *scene, const rsv_emitter *e)
{
    return e->double_sided && rsv_twins_hide_part(scene, e->triangle);
}

/// Mean over the sides of the emitter, each place standing for a patch.
static rsv_rgb mean_over(
    const rsv_scene_view *scene, const rsv_emitter *e, float width, rsv_emission_spread *spread)
{
    rsv_rgb sum = rgb_gray(0);
    double luminance = 0, squares = 0, most = 0;
    uint32_t points = RADIANCE_POINTS * (rsv_emitter_sides_differ(scene, e) ? 2 : 1);
    for (uint32_t k = 0; k < points; k++) {
        float x, y, u, v;
        rsv_sobol_2d(k % RADIANCE_POINTS, 0, &x, &y);
        rsv_square_to_triangle(x, y, &u, &v);
        rsv_emitter_to_triangle(e, &u, &v);
        rsv_rgb radiance = rsv_emission_at(scene, e->triangle, k >= RADIANCE_POINTS, u, v, width);
        double own = rgb_luminance(radiance);
        sum = rgb_add(sum, radiance);
        luminance += own / points;
        squares += own * own / points;
        if (own <= most) continue;
        most = own;
        spread->u = u, spread->v = v;
    }
    spread->variance = luminance > 0 ? (float)fmax(squares / (luminance * luminance) - 1, 0) : 0;
    return rgb_scale(sum, 1.0f / (float)points);
}

/// Each sample represents its part of the area. If that is dark, wider patches are sampled to find what is between,
/// such as a single bright texel.
static rsv_rgb mean_radiance(
    const rsv_scene_view *scene, const rsv_emitter *e, rsv_emission_spread *spread)
{
    float width = sqrtf(e->area / RADIANCE_POINTS);
    rsv_rgb mean = mean_over(scene, e, width, spread);
    if (!rgb_is_black(mean)) return mean;
    mean = mean_over(scene, e, 2 * width, spread);
    if (!rgb_is_black(mean)) spread->variance = BARELY_SEEN;
    return mean;
}

bool rsv_emission_varies(const rsv_material *m)
{
    if (m->alpha_cutoff == 0 && m->opacity < 1) return true;
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->textures[i].role == RSV_TEXTURE_EMISSION ||
            m->textures[i].role == RSV_TEXTURE_OPACITY)
            return true;
    return false;
}

/// Corners of a cell: two bits of its index per level say which of the four parts it lies in, the last of which is
/// the middle one.
static void cell_corners(int level, uint32_t cell, float u[3], float v[3])
{
    u[0] = 0, u[1] = 1, u[2] = 0;
    v[0] = 0, v[1] = 0, v[2] = 1;
    while (level-- > 0) {
        uint32_t part = cell >> 2 * level & 3;
        float mu[3], mv[3]; // middle of the side opposite to each corner
        for (int k = 0; k < 3; k++) {
            mu[k] = 0.5f * (u[(k + 1) % 3] + u[(k + 2) % 3]);
            mv[k] = 0.5f * (v[(k + 1) % 3] + v[(k + 2) % 3]);
        }
        for (uint32_t k = 0; k < 3; k++) {
            if (k == part) continue;
            uint32_t side = part == 3 ? k : 3 - k - part;
            u[k] = mu[side];
            v[k] = mv[side];
        }
    }
}

void rsv_emitter_follow(const rsv_scene_view *scene, rsv_emitter *e)
{
    const uint32_t *index = scene->triangle[e->triangle];
    for (int i = 0; i < 3; i++)
        e->corner[i] = v3_barycentric(scene->position[index[0]], scene->position[index[1]],
            scene->position[index[2]], e->u[i], e->v[i]);
    rsv_vec3 cross =
        v3_cross(v3_sub(e->corner[1], e->corner[0]), v3_sub(e->corner[2], e->corner[0]));
    e->normal = v3_normalize(cross);
    e->area = 0.5f * v3_length(cross);
}

void rsv_emitter_set_strength(const rsv_scene_view *scene, const rsv_bsdf *material, rsv_emitter *e)
{
    rsv_emission_spread spread;
    e->radiance = e->varies ? mean_radiance(scene, e, &spread) : material->emission;
}

rsv_emitter rsv_emitter_create(const rsv_scene_view *scene, const rsv_bsdf *bsdf, uint32_t triangle,
    int level, uint32_t place, rsv_emission_spread *spread)
{
    const rsv_material *material = &scene->material[scene->triangle_material[triangle]];
    const rsv_bsdf *common = &bsdf[scene->triangle_material[triangle]];
    rsv_emitter emitter = {
        .triangle = triangle,
        .place = place,
        .cells = 1,
        .double_sided = common->double_sided && !rsv_twins_hide(scene, triangle, true),
    };
    cell_corners(level, place >> 2 * (RSV_EMITTER_LEVELS - level), emitter.u, emitter.v);
    rsv_emitter_follow(scene, &emitter);
    emitter.varies = rsv_emission_varies(material) || rsv_twins_hide_part(scene, triangle);
    *spread = (rsv_emission_spread){ 0 };
    emitter.radiance = emitter.varies ? mean_radiance(scene, &emitter, spread) : common->emission;
    return emitter;
}
