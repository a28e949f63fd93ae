/// The light of all lamps: a cut through their tree.
#include "lamps.h"

#include "../sources/local_lights.h"
#include "lobe_polygon.h"

/// Nodes go undivided below this share of the light.
#define NEGLIGIBLE 2e-3f

/// The widest a lobe of width w is from an angle whose tangent is r away.
static float widened(float width, float r) { return sqrtf(width * width + r * r); }

/// A bound of the response, roughly: that of lobes as much wider as the lamps are.
static float rough_response(const rsv_highlight_lobes *l, rsv_vec3 wi, float r)
{
    float sum = 0;
    for (uint32_t k = 0; k < l->count; k++) {
        const rsv_highlight_lobe *lobe = &l->lobe[k];
        rsv_lobe_shape shape = lobe->shape;
        rsv_vec3 to = wi;
        if (rsv_lobe_is_below(lobe->kind)) to.z = -to.z;
        if (!(to.z > -r)) continue;
        to.z = f_max(to.z, 0.1f * r + 1e-3f);
        shape.width_x = widened(shape.width_x, r);
        shape.width_y = widened(shape.width_y, r);
        sum += rgb_max(lobe->albedo) * rsv_lobe_density(&shape, to);
    }
    return sum;
}

static float narrowest(const rsv_highlight_lobes *l)
{
    float width = 1;
    for (uint32_t k = 0; k < l->count; k++)
        width = f_min(width, f_min(l->lobe[k].shape.width_x, l->lobe[k].shape.width_y));
    return width;
}

float rsv_lamp_urge(
    const rsv_highlights *h, const rsv_highlight_lobes *l, uint32_t index, float *detail)
{
    const rsv_lamp_node *node = &h->lamps.node[index];
    rsv_vec3 towards = v3_sub(node->middle, l->point.position);
    float distance2 = v3_dot(towards, towards), radius2 = node->radius * node->radius;
    *detail = 1;
    if (!(distance2 > 1.5f * radius2)) {
        // among them: all of them may be close
        float flow = v3_length(node->flow) +
                     sqrtf(f_max(node->facing[0] + node->facing[1] + node->facing[2], 0));
        return flow / f_max(radius2, 1e-30f);
    }
    rsv_vec3 wi = v3_scale(towards, 1 / sqrtf(distance2));
    float r2 = radius2 / distance2, r = sqrtf(r2), width = narrowest(l);
    float intensity = rsv_lamp_intensity(node, v3_neg(wi));
    if (node->right)
        intensity +=
            0.1f * r * sqrtf(f_max(node->facing[0] + node->facing[1] + node->facing[2], 0));
    *detail = r2 / (r2 + width * width);
    return intensity / distance2 * rough_response(l, rsv_to_lobe_frame(l, wi), r);
}

/// Nodes that stand for all lamps.
typedef struct lamp_cut {
    uint32_t node[RSV_MOST_POLYGONS];
    float estimate[RSV_MOST_POLYGONS], urge[RSV_MOST_POLYGONS];
    uint32_t count;
    float total;
} lamp_cut;

static void put(lamp_cut *cut, const rsv_highlights *h, const rsv_highlight_lobes *l,
    uint32_t place, uint32_t node)
{
    float detail;
    cut->node[place] = node;
    cut->estimate[place] = rsv_lamp_urge(h, l, node, &detail);
    cut->urge[place] = h->lamps.node[node].right ? cut->estimate[place] * detail : 0;
    cut->total += cut->estimate[place];
}

static uint32_t most_urgent(const lamp_cut *cut)
{
    uint32_t first = 0;
    for (uint32_t i = 1; i < cut->count; i++)
        if (cut->urge[i] > cut->urge[first]) first = i;
    return first;
}

static void find_cut(const rsv_highlights *h, const rsv_highlight_lobes *l, lamp_cut *cut)
{
    uint32_t most = h->desc.polygons;
    cut->count = 1;
    cut->total = 0;
    put(cut, h, l, 0, 0);
    while (cut->count < most) {
        uint32_t first = most_urgent(cut), node = cut->node[first];
        if (!(cut->urge[first] > NEGLIGIBLE * cut->total)) break;
        cut->total -= cut->estimate[first];
        put(cut, h, l, first, node + 1);
        put(cut, h, l, cut->count++, h->lamps.node[node].right);
    }
}

/// One lamp, exactly; several as a rectangle.
static rsv_rgb node_light(const rsv_highlights *h, const rsv_highlight_lobes *l, uint32_t index)
{
    const rsv_lamp_node *node = &h->lamps.node[index];
    if (node->right) {
        rsv_vec3 corner[4];
        float luminance = rsv_lamp_stand_in(node, l->point.position, corner);
        if (!(luminance > 0)) return rgb_gray(0);
        return rgb_mul(rgb_scale(node->color, luminance), rsv_highlight_polygon(l, corner, 4));
    }
    const rsv_lamp *lamp = &h->lamps.lamp[node->lamp];
    if (!rsv_emitter_faces(&h->lights->emitter[lamp->emitter], l->point.position))
        return rgb_gray(0);
    return rgb_mul(lamp->radiance, rsv_highlight_polygon(l, lamp->corner, lamp->count));
}

void rsv_lamps_light(
    const rsv_highlights *h, const rsv_highlight_lobes *l, rsv_light_taker take, void *user)
{
    lamp_cut cut;
    if (h->lamps.lamp_count == 0) return;
    find_cut(h, l, &cut);
    for (uint32_t i = 0; i < cut.count; i++) {
        if (!(cut.estimate[i] > 0)) continue;
        rsv_rgb light = node_light(h, l, cut.node[i]);
        if (!rgb_is_black(light)) take(user, h->lamps.node[cut.node[i]].group, light);
    }
}
