#include "bvh_internal.h"

#include "../scene/material_at.h"

static rsv_boxed_triangle boxed(
    const rsv_vec3 *position, const uint32_t corner[3], uint32_t triangle)
{
    rsv_vec3 a = position[corner[0]], b = position[corner[1]], c = position[corner[2]];
    rsv_box box = { v3_min(v3_min(a, b), c), v3_max(v3_max(a, b), c) };
    return (rsv_boxed_triangle){ box, triangle };
}

static rsv_status allocate(rsv_bvh *bvh, size_t count)
{
    bvh->node = rsv_reserve(bvh->context, count, sizeof *bvh->node);
    bvh->triangle = rsv_alloc(bvh->context, count, sizeof *bvh->triangle);
    return bvh->node && bvh->triangle ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status rsv_bvh_build(rsv_context *context, const rsv_vec3 *position,
    const uint32_t (*triangle)[3], size_t triangle_count, rsv_bvh *bvh)
{
    rsv_status status = RSV_OK;
    uint32_t count = (uint32_t)triangle_count, *order = NULL;
    rsv_boxed_triangle *part = NULL;
    rsv_binary_node *binary = NULL;
    *bvh = (rsv_bvh){ 0 };
    if (triangle_count > UINT32_MAX / 4)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "hierarchy: %zu triangles are too many; 2^30 at most", triangle_count);
    bvh->context = context;
    if (count == 0) return RSV_OK;
    RSV_TRY(allocate(bvh, count));
    status = RSV_ERROR_MEMORY;
    part = rsv_reserve(context, count, sizeof *part);
    binary = rsv_reserve(context, 2 * (size_t)count - 1, sizeof *binary);
    order = rsv_reserve(context, count, sizeof *order);
    if (!part || !binary || !order) goto cleanup;
    for (uint32_t k = 0; k < count; k++)
        part[k] = boxed(position, triangle[k], k);
    rsv_binary_build(context, part, count, binary);
    RSV_TRY(rsv_bvh_widen(context, binary, bvh->node, order, &bvh->view.node_count));
    for (uint32_t k = 0; k < count; k++) {
        uint32_t index = part[order[k]].triangle;
        const uint32_t *corner = triangle[index];
        bvh->triangle[k] = (rsv_bvh_triangle){ .a = position[corner[0]],
            .index = index,
            .b = position[corner[1]],
            .c = position[corner[2]] };
    }
    bvh->view.node = bvh->node;
    bvh->view.triangle = bvh->triangle;
    bvh->view.triangle_count = count;
cleanup:
    rsv_free(context, part);
    rsv_free(context, binary);
    rsv_free(context, order);
    if (status != RSV_OK) rsv_bvh_destroy(bvh);
    return status;
}

rsv_status rsv_bvh_build_scene(const rsv_scene *scene, rsv_bvh *bvh)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_status status = rsv_bvh_build(
        rsv_scene_get_context(scene), view->position, view->triangle, view->triangle_count, bvh);
    if (status == RSV_OK && (rsv_find_cut_out(view) || rsv_find_blended(view)))
        bvh->view.holes = view;
    if (status == RSV_OK && view->twins) bvh->view.twins = view;
    return status;
}

void rsv_bvh_destroy(rsv_bvh *bvh)
{
    if (!bvh->context) return;
    rsv_free(bvh->context, bvh->node);
    rsv_free(bvh->context, bvh->triangle);
    *bvh = (rsv_bvh){ 0 };
}
