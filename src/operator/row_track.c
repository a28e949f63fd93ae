#include "row_track.h"

rsv_status rsv_row_track_create(rsv_context *context, uint32_t rays, rsv_row_track **result)
{
    rsv_row_track *t = rsv_alloc(context, 1, sizeof *t);
    if (!t) return RSV_ERROR_MEMORY;
    t->context = context;
    t->reach = rsv_alloc(context, rays, sizeof *t->reach);
    t->tinted_ray = rsv_alloc(context, rays, sizeof *t->tinted_ray);
    t->bin_ray = rsv_alloc(context, rays, sizeof *t->bin_ray);
    t->tinted_bin_ray = rsv_alloc(context, rays, sizeof *t->tinted_bin_ray);
    t->light_ray = rsv_alloc(context, rays, sizeof *t->light_ray);
    t->light = rsv_alloc(context, rays, sizeof *t->light);
    t->color = rsv_alloc(context, rays, sizeof *t->color);
    t->light_color = rsv_alloc(context, rays, sizeof *t->light_color);
    if (t->reach && t->tinted_ray && t->bin_ray && t->tinted_bin_ray && t->light_ray && t->light &&
        t->color && t->light_color) {
        *result = t;
        return RSV_OK;
    }
    rsv_row_track_destroy(t);
    return RSV_ERROR_MEMORY;
}

void rsv_row_track_destroy(rsv_row_track *t)
{
    if (!t) return;
    rsv_free(t->context, t->reach);
    rsv_free(t->context, t->tinted_ray);
    rsv_free(t->context, t->bin_ray);
    rsv_free(t->context, t->tinted_bin_ray);
    rsv_free(t->context, t->light_ray);
    rsv_free(t->context, t->light);
    rsv_free(t->context, t->color);
    rsv_free(t->context, t->light_color);
    rsv_free(t->context, t->trail);
    rsv_free(t->context, t);
}

void rsv_row_track_clear(rsv_row_track *t)
{
    t->light_count = 0;
    t->trail_count = 0;
}

static uint16_t on_lattice(float x, float low, float high)
{
    float part = high > low ? (x - low) / (high - low) : 0;
    return (uint16_t)(f_min(f_max(part, 0), 1) * 65535 + 0.5f);
}

/// Metres along a direction to where it leaves the frame.
static float way_out(const rsv_trail_frame *f, rsv_vec3 from, rsv_vec3 d)
{
    float x = d.x > 0 ? (f->high.x - from.x) / d.x : d.x < 0 ? (f->low.x - from.x) / d.x : INFINITY;
    float y = d.y > 0 ? (f->high.y - from.y) / d.y : d.y < 0 ? (f->low.y - from.y) / d.y : INFINITY;
    float z = d.z > 0 ? (f->high.z - from.z) / d.z : d.z < 0 ? (f->low.z - from.z) / d.z : INFINITY;
    float out = f_min(x, f_min(y, z));
    return out > 0 && out < INFINITY ? out : 0;
}

static rsv_vec3 place_of(const rsv_scene_view *scene, const rsv_specular_path *path)
{
    const uint32_t *corner = scene->triangle[path->triangle];
    return v3_barycentric(scene->position[corner[0]], scene->position[corner[1]],
        scene->position[corner[2]], path->u, path->v);
}

static void add_point(rsv_row_track *t, uint32_t ray, rsv_vec3 p)
{
    const rsv_trail_frame *f = &t->frame;
    if (rsv_grow(t->context, (void **)&t->trail, &t->trail_capacity, t->trail_count + 1,
            sizeof *t->trail) != RSV_OK) {
        t->failed = true;
        return;
    }
    t->trail[t->trail_count++] = (rsv_trail_point){ (uint16_t)ray,
        { on_lattice(p.x, f->low.x, f->high.x), on_lattice(p.y, f->low.y, f->high.y),
            on_lattice(p.z, f->low.z, f->high.z) } };
}

void rsv_row_track_visit(rsv_row_track *t, uint32_t ray, const rsv_scene_view *scene,
    const rsv_specular_path *path, bool left_scene, rsv_vec3 from)
{
    const rsv_trail_frame *f = &t->frame;
    rsv_vec3 p = left_scene ? v3_mad(from, way_out(f, from, path->direction), path->direction)
                            : place_of(scene, path);
    bool begins = t->trail_count == 0 || t->trail[t->trail_count - 1].ray != ray;
    if (begins) add_point(t, ray, from);
    add_point(t, ray, p);
}
