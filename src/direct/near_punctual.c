#include "near_punctual.h"

#include "direct_constants.h"

static const rsv_punctual_light *light_at(const rsv_lights *lights, uint32_t k)
{
    return &lights->scene->light[lights->punctual[k]];
}

/// Length of the longest side of a node's cells, about.
static float reach_of(const rsv_elements *e, uint32_t node)
{
    float area = 0;
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        area = f_max(area, rsv_cell_area(e, e->support[s] / 4));
    return 2 * sqrtf(area);
}

uint32_t rsv_near_punctual(const rsv_direct_job *job, uint32_t node)
{
    const rsv_lights *lights = job->setting.lights;
    uint32_t near_lights = 0, count = rsv_punctual_count(lights);
    if (lights->punctual_tree || lights->distant_count == lights->punctual_count) return 0;
    rsv_surface_point point = rsv_elements_node_point(job->scene->view, job->elements, node);
    float reach = reach_of(job->elements, node);
    for (uint32_t k = 0; k < count && k < RSV_SUMMED_LIGHTS; k++) {
        const rsv_punctual_light *light = light_at(lights, k);
        if (rsv_punctual_is_distant(light) || rsv_punctual_is_extended(light)) continue;
        rsv_vec3 towards = v3_sub(rsv_punctual_place_by(light, 0.5f, k), point.position);
        bool close = v3_dot(towards, towards) < NEAR_LIGHT * NEAR_LIGHT * reach * reach;
        if (close && v3_dot(towards, point.geometric) > 0) near_lights |= 1u << k;
    }
    return near_lights;
}

/// One light and one node.
typedef struct average {
    const rsv_direct_job *job;
    rsv_entrance entrance;
    uint32_t node, light;
    rsv_vec3 place; ///< of the light
    double sum[3];  ///< of irradiance times hat function times area
    double area;    ///< the same of an irradiance of 1
    uint32_t seen, hidden, rays;
    uint32_t triangle; ///< of the cell in hand
    bool back;
    float weight; ///< of the node's value there
} average;

/// A part of a cell.
typedef struct part {
    float corner[3][3]; ///< u, v and the hat function
    float area;
    int depth;
} part;

static rsv_surface_point point_of(const average *a, const float middle[3])
{
    return rsv_surface_point_seen(a->job->scene->view, a->triangle, middle[0], middle[1], a->back,
        rsv_direct_width(a->job->elements, a->node));
}

/// Takes a part for as bright as its middle.
static void add_part(average *a, const float middle[3], const rsv_surface_point *point, float area)
{
    const rsv_transport_scene *scene = a->job->scene;
    rsv_receiver at =
        rsv_receiver_at(scene->view, scene->tracer, a->triangle, middle[0], middle[1], *point);
    rsv_next_event event;
    rsv_next_event_punctual(&at, &a->entrance, a->job->setting.lights, a->light, 0.5f, &event);
    float passed = rsv_next_event_passed(scene->tracer, &event);
    a->rays += rsv_next_event_asks(&event);
    a->seen += passed > 0;
    a->hidden += passed < 1 && !rgb_is_black(event.light);
    if (!(passed > 0)) return;
    double weight = (double)(a->weight * area * middle[2] * passed);
    a->sum[0] += weight * (double)event.light.r;
    a->sum[1] += weight * (double)event.light.g;
    a->sum[2] += weight * (double)event.light.b;
}

/// Child k keeps that corner, the last one is the middle.
static part child_of(const part *whole, int k)
{
    part child = { .area = whole->area / 4, .depth = whole->depth + 1 };
    for (int corner = 0; corner < 3; corner++)
        for (int i = 0; i < 3; i++) {
            int other = k < 3 ? k : (corner + 1) % 3, own = k < 3 ? corner : (corner + 2) % 3;
            child.corner[corner][i] = (whole->corner[own][i] + whole->corner[other][i]) / 2;
        }
    return child;
}

static void divide(average *a, const part *p) // NOLINT(misc-no-recursion): to NEAR_LIGHT_DEPTH
{
    float middle[3];
    for (int i = 0; i < 3; i++)
        middle[i] = (p->corner[0][i] + p->corner[1][i] + p->corner[2][i]) / 3;
    rsv_surface_point point = point_of(a, middle);
    float distance = v3_length(v3_sub(a->place, point.position));
    if (p->depth == NEAR_LIGHT_DEPTH || sqrtf(2 * p->area) <= NEAR_LIGHT_PART * distance) {
        add_part(a, middle, &point, p->area);
        return;
    }
    for (int k = 0; k < 4; k++) {
        part child = child_of(p, k);
        divide(a, &child);
    }
}

static void visit(void *user, uint32_t support, float weight)
{
    average *a = user;
    const rsv_elements *e = a->job->elements;
    const rsv_cell *cell = &e->cell[support / 4];
    part whole = { .area = rsv_cell_area(e, support / 4) };
    for (int k = 0; k < 3; k++) {
        rsv_cell_corner(cell, k, &whole.corner[k][0], &whole.corner[k][1]);
        whole.corner[k][2] = k == (int)(support & 3) ? 1 : 0;
    }
    a->triangle = e->face_triangle[cell->face];
    a->back = e->face_back[cell->face];
    a->weight = weight;
    a->area += (double)(weight * whole.area / 3);
    divide(a, &whole);
}

void rsv_near_punctual_add(const rsv_direct_job *job, const rsv_node_receivers *receivers,
    uint32_t node, uint32_t near_lights, rsv_direct_estimate *estimate)
{
    const rsv_lights *lights = job->setting.lights;
    for (uint32_t k = 0; near_lights >> k; k++) {
        if (!(near_lights >> k & 1)) continue;
        average a = { .job = job,
            .entrance = rsv_direct_entrance(&job->setting, receivers),
            .node = node,
            .light = k,
            .place = rsv_punctual_place_by(light_at(lights, k), 0.5f, k) };
        rsv_elements_visit_support(job->elements, node, visit, &a);
        estimate->rays += a.rays;
        estimate->partial = estimate->partial || (a.seen > 0 && a.hidden > 0);
        if (!(a.area > 0)) continue;
        estimate->irradiance.r += (float)(a.sum[0] / a.area);
        estimate->irradiance.g += (float)(a.sum[1] / a.area);
        estimate->irradiance.b += (float)(a.sum[2] / a.area);
    }
}
