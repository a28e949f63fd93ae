/// The contribution of each source of a relighter, bounces included. They are kept, so that other strengths are a
/// weighted sum.
///
/// Lamps that rows gathered are stored as one sum and have one response; every other source has its own.
#ifndef RSV_RELIGHT_RESPONSES_H
#define RSV_RELIGHT_RESPONSES_H

#include "relighter.h"

typedef struct rsv_relight_responses {
    rsv_context *context;
    size_t count;        ///< of responses
    size_t *of_source;   ///< [source_count] the response that a source belongs to
    rsv_rgb *irradiance; ///< [node_count x count] at the strengths that sources have by themselves
    rsv_rgb *shown;      ///< [node_count x count] the same without E0, as cameras look it up
} rsv_relight_responses;

/// Solves for all sources as they stand, with the present colours.
/// @param responses out; NULL where they would take more than RSV_MAX_RESPONSE_BYTES, or the solver fails
rsv_status rsv_relight_responses_create(
    rsv_relighter *relighter, rsv_relight_responses **responses);
/// Drops those of a relighter: they are of sources or colours that have changed.
void rsv_relight_responses_forget(rsv_relighter *relighter);
void rsv_relight_responses_destroy(rsv_relight_responses *responses);

#define RSV_MAX_RESPONSE_BYTES ((size_t)512 << 20)

/// Puts irradiance and indirect light of the solution together at the relighter's present strengths.
void rsv_relight_responses_combine(
    const rsv_relight_responses *responses, const rsv_relighter *relighter);

#endif
