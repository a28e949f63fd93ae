/// A way to keep light in files. Each has a file of its own, target_NAME.c, which defines
///
///     const rsv_bake_target rsv_bake_target_NAME = { ... };
///
/// The build lists them by the names of these files; rsv_bake and `resolvent bake --to NAME` find them there.
#ifndef RSV_BAKE_TARGET_H
#define RSV_BAKE_TARGET_H

#include "../solve/light.h"
#include "resolvent/bake.h"

typedef struct rsv_bake_target {
    const char *extension; ///< of the file that is written: ".glb"; files beside it have its name
    /// @param desc checked, see rsv_bake_desc @param output ends in the extension @param report out: zero before
    rsv_status (*write)(const rsv_light_view *light, const rsv_bake_desc *desc, const char *output,
        rsv_bake_report *report);
} rsv_bake_target;

#endif
