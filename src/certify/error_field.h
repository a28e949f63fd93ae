/// From the residual to the error: e = r + s with s = (I - G K)^-1 G K r, the residual after one or more reflections.
///
/// s is smooth, and integrals over all residuals average their noise. A few thousand points determine it on the
/// solution's own elements, with its own operator. r itself cannot be represented on elements; only mean squares of it
/// are used.
#ifndef RSV_ERROR_FIELD_H
#define RSV_ERROR_FIELD_H

#include "../solve/transport_map.h"
#include "moments.h"
#include "residual.h"
#include "resolvent/certify.h"

/// Independent sets of residuals, and the reflected error predicted by each: products of different sets have no bias,
/// and the effect of omitting one of them shows how uncertain the whole is.
#define RSV_SAMPLE_SETS 8

typedef struct rsv_error_field {
    rsv_rgb *reflected[RSV_SAMPLE_SETS]; ///< [node_count] s, W/m2
} rsv_error_field;

/// A residual at a point.
typedef struct rsv_residual_sample {
    rsv_face_point point;
    double weight; ///< of the point: density of area over that which it was drawn with
    rsv_residual at;
    bool valid; ///< not buried
} rsv_residual_sample;

/// Sample k belongs to set k % RSV_SAMPLE_SETS.
/// @param area of the surfaces that one valid sample of weight 1 stands for, m2
rsv_status rsv_error_field_create(const rsv_light_view *solution, const rsv_residual_sample *sample,
    size_t count, double area, rsv_error_field *field);
void rsv_error_field_destroy(rsv_context *context, rsv_error_field *field);

/// rsv_certify, with the field computed on the way.
/// @param field destroyed by the caller, even after an error; its fields stay NULL if nothing is diffuse
rsv_status rsv_examine(const rsv_light_view *solution, const rsv_certify_desc *desc,
    rsv_certificate *certificate, rsv_error_field *field);

/// Mean of e^2 with e = r + s, luminance, (W/m2)^2, and how well it is known, all noise that the residuals of a set
/// share through their s included.
rsv_moments rsv_mean_squared_error(const rsv_light_view *solution,
    const rsv_residual_sample *sample, size_t count, const rsv_error_field *field);

/// s as the samples of one set predict it.
rsv_rgb rsv_error_field_at(
    const rsv_light_view *solution, const rsv_rgb *reflected, const rsv_face_point *point);

#endif
