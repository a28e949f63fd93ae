/// Bakes at places that a test chooses: the light stored there, read without samples of direct light.
#ifndef RSV_TEST_BAKE_PLACES_H
#define RSV_TEST_BAKE_PLACES_H

#include "bake/bake_basis.h"
#include "bake/bake_receiver.h"

static inline rsv_status read_stored_places(
    const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value)
{
    const rsv_bake_receiver *receiver = reader->receiver;
    for (size_t n = 0; n < reader->count; n++)
        value[n] = rsv_bake_irradiance(light, &receiver[n]);
    return RSV_OK;
}

/// @param kind "vertex", "texel", ... @param receiver [count]; borrowed
static inline rsv_bake_reader reader_of_places(
    const char *kind, const rsv_bake_receiver *receiver, size_t count)
{
    return rsv_bake_surface_reader(kind, receiver, count, read_stored_places);
}

#endif
