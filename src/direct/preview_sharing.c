#include "preview_sharing.h"

#include <stdatomic.h>

void rsv_preview_mark_edge(const rsv_receiver_blocks *b, uint32_t node)
{
    const rsv_elements *e = b->elements;
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        for (int k = 0; k < 3; k++) {
            uint32_t corner = e->cell_node[e->support[s] / 4][k];
            atomic_store_explicit(&b->edge[corner], 1, memory_order_relaxed);
        }
}

/// Mean over the corners of the cells around a node.
static rsv_preview_sums mean_around(
    const rsv_elements *e, uint32_t node, const rsv_preview_sums *sums)
{
    rsv_preview_sums all = { { 0, 0, 0 }, { 0, 0, 0 } };
    uint32_t begin = e->support_begin[node], end = e->support_begin[node + 1];
    float scale = 1 / (3 * (float)(end - begin));
    for (uint32_t s = begin; s < end; s++)
        for (int k = 0; k < 3; k++) {
            const rsv_preview_sums *one = &sums[e->cell_node[e->support[s] / 4][k]];
            all.open = rgb_mad(all.open, scale, one->open);
            all.visible = rgb_mad(all.visible, scale, one->visible);
        }
    return all;
}

void rsv_preview_share(const rsv_receiver_blocks *b, const rsv_receiver_block *block)
{
    for (uint32_t n = 0; n < RSV_BLOCK_NODES && block->node[n] != RSV_NONE; n++) {
        uint32_t node = block->node[n];
        b->spread[node] = b->edge[node] ? mean_around(b->elements, node, b->sums) : b->sums[node];
    }
}

static float ratio(float unshadowed, float visible, float open)
{
    return open > 0 ? unshadowed * (visible / open) : 0;
}

void rsv_preview_shadow(
    const rsv_receiver_blocks *b, const rsv_receiver_block *block, rsv_rgb *irradiance)
{
    for (uint32_t n = 0; n < RSV_BLOCK_NODES && block->node[n] != RSV_NONE; n++) {
        uint32_t node = block->node[n];
        rsv_rgb *e = &irradiance[node];
        if (rgb_is_black(*e)) continue;
        rsv_preview_sums s =
            b->edge[node] ? mean_around(b->elements, node, b->spread) : b->spread[node];
        *e = rgb(ratio(e->r, s.visible.r, s.open.r), ratio(e->g, s.visible.g, s.open.g),
            ratio(e->b, s.visible.b, s.open.b));
    }
}
