#include "specular_light.h"

#include "../render/camera_path.h"

void rsv_specular_light_refresh(rsv_specular_light *l)
{
    l->lights = l->table->solution->lights;
    l->sky = l->lights->environment ? l->lights->environment->whole : (rsv_sky){ 0 };
}

void rsv_add_sky(rsv_specular_light *l, rsv_vec3 direction, rsv_rgb weight)
{
    if (l->sky.pixel && rsv_shows_emission(l->table))
        rsv_add_light(l, rgb_mul(weight, rsv_sky_radiance(&l->sky, direction)));
}

/// The light of a point with the object's shadow.
static rsv_rgb shaded(const rsv_mover *mover, const rsv_receiver *receiver, uint32_t stream,
    rsv_rgb albedo, rsv_rgb shown)
{
    rsv_rgb kept = rsv_mover_shadow(mover, receiver, stream);
    return rgb_positive(rgb_sub(shown, rgb_scale(rgb_mul(albedo, kept), 1 / RSV_PI)));
}

rsv_rgb rsv_shade_stored(const rsv_light_table *table, const rsv_mover *mover,
    const rsv_ray_packet *rays, uint32_t lane, uint32_t stream, rsv_rgb shown)
{
    const rsv_light_view *s = table->solution;
    uint32_t triangle = rays->triangle[lane];
    bool back = rsv_packet_meets_back(rays, lane);
    if (s->elements->face_of[back][triangle] == RSV_NONE) return shown;
    float u = rays->u[lane], v = rays->v[lane];
    rsv_receiver receiver = rsv_receiver_at(s->scene.view, s->tracer, triangle, u, v,
        rsv_surface_point_at(s->scene.view, triangle, u, v, back));
    rsv_rgb albedo = s->bsdf[s->scene.view->triangle_material[triangle]].base_color;
    return shaded(mover, &receiver, stream, albedo, shown);
}

void rsv_add_stored(rsv_specular_light *l, rsv_rgb throughput, const rsv_ray_packet *rays,
    const rsv_packet_places *places, uint32_t lane)
{
    rsv_float4 light = rsv_light_in_cell(l->table->cell, rsv_packet_place(places, lane));
    rsv_rgb shown = rgb(light[0], light[1], light[2]);
    if (l->mover) shown = rsv_shade_stored(l->table, l->mover, rays, lane, l->trail, shown);
    rsv_add_light(l, rgb_mul(throughput, shown));
}

/// Whether a path still runs along the camera's ray.
static bool is_straight(const rsv_specular_light *l, const rsv_specular_path *path)
{
    if (path->events == 0) return true;
    rsv_surface_point at =
        rsv_surface_point_at(l->scene->view, path->triangle, path->u, path->v, path->back);
    rsv_vec3 ray = l->parallel ? l->forward : v3_normalize(v3_sub(at.position, l->eye));
    return rsv_runs_straight(ray, path->direction);
}

void rsv_add_emission(
    rsv_specular_light *l, const rsv_specular_path *path, const rsv_bsdf *bsdf, rsv_rgb throughput)
{
    if (!rsv_side_shows_emission(bsdf, path->back) || !rsv_shows_emission(l->table)) return;
    float seen = rsv_hides_emission(bsdf) && is_straight(l, path) ? bsdf->camera_emission : 1;
    rsv_add_light(l, rgb_mul(throughput, rgb_scale(bsdf->emission, seen * bsdf->opacity)));
}

void rsv_add_diffuse_end(void *light, const rsv_specular_path *path, rsv_rgb weight)
{
    rsv_specular_light *l = light;
    rsv_bsdf storage;
    if (l->table->solution->elements->face_of[path->back][path->triangle] != RSV_NONE)
        rsv_add_diffuse_light(
            l, path, rsv_specular_bsdf(l->scene, path, &storage)->base_color, weight);
}

void rsv_add_diffuse_light(
    rsv_specular_light *l, const rsv_specular_path *path, rsv_rgb albedo, rsv_rgb weight)
{
    const rsv_light_view *s = l->table->solution;
    uint32_t face = s->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return;
    rsv_rgb shown = rsv_shown_reflected(l->table, face, albedo, path->u, path->v);
    if (l->mover) {
        const rsv_scene_view *view = l->scene->view;
        rsv_receiver receiver = rsv_receiver_at(view, l->scene->tracer, path->triangle, path->u,
            path->v, rsv_surface_point_at(view, path->triangle, path->u, path->v, path->back));
        shown = shaded(l->mover, &receiver, l->trail, albedo, shown);
    }
    rsv_add_light(l, rgb_mul(weight, shown));
}

