/// Operator files with the receivers of a bake: for lights at run time that were not baked (docs/runtime.md).
#ifndef RSV_BAKE_OPERATOR_H
#define RSV_BAKE_OPERATOR_H

#include "bake_receiver.h"
#include "resolvent/bake.h"

/// Whether there is such a file of a solution: RSV_ERROR_UNSUPPORTED where light leaves elsewhere than it enters.
rsv_status rsv_bake_check_operator(const rsv_light_view *solution, const rsv_bake_desc *desc);

/// Writes the operator with its receivers beside the baked file: OUT.operator.safetensors. A receiver is the mean of
/// the elements at the corners of the cell around it; one beyond a border has the value of the border.
/// @param kind "vertex" or "texel" @param receiver [count]
rsv_status rsv_bake_write_operator(const rsv_light_view *solution, const char *kind,
    const rsv_bake_receiver *receiver, size_t count, const char *output);

#endif
