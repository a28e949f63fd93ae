#include "lamp_tree.h"

#include "../core/core.h"

#include <stdlib.h>

// ---- lamps --------------------------------------------------------------------------------------

static bool takes_part(const rsv_emitter_group *group, rsv_highlight_part part)
{
    if (group->muted) return false;
    return part & (group->gathered ? RSV_HIGHLIGHT_GATHERED : RSV_HIGHLIGHT_SAMPLED);
}

static bool same_place(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static rsv_lamp lamp_of(const rsv_lights *lights, uint32_t index)
{
    const rsv_emitter *e = &lights->emitter[index];
    return (rsv_lamp){ .corner = { e->corner[0], e->corner[1], e->corner[2] },
        .normal = e->normal,
        .radiance = e->radiance,
        .area = e->area,
        .count = 3,
        .emitter = index,
        .group = e->group,
        .double_sided = e->double_sided };
}

/// Adds the other half of a parallelogram, if `e` is that.
static bool complete(rsv_lamp *lamp, const rsv_emitter *e)
{
    bool alike = e->group == lamp->group && e->double_sided == lamp->double_sided &&
                 e->radiance.r == lamp->radiance.r && e->radiance.g == lamp->radiance.g &&
                 e->radiance.b == lamp->radiance.b && v3_dot(e->normal, lamp->normal) > 0.999999f;
    if (!alike || lamp->count != 3) return false;
    for (int i = 0; i < 3; i++) {
        rsv_vec3 before = lamp->corner[(i + 2) % 3], after = lamp->corner[(i + 1) % 3];
        for (int k = 0; k < 3; k++) {
            if (!same_place(e->corner[k], before) || !same_place(e->corner[(k + 1) % 3], after))
                continue;
            rsv_vec3 fourth = e->corner[(k + 2) % 3];
            rsv_vec3 wanted = v3_sub(v3_add(before, after), lamp->corner[i]);
            rsv_vec3 gap = v3_sub(fourth, wanted);
            if (v3_dot(gap, gap) > 1e-6f * lamp->area) continue;
            rsv_vec3 corner[4] = { lamp->corner[i], after, fourth, before };
            for (int c = 0; c < 4; c++)
                lamp->corner[c] = corner[c];
            lamp->count = 4;
            lamp->area += e->area;
            return true;
        }
    }
    return false;
}

static size_t collect(const rsv_lights *lights, rsv_highlight_part part, rsv_lamp *lamp)
{
    size_t count = 0;
    for (size_t g = 0; g < lights->group_count; g++) {
        const rsv_emitter_group *group = &lights->group[g];
        size_t first = count;
        if (!takes_part(group, part)) continue;
        for (uint32_t e = group->first; e < group->first + group->count; e++) {
            const rsv_emitter *emitter = &lights->emitter[e];
            if (rgb_is_black(emitter->radiance) || !(emitter->area > 0)) continue;
            if (count > first && complete(&lamp[count - 1], emitter)) continue;
            lamp[count++] = lamp_of(lights, e);
        }
    }
    return count;
}

static rsv_vec3 lamp_middle(const rsv_lamp *lamp)
{
    rsv_vec3 sum = v3(0, 0, 0);
    for (uint32_t i = 0; i < lamp->count; i++)
        sum = v3_add(sum, v3_sub(lamp->corner[i], lamp->corner[0]));
    return v3_mad(lamp->corner[0], 1 / (float)lamp->count, sum);
}

// ---- nodes --------------------------------------------------------------------------------------

typedef struct node_sums {
    double weight, area, place[3], square[6], color[3], flow[3], facing[6];
} node_sums;

static void add_outer(double sum[6], double weight, const float v[3])
{
    const int a[6] = { 0, 1, 2, 0, 0, 1 }, b[6] = { 0, 1, 2, 1, 2, 2 };
    for (int k = 0; k < 6; k++)
        sum[k] += weight * (double)v[a[k]] * (double)v[b[k]];
}

/// The second moments of a triangle and of a parallelogram, by their corners and middle.
static void add_place(node_sums *s, const rsv_lamp *lamp, rsv_vec3 origin, double weight)
{
    rsv_vec3 middle = v3_sub(lamp_middle(lamp), origin);
    const double corner = 1.0 / 12;
    const float m[3] = { middle.x, middle.y, middle.z };
    for (int k = 0; k < 3; k++)
        s->place[k] += weight * (double)m[k];
    for (uint32_t i = 0; i < lamp->count; i++) {
        rsv_vec3 c = v3_sub(lamp->corner[i], origin);
        const float v[3] = { c.x, c.y, c.z };
        add_outer(s->square, weight * corner, v);
    }
    add_outer(s->square, weight * (1 - corner * lamp->count), m);
}

static void add_lamp(node_sums *s, const rsv_lamp *lamp, rsv_vec3 origin)
{
    double luminance = (double)f_max(rgb_luminance(lamp->radiance), 1e-20f);
    double weight = (double)lamp->area * luminance, sides = lamp->double_sided ? 2 : 1;
    const float n[3] = { lamp->normal.x, lamp->normal.y, lamp->normal.z };
    s->weight += sides * weight;
    s->color[0] += weight * (double)lamp->radiance.r / luminance;
    s->color[1] += weight * (double)lamp->radiance.g / luminance;
    s->color[2] += weight * (double)lamp->radiance.b / luminance;
    s->area += weight;
    add_place(s, lamp, origin, weight);
    add_outer(s->facing, sides * weight, n);
    for (int k = 0; k < 3 && !lamp->double_sided; k++)
        s->flow[k] += weight * (double)n[k];
}

/// In the mean over all directions a lamp shows half of each side: of sqrt(w.Qw) too.
static double facing_scale(const node_sums *s)
{
    enum { DIRECTIONS = 64 };
    double mean = 0;
    float q[6];
    for (int k = 0; k < 6; k++)
        q[k] = (float)(s->facing[k] * s->weight);
    for (uint32_t i = 0; i < DIRECTIONS; i++) {
        float x, y;
        rsv_shared_place(i, &x, &y);
        mean += sqrt(fmax((double)rsv_quadratic(q, rsv_square_to_sphere(x, y)), 0)) / DIRECTIONS;
    }
    return mean > 0 ? 0.5 * s->weight / mean : 0;
}

static float farthest(const rsv_lamp *lamp, size_t count, rsv_vec3 middle)
{
    float radius2 = 0;
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < lamp[i].count; c++) {
            rsv_vec3 arm = v3_sub(lamp[i].corner[c], middle);
            radius2 = f_max(radius2, v3_dot(arm, arm));
        }
    return sqrtf(radius2);
}

