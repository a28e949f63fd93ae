/// @file operator.h
/// The light-transport operator G K of a scene: which share of the light that arrives at each element arrives at every
/// other one next. It is found once and constant from then on; lights (solve.h) come and go.
///
/// Fields are [element_count] RGB values, in W/m2 where they are irradiances. All of these functions are thread-safe.
#ifndef RESOLVENT_OPERATOR_H
#define RESOLVENT_OPERATOR_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Counted: whoever retains one releases it, and each light of it keeps it alive.
typedef struct rsv_operator rsv_operator;

RSV_API rsv_operator *rsv_operator_retain(rsv_operator *transport);
RSV_API void rsv_operator_release(rsv_operator *transport); ///< NULL is allowed

/// Unknowns of the linear system: values at the nodes of elements on the scene's own triangles.
RSV_API size_t rsv_operator_element_count(const rsv_operator *transport);

/// image = G K field: the irradiance that follows from an irradiance after one reflection.
RSV_API rsv_status rsv_operator_apply(
    const rsv_operator *transport, const rsv_rgb *field, rsv_rgb *image);

/// image = (G K)* field: importance one reflection earlier.
RSV_API rsv_status rsv_operator_apply_transpose(
    const rsv_operator *transport, const rsv_rgb *field, rsv_rgb *image);

/// residual = source + G K field - field, with sums in double.
RSV_API rsv_status rsv_operator_residual(
    const rsv_operator *transport, const rsv_rgb *source, const rsv_rgb *field, rsv_rgb *residual);

/// ||G K||_inf: the largest row sum over elements and channels. Below 1 the series of reflections converges.
RSV_API rsv_status rsv_operator_norm(const rsv_operator *transport, double *norm_inf);

/// Elements around a point and their weights: a field's value there is the weighted sum of theirs.
typedef struct rsv_element_weights {
    uint32_t element[3];
    float weight[3];
} rsv_element_weights;

/// What a point of a triangle looks up. @param u, v barycentric weights of the triangle's corners 1 and 2
/// @return false where that side of the triangle has no elements: it does not reflect diffusely
RSV_API bool rsv_operator_locate(const rsv_operator *transport, uint32_t triangle, float u, float v,
    bool back_side, rsv_element_weights *around);

#ifdef __cplusplus
}
#endif

#endif
