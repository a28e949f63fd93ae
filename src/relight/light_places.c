#include "light_places.h"

#include "../scene/scene.h"

/// Marks the vertices of a material's triangles, which are no other's. @return how many
static size_t mark_vertices(const rsv_scene *scene, uint32_t material, uint8_t *marked)
{
    size_t count = 0;
    for (size_t t = 0; t < scene->triangle_count; t++)
        for (int k = 0; k < 3 && scene->triangle_material[t] == material; k++) {
            uint8_t *mark = &marked[scene->triangle[t][k]];
            count += !*mark;
            *mark = 1;
        }
    return count;
}

static void note_home(const rsv_scene *scene, const uint8_t *marked, rsv_light_place *place)
{
    double sum[3] = { 0 };
    size_t count = 0;
    for (size_t v = 0; v < scene->vertex_count; v++) {
        if (!marked[v]) continue;
        rsv_vec3 at = scene->position[v];
        place->vertex[count] = (uint32_t)v;
        place->home[count++] = at;
        sum[0] += (double)at.x, sum[1] += (double)at.y, sum[2] += (double)at.z;
    }
    double scale = count ? 1 / (double)count : 0;
    place->centre = v3((float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale));
    place->vertex_count = count;
}

static rsv_status find_lamp(const rsv_scene *scene, uint32_t material, rsv_light_place *place)
{
    uint8_t *marked = rsv_alloc(scene->context, scene->vertex_count, 1);
    if (!marked) return RSV_ERROR_MEMORY;
    size_t count = mark_vertices(scene, material, marked);
    place->vertex = rsv_alloc(scene->context, count, sizeof *place->vertex);
    place->home = rsv_alloc(scene->context, count, sizeof *place->home);
    bool good = place->vertex && place->home;
    if (good) note_home(scene, marked, place);
    rsv_free(scene->context, marked);
    return good ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_light_place_note(const rsv_punctual_light *light, rsv_light_place *place)
{
    place->centre = light->position;
    place->direction = light->direction;
    place->side = light->side;
}

rsv_status rsv_light_places_find(
    const rsv_scene *scene, const rsv_source *source, size_t count, rsv_light_place *place)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < count && status == RSV_OK; k++) {
        if (source[k].kind == RSV_SOURCE_MATERIAL)
            status = find_lamp(scene, source[k].index, &place[k]);
        else if (source[k].kind == RSV_SOURCE_LIGHT)
            rsv_light_place_note(&scene->light[source[k].index], &place[k]);
    }
    return status;
}

void rsv_light_places_free(rsv_context *context, rsv_light_place *place, size_t count)
{
    for (size_t k = 0; place && k < count; k++) {
        rsv_free(context, place[k].vertex);
        rsv_free(context, place[k].home);
    }
}

/// Turns a vector as the shortest turn from one direction to another does; half a turn is about any axis.
static rsv_vec3 turn_along(rsv_vec3 v, rsv_vec3 from, rsv_vec3 to)
{
    rsv_vec3 axis = v3_cross(from, to), other;
    float cosine = v3_dot(from, to);
    if (cosine < -0.999999f) {
        v3_frame(from, &axis, &other);
        return v3_sub(v3_scale(axis, 2 * v3_dot(axis, v)), v);
    }
    // Rodrigues' formula
    rsv_vec3 turned = v3_mad(v3_cross(axis, v), 1, v3_scale(v, cosine));
    return v3_mad(turned, v3_dot(axis, v) / (1 + cosine), axis);
}

static void aim_light(rsv_punctual_light *light, const rsv_light_place *place, rsv_vec3 aim)
{
    bool turned = v3_dot(aim, aim) > 0;
    light->direction = turned ? aim : place->direction;
    light->side = turned ? turn_along(place->side, place->direction, aim) : place->side;
}

void rsv_light_place_move(rsv_scene *scene, const rsv_source *source, const rsv_light_place *place,
    rsv_vec3 offset, rsv_vec3 aim)
{
    if (source->kind == RSV_SOURCE_LIGHT) {
        scene->light[source->index].position = v3_add(place->centre, offset);
        aim_light(&scene->light[source->index], place, aim);
    }
    for (size_t k = 0; k < place->vertex_count; k++)
        scene->position[place->vertex[k]] = v3_add(place->home[k], offset);
}
