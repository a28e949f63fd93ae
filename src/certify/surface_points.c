#include "surface_points.h"

#include "../elements/spacing.h"

/// What is closer above a surface is in touch with it, in parts of the spacing of a draft's elements ...
#define CONTACT 0.02f
/// ... of which so many cover the scene, whatever the quality of the solution.
#define DRAFT_ELEMENTS 3000

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
    return (rsv_visible_surface){ scene, elements,
        CONTACT * rsv_spacing_for(scene, DRAFT_ELEMENTS).metres };
}

bool rsv_point_is_buried(
    const rsv_visible_surface *surface, const rsv_face_point *point, uint32_t seed, uint64_t *rays)
{
    const rsv_elements *e = surface->elements;
    rsv_hit place = { .triangle = e->face_triangle[point->face], .u = point->u, .v = point->v };
    rsv_surface_point at =
        rsv_surface_point_at(e->scene, place.triangle, place.u, place.v, e->face_back[point->face]);
    if (rsv_is_behind_twin(e->scene, place, at.geometric)) return true;
    rsv_vec3 origin = rsv_offset_origin(at.position, at.geometric, at.extent);
    rsv_ray up = { origin, at.geometric, surface->contact };
    ++*rays;
    return rsv_tracer_occluded(surface->scene->tracer, &up) ||
           rsv_is_within_body(surface->scene, origin, at.geometric, seed, rays);
}
