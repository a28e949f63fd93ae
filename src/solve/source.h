/// E0: what arrives from the sources, on the coarse elements and on finer levels of its own.
#ifndef RSV_SOURCE_H
#define RSV_SOURCE_H

#include "solution.h"

/// Tells gather rays and shadow rays what each of them finds of the surroundings.
rsv_status rsv_source_divide_environment(rsv_solution *solution);

/// Direct light and caustics on finer elements, where they are wanted. Caustics have elements of their own: they are
/// the same whether direct light is left to the renderer or not.
rsv_status rsv_source_create_levels(rsv_solution *solution);

/// Direct light alone, of all nodes that are not known. @param known [node_count]
rsv_status rsv_source_estimate(rsv_solution *solution, const uint8_t *known);

/// E0 on the coarse elements: next-event estimates, gathered emission and caustics. Needs rows.
rsv_status rsv_source_create(rsv_solution *solution);

/// Adds what is gathered, and caustics, to the next-event estimates in `source`.
void rsv_source_complete(rsv_solution *solution);

/// Adds gathered emission, by rows and by the bins of the surroundings as they are now, and caustics to `source`.
void rsv_source_add_gathered(rsv_solution *solution);

#endif
