#include "surface_points.h"

float rsv_point_width(const rsv_light_view *s, const rsv_face_point *p)
{
    const rsv_elements *e = s->fine.direct ? s->fine.elements : s->elements;
    float weight[3], area = 0;
    const uint32_t *node = e->cell_node[rsv_elements_locate(e, p->face, p->u, p->v, weight)];
    for (int k = 0; k < 3; k++)
        area += weight[k] * e->node_area[node[k]];
    return sqrtf(area);
}

rsv_visible_surface rsv_visible_surface_of(
    const rsv_transport_scene *scene, const rsv_elements *elements)
{
    return (rsv_visible_surface){ scene, elements, rsv_touch_distance(scene) };
}

bool rsv_point_is_buried(
    const rsv_visible_surface *surface, const rsv_face_point *point, uint32_t seed, uint64_t *rays)
{
    const rsv_elements *e = surface->elements;
    const rsv_hit place = {
        .triangle = e->face_triangle[point->face], .u = point->u, .v = point->v
    };
    rsv_surface_point at =
        rsv_surface_point_at(e->scene, place.triangle, place.u, place.v, e->face_back[point->face]);
    return rsv_is_touched_or_hidden(surface->scene, place, &at, surface->contact, rays) ||
           rsv_is_within_body(surface->scene,
               rsv_offset_origin(at.position, at.geometric, at.extent), at.geometric, seed, rays);
}
