#include "bake_cells.h"

#include "../core/vec.h"
#include "bake_constants.h"

// ---- light ----------------------------------------------------------------------------------------

rsv_bake_receiver rsv_bake_cells_receiver(const rsv_bake_cells *q, float w1, float w2)
{
    rsv_bake_receiver r = { .triangle = q->part->triangle[q->t], .back = q->part->back[q->t] };
    rsv_bake_place(q->part, w1, w2, &r.u, &r.v);
    return r;
}

rsv_bake_receiver rsv_bake_cells_pulled(
    const rsv_bake_cells *q, float w1, float w2, float m1, float m2)
{
    float w[2] = { w1, w2 };
    rsv_bake_lattices_stand_in(q->lattices, q->t, w);
    return rsv_bake_cells_receiver(q, w[0] + PULL * (m1 - w[0]), w[1] + PULL * (m2 - w[1]));
}

rsv_rgb rsv_bake_cells_light(const rsv_bake_cells *q, float w1, float w2)
{
    return rsv_bake_lattices_at(q->lattices, q->t, w1, w2);
}

static float difference(rsv_rgb a, rsv_rgb b)
{
    return fabsf(a.r - b.r) + fabsf(a.g - b.g) + fabsf(a.b - b.b);
}

bool rsv_bake_cells_agree(const rsv_bake_cells *q, rsv_rgb a, rsv_rgb b, float tolerance)
{
    return difference(a, b) <= tolerance * (a.r + a.g + a.b + 3 * q->desc->accuracy.dark);
}

// ---- deciding -------------------------------------------------------------------------------------

/// Whether cell `node` must stay divided. @param c weights of its corners
static bool decide(rsv_bake_cells *q, size_t node, int depth, const float (*c)[2])
{
    if (depth == q->depth) return false;
    float m[3][2];
    for (int axis = 0; axis < 2; axis++)
        for (int k = 0; k < 3; k++)
            m[k][axis] = 0.5f * (c[k][axis] + c[(k + 1) % 3][axis]);
    const float child[4][3][2] = {
        { { c[0][0], c[0][1] }, { m[0][0], m[0][1] }, { m[2][0], m[2][1] } },
        { { m[0][0], m[0][1] }, { c[1][0], c[1][1] }, { m[1][0], m[1][1] } },
        { { m[2][0], m[2][1] }, { m[1][0], m[1][1] }, { c[2][0], c[2][1] } },
        { { m[1][0], m[1][1] }, { m[2][0], m[2][1] }, { m[0][0], m[0][1] } },
    };
    bool split = false;
    for (size_t k = 0; k < 4; k++)
        split |= decide(q, 4 * node + 1 + k, depth + 1, child[k]);
    rsv_rgb light[3];
    for (int k = 0; k < 3 && !split; k++)
        light[k] = rsv_bake_cells_light(q, c[k][0], c[k][1]);
    for (int k = 0; k < 3 && !split; k++) {
        rsv_rgb linear = rgb_scale(rgb_add(light[k], light[(k + 1) % 3]), 0.5f);
        rsv_rgb truth = rsv_bake_cells_light(q, m[k][0], m[k][1]);
        split = rsv_bake_lattices_is_open(q->lattices, q->t, m[k][0], m[k][1]) &&
                !rsv_bake_cells_agree(q, truth, linear, q->desc->tolerance);
    }
    q->split[node] = split;
    return split;
}

void rsv_bake_cells_decide(rsv_bake_cells *q)
{
    static const float whole[3][2] = { { 0, 0 }, { 1, 0 }, { 0, 1 } };
    q->depth = q->lattices->depth[q->t];
    decide(q, 0, 0, whole);
}
