/// Hours at which shades are down, room by room.
#ifndef RSV_DAYLIGHT_SHADES_H
#define RSV_DAYLIGHT_SHADES_H

#include "year.h"

/// RSV_ERROR_ARGUMENT where the two states do not fit each other.
rsv_status rsv_shades_check(const rsv_daylight *daylight, const rsv_daylight_run_desc *desc);

/// Rooms whose shades move together: those of the run, or all sensors if it has none.
static inline size_t rsv_shades_rooms(const rsv_daylight_run_desc *desc)
{
    return desc->room ? desc->room_count : 1;
}

static inline size_t rsv_shades_room_of(const rsv_daylight_run_desc *desc, size_t sensor)
{
    return desc->room ? desc->room[sensor] : 0;
}

/// @param down out: [rooms][lit_count] 1 = they are; zero before
rsv_status rsv_shades_lower(const rsv_daylight *daylight, const rsv_year *year,
    const rsv_daylight_run_desc *desc, uint8_t *down);

#endif
