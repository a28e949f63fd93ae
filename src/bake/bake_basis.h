/// Files with the contribution of each light, for the runtime (docs/bake-reference.md).
#ifndef RSV_BAKE_BASIS_H
#define RSV_BAKE_BASIS_H

#include "../io/atomic_file.h"
#include "../opfile/tensor_file.h"
#include "bake_receiver.h"
#include "resolvent/bake.h"

/// How light is read at receivers of some kind.
typedef struct rsv_bake_reader {
    const char *kind;     ///< as the file names it: "vertex", "texel", "probe"
    const char *units;    ///< of the values
    const void *receiver; ///< [count]
    size_t count;
    size_t width; ///< RGB values of each
    /// @param value out: [count][width]
    rsv_status (*read)(
        const struct rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value);
    rsv_rgb *sum; ///< out: [count][width] light of all lights together; NULL = not needed
    /// Writes other data of the receivers; NULL = none.
    rsv_status (*describe)(const struct rsv_bake_reader *reader, rsv_tensor_file *file);
} rsv_bake_reader;

/// "room.glb" -> "room.KIND.safetensors"
void rsv_bake_name_beside(const char *output, const char *kind, char path[RSV_PATH_BYTES]);

/// Irradiance on surfaces. @param receiver input of `read`; borrowed @param read as above
rsv_bake_reader rsv_bake_surface_reader(const char *kind, const void *receiver, size_t count,
    rsv_status (*read)(const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value));

/// Call it before anything is baked: RSV_ERROR_UNSUPPORTED if there are too many lights for separate contributions, and
/// a warning if they take long. RSV_OK if no basis is requested.
rsv_status rsv_bake_check_lights(const rsv_light_view *solution, const rsv_bake_desc *desc);

/// Writes the readings of receivers, light by light, beside the baked file: OUT.light.safetensors. The environment at
/// each of desc->turns angles comes last. RSV_ERROR_UNSUPPORTED if it does not fit into memory.
/// @param lights out: number of lights, with every angle of the environment
rsv_status rsv_bake_write_basis(const rsv_light_view *solution, const rsv_bake_reader *reader,
    const rsv_bake_desc *desc, const char *output, size_t *lights);

#endif
