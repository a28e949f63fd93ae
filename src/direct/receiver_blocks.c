#include "receiver_blocks.h"

#include "../core/morton.h"
#include "../core/parallel.h"
#include "../receiver/receiver.h"
#include "../trace/packet.h"
#include "direct_receiver.h"

#include <stdlib.h>
#include <string.h>

/// A node's place on a space-filling curve.
typedef struct curve_place {
    uint64_t key;
    uint32_t node;
} curve_place;

typedef struct builder {
    rsv_receiver_blocks *b;
    uint32_t points, seed;
    const uint16_t *valid_points;
    const bool *moves; ///< [material_count]
    rsv_vec3 low;
    float scale; ///< 1 / the longest side of the box of all
    curve_place *place;
    size_t count;
} builder;

static uint32_t material_of(const rsv_receiver_blocks *b, uint32_t node)
{
    return b->scene->view
        ->triangle_material[b->elements->face_triangle[b->elements->node_face[node]]];
}

/// The first few of a node's points that are not buried. @return how many
static uint32_t find_points(
    const builder *w, uint32_t node, rsv_support_point *sample, rsv_receiver *receiver)
{
    const rsv_elements *e = w->b->elements;
    uint32_t count = 0;
    rsv_elements_sample_support(e, node, w->points, w->seed, sample);
    for (uint32_t k = 0; k < w->points && count < RSV_BLOCK_POINTS; k++) {
        if (!(w->valid_points[node] >> k & 1)) continue;
        uint32_t face = e->cell[sample[k].support / 4].face;
        uint32_t triangle = e->face_triangle[face];
        float u = sample[k].u, v = sample[k].v;
        receiver[count++] = rsv_receiver_at(e->scene, w->b->scene->tracer, triangle, u, v,
            rsv_surface_point_seen(
                e->scene, triangle, u, v, e->face_back[face], rsv_direct_width(e, node)));
    }
    return count;
}

static bool absorbs(const rsv_transport_scene *scene, const rsv_receiver *r)
{
    if (scene->view->fog) return true;
    rsv_medium medium = rsv_medium_above(&scene->media, r->origin, r->point.geometric);
    return rsv_medium_absorbs(&medium, scene->bsdf);
}

// ---- order ------------------------------------------------------------------------------------------

#define CURVE_BITS 16

/// Neighbours in space come one after the other, those that face another way in a run of their own.
static uint64_t curve_key(const builder *w, rsv_vec3 p, rsv_vec3 n)
{
    rsv_vec3 place = v3_scale(v3_sub(p, w->low), w->scale);
    uint64_t key = rsv_morton_key(place.x, place.y, place.z, CURVE_BITS);
    uint64_t octant = (n.x < 0 ? 1u : 0u) | (n.y < 0 ? 2u : 0u) | (n.z < 0 ? 4u : 0u);
    const int fine = 30; // 64 cells along the scene
    return (key >> fine) << (fine + 3) | octant << fine | (key & ((1ull << fine) - 1));
}

static int compare_places(const void *left, const void *right)
{
    const curve_place *a = left, *b = right;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->node > b->node) - (a->node < b->node);
}

static void measure_scene(builder *w)
{
    const rsv_scene_view *view = w->b->scene->view;
    rsv_vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_neg(low);
    for (size_t v = 0; v < view->vertex_count; v++) {
        low = v3_min(low, view->position[v]);
        high = v3_max(high, view->position[v]);
    }
    float side = v3_max_abs(v3_sub(high, low));
    w->low = low;
    w->scale = side > 0 ? 1 / side : 0;
}

/// Selects the nodes to store, and their positions on the curve.
static void place_nodes(void *data, rsv_span span)
{
    const builder *w = data;
    const rsv_receiver_blocks *b = w->b;
    for (size_t node = span.begin; node < span.end; node++) {
        rsv_support_point sample[RSV_SUPPORT_POINTS];
        rsv_receiver receiver[RSV_BLOCK_POINTS];
        w->place[node] = (curve_place){ UINT64_MAX, (uint32_t)node };
        b->held[node] = !w->valid_points[node];
        if (b->held[node] || w->moves[material_of(b, (uint32_t)node)]) continue;
        find_points(w, (uint32_t)node, sample, receiver);
        const rsv_surface_point *first = &receiver[0].point;
        b->held[node] = !absorbs(b->scene, &receiver[0]);
        if (b->held[node]) w->place[node].key = curve_key(w, first->position, first->geometric);
    }
}

/// Lists the nodes to store, in order.
static rsv_status sort_nodes(builder *w)
{
    rsv_receiver_blocks *b = w->b;
    size_t nodes = rsv_elements_surface_nodes(b->elements);
    w->place = rsv_alloc(b->context, nodes, sizeof *w->place);
    if (!w->place) return RSV_ERROR_MEMORY;
    rsv_parallel_for(b->context, nodes, 256, place_nodes, w);
    b->holds_all = nodes == b->elements->node_count;
    for (size_t node = 0; node < nodes; node++) {
        b->holds_all = b->holds_all && b->held[node];
        if (w->place[node].key != UINT64_MAX) w->place[w->count++] = w->place[node];
    }
    qsort(w->place, w->count, sizeof *w->place, compare_places);
    return RSV_OK;
}

