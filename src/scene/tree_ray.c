#include "tree_ray.h"

/// Moeller and Trumbore (1997), in double and with edges included: nothing slips through between triangles.
static bool meets(const rsv_tree_ray *r, uint32_t triangle, rsv_hit *hit)
{
    const rsv_scene_view *view = r->view;
    const rsv_ray *ray = &r->ray;
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 p[3] = { view->position[corner[0]], view->position[corner[1]],
        view->position[corner[2]] };
    double a[3] = { (double)p[1].x - p[0].x, (double)p[1].y - p[0].y, (double)p[1].z - p[0].z };
    double b[3] = { (double)p[2].x - p[0].x, (double)p[2].y - p[0].y, (double)p[2].z - p[0].z };
    double o[3] = { (double)ray->origin.x - p[0].x, (double)ray->origin.y - p[0].y,
        (double)ray->origin.z - p[0].z };
    double d[3] = { ray->direction.x, ray->direction.y, ray->direction.z };
    double db[3] = { d[1] * b[2] - d[2] * b[1], d[2] * b[0] - d[0] * b[2],
        d[0] * b[1] - d[1] * b[0] };
    double oa[3] = { o[1] * a[2] - o[2] * a[1], o[2] * a[0] - o[0] * a[2],
        o[0] * a[1] - o[1] * a[0] };
    double volume = db[0] * a[0] + db[1] * a[1] + db[2] * a[2];
    if (volume == 0) return false;
    double u = (db[0] * o[0] + db[1] * o[1] + db[2] * o[2]) / volume;
    double v = (oa[0] * d[0] + oa[1] * d[1] + oa[2] * d[2]) / volume;
    double t = (oa[0] * b[0] + oa[1] * b[1] + oa[2] * b[2]) / volume;
    if (u < -1e-7 || v < -1e-7 || u + v > 1 + 1e-7 || t <= (double)r->t_min || t >= (double)hit->t)
        return false;
    float inside = f_min(f_max((float)u, 0), 1);
    if (rsv_is_cut_out(view, triangle, inside, f_min(f_max((float)v, 0), 1 - inside))) return false;
    *hit = (rsv_hit){ triangle, (float)t, inside, f_min(f_max((float)v, 0), 1 - inside) };
    return true;
}

/// A ray prepared for box tests.
typedef struct box_ray {
    float from[3];
    float inverse[3]; ///< of the direction; 0 = the ray is parallel to the faces
    float slack;
} box_ray;

static box_ray box_ray_of(const rsv_tree_ray *r)
{
    const float *from = &r->ray.origin.x, *along = &r->ray.direction.x;
    box_ray b = { .slack = r->slack };
    for (int k = 0; k < 3; k++) {
        b.from[k] = from[k];
        b.inverse[k] = fabsf(along[k]) < 1e-12f ? 0 : 1 / along[k];
    }
    return b;
}

/// @param enter, leave the part of the ray that counts
static bool misses_box(const rsv_twin_node *node, const box_ray *r, float enter, float leave)
{
    const float *low = &node->low.x, *high = &node->high.x;
    for (int k = 0; k < 3; k++) {
        float near = low[k] - r->slack - r->from[k], far = high[k] + r->slack - r->from[k];
        if (r->inverse[k] == 0) {
            if (near > 0 || far < 0) return true;
            continue;
        }
        float a = near * r->inverse[k], b = far * r->inverse[k];
        enter = f_max(enter, f_min(a, b));
        leave = f_min(leave, f_max(a, b));
    }
    return enter > leave;
}

static bool counts(const rsv_tree_ray *r, uint32_t triangle)
{
    return !r->kind_of || r->kind_of[triangle] == r->kind;
}

bool rsv_tree_ray_closest(const rsv_tree_ray *r, rsv_hit *hit)
{
    const rsv_twin_tree *tree = r->tree;
    box_ray boxes = box_ray_of(r);
    *hit = (rsv_hit){ RSV_NONE, INFINITY, 0, 0 };
    for (uint32_t n = 0; n < tree->node_count;) {
        const rsv_twin_node *node = &tree->node[n];
        bool misses = misses_box(node, &boxes, 0, hit->t);
        if (!misses && node->next == n + 1)
            for (uint32_t k = node->first; k < node[1].first; k++)
                if (counts(r, tree->face[k])) meets(r, tree->face[k], hit);
        n = misses ? node->next : n + 1;
    }
    return hit->triangle != RSV_NONE;
}

uint32_t rsv_tree_ray_all(const rsv_tree_ray *r, float *t, uint32_t most)
{
    const rsv_twin_tree *tree = r->tree;
    rsv_tree_ray line = *r;
    box_ray boxes = box_ray_of(r);
    uint32_t count = 0;
    line.t_min = -INFINITY;
    for (uint32_t n = 0; n < tree->node_count && count < most;) {
        const rsv_twin_node *node = &tree->node[n];
        bool misses = misses_box(node, &boxes, -INFINITY, INFINITY);
        if (!misses && node->next == n + 1)
            for (uint32_t k = node->first; k < node[1].first && count < most; k++) {
                rsv_hit hit = { RSV_NONE, INFINITY, 0, 0 };
                if (counts(r, tree->face[k]) && meets(&line, tree->face[k], &hit))
                    t[count++] = hit.t;
            }
        n = misses ? node->next : n + 1;
    }
    return count;
}
