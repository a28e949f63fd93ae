#include "../core/vec.h"
#include "material_at.h"
#include "scene.h"

typedef struct bounding_box {
    rsv_vec3 low, high;
} bounding_box;

static bounding_box find_bounds(const rsv_scene *scene)
{
    bounding_box bounds = { scene->position[0], scene->position[0] };
    for (size_t i = 1; i < scene->vertex_count; i++) {
        bounds.low = v3_min(bounds.low, scene->position[i]);
        bounds.high = v3_max(bounds.high, scene->position[i]);
    }
    return bounds;
}

/// Squares and products of coordinates must stay within float, and the scene must be larger than the rounding
/// of where it lies.
#define LARGEST_COORDINATE 1e9f
#define SMALLEST_SIZE 1e-12f

static const char *name_of_farthest(const rsv_scene *scene)
{
    uint32_t farthest = 0;
    float distance = -1;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        float reach = v3_max_abs(scene->position[scene->triangle[t][0]]);
        if (reach > distance) farthest = scene->triangle_object[t];
        distance = f_max(distance, reach);
    }
    return scene->object_name[farthest];
}

static float reach_of(bounding_box bounds)
{
    return f_max(v3_max_abs(bounds.low), v3_max_abs(bounds.high));
}

static rsv_status check_reach(const rsv_scene *scene, bounding_box bounds)
{
    float reach = reach_of(bounds);
    if (reach <= LARGEST_COORDINATE) return RSV_OK;
    return rsv_fail(RSV_ERROR_SCENE,
        "object '%s' reaches to a coordinate of %.3g m: scale the scene to below %.0e m",
        name_of_farthest(scene), reach, LARGEST_COORDINATE);
}

static rsv_status check_size(const rsv_scene *scene, bounding_box bounds)
{
    float reach = reach_of(bounds), size = v3_max_abs(v3_sub(bounds.high, bounds.low));
    rsv_status status = check_reach(scene, bounds);
    if (status != RSV_OK) return status;
    if (!(size >= SMALLEST_SIZE))
        return rsv_fail(RSV_ERROR_SCENE,
            "the whole scene is %.3g m across: scale it to more than %.0e m", size, SMALLEST_SIZE);
    if (size < 1e-3f * reach)
        rsv_log(scene->context, RSV_LOG_WARNING,
            "the scene is %.3g m across but lies %.3g m from the origin: single precision leaves "
            "it few digits; move it to the origin",
            size, reach);
    return RSV_OK;
}

static void fill_view(rsv_scene *scene, bounding_box bounds)
{
    scene->view = (rsv_scene_view){
        .vertex_count = scene->vertex_count,
        .triangle_count = scene->triangle_count,
        .material_count = scene->material_count,
        .light_count = scene->light_count,
        .camera_count = scene->camera_count,
        .object_count = scene->object_count,
        .texture_count = scene->texture_count,
        .luminaire_count = scene->luminaire_count,
        .position = scene->position,
        .normal = scene->normal,
        .uv = { (const float(*)[2])scene->uv[0], (const float(*)[2])scene->uv[1] },
        .tangent = (const float(*)[4])scene->tangent,
        .color = (const float(*)[4])scene->color,
        .triangle = (const uint32_t(*)[3])scene->triangle,
        .triangle_material = scene->triangle_material,
        .triangle_object = scene->triangle_object,
        .material = scene->material,
        .texture = scene->texture,
        .material_varies = scene->material_varies,
        .light = scene->light,
        .luminaire = scene->luminaire,
        .camera = scene->camera,
        .object_name = (const char *const *)scene->object_name,
        .environment = scene->environment.pixels ? &scene->environment : NULL,
        .bounds_min = bounds.low,
        .bounds_max = bounds.high,
        .origin = { scene->origin[0], scene->origin[1], scene->origin[2] },
    };
}

static rsv_status update_bounds(rsv_scene *scene)
{
    bounding_box bounds = find_bounds(scene);
    rsv_status status = check_reach(scene, bounds);
    if (status != RSV_OK) return status;
    scene->view.bounds_min = bounds.low;
    scene->view.bounds_max = bounds.high;
    return RSV_OK;
}

rsv_status rsv_scene_update_bounds(rsv_scene *scene)
{
    rsv_status status = update_bounds(scene);
    return status == RSV_OK ? rsv_scene_move_twins(scene) : status;
}