// ---- blocks -----------------------------------------------------------------------------------------

static void set_lane(rsv_receiver_block *block, uint32_t lane, const rsv_receiver *r)
{
    const rsv_surface_point *p = &r->point;
    block->x[lane] = r->origin.x, block->y[lane] = r->origin.y, block->z[lane] = r->origin.z;
    block->normal_x[lane] = p->normal.x;
    block->normal_y[lane] = p->normal.y;
    block->normal_z[lane] = p->normal.z;
    block->valid |= 1u << lane;
    if (!rsv_is_lifted(p)) return;
    block->lifted |= 1u << lane;
    block->geometric[lane] = p->geometric;
    block->lift[lane] = p->lift;
}

void rsv_receiver_block_lift(const rsv_receiver_block *block, rsv_ray_packet *packet)
{
    for (uint32_t left = block->lifted; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        if (!(packet->t_max[k] > 0)) continue;
        rsv_surface_point point = { .geometric = block->geometric[k], .lift = block->lift[k] };
        rsv_ray ray = { v3(packet->origin_x[k], packet->origin_y[k], packet->origin_z[k]),
            v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]),
            packet->t_max[k] };
        rsv_lift_ray(&point, &ray);
        rsv_packet_set_ray(packet, k, ray);
    }
}

static void fill_block(const builder *w, size_t index)
{
    rsv_receiver_block *block = &w->b->block[index];
    for (uint32_t n = 0; n < RSV_BLOCK_NODES; n++) {
        size_t k = index * RSV_BLOCK_NODES + n;
        rsv_support_point sample[RSV_SUPPORT_POINTS];
        rsv_receiver receiver[RSV_BLOCK_POINTS];
        block->node[n] = k < w->count ? w->place[k].node : RSV_NONE;
        if (k >= w->count) continue;
        uint32_t node = block->node[n], count = find_points(w, node, sample, receiver);
        for (uint32_t p = 0; p < count; p++)
            set_lane(block, n * RSV_BLOCK_POINTS + p, &receiver[p]);
        if (!w->b->entry) continue;
        block->coated = block->coated || w->b->scene->bsdf[material_of(w->b, node)].coated;
        w->b->entry[k] =
            rsv_elements_entry(w->b->elements, node, sample, w->points, w->valid_points[node]);
    }
}

static void fill_blocks(void *data, rsv_span span)
{
    for (size_t k = span.begin; k < span.end; k++)
        fill_block(data, k);
}

static bool any_coated(const rsv_transport_scene *scene)
{
    for (size_t m = 0; m < scene->view->material_count; m++)
        if (scene->bsdf[m].coated) return true;
    return false;
}

rsv_status rsv_receiver_blocks_create(const rsv_transport_scene *scene,
    const rsv_elements *elements, rsv_support_draw draw, const uint16_t *valid_points,
    const bool *moves, rsv_receiver_blocks **blocks)
{
    rsv_status status;
    rsv_context *context = elements->context;
    rsv_receiver_blocks *b = rsv_alloc(context, 1, sizeof *b);
    if (!b) return RSV_ERROR_MEMORY;
    *b = (rsv_receiver_blocks){ .context = context, .scene = scene, .elements = elements };
    builder w = { .b = b,
        .points = draw.points,
        .seed = draw.seed,
        .valid_points = valid_points,
        .moves = moves };
    b->held = rsv_alloc(context, elements->node_count, sizeof *b->held);
    RSV_TRY(b->held ? RSV_OK : RSV_ERROR_MEMORY);
    measure_scene(&w);
    RSV_TRY(sort_nodes(&w));
    b->block_count = (w.count + RSV_BLOCK_NODES - 1) / RSV_BLOCK_NODES;
    b->block = rsv_alloc(context, b->block_count, sizeof *b->block);
    b->edge = rsv_alloc(context, elements->node_count, sizeof *b->edge);
    b->sums = rsv_alloc(context, elements->node_count, sizeof *b->sums);
    b->spread = rsv_alloc(context, elements->node_count, sizeof *b->spread);
    RSV_TRY(b->block && b->edge && b->sums && b->spread ? RSV_OK : RSV_ERROR_MEMORY);
    if (any_coated(scene)) {
        b->entry = rsv_alloc(context, b->block_count * RSV_BLOCK_NODES, sizeof *b->entry);
        RSV_TRY(b->entry ? RSV_OK : RSV_ERROR_MEMORY);
    }
    rsv_parallel_for(context, b->block_count, 64, fill_blocks, &w);
    *blocks = b;
    b = NULL;
cleanup:
    rsv_free(context, w.place);
    rsv_receiver_blocks_destroy(b);
    return status;
}

void rsv_receiver_blocks_destroy(rsv_receiver_blocks *b)
{
    if (!b) return;
    rsv_free(b->context, b->block);
    rsv_free(b->context, b->entry);
    rsv_free(b->context, b->edge);
    rsv_free(b->context, b->sums);
    rsv_free(b->context, b->spread);
    rsv_free(b->context, b->held);
    rsv_free(b->context, b);
}
