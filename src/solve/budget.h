/// Budgets of a solution: elements of the operator, and memory. They are kept by a coarser solution.
#ifndef RSV_BUDGET_H
#define RSV_BUDGET_H

#include "../elements/elements.h"
#include "builder.h"

/// Records the memory left for the solution, besides what the process already uses. RSV_ERROR_MEMORY if that is too
/// little for the elements of the scene's own triangles.
rsv_status rsv_budget_open(rsv_builder *builder);

/// Elements that a budget counts: those that follow others, on meshes finer than the spacing, cost nothing to speak of.
static inline size_t rsv_budget_elements(const rsv_builder *builder)
{
    return builder->elements->node_count - builder->elements->follower_count;
}

/// Rows that the budgets leave to the elements in hand; SIZE_MAX without budgets.
size_t rsv_budget_rows(const rsv_builder *builder);

/// Halves the rays of a row where memory is short and they are many. @return whether it did
bool rsv_budget_halve_rays(rsv_builder *builder);

/// Cells that the budget of memory leaves to the levels of direct light and caustics; SIZE_MAX without one.
size_t rsv_budget_cells(const rsv_builder *builder);

/// Says why the elements in hand do not keep the budgets. @param least elements that there can be
rsv_status rsv_budget_refuse(const rsv_builder *builder, size_t least);

/// Logs what a budget made coarser than requested, if anything.
/// @param wanted requested metres between elements
void rsv_budget_report(const rsv_builder *builder, float wanted);

#endif
