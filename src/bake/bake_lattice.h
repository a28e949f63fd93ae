/// Light on regular grids of points over the triangles of a part.
///
/// A point, or a vertex there, represents the mean over a patch around it, as wide as cells of the finest grid: the
/// visible part of it on its own triangle (bake_open.h). Where light varies smoothly, this is the light at the point.
/// Where the edge of a shadow crosses a cell, no value is right on all sides of a vertex; a least-squares fit would
/// make vertices brighter or darker than any real light, on both sides of the edge.
#ifndef RSV_BAKE_LATTICE_H
#define RSV_BAKE_LATTICE_H

#include "bake_grid_light.h"

#define RSV_BAKE_DEEPEST 9 ///< halvings of a triangle's sides at most

/// Of a triangle divided `depth` times, point (i, j) has the weights i and j over 2^depth of the file's corners 1 and
/// 2.
typedef struct rsv_bake_lattices {
    rsv_context *context;
    const rsv_light_view *s;
    const rsv_bake_part *part;
    float finest;   ///< metres
    uint8_t *depth; ///< [triangle_count]
    size_t *first;  ///< [triangle_count] its point (0, 0); the next row is `width` further
    uint32_t width, height;
    uint32_t *group; ///< [height * width] triangle; RSV_NONE = none
    rsv_rgb *light;  ///< [height * width]
    uint32_t *
        stand_in; ///< [height * width] the point whose light each has: itself, unless it is hidden
} rsv_bake_lattices;

/// @param finest metres: sides are not halved below @param divide whether they are at all
rsv_status rsv_bake_lattices_create(const rsv_light_view *solution, const rsv_bake_part *part,
    float finest, bool divide, rsv_bake_lattices *lattices);
void rsv_bake_lattices_destroy(rsv_bake_lattices *lattices);

rsv_status rsv_bake_lattices_light(rsv_bake_lattices *lattices, const rsv_bake_accuracy *accuracy);

/// Light there, linear between points. @param w1, w2 weights of the file's corners 1 and 2
rsv_rgb rsv_bake_lattices_at(const rsv_bake_lattices *lattices, uint32_t t, float w1, float w2);

/// Whether the nearest point of a lattice is visible.
bool rsv_bake_lattices_is_open(const rsv_bake_lattices *lattices, uint32_t t, float w1, float w2);

/// The point of a lattice that stands in for the nearest one. @param w in: weights of corners 1 and 2; out: its own,
/// unless the nearest stands for itself
void rsv_bake_lattices_stand_in(const rsv_bake_lattices *lattices, uint32_t t, float w[2]);

/// The patch of a vertex: places around it on its triangle, within half the finest cells.
void rsv_bake_vertex_patch(const rsv_light_view *solution, const rsv_bake_receiver *receiver,
    float finest, rsv_bake_patch *patch);

#endif
