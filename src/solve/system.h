/// Everything that belongs to one set of coarse elements: G, K, E0 and the solution.
#ifndef RSV_SYSTEM_H
#define RSV_SYSTEM_H

#include "solution.h"

/// The fewest rays of a row.
#define RSV_FEWEST_RAYS 64

/// Where nothing reflects diffusely, irradiance is of no consequence: what cameras and probes see comes straight
/// from the sources.
bool rsv_reflects_diffusely(const rsv_solution *solution);

/// Albedos of the elements, and room for their sources.
rsv_status rsv_system_create_fields(rsv_solution *solution);

/// G, with so many rays to a row.
rsv_status rsv_system_assemble(rsv_solution *solution, uint32_t rays);

/// Frees all of it but the elements.
void rsv_system_destroy(rsv_solution *solution);

#endif
