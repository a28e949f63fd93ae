/// Who traces and keeps which rows of G: parts of a space-filling curve through the nodes, of equal cost.
///
/// Neighbours on the curve are neighbours in space: they see much the same, so that the rows of one part share most of
/// the nodes that they refer to (what a distributed product has to send). Costs are measured on a few rows beforehand.
#ifndef RSV_DIVISION_H
#define RSV_DIVISION_H

#include "../elements/elements.h"

typedef struct rsv_division {
    rsv_context *context;
    size_t node_count;
    uint32_t part, part_count; ///< this process's
    uint32_t *order;           ///< [node_count] nodes along the curve
    size_t *begin;             ///< [part_count + 1] into order
    size_t *row_begin;         ///< [part_count + 1] likewise, only nodes with a row being counted
    float *cost;               ///< [node_count] predicted, by node; any unit; 0 = it has no row
} rsv_division;

/// Nodes along a Hilbert curve, and no parts yet.
rsv_status rsv_division_create(const rsv_elements *elements, rsv_division **division);
void rsv_division_destroy(rsv_division *division);

/// Cuts the curve where parts cost the same.
/// @param part which of them is this process's
rsv_status rsv_division_cut(rsv_division *division, uint32_t part, uint32_t part_count);

/// Timing in turns: item `index * step % count` comes next, far from those before it, so that a machine which is busy
/// for a while makes all parts dearer alike. @return the step, which reaches each of `count` items
size_t rsv_division_step(size_t count);

/// Hands a field, known to each process in its own part, to all. Nodes without a row are left out: all must know
/// theirs.
/// @param division NULL = there is nothing to do
void rsv_division_share(const rsv_division *division, void *field, size_t item_bytes);

#endif
