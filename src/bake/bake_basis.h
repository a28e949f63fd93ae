/// Files of what each light does by itself, for the runtime (docs/bake.md).
#ifndef RSV_BAKE_BASIS_H
#define RSV_BAKE_BASIS_H

#include "../solve/light_response.h"
#include "bake_tessellate.h"

/// Writes irradiance at receivers, light by light, beside the baked file: OUT.light.safetensors.
/// @param kind what the receivers are: "vertex", "texel" @param lights out: how many there are
rsv_status rsv_bake_write_basis(const rsv_solution *solution, const rsv_bake_receiver *receiver,
    size_t count, const char *kind, const char *output, size_t *lights);

#endif
