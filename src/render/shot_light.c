#include "shot_light.h"

#include "../direct/photons.h"
#include "../trace/camera_ray.h"
#include "rough_light.h"

/// As many paths as camera rays, but at least this many for pictures of a few pixels.
#define FEWEST_PATHS (1u << 16)

struct rsv_shot_light {
    const rsv_light_view *solution;
    const rsv_camera *camera;
    const rsv_medium *medium;
    rsv_photon_shooter *shooter;
};

typedef struct shot_splat {
    size_t pixel;
    rsv_rgb radiance;
} shot_splat;

/// The splats of one slot since they were last collected.
typedef struct splat_list {
    shot_splat *splat;
    size_t count, capacity;
    rsv_status status;
} splat_list;

typedef struct shot_job {
    const rsv_light_view *solution;
    const rsv_render_desc *desc;
    const rsv_medium *medium;
    rsv_lens lens;
    float spread; ///< of a camera ray, as in camera paths
    rsv_image *image;
    splat_list *list; ///< [rsv_photon_slots]
} shot_job;

bool rsv_shot_light_wanted(const rsv_light_view *s)
{
    bool rough = false;
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        rough = rough || s->bsdf[m].rough;
    return rough && rsv_photons_wanted(&s->scene, s->lights);
}

static void push(const shot_job *job, splat_list *list, shot_splat splat)
{
    if (list->status == RSV_OK)
        list->status = rsv_grow(job->solution->context, (void **)&list->splat, &list->capacity,
            list->count + 1, sizeof *list->splat);
    if (list->status == RSV_OK) list->splat[list->count++] = splat;
}

/// Whether the point is in the picture, and where.
static bool in_picture(const shot_job *job, rsv_vec3 point, rsv_lens_view *view)
{
    return rsv_lens_see(&job->lens, point, view) && view->x >= 0 && view->y >= 0 &&
           view->x < (float)job->desc->width && view->y < (float)job->desc->height;
}

static bool hidden(const shot_job *job, const rsv_surface_point *point, const rsv_lens_view *view)
{
    rsv_vec3 side = point->geometric, towards = v3_neg(view->direction);
    if (v3_dot(side, towards) < 0) side = v3_neg(side);
    rsv_ray ray = { rsv_offset_origin(point->position, side, point->extent), towards,
        view->distance };
    return rsv_tracer_occluded(job->solution->tracer, &ray);
}

/// Joins the end of a light path to the camera, as the surface that a camera path meets first. False if it is seen by
/// no camera ray, or does not scatter widely.
static bool join(
    const shot_job *job, const rsv_specular_path *end, rsv_lens_view *view, rsv_specular_path *seen)
{
    const rsv_transport_scene *scene = &job->solution->scene;
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, end->triangle, end->u, end->v, end->back);
    if (end->events >= job->desc->path_depth || !in_picture(job, point.position, view))
        return false;
    *seen = rsv_specular_begin(scene, job->medium, view->direction,
        (rsv_hit){ end->triangle, view->distance, end->u, end->v });
    rsv_specular_set_spread(seen, job->spread, view->distance);
    rsv_bsdf storage;
    return rsv_rough_is_wide(rsv_specular_bsdf(scene, seen, &storage)) &&
           !hidden(job, &point, view);
}

static bool is_seen(void *user, const rsv_specular_path *end)
{
    rsv_lens_view view;
    rsv_specular_path seen;
    return join(user, end, &view, &seen);
}