static void sum_up(const rsv_lamp *lamp, size_t count, rsv_lamp_node *node)
{
    node_sums s = { 0 };
    rsv_vec3 origin = lamp->corner[0];
    for (size_t i = 0; i < count; i++)
        add_lamp(&s, &lamp[i], origin);
    float shift[3];
    for (int k = 0; k < 3; k++)
        shift[k] = (float)(s.place[k] / s.area);
    node->middle = v3_add(origin, v3(shift[0], shift[1], shift[2]));
    node->radius = farthest(lamp, count, node->middle);
    node->flow = v3((float)s.flow[0], (float)s.flow[1], (float)s.flow[2]);
    node->color = rgb(
        (float)(s.color[0] / s.area), (float)(s.color[1] / s.area), (float)(s.color[2] / s.area));
    double scale = count == 1 ? 1 : facing_scale(&s), back[6] = { 0 };
    add_outer(back, 1, shift);
    for (int k = 0; k < 6; k++) {
        node->facing[k] = (float)(s.facing[k] * s.weight * scale * scale);
        node->spread[k] = (float)(s.square[k] / s.area - back[k]);
    }
}

// ---- the tree -----------------------------------------------------------------------------------

typedef struct tree_build {
    rsv_lamp *lamp;
    rsv_lamp_node *node;
    uint32_t *root;
    uint32_t node_count;
} tree_build;