rsv_status rsv_scene_update_bounds_only(rsv_scene *scene)
{
    rsv_status status = update_bounds(scene);
    if (status == RSV_OK) rsv_scene_fit_twins(scene);
    return status;
}

/// Finds out which materials are not the same all over: textured ones, and those on coloured vertices.
static rsv_status find_varying_materials(rsv_scene *scene)
{
    scene->material_varies = rsv_alloc(scene->context, scene->material_count, 1);
    if (!scene->material_varies) return RSV_ERROR_MEMORY;
    for (size_t m = 0; m < scene->material_count; m++) {
        if (scene->material[m].texture_count) scene->material_varies[m] = RSV_VARIES_BY_TEXTURE;
        if (scene->material[m].anisotropy > 0 && scene->material[m].metallic > 0)
            scene->material_varies[m] |= RSV_VARIES_BY_TANGENT;
    }
    for (size_t t = 0; scene->color && t < scene->triangle_count; t++) {
        uint8_t *varies = &scene->material_varies[scene->triangle_material[t]];
        for (int k = 0; k < 3; k++) {
            const float *c = scene->color[scene->triangle[t][k]];
            if (c[0] != 1 || c[1] != 1 || c[2] != 1) *varies |= RSV_VARIES_BY_COLOR;
            if (c[3] != 1) *varies |= RSV_VARIES_BY_OPACITY;
        }
    }
    return RSV_OK;
}

/// A uniform cut-out surface is either completely there or not. If it is there, it is opaque, whatever its opacity.
static void fill_cut_outs(rsv_scene *scene)
{
    for (size_t k = 0; k < scene->material_count; k++) {
        rsv_material *m = &scene->material[k];
        bool is_cut = m->alpha_cutoff > 0 && !scene->material_varies[k];
        if (is_cut && m->opacity >= RSV_CUTOFF_SHARE * m->alpha_cutoff) m->opacity = 1;
    }
}

static rsv_status add_framing_camera(rsv_scene *scene, bounding_box bounds)
{
    rsv_vec3 centre = v3_mad(v3_scale(bounds.low, 0.5f), 0.5f, bounds.high);
    float radius = 0;
    for (size_t i = 0; i < scene->vertex_count; i++)
        radius = f_max(radius, v3_length(v3_sub(scene->position[i], centre)));
    rsv_camera camera = rsv_camera_frame_sphere("framing", centre, radius);
    if (!scene->is_part)
        rsv_log(scene->context, RSV_LOG_INFO,
            scene->origin[0] != 0 || scene->origin[1] != 0 || scene->origin[2] != 0
                ? "the scene has no camera: 'framing' is chosen, at (%.10g, %.10g, %.10g)"
                : "the scene has no camera: 'framing' is chosen, at (%.4g, %.4g, %.4g)",
            camera.position.x + scene->origin[0], camera.position.y + scene->origin[1],
            camera.position.z + scene->origin[2]);
    return rsv_scene_add_camera(scene, &camera);
}

rsv_status rsv_scene_finish(rsv_scene *scene)
{
    rsv_status status;
    if (!scene->triangle_count)
        return rsv_fail(RSV_ERROR_SCENE,
            "the scene has no triangles, so there is nothing to light; add a mesh");
    bounding_box bounds = find_bounds(scene);
    RSV_TRY(check_size(scene, bounds));
    RSV_TRY(find_varying_materials(scene));
    fill_cut_outs(scene);
    if (!scene->camera_count) RSV_TRY(add_framing_camera(scene, bounds));
    fill_view(scene, bounds);
    RSV_TRY(rsv_scene_list_nodes(scene));
    rsv_scene_release_sources(scene); // the search for twins takes memory of its own
    RSV_TRY(rsv_scene_find_twins(scene));
    scene->commit_tried = scene->committed = true;
cleanup:
    return status;
}

rsv_status rsv_scene_require_committed(const rsv_scene *scene)
{
    if (scene->committed) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT,
        scene->commit_tried ? "scene: rsv_scene_commit() failed, so it cannot be used"
                            : "scene: it has not been committed; call rsv_scene_commit() first");
}

rsv_status rsv_scene_commit(rsv_scene *scene)
{
    if (scene->commit_tried)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "scene: it has been committed already, or its commit failed");
    scene->commit_tried = true;
    rsv_status status = rsv_scene_take_origin(scene);
    if (status == RSV_OK) status = rsv_scene_flatten(scene);
    return status == RSV_OK ? rsv_scene_finish(scene) : status;
}