/// Mean radiance that arrives, if as much comes from everywhere.
static rsv_rgb even_radiance(const rsv_specular_light *l, const rsv_specular_path *path)
{
    uint32_t face = l->table->solution->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return rgb_gray(0);
    return rsv_shown_reflected(l->table, face, rgb_gray(1), path->u, path->v);
}

void rsv_add_even_gloss(rsv_specular_light *l, const rsv_specular_path *path,
    const rsv_surface_point *point, const rsv_bsdf *bsdf, rsv_rgb throughput)
{
    rsv_vec3 normal = rsv_specular_bsdf_normal(bsdf, path, point);
    float opacity = bsdf->opacity;
    rsv_rgb albedo = rsv_glossy_albedo(bsdf, -v3_dot(normal, path->direction));
    rsv_add_light(
        l, rgb_scale(rgb_mul(throughput, rgb_mul(albedo, even_radiance(l, path))), opacity));
}

static void note(rsv_glossy_plane plane[3], uint32_t pixel, float x, float y, float z)
{
    plane[0][pixel] = x, plane[1][pixel] = y, plane[2][pixel] = z;
}

/// Less than this is not worth a lobe's rays.
#define LEAST_PASSED 0.05f

bool rsv_sees_through_panes(
    const rsv_specular_light *l, rsv_vec3 direction, rsv_vec3 point, rsv_rgb throughput)
{
    bool passes = f_min(f_min(throughput.r, throughput.g), throughput.b) > LEAST_PASSED;
    if (l->parallel || !passes || l->gloss->depth[l->pixel] > 0) return false;
    return v3_dot(v3_normalize(v3_sub(point, l->eye)), direction) > 0.99995f;
}

void rsv_note_gloss(rsv_specular_light *l, const rsv_specular_path *path,
    const rsv_surface_point *point, const rsv_bsdf *bsdf, float distance, rsv_rgb throughput)
{
    rsv_glossy_tile *g = l->gloss;
    uint32_t pixel = l->pixel;
    rsv_vec3 normal = rsv_specular_bsdf_normal(bsdf, path, point);
    rsv_rgb albedo = rsv_glossy_albedo(bsdf, -v3_dot(normal, path->direction));
    rsv_rgb even = even_radiance(l, path);
    albedo = rgb_mul(rgb_scale(albedo, bsdf->opacity), throughput);
    note(g->normal, pixel, normal.x, normal.y, normal.z);
    note(g->albedo, pixel, albedo.r, albedo.g, albedo.b);
    note(g->passed, pixel, throughput.r, throughput.g, throughput.b);
    note(g->even, pixel, even.r, even.g, even.b);
    g->depth[pixel] = distance;
    g->alpha[pixel] = rsv_glossy_width(bsdf);
    g->u[pixel] = path->u;
    g->v[pixel] = path->v;
    g->triangle[pixel] = path->triangle;
    g->count++;
}

/// Light of voxels along a segment.
static rsv_rgb cross_fog(void *light, const rsv_ray *ray, rsv_rgb throughput, uint32_t trail)
{
    rsv_specular_light *l = light;
    rsv_rgb passed, shown = rsv_fog_shine_along(l->shine, ray, &passed);
    (void)trail;
    rsv_add_light(l, rgb_mul(throughput, shown));
    return passed;
}

void rsv_add_whole_path(rsv_specular_light *l, const rsv_specular_path *path)
{
    const rsv_camera_setting setting = { l->scene, l->lights, NULL, l->max_events, false,
        l->shine ? cross_fog : NULL, 0, false, false };
    rsv_rgb found = rsv_camera_path(&setting, *path, l->trail, NULL, rsv_add_diffuse_end, l);
    if (rsv_shows_emission(l->table)) rsv_add_light(l, found);
}

void rsv_add_mover(
    rsv_specular_light *l, const rsv_specular_path *path, const rsv_ray_packet *body, uint32_t lane)
{
    rsv_rgb dimmed = rsv_medium_transmittance(&path->medium, l->scene->bsdf, body->t_max[lane]);
    rsv_rgb throughput = rsv_specular_throughput(l->scene, path, &path->medium);
    rsv_add_light(l, rgb_mul(rgb_mul(throughput, dimmed), rsv_mover_shown(l->mover, body, lane)));
}
