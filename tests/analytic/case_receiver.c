#include "case_receiver.h"

#include "core/vec.h"

bool case_receiver_needed(const case_scene *scene)
{
    for (int i = 0; i < scene->surface_count && scene->light_count; i++)
        if (scene->surface[i].bsdf != CASE_DIFFUSE) return true;
    return false;
}

double case_receiver_area(const case_scene *scene) { return case_surface_area(&scene->receiver); }

/// A plate ends at a mirror that stands on it.
static void clip_to_mirrors(const case_scene *scene, rsv_vec3 *low)
{
    for (int i = 0; i < scene->surface_count; i++) {
        const case_surface *mirror = &scene->surface[i];
        if (mirror->bsdf != CASE_MIRROR) continue;
        if (mirror->normal.x > 0.5f) low->x = f_max(low->x, mirror->corner[0].x);
        if (mirror->normal.y > 0.5f) low->y = f_max(low->y, mirror->corner[0].y);
    }
}

void case_receiver_cover(case_scene *scene, rsv_vec3 point, rsv_vec3 normal, double radius)
{
    case_surface *plate = &scene->receiver;
    rsv_vec3 reach = v3((float)radius, (float)radius, 0);
    rsv_vec3 low = v3_sub(point, reach), high = v3_add(point, reach);
    if (plate->name) {
        low = v3_min(low, v3_min(plate->corner[0], plate->corner[2]));
        high = v3_max(high, v3_max(plate->corner[0], plate->corner[2]));
    }
    clip_to_mirrors(scene, &low);
    int second = normal.z > 0 ? 1 : 3;
    *plate = (case_surface){ .name = "receiver", .normal = normal, .zone_count = 1 };
    plate->zone[0] = (case_zone){ -1, 1, 0, 0 };
    plate->corner[0] = low;
    plate->corner[second] = v3(high.x, low.y, low.z);
    plate->corner[2] = high;
    plate->corner[4 - second] = v3(low.x, high.y, low.z);
}

size_t case_receiver_disk(const case_scene *scene, rsv_probe center, double radius,
    rsv_probe points[CASE_RECEIVER_POINTS])
{
    rsv_vec3 normal = center.normal;
    const double golden_angle = 2.399963229728653;
    size_t count = 0;
    for (int k = 0; k < CASE_RECEIVER_POINTS; k++) {
        double r = radius * sqrt((k + 0.5) / CASE_RECEIVER_POINTS);
        rsv_vec3 step =
            v3((float)(r * cos(k * golden_angle)), (float)(r * sin(k * golden_angle)), 0);
        rsv_vec3 point = v3_add(center.position, step);
        if (!scene->receiver.name || case_surface_contains(&scene->receiver, point))
            points[count++] = (rsv_probe){ point, normal };
    }
    return count;
}
