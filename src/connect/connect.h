/// Specular connections: light of punctual sources that mirrors, panes, prisms and lenses send to a given point.
/// Neither shadow rays nor random paths find it.
///
/// Rays from each light towards smooth surfaces find all chains of specular events. For a point, Newton's method finds
/// the ray of each chain that passes through it (Mitchell and Hanrahan 1992). Irradiance is intensity times throughput
/// times the solid angle of the ray per area at the point. Planar surfaces are exact. Curved surfaces are exact for
/// facets and interpolated normals, but not for normal maps.
#ifndef RSV_CONNECT_H
#define RSV_CONNECT_H

#include "../sources/lights.h"
#include "../specular/specular_path.h"

typedef struct rsv_connections rsv_connections;

/// Light that arrives at a place along one path.
typedef struct rsv_connection {
    rsv_vec3 towards;   ///< unit, where it comes from
    rsv_rgb irradiance; ///< on a plane that faces it, W/m2
    bool straight;      ///< it was not deflected: it only passed thin sheets
} rsv_connection;

#define RSV_MOST_CONNECTIONS 256 ///< of one place

/// @param scene, lights borrowed
/// @param connections out: NULL where there is nothing to connect: no punctual light or nothing smooth. In fog, too.
rsv_status rsv_connections_create(
    const rsv_transport_scene *scene, const rsv_lights *lights, rsv_connections **connections);
void rsv_connections_destroy(rsv_connections *connections);

/// All connections of a place, each once. Thread-safe. @return how many
size_t rsv_connect(
    const rsv_connections *connections, rsv_vec3 point, rsv_connection found[RSV_MOST_CONNECTIONS]);

/// Number of chains, which determines the cost of rsv_connect.
size_t rsv_connections_chain_count(const rsv_connections *connections);

/// Their irradiance on the side that `normal` (unit) faces. NULL gives 0. @param turned omit straight connections
rsv_rgb rsv_connected_irradiance(
    const rsv_connections *connections, rsv_vec3 point, rsv_vec3 normal, bool turned);

#endif
