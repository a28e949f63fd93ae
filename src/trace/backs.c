#include "backs.h"

#include "../core/core.h"
#include "../scene/scene.h"
#include "camera_ray.h"

enum { ROWS = 48, COLUMNS = 64 };

#define LARGEST_SHARE 0.01

/// The material whose back a ray meets; RSV_NONE = it meets anything else. @param meets set where it meets a surface
static uint32_t back_met(const rsv_tracer *tracer, const rsv_ray *ray, bool *meets)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_tracer_scene(tracer));
    rsv_hit hit;
    if (!rsv_tracer_closest(tracer, ray, &hit)) return RSV_NONE;
    *meets = true;
    const uint32_t *v = view->triangle[hit.triangle];
    uint32_t material = view->triangle_material[hit.triangle];
    const rsv_material *m = &view->material[material];
    rsv_vec3 normal = v3_cross(v3_sub(view->position[v[1]], view->position[v[0]]),
        v3_sub(view->position[v[2]], view->position[v[0]]));
    bool has_back = !m->double_sided && m->transmission == 0;
    return has_back && v3_dot(normal, ray->direction) > 0 ? material : RSV_NONE;
}

rsv_seen_backs rsv_look_for_backs(const rsv_tracer *tracer, const rsv_camera *camera)
{
    const rsv_lens lens = rsv_lens_of(camera, COLUMNS, ROWS);
    rsv_seen_backs seen = { 0, RSV_NONE, false };
    size_t count = 0, votes = 0;
    for (int k = 0; k < ROWS * COLUMNS; k++) {
        const rsv_ray ray =
            rsv_lens_ray(&lens, (float)(k % COLUMNS) + 0.5f, (float)(k / COLUMNS) + 0.5f);
        uint32_t material = back_met(tracer, &ray, &seen.anything);
        if (material == RSV_NONE) continue;
        count++;
        if (votes == 0) seen.material = material; // a majority is left (Boyer and Moore 1991)
        votes += material == seen.material ? 1 : (size_t)-1;
    }
    seen.share = (double)count / (ROWS * COLUMNS);
    return seen;
}

void rsv_warn_of_view(const rsv_tracer *tracer, const rsv_camera *camera)
{
    const rsv_scene *scene = rsv_tracer_scene(tracer);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    const rsv_seen_backs seen = rsv_look_for_backs(tracer, camera);
    if (!seen.anything && !view->environment && !view->fog)
        rsv_log(rsv_scene_get_context(scene), RSV_LOG_WARNING,
            "camera '%.80s' sees nothing: no surface lies before it, and the scene has no "
            "environment; move or turn it",
            camera->name ? camera->name : "");
    if (seen.share <= LARGEST_SHARE) return;
    rsv_log(rsv_scene_get_context(scene), RSV_LOG_WARNING,
        "%.0f %% of the picture shows single-sided surfaces from behind, which are black (mostly '%s'): flipped "
        "normals? --two-sided shows them",
        100 * seen.share, view->material[seen.material].name);
}
