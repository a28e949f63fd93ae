#include "final_path.h"

#include "../render/camera_path.h"
#include "../render/pixel_direct.h"

/// A diffuse surface at the end of a path.
typedef struct diffuse_end {
    const rsv_light_view *solution;
    const rsv_specular_path *path;
    uint32_t face, seed;
} diffuse_end;

static rsv_rgb sampled(const diffuse_end *e, rsv_rgb all, rsv_rgb kept)
{
    return rsv_seen_irradiance(e->solution, e->path, rgb_sub(all, kept), e->seed);
}

static rsv_rgb plain_irradiance(const diffuse_end *e)
{
    const rsv_light_view *s = e->solution;
    float u = e->path->u, v = e->path->v;
    rsv_rgb all = rsv_light_view_direct(s, e->face, u, v, false);
    rsv_rgb kept = rsv_light_view_direct(s, e->face, u, v, true);
    rsv_rgb indirect = rsv_elements_interpolate(s->elements, s->indirect, e->face, u, v);
    return rgb_add(rgb_add(kept, indirect), sampled(e, all, kept));
}

/// For translucent surfaces: samples the light that the diffused level does not resolve.
static rsv_rgb diffused_irradiance(const diffuse_end *e)
{
    const rsv_light_view *s = e->solution;
    float u = e->path->u, v = e->path->v;
    rsv_unresolved detail = rsv_light_unresolved(s, e->face, u, v);
    rsv_rgb all = rsv_light_view_direct(s, e->face, u, v, false);
    rsv_rgb kept = rsv_light_view_direct(s, e->face, u, v, true);
    rsv_rgb seen = rgb_sub(rgb_add(kept, sampled(e, all, kept)), detail.known);
    rsv_rgb stored = rgb_add(rsv_light_view_diffused(s, e->face, u, v, 0),
        rsv_light_view_diffused(s, e->face, u, v, RSV_NONE));
    return rgb_add(stored, rgb_mul(detail.share, seen));
}

/// @param weight radiance at the camera per B / pi
static void add_end(void *light, const rsv_specular_path *path, rsv_rgb weight)
{
    rsv_specular_light *l = light;
    const rsv_light_view *s = l->table->solution;
    rsv_bsdf storage;
    uint32_t face = s->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return;
    const diffuse_end e = { s, path, face, rsv_hash3(l->trail, path->triangle, path->events) };
    rsv_rgb albedo = rsv_specular_bsdf(l->scene, path, &storage)->base_color;
    rsv_rgb irradiance =
        rsv_is_translucent(s, face) ? diffused_irradiance(&e) : plain_irradiance(&e);
    rsv_add_light(l, rgb_scale(rgb_mul(rgb_mul(weight, albedo), irradiance), 1 / RSV_PI));
}

void rsv_add_final_path(rsv_specular_light *l, const rsv_specular_path *path)
{
    const rsv_camera_setting setting = { l->scene, l->lights, NULL, RSV_CAMERA_PATH_DEPTH, false,
        NULL, 0, false, false };
    rsv_add_light(l, rsv_camera_path(&setting, *path, l->trail, NULL, add_end, l));
}
