/// The linear map A = G K of a scene, as solvers see it.
///
/// Hanging nodes are no unknowns: K first fills them in from their parents, and their rows of A are 0. So a
/// solution of x = b + A x, with b 0 there, lacks them; rsv_elements_constrain adds them.
#ifndef RSV_TRANSPORT_MAP_H
#define RSV_TRANSPORT_MAP_H

#include "../diffusion/subsurface.h"
#include "../operator/transport_columns.h"
#include "../solver/linear_map.h"
#include "device_map.h"
#include "krylov.h"
#include "resolvent/solve.h"

typedef struct rsv_transport_map {
    rsv_linear_map linear;      ///< what solvers get
    rsv_linear_map_table table; ///< of that; grows with what the map is prepared for
    rsv_transport *transport;
    const rsv_elements *elements;
    const rsv_rgb *albedo;          ///< [node_count]
    rsv_subsurface *subsurface;     ///< NULL = none
    size_t fields;                  ///< at most so many RGB fields at once
    rsv_rgb *filled, *scattered;    ///< [node_count] of one field
    rsv_rgb *exitance;              ///< [node_count x fields]
    uint32_t *group;                ///< of linear.group
    uint32_t *place;                ///< [node_count] the same, and the groups of hanging nodes
    rsv_transport_columns *columns; ///< NULL until rsv_transport_map_transpose
    uint32_t *child_begin;          ///< [node_count + 1] hanging nodes by parent; likewise
    uint32_t *child;                ///< indices into elements->hanging
    rsv_device_map *device;         ///< the same on the context's device; NULL = there is none
    rsv_solver device_solver;       ///< that it was prepared for
    rsv_krylov *krylov;             ///< PETSc's view of it; NULL until rsv_transport_map_prepare
} rsv_transport_map;

/// Borrows all that it is made of; where a solver needs rows or columns, they are brought together (rsv_transport_complete).
/// Not to be used by two threads at a time.
/// @param fields RGB fields at once, at most
rsv_status rsv_transport_map_create(const rsv_elements *elements, rsv_transport *transport,
    rsv_subsurface *subsurface, const rsv_rgb *albedo, size_t fields, rsv_transport_map **map);
void rsv_transport_map_destroy(rsv_transport_map *map);

/// Adds the columns of G, without which the map knows neither its transposed nor how to shoot.
rsv_status rsv_transport_map_transpose(rsv_transport_map *map);

/// Adds what a solver needs beyond rows: columns, groups of nodes, or PETSc.
rsv_status rsv_transport_map_prepare(rsv_transport_map *map, rsv_solver solver);

/// Sets a field to 0 at hanging nodes.
void rsv_transport_map_mask(const rsv_transport_map *map, size_t fields, rsv_rgb *field);

#endif
