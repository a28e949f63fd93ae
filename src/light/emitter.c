/// Emissive triangles and, where textures make their brightness vary, the cells of a subdivision of them.
#include "emitter_body.h"
#include "light_internal.h"

#include "../core/core.h"
#include "../scene/twins.h"

/// Places on a textured emitter from which its mean radiance is estimated.
#define RADIANCE_POINTS 64

/// Mean over the emitter, each place standing for its share of the area.
static rsv_rgb mean_radiance(const rsv_scene_view *scene, const rsv_emitter *e)
{
    rsv_rgb sum = rgb_gray(0);
    float width = sqrtf(e->area / RADIANCE_POINTS);
    for (uint32_t k = 0; k < RADIANCE_POINTS; k++) {
        float x, y, u, v;
        rsv_sobol_2d(k, 0, &x, &y);
        rsv_square_to_triangle(x, y, &u, &v);
        rsv_emitter_to_triangle(e, &u, &v);
        sum = rgb_add(sum, rsv_emission_at(scene, e->triangle, u, v, width));
    }
    return rgb_scale(sum, 1.0f / RADIANCE_POINTS);
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
    e->radiance = e->varies ? mean_radiance(scene, e) : material->emission;
}

rsv_emitter rsv_emitter_create(
    const rsv_scene_view *scene, const rsv_bsdf *bsdf, uint32_t triangle, int level, uint32_t cell)
{
    const rsv_bsdf *material = &bsdf[scene->triangle_material[triangle]];
    rsv_emitter emitter = { .triangle = triangle,
        .level = (uint8_t)level,
        .double_sided = material->double_sided && !rsv_twins_hide(scene, triangle, true) };
    cell_corners(level, cell, emitter.u, emitter.v);
    rsv_emitter_follow(scene, &emitter);
    emitter.varies = rsv_emission_varies(&scene->material[scene->triangle_material[triangle]]);
    rsv_emitter_set_strength(scene, material, &emitter);
    return emitter;
}
