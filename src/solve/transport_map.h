/// The linear map A = G K of a scene, for solvers.
///
/// Hanging nodes are not unknowns: K first computes them from their parents, and their rows of A are 0. A solution of x
/// = b + A x, with b 0 there, therefore lacks them; rsv_elements_constrain adds them.
#ifndef RSV_TRANSPORT_MAP_H
#define RSV_TRANSPORT_MAP_H

#include "../diffusion/subsurface.h"
#include "../operator/transport_columns.h"
#include "../solver/linear_map.h"
#include "device_map.h"
#include "krylov.h"
#include "resolvent/solve.h"

typedef struct rsv_transport_map {
    rsv_linear_map linear;      ///< for solvers
    rsv_linear_map_table table; ///< its functions, including those that the map was prepared for
    rsv_transport *transport;
    const rsv_elements *elements;
    const rsv_rgb *albedo;          ///< [node_count]
    rsv_subsurface *subsurface;     ///< NULL = none
    size_t fields;                  ///< maximum number of RGB fields at once
    rsv_rgb *filled, *scattered;    ///< [node_count] of one field
    rsv_rgb *exitance;              ///< [node_count x fields]
    uint32_t *group;                ///< of linear.group
    uint32_t *place;                ///< [node_count] the same, and the groups of hanging nodes
    rsv_transport_columns *columns; ///< NULL until rsv_transport_map_transpose
    uint32_t *child_begin;          ///< [node_count + 1] hanging nodes by parent
    uint32_t *child;                ///< indices into elements->hanging
    rsv_device_map *device;         ///< the same on the context's device; NULL = there is none
    rsv_solver device_solver;       ///< that it was prepared for
    rsv_krylov *krylov;             ///< PETSc's view of it; NULL until rsv_transport_map_prepare
} rsv_transport_map;

/// Borrows all its parts. If a solver needs rows or columns, those of all processes are collected
/// (rsv_transport_complete). Not thread-safe.
/// @param fields maximum number of RGB fields at once
rsv_status rsv_transport_map_create(const rsv_elements *elements, rsv_transport *transport,
    rsv_subsurface *subsurface, const rsv_rgb *albedo, size_t fields, rsv_transport_map **map);
void rsv_transport_map_destroy(rsv_transport_map *map);

/// Adds the columns of G, which the transposed map and shooting need.
rsv_status rsv_transport_map_transpose(rsv_transport_map *map);

/// Adds what a solver needs besides rows: columns, groups of nodes, or PETSc.
rsv_status rsv_transport_map_prepare(rsv_transport_map *map, rsv_solver solver);

/// Sets a field to 0 at hanging nodes.
void rsv_transport_map_mask(const rsv_transport_map *map, size_t fields, rsv_rgb *field);

#endif
