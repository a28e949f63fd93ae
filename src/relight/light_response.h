/// The contribution of each light, bounces included: the basis for relighting by factors.
///
/// Lights that share a definition are distinguished by their nodes. Sources with the same names form one entry. So do
/// lamps that only gather rays find, which are stored as one sum. Every value of the total is divided in proportion, so
/// that the parts add up to it.
#ifndef RSV_LIGHT_RESPONSE_H
#define RSV_LIGHT_RESPONSE_H

#include "../solve/light_change.h"

typedef struct rsv_light_responses {
    rsv_context *context;
    size_t count;
    const char *
        *name; ///< [count] name of a light in the scene, or of the node that distinguishes it from others
    const char **definition; ///< [count] name of the light only
    rsv_rgb *
        scale; ///< [count] how strong its first source stands, of the strength that it has by itself
    /// [count] on the operator and the levels of the whole. Their orders are not kept apart
    rsv_light **light;           ///< those of its own; NULL = the whole itself
    const rsv_light_view **view; ///< [count] of these
    bool sky_last;               ///< the last one is of the surroundings and of nothing else
} rsv_light_responses;

/// RSV_ERROR_UNSUPPORTED beyond RSV_MAX_PART_BYTES. The solution must outlive the responses.
rsv_status rsv_light_responses_create(const rsv_light *solution, rsv_light_responses **responses);
/// How many there would be: takes no time. Errors as above.
rsv_status rsv_light_responses_count(const rsv_light *solution, size_t *count);
void rsv_light_responses_destroy(rsv_light_responses *responses);

#endif
