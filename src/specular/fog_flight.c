#include "fog_flight.h"

bool rsv_specular_lands(const rsv_transport_scene *scene, rsv_specular_path *path, bool leaves,
    rsv_random *random, rsv_vec3 *place)
{
    const rsv_fog *fog = scene->view->fog;
    if (!fog || path->medium.depth || !(leaves || path->length > 0)) return false;
    rsv_ray ray = rsv_specular_segment(scene, path, leaves);
    float u_channel = rsv_random_float(random), u = rsv_random_float(random);
    rsv_fog_flight flight = rsv_fog_fly(fog, &ray, path->weight, u_channel, u);
    path->length = 0;
    path->weight = rgb_mul(path->weight, flight.weight);
    *place = flight.place;
    return flight.lands;
}
