/// Hours at which shades are down.
#ifndef RSV_DAYLIGHT_SHADES_H
#define RSV_DAYLIGHT_SHADES_H

#include "year.h"

/// RSV_ERROR_ARGUMENT where the two states do not fit each other.
rsv_status rsv_shades_check(const rsv_daylight *daylight, const rsv_daylight_run_desc *desc);

/// @param down out: [lit_count] 1 = they are; zero before
rsv_status rsv_shades_lower(const rsv_daylight *daylight, const rsv_year *year,
    const rsv_daylight_run_desc *desc, uint8_t *down);

#endif
