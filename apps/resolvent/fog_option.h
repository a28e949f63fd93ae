/// --fog and --fog-height.
#ifndef CLI_FOG_OPTION_H
#define CLI_FOG_OPTION_H

#include "resolvent/scene.h"

typedef struct cli_fog {
    const char *medium; ///< EXTINCTION[,ALBEDO[,G]]; NULL = clear air
    const char *height; ///< SCALE[,BASE]; NULL = the same everywhere
    const char *volume; ///< .vdb file of densities; NULL = the same everywhere
} cli_fog;

/// Reads both options into `fog`, which the library still has to check. Prints an error and returns false on failure.
bool cli_read_fog(const cli_fog *given, rsv_fog *fog);

#endif
