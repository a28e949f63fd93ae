/// Files of what each light does by itself, for the runtime (docs/bake.md).
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
    rsv_rgb *sum; ///< out: [count][width] what all lights together bring; NULL = not asked for
    /// Writes what else the file says of the receivers; NULL = nothing.
    rsv_status (*describe)(const struct rsv_bake_reader *reader, rsv_tensor_file *file);
} rsv_bake_reader;

/// "room.glb" -> "room.KIND.safetensors"
void rsv_bake_name_beside(const char *output, const char *kind, char path[RSV_PATH_BYTES]);

/// Irradiance on surfaces. @param receiver what `read` reads by; borrowed @param read as above
rsv_bake_reader rsv_bake_surface_reader(const char *kind, const void *receiver, size_t count,
    rsv_status (*read)(const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value));

/// To be called before anything is baked: RSV_ERROR_UNSUPPORTED if the lights are too many to be kept apart, and a warning if they
/// take long. OK where no basis is asked for.
rsv_status rsv_bake_check_lights(const rsv_light_view *solution, const rsv_bake_desc *desc);

/// Writes what receivers read, light by light, beside the baked file: OUT.light.safetensors. Surroundings are there at
/// each of desc->turns angles, last of all.
/// RSV_ERROR_UNSUPPORTED if memory cannot hold it.
/// @param lights out: how many there are, every angle of the surroundings counted
rsv_status rsv_bake_write_basis(const rsv_light_view *solution, const rsv_bake_reader *reader,
    const rsv_bake_desc *desc, const char *output, size_t *lights);

#endif
