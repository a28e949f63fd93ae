/// Rooms of sensors, with a given tracer.
#ifndef RSV_DAYLIGHT_ROOMS_H
#define RSV_DAYLIGHT_ROOMS_H

#include "resolvent/daylight.h"
#include "resolvent/trace.h"

/// Fewer sensors in sight of a room are a sliver, as in a doorway.
#define RSV_ROOM_LEAST 4

typedef struct rsv_sensor_list {
    rsv_probe *sensor; ///< [count]
    size_t count;
} rsv_sensor_list;

/// rsv_daylight_rooms.
rsv_status rsv_rooms_find(rsv_context *context, const rsv_tracer *tracer, rsv_sensor_list sensors,
    uint32_t *room, size_t *room_count);

/// Removes slivers from which a sensor of a room is in sight, at most `reach` metres away.
rsv_status rsv_rooms_drop_slivers(
    rsv_context *context, const rsv_tracer *tracer, float reach, rsv_sensor_list *sensors);

#endif
