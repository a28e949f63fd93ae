/// Fog: checks its values and finds its box.
#include "../core/vec.h"
#include "restore.h"
#include "scene.h"
#include "volume.h"

/// As of an environment's pixels.
#define LARGEST_EMISSION 1e12f

rsv_fog rsv_default_fog(void)
{
    return (rsv_fog){ .albedo = { 1, 1, 1 }, .scale_height = INFINITY };
}

static bool within(rsv_rgb value, float low, float high)
{
    const float v[3] = { value.r, value.g, value.b };
    for (int c = 0; c < 3; c++)
        if (!(v[c] >= low && v[c] <= high)) return false;
    return true;
}

static rsv_status refuse_color(const char *what, rsv_rgb value, const char *range)
{
    return rsv_fail(RSV_ERROR_ARGUMENT, "fog: %s of %g, %g, %g; each must be %s", what,
        (double)value.r, (double)value.g, (double)value.b, range);
}

/// Without extinction, nothing limits the emission collected along a long path.
static bool emits_without_extinction(const rsv_fog *fog)
{
    return (fog->emission.r > 0 && fog->extinction.r == 0) ||
           (fog->emission.g > 0 && fog->extinction.g == 0) ||
           (fog->emission.b > 0 && fog->extinction.b == 0);
}

static bool is_set(float low, float high) { return low < high; }

static bool has_box(const rsv_fog *fog)
{
    rsv_vec3 a = fog->bounds_min, b = fog->bounds_max;
    return is_set(a.x, b.x) && is_set(a.y, b.y) && is_set(a.z, b.z);
}

static rsv_status check_place(const rsv_fog *fog)
{
    rsv_vec3 a = fog->bounds_min, b = fog->bounds_max;
    if (!(fog->scale_height > 0))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "fog: a scale height of %g m; it must be above 0, or infinite",
            (double)fog->scale_height);
    if (!isfinite(fog->base_height))
        return rsv_fail(RSV_ERROR_ARGUMENT, "fog: the base height must be finite, not %g m",
            (double)fog->base_height);
    if (isnan(a.x + a.y + a.z) || isnan(b.x + b.y + b.z))
        return rsv_fail(RSV_ERROR_ARGUMENT, "fog: a side of its box is not a number");
    return RSV_OK;
}

static rsv_status check_fog(const rsv_fog *fog)
{
    if (!within(fog->extinction, 0, RSV_LARGEST_EXTINCTION))
        return refuse_color("an extinction", fog->extinction, "from 0 to 1e6 per metre");
    if (!within(fog->albedo, 0, 1)) return refuse_color("an albedo", fog->albedo, "from 0 to 1");
    if (!within(fog->emission, 0, LARGEST_EMISSION))
        return refuse_color("an emission", fog->emission, "from 0 to 1e12 W/(sr m3)");
    if (!(fabsf(fog->anisotropy) < 1))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "fog: an anisotropy g of %g; it must be above -1 and below 1", (double)fog->anisotropy);
    if (emits_without_extinction(fog))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "fog: it emits in a channel without extinction; give that channel some");
    return check_place(fog);
}

/// The box around surfaces, cameras and lights that have a place.
static void fill_scene(const rsv_scene_view *view, rsv_fog *fog)
{
    rsv_vec3 low = view->bounds_min, high = view->bounds_max;
    for (size_t k = 0; k < view->camera_count; k++) {
        low = v3_min(low, view->camera[k].position);
        high = v3_max(high, view->camera[k].position);
    }
    for (size_t k = 0; k < view->light_count; k++) {
        if (!rsv_punctual_facts_of(view->light[k].kind).has_place) continue;
        low = v3_min(low, view->light[k].position);
        high = v3_max(high, view->light[k].position);
    }
    fog->bounds_min = low;
    fog->bounds_max = high;
}

static rsv_vec3 less_origin(rsv_vec3 p, const double origin[3])
{
    return v3((float)((double)p.x - origin[0]), (float)((double)p.y - origin[1]),
        (float)((double)p.z - origin[2]));
}

static void find_box(const rsv_scene *scene, rsv_fog *fog)
{
    if (has_box(fog)) {
        fog->bounds_min = less_origin(fog->bounds_min, scene->origin);
        fog->bounds_max = less_origin(fog->bounds_max, scene->origin);
    } else if (fog->scale_height < INFINITY) {
        fog->bounds_min = v3(-INFINITY, -INFINITY, -INFINITY);
        fog->bounds_max = v3(INFINITY, INFINITY, INFINITY);
    } else {
        fill_scene(&scene->view, fog);
    }
}

rsv_status rsv_scene_set_fog(rsv_scene *scene, const rsv_fog *fog)
{
    rsv_status status = rsv_scene_require_committed(scene);
    if (status == RSV_OK && fog) status = check_fog(fog);
    if (status != RSV_OK) return status;
    scene->view.fog = NULL;
    if (!fog || rgb_is_black(fog->extinction)) return RSV_OK;
    scene->fog = *fog;
    scene->fog.volume = NULL;
    scene->fog.base_height = (float)((double)fog->base_height - scene->origin[1]);
    find_box(scene, &scene->fog);
    scene->view.fog = &scene->fog;
    return RSV_OK;
}

static bool is_endless(const rsv_fog *fog)
{
    rsv_vec3 extent = v3_sub(fog->bounds_max, fog->bounds_min);
    return !(extent.x < INFINITY && extent.y < INFINITY && extent.z < INFINITY);
}

rsv_status rsv_scene_restore_fog(rsv_scene *scene, const rsv_fog *fog)
{
    if (check_fog(fog) != RSV_OK || rgb_is_black(fog->extinction) || is_endless(fog))
        return rsv_fail(RSV_ERROR_FORMAT, "scene: a solution cannot have this fog");
    scene->fog = *fog;
    scene->fog.volume = NULL;
    scene->view.fog = &scene->fog;
    return RSV_OK;
}

bool rsv_fog_has_volume(const rsv_fog *fog)
{
    if (!fog || is_endless(fog)) return false;
    rsv_vec3 extent = v3_sub(fog->bounds_max, fog->bounds_min);
    return extent.x > 0 && extent.y > 0 && extent.z > 0;
}

rsv_status rsv_scene_refuse_endless_fog(const rsv_scene *scene, const char *what)
{
    if (!scene->view.fog || !is_endless(scene->view.fog)) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "fog: %s only supports fog in a finite box; leave out the height (--fog-height), or use "
        "mode reference",
        what);
}

rsv_status rsv_scene_refuse_fog(const rsv_scene *scene, const char *what)
{
    if (!scene->view.fog) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED, "fog: %s does not support fog; leave it out", what);
}
