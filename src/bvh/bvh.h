/// An 8-wide bounding volume hierarchy for devices: compressed nodes of 80 bytes after Ylitie, Karras and Laine,
/// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs" (2017).
///
/// Built on the host into two arrays of plain data, which can be copied to any memory. bvh_trace.h traces rays through
/// them on hosts and devices, with the results of src/trace, up to ties.
#ifndef RSV_BVH_H
#define RSV_BVH_H

#include "resolvent/scene.h"

/// Maximum depth, for any triangles.
#define RSV_BVH_DEPTH 64
/// Triangles of a leaf at most.
#define RSV_BVH_LEAF 3

/// Eight children in slots. Bits 0, 1 and 2 of a slot's number say whether its child is on the far side along +x, +y
/// and +z, as far as possible: for a ray towards +x +y +z, slots are ordered from near to far.
///
/// Boxes are stored on a grid: along each axis, child k extends from origin + low[k] * 2^exponent to origin + high[k] *
/// 2^exponent. Arrays of eight bytes are pairs of words, with the first child in the lowest byte.
typedef struct rsv_bvh_node {
    float origin[3];
    /// + 127, a byte for each axis; the highest byte has a bit for each slot with an inner child.
    uint32_t exponents;
    uint32_t first_child; ///< nodes of inner children follow each other in the order of their slots
    uint32_t first_triangle; ///< of the leaves
    /// A byte for each slot. 0 = empty; inner child: 1 << 5 | (24 + slot); leaf: a bit from 5 on for each
    /// triangle, and the first of them relative to first_triangle in bits 0 to 4.
    uint32_t meta[2];
    uint32_t low[3][2], high[3][2];
} __attribute__((aligned(16))) rsv_bvh_node;

/// Corners, and which triangle of the scene it is.
typedef struct rsv_bvh_triangle {
    rsv_vec3 a;
    uint32_t index;
    rsv_vec3 b;
    uint32_t unused_b;
    rsv_vec3 c;
    uint32_t unused_c;
} __attribute__((aligned(16))) rsv_bvh_triangle;

/// The arrays, in any memory.
typedef struct rsv_bvh_view {
    const rsv_bvh_node *node;            ///< [node_count]; the first is the root
    const rsv_bvh_triangle *triangle;    ///< [triangle_count] in the order of the leaves
    uint32_t node_count, triangle_count; ///< 0 nodes: nothing to hit
    /// Whose cut-out surfaces rays pass, and light in part those that are blended; NULL = there are neither.
    const rsv_scene_view *holes;
    const rsv_scene_view *twins; ///< faces of which lie in the same place; NULL = none do
} rsv_bvh_view;

typedef struct rsv_bvh {
    rsv_context *context;
    rsv_bvh_view view;
    rsv_bvh_node *node;
    rsv_bvh_triangle *triangle;
} rsv_bvh;

/// Builds it over triangles with finite corners. The same bytes for any thread count.
/// @param triangle [triangle_count] indices into `position` @param bvh out
rsv_status rsv_bvh_build(rsv_context *context, const rsv_vec3 *position,
    const uint32_t (*triangle)[3], size_t triangle_count, rsv_bvh *bvh);

/// Over a committed scene, which must outlive it where a material is cut out or blended and where faces lie in the
/// same place.
rsv_status rsv_bvh_build_scene(const rsv_scene *scene, rsv_bvh *bvh);

void rsv_bvh_destroy(rsv_bvh *bvh);

#endif