static float along(rsv_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static int longest_axis(const rsv_lamp *lamp, size_t count)
{
    rsv_vec3 low = lamp_middle(lamp), high = low;
    for (size_t i = 1; i < count; i++) {
        rsv_vec3 m = lamp_middle(&lamp[i]);
        low = v3_min(low, m), high = v3_max(high, m);
    }
    rsv_vec3 size = v3_sub(high, low);
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

static int compare(const void *left, const void *right, int axis)
{
    const rsv_lamp *a = left, *b = right;
    float x = along(lamp_middle(a), axis), y = along(lamp_middle(b), axis);
    if (x != y) return x < y ? -1 : 1;
    return a->emitter < b->emitter ? -1 : a->emitter > b->emitter;
}
static int compare_x(const void *a, const void *b) { return compare(a, b, 0); }
static int compare_y(const void *a, const void *b) { return compare(a, b, 1); }
static int compare_z(const void *a, const void *b) { return compare(a, b, 2); }

/// Groups stay whole as long as there are several. They come in their order.
static size_t divide(rsv_lamp *lamp, size_t count)
{
    size_t half = count / 2;
    if (lamp[0].group != lamp[count - 1].group) {
        size_t up = half, down = half;
        while (up < count && lamp[up].group == lamp[up - 1].group)
            up++;
        while (down > 0 && lamp[down].group == lamp[down - 1].group)
            down--;
        return down > 0 && (up == count || half - down < up - half) ? down : up;
    }
    int axis = longest_axis(lamp, count);
    qsort(lamp, count, sizeof *lamp, axis == 0 ? compare_x : axis == 1 ? compare_y : compare_z);
    return half;
}

/// Depth first; the stack holds the right halves.
static void build(tree_build *b, size_t first, size_t count)
{
    uint32_t index = b->node_count++;
    rsv_lamp_node *node = &b->node[index];
    rsv_lamp *lamp = b->lamp + first;
    sum_up(lamp, count, node);
    bool one = lamp[0].group == lamp[count - 1].group;
    node->group = one ? lamp[0].group : RSV_NONE;
    if (one && b->root[node->group] == RSV_NONE) b->root[node->group] = index;
    node->right = 0;
    if (count > 1) {
        size_t left = divide(lamp, count);
        build(b, first, left);
        node->right = b->node_count;
        build(b, first + left, count - left);
    }
    node->lamp = (uint32_t)first;
}

rsv_status rsv_lamp_tree_create(
    const rsv_lights *lights, rsv_highlight_part part, rsv_lamp_tree *tree)
{
    rsv_context *context = lights->context;
    *tree = (rsv_lamp_tree){ 0 };
    tree->root = rsv_alloc(context, lights->group_count + 1, sizeof *tree->root);
    tree->lamp = rsv_alloc(context, lights->emitter_count + 1, sizeof *tree->lamp);
    if (!tree->root || !tree->lamp) return RSV_ERROR_MEMORY;
    for (size_t g = 0; g < lights->group_count; g++)
        tree->root[g] = RSV_NONE;
    tree->lamp_count = collect(lights, part, tree->lamp);
    if (tree->lamp_count == 0) return RSV_OK;
    tree->node = rsv_alloc(context, 2 * tree->lamp_count, sizeof *tree->node);
    if (!tree->node) return RSV_ERROR_MEMORY;
    tree_build b = { tree->lamp, tree->node, tree->root, 0 };
    build(&b, 0, tree->lamp_count);
    return RSV_OK;
}

void rsv_lamp_tree_destroy(rsv_context *context, rsv_lamp_tree *tree)
{
    rsv_free(context, tree->lamp);
    rsv_free(context, tree->node);
    rsv_free(context, tree->root);
}

// ---- stand-ins ----------------------------------------------------------------------------------

/// Covariance across the directions t and b.
static float bilinear(const float q[6], rsv_vec3 t, rsv_vec3 b)
{
    return q[0] * t.x * b.x + q[1] * t.y * b.y + q[2] * t.z * b.z + q[3] * (t.x * b.y + t.y * b.x) +
           q[4] * (t.x * b.z + t.z * b.x) + q[5] * (t.y * b.z + t.z * b.y);
}

float rsv_lamp_stand_in(const rsv_lamp_node *node, rsv_vec3 point, rsv_vec3 *corner)
{
    rsv_vec3 w = v3_normalize(v3_sub(point, node->middle)), t, b;
    v3_frame(w, &t, &b);
    float tt = bilinear(node->spread, t, t), bb = bilinear(node->spread, b, b);
    float tb = bilinear(node->spread, t, b), mean = 0.5f * (tt + bb);
    float turn = 0.5f * atan2f(2 * tb, tt - bb), c = cosf(turn), s = sinf(turn);
    float apart = sqrtf(0.25f * (tt - bb) * (tt - bb) + tb * tb);
    rsv_vec3 along = v3_mad(v3_scale(t, c), s, b), across = v3_mad(v3_scale(b, c), -s, t);
    float least = 1e-3f * node->radius; // sqrt(3) standard deviations are half a side
    along = v3_scale(along, f_max(sqrtf(f_max(3 * (mean + apart), 0)), least));
    across = v3_scale(across, f_max(sqrtf(f_max(3 * (mean - apart), 0)), least));
    corner[0] = v3_sub(v3_sub(node->middle, along), across);
    corner[1] = v3_sub(v3_add(node->middle, along), across);
    corner[2] = v3_add(v3_add(node->middle, along), across);
    corner[3] = v3_add(v3_sub(node->middle, along), across);
    float area = 4 * v3_length(along) * v3_length(across);
    return area > 0 ? rsv_lamp_intensity(node, w) / area : 0;
}