static void add_light_path(void *user, size_t slot, const rsv_specular_path *end, rsv_rgb flux)
{
    const shot_job *job = user;
    const rsv_transport_scene *scene = &job->solution->scene;
    rsv_lens_view view;
    rsv_specular_path seen;
    if (!join(job, end, &view, &seen)) return;
    rsv_rough_surface surface;
    rsv_rough_meet(scene, &seen, &surface);
    rsv_rgb response = rsv_rough_response(&surface, v3_neg(end->direction));
    // a photon's flux is spread over the true surface, the response counts irradiance by the shading normal (Veach
    // 1997, 5.3)
    rsv_vec3 geometric =
        rsv_surface_point_at(scene->view, end->triangle, end->u, end->v, end->back).geometric;
    float arrives = fabsf(v3_dot(geometric, end->direction));
    float leaves = fabsf(v3_dot(geometric, view.direction));
    if (rgb_is_black(response) || !(arrives > 0)) return;
    size_t pixel = (size_t)view.y * job->desc->width + (size_t)view.x;
    float scale = view.pixels_per_area * leaves / arrives;
    shot_splat splat = { pixel, rgb_scale(rgb_mul(flux, response), scale) };
    push(job, &job->list[slot], splat);
}

static void collect_slot(const shot_job *job, splat_list *list)
{
    uint32_t layers = job->desc->layers ? 2 : 1;
    for (uint32_t layer = 0; layer < layers; layer++) {
        rsv_rgb *out = rsv_image_pixels(job->image, layer);
        for (size_t k = 0; k < list->count; k++)
            out[list->splat[k].pixel] = rgb_add(out[list->splat[k].pixel], list->splat[k].radiance);
    }
    list->count = 0;
}

static void collect(void *user, size_t slots)
{
    const shot_job *job = user;
    for (size_t slot = 0; slot < slots; slot++)
        collect_slot(job, &job->list[slot]);
}

static float spread_of(const rsv_shot_light *shot, const rsv_render_desc *desc)
{
    return rsv_camera_spread(shot->camera, desc->height) / sqrtf((float)desc->samples);
}

static shot_job begin_job(const rsv_shot_light *shot, const rsv_render_desc *desc, rsv_image *image)
{
    return (shot_job){ .solution = shot->solution,
        .desc = desc,
        .medium = shot->medium,
        .lens = rsv_lens_of(shot->camera, desc->width, desc->height),
        .spread = spread_of(shot, desc),
        .image = image };
}

static uint32_t seed_of(const rsv_render_desc *desc) { return rsv_hash2(desc->seed, 0x51a7u); }

rsv_status rsv_shot_light_create(const rsv_light_view *solution, const rsv_render_desc *desc,
    const rsv_camera *camera, const rsv_medium *medium, rsv_shot_light **shot)
{
    uint64_t rays = 0;
    *shot = rsv_alloc(solution->context, 1, sizeof **shot);
    if (!*shot) return RSV_ERROR_MEMORY;
    **shot = (rsv_shot_light){ solution, camera, medium, NULL };
    shot_job job = begin_job(*shot, desc, NULL);
    const rsv_photon_sink sink = { .user = &job, .wants = is_seen };
    return rsv_photon_shooter_create(
        &solution->scene, solution->lights, seed_of(desc), &sink, &(*shot)->shooter, &rays);
}

void rsv_shot_light_destroy(rsv_shot_light *shot)
{
    if (!shot) return;
    rsv_photon_shooter_destroy(shot->shooter);
    rsv_free(shot->solution->context, shot);
}

rsv_status rsv_shot_light_add(
    const rsv_shot_light *shot, const rsv_render_desc *desc, rsv_image *image)
{
    rsv_context *context = shot->solution->context;
    uint64_t paths = (uint64_t)desc->width * desc->height * desc->samples, rays = 0;
    size_t slots = rsv_photon_slots(context);
    shot_job job = begin_job(shot, desc, image);
    job.list = rsv_alloc(context, slots, sizeof *job.list);
    if (!job.list) return RSV_ERROR_MEMORY;
    paths = paths < FEWEST_PATHS ? FEWEST_PATHS : paths > INT32_MAX ? INT32_MAX : paths;
    const rsv_photon_sink sink = { &job, add_light_path, collect, is_seen, NULL };
    rsv_status status =
        rsv_photons_send(shot->shooter, (uint32_t)paths, seed_of(desc), &sink, &rays);
    for (size_t k = 0; k < slots; k++) {
        if (status == RSV_OK) status = job.list[k].status;
        rsv_free(context, job.list[k].splat);
    }
    rsv_free(context, job.list);
    return status;
}
