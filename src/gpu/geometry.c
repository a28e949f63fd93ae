#include "geometry.h"

rsv_gpu_geometry rsv_gpu_geometry_of(const rsv_scene_view *view, rsv_bvh_view bvh)
{
    return (rsv_gpu_geometry){ .host = view, .host_bvh = bvh, .bvh = bvh };
}

void rsv_gpu_geometry_place(rsv_gpu_geometry *g, rsv_gpu_block *b)
{
    const rsv_scene_view *host = g->host;
    rsv_scene_view *view = &g->view;
    g->view_there = rsv_gpu_place(b, 1, sizeof *g->view_there);
    view->position = rsv_gpu_place(b, host->vertex_count, sizeof *host->position);
    view->normal = rsv_gpu_place(b, host->vertex_count, sizeof *host->normal);
    view->triangle = rsv_gpu_place(b, host->triangle_count, sizeof *host->triangle);
    view->triangle_material =
        rsv_gpu_place(b, host->triangle_count, sizeof *host->triangle_material);
    view->material = rsv_gpu_place(b, host->material_count, sizeof *host->material);
    g->bvh.node = rsv_gpu_place(b, g->host_bvh.node_count, sizeof *g->bvh.node);
    g->bvh.triangle = rsv_gpu_place(b, g->host_bvh.triangle_count, sizeof *g->bvh.triangle);
}

void rsv_gpu_geometry_upload(const rsv_gpu_geometry *g, rsv_gpu *gpu)
{
    const rsv_scene_view *host = g->host, *view = &g->view;
    const rsv_bvh_view *bvh = &g->host_bvh;
    const rsv_gpu_array array[] = { { g->view_there, view, 1, sizeof *view },
        { view->position, host->position, host->vertex_count, sizeof *host->position },
        { view->normal, host->normal, host->vertex_count, sizeof *host->normal },
        { view->triangle, host->triangle, host->triangle_count, sizeof *host->triangle },
        { view->triangle_material, host->triangle_material, host->triangle_count,
            sizeof *host->triangle_material },
        { view->material, host->material, host->material_count, sizeof *host->material },
        { g->bvh.node, bvh->node, bvh->node_count, sizeof *bvh->node },
        { g->bvh.triangle, bvh->triangle, bvh->triangle_count, sizeof *bvh->triangle } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
}
