#include "../core/stratified.h"
#include "../trace/camera_ray.h"
#include "goal.h"
#include "solve_constants.h"

#include <string.h>

rsv_goal_aim rsv_goal_aim_of(const rsv_solve_desc *desc)
{
    return (rsv_goal_aim){ desc->goal_camera, desc->goal_points, desc->goal_point_count };
}

bool rsv_goal_is_wanted(const rsv_goal_aim *aim)
{
    return aim->camera != RSV_NONE || aim->point_count > 0;
}

rsv_status rsv_check_probes(const rsv_probe *probes, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        rsv_vec3 p = probes[k].position, n = probes[k].normal;
        if (!isfinite(p.x + p.y + p.z) || !isfinite(n.x + n.y + n.z) || v3_length(n) == 0)
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "probe %zu: position and normal must be finite, the normal not zero", k);
    }
    return RSV_OK;
}

static bool counts_nothing(const void *user, uint32_t triangle, uint32_t turns)
{
    (void)user, (void)triangle, (void)turns;
    return false;
}

/// One ray of the goal: to the diffuse surface that it leads to.
static bool follow(const rsv_transport_scene *scene, const rsv_ray *ray, const rsv_medium *medium,
    rsv_random *random, rsv_specular_path *end)
{
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, ray, &hit)) return false;
    rsv_specular_path first = rsv_specular_begin(scene, medium, ray->direction, hit);
    rsv_gather gather = rsv_specular_gather(scene, first, random, counts_nothing, NULL);
    *end = gather.path;
    return gather.end == RSV_SPECULAR_DIFFUSE;
}

void rsv_goal_weigh_end(
    const rsv_operator_view *op, const rsv_specular_path *end, float share, rsv_rgb *weight)
{
    const rsv_elements *e = op->elements;
    uint32_t face = e->face_of[end->back][end->triangle];
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    float w[3];
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&op->world->scene, end, &storage);
    rsv_rgb seen = rgb_scale(rgb_mul(end->weight, bsdf->base_color), share / RSV_PI);
    // luminance is linear: its weights go along
    seen = rgb(rgb_luminance(rgb(seen.r, 0, 0)), rgb_luminance(rgb(0, seen.g, 0)),
        rgb_luminance(rgb(0, 0, seen.b)));
    const uint32_t *node = e->cell_node[rsv_elements_locate(e, face, end->u, end->v, w)];
    for (int k = 0; k < 3; k++)
        weight[node[k]] = rgb_mad(weight[node[k]], w[k], seen);
}

static void weigh_picture(
    const rsv_operator_view *op, uint32_t index, uint32_t side, uint32_t seed, rsv_rgb *weight)
{
    const rsv_transport_scene *scene = &op->world->scene;
    const rsv_camera *camera = &scene->view->camera[index];
    rsv_medium medium = rsv_medium_above(&scene->media, camera->position, camera->forward);
    float aspect = camera->aspect > 0 ? camera->aspect : 1;
    uint32_t height = 1024, width = (uint32_t)fmaxf(height * aspect, 1);
    for (uint32_t k = 0; k < side * side; k++) {
        rsv_random random = rsv_random_from(seed, k, 0x60a1u);
        float x = ((float)(k % side) + rsv_random_float(&random)) / (float)side;
        float y = ((float)(k / side) + rsv_random_float(&random)) / (float)side;
        rsv_ray ray = rsv_camera_ray(camera, width, height, x * (float)width, y * (float)height);
        rsv_specular_path end;
        if (follow(scene, &ray, &medium, &random, &end))
            rsv_goal_weigh_end(op, &end, 1 / (float)(side * side), weight);
    }
}

/// A gather ray counts pi / rays times the radiance it finds. @param stream of random numbers
static void weigh_reading(const rsv_operator_view *op, const rsv_goal_aim *aim, size_t index,
    uint32_t rays, uint32_t stream, rsv_rgb *weight)
{
    const rsv_transport_scene *scene = &op->world->scene;
    rsv_vec3 normal = v3_normalize(aim->point[index].normal);
    rsv_vec3 origin = rsv_tracer_receiver_origin(scene->tracer, aim->point[index].position, normal);
    rsv_medium medium = rsv_medium_above(&scene->media, origin, normal);
    for (uint32_t k = 0; k < rays; k++) {
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_random random = rsv_random_from(stream, k, 0x2f6u);
        rsv_ray ray = { origin, v3_turned_to(normal, d), INFINITY };
        rsv_specular_path end;
        if (follow(scene, &ray, &medium, &random, &end))
            rsv_goal_weigh_end(op, &end, RSV_PI / ((float)rays * (float)aim->point_count), weight);
    }
}

rsv_status rsv_goal_enter(const rsv_operator_view *op, rsv_rgb *weight)
{
    const rsv_elements *e = op->elements;
    if (op->subsurface) {
        rsv_rgb *shown = rsv_alloc(op->context, e->node_count, sizeof *shown);
        if (!shown) return RSV_ERROR_MEMORY;
        memcpy(shown, weight, e->node_count * sizeof *weight);
        rsv_subsurface_apply_transpose(op->subsurface, e, shown, weight);
        rsv_free(op->context, shown);
    }
    rsv_elements_constrain_transpose(e, 1, weight);
    return RSV_OK;
}

rsv_status rsv_goal_weights(
    const rsv_operator *of, const rsv_goal_aim *aim, uint32_t side, uint32_t seed, rsv_rgb *weight)
{
    const rsv_operator_view *op = rsv_operator_get_view(of);
    for (size_t n = 0; n < op->elements->node_count; n++)
        weight[n] = rgb_gray(0);
    if (aim->camera != RSV_NONE) weigh_picture(op, aim->camera, side, seed, weight);
    for (size_t k = 0; k < aim->point_count; k++) {
        uint32_t rays = (uint32_t)(side * side / aim->point_count);
        if (rsv_cancelled(op->context)) break;
        weigh_reading(op, aim, k, rays > FEWEST_SENSOR_RAYS ? rays : FEWEST_SENSOR_RAYS,
            rsv_hash3(seed, (uint32_t)k, 0x5e45u), weight);
    }
    rsv_status status = rsv_goal_enter(op, weight);
    return status == RSV_OK ? rsv_progress(op->context, "weights", 1) : status;
}

rsv_status rsv_goal_hidden_cells(
    const rsv_operator *op, const rsv_goal_aim *aim, uint32_t seed, uint8_t *hidden)
{
    const rsv_elements *e = rsv_operator_get_view(op)->elements;
    rsv_rgb *weight = rsv_alloc(e->context, e->node_count, sizeof *weight);
    if (!weight) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_goal_weights(op, aim, VIEW_SIDE, seed, weight);
    rsv_elements_constrain(e, weight);
    for (size_t c = 0; c < e->cell_count; c++) {
        hidden[c] = 1;
        for (int k = 0; k < 3; k++)
            if (!rgb_is_black(weight[e->cell_node[c][k]])) hidden[c] = 0;
    }
    rsv_free(e->context, weight);
    return status;
}
