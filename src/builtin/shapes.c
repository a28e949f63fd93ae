#include "shapes.h"

#include <string.h>

static rsv_status add_shape(rsv_shape shape, rsv_mesh_desc mesh)
{
    rsv_status status;
    uint32_t id;
    mesh.name = shape.name;
    mesh.material = shape.material;
    RSV_TRY(rsv_scene_add_mesh(shape.scene, &mesh, &id));
    RSV_TRY(rsv_scene_add_instance(shape.scene, id, shape.transform, shape.name));
cleanup:
    return status;
}

rsv_status rsv_add_quad(rsv_shape shape, const rsv_vec3 corner[4])
{
    static const uint32_t index[] = { 0, 1, 2, 0, 2, 3 };
    return add_shape(shape, (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                                .positions = corner,
                                .vertex_count = 4,
                                .indices = index,
                                .triangle_count = 2 });
}

/// Corners 0-3 are the bottom, counter-clockwise seen from above, 4-7 the top. The bottom face comes
/// last, so that a block without it is a prefix.
static const uint32_t box_outwards[36] = { 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2,
    3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7, 3, 2, 1, 3, 1, 0 };

rsv_status rsv_add_block(rsv_shape shape, const float footprint[4][2], float bottom, float top)
{
    rsv_vec3 corner[8];
    for (int i = 0; i < 4; i++) {
        corner[i] = v3(footprint[i][0], bottom, footprint[i][1]);
        corner[i + 4] = v3(footprint[i][0], top, footprint[i][1]);
    }
    return add_shape(shape, (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                                .positions = corner,
                                .vertex_count = 8,
                                .indices = box_outwards,
                                .triangle_count = 10 });
}

static void box_corners(rsv_vec3 low, rsv_vec3 high, rsv_vec3 corner[8])
{
    for (int i = 0; i < 8; i++)
        corner[i] = v3(i % 4 == 0 || i % 4 == 3 ? low.x : high.x, i < 4 ? low.y : high.y,
            i % 4 < 2 ? high.z : low.z);
}

rsv_status rsv_add_box(rsv_shape shape, rsv_vec3 low, rsv_vec3 high)
{
    rsv_vec3 corner[8];
    box_corners(low, high, corner);
    return add_shape(shape, (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                                .positions = corner,
                                .vertex_count = 8,
                                .indices = box_outwards,
                                .triangle_count = 12 });
}

rsv_status rsv_add_room(rsv_shape shape, rsv_vec3 low, rsv_vec3 high)
{
    rsv_vec3 corner[8];
    uint32_t inwards[36];
    box_corners(low, high, corner);
    for (int i = 0; i < 36; i++)
        inwards[i] = box_outwards[35 - i];
    return add_shape(shape, (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                                .positions = corner,
                                .vertex_count = 8,
                                .indices = inwards,
                                .triangle_count = 12 });
}

/// A geodesic sphere while it grows. Each edge's midpoint is found again through a hash table, so
/// that neighbouring triangles share it.
typedef struct geodesic {
    rsv_vec3 *direction; ///< unit
    size_t vertex_count;
    uint32_t *index;
    size_t triangle_count;
    struct midpoint {
        uint32_t low, high, vertex; ///< the edge's ends; high 0 = free slot
    } * midpoint;
    size_t slot_mask;
} geodesic;

static uint32_t edge_midpoint(geodesic *sphere, uint32_t a, uint32_t b)
{
    uint32_t low = a < b ? a : b, high = a < b ? b : a;
    size_t slot = (low * 73856093u ^ high * 19349663u) & sphere->slot_mask;
    struct midpoint *m = &sphere->midpoint[slot];
    while (m->high && (m->low != low || m->high != high)) {
        slot = (slot + 1) & sphere->slot_mask;
        m = &sphere->midpoint[slot];
    }
    if (!m->high) {
        *m = (struct midpoint){ low, high, (uint32_t)sphere->vertex_count };
        sphere->direction[sphere->vertex_count++] =
            v3_normalize(v3_add(sphere->direction[low], sphere->direction[high]));
    }
    return m->vertex;
}

/// Replaces each triangle by its middle (in place) and three corners (appended).
static void subdivide(geodesic *sphere)
{
    size_t count = sphere->triangle_count;
    for (size_t t = 0; t < count; t++) {
        uint32_t *corner = &sphere->index[3 * t];
        uint32_t middle[3];
        for (int i = 0; i < 3; i++)
            middle[i] = edge_midpoint(sphere, corner[i], corner[(i + 1) % 3]);
        for (int i = 0; i < 3; i++) {
            uint32_t *added = &sphere->index[3 * sphere->triangle_count++];
            added[0] = corner[i];
            added[1] = middle[i];
            added[2] = middle[(i + 2) % 3];
        }
        memcpy(corner, middle, sizeof middle);
    }
}

static void start_with_icosahedron(geodesic *sphere)
{
    static const float g = 1.6180339887f; // golden ratio
    const rsv_vec3 vertex[12] = { { -1, g, 0 }, { 1, g, 0 }, { -1, -g, 0 }, { 1, -g, 0 },
        { 0, -1, g }, { 0, 1, g }, { 0, -1, -g }, { 0, 1, -g }, { g, 0, -1 }, { g, 0, 1 },
        { -g, 0, -1 }, { -g, 0, 1 } };
    static const uint32_t index[60] = { 0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5,
        11, 4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5,
        2, 4, 11, 6, 2, 10, 8, 6, 7, 9, 8, 1 };
    for (int i = 0; i < 12; i++)
        sphere->direction[i] = v3_normalize(vertex[i]);
    memcpy(sphere->index, index, sizeof index);
    sphere->vertex_count = 12;
    sphere->triangle_count = 20;
}

rsv_status rsv_add_sphere(rsv_shape shape, rsv_vec3 centre, float radius, int level)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_context *context = shape.scene->context;
    size_t triangle_count = (size_t)20 << (2 * level);
    size_t vertex_count = triangle_count / 2 + 2; // Euler
    size_t slot_count =
        16; // of all edges that are ever split, fewer than vertices; half full at most
    while (slot_count < 2 * vertex_count)
        slot_count *= 2;
    geodesic sphere = { .slot_mask = slot_count - 1 };
    sphere.direction = rsv_alloc(context, vertex_count, sizeof *sphere.direction);
    sphere.index = rsv_alloc(context, 3 * triangle_count, sizeof *sphere.index);
    sphere.midpoint = rsv_alloc(context, slot_count, sizeof *sphere.midpoint);
    rsv_vec3 *position = rsv_alloc(context, vertex_count, sizeof *position);
    if (!sphere.direction || !sphere.index || !sphere.midpoint || !position) goto cleanup;

    start_with_icosahedron(&sphere);
    for (int i = 0; i < level; i++)
        subdivide(&sphere);
    for (size_t i = 0; i < vertex_count; i++)
        position[i] = v3_mad(centre, radius, sphere.direction[i]);
    status = add_shape(shape, (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                                  .positions = position,
                                  .normals = sphere.direction,
                                  .vertex_count = vertex_count,
                                  .indices = sphere.index,
                                  .triangle_count = triangle_count });
cleanup:
    rsv_free(context, sphere.direction);
    rsv_free(context, sphere.index);
    rsv_free(context, sphere.midpoint);
    rsv_free(context, position);
    return status;
}
