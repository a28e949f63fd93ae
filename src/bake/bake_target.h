/// A kind of baked file. Each is in one source, target_NAME.c, which defines
///
///     const rsv_bake_target rsv_bake_target_NAME = { ... };
///
/// The build finds them by the names of these sources; rsv_bake and `resolvent bake --to NAME` use the list.
#ifndef RSV_BAKE_TARGET_H
#define RSV_BAKE_TARGET_H

#include "../solve/light.h"
#include "resolvent/bake.h"

typedef struct rsv_bake_target {
    const char *extension; ///< of the output: ".glb"; other files have its name
    /// @param desc checked, see rsv_bake_desc @param output ends in the extension @param report out: zero before
    rsv_status (*write)(const rsv_light_view *light, const rsv_bake_desc *desc, const char *output,
        rsv_bake_report *report);
} rsv_bake_target;

#endif
