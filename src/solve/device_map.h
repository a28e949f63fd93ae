/// The linear map A = G K on the context's device, as long as that works.
///
/// The caller does what the device cannot do: results never depend on whether it could (core/device.h describes how
/// failures are reported).
#ifndef RSV_DEVICE_MAP_H
#define RSV_DEVICE_MAP_H

#include "../diffusion/subsurface.h"
#include "../operator/transport.h"
#include "device_transport.h"

typedef struct rsv_device_map rsv_device_map;

/// @param albedo [node_count], borrowed like the rest @param subsurface NULL = none @param map out; NULL = there is no
/// device for it
/// @return the device's failure, unless it is optional
rsv_status rsv_device_map_create(const rsv_elements *elements, const rsv_transport *transport,
    const rsv_subsurface *subsurface, const rsv_rgb *albedo, rsv_device_map **map);
void rsv_device_map_destroy(rsv_device_map *map);

/// image = A field. @param map NULL = there is no device @return false = the caller has to do it
bool rsv_device_map_apply(rsv_device_map *map, size_t fields, const rsv_rgb *field, rsv_rgb *image);

/// residual = source + A field - field, on the device.
bool rsv_device_map_residual(rsv_device_map *map, size_t fields, const rsv_rgb *source,
    const rsv_rgb *field, rsv_rgb *residual);

/// Whether the device runs this solver by itself.
bool rsv_device_map_solves(const rsv_device_map *map, rsv_solver solver);

/// As rsv_measure_device.
rsv_status rsv_device_map_measure(
    rsv_device_map *map, uint32_t repetitions, double *copy_rate, double *seconds, size_t *bytes);

/// A correction as rsv_device_solve says, for one field. Where an optional device fails there is none: `correction`
/// stays as it was, not converged, after no application.
rsv_status rsv_device_map_solve(
    rsv_device_map *map, rsv_device_solve *solve, const rsv_rgb *residual, rsv_rgb *correction);

#endif
