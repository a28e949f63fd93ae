#ifndef RSV_BAKE_DESC_H
#define RSV_BAKE_DESC_H

#include "resolvent/bake.h"

/// RSV_ERROR_ARGUMENT for values out of range.
rsv_status rsv_bake_check_desc(const rsv_bake_desc *desc);

#endif
